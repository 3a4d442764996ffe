//! What goes wrong between a person and an archive, in words that say what to do.

use std::io;
use std::path::PathBuf;

use lumivox_core::Cancelled;

/// Why an archive did not answer, or not with what was asked.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// What was given as an address is none.
    #[error(
        "'{address}' is no address of an archive: {why}. One looks like https://archive.example.org/dicom-web"
    )]
    Address {
        /// What was given.
        address: String,
        /// What is wrong with it.
        why: &'static str,
    },
    /// Days of which none is asked for.
    #[error("'{days}' is no day and no range of days; they look like 2026-01-31 and 2026-01-01 - 2026-01-31")]
    Days {
        /// What was given.
        days: String,
    },
    /// Nobody answers there.
    #[error("{server} cannot be reached: {why}")]
    Unreachable {
        /// The address.
        server: String,
        /// What the system says.
        why: String,
    },
    /// Its certificate is not trusted by this system.
    #[error(
        "{server} cannot be trusted: {why}. Where it has a certificate of the hospital's own, this system has to know who issues those"
    )]
    Untrusted {
        /// The address.
        server: String,
        /// What is wrong with it.
        why: String,
    },
    /// It wants to know who asks, or does not let them.
    #[error("{server} does not let you in (HTTP {status}): check the name and the password, or the token")]
    Login {
        /// The address.
        server: String,
        /// 401 or 403.
        status: u16,
    },
    /// It answers, and not as an archive does.
    #[error(
        "{server} answers, but not as DICOMweb does: {why}. Is the path missing? It is often /dicom-web (Orthanc), /dcm4chee-arc/aets/NAME/rs (dcm4chee) or /dicomweb"
    )]
    NoArchive {
        /// The address.
        server: String,
        /// What came instead.
        why: String,
    },
    /// It refuses.
    #[error("{server} refuses (HTTP {status}){words}")]
    Refused {
        /// The address.
        server: String,
        /// HTTP's status.
        status: u16,
        /// The beginning of what it says, after a colon; empty where it says nothing.
        words: String,
    },
    /// There is no such study or series any more, or it has no images.
    #[error("{server} has no images of this series (any more)")]
    Nothing {
        /// The address.
        server: String,
    },
    /// It has more images than it gave.
    #[error("{server} gave {got} of {of} images of this series. Try again, or ask whoever runs it")]
    Incomplete {
        /// The address.
        server: String,
        /// Images that came.
        got: u64,
        /// Images that it has: those that it told of before, or `more`.
        of: String,
    },
    /// It sends whoever asks to another machine, or to where others can read along. Nobody is told there who is looked for.
    #[error("{server} sends on to {to}. If that is right, ask there: write that address")]
    Elsewhere {
        /// The address.
        server: String,
        /// Where to, without what was asked.
        to: String,
    },
    /// An answer that ends before its end.
    #[error("{server} stopped in the middle: {why}. Try again")]
    Cut {
        /// The address.
        server: String,
        /// What is missing.
        why: String,
    },
    /// Images cannot be kept.
    #[error("{}: {error}", path.display())]
    Disk {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        error: io::Error,
    },
    /// It was asked to end.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
