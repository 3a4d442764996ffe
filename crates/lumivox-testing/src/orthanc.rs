//! A real archive for a test: Orthanc with its plugin for DICOMweb, alone with its images, on a port of its own.

use std::fs;
use std::io::{self, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// The one who may ask.
pub const NAME: &str = "doctor";
/// And the password, as no address or header could hold it.
pub const PASSWORD: &str = "s\u{e4}cret: yes";

/// It runs until this is dropped.
#[derive(Debug)]
pub struct Orthanc {
    child: Child,
    port: u16,
    log: PathBuf,
}

impl Orthanc {
    /// Starts one that keeps what it has in an empty folder.
    ///
    /// # Panics
    /// Where there is none, or it does not start.
    pub fn start(folder: &Path) -> Self {
        let [program, plugins] = ["ORTHANC", "ORTHANC_PLUGINS"].map(|name| {
            let value = std::env::var_os(name);
            PathBuf::from(value.unwrap_or_else(|| {
                panic!("{name} must name Orthanc, and the folder of its plugins; script/test finds or fetches them")
            }))
        });
        // A port that was free a moment ago may be taken: then it says so, and another is tried.
        for _ in 0..5 {
            let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
            let configuration = format!(
                r#"{{ "Name": "lumivox", "StorageDirectory": "{0}", "IndexDirectory": "{0}", "HttpPort": {port},
                "DicomServerEnabled": false, "AuthenticationEnabled": true, "RegisteredUsers": {{ "{NAME}": "{PASSWORD}" }},
                "Plugins": ["{1}/libOrthancDicomWeb.so"], "DicomWeb": {{ "Enable": true, "Root": "/dicom-web/" }} }}"#,
                folder.display(),
                plugins.display()
            );
            let (file, log) = (folder.join("orthanc.json"), folder.join("log"));
            fs::write(&file, configuration).unwrap();
            // It ends with this process, however that ends: then nobody holds the other end of the shell's input.
            let watch = r#""$0" "$1" </dev/null & read -r never; kill -9 $!"#;
            let mut command = Command::new("sh");
            command.args(["-c", watch]).args([&program, &file]).stdin(Stdio::piped()).stdout(Stdio::null());
            command.stderr(fs::File::create(&log).unwrap());
            let child = command.spawn().unwrap_or_else(|error| panic!("{}: {error}", program.display()));
            let mut orthanc = Self { child, port, log: log.clone() };
            if orthanc.answers() {
                return orthanc;
            }
            let said = fs::read_to_string(&log).unwrap_or_default();
            assert!(said.contains("port"), "Orthanc does not start:\n{said}");
        }
        panic!("no port is free")
    }

    /// Waits until it does; not where it has ended.
    fn answers(&mut self) -> bool {
        let begin = Instant::now();
        while begin.elapsed() < Duration::from_secs(120) {
            if fs::read_to_string(&self.log).is_ok_and(|said| said.contains("Orthanc has stopped")) {
                return false;
            }
            if self.ask("GET /system HTTP/1.0", &[]).is_ok_and(|answer| answer.contains("200 OK")) {
                return true;
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        false
    }

    /// Where DICOMweb answers.
    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}/dicom-web", self.port)
    }

    /// Gives it all images of a folder.
    ///
    /// # Panics
    /// Where it does not take one.
    pub fn store(&self, folder: &Path) {
        for entry in fs::read_dir(folder).unwrap() {
            let bytes = fs::read(entry.unwrap().path()).unwrap();
            let answer = self.ask("POST /instances HTTP/1.0", &bytes).unwrap();
            assert!(answer.contains("200 OK"), "{answer}");
        }
    }

    fn ask(&self, line: &str, body: &[u8]) -> io::Result<String> {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port))?;
        // The name and the password of above, in base64.
        let login = "Authorization: Basic ZG9jdG9yOnPDpGNyZXQ6IHllcw==";
        write!(stream, "{line}\r\n{login}\r\nContent-Length: {}\r\n\r\n", body.len())?;
        stream.write_all(body)?;
        let mut answer = vec![];
        stream.read_to_end(&mut answer)?;
        Ok(String::from_utf8_lossy(&answer).into_owned())
    }
}

impl Drop for Orthanc {
    fn drop(&mut self) {
        drop(self.child.stdin.take());
        let _ = self.child.wait();
    }
}
