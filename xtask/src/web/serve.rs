//! Static files by HTTP, to this machine alone.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::{Component, Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

/// Serves a folder, below `/studio/` and at `/`, until the program is ended; says where.
pub fn serve(folder: &Path, port: u16) -> Result<(), String> {
    let served = Served::of(folder)?;
    let (listener, address) = listen(port)?;
    println!("It is at {address}\nCtrl+C ends it.");
    answer_all(&listener, &Arc::new(served));
    Ok(())
}

/// A port of this machine, any free one for 0; its address.
pub fn listen(port: u16) -> Result<(TcpListener, String), String> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))
        .map_err(|error| format!("cannot serve at 127.0.0.1:{port}: {error}; name another port"))?;
    let port = listener.local_addr().map_err(|error| error.to_string())?.port();
    Ok((listener, format!("http://127.0.0.1:{port}/")))
}

/// The page's folder, and what is said with each of its files.
pub struct Served {
    folder: PathBuf,
    /// The page's own. Its Workers and its service worker heed that of their files, not the page's.
    policy: String,
    /// Whether nobody is answered any more, as if there were no network.
    pub is_cut: AtomicBool,
    /// What was asked for since.
    pub asked_in_vain: Mutex<Vec<String>>,
}

impl Served {
    pub fn of(folder: &Path) -> Result<Self, String> {
        let file = folder.join("index.html");
        let page = fs::read_to_string(&file).map_err(|error| {
            format!("{}: {error}; script/studio --web --out FOLDER makes the page", file.display())
        })?;
        let policy = policy_of(&page)
            .ok_or_else(|| format!("{}: it has no Content-Security-Policy", file.display()))?;
        let (folder, policy) = (folder.to_owned(), policy.to_owned());
        Ok(Self { folder, policy, is_cut: AtomicBool::new(false), asked_in_vain: Mutex::default() })
    }
}

/// What a page holds itself to.
fn policy_of(page: &str) -> Option<&str> {
    let (_, meta) = page.split_once("http-equiv=\"Content-Security-Policy\" content=\"")?;
    meta.split_once('"').map(|(policy, _)| policy)
}

/// Answers whoever asks, each on a thread of its own.
pub fn answer_all(listener: &TcpListener, served: &Arc<Served>) {
    for stream in listener.incoming().flatten() {
        let served = served.clone();
        // Who hangs up in the middle is told nothing.
        thread::spawn(move || answer(&stream, &served));
    }
}

fn answer(stream: &TcpStream, served: &Served) -> std::io::Result<()> {
    let mut lines = BufReader::new(stream).take(1 << 16).lines();
    let request = lines.next().transpose()?.unwrap_or_default();
    while lines.next().transpose()?.is_some_and(|line| !line.is_empty()) {}
    let mut words = request.split(' ');
    let (method, target) = (words.next().unwrap_or(""), words.next().unwrap_or(""));
    if served.is_cut.load(Ordering::Relaxed) {
        let mut asked = served.asked_in_vain.lock().unwrap_or_else(PoisonError::into_inner);
        // Browsers connect in advance, too, and ask for nothing.
        asked.extend((!target.is_empty()).then(|| target.to_owned()));
        return Ok(());
    }
    let found = (method == "GET").then(|| file_of(&served.folder, target)).flatten();
    let (status, kind, body) = match found {
        Some(file) => ("200 OK", kind_of(&file), fs::read(&file)?),
        None => ("404 Not Found", "text/plain", b"not found\n".to_vec()),
    };
    let mut stream = stream;
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nCache-Control: no-cache\r\n\
         Content-Security-Policy: {}\r\nX-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n",
        body.len(),
        served.policy
    )?;
    stream.write_all(&body)
}

/// The file that a request means, within the folder.
fn file_of(folder: &Path, target: &str) -> Option<PathBuf> {
    let path = target.split(['?', '#']).next()?.strip_prefix('/')?;
    let path = path.strip_prefix("studio/").unwrap_or(path);
    let path = Path::new(if path.is_empty() { "index.html" } else { path });
    let is_within = path.components().all(|part| matches!(part, Component::Normal(_)));
    let file = folder.join(path);
    (is_within && file.is_file()).then_some(file)
}

fn kind_of(file: &Path) -> &'static str {
    match file.extension().and_then(|ending| ending.to_str()) {
        Some("html") => "text/html; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("js") => "text/javascript; charset=utf-8",
        Some("wasm") => "application/wasm",
        Some("svg") => "image/svg+xml",
        Some("webmanifest") => "application/manifest+json",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_outside_of_the_folder_is_served() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/web");
        let found = |target: &str| file_of(&folder, target);
        assert_eq!(found("/serve.rs?a"), Some(folder.join("serve.rs")));
        assert_eq!(found("/studio/serve.rs"), Some(folder.join("serve.rs")));
        for target in ["/../main.rs", "//etc/passwd", "/", "/none", "serve.rs", "/studio/../../main.rs"] {
            assert_eq!(found(target), None, "{target}");
        }
    }

    fn page() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../apps/studio/web")
    }

    /// What the server says to a request.
    fn said(address: &str, target: &str) -> String {
        let address = address.trim_start_matches("http://").trim_end_matches('/');
        let mut stream = TcpStream::connect(address).unwrap();
        write!(stream, "GET {target} HTTP/1.1\r\n\r\n").unwrap();
        let mut said = vec![];
        // Who is cut off may be told so by the system.
        let _ = stream.read_to_end(&mut said);
        String::from_utf8_lossy(&said).into_owned()
    }

    #[test]
    fn every_file_is_held_to_what_the_page_is() {
        let served = Arc::new(Served::of(&page()).unwrap());
        let (listener, address) = listen(0).unwrap();
        let answering = served.clone();
        thread::spawn(move || answer_all(&listener, &answering));
        let header =
            "\r\nContent-Security-Policy: default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; ";
        for target in ["/", "/studio/worker.js", "/offline.js", "/none"] {
            let said = said(&address, target);
            assert!(said.contains(header), "{target}: {said}");
        }
        served.is_cut.store(true, Ordering::Relaxed);
        assert_eq!(said(&address, "/offline.js"), "");
        assert_eq!(*served.asked_in_vain.lock().unwrap(), ["/offline.js"]);
        assert!(Served::of(&page().join("none")).is_err());
    }

    /// Who serves the page elsewhere sends it, too.
    #[test]
    fn the_guide_has_the_header_as_it_is() {
        let guide = fs::read_to_string(page().join("../../../docs/guide/src/studio.md")).unwrap();
        let line = format!("\nContent-Security-Policy: {}\n", Served::of(&page()).unwrap().policy);
        assert!(guide.contains(&line), "docs/guide/src/studio.md has no line {line}");
    }
}
