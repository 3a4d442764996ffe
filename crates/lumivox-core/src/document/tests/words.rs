//! What is wrong is said in plain words, where it is.

use super::super::*;

fn wrong(text: &str) -> DocumentError {
    SceneDocument::parse(text).expect_err(text)
}

/// A document of several lines, with a part of it replaced.
const LINES: &str = r#"{
  "lumivox_scene": 1,
  "volumes": [
    {
      "scan": {
        "files": ["scans/head"]
      },
      "look": {
        "surface": {
          "strength": 0.5,
          "roughness": 0.3
        },
        "transfer_function": {
          "opacity": [[0, 0], [100, 1]],
          "color": [[0, [1, 1, 1]]]
        }
      },
      "labels": {
        "styles": [
          {"label": "liver", "color": true}
        ]
      }
    }
  ],
  "lights": [
    {
      "kind": "sun",
      "direction": [0, -1, 0],
      "irradiance": [3, 3, 3]
    }
  ],
  "film": {
    "size": [320, 240],
    "seed": 7
  }
}
"#;

#[test]
fn what_is_wrong_is_said_in_plain_words_at_its_place() {
    SceneDocument::parse(LINES).unwrap();
    let mut others = vec![];
    for (old, new, line, column, words) in [
        // Paths of Windows.
        ("scans/head", r"C:\scans\head", 6, 22, "a backslash in a path is written twice, or use /"),
        ("scans/head", r"C:\users\head", 6, 22, "a backslash in a path is written twice, or use /"),
        ("scans/head", r"C:\new", 6, 18, "a backslash in a path is written twice, or use /"),
        // Commas and brackets.
        ("0.3\n", "0.3,\n", 11, 27, "a comma before the closing bracket: take it out"),
        ("240],", "240,],", 33, 22, "a comma before the closing bracket: take it out"),
        ("240],", "240]", 34, 5, "a comma is missing before this"),
        ("\"seed\": 7", "\"seed\" 7", 34, 12, "a colon is missing here"),
        ("\"seed\": 7", "seed: 7", 34, 5, "a key belongs here, in double quotes"),
        ("\"seed\": 7", "\"seed\": 7 // mine", 34, 15, "JSON has no comments"),
        ("\"seed\": 7", "\"seed\": 07", 34, 14, "this is no number as JSON writes them"),
        ("true", "#c0503c", 20, 39, "text stands in double quotes"),
        ("\"seed\": 7", "# \"seed\": 7", 34, 5, "JSON has no comments"),
        ("true", "True", 20, 39, "no value begins so"),
        ("scans/head\"", "scans/head", 6, 30, "a closing \" is missing here"),
        ("    \"seed\": 7\n  }\n}\n", "    \"seed\": 7\n", 34, 13, "the { of line 32 is not closed"),
        ("    \"seed\": 7\n  }\n}\n", "    \"seed\": 7\n  }\n}}\n", 36, 2, "a bracket is too many"),
        // Kinds of values.
        (
            "\"seed\": 7",
            "\"seed\": \"7\"",
            34,
            13,
            "seed has to be a whole number from 0 to 4294967295, not text: \"7\": leave the quotes out",
        ),
        (
            "\"seed\": 7",
            "\"seed\": 7.5",
            34,
            13,
            "seed has to be a whole number from 0 to 4294967295, not 7.5",
        ),
        (
            "\"seed\": 7",
            "\"seed\": -7",
            34,
            13,
            "seed has to be a whole number from 0 to 4294967295, and is -7",
        ),
        (
            "\"seed\": 7",
            "\"seed\": {\"a\": 1}",
            34,
            13,
            "seed has to be a whole number from 0 to 4294967295, not a block",
        ),
        (
            "[320, 240]",
            "\"320x240\"",
            33,
            13,
            "size has to be a list of 2 entries, in [ ], not text: \"320x240\"",
        ),
        ("[320, 240]", "[320]", 33, 13, "size has to be a list of 2 entries, in [ ], and has 1"),
        ("[320, 240]", "[320, 240, 1]", 33, 13, "size has more entries than it may have"),
        ("[320, 240]", "[320, \"a\"]", 33, 19, "entry 2 of size has to be a whole number"),
        (
            "[\"scans/head\"]",
            "\"scans/head\"",
            6,
            18,
            "files has to be a list, in [ ], not text: \"scans/head\"",
        ),
        (
            "\"strength\": 0.5",
            "\"strength\": \"half\"",
            10,
            23,
            "strength has to be a number, not text: \"half\"",
        ),
        (
            "{\"label\": \"liver\", \"color\": true}",
            "7",
            20,
            11,
            "entry 1 of styles has to be a block, in { }, not 7",
        ),
        ("true", "\"#c0503\"", 20, 39, "'#c0503' is no colour; write it as \"#c0503c\""),
        ("true", "[1, 2]", 20, 39, "color has to be a list of 3 entries"),
        // Keys, each at its own line.
        (
            "\"roughness\"",
            "\"roughnes\"",
            11,
            11,
            "there is no key 'roughnes' here, did you mean 'roughness'?",
        ),
        ("\"irradiance\"", "\"intensity\"", 29, 7, "there is no key 'intensity' here; there are kind"),
        (
            "\"irradiance\"",
            "\"half_angle\": 30, \"irradiance\"",
            29,
            7,
            "there is no key 'half_angle' here; there are kind",
        ),
        ("\"direction\": [0, -1, 0],\n", "", 26, 5, "'direction' is missing in this block"),
        ("\"sun\"", "\"moon\"", 27, 15, "kind: there is no 'moon'; there are sun, point and spot"),
        ("\"seed\": 7", "\"seed\": 7, \"seed\": 8", 34, 16, "'seed' is said twice"),
        (
            "[100, 1]",
            "[100]",
            14,
            31,
            "entry 2 of opacity has to be [value, opacity] or [value, opacity, \"in-out\"], and has 1",
        ),
        ("[100, 1]", "[100, 2]", 14, 31, "the opacity at 100 is 2, and must be 0 to 1"),
        ("[1, 1, 1]]", "[1, 1.5, 1]]", 15, 25, "a part of the colour is 1.5, and must be 0 to 1"),
        ("[[0, [1, 1, 1]]]", "[]", 13, 30, "a transfer function needs at least one colour stop"),
        ("\"surface\"", "\"preset\": \"ct-bome\", \"surface\"", 9, 19, "did you mean 'ct-bone'"),
        (
            "  \"film\"",
            "  \"display\": {\n    \"background\": \"blak\"\n  },\n  \"film\"",
            33,
            19,
            "the background 'blak' must be",
        ),
        (
            "true",
            "true, \"surface\": \"on\"",
            20,
            56,
            "surface has to be true, false, or a block of strength",
        ),
        ("\"seed\": 7", "\"samples\": 0", 34, 16, "samples is 0, and must be 1 to 16777216"),
    ] {
        assert!(LINES.contains(old), "{old}");
        let error = wrong(&LINES.replacen(old, new, 1));
        if (error.line, error.column) != (line, column) || !error.why.contains(words) {
            others.push(format!("{new:?}: line {line}, column {column}: {words}\n  not {error}"));
        }
    }
    assert!(others.is_empty(), "{}", others.join("\n"));
}

#[test]
fn what_is_no_scene_at_all_is_told() {
    for (text, words) in [
        ("", "the file is empty"),
        ("  \n", "the file is empty"),
        ("[1, 2]", "this is no scene of Lumivox's"),
        ("<html>", "this is no scene of Lumivox's"),
        ("{\"a\": 1}", "this is no scene of Lumivox's"),
        ("{", "the { of line 1 is not closed"),
        ("{\"lumivox_scene\": 1, \"film\": [", "the [ of line 1 is not closed"),
    ] {
        let error = wrong(text);
        assert!(error.line == 1 && error.why.contains(words), "{text:?}: {error}");
    }
}

/// Columns count letters, as editors do, and a mark at the beginning is none.
#[test]
fn columns_are_those_of_editors() {
    let error = wrong(
        "\u{feff}{\"lumivox_scene\": 1, \"volumes\": [{\"scan\": {\"files\": [\"Ährenfeld/Größe\"]}, \"pel\": 3}]}",
    );
    assert_eq!((error.line, error.column), (1, 75));
    assert!(error.why.contains("did you mean 'peel'"), "{error}");
    let error = wrong("{\"lumivox_scene\": 1, \"film\": {\"size\": [0, 1]}}");
    assert_eq!(error.to_string().split(": ").next(), Some("line 1, column 39"));
}

/// Whatever is cut off or exchanged in a document, there is an error in it or none, and its place is in the text.
#[test]
fn no_text_is_too_strange() {
    let letters = ['"', '{', '}', '[', ']', ',', ':', '\\', '7', 'ß', '\n', ' ', '\u{0}'];
    for (at, _) in LINES.char_indices() {
        let parts = letters.iter().map(|letter| format!("{}{letter}{}", &LINES[..at], &LINES[at + 1..]));
        for text in parts.chain([LINES[..at].to_owned()]) {
            if let Err(error) = SceneDocument::parse(&text) {
                let lines = text.lines().count().max(1);
                assert!(error.line <= lines && error.column > 0 && !error.why.is_empty(), "{error}: {text}");
            }
        }
    }
}
