//! What leaves the program: tables, turns, a view for the clipboard; and what is kept of unsaved work when it ends.

use std::path::{Path, PathBuf};
use std::time::Duration;

use eframe::egui::{self, ViewportCommand};

use super::{App, Closing};
use crate::darkroom::{film_file, step_file};
use crate::opening::Source;
use crate::rescue::{EVERY_SECONDS, Rescue};
use crate::session::Session;
use crate::state::{Dialog, State};
use crate::words::Word;
use crate::{errands, files, measuring};

/// Names of files, as far as a dialog has room for them.
fn names(files: &[PathBuf]) -> String {
    const MOST: usize = 4;
    let all: Vec<_> =
        files.iter().map(|file| file.file_name().unwrap_or_default().to_string_lossy()).collect();
    match &all[..] {
        [first, .., last] if all.len() > MOST => format!("{first} \u{2026} {last} ({})", all.len()),
        _ => all.join(", "),
    }
}

/// What is said of a turn that is written.
pub(super) fn turned(state: &State, file: &Path, steps: u32, is_reduced: bool, has_film: bool) -> String {
    let pictures: Vec<PathBuf> = (0..steps).map(|step| step_file(file, step)).collect();
    let mut said = format!("{}: {}", state.say(Word::Saved), names(&pictures));
    if has_film {
        said += &format!(", {}", names(&[film_file(file)]));
    }
    for word in
        [is_reduced.then_some(Word::Reduced), (!has_film).then_some(Word::NoFilm)].into_iter().flatten()
    {
        said += &format!(". {}", state.say(word));
    }
    said
}

impl App {
    /// A turn, once it is asked whether its files replace others.
    pub(super) fn ask_to_turn(&mut self, file: PathBuf, steps: u32) {
        let files = (0..steps).map(|step| step_file(&file, step)).chain([film_file(&file)]);
        let there: Vec<PathBuf> = files.filter(|file| file.exists()).collect();
        if there.is_empty() {
            self.turn_to(file, steps);
        } else {
            let there = names(&there);
            self.state.dialog = Some(Dialog::Overwrite { file, steps, there });
        }
    }

    pub(super) fn turn_to(&mut self, file: PathBuf, steps: u32) {
        let Some(session) = &self.state.session else { return };
        if session.is_coming() {
            return self.has_no_picture();
        }
        (self.tiling, self.were_tiles_made) = (None, false);
        let (scene, document) = (session.scene().0.clone(), session.document().clone());
        let (start, room, wake) = (session.orbit(), self.darkroom.clone(), self.wake.clone());
        let job = errands::turn(room, document, scene, start, (file.clone(), steps), wake);
        self.exporting = Some((file, job));
    }

    /// The picture of the view that keys are for, once the window was drawn.
    pub(super) fn copy_screenshot(&mut self, context: &egui::Context) {
        let image = context.input(|input| {
            input.events.iter().find_map(|event| match event {
                egui::Event::Screenshot { image, .. } => Some(image.clone()),
                _ => None,
            })
        });
        if let Some(image) = image {
            let scale = context.pixels_per_point();
            context.copy_image(image.region(&self.state.active_rect, Some(scale)));
            self.state.done = Some(self.state.say(Word::Copied).to_owned());
        }
    }

    /// Keeps what is unsaved, every few seconds.
    pub(super) fn keep_unsaved(&mut self, context: &egui::Context) {
        let (Some(session), Some(rescue)) = (&self.state.session, &mut self.rescue) else { return };
        let now = context.input(|input| input.time);
        if now - self.looked_at >= EVERY_SECONDS {
            self.looked_at = now;
            if session.is_changed() {
                rescue.keep(&session.document_with(self.state.slices()));
            }
        }
        // A view that rests is looked at again, too. Any frame between forgets what the one before asked for.
        let left = self.looked_at + EVERY_SECONDS - now;
        context.request_repaint_after(Duration::from_secs_f64(left.clamp(0.0, EVERY_SECONDS)));
    }

    /// Asks what becomes of what another run left, if it left something.
    pub(super) fn ask_to_restore(&mut self) {
        let left = self.rescue.as_ref().and_then(Rescue::left).map(Path::to_owned);
        if left.is_some() {
            self.state.dialog = left.map(Dialog::Restore);
        }
    }

    /// Whether what another run left is asked about, or on its way: nothing else takes its place, and it is kept.
    fn is_left(&self) -> bool {
        self.is_restoring || matches!(self.state.dialog, Some(Dialog::Restore(_)))
    }

    /// Opens what came while that was so.
    pub(super) fn open_later(&mut self) {
        let later = std::mem::take(&mut self.later);
        if !later.is_empty() {
            self.replace(Source::Files(later));
        }
    }

    /// Opens something in place of what is shown; asks before where that is unsaved.
    pub(super) fn replace(&mut self, source: Source) {
        if self.is_left()
            && let Source::Files(files) = source
        {
            self.later = files;
        } else if self.state.session.as_ref().is_some_and(Session::has_work) {
            self.next = Some(source);
            self.state.dialog = Some(Dialog::Leave { opens: true });
        } else {
            self.open(source);
        }
    }

    /// Leaves a scene whose work is saved, or wanted by nobody: for what comes in its place, or for good.
    pub(super) fn leave(&mut self) {
        self.closes = match self.next.take() {
            Some(source) => {
                self.open(source);
                None
            }
            None => Some(Closing::Now),
        };
    }

    /// A window that is to be closed asks where something is unsaved.
    pub(super) fn follow_close(&mut self, context: &egui::Context) {
        if self.closes == Some(Closing::Now) {
            context.send_viewport_cmd(ViewportCommand::Close);
        }
        if !context.input(|input| input.viewport().close_requested()) {
            return;
        }
        let has_work = self.state.session.as_ref().is_some_and(Session::has_work);
        if has_work && self.closes != Some(Closing::Now) {
            context.send_viewport_cmd(ViewportCommand::CancelClose);
            self.next = None;
            self.state.dialog = Some(Dialog::Leave { opens: false });
        } else if !self.is_left()
            && let Some(rescue) = &mut self.rescue
        {
            rescue.clear();
        }
    }

    pub(super) fn save_table(&mut self, file: &Path) {
        let Some(session) = &self.state.session else { return };
        let table = measuring::csv(&session.document().measurements, session.scan());
        match files::save(file, &mut |out| Ok(out.write_all(table.as_bytes())?)) {
            Ok(()) => {
                let name = file.file_name().unwrap_or_default().to_string_lossy();
                self.state.done = Some(format!("{}: {name}", self.state.say(Word::Saved)));
            }
            Err(why) => self.state.failed = Some((Word::CannotSave, why)),
        }
    }

    /// Opens what another run left, or throws it away.
    pub(super) fn restore(&mut self, restores: bool) {
        let left = self.rescue.as_ref().and_then(Rescue::left).map(Path::to_owned);
        match left {
            Some(file) if restores => {
                self.open(Source::Files(vec![file]));
                self.is_restoring = true;
            }
            _ => {
                if let Some(rescue) = &mut self.rescue {
                    rescue.clear();
                }
                self.open_later();
            }
        }
    }
}
