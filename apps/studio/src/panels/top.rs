//! What lies above and below the views: the toolbar, the banner of the scan's geometry, the line of what goes on.

use eframe::egui::{self, Align, Color32, CornerRadius, Frame, Margin, RichText, Stroke, Ui};

use super::tools::{named, toggle_oblique};
use crate::archive;
use crate::settings::Mouse;
use crate::slices::{Plane, Projection};
use crate::state::{Action, Ask, Layout, State, Tool, ViewId};
use crate::theme::palette;
use crate::words::{self, Language, Word};

/// Opening, saving, undoing; how it is shown; help.
pub fn toolbar(ui: &mut Ui, state: &mut State) {
    let p = palette(state.settings.is_dark);
    ui.horizontal_centered(|ui| {
        ui.label(RichText::new("Lumivox").size(18.0).strong().color(p.text));
        ui.label(RichText::new("Studio").size(18.0).color(p.accent));
        ui.add_space(14.0);
        button(ui, state, Word::OpenFiles, "Ctrl+O", true, Action::Ask(Ask::Files));
        button(ui, state, Word::OpenFolder, "Ctrl+Shift+O", true, Action::Ask(Ask::Folder));
        if archive::IS_THERE {
            button(ui, state, Word::Archive, "Ctrl+Shift+A", true, Action::ArchiveDialog);
        }
        let file = state.session.as_ref().map(|session| session.file_name("lumivox"));
        let is_open = file.is_some();
        button(
            ui,
            state,
            Word::SaveScene,
            "Ctrl+S",
            is_open,
            Action::Ask(Ask::SaveScene(file.unwrap_or_default())),
        );
        let has_picture = state.session.as_ref().is_some_and(|session| !session.is_coming());
        button(ui, state, Word::Export, "Ctrl+E", has_picture, Action::ExportDialog);
        button(ui, state, Word::Share, "Ctrl+Shift+E", has_picture, Action::ShareDialog);
        ui.add_space(10.0);
        let [undo, redo] = state.session.as_ref().map_or([None, None], |session| session.history().next());
        for (word, step, keys, action) in
            [(Word::Undo, undo, "Ctrl+Z", Action::Undo), (Word::Redo, redo, "Ctrl+Y", Action::Redo)]
        {
            let hint = step.map_or(keys.to_owned(), |step| format!("{} ({keys})", state.say(step)));
            let shown = egui::Button::new(state.say(word)).frame_when_inactive(false);
            if ui.add_enabled(step.is_some(), shown).on_hover_text(hint).clicked() {
                state.act(action);
            }
        }
        ui.with_layout(egui::Layout::right_to_left(Align::Center), |ui| {
            button(ui, state, Word::About, "F1", true, Action::About);
            preferences(ui, state);
        });
    });
}

fn button(ui: &mut Ui, state: &mut State, word: Word, keys: &str, enabled: bool, action: Action) {
    if ui.add_enabled(enabled, egui::Button::new(state.say(word))).on_hover_text(keys).clicked() {
        state.act(action);
    }
}

fn preferences(ui: &mut Ui, state: &mut State) {
    let mut settings = state.settings.clone();
    let (word, other) = if settings.is_dark { (Word::LightTheme, false) } else { (Word::DarkTheme, true) };
    if ui.add(egui::Button::new(state.say(word)).frame_when_inactive(false)).clicked() {
        settings.is_dark = other;
    }
    let own = Language::ALL.iter().find(|(language, _)| *language == settings.language);
    ui.menu_button(own.map_or("", |(_, name)| name), |ui| {
        for (language, name) in Language::ALL {
            if ui.selectable_label(settings.language == language, name).clicked() {
                settings.language = language;
                ui.close();
            }
        }
        ui.separator();
        ui.label(RichText::new(state.say(Word::Profile)).small());
        for mouse in Mouse::ALL {
            if ui.selectable_label(settings.mouse == mouse, mouse.profile().name).clicked() {
                settings.mouse = mouse;
                ui.close();
            }
        }
    });
    if settings != state.settings {
        state.act(Action::Settings(settings));
    }
}

/// Sentences of the banner that are seen without asking.
const SENTENCES: usize = 3;

/// What is not as it should be with the scan: never silent.
pub fn banner(ui: &mut Ui, state: &mut State) {
    let told = told(state);
    if told.is_empty() {
        return;
    }
    let p = palette(state.settings.is_dark);
    let frame = Frame::new()
        .fill(p.warning_ground)
        .inner_margin(Margin::symmetric(14, 8))
        .stroke(Stroke::new(1.0, p.warning.gamma_multiply(0.35)));
    frame.show(ui, |ui| {
        ui.set_width(ui.available_width());
        let shown = if state.shows_all_notes { told.len() } else { SENTENCES };
        for (place, sentence) in told.iter().take(shown).enumerate() {
            ui.horizontal(|ui| {
                ui.label(RichText::new("\u{26a0}").color(if place == 0 {
                    p.warning
                } else {
                    Color32::TRANSPARENT
                }));
                ui.add(egui::Label::new(RichText::new(sentence).color(p.warning)).wrap());
                if place == 0 && told.len() > SENTENCES {
                    let word = if state.shows_all_notes { Word::ShowLess } else { Word::ShowAll };
                    let text = format!("{} ({})", state.say(word), told.len());
                    if ui.add(egui::Button::new(text).small()).clicked() {
                        state.shows_all_notes = !state.shows_all_notes;
                    }
                }
            });
        }
    });
}

/// What the importer says of the scan, and how many files were left out.
pub fn told(state: &State) -> Vec<String> {
    let Some(session) = &state.session else { return vec![] };
    let mut told = session.report.notes.clone();
    // That it is another scan than it was concerns the scan itself, too.
    told.extend(session.notes.iter().filter(|note| note.contains(lumivox_scene::ANOTHER_SCAN)).cloned());
    let reasons = session.report.skipped_by_reason();
    if !reasons.is_empty() {
        let why: Vec<String> = reasons.iter().map(|(why, files)| format!("{files}: {why}")).collect();
        let files = session.report.skipped.len();
        told.push(format!("{}: {files} ({})", state.say(Word::SkippedFiles), why.join("; ")));
    }
    told
}

/// What lies under the pointer, what goes on, how far the picture is.
pub fn status(ui: &mut Ui, state: &mut State, gpu: &str) {
    let p = palette(state.settings.is_dark);
    let small = |text: String| RichText::new(text).small().color(p.weak);
    ui.horizontal_centered(|ui| {
        if let Some((word, busy)) = state.busy {
            ui.spinner();
            let stage = busy.stage.map_or(String::new(), |stage| {
                format!(": {}", words::stage(stage).map_or(stage.label(), |word| state.say(word)))
            });
            ui.label(RichText::new(format!("{}{stage}", state.say(word))).small().color(p.text));
            if let Some(part) = busy.part() {
                let bar = egui::ProgressBar::new(part)
                    .desired_width(160.0)
                    .desired_height(6.0)
                    .fill(p.accent)
                    .corner_radius(CornerRadius::same(3));
                ui.add(bar);
            }
            if ui.add(egui::Button::new(state.say(Word::Cancel)).small()).clicked() {
                state.act(Action::Cancel);
            }
        } else if let Some(done) = &state.done {
            ui.label(RichText::new(done).small().color(p.accent));
        }
        if let Some(probe) = state.probe {
            let unit = state.session.as_ref().map_or("", |session| session.scan().unit());
            let unit = if unit.is_empty() { state.say(Word::NoUnit) } else { unit };
            let structure = state.overlay.as_ref().and_then(|(_, overlay)| {
                overlay.named(overlay.value_at(probe.patient_mm)?).map(|(name, _)| format!("      {name}"))
            });
            ui.label(small(probe_words(&probe, unit) + structure.as_deref().unwrap_or_default()));
        }
        ui.with_layout(egui::Layout::right_to_left(Align::Center), |ui| {
            ui.label(small(state.say(Word::NoDevice).to_owned()));
            if state.session.is_some() {
                ui.separator();
                ui.label(small(format!("{} {}", state.progress.samples, state.say(Word::Samples))));
                ui.separator();
                ui.label(small(gpu.to_owned()));
            }
        });
    });
}

/// `L 12.3  P 4.0  H 20.1 mm   1034 HU`: where it is by the patient's own directions, and its value.
pub fn probe_words(probe: &crate::state::Probe, unit: &str) -> String {
    let directions = [["R", "L"], ["A", "P"], ["F", "H"]];
    let [x, y, z] = [0, 1, 2].map(|axis| {
        let mm = probe.patient_mm[axis];
        format!("{} {:.1}", directions[axis][usize::from(mm >= 0.0)], mm.abs())
    });
    format!(
        "{x}   {y}   {z} mm      {} {unit}",
        lumivox_core::words::number((probe.value * 10.0).round() / 10.0)
    )
}

/// Keys that are for everything; those of a view are in [`views`](super::views).
pub fn keys(context: &egui::Context, state: &mut State) {
    use egui::{Key, Modifiers};
    if context.text_edit_focused() || state.dialog.is_some() || !state.settings.has_agreed {
        return;
    }
    let is_open = state.session.is_some();
    let pressed =
        |modifiers: Modifiers, key: Key| context.input_mut(|input| input.consume_key(modifiers, key));
    let shift = Modifiers::COMMAND | Modifiers::SHIFT;
    let mut actions = vec![];
    // The one with more keys first: a shortcut takes those with fewer, too.
    if pressed(shift, Key::O) {
        actions.push(Action::Ask(Ask::Folder));
    }
    if archive::IS_THERE && pressed(shift, Key::A) {
        actions.push(Action::ArchiveDialog);
    }
    if pressed(Modifiers::COMMAND, Key::O) {
        actions.push(Action::Ask(Ask::Files));
    }
    if pressed(Modifiers::NONE, Key::F1) {
        actions.push(Action::About);
    }
    if is_open {
        // Systems have a key of their own for it.
        if context.input(|input| input.events.contains(&egui::Event::Copy)) {
            actions.push(Action::Copy);
        }
        if pressed(shift, Key::Z) || pressed(Modifiers::COMMAND, Key::Y) {
            actions.push(Action::Redo);
        }
        if pressed(Modifiers::COMMAND, Key::Z) {
            actions.push(Action::Undo);
        }
        if pressed(Modifiers::COMMAND, Key::S) {
            let name = state.session.as_ref().map(|session| session.file_name("lumivox"));
            actions.push(Action::Ask(Ask::SaveScene(name.unwrap_or_default())));
        }
        if pressed(shift, Key::E) {
            actions.push(Action::ShareDialog);
        }
        if pressed(Modifiers::COMMAND, Key::E) {
            actions.push(Action::ExportDialog);
        }
        let numbers = [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5];
        for (key, view) in numbers.into_iter().zip(ViewId::ALL) {
            if pressed(Modifiers::NONE, key) {
                if view == ViewId::Slice(Plane::Oblique) && !state.shows_oblique {
                    toggle_oblique(state);
                }
                state.active = view;
            }
        }
        for tool in Tool::ALL {
            if pressed(Modifiers::NONE, named(tool).1) {
                state.take(tool);
            }
        }
        if pressed(Modifiers::NONE, Key::Escape) {
            // First what is being made, then the tool.
            let is_made = state.draft.is_some() || state.lasso.is_some();
            let tool = if is_made { state.tool } else { Tool::Navigate };
            state.take(tool);
        }
        if pressed(Modifiers::NONE, Key::O) {
            toggle_oblique(state);
        }
        if pressed(Modifiers::NONE, Key::S) {
            let place = Projection::ALL.iter().position(|own| *own == state.slab.projection);
            state.slab.projection = Projection::ALL[(place.unwrap_or(0) + 1) % Projection::ALL.len()];
        }
        if pressed(Modifiers::NONE, Key::Delete) {
            state.change(Word::Delete, |document| {
                document.measurements.pop();
            });
        }
        if pressed(Modifiers::NONE, Key::G) {
            state.layout = Layout::Grid;
        }
        if pressed(Modifiers::NONE, Key::M) {
            state.layout = Layout::Main;
        }
        // With a focus, the space bar presses what has it.
        let is_free = context.memory(|memory| memory.focused().is_none());
        if is_free && pressed(Modifiers::NONE, Key::Space) {
            state.toggle_one(state.active);
        }
    }
    actions.into_iter().for_each(|action| state.act(action));
}
