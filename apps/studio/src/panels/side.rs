//! The panel at the right: what a person changes, by what it is about, and what the camera frames.

use eframe::egui::{self, Ui};

use super::{cut, look, measure, structures};
use crate::session::Session;
use crate::state::{Action, State, Tab};
use crate::words::Word;

/// The whole panel.
pub fn show(ui: &mut Ui, state: &mut State) {
    egui::Panel::bottom("camera").frame(egui::Frame::new()).show_separator_line(true).show(ui, |ui| {
        ui.add_space(6.0);
        camera(ui, state);
    });
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        ui.spacing_mut().button_padding.x = 7.0;
        for tab in Tab::ALL {
            let name = egui::RichText::new(state.say(word(tab))).size(13.0);
            if ui.selectable_label(state.tab == tab, name).clicked() {
                state.tab = tab;
            }
        }
    });
    ui.add_space(4.0);
    egui::ScrollArea::vertical().id_salt(state.tab).auto_shrink(false).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 6.0;
        match state.tab {
            Tab::Look => look::show(ui, state),
            Tab::Cut => cut::show(ui, state),
            Tab::Structures => structures::show(ui, state),
            Tab::Measure => measure::list(ui, state),
        }
    });
}

fn word(tab: Tab) -> Word {
    match tab {
        Tab::Look => Word::Looks,
        Tab::Cut => Word::Cut,
        Tab::Structures => Word::Structures,
        Tab::Measure => Word::Measure,
    }
}

fn camera(ui: &mut Ui, state: &mut State) {
    const SIDES: [(Word, [f64; 2]); 5] = [
        (Word::Front, [0.0, 0.0]),
        (Word::Left, [90.0, 0.0]),
        (Word::Right, [-90.0, 0.0]),
        (Word::Back, [180.0, 0.0]),
        (Word::Above, [0.0, 89.0]),
    ];
    ui.horizontal_wrapped(|ui| {
        for (word, [azimuth, elevation]) in SIDES {
            if ui.button(state.say(word)).clicked() {
                state.act(Action::Frame(azimuth, elevation));
            }
        }
        let orbit = state.session.as_ref().map(Session::orbit);
        if let (true, Some(orbit)) =
            (ui.button(state.say(Word::FrameAll)).on_hover_text("R").clicked(), orbit)
        {
            state.act(Action::Frame(orbit.azimuth.to_degrees(), orbit.elevation.to_degrees()));
        }
    });
}
