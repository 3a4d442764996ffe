//! A hospital's archive, asked by DICOMweb: which studies there are, and the images of one.

mod panel;
pub mod told;

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use eframe::egui;
use lumivox_core::Progress;
use lumivox_dicomweb::{Error, Filter, Login, SeriesEntry, Server, Studies, StudyEntry, Uid};

use crate::jobs::{Busy, Desk, Job, Wake, start};
use crate::settings::Settings;
use crate::state::{Dialog, State};
use crate::words::{Language, Word};

/// Whether archives are asked here.
pub const IS_THERE: bool = true;

/// A series that is to come.
#[derive(Clone, Debug)]
pub struct Request {
    server: Server,
    study: Uid,
    series: SeriesEntry,
    into: PathBuf,
}

/// The dialog, and what it asked for. A password is kept as long as the program runs, and nowhere.
pub struct Archive {
    /// Where images that come are kept; nowhere, where the system has no place for them.
    folder: Option<PathBuf>,
    address: String,
    name: String,
    password: String,
    filter: Filter,
    searching: Option<Job<Result<(Server, Studies), Error>>>,
    listing: Option<Job<Result<Vec<SeriesEntry>, Error>>>,
    fetching: Option<Job<Result<PathBuf, Error>>>,
    forgetting: Option<Job<Result<(), String>>>,
    /// What the archive found, and whom that was.
    found: Option<(Server, Studies)>,
    study: Option<StudyEntry>,
    series: Vec<SeriesEntry>,
    chosen: Option<Uid>,
    failed: Option<String>,
    /// Whether it was asked for once that all that came goes.
    asks_to_forget: bool,
}

impl Archive {
    /// The one that was asked last. Images are kept in a folder.
    pub fn new(folder: Option<PathBuf>, settings: &Settings) -> Self {
        if let Some(going) = folder.as_deref().map(going_folder).filter(|going| going.is_dir()) {
            // Nobody waits for it, and what fails is tried with the next start.
            std::thread::spawn(move || remove(&going));
        }
        Self {
            folder,
            address: settings.archive.clone(),
            name: settings.archive_name.clone(),
            password: String::new(),
            filter: Filter::default(),
            searching: None,
            listing: None,
            fetching: None,
            forgetting: None,
            found: None,
            study: None,
            series: vec![],
            chosen: None,
            failed: None,
            asks_to_forget: false,
        }
    }

    /// Draws the dialog where it is open, and does what it says.
    pub fn show(&mut self, context: &egui::Context, state: &mut State, wake: &Wake) {
        if state.dialog != Some(Dialog::Archive) || state.failed.is_some() || !state.settings.has_agreed {
            return;
        }
        self.hear(state, wake);
        panel::show(self, context, state, wake);
        if state.dialog != Some(Dialog::Archive) {
            // Who closes it waits for nothing any more.
            self.asks_to_forget = false;
            self.stop_asking();
        }
    }

    /// Waits for no answer any more.
    fn stop_asking(&mut self) {
        self.searching = None;
        if self.listing.take().is_some() {
            self.study = None;
        }
    }

    /// Fetches a series, in place of one that is on its way.
    pub fn fetch(&mut self, request: Request, wake: &Wake) {
        let Request { server, study, series, into } = request;
        self.fetching = Some(start("fetch a series", wake.clone(), move |desk: &Desk<_>| {
            let fetch =
                |progress: Progress<'_>| server.fetch(&study, &series, &into, progress, desk.cancel());
            desk.tell(desk.watch(fetch));
        }));
    }

    /// Where a series lies that has come, or why it does not, in a language.
    pub fn poll(&mut self, language: Language) -> Option<Result<PathBuf, String>> {
        told(&mut self.fetching).map(|told| or_why(told, language))
    }

    /// How far one is that comes.
    pub fn busy(&self) -> Option<Busy> {
        self.fetching.as_ref().map(Job::busy)
    }

    /// It is not wanted any more.
    pub fn give_up(&mut self) {
        self.fetching = None;
    }

    fn is_asking(&self) -> bool {
        self.searching.is_some() || self.listing.is_some()
    }

    /// Whether images may still come to where they are kept, or go from there.
    fn is_keeping(&self) -> bool {
        self.fetching.is_some() || self.forgetting.is_some()
    }

    /// What the archive has said.
    fn hear(&mut self, state: &State, wake: &Wake) {
        let language = state.settings.language;
        if let Some(told) = told(&mut self.searching) {
            match or_why(told, language) {
                Ok(found) => {
                    let only = match &found.1.found[..] {
                        [study] => Some(study.clone()),
                        _ => None,
                    };
                    self.found = Some(found);
                    if let Some(study) = only {
                        self.list(study, wake);
                    }
                }
                Err(why) => self.failed = Some(why),
            }
        }
        if let Some(told) = told(&mut self.listing) {
            match or_why(told, language) {
                Ok(series) => {
                    // Most images mostly are what a person wants of a study.
                    self.chosen =
                        series.iter().max_by_key(|series| series.images).map(|series| series.uid.clone());
                    self.series = series;
                }
                Err(why) => self.failed = Some(why),
            }
        }
        if let Some(told) = told(&mut self.forgetting) {
            let told = told.unwrap_or_else(|| Err(Word::Stopped.of(language).to_owned()));
            self.failed = told.err().or(self.failed.take());
        }
    }

    fn login(&self) -> Login {
        match (self.name.trim(), self.password.as_str()) {
            ("", "") => Login::Nobody,
            ("", token) => Login::Token(token.to_owned()),
            (name, password) => Login::Password { name: name.to_owned(), password: password.to_owned() },
        }
    }

    /// Asks for studies.
    fn search(&mut self, state: &mut State, wake: &Wake) {
        (self.found, self.study, self.chosen, self.failed) = (None, None, None, None);
        (self.listing, self.series) = (None, vec![]);
        let server = match Server::new(&self.address, self.login()) {
            Ok(server) => server,
            Err(error) => {
                self.failed = Some(told::words(&error, state.settings.language));
                return;
            }
        };
        let (archive, archive_name) = (server.address().to_owned(), self.name.trim().to_owned());
        let settings = Settings { archive, archive_name, ..state.settings.clone() };
        if settings != state.settings {
            state.act(crate::state::Action::Settings(settings));
        }
        let filter = self.filter.clone();
        self.searching = Some(start("ask an archive", wake.clone(), move |desk: &Desk<_>| {
            let studies = server.studies(&filter);
            desk.tell(studies.map(|studies| (server, studies)));
        }));
    }

    /// Asks for the series of a study.
    fn list(&mut self, study: StudyEntry, wake: &Wake) {
        let Some((server, _)) = &self.found else { return };
        (self.series, self.chosen, self.failed) = (vec![], None, None);
        let (server, uid) = (server.clone(), study.uid.clone());
        self.study = Some(study);
        self.listing = Some(start("ask for a study", wake.clone(), move |desk: &Desk<_>| {
            desk.tell(server.series(&uid));
        }));
    }

    /// The series that is chosen; none while what came is deleted.
    fn request(&self) -> Option<Request> {
        if self.forgetting.is_some() {
            return None;
        }
        let ((server, _), study, chosen) =
            (self.found.as_ref()?, self.study.as_ref()?, self.chosen.as_ref()?);
        let series = self.series.iter().find(|series| series.uid == *chosen)?.clone();
        // By study, as archives keep them.
        let into = self.folder.as_ref()?.join(study.uid.as_str());
        Some(Request { server: server.clone(), study: study.uid.clone(), series, into })
    }

    /// Deletes all images that came: there may be tens of thousands. A program that ends meanwhile goes on with that when it starts
    /// again.
    fn forget(&mut self, wake: &Wake) {
        let Some(folder) = self.folder.clone() else { return };
        let going = going_folder(&folder);
        self.forgetting = Some(start("delete what came", wake.clone(), move |desk: &Desk<_>| {
            let gone = remove(&going).and_then(|()| match fs::rename(&folder, &going) {
                Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
                _ => remove(&going),
            });
            desk.tell(gone.map_err(|error| format!("{}: {error}", folder.display())));
        }));
    }
}

/// What a folder is called while it is deleted.
fn going_folder(folder: &Path) -> PathBuf {
    let mut name = folder.file_name().unwrap_or_default().to_owned();
    name.push(".deleted");
    folder.with_file_name(name)
}

/// Removes a folder with all that is in it, if it is there.
fn remove(folder: &Path) -> std::io::Result<()> {
    match fs::remove_dir_all(folder) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        removed => removed,
    }
}

/// What a job has told, which is over then; one that broke has told nothing.
fn told<T>(job: &mut Option<Job<T>>) -> Option<Option<T>> {
    let running = job.as_mut()?;
    let told = running.poll().pop();
    let is_over = told.is_some() || running.is_over();
    is_over.then(|| *job = None).map(|()| told)
}

/// What was told, or why it was not: a job that broke has told nothing.
fn or_why<T>(told: Option<Result<T, Error>>, language: Language) -> Result<T, String> {
    match told {
        Some(told) => told.map_err(|error| told::words(&error, language)),
        None => Err(Word::Stopped.of(language).to_owned()),
    }
}
