//! Whose works are in what people install: the crates that are linked into it, with their licences and texts.
//!
//! Which crates those are, `cargo tree` says, of the same selection and system that are built: neither what builds a crate nor
//! what tests it, and no macros, which stay at home.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use super::archive;

/// Texts of licences that leave no room for a name, and those that begin with one. For crates that come without a text.
const APACHE: &str = include_str!("../../../LICENSE-APACHE");
const CC0: &str = include_str!("../../licences/CC0-1.0.txt");
const MPL: &str = include_str!("../../licences/MPL-2.0.txt");
const BSL: &str = include_str!("../../licences/BSL-1.0.txt");
const BSD_3: &str = include_str!("../../licences/BSD-3-Clause.txt");
const MIT: &str = include_str!("../../../LICENSE-MIT");
const MINGW: &str = include_str!("../../licences/mingw-w64.txt");
const GCC: &str = include_str!("../../licences/GCC-exception-3.1.txt");

/// A work that is linked into something.
#[derive(Clone, Debug, PartialEq)]
pub struct Work {
    pub name: String,
    pub version: String,
    /// As SPDX writes it.
    pub license: String,
    /// Without their addresses.
    pub authors: Vec<String>,
    /// Where it is developed.
    pub home: String,
    /// The SHA-256 of its archive; none of our own.
    pub checksum: Option<String>,
    pub texts: Vec<String>,
    /// Works that it links itself.
    pub uses: Vec<Key>,
    /// Ours, the licence of which lies beside.
    pub is_own: bool,
    /// What kind of package it is, as package URLs name it.
    pub kind: &'static str,
}

/// Name and version.
pub type Key = (String, String);

impl Work {
    pub fn key(&self) -> Key {
        (self.name.clone(), self.version.clone())
    }

    /// The package URL.
    pub fn purl(&self) -> String {
        // `+` begins what says how a version was built.
        format!("pkg:{}/{}@{}", self.kind, self.name, self.version.replace('+', "%2B"))
    }
}

/// What links what, in a build.
pub struct Graph {
    edges: BTreeMap<Key, BTreeSet<Key>>,
    crates: BTreeMap<Key, Value>,
    checksums: BTreeMap<Key, String>,
    release: String,
}

impl Graph {
    /// Of packages that are built together for a system.
    pub fn new(root: &Path, target: &str, packages: &[&str]) -> Result<Self, String> {
        let mut tree = cargo(root);
        tree.args(["tree", "--locked", "--edges", "normal,no-proc-macro", "--prefix", "depth"]);
        tree.args(["--format", " {p}", "--target", target]);
        tree.args(packages.iter().flat_map(|name| ["--package", name]));
        let edges = edges(&output(&mut tree)?)?;
        let mut metadata = cargo(root);
        metadata.args(["metadata", "--locked", "--format-version", "1", "--filter-platform", target]);
        let mut said: Value = serde_json::from_str(&output(&mut metadata)?).map_err(|e| e.to_string())?;
        let mut crates = BTreeMap::new();
        for package in said["packages"].as_array_mut().into_iter().flatten() {
            let word = |key: &str| package[key].as_str().unwrap_or_default().to_owned();
            crates.insert((word("name"), word("version")), package.take());
        }
        let lock = super::read(&root.join("Cargo.lock"))?;
        let release = output(Command::new("rustc").arg("--version"))?;
        let release = release.split_whitespace().nth(1).ok_or("rustc says no version")?.to_owned();
        Ok(Self { edges, crates, checksums: checksums(&lock), release })
    }

    /// All that is linked into these, by name; they themselves, too.
    pub fn linked(&self, roots: &[&str]) -> Result<Vec<Work>, String> {
        let mut waiting: Vec<&Key> =
            self.edges.keys().filter(|(name, _)| roots.contains(&name.as_str())).collect();
        if waiting.len() != roots.len() {
            return Err(format!("{roots:?} are not what was built"));
        }
        let mut seen: BTreeSet<&Key> = waiting.iter().copied().collect();
        while let Some(key) = waiting.pop() {
            for used in &self.edges[key] {
                if seen.insert(used) {
                    waiting.push(used);
                }
            }
        }
        let mut works = seen.into_iter().map(|key| self.work(key)).collect::<Result<Vec<_>, _>>()?;
        works.push(self.standard_library());
        Ok(works)
    }

    fn work(&self, key: &Key) -> Result<Work, String> {
        let (name, version) = key;
        let said = self.crates.get(key).ok_or_else(|| format!("cargo metadata has no {name} {version}"))?;
        let word = |key: &str| said[key].as_str().unwrap_or_default().to_owned();
        let license = word("license").replace('/', " OR ");
        let authors = said["authors"].as_array().into_iter().flatten().filter_map(Value::as_str);
        let authors: Vec<String> =
            authors.map(|author| author.split(" <").next().unwrap_or(author).to_owned()).collect();
        let home = [word("repository"), word("homepage")].into_iter().find(|home| !home.is_empty());
        let is_own = said["source"].is_null();
        let manifest = word("manifest_path");
        let folder = Path::new(&manifest).parent().unwrap_or(Path::new(""));
        let (mut texts, of_fonts) = if is_own { Default::default() } else { texts(folder)? };
        if texts.is_empty() && !is_own {
            // The terms of what is compiled come first.
            let own =
                if of_fonts.is_empty() { &license } else { license.split(" AND ").next().unwrap_or("") };
            let standard = standard(own.trim_matches(['(', ')']), &authors).ok_or_else(|| {
                format!(
                    "{name} {version} ({license}) comes without the text of its licence, and none is in xtask/licences"
                )
            })?;
            texts.push(standard);
        }
        texts.extend(of_fonts);
        Ok(Work {
            name: name.clone(),
            version: version.clone(),
            license,
            authors,
            home: home.unwrap_or_default(),
            checksum: self.checksums.get(key).cloned(),
            texts,
            uses: self.edges[key].iter().cloned().collect(),
            is_own,
            kind: "cargo",
        })
    }

    /// Linked into every program of Rust.
    fn standard_library(&self) -> Work {
        let authors = vec!["The Rust Project Developers".to_owned()];
        let texts = ["Apache-2.0", "MIT"].iter().filter_map(|license| standard(license, &authors)).collect();
        Work {
            name: "rust-std".to_owned(),
            version: self.release.clone(),
            license: "MIT OR Apache-2.0".to_owned(),
            authors,
            home: "https://github.com/rust-lang/rust".to_owned(),
            checksum: None,
            texts,
            uses: vec![],
            is_own: false,
            kind: "generic",
        }
    }
}

/// The C++ library that Zig links into what it builds, by Zig's folder.
pub fn cxx_of_zig(zig: &Path, version: &str) -> Result<Work, String> {
    let text = super::read(&zig.join("lib/libcxx/LICENSE.TXT"))?;
    Ok(Work {
        name: "llvm-libcxx".to_owned(),
        version: format!("zig-{version}"),
        license: "Apache-2.0 WITH LLVM-exception".to_owned(),
        authors: vec!["The LLVM Project".to_owned()],
        home: "https://libcxx.llvm.org".to_owned(),
        checksum: None,
        texts: vec![text.trim().to_owned()],
        uses: vec![],
        is_own: false,
        kind: "generic",
    })
}

/// What MinGW's compilers link into programs for Windows: its own library, and GCC's.
pub fn runtime_of_mingw() -> Vec<Work> {
    let work = |name: &str, license: &str, home: &str, text: &str| Work {
        name: name.to_owned(),
        version: "of-the-compiler".to_owned(),
        license: license.to_owned(),
        authors: vec![],
        home: home.to_owned(),
        checksum: None,
        texts: vec![text.trim().to_owned()],
        uses: vec![],
        is_own: false,
        kind: "generic",
    };
    vec![
        work("mingw-w64", "ZPL-2.1 AND MIT AND BSD-3-Clause", "https://www.mingw-w64.org", MINGW),
        work("gcc-libraries", "GPL-3.0-or-later WITH GCC-exception-3.1", "https://gcc.gnu.org", GCC),
    ]
}

/// The notice that goes with a package: whose works are in it, and under what terms.
pub fn notice(works: &[Work]) -> String {
    let others = || works.iter().filter(|work| !work.is_own);
    let mut text = "What is compiled here has parts of these works.\n".to_owned();
    for work in others() {
        text += &format!("\n{} {}: {}\n", work.name, work.version, work.license);
        for line in [work.authors.join(", "), work.home.clone()] {
            if !line.is_empty() {
                text += &format!("{line}\n");
            }
        }
        if work.license.contains("MPL") {
            text += "Its source is at that address, and in the Rust community's registry under its name and version.\n";
        }
    }
    // Each text once, below all that have it.
    let mut users: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    let mut order = vec![];
    for work in others() {
        for one in &work.texts {
            let of_it = users.entry(one).or_insert_with(|| {
                order.push(one.as_str());
                vec![]
            });
            of_it.push(format!("{} {}", work.name, work.version));
        }
    }
    for one in order {
        text += &format!("\n\n{}\n{}\n\n{one}\n", "=".repeat(80), users[one].join(", "));
    }
    text
}

/// Licence texts in a crate's sources, each once; those of C sources lie in folders of their own. Then those of fonts: all texts
/// beside them.
fn texts(folder: &Path) -> Result<(Vec<String>, Vec<String>), String> {
    let (mut found, mut of_fonts) = (vec![], vec![]);
    let paths = archive::below(folder)?;
    let within = |path: &str| path.rsplit_once('/').map_or("", |(folder, _)| folder).to_owned();
    let is_font = |path: &&String| path.ends_with(".ttf") || path.ends_with(".otf");
    let fonts: BTreeSet<String> = paths.iter().filter(is_font).map(|path| within(path)).collect();
    for path in &paths {
        let found: &mut Vec<String> = match is_text(path.rsplit('/').next().unwrap_or(path)) {
            true => &mut found,
            false if path.ends_with(".txt") && fonts.contains(&within(path)) => &mut of_fonts,
            false => continue,
        };
        let file = folder.join(path);
        let bytes = fs::read(&file).map_err(|error| format!("{}: {error}", file.display()))?;
        let text = String::from_utf8_lossy(&bytes).replace("\r\n", "\n").trim().to_owned();
        if !text.is_empty() && !found.contains(&text) {
            found.push(text);
        }
    }
    Ok((found, of_fonts))
}

fn is_text(name: &str) -> bool {
    let name = name.to_uppercase();
    let code = [".RS", ".C", ".CPP", ".H", ".PY", ".TOML"];
    let starts = ["LICENSE", "LICENCE", "COPYING", "NOTICE", "COPYRIGHT", "UNLICENSE"];
    let rest = starts.iter().find_map(|start| name.strip_prefix(start));
    rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['-', '.', '_']))
        && !code.iter().any(|ending| name.ends_with(ending))
}

/// The text of a licence, or of one that may be chosen, where it is a standard one. Where it names the holders of rights, those are the
/// authors, who then must be known.
fn standard(license: &str, authors: &[String]) -> Option<String> {
    let holders = (!authors.is_empty()).then(|| authors.join(", "));
    license.split(" OR ").find_map(|one| match one.trim() {
        "Apache-2.0" => Some(APACHE.trim().to_owned()),
        "BSL-1.0" => Some(BSL.trim().to_owned()),
        "CC0-1.0" => Some(CC0.trim().to_owned()),
        "MPL-2.0" => Some(MPL.trim().to_owned()),
        "BSD-3-Clause" => Some(format!("Copyright (c) {}\n\n{}", holders.as_ref()?, BSD_3.trim())),
        "MIT" => {
            let terms = MIT.split_once("Permission is hereby granted")?.1;
            let head = format!("MIT License\n\nCopyright (c) {}", holders.as_ref()?);
            Some(format!("{head}\n\nPermission is hereby granted{terms}").trim().to_owned())
        }
        _ => None,
    })
}

/// Who links whom, of `cargo tree --prefix depth`: what was listed before is not listed again below.
fn edges(tree: &str) -> Result<BTreeMap<Key, BTreeSet<Key>>, String> {
    let mut edges: BTreeMap<Key, BTreeSet<Key>> = BTreeMap::new();
    let mut path: Vec<Key> = vec![];
    for line in tree.lines().filter(|line| !line.is_empty()) {
        let wrong = || format!("cargo tree says {line:?}");
        let (depth, package) = line.split_once(' ').ok_or_else(wrong)?;
        let depth: usize = depth.parse().map_err(|_| wrong())?;
        let mut words = package.split(' ');
        let (name, version) = (words.next(), words.next().and_then(|word| word.strip_prefix('v')));
        let key = (name.ok_or_else(wrong)?.to_owned(), version.ok_or_else(wrong)?.to_owned());
        path.truncate(depth);
        if let Some(parent) = path.last() {
            edges.entry(parent.clone()).or_default().insert(key.clone());
        }
        edges.entry(key.clone()).or_default();
        path.push(key);
    }
    Ok(edges)
}

/// Of Cargo.lock.
fn checksums(lock: &str) -> BTreeMap<Key, String> {
    let mut found = BTreeMap::new();
    for block in lock.split("[[package]]") {
        let value = |key: &str| {
            let line = block.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(" = \""))?;
            line.strip_suffix('"').map(str::to_owned)
        };
        if let (Some(name), Some(version), Some(checksum)) =
            (value("name"), value("version"), value("checksum"))
        {
            found.insert((name, version), checksum);
        }
    }
    found
}

fn cargo(root: &Path) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root);
    command
}

fn output(command: &mut Command) -> Result<String, String> {
    let output = command.output().map_err(|error| format!("{command:?}: {error}"))?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    Err(format!("{command:?}: {}", String::from_utf8_lossy(&output.stderr).trim_end()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(name: &str) -> Key {
        (name.to_owned(), "1.0.0".to_owned())
    }

    #[test]
    fn what_is_linked_through_others_is_linked() {
        let tree = "0 app v1.0.0 (/x/app)\n1 a v1.0.0\n2 b v1.0.0\n3 c v1.0.0\n1 c v1.0.0\n\n0 tool v1.0.0\n1 b v1.0.0 (*)\n";
        let edges = edges(tree).unwrap();
        let of = |name: &str| edges[&key(name)].iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>();
        assert_eq!(of("app"), ["a", "c"]);
        assert_eq!(of("b"), ["c"]);
        assert_eq!(of("tool"), ["b"]);
        assert!(super::edges("app v1").is_err());
    }

    #[test]
    fn the_text_of_a_licence_is_found_or_not_made_up() {
        let nobody = &[][..];
        assert!(standard("Zlib OR Apache-2.0", nobody).unwrap().contains("Apache License"));
        assert!(standard("BSL-1.0", nobody).unwrap().contains("Boost Software License"));
        assert!(standard("CC0-1.0", nobody).unwrap().contains("CC0 1.0 Universal"));
        assert!(standard("MPL-2.0", nobody).unwrap().contains("Mozilla Public License"));
        // Whose rights those are, nobody says.
        assert_eq!(standard("MIT", nobody), None);
        assert_eq!(standard("LGPL-3.0", &["A".to_owned()]), None);
        let mit = standard("MIT", &["A. Nyone".to_owned()]).unwrap();
        assert!(mit.contains("(c) A. Nyone") && mit.contains("Permission is hereby granted, free"), "{mit}");
        assert!(!mit.contains("Lumivox"), "{mit}");
        assert!(standard("BSD-3-Clause", &["A. Nyone".to_owned()]).unwrap().contains("Neither the name"));
        for (name, is_one) in [
            ("LICENSE", true),
            ("LICENSE-MIT", true),
            ("licence.txt", true),
            ("COPYING.LESSER", true),
            ("license.rs", false),
            ("licenses", false),
            ("README.md", false),
        ] {
            assert_eq!(is_text(name), is_one, "{name}");
        }
    }

    #[test]
    fn the_page_has_its_fonts_terms() {
        let root = crate::root().unwrap();
        let graph = Graph::new(&root, "wasm32-unknown-unknown", &["lumivox-studio"]).unwrap();
        let notice = notice(&graph.linked(&["lumivox-studio"]).unwrap());
        for terms in
            ["SIL OPEN FONT LICENSE", "UBUNTU FONT LICENCE", "Bitstream Vera License", "Apache License"]
        {
            assert!(notice.contains(terms), "{terms}");
        }
    }

    #[test]
    fn everything_in_the_unity_library_has_a_text_and_a_checksum() {
        let root = crate::root().unwrap();
        let graph = Graph::new(&root, "x86_64-unknown-linux-gnu", &["lumivox-unity", "lumivox"]).unwrap();
        let works = graph.linked(&["lumivox-unity"]).unwrap();
        let names: Vec<&str> = works.iter().map(|work| work.name.as_str()).collect();
        for wanted in ["lumivox-unity", "lumivox-core", "openjpeg-sys", "rust-std"] {
            assert!(names.contains(&wanted), "{names:?}");
        }
        // Neither another package's, nor macros, nor tests'.
        for unwanted in ["wgpu", "clap", "serde_derive", "lumivox-testing"] {
            assert!(!names.contains(&unwanted), "{names:?}");
        }
        for work in &works {
            assert_eq!(work.texts.is_empty(), work.is_own, "{work:?}");
            assert!(work.is_own || work.checksum.is_some() || work.kind == "generic", "{work:?}");
        }
        let notice = notice(&works);
        assert!(notice.contains("openjpeg-sys") && !notice.contains("lumivox-core"), "{notice}");
        assert!(graph.linked(&["nothing"]).is_err());
    }
}
