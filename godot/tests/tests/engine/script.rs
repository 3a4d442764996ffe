//! `script/godot` on a machine without a display: whatever is asked for, it ends, and says how.
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
