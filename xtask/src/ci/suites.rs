//! The programs of the workspace with tests in them: built at once, run beside each other.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::lanes::Job;
use super::{Programs, Scope, cargo_command};

/// A program that Cargo built for tests.
#[derive(Debug, PartialEq)]
struct Suite {
    /// As its target is called: `lumivox_core`, `physics`.
    name: String,
    program: PathBuf,
    /// The folder of its package, in which Cargo runs tests.
    folder: PathBuf,
}

/// Builds all tests, and says how to run them: each program a job, and one for the tests in the documentation. What wants
/// chores done, or pictures made by the command, takes `programs`, and builds none.
pub fn build(scope: Scope, programs: &Programs) -> Result<Vec<Job>, String> {
    let mut command = cargo_command(&["test", "--workspace", "--release", "--no-run"]);
    command.arg("--message-format=json-render-diagnostics").stdin(Stdio::null()).stdout(Stdio::piped());
    let mut child = command.spawn().map_err(|error| format!("{command:?}: {error}"))?;
    let mut suites = vec![];
    for line in BufReader::new(child.stdout.take().expect("a pipe")).lines() {
        suites.extend(suite(&line.map_err(|error| error.to_string())?));
    }
    let status = child.wait().map_err(|error| error.to_string())?;
    if !status.success() {
        return Err(format!("{command:?}: {status}"));
    }
    if suites.is_empty() {
        return Err("no program with tests was built".into());
    }
    let mut jobs: Vec<Job> = suites.iter().flat_map(|suite| jobs(suite, scope, programs)).collect();
    // One program for all tests of it is linked for each crate.
    let documentation = cargo_command(&["test", "--workspace", "--release", "--no-fail-fast", "--doc"]);
    jobs.push(Job::of("documentation tests", documentation));
    Ok(jobs)
}

/// What a line of Cargo's tells of a program with tests.
fn suite(line: &str) -> Option<Suite> {
    let message: serde_json::Value = serde_json::from_str(line).ok()?;
    let is_test = message["reason"] == "compiler-artifact" && message["profile"]["test"] == true;
    let program = message["executable"].as_str().filter(|_| is_test)?;
    Some(Suite {
        name: message["target"]["name"].as_str()?.to_owned(),
        program: program.into(),
        folder: Path::new(message["manifest_path"].as_str()?).parent()?.to_owned(),
    })
}

fn jobs(suite: &Suite, scope: Scope, programs: &Programs) -> Vec<Job> {
    let job = |name: &str, words: &[&str]| {
        let mut command = Command::new(&suite.program);
        command.args(words).current_dir(&suite.folder).env("CARGO_MANIFEST_DIR", &suite.folder);
        command.env("LUMIVOX_XTASK", &programs.xtask);
        command.env("LUMIVOX_COMMAND", programs.built.join("lumivox"));
        if scope == Scope::All {
            command.arg("--include-ignored");
        }
        Job::of(name, command)
    };
    // The border under valgrind has one core: a lane of its own.
    if suite.name == "package" {
        let others = job("package", &["documentation", "kernels", "package", "installed"]);
        vec![others, job("border under valgrind", &["border"])]
    } else {
        vec![job(&suite.name, &[])]
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    #[test]
    fn programs_with_tests_are_found_in_what_cargo_says() {
        let line = r#"{"reason":"compiler-artifact","manifest_path":"/x/crates/a/Cargo.toml",
            "target":{"kind":["test"],"name":"physics"},"profile":{"test":true},"executable":"/x/deps/physics-1"}"#;
        let found = suite(line).unwrap();
        let wanted = Suite {
            name: "physics".into(),
            program: "/x/deps/physics-1".into(),
            folder: "/x/crates/a".into(),
        };
        assert_eq!(found, wanted);
        for other in [
            r#"{"reason":"build-finished","success":true}"#,
            &line.replace("true", "false"),
            &line.replace(r#""/x/deps/physics-1""#, "null"),
            "   Compiling lumivox-core",
        ] {
            assert_eq!(suite(other), None, "{other}");
        }
    }

    /// Tests in a library that is built without tests would be compiled by nobody, and run by nobody.
    #[test]
    fn no_test_lies_where_none_is_built() {
        let output =
            cargo_command(&["metadata", "--no-deps", "--format-version", "1"]).output().expect("cargo");
        let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let mut folders: BTreeMap<PathBuf, bool> = BTreeMap::new();
        for target in
            metadata["packages"].as_array().unwrap().iter().flat_map(|it| it["targets"].as_array().unwrap())
        {
            let folder = Path::new(target["src_path"].as_str().unwrap()).parent().unwrap().to_owned();
            *folders.entry(folder).or_default() |= target["test"] == true;
        }
        let without: Vec<&PathBuf> =
            folders.iter().filter(|(_, tested)| !**tested).map(|(folder, _)| folder).collect();
        assert!(without.iter().any(|folder| folder.ends_with("apps/studio/src")), "{without:?}");
        let mut open: Vec<PathBuf> =
            without.into_iter().filter(|folder| folder.ends_with("src")).cloned().collect();
        while let Some(folder) = open.pop() {
            for entry in std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()) {
                if entry.is_dir() {
                    open.push(entry);
                } else if entry.extension().is_some_and(|extension| extension == "rs") {
                    let text = std::fs::read_to_string(&entry).unwrap();
                    assert!(!text.contains("#[test]"), "{} has tests that nobody builds", entry.display());
                }
            }
        }
    }
}
