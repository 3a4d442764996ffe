//! Tables of labels, as programs leave them beside label maps: ITK-SNAP's descriptions, FreeSurfer's and 3D Slicer's
//! colour tables, FSLeyes' look-up tables, and tables with a line of headings.

use std::{
    collections::BTreeMap,
    io::Read,
    path::{Path, PathBuf},
};

use crate::{colors, error::ImportError};

/// No table is longer.
const LONGEST: u64 = 4 << 20;

/// Longer names are cut.
const LONGEST_NAME: usize = 64;

/// Endings of tables beside a label map, the surest first.
const BESIDE: [&str; 6] = ["label", "ctbl", "lut", "txt", "tsv", "csv"];

/// Endings of label maps, longer ones first.
pub(crate) const ENDINGS: [&str; 10] =
    [".nii.gz", ".nii", ".img.gz", ".hdr", ".img", ".seg.nrrd", ".nrrd", ".nhdr", ".mha", ".mhd"];

/// What a table says of a number.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Entry {
    pub name: String,
    /// Linear, sRGB primaries.
    pub color: Option<[f64; 3]>,
}

/// What numbers mean.
pub(crate) type Table = BTreeMap<i128, Entry>;

/// Reads a table.
///
/// # Errors
/// [`ImportError`] names the file and the line.
pub(crate) fn read(path: &Path) -> Result<Table, ImportError> {
    let metadata = crate::files::metadata(path).map_err(ImportError::io(path))?;
    let unsupported = |what: String, remedy: &str| ImportError::Unsupported {
        path: path.to_owned(),
        what,
        remedy: remedy.to_owned(),
    };
    // Pipes and devices might never end.
    if !metadata.is_file() || metadata.length() > LONGEST {
        return Err(unsupported("no table of labels: it is no text file of usual size".to_owned(), TABLES));
    }
    let mut bytes = Vec::new();
    let file = crate::files::File::open(path).map_err(ImportError::io(path))?;
    file.take(LONGEST).read_to_end(&mut bytes).map_err(ImportError::io(path))?;
    let text = String::from_utf8_lossy(&bytes);
    match parse(text.trim_start_matches('\u{feff}')) {
        Ok(table) if table.is_empty() => Err(unsupported("a table of labels without one".to_owned(), TABLES)),
        Ok(table) => Ok(table),
        Err(line) => Err(ImportError::Field {
            path: path.to_owned(),
            field: format!("line {line}"),
            problem: "says no label: a number, a name and a colour are expected".to_owned(),
            remedy: TABLES.to_owned(),
        }),
    }
}

/// What to do about a table that is none.
const TABLES: &str = "Give a table of ITK-SNAP, FreeSurfer, 3D Slicer or FSLeyes, or one with the columns index, name and color";

/// The table beside a label map: the same name with another ending.
pub(crate) fn beside(map: &Path) -> Option<PathBuf> {
    let name = map.file_name()?.to_str()?;
    let lower = name.to_ascii_lowercase();
    let stem = ENDINGS.iter().find(|ending| lower.ends_with(**ending)).map_or_else(
        || map.file_stem().and_then(|stem| stem.to_str()).unwrap_or(name),
        |ending| &name[..name.len() - ending.len()],
    );
    if stem.is_empty() {
        return None;
    }
    let candidates = BESIDE.iter().map(|ending| map.with_file_name(format!("{stem}.{ending}")));
    candidates.into_iter().find(|path| path != map && crate::files::is_file(path))
}

/// The number of a line that cannot be understood is the error.
fn parse(text: &str) -> Result<Table, usize> {
    let lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
    let mut lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#')).peekable();
    let mut table = Table::new();
    if let Some((_, first)) = lines.peek()
        && let Some(columns) = Columns::of(first)
    {
        lines.next();
        for (at, line) in lines {
            let (number, entry) = columns.entry(line).ok_or(at)?;
            table.insert(number, entry);
        }
        return Ok(table);
    }
    for (at, line) in lines {
        let (number, entry) = entry(line).ok_or(at)?;
        table.insert(number, entry);
    }
    Ok(table)
}

/// A line without headings: a number, then a name and a colour in either order.
fn entry(line: &str) -> Option<(i128, Entry)> {
    let (before, quoted) = match line.split_once('"') {
        Some((before, rest)) => (before, Some(rest.split('"').next().unwrap_or_default())),
        None => (line, None),
    };
    let words: Vec<&str> = before.split_whitespace().collect();
    let (number, rest) = words.split_first()?;
    let number = number.parse().ok()?;
    if let Some(name) = quoted {
        // ITK-SNAP: IDX R G B A VIS MSH "LABEL".
        return Some((number, Entry { name: clean(name), color: color(rest.get(..3)?) }));
    }
    let is_number = |word: &&&str| word.parse::<f64>().is_ok();
    let leading = rest.iter().take_while(is_number).count();
    if leading >= 3 {
        // FSLeyes: number R G B name.
        return Some((number, Entry { name: clean(&rest[leading..].join(" ")), color: color(&rest[..3]) }));
    }
    // FreeSurfer and 3D Slicer: number name R G B A.
    let trailing = rest.iter().rev().take_while(is_number).count().min(4);
    let (name, numbers) = rest.split_at(rest.len() - trailing);
    if name.is_empty() {
        return None;
    }
    let name = if trailing >= 3 { name.join(" ") } else { rest.first()?.to_string() };
    let color = if trailing >= 3 { color(&numbers[..3]) } else { None };
    Some((number, Entry { name: clean(&name), color }))
}

/// Three numbers as a colour: bytes, or parts of one where none is larger.
fn color(words: &[&str]) -> Option<[f64; 3]> {
    let numbers: Vec<f64> = words.iter().map(|word| word.parse().ok()).collect::<Option<_>>()?;
    let codes: [f64; 3] = numbers.try_into().ok()?;
    if !codes.iter().all(|code| (0.0..=255.0).contains(code)) {
        return None;
    }
    let parts = codes.iter().all(|code| *code <= 1.0);
    Some(if parts { colors::from_srgb(codes) } else { colors::from_bytes(codes) })
}

/// A name as people read it: underscores that stand for spaces are spaces, and nothing is there that moves a cursor.
pub(crate) fn clean(name: &str) -> String {
    let words = name.split(|c: char| c.is_whitespace() || c.is_control() || c == '_');
    let name = words.filter(|word| !word.is_empty()).collect::<Vec<_>>().join(" ");
    name.chars().take(LONGEST_NAME).collect()
}

/// Where a table with headings has what.
#[derive(Debug)]
struct Columns {
    separator: char,
    number: usize,
    name: usize,
    /// Red, green and blue, or one column of `#rrggbb`.
    color: Option<[usize; 3]>,
    hex: Option<usize>,
}

impl Columns {
    /// The columns that a line of headings names, if it is one.
    fn of(line: &str) -> Option<Self> {
        let separator = ['\t', ',', ';'].into_iter().find(|separator| line.contains(*separator))?;
        let headings: Vec<String> = cells(line, separator).iter().map(|cell| cell.to_lowercase()).collect();
        let find = |names: &[&str]| headings.iter().position(|heading| names.contains(&heading.as_str()));
        let part = |letter: &str, word: &str| find(&[letter, word, &format!("color_{letter}")]);
        let color = (|| Some([part("r", "red")?, part("g", "green")?, part("b", "blue")?]))();
        Some(Self {
            separator,
            number: find(&["labelvalue", "index", "id", "value", "label"])?,
            name: find(&["name", "labelname", "label name", "abbreviation"])?,
            color,
            hex: find(&["color", "colour", "hex"]),
        })
    }

    fn entry(&self, line: &str) -> Option<(i128, Entry)> {
        let cells = cells(line, self.separator);
        let number = cells.get(self.number)?.parse().ok()?;
        let name = clean(cells.get(self.name)?);
        let parts = || {
            let [r, g, b] = self.color?;
            color(&[cells.get(r)?, cells.get(g)?, cells.get(b)?])
        };
        let hex = || hex(cells.get(self.hex?)?);
        Some((number, Entry { name, color: parts().or_else(hex) }))
    }
}

/// The cells of a line; those in quotes may hold the separator.
fn cells(line: &str, separator: char) -> Vec<String> {
    let mut cells = vec![String::new()];
    let mut quoted = false;
    for c in line.chars() {
        match c {
            '"' => quoted = !quoted,
            c if c == separator && !quoted => cells.push(String::new()),
            c => cells.last_mut().expect("there is one").push(c),
        }
    }
    cells.iter().map(|cell| cell.trim().to_owned()).collect()
}

fn hex(text: &str) -> Option<[f64; 3]> {
    let digits = text.strip_prefix('#')?;
    let code = (digits.len() == 6).then(|| u32::from_str_radix(digits, 16).ok()).flatten()?;
    Some(colors::from_bytes([code >> 16, code >> 8 & 0xff, code & 0xff].map(f64::from)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(line: &str) -> (i128, String, Option<[f64; 3]>) {
        let table = parse(line).unwrap_or_else(|at| panic!("line {at} of {line}"));
        let (number, entry) = table.into_iter().next().unwrap();
        (number, entry.name, entry.color.map(|color| color.map(|part| (part * 1e3).round() / 1e3)))
    }

    #[test]
    fn tables_of_the_field_are_understood() {
        let red = Some([1.0, 0.216, 0.0]);
        for (line, number, name) in [
            ("# ITK-SnAP Label Description File\n  7  255 128 0   1  1  1    \"Left lung\"", 7, "Left lung"),
            (
                "#No. Label Name:     R   G   B   A\n\n17  Left-Hippocampus   255 128 0  0\n",
                17,
                "Left-Hippocampus",
            ),
            ("# Color table file x.ctbl\n3 left_lung_upper_lobe 255 128 0 255", 3, "left lung upper lobe"),
            ("2 1.0 0.50196 0.0 Caudate nucleus", 2, "Caudate nucleus"),
            (
                "LabelValue,Name,Color_R,Color_G,Color_B,Color_A\n5,\"liver, left\",255,128,0,255",
                5,
                "liver, left",
            ),
            ("index\tname\tcolor\n9\taorta\t#ff8000", 9, "aorta"),
            ("\u{feff}4 a b 255 128 0", 4, "a b"),
        ] {
            let (n, found, color) = one(line.trim_start_matches('\u{feff}'));
            assert_eq!((n, found.as_str()), (number, name), "{line}");
            assert_eq!(color, red, "{line}");
        }
        // Names without colours: AAL's.
        assert_eq!(one("1 Precentral_L 2001"), (1, "Precentral L".to_owned(), None));
        assert_eq!(one("2001 Precentral"), (2001, "Precentral".to_owned(), None));
    }

    #[test]
    fn what_is_no_table_is_refused_by_its_line() {
        for (text, line) in [
            ("hello\n", 1),
            ("1 a 1 2 3 4\n\nb 2\n", 3),
            ("1\n", 1),
            ("1 2 3\n", 1),
            ("1 2 \"", 1),
            ("index,name\nx,y\n", 2),
        ] {
            assert_eq!(parse(text), if text == "1 2 \"" { Err(1) } else { Err(line) }, "{text:?}");
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("names.txt");
        std::fs::write(&path, "1 a 0 0 0 0\nDear doctor,\n").unwrap();
        let error = read(&path).unwrap_err().to_string();
        assert!(error.contains("names.txt: line 2 says no label"), "{error}");
        assert!(!error.contains("Dear"), "{error}");
        std::fs::write(&path, "# nothing\n").unwrap();
        assert!(read(&path).unwrap_err().to_string().contains("a table of labels without one"));
        assert!(read(folder.path()).is_err(), "a folder");
        assert!(read(&folder.path().join("none")).is_err(), "nothing");
    }

    #[test]
    fn names_move_no_cursor() {
        assert_eq!(clean("a\u{1b}[2J_b  c"), "a [2J b c");
        assert_eq!(clean(&"x".repeat(999)).len(), LONGEST_NAME);
    }

    #[test]
    fn a_table_beside_a_map_has_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for map in ["seg.nii.gz", "seg.NII", "seg.mha", "seg.seg.nrrd", "seg.hdr"] {
            assert_eq!(beside(&at(map)), None, "{map}");
        }
        std::fs::write(at("seg.txt"), "1 a").unwrap();
        for map in ["seg.nii.gz", "seg.NII", "seg.mha", "seg.seg.nrrd", "seg.hdr"] {
            assert_eq!(beside(&at(map)), Some(at("seg.txt")), "{map}");
        }
        std::fs::write(at("seg.label"), "1 a").unwrap();
        assert_eq!(beside(&at("seg.nii")), Some(at("seg.label")));
        assert_eq!(beside(&at("seg.label")), Some(at("seg.txt")), "not itself");
    }
}
