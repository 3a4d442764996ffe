//! What a person would do with the page, and what is seen of it.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::sync::{Arc, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::package::archive::Files;

use super::browser::{Browser, Worker};
use super::serve::{Served, answer_all, listen};

/// A processor that does a GPU's work, of which others want some, too.
const PATIENCE: Duration = Duration::from_secs(100);
/// Longer nothing may hold the page up, in ms: .2 to 1.8 s is what preparing for the GPU takes, the latter where six programs want
/// each processor.
const LONGEST_FREEZE: f64 = 4000.0;

/// Of files in the archive that is dropped: a day in 2026.
const DATE: u64 = 1_780_000_000;

/// A part of the page, in pixels: left, top, right, bottom.
type Part = [u32; 4];
/// The middle of the 3D view, where the head is, and a strip at its edge, where nothing is.
const HEAD: Part = [420, 330, 560, 480];
const NOTHING: Part = [250, 90, 330, 160];
/// The axial slice.
const SLICE: Part = [740, 80, 940, 260];
/// Of a page for others, where the head is, and where nothing is.
const PAGE_MIDDLE: Part = [540, 300, 740, 500];
const PAGE_CORNER: Part = [40, 560, 200, 700];

/// How much is tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Extent {
    /// A phantom and an archive are opened, and seen.
    First,
    /// All that a person would do.
    Whole,
}

pub fn run(
    extent: Extent,
    folder: &Path,
    program: &Path,
    scan: &Path,
    pictures: &Path,
) -> Result<(), String> {
    names_no_folder(&folder.join("lumivox_studio_bg.wasm"))?;
    fs::create_dir_all(pictures).map_err(|error| format!("{}: {error}", pictures.display()))?;
    let archive = std::path::absolute(pictures.join("scan.zip"));
    let archive = archive.map_err(|error| error.to_string())?;
    let mut files = Files::default();
    files.add_folder("head/", scan, &|_| true)?;
    fs::write(&archive, files.zip(DATE)?).map_err(|error| format!("{}: {error}", archive.display()))?;
    let (listener, address) = listen(0)?;
    let served = Arc::new(Served::of(folder)?);
    let answering = served.clone();
    thread::spawn(move || answer_all(&listener, &answering));
    let mut browser = Browser::start(program)?;
    let mut trial = Trial { browser: &mut browser, address, served, pictures };
    trial.first_start()?;
    trial.phantom()?;
    trial.dropped(&archive, extent)?;
    if extent == Extent::First {
        return trial.is_quiet();
    }
    trial.looks()?;
    let shared = trial.shares()?;
    trial.pair()?;
    trial.empty_folder()?;
    trial.is_quiet()?;
    trial.is_held()?;
    trial.is_shared(&shared)?;
    trial.offline()?;
    trial.broken()?;
    trial.without_webgpu()
}

/// A program tells nobody where it was made.
pub fn names_no_folder(file: &Path) -> Result<(), String> {
    let program = fs::read(file).map_err(|error| format!("{}: {error}", file.display()))?;
    let home = std::env::var_os("HOME").map(PathBuf::from);
    let cargo = std::env::var_os("CARGO_HOME").map(PathBuf::from).or(home.map(|home| home.join(".cargo")));
    for own in [Some(crate::root()?), cargo].into_iter().flatten() {
        let name = own.to_string_lossy();
        // A root of files is in every path.
        if name.len() > 1 && program.windows(name.len()).any(|part| part == name.as_bytes()) {
            return Err(format!("{} names {name}, where it was made", file.display()));
        }
    }
    Ok(())
}

struct Trial<'a> {
    browser: &'a mut Browser,
    address: String,
    served: Arc<Served>,
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

    fn dropped(&mut self, scan: &Path, extent: Extent) -> Result<(), String> {
        self.browser.drop_files(&[scan], 500.0, 400.0)?;
        self.shown("[32, 32, 32]", "the dropped archive")?;
        let told = self.told()?;
        if told["series"] != json!(1) {
            return Err(format!("the dropped archive has one series, and there are {}", told["series"]));
        }
        self.shows_a_head("3-dropped", "the dropped archive")?;
        let longest = self.browser.evaluate("window.longest")?.as_f64().unwrap_or(f64::INFINITY);
        println!("web: the page was held up for at most {longest:.0} ms");
        // A page that nobody has optimised, beside other tests, is held up for longer.
        if extent == Extent::Whole && longest > LONGEST_FREEZE {
            return Err(format!("for {longest:.0} ms the page could do nothing else"));
        }
        Ok(())
    }

    /// Once the view is clean enough, looks are seen as pictures of the scan.
    fn looks(&mut self) -> Result<(), String> {
        let first = self.browser.wait("JSON.parse(window.studio.told()).tiles > 0", 3 * PATIENCE)?;
        self.seen("4-looks")?;
        println!("web: a look's picture comes after {:.0} s", first.as_secs_f64());
        Ok(())
    }

    /// The scan as a page of its own, in a file.
    fn shares(&mut self) -> Result<PathBuf, String> {
        let begin = Instant::now();
        self.keep_saved()?;
        self.browser.evaluate("window.studio.share()")?;
        let page = self.saved()?;
        let took = begin.elapsed().as_secs_f64();
        println!("web: a page of {:.1} MB for others is there after {took:.0} s", page.len() as f64 / 1e6);
        let file =
            std::path::absolute(self.pictures.join("shared.html")).map_err(|error| error.to_string())?;
        fs::write(&file, page).map_err(|error| format!("{}: {error}", file.display()))?;
        Ok(file)
    }

    /// Such a page shows the scan from wherever it lies, and asks for nothing.
    fn is_shared(&mut self, file: &Path) -> Result<(), String> {
        let asked = self.browser.events.len();
        let begin = Instant::now();
        let url = format!("file://{}", file.display());
        self.browser.ask("Page.navigate", json!({ "url": url }))?;
        let is_there = "window.view !== undefined && document.getElementById('told').hidden";
        self.browser.wait(is_there, 2 * PATIENCE)?;
        let took = begin.elapsed().as_secs_f64();
        self.browser.wait("parseInt(document.getElementById('samples').textContent) >= 4", 2 * PATIENCE)?;
        let look = "(look => { look.value = 'ct-bone'; look.onchange(); return window.view.preset })(document.getElementById('look'))";
        let bone = self.browser.evaluate(look)?;
        self.browser.evaluate("document.getElementById('reset').click()")?;
        self.browser.wait("parseInt(document.getElementById('samples').textContent) >= 4", 2 * PATIENCE)?;
        let seen = self.seen("7-shared")?;
        let (middle, corner) = (seen.mean(PAGE_MIDDLE), seen.mean(PAGE_CORNER));
        let colors = seen.colors(PAGE_MIDDLE);
        if bone != json!("ct-bone") || middle < corner + 30.0 || colors < 500 {
            return Err(format!(
                "a page for others shows {middle:.0} of {colors} colours, beside it {corner:.0}; {bone}"
            ));
        }
        let requests =
            self.browser.events.iter().skip(asked).filter(|it| it["method"] == "Network.requestWillBeSent");
        let urls = requests.filter_map(|it| it["params"]["request"]["url"].as_str());
        let strange: Vec<&str> =
            urls.filter(|asked| !asked.starts_with(&url) && !asked.starts_with("blob:")).collect();
        if !strange.is_empty() {
            return Err(format!("a page for others asks for {}", strange.join(", ")));
        }
        println!("web: a page for others is seen after {took:.0} s: {middle:.0} of {colors} colours");
        self.go("studio/")?;
        self.browser.wait("window.studio !== undefined", PATIENCE).map(|_| ())
    }

    /// Keeps what the page gives somebody as a file.
    fn keep_saved(&mut self) -> Result<(), String> {
        let keep = "window.saved = undefined; window.make ??= URL.createObjectURL; \
                    URL.createObjectURL = blob => window.make.call(URL, window.saved = blob); true";
        self.browser.evaluate(keep).map(|_| ())
    }

    /// What that is.
    fn saved(&mut self) -> Result<String, String> {
        self.browser.wait("window.saved !== undefined", PATIENCE)?;
        let saved = self.browser.evaluate("window.saved.text()")?;
        Ok(saved.as_str().unwrap_or_default().to_owned())
    }

    /// A header and its samples, dropped side by side; a scene of them names the header as it is called, and finds it again.
    fn pair(&mut self) -> Result<(), String> {
        let file =
            |name: &str| std::path::absolute(self.pictures.join(name)).map_err(|error| error.to_string());
        let [header, samples, scene] = [file("ball.nhdr")?, file("ball.raw")?, file("ball.lumivox")?];
        let write = |file: &Path, bytes: &[u8]| {
            fs::write(file, bytes).map_err(|error| format!("{}: {error}", file.display()))
        };
        let text = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 24 24 24\nspacings: 1 1 1\nencoding: raw\n\
                    data file: ball.raw\n";
        write(&header, text.as_bytes())?;
        let voxel = |at: usize| {
            let squares = [at % 24, at / 24 % 24, at / 576].map(|c| (c as f64 - 11.5).powi(2));
            (400.0 - squares.iter().sum::<f64>() * 3.0).clamp(0.0, 255.0) as u8
        };
        write(&samples, &(0..24 * 24 * 24).map(voxel).collect::<Vec<_>>())?;
        self.browser.drop_files(&[&samples, &header], 500.0, 400.0)?;
        self.shown("[24, 24, 24]", "the header with its samples")?;
        self.seen("5-pair")?;
        self.keep_saved()?;
        for kind in ["keyDown", "keyUp"] {
            let key = json!({ "type": kind, "key": "s", "code": "KeyS", "windowsVirtualKeyCode": 83, "modifiers": 2 });
            self.browser.ask("Input.dispatchKeyEvent", key)?;
        }
        let saved = self.saved()?;
        let document: Value = serde_json::from_str(&saved).map_err(|error| format!("{error}: {saved}"))?;
        let files = &document["volumes"][0]["scan"]["files"];
        if *files != json!(["ball.nhdr"]) {
            return Err(format!("the scene names {files}, and not ball.nhdr"));
        }
        write(&scene, saved.as_bytes())?;
        self.browser.evaluate("window.studio.phantom(16)")?;
        self.shown("[16, 16, 16]", "another phantom")?;
        self.browser.drop_files(&[&scene], 500.0, 400.0)?;
        self.shown("[24, 24, 24]", "the saved scene")
    }

    /// What cannot be opened is told.
    fn empty_folder(&mut self) -> Result<(), String> {
        let folder = std::path::absolute(self.pictures.join("empty")).map_err(|error| error.to_string())?;
        fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        self.browser.drop_files(&[&folder], 500.0, 400.0)?;
        self.browser
            .wait("JSON.parse(window.studio.told()).failed === 'empty: there is no file in it'", PATIENCE)?;
        thread::sleep(Duration::from_secs(2));
        self.seen("6-empty-folder")?;
        println!("web: an empty folder is told of");
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
        let mut of_workers = 0;
        for event in &self.browser.events {
            let of = &event["params"];
            match event["method"].as_str().unwrap_or_default() {
                "Network.requestWillBeSent" => {
                    let url = of["request"]["url"].as_str().unwrap_or_default();
                    let is_own =
                        url.starts_with(&self.address) || url.starts_with("blob:") || url == "about:blank";
                    let is_get = of["request"]["method"] == "GET";
                    asked += 1;
                    let mut workers = self.browser.workers.iter();
                    let worker = workers.find(|worker| event["sessionId"] == worker.session);
                    of_workers += usize::from(worker.is_some_and(|worker| worker.kind == "service_worker"));
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
        // It has fetched all that it keeps: else nobody would have looked at it.
        if of_workers < 5 {
            wrong.push(format!("of its service worker {of_workers} requests were seen"));
        }
        println!("web: {asked} requests, all for its own files, {of_workers} of them its service worker's");
        if wrong.is_empty() { Ok(()) } else { Err(format!("the page is not quiet:\n{}", wrong.join("\n"))) }
    }

    /// Worker and service worker can ask nobody else either, whatever program there was in them.
    fn is_held(&mut self) -> Result<(), String> {
        let (stranger, url) = listen(0)?;
        stranger.set_nonblocking(true).map_err(|error| error.to_string())?;
        // It answers what is no errand, too: then it runs.
        let idle = "window.idle = new Worker('worker.js', { type: 'module' }); \
                    new Promise(done => { idle.onmessage = done; idle.postMessage({ module: 1 }) }).then(() => true)";
        self.browser.evaluate(idle)?;
        for kind in ["worker", "service_worker"] {
            let ask = format!("fetch('{url}', {{ mode: 'no-cors' }}).then(() => 'sent', () => 'refused')");
            let outcome = self.in_worker(kind, &ask)?;
            let is_asked = !stranger.accept().is_err_and(|error| error.kind() == ErrorKind::WouldBlock);
            if outcome != json!("refused") || is_asked {
                return Err(format!("its {kind} asks a stranger: {outcome}"));
            }
        }
        self.browser.evaluate("window.idle.terminate(); true")?;
        println!("web: its Workers ask nobody else");
        Ok(())
    }

    /// What an expression is in the newest Worker of a kind. One that has ended answers nothing; a service worker that does is begun
    /// again by what it is sent.
    fn in_worker(&mut self, kind: &str, expression: &str) -> Result<Value, String> {
        let begin = Instant::now();
        loop {
            self.browser
                .evaluate("navigator.serviceWorker.ready.then(own => own.active.postMessage('there?'))")?;
            let is_it = |worker: &&Worker| worker.kind == kind && !worker.is_over;
            let session = self.browser.workers.iter().rev().find(is_it).map(|worker| worker.session.clone());
            let outcome = match session {
                Some(session) => self.browser.evaluate_in(Some(&session), expression, PATIENCE / 5),
                None => Err("it is not there".to_owned()),
            };
            if outcome.is_ok() || begin.elapsed() > PATIENCE {
                return outcome.map_err(|why| format!("the page's {kind}: {why}"));
            }
            thread::sleep(Duration::from_millis(200));
        }
    }

    fn offline(&mut self) -> Result<(), String> {
        self.browser.wait("navigator.serviceWorker.controller !== null", PATIENCE)?;
        self.served.is_cut.store(true, Ordering::Relaxed);
        // What is open is not changed: nobody is asked whether to leave.
        self.go("studio/?offline")?;
        self.browser.wait("location.search === '?offline' && window.studio !== undefined", PATIENCE)?;
        self.served.is_cut.store(false, Ordering::Relaxed);
        let mut asked = self.served.asked_in_vain.lock().unwrap_or_else(PoisonError::into_inner).clone();
        // Browsers look by themselves whether there is another version.
        asked.retain(|target| target != "/studio/offline.js");
        if !asked.is_empty() {
            return Err(format!("without a network it asks for {}", asked.join(", ")));
        }
        println!("web: it opens without a network, too");
        Ok(())
    }

    /// A page without a clock, by which the interface's library breaks: it says so where the picture was.
    fn broken(&mut self) -> Result<(), String> {
        self.browser.evaluate("Object.defineProperty(window, 'performance', { value: undefined }); true")?;
        let moved = json!({ "type": "mouseMoved", "x": 500, "y": 400 });
        self.browser.ask("Input.dispatchMouseEvent", moved)?;
        let words = "!document.getElementById('told').hidden && \
                     document.getElementById('words').textContent.includes('The Studio broke')";
        self.browser.wait(words, PATIENCE)?;
        self.seen("8-broken")?;
        println!("web: a program that breaks says so");
        Ok(())
    }

    fn without_webgpu(&mut self) -> Result<(), String> {
        let without = json!({ "source": "delete Navigator.prototype.gpu" });
        self.browser.ask("Page.addScriptToEvaluateOnNewDocument", without)?;
        self.go("studio/?without")?;
        let words = "location.search === '?without' && document.getElementById('words')?.textContent.includes('has no WebGPU')";
        self.browser.wait(words, PATIENCE)?;
        self.seen("9-without-webgpu")?;
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
