//! The made Unity package as a branch of its own, which Unity's package manager installs by a git URL: `...git#upm`.
//!
//! A branch that shares no history with the project's: its tree is the package, kernels and libraries in it, and each commit is
//! one that was made. Nothing is checked out, and no index but one of its own is written.

use std::path::Path;
use std::process::Command;

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

/// The tree of a folder, byte for byte and with all that it holds, whatever is ignored elsewhere.
fn tree(root: &Path, folder: &Path) -> Result<String, String> {
    let repository = git(root, &["rev-parse", "--absolute-git-dir"])?;
    let index = folder.with_extension("index");
    // Of a run that was cut short.
    let _ = std::fs::remove_file(&index);
    let in_folder = |words: &[&str]| {
        let mut command = Command::new("git");
        command.args(["-c", "core.autocrlf=false"]).args(words).current_dir(folder);
        command.env("GIT_DIR", &repository).env("GIT_WORK_TREE", folder).env("GIT_INDEX_FILE", &index);
        output(&mut command)
    };
    let tree = in_folder(&["add", "--all", "--force", "."]).and_then(|_| in_folder(&["write-tree"]));
    let _ = std::fs::remove_file(&index);
    tree
}

/// Git in the project's repository, wherever it works.
fn git(root: &Path, words: &[&str]) -> Result<String, String> {
    output(Command::new("git").args(words).current_dir(root))
}

/// What it says, without the last end of line.
fn output(command: &mut Command) -> Result<String, String> {
    let output = command.output().map_err(|error| format!("{command:?}: {error}"))?;
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
        fs::write(package.join("package.json"), "{ \"name\": \"com.lumivox\" }\n").unwrap();
        // Ignored in the project, and ends of lines stay.
        fs::write(package.join("made/kernel"), "a\r\nb\n").unwrap();
        fs::write(root.join("work"), "that is not committed").unwrap();

        commit(&root, &package, "upm", "1.0.0").unwrap();
        assert_eq!(run(&["ls-tree", "-r", "--name-only", "upm"]), "made/kernel\npackage.json");
        assert_eq!(run(&["cat-file", "-s", "upm:made/kernel"]), "5");
        assert!(run(&["log", "--format=%s", "upm"]).starts_with("com.lumivox 1.0.0, made of "));
        commit(&root, &package, "upm", "1.0.0").unwrap();
        assert_eq!(run(&["rev-list", "--count", "upm"]), "1");
        fs::remove_file(package.join("made/kernel")).unwrap();
        commit(&root, &package, "upm", "1.1.0").unwrap();
        assert_eq!(run(&["ls-tree", "-r", "--name-only", "upm"]), "package.json");
        assert_eq!(run(&["rev-list", "--count", "upm"]), "2");
        assert_eq!(run(&["status", "--porcelain"]), "?? work");

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
