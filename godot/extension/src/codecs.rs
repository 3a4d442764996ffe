//! The program that decodes JPEG-LS and JPEG 2000 beside the extension: a file that crashes such a decoder costs its
//! slice, not the editor or the game. A library inside an engine cannot run itself a second time, as the command does.

use std::env::consts::{ARCH, EXE_SUFFIX, OS as SYSTEM};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Once, OnceLock};

use godot::classes::Os;
use godot::obj::Singleton;
use lumivox_import::CodecWorker;

use crate::convert;

/// Where the program may be.
static PLACES: OnceLock<Vec<PathBuf>> = OnceLock::new();

/// The engine is up: finds out where the program may be.
pub fn start() {
    let name = format!("lumivox-codecs{EXE_SUFFIX}");
    let folder = match (SYSTEM, ARCH) {
        ("macos", _) => "macos".to_owned(),
        (system, "aarch64") => format!("{system}.arm64"),
        (system, arch) => format!("{system}.{arch}"),
    };
    let in_project = format!("res://addons/lumivox/bin/{folder}/{name}");
    let mut places = vec![convert::system_path(&in_project.as_str().into())];
    // An exported game has what the addon's libraries depend on beside its program.
    let game = PathBuf::from(Os::singleton().get_executable_path().to_string());
    if let Some(folder) = game.parent() {
        places.push(folder.join(&name));
        if cfg!(target_os = "macos") {
            places.push(folder.join("../Frameworks").join(&name));
        }
    }
    // A game without a project's folder makes `res://` the folder that it was started in, which may be anyone's.
    places.retain(|place| place.is_absolute());
    let _ = PLACES.set(places);
}

/// Before anything is decoded: names the program, if there is one that runs. Without, decoders run in this process.
pub fn name_worker() {
    static NAMED: Once = Once::new();
    let Some(places) = PLACES.get() else { return };
    NAMED.call_once(|| {
        if let Some(program) = places.iter().find(|place| runs(place)) {
            let arguments: [&str; 0] = [];
            lumivox_import::set_codec_worker(Some(CodecWorker::new(program, arguments)));
        }
    });
}

/// Whether this is a program that runs here. One that is asked for nothing ends at once, and well.
fn runs(program: &Path) -> bool {
    if !program.is_file() {
        return false;
    }
    make_executable(program);
    let mut command = Command::new(program);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    // A program without a console would get one to see.
    #[cfg(windows)]
    std::os::windows::process::CommandExt::creation_flags(&mut command, 0x0800_0000);
    command.status().is_ok_and(|status| status.success())
}

/// An export copies files without this permission. Where it cannot be given, the program does not run.
fn make_executable(program: &Path) {
    #[cfg(unix)]
    if let Ok(metadata) = program.metadata() {
        use std::os::unix::fs::PermissionsExt;
        let mut permissions = metadata.permissions();
        let mode = permissions.mode();
        if mode & 0o111 == 0 {
            // Whoever may read it may run it.
            permissions.set_mode(mode | (mode & 0o444) >> 2);
            let _ = std::fs::set_permissions(program, permissions);
        }
    }
    #[cfg(not(unix))]
    let _ = program;
}
