//! `script/godot` on a machine without a display: whatever is asked for, it ends, and says how. And where it fetches an
//! engine from: the mirror, the proxy and the password are those of the machine's own apt.
//!
//! It runs in a folder of its own beside programs that only pretend: nothing is built, and no engine starts.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A checkout with the scripts alone, and a `PATH` whose first folder is `fake`.
struct Checkout(PathBuf);

impl Checkout {
    fn new(name: &str) -> Self {
        let root = Path::new(env!("CARGO_TARGET_TMPDIR")).join("script").join(name);
        let _ = fs::remove_dir_all(&root);
        for folder in ["script", "fake", "godot/demo", "target/release"] {
            fs::create_dir_all(root.join(folder)).unwrap();
        }
        let scripts = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../script");
        for script in ["godot", "godot.sh", "lib.sh"] {
            fs::copy(scripts.join(script), root.join("script").join(script)).unwrap();
        }
        for built in ["liblumivox_godot.so", "lumivox-codecs"] {
            fs::write(root.join("target/release").join(built), "").unwrap();
        }
        let checkout = Self(root);
        checkout.fake("cargo", "echo cargo 1.95.0");
        checkout.fake("strip", "");
        checkout.fake("Xvfb", "");
        checkout.fake("xvfb-run", "shift 3; exec \"$@\"");
        // -k 10, the limit, and what is run.
        checkout.fake("timeout", "echo \"limit $3\"; shift 3; exec \"$@\"");
        checkout
    }

    fn fake(&self, name: &str, does: &str) {
        let file = self.0.join("fake").join(name);
        fs::write(&file, format!("#!/bin/sh\n{does}\n")).unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o755)).unwrap();
    }

    /// Runs the script with an engine that does what is asked of it.
    fn run(&self, engine: &str, arguments: &[&str]) -> Output {
        let answers = "case \"$*\" in --version) echo 4.6.1; exit ;; *--import*) exit ;; esac";
        self.fake("engine", &format!("{answers}\n{engine}"));
        let fake = self.0.join("fake");
        let path = format!("{}:{}", fake.display(), std::env::var("PATH").unwrap());
        Command::new("bash")
            .arg(self.0.join("script/godot"))
            .args(arguments)
            .env("PATH", path)
            .env("GODOT", fake.join("engine"))
            // Any driver will do.
            .env("VK_DRIVER_FILES", "/dev/null")
            .env_remove("DISPLAY")
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("CARGO_TARGET_DIR")
            .output()
            .unwrap()
    }
}

fn said(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

/// Writes the picture that it is asked for.
const TAKES_A_PICTURE: &str = "for last; do :; done; touch \"$last\"";

#[test]
fn the_editor_without_a_display_is_refused_at_once() {
    let checkout = Checkout::new("editor");
    for arguments in [&["--editor"][..], &["-e"], &["res://main.tscn", "--editor"]] {
        let output = checkout.run(TAKES_A_PICTURE, arguments);
        assert!(said(&output).contains("The editor needs a display"), "{}", said(&output));
        assert_eq!(output.status.code(), Some(1));
    }
    let output = checkout.run("echo \"ran $*\"", &["--headless", "--editor", "--quit"]);
    assert!(said(&output).contains("ran --path godot/demo --headless --editor --quit"), "{}", said(&output));
    assert!(output.status.success());
}

#[test]
fn a_run_off_screen_ends_with_a_picture_or_an_error() {
    let checkout = Checkout::new("screen");
    let output = checkout.run(TAKES_A_PICTURE, &[]);
    assert!(output.status.success() && said(&output).contains("Done: "), "{}", said(&output));
    assert!(said(&output).contains("limit 240"), "{}", said(&output));
    // A picture of another run is none of this one.
    for (engine, word) in
        [("exit 0", "left no picture"), ("exit 3", "ended with 3"), ("exit 124", "not done")]
    {
        let output = checkout.run(engine, &[]);
        assert!(said(&output).contains(word), "{}", said(&output));
        assert_eq!(output.status.code(), Some(1), "{engine}");
    }
    let output = checkout.run(TAKES_A_PICTURE, &["--", "--seconds", "500"]);
    assert!(said(&output).contains("limit 590"), "{}", said(&output));
}

/// Sources of both kinds: one-line, with third parties, comments and a medium, and deb822, with a block that is off.
const ONE_LINE: &str = "\
deb [arch=amd64] http://mirror.example/debian bookworm main contrib
deb-src http://sources.example/debian bookworm main
# deb http://comment.example/debian bookworm main
deb http://mirror.example/debian bookworm-updates main
deb http://security.example/debian-security bookworm-security main
deb http://tools.example/linux bookworm stable
deb cdrom:[Debian]/ bookworm main
";
const DEB822: &str = "\
Types: deb deb-src
URIs: https://second.example/mirrors/debian
Suites: stable stable-updates
Components: main
Signed-By: /usr/share/keyrings/debian-archive-keyring.gpg

Enabled: no
Types: deb
URIs: http://off.example/debian
Suites: stable
Components: main
";

/// Apt's settings on a machine with those sources, which reaches them through a proxy.
fn apt_settings(checkout: &Checkout) -> PathBuf {
    let folder = checkout.0.join("apt");
    fs::create_dir_all(folder.join("parts")).unwrap();
    fs::write(folder.join("sources.list"), ONE_LINE).unwrap();
    fs::write(folder.join("parts/debian.sources"), DEB822).unwrap();
    let settings = format!(
        "Dir::Etc::sourcelist \"{0}/sources.list\";\nDir::Etc::sourceparts \"{0}/parts\";\n\
         Dir::State::lists \"{0}/lists\";\nAcquire::http::Proxy \"http://proxy.example:3128\";\n",
        folder.display()
    );
    fs::write(folder.join("apt.conf"), settings).unwrap();
    folder.join("apt.conf")
}

/// Runs what `script/godot` would, in the shell that it is written for, with those settings of apt.
fn in_bash(checkout: &Checkout, command: &str, environment: &[(&str, &str)]) -> Output {
    assert!(Path::new("/usr/bin/apt-get").exists(), "this test asks Debian's apt-get, and there is none");
    let path = format!("{}:{}", checkout.0.join("fake").display(), std::env::var("PATH").unwrap());
    Command::new("bash")
        .args(["-c", &format!("set -euo pipefail; . script/lib.sh; . script/godot.sh; {command}")])
        .current_dir(&checkout.0)
        .env_remove("GODOT")
        .env_remove("CARGO_TARGET_DIR")
        .env_remove("DEBIAN_MIRROR")
        .env("PATH", path)
        .env("APT_CONFIG", apt_settings(checkout))
        .envs(environment.iter().copied())
        .output()
        .unwrap()
}

fn system(checkout: &Checkout, name: &str, text: &str) -> String {
    let file = checkout.0.join(name);
    fs::write(&file, text).unwrap();
    file.display().to_string()
}

#[test]
fn debians_mirror_is_that_of_the_systems_own_sources() {
    let checkout = Checkout::new("mirror");
    let debian = system(&checkout, "debian", "NAME=Debian\nID=debian\nVERSION_CODENAME=bookworm\n");
    let ubuntu = system(&checkout, "ubuntu", "NAME=Ubuntu\nID=ubuntu\nID_LIKE=debian\n");
    let mirrors = |system: &str, environment: &[(&str, &str)]| {
        let output = in_bash(&checkout, &format!("debian_mirrors {system}"), environment);
        assert!(output.status.success(), "{}", said(&output));
        said(&output).lines().map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(
        mirrors(&debian, &[]),
        ["http://mirror.example/debian/", "https://second.example/mirrors/debian/"]
    );
    assert!(mirrors(&ubuntu, &[]).is_empty(), "{:?}", mirrors(&ubuntu, &[]));
    for system in [&debian, &ubuntu] {
        assert_eq!(
            mirrors(system, &[("DEBIAN_MIRROR", "http://asked.example/d")]),
            ["http://asked.example/d"]
        );
    }
}

/// An engine that is too old, wherever it is looked for, and an apt-get that only tells what it is asked.
fn without_an_engine(name: &str) -> Checkout {
    let checkout = Checkout::new(name);
    for engine in ["godot", "godot4", "godot-4"] {
        checkout.fake(engine, "echo 3.5");
    }
    let told = checkout.0.join("told").display().to_string();
    checkout.fake(
        "apt-get",
        &format!(
            "case $1 in -c) ;; *) exec /usr/bin/apt-get \"$@\" ;; esac\n\
             cat sources.list >>{told}\n\
             apt-config -c \"$2\" dump Acquire::http::Proxy >>{told}\nexit 100"
        ),
    );
    checkout
}

#[test]
fn an_engine_is_fetched_through_the_systems_own_proxy_signed_by_debian() {
    let checkout = without_an_engine("fetch");
    let keyring = system(&checkout, "keyring.gpg", "");
    let command = format!(
        "DEBIAN_KEYRING={keyring}; debian_mirrors() {{ echo http://a.example/d http://b.example/d; }}; need_godot"
    );
    let output = in_bash(&checkout, &command, &[]);
    assert_eq!(output.status.code(), Some(1));
    assert!(said(&output).contains("could not be fetched from http://b.example/d"), "{}", said(&output));
    let source = |mirror| format!("deb [signed-by={keyring}] {mirror} forky main");
    let proxy = "Acquire::http::Proxy \"http://proxy.example:3128\";";
    let told = fs::read_to_string(checkout.0.join("told")).unwrap();
    let lines: Vec<_> = told.lines().collect();
    assert_eq!(lines, [&source("http://a.example/d")[..], proxy, &source("http://b.example/d"), proxy]);
}

#[test]
fn a_system_that_names_no_mirror_is_told_how_to() {
    let checkout = without_an_engine("no_mirror");
    let keyring = system(&checkout, "keyring.gpg", "");
    let command = format!("DEBIAN_KEYRING={keyring}; debian_mirrors() {{ :; }}; need_godot");
    let output = in_bash(&checkout, &command, &[]);
    assert_eq!(output.status.code(), Some(1));
    let said = said(&output);
    for words in ["apt's sources name no mirror of Debian", "DEBIAN_MIRROR=URI", "GODOT=/path/to/godot"] {
        assert!(said.contains(words), "{said}");
    }
    assert!(!checkout.0.join("told").exists(), "something was fetched all the same");
}

#[test]
fn no_script_names_a_host_to_fetch_packages_from() {
    // An engine's and a toolchain's own pages, for people.
    let known = ["godotengine.org", "sh.rustup.rs"];
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let files =
        ["script", "script/ci"].into_iter().flat_map(|folder| fs::read_dir(root.join(folder)).unwrap());
    for path in files.map(|entry| entry.unwrap().path()).filter(|path| path.is_file()) {
        let text = fs::read_to_string(&path).unwrap();
        for (at, _) in text.match_indices("://") {
            let host =
                text[at + 3..].split(|c: char| !(c.is_alphanumeric() || ".-".contains(c))).next().unwrap();
            // A path in a project is no host's.
            assert!(text[..at].ends_with("res") || known.contains(&host), "{} names {host}", path.display());
        }
    }
}
