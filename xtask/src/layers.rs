//! Which crate may import which: the rules of ARCHITECTURE.md, checked against `cargo metadata`.
//!
//! Imports go one way: core <- import, phantom, segmentation, reference; core <- shaders <- renderer <- executors <- apps.
//! Dev-dependencies are free (a renderer's tests need an executor), except that nobody imports an app.

use std::{
    collections::{BTreeMap, BTreeSet},
    process::Command,
};

use serde_json::Value;

use crate::{floors, seam};

/// What one crate of the workspace may import.
struct Rule {
    name: &'static str,
    /// Crates of the workspace that it may depend on.
    imports: &'static [&'static str],
    kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// Runs in every host: no GPU API, window or engine, however indirectly.
    Portable,
    /// May use whatever it needs.
    Library,
    /// Only ever a dev-dependency, but of others of its kind.
    TestOnly,
    /// A program; nobody imports it.
    App,
}

/// What others may build on: published, and together.
pub const LIBRARIES: &[&str] = &[
    "lumivox-core",
    "lumivox-import",
    "lumivox-phantom",
    "lumivox-segmentation",
    "lumivox-scene",
    "lumivox-reference",
    "lumivox-shaders",
    "lumivox-renderer",
    "lumivox-wgpu",
];

#[rustfmt::skip]
const RULES: &[Rule] = &[
    Rule { name: "lumivox-core",      kind: Kind::Portable, imports: &[] },
    Rule { name: "lumivox-import",    kind: Kind::Portable, imports: &["lumivox-core"] },
    Rule { name: "lumivox-phantom",   kind: Kind::Portable, imports: &["lumivox-core"] },
    Rule { name: "lumivox-segmentation", kind: Kind::Portable, imports: &["lumivox-core"] },
    Rule { name: "lumivox-scene",     kind: Kind::Portable, imports: &["lumivox-core", "lumivox-import", "lumivox-segmentation"] },
    // The evidence must not share a line with what it judges.
    Rule { name: "lumivox-reference", kind: Kind::Portable, imports: &["lumivox-core"] },
    Rule { name: "lumivox-shaders",   kind: Kind::Portable, imports: &["lumivox-core"] },
    Rule { name: "lumivox-renderer",  kind: Kind::Portable, imports: &["lumivox-core", "lumivox-shaders"] },
    Rule { name: "lumivox-wgpu",      kind: Kind::Library,  imports: &["lumivox-core", "lumivox-shaders", "lumivox-renderer"] },
    // A live view for hosts with a user interface: it knows none, but wgpu.
    Rule { name: "lumivox-viewport",  kind: Kind::Library,  imports: &["lumivox-core", "lumivox-shaders", "lumivox-renderer", "lumivox-wgpu"] },
    // What pages have of their browser.
    Rule { name: "lumivox-browser",   kind: Kind::Library,  imports: &["lumivox-core", "lumivox-import", "lumivox-renderer", "lumivox-viewport", "lumivox-wgpu"] },
    // What asks archives; it knows no scans.
    Rule { name: "lumivox-dicomweb",  kind: Kind::Library,  imports: &["lumivox-core"] },
    Rule { name: "lumivox-testing",   kind: Kind::TestOnly, imports: LIBRARIES },
    Rule { name: "lumivox",           kind: Kind::App,      imports: LIBRARIES },
    Rule { name: "lumivox-window",    kind: Kind::App,      imports: LIBRARIES },
    Rule { name: "lumivox-js",        kind: Kind::App,      imports: &["lumivox-browser", "lumivox-core", "lumivox-import", "lumivox-phantom", "lumivox-scene", "lumivox-viewport", "lumivox-wgpu"] },
    Rule { name: "lumivox-studio",    kind: Kind::App,      imports: &["lumivox-browser", "lumivox-core", "lumivox-dicomweb", "lumivox-import", "lumivox-phantom", "lumivox-scene", "lumivox-renderer", "lumivox-viewport", "lumivox-wgpu"] },
    // Its tests depend on it, so that it is built with them; nobody else does.
    Rule { name: "lumivox-godot",     kind: Kind::Library,  imports: &["lumivox-core", "lumivox-import", "lumivox-phantom", "lumivox-scene", "lumivox-segmentation", "lumivox-shaders", "lumivox-renderer"] },
    // The program of the import crate is built with them, too.
    Rule { name: "lumivox-godot-tests", kind: Kind::App,    imports: &["lumivox-import"] },
    Rule { name: "lumivox-unity",     kind: Kind::Library,  imports: &["lumivox-core", "lumivox-import", "lumivox-phantom", "lumivox-scene", "lumivox-segmentation", "lumivox-shaders", "lumivox-renderer"] },
    // What the Unity package's tests have in place of an engine's GPU; knows nothing of ours.
    Rule { name: "standin-gpu",       kind: Kind::TestOnly, imports: &[] },
    // What its pictures are compared with: test scenes, and the wgpu host.
    Rule { name: "standin-twin",      kind: Kind::TestOnly,      imports: &["lumivox-renderer", "lumivox-testing", "lumivox-unity", "lumivox-wgpu"] },
    // The program of the import crate is built with them, as with Godot's.
    Rule { name: "lumivox-unity-tests", kind: Kind::App,    imports: &["lumivox-import"] },
    Rule { name: "lumivox-python",    kind: Kind::App,      imports: LIBRARIES },
    // It translates the kernels for Unity.
    Rule { name: "xtask",             kind: Kind::App,      imports: &["lumivox-shaders", "lumivox-renderer"] },
];

/// GPU APIs, windows, user interfaces and engines, with the crates whose names begin so. naga is not one: it only
/// translates shaders.
const HOST_CRATES: &[&str] =
    &["wgpu", "winit", "egui", "eframe", "bevy", "godot", "ash", "vulkano", "metal", "objc2-metal"];

/// The part of `cargo metadata` that the rules are about. Names of packages; kinds as Cargo writes them.
#[derive(Default)]
struct Graph {
    /// Crates of the workspace.
    members: BTreeSet<String>,
    /// Dependencies a package declares, for any platform.
    declared: BTreeMap<String, Vec<Dependency>>,
    /// Normal and build dependencies as resolved for this platform, by package.
    resolved: BTreeMap<String, BTreeSet<String>>,
}

struct Dependency {
    name: String,
    dev: bool,
}

impl Graph {
    fn from_metadata(metadata: &Value) -> Option<Self> {
        let mut graph = Graph::default();
        let mut names = BTreeMap::new();
        for package in metadata["packages"].as_array()? {
            let name = package["name"].as_str()?.to_owned();
            names.insert(package["id"].as_str()?, name.clone());
            let dependencies = package["dependencies"].as_array()?.iter().map(|dependency| {
                let dev = dependency["kind"] == "dev";
                Some(Dependency { name: dependency["name"].as_str()?.to_owned(), dev })
            });
            graph.declared.entry(name).or_default().extend(dependencies.collect::<Option<Vec<_>>>()?);
        }
        for id in metadata["workspace_members"].as_array()? {
            graph.members.insert(names.get(id.as_str()?)?.clone());
        }
        for node in metadata["resolve"]["nodes"].as_array()? {
            let from = names.get(node["id"].as_str()?)?;
            let to = graph.resolved.entry(from.clone()).or_default();
            for dependency in node["deps"].as_array()? {
                let used = dependency["dep_kinds"].as_array()?.iter().any(|kind| kind["kind"] != "dev");
                if used {
                    to.insert(names.get(dependency["pkg"].as_str()?)?.clone());
                }
            }
        }
        Some(graph)
    }

    /// The shortest chain of imports from `start` to a package that satisfies `found`, both ends included.
    fn path_to(&self, start: &str, found: impl Fn(&str) -> bool) -> Option<Vec<String>> {
        let mut came_from = BTreeMap::from([(start, None)]);
        let mut queue = std::collections::VecDeque::from([start]);
        while let Some(at) = queue.pop_front() {
            if at != start && found(at) {
                let path = std::iter::successors(Some(at), |step| came_from[step]);
                let mut path: Vec<String> = path.map(str::to_owned).collect();
                path.reverse();
                return Some(path);
            }
            let declared = self.declared.get(at).into_iter().flatten();
            // Of strangers only what is really built counts; our own crates answer for every platform.
            let declared = declared.filter(|d| self.members.contains(at) && !d.dev).map(|d| &d.name);
            for next in self.resolved.get(at).into_iter().flatten().chain(declared) {
                came_from.entry(next).or_insert_with(|| {
                    queue.push_back(next);
                    Some(at)
                });
            }
        }
        None
    }
}

fn is_host_crate(name: &str) -> bool {
    HOST_CRATES.iter().any(|host| {
        name.strip_prefix(host).is_some_and(|rest| rest.is_empty() || rest.starts_with(['-', '_']))
    })
}

/// Every broken rule, as a sentence.
fn violations(graph: &Graph, rules: &[Rule]) -> Vec<String> {
    let mut broken = Vec::new();
    let kind_of = |name: &str| rules.iter().find(|rule| rule.name == name).map(|rule| rule.kind);
    for member in &graph.members {
        let Some(rule) = rules.iter().find(|rule| rule.name == *member) else {
            broken.push(format!("{member} has no rule; add one to xtask/src/layers.rs"));
            continue;
        };
        for dependency in graph.declared.get(member).into_iter().flatten() {
            let name = dependency.name.as_str();
            if !graph.members.contains(name) {
                continue;
            }
            if kind_of(name) == Some(Kind::App) {
                broken.push(format!("{member} imports {name}, a program; nobody imports a program"));
            } else if dependency.dev {
            } else if kind_of(name) == Some(Kind::TestOnly) && rule.kind != Kind::TestOnly {
                broken.push(format!("{member} imports {name}, which may only be a dev-dependency"));
            } else if !rule.imports.contains(&name) {
                let allowed =
                    if rule.imports.is_empty() { "nothing".into() } else { rule.imports.join(", ") };
                broken.push(format!("{member} imports {name}; of this workspace it may import {allowed}"));
            }
        }
        if rule.kind == Kind::Portable
            && let Some(path) = graph.path_to(member, is_host_crate)
        {
            let path = path.join(" -> ");
            broken.push(format!("{member} must run in every host, but imports one: {path}"));
        }
    }
    broken
}

/// Checks this workspace.
pub fn run() -> Result<(), String> {
    let metadata = metadata()?;
    let graph = Graph::from_metadata(&metadata).ok_or("cargo metadata has an unexpected form")?;
    let broken = violations(&graph, RULES);
    if broken.is_empty() {
        println!("layers: the imports of {} crates go one way", graph.members.len());
        seam::run()?;
        return floors::run();
    }
    Err(format!("imports between crates break the rules of ARCHITECTURE.md:\n  {}", broken.join("\n  ")))
}

fn metadata() -> Result<Value, String> {
    let output = |command: &mut Command| -> Result<Vec<u8>, String> {
        let output = command
            .stderr(std::process::Stdio::inherit())
            .output()
            .map_err(|error| format!("{command:?}: {error}"))?;
        if output.status.success() { Ok(output.stdout) } else { Err(format!("{command:?} failed")) }
    };
    // One platform only, so that Cargo does not download the crates of all others.
    let version = output(Command::new("rustc").arg("-vV"))?;
    let version = String::from_utf8_lossy(&version);
    let host =
        version.lines().find_map(|line| line.strip_prefix("host: ")).ok_or("rustc -vV names no host")?;
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let json =
        output(Command::new(cargo).args(["metadata", "--format-version", "1", "--filter-platform", host]))?;
    serde_json::from_slice(&json).map_err(|error| format!("cargo metadata: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A graph of `(package, [(dependency, is dev)])`; the packages with a rule are the workspace.
    fn graph(packages: &[(&str, &[(&str, bool)])]) -> Graph {
        let mut graph = Graph::default();
        for (name, dependencies) in packages {
            if name.starts_with("lumivox") || *name == "xtask" {
                graph.members.insert((*name).into());
            }
            let of = |&(name, dev): &(&str, bool)| Dependency { name: name.into(), dev };
            graph.declared.insert((*name).into(), dependencies.iter().map(of).collect());
            let built = dependencies.iter().filter(|d| !d.1).map(|d| d.0.to_owned());
            graph.resolved.insert((*name).into(), built.collect());
        }
        graph
    }

    fn check(packages: &[(&str, &[(&str, bool)])]) -> Vec<String> {
        violations(&graph(packages), RULES)
    }

    #[test]
    fn the_designed_graph_passes() {
        let broken = check(&[
            ("lumivox-core", &[("glam", false)]),
            ("lumivox-reference", &[("lumivox-core", false), ("lumivox-testing", true)]),
            ("lumivox-testing", &[("lumivox-core", false)]),
            ("lumivox-shaders", &[("naga", false)]),
            ("lumivox-renderer", &[("lumivox-shaders", false), ("lumivox-wgpu", true)]),
            ("lumivox-wgpu", &[("lumivox-renderer", false), ("wgpu", false)]),
            ("lumivox", &[("lumivox-wgpu", false)]),
            ("xtask", &[("serde_json", false)]),
            ("wgpu", &[("naga", false)]),
        ]);
        assert_eq!(broken, Vec::<String>::new());
    }

    #[test]
    fn an_import_against_the_direction_is_caught() {
        let broken = check(&[("lumivox-core", &[("lumivox-import", false)]), ("lumivox-import", &[])]);
        assert_eq!(broken, ["lumivox-core imports lumivox-import; of this workspace it may import nothing"]);
    }

    #[test]
    fn the_reference_stays_independent() {
        for shared in ["lumivox-shaders", "lumivox-renderer"] {
            let broken = check(&[("lumivox-reference", &[(shared, false)]), (shared, &[])]);
            assert_eq!(broken.len(), 1, "{broken:?}");
        }
    }

    #[test]
    fn a_gpu_api_far_below_a_portable_crate_is_caught_with_its_path() {
        let broken = check(&[
            ("lumivox-renderer", &[("innocent", false)]),
            ("innocent", &[("wgpu-types", false)]),
            ("wgpu-types", &[]),
        ]);
        assert_eq!(
            broken,
            ["lumivox-renderer must run in every host, but imports one: \
              lumivox-renderer -> innocent -> wgpu-types"]
        );
        assert!(check(&[("lumivox-renderer", &[("wgpu", true)])]).is_empty(), "dev-dependencies are free");
    }

    #[test]
    fn host_crates_are_told_from_their_namesakes() {
        assert!(is_host_crate("wgpu") && is_host_crate("wgpu-hal") && is_host_crate("bevy_ecs"));
        assert!(!is_host_crate("ashlar") && !is_host_crate("naga"));
    }

    #[test]
    fn programs_and_test_crates_are_not_imported() {
        let broken = check(&[("lumivox", &[]), ("lumivox-wgpu", &[("lumivox", true)])]);
        assert_eq!(broken, ["lumivox-wgpu imports lumivox, a program; nobody imports a program"]);
        let broken = check(&[("lumivox-testing", &[]), ("lumivox", &[("lumivox-testing", false)])]);
        assert_eq!(broken, ["lumivox imports lumivox-testing, which may only be a dev-dependency"]);
    }

    #[test]
    fn a_crate_without_a_rule_is_caught() {
        assert_eq!(check(&[("lumivox-new", &[])]).len(), 1);
    }

    #[test]
    fn metadata_is_read() {
        let metadata = serde_json::json!({
            "packages": [
                { "id": "a 1", "name": "lumivox-core", "dependencies": [
                    { "name": "glam", "kind": null }, { "name": "lumivox-testing", "kind": "dev" } ] },
                { "id": "b 1", "name": "glam", "dependencies": [] },
                { "id": "c 1", "name": "lumivox-testing", "dependencies": [] },
            ],
            "workspace_members": ["a 1", "c 1"],
            "resolve": { "nodes": [
                { "id": "a 1", "deps": [
                    { "pkg": "b 1", "dep_kinds": [{ "kind": null }, { "kind": "dev" }] },
                    { "pkg": "c 1", "dep_kinds": [{ "kind": "dev" }] } ] },
            ] },
        });
        let graph = Graph::from_metadata(&metadata).unwrap();
        assert_eq!(graph.members.len(), 2);
        assert_eq!(graph.resolved["lumivox-core"], BTreeSet::from(["glam".to_owned()]));
        assert_eq!(graph.declared["lumivox-core"].iter().map(|d| d.dev).collect::<Vec<_>>(), [false, true]);
        assert!(violations(&graph, RULES).is_empty());
        assert!(Graph::from_metadata(&serde_json::json!({})).is_none());
    }
}
