//! A DICOM file's elements (PS3.5 section 7) as a stream: keeps the few values Lumivox needs, steps over the rest.
//!
//! What a file declares is never believed: no memory is taken for a length before the bytes are there, nesting is
//! walked with a counter and not with the stack, and every step moves forward, so that time and memory are bounded by
//! the file's own size. Nothing after the start of the pixel data is touched.

use std::io;

use lumivox_core::CancelToken;

use crate::dicom::{
    bytes::source::{Input, Source},
    elements::attributes::{self, Attribute, Private},
};

/// Longer values than this are not among the wanted attributes of any real file.
const LONGEST_VALUE: u64 = 1 << 20;
/// Items of wanted sequences in one file; far above what the frames of any scan need.
const MOST_ITEMS: usize = 1 << 21;
/// Wanted sequences lie at most three deep (PerFrame..., PlanePosition..., value).
const DEEPEST_WANTED: usize = 4;

const ITEM: u32 = 0xFFFE_E000;
const ITEM_DELIMITATION: u32 = 0xFFFE_E00D;
const SEQUENCE_DELIMITATION: u32 = 0xFFFE_E0DD;
const UNDEFINED: u32 = u32::MAX;
/// Only a DICOMDIR has it.
const DIRECTORY_RECORD_SEQUENCE: u32 = 0x0004_1220;

/// Why a file's elements could not be read.
#[derive(Debug)]
pub(crate) enum Fault {
    /// It is something else.
    NotDicom(&'static str),
    /// Its structure is broken.
    Damaged(String),
    /// The system could not read it.
    Io(io::Error),
}

impl From<io::Error> for Fault {
    fn from(e: io::Error) -> Self {
        match e.kind() {
            io::ErrorKind::UnexpectedEof => Fault::Damaged("ends in the middle of its header".to_owned()),
            // What a stream's own decoder has to say: bad deflate data, a bomb.
            io::ErrorKind::InvalidInput | io::ErrorKind::InvalidData | io::ErrorKind::Other => {
                Fault::Damaged(format!("cannot be unpacked ({e})"))
            }
            _ => Fault::Io(e),
        }
    }
}

type Result<T, E = Fault> = std::result::Result<T, E>;

/// How the elements of a data set are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Syntax {
    pub(crate) big_endian: bool,
    pub(crate) explicit: bool,
}

const EXPLICIT_LITTLE: Syntax = Syntax { big_endian: false, explicit: true };
const IMPLICIT_LITTLE: Syntax = Syntax { big_endian: false, explicit: false };
const EXPLICIT_BIG: Syntax = Syntax { big_endian: true, explicit: true };

/// The wanted values of a data set or item.
#[derive(Clone, Debug, Default)]
pub(crate) struct DataSet {
    values: Vec<(u32, Vec<u8>)>,
    sequences: Vec<(u32, Vec<DataSet>)>,
    pub(crate) big_endian: bool,
}

impl DataSet {
    fn has(&self, tag: u32) -> bool {
        self.values.iter().any(|(t, _)| *t == tag)
    }

    /// The bytes of `attribute`, unless it is absent or empty.
    pub(crate) fn bytes(&self, attribute: Attribute) -> Option<&[u8]> {
        let (_, bytes) = self.values.iter().find(|(tag, _)| *tag == attribute.tag)?;
        (!bytes.is_empty()).then_some(bytes)
    }

    /// Where `private` is, in a block that its creator has, unless it is absent or empty.
    pub(crate) fn find_private(&self, private: Private) -> Option<Attribute> {
        self.places_of(private).find(|attribute| self.bytes(*attribute).is_some())
    }

    /// Where `private` is, or would be where an anonymizer has taken its creator's name and left the block.
    pub(crate) fn find_nameless_private(&self, private: Private) -> Attribute {
        self.find_private(private).unwrap_or(private.in_block(0x10))
    }

    /// The items of the sequence `private`, as [`DataSet::find_nameless_private`] finds it.
    pub(crate) fn private_items(&self, private: Private) -> &[DataSet] {
        let places = self.places_of(private).chain([private.in_block(0x10)]);
        places.map(|attribute| self.items(attribute)).find(|items| !items.is_empty()).unwrap_or(&[])
    }

    /// Where `private` belongs in the blocks that its creator has.
    fn places_of(&self, private: Private) -> impl Iterator<Item = Attribute> {
        let creators = self
            .values
            .iter()
            .filter(move |(tag, _)| tag >> 16 == private.group && (0x10..=0xFF).contains(&(tag & 0xFFFF)));
        let is_creator = move |name: &[u8]| {
            let name = name.trim_ascii_end();
            let name = name.strip_suffix(b"\0").unwrap_or(name).trim_ascii();
            name.eq_ignore_ascii_case(private.creator.as_bytes())
        };
        let blocks = creators.filter(move |(_, name)| is_creator(name)).map(|(tag, _)| tag & 0xFF);
        blocks.map(move |block| private.in_block(block))
    }

    /// What it says and, where it is silent, the others, of values and of the sequence `of` alone.
    pub(crate) fn completed_by<'a>(
        &'a self,
        others: impl Iterator<Item = &'a DataSet>,
        of: Attribute,
    ) -> DataSet {
        let mut all = DataSet { big_endian: self.big_endian, ..DataSet::default() };
        for set in [self].into_iter().chain(others) {
            // What is there and empty says nothing.
            let is_new = |(tag, value): &&(u32, Vec<u8>)| !value.is_empty() && !all.has(*tag);
            let news: Vec<_> = set.values.iter().filter(is_new).cloned().collect();
            all.values.extend(news);
            if all.sequences.is_empty() && !set.items(of).is_empty() {
                all.sequences.push((of.tag, set.items(of).to_vec()));
            }
        }
        all
    }

    /// The items of sequence `attribute`; none where it is absent.
    pub(crate) fn items(&self, attribute: Attribute) -> &[DataSet] {
        self.sequences.iter().find(|(tag, _)| *tag == attribute.tag).map_or(&[], |(_, items)| items)
    }
}

/// Where and what the pixel data are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PixelElement {
    /// PixelData, FloatPixelData or DoubleFloatPixelData.
    pub(crate) attribute: Attribute,
    /// Whether 8-bit samples lie in 16-bit words, to be swapped in a big endian file.
    pub(crate) words: bool,
    /// Offset of the value; after inflating, where the data set is deflated.
    pub(crate) offset: u64,
    /// Declared length; `None` for encapsulated pixel data.
    pub(crate) length: Option<u64>,
    /// Bytes from `offset` to the end of the file, where that is known.
    pub(crate) available: Option<u64>,
}

/// A file's wanted values, and where its pixels are.
#[derive(Debug)]
pub(crate) struct Header {
    /// TransferSyntaxUID; empty where the file does not say.
    pub(crate) transfer_syntax: String,
    /// The data set's values.
    pub(crate) data: DataSet,
    /// The pixel data, if there are any.
    pub(crate) pixels: Option<PixelElement>,
    /// Where a deflated data set starts.
    pub(crate) deflated_from: Option<u64>,
    /// Whether this is a DICOMDIR, an index of other files.
    pub(crate) is_directory: bool,
}

/// Reads a file's header, up to its pixel data.
pub(crate) fn read_header(source: &Source, cancel: &CancelToken) -> Result<Header> {
    let Some((start, bare_syntax)) = find_start(source)? else {
        return Err(Fault::NotDicom("it is not a DICOM file"));
    };
    let mut input = source.open_cancellable(cancel)?;
    input.skip(start)?;
    let mut walker = Walker::new(input);
    // Group 0002 is written alike in every syntax.
    let first = walker.peek_tag(EXPLICIT_LITTLE)?;
    match bare_syntax {
        Some(syntax) if first.is_none_or(|tag| tag >> 16 != 2) => {
            read_data_set(walker, String::new(), syntax, None)
        }
        _ => read_after_prefix(walker),
    }
}

/// Whether a file's first bytes are those of a DICOM file.
pub(crate) fn is_dicom(source: &Source) -> bool {
    find_start(source).is_ok_and(|start| start.is_some())
}

/// Where a file's first element is, and its syntax where no prefix says that it is the file meta information.
fn find_start(source: &Source) -> Result<Option<(u64, Option<Syntax>)>> {
    let mut head = [0; 138];
    let n = source.open()?.read_up_to(&mut head)?;
    if n == 0 {
        return Err(Fault::NotDicom("it is empty"));
    }
    let has_prefix = n >= 132 && &head[128..132] == b"DICM";
    // A file without preamble may have these letters there in a value; behind a prefix the meta group begins.
    let has_meta = n == 138 && head[132..134] == [2, 0] && is_known_vr([head[136], head[137]]);
    if has_prefix && (has_meta || bare_syntax(&head).is_none()) {
        return Ok(Some((132, None)));
    }
    // The prefix without its preamble, or neither.
    let start = if head.starts_with(b"DICM") { 4 } else { 0 };
    Ok(bare_syntax(&head[start..n.max(start)]).map(|syntax| (start as u64, Some(syntax))))
}

/// What a file without preamble is written in, judged by its first element; `None` if that is none.
fn bare_syntax(head: &[u8]) -> Option<Syntax> {
    let first = head.first_chunk::<8>()?;
    let explicit = is_known_vr([first[4], first[5]]);
    let length = u32::from_le_bytes([first[4], first[5], first[6], first[7]]);
    match (first[0], first[1]) {
        (2 | 8, 0) if explicit => Some(EXPLICIT_LITTLE),
        (8, 0) if length <= 1024 && length.is_multiple_of(2) && first[3] < 0x20 => Some(IMPLICIT_LITTLE),
        (0, 8) if explicit => Some(EXPLICIT_BIG),
        _ => None,
    }
}

/// Reads the file meta information (group 0002, always explicit little endian), then the data set.
fn read_after_prefix(mut walker: Walker) -> Result<Header> {
    let mut meta = DataSet::default();
    let mut group_end = None;
    // FileMetaInformationGroupLength is often wrong, so the group number decides; but what follows may be deflated and
    // look like anything.
    while !(group_end == Some(walker.input.position())
        && meta.bytes(attributes::TRANSFER_SYNTAX_UID).is_some())
    {
        if walker.peek_tag(EXPLICIT_LITTLE)?.is_none_or(|tag| tag >> 16 != 2) {
            break;
        }
        let element = walker.element(EXPLICIT_LITTLE)?;
        let is_group_length = element.tag == attributes::FILE_META_INFORMATION_GROUP_LENGTH.tag;
        walker.value_or_skip(element, EXPLICIT_LITTLE, &mut meta, 0)?;
        if is_group_length
            && let Some(Ok(bytes)) =
                meta.bytes(attributes::FILE_META_INFORMATION_GROUP_LENGTH).map(<[u8; 4]>::try_from)
        {
            group_end = walker.input.position().checked_add(u32::from_le_bytes(bytes).into());
        }
    }
    let uid = meta.bytes(attributes::TRANSFER_SYNTAX_UID).map(String::from_utf8_lossy).unwrap_or_default();
    let uid = uid.trim_matches(|c: char| c == '\0' || c.is_whitespace()).to_owned();
    match uid.as_str() {
        "1.2.840.10008.1.2" => read_data_set(walker, uid, IMPLICIT_LITTLE, None),
        "1.2.840.10008.1.2.2" => read_data_set(walker, uid, EXPLICIT_BIG, None),
        "1.2.840.10008.1.2.1.99" => {
            // The tag that ended the group above may have been deflated bytes already.
            let prefix = walker.pending.map_or(Vec::new(), |bytes| bytes.to_vec());
            let start = walker.input.position() - prefix.len() as u64;
            read_data_set(Walker::new(walker.input.inflate(prefix)), uid, EXPLICIT_LITTLE, Some(start))
        }
        _ => read_data_set(walker, uid, EXPLICIT_LITTLE, None),
    }
}

fn read_data_set(
    mut walker: Walker,
    transfer_syntax: String,
    mut syntax: Syntax,
    deflated_from: Option<u64>,
) -> Result<Header> {
    let mut data = DataSet { big_endian: syntax.big_endian, ..Default::default() };
    let mut is_directory = false;
    let mut is_first = true;
    let pixels = loop {
        let Some(tag) = walker.peek_tag(syntax)? else { break None };
        // No file has such an element; zeros at the end are padding.
        if tag == 0 {
            break None;
        }
        let element = if is_first && !syntax.big_endian {
            // Some writers call an implicit data set explicit, or the other way round: the first element shows it.
            is_first = false;
            let element = walker.element_of_unsure_syntax()?;
            syntax.explicit = element.vr.is_some();
            element
        } else {
            walker.element(syntax)?
        };
        let attribute = match tag {
            0x7FE0_0008 => attributes::FLOAT_PIXEL_DATA,
            0x7FE0_0009 => attributes::DOUBLE_FLOAT_PIXEL_DATA,
            0x7FE0_0010 => attributes::PIXEL_DATA,
            _ => {
                is_directory |= tag == DIRECTORY_RECORD_SEQUENCE;
                walker.value_or_skip(element, syntax, &mut data, 0)?;
                continue;
            }
        };
        break Some(PixelElement {
            attribute,
            words: element.vr != Some(*b"OB"),
            offset: walker.input.position(),
            length: element.length,
            available: walker.input.remaining(),
        });
    };
    Ok(Header { transfer_syntax, data, pixels, deflated_from, is_directory })
}

/// The head of an element: what it is and how long its value is.
#[derive(Clone, Copy, Debug)]
struct Element {
    tag: u32,
    /// `None` where the syntax is implicit.
    vr: Option<[u8; 2]>,
    /// `None` where it is undefined: the value ends with a delimiter.
    length: Option<u64>,
}

impl Element {
    /// What the items of this element are written in: those of an unknown VR are always implicit (PS3.5 6.2.2).
    fn item_syntax(self, syntax: Syntax) -> Syntax {
        if self.vr == Some(*b"UN") { IMPLICIT_LITTLE } else { syntax }
    }
}

/// Walks elements, one after the other.
struct Walker {
    input: Input,
    /// A tag that was peeked at.
    pending: Option<[u8; 4]>,
    /// Items that may still be kept.
    items_left: usize,
}

impl Walker {
    fn new(input: Input) -> Self {
        Self { input, pending: None, items_left: MOST_ITEMS }
    }

    /// The tag of the next element; `None` at the end of the file.
    fn peek_tag(&mut self, syntax: Syntax) -> Result<Option<u32>> {
        let bytes = match self.pending {
            Some(bytes) => bytes,
            None => {
                let mut bytes = [0; 4];
                // One to three bytes after the last element are padding.
                if self.input.read_up_to(&mut bytes)? < 4 {
                    return Ok(None);
                }
                self.pending = Some(bytes);
                bytes
            }
        };
        let half =
            |a, b| if syntax.big_endian { u16::from_be_bytes([a, b]) } else { u16::from_le_bytes([a, b]) };
        Ok(Some(u32::from(half(bytes[0], bytes[1])) << 16 | u32::from(half(bytes[2], bytes[3]))))
    }

    fn tag(&mut self, syntax: Syntax) -> Result<u32> {
        let tag = self
            .peek_tag(syntax)?
            .ok_or_else(|| Fault::from(io::Error::from(io::ErrorKind::UnexpectedEof)))?;
        self.pending = None;
        Ok(tag)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        let mut bytes = [0; N];
        self.input.read_exact(&mut bytes)?;
        Ok(bytes)
    }

    /// Reads the head of the next element, whether explicit or implicit.
    fn element_of_unsure_syntax(&mut self) -> Result<Element> {
        let tag = self.tag(EXPLICIT_LITTLE)?;
        let four = self.array()?;
        let explicit = is_known_vr([four[0], four[1]]);
        self.element_after(tag, four, Syntax { big_endian: false, explicit })
    }

    /// Reads the head of the next element.
    fn element(&mut self, syntax: Syntax) -> Result<Element> {
        let tag = self.tag(syntax)?;
        let four: [u8; 4] = self.array()?;
        // Some writers drop the VR of single elements of an explicit data set.
        let has_vr = four[0].is_ascii_uppercase() && four[1].is_ascii_uppercase() && tag >> 16 != 0xFFFE;
        self.element_after(tag, four, Syntax { explicit: syntax.explicit && has_vr, ..syntax })
    }

    fn element_after(&mut self, tag: u32, four: [u8; 4], syntax: Syntax) -> Result<Element> {
        let long =
            |bytes| if syntax.big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) };
        if !syntax.explicit {
            let length = long(four);
            return Ok(Element { tag, vr: None, length: (length != UNDEFINED).then_some(length.into()) });
        }
        let [v, r, a, b] = four;
        let vr = [v, r];
        // A VR of a future edition has the long form, with two reserved bytes.
        let length = if !is_short_vr(vr) && (is_known_vr(vr) || [a, b] == [0, 0]) {
            long(self.array()?)
        } else if syntax.big_endian {
            u16::from_be_bytes([a, b]).into()
        } else {
            u16::from_le_bytes([a, b]).into()
        };
        Ok(Element { tag, vr: Some(vr), length: (length != UNDEFINED).then_some(length.into()) })
    }

    /// Fails where `length` bytes cannot follow.
    fn check_length(&self, tag: u32, length: u64) -> Result<()> {
        match self.input.remaining() {
            Some(remaining) if length > remaining => Err(Fault::Damaged(format!(
                "has {remaining} bytes left for element ({:04X},{:04X}), which declares {length}",
                tag >> 16,
                tag & 0xFFFF
            ))),
            _ => Ok(()),
        }
    }

    /// Keeps the value of `element` in `data` if it is wanted, else steps over it.
    fn value_or_skip(
        &mut self,
        element: Element,
        syntax: Syntax,
        data: &mut DataSet,
        depth: usize,
    ) -> Result<()> {
        let Element { tag, vr, length } = element;
        if let Some(length) = length {
            self.check_length(tag, length)?;
        }
        let may_hold_items = vr.is_none_or(|vr| &vr == b"SQ" || &vr == b"UN");
        if attributes::is_wanted_sequence(tag) && may_hold_items && depth < DEEPEST_WANTED {
            let items = self.items(length, element.item_syntax(syntax), depth + 1)?;
            if data.sequences.iter().all(|(t, _)| *t != tag) {
                data.sequences.push((tag, items));
            }
            return Ok(());
        }
        match length {
            // Of an element that is there twice the first counts.
            Some(length) if is_wanted(tag, data) && length <= LONGEST_VALUE && !data.has(tag) => {
                data.values.push((tag, self.input.read_vec(length)?));
                Ok(())
            }
            Some(length) => Ok(self.input.skip(length)?),
            None => self.skip_undefined(element.item_syntax(syntax)),
        }
    }

    /// The items of a sequence.
    fn items(&mut self, length: Option<u64>, syntax: Syntax, depth: usize) -> Result<Vec<DataSet>> {
        let end = length.map(|length| self.input.position().saturating_add(length));
        let mut items = Vec::new();
        while end.is_none_or(|end| self.input.position() < end) {
            let item = self.element(Syntax { explicit: false, ..syntax })?;
            match item.tag {
                ITEM if self.items_left == 0 => {
                    return Err(Fault::Damaged(format!("has more than {MOST_ITEMS} items")));
                }
                ITEM => {
                    self.items_left -= 1;
                    items.push(self.item(item, syntax, depth)?);
                }
                ITEM_DELIMITATION => {}
                SEQUENCE_DELIMITATION => break,
                _ => return Err(Fault::Damaged("has a sequence that is not made of items".to_owned())),
            }
        }
        Ok(items)
    }

    /// The wanted values of an item.
    fn item(&mut self, item: Element, syntax: Syntax, depth: usize) -> Result<DataSet> {
        if let Some(length) = item.length {
            self.check_length(item.tag, length)?;
        }
        let end = item.length.map(|length| self.input.position().saturating_add(length));
        let mut data = DataSet { big_endian: syntax.big_endian, ..Default::default() };
        while end.is_none_or(|end| self.input.position() < end) {
            match self.peek_tag(syntax)? {
                Some(ITEM_DELIMITATION) => {
                    self.element(syntax)?;
                    break;
                }
                // Of the sequence, whose item has no delimiter of its own.
                Some(SEQUENCE_DELIMITATION) => break,
                _ => {
                    let element = self.element(syntax)?;
                    self.value_or_skip(element, syntax, &mut data, depth)?;
                }
            }
        }
        Ok(data)
    }

    /// Steps over the items of a value of undefined length, however deep they are nested.
    fn skip_undefined(&mut self, syntax: Syntax) -> Result<()> {
        // Sequences and items alternate, so that a counter is all the stack there is: odd in a sequence, even in an
        // item.
        let mut depth = 1u64;
        // The depth of the outermost value of unknown VR, within which all is implicit.
        let mut implicit_from = None;
        while depth > 0 {
            let now = if implicit_from.is_some() { IMPLICIT_LITTLE } else { syntax };
            let element = self.element(now)?;
            match (depth % 2 == 1, element.tag, element.length) {
                (true, SEQUENCE_DELIMITATION, _) | (false, ITEM_DELIMITATION, _) => depth -= 1,
                // The delimiter of an item is missing.
                (false, SEQUENCE_DELIMITATION, _) => depth -= 2,
                (true, ITEM_DELIMITATION, _) => {}
                (true, ITEM, None) => depth += 1,
                (true, tag, _) if tag != ITEM => {
                    return Err(Fault::Damaged("has a sequence that is not made of items".to_owned()));
                }
                (_, tag, Some(length)) => {
                    self.check_length(tag, length)?;
                    self.input.skip(length)?;
                }
                (_, _, None) => {
                    depth += 1;
                    if element.vr == Some(*b"UN") && implicit_from.is_none() {
                        implicit_from = Some(depth);
                    }
                }
            }
            if implicit_from.is_some_and(|outermost| depth < outermost) {
                implicit_from = None;
            }
        }
        Ok(())
    }
}

/// Whether a value is kept. The long private header of Siemens is, where it says how a mosaic is made.
fn is_wanted(tag: u32, data: &DataSet) -> bool {
    let is_csa = |tag: u32| tag >> 16 == attributes::SIEMENS_CSA_HEADER.group && tag & 0xFFFF >= 0x1000;
    attributes::is_wanted_value(tag)
        && (!is_csa(tag)
            || data.bytes(attributes::IMAGE_TYPE).is_some_and(|t| t.windows(6).any(|w| w == b"MOSAIC")))
}

/// VRs whose length has 16 bits (PS3.5 table 7.1-2).
fn is_short_vr(vr: [u8; 2]) -> bool {
    const SHORT: [&[u8; 2]; 21] = [
        b"AE", b"AS", b"AT", b"CS", b"DA", b"DS", b"DT", b"FL", b"FD", b"IS", b"LO", b"LT", b"PN", b"SH",
        b"SL", b"SS", b"ST", b"TM", b"UI", b"UL", b"US",
    ];
    SHORT.contains(&&vr)
}

fn is_known_vr(vr: [u8; 2]) -> bool {
    const LONG: [&[u8; 2]; 12] =
        [b"OB", b"OD", b"OF", b"OL", b"OV", b"OW", b"SQ", b"SV", b"UC", b"UN", b"UR", b"UT"];
    is_short_vr(vr) || LONG.contains(&&vr) || &vr == b"UV"
}
