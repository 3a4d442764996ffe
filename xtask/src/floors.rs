//! Which module may import which, where a crate's modules lie on floors: imports go down, and nowhere in a circle. What is
//! written in the sources is looked at, tests left out.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::Path,
};

use crate::seam;

/// A module whose parts lie on floors. It stands on top of them itself.
struct House {
    /// The crate's sources.
    sources: &'static str,
    /// The module's path in the crate; empty for the crate itself.
    module: &'static [&'static str],
    /// Its parts, the lowest floor first. Those of one floor may import each other, but not in a circle.
    floors: &'static [&'static [&'static str]],
}

const HOUSES: &[House] = &[
    House {
        sources: "crates/lumivox-import/src",
        module: &[],
        floors: &[
            // Bytes, samples and words, of no format.
            &[
                "axes",
                "broken_pipe",
                "claims",
                "codec",
                "codec_worker",
                "codecs_here",
                "colors",
                "error",
                "files",
                "lengths",
                "luminance",
                "modality",
                "panorama",
                "payload",
                "sample",
                "samples",
                "sizes",
                "text_header",
                "written_samples",
            ],
            // What is said of a scan, and the way that all formats but DICOM end on.
            &["layout", "options", "placement", "raw_description", "report", "single", "values"],
            // The formats.
            &[
                "dicom",
                "format",
                "memory",
                "metaimage",
                "mgh",
                "nifti",
                "npy",
                "nrrd",
                "pictures",
                "radiance",
                "raw",
                "transfer_function_file",
                "zarr",
            ],
            // What people and scenes mean by files.
            &["choice", "environment_file", "labels", "source"],
            &["study"],
        ],
    },
    House {
        sources: "crates/lumivox-import/src",
        module: &["dicom"],
        floors: &[
            &["bytes"],
            &["elements"],
            &["header"],
            &["frames"],
            &["images"],
            &["series"],
            &["assembly"],
        ],
    },
];

/// A source file.
struct Source {
    /// As it is shown to people.
    shown: String,
    /// Its module's path in the crate.
    module: Vec<String>,
    text: String,
}

/// An import from one part of a module by another.
struct Arrow<'a> {
    from: &'a str,
    to: String,
    /// File and line.
    place: String,
}

/// Checks this workspace.
pub fn run() -> Result<(), String> {
    let mut broken = vec![];
    for house in HOUSES {
        let sources = read(house.sources)?;
        let found = violations(house, &sources);
        if found.is_empty() {
            let name = [&["crate"], house.module].concat().join("::");
            println!("floors: {} of {}, {name}", house.floors.len(), house.sources);
        }
        broken.extend(found);
    }
    broken.sort();
    broken.dedup();
    if broken.is_empty() {
        return Ok(());
    }
    Err(format!(
        "imports between modules go down and in no circle (floors of ARCHITECTURE.md; they are listed in \
         xtask/src/floors.rs):\n  {}",
        broken.join("\n  ")
    ))
}

fn read(folder: &str) -> Result<Vec<Source>, String> {
    let source = |path: std::path::PathBuf| {
        let shown = path.to_string_lossy().replace('\\', "/");
        let text = fs::read_to_string(&path).map_err(|error| format!("{shown}: {error}"))?;
        let module = module_of(shown.strip_prefix(folder).unwrap_or(&shown));
        Ok(Source { shown, module, text })
    };
    // Programs are crates of their own.
    let programs = Path::new(folder).join("bin");
    let paths = seam::sources(Path::new(folder).to_owned())?.into_iter();
    paths.filter(|path| !path.starts_with(&programs)).map(source).collect()
}

/// The module of a file whose path is given from the crate's sources.
fn module_of(path: &str) -> Vec<String> {
    let path = path.trim_start_matches('/').trim_end_matches(".rs");
    let mut module: Vec<String> = path.split('/').map(str::to_owned).collect();
    module.pop_if(|last| ["mod", "lib", "main"].contains(&last.as_str()));
    module
}

/// Every broken rule, as a sentence.
fn violations(house: &House, sources: &[Source]) -> Vec<String> {
    let module: Vec<String> = house.module.iter().map(|&part| part.to_owned()).collect();
    let depth = module.len();
    let parts = parts(&module, sources);
    let name = |part: &str| [&["crate"], house.module, &[part]].concat().join("::");
    let floor_of = |part: &str| house.floors.iter().position(|floor| floor.contains(&part));
    let mut broken = vec![];
    for part in parts.iter().filter(|part| floor_of(part).is_none()) {
        broken.push(format!("{} lies on no floor; put it on one", name(part)));
    }
    for part in house.floors.iter().flat_map(|floor| floor.iter()).filter(|part| !parts.contains(**part)) {
        broken.push(format!("{} has a floor and no file", name(part)));
    }
    let borrowed = reexports(&module, &parts, sources);
    let mut arrows = vec![];
    for source in
        sources.iter().filter(|source| source.module.len() > depth && source.module.starts_with(&module))
    {
        let from = source.module[depth].as_str();
        for (line, path) in imports(source) {
            if !path.starts_with(&module) {
                continue;
            }
            let place = format!("{}:{line}", source.shown);
            let to = path.get(depth).map_or("*", String::as_str);
            let to = borrowed.get(to).map_or(to, String::as_str);
            if !parts.contains(to) {
                let what = [&["crate".to_owned()], &path[..]].concat().join("::");
                broken.push(format!("{place} imports {what}, which is above all floors"));
                continue;
            }
            if floor_of(to) > floor_of(from) {
                broken.push(format!("{place} imports {to}, which lies above {from}"));
            } else if floor_of(to) == floor_of(from) {
                arrows.push(Arrow { from, to: to.to_owned(), place });
            }
        }
    }
    broken.extend(circle(&arrows));
    for part in &parts {
        circles_within(&[&module[..], std::slice::from_ref(part)].concat(), sources, &mut broken);
    }
    broken
}

/// Circles among the parts of a module and among theirs. The file of a module and those of its parts count as one.
fn circles_within(module: &[String], sources: &[Source], broken: &mut Vec<String>) {
    let (depth, parts) = (module.len(), parts(module, sources));
    let mut arrows = vec![];
    for source in
        sources.iter().filter(|source| source.module.len() > depth && source.module.starts_with(module))
    {
        for (line, path) in imports(source).into_iter().filter(|(_, path)| path.starts_with(module)) {
            if let Some(to) = path.get(depth).filter(|to| parts.contains(*to)) {
                let place = format!("{}:{line}", source.shown);
                arrows.push(Arrow { from: &source.module[depth], to: to.clone(), place });
            }
        }
    }
    broken.extend(circle(&arrows));
    for part in &parts {
        circles_within(&[module, std::slice::from_ref(part)].concat(), sources, broken);
    }
}

/// The modules right below one.
fn parts(module: &[String], sources: &[Source]) -> BTreeSet<String> {
    let below = sources.iter().filter(|source| source.module.starts_with(module));
    below.filter_map(|source| source.module.get(module.len()).cloned()).collect()
}

/// A circle of imports, if there is one, as a sentence.
fn circle(arrows: &[Arrow<'_>]) -> Option<String> {
    let mut from: BTreeMap<&str, Vec<&Arrow<'_>>> = BTreeMap::new();
    for arrow in arrows.iter().filter(|arrow| arrow.from != arrow.to) {
        from.entry(arrow.from).or_default().push(arrow);
    }
    // Whatever imports only what is in no circle is in none.
    loop {
        let free = from.iter().find(|(_, arrows)| arrows.iter().all(|arrow| !from.contains_key(&*arrow.to)));
        let Some((&free, _)) = free else { break };
        from.remove(free);
    }
    let mut at = *from.keys().next()?;
    let mut walked: Vec<&Arrow<'_>> = vec![];
    let first = loop {
        if let Some(first) = walked.iter().position(|arrow| arrow.from == at) {
            break first;
        }
        let next = from[at].iter().find(|arrow| from.contains_key(&*arrow.to))?;
        walked.push(next);
        at = &next.to;
    };
    let steps: Vec<String> =
        walked[first..].iter().map(|arrow| format!("{} imports {}", arrow.place, arrow.to)).collect();
    Some(format!("a circle: {}", steps.join(", ")))
}

/// What a module's own file names in it, out of its parts: an item's name, and the part that it is of.
fn reexports(module: &[String], parts: &BTreeSet<String>, sources: &[Source]) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    for source in sources.iter().filter(|source| source.module == module) {
        let code = code(&source.text);
        for (at, _) in code.match_indices("use ") {
            let mut paths = vec![];
            tree(&code, at + "use ".len(), vec![], &mut paths);
            for (_, path) in paths {
                if let [part, .., item] = &path[..]
                    && parts.contains(part)
                {
                    found.insert(item.clone(), part.clone());
                }
            }
        }
    }
    found
}

/// What a file imports of its own crate: lines, counted from 1, and paths from the crate on.
fn imports(source: &Source) -> Vec<(usize, Vec<String>)> {
    let code = code(&source.text);
    let mut found = vec![];
    for head in ["crate::", "super::", "self::"] {
        for (at, _) in code.match_indices(head) {
            let before = &code[..at];
            // The rest of a longer path or word, or how far something can be seen.
            let goes_on = before.ends_with(|c: char| c.is_alphanumeric() || "_:$".contains(c));
            if goes_on || before.ends_with("(in ") {
                continue;
            }
            let mut paths = vec![];
            tree(&code, at, vec![], &mut paths);
            let absolute =
                |(at, path)| (code[..at].matches('\n').count() + 1, absolute(&source.module, path));
            found.extend(paths.into_iter().map(absolute));
        }
    }
    found.sort();
    found
}

/// The code of a file: without comments, and without the tests at its end. Lines stay where they are.
fn code(text: &str) -> String {
    let lines = text.lines().take_while(|line| *line != "mod tests {");
    lines.map(|line| line.split("//").next().unwrap_or_default().to_owned() + "\n").collect()
}

/// Finds the paths of the tree of imports, or the one path, that begins at a place, and where each ends. Returns where the
/// tree ends.
fn tree(code: &str, mut at: usize, mut path: Vec<String>, found: &mut Vec<(usize, Vec<String>)>) -> usize {
    loop {
        let rest = &code[at..];
        if rest.starts_with('{') {
            at += 1;
            loop {
                let rest = &code[at..];
                // Commas, blanks, other names.
                let next = rest.find(|c: char| c.is_alphanumeric() || "_{}*".contains(c));
                let Some(next) = next else { return code.len() };
                at += next;
                if code[at..].starts_with('}') {
                    return at + 1;
                }
                at = tree(code, at, path.clone(), found);
                at += code[at..].find([',', '}']).unwrap_or(0);
            }
        }
        let length = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        if length == 0 {
            // All of it, or a generic's parameters.
            found.push((at, path));
            return at + usize::from(rest.starts_with('*'));
        }
        path.push(rest[..length].to_owned());
        at += length;
        if !code[at..].starts_with("::") {
            found.push((at, path));
            return at;
        }
        at += 2;
    }
}

/// The path from the crate on of one that begins with `crate`, `super` or `self`.
fn absolute(module: &[String], path: Vec<String>) -> Vec<String> {
    let mut base = module.to_vec();
    let mut absolute = vec![];
    for part in path {
        match part.as_str() {
            "crate" => base.clear(),
            "super" => drop(base.pop()),
            "self" => {}
            _ => absolute.push(part),
        }
    }
    base.extend(absolute);
    base
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOUSE: House = House {
        sources: "src",
        module: &["house"],
        floors: &[&["cellar"], &["ground", "garden"], &["attic"]],
    };

    fn check(files: &[(&str, &str)]) -> Vec<String> {
        let source = |&(path, text): &(&str, &str)| Source {
            shown: format!("src/{path}"),
            module: module_of(path),
            text: text.to_owned(),
        };
        let empty =
            ["house/mod.rs", "house/cellar.rs", "house/ground/mod.rs", "house/garden.rs", "house/attic.rs"];
        let missing = empty.iter().filter(|path| files.iter().all(|(given, _)| given != *path));
        let all: Vec<Source> =
            files.iter().map(source).chain(missing.map(|path| source(&(path, "")))).collect();
        violations(&HOUSE, &all)
    }

    #[test]
    fn imports_that_go_down_pass() {
        let attic = "//! See `crate::house`.\nuse crate::house::{cellar::{self, A as B, C}, ground::window::*};\n\
                     fn f() { super::garden::g::<u8>() }\n";
        let ground = "use super::super::cellar::D;\nuse crate::{house::garden, other::Thing};\n";
        let tests = "fn f() {}\n\n#[cfg(test)]\nmod tests {\n    use crate::house::attic;\n}\n";
        let files = [
            ("house/attic.rs", attic),
            ("house/ground/window.rs", ground),
            ("house/cellar.rs", tests),
            ("house/mod.rs", "mod attic;\nuse attic::A;\nuse crate::house::attic::B;\n"),
        ];
        assert_eq!(check(&files), Vec::<String>::new());
    }

    #[test]
    fn an_import_that_goes_up_is_told_by_file_and_line() {
        let below = "use crate::{\n    other::Thing,\n    house::{\n        garden::A,\n        attic::{B, C},\n    },\n};\n";
        let broken = check(&[("house/ground/mod.rs", below)]);
        let told = "src/house/ground/mod.rs:5 imports attic, which lies above ground";
        assert_eq!(broken, [told, told]);
        let broken = check(&[("house/cellar.rs", "fn f() {\n    super::attic::g()\n}\n")]);
        assert_eq!(broken, ["src/house/cellar.rs:2 imports attic, which lies above cellar"]);
        let broken = check(&[("house/ground/window.rs", "use super::super::attic;\n")]);
        assert_eq!(broken, ["src/house/ground/window.rs:1 imports attic, which lies above ground"]);
    }

    #[test]
    fn what_is_above_all_floors_is_imported_by_none_of_them() {
        for text in ["use super::Study;\n", "use crate::house::Study;\n", "use crate::{house::Study};\n"] {
            let broken = check(&[("house/attic.rs", text)]);
            assert_eq!(
                broken,
                ["src/house/attic.rs:1 imports crate::house::Study, which is above all floors"]
            );
        }
        for text in ["use crate::house;\n", "use crate::house::{self as h};\n", "use crate::house::*;\n"] {
            let broken = check(&[("house/attic.rs", text)]);
            assert_eq!(
                broken,
                ["src/house/attic.rs:1 imports crate::house, which is above all floors"],
                "{text}"
            );
        }
        // What the house borrows from a floor lies on that.
        let borrowed =
            [("house/mod.rs", "pub(crate) use attic::{A, B};\n"), ("house/cellar.rs", "use super::B;\n")];
        assert_eq!(check(&borrowed), ["src/house/cellar.rs:1 imports attic, which lies above cellar"]);
    }

    #[test]
    fn circles_on_a_floor_and_in_its_files_are_found() {
        let broken = check(&[
            ("house/ground/mod.rs", "use super::garden::A;\n"),
            ("house/garden.rs", "\nuse super::ground::B;\n"),
        ]);
        let circle =
            "a circle: src/house/garden.rs:2 imports ground, src/house/ground/mod.rs:1 imports garden";
        assert_eq!(broken, [circle]);
        let door = ("house/ground/door.rs", "use super::wall::A;\n");
        let wall = ("house/ground/wall.rs", "use crate::house::ground::window::A;\n");
        let window = ("house/ground/window.rs", "use super::{B, door::A};\n");
        assert_eq!(
            check(&[door, wall, window]),
            [
                "a circle: src/house/ground/door.rs:1 imports wall, src/house/ground/wall.rs:1 imports window, \
              src/house/ground/window.rs:1 imports door"
            ]
        );
        assert!(check(&[door, wall]).is_empty());
    }

    #[test]
    fn floors_and_files_belong_together() {
        let broken = check(&[("house/roof.rs", "")]);
        assert_eq!(broken, ["crate::house::roof lies on no floor; put it on one"]);
        let without = House { floors: &[&["cellar"], &["well"]], ..HOUSE };
        let cellar =
            Source { shown: String::new(), module: module_of("house/cellar.rs"), text: String::new() };
        assert_eq!(violations(&without, &[cellar]), ["crate::house::well has a floor and no file"]);
    }
}
