//! The dialog: where the archive is, what is looked for, what there is.

use eframe::egui::{
    self, Align2, Color32, FontId, Key, Rect, Response, RichText, ScrollArea, Sense, TextEdit, Ui,
    WidgetInfo, WidgetType, vec2,
};
use lumivox_dicomweb::{Login, SeriesEntry, Server, StudyEntry};

use super::Archive;
use crate::jobs::Wake;
use crate::panels::dialogs::{buttons, heading, modal};
use crate::state::{Action, State};
use crate::theme::{Palette, palette, primary};
use crate::words::Word;

const WIDTH: f32 = 760.0;
const EXAMPLE: &str = "https://archive.example.org/dicom-web";
/// Where the columns of studies begin, as parts of the width: day, patient, identifier, modalities, description, images.
const STUDY: [f32; 6] = [0.0, 0.13, 0.36, 0.55, 0.66, 0.92];
/// And those of series: number, modality, description, images.
const SERIES: [f32; 4] = [0.0, 0.08, 0.2, 0.92];

/// Draws it.
pub fn show(archive: &mut Archive, context: &egui::Context, state: &mut State, wake: &Wake) {
    let p = palette(state.settings.is_dark);
    let (asked, leaves) = modal(context, state, WIDTH, |ui| {
        heading(ui, state.say(Word::ArchiveTitle));
        let searches = questions(ui, archive, state, &p);
        ui.add_space(8.0);
        let opens = answers(ui, archive, state, &p, wake);
        ui.add_space(6.0);
        kept(ui, archive, state, &p, wake);
        let (opened, closed) = buttons(ui, |ui| {
            let is_chosen = archive.request().is_some();
            let opened = ui.add_enabled(is_chosen, primary(&p, state.say(Word::ArchiveOpen))).clicked();
            (opened, ui.button(state.say(Word::Close)).clicked())
        });
        (searches, opens || opened, closed)
    });
    let (searches, opens, closes) = asked;
    if searches {
        archive.search(state, wake);
    }
    if opens && let Some(request) = archive.request() {
        state.dialog = None;
        state.act(Action::Fetch(Box::new(request)));
    } else if closes || leaves {
        state.dialog = None;
    }
}

/// Whom to ask, and what for. Whether that is to be done now.
fn questions(ui: &mut Ui, archive: &mut Archive, state: &State, p: &Palette) -> bool {
    let mut enters = false;
    let mut field = |ui: &mut Ui, word: Word, text: &mut String, width: f32, hint: &str, is_secret: bool| {
        ui.vertical(|ui| {
            let label = ui.label(RichText::new(state.say(word)).small().color(p.weak));
            let edit = TextEdit::singleline(text).desired_width(width).hint_text(hint).password(is_secret);
            let shown = ui.add(edit.margin(vec2(8.0, 6.0))).labelled_by(label.id);
            enters |= shown.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
        });
    };
    ui.horizontal(|ui| {
        field(ui, Word::ArchiveAddress, &mut archive.address, 424.0, EXAMPLE, false);
        field(ui, Word::ArchiveName, &mut archive.name, 150.0, "", false);
        field(ui, Word::ArchivePassword, &mut archive.password, 150.0, "", true);
    });
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        field(ui, Word::ArchivePatient, &mut archive.filter.patient, 196.0, "", false);
        field(ui, Word::ArchivePatientId, &mut archive.filter.patient_id, 120.0, "", false);
        field(ui, Word::ArchiveDays, &mut archive.filter.days, 196.0, "2026-01-01 - 2026-01-31", false);
        field(ui, Word::ArchiveModality, &mut archive.filter.modality, 72.0, "CT", false);
    });
    let mut searches = enters;
    ui.add_space(8.0);
    ui.horizontal(|ui| {
        searches |= ui
            .add_enabled(
                !archive.address.trim().is_empty(),
                egui::Button::new(state.say(Word::ArchiveSearch)),
            )
            .clicked();
        if archive.is_asking() {
            ui.spinner();
            if ui.add(egui::Button::new(state.say(Word::ArchiveStop)).small()).clicked() {
                archive.stop_asking();
            }
        }
        let is_open =
            Server::new(&archive.address, Login::Nobody).is_ok_and(|server| server.is_open_to_readers());
        let (word, color) =
            if is_open { (Word::ArchiveReadable, p.warning) } else { (Word::ArchivePrivacy, p.weak) };
        ui.add(egui::Label::new(RichText::new(state.say(word)).small().color(color)).wrap());
    });
    searches && !archive.address.trim().is_empty()
}

/// What the archive said. Whether a series is to be opened now.
fn answers(ui: &mut Ui, archive: &mut Archive, state: &State, p: &Palette, wake: &Wake) -> bool {
    let (mut opens, mut lists) = (false, None);
    if let Some(why) = &archive.failed {
        ui.add(egui::Label::new(RichText::new(why).color(p.warning)).wrap().selectable(true));
    }
    let Some((_, studies)) = &archive.found else {
        // The dialog does not jump when answers come.
        ui.add_space(300.0);
        return false;
    };
    let list = |name: &'static str, height: f32| {
        ScrollArea::vertical().id_salt(name).max_height(height).min_scrolled_height(height).auto_shrink(false)
    };
    let words = match () {
        () if studies.found.is_empty() => Word::ArchiveNone,
        () if studies.has_more => Word::ArchiveMore,
        () => Word::ArchiveStudies,
    };
    ui.label(RichText::new(state.say(words)).strong());
    let heads = [
        Word::ArchiveDay,
        Word::ArchivePatient,
        Word::ArchivePatientId,
        Word::ArchiveModality,
        Word::ArchiveDescription,
        Word::ArchiveImages,
    ];
    head(ui, p, &STUDY, &heads.map(|word| state.say(word)));
    list("studies", 150.0).show(ui, |ui| {
        for study in &studies.found {
            let is_chosen = archive.study.as_ref().is_some_and(|chosen| chosen.uid == study.uid);
            if row(ui, p, is_chosen, &STUDY, &study_cells(study)).clicked() {
                lists = Some(study.clone());
            }
        }
    });
    if archive.study.is_some() {
        ui.label(RichText::new(state.say(Word::Series)).strong());
        let heads = [Word::ArchiveModality, Word::ArchiveDescription, Word::ArchiveImages];
        let [modality, description, images] = heads.map(|word| state.say(word));
        head(ui, p, &SERIES, &["", modality, description, images]);
    }
    list("series", 110.0).show(ui, |ui| {
        for series in &archive.series {
            let shown =
                row(ui, p, archive.chosen.as_ref() == Some(&series.uid), &SERIES, &series_cells(series));
            if shown.clicked() {
                archive.chosen = Some(series.uid.clone());
            }
            opens |= shown.double_clicked();
        }
    });
    if let Some(study) = lists {
        archive.list(study, wake);
    }
    opens
}

fn study_cells(study: &StudyEntry) -> [String; 6] {
    [
        study.day.clone(),
        study.patient.clone(),
        study.patient_id.clone(),
        study.modalities.join(" "),
        study.description.clone(),
        study.images.map_or(String::new(), |images| images.to_string()),
    ]
}

fn series_cells(series: &SeriesEntry) -> [String; 4] {
    let count = |count: Option<u64>| count.map_or(String::new(), |count| count.to_string());
    [count(series.number), series.modality.clone(), series.description.clone(), count(series.images)]
}

/// What columns are of.
fn head(ui: &mut Ui, p: &Palette, columns: &[f32], words: &[&str]) {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 18.0), Sense::hover());
    write(ui, rect, columns, words, (FontId::proportional(12.0), p.weak));
}

/// A line of a table that can be chosen. What is too long ends where the next column begins.
fn row(ui: &mut Ui, p: &Palette, is_chosen: bool, columns: &[f32], cells: &[String]) -> Response {
    let (rect, shown) = ui.allocate_exact_size(vec2(ui.available_width(), 26.0), Sense::click());
    let told = cells.join("   ");
    shown.widget_info(|| WidgetInfo::selected(WidgetType::SelectableLabel, true, is_chosen, &told));
    if ui.is_rect_visible(rect) {
        let fill = match () {
            () if is_chosen => p.accent.gamma_multiply(0.25),
            () if shown.hovered() || shown.has_focus() => p.line.gamma_multiply(0.6),
            () => Color32::TRANSPARENT,
        };
        ui.painter().rect_filled(rect, 4.0, fill);
        write(ui, rect, columns, cells, (FontId::proportional(13.5), p.text));
    }
    shown
}

/// Writes cells where their columns begin.
fn write(ui: &Ui, rect: Rect, columns: &[f32], cells: &[impl AsRef<str>], (font, color): (FontId, Color32)) {
    for (place, cell) in cells.iter().enumerate() {
        let at =
            |place: usize| rect.left() + 6.0 + columns.get(place).unwrap_or(&1.0) * (rect.width() - 12.0);
        let room = Rect::from_x_y_ranges(at(place)..=at(place + 1) - 8.0, rect.y_range());
        let text = ui.painter().with_clip_rect(room.intersect(ui.clip_rect()));
        text.text(room.left_center(), Align2::LEFT_CENTER, cell.as_ref(), font.clone(), color);
    }
}

/// Where images lie that came, and how they go.
fn kept(ui: &mut Ui, archive: &mut Archive, state: &State, p: &Palette, wake: &Wake) {
    let Some(folder) = archive.folder.clone() else {
        ui.label(RichText::new(state.say(Word::ArchiveNoFolder)).color(p.warning));
        return;
    };
    // They may all be on their way.
    let can_go = folder.is_dir() && !archive.is_keeping();
    ui.horizontal(|ui| {
        if archive.asks_to_forget && can_go {
            // Not where the hand is already.
            if ui.add(egui::Button::new(state.say(Word::Cancel)).small()).clicked() {
                archive.asks_to_forget = false;
            }
            ui.label(RichText::new(state.say(Word::ArchiveForgetWhy)).small().color(p.warning));
            if ui.add(egui::Button::new(state.say(Word::ArchiveForgetAll)).small()).clicked() {
                archive.forget(wake);
                archive.asks_to_forget = false;
            }
            return;
        }
        if can_go && ui.add(egui::Button::new(state.say(Word::ArchiveForget)).small()).clicked() {
            archive.asks_to_forget = true;
        }
        if archive.forgetting.is_some() {
            ui.spinner();
        }
        let text = format!("{} {}", state.say(Word::ArchiveKept), folder.display());
        ui.add(egui::Label::new(RichText::new(text).small().color(p.weak)).truncate());
    });
}
