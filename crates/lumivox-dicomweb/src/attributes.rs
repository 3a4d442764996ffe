//! DICOM's JSON model (PS3.18, annex F), as far as searches answer with it.

use serde_json::{Map, Value};

/// The attributes of one study or series. What is missing, empty or of another kind than it should be is empty: servers differ.
pub struct Attributes<'a>(&'a Map<String, Value>);

impl<'a> Attributes<'a> {
    /// Those of one answer, where it is one: keys of eight hexadecimal digits with what is below them.
    pub fn of(answer: &'a Value) -> Option<Self> {
        let attributes = answer.as_object()?;
        let is_tag = |key: &String| key.len() == 8 && key.bytes().all(|byte| byte.is_ascii_hexdigit());
        attributes.iter().all(|(key, value)| is_tag(key) && value.is_object()).then_some(Self(attributes))
    }

    fn values(&self, tag: &str) -> impl Iterator<Item = &'a Value> + use<'a> {
        // Digits are upper case by the standard, and lower case here and there.
        let attribute = self.0.get(tag).or_else(|| self.0.get(&tag.to_ascii_lowercase()));
        let values = attribute.and_then(|attribute| attribute.get("Value")).and_then(Value::as_array);
        values.into_iter().flatten()
    }

    /// All texts.
    pub fn texts(&self, tag: &str) -> Vec<String> {
        self.values(tag).map(text).filter(|text| !text.is_empty()).collect()
    }

    /// The first text.
    pub fn text(&self, tag: &str) -> String {
        self.texts(tag).into_iter().next().unwrap_or_default()
    }

    /// The first number, which is a text here and there.
    pub fn number(&self, tag: &str) -> Option<u64> {
        self.text(tag).parse().ok()
    }
}

/// A value as people read it; of a person's name that of its three spellings that is there.
fn text(value: &Value) -> String {
    match value {
        Value::String(text) => text.trim_matches([' ', '\0']).to_owned(),
        Value::Number(number) => number.to_string(),
        Value::Object(spellings) => ["Alphabetic", "Ideographic", "Phonetic"]
            .iter()
            .filter_map(|kind| spellings.get(*kind)?.as_str())
            .map(person)
            .find(|name| !name.is_empty())
            .unwrap_or_default(),
        _ => String::new(),
    }
}

/// A name's five parts (PS3.5, 6.2.1), as in a list: family, then given names.
fn person(name: &str) -> String {
    let mut parts = name.split('^').map(str::trim);
    let family = parts.next().unwrap_or_default();
    let others: Vec<&str> = parts.filter(|part| !part.is_empty()).collect();
    let separator = if family.is_empty() || others.is_empty() { "" } else { ", " };
    format!("{family}{separator}{}", others.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn values_are_read_as_servers_write_them() {
        let answer = json!({
            "00100010": {"vr": "PN", "Value": [{"Alphabetic": "Doe^John^^Dr"}]},
            "0020000d": {"vr": "UI", "Value": ["1.2.3\0"]},
            "00201206": {"vr": "IS", "Value": [3]},
            "00201208": {"vr": "IS", "Value": ["120 "]},
            "00080061": {"vr": "CS", "Value": ["CT", null, "SEG"]},
            "00081030": {"vr": "LO"},
        });
        let of = Attributes::of(&answer).unwrap();
        assert_eq!(of.text("00100010"), "Doe, John Dr");
        assert_eq!(of.text("0020000D"), "1.2.3");
        assert_eq!([of.number("00201206"), of.number("00201208")], [Some(3), Some(120)]);
        assert_eq!(of.texts("00080061"), ["CT", "SEG"]);
        assert_eq!([of.text("00081030"), of.text("00080020")], ["", ""]);
    }

    #[test]
    fn names_in_other_letters_are_names() {
        let name = |spellings: Value| text(&spellings);
        assert_eq!(name(json!({"Ideographic": "山田^太郎"})), "山田, 太郎");
        assert_eq!(name(json!({"Alphabetic": "", "Phonetic": "やまだ^たろう"})), "やまだ, たろう");
        assert_eq!(name(json!({"Alphabetic": "^Anna"})), "Anna");
        assert_eq!(name(json!({})), "");
    }

    #[test]
    fn other_answers_are_none() {
        for other in [json!("6b9e"), json!({"error": "no"}), json!([]), json!({"00100010": "Doe"})] {
            assert!(Attributes::of(&other).is_none(), "{other}");
        }
    }
}
