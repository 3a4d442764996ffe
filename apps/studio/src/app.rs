//! The program: it gathers what people and jobs want, does it, and shows the state.

mod keeping;
mod polling;

use std::future::Future;
use std::path::PathBuf;
use std::pin::Pin;
use std::sync::Arc;

use eframe::egui::{self, Frame, Margin, Panel, ViewportCommand};
use lumivox_core::Preset;
use lumivox_core::document::View;

use crate::archive::Archive;
use crate::darkroom::{Darkroom, ExportDraft, Exported, Tile};
use crate::errands;
use crate::jobs::{Job, Wake};
use crate::live::Live;
use crate::opening::{Shown, Source, Told};
use crate::panels::{dialogs, light, side, strip, structures, tools, top, views, welcome};
use crate::rescue::Rescue;
use crate::session::Session;
use crate::settings::{Drawer, Settings};
use crate::sharing::{SIDES, Sharing};
use crate::state::{Action, Ask, Dialog, State, Strip};
use crate::theme;
use crate::words::{Language, Word};

/// What a file dialog will say: nothing, where it was closed.
#[cfg(not(target_family = "wasm"))]
pub type Choice = Pin<Box<dyn Future<Output = Vec<PathBuf>> + Send>>;
/// What a file dialog will say: nothing, where it was closed. There is one thread.
#[cfg(target_family = "wasm")]
pub type Choice = Pin<Box<dyn Future<Output = Vec<PathBuf>>>>;

/// Who shows file dialogs: the desktop, a browser, a test.
pub trait Chooser {
    /// Begins a dialog.
    fn ask(&self, ask: &Ask, language: Language) -> Choice;
}

/// What the program is given by its host.
pub struct Launch {
    /// Scans or a scene that are opened at once.
    pub open: Vec<PathBuf>,
    /// Where settings are kept.
    pub drawer: Box<dyn Drawer>,
    /// Who shows file dialogs.
    pub chooser: Box<dyn Chooser>,
    /// Whether looks are shown as tiles of the scan, which takes a slow GPU's time.
    pub makes_tiles: bool,
}

/// The program.
pub struct App {
    /// What is shown.
    pub state: State,
    live: Option<Live>,
    drawer: Box<dyn Drawer>,
    chooser: Box<dyn Chooser>,
    archive: Archive,
    darkroom: Darkroom,
    /// Of this scan; not again where a look has none.
    were_tiles_made: bool,
    wake: Wake,
    opening: Option<Job<Told>>,
    /// The series of what is opened, until that takes the place of what is shown.
    arriving: Option<Strip>,
    showing: Option<Job<Shown>>,
    tiling: Option<Job<Tile>>,
    exporting: Option<(PathBuf, Job<Exported>)>,
    asking: Option<(Ask, Job<Vec<PathBuf>>)>,
    rescue: Option<Rescue>,
    /// When unsaved work was last looked at, in seconds of the interface.
    looked_at: f64,
    /// What is opened once it is said what becomes of another run's unsaved work, and that is there again.
    later: Vec<PathBuf>,
    /// What is opened was unsaved before.
    is_restoring: bool,
    /// The window closes once the scene is saved, or now.
    closes: Option<Closing>,
    /// What is opened in place of a scene with unsaved work, once it is said what becomes of that.
    next: Option<Source>,
    title: String,
}

/// How a window is closed that had unsaved work.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Closing {
    /// When the scene is saved.
    Saved,
    /// Whatever is unsaved.
    Now,
}

impl App {
    /// Begins. The device is eframe's, which [`gpu_options`](crate::gpu_options) describes.
    pub fn new(context: &eframe::CreationContext<'_>, launch: Launch) -> Self {
        let egui = context.egui_ctx.clone();
        theme::apply(&egui);
        let settings = launch.drawer.read().unwrap_or_default();
        theme::choose(&egui, settings.is_dark);
        let wake: Wake = Arc::new(move || egui.request_repaint());
        let mut app = Self {
            archive: Archive::new(launch.drawer.archive_folder(), &settings),
            state: State::new(settings),
            live: context.wgpu_render_state.as_ref().map(Live::new),
            drawer: launch.drawer,
            chooser: launch.chooser,
            darkroom: Darkroom::default(),
            were_tiles_made: false,
            wake,
            opening: None,
            arriving: None,
            showing: None,
            tiling: None,
            exporting: None,
            asking: None,
            rescue: None,
            looked_at: 0.0,
            later: vec![],
            is_restoring: false,
            closes: None,
            next: None,
            title: String::new(),
        };
        app.state.has_tiles = launch.makes_tiles;
        app.rescue = app.drawer.rescue_folder().and_then(|folder| Rescue::in_folder(&folder));
        app.ask_to_restore();
        if app.state.dialog.is_some() {
            app.later = launch.open;
        } else if !launch.open.is_empty() {
            app.open(Source::Files(launch.open));
        }
        app
    }

    /// The 3D view, for tests of its pixels.
    pub fn live_mut(&mut self) -> Option<&mut Live> {
        self.live.as_mut()
    }

    /// Whether nothing is done beside the interface but tiles, and the scan is seen.
    pub fn is_quiet(&self) -> bool {
        let jobs = self.opening.is_some() || self.showing.is_some() || self.archive.busy().is_some();
        let is_seen = self.state.session.is_none() || self.state.progress.is_shown;
        !jobs && self.exporting.is_none() && self.asking.is_none() && is_seen
    }

    fn open(&mut self, source: Source) {
        let job = errands::open(source, self.wake.clone());
        self.begin(job);
    }

    /// Shows what a job opens, once it has.
    pub fn begin(&mut self, job: Job<Told>) {
        // Tiles that are left come when it is over, whatever becomes of it.
        (self.tiling, self.were_tiles_made) = (None, false);
        (self.state.done, self.is_restoring) = (None, false);
        // The job before may still look for what is shown of the scan that is there, which stays if this one fails.
        if self.state.session.as_ref().is_some_and(Session::is_coming) && self.showing.is_none() {
            self.show_anew();
        }
        (self.opening, self.arriving) = (Some(job), Some(Strip::default()));
    }

    /// Wakes the interface.
    pub fn wake(&self) -> &Wake {
        &self.wake
    }

    /// Shows the voxels that the document wants.
    fn show_anew(&mut self) {
        let Some(session) = &mut self.state.session else { return };
        self.showing = Some(errands::show(session.to_show(), self.wake.clone()));
    }

    fn export_to(&mut self, file: PathBuf) {
        let Some(session) = &self.state.session else { return };
        if session.is_coming() {
            return self.has_no_picture();
        }
        // The picture comes before the tiles that are left.
        (self.tiling, self.were_tiles_made) = (None, false);
        let (scene, document) = (session.scene().0.clone(), session.document().clone());
        let (camera, room) = (*session.camera(), self.darkroom.clone());
        let job = errands::export(room, document, scene, camera, file.clone(), self.wake.clone());
        self.exporting = Some((file, job));
    }

    /// Whether the scene is that of the document: what was cut away a moment ago may be in it still.
    fn shows_what_is_wanted(&self) -> bool {
        let session = self.state.session.as_ref();
        session.is_some_and(|session| !session.is_coming()) && self.showing.is_none()
    }

    fn share_to(&mut self, file: PathBuf, side: usize) {
        if !self.shows_what_is_wanted() {
            return self.has_no_picture();
        }
        let Some(session) = &self.state.session else { return };
        let sharing = Sharing {
            scene: session.scene().0.clone(),
            document: session.document().clone(),
            camera: *session.camera(),
            title: session.name().to_owned(),
            looks: session.looks_of_shown(&self.state.looks),
            language: self.state.settings.language,
            side,
        };
        let job = errands::share(sharing, file.clone(), self.wake.clone());
        self.exporting = Some((file, job));
    }

    /// Who asked for a picture of the scan before hears that there is none yet of the one in its place.
    fn has_no_picture(&mut self) {
        self.state.failed = Some((Word::CannotSave, self.state.say(Word::Preparing).to_owned()));
    }

    /// What became of a file dialog.
    fn chosen(&mut self, ask: Ask, files: Vec<PathBuf>) {
        if matches!(ask, Ask::Files | Ask::Folder) {
            return self.replace(Source::Files(files));
        }
        if matches!(ask, Ask::Labels | Ask::LabelFolder) {
            return structures::open(&mut self.state, files);
        }
        match (ask, files.into_iter().next()) {
            (Ask::Light, Some(file)) => light::open(&mut self.state, file),
            (Ask::SaveScene(_), Some(file)) => {
                let file = with_extension(file, &["lumivox", "json"]);
                let slices = self.state.slices();
                if let Some(session) = &mut self.state.session {
                    match session.save(&file, slices) {
                        Ok(()) => {
                            if let Some(rescue) = &mut self.rescue {
                                rescue.clear();
                            }
                            if self.closes == Some(Closing::Saved) {
                                self.leave();
                            }
                            let name = file.file_name().unwrap_or_default().to_string_lossy();
                            self.state.done = Some(format!("{}: {name}", self.state.say(Word::Saved)));
                        }
                        Err(why) => {
                            self.closes = None;
                            self.state.failed = Some((Word::CannotSave, why));
                        }
                    }
                }
            }
            (Ask::SavePicture(_), Some(file)) => self.export_to(with_extension(file, &["png"])),
            (Ask::SaveTurn(_, steps), Some(file)) => self.ask_to_turn(with_extension(file, &["png"]), steps),
            (Ask::SavePage(_, side), Some(file)) => self.share_to(with_extension(file, &["html"]), side),
            (Ask::SaveTable(_), Some(file)) => self.save_table(&with_extension(file, &["csv"])),
            _ => {}
        }
    }

    fn act(&mut self, context: &egui::Context, action: Action) {
        let mut anew = false;
        match action {
            Action::Ask(ask) => {
                if self.asking.is_none() {
                    let choice = self.chooser.ask(&ask, self.state.settings.language);
                    self.asking = Some((ask, errands::choose(choice, self.wake.clone())));
                }
            }
            Action::Open(files) => self.replace(Source::Files(files)),
            Action::Series(place) => {
                if let Some(study) = self.state.strip.study.clone() {
                    self.replace(Source::Series(study, place));
                }
            }
            Action::Look(preset) => {
                anew = self.change(Word::Looks, |document| {
                    if let Some(entry) = document.volumes.first_mut() {
                        entry.look = lumivox_core::document::Look::of_preset(preset);
                    }
                });
            }
            Action::Camera(orbit) => {
                anew = self.change(Word::Camera, |document| document.camera = View::of(&orbit.camera()));
            }
            Action::Frame(azimuth, elevation) => {
                let [width, height] = self.state.view_size.map(f64::from);
                let orbit = self.state.session.as_ref().map(|session| {
                    session.framed(azimuth.to_radians(), elevation.to_radians(), width / height)
                });
                if let Some(orbit) = orbit {
                    anew = self.change(Word::Camera, |document| document.camera = View::of(&orbit.camera()));
                }
            }
            Action::Change(what, document) => anew = self.change(what, |own| *own = *document),
            Action::Cross(point) => self.state.cross = point,
            Action::Undo => anew = self.state.session.as_mut().is_some_and(Session::undo),
            Action::Redo => anew = self.state.session.as_mut().is_some_and(Session::redo),
            Action::About => self.state.dialog = Some(Dialog::About),
            Action::ExportDialog => {
                // Keys ask for it while there is nothing to see, too.
                if let Some(session) = self.state.session.as_ref().filter(|session| !session.is_coming()) {
                    let draft = ExportDraft::of(session.document(), self.state.view_size);
                    self.state.dialog = Some(Dialog::Export(draft));
                }
            }
            Action::ShareDialog => {
                if self.shows_what_is_wanted() {
                    self.state.dialog = Some(Dialog::Share(SIDES[1], false));
                }
            }
            Action::ArchiveDialog => self.state.dialog = Some(Dialog::Archive),
            Action::Fetch(request) => self.archive.fetch(*request, &self.wake),
            Action::Agree => {
                let settings = Settings { has_agreed: true, ..self.state.settings.clone() };
                self.keep(settings);
            }
            Action::Settings(settings) => self.keep(settings),
            Action::Copy => context.send_viewport_cmd(ViewportCommand::Screenshot(Default::default())),
            Action::Restore(restores) => self.restore(restores),
            Action::Turn(file, steps) => self.turn_to(file, steps),
            Action::Close => self.leave(),
            Action::SaveAndClose => {
                match &self.asking {
                    None => {
                        self.closes = Some(Closing::Saved);
                        let name = self.state.session.as_ref().map(|session| session.file_name("lumivox"));
                        self.state.act(Action::Ask(Ask::SaveScene(name.unwrap_or_default())));
                    }
                    // It is asked already where to.
                    Some((Ask::SaveScene(_), _)) => self.closes = Some(Closing::Saved),
                    // Of two file dialogs at once the second would not come: this one stays until there is room.
                    Some(_) => self.state.dialog = Some(Dialog::Leave { opens: self.next.is_some() }),
                }
            }
            Action::Cancel => {
                // What was shown before stays.
                self.end_opening();
                self.exporting = None;
                self.archive.give_up();
                if let (Some(_), Some(session)) = (self.showing.take(), &mut self.state.session) {
                    anew = session.give_up();
                }
            }
        }
        // What is looked for already comes first.
        if anew && !self.state.session.as_ref().is_some_and(Session::is_coming) {
            self.show_anew();
        }
    }

    fn change(
        &mut self,
        what: Word,
        change: impl FnOnce(&mut lumivox_core::document::SceneDocument),
    ) -> bool {
        self.state.session.as_mut().is_some_and(|session| session.change(what, change))
    }

    fn keep(&mut self, settings: Settings) {
        self.drawer.write(&settings);
        self.state.settings = settings;
    }

    /// The window's title: what kind of scan it is, and never whose.
    fn follow_title(&mut self, context: &egui::Context) {
        let title = match &self.state.session {
            Some(session) => format!("{} \u{2013} Lumivox Studio", session.name()),
            None => "Lumivox Studio".to_owned(),
        };
        if title != self.title {
            context.send_viewport_cmd(ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }
}

/// A file's name with one of these endings, the first where it has none of them.
fn with_extension(file: PathBuf, known: &[&str]) -> PathBuf {
    let has = |ending: &&str| file.extension().is_some_and(|own| own.eq_ignore_ascii_case(ending));
    if known.iter().any(has) {
        return file;
    }
    let mut name = file.into_os_string();
    name.push(".");
    name.push(known[0]);
    name.into()
}

impl eframe::App for App {
    #[cfg(target_family = "wasm")]
    fn as_any_mut(&mut self) -> Option<&mut dyn std::any::Any> {
        Some(self)
    }

    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        let context = ui.ctx().clone();
        theme::choose(&context, self.state.settings.is_dark);
        self.poll(&context);
        self.copy_screenshot(&context);
        self.keep_unsaved(&context);
        self.follow_close(&context);
        let dropped: Vec<PathBuf> = context
            .input(|input| input.raw.dropped_files.iter().filter_map(|file| file.path.clone()).collect());
        if !dropped.is_empty() {
            self.state.act(Action::Open(dropped));
        }
        top::keys(&context, &mut self.state);
        let p = theme::palette(self.state.settings.is_dark);
        let bar = |sides: i8| Frame::new().fill(p.panel).inner_margin(Margin::symmetric(sides, 6));
        let state = &mut self.state;
        let gpu = self.live.as_ref().map_or(String::new(), |live| live.gpu_name().to_owned());
        Panel::top("toolbar").exact_size(52.0).frame(bar(16)).show(ui, |ui| top::toolbar(ui, state));
        Panel::bottom("status").exact_size(32.0).frame(bar(14)).show(ui, |ui| top::status(ui, state, &gpu));
        if state.session.is_some() {
            let side =
                Frame::new().fill(p.panel).inner_margin(Margin { left: 14, right: 10, top: 8, bottom: 8 });
            Panel::left("series").default_size(232.0).size_range(180.0..=340.0).frame(side).show(ui, |ui| {
                strip::show(ui, state);
            });
            Panel::right("look").exact_size(324.0).resizable(false).frame(side).show(ui, |ui| {
                side::show(ui, state);
            });
        }
        egui::CentralPanel::no_frame().show(ui, |ui| {
            ui.spacing_mut().item_spacing = egui::vec2(8.0, 0.0);
            top::banner(ui, state);
            if state.session.is_some() {
                tools::show(ui, state);
                views::show(ui, state, self.live.as_mut());
            } else {
                welcome::show(ui, state);
            }
        });
        dialogs::show(&context, &mut self.state);
        self.archive.show(&context, &mut self.state, &self.wake);
        for action in std::mem::take(&mut self.state.actions) {
            self.act(&context, action);
        }
        // What is held is one step; what comes after is another.
        if !context.input(|input| input.pointer.any_down())
            && let Some(session) = &mut self.state.session
        {
            session.close_step();
        }
        self.follow_title(&context);
    }
}

/// Looks that the panel has tiles of.
impl App {
    /// Whether a look's tile is there.
    pub fn has_tile(&self, preset: Preset) -> bool {
        self.state.tiles.contains_key(&preset)
    }
}
