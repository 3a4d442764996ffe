//! Stands where the extension looks for its decoders: leaves a mark beside itself (`NAME.marks`, a byte each time that
//! it is started for frames) and becomes the real program (`NAME.real`). Where there is `NAME.crash`, it takes that away
//! and crashes.

#[cfg(unix)]
fn main() -> std::io::Result<()> {
    use std::fs::{self, OpenOptions};
    use std::io::Write;
    use std::os::unix::{fs::FileTypeExt, process::CommandExt};
    use std::process::Command;

    let program = std::env::current_exe()?;
    // Frames come through a pipe. The extension's look whether it runs here has none.
    if fs::metadata("/dev/stdin")?.file_type().is_fifo() {
        let marks = program.with_extension("marks");
        OpenOptions::new().create(true).append(true).open(marks)?.write_all(b"|")?;
        if fs::remove_file(program.with_extension("crash")).is_ok() {
            std::process::abort();
        }
    }
    Err(Command::new(program.with_extension("real")).exec())
}

/// The engine tests run on Linux.
#[cfg(not(unix))]
fn main() {}
