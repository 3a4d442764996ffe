//! What is made, part by part, and what of all of it lies in the folder in the end: `cargo xtask package all`.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::archive::{self, Files, How};
use super::build::{LINUX, Native, PACKAGES, STUDIO};
use super::command::{self, Manual, Words};
use super::godot::{self, Libraries};
use super::options::Options;
use super::works::{Graph, Work};
use super::{VERSION, crates, date, python, read, run, sbom, studio, target_folder, unity, works, write};

/// What people install.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Part {
    Command,
    Studio,
    Godot,
    Unity,
    Python,
    Crates,
    Web,
    Npm,
}

impl Part {
    /// Those of a release. What is for browsers is made by itself: its tools are of one version, which Debian's testing has today.
    pub const ALL: [Self; 6] =
        [Self::Command, Self::Studio, Self::Godot, Self::Unity, Self::Python, Self::Crates];

    /// By its word on the command line; `all` are those of a release. `unity` alone is made of this system's, whatever it is.
    pub fn named(name: &str) -> Option<Vec<Self>> {
        Some(match name {
            "all" => Self::ALL.to_vec(),
            "command" => vec![Self::Command],
            "studio" => vec![Self::Studio],
            "godot" => vec![Self::Godot],
            "python" => vec![Self::Python],
            "crates" => vec![Self::Crates],
            "web" => vec![Self::Web],
            "npm" => vec![Self::Npm],
            _ => return None,
        })
    }

    /// What of it is native on Linux.
    fn linux_files(self) -> &'static [&'static str] {
        match self {
            Self::Command => &["lumivox"],
            Self::Studio => &["lumivox-studio"],
            Self::Godot => &["liblumivox_godot.so", "lumivox-codecs"],
            Self::Unity => &["liblumivox_unity.so", "lumivox-codecs"],
            Self::Python | Self::Crates | Self::Web | Self::Npm => &[],
        }
    }

    /// What of it `script/windows` makes.
    fn windows_files(self) -> &'static [&'static str] {
        match self {
            Self::Command => &["lumivox.exe"],
            Self::Studio => &["lumivox-studio.exe"],
            Self::Godot => &["lumivox_godot.dll", "lumivox-codecs.exe"],
            Self::Unity => &unity::WINDOWS_FILES,
            Self::Python | Self::Crates | Self::Web | Self::Npm => &[],
        }
    }
}

/// Efforts to pack what people download, and what is taken from a folder as it is, for a look at it.
const THOROUGH: u32 = 6;
const QUICK: u32 = 0;

/// What browsers have for a system.
const BROWSERS: &str = "wasm32-unknown-unknown";

/// The system that `script/windows` builds for.
const WINDOWS: &str = "x86_64-pc-windows-gnu";

/// Makes parts in a folder, with checksums, and for each archive a bill of what is in it.
pub fn make(parts: &[Part], out: &Path, options: &Options<'_>) -> Result<(), String> {
    if (std::env::consts::OS, std::env::consts::ARCH) != ("linux", "x86_64") {
        return Err("packages are made on Linux (x86-64), those for Windows, too".to_owned());
    }
    let root = crate::root()?;
    if let Some(folder) = options.from {
        let mut wanted = parts.iter().flat_map(|part| part.linux_files()).map(|name| folder.join(name));
        if let Some(file) = wanted.find(|file| !file.is_file()) {
            return Err(format!("there is no {}", file.display()));
        }
    }
    if !parts.contains(&Part::Unity) && (options.branch.is_some() || !options.libraries.is_empty()) {
        return Err("--library and --upm are for the Unity package".to_owned());
    }
    unity::check_others(&options.libraries)?;
    let out = std::path::absolute(out).map_err(|error| format!("{}: {error}", out.display()))?;
    let maker = Maker {
        how: How { date: date(&root)?, effort: if options.from.is_some() { QUICK } else { THOROUGH } },
        windows: match options.windows {
            Some(folder) => folder.to_owned(),
            None => target_folder(&root).join("windows/dist"),
        },
        staging: out.join("staging"),
        out,
        root,
    };
    maker.make(parts, options)?;
    match fs::remove_dir_all(&maker.staging) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(format!("{}: {error}", maker.staging.display()))
        }
        _ => Ok(()),
    }
}

struct Maker {
    root: PathBuf,
    how: How,
    windows: PathBuf,
    /// Where things lie that are packed.
    staging: PathBuf,
    out: PathBuf,
}

/// What is made, before it lies there: files by their names.
type Made = Vec<(String, Vec<u8>)>;

impl Maker {
    fn make(&self, parts: &[Part], options: &Options<'_>) -> Result<(), String> {
        let wants = |part: Part| parts.contains(&part);
        fs::create_dir_all(&self.out).map_err(|error| format!("{}: {error}", self.out.display()))?;
        let mut names = vec![];
        if parts.iter().any(|part| !part.windows_files().is_empty()) {
            let others = [Part::Command, Part::Godot, Part::Unity];
            let has_others = others.iter().any(|part| wants(*part));
            let native = match options.from {
                Some(folder) => Native::taken(folder, &self.staging.join("native"))?,
                None => Native::built(&self.root, has_others, wants(Part::Studio))?,
            };
            let mut made = vec![];
            if has_others {
                let graphs = self.graphs(&PACKAGES, parts, &native)?;
                if wants(Part::Command) {
                    made.extend(self.command(&native, &graphs)?);
                }
                if wants(Part::Godot) {
                    made.extend(self.godot(&native, &graphs)?);
                }
                if wants(Part::Unity) {
                    made.extend(self.unity(&native, &graphs, options)?);
                }
            }
            if wants(Part::Studio) {
                let graphs = self.graphs(&STUDIO, parts, &native)?;
                made.extend(self.studio(&native, &graphs, self.viewer(options.from)?.as_deref())?);
            }
            for (name, bytes) in made {
                write(&self.out.join(&name), &bytes)?;
                names.push(name);
            }
        }
        if wants(Part::Python) {
            names.extend(self.python(options.from)?);
        }
        if wants(Part::Crates) {
            names.extend(crates::make(&self.root, &self.out)?);
        }
        if wants(Part::Web) {
            names.extend(self.web(options.from)?);
        }
        if wants(Part::Npm) {
            names.extend(self.npm(options.from)?);
        }
        let (section, notes) = command::notes(&self.root)?;
        if section != VERSION {
            println!("note: CHANGELOG.md has no section [{VERSION}]; the notes are those of [{section}]");
        }
        write(&self.out.join("NOTES.md"), notes.as_bytes())?;
        names.push("NOTES.md".to_owned());
        self.sum(names)
    }

    /// What is linked into packages that are built together.
    fn graphs(&self, packages: &[&str], parts: &[Part], native: &Native) -> Result<Graphs, String> {
        let mut for_windows = parts.iter().flat_map(|part| part.windows_files());
        let has_windows = for_windows.any(|name| self.windows.join(name).is_file());
        let linux = Graph::new(&self.root, LINUX, packages)?;
        let windows = has_windows.then(|| Graph::new(&self.root, WINDOWS, packages)).transpose()?;
        Ok(Graphs { linux, windows, extra: native.extra.clone() })
    }

    /// Writes `SHA256SUMS`, as `sha256sum --check` reads it. What was made before is in it, too, where it is still what it was.
    fn sum(&self, names: Vec<String>) -> Result<(), String> {
        let list = self.out.join("SHA256SUMS");
        let mut sums = BTreeMap::new();
        let before = if list.exists() { read(&list)? } else { String::new() };
        for (sum, name) in before.lines().filter_map(|line| line.split_once("  ")) {
            if fs::read(self.out.join(name)).is_ok_and(|bytes| archive::sha256(&bytes) == sum) {
                sums.insert(name.to_owned(), sum.to_owned());
            }
        }
        for name in names {
            let file = self.out.join(&name);
            let bytes = fs::read(&file).map_err(|error| format!("{}: {error}", file.display()))?;
            println!("{}: {:.1} MB", file.display(), bytes.len() as f64 * 1e-6);
            sums.insert(name, archive::sha256(&bytes));
        }
        let lines: String = sums.iter().map(|(name, sum)| format!("{sum}  {name}\n")).collect();
        write(&list, lines.as_bytes())
    }

    /// The files for Windows of a part, where all are there; else says how they come there.
    fn windows_files(&self, part: Part) -> Option<Vec<PathBuf>> {
        let files: Vec<PathBuf> = part.windows_files().iter().map(|name| self.windows.join(name)).collect();
        let Some(missing) = files.iter().find(|file| !file.is_file()) else { return Some(files) };
        println!(
            "LEFT OUT: {part:?} for Windows, for there is no {}; script/windows makes it",
            missing.display()
        );
        None
    }

    fn command(&self, native: &Native, graphs: &Graphs) -> Result<Made, String> {
        let manual = Manual::new(&self.root, &native.command, &self.staging.join("manual"))?;
        let (_, notes) = command::notes(&self.root)?;
        let roots = ["lumivox"];
        let mut made = vec![];
        let works = graphs.linux(&roots)?;
        let (notice, bill) = (works::notice(&works), self.bill("lumivox", &roots, &works)?);
        let words = Words { notes: &notes, notice: &notice, bill: &bill };
        let archive = command::linux(&native.command, &manual, &words, self.how)?;
        made.push((format!("lumivox-{VERSION}-x86_64-linux.tar.xz"), archive));
        let package = command::debian(&native.command, &manual, &words, self.how)?;
        made.push((format!("lumivox_{VERSION}_amd64.deb"), package));
        made.push((format!("lumivox-{VERSION}-x86_64-linux.cdx.json"), bill.into_bytes()));
        if let Some(files) = self.windows_files(Part::Command) {
            let works = graphs.windows(&roots)?;
            let (notice, bill) = (works::notice(&works), self.bill("lumivox", &roots, &works)?);
            let words = Words { notes: &notes, notice: &notice, bill: &bill };
            let archive = command::windows(&files[0], &manual, &words, self.how)?;
            made.push((format!("lumivox-{VERSION}-x86_64-windows.zip"), archive));
            made.push((format!("lumivox-{VERSION}-x86_64-windows.cdx.json"), bill.into_bytes()));
        }
        Ok(made)
    }

    /// The npm package in a folder, of which the Studio makes pages for others.
    fn viewer(&self, from: Option<&Path>) -> Result<Option<PathBuf>, String> {
        if let Some(folder) = from {
            println!(
                "LEFT OUT: pages for others, for what is taken from {} has no program",
                folder.display()
            );
            return Ok(None);
        }
        let viewer = self.staging.join("viewer");
        // Its tools are Debian's of today, as those for the wheels are: where they do not come, the rest is made.
        match run(Command::new("script/js").arg("--out").arg(&viewer).current_dir(&self.root)) {
            Ok(()) => Ok(Some(viewer)),
            Err(why) => {
                println!("LEFT OUT: pages for others, for there is no program for them: {why}");
                Ok(None)
            }
        }
    }

    fn studio(&self, native: &Native, graphs: &Graphs, viewer: Option<&Path>) -> Result<Made, String> {
        let (_, notes) = command::notes(&self.root)?;
        let own = own_licenses(&self.root)?;
        let mut made = vec![];
        let of_pages = match viewer {
            Some(_) => in_browsers(&self.root)?,
            None => vec![],
        };
        let root = self.root.as_path();
        let works = both(graphs.linux(&STUDIO)?, of_pages.clone());
        let (notice, bill) = (works::notice(&works), self.bill("lumivox-studio", &STUDIO, &works)?);
        let words = Words { notes: &notes, notice: &notice, bill: &bill };
        let name = format!("lumivox-studio-{VERSION}-x86_64");
        let content = studio::Content { studio: &native.studio, viewer, root };
        let archive = studio::linux(&content, &own, &words, self.how)?;
        made.push((format!("{name}-linux.tar.xz"), archive));
        let package = studio::debian(&content, &own, &words, self.how)?;
        made.push((format!("lumivox-studio_{VERSION}_amd64.deb"), package));
        made.push((format!("{name}-linux.cdx.json"), bill.into_bytes()));
        if let Some(files) = self.windows_files(Part::Studio) {
            let works = both(graphs.windows(&STUDIO)?, of_pages);
            let (notice, bill) = (works::notice(&works), self.bill("lumivox-studio", &STUDIO, &works)?);
            let words = Words { notes: &notes, notice: &notice, bill: &bill };
            let content = studio::Content { studio: &files[0], ..content };
            let archive = studio::windows(&content, &own, &words, self.how)?;
            made.push((format!("{name}-windows.zip"), archive));
            made.push((format!("{name}-windows.cdx.json"), bill.into_bytes()));
        }
        Ok(made)
    }

    fn godot(&self, native: &Native, graphs: &Graphs) -> Result<Made, String> {
        let roots = ["lumivox-godot", "lumivox-import"];
        let mut works = graphs.linux(&roots)?;
        let files = vec![native.godot.clone(), native.codecs.clone()];
        let mut libraries = vec![Libraries { folder: "linux.x86_64", files }];
        if let Some(files) = self.windows_files(Part::Godot) {
            libraries.push(Libraries { folder: "windows.x86_64", files });
            works = both(works, graphs.windows(&roots)?);
        }
        let addon = godot::addon(&self.root, &libraries, &works::notice(&works))?;
        let demo = godot::demo(&self.root, &addon)?;
        let bill = self.bill("lumivox-godot", &roots, &works)?;
        Ok(vec![
            (format!("lumivox-godot-{VERSION}.zip"), addon.zip(self.how.date)?),
            (format!("lumivox-godot-demo-{VERSION}.zip"), demo.zip(self.how.date)?),
            (format!("lumivox-godot-{VERSION}.cdx.json"), bill.into_bytes()),
        ])
    }

    fn unity(&self, native: &Native, graphs: &Graphs, options: &Options<'_>) -> Result<Made, String> {
        let roots = ["lumivox-unity", "lumivox-import"];
        let mut works = graphs.linux(&roots)?;
        let windows = self.windows_files(Part::Unity).unwrap_or_default();
        if !windows.is_empty() {
            works = both(works, graphs.windows(&roots)?);
        }
        let mut others: Vec<&Path> = windows.iter().map(PathBuf::as_path).collect();
        others.extend(&options.libraries);
        let own = [native.unity.clone(), native.codecs.clone()];
        let content = unity::Content { own: &own, others: &others, notice: &works::notice(&works) };
        let staging = self.staging.join("unity");
        let archive = unity::pack(&self.root, &staging, &content, options.branch, self.how.date)?;
        let bill = self.bill("com.lumivox", &roots, &works)?;
        Ok(vec![
            (format!("com.lumivox-{VERSION}.tgz"), archive),
            (format!("com.lumivox-{VERSION}.cdx.json"), bill.into_bytes()),
        ])
    }

    /// The wheels and the sources. What programs are taken from a folder has none in it.
    fn python(&self, from: Option<&Path>) -> Result<Vec<String>, String> {
        let mut names = match from {
            None => python::make(&self.root, &self.out)?,
            Some(folder) => {
                println!(
                    "LEFT OUT: Python for Linux, for what is taken from {} has no wheel",
                    folder.display()
                );
                vec![]
            }
        };
        let is_wheel = |name: &str| {
            name.starts_with(&format!("lumivox-{VERSION}-cp310-abi3-")) && name.ends_with("win_amd64.whl")
        };
        let there = fs::read_dir(&self.windows).into_iter().flatten().flatten();
        let wheel =
            there.filter_map(|entry| entry.file_name().into_string().ok()).find(|name| is_wheel(name));
        match wheel {
            Some(name) => {
                let from = self.windows.join(&name);
                fs::copy(&from, self.out.join(&name))
                    .map_err(|error| format!("{}: {error}", from.display()))?;
                names.push(name);
            }
            None => println!(
                "LEFT OUT: Python for Windows, for there is no wheel in {}; script/windows makes it",
                self.windows.display()
            ),
        }
        let roots = ["lumivox-python"];
        // With what the notebook's widget sends to browsers.
        let works = both(Graph::new(&self.root, LINUX, &roots)?.linked(&roots)?, in_browsers(&self.root)?);
        let bill = format!("lumivox-python-{VERSION}.cdx.json");
        write(&self.out.join(&bill), self.bill("lumivox-python", &roots, &works)?.as_bytes())?;
        names.push(bill);
        Ok(names)
    }

    /// The Studio's page: static files for any server, below any path.
    fn web(&self, from: Option<&Path>) -> Result<Vec<String>, String> {
        let page = self.staging.join("web");
        if let Some(folder) = from {
            println!("LEFT OUT: the Studio's page, for what is taken from {} has none", folder.display());
            return Ok(vec![]);
        }
        let mut script = Command::new("script/studio");
        run(script.args(["--web", "--out"]).arg(&page).current_dir(&self.root))?;
        let roots = ["lumivox-studio"];
        let works = Graph::new(&self.root, BROWSERS, &roots)?.linked(&roots)?;
        let works = both(works, in_browsers(&self.root)?);
        let mut files = Files::default();
        files.add_folder("lumivox-studio/", &page, &|_| true)?;
        files.add("lumivox-studio/NOTICE.txt", archive::File::text(works::notice(&works)));
        for name in ["LICENSE-APACHE", "LICENSE-MIT"] {
            files.add_copy(format!("lumivox-studio/{name}"), &self.root.join(name))?;
        }
        let made = [
            (format!("lumivox-studio-web-{VERSION}.zip"), files.zip(self.how.date)?),
            (
                format!("lumivox-studio-web-{VERSION}.cdx.json"),
                self.bill("lumivox-studio", &roots, &works)?.into_bytes(),
            ),
        ];
        for (name, bytes) in &made {
            write(&self.out.join(name), bytes)?;
        }
        Ok(made.map(|(name, _)| name).into())
    }

    /// What npm installs: a tar with one folder, as `npm pack` makes it.
    fn npm(&self, from: Option<&Path>) -> Result<Vec<String>, String> {
        let package = self.staging.join("npm");
        if let Some(folder) = from {
            println!("LEFT OUT: the npm package, for what is taken from {} has none", folder.display());
            return Ok(vec![]);
        }
        run(Command::new("script/js").arg("--out").arg(&package).current_dir(&self.root))?;
        let roots = ["lumivox-js"];
        let works = in_browsers(&self.root)?;
        let mut files = Files::default();
        files.add_folder("", &package, &|_| true)?;
        files.add("NOTICE.txt", archive::File::text(works::notice(&works)));
        let made = [
            (
                format!("lumivox-{VERSION}-npm.tgz"),
                archive::gz(&files.within("package").tar("", self.how.date)?)?,
            ),
            (
                format!("lumivox-{VERSION}-npm.cdx.json"),
                self.bill("lumivox-js", &roots, &works)?.into_bytes(),
            ),
        ];
        for (name, bytes) in &made {
            write(&self.out.join(name), bytes)?;
        }
        Ok(made.map(|(name, _)| name).into())
    }

    fn bill(&self, name: &str, roots: &[&str], works: &[Work]) -> Result<String, String> {
        sbom::write(name, VERSION, roots, works, self.how.date)
    }
}

/// What is linked, on each system.
struct Graphs {
    linux: Graph,
    windows: Option<Graph>,
    /// What the builder for Linux added.
    extra: Vec<Work>,
}

impl Graphs {
    fn linux(&self, roots: &[&str]) -> Result<Vec<Work>, String> {
        let mut works = self.linux.linked(roots)?;
        works.extend(self.extra.iter().cloned());
        Ok(works)
    }

    fn windows(&self, roots: &[&str]) -> Result<Vec<Work>, String> {
        let graph = self.windows.as_ref().ok_or("nothing is there for Windows")?;
        let mut works = graph.linked(roots)?;
        works.extend(works::runtime_of_mingw());
        Ok(works)
    }
}

/// The works of two systems, each once.
fn both(mut works: Vec<Work>, others: Vec<Work>) -> Vec<Work> {
    for other in others {
        match works.iter_mut().find(|work| work.key() == other.key()) {
            // It may use something else there.
            Some(work) => {
                work.uses.extend(other.uses);
                work.uses.sort();
                work.uses.dedup();
            }
            None => works.push(other),
        }
    }
    works
}

/// What is linked into the program for pages.
fn in_browsers(root: &Path) -> Result<Vec<Work>, String> {
    let roots = ["lumivox-js"];
    Graph::new(root, BROWSERS, &roots)?.linked(&roots)
}

/// The licences of Lumivox itself.
pub fn own_licenses(root: &Path) -> Result<Files, String> {
    let mut files = Files::default();
    for name in ["LICENSE-APACHE", "LICENSE-MIT"] {
        files.add_copy(name, &root.join(name))?;
    }
    Ok(files)
}
