//! The patient's name and number, as what no text that is told may hold: whole, in parts, inside of words, and spelt
//! otherwise.

use unicode_normalization::{UnicodeNormalization, char::is_combining_mark};

use crate::dicom::elements::{attributes as attr, charset::Charset, data_set::DataSet};

/// Letters that a part of a name must have at least, where it counts inside of words, too: `Li` is a name, and in `liver`.
const DISTINCTIVE: usize = 4;
/// As much of scripts that write words or syllables with a letter, and parts without spaces between them.
const DISTINCTIVE_IN_SCRIPTS: usize = 2;

/// Letters that have no parts, but are written otherwise all the same.
const SPELLINGS: [(char, &str); 9] = [
    ('ß', "s"),
    ('æ', "a"),
    ('œ', "o"),
    ('ø', "o"),
    ('ł', "l"),
    ('đ', "d"),
    ('ð', "d"),
    ('þ', "th"),
    ('ı', "i"),
];

/// A patient's name and number.
#[derive(Debug, Default)]
pub(crate) struct PatientNames {
    /// In lower case as they are written: whole without what parts them, in parts, and their runs of letters and digits.
    plain: Vec<String>,
    /// Parts as [`fold`] spells them.
    folded: Vec<String>,
}

impl PatientNames {
    /// Those of a data set.
    pub(crate) fn of(data: &DataSet) -> Self {
        let charset = Charset::of(data, data);
        let mut names = Self::default();
        for text in
            [attr::PATIENT_NAME, attr::PATIENT_ID].into_iter().filter_map(|name| charset.text(data, name))
        {
            names.add(&text);
        }
        names
    }

    /// Those of somebody who is called so.
    #[cfg(test)]
    pub(crate) fn called(name: &str) -> Self {
        let mut names = Self::default();
        names.add(name);
        names
    }

    fn add(&mut self, text: &str) {
        let text = text.to_lowercase();
        self.plain.push(text.chars().filter(|c| c.is_alphanumeric()).collect());
        let parts = text.split(|c: char| !c.is_alphanumeric()).filter(|part| !part.is_empty());
        self.plain.extend(parts.map(str::to_owned));
        self.plain.extend(runs(&text).filter(|run| run.len() > 1).map(str::to_owned));
        // Of a part such as O'Brien or Jean-Luc both the whole and the pieces.
        let wholes = text.split(|c: char| c == '^' || c == '=' || c.is_whitespace());
        let pieces = text.split(|c: char| !(c.is_alphanumeric() || is_combining_mark(c)));
        self.folded.extend(wholes.chain(pieces).map(fold).filter(|part| !part.is_empty()));
        self.folded.sort_unstable();
        self.folded.dedup();
    }

    /// Whether a word in lower case, or a run of letters or digits in it, is one of the names.
    pub(crate) fn is_named(&self, word: &str) -> bool {
        let is_name = |part: &str| self.plain.iter().any(|name| name == part);
        let bare: String = word.chars().filter(|c| c.is_alphanumeric()).collect();
        is_name(word) || is_name(&bare) || runs(word).any(is_name)
    }

    /// Whether one of them is exactly this.
    pub(crate) fn has(&self, word: &str) -> bool {
        self.plain.iter().any(|name| name == word)
    }

    /// The words of a text that hold nothing of the names, parted by spaces. Names are found inside of words and across
    /// them, with other accents, and with what stands for these.
    pub(crate) fn without(&self, text: &str) -> String {
        let words: Vec<&str> = text.split_whitespace().collect();
        let folded: Vec<String> = words.iter().map(|word| fold(word)).collect();
        let mut is_told: Vec<bool> = words
            .iter()
            .zip(&folded)
            .map(|(word, folded)| !self.is_named(&word.to_lowercase()) && !self.folded.contains(folded))
            .collect();
        // All words in a row, and which one each byte is of.
        let row = folded.concat();
        let word_of: Vec<usize> = folded
            .iter()
            .enumerate()
            .flat_map(|(word, text)| std::iter::repeat_n(word, text.len()))
            .collect();
        for name in self.folded.iter().filter(|name| is_distinctive(name)) {
            for (at, found) in row.match_indices(name.as_str()) {
                word_of[at..at + found.len()].iter().for_each(|word| is_told[*word] = false);
            }
        }
        // A piece of a name in a script without spaces, or whose letters are no ASCII.
        for (told, word) in is_told.iter_mut().zip(&folded) {
            let is_piece =
                || word.chars().count() > 1 && self.folded.iter().any(|name| name.contains(word.as_str()));
            *told &= word.is_ascii() || !is_piece();
        }
        let told = words.iter().zip(&is_told).filter(|(_, is_told)| **is_told);
        told.map(|(word, _)| *word).collect::<Vec<_>>().join(" ")
    }
}

/// Whether a part of a name is hardly in a word by chance.
fn is_distinctive(part: &str) -> bool {
    // From Thai on, through kana, Chinese and Hangul.
    let is_of_script = part.chars().all(|c| c >= '\u{0E00}');
    part.chars().count() >= if is_of_script { DISTINCTIVE_IN_SCRIPTS } else { DISTINCTIVE }
}

/// Letters and digits alone, in lower case, without accents; `ae`, `oe` and `ue`, which stand for such, and doubled `s`,
/// which stands for another, are their first letters. So are Müller, Mueller and Muller one, and O'Brien and OBrien.
fn fold(text: &str) -> String {
    let mut folded = String::new();
    // Lower case first: it may part letters anew.
    for c in text.to_lowercase().nfkd().filter(|c| !is_combining_mark(*c) && c.is_alphanumeric()) {
        let spelt = SPELLINGS.iter().find(|(letter, _)| *letter == c);
        let mut buffer = [0; 4];
        let spelt = spelt.map_or_else(|| &*c.encode_utf8(&mut buffer), |(_, spelt)| spelt);
        let last = folded.chars().last();
        let is_second =
            matches!((last, spelt), (Some('a' | 'o' | 'u'), "e") | (Some('a'), "a") | (Some('s'), "s"));
        if !is_second {
            folded.push_str(spelt);
        }
    }
    folded
}

/// The runs of letters and of digits in a text, of what ASCII has.
fn runs(text: &str) -> impl Iterator<Item = &str> {
    let kind = |byte: &u8| (byte.is_ascii_alphabetic(), byte.is_ascii_digit());
    let runs = text.as_bytes().chunk_by(move |a, b| kind(a) == kind(b));
    let runs = runs.filter(|run| run[0].is_ascii_alphanumeric());
    runs.filter_map(|run| std::str::from_utf8(run).ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn without(name: &str, text: &str) -> String {
        PatientNames::called(name).without(text)
    }

    #[test]
    fn names_are_found_however_they_are_written() {
        for (name, text, told) in [
            ("ZYXNAMER^Q", "liverZYXNAMER2", ""),
            ("ZYXNAMER^Q", "Zyxnamers liver", "liver"),
            ("O'Brien^Ann", "OBrien liver", "liver"),
            ("OBrien^Ann", "liver O'Brien's", "liver"),
            ("Müller^Jörg", "Mueller Leber", "Leber"),
            ("Mueller^J", "tumor_Müller", ""),
            ("Muller", "Lebermüller1 rechts", "rechts"),
            ("Strauß", "STRAUSS Niere", "Niere"),
            ("Ångström", "Aangstrom kidney", "kidney"),
            ("Łukasz Wałęsa", "walesa1 nerka", "nerka"),
            ("Jean-Luc^Picard", "foie Jean Luc", "foie"),
            ("MacDonald", "Mac Donald spleen", "spleen"),
            ("山田^太郎", "山田の肝臓", ""),
            ("山田^太郎", "肝臓", "肝臓"),
            ("Иванов", "печень Иванова", "печень"),
            ("123456", "roi123456b", ""),
        ] {
            assert_eq!(without(name, text), told, "{name}: {text}");
        }
    }

    #[test]
    fn short_names_are_no_parts_of_words() {
        assert_eq!(without("Li^Lu", "liver lung Li"), "liver lung");
        assert_eq!(without("Hart", "heart left"), "heart left");
        assert_eq!(without("1", "kidney 1 right"), "kidney right");
        assert_eq!(without("", "Größe der Leber"), "Größe der Leber");
    }
}
