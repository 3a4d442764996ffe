//! Archives as they are: Orthanc, and servers that are none, or break off, or lie.

mod archive;
mod odd_servers;

use lumivox_dicomweb::{SeriesEntry, Uid};

/// A series of which nothing but the identifier is known.
fn series(uid: &str) -> SeriesEntry {
    SeriesEntry {
        uid: Uid::new(uid).unwrap(),
        number: None,
        description: String::new(),
        modality: String::new(),
        images: None,
    }
}
