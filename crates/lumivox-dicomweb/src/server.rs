//! An archive's address, who asks it, and what it says at all.

use std::sync::Arc;
use std::time::Duration;

use base64::prelude::{BASE64_STANDARD, Engine};
use ureq::http::header::{ACCEPT, AUTHORIZATION, LOCATION};
use ureq::http::{Response, Uri};
use ureq::tls::{RootCerts, TlsConfig, TlsProvider};
use ureq::{Agent, Body};

use crate::error::Error;

/// Who is not there after this does not come.
const CONNECT: Duration = Duration::from_secs(10);
/// For a list, and between two pieces of images.
pub const SILENCE: Duration = Duration::from_secs(60);
/// Until images begin to come: some archives fetch them from tape.
pub const PATIENCE: Duration = Duration::from_secs(600);
/// Who sends on more often sends in a circle.
const MOST_TURNS: usize = 5;
/// Of what a server says in its refusal so much is shown.
const MOST_WORDS: usize = 200;

/// Who asks.
#[derive(Clone, Default, PartialEq, Eq)]
pub enum Login {
    /// Nobody in particular.
    #[default]
    Nobody,
    /// A name and a password (RFC 7617).
    Password {
        /// The name.
        name: String,
        /// The password.
        password: String,
    },
    /// A token that some other service gave (RFC 6750).
    Token(String),
}

// Whatever prints one prints no secret.
impl std::fmt::Debug for Login {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str(match self {
            Self::Nobody => "Nobody",
            Self::Password { .. } => "Password",
            Self::Token(_) => "Token",
        })
    }
}

/// An archive.
#[derive(Clone, Debug)]
pub struct Server {
    address: String,
    login: Login,
    agent: Agent,
}

impl Server {
    /// One at an address, such as `https://archive.example.org/dicom-web`. Without `http://` it is taken for `https://`. It is not
    /// asked for anything yet.
    ///
    /// # Errors
    /// [`Error::Address`].
    pub fn new(address: &str, login: Login) -> Result<Self, Error> {
        let wrong = |why| Error::Address { address: without_secret(address), why };
        let (scheme, rest) = address.trim().split_once("://").unwrap_or(("https", address.trim()));
        if !matches!(scheme, "http" | "https") {
            return Err(wrong("it begins neither with http:// nor with https://"));
        }
        let address = format!("{scheme}://{}", rest.trim_end_matches('/'));
        // As it stands in a browser that shows its list.
        let address = address.strip_suffix("/studies").unwrap_or(&address).to_owned();
        let uri: Uri =
            address.parse().map_err(|_| wrong("it has letters that no address has, or no name"))?;
        let authority = uri.authority().ok_or_else(|| wrong("it has no name"))?;
        if authority.as_str().contains('@') {
            return Err(wrong("name and password do not belong into it"));
        }
        if uri.query().is_some() || address.contains('#') {
            return Err(wrong("it goes on after its path"));
        }
        if authority.host().is_empty() {
            return Err(wrong("it has no name"));
        }
        Ok(Self { agent: agent(authority.host()), address, login })
    }

    /// Its address.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Whether whoever is in between reads what is sent: patients and passwords. Within this machine nobody is.
    pub fn is_open_to_readers(&self) -> bool {
        let host = self.address.parse::<Uri>().ok().and_then(|uri| uri.host().map(str::to_owned));
        self.address.starts_with("http://") && !is_here(&host.unwrap_or_default())
    }

    /// Asks for something, with the kinds of answer that are wanted, the best first: the next is asked for where a server does
    /// not know the one before.
    pub(crate) fn get(
        &self,
        what: &str,
        query: &[(&str, String)],
        kinds: &[&str],
        patience: Duration,
    ) -> Result<Response<Body>, Error> {
        let mut last = None;
        for kind in kinds {
            let answer = self.ask(what, query, kind, patience)?;
            match answer.status().as_u16() {
                200..=299 => return Ok(answer),
                // Not this kind, or a form of it that is not understood.
                400 | 406 | 415 => last = Some(answer),
                _ => return Err(self.refused(answer)),
            }
        }
        Err(last.map_or_else(|| self.cut("nothing was asked"), |answer| self.refused(answer)))
    }

    /// Asks once, and where the archive sends on within itself.
    fn ask(
        &self,
        what: &str,
        query: &[(&str, String)],
        kind: &str,
        patience: Duration,
    ) -> Result<Response<Body>, Error> {
        let mut address = format!("{}/{what}", self.address);
        for turn in 0..=MOST_TURNS {
            let mut request = self.agent.get(&address).header(ACCEPT, kind);
            // Who sends on says all of it.
            for (name, value) in query.iter().filter(|_| turn == 0) {
                request = request.query(name, value);
            }
            if let Some(credentials) = self.credentials() {
                request = request.header(AUTHORIZATION, credentials);
            }
            let request = request.config().timeout_recv_response(Some(patience)).build();
            let answer = request.call().map_err(|error| self.unreachable(error))?;
            if !matches!(answer.status().as_u16(), 301 | 302 | 303 | 307 | 308) {
                return Ok(answer);
            }
            let to = answer.headers().get(LOCATION).and_then(|to| to.to_str().ok()).unwrap_or_default();
            address = self.sent_on(&address, to)?;
        }
        let server = self.address.clone();
        Err(Error::Unreachable { server, why: "it sends on and on".to_owned() })
    }

    /// Where the archive sends to, if that is itself, by the same way or one that nobody reads along.
    fn sent_on(&self, from: &str, to: &str) -> Result<String, Error> {
        let no = |to: &str| {
            let to = to.split(['?', '#']).next().unwrap_or_default().to_owned();
            Error::Elsewhere { server: self.address.clone(), to: without_secret(&to) }
        };
        let parse = |address: &str| address.parse::<Uri>().ok();
        let own = parse(from).ok_or_else(|| no(to))?;
        let (scheme, authority) =
            (own.scheme_str().unwrap_or_default(), own.authority().map_or("", |own| own.as_str()));
        // Within the archive.
        if to.starts_with('/') && !to.starts_with("//") {
            return Ok(format!("{scheme}://{authority}{to}"));
        }
        let other = parse(to).ok_or_else(|| no(to))?;
        let is_same = other.scheme_str() == Some(scheme) && other.authority() == own.authority();
        let is_safer = scheme == "http" && other.scheme_str() == Some("https") && other.host() == own.host();
        let has_names = other.authority().is_some_and(|other| other.as_str().contains('@'));
        if (is_same || is_safer) && !has_names { Ok(to.to_owned()) } else { Err(no(to)) }
    }

    fn credentials(&self) -> Option<String> {
        match &self.login {
            Login::Nobody => None,
            Login::Password { name, password } => {
                Some(format!("Basic {}", BASE64_STANDARD.encode(format!("{name}:{password}"))))
            }
            Login::Token(token) => Some(format!("Bearer {}", token.trim())),
        }
    }

    fn refused(&self, mut answer: Response<Body>) -> Error {
        let (server, status) = (self.address.clone(), answer.status().as_u16());
        match status {
            401 | 403 => return Error::Login { server, status },
            404 | 410 => {
                return Error::NoArchive { server, why: format!("there is nothing there (HTTP {status})") };
            }
            _ => {}
        }
        let text = answer.body_mut().with_config().limit(64 << 10).lossy_utf8(true).read_to_string();
        let text = text.unwrap_or_default();
        // A page of HTML says nothing to a person as text.
        let is_text = !text.trim_start().starts_with('<');
        let line: String = text.split_whitespace().collect::<Vec<_>>().join(" ");
        let line: String = line.chars().filter(|letter| !letter.is_control()).take(MOST_WORDS).collect();
        let words = if is_text && !line.is_empty() { format!(": {line}") } else { String::new() };
        Error::Refused { server, status, words }
    }

    /// An answer that has no end.
    pub(crate) fn cut(&self, why: &str) -> Error {
        Error::Cut { server: self.address.clone(), why: why.to_owned() }
    }

    fn unreachable(&self, error: ureq::Error) -> Error {
        let server = self.address.clone();
        let why = match error {
            ureq::Error::HostNotFound => "no machine of that name is known".to_owned(),
            ureq::Error::Timeout(_) => "it does not answer in time".to_owned(),
            ureq::Error::Rustls(error) => return Error::Untrusted { server, why: error.to_string() },
            ureq::Error::Tls(why) => return Error::Untrusted { server, why: why.to_owned() },
            // What rustls says comes as an error of reading.
            ureq::Error::Io(error) => {
                match error.get_ref().and_then(|inner| inner.downcast_ref::<rustls::Error>()) {
                    Some(inner) => return Error::Untrusted { server, why: inner.to_string() },
                    None => error.to_string(),
                }
            }
            other => other.to_string(),
        };
        Error::Unreachable { server, why }
    }
}

/// Asks in the ways that all requests have in common.
fn agent(host: &str) -> Agent {
    let tls = TlsConfig::builder()
        .provider(TlsProvider::Rustls)
        .unversioned_rustls_crypto_provider(Arc::new(rustls::crypto::ring::default_provider()))
        .root_certs(RootCerts::PlatformVerifier)
        .build();
    let config = Agent::config_builder()
        .tls_config(tls)
        .http_status_as_error(false)
        .user_agent(concat!("lumivox/", env!("CARGO_PKG_VERSION")))
        // Where it sends on is looked at before.
        .max_redirects(0)
        .max_redirects_will_error(false)
        // Between two questions a person thinks, and many servers hang up after a second: one that was kept would be found closed.
        .max_idle_connections(0)
        .max_idle_connections_per_host(0)
        .timeout_resolve(Some(CONNECT))
        .timeout_connect(Some(CONNECT))
        .timeout_per_read(Some(SILENCE));
    // A proxy does not know what this machine calls itself.
    let config = if is_here(host) { config.proxy(None) } else { config };
    config.build().new_agent()
}

/// Whether a host is this machine.
fn is_here(host: &str) -> bool {
    let host = host.trim_matches(['[', ']']);
    host == "localhost" || host.parse::<std::net::IpAddr>().is_ok_and(|address| address.is_loopback())
}

/// An address as it may be shown: a password that stands in it is left out.
fn without_secret(address: &str) -> String {
    match address.rsplit_once('@') {
        Some((_, host)) => format!("...@{host}"),
        None => address.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_taken_as_people_have_them() {
        let of = |text: &str| Server::new(text, Login::Nobody).map(|server| server.address().to_owned());
        for (text, wanted) in [
            ("https://a.example.org/dicom-web", "https://a.example.org/dicom-web"),
            (" http://localhost:8042/dicom-web/ ", "http://localhost:8042/dicom-web"),
            ("a.example.org/rs", "https://a.example.org/rs"),
            ("http://[::1]:8042/dicom-web/studies", "http://[::1]:8042/dicom-web"),
        ] {
            assert_eq!(of(text).unwrap(), wanted);
        }
        for wrong in ["", "ftp://a", "https://", "http://a b/", "https://a/rs?x=1", "https://a/rs#top"] {
            assert!(matches!(of(wrong), Err(Error::Address { .. })), "{wrong}");
        }
    }

    #[test]
    fn no_error_shows_a_password() {
        let error = Server::new("https://doctor:secret@archive/rs", Login::Nobody).unwrap_err().to_string();
        assert!(!error.contains("secret") && error.contains("archive/rs"), "{error}");
        let login = Login::Password { name: "doctor".into(), password: "secret".into() };
        assert!(!format!("{:?}", Server::new("https://archive/rs", login).unwrap()).contains("secret"));
    }

    #[test]
    fn who_may_read_along_is_known() {
        for (address, is_open) in [
            ("http://archive/rs", true),
            ("https://archive/rs", false),
            ("http://localhost:8042/rs", false),
            ("http://127.0.0.1/rs", false),
            ("http://[::1]:80/rs", false),
        ] {
            assert_eq!(
                Server::new(address, Login::Nobody).unwrap().is_open_to_readers(),
                is_open,
                "{address}"
            );
        }
    }

    #[test]
    fn it_sends_on_within_itself_alone() {
        let to = |address: &str, to: &str| {
            let server = Server::new(address, Login::Nobody).unwrap();
            server.sent_on(&format!("{address}/studies"), to).map_err(|error| error.to_string())
        };
        let (open, closed) = ("http://a:80/rs", "https://a/rs");
        assert_eq!(to(open, "/other/studies?x=1").unwrap(), "http://a:80/other/studies?x=1");
        assert_eq!(to(open, "https://a/rs/studies?x=1").unwrap(), "https://a/rs/studies?x=1");
        assert_eq!(to(closed, "https://a/rs2/studies").unwrap(), "https://a/rs2/studies");
        for (from, other) in [
            (closed, "http://a/rs/studies?PatientName=Doe"),
            (closed, "https://b/rs/studies?PatientName=Doe"),
            (closed, "https://a:8443/rs/studies?PatientName=Doe"),
            (closed, "//b/rs?PatientName=Doe"),
            (closed, "https://doctor:secret@a/rs"),
            (open, "http://a:81/rs"),
            (closed, ""),
            (closed, "studies"),
        ] {
            let error = to(from, other).unwrap_err();
            assert!(
                error.contains("sends on") && !error.contains("Doe") && !error.contains("secret"),
                "{error}"
            );
        }
    }
}
