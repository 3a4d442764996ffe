//! Servers that are no archives, break off, or lie.

use std::fs;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::thread;

use lumivox_core::{CancelToken, Progress};
use lumivox_dicomweb::{Error, Filter, Login, SeriesEntry, Server, Uid};

/// Answers everybody with the same bytes, and remembers what was asked.
struct Odd {
    address: String,
    asked: Arc<Mutex<Vec<String>>>,
}

fn odd(answers: &[&[u8]]) -> Odd {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("http://{}/rs", listener.local_addr().unwrap());
    let (asked, answers) =
        (Arc::new(Mutex::new(vec![])), answers.iter().map(|bytes| bytes.to_vec()).collect::<Vec<_>>());
    let kept = asked.clone();
    thread::spawn(move || {
        for (place, stream) in listener.incoming().enumerate() {
            let Ok(mut stream) = stream else { continue };
            kept.lock().unwrap().push(request(&mut stream));
            let _ = stream.write_all(&answers[place.min(answers.len() - 1)]);
        }
    });
    Odd { address, asked }
}

fn request(stream: &mut TcpStream) -> String {
    let mut bytes = vec![];
    let mut next = [0];
    while !bytes.ends_with(b"\r\n\r\n") && stream.read(&mut next).is_ok_and(|read| read == 1) {
        bytes.push(next[0]);
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

fn ok(kind: &str, body: &[u8]) -> Vec<u8> {
    let head = format!("HTTP/1.1 200 OK\r\nContent-Type: {kind}\r\nConnection: close\r\n\r\n");
    [head.as_bytes(), body].concat()
}

fn studies(answer: &[u8]) -> Result<usize, Error> {
    let odd = odd(&[answer]);
    Server::new(&odd.address, Login::Nobody).unwrap().studies(&Filter::default()).map(|all| all.found.len())
}

#[test]
fn what_is_no_list_of_studies_is_refused_in_words() {
    for (answer, wanted) in [
        (ok("text/html", b"<html>Welcome</html>"), "a page for people"),
        (ok("application/json", b"{\"status\": 1}"), "no list came"),
        (ok("application/json", b"[\"6b9e19d9\"]"), "none of studies"),
        (ok("application/json", b"[{\"name\": \"x\"}]"), "none of studies"),
        (ok("application/json", b"hello"), "no JSON"),
        (ok("application/dicom+json", b"[{\"0020000D\": {\"vr\""), "has no end"),
        (
            b"HTTP/1.1 500 Oops\r\nContent-Length: 22\r\n\r\nthe disk\n is full\0\x1b[2J".to_vec(),
            "(HTTP 500): the disk is full",
        ),
        (b"HTTP/1.1 503 Busy\r\nContent-Length: 6\r\n\r\n<html>".to_vec(), "(HTTP 503)"),
        (
            b"HTTP/1.1 302 Found\r\nLocation: /rs/studies\r\nContent-Length: 0\r\n\r\n".to_vec(),
            "sends on and on",
        ),
        (b"SSH-2.0-OpenSSH_9.2\r\n".to_vec(), "cannot be reached"),
        (b"".to_vec(), "cannot be reached"),
        (
            b"HTTP/1.1 200 OK\r\nContent-Type: application/dicom+json\r\nContent-Length: 900\r\n\r\n["
                .to_vec(),
            "in the middle",
        ),
    ] {
        let error = studies(&answer).unwrap_err().to_string();
        assert!(error.contains(wanted), "{wanted}: {error}");
        assert!(!error.contains('\x1b'), "{error:?}");
    }
    assert_eq!(studies(b"HTTP/1.1 204 No Content\r\n\r\n").unwrap(), 0);
    assert_eq!(studies(&ok("application/dicom+json", b" \n")).unwrap(), 0);
    // An identifier that is a path is none.
    let path = br#"[{"0020000D": {"vr": "UI", "Value": ["../../etc"]}}, {"0020000D": {"vr": "UI", "Value": ["1.2"]}}]"#;
    assert_eq!(studies(&ok("application/dicom+json", path)).unwrap(), 1);
}

#[test]
fn an_archive_that_knows_no_limit_is_cut() {
    let study = |i| format!(r#"{{"0020000D": {{"vr": "UI", "Value": ["1.2.{i}"]}}}}"#);
    let all = format!("[{}]", (1..=150).map(study).collect::<Vec<_>>().join(","));
    let odd = odd(&[&ok("application/dicom+json", all.as_bytes())]);
    let found = Server::new(&odd.address, Login::Nobody).unwrap().studies(&Filter::default()).unwrap();
    assert_eq!((found.found.len(), found.has_more), (100, true));
}

#[test]
fn nobody_there_is_said() {
    // Of this machine, and no port that others are given.
    let address = "http://127.0.0.1:1/rs".to_owned();
    let error = Server::new(&address, Login::Nobody).unwrap().studies(&Filter::default()).unwrap_err();
    assert!(matches!(error, Error::Unreachable { .. }), "{error}");
}

#[test]
fn what_is_no_tls_is_not_trusted_and_gets_no_password() {
    // It answers whatever comes, at once: no line ends in what TLS begins with.
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("https://{}/rs", listener.local_addr().unwrap());
    let server = thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        stream.write_all(b"HTTP/1.1 200 OK\r\nConnection: close\r\n\r\n[]").unwrap();
        let mut asked = vec![0; 4096];
        let read = stream.read(&mut asked).unwrap();
        asked.truncate(read);
        asked
    });
    let login = Login::Password { name: "doctor".into(), password: "secret".into() };
    let error = Server::new(&address, login).unwrap().studies(&Filter::default()).unwrap_err();
    assert!(matches!(error, Error::Untrusted { .. }), "{error}");
    let asked = server.join().unwrap();
    assert!(!asked.is_empty() && !String::from_utf8_lossy(&asked).to_lowercase().contains("authorization"));
}

#[test]
fn nobody_else_is_told_who_is_looked_for() {
    let other = odd(&[&ok("application/dicom+json", b"[]")]);
    let first = odd(&[&sends_on(&format!("{}/studies?PatientName=Doe*", other.address))]);
    let login = Login::Password { name: "doctor".into(), password: "secret".into() };
    let filter = Filter { patient: "Doe".into(), ..Filter::default() };
    let error = Server::new(&first.address, login.clone()).unwrap().studies(&filter).unwrap_err();
    assert!(matches!(&error, Error::Elsewhere { .. }), "{error}");
    assert!(error.to_string().contains(&other.address) && !error.to_string().contains("Doe"), "{error}");
    let asked = first.asked.lock().unwrap().join("").to_lowercase();
    assert!(asked.contains("authorization: basic") && asked.contains("patientname=doe"), "{asked}");
    assert_eq!(other.asked.lock().unwrap().len(), 0);
    // Within itself it may.
    let within = odd(&[&sends_on("/elsewhere/studies?x=1"), &ok("application/dicom+json", b"[]")]);
    assert_eq!(
        Server::new(&within.address, login).unwrap().studies(&Filter::default()).unwrap().found.len(),
        0
    );
    let asked = within.asked.lock().unwrap();
    assert!(
        asked[1].starts_with("GET /elsewhere/studies?x=1 ")
            && asked[1].to_lowercase().contains("authorization"),
        "{asked:?}"
    );
}

fn sends_on(to: &str) -> Vec<u8> {
    format!("HTTP/1.1 307 Elsewhere\r\nLocation: {to}\r\nContent-Length: 0\r\nConnection: close\r\n\r\n")
        .into_bytes()
}

#[test]
fn who_knows_no_patterns_is_asked_once_more() {
    let one = br#"[{"0020000D": {"vr": "UI", "Value": ["1.2"]}}]"#;
    let odd = odd(&[&ok("application/dicom+json", b"[]"), &ok("application/dicom+json", one)]);
    let filter = Filter { patient: "Doe, Jane".into(), ..Filter::default() };
    let found = Server::new(&odd.address, Login::Nobody).unwrap().studies(&filter).unwrap();
    assert_eq!(found.found.len(), 1);
    let asked = odd.asked.lock().unwrap();
    assert!(
        asked[0].contains("PatientName=Doe%5EJane*") || asked[0].contains("PatientName=Doe^Jane*"),
        "{asked:?}"
    );
    assert!(asked[1].contains("fuzzymatching=true") && !asked[1].contains("Jane*"), "{asked:?}");
}

#[test]
fn an_archive_says_that_there_are_more() {
    let one = r#"[{"0020000D": {"vr": "UI", "Value": ["1.2"]}}]"#;
    for (line, has_more) in [
        ("Warning: 299 a: \"There are 7 additional results that can be requested\"\r\n", true),
        ("Warning: 299 a: \"The fuzzymatching parameter is not supported\"\r\n", false),
    ] {
        let answer = format!("HTTP/1.1 200 OK\r\n{line}Connection: close\r\n\r\n{one}");
        let odd = odd(&[answer.as_bytes()]);
        let found = Server::new(&odd.address, Login::Nobody).unwrap().studies(&Filter::default()).unwrap();
        assert_eq!((found.found.len(), found.has_more), (1, has_more), "{line}");
    }
}

/// Fetches a series from such a server; what was left there.
fn fetch(answers: &[&[u8]]) -> (Result<Vec<Vec<u8>>, Error>, usize, Vec<String>) {
    let (odd, into) = (odd(answers), tempfile::tempdir().unwrap());
    let server = Server::new(&odd.address, Login::Nobody).unwrap();
    let (study, series) = (Uid::new("1.2").unwrap(), crate::series("1.2.3"));
    let fetched = server.fetch(&study, &series, into.path(), Progress::SILENT, &CancelToken::new());
    let read = fetched.map(|folder| {
        let mut files: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        files.sort();
        files.iter().map(|file| fs::read(file).unwrap()).collect()
    });
    let left = fs::read_dir(into.path()).unwrap().count();
    let asked = odd.asked.lock().unwrap().clone();
    (read, left, asked)
}

const RELATED: &str = r#"multipart/related; type="application/dicom"; boundary="x y""#;

#[test]
fn images_come_in_every_form_that_servers_give_them() {
    let two = b"--x y\r\nContent-Type: application/dicom\r\n\r\none\r\n--x y\r\n\r\n\r\n--x\r\n--x y--";
    assert_eq!(fetch(&[&ok(RELATED, two)]).0.unwrap(), [b"one".to_vec(), b"\r\n--x".to_vec()]);
    assert_eq!(fetch(&[&ok("application/dicom", b"alone")]).0.unwrap(), [b"alone".to_vec()]);
    // A server that does not know how to give them as they are stored.
    let (read, _, asked) =
        fetch(&[b"HTTP/1.1 406 No\r\nContent-Length: 0\r\nConnection: close\r\n\r\n", &ok(RELATED, two)]);
    assert_eq!(read.unwrap().len(), 2);
    assert!(asked[0].contains("transfer-syntax=*") && !asked[1].contains("transfer-syntax"), "{asked:?}");
}

#[test]
fn images_that_break_off_leave_nothing() {
    let cut = b"--x y\r\n\r\none\r\n--x y\r\n\r\ntw";
    for (answer, wanted) in [
        (ok(RELATED, cut), "have no end"),
        (ok(RELATED, b""), "have no end"),
        (ok(RELATED, b"--x y--"), "no images"),
        (ok("text/html", b"<html>"), "came instead of images"),
        (ok("multipart/related", b"--x--"), "came instead of images"),
        (ok("application/dicom+json", b"[]"), "came instead of images"),
        (ok("multipart/mixed; boundary=x", b"--x\r\n\r\n1\r\n--x--"), "came instead of images"),
        (ok(RELATED, b"--x y\r\nContent-Type: text/plain\r\n\r\nno\r\n--x y--"), "no images"),
        (
            b"HTTP/1.1 206 Part\r\nContent-Type: application/dicom\r\nConnection: close\r\n\r\none".to_vec(),
            "1 of more images",
        ),
        (b"HTTP/1.1 204 No Content\r\n\r\n".to_vec(), "no images"),
        (b"HTTP/1.1 404 Gone\r\nContent-Length: 0\r\n\r\n".to_vec(), "no images"),
        (
            [
                b"HTTP/1.1 200 OK\r\nContent-Type: ".to_vec(),
                RELATED.as_bytes().to_vec(),
                b"\r\nTransfer-Encoding: chunked\r\n\r\nzz\r\n".to_vec(),
            ]
            .concat(),
            "in the middle",
        ),
    ] {
        let (read, left, _) = fetch(&[&answer]);
        let error = read.unwrap_err().to_string();
        assert!(error.contains(wanted), "{wanted}: {error}");
        assert_eq!(left, 0, "{error}");
    }
}

#[test]
fn a_series_that_lacks_images_does_not_come() {
    let (odd, into) = (odd(&[&ok("application/dicom", b"alone")]), tempfile::tempdir().unwrap());
    let server = Server::new(&odd.address, Login::Nobody).unwrap();
    let series = SeriesEntry { images: Some(2), ..crate::series("1.2.3") };
    let study = Uid::new("1.2").unwrap();
    let error =
        server.fetch(&study, &series, into.path(), Progress::SILENT, &CancelToken::new()).unwrap_err();
    assert!(error.to_string().contains("gave 1 of 2 images"), "{error}");
    assert_eq!(fs::read_dir(into.path()).unwrap().count(), 0);
}

#[test]
fn a_place_that_cannot_be_written_is_named() {
    let file = tempfile::NamedTempFile::new().unwrap();
    let odd = odd(&[&ok("application/dicom", b"alone")]);
    let server = Server::new(&odd.address, Login::Nobody).unwrap();
    let into = file.path().join("scans");
    let error = server
        .fetch(
            &Uid::new("1.2").unwrap(),
            &crate::series("1.2.3"),
            &into,
            Progress::SILENT,
            &CancelToken::new(),
        )
        .unwrap_err();
    assert!(matches!(error, Error::Disk { .. }) && error.to_string().contains("scans"), "{error}");
}
