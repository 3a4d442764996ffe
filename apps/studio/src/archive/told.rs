//! What goes wrong with an archive, in the language of whoever reads it.

use lumivox_dicomweb::Error;

use crate::words::Language;

/// Reasons that the client of archives finds by itself.
pub const REASONS: [(&str, &str); 13] = [
    ("it begins neither with http:// nor with https://", "sie beginnt weder mit http:// noch mit https://"),
    (
        "it has letters that no address has, or no name",
        "sie hat Zeichen, die keine Adresse hat, oder keinen Namen",
    ),
    ("it has no name", "sie hat keinen Namen"),
    ("name and password do not belong into it", "Name und Passwort gehören nicht hinein"),
    ("it goes on after its path", "sie geht nach ihrem Pfad weiter"),
    ("no machine of that name is known", "kein Rechner dieses Namens ist bekannt"),
    ("it does not answer in time", "es antwortet nicht rechtzeitig"),
    ("it sends on and on", "es verweist immer weiter"),
    ("a page for people came", "es kam eine Seite für Menschen"),
    ("no list came", "es kam keine Liste"),
    ("a list came that is none of studies", "es kam eine Liste, aber keine von Studien"),
    ("the list has no end", "die Liste hat kein Ende"),
    ("the images have no end", "die Bilder haben kein Ende"),
];

/// A sentence, or two. What a server or the system says of it stays in theirs.
pub fn words(error: &Error, language: Language) -> String {
    match language {
        Language::English => error.to_string(),
        Language::German => german(error),
    }
}

fn german(error: &Error) -> String {
    match error {
        Error::Address { address, why } => format!(
            "„{address}“ ist keine Adresse eines Archivs: {}. Eine sieht so aus: https://archive.example.org/dicom-web",
            reason(why)
        ),
        Error::Days { days } => format!(
            "„{days}“ ist weder ein Tag noch ein Zeitraum; sie sehen so aus: 2026-01-31 und 2026-01-01 - 2026-01-31"
        ),
        Error::Unreachable { server, why } => format!("{server} ist nicht zu erreichen: {}", reason(why)),
        Error::Untrusted { server, why } => format!(
            "{server} ist nicht zu trauen: {why}. Hat es ein Zertifikat des Krankenhauses, muss dieses System wissen, wer die ausstellt"
        ),
        Error::Login { server, status } => {
            format!(
                "{server} lässt Sie nicht ein (HTTP {status}): Bitte Name und Passwort prüfen, oder das Token"
            )
        }
        Error::NoArchive { server, why } => format!(
            "{server} antwortet, aber nicht wie DICOMweb: {}. Fehlt der Pfad? Oft ist er /dicom-web (Orthanc), /dcm4chee-arc/aets/NAME/rs (dcm4chee) oder /dicomweb",
            reason(why)
        ),
        Error::Refused { server, status, words } => format!("{server} lehnt ab (HTTP {status}){words}"),
        Error::Nothing { server } => format!("{server} hat keine Bilder dieser Serie (mehr)"),
        Error::Incomplete { server, got, of } => {
            let of = if of == "more" { "mehr" } else { of };
            format!(
                "{server} gab {got} von {of} Bildern dieser Serie. Bitte erneut versuchen, oder fragen, wer es betreibt"
            )
        }
        Error::Elsewhere { server, to } => {
            format!("{server} verweist auf {to}. Stimmt das, bitte dort fragen: diese Adresse eintragen")
        }
        Error::Cut { server, why } => {
            format!("{server} brach mittendrin ab: {}. Bitte erneut versuchen", reason(why))
        }
        other => other.to_string(),
    }
}

/// A reason that the client of archives found by itself, or a system's own words.
fn reason(why: &str) -> &str {
    REASONS.iter().find(|(english, _)| *english == why).map_or(why, |(_, german)| german)
}
