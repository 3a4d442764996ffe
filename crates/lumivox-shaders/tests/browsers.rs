//! What browsers' compilers refuse, and naga lets pass.

use std::fs;

/// Lines where 'and' and 'or' stand beside each other without brackets, which the language does not allow.
fn mixed(text: &str) -> Vec<usize> {
    let mut found = vec![];
    // Of each bracket that is open: whether there was an 'and', and an 'or'.
    let mut open = vec![[false; 2]];
    for (line, words) in text.lines().enumerate() {
        let words = words.split("//").next().unwrap_or_default().as_bytes();
        for (at, word) in words.iter().enumerate() {
            match word {
                b'(' | b'[' => open.push([false; 2]),
                b')' | b']' => drop(open.pop()),
                b';' | b'{' | b'}' | b',' => drop(open.last_mut().map(|last| *last = [false; 2])),
                b'&' | b'|' if words.get(at + 1) == Some(word) => {
                    let Some(last) = open.last_mut() else { continue };
                    last[usize::from(*word == b'|')] = true;
                    if *last == [true; 2] {
                        found.push(line + 1);
                    }
                }
                _ => {}
            }
        }
    }
    found
}

#[test]
fn and_and_or_are_never_mixed_without_brackets() {
    assert_eq!(mixed("if (a && b ||\n c) {}"), [1]);
    assert_eq!(mixed("x = a && f(b || c, d && e) // || no\n && (g || h); y = a || b;"), []);
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/wgsl");
    let mut files = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let lines = mixed(&fs::read_to_string(&path).unwrap());
        assert!(lines.is_empty(), "{}: lines {lines:?}", path.display());
        files += 1;
    }
    assert!(files > 30, "only {files} files");
}
