//! Static files by HTTP, to this machine alone.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;
use std::thread;

/// Serves a folder, below `/studio/` and at `/`, until the program is ended; says where.
pub fn serve(folder: &Path, port: u16) -> Result<(), String> {
    let (listener, address) = listen(port)?;
    println!("Lumivox Studio: {address}\nCtrl+C ends it.");
    answer_all(&listener, folder);
    Ok(())
}

/// A port of this machine, any free one for 0; its address.
pub fn listen(port: u16) -> Result<(TcpListener, String), String> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))
        .map_err(|error| format!("cannot serve at 127.0.0.1:{port}: {error}; name another port"))?;
    let port = listener.local_addr().map_err(|error| error.to_string())?.port();
    Ok((listener, format!("http://127.0.0.1:{port}/")))
}

/// Answers whoever asks, each on a thread of its own.
pub fn answer_all(listener: &TcpListener, folder: &Path) {
    let folder: Arc<Path> = folder.into();
    for stream in listener.incoming().flatten() {
        let folder = folder.clone();
        // Who hangs up in the middle is told nothing.
        thread::spawn(move || answer(&stream, &folder));
    }
}

fn answer(stream: &TcpStream, folder: &Path) -> std::io::Result<()> {
    let mut lines = BufReader::new(stream).take(1 << 16).lines();
    let request = lines.next().transpose()?.unwrap_or_default();
    while lines.next().transpose()?.is_some_and(|line| !line.is_empty()) {}
    let mut words = request.split(' ');
    let (method, target) = (words.next().unwrap_or(""), words.next().unwrap_or(""));
    let found = (method == "GET").then(|| file_of(folder, target)).flatten();
    let (status, kind, body) = match found {
        Some(file) => ("200 OK", kind_of(&file), fs::read(&file)?),
        None => ("404 Not Found", "text/plain", b"not found\n".to_vec()),
    };
    let mut stream = stream;
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nCache-Control: no-cache\r\n\
         X-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n",
        body.len()
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
}
