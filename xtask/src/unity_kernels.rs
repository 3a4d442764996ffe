//! The kernels as Unity takes them: `NAME.compute`, or `NAME.shader` where they are drawn, in a `Resources` folder, where
//! the package finds them by name and every player has them; and the table of what they bind.
//!
//! A package has to bring every kernel that a live view of any scene may want, and Unity compiles each for every graphics
//! API of a player: [`DeviceLimits::few_kernels`] keeps them few. They are tens of thousands of lines: git holds the table and
//! a list of them, which [`check`] compares with what the WGSL says, and whoever packages or tests the package makes them.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use lumivox_renderer::{DeviceLimits, Features, FineTexels, LoopTurns, ViewKind};
use lumivox_shaders::{Kernel, KernelKind};

use crate::unity_kernels_hlsl::{Place, Translated, translate};
use crate::unity_metas::{self, fnv_1a};

/// In the package, and nothing else lies there; git does not see it.
const KERNELS: &str = "Runtime/Kernels/Generated";
/// What is committed.
const TABLE: &str = "unity/com.lumivox/Runtime/Gpu/KernelTable.cs";
const LIST: &str = "unity/hlsl/kernels.txt";

/// What generated files begin with.
const MARK: &str = "// Made by `cargo xtask unity-kernels` from crates/lumivox-shaders: do not edit.\n";

/// What chooses kernels of what Unity runs on; the rest does not matter here.
const LIMITS: DeviceLimits = {
    let mut limits = DeviceLimits::webgpu_default();
    limits.max_texture_3d = 2048;
    limits.max_texture_bytes = DeviceLimits::TEXTURE_BYTES_OF_GPU;
    limits.fine_texels = FineTexels::Norms;
    limits.max_texture_2d = 16384;
    limits.max_storage_binding = 128 << 20;
    limits.max_samples_per_dispatch = DeviceLimits::SAMPLES_OF_GPU;
    limits.few_kernels = true;
    limits
};

/// Kernels by name.
type Kernels = BTreeMap<String, (Kernel, Translated)>;

/// Writes the package's kernels into its folder, and what is committed of them.
pub fn write() -> Result<(), String> {
    let root = crate::root()?;
    let kernels = of_package()?;
    for (path, text) in committed(&kernels) {
        write_if_changed(&root.join(path), &text)?;
    }
    write_files(&root.join(unity_metas::PACKAGE), &kernels)
}

/// Writes the package's kernels into its folder, where what is committed of them is as they are.
pub fn write_listed() -> Result<(), String> {
    let root = crate::root()?;
    let kernels = of_package()?;
    compare(&root, &kernels)?;
    write_files(&root.join(unity_metas::PACKAGE), &kernels)
}

/// Writes them into a copy of the package.
pub fn complete(package: &Path) -> Result<(), String> {
    write_files(package, &of_package()?)
}

/// Compares what is committed with what would be written.
pub fn check() -> Result<(), String> {
    let kernels = of_package()?;
    compare(&crate::root()?, &kernels)?;
    println!("{} kernels are as listed", kernels.len());
    Ok(())
}

fn compare(root: &Path, kernels: &Kernels) -> Result<(), String> {
    for (path, text) in committed(kernels) {
        // Git may check files out with other ends of lines.
        let there = fs::read_to_string(root.join(path)).unwrap_or_default().replace("\r\n", "\n");
        if there != text {
            return Err(format!(
                "{path} is stale: run `cargo xtask unity-kernels`, and commit what it writes"
            ));
        }
    }
    Ok(())
}

/// Writes the kernels of stills, as the package would be given them, for tests: see [`write_table`].
pub fn write_stills(folder: &Path) -> Result<(), String> {
    write_table(folder, &translated([LIMITS], &[ViewKind::Still { guides: false }])?)
}

/// Writes the kernels of all views, of devices that count turns of loops, too: see [`write_table`].
pub fn write_all(folder: &Path) -> Result<(), String> {
    let limits = [false, true].into_iter().flat_map(|few_kernels| {
        [None, Some(LoopTurns::of_software(16))].map(|loop_turns| {
            LIMITS.with(|it| {
                it.few_kernels = few_kernels;
                it.loop_turns = loop_turns;
            })
        })
    });
    let views = [
        ViewKind::Live { guides: false, kept_light: true },
        ViewKind::Still { guides: false },
        ViewKind::Still { guides: true },
    ];
    write_table(folder, &translated(limits, &views)?)
}

/// Writes kernels into `Resources/Lumivox` of a folder, and beside that `table.txt`: a line for each, its name and entry point and,
/// in the order of its bindings, `u:`, `b:` and `t:` with the names of uniform buffers, others and textures.
fn write_table(folder: &Path, kernels: &Kernels) -> Result<(), String> {
    let mut table = String::new();
    for (name, (kernel, translated)) in kernels {
        let (kind, text) = file(*kernel, translated);
        write_if_changed(&folder.join(format!("Resources/Lumivox/{name}.{kind}")), &text)?;
        let _ = write!(table, "{name} {}", kernel.entry_point());
        for (place, name) in &translated.bindings {
            let place = match place {
                Place::Uniform => 'u',
                Place::Buffer => 'b',
                Place::Texture => 't',
            };
            let _ = write!(table, " {place}:{name}");
        }
        table.push('\n');
    }
    write_if_changed(&folder.join("table.txt"), &table)?;
    println!("{} kernels in {}", kernels.len(), folder.display());
    Ok(())
}

fn of_package() -> Result<Kernels, String> {
    translated([LIMITS], &[ViewKind::Live { guides: false, kept_light: true }])
}

/// Every kernel with which some view of some scene is recorded.
fn translated(limits: impl IntoIterator<Item = DeviceLimits>, views: &[ViewKind]) -> Result<Kernels, String> {
    let mut kernels = Kernels::new();
    for limits in limits {
        for (features, view) in Features::ALL.subsets().flat_map(|f| views.iter().map(move |view| (f, *view)))
        {
            for kernel in features.kernels(view, limits) {
                let name = kernel.name();
                if let Entry::Vacant(place) = kernels.entry(name) {
                    let translated =
                        translate(kernel).map_err(|error| format!("{}: {error}", place.key()))?;
                    place.insert((kernel, translated));
                }
            }
        }
    }
    Ok(kernels)
}

/// A kernel's kind of file, and what is in it.
fn file(kernel: Kernel, translated: &Translated) -> (&'static str, String) {
    match kernel.kind() {
        KernelKind::Compute => ("compute", compute(kernel, translated)),
        KernelKind::DrawColor | KernelKind::DrawOver | KernelKind::DrawDepth => {
            ("shader", shader(kernel, translated))
        }
    }
}

/// Files by their names.
fn files(kernels: &Kernels) -> BTreeMap<String, String> {
    let named = kernels.iter().map(|(name, (kernel, translated))| {
        let (kind, text) = file(*kernel, translated);
        (format!("{name}.{kind}"), text)
    });
    named.collect()
}

/// Files by their paths.
fn committed(kernels: &Kernels) -> [(&'static str, String); 2] {
    [(TABLE, table(kernels)), (LIST, list(&files(kernels)))]
}

/// Writes what is missing or stale into a package's folder, and removes what is made no more.
fn write_files(package: &Path, kernels: &Kernels) -> Result<(), String> {
    let folder = package.join(KERNELS).join("Resources/Lumivox");
    let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
    let files = files(kernels);
    fs::create_dir_all(&folder).map_err(failed)?;
    for entry in fs::read_dir(&folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if !files.contains_key(name.trim_end_matches(".meta")) {
            fs::remove_file(&path).map_err(failed)?;
        }
    }
    let mut written = 0;
    for (name, text) in &files {
        written += u32::from(write_if_changed(&folder.join(name), text)?);
    }
    unity_metas::complete(package, &package.join(KERNELS))?;
    println!("{} kernels, {written} of them changed", files.len());
    Ok(())
}

/// What a reviewer sees of the files: a line for each, its name, its lines and a hash of it, which tells whether it changed.
fn list(files: &BTreeMap<String, String>) -> String {
    let mut text = String::from("# Made by `cargo xtask unity-kernels`: file, lines, FNV-1a of 128 bits.\n");
    for (name, content) in files {
        let _ = writeln!(text, "{name} {} {:032x}", content.lines().count(), fnv_1a(content.bytes()));
    }
    text
}

fn compute(kernel: Kernel, translated: &Translated) -> String {
    format!("{MARK}#pragma kernel {}\n\n{}", kernel.entry_point(), translated.text)
}

fn shader(kernel: Kernel, translated: &Translated) -> String {
    let state = match kernel.kind() {
        KernelKind::DrawDepth => "ColorMask 0\n            ZWrite On",
        KernelKind::DrawOver => "Blend Off\n            ZWrite Off",
        _ => "Blend One OneMinusSrcAlpha\n            ZWrite Off",
    };
    let (vertex, fragment) = (Kernel::VERTEX_ENTRY_POINT, kernel.entry_point());
    format!(
        "{MARK}Shader \"Hidden/Lumivox/{name}\"\n\
         {{\n    SubShader\n    {{\n        Pass\n        {{\n            Cull Off\n            ZTest Always\n            \
         {state}\n\nHLSLPROGRAM\n#pragma target 4.5\n#pragma vertex {vertex}\n#pragma fragment {fragment}\n\n\
         {text}ENDHLSL\n        }}\n    }}\n}}\n",
        name = kernel.name(),
        text = translated.text,
    )
}

/// The table in C#.
fn table(kernels: &Kernels) -> String {
    let mut text = format!(
        "{MARK}\n\
         namespace Lumivox\n\
         {{\n    \
             /// <summary>What kernels there are, and by which names they bind.</summary>\n    \
             internal static class KernelTable\n    \
             {{\n        \
                 /// <summary>What a resource is.</summary>\n        \
                 internal enum Kind : byte\n        \
                 {{\n            \
                     /// <summary>A raw buffer.</summary>\n            \
                     Buffer,\n            \
                     /// <summary>A texture.</summary>\n            \
                     Texture,\n        \
                 }}\n\n        \
                 /// <summary>A kernel.</summary>\n        \
                 internal sealed class Entry\n        \
                 {{\n            \
                     /// <summary>Of its file, and by which recordings call it.</summary>\n            \
                     internal readonly string Name;\n            \
                     /// <summary>Of its program; of the fragment program where it is drawn.</summary>\n            \
                     internal readonly string EntryPoint;\n            \
                     /// <summary>Whether it is a shader that is drawn, not one that computes.</summary>\n            \
                     internal readonly bool IsDrawn;\n            \
                     /// <summary>Its constant buffers, in the order of a recording's uniforms.</summary>\n            \
                     internal readonly string[] Uniforms;\n            \
                     /// <summary>Its buffers and textures, in the order of a recording's resources.</summary>\n            \
                     internal readonly string[] Resources;\n            \
                     /// <summary>What each of them is.</summary>\n            \
                     internal readonly Kind[] Kinds;\n\n            \
                     internal Entry(string name, string entryPoint, bool isDrawn, string[] uniforms, string[] resources, Kind[] kinds)\n            \
                     {{\n                \
                         Name = name;\n                \
                         EntryPoint = entryPoint;\n                \
                         IsDrawn = isDrawn;\n                \
                         Uniforms = uniforms;\n                \
                         Resources = resources;\n                \
                         Kinds = kinds;\n            \
                     }}\n        \
                 }}\n\n        \
                 /// <summary>All of them, by name.</summary>\n        \
                 internal static readonly Entry[] Entries =\n        \
                 {{\n"
    );
    for (name, (kernel, translated)) in kernels {
        let names = |wanted: &dyn Fn(Place) -> bool| {
            let of_place = translated.bindings.iter().filter(|(place, _)| wanted(*place));
            of_place.map(|(_, name)| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
        };
        let kinds = translated.bindings.iter().filter_map(|(place, _)| match place {
            Place::Uniform => None,
            Place::Buffer => Some("Kind.Buffer"),
            Place::Texture => Some("Kind.Texture"),
        });
        let _ = writeln!(
            text,
            "            new Entry(\"{name}\", \"{}\", {},\n                new[] {{ {} }},\n                \
             new[] {{ {} }},\n                new[] {{ {} }}),",
            kernel.entry_point(),
            kernel.kind() != KernelKind::Compute,
            names(&|place| place == Place::Uniform),
            names(&|place| place != Place::Uniform),
            kinds.collect::<Vec<_>>().join(", "),
        );
    }
    text + "        };\n    }\n}\n"
}

/// Whether it was. Whoever reads the file meanwhile, such as an editor that imports it, finds the old one or the new one whole.
fn write_if_changed(path: &Path, text: &str) -> Result<bool, String> {
    if fs::read(path).is_ok_and(|bytes| bytes == text.as_bytes()) {
        return Ok(false);
    }
    let failed = |error: std::io::Error| format!("{}: {error}", path.display());
    let folder = path.parent().unwrap_or(Path::new("."));
    fs::create_dir_all(folder).map_err(failed)?;
    // Unity sees nothing that begins with a dot.
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let written = folder.join(format!(".{name}.{}", std::process::id()));
    let moved = fs::write(&written, text).and_then(|()| fs::rename(&written, path));
    moved.map_err(|error| {
        let _ = fs::remove_file(&written);
        failed(error)
    })?;
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_package_brings_few_kernels_and_all_that_live_views_want() {
        let kernels = of_package().unwrap();
        let traces = kernels.values().filter(|(kernel, _)| matches!(kernel, Kernel::PathTrace(_))).count();
        assert_eq!((kernels.len(), traces), (36, 13));
        let files = files(&kernels);
        assert!(files.values().all(|text| text.starts_with(MARK)));
        let depth = &files["composite_depth.shader"];
        assert!(depth.contains("ColorMask 0") && depth.contains("ZWrite On") && depth.contains("SV_Depth"));
        let color = &files["composite_color.shader"];
        assert!(color.contains("Blend One OneMinusSrcAlpha") && color.contains("#pragma vertex fullscreen"));
        assert!(files["film_count.compute"].contains("#pragma kernel film_count\n"));
        assert!(table(&kernels).contains("new[] { \"frame_buffer\" }"));
    }

    #[test]
    fn the_list_tells_which_kernel_changed() {
        let mut kernels =
            BTreeMap::from([("a.compute".into(), "x\ny\n".into()), ("b.shader".into(), "z".into())]);
        let before = list(&kernels);
        assert!(before.contains("\na.compute 2 ") && before.contains("\nb.shader 1 "), "{before}");
        kernels.insert("b.shader".into(), "w".into());
        let after = list(&kernels);
        let changed = before.lines().zip(after.lines()).filter(|(a, b)| a != b).count();
        assert_eq!((before.lines().count(), after.lines().count(), changed), (3, 3, 1));
    }

    #[test]
    fn a_folder_of_kernels_holds_those_that_are_made_and_no_others() {
        let package = std::env::temp_dir().join(format!("lumivox-kernels-{}", std::process::id()));
        let folder = package.join(KERNELS).join("Resources/Lumivox");
        fs::create_dir_all(&folder).unwrap();
        for old in ["old.compute", "old.compute.meta"] {
            fs::write(folder.join(old), "").unwrap();
        }
        complete(&package).unwrap();
        let entries = fs::read_dir(&folder).unwrap().flatten();
        let mut names: Vec<_> = entries.map(|entry| entry.file_name().into_string().unwrap()).collect();
        names.sort();
        let of_kernels = files(&of_package().unwrap()).into_keys();
        let mut wanted: Vec<_> = of_kernels.flat_map(|name| [format!("{name}.meta"), name]).collect();
        wanted.sort();
        assert_eq!(names, wanted);
        assert!(package.join(format!("{KERNELS}.meta")).exists());
        fs::remove_dir_all(&package).unwrap();
    }
}
