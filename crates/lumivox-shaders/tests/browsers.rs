//! What browsers' compilers refuse, and naga lets pass.

use std::fs;

/// Operators between two operands, by what may stand beside them.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    And,
    Or,
    /// One of bits, which only the same may follow.
    Bits(&'static str),
    Shift,
    Arithmetic,
    Comparison,
    /// What ends an expression.
    End,
}

const OPERATORS: [(&str, Kind); 20] = [
    ("&&", Kind::And),
    ("||", Kind::Or),
    ("&", Kind::Bits("&")),
    ("|", Kind::Bits("|")),
    ("^", Kind::Bits("^")),
    ("<<", Kind::Shift),
    (">>", Kind::Shift),
    ("+", Kind::Arithmetic),
    ("-", Kind::Arithmetic),
    ("*", Kind::Arithmetic),
    ("/", Kind::Arithmetic),
    ("%", Kind::Arithmetic),
    ("==", Kind::Comparison),
    ("!=", Kind::Comparison),
    ("<", Kind::Comparison),
    (">", Kind::Comparison),
    ("<=", Kind::Comparison),
    (">=", Kind::Comparison),
    ("=", Kind::End),
    ("return", Kind::End),
];

/// What stands in a bracket so far: in all of an expression, and since the last comparison, 'and' or 'or'.
#[derive(Clone, Default)]
struct Level {
    all: Vec<Kind>,
    part: Vec<Kind>,
}

impl Level {
    /// Whether an operator may follow those before it (<https://www.w3.org/TR/WGSL/#expression-grammar>).
    fn takes(&mut self, kind: Kind) -> bool {
        let bits = |kind: &Kind| matches!(kind, Kind::Bits(_));
        let is_apart = match kind {
            Kind::Bits(_) => self.all.iter().any(|other| *other != kind),
            Kind::And => self.all.iter().any(|other| *other == Kind::Or || bits(other)),
            Kind::Or => self.all.iter().any(|other| *other == Kind::And || bits(other)),
            Kind::Shift => !self.part.is_empty() || self.all.iter().any(bits),
            Kind::Arithmetic => self.part.contains(&Kind::Shift) || self.all.iter().any(bits),
            Kind::Comparison => self.all.iter().any(bits),
            Kind::End => {
                *self = Self::default();
                return true;
            }
        };
        self.all.push(kind);
        match kind {
            Kind::And | Kind::Or | Kind::Comparison => self.part.clear(),
            _ => self.part.push(kind),
        }
        !is_apart
    }
}

/// Lines where operators stand beside each other without brackets that the language wants between them. Those between two operands
/// have spaces around them.
fn mixed(text: &str) -> Vec<usize> {
    let mut found = vec![];
    let mut open = vec![Level::default()];
    for (line, words) in text.lines().enumerate() {
        let words = words.split("//").next().unwrap_or_default();
        let spaced = "()[]{},;".chars().fold(words.to_owned(), |text, c| text.replace(c, &format!(" {c} ")));
        for word in spaced.split_whitespace() {
            let Some(last) = open.last_mut() else { return vec![line + 1] };
            match word {
                "(" | "[" => open.push(Level::default()),
                ")" | "]" => drop(open.pop()),
                ";" | "{" | "}" | "," => *last = Level::default(),
                _ => {
                    let operator = OPERATORS.iter().find(|(name, _)| *name == word);
                    if operator.is_some_and(|(_, kind)| !last.takes(*kind)) {
                        found.push(line + 1);
                    }
                }
            }
        }
    }
    found
}

#[test]
fn what_needs_brackets_has_them() {
    for wrong in [
        "if (a && b ||\n c) {}",
        "x = a >> b & 1u;",
        "x = a & b | c;",
        "if (a & b != 0u) {}",
        "x = a + b << 2u;",
        "x = a << b << c;",
        "x = a << b\n + c;",
    ] {
        assert_eq!(mixed(wrong).len(), 1, "{wrong}");
    }
    let right = "x = a && f(b || c, d && e) // || no\n && (g || h); y = a || b; z = (a >> b) & 1u; w = a << 2u == b && c + d > e;
        v = a | b | (c << 3u); u = array<vec2<f32>>(a - b); t = -a & b;";
    assert_eq!(mixed(right), []);
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
