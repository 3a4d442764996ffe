//! Asks archives of hospitals for studies, and fetches them: a client of DICOMweb (DICOM PS3.18), which has searches (QIDO-RS, 10.6)
//! and retrieval (WADO-RS, 10.4). Nothing is ever stored or changed on a server.
//!
//! ```no_run
//! # use lumivox_core::{CancelToken, Progress};
//! # use lumivox_dicomweb::{Filter, Login, Server};
//! # use std::path::Path;
//! let server = Server::new("http://localhost:8042/dicom-web", Login::Nobody)?;
//! let studies = server.studies(&Filter { patient: "Doe".into(), ..Filter::default() })?;
//! let series = server.series(&studies.found[0].uid)?;
//! let (into, never) = (Path::new("scans"), CancelToken::new());
//! let folder = server.fetch(&studies.found[0].uid, &series[0], into, Progress::SILENT, &never)?;
//! # Ok::<(), lumivox_dicomweb::Error>(())
//! ```
//!
//! Calls wait for the server: they belong on a thread of their own. No error names a patient, and none a password.

mod attributes;
mod error;
mod fetch;
mod multipart;
mod query;
mod server;

pub use error::Error;
pub use query::{Filter, SeriesEntry, Studies, StudyEntry, Uid};
pub use server::{Login, Server};
