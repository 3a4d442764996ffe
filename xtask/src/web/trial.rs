//! What a person would do with the page, and what is seen of it.

use std::fs;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::package::archive::Files;

use super::browser::Browser;
use super::serve::{answer_all, listen};

/// A processor that does a GPU's work, of which others want some, too.
const PATIENCE: Duration = Duration::from_secs(100);
/// Longer nothing may hold the page up, in ms.
const LONGEST_FREEZE: f64 = 1500.0;

/// Of files in the archive that is dropped: a day in 2026.
const DATE: u64 = 1_780_000_000;

/// A part of the page, in pixels: left, top, right, bottom.
type Part = [u32; 4];
/// The middle of the 3D view, where the head is, and a strip at its edge, where nothing is.
const HEAD: Part = [420, 330, 560, 480];
const NOTHING: Part = [250, 90, 330, 160];
/// The axial slice.
const SLICE: Part = [740, 80, 940, 260];

pub fn run(folder: &Path, program: &Path, scan: &Path, pictures: &Path) -> Result<(), String> {
    fs::create_dir_all(pictures).map_err(|error| format!("{}: {error}", pictures.display()))?;
    let archive = std::path::absolute(pictures.join("scan.zip"));
    let archive = archive.map_err(|error| error.to_string())?;
    let mut files = Files::default();
    files.add_folder("head/", scan, &|_| true)?;
    fs::write(&archive, files.zip(DATE)?).map_err(|error| format!("{}: {error}", archive.display()))?;
    let (listener, address) = listen(0)?;
    let served = folder.to_owned();
    thread::spawn(move || answer_all(&listener, &served));
    let mut browser = Browser::start(program)?;
    let mut trial = Trial { browser: &mut browser, address, pictures };
    trial.first_start()?;
    trial.phantom()?;
    trial.dropped(&archive)?;
    trial.is_quiet()?;
    trial.offline()?;
    trial.without_webgpu()
}

struct Trial<'a> {
    browser: &'a mut Browser,
    address: String,
    pictures: &'a Path,
}

impl Trial<'_> {
    fn go(&mut self, to: &str) -> Result<(), String> {
        let url = format!("{}{to}", self.address);
        self.browser.ask("Page.navigate", json!({ "url": url })).map(|_| ())
    }

    fn first_start(&mut self) -> Result<(), String> {
        // Below a path of its own, as on somebody's server.
        self.go("studio/#phantom=48")?;
        let took = self.browser.wait("window.studio !== undefined", PATIENCE)?;
        println!("web: the interface is there after {:.1} s", took.as_secs_f64());
        // Timers come when nothing else holds the page up; frames come as late as the processor that draws them.
        let watch = "window.longest = 0; window.last = performance.now(); setInterval(() => { const now = performance.now(); \
                     window.longest = Math.max(window.longest, now - window.last); window.last = now }, 20)";
        self.browser.evaluate(watch)?;
        thread::sleep(Duration::from_secs(1));
        self.seen("1-first-start")?;
        for kind in ["keyDown", "keyUp"] {
            self.browser
                .ask("Input.dispatchKeyEvent", json!({ "type": kind, "key": "Enter", "code": "Enter" }))?;
        }
        Ok(())
    }

    fn phantom(&mut self) -> Result<(), String> {
        self.shown("[48, 48, 48]", "the phantom")?;
        self.shows_a_head("2-phantom", "the phantom")
    }

    fn dropped(&mut self, scan: &Path) -> Result<(), String> {
        self.browser.drop_files(&[scan], 500.0, 400.0)?;
        self.shown("[32, 32, 32]", "the dropped archive")?;
        let told = self.told()?;
        if told["series"] != json!(1) {
            return Err(format!("the dropped archive has one series, and there are {}", told["series"]));
        }
        self.shows_a_head("3-dropped", "the dropped archive")?;
        let longest = self.browser.evaluate("window.longest")?.as_f64().unwrap_or(f64::INFINITY);
        println!("web: the page was held up for at most {longest:.0} ms");
        if longest > LONGEST_FREEZE {
            return Err(format!("for {longest:.0} ms the page could do nothing else"));
        }
        Ok(())
    }

    fn told(&mut self) -> Result<Value, String> {
        let told = self.browser.evaluate("window.studio.told()")?;
        serde_json::from_str(told.as_str().unwrap_or_default()).map_err(|error| error.to_string())
    }

    /// Waits for a scan of so many voxels, and a picture of it.
    fn shown(&mut self, dims: &str, what: &str) -> Result<(), String> {
        let begin = Instant::now();
        let is_there = |condition: &str| format!("(t => {condition})(JSON.parse(window.studio.told()))");
        let read = format!("t.failed !== null || JSON.stringify(t.dims) === JSON.stringify({dims})");
        self.browser.wait(&is_there(&read), PATIENCE)?;
        let told = self.told()?;
        if let Some(why) = told["failed"].as_str() {
            return Err(format!("{what}: {why}"));
        }
        let opened = begin.elapsed();
        self.browser.wait(&is_there("t.failed !== null || t.isShown"), PATIENCE)?;
        let told = self.told()?;
        if let Some(why) = told["failed"].as_str() {
            return Err(format!("{what}: {why}"));
        }
        let (opened, shown) = (opened.as_secs_f64(), begin.elapsed().as_secs_f64());
        println!("web: {what} is open after {opened:.1} s, and path-traced after {shown:.1} s");
        Ok(())
    }

    /// Looks until a head is seen: what is drawn comes later than it is told.
    fn shows_a_head(&mut self, name: &str, what: &str) -> Result<(), String> {
        let begin = Instant::now();
        loop {
            match self.seen(name)?.shows_a_head(what) {
                Err(why) if begin.elapsed() > PATIENCE => return Err(why),
                Err(_) => thread::sleep(Duration::from_millis(500)),
                Ok(()) => return Ok(()),
            }
        }
    }

    /// The page's pixels; kept, too.
    fn seen(&mut self, name: &str) -> Result<Seen, String> {
        let bytes = self.browser.screenshot()?;
        let file = self.pictures.join(name).with_extension("png");
        fs::write(&file, &bytes).map_err(|error| format!("{}: {error}", file.display()))?;
        Seen::read(&bytes)
    }

    /// Nothing was asked of anybody else, and nothing complained of.
    fn is_quiet(&mut self) -> Result<(), String> {
        let (mut asked, mut wrong) = (0, vec![]);
        for event in &self.browser.events {
            let of = &event["params"];
            match event["method"].as_str().unwrap_or_default() {
                "Network.requestWillBeSent" => {
                    let url = of["request"]["url"].as_str().unwrap_or_default();
                    let is_own =
                        url.starts_with(&self.address) || url.starts_with("blob:") || url == "about:blank";
                    let is_get = of["request"]["method"] == "GET";
                    asked += 1;
                    if !is_own || !is_get {
                        wrong.push(format!("it asks for {url}"));
                    }
                }
                "Runtime.exceptionThrown" => wrong.push(of["exceptionDetails"].to_string()),
                "Runtime.consoleAPICalled" if of["type"] == "error" => wrong.push(of["args"].to_string()),
                "Log.entryAdded" if of["entry"]["level"] == "error" => wrong.push(of["entry"].to_string()),
                _ => {}
            }
        }
        println!("web: {asked} requests, all for its own files");
        if wrong.is_empty() { Ok(()) } else { Err(format!("the page is not quiet:\n{}", wrong.join("\n"))) }
    }

    fn offline(&mut self) -> Result<(), String> {
        self.browser.wait("navigator.serviceWorker.controller !== null", PATIENCE)?;
        let cut = json!({ "offline": true, "latency": 0, "downloadThroughput": -1, "uploadThroughput": -1 });
        self.browser.ask("Network.emulateNetworkConditions", cut)?;
        // What is open is not changed: nobody is asked whether to leave.
        self.go("studio/?offline")?;
        self.browser.wait("location.search === '?offline' && window.studio !== undefined", PATIENCE)?;
        println!("web: it opens without a network, too");
        let back =
            json!({ "offline": false, "latency": 0, "downloadThroughput": -1, "uploadThroughput": -1 });
        self.browser.ask("Network.emulateNetworkConditions", back).map(|_| ())
    }

    fn without_webgpu(&mut self) -> Result<(), String> {
        let without = json!({ "source": "delete Navigator.prototype.gpu" });
        self.browser.ask("Page.addScriptToEvaluateOnNewDocument", without)?;
        self.go("studio/?without")?;
        let words = "location.search === '?without' && document.getElementById('words')?.textContent.includes('has no WebGPU')";
        self.browser.wait(words, PATIENCE)?;
        self.seen("4-without-webgpu")?;
        println!("web: a browser without WebGPU is told so");
        Ok(())
    }
}

/// Pixels of a screenshot.
struct Seen {
    width: u32,
    rgb: Vec<[u8; 3]>,
}

impl Seen {
    fn read(bytes: &[u8]) -> Result<Self, String> {
        let mut reader =
            png::Decoder::new(std::io::Cursor::new(bytes)).read_info().map_err(|error| error.to_string())?;
        let mut all = vec![0; reader.output_buffer_size().ok_or("the screenshot is too large")?];
        let info = reader.next_frame(&mut all).map_err(|error| error.to_string())?;
        let channels = info.color_type.samples();
        let rgb =
            all.chunks_exact(channels).map(|pixel| [0, 1, 2].map(|c| pixel[c.min(channels - 1)])).collect();
        Ok(Self { width: info.width, rgb })
    }

    fn part(&self, [left, top, right, bottom]: Part) -> impl Iterator<Item = [u8; 3]> + '_ {
        let line = move |y: u32| (left..right).map(move |x| (y * self.width + x) as usize);
        (top..bottom).flat_map(line).filter_map(|at| self.rgb.get(at).copied())
    }

    fn mean(&self, part: Part) -> f64 {
        let (sum, count) = self.part(part).fold((0.0, 0.0), |(sum, count), pixel| {
            (sum + pixel.iter().map(|c| f64::from(*c)).sum::<f64>() / 3.0, count + 1.0)
        });
        sum / f64::max(count, 1.0)
    }

    fn colors(&self, part: Part) -> usize {
        self.part(part).collect::<std::collections::HashSet<_>>().len()
    }

    /// Bright where the head is, of many colours; dark where nothing is; and a slice beside it.
    fn shows_a_head(&self, what: &str) -> Result<(), String> {
        let (head, nothing, slice) = (self.mean(HEAD), self.mean(NOTHING), self.mean(SLICE));
        let colors = self.colors(HEAD);
        if head < 60.0 || head < nothing + 30.0 || colors < 500 {
            return Err(format!("{what} is not seen: {head:.0}, {colors} colours, beside it {nothing:.0}"));
        }
        if slice < 15.0 || self.colors(SLICE) < 20 {
            return Err(format!("{what} has no slice: {slice:.0}"));
        }
        println!("web: {what}: head {head:.0} of {colors} colours, beside it {nothing:.0}, slice {slice:.0}");
        Ok(())
    }
}
