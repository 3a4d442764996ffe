//! What `cargo xtask package` makes, installed into empty places and used there.
//!
//! It packs what the workspace's tests were built of; `script/test --all` builds for old systems, as releases are.
#![cfg(target_os = "linux")]

use std::collections::BTreeSet;
use std::fs;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use serde_json::Value;

const VERSION: &str = env!("CARGO_PKG_VERSION");

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().unwrap()
}

/// A folder of this run's own, made anew.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// What was built: programs in the folder above that of tests, libraries beside these.
fn native() -> &'static Path {
    static NATIVE: OnceLock<PathBuf> = OnceLock::new();
    NATIVE.get_or_init(gather)
}

fn gather() -> PathBuf {
    let deps = std::env::current_exe().unwrap().parent().unwrap().to_owned();
    let folder = folder("packages-native");
    for (from, name) in [
        ("../lumivox", "lumivox"),
        ("../lumivox-codecs", "lumivox-codecs"),
        ("../lumivox-studio", "lumivox-studio"),
        ("liblumivox_godot.so", "liblumivox_godot.so"),
        ("liblumivox_unity.so", "liblumivox_unity.so"),
    ] {
        let from = deps.join(from);
        assert!(
            from.is_file(),
            "{}: run 'cargo build --release --workspace --bins' and 'cargo test --release --workspace --no-run' before",
            from.display()
        );
        // As what is released is: names are half of it, and take as long to pack.
        succeeds(Command::new("strip").arg(&from).arg("-o").arg(folder.join(name)));
    }
    folder
}

/// What stands for programs and libraries for Windows: all of them that packing looks at. `script/windows` makes real ones.
fn for_windows() -> PathBuf {
    let folder = folder("packages-windows");
    let mut program = vec![0; 0x80];
    program[..2].copy_from_slice(b"MZ");
    program[0x3c] = 0x80;
    program.extend(b"PE\0\0\x64\x86");
    for (name, words) in [
        ("lumivox.exe", ""),
        ("lumivox-studio.exe", ""),
        ("lumivox-codecs.exe", ""),
        ("lumivox_godot.dll", "gdext_rust_init"),
        ("lumivox_unity.dll", "lumivox_abi_version"),
        (&wheel_for_windows(), ""),
    ] {
        fs::write(folder.join(name), [&program, words.as_bytes()].concat()).unwrap();
    }
    folder
}

fn wheel_for_windows() -> String {
    format!("lumivox-{VERSION}-cp310-abi3-win_amd64.whl")
}

fn xtask(words: &[&str], out: &Path, options: &[&Path]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_xtask"));
    command.arg("package").args(words).arg(out).current_dir(root());
    for (name, value) in ["--from", "--windows"].iter().zip(options) {
        command.arg(name).arg(value);
    }
    command.output().unwrap()
}

/// All packages, of what was built.
fn packed() -> &'static Path {
    static PACKED: OnceLock<PathBuf> = OnceLock::new();
    PACKED.get_or_init(|| {
        let out = folder("packages");
        let output = xtask(&["all"], &out, &[native(), &for_windows()]);
        assert!(output.status.success(), "{}", words(&output));
        out
    })
}

fn words(output: &Output) -> String {
    [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned()).concat()
}

fn succeeds(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    assert!(output.status.success(), "{command:?}: {}", words(&output));
    words(&output)
}

/// The command of the archive, unpacked.
fn unpacked() -> &'static Path {
    static UNPACKED: OnceLock<PathBuf> = OnceLock::new();
    UNPACKED.get_or_init(|| {
        let folder = folder("packages-unpacked");
        let archive = packed().join(format!("lumivox-{VERSION}-x86_64-linux.tar.xz"));
        succeeds(Command::new("tar").arg("-xJf").arg(archive).arg("-C").arg(&folder));
        folder.join(format!("lumivox-{VERSION}-x86_64-linux"))
    })
}

/// A root with a program in it, and the libraries that it is linked to; returns these.
fn bare_root(name: &str, program: &Path) -> (PathBuf, BTreeSet<String>) {
    let root = folder(name);
    let put = |file: &Path| {
        let place = root.join(file.strip_prefix("/").unwrap());
        fs::create_dir_all(place.parent().unwrap()).unwrap();
        fs::copy(file, place).unwrap();
    };
    let linked = succeeds(Command::new("ldd").arg(program));
    let paths = linked.split_whitespace().filter(|word| word.starts_with('/'));
    let libraries: BTreeSet<PathBuf> = paths.map(PathBuf::from).collect();
    libraries.iter().for_each(|library| put(library));
    for name in ["data", "tmp", "dev", "bin"] {
        fs::create_dir_all(root.join(name)).unwrap();
    }
    fs::copy(program, root.join("bin/lumivox")).unwrap();
    let names = libraries.iter().map(|path| path.file_name().unwrap().to_str().unwrap().to_owned());
    (root, names.collect())
}

/// Runs the command with nothing around it but that root.
fn alone(root: &Path, words: &[&str]) -> Output {
    // Who is root needs no names of users of their own, which containers may forbid.
    let is_root = succeeds(Command::new("id").arg("-u")).trim() == "0";
    let mut command = Command::new(if is_root { "chroot" } else { "unshare" });
    if !is_root {
        command.args(["--map-root-user", "chroot"]);
    }
    command
        .arg(root)
        .arg("/bin/lumivox")
        .args(words)
        .env_clear()
        .env("PATH", "/usr/sbin:/usr/bin:/sbin:/bin");
    command.output().unwrap()
}

/// What a person does first, in a place with nothing but a C library.
fn use_alone(root: &Path) {
    let said = |words: &[&str]| {
        let output = alone(root, words);
        assert!(output.status.success(), "{words:?}: {}", self::words(&output));
        self::words(&output)
    };
    assert_eq!(said(&["--version"]).trim(), format!("lumivox {VERSION}"));
    assert!(said(&["presets"]).contains("ct-bone"));
    said(&["phantom", "head", "--size", "24", "--out", "/data/scan"]);
    let imported: Value = serde_json::from_str(&said(&["import", "/data/scan", "--json"])).unwrap();
    assert!(imported.to_string().contains("CT"), "{imported}");
    assert!(said(&["info", "/data/scan"]).contains("24"));
    // Pictures need a driver, which is not there: what it says is what helps.
    let output = alone(root, &["render", "/data/scan", "-o", "/data/head.png"]);
    let said = words(&output);
    assert_eq!(output.status.code(), Some(4), "{said}");
    assert!(said.contains("Vulkan") && said.contains("'lumivox doctor' says what to install"), "{said}");
    assert!(!root.join("data/head.png").exists());
    let said = words(&alone(root, &["doctor"]));
    assert!(said.contains("mesa-vulkan-drivers"), "{said}");
}

#[test]
fn the_command_runs_where_there_is_nothing_but_a_c_library() {
    let (root, libraries) = bare_root("packages-root", &unpacked().join("bin/lumivox"));
    // This build has the C++ library of this system; a release has it inside.
    let known = [
        "libc.so.6",
        "libm.so.6",
        "libdl.so.2",
        "libpthread.so.0",
        "librt.so.1",
        "ld-linux-x86-64.so.2",
        "libgcc_s.so.1",
        "libstdc++.so.6",
    ];
    assert!(libraries.iter().all(|name| known.contains(&name.as_str())), "{libraries:?}");
    use_alone(&root);
}

#[test]
fn the_archive_has_a_manual_and_completions_that_shells_read() {
    let folder = unpacked();
    let text = |path: &str| fs::read_to_string(folder.join(path)).unwrap_or_else(|e| panic!("{path}: {e}"));
    let page = text("share/man/man1/lumivox-render.1");
    assert!(page.starts_with(".ie") || page.contains(".TH LUMIVOX-RENDER 1"), "{page}");
    assert!(page.contains("azimuth") && !text("share/man/man1/lumivox.1").contains("manual"));
    let bash = folder.join("share/bash-completion/completions/lumivox");
    let completed = |word: &str| {
        let script = format!(
            ". '{}'; COMP_WORDS=(lumivox {word}); COMP_CWORD=1; _lumivox lumivox '{word}' lumivox; echo ${{COMPREPLY[@]}}",
            bash.display()
        );
        succeeds(Command::new("bash").args(["-c", &script])).trim().to_owned()
    };
    assert_eq!((completed("pre").as_str(), completed("man").as_str()), ("presets", ""));
    for path in [
        "share/bash-completion/completions/lumivox",
        "share/zsh/site-functions/_lumivox",
        "share/fish/vendor_completions.d/lumivox.fish",
    ] {
        assert!(text(path).contains("azimuth") && !text(path).contains("manual"), "{path}");
    }
    let readme = text("README.txt");
    assert!(readme.contains(VERSION) && readme.lines().count() < 60, "{readme}");
    assert!(text("LICENSE-MIT").contains("MIT License") && text("LICENSE-APACHE").contains("Apache License"));
    assert!(text("CHANGES.md").contains(&format!("# Lumivox {VERSION}")));
}

#[test]
fn whose_works_are_in_it_is_told_for_each_package() {
    let notice = fs::read_to_string(unpacked().join("THIRD-PARTY-LICENSES.txt")).unwrap();
    for (bill, wanted, unwanted) in [
        (
            format!("lumivox-{VERSION}-x86_64-linux.cdx.json"),
            &["wgpu", "clap", "openjpeg-sys"][..],
            &["godot"][..],
        ),
        (
            format!("lumivox-studio-{VERSION}-x86_64-linux.cdx.json"),
            &["egui", "winit", "wgpu", "openjpeg-sys"],
            &["clap", "godot-core", "js-sys"],
        ),
        (format!("lumivox-godot-{VERSION}.cdx.json"), &["godot-core", "openjpeg-sys"], &["clap", "pyo3"]),
        (
            format!("com.lumivox-{VERSION}.cdx.json"),
            &["lumivox-unity", "openjpeg-sys"],
            &["wgpu", "godot-core"],
        ),
        (format!("lumivox-python-{VERSION}.cdx.json"), &["pyo3", "wgpu"], &["clap", "godot-core"]),
    ] {
        let text = fs::read_to_string(packed().join(&bill)).unwrap();
        let said: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(
            (said["bomFormat"].as_str(), said["specVersion"].as_str()),
            (Some("CycloneDX"), Some("1.6"))
        );
        let parts = said["components"].as_array().unwrap();
        let names: BTreeSet<&str> = parts.iter().map(|part| part["name"].as_str().unwrap()).collect();
        assert!(wanted.iter().all(|name| names.contains(name)), "{bill}: {names:?}");
        assert!(!unwanted.iter().any(|name| names.contains(name)), "{bill}: {names:?}");
        assert!(parts.iter().all(|part| part["purl"].as_str().unwrap().starts_with("pkg:")), "{bill}");
        let references: BTreeSet<&str> = parts.iter().map(|part| part["bom-ref"].as_str().unwrap()).collect();
        for hangs in said["dependencies"].as_array().unwrap() {
            let all = hangs["dependsOn"].as_array().unwrap();
            assert!(all.iter().all(|one| references.contains(one.as_str().unwrap())), "{bill}: {hangs}");
        }
        if bill.starts_with("lumivox-0") {
            let ours = |name: &&&str| name.starts_with("lumivox");
            for name in names.iter().filter(|name| !ours(name)) {
                assert!(notice.contains(&format!("\n{name} ")), "{name} is in {bill}, and not in the notice");
            }
        }
    }
}

#[test]
fn checksums_are_those_of_all_that_was_made() {
    let said = succeeds(Command::new("sha256sum").args(["--check", "SHA256SUMS"]).current_dir(packed()));
    assert!(said.lines().count() > 15 && said.lines().all(|line| line.ends_with(": OK")), "{said}");
    let listed = fs::read_to_string(packed().join("SHA256SUMS")).unwrap();
    for entry in fs::read_dir(packed()).unwrap().map(|entry| entry.unwrap()) {
        let name = entry.file_name().into_string().unwrap();
        assert!(name == "SHA256SUMS" || listed.contains(&name), "{name} has no checksum");
    }
    for library in ["core", "import", "wgpu"] {
        assert!(listed.contains(&format!("  crates/lumivox-{library}-{VERSION}.crate")), "{listed}");
    }
}

#[test]
fn debian_packages_are_installed_by_dpkg() {
    for name in ["lumivox", "lumivox-studio"] {
        let package = packed().join(format!("{name}_{VERSION}_amd64.deb"));
        let root = folder(&format!("packages-debian-{name}"));
        for name in ["info", "updates", "triggers"] {
            fs::create_dir_all(root.join("var/lib/dpkg").join(name)).unwrap();
        }
        fs::write(root.join("var/lib/dpkg/status"), "").unwrap();
        // Its own list of what is installed knows no C library.
        // Some people have no programs of administrators in PATH, and it wants them.
        let path = format!("{}:/usr/sbin:/sbin", std::env::var("PATH").unwrap());
        let mut dpkg = Command::new("dpkg");
        dpkg.env("PATH", &path)
            .args(["--force-not-root", "--force-script-chrootless", "--force-depends", "--root"])
            .arg(&root);
        succeeds(dpkg.arg("--log=/dev/null").arg("--install").arg(&package));
        let said = succeeds(Command::new("dpkg").arg("--root").arg(&root).args(["--status", name]));
        assert!(said.contains("Status: install ok installed") && said.contains("libc6 (>= 2.28)"), "{said}");
        let program = root.join("usr/bin").join(name);
        let version = succeeds(Command::new(&program).arg("--version"));
        assert_eq!(version.trim(), format!("{name} {VERSION}"));
        let doc = format!("usr/share/doc/{name}");
        let mut packed = vec![format!("{doc}/changelog.gz")];
        match name {
            "lumivox" => packed.push("usr/share/man/man1/lumivox.1.gz".to_owned()),
            // What menus start, and by which icon they show it.
            _ => {
                let entry = fs::read_to_string(root.join("usr/share/applications/lumivox-studio.desktop"));
                assert!(entry.unwrap().contains("\nExec=lumivox-studio %F\nIcon=lumivox-studio\n"));
                let icon = root.join("usr/share/icons/hicolor/scalable/apps/lumivox-studio.svg");
                assert!(fs::read_to_string(icon).unwrap().starts_with("<svg"));
            }
        }
        for path in packed {
            succeeds(Command::new("gzip").arg("--test").arg(root.join(path)));
        }
        let copyright = fs::read_to_string(root.join(doc).join("copyright")).unwrap();
        assert!(copyright.contains("MIT License") && copyright.contains("openjpeg-sys"));
        let mut dpkg = Command::new("dpkg");
        dpkg.env("PATH", &path).args(["--force-not-root", "--log=/dev/null", "--root"]).arg(&root);
        succeeds(dpkg.args(["--purge", name]));
        assert!(!program.exists());
    }
}

/// How many colours a screen of Xvfb's has, none where most of it is black as without a window. It keeps it in a file (X Window Dump,
/// version 7): 100 numbers of 32 bits, the first is the header's length, the 20th the colours of a palette of 12 bytes each, then
/// pixels.
fn colors(screen: &Path) -> usize {
    let bytes = fs::read(screen).unwrap_or_default();
    let number = |place: usize| {
        let own = bytes.get(4 * place..4 * place + 4);
        own.map_or(0, |own| u32::from_be_bytes(own.try_into().unwrap()) as usize)
    };
    let pixels = bytes.get(number(0) + 12 * number(19)..).unwrap_or_default();
    let pixels: Vec<[u8; 3]> = pixels.chunks_exact(4).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    let is_filled = 2 * pixels.iter().filter(|pixel| **pixel == [0; 3]).count() < pixels.len();
    if is_filled { pixels.into_iter().collect::<BTreeSet<_>>().len() } else { 0 }
}

#[test]
fn the_studio_opens_where_it_was_unpacked() {
    let place = folder("packages-studio");
    let archive = packed().join(format!("lumivox-studio-{VERSION}-x86_64-linux.tar.xz"));
    succeeds(Command::new("tar").arg("-xJf").arg(archive).arg("-C").arg(&place));
    let unpacked = place.join(format!("lumivox-studio-{VERSION}-x86_64-linux"));
    let readme = fs::read_to_string(unpacked.join("README.txt")).unwrap();
    assert!(readme.contains(VERSION) && readme.lines().count() < 60, "{readme}");
    let program = unpacked.join("bin/lumivox-studio");
    let [scan, screen] = ["scan", "screen"].map(|name| place.join(name));
    fs::create_dir(&screen).unwrap();
    succeeds(
        Command::new(native().join("lumivox")).args(["phantom", "head", "--size", "32", "--out"]).arg(&scan),
    );
    // With nothing of this person's, in a group of its own, which ends with it.
    let mut studio = Command::new("xvfb-run");
    studio.args(["-a", "-s"]).arg(format!("-screen 0 1440x900x24 -fbdir {}", screen.display()));
    studio.arg(&program).arg(&scan).env("HOME", &place).env("XDG_CONFIG_HOME", place.join("config"));
    let log = fs::File::create(place.join("log")).unwrap();
    studio.stdout(log.try_clone().unwrap()).stderr(log).process_group(0);
    let mut studio = studio.spawn().unwrap();
    let said = || fs::read_to_string(place.join("log")).unwrap();
    let begin = Instant::now();
    let mut ended = None;
    // An empty screen has one colour, letters have some dozens, and a slice has all greys.
    while colors(&screen.join("Xvfb_screen0")) < 150 && ended.is_none() && begin.elapsed().as_secs() < 180 {
        std::thread::sleep(Duration::from_millis(200));
        ended = studio.try_wait().unwrap();
    }
    let seen = colors(&screen.join("Xvfb_screen0"));
    succeeds(Command::new("cp").arg(screen.join("Xvfb_screen0")).arg(place.join("seen.xwd")));
    let group = format!("-{}", studio.id());
    let _ = Command::new("kill").args(["-TERM", "--", &group]).status();
    studio.wait().unwrap();
    assert!(ended.is_none() && seen >= 150, "{ended:?}, {seen} colours: {}", said());
}

/// The files of a ZIP archive, with their modes.
fn listed(name: &str) -> Vec<(String, u32)> {
    let file = fs::File::open(packed().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
    let mut archive = zip::ZipArchive::new(file).unwrap();
    let count = archive.len();
    let entry = |at| {
        let file = archive.by_index(at).unwrap();
        (file.name().unwrap().into_owned(), file.unix_mode().unwrap() & 0o777)
    };
    (0..count).map(entry).collect()
}

#[test]
fn what_is_for_windows_lies_where_it_is_looked_for() {
    let folder = format!("lumivox-{VERSION}-x86_64-windows");
    let files = listed(&format!("{folder}.zip"));
    for name in
        ["lumivox.exe", "README.txt", "completions/lumivox.ps1", "LICENSE-MIT", "THIRD-PARTY-LICENSES.txt"]
    {
        assert!(files.iter().any(|(file, _)| *file == format!("{folder}/{name}")), "no {name}: {files:?}");
    }
    let folder = format!("lumivox-studio-{VERSION}-x86_64-windows");
    let files = listed(&format!("{folder}.zip"));
    for name in ["lumivox-studio.exe", "README.txt", "LICENSE-MIT", "THIRD-PARTY-LICENSES.txt"] {
        assert!(files.iter().any(|(file, _)| *file == format!("{folder}/{name}")), "no {name}: {files:?}");
    }
    let files = listed(&format!("lumivox-godot-{VERSION}.zip"));
    for (name, mode) in [
        ("bin/linux.x86_64/liblumivox_godot.so", 0o755),
        ("bin/linux.x86_64/lumivox-codecs", 0o755),
        ("bin/windows.x86_64/lumivox_godot.dll", 0o755),
        ("bin/windows.x86_64/lumivox-codecs.exe", 0o755),
        ("lumivox.gdextension", 0o644),
    ] {
        let wanted = (format!("addons/lumivox/{name}"), mode);
        assert!(files.contains(&wanted), "no {wanted:?}: {files:?}");
    }
    let archive = packed().join(format!("com.lumivox-{VERSION}.tgz"));
    let files = succeeds(Command::new("tar").arg("-tzf").arg(archive));
    for name in [
        "Windows/x86_64/lumivox_unity.dll",
        "Windows/x86_64/lumivox-codecs.exe",
        "Linux/x86_64/lumivox-codecs",
    ] {
        let place = format!("package/Runtime/Plugins/{name}");
        assert!(files.lines().any(|file| file == place), "no {place}: {files}");
    }
    assert!(packed().join(wheel_for_windows()).is_file());
    // Whose works are in it differs: the compiler's libraries, and what asks Windows.
    let bill = |system: &str| {
        fs::read_to_string(packed().join(format!("lumivox-{VERSION}-x86_64-{system}.cdx.json"))).unwrap()
    };
    assert!(bill("windows").contains("mingw-w64") && bill("windows").contains("cargo/windows"));
    assert!(!bill("linux").contains("mingw-w64"));
}

#[test]
fn the_same_files_make_the_same_bytes_and_what_is_left_out_is_said() {
    let (out, windows) = (folder("packages-again"), folder("packages-windows-again"));
    for name in ["lumivox_godot.dll", "lumivox-codecs.exe"] {
        packed();
        fs::copy(
            Path::new(env!("CARGO_TARGET_TMPDIR")).join("packages-windows").join(name),
            windows.join(name),
        )
        .unwrap();
    }
    let output = xtask(&["godot"], &out, &[native(), &windows]);
    assert!(output.status.success(), "{}", words(&output));
    for name in ["lumivox-godot", "lumivox-godot-demo"] {
        let name = format!("{name}-{VERSION}.zip");
        let [first, second] = [packed(), &out].map(|folder| fs::read(folder.join(&name)).unwrap());
        assert!(first == second, "{name} differs");
    }
    fs::remove_file(windows.join("lumivox_godot.dll")).unwrap();
    let output = xtask(&["godot"], &out, &[native(), &windows]);
    let missing = windows.join("lumivox_godot.dll");
    let said = format!(
        "LEFT OUT: Godot for Windows, for there is no {}; script/windows makes it",
        missing.display()
    );
    assert!(output.status.success() && words(&output).contains(&said), "{}", words(&output));
}

#[test]
fn what_is_missing_or_makes_no_sense_is_told() {
    let (out, empty) = (folder("packages-wrong"), folder("packages-empty"));
    // Options mean the same for all parts, and are refused where they mean nothing.
    let library = empty.join("lumivox_unity.dll");
    for (part, why) in [("command", "for the Unity package"), ("all", "lumivox_unity.dll")] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_xtask"));
        command.args(["package", part]).arg(&out).arg("--from").arg(native()).arg("--library").arg(&library);
        let output = command.current_dir(root()).output().unwrap();
        assert!(!output.status.success() && words(&output).contains(why), "{part}: {}", words(&output));
    }
    let output = xtask(&["command"], &out, &[&empty]);
    let missing = format!("there is no {}", empty.join("lumivox").display());
    assert!(!output.status.success() && words(&output).contains(&missing), "{}", words(&output));
    for wrong in
        [&["package", "everything", "x"][..], &["package", "all"], &["package", "unity", "x", "--from"]]
    {
        let output =
            Command::new(env!("CARGO_BIN_EXE_xtask")).args(wrong).current_dir(root()).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{wrong:?}: {}", words(&output));
    }
}

#[test]
fn crates_have_their_licences_and_lean_on_no_folder() {
    let crates = packed().join("crates");
    let mut count = 0;
    for entry in fs::read_dir(&crates).unwrap() {
        let file = entry.unwrap().path();
        let name = file.file_stem().unwrap().to_str().unwrap().to_owned();
        let list = succeeds(Command::new("tar").arg("-tzf").arg(&file));
        for wanted in ["Cargo.toml", "README.md", "LICENSE-MIT", "LICENSE-APACHE", "src/lib.rs"] {
            assert!(
                list.lines().any(|path| path == format!("{name}/{wanted}")),
                "{name} has no {wanted}: {list}"
            );
        }
        let text =
            |path: &str| succeeds(Command::new("tar").arg("-xzOf").arg(&file).arg(format!("{name}/{path}")));
        assert!(text("LICENSE-MIT").starts_with("MIT License"), "{name}");
        // A dependency by its path alone is one that nobody else has.
        let manifest = text("Cargo.toml");
        let mut tables = manifest.split("\n[").filter(|table| table.starts_with("dependencies."));
        assert!(tables.all(|table| table.contains("version = ") && !table.contains("path = ")), "{manifest}");
        count += 1;
    }
    assert_eq!(count, 9);
}

/// Makes the command's packages for old systems, as releases are, of the tree `root`; `target` is where it is built.
fn release_command(root: &Path, out: &Path, target: Option<&Path>) {
    let nothing = folder(&format!("{}-nothing", out.file_name().unwrap().to_str().unwrap()));
    let mut command = Command::new(env!("CARGO_BIN_EXE_xtask"));
    command.args(["package", "command"]).arg(out).arg("--windows").arg(&nothing).current_dir(root);
    command.envs(target.map(|folder| ("CARGO_TARGET_DIR", folder)));
    succeeds(command.env("SOURCE_DATE_EPOCH", "1600000000"));
}

/// Made once, where releases are built.
fn release() -> &'static Path {
    static RELEASE: OnceLock<PathBuf> = OnceLock::new();
    RELEASE.get_or_init(|| {
        let out = folder("packages-release");
        release_command(&root(), &out, None);
        out
    })
}

#[test]
#[ignore = "slow: script/test --all"]
fn a_release_needs_nothing_but_a_c_library() {
    let place = folder("packages-release-root");
    let archive = release().join(format!("lumivox-{VERSION}-x86_64-linux.tar.xz"));
    succeeds(Command::new("tar").arg("-xJf").arg(archive).arg("-C").arg(&place));
    let program = place.join(format!("lumivox-{VERSION}-x86_64-linux/bin/lumivox"));
    let (bare, libraries) = bare_root("packages-release-bare", &program);
    assert!(!libraries.iter().any(|name| name.contains("stdc++") || name.contains("gcc")), "{libraries:?}");
    use_alone(&bare);
}

/// In another folder, of which it is to know nothing.
#[test]
#[ignore = "slow: script/test --all"]
fn a_release_is_built_again_the_same() {
    // The tree as it lies there, with what is not committed.
    let elsewhere = folder("packages-elsewhere").join("with/another/name");
    fs::create_dir_all(&elsewhere).unwrap();
    let files = succeeds(
        Command::new("git")
            .args(["ls-files", "--cached", "--others", "--exclude-standard"])
            .current_dir(root()),
    );
    for file in files.lines().filter(|file| root().join(file).is_file()) {
        let to = elsewhere.join(file);
        fs::create_dir_all(to.parent().unwrap()).unwrap();
        fs::copy(root().join(file), to).unwrap();
    }
    let (again, target) = (folder("packages-release-again"), folder("packages-release-again-target"));
    release_command(&elsewhere, &again, Some(&target));
    fs::remove_dir_all(target).unwrap();
    let [first, second] =
        [release(), &again].map(|folder| fs::read_to_string(folder.join("SHA256SUMS")).unwrap());
    assert_eq!(first, second);
}
