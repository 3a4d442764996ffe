//! The made Unity package as a branch of its own, which Unity's package manager installs by a git URL: `...git#upm`.
//!
//! A branch that shares no history with the project's: its tree is the package, kernels and libraries in it, and each commit is
//! one that was made. Nothing is checked out, and no index but one of its own is written.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::package;

/// Fails where packages cannot be committed to the branch; else says which commit it is at, where it is there.
pub fn check(root: &Path, branch: &str) -> Result<Option<String>, String> {
    let name = format!("refs/heads/{branch}");
    git(root, &["check-ref-format", &name])?;
    let before = git(root, &["rev-parse", "--verify", "--quiet", &name]).ok();
    if before.is_some() {
        let manifest = git(root, &["show", &format!("{name}:package.json")]).unwrap_or_default();
        let said: serde_json::Value = serde_json::from_str(&manifest).unwrap_or_default();
        if said["name"] != "com.lumivox" {
            return Err(format!("the branch {branch} is not one of made packages: choose another name"));
        }
    }
    if git(root, &["worktree", "list", "--porcelain"])?.lines().any(|line| line == format!("branch {name}")) {
        return Err(format!("the branch {branch} is checked out: choose another name"));
    }
    Ok(before)
}

/// Commits the folder to the branch, on top of what was made before.
pub fn commit(root: &Path, package: &Path, branch: &str, version: &str) -> Result<(), String> {
    let before = check(root, branch)?;
    let name = format!("refs/heads/{branch}");
    let package = std::path::absolute(package).map_err(|error| format!("{}: {error}", package.display()))?;
    let tree = tree(root, &package)?;
    if let Some(before) = &before
        && git(root, &["rev-parse", &format!("{before}^{{tree}}")])? == tree
    {
        println!("the branch {branch} holds this package already");
        return Ok(());
    }
    // There is nothing to tell of a repository without the project in it.
    let source = git(root, &["describe", "--always", "--dirty", "--exclude=*"]);
    let source = source.map_or(String::new(), |source| format!(", made of {source}"));
    let message = format!("com.lumivox {version}{source}");
    let mut words = vec!["commit-tree", &tree, "-m", &message];
    if let Some(before) = &before {
        words.extend(["-p", before]);
    }
    let made = git(root, &words)?;
    // Not if somebody else has moved it meanwhile.
    git(root, &["update-ref", &name, &made, before.as_deref().unwrap_or(&"0".repeat(made.len()))])?;
    println!("the branch {branch} is {made}");
    Ok(())
}

/// The tree of a folder, byte for byte and with all that it holds: whatever a person's git ignores, filters, converts, checks out
/// in part, or takes for a program.
fn tree(root: &Path, folder: &Path) -> Result<String, String> {
    let repository = git(root, &["rev-parse", "--absolute-git-dir"])?;
    let index = folder.with_extension("index");
    // Of a run that was cut short.
    let _ = std::fs::remove_file(&index);
    let in_folder = |words: &[&str], input: &str| {
        let mut command = Command::new("git");
        command.args(words).current_dir(folder);
        command.env("GIT_DIR", &repository).env("GIT_WORK_TREE", folder).env("GIT_INDEX_FILE", &index);
        told(&mut command, input)
    };
    let files = list(folder)?;
    let made = || {
        let paths: String = files.iter().map(|(path, _)| format!("{path}\n")).collect();
        let hashes = in_folder(&["hash-object", "-w", "--no-filters", "--stdin-paths"], &paths)?;
        let entries = hashes.lines().zip(&files);
        let entries: String =
            entries.map(|(hash, (path, mode))| format!("{mode} {hash}\t{path}\n")).collect();
        in_folder(&["update-index", "--add", "--index-info"], &entries)?;
        in_folder(&["write-tree"], "")
    };
    let tree = made();
    let _ = std::fs::remove_file(&index);
    tree
}

/// All files of a folder, by their paths in it, with git's mode.
fn list(folder: &Path) -> Result<Vec<(String, &'static str)>, String> {
    let with_mode = |path: String| {
        if path.contains(['\n', '"']) {
            return Err(format!("{path} is no name for git"));
        }
        let name = path.rsplit('/').next().unwrap_or_default();
        let is_program = name.starts_with("lumivox-codecs") && !name.ends_with(".meta");
        Ok((path, if is_program { "100755" } else { "100644" }))
    };
    package::below(folder)?.into_iter().map(with_mode).collect()
}

/// Git in the project's repository, wherever it works.
fn git(root: &Path, words: &[&str]) -> Result<String, String> {
    output(Command::new("git").args(words).current_dir(root))
}

fn output(command: &mut Command) -> Result<String, String> {
    told(command, "")
}

/// What it says to some input, without the last end of line.
fn told(command: &mut Command, input: &str) -> Result<String, String> {
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let failed = |error: std::io::Error| format!("git: {error}");
    let mut child = command.spawn().map_err(failed)?;
    let mut stdin = child.stdin.take().ok_or("git takes no input")?;
    // It answers while it is told.
    let output = std::thread::scope(|scope| {
        scope.spawn(move || stdin.write_all(input.as_bytes()));
        child.wait_with_output().map_err(failed)
    })?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).trim_end().to_owned());
    }
    Err(format!("{command:?}: {}", String::from_utf8_lossy(&output.stderr).trim_end()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_branch_holds_what_was_made_and_nothing_else_is_touched() {
        let place = std::env::temp_dir().join(format!("lumivox-branch-{}", std::process::id()));
        let (root, package) = (place.join("project"), place.join("package"));
        fs::create_dir_all(&root).unwrap();
        fs::create_dir_all(package.join("made")).unwrap();
        let run = |words: &[&str]| git(&root, words).unwrap();
        run(&["init", "--quiet", "--initial-branch=main"]);
        run(&["config", "commit.gpgsign", "false"]);
        run(&["config", "core.hooksPath", "none"]);
        run(&["config", "user.name", "a test"]);
        run(&["config", "user.email", "test@example.org"]);
        fs::write(root.join(".gitignore"), "made\n").unwrap();
        run(&["add", "."]);
        run(&["commit", "--quiet", "-m", "the project"]);
        // What a person may have set, none of which is about packages.
        for (key, value) in [
            ("core.autocrlf", "input"),
            ("core.fileMode", "false"),
            ("core.sparseCheckout", "true"),
            ("filter.lost.clean", "tr a-z A-Z"),
        ] {
            run(&["config", key, value]);
        }
        fs::create_dir_all(root.join(".git/info")).unwrap();
        fs::write(root.join(".git/info/attributes"), "* filter=lost text eol=crlf\n").unwrap();
        fs::write(root.join(".git/info/sparse-checkout"), "/nothing\n").unwrap();
        fs::write(package.join("package.json"), "{ \"name\": \"com.lumivox\" }\n").unwrap();
        fs::write(package.join("lumivox-codecs"), "a program").unwrap();
        // Ignored in the project, and ends of lines stay.
        fs::write(package.join("made/kernel"), "a\r\nb\n").unwrap();
        fs::write(root.join("work"), "that is not committed").unwrap();

        let before = run(&["status", "--porcelain"]);
        commit(&root, &package, "upm", "1.0.0").unwrap();
        assert_eq!(
            run(&["ls-tree", "-r", "--name-only", "upm"]),
            "lumivox-codecs\nmade/kernel\npackage.json"
        );
        assert_eq!(run(&["cat-file", "-p", "upm:made/kernel"]), "a\r\nb");
        assert!(run(&["ls-tree", "upm", "lumivox-codecs"]).starts_with("100755 "));
        assert!(run(&["ls-tree", "upm", "package.json"]).starts_with("100644 "));
        assert!(run(&["log", "--format=%s", "upm"]).starts_with("com.lumivox 1.0.0, made of "));
        commit(&root, &package, "upm", "1.0.0").unwrap();
        assert_eq!(run(&["rev-list", "--count", "upm"]), "1");
        fs::remove_file(package.join("made/kernel")).unwrap();
        commit(&root, &package, "upm", "1.1.0").unwrap();
        assert_eq!(run(&["ls-tree", "-r", "--name-only", "upm"]), "lumivox-codecs\npackage.json");
        assert_eq!(run(&["rev-list", "--count", "upm"]), "2");
        assert_eq!(run(&["status", "--porcelain"]), before);

        run(&["branch", "other"]);
        let refused = |branch: &str, why: &str| {
            let error = commit(&root, &package, branch, "1.1.0").unwrap_err();
            assert!(error.contains(why), "{error}");
        };
        refused("other", "not one of made packages");
        refused("main", "not one of made packages");
        refused("a..b", "check-ref-format");
        run(&["worktree", "add", "--quiet", "../elsewhere", "upm"]);
        refused("upm", "checked out");
        fs::remove_dir_all(&place).unwrap();
    }
}
