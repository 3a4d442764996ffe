//! What jobs have told, before each frame.

use std::path::Path;

use eframe::egui::{self, ColorImage, TextureOptions};
use lumivox_core::Preset;

use super::{App, keeping};
use crate::darkroom::{Exported, Tile};
use crate::errands;
use crate::opening::{Source, Told};
use crate::session::Session;
use crate::state::Strip;
use crate::words::Word;

/// Samples of the picture from which looks are made pictures of, too: where a processor traces, it rests minutes later.
const ENOUGH: u32 = 64;

/// What is done for a file.
fn exporting(file: &Path) -> Word {
    match file.extension() {
        Some(ending) if ending == "html" => Word::Sharing,
        _ => Word::Rendering,
    }
}

impl App {
    /// What jobs have told.
    pub(super) fn poll(&mut self, context: &egui::Context) {
        match self.archive.poll(self.state.settings.language) {
            // Meanwhile there may be work, which is asked about.
            Some(Ok(folder)) => self.replace(Source::Files(vec![folder])),
            Some(Err(why)) => self.state.failed = Some((Word::CannotOpen, why)),
            None => {}
        }
        self.poll_opening(context);
        self.poll_showing();
        if let Some(job) = &mut self.tiling {
            for Tile { preset, picture } in job.poll() {
                let size = picture.size.map(|n| n as usize);
                let image = ColorImage::from_rgba_unmultiplied(size, &picture.rgba);
                let texture = context.load_texture(preset.name(), image, TextureOptions::LINEAR);
                self.state.tiles.insert(preset, texture);
            }
            if job.is_over() {
                self.tiling = None;
            }
        }
        self.poll_export();
        self.make_tiles();
        if let Some((_, job)) = &mut self.asking {
            let told = job.poll();
            // What was told counts at once: the job may end a moment later.
            if (!told.is_empty() || job.is_over())
                && let Some((ask, _)) = self.asking.take()
            {
                match told.into_iter().next() {
                    Some(files) if !files.is_empty() => self.chosen(ask, files),
                    // Who does not say where, does not leave either.
                    _ => self.closes = None,
                }
            }
        }
        let is_coming = self.state.session.as_ref().is_some_and(Session::is_coming);
        let opening = if is_coming { Word::Showing } else { Word::Reading };
        let jobs = [
            self.archive.busy().map(|busy| (Word::Reading, busy)),
            self.opening.as_ref().map(|job| (opening, job.busy())),
            self.exporting.as_ref().map(|(file, job)| (exporting(file), job.busy())),
            self.showing.as_ref().map(|job| (Word::Showing, job.busy())),
        ];
        self.state.busy = jobs.into_iter().flatten().next();
    }

    /// Voxels that are shown anew. Where they do not come, the scan stays as it is shown.
    fn poll_showing(&mut self) {
        let Some(job) = &mut self.showing else { return };
        let told = job.poll();
        let mut why = job.is_broken().then(|| self.state.say(Word::Stopped).to_owned());
        if job.is_over() {
            self.showing = None;
        }
        let mut anew = false;
        for shown in told {
            match (shown, &mut self.state.session) {
                (Ok((scene, notes)), Some(session)) => anew = session.shown(&scene, notes),
                (Ok(_), None) => {}
                (Err(words), _) => why = Some(words),
            }
        }
        if anew {
            self.show_anew();
        }
        if let Some(why) = why {
            self.showing = None;
            self.state.failed = Some((Word::CannotShow, why));
            if self.state.session.as_mut().is_some_and(Session::refused) {
                self.show_anew();
            }
        }
    }

    /// Begins with tiles that are wanted, once the picture itself is clean enough to look at.
    fn make_tiles(&mut self) {
        let is_busy = self.tiling.is_some() || self.exporting.is_some() || self.opening.is_some();
        let is_wanted = |look: &Preset| !self.state.tiles.contains_key(look);
        let looks: Vec<Preset> = self.state.looks.iter().copied().filter(is_wanted).collect();
        if !self.state.has_tiles
            || is_busy
            || looks.is_empty()
            || self.were_tiles_made
            || !(self.state.progress.rests || self.state.progress.samples >= ENOUGH)
        {
            return;
        }
        let Some(session) = &self.state.session else { return };
        let (document, scan) = (session.document().clone(), session.scan().clone());
        self.tiling = Some(errands::tiles(self.darkroom.clone(), document, scan, looks, self.wake.clone()));
        self.were_tiles_made = true;
    }

    fn poll_opening(&mut self, context: &egui::Context) {
        let Some(job) = &mut self.opening else { return };
        let told = job.poll();
        let is_over = job.is_over();
        if job.is_broken() {
            self.state.failed = Some((Word::CannotOpen, self.state.say(Word::Stopped).to_owned()));
        }
        for message in told {
            match message {
                Told::Series { series, chosen, study } => {
                    let known = &self.state.strip;
                    let is_same = known.study.as_ref().is_some_and(|known| known.is_same(&study));
                    let thumbnails = if is_same { known.thumbnails.clone() } else { Default::default() };
                    *self.arriving.as_mut().unwrap_or(&mut self.state.strip) =
                        Strip { series, chosen, study: Some(study), thumbnails };
                }
                Told::Thumbnail(place, picture) => {
                    let size = [picture.width, picture.height];
                    let image = ColorImage::from_gray(size, &picture.grey);
                    let texture = context.load_texture("series", image, TextureOptions::LINEAR);
                    let strip = self.arriving.as_mut().unwrap_or(&mut self.state.strip);
                    strip.thumbnails.insert(place, texture);
                }
                Told::Opened(opened) => self.begin_session(Session::new(*opened)),
                Told::Scan(opened) => self.begin_session(Session::of_scan(*opened)),
                Told::Content(content) => {
                    if let Some(session) = &mut self.state.session {
                        session.identify(&content);
                    }
                }
                Told::Found(scene, notes) => {
                    let session = self.state.session.as_mut();
                    if session.is_some_and(|session| session.shown(&scene, notes)) {
                        self.show_anew();
                    }
                }
                Told::Failed(why) => {
                    self.state.failed = Some((Word::CannotOpen, why));
                }
            }
        }
        if is_over {
            self.end_opening();
        }
    }

    /// A scan takes the place of what is shown.
    fn begin_session(&mut self, mut session: Session) {
        if let Some(live) = &mut self.live {
            live.forget();
        }
        self.showing = None;
        self.state.progress = Default::default();
        let was_left = std::mem::take(&mut self.is_restoring);
        if was_left {
            session.forget_saved();
        } else if let Some(rescue) = &mut self.rescue {
            rescue.clear();
        }
        self.state.begin(session);
        if let Some(strip) = self.arriving.take() {
            self.state.strip = strip;
        }
        if was_left {
            self.open_later();
        }
    }

    /// Nothing is opened any more. What another run left is asked for again where it did not come.
    pub(super) fn end_opening(&mut self) {
        (self.opening, self.arriving) = (None, None);
        // Nobody looks any more for what is shown of a scan: all of it.
        let session = self.state.session.as_mut().filter(|session| session.is_coming());
        if let (Some(session), None) = (session, &self.showing)
            && session.give_up()
        {
            self.show_anew();
        }
        if std::mem::take(&mut self.is_restoring) {
            self.ask_to_restore();
        }
    }

    fn poll_export(&mut self) {
        let Some((file, job)) = &mut self.exporting else { return };
        for told in job.poll() {
            match told {
                Exported::Written(note) => {
                    let name = file.file_name().unwrap_or_default().to_string_lossy();
                    let note = note
                        .map_or(String::new(), |word| format!(". {}", word.of(self.state.settings.language)));
                    self.state.done = Some(format!("{}: {name}{note}", self.state.say(Word::Saved)));
                }
                Exported::Turned { steps, is_reduced, has_film } => {
                    self.state.done = Some(keeping::turned(&self.state, file, steps, is_reduced, has_film));
                }
                Exported::Failed(why) => self.state.failed = Some((Word::CannotSave, why)),
            }
        }
        if job.is_broken() {
            self.state.failed = Some((Word::CannotSave, self.state.say(Word::Stopped).to_owned()));
        }
        if job.is_over() {
            self.exporting = None;
        }
    }
}
