//! Ctrl-C and SIGTERM, whenever they come: what was rendered is kept.
#![cfg(unix)]

use std::{
    fs,
    io::{BufRead, BufReader, Lines},
    path::Path,
    process::{Child, ChildStderr, Command, Stdio},
    thread,
    time::Duration,
};

/// Signals further apart are wishes of their own.
const APART: Duration = Duration::from_millis(400);

fn folder_with_scan() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    let phantom = ["phantom", "sphere", "--size", "24", "--out", "scan", "--quiet"];
    let made = Command::new(env!("CARGO_BIN_EXE_lumivox")).current_dir(folder.path()).args(phantom).status();
    assert!(made.is_ok_and(|status| status.success()));
    folder
}

/// A render of `scan` to `a.png`, and its words from the line on that begins so.
fn render(folder: &Path, more: &[&str], from: &str) -> (Child, Lines<BufReader<ChildStderr>>) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_lumivox"))
        .current_dir(folder)
        .args(["render", "scan", "-o", "a.png"])
        .args(more)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    let mut lines = BufReader::new(child.stderr.take().expect("a pipe")).lines();
    assert!(lines.by_ref().map_while(Result::ok).any(|line| line.starts_with(from)), "'{from}' is said");
    (child, lines)
}

fn signal(child: &Child, name: &str) {
    let killed = Command::new("kill").args([name, &child.id().to_string()]).status();
    assert!(killed.is_ok_and(|status| status.success()));
}

/// Its exit code, and what else it said.
fn end(mut child: Child, lines: Lines<BufReader<ChildStderr>>) -> (Option<i32>, String) {
    let rest: Vec<String> = lines.map_while(Result::ok).collect();
    (child.wait().expect("it ends").code(), rest.join("\n"))
}

fn size(folder: &Path) -> [u32; 2] {
    let file = BufReader::new(fs::File::open(folder.join("a.png")).expect("the picture is there"));
    let mut reader = png::Decoder::new(file).read_info().expect("it is a PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    reader.next_frame(&mut pixels).expect("it is whole");
    let info = reader.info();
    [info.width, info.height]
}

/// `timeout` sends its signal twice in a row, and who is impatient presses twice: neither loses the picture.
#[test]
fn a_second_signal_does_not_lose_the_picture() {
    let folder = folder_with_scan();
    for (name, pause) in [("-INT", Duration::ZERO), ("-TERM", Duration::ZERO), ("-INT", APART)] {
        let (child, lines) = render(
            folder.path(),
            &["--size", "1500x1500", "--bounces", "1000", "--time", "600"],
            "tracing on",
        );
        thread::sleep(Duration::from_secs(1));
        signal(&child, name);
        thread::sleep(pause);
        signal(&child, name);
        let (code, said) = end(child, lines);
        assert_eq!(code, Some(130), "{said}");
        assert!(said.contains("stopping; the picture is saved as it is"), "{said}");
        assert!(said.contains("Stopped early.") && said.contains("What there was is in a.png"), "{said}");
        assert_eq!(size(folder.path()), [1500, 1500]);
        fs::remove_file(folder.path().join("a.png")).unwrap();
    }
}

/// Whoever stops it while it is denoised gets what was asked for; whoever insists has it at once, with its noise.
#[test]
fn denoising_is_finished_or_left_out_and_the_picture_is_saved() {
    let folder = folder_with_scan();
    // Done within the time that it is given, on a busy machine, too.
    let options = ["--size", "300x300", "--zoom", "0.1", "--samples", "1", "--denoise"];
    let (child, lines) = render(folder.path(), &options, "denoising");
    signal(&child, "-INT");
    let (code, said) = end(child, lines);
    assert_eq!((code, said.as_str()), (Some(0), "stopping; the picture is saved as it is"));
    assert_eq!(size(folder.path()), [300, 300]);

    fs::remove_file(folder.path().join("a.png")).unwrap();
    let (child, lines) = render(folder.path(), &options, "denoising");
    signal(&child, "-INT");
    thread::sleep(APART);
    signal(&child, "-INT");
    let (code, said) = end(child, lines);
    if code != Some(0) {
        assert_eq!(code, Some(130), "{said}");
        assert!(said.contains("once more ends at once, without it"), "{said}");
        assert!(said.contains("Stopped before it was denoised.") && said.contains("is in a.png"), "{said}");
    }
    assert_eq!(size(folder.path()), [300, 300]);
}
