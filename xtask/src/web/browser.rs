//! A Chromium that nobody sees, steered by its own protocol over a pipe.

use std::collections::VecDeque;
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

/// Nothing that a browser is asked takes longer.
const LONGEST: Duration = Duration::from_secs(120);

/// WebGPU by the processor; and no sandbox, which machines without privileges cannot give it.
const OPTIONS: [&str; 14] = [
    "--headless=new",
    "--remote-debugging-pipe",
    "--no-sandbox",
    "--enable-unsafe-webgpu",
    "--ignore-gpu-blocklist",
    "--disable-gpu-watchdog",
    "--use-vulkan=swiftshader",
    "--enable-features=Vulkan",
    "--use-angle=vulkan",
    "--enable-unsafe-swiftshader",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--window-size=1280,800",
];

/// Somebody who works for the page.
pub struct Worker {
    /// `worker` or `service_worker`.
    pub kind: String,
    /// By which it is spoken to.
    pub session: String,
    /// Whether it has ended.
    pub is_over: bool,
}

/// A browser with one page.
pub struct Browser {
    child: Child,
    to: ChildStdin,
    from: Receiver<Value>,
    profile: PathBuf,
    asked: u64,
    session: Option<String>,
    /// The page's Workers, and its service worker, the oldest first.
    pub workers: Vec<Worker>,
    /// What it told without being asked, the oldest first.
    pub events: VecDeque<Value>,
}

impl Browser {
    /// Starts one with a blank page.
    pub fn start(program: &Path) -> Result<Self, String> {
        let profile = std::env::temp_dir().join(format!("lumivox-browser-{}", std::process::id()));
        // The protocol is spoken over the descriptors 3 and 4.
        let mut child = Command::new("sh")
            .args(["-c", "exec \"$0\" \"$@\" 3<&0 4>&1 </dev/null >/dev/null"])
            .arg(program)
            .args(OPTIONS)
            .arg(format!("--user-data-dir={}", profile.display()))
            .arg("about:blank")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|error| format!("{}: {error}", program.display()))?;
        let (to, out) = (child.stdin.take(), child.stdout.take());
        let (to, out) = to.zip(out).ok_or("the browser has no pipes")?;
        let (send, from) = channel();
        thread::spawn(move || {
            for message in BufReader::new(out).split(0).map_while(Result::ok) {
                let Ok(message) = serde_json::from_slice(&message) else { continue };
                if send.send(message).is_err() {
                    return;
                }
            }
        });
        let (session, workers, events) = (None, vec![], VecDeque::new());
        let mut browser = Self { child, to, from, profile, asked: 0, session, workers, events };
        let targets = browser.ask("Target.getTargets", json!({}))?;
        let is_page = |target: &&Value| target["type"] == "page";
        let page = targets["targetInfos"].as_array().into_iter().flatten().find(is_page);
        let page = page.ok_or("the browser has no page")?["targetId"].clone();
        let attached = browser.ask("Target.attachToTarget", json!({ "targetId": page, "flatten": true }))?;
        // What belongs to the whole browser is asked for before there is a session. They wait until somebody listens.
        let mut attach = json!({ "autoAttach": true, "waitForDebuggerOnStart": true, "flatten": true });
        let page_attach = attach.clone();
        attach["filter"] = json!([{ "type": "service_worker" }]);
        browser.ask("Target.setAutoAttach", attach)?;
        browser.session = attached["sessionId"].as_str().map(str::to_owned);
        browser.ask("Target.setAutoAttach", page_attach)?;
        for domain in ["Page", "Runtime", "Network", "Log"] {
            browser.ask(&format!("{domain}.enable"), json!({}))?;
        }
        let size = json!({ "width": 1280, "height": 800, "deviceScaleFactor": 1, "mobile": false });
        browser.ask("Emulation.setDeviceMetricsOverride", size)?;
        Ok(browser)
    }

    /// Asks the page for something, and waits for the answer.
    pub fn ask(&mut self, method: &str, params: Value) -> Result<Value, String> {
        let session = self.session.clone();
        self.ask_in(session.as_deref(), method, params, LONGEST)
    }

    fn send(&mut self, session: Option<&str>, method: &str, params: Value) -> Result<u64, String> {
        self.asked += 1;
        let mut message = json!({ "id": self.asked, "method": method, "params": params });
        if let Some(session) = session {
            message["sessionId"] = json!(session);
        }
        let mut bytes = message.to_string().into_bytes();
        bytes.push(0);
        self.to.write_all(&bytes).map_err(|error| format!("the browser is gone: {error}"))?;
        Ok(self.asked)
    }

    fn ask_in(
        &mut self,
        session: Option<&str>,
        method: &str,
        params: Value,
        within: Duration,
    ) -> Result<Value, String> {
        let asked = self.send(session, method, params)?;
        let begin = Instant::now();
        loop {
            let Some(message) = self.next(within.saturating_sub(begin.elapsed()))? else {
                return Err(format!("the browser does not answer {method}"));
            };
            if message["id"] == json!(asked) {
                return match message.get("error") {
                    Some(error) => Err(format!("{method}: {error}")),
                    None => Ok(message["result"].clone()),
                };
            }
            match message["method"].as_str() {
                Some("Target.attachedToTarget") => self.listen_to(&message["params"])?,
                Some("Target.detachedFromTarget") => {
                    let session = &message["params"]["sessionId"];
                    let own = self.workers.iter_mut().filter(|worker| *session == worker.session);
                    own.for_each(|worker| worker.is_over = true);
                }
                _ => {}
            }
            // Answers that nobody waits for are not kept.
            if message.get("id").is_none() {
                self.events.push_back(message);
            }
        }
    }

    /// A Worker begins: what it asks for is told, too, from its first request on.
    fn listen_to(&mut self, attached: &Value) -> Result<(), String> {
        let Some(session) = attached["sessionId"].as_str() else { return Ok(()) };
        let kind = attached["targetInfo"]["type"].as_str().unwrap_or_default();
        if kind.ends_with("worker") {
            let (kind, session) = (kind.to_owned(), session.to_owned());
            self.workers.push(Worker { kind, session, is_over: false });
        }
        for method in ["Network.enable", "Runtime.enable", "Log.enable", "Runtime.runIfWaitingForDebugger"] {
            self.send(Some(session), method, json!({}))?;
        }
        Ok(())
    }

    fn next(&mut self, within: Duration) -> Result<Option<Value>, String> {
        match self.from.recv_timeout(within) {
            Ok(message) => Ok(Some(message)),
            Err(RecvTimeoutError::Timeout) => Ok(None),
            Err(RecvTimeoutError::Disconnected) => Err("the browser has ended".to_owned()),
        }
    }

    /// What an expression is, of the page.
    pub fn evaluate(&mut self, expression: &str) -> Result<Value, String> {
        self.evaluate_within(expression, LONGEST)
    }

    /// The same of what takes long.
    pub fn evaluate_within(&mut self, expression: &str, within: Duration) -> Result<Value, String> {
        let session = self.session.clone();
        self.evaluate_in(session.as_deref(), expression, within)
    }

    /// What it is in another session.
    pub fn evaluate_in(
        &mut self,
        session: Option<&str>,
        expression: &str,
        within: Duration,
    ) -> Result<Value, String> {
        let asked = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let answer = self.ask_in(session, "Runtime.evaluate", asked, within)?;
        match answer.get("exceptionDetails") {
            Some(wrong) => Err(format!("{expression}: {wrong}")),
            None => Ok(answer["result"]["value"].clone()),
        }
    }

    /// Waits until an expression is true.
    pub fn wait(&mut self, expression: &str, within: Duration) -> Result<Duration, String> {
        let begin = Instant::now();
        loop {
            // A page that goes away answers nothing; the next one may.
            let found = self.evaluate(expression);
            if found == Ok(json!(true)) {
                break;
            }
            if begin.elapsed() > within {
                let why = found.err().unwrap_or_default();
                return Err(format!("after {} s it is not so: {expression} {why}", within.as_secs()));
            }
            thread::sleep(Duration::from_millis(100));
        }
        Ok(begin.elapsed())
    }

    /// Drops files of this machine on the page.
    pub fn drop_files(&mut self, files: &[&Path], x: f64, y: f64) -> Result<(), String> {
        let files: Vec<_> = files.iter().map(|file| file.display().to_string()).collect();
        let data = json!({ "items": [], "files": files, "dragOperationsMask": 1 });
        for kind in ["dragEnter", "dragOver", "drop"] {
            self.ask("Input.dispatchDragEvent", json!({ "type": kind, "x": x, "y": y, "data": data }))?;
        }
        Ok(())
    }

    /// The page as it is seen: a PNG.
    pub fn screenshot(&mut self) -> Result<Vec<u8>, String> {
        let answer = self.ask("Page.captureScreenshot", json!({ "format": "png" }))?;
        from_base64(answer["data"].as_str().unwrap_or_default())
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        let _ = fs::remove_dir_all(&self.profile);
    }
}

fn from_base64(text: &str) -> Result<Vec<u8>, String> {
    let mut bytes = vec![];
    let (mut bits, mut count) = (0_u32, 0);
    for digit in text.bytes().filter(|digit| *digit != b'=') {
        let value = match digit {
            b'A'..=b'Z' => digit - b'A',
            b'a'..=b'z' => digit - b'a' + 26,
            b'0'..=b'9' => digit - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return Err("the browser's picture is none".to_owned()),
        };
        bits = bits << 6 | u32::from(value);
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count) as u8);
            bits &= (1 << count) - 1;
        }
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base_64_is_read() {
        assert_eq!(from_base64("TGlnaHQ="), Ok(b"Light".to_vec()));
        assert_eq!(from_base64("+/8A"), Ok(vec![0xfb, 0xff, 0]));
        assert!(from_base64("a b").is_err());
    }
}
