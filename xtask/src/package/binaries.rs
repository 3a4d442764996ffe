//! What a program or library says of itself: for which system it is, how old a C library it runs with, and where it was built.

use std::fs;
use std::path::Path;
use std::process::Command;

/// The glibc of the oldest systems that packages are for: Debian 10, RHEL 8, Ubuntu 18.10, as wheels of manylinux_2_28.
pub const OLDEST_GLIBC: (u32, u32) = (2, 28);

/// Fails where a program wants more of glibc than the oldest has, and names what.
pub fn check_glibc(file: &Path) -> Result<(), String> {
    let output = Command::new("objdump").arg("-T").arg(file).output();
    let output = output.map_err(|error| format!("objdump, of binutils: {error}"))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        return Err(format!("objdump -T {}: {}", file.display(), said.trim_end()));
    }
    newer_symbols(&String::from_utf8_lossy(&output.stdout))
        .map_err(|why| format!("{}: {why}", file.display()))
}

/// Of what `objdump -T` lists.
fn newer_symbols(list: &str) -> Result<(), String> {
    let (major, minor) = OLDEST_GLIBC;
    let mut known = 0;
    let mut newer = vec![];
    for line in list.lines() {
        let mut words = line.split_whitespace().rev();
        let (Some(symbol), Some(version)) = (words.next(), words.next()) else { continue };
        let version = version.trim_matches(['(', ')']);
        let Some(number) = version.strip_prefix("GLIBC_") else { continue };
        known += 1;
        let mut parts = number.split('.').map(|part| part.parse::<u32>().unwrap_or(u32::MAX));
        if (parts.next().unwrap_or(u32::MAX), parts.next().unwrap_or(0)) > OLDEST_GLIBC {
            newer.push(format!("{symbol} of {version}"));
        }
    }
    newer.sort();
    newer.dedup();
    match (known, newer.is_empty()) {
        (0, _) => Err("it asks nothing of glibc, so that nothing could be checked".to_owned()),
        (_, true) => Ok(()),
        (_, false) => Err(format!("glibc {major}.{minor} has no {}", newer.join(", "))),
    }
}

/// Fails where a program names a folder of the machine that built it.
pub fn check_paths(file: &Path, folders: &[&Path]) -> Result<(), String> {
    let bytes = fs::read(file).map_err(|error| format!("{}: {error}", file.display()))?;
    for folder in folders {
        let Some(path) = folder.to_str().filter(|path| path.len() > 1) else { continue };
        // With what follows, so that `/home/a` is not found in `/home/abc`.
        let path = format!("{}/", path.trim_end_matches('/'));
        let mut from = 0;
        while let Some(at) = find(&bytes[from..], path.as_bytes()).map(|at| from + at) {
            from = at + path.len();
            if !is_there(folder, &bytes[from..]) {
                continue;
            }
            let end = bytes[at..].iter().position(|byte| !byte.is_ascii_graphic()).unwrap_or(0).min(200);
            let found = String::from_utf8_lossy(&bytes[at..at + end]).into_owned();
            return Err(format!("{}: it names where it was built: {found}", file.display()));
        }
    }
    Ok(())
}

/// Whether a folder has what is named. Texts of a program lie one after the other: `accessible/root` before `/org/a11y` names
/// nothing in the home of `root`.
fn is_there(folder: &Path, named: &[u8]) -> bool {
    let Ok(entries) = fs::read_dir(folder) else { return true };
    entries.flatten().any(|entry| named.starts_with(entry.file_name().as_encoded_bytes()))
}

pub fn find(bytes: &[u8], wanted: &[u8]) -> Option<usize> {
    let first = *wanted.first()?;
    let starts = bytes.iter().enumerate().filter(|(_, byte)| **byte == first).map(|(at, _)| at);
    starts.into_iter().find(|at| bytes[*at..].starts_with(wanted))
}

/// What a program or library is for, by its headers: ELF's, PE's or Mach-O's.
pub fn system_of(bytes: &[u8]) -> Option<&'static str> {
    let word = |at: usize| Some(u16::from_le_bytes(bytes.get(at..at + 2)?.try_into().ok()?));
    match bytes.get(..4)? {
        [0x7f, b'E', b'L', b'F'] => (bytes.get(4) == Some(&2) && word(18)? == 62).then_some("linux"),
        [b'M', b'Z', ..] => {
            let at = u32::from_le_bytes(bytes.get(0x3c..0x40)?.try_into().ok()?) as usize;
            (bytes.get(at..at.checked_add(4)?)? == b"PE\0\0" && word(at + 4)? == 0x8664).then_some("windows")
        }
        [0xcf, 0xfa, 0xed, 0xfe] | [0xca, 0xfe, 0xba, 0xbe] => Some("macos"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_symbol_that_an_old_glibc_lacks_is_named() {
        let old = "0000000000000000      DF *UND*\t0000000000000000 (GLIBC_2.2.5) free\n\
                   0000000000000000      DF *UND*\t0000000000000000  GLIBC_2.28  fcntl64\n\
                   0000000000012340 g    DF .text\t0000000000000010  Base        lumivox_abi_version\n";
        assert_eq!(newer_symbols(old), Ok(()));
        let new =
            format!("{old}0000000000000000      DF *UND*\t0000000000000000 (GLIBC_2.34) pthread_create\n");
        assert_eq!(newer_symbols(&new), Err("glibc 2.28 has no pthread_create of GLIBC_2.34".to_owned()));
        assert!(newer_symbols(&format!("{old}x (GLIBC_PRIVATE) hidden")).unwrap_err().contains("hidden"));
        assert!(newer_symbols("").is_err());
    }

    #[test]
    fn a_folder_of_the_builder_is_found_in_a_program() {
        let file = std::env::temp_dir().join(format!("lumivox-paths-{}", std::process::id()));
        fs::write(&file, b"\0panicked at /home/anyone/src/lib.rs\0").unwrap();
        let error = check_paths(&file, &[Path::new("/root"), Path::new("/home/anyone")]).unwrap_err();
        assert!(error.contains("/home/anyone/src/lib.rs"), "{error}");
        assert_eq!(check_paths(&file, &[Path::new("/home/any"), Path::new("/")]), Ok(()));
        // Two texts, which together look like a path.
        let home = std::env::temp_dir();
        let path = home.to_str().unwrap();
        let name = file.file_name().unwrap().to_str().unwrap();
        fs::write(&file, format!("accessible{path}/no-such-file-here\0")).unwrap();
        assert_eq!(check_paths(&file, &[&home]), Ok(()));
        fs::write(&file, format!("accessible{path}/no-such-file-here\0{path}/{name}\0")).unwrap();
        let error = check_paths(&file, &[&home]).unwrap_err();
        assert!(error.contains(name), "{error}");
        fs::remove_file(&file).unwrap();
    }
}
