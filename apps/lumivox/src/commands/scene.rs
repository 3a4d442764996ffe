//! `lumivox scene`: a scene to one file, and whether a file can be opened.

use lumivox_core::{
    CancelToken, Progress,
    document::{Look, SceneDocument},
};
use lumivox_scene::{ANOTHER_SCAN, Audience, Note, Opening, content_of, is_another, open};

use crate::{
    args::{BYTES_PER_PIXEL, CheckArgs, SaveArgs, SceneCommand},
    exit::{self, Failure},
    opening::{self, Opened, Plan, files_named, is_scene},
    output,
    progress::Reporter,
};

/// Does what was asked.
pub fn run(command: &SceneCommand) -> Result<(), Failure> {
    match command {
        SceneCommand::Save(args) => save(args),
        SceneCommand::Check(args) => check(args),
    }
}

/// Opens what the options say, so that all of it is known to be there, and writes it down.
fn save(args: &SaveArgs) -> Result<(), Failure> {
    let reporter = Reporter::new(args.quiet);
    // The scene itself may be replaced by what becomes of it; scans may not.
    let named = files_named(&args.scene).filter(|file| !is_scene(file));
    let target = output::writable(&args.output, &["json", "lumivox"], named)?;
    let plan = Plan::new(&args.scene)?;
    plan.check_output(&args.output)?;
    let cancel = exit::cancel_on_ctrl_c()?;
    let opened = plan.open(&args.scene, true, reporter, &cancel)?;
    let document = complete(opened);
    lumivox_scene::save(&document, &target)
        .map_err(|error| Failure::other(format!("cannot write {}: {error}", args.output.display())))?;
    if !args.quiet {
        output::print(&format!("Wrote {}\n", args.output.display()))?;
    }
    Ok(())
}

/// The document with what was found: which series, what was taken off, the preset that suits.
fn complete(opened: Opened) -> SceneDocument {
    let Opened { mut document, scene, .. } = opened;
    for (entry, instance) in document.volumes.iter_mut().zip(&scene.volumes) {
        if let Some(source) = instance.volume.source() {
            entry.scan = source.clone();
        }
        if entry.look.transfer_function.is_none() {
            let preset = entry.look.base(&instance.volume);
            entry.look = Look { preset: Some(preset), ..entry.look.clone() };
        }
        let source = instance.labels.as_ref().and_then(|labelling| labelling.labels.source());
        if let (Some(labels), Some(source)) = (&mut entry.labels, source) {
            labels.files.clone_from(&source.files);
            labels.table.clone_from(&source.table);
            // What is found in the scan itself is told by the scan.
            let map = instance.labels.as_ref().filter(|_| !source.files.is_empty());
            // What lassos cut away of it is no content of its file.
            labels.content = map.map(|labelling| {
                let cut = labelling.labels.cut_away().and_then(|cut| cut.before.as_ref());
                content_of(cut.unwrap_or(&labelling.labels).volume())
            });
        }
    }
    if let Some(map) = scene.environment.file() {
        document.environment.source = map.to_owned();
    }
    document
}

/// Who waits while a scene is checked: that a scan is another is what the check ends with.
struct Checking(Reporter);

impl Audience for Checking {
    fn note(&self, note: Note) {
        if note.another.is_none() {
            self.0.note(note);
        }
    }

    fn say(&self, line: &str) {
        self.0.say(line);
    }

    fn watch<T>(&self, work: impl FnOnce(Progress<'_>) -> T) -> T {
        self.0.watch(work)
    }
}

/// Opens all of a scene, and says what it is or what is wrong with it.
fn check(args: &CheckArgs) -> Result<(), Failure> {
    let written = opening::read(&args.file)?;
    let reporter = Reporter::new(args.quiet);
    let cancel: CancelToken = exit::cancel_on_ctrl_c()?;
    let options = Opening { allow_outside_data: args.allow_outside_data, identify: false };
    let opened = open(&written.document, written.folder(), &options, &Checking(reporter), &cancel)
        .map_err(|error| opening::failure(Some(&written), error))?;
    let volumes = &opened.scene.volumes;
    let mut scans = written.document.volumes.iter().map(|entry| &entry.scan).zip(volumes);
    if let Some(index) = scans.position(|(scan, instance)| is_another(scan, &instance.volume)) {
        let place = written.place(&["volumes".into(), index.into(), "scan".into(), "files".into()]);
        return Err(Failure::input(format!("{place}: {ANOTHER_SCAN}")));
    }
    say_what_is_hard(&written.document, reporter);
    let scans = if volumes.len() == 1 { "1 scan".to_owned() } else { format!("{} scans", volumes.len()) };
    if args.quiet {
        return Ok(());
    }
    output::print(&format!("{}: {scans}, all is there\n", args.file.display()))
}

/// Says what a machine may have no room or time for. Whether this one has, only a render tells.
fn say_what_is_hard(document: &SceneDocument, reporter: Reporter) {
    /// Gigabytes that not every machine has for an image.
    const MUCH: f64 = 4.0;
    /// Scans whose looks the GPUs have room for that bind no more than they must, 128 MiB.
    const MANY_SCANS: usize = 1000;
    /// Shapes that drivers in software take.
    const MANY: usize = 100;
    let film = &document.film;
    let gigabytes = (film.pixels() * BYTES_PER_PIXEL) as f64 / 1e9;
    if gigabytes >= MUCH {
        let [width, height] = film.size;
        reporter
            .say(&format!("  note: an image of {width} x {height} pixels takes {gigabytes:.0} GB of memory"));
    }
    let scans = document.volumes.len();
    if scans > MANY_SCANS {
        reporter.say(&format!(
            "  note: {scans} scans, each with a look of its own, are more than some GPUs have room for"
        ));
    }
    for (index, entry) in
        document.volumes.iter().enumerate().filter(|(_, entry)| entry.clip_shapes.len() > MANY)
    {
        let (scan, shapes) = (index + 1, entry.clip_shapes.len());
        reporter.say(&format!(
            "  note: {shapes} shapes cut scan {scan}, and each point of a path asks all of them: drivers in software may give up"
        ));
    }
}
