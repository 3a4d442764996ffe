//! A scan that is open: the scene document with its one stack of commands, and the scene that is made of it.

use std::f64::consts::FRAC_PI_2;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use lumivox_core::document::{Entry, Keep, SceneDocument, Slices, Surroundings, TakenOff, View};
use lumivox_core::glam::{DMat3, DVec3};
use lumivox_core::{
    EnvironmentMap, EnvironmentSource, Lasso, Orbit, PerspectiveCamera, Preset, Scene, Volume, framing,
};
use lumivox_import::ImportReport;
use lumivox_scene::Part;

use crate::files;
use crate::history::History;
use crate::opening::Opened;
use crate::words::Word;

/// What decides which voxels of a scan are shown; while it stays, a look costs nothing.
#[derive(Clone, Debug, PartialEq)]
struct ShownAs {
    keep: Keep,
    taken_off: Option<TakenOff>,
    by_look: TakenOff,
    finds_labels: bool,
    label_files: Vec<std::path::PathBuf>,
    /// How deep is a number; how deep each point lies is what takes long.
    is_peeled: bool,
    cut: CutBy,
}

/// What is taken off so that a look shows what it is for.
fn taken_by_look(preset: Option<Preset>) -> TakenOff {
    match preset.and_then(Preset::organ) {
        Some(organ) => TakenOff::AllBut(organ),
        None => TakenOff::Skin(preset.map_or(0.0, Preset::peel_mm)),
    }
}

/// What lassos cut away, and which labels they spare.
#[derive(Clone, Debug, Default, PartialEq)]
struct CutBy {
    lassos: Vec<Lasso>,
    spared: Vec<(String, bool)>,
}

impl CutBy {
    fn of(entry: &Entry) -> Self {
        if entry.lassos.is_empty() {
            return Self::default();
        }
        let styles = entry.labels.iter().flat_map(|labels| &labels.styles);
        let spared = styles.filter_map(|style| Some((style.label.clone(), !style.clipped?)));
        Self { lassos: entry.lassos.clone(), spared: spared.collect() }
    }
}

impl ShownAs {
    fn of(entry: &Entry) -> Self {
        Self {
            keep: entry.scan.keep,
            taken_off: entry.scan.taken_off,
            by_look: taken_by_look(entry.look.preset),
            finds_labels: entry.labels.as_ref().is_some_and(|labels| labels.files.is_empty()),
            label_files: entry.labels.as_ref().map_or(vec![], |labels| labels.files.clone()),
            is_peeled: entry.peel.is_some_and(|mm| mm > 0.0),
            cut: CutBy::of(entry),
        }
    }

    /// The same, uncut.
    fn uncut(entry: &Entry) -> Self {
        Self { cut: CutBy::default(), ..Self::of(entry) }
    }
}

/// What of a document takes a job to show: voxels of its scans, and a map of light that is in a file.
#[derive(Clone)]
struct Asked {
    entries: Vec<Entry>,
    /// Of which scans it is known how deep their points lie, whether or not that is wanted now.
    have_depth: Vec<bool>,
    light: Surroundings,
}

impl Asked {
    fn of(document: &SceneDocument) -> Self {
        let have_depth = document.volumes.iter().map(|entry| ShownAs::of(entry).is_peeled).collect();
        Self { entries: document.volumes.clone(), have_depth, light: document.environment.clone() }
    }

    /// Whether a document is shown by that.
    fn is_of(&self, document: &SceneDocument) -> bool {
        self.is_alike(document, ShownAs::of)
    }

    /// Whether a document is shown by that but for what lassos cut away.
    fn is_of_uncut(&self, document: &SceneDocument) -> bool {
        self.is_alike(document, ShownAs::uncut)
    }

    fn is_alike(&self, document: &SceneDocument, shown: impl Fn(&Entry) -> ShownAs) -> bool {
        let covers = |(entry, (own, has_depth)): (&Entry, (&Entry, &bool))| {
            let [mut wanted, mut known] = [entry, own].map(&shown);
            let is_deep_enough = *has_depth || !wanted.is_peeled;
            (wanted.is_peeled, known.is_peeled) = (false, false);
            is_deep_enough && wanted == known
        };
        let own = self.entries.iter().zip(&self.have_depth);
        self.light.file() == document.environment.file()
            && document.volumes.len() == self.entries.len()
            && document.volumes.iter().zip(own).all(covers)
    }

    /// Makes a document such that it is shown by that; what has nothing to do with that stays.
    fn put_back(&self, document: &mut SceneDocument) {
        for (entry, shown) in document.volumes.iter_mut().zip(&self.entries) {
            let [own, old] = [&*entry, shown].map(ShownAs::of);
            (entry.scan.keep, entry.scan.taken_off) = (old.keep, old.taken_off);
            if own.is_peeled != old.is_peeled {
                entry.peel = shown.peel;
            }
            if own.by_look != old.by_look {
                entry.look = shown.look.clone();
            }
            if (own.finds_labels, own.label_files) != (old.finds_labels, old.label_files) {
                entry.labels = shown.labels.clone();
            }
            if own.cut != old.cut {
                entry.lassos.clone_from(&shown.lassos);
                // They say what is spared.
                entry.labels.clone_from(&shown.labels);
            }
        }
        if self.light.file() != document.environment.file() {
            document.environment.source.clone_from(&self.light.source);
        }
    }
}

/// What of scans is to be shown.
pub struct Wanted {
    /// As it says.
    pub document: SceneDocument,
    /// As they lie in their files.
    pub scans: Vec<Arc<Volume>>,
    /// What is shown by now, and the map of light, where nothing else changes than what lassos cut away of it.
    pub to_cut: Option<(Vec<Part>, Option<Arc<EnvironmentMap>>)>,
}

/// A scan that is open.
pub struct Session {
    history: History,
    scans: Vec<Arc<Volume>>,
    parts: Vec<Part>,
    /// What is shown, by the document then; and what is on its way, or shown as well.
    shown_of: Asked,
    asked_of: Asked,
    /// The map of light of that file.
    map: Option<(PathBuf, Arc<EnvironmentMap>)>,
    scene: Scene,
    version: u64,
    camera: PerspectiveCamera,
    /// From where it is seen until the view has a shape, which all is to fit: nobody said from where.
    unframed: Option<View>,
    /// Whether what is shown is still looked for.
    is_coming: bool,
    saved: SceneDocument,
    /// How the first scan was read.
    pub report: ImportReport,
    /// What else is worth telling.
    pub notes: Vec<String>,
}

/// Scenes are told from each other by numbers that no two sessions share.
fn next_version() -> u64 {
    static LAST: AtomicU64 = AtomicU64::new(0);
    LAST.fetch_add(1, Ordering::Relaxed) + 1
}

fn parts_of(scene: &Scene) -> Vec<Part> {
    let part = |it: &lumivox_core::VolumeInstance| Part {
        volume: it.volume.clone(),
        labels: it.labels.as_ref().map(|labelling| labelling.labels.clone()),
        peel: it.peel.clone(),
    };
    scene.volumes.iter().map(part).collect()
}

/// The map of light that a document names and a scene has.
fn map_of(light: &Surroundings, scene: &Scene) -> Option<(PathBuf, Arc<EnvironmentMap>)> {
    match &scene.environment.source {
        EnvironmentSource::Map(map) => Some((light.file()?.to_owned(), map.clone())),
        _ => None,
    }
}

impl Session {
    /// Begins with a scan of which it is still looked for what is shown.
    pub fn of_scan(opened: Opened) -> Self {
        let mut session = Self::new(opened);
        session.is_coming = true;
        for entry in &mut session.shown_of.entries {
            entry.scan.keep = Keep::Everything;
            (entry.labels, entry.peel) = (None, None);
        }
        session.shown_of.have_depth.fill(false);
        session
    }

    /// Begins with what was opened.
    pub fn new(opened: Opened) -> Self {
        let Opened { mut document, scans, scene, camera, is_framed, report, notes } = opened;
        // Wherever the camera is, it is there exactly: what is framed anew with every look would jump.
        document.camera = View::of(&camera);
        Self {
            map: map_of(&document.environment, &scene),
            unframed: is_framed.then_some(document.camera),
            parts: parts_of(&scene),
            shown_of: Asked::of(&document),
            asked_of: Asked::of(&document),
            saved: document.clone(),
            history: History::new(document),
            scans,
            scene,
            version: next_version(),
            camera,
            is_coming: false,
            report,
            notes,
        }
    }

    /// The document.
    pub fn document(&self) -> &SceneDocument {
        self.history.document()
    }

    /// What there is to see, and its number.
    pub fn scene(&self) -> (&Scene, u64) {
        (&self.scene, self.version)
    }

    /// Whether what is shown is still looked for: until then there are slices alone.
    pub fn is_coming(&self) -> bool {
        self.is_coming
    }

    /// From where.
    pub fn camera(&self) -> &PerspectiveCamera {
        &self.camera
    }

    /// Whether all of a scan is to fit the view, of which it is still looked for what is shown: until somebody turns it.
    pub fn fits_meanwhile(&self) -> bool {
        self.is_coming && self.unframed.as_ref() == Some(&self.document().camera)
    }

    /// The view has that shape, width over height: what nobody framed otherwise is framed for it, once.
    pub fn fit(&mut self, aspect: f64) {
        if !self.is_coming
            && let Some(before) = self.unframed.take()
            // Who turned it meanwhile said from where.
            && self.document().camera == before
            && let Some(camera) = View::default().camera(&self.scene, aspect)
        {
            let framed = View::of(&camera);
            // No command: there is nothing to go back to.
            self.history.rewrite(|document| {
                if document.camera == before {
                    document.camera = framed;
                }
            });
            self.saved.camera = framed;
            self.camera = camera;
        }
    }

    /// Says what tells the first scan from others. No command: it was so all along.
    pub fn identify(&mut self, content: &str) {
        let identify = |document: &mut SceneDocument| {
            if let Some(entry) = document.volumes.first_mut() {
                entry.scan.content.get_or_insert_with(|| content.to_owned());
            }
        };
        self.history.rewrite(identify);
        identify(&mut self.saved);
    }

    /// The stack of commands.
    pub fn history(&self) -> &History {
        &self.history
    }

    /// The first scan as it lies in its files: what slices show.
    pub fn scan(&self) -> &Arc<Volume> {
        &self.scans[0]
    }

    /// All of them.
    pub fn scans(&self) -> &[Arc<Volume>] {
        &self.scans
    }

    /// What to call it, without a patient's name.
    pub fn name(&self) -> &str {
        self.report.series.get(self.report.chosen).map_or("", |series| series.name.as_str())
    }

    /// A name for its files: letters and digits of [`name`](Self::name).
    pub fn file_name(&self, extension: &str) -> String {
        let plain = self.name().to_lowercase();
        let words: Vec<&str> =
            plain.split(|c: char| !c.is_ascii_alphanumeric()).filter(|w| !w.is_empty()).collect();
        let stem = if words.is_empty() { "scan".to_owned() } else { words.join("-") };
        format!("{stem}.{extension}")
    }

    /// Which of these looks the voxels that are shown have, too: one that wants more taken off would hide behind it, and skin that is
    /// not there cannot be seen.
    pub fn looks_of_shown(&self, looks: &[Preset]) -> Vec<Preset> {
        let Some(own) = self.document().volumes.first().and_then(|entry| entry.look.preset) else {
            return vec![];
        };
        let is_shown = |look: &Preset| {
            let has_skin = own.peel_mm() == 0.0 || *look != Preset::CtSkin;
            *look != own && look.organ() == own.organ() && look.peel_mm() <= own.peel_mm() && has_skin
        };
        looks.iter().copied().filter(is_shown).collect()
    }

    /// Whether something was changed since it was opened or saved.
    pub fn is_changed(&self) -> bool {
        self.history.document() != &self.saved
    }

    /// Whether something is unsaved that took work: not only where the camera stands.
    pub fn has_work(&self) -> bool {
        let document = self.history.document();
        document != &SceneDocument { camera: document.camera, ..self.saved.clone() }
    }

    /// It was never saved, as what was restored.
    pub fn forget_saved(&mut self) {
        self.saved = SceneDocument::default();
    }

    /// Changes the document by a command of that name. Whether voxels have to be shown anew, which takes a job.
    pub fn change(&mut self, what: Word, change: impl FnOnce(&mut SceneDocument)) -> bool {
        let mut document = self.document().clone();
        change(&mut document);
        self.history.change(what, document) && self.follow()
    }

    /// Nothing is held any more.
    pub fn close_step(&mut self) {
        self.history.close();
    }

    /// Goes back. Whether voxels have to be shown anew.
    pub fn undo(&mut self) -> bool {
        self.history.undo() && self.follow()
    }

    /// Goes forward again. Whether voxels have to be shown anew.
    pub fn redo(&mut self) -> bool {
        self.history.redo() && self.follow()
    }

    /// The camera as one that turns around what there is to see.
    pub fn orbit(&self) -> Orbit {
        lumivox_viewport::orbit_of(&self.camera, self.center())
    }

    /// Where the scan's middle is in the world.
    pub fn center(&self) -> DVec3 {
        lumivox_viewport::center_of(&self.scene)
    }

    /// The patient's left, back and head in the world, of the first scan.
    pub fn patient_axes(&self) -> DMat3 {
        let placed = self.scene.volumes.first().map_or(DMat3::IDENTITY, |it| it.world_from_patient.matrix3);
        let [x, y, z] = [placed.x_axis, placed.y_axis, placed.z_axis].map(|axis| axis.normalize_or_zero());
        DMat3::from_cols(x, y, z)
    }

    /// The azimuth and elevation from which a side of the patient (LPS) is seen, in radians.
    pub fn angles_of(&self, side: DVec3) -> [f64; 2] {
        /// Straight from above the vertical has no direction.
        const STEEP: f64 = FRAC_PI_2 - 0.01;
        let axes = self.patient_axes();
        let (out, front) = (axes * side, -axes.y_axis);
        let elevation = out.y.clamp(-1.0, 1.0).asin();
        // From above and below the patient lies as from the front.
        let around = if elevation.abs() > STEEP { front } else { out };
        [around.x.atan2(around.z), elevation.clamp(-STEEP, STEEP)]
    }

    /// An orbit around all that is seen, from these angles in radians.
    pub fn framed(&self, azimuth: f64, elevation: f64, aspect: f64) -> Orbit {
        framing::frame(&self.scene, azimuth, elevation, self.camera.vertical_fov, aspect)
    }

    /// What a job has to do for the document as it is.
    pub fn to_show(&mut self) -> Wanted {
        self.asked_of = Asked::of(self.document());
        let is_uncut = !self.is_coming && self.shown_of.is_of_uncut(self.document());
        Wanted {
            document: self.document().clone(),
            scans: self.scans.clone(),
            to_cut: is_uncut.then(|| (self.parts.clone(), self.map.clone().map(|(_, map)| map))),
        }
    }

    /// What such a job found. What was changed meanwhile stays changed. Whether that has to be asked for.
    pub fn shown(&mut self, scene: &Scene, notes: Vec<String>) -> bool {
        self.is_coming = false;
        self.parts = parts_of(scene);
        self.map = map_of(&self.asked_of.light, scene);
        self.shown_of = self.asked_of.clone();
        for note in notes {
            if !self.notes.contains(&note) {
                self.notes.push(note);
            }
        }
        self.follow()
    }

    /// What is on its way is not waited for: by one command the document is again what is shown of it, and what was changed otherwise
    /// stays. Back from there it is asked for once more. A scan of which nothing was found yet begins with all of it.
    /// Whether something else has to be asked for.
    pub fn give_up(&mut self) -> bool {
        if self.is_coming {
            return self.refused();
        }
        let shown = self.shown_of.clone();
        self.asked_of.clone_from(&shown);
        let anew = self.change(Word::TakenBack, |document| shown.put_back(document));
        self.close_step();
        anew
    }

    /// What was on its way cannot be shown: no document wants it any more, nor did one. Whether something else has to be asked for.
    pub fn refused(&mut self) -> bool {
        let shown = self.shown_of.clone();
        let refused = std::mem::replace(&mut self.asked_of, shown.clone());
        // It begins with all that was scanned, where that is what there is.
        let was_coming = std::mem::take(&mut self.is_coming);
        let put_back = |document: &mut SceneDocument| {
            if was_coming {
                let lassos: Vec<_> = document.volumes.iter().map(|entry| entry.lassos.clone()).collect();
                shown.put_back(document);
                // Those were drawn meanwhile.
                document.volumes.iter_mut().zip(lassos).for_each(|(entry, own)| entry.lassos = own);
            } else if refused.is_of(document) {
                shown.put_back(document);
            }
        };
        self.history.rewrite(put_back);
        if was_coming {
            put_back(&mut self.saved);
        }
        self.follow()
    }

    /// Makes the scene that the document says, with the voxels that there are. Whether others have to be asked for.
    fn follow(&mut self) -> bool {
        let document = self.history.document();
        let file = document.environment.file();
        let map = self.map.as_ref().filter(|(known, _)| file == Some(known)).map(|(_, map)| map.clone());
        let mut parts = self.parts.clone();
        for (part, entry) in parts.iter_mut().zip(&document.volumes) {
            if let Some(peel) = &mut part.peel {
                peel.mm = entry.peel.unwrap_or(0.0);
            }
        }
        // Until the map of another file is there, all stays as it is.
        if file.is_some() == map.is_some()
            && let Ok(scene) = lumivox_scene::assemble(document, parts, map)
            && !scene.is_same(&self.scene)
        {
            self.scene = scene;
            self.version = next_version();
        }
        if let Some(camera) = document.camera.camera(&self.scene, document.film.aspect()) {
            self.camera = camera;
        }
        // What needs no other voxels is shown by now.
        if self.shown_of.is_of(document) {
            let have_depth = std::mem::take(&mut self.shown_of.have_depth);
            self.shown_of = Asked { have_depth, ..Asked::of(document) };
        }
        !self.asked_of.is_of(document)
    }

    /// The document, with how slices are seen: that is no command, and no work that would be asked about.
    pub fn document_with(&self, slices: Slices) -> SceneDocument {
        SceneDocument { slices: Some(slices), ..self.document().clone() }
    }

    /// Writes the scene's file.
    ///
    /// # Errors
    /// A sentence that names the file.
    pub fn save(&mut self, file: &Path, slices: Slices) -> Result<(), String> {
        files::save_scene(file, &self.document_with(slices), &self.scene)?;
        self.saved = self.document().clone();
        Ok(())
    }
}
