//! What packages are made with: the words after `cargo xtask package PART OUT`, which mean the same for every part.

use std::path::Path;

#[derive(Debug, Default, PartialEq)]
pub struct Options<'a> {
    /// The folder in which programs and libraries of this system lie, instead of building them.
    pub from: Option<&'a Path>,
    /// The folder in which those for Windows lie.
    pub windows: Option<&'a Path>,
    /// Libraries and programs of further systems, for the Unity package.
    pub libraries: Vec<&'a Path>,
    /// The branch that the Unity package is committed to.
    pub branch: Option<&'a str>,
}

impl<'a> Options<'a> {
    /// Of `--from DIR`, `--windows DIR`, `--library FILE` and `--upm BRANCH`; `None` where they are something else.
    pub fn parse(words: &[&'a str]) -> Option<Self> {
        let mut options = Self::default();
        for pair in words.chunks(2) {
            match *pair {
                ["--from", folder] if options.from.is_none() => options.from = Some(Path::new(folder)),
                ["--windows", folder] if options.windows.is_none() => {
                    options.windows = Some(Path::new(folder))
                }
                ["--library", file] => options.libraries.push(Path::new(file)),
                ["--upm", branch] if options.branch.is_none() && !branch.starts_with('-') => {
                    options.branch = Some(branch)
                }
                _ => return None,
            }
        }
        Some(options)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_folders_and_files_in_any_order() {
        let words = "--library a.dll --from native --windows dist --library b.exe --upm upm";
        let all = Options {
            from: Some(Path::new("native")),
            windows: Some(Path::new("dist")),
            libraries: vec![Path::new("a.dll"), Path::new("b.exe")],
            branch: Some("upm"),
        };
        assert_eq!(Options::parse(&words.split(' ').collect::<Vec<_>>()), Some(all));
        assert_eq!(Options::parse(&[]), Some(Options::default()));
        for wrong in [
            &["--library"][..],
            &["--from", "a", "--from", "b"],
            &["--windows", "a", "--windows", "b"],
            &["--else", "a"],
            &["a.dll"],
            &["--upm", "--from"],
        ] {
            assert_eq!(Options::parse(wrong), None, "{wrong:?}");
        }
    }
}
