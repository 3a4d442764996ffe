//! Project chores: `cargo xtask ci` runs what CI runs, `cargo xtask layers` checks which crate may import which,
//! `cargo xtask unity-kernels` writes the kernels as Unity takes them, `cargo xtask unity-border` what C# calls.

mod ci;
mod floors;
mod layers;
mod package;
mod seam;
mod unity_border;
mod unity_branch;
mod unity_kernels;
mod unity_kernels_hlsl;
mod unity_metas;
mod web;
mod windows;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

const HELP: &str = "\
Usage: cargo xtask <COMMAND>

Commands:
  ci      Format check, clippy, import rules, tests, documentation, licences: what CI runs
  ci --all                  The same, and the slow tests
  layers  Check that imports between the crates go one way, and between the importer's floors, and that clock
          and threads are the host's
  package all OUT           Make all that people install in the folder OUT, for Linux, and for Windows what script/windows
                            made before: the command, the Studio, packages for Debian, Godot, Unity and Python, crates,
                            checksums
  package command OUT, package studio OUT, package godot OUT, package python OUT, package crates OUT
                            Make a part of it
  package web OUT, package npm OUT
                            Make what is for browsers: the Studio's page, the npm package
  package unity OUT         Make the Unity package alone, of this system's library, on any system
    --from DIR              With this system's programs and libraries from a folder as they are
    --windows DIR           With those for Windows from another folder than target/windows/dist; the Unity package
                            alone has none but of a folder that is named
    --library FILE...       With those of other systems in the Unity package, too, that were built there:
                            liblumivox_unity.dylib, lumivox_unity.dll, and lumivox-codecs as it is called there
    --upm BRANCH            Commit the Unity package to a branch of its own, too, for installations by a git URL
  unity-border              Write the C# structs and functions of the Unity package's border of those in Rust
  unity-border --check      Fail where they are not what would be written
  unity-kernels             Write the Unity package's kernels, which git does not hold, and the table and list of them
  unity-kernels --listed    Write the kernels alone, or fail where table and list are not theirs
  unity-kernels --check     Fail where table and list are not what would be written
  unity-kernels --stills DIR
                            Write the kernels of stills there, for tests
  unity-kernels --all DIR   Write every kernel of every view there, for tests
  unity-metas               Give each file of the Unity package its identifier
  unity-metas --check       Fail where one is missing, left over or there twice
  web serve FOLDER [PORT]   Serve a page, which script/studio --web makes, to this machine
  web test FOLDER BROWSER SCAN PICTURES
                            Try that page in a Chromium that nobody sees: first start, a phantom, SCAN dropped, no network;
                            its screenshots go to the folder PICTURES
  web smoke FOLDER BROWSER SCAN PICTURES
                            Try no more than whether it shows a phantom and SCAN
  web test-npm FOLDER BROWSER SCAN PICTURES
                            Try the npm package, which script/js makes, in the same way
  web kernels BROWSER       Fail where the compiler of a Chromium that nobody sees refuses a kernel that browsers may be given,
                            or is ended by it
  web kernels --every BROWSER
                            The same with every set of constants that there is: ten minutes more
  windows HERE THERE        Fail where the command THERE, for Windows, run by the program LUMIVOX_WINE, does not do what
                            the command HERE does: exit codes, words and files
  windows --first HERE THERE
                            The same, on a few runs

Exit codes: 0 all is well, 1 a check failed, 2 wrong usage";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let result = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["ci"] => ci::run(ci::Scope::Usual),
        ["ci", "--all"] => ci::run(ci::Scope::All),
        ["layers"] => layers::run(),
        ["unity-border"] => unity_border::write(),
        ["unity-border", "--check"] => unity_border::check(),
        ["unity-kernels"] => unity_kernels::write(),
        ["unity-kernels", "--listed"] => unity_kernels::write_listed(),
        ["unity-kernels", "--check"] => unity_kernels::check(),
        ["unity-kernels", "--stills", folder] => unity_kernels::write_stills(Path::new(folder)),
        ["unity-kernels", "--all", folder] => unity_kernels::write_all(Path::new(folder)),
        ["package", part, out, ref options @ ..] if !out.starts_with('-') => {
            match packing(part, Path::new(out), options) {
                Some(result) => result,
                None => {
                    eprintln!("{HELP}");
                    return ExitCode::from(2);
                }
            }
        }
        ["unity-metas"] => unity_metas::write(),
        ["unity-metas", "--check"] => unity_metas::check(),
        ["web", "serve", folder] => web::serve(Path::new(folder), 8080),
        ["web", "serve", folder, port] if port.parse::<u16>().is_ok() => {
            web::serve(Path::new(folder), port.parse().unwrap_or_default())
        }
        ["web", "test", folder, browser, scan, pictures] => {
            let extent = web::Extent::Whole;
            web::test(extent, Path::new(folder), Path::new(browser), Path::new(scan), Path::new(pictures))
        }
        ["web", "smoke", folder, browser, scan, pictures] => {
            let extent = web::Extent::First;
            web::test(extent, Path::new(folder), Path::new(browser), Path::new(scan), Path::new(pictures))
        }
        ["web", "test-npm", folder, browser, scan, pictures] => {
            web::test_npm(Path::new(folder), Path::new(browser), Path::new(scan), Path::new(pictures))
        }
        ["web", "kernels", browser] => web::test_kernels(web::Texts::Usual, Path::new(browser)),
        ["web", "kernels", "--every", browser] => web::test_kernels(web::Texts::Every, Path::new(browser)),
        ["windows", here, there] => windows::compare(Path::new(here), Path::new(there), true),
        ["windows", "--first", here, there] => windows::compare(Path::new(here), Path::new(there), false),
        ["help" | "--help" | "-h"] => {
            println!("{HELP}");
            Ok(())
        }
        _ => {
            eprintln!("{HELP}");
            return ExitCode::from(2);
        }
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("\nxtask: {message}");
            ExitCode::FAILURE
        }
    }
}

/// Makes a package, where the words make sense.
fn packing(part: &str, out: &Path, options: &[&str]) -> Option<Result<(), String>> {
    let options = package::Options::parse(options)?;
    if part == "unity" {
        return Some(package::unity(out, &options));
    }
    Some(package::make(&package::Part::named(part)?, out, &options))
}

/// The project's folder, around the one in which this was called.
fn root() -> Result<PathBuf, String> {
    let here = std::env::current_dir().map_err(|error| error.to_string())?;
    let found = here.ancestors().find(|folder| folder.join("xtask/Cargo.toml").exists());
    found.map(Path::to_owned).ok_or_else(|| format!("{} is in no folder of Lumivox", here.display()))
}
