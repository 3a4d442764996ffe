//! Searches (QIDO-RS, PS3.18, 10.6): which studies there are, and which series of one.

use std::fmt;

use serde_json::Value;
use ureq::http::HeaderValue;
use ureq::http::header::WARNING;

use crate::attributes::Attributes;
use crate::error::Error;
use crate::server::{SILENCE, Server};

/// A unique identifier (PS3.5, 9.1): digits and dots, so that it may stand in an address and in a file's name.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Uid(String);

impl Uid {
    /// One of those letters; `None` where they are none.
    pub fn new(text: &str) -> Option<Self> {
        let is_one = (1..=64).contains(&text.len())
            && text.split('.').all(|part| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit()));
        is_one.then(|| Self(text.to_owned()))
    }

    /// Its letters.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for Uid {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.0)
    }
}

/// Which studies are asked for: all that match every field that is not empty.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Filter {
    /// The beginning of the patient's name, as `Doe, Jane` or `Doe^Jane`, or a pattern of it with `*` and `?`.
    pub patient: String,
    /// The patient's identifier.
    pub patient_id: String,
    /// A day, `2026-01-31`, or from one on to another: `2026-01-01 - 2026-01-31`; either may be left out. Dashes within days may be missing.
    pub days: String,
    /// A modality that some series of it have: `CT`.
    pub modality: String,
}

/// Answers are no longer, so that nobody waits for a hospital's whole archive.
pub const MOST_STUDIES: usize = 100;
/// Nor larger, in bytes.
const MOST_BYTES: u64 = 64 << 20;

/// Studies that match.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Studies {
    /// The newest first.
    pub found: Vec<StudyEntry>,
    /// Whether there are more.
    pub has_more: bool,
}

/// A study, as a list tells of it. What the archive does not say is empty.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StudyEntry {
    /// What it is fetched by.
    pub uid: Uid,
    /// The patient's name, as `Doe, John`.
    pub patient: String,
    /// The patient's identifier.
    pub patient_id: String,
    /// Its day, as `2026-01-31`.
    pub day: String,
    /// What it is of.
    pub description: String,
    /// Modalities of its series.
    pub modalities: Vec<String>,
    /// How many series it has.
    pub series: Option<u64>,
    /// How many images.
    pub images: Option<u64>,
}

/// A series of a study.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SeriesEntry {
    /// What it is fetched by.
    pub uid: Uid,
    /// Its number in the study.
    pub number: Option<u64>,
    /// What it is.
    pub description: String,
    /// How it was taken.
    pub modality: String,
    /// How many images it has.
    pub images: Option<u64>,
}

/// What an archive answers.
#[derive(Default)]
struct Answers {
    all: Vec<Value>,
    /// Whether it has more than it says.
    are_cut: bool,
}

/// What is told of studies beside what every archive returns without being asked: modalities, description, series, images.
const STUDY_FIELDS: [&str; 4] = ["00080061", "00081030", "00201206", "00201208"];
/// And of series: modality, description, number, images.
const SERIES_FIELDS: [&str; 4] = ["00080060", "0008103E", "00200011", "00201209"];

impl Server {
    /// Studies that match, at most 100.
    ///
    /// # Errors
    /// [`Error`]: for days that are none, and where the archive does not answer as one does.
    pub fn studies(&self, filter: &Filter) -> Result<Studies, Error> {
        let mut asked: Vec<(&str, String)> = vec![];
        // As lists show it, or as the standard has it.
        let patient = filter.patient.trim().replace(", ", "^");
        let is_pattern = patient.contains(['*', '?']);
        if !patient.is_empty() {
            asked.push(("PatientName", if is_pattern { patient.clone() } else { format!("{patient}*") }));
        }
        if !filter.patient_id.trim().is_empty() {
            asked.push(("PatientID", filter.patient_id.trim().to_owned()));
        }
        if !filter.days.trim().is_empty() {
            asked.push(("StudyDate", self.days(&filter.days)?));
        }
        if !filter.modality.trim().is_empty() {
            asked.push(("ModalitiesInStudy", filter.modality.trim().to_ascii_uppercase()));
        }
        asked.extend(STUDY_FIELDS.map(|field| ("includefield", field.to_owned())));
        asked.push(("limit", (MOST_STUDIES + 1).to_string()));
        let mut answers = self.search("studies", &asked)?;
        // Archives that know no patterns take the star for a letter of the name.
        if answers.all.is_empty() && !patient.is_empty() && !is_pattern {
            asked[0].1 = patient;
            asked.push(("fuzzymatching", "true".to_owned()));
            answers = self.search("studies", &asked)?;
        }
        let mut found: Vec<StudyEntry> = self.entries(&answers.all)?.iter().filter_map(study).collect();
        // An archive that knows no limit, or has one of its own.
        let has_more = answers.are_cut || found.len() > MOST_STUDIES;
        found.sort_by(|a, b| b.day.cmp(&a.day));
        found.truncate(MOST_STUDIES);
        Ok(Studies { found, has_more })
    }

    /// The series of a study, in the order of their numbers.
    ///
    /// # Errors
    /// [`Error`], where the archive does not answer as one does.
    pub fn series(&self, study: &Uid) -> Result<Vec<SeriesEntry>, Error> {
        let fields = SERIES_FIELDS.map(|field| ("includefield", field.to_owned()));
        let answers = self.search(&format!("studies/{study}/series"), &fields)?;
        let mut found: Vec<SeriesEntry> = self.entries(&answers.all)?.iter().filter_map(series).collect();
        found.sort_by_key(|series| (series.number.is_none(), series.number));
        Ok(found)
    }

    fn search(&self, what: &str, asked: &[(&str, String)]) -> Result<Answers, Error> {
        let answer = self.get(what, asked, &["application/dicom+json"], SILENCE);
        let mut answer = answer.map_err(|error| match error {
            // All that is asked is in the standard; other interfaces that have studies do not know it.
            Error::Refused { server, status: status @ 400, words } => Error::NoArchive {
                server,
                why: format!("it does not understand the question (HTTP {status}){words}"),
            },
            error => error,
        })?;
        // 'No content', where nothing matches.
        if answer.status().as_u16() == 204 {
            return Ok(Answers::default());
        }
        // How archives say that there are more (PS3.18, 8.3.4.4), by a warning or, formerly, as a part.
        let warns = |value: &HeaderValue| {
            let text = value.to_str().unwrap_or_default().to_ascii_lowercase();
            text.contains("additional results") || text.contains("more results")
        };
        let are_cut = answer.status().as_u16() == 206 || answer.headers().get_all(WARNING).iter().any(warns);
        let kind = answer.body().mime_type().unwrap_or_default().to_owned();
        let bytes = answer.body_mut().with_config().limit(MOST_BYTES).read_to_vec();
        let bytes = bytes.map_err(|error| self.cut(&error.to_string()))?;
        let none = |why: String| Error::NoArchive { server: self.address().to_owned(), why };
        if kind.contains("html") {
            return Err(none("a page for people came".to_owned()));
        }
        if bytes.trim_ascii().is_empty() {
            return Ok(Answers::default());
        }
        match serde_json::from_slice(&bytes) {
            Ok(Value::Array(all)) => Ok(Answers { all, are_cut }),
            Ok(_) => Err(none("no list came".to_owned())),
            Err(error) if error.is_eof() => Err(self.cut("the list has no end")),
            Err(error) => Err(none(format!("no JSON came ({error})"))),
        }
    }

    /// Those that are studies or series: where there are answers and none of them is, it is no archive.
    fn entries<'a>(&self, answers: &'a [Value]) -> Result<Vec<Attributes<'a>>, Error> {
        let all: Vec<Attributes<'a>> = answers.iter().filter_map(Attributes::of).collect();
        if all.is_empty() && !answers.is_empty() {
            let why = "a list came that is none of studies".to_owned();
            return Err(Error::NoArchive { server: self.address().to_owned(), why });
        }
        Ok(all)
    }

    /// Days as DICOM has them (PS3.4, C.2.2.2.5).
    fn days(&self, text: &str) -> Result<String, Error> {
        let wrong = || Error::Days { days: text.to_owned() };
        // A day has eight digits, two of them are a range; of dashes only one before or after a single day counts.
        let compact: String = text.split_whitespace().collect();
        let digits: String = compact.chars().filter(|letter| *letter != '-').collect();
        if !digits.bytes().all(|byte| byte.is_ascii_digit()) || !matches!(digits.len(), 8 | 16) {
            return Err(wrong());
        }
        let days: Vec<&str> = [0, 8].iter().filter_map(|at| digits.get(*at..at + 8)).collect();
        if days.iter().any(|day| !is_day(day)) {
            return Err(wrong());
        }
        Ok(match days[..] {
            [first, last] => format!("{first}-{last}"),
            [day] if compact.starts_with('-') => format!("-{day}"),
            [day] if compact.ends_with('-') => format!("{day}-"),
            _ => digits.clone(),
        })
    }
}

/// Whether eight digits may be a day.
fn is_day(digits: &str) -> bool {
    let part = |from: usize, to: usize| digits.get(from..to).and_then(|part| part.parse::<u32>().ok());
    part(4, 6).is_some_and(|month| (1..=12).contains(&month))
        && part(6, 8).is_some_and(|day| (1..=31).contains(&day))
}

fn study(of: &Attributes<'_>) -> Option<StudyEntry> {
    let mut modalities = of.texts("00080061");
    modalities.dedup();
    Some(StudyEntry {
        uid: Uid::new(&of.text("0020000D"))?,
        patient: of.text("00100010"),
        patient_id: of.text("00100020"),
        day: day(&of.text("00080020")),
        description: of.text("00081030"),
        modalities,
        series: of.number("00201206"),
        images: of.number("00201208"),
    })
}

fn series(of: &Attributes<'_>) -> Option<SeriesEntry> {
    Some(SeriesEntry {
        uid: Uid::new(&of.text("0020000E"))?,
        number: of.number("00200011"),
        description: of.text("0008103E"),
        modality: of.text("00080060"),
        images: of.number("00201209"),
    })
}

/// A day as people write it; what is none stays as it is.
fn day(text: &str) -> String {
    match (text.get(..4), text.get(4..6), text.get(6..8)) {
        (Some(year), Some(month), Some(day)) if text.len() == 8 && is_day(text) => {
            format!("{year}-{month}-{day}")
        }
        _ => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::server::Login;

    #[test]
    fn days_are_taken_as_people_write_them() {
        let server = Server::new("http://localhost/dicom-web", Login::Nobody).unwrap();
        for (text, wanted) in [
            ("2026-01-31", "20260131"),
            ("20260131", "20260131"),
            ("2026-01-01 - 2026-01-31", "20260101-20260131"),
            ("20260101-20260131", "20260101-20260131"),
            ("2026-01-01 -", "20260101-"),
            ("- 2026-01-31", "-20260131"),
        ] {
            assert_eq!(server.days(text).unwrap(), wanted, "{text}");
        }
        for wrong in ["yesterday", "2026", "2026-13-01", "2026-01-32", "31.01.2026", "2026-01-01 - 2026"] {
            assert!(matches!(server.days(wrong), Err(Error::Days { .. })), "{wrong}");
        }
    }

    #[test]
    fn an_identifier_is_no_path() {
        assert_eq!(Uid::new("1.2.840.10008").unwrap().to_string(), "1.2.840.10008");
        for wrong in ["", ".", "..", "1..2", "1.2.", "../1", "1/2", "1.2?x=1", "1.2a", &"1".repeat(65)] {
            assert!(Uid::new(wrong).is_none(), "{wrong}");
        }
    }
}
