//! What a program would do with the npm package, in a browser that nobody sees.

use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use serde_json::json;

use super::browser::Browser;
use super::serve::{Served, answer_all, listen};
use super::trial::names_no_folder;

/// A processor that does a GPU's work, of which others want some, too.
const PATIENCE: Duration = Duration::from_secs(100);
/// It compiles kernels first, and then draws some pictures.
const LONGEST: Duration = Duration::from_secs(400);

/// Puts the package into a page's folder with its example and its trial, and has a browser call that; pictures go to `pictures`.
pub fn run(package: &Path, program: &Path, scan: &Path, pictures: &Path) -> Result<(), String> {
    names_no_folder(&package.join("lumivox_wasm_bg.wasm"))?;
    let error = |at: &Path, error: std::io::Error| format!("{}: {error}", at.display());
    let page = pictures.join("page");
    let _ = fs::remove_dir_all(&page);
    fs::create_dir_all(page.join("scan")).map_err(|why| error(&page, why))?;
    let own = crate::root()?.join("js");
    for from in [package, &own.join("example"), &own.join("tests")] {
        copy(from, &page)?;
    }
    let names = copy(scan, &page.join("scan"))?;
    let (listener, address) = listen(0)?;
    let served = Arc::new(Served::of(&page)?);
    thread::spawn(move || answer_all(&listener, &served));
    let mut browser = Browser::start(program)?;
    browser.ask("Page.navigate", json!({ "url": address }))?;
    // The example itself.
    browser.wait("parseInt(document.getElementById('told')?.textContent) >= 1", PATIENCE)?;
    keep(&mut browser, pictures, "1-example")?;
    println!("npm: the example shows {}", browser.evaluate("document.getElementById('told').textContent")?);
    is_quiet(&browser, &address)?;
    for (name, given) in
        [("wrongs", vec![]), ("arrays", vec![]), ("scenes", vec![]), ("files", names), ("elsewhere", vec![])]
    {
        // Each in a browser of its own: one in which a processor stands in for a GPU stood still now and then after some dozen pictures.
        drop(browser);
        browser = Browser::start(program)?;
        call(&mut browser, &address, name, &given)?;
        is_quiet(&browser, &address)?;
    }
    drop(browser);
    let mut browser = Browser::start(program)?;
    call(&mut browser, &address, "controls", &[])?;
    for (kind, x, y, buttons) in [
        ("mousePressed", 100, 80, 1),
        ("mouseMoved", 160, 100, 1),
        ("mouseReleased", 160, 100, 0),
        ("mouseWheel", 160, 100, 0),
    ] {
        let mut event = json!({ "type": kind, "x": x, "y": y, "buttons": buttons, "clickCount": 1 });
        event["button"] =
            if kind == "mouseWheel" || kind == "mouseMoved" { json!("none") } else { json!("left") };
        if kind == "mouseWheel" {
            (event["deltaX"], event["deltaY"]) = (json!(0), json!(-200));
        }
        browser.ask("Input.dispatchMouseEvent", event)?;
    }
    browser.wait("window.moved >= 2", PATIENCE)?;
    browser.evaluate_within("window.view.rest().then(() => true)", LONGEST)?;
    keep(&mut browser, pictures, "2-turned")?;
    println!("npm: the mouse turns it");
    is_quiet(&browser, &address)
}

/// Calls a function of the trial's, in a page of its own.
fn call(browser: &mut Browser, address: &str, name: &str, given: &[String]) -> Result<(), String> {
    browser.ask("Page.navigate", json!({ "url": format!("{address}trial.html") }))?;
    browser
        .wait("location.pathname === '/trial.html' && document.getElementById('view') !== null", PATIENCE)?;
    let given = if given.is_empty() { String::new() } else { json!(given).to_string() };
    let call = format!("import('/trial.js').then((trial) => trial.{name}({given})).then(String)");
    let begin = Instant::now();
    let told = browser.evaluate_within(&call, LONGEST)?;
    println!("npm: {} ({:.0} s)", told.as_str().unwrap_or_default(), begin.elapsed().as_secs_f64());
    Ok(())
}

/// Copies the files of a folder, and tells their names.
fn copy(from: &Path, to: &Path) -> Result<Vec<String>, String> {
    let error = |error: std::io::Error| format!("{}: {error}", from.display());
    let mut names = vec![];
    for entry in fs::read_dir(from).map_err(error)? {
        let entry = entry.map_err(error)?;
        fs::copy(entry.path(), to.join(entry.file_name())).map_err(error)?;
        names.push(entry.file_name().to_string_lossy().into_owned());
    }
    names.sort();
    Ok(names)
}

fn keep(browser: &mut Browser, pictures: &Path, name: &str) -> Result<(), String> {
    let file = pictures.join(name).with_extension("png");
    fs::write(&file, browser.screenshot()?).map_err(|error| format!("{}: {error}", file.display()))
}

/// Nobody else was asked for anything, and nothing complained of but the file that there is not.
fn is_quiet(browser: &Browser, address: &str) -> Result<(), String> {
    let mut wrong = vec![];
    for event in &browser.events {
        let of = &event["params"];
        match event["method"].as_str().unwrap_or_default() {
            "Network.requestWillBeSent" => {
                let url = of["request"]["url"].as_str().unwrap_or_default();
                if !url.starts_with(address) && !url.starts_with("blob:") && !url.starts_with("data:") {
                    wrong.push(format!("it asks for {url}"));
                }
            }
            "Runtime.exceptionThrown" => wrong.push(of["exceptionDetails"].to_string()),
            "Runtime.consoleAPICalled" if of["type"] == "error" => wrong.push(of["args"].to_string()),
            "Log.entryAdded" if of["entry"]["level"] == "error" => {
                let entry = of["entry"].to_string();
                if !entry.contains("nowhere.wasm") && !entry.contains("favicon.ico") {
                    wrong.push(entry);
                }
            }
            _ => {}
        }
    }
    if wrong.is_empty() { Ok(()) } else { Err(format!("the page is not quiet:\n{}", wrong.join("\n"))) }
}
