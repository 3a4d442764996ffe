//! The `.meta` files of the Unity package: each file and folder has one with an identifier that scenes and prefabs refer
//! to, so that it must never change. It is made of the path within the package; a file that moves keeps what it has.
//!
//! Kernels, which git does not hold, get theirs when they are made.
//!
//! Folders whose names end with `~` are hidden from Unity and have none, nor has what begins with a dot.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The package, below the project's root.
pub const PACKAGE: &str = "unity/com.lumivox";

/// Writes those that are missing, and removes those whose file is gone.
pub fn write() -> Result<(), String> {
    let root = root()?;
    for path in unmatched(&root)? {
        fs::remove_file(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        println!("removed {}", path.display());
    }
    complete(&root, &root)?;
    check()
}

/// Writes those that are lacking within a folder of the package or of a copy of it, `root`.
pub fn complete(root: &Path, folder: &Path) -> Result<(), String> {
    for path in assets(root)?.into_iter().filter(|path| path.starts_with(folder)) {
        let meta = meta_of(&path);
        if !meta.exists() {
            let text = text(root, &path);
            fs::write(&meta, text).map_err(|error| format!("{}: {error}", meta.display()))?;
        }
    }
    Ok(())
}

/// Whether each file has one, none is left over, and no identifier is there twice.
pub fn check() -> Result<(), String> {
    let root = root()?;
    let remedy = "run `cargo xtask unity-metas`";
    if let Some(path) = unmatched(&root)?.first() {
        return Err(format!("{} belongs to no file: {remedy}", path.display()));
    }
    let mut known: BTreeMap<String, PathBuf> = BTreeMap::new();
    for path in assets(&root)? {
        let meta = meta_of(&path);
        let text =
            fs::read_to_string(&meta).map_err(|_| format!("{} has no .meta: {remedy}", path.display()))?;
        let guid = text.lines().find_map(|line| line.strip_prefix("guid: ")).unwrap_or_default();
        if guid.len() != 32 || !guid.bytes().all(|b| b.is_ascii_digit() || (b'a'..=b'f').contains(&b)) {
            return Err(format!("{} has no identifier of 32 lowercase hexadecimal digits", meta.display()));
        }
        if let Some(other) = known.insert(guid.to_owned(), path.clone()) {
            return Err(format!("{} and {} have the same identifier", other.display(), path.display()));
        }
    }
    println!("{} files and folders, each with an identifier of its own", known.len());
    Ok(())
}

fn root() -> Result<PathBuf, String> {
    Ok(crate::root()?.join(PACKAGE))
}

fn meta_of(path: &Path) -> PathBuf {
    let mut meta = path.as_os_str().to_owned();
    meta.push(".meta");
    meta.into()
}

/// Every file and folder that Unity sees, in order.
fn assets(root: &Path) -> Result<Vec<PathBuf>, String> {
    let all = entries(root)?;
    Ok(all.into_iter().filter(|path| path.extension().is_none_or(|extension| extension != "meta")).collect())
}

/// `.meta` files beside no file.
fn unmatched(root: &Path) -> Result<Vec<PathBuf>, String> {
    let is_meta = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "meta");
    Ok(entries(root)?.into_iter().filter(|path| is_meta(path) && !path.with_extension("").exists()).collect())
}

fn entries(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
    let mut all = vec![];
    for entry in fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if name.starts_with('.') || name.ends_with('~') {
            continue;
        }
        if path.is_dir() {
            all.extend(entries(&path)?);
        }
        all.push(path);
    }
    all.sort();
    Ok(all)
}

/// What Unity writes for a new file of this kind.
fn text(root: &Path, path: &Path) -> String {
    let inside = path.strip_prefix(root).unwrap_or(path).to_string_lossy().replace('\\', "/");
    let tail = "  externalObjects: {}\n  userData: \n  assetBundleName: \n  assetBundleVariant: \n";
    let extension = path.extension().unwrap_or_default().to_string_lossy().into_owned();
    let importer = match extension.as_str() {
        _ if path.is_dir() => format!("folderAsset: yes\nDefaultImporter:\n{tail}"),
        "cs" => format!(
            "MonoImporter:\n  externalObjects: {{}}\n  serializedVersion: 2\n  defaultReferences: []\n  executionOrder: 0\n  \
             icon: {{instanceID: 0}}\n{}",
            tail.trim_start_matches("  externalObjects: {}\n")
        ),
        "asmdef" => format!("AssemblyDefinitionImporter:\n{tail}"),
        "compute" => format!("ComputeShaderImporter:\n{tail}"),
        "shader" => format!(
            "ShaderImporter:\n  externalObjects: {{}}\n  defaultTextures: []\n  nonModifiableTextures: []\n{}",
            tail.trim_start_matches("  externalObjects: {}\n")
        ),
        "hlsl" | "cginc" => format!("ShaderIncludeImporter:\n{tail}"),
        "md" | "txt" => format!("TextScriptImporter:\n{tail}"),
        "json" if inside == "package.json" => format!("PackageManifestImporter:\n{tail}"),
        "json" => format!("TextScriptImporter:\n{tail}"),
        "asset" | "mat" => format!(
            "NativeFormatImporter:\n  externalObjects: {{}}\n  mainObjectFileID: 11400000\n{}",
            tail.trim_start_matches("  externalObjects: {}\n")
        ),
        "so" | "dll" | "dylib" => plugin(&inside),
        _ => format!("DefaultImporter:\n{tail}"),
    };
    format!("fileFormatVersion: 2\nguid: {}\n{importer}", identifier(&inside))
}

/// A native library: for the editor and the players of its own system, by the folder that it lies in.
fn plugin(inside: &str) -> String {
    let (os, player, cpu) = match inside {
        path if path.contains("/Linux/") => ("Linux", "Linux64", "x86_64"),
        path if path.contains("/Windows/") => ("Windows", "Win64", "x86_64"),
        path if path.contains("/macOS/") => ("OSX", "OSXUniversal", "AnyCPU"),
        _ => ("AnyOS", "Any", "AnyCPU"),
    };
    format!(
        "PluginImporter:\n  externalObjects: {{}}\n  serializedVersion: 2\n  iconMap: {{}}\n  executionOrder: {{}}\n  \
         defineConstraints: []\n  isPreloaded: 0\n  isOverridable: 0\n  isExplicitlyReferenced: 0\n  validateReferences: 1\n  \
         platformData:\n  - first:\n      Any: \n    second:\n      enabled: 0\n      settings: {{}}\n  - first:\n      \
         Editor: Editor\n    second:\n      enabled: 1\n      settings:\n        CPU: {cpu}\n        OS: {os}\n  - first:\n      \
         Standalone: {player}\n    second:\n      enabled: 1\n      settings:\n        CPU: {cpu}\n  userData: \n  \
         assetBundleName: \n  assetBundleVariant: \n"
    )
}

fn identifier(inside: &str) -> String {
    format!("{:032x}", fnv_1a(format!("{PACKAGE}/{inside}").bytes()))
}

/// 128 bits of a text (G. Fowler, L. C. Noll, K.-P. Vo, "The FNV Non-Cryptographic Hash Algorithm").
pub fn fnv_1a(bytes: impl Iterator<Item = u8>) -> u128 {
    const OFFSET: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;
    bytes.fold(OFFSET, |hash, byte| (hash ^ u128::from(byte)).wrapping_mul(PRIME))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifiers_stay_what_they_are() {
        assert_eq!(identifier("package.json"), identifier("package.json"));
        assert_ne!(identifier("Runtime"), identifier("Runtime.cs"));
        assert_eq!(identifier("Runtime/LumivoxVolume.cs").len(), 32);
    }

    #[test]
    fn the_package_is_complete() {
        check().unwrap();
    }
}
