//! `lumivox scene`: a scene to one file, and whether a file can be opened.

use lumivox_core::{
    CancelToken,
    document::{Look, SceneDocument},
};
use lumivox_scene::{ANOTHER_SCAN, Opening, content_of, is_another, open};

use crate::{
    args::{CheckArgs, SaveArgs, SceneCommand},
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
    output::check_is_none_of(
        &args.output,
        plan.files().iter().map(|file| file.as_path()).filter(|file| !is_scene(file)),
    )?;
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
            labels.content = map.map(|labelling| content_of(labelling.labels.volume()));
        }
    }
    if let Some(map) = scene.environment.file() {
        document.environment.source = map.to_owned();
    }
    document
}

/// Opens all of a scene, and says what it is or what is wrong with it.
fn check(args: &CheckArgs) -> Result<(), Failure> {
    let written = opening::read(&args.file)?;
    let reporter = Reporter::new(false);
    let cancel: CancelToken = exit::cancel_on_ctrl_c()?;
    let options = Opening { allow_outside_data: args.allow_outside_data, identify: false };
    let opened = open(&written.document, written.folder(), &options, &reporter, &cancel)
        .map_err(|error| opening::failure(Some(&written), error))?;
    let volumes = &opened.scene.volumes;
    let mut scans = written.document.volumes.iter().map(|entry| &entry.scan).zip(volumes);
    if let Some(index) = scans.position(|(scan, instance)| is_another(scan, &instance.volume)) {
        let place = written.place(Some(index), &["scan", "files"]);
        return Err(Failure::input(format!("{place}: {ANOTHER_SCAN}")));
    }
    let scans = if volumes.len() == 1 { "1 scan".to_owned() } else { format!("{} scans", volumes.len()) };
    output::print(&format!("{}: {scans}, all is there\n", args.file.display()))
}
