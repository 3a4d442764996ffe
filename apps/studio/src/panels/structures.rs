//! Structures of the scan: found in it, or opened; each with an eye, a colour, a look and how large it is.

use std::path::PathBuf;

use eframe::egui::{self, Align, Button, Label, RichText, Ui, vec2};
use lumivox_core::document::{Color, Labels, SceneDocument, Style};
use lumivox_core::{Label as Structure, Labelling, Preset, TransferFunction, UNLABELLED};

use super::look::entry;
use crate::settings::Settings;
use crate::state::{Action, Ask, State};
use crate::theme::palette;
use crate::words::{self, Word};

/// The list, and where structures come from.
pub fn show(ui: &mut Ui, state: &mut State) {
    let p = palette(state.settings.is_dark);
    let labelling =
        state.session.as_ref().and_then(|session| session.scene().0.volumes.first()?.labels.clone());
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(4.0, 4.0);
        if ui
            .button(state.say(Word::StructuresFind))
            .on_hover_text(state.say(Word::StructuresFindHint))
            .clicked()
        {
            put(state, Word::StructuresFind, vec![], vec![]);
        }
        if ui.button(state.say(Word::StructuresOpen)).on_hover_text(state.say(Word::StructuresHint)).clicked()
        {
            state.act(Action::Ask(Ask::Labels));
        }
        if ui.button(state.say(Word::StructuresFolder)).clicked() {
            state.act(Action::Ask(Ask::LabelFolder));
        }
    });
    let Some(labelling) = labelling.filter(|_| entry(state).is_some_and(|entry| entry.labels.is_some()))
    else {
        ui.add(Label::new(RichText::new(state.say(Word::StructuresHint)).small().color(p.weak)).wrap());
        return;
    };
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(4.0, 4.0);
        for (word, is_visible) in [(Word::StructuresAll, true), (Word::StructuresNone, false)] {
            if ui.add(Button::new(state.say(word)).small()).clicked() {
                let own = labelling.labels.own_labels();
                let all: Vec<String> = own.map(|label| labelling.labels.word_of(label.value)).collect();
                state.change(word, |document| {
                    all.iter()
                        .for_each(|label| change(document, label, |style| style.visible = Some(is_visible)));
                });
            }
        }
        if ui.add(Button::new(state.say(Word::StructuresRemove)).small()).clicked() {
            state.change(Word::StructuresRemove, |document| {
                document.volumes.iter_mut().take(1).for_each(|entry| entry.labels = None);
            });
        }
    });
    rest(ui, state, &labelling);
    let mut shows_names = state.settings.shows_names;
    if ui.checkbox(&mut shows_names, state.say(Word::StructureNames)).changed() {
        state.act(Action::Settings(Settings { shows_names, ..state.settings.clone() }));
    }
    for label in labelling.labels.own_labels() {
        row(ui, state, &labelling, label);
    }
}

/// Structures of these files, each in its own colour: somebody drew them to be told apart.
pub fn open(state: &mut State, files: Vec<PathBuf>) {
    let own = Style { label: "*".into(), color: Some(Color::Own(true)), ..Style::default() };
    put(state, Word::StructuresOpen, files, vec![own]);
}

/// Structures of these files, or those that are found where there are none.
fn put(state: &mut State, what: Word, files: Vec<PathBuf>, styles: Vec<Style>) {
    state.change(what, |document| {
        if let Some(entry) = document.volumes.first_mut() {
            entry.labels = Some(Labels { files, styles, ..Labels::default() });
        }
    });
}

/// Changes what is said of a label.
fn change(document: &mut SceneDocument, label: &str, change: impl FnOnce(&mut Style)) {
    let Some(labels) = document.volumes.first_mut().and_then(|entry| entry.labels.as_mut()) else { return };
    let place = labels.styles.iter().rposition(|style| style.label == label).unwrap_or_else(|| {
        labels.styles.push(Style { label: label.to_owned(), ..Style::default() });
        labels.styles.len() - 1
    });
    change(&mut labels.styles[place]);
}

/// What has no label.
fn rest(ui: &mut Ui, state: &mut State, labelling: &Labelling) {
    let mut is_visible = labelling.style(UNLABELLED).visible;
    if ui.checkbox(&mut is_visible, state.say(Word::StructuresRest)).changed() {
        state.change(Word::StructuresRest, |document| {
            change(document, "unlabelled", |style| style.visible = Some(is_visible));
        });
    }
}

fn row(ui: &mut Ui, state: &mut State, labelling: &Labelling, label: &Structure) {
    let p = palette(state.settings.is_dark);
    let ml = state.sizes.as_ref().map_or(0.0, |sizes| sizes.millilitres(label.value));
    if ml == 0.0 {
        // Looked for, and not there.
        return;
    }
    let style = labelling.style(label.value);
    let word = labelling.labels.word_of(label.value);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 5.0;
        ui.spacing_mut().interact_size = vec2(26.0, 22.0);
        let mut color = style.color.unwrap_or(label.color).map(|c| c as f32);
        if ui.color_edit_button_rgb(&mut color).changed() {
            let color = color.map(|c| f64::from(c.clamp(0.0, 1.0)));
            state.change(Word::StructureColor, |document| {
                change(document, &word, |style| style.color = Some(Color::Rgb(color)));
            });
        }
        let mut is_visible = style.visible;
        let room = (ui.available_width() - 128.0).max(60.0);
        let left = egui::Layout::left_to_right(Align::Center);
        let toggled = ui.allocate_ui_with_layout(vec2(room, 22.0), left, |ui| {
            ui.set_min_width(room);
            ui.style_mut().wrap_mode = Some(egui::TextWrapMode::Truncate);
            ui.checkbox(&mut is_visible, &label.name).changed()
        });
        if toggled.inner {
            state.change(Word::StructureEye, |document| {
                change(document, &word, |style| style.visible = Some(is_visible));
            });
        }
        ui.with_layout(egui::Layout::right_to_left(Align::Center), |ui| {
            look(ui, state, &word, &label.name);
            let decimals = if ml < 10.0 { 1 } else { 0 };
            ui.label(RichText::new(format!("{ml:.decimals$} ml")).size(12.0).color(p.weak));
        });
    });
}

/// A menu for one structure: whether cuts spare it; and its look, as the scan has it, solid whatever its values are, or one of the
/// scan's looks.
fn look(ui: &mut Ui, state: &mut State, word: &str, name: &str) {
    let own = entry(state).and_then(|entry| {
        let styles = &entry.labels.as_ref()?.styles;
        styles.iter().rfind(|style| style.label == word).cloned()
    });
    let mut is_spared = own.as_ref().is_some_and(|style| style.clipped == Some(false));
    let (preset, is_solid) =
        own.map_or((None, false), |style| (style.preset, style.transfer_function.is_some()));
    let menu = ui.menu_button(RichText::new("\u{2026}").size(15.0), |ui| {
        if ui.checkbox(&mut is_spared, state.say(Word::StructureSpared)).changed() {
            state.change(Word::StructureSpared, |document| {
                change(document, word, |style| style.clipped = Some(!is_spared));
            });
            ui.close();
        }
        ui.separator();
        let mut chosen = None;
        if ui.selectable_label(preset.is_none() && !is_solid, state.say(Word::StructureAsScan)).clicked() {
            chosen = Some((None, None));
        }
        if ui.selectable_label(is_solid, state.say(Word::StructureSolid)).clicked() {
            chosen = Some((None, Some(TransferFunction::constant(1.0, [1.0; 3]))));
        }
        ui.separator();
        for look in state.looks.clone() {
            let name = words::look(look).map_or(look.name(), |word| state.say(word));
            if ui.selectable_label(preset == Some(look), name).clicked() {
                chosen = Some((Some(look), None));
            }
        }
        if let Some((preset, function)) = chosen {
            dress(state, word, preset, function);
            ui.close();
        }
    });
    let said = format!("{}: {name}", state.say(Word::StructureLook));
    menu.response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, true, &said));
    menu.response.on_hover_text(state.say(Word::StructureLook));
}

fn dress(state: &mut State, word: &str, preset: Option<Preset>, function: Option<TransferFunction>) {
    state.change(Word::StructureLook, |document| {
        change(document, word, |style| (style.preset, style.transfer_function) = (preset, function));
    });
}
