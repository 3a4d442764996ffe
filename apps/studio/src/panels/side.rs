//! The panel at the right: what a person changes, by what it is about, and what the camera frames.

use eframe::egui::{self, Ui};
use lumivox_core::glam::DVec3;

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
    // Of the patient (LPS).
    const SIDES: [(Word, DVec3); 5] = [
        (Word::Front, DVec3::NEG_Y),
        (Word::Left, DVec3::X),
        (Word::Right, DVec3::NEG_X),
        (Word::Back, DVec3::Y),
        (Word::Above, DVec3::Z),
    ];
    ui.horizontal_wrapped(|ui| {
        for (word, side) in SIDES {
            let angles = state.session.as_ref().map(|session| session.angles_of(side).map(f64::to_degrees));
            if let (true, Some([azimuth, elevation])) = (ui.button(state.say(word)).clicked(), angles) {
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
