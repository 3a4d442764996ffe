//! Texts in the character sets that DICOM knows (SpecificCharacterSet, PS3.3 C.12.1.1.2 and PS3.5 6.1): one for the whole
//! text, or several that escapes of ISO 2022 switch between.

use std::borrow::Cow;

use encoding_rs::{self as enc, Encoding};

use crate::dicom::elements::{
    attributes::{self as attr, Attribute},
    data_set::DataSet,
};

const ESCAPE: u8 = 0x1B;

/// How bytes stand for letters.
#[derive(Clone, Copy, Debug)]
enum Code {
    /// ASCII below 128, and this above.
    Upper(&'static Encoding),
    /// Pairs of bytes below 128: the Japanese sets, JIS X 0208 and (`true`) JIS X 0212.
    Kanji(bool),
    /// What the text itself looks like: UTF-8, else Latin-1.
    Unknown,
}

/// The character set of a data set's texts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Charset {
    first: Code,
}

impl Charset {
    /// The one of `item`, or where it says none that of the data set around it.
    pub(crate) fn of(item: &DataSet, around: &DataSet) -> Self {
        let told = [item, around].into_iter().find(|data| data.bytes(attr::SPECIFIC_CHARACTER_SET).is_some());
        let terms = told.map(|data| data.texts(attr::SPECIFIC_CHARACTER_SET)).unwrap_or_default();
        // The first counts until an escape; where it is empty that is ASCII.
        let first = terms.iter().map(String::as_str).find(|term| !term.is_empty()).unwrap_or_default();
        let starts_plain = terms.first().is_none_or(String::is_empty);
        Self { first: if starts_plain { Code::Unknown } else { of_term(first) } }
    }

    /// A text of `data` without its padding. Bytes that stand for nothing become `\u{FFFD}`, what moves a cursor a space; a
    /// zero stays, since no text has one.
    pub(crate) fn text(self, data: &DataSet, attribute: Attribute) -> Option<String> {
        /// Longer values are no names.
        const LONGEST: usize = 4096;
        let bytes = data.bytes(attribute)?;
        let text = self.decode(&bytes[..bytes.len().min(LONGEST)]);
        let text: String = text.chars().map(|c| if c.is_control() && c != '\0' { ' ' } else { c }).collect();
        let text = text.trim_matches(|c: char| c == '\0' || c.is_whitespace());
        (!text.is_empty()).then(|| text.to_owned())
    }

    fn decode(self, bytes: &[u8]) -> String {
        let mut parts = bytes.split(|byte| *byte == ESCAPE);
        let mut text = self.first.decode(parts.next().unwrap_or_default()).into_owned();
        let mut upper = self.first;
        for part in parts {
            let (code, rest) = escaped(part, upper);
            if let Code::Upper(_) = code {
                upper = code;
            }
            text.push_str(&code.decode(rest));
        }
        text
    }
}

/// The set of a defined term, with or without code extensions.
fn of_term(term: &str) -> Code {
    let number = term.rsplit(' ').next().unwrap_or_default().trim_start_matches("ISO_IR").trim();
    Code::Upper(match (term, number) {
        ("GB18030", _) => enc::GB18030,
        ("GBK", _) => enc::GBK,
        (_, "100") => enc::WINDOWS_1252,
        (_, "101") => enc::ISO_8859_2,
        (_, "109") => enc::ISO_8859_3,
        (_, "110") => enc::ISO_8859_4,
        (_, "144") => enc::ISO_8859_5,
        (_, "127") => enc::ISO_8859_6,
        (_, "126") => enc::ISO_8859_7,
        (_, "138") => enc::ISO_8859_8,
        (_, "148") => enc::WINDOWS_1254,
        (_, "203") => enc::ISO_8859_15,
        (_, "166") => enc::WINDOWS_874,
        (_, "13") => enc::SHIFT_JIS,
        (_, "149") => enc::EUC_KR,
        (_, "58") => enc::GBK,
        (_, "192") => enc::UTF_8,
        (_, "87") => return Code::Kanji(false),
        (_, "159") => return Code::Kanji(true),
        _ => return Code::Unknown,
    })
}

/// What comes after an escape, and in which set (PS3.3 table C.12-3 and C.12-4); `upper` is that of bytes above 127 so far.
fn escaped(part: &[u8], upper: Code) -> (Code, &[u8]) {
    let known = |code: &'static Encoding, length: usize| (Code::Upper(code), &part[length..]);
    match part {
        [b'$', b'B' | b'@', ..] => (Code::Kanji(false), &part[2..]),
        [b'$', b'(', b'D', ..] => (Code::Kanji(true), &part[3..]),
        [b'$', b')', b'C', ..] => known(enc::EUC_KR, 3),
        [b'$', b')', b'A', ..] => known(enc::GBK, 3),
        [b')', b'I', ..] => known(enc::SHIFT_JIS, 2),
        // ASCII, and its Japanese sibling, below 128.
        [b'(', b'B' | b'J', ..] => (upper, &part[2..]),
        [b'-', set, ..] => {
            let code = match set {
                b'A' => enc::WINDOWS_1252,
                b'B' => enc::ISO_8859_2,
                b'C' => enc::ISO_8859_3,
                b'D' => enc::ISO_8859_4,
                b'F' => enc::ISO_8859_7,
                b'G' => enc::ISO_8859_6,
                b'H' => enc::ISO_8859_8,
                b'L' => enc::ISO_8859_5,
                b'M' => enc::WINDOWS_1254,
                b'T' => enc::WINDOWS_874,
                b'b' => enc::ISO_8859_15,
                _ => return (Code::Unknown, &part[2..]),
            };
            known(code, 2)
        }
        _ => (upper, part),
    }
}

impl Code {
    fn decode(self, bytes: &[u8]) -> Cow<'_, str> {
        match self {
            Code::Upper(encoding) => encoding.decode_without_bom_handling(bytes).0,
            Code::Unknown => match std::str::from_utf8(bytes) {
                Ok(text) => text.into(),
                Err(_) => enc::WINDOWS_1252.decode_without_bom_handling(bytes).0,
            },
            // The same pairs with their upper bits set are EUC-JP, in which JIS X 0212 has a byte before them.
            Code::Kanji(second) => {
                let pairs = bytes.chunks(2).flat_map(|pair| {
                    let mark = (second && pair.len() == 2).then_some(0x8F);
                    mark.into_iter().chain(pair.iter().map(|byte| byte | 0x80))
                });
                let euc: Vec<u8> = pairs.collect();
                enc::EUC_JP.decode_without_bom_handling(&euc).0.into_owned().into()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(terms: &[&str], bytes: &[u8]) -> String {
        let first = if terms[0].is_empty() { Code::Unknown } else { of_term(terms[0]) };
        Charset { first }.decode(bytes)
    }

    /// The examples of PS3.5 annexes H to K, and the field's own words.
    #[test]
    fn sets_of_one_kind() {
        for (term, bytes, text) in [
            ("ISO_IR 192", "Größe der Leber 肝臓".as_bytes(), "Größe der Leber 肝臓"),
            ("ISO_IR 100", b"Gr\xf6\xdfe", "Größe"),
            ("ISO_IR 144", &[0xBB, 0xEE, 0xDA], "Люк"),
            ("ISO_IR 101", &[0xB1, b'a'], "ąa"),
            ("ISO_IR 126", &[0xC4, 0xE9, 0xEF], "Διο"),
            ("ISO_IR 166", &[0xB5, 0xD1, 0xBA], "ตับ"),
            ("ISO_IR 13", &[0xD4, 0xCF, 0xC0, 0xDE], "ﾔﾏﾀﾞ"),
            ("GB18030", &[0xB8, 0xCE, 0xD4, 0xE0], "肝脏"),
            ("ISO 2022 IR 100", b"Gr\xf6\xdfe", "Größe"),
            ("", b"Gr\xf6\xdfe", "Größe"),
            ("", "Größe".as_bytes(), "Größe"),
            ("ISO_IR 6", b"liver", "liver"),
        ] {
            assert_eq!(decoded(&[term], bytes), text, "{term}");
        }
    }

    #[test]
    fn escapes_switch_between_sets() {
        assert_eq!(decoded(&["", "ISO 2022 IR 87"], b"\x1b$B4NB!\x1b(B 1"), "肝臓 1");
        assert_eq!(decoded(&["", "ISO 2022 IR 149"], b"\x1b$)C\xb1\xe8\xc8\xf1\xc1\xdf"), "김희중");
        assert_eq!(decoded(&["", "ISO 2022 IR 58"], b"\x1b$)A\xd0\xa1\xb6\xab"), "小东");
        assert_eq!(decoded(&["ISO 2022 IR 6", "ISO 2022 IR 144"], b"a\x1b-L\xbb\xee\xda"), "aЛюк");
        // JIS X 0212: the copyright sign.
        assert_eq!(decoded(&["", "ISO 2022 IR 159"], b"\x1b$(D\x22\x6d\x1b(B"), "©");
        // An escape that nobody knows, and one that is cut off.
        assert_eq!(decoded(&[""], b"a\x1b%Gb\x1b"), "a%Gb");
    }
}
