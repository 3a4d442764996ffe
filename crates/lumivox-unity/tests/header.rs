//! `include/lumivox_unity.h` says what the library has. `UPDATE_HEADER=1` writes it anew.

use std::path::Path;

const START: &str = "\
/* The C ABI of Lumivox for Unity, made of crates/lumivox-unity by its test `header`.
 *
 * Functions that give a pointer give null, those that give an int32_t a negative number where something is wrong;
 * lumivox_last_error says what, to the thread that asked. Handles are freed once by the function of their name; to free
 * null does nothing. Any thread may call anything, but a LumivoxStage and its recordings belong to one thread at a time.
 * Strings are UTF-8, ended by 0. Places and matrices are in Unity's conventions. */";

fn header(root: &Path) -> String {
    let mut config = cbindgen::Config {
        language: cbindgen::Language::C,
        header: Some(START.to_owned()),
        include_guard: Some("LUMIVOX_UNITY_H".to_owned()),
        cpp_compat: true,
        no_includes: true,
        sys_includes: vec!["stdint.h".to_owned()],
        ..cbindgen::Config::default()
    };
    // C has one space of names for all enumerators.
    config.enumeration.prefix_with_name = true;
    let mut builder = cbindgen::Builder::new().with_config(config);
    let before = ["abi", "border", "volume", "look", "labels", "jobs", "scene"];
    for file in before.into_iter().chain(["scene_light", "saving", "steps", "stage"]) {
        builder = builder.with_src(root.join(format!("src/{file}.rs")));
    }
    let mut text = vec![];
    builder.generate().expect("the sources can be read").write(&mut text);
    String::from_utf8(text).unwrap()
}

#[test]
fn the_header_is_current() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (path, made) = (root.join("include/lumivox_unity.h"), header(root));
    if std::env::var_os("UPDATE_HEADER").is_some() {
        std::fs::write(&path, &made).unwrap();
    }
    let written = std::fs::read_to_string(&path).unwrap_or_default();
    // It is C, and whatever a C compiler warns of is wrong.
    let compiled = std::process::Command::new("cc")
        .args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-x", "c"])
        .arg(&path)
        .output()
        .expect("a C compiler");
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    assert!(written == made, "{} is not what the library has: run this with UPDATE_HEADER=1", path.display());
}
