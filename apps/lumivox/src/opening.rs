//! From the command line to a scene: a document is read or begun, options change it, and its files are opened.

use std::{
    fs::File,
    io::Read,
    path::{Path, PathBuf},
    sync::Arc,
};

use lumivox_core::{
    CancelToken, MOST_CLIP_SHAPES, PerspectiveCamera, Preset, Scene, Volume,
    document::{
        Entry, Film, Keep as Kept, Labels, Lighting, Scan, SceneDocument, Surroundings, TakenOff, View,
        Written,
    },
    glam::DVec3,
};
use lumivox_scene::{Audience, Loaded, Note, OpenError, OpenErrorKind, Opening, Remedy};

use crate::{
    args::{EnvironmentName, Fusion, InputArgs, Keep, SceneArgs},
    exit::{Exit, Failure},
    inputs,
    looks::{LookOptions, looks},
    output,
    progress::Reporter,
};

/// What is to be opened: known before anything that takes long.
pub struct Plan {
    document: SceneDocument,
    /// Where it is written, if it is.
    written: Option<Written>,
    looks: Vec<LookOptions>,
    fuses: bool,
}

/// A scene, and the document that says all of it.
pub struct Opened {
    /// The document, with what was found of its scans.
    pub document: SceneDocument,
    /// The scene.
    pub scene: Scene,
    /// From where it is seen.
    pub camera: PerspectiveCamera,
}

impl Audience for Reporter {
    fn note(&self, note: Note) {
        let remedy = match note.remedy {
            Some(Remedy::KeepEverything) => " ('--keep everything' shows it)".to_owned(),
            Some(Remedy::Density(density)) => {
                format!("; --density {} is a body's", lumivox_core::words::number(density))
            }
            Some(Remedy::LabelPreset) => {
                "; a look of its own shows it, such as preset:NAME in its --label".to_owned()
            }
            _ => String::new(),
        };
        Reporter::say(self, &format!("  note: {}{remedy}", note.text));
    }

    fn say(&self, line: &str) {
        Reporter::say(self, line);
    }

    fn watch<T>(&self, work: impl FnOnce(lumivox_core::Progress<'_>) -> T) -> T {
        self.stages(work)
    }
}

/// The scene that the only input is, if it is one.
fn written(args: &SceneArgs) -> Result<Option<Written>, Failure> {
    let mut scenes = args.input.inputs.iter().filter(|path| is_scene(path));
    let Some(file) = scenes.next() else { return Ok(None) };
    if args.input.inputs.len() > 1 {
        return Err(Failure::usage(format!(
            "{} is a scene, which has its own scans; give it alone",
            file.display()
        )));
    }
    read(file).map(Some)
}

/// Reads a scene.
pub fn read(file: &Path) -> Result<Written, Failure> {
    lumivox_scene::read(file).map_err(|error| Failure::input(error.to_string()))
}

/// Refuses scenes where scans are wanted.
pub fn check_are_scans(args: &InputArgs) -> Result<(), Failure> {
    let Some(scene) = args.inputs.iter().find(|path| is_scene(path)) else { return Ok(()) };
    let scene = scene.display();
    Err(Failure::input(format!(
        "{scene} is a scene of Lumivox's, and no scan: 'lumivox render {scene} -o PICTURE.png' renders it, 'lumivox scene check \
         {scene}' says whether all of it is there; its scans can be named here"
    )))
}

/// Every file that the command line names for reading.
pub fn files_named(args: &SceneArgs) -> impl Iterator<Item = &Path> {
    let map = match &args.environment {
        Some(EnvironmentName::File(path)) => Some(path),
        _ => None,
    };
    let files = args.input.inputs.iter().chain(args.looks.files()).chain(&args.labels).chain(map);
    files.map(PathBuf::as_path)
}

/// Whether a file is a scene.
pub fn is_scene(path: &Path) -> bool {
    /// What tells it stands in its first lines.
    const BEGINNING: u64 = 4096;
    let mut beginning = Vec::new();
    let begins = |file: File| file.take(BEGINNING).read_to_end(&mut beginning);
    path.is_file() && File::open(path).and_then(begins).is_ok() && SceneDocument::is_one(&beginning)
}

impl Plan {
    /// Reads or begins the document, and changes it by the options. Everything that can be wrong is looked at before the long
    /// work.
    pub fn new(args: &SceneArgs) -> Result<Self, Failure> {
        check(args)?;
        inputs::check(&args.input)?;
        let written = written(args)?;
        let count = match &written {
            Some(written) => written.document.volumes.len(),
            None => inputs::count(&args.input),
        };
        let fuses = match args.fusion {
            // A scene says which scans there are.
            _ if written.is_some() => false,
            Fusion::Auto => count == 1 && args.looks.0.is_empty() && args.input.series.is_none(),
            Fusion::On if count > 1 => {
                return Err(Failure::usage(
                    "--fusion on is for one folder; of several scans all are shown anyway",
                ));
            }
            Fusion::On => true,
            Fusion::Off => false,
        };
        let looks = looks(args, if fuses && args.fusion == Fusion::On { 2 } else { count })?;
        let mut document = match &written {
            Some(written) => written.document.clone(),
            None => {
                let scans = inputs::scans(&args.input.inputs).into_iter();
                let volumes = scans.map(|files| Entry::new(Scan::of_files(files))).collect();
                SceneDocument { volumes, ..SceneDocument::default() }
            }
        };
        change(args, &mut document, written.is_some())?;
        for (entry, look) in document.volumes.iter_mut().zip(&looks) {
            look.apply(args, &mut entry.look);
        }
        for file in label_files(&document) {
            inputs::check_file(&folder(written.as_ref()).join(file))?;
        }
        Ok(Self { document, written, looks, fuses })
    }

    /// The files that a scene names: they must not be written.
    pub fn files(&self) -> Vec<PathBuf> {
        let folder = folder(self.written.as_ref());
        let map = self.document.environment.file();
        let scans = self.document.volumes.iter().flat_map(|entry| &entry.scan.files).map(PathBuf::as_path);
        scans.chain(label_files(&self.document)).chain(map).map(|file| folder.join(file)).collect()
    }

    /// Refuses to write over what is read, or to where it would be read as part of a scan. A scene may be replaced by what becomes
    /// of it.
    pub fn check_output(&self, output: &Path) -> Result<(), Failure> {
        let files = self.files();
        output::check_is_none_of(output, files.iter().map(PathBuf::as_path).filter(|file| !is_scene(file)))?;
        let folder = folder(self.written.as_ref());
        let scans = self.document.volumes.iter().map(|entry| &entry.scan.files);
        scans
            .map(|files| files.iter().map(|file| folder.join(file)).collect::<Vec<_>>())
            .try_for_each(|files| output::check_is_no_slice(output, &files))
    }

    /// The image that is rendered.
    pub fn film(&self) -> &Film {
        &self.document.film
    }

    /// Opens everything; a document that is to be `saved` says what tells its scans from others, which takes a while to find.
    pub fn open(
        mut self,
        args: &SceneArgs,
        saved: bool,
        reporter: Reporter,
        cancel: &CancelToken,
    ) -> Result<Opened, Failure> {
        let folder = folder(self.written.as_ref()).to_owned();
        let opening = Opening { allow_outside_data: args.input.allow_outside_data, identify: saved };
        let scans = self.scans(args, &folder, &opening, reporter, cancel)?;
        if let [a, b] = &scans[..]
            && !lie_together(&a.volume, &b.volume)
        {
            reporter.say("note: the scans lie apart: are they of one patient, and of one place?");
        }
        let mut volumes = Vec::with_capacity(scans.len());
        for (index, scan) in scans.into_iter().enumerate() {
            let is_named = self.document.volumes[index].scan.series.is_some() || args.input.series.is_some();
            if !scan.is_shared {
                tell(&scan, !is_named, reporter);
            }
            if let Some(path) = self.looks.get(index).and_then(LookOptions::file) {
                let loaded = lumivox_import::load_transfer_function_2d(path, scan.volume.value_range())?;
                let look = &mut self.document.volumes[index].look;
                (look.transfer_function, look.gradients) = (Some(loaded.0), loaded.1);
            }
            volumes.push(scan.volume);
        }
        if self.written.is_none() {
            tell_of_twins(&self.document, &volumes, reporter);
        }
        let opened =
            lumivox_scene::open_loaded(&self.document, volumes, &folder, &opening, &reporter, cancel);
        let lumivox_scene::Opened { scene, camera } = opened.map_err(|error| self.failure(error))?;
        cancel.check()?;
        Ok(Opened { document: self.document, scene, camera })
    }

    /// Loads the scans, a CT or MR and the PET of its place from one folder, too.
    fn scans(
        &mut self,
        args: &SceneArgs,
        folder: &Path,
        opening: &Opening,
        reporter: Reporter,
        cancel: &CancelToken,
    ) -> Result<Vec<Loaded>, Failure> {
        if !self.fuses {
            let scans = lumivox_scene::load_scans(&self.document, folder, opening, &reporter, cancel)
                .map_err(|error| self.failure(error))?;
            if self.written.is_none() && args.fusion != Fusion::Off && self.has_no_look(args) {
                self.fusion_looks(&scans);
            }
            return Ok(scans);
        }
        let scans = inputs::load_fusion(&args.input, reporter, cancel)?.into_iter().map(|mut scan| {
            if opening.identify {
                scan.volume = lumivox_scene::identified(scan.volume);
            }
            Loaded::from(scan)
        });
        let scans: Vec<Loaded> = scans.collect();
        if args.fusion == Fusion::On && scans.len() < 2 {
            return Err(Failure::input(
                "--fusion on: there are no CT or MR and PET of one place; 'lumivox info' lists what there is, and files of \
                 both may be named one after the other",
            ));
        }
        if scans.len() > self.document.volumes.len() {
            let names: Vec<&str> =
                scans.iter().map(|scan| scan.report.series[scan.report.chosen].name.as_str()).collect();
            reporter.say(&format!(
                "{} of one place are shown at once ('--fusion off' shows one)",
                names.join(" and ")
            ));
            let mut second = self.document.volumes[0].clone();
            if self.looks.len() < 2 {
                self.looks.push(self.looks[0].unnamed());
            }
            second.look = Default::default();
            self.looks[1].apply(args, &mut second.look);
            self.document.volumes.push(second);
        }
        if self.has_no_look(args) {
            self.fusion_looks(&scans);
        }
        Ok(scans)
    }

    fn has_no_look(&self, args: &SceneArgs) -> bool {
        args.looks.0.is_empty() && args.input.series.is_none()
    }

    /// Gives a CT or MR and a PET in it the looks by which both are seen.
    fn fusion_looks(&mut self, scans: &[Loaded]) {
        let volumes: Vec<&Volume> = scans.iter().map(|scan| &*scan.volume).collect();
        if let Some(presets) = Preset::fusion_of(&volumes) {
            let entries = self.document.volumes.iter_mut();
            entries.zip(presets).for_each(|(entry, preset)| entry.look.preset = Some(preset));
        }
    }

    fn failure(&self, error: OpenError) -> Failure {
        failure(self.written.as_ref(), error)
    }
}

/// Says what was read.
fn tell(scan: &Loaded, is_chosen_here: bool, reporter: Reporter) {
    reporter.say(&format!("{}: {}", scan.report.format, inputs::describe(&scan.volume)));
    let of_holes = inputs::note_of_holes(&scan.report, &scan.volume);
    let notes = scan.report.notes.iter().map(String::as_str).chain(of_holes);
    notes.for_each(|note| reporter.say(&format!("  note: {note}")));
    if is_chosen_here && scan.report.series.len() > 1 {
        let (all, chosen) = (scan.report.series.len(), scan.report.chosen + 1);
        let name = scan.report.series.get(scan.report.chosen).map_or("", |series| &series.name);
        reporter.say(&format!(
            "  note: series {chosen} of {all} is taken ({name}); --series takes another, 'lumivox import' lists them"
        ));
    }
    if !scan.report.skipped.is_empty() {
        let count = scan.report.skipped.len();
        let were = if count == 1 { "file was" } else { "files were" };
        reporter.say(&format!("  note: {count} {were} left out; 'lumivox import' says which and why"));
    }
}

/// Says which scans are others once more, by another path perhaps. With a look of its own it is meant so.
fn tell_of_twins(document: &SceneDocument, volumes: &[Arc<Volume>], reporter: Reporter) {
    let is_twin = |a: &Volume, b: &Volume| {
        (a.dims(), a.patient_from_voxel(), a.slope(), a.intercept())
            == (b.dims(), b.patient_from_voxel(), b.slope(), b.intercept())
            && a.voxels() == b.voxels()
    };
    for (later, volume) in volumes.iter().enumerate() {
        let looks_alike = |other: usize| document.volumes[other].look == document.volumes[later].look;
        let first = (0..later).find(|&other| looks_alike(other) && is_twin(&volumes[other], volume));
        if let Some(first) = first {
            let (first, later) = (first + 1, later + 1);
            reporter.say(&format!(
                "note: scan {later} is scan {first} once more: they are shown in one place, twice as dense; give it once"
            ));
        }
    }
}

/// What went wrong, with the line of a document that says so.
pub fn failure(written: Option<&Written>, error: OpenError) -> Failure {
    let place = written.map(|written| error.place(written));
    let (exit, message) = match (error.kind, &place) {
        (OpenErrorKind::Import(import), _) => {
            let failure = Failure::from(*import);
            (failure.exit, failure.message)
        }
        (OpenErrorKind::Cancelled(cancelled), _) => return cancelled.into(),
        // Of the command line these are wrong options.
        (OpenErrorKind::NoView, None) => return no_view(),
        (kind @ OpenErrorKind::NoSuchLabel { .. }, None) => (Exit::Usage, format!("--{kind}")),
        (kind, _) => (Exit::Input, kind.to_string()),
    };
    match place {
        Some(place) => Failure::new(exit, format!("{place}: {message}")),
        None => Failure::new(exit, message),
    }
}

fn folder(written: Option<&Written>) -> &Path {
    written.map_or(Path::new(""), Written::folder)
}

fn label_files(document: &SceneDocument) -> impl Iterator<Item = &Path> {
    let labels = document.volumes.iter().filter_map(|entry| entry.labels.as_ref());
    labels.flat_map(|labels| &labels.files).map(PathBuf::as_path)
}

fn no_view() -> Failure {
    Failure::usage("--eye is the point looked at; move it, or give another --target")
}

/// Refuses options that make no sense, whatever there is to open.
fn check(args: &SceneArgs) -> Result<(), Failure> {
    if let (Some(eye), Some(target)) = (args.eye, args.target)
        && eye.0.distance(target.0) <= 1e-6
    {
        return Err(no_view());
    }
    if args.clip_shape.len() > MOST_CLIP_SHAPES {
        let (given, most) = (args.clip_shape.len(), MOST_CLIP_SHAPES);
        return Err(Failure::usage(format!(
            "--clip-shape is given {given} times, of which {most} are possible"
        )));
    }
    if args.keep == Some(Keep::Everything) {
        check_peel(args)?;
    }
    Ok(())
}

fn check_peel(args: &SceneArgs) -> Result<(), Failure> {
    if args.peel.is_some_and(|mm| mm > 0.0) {
        return Err(Failure::usage(
            "--peel takes the patient's skin off; it goes with '--keep patient' only",
        ));
    }
    Ok(())
}

/// Changes a document by the options that were given.
fn change(args: &SceneArgs, document: &mut SceneDocument, is_written: bool) -> Result<(), Failure> {
    // What options name is seen from where they are given, and not from a document's folder.
    let seen = |file: &Path| {
        if is_written { std::path::absolute(file).unwrap_or_default() } else { file.to_owned() }
    };
    let labels = label_option(args, seen)?;
    for entry in &mut document.volumes {
        change_scan(args, &mut entry.scan)?;
        if let Some(clip) = args.clip {
            entry.clip = Some(clip.0.map(|corner| corner.to_array()));
        }
        if !args.clip_shape.is_empty() {
            entry.clip_shapes = args.clip_shape.iter().map(|clip| clip.0).collect();
        }
        if let Some(labels) = &labels {
            entry.labels = Some(labels.clone());
        }
        match &mut entry.labels {
            Some(labels) => labels.styles.extend(args.label.iter().map(|option| option.0.clone())),
            None if args.label.is_empty() => {}
            None => {
                return Err(Failure::usage(
                    "--label is about labels, which --labels gives: a file, or 'found'",
                ));
            }
        }
    }
    change_light(args, document, seen);
    change_view(args, &mut document.camera);
    let film = &mut document.film;
    film.size = args.size.map_or(film.size, |size| [size.width, size.height]);
    film.samples = args.samples.or(film.samples);
    film.noise = args.noise.or(film.noise);
    film.seed = args.seed.unwrap_or(film.seed);
    film.denoise |= args.denoise;
    let display = &mut document.display;
    display.background = args.background.unwrap_or(display.background);
    display.exposure = args.exposure.unwrap_or(display.exposure);
    display.tone = args.tone.map_or(display.tone, Into::into);
    display.gamma = args.gamma.unwrap_or(display.gamma);
    Ok(())
}

fn change_scan(args: &SceneArgs, scan: &mut Scan) -> Result<(), Failure> {
    let input = &args.input;
    scan.series = input.series.clone().or(scan.series.take());
    scan.phase = input.phase.or(scan.phase);
    scan.leave_gaps |= input.leave_gaps;
    scan.fill_damaged |= input.fill_damaged;
    let text = |value: Option<String>, own: &mut Option<String>| *own = value.or(own.take());
    text(input.raw.as_ref().map(ToString::to_string), &mut scan.raw);
    text(input.axes.as_ref().map(ToString::to_string), &mut scan.axes);
    text(input.layout.as_ref().map(ToString::to_string), &mut scan.layout);
    text(input.unit.clone(), &mut scan.unit);
    scan.spacing = input.spacing.or(scan.spacing);
    scan.slope = input.slope.or(scan.slope);
    scan.intercept = input.intercept.or(scan.intercept);
    scan.modality = input.modality.or(scan.modality);
    let other_voxels = input.series.is_some()
        || input.phase.is_some()
        || input.raw.is_some()
        || input.slope.is_some()
        || input.intercept.is_some()
        || input.spacing.is_some()
        || input.axes.is_some()
        || input.layout.is_some();
    if other_voxels {
        scan.content = None;
    }
    if let Some(keep) = args.keep {
        scan.keep = match keep {
            Keep::Patient => Kept::Patient,
            Keep::Everything => Kept::Everything,
        };
    }
    if let Some(mm) = args.peel {
        scan.taken_off = Some(TakenOff::Depth(mm));
        if scan.keep == Kept::Everything {
            check_peel(args)?;
        }
    } else if !args.looks.0.is_empty() {
        // Another look hides behind other things.
        scan.taken_off = None;
    }
    Ok(())
}

/// What `--labels` gives, if it does.
fn label_option(args: &SceneArgs, seen: impl Fn(&Path) -> PathBuf) -> Result<Option<Labels>, Failure> {
    if args.labels.is_empty() {
        return Ok(None);
    }
    let files: Vec<PathBuf> =
        args.labels.iter().filter(|file| !is_found(file)).map(|file| seen(file)).collect();
    if !files.is_empty() && files.len() < args.labels.len() {
        return Err(Failure::usage("--labels found finds labels by itself; it goes with no file of labels"));
    }
    Ok(Some(Labels { files, ..Labels::default() }))
}

/// Whether labels are what is found in the scan itself, and no file: `found`, unless there is a file of that name in other
/// letters.
fn is_found(labels: &Path) -> bool {
    const FOUND: &str = "found";
    let is_word = labels.to_str().is_some_and(|word| word.eq_ignore_ascii_case(FOUND));
    labels == Path::new(FOUND) || is_word && !labels.exists()
}

fn change_light(args: &SceneArgs, document: &mut SceneDocument, seen: impl Fn(&Path) -> PathBuf) {
    let environment = &mut document.environment;
    if let Some(name) = &args.environment {
        let source = match name {
            EnvironmentName::Studio => "studio".into(),
            EnvironmentName::Uniform => "uniform".into(),
            EnvironmentName::Gradient => "gradient".into(),
            EnvironmentName::File(path) => seen(path),
        };
        let (strength, rotation) = (environment.strength, environment.rotation);
        *environment = Surroundings { source, strength, rotation, ..Surroundings::default() };
    }
    environment.strength = args.environment_strength.unwrap_or(environment.strength);
    environment.rotation = args.environment_rotation.unwrap_or(environment.rotation);
    if !args.light.is_empty() {
        document.lights = args.light.iter().map(|sun| Lighting::of(&sun.0)).collect();
    }
}

fn change_view(args: &SceneArgs, view: &mut View) {
    view.fov = args.fov.unwrap_or(view.fov);
    let orbits = args.azimuth.is_some() || args.elevation.is_some() || args.zoom.is_some();
    let point = |point: DVec3| point.to_array();
    if orbits || args.eye.is_some() || args.target.is_some() {
        view.world_from_camera = None;
    }
    if orbits {
        view.eye = None;
        view.azimuth = args.azimuth.or(view.azimuth);
        view.elevation = args.elevation.or(view.elevation);
        view.zoom = args.zoom.or(view.zoom);
    }
    if let Some(eye) = args.eye {
        *view = View { eye: Some(point(eye.0)), azimuth: None, elevation: None, zoom: None, ..*view };
    }
    if let Some(target) = args.target {
        view.target = Some(point(target.0));
    }
}

/// Whether the boxes of two scans meet in the patient's space.
fn lie_together(a: &Volume, b: &Volume) -> bool {
    let bounds = |volume: &Volume| {
        let size = DVec3::from_array(volume.dims().map(|n| n as f64));
        let corner = |i: usize| {
            let at = DVec3::from_array([i & 1, i >> 1 & 1, i >> 2].map(|k| k as f64)) * size - 0.5;
            volume.patient_from_voxel().transform_point3(at)
        };
        (1..8).map(corner).fold([corner(0); 2], |[low, high], p| [low.min(p), high.max(p)])
    };
    let ([a_low, a_high], [b_low, b_high]) = (bounds(a), bounds(b));
    a_low.cmple(b_high).all() && b_low.cmple(a_high).all()
}
