//! Names and colours in the extensions of a NIfTI header: the label table of Connectome Workbench (`CaretExtension`), which
//! TotalSegmentator writes, too.

use std::path::Path;

use super::{
    colors,
    table::{Entry, Table, clean},
};
use crate::{error::ImportError, nifti};

/// Elements of a document that are looked at; no table has more.
const MOST_ELEMENTS: u32 = 1 << 17;

/// The table of a NIfTI file; empty where it has none.
///
/// # Errors
/// [`ImportError`] where the file cannot be read.
pub(crate) fn table(path: &Path) -> Result<Table, ImportError> {
    let contents = nifti::extensions(path)?;
    Ok(contents
        .iter()
        .filter_map(|content| parse(content))
        .find(|table| !table.is_empty())
        .unwrap_or_default())
}

/// The label table in an extension's content, if it is one.
fn parse(content: &[u8]) -> Option<Table> {
    let text = String::from_utf8_lossy(content);
    let text = text.trim_matches(|c: char| c == '\0' || c.is_whitespace());
    if !text.contains("<LabelTable") {
        return None;
    }
    let options = roxmltree::ParsingOptions { nodes_limit: MOST_ELEMENTS, ..Default::default() };
    let document = roxmltree::Document::parse_with_options(text, options).ok()?;
    let label = |node: roxmltree::Node<'_, '_>| {
        let number = node.attribute("Key")?.trim().parse().ok()?;
        let part =
            |name: &str| node.attribute(name)?.trim().parse::<f64>().ok().filter(|part| part.is_finite());
        let color = (|| Some([part("Red")?, part("Green")?, part("Blue")?]))();
        let name =
            node.descendants().filter_map(|part| part.text().filter(|_| part.is_text())).collect::<String>();
        Some((number, Entry { name: clean(&name), color: color.map(colors::from_srgb) }))
    };
    Some(document.descendants().filter(|node| node.has_tag_name("Label")).filter_map(label).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn label_tables_are_read_and_others_are_none() {
        let text = b"<?xml version=\"1.0\" encoding=\"UTF-8\"?><CaretExtension><VolumeInformation Index=\"0\"><LabelTable>\
            <Label Key=\"7\" Red=\"1.0\" Green=\"0\" Blue=\"0.5\" Alpha=\"1\"><![CDATA[kidney_right]]></Label>\
            <Label Key=\"9\">a &amp; b</Label><Label Key=\"x\">no</Label></LabelTable></VolumeInformation></CaretExtension>\0\0";
        let table = parse(text).unwrap();
        assert_eq!(table.len(), 2);
        assert_eq!((table[&7].name.as_str(), table[&9].name.as_str()), ("kidney right", "a & b"));
        assert_eq!(table[&7].color.unwrap()[0], 1.0);
        assert_eq!(table[&9].color, None);
        for other in [&b"<LabelTable><Label"[..], b"<a/>", b"", b"\xff\xfe<LabelTable>"] {
            assert!(parse(other).is_none_or(|table| table.is_empty()));
        }
        // Entities that grow are no part of a table.
        let bomb =
            b"<!DOCTYPE a [<!ENTITY b \"bbbb\">]><LabelTable><Label Key=\"1\">&b;</Label></LabelTable>";
        assert!(parse(bomb).is_none());
    }
}
