//! The line above the views: what the left button does, the window, how thick slices are, the oblique plane, the layout.

use eframe::egui::{self, DragValue, Frame, Margin, RichText, Ui};
use lumivox_core::document::MeasurementKind;

use super::slice::projection_word;
use crate::slices::{Projection, window_between};
use crate::state::{Layout, State, Tool, ViewId};
use crate::theme::palette;
use crate::words::Word;

/// Of a tool: its name and its key.
pub fn named(tool: Tool) -> (Word, egui::Key) {
    match tool {
        Tool::Navigate => (Word::Navigate, egui::Key::V),
        Tool::Measure(MeasurementKind::Distance) => (Word::Distance, egui::Key::D),
        Tool::Measure(MeasurementKind::Angle) => (Word::Angle, egui::Key::A),
        Tool::Measure(MeasurementKind::Region) => (Word::Region, egui::Key::E),
        Tool::Shape => (Word::Shape, egui::Key::W),
        Tool::Lasso => (Word::Lasso, egui::Key::L),
    }
}

/// The whole line.
pub fn show(ui: &mut Ui, state: &mut State) {
    let p = palette(state.settings.is_dark);
    Frame::new().fill(p.panel).inner_margin(Margin::symmetric(8, 3)).show(ui, |ui| {
        ui.set_width(ui.available_width());
        // All of it in one line of a usual window.
        ui.style_mut().text_styles.insert(egui::TextStyle::Button, egui::FontId::proportional(13.0));
        ui.spacing_mut().button_padding = egui::vec2(5.5, 3.0);
        ui.spacing_mut().item_spacing = egui::vec2(2.5, 4.0);
        ui.spacing_mut().interact_size.y = 24.0;
        ui.horizontal_wrapped(|ui| {
            for tool in Tool::ALL {
                let (word, key) = named(tool);
                let label = ui.selectable_label(state.tool == tool, state.say(word));
                if label.on_hover_text(format!("{} ({})", state.say(hint(tool)), key.name())).clicked() {
                    state.take(tool);
                }
            }
            ui.separator();
            window(ui, state);
            slab(ui, state);
            let oblique = ui.selectable_label(state.shows_oblique, state.say(Word::Oblique));
            if oblique.on_hover_text(format!("{} (O)", state.say(Word::ObliqueHint))).clicked() {
                toggle_oblique(state);
            }
            ui.separator();
            layouts(ui, state);
        });
    });
}

/// How views share the room.
fn layouts(ui: &mut Ui, state: &mut State) {
    for (layout, word) in [(Layout::Main, Word::LayoutMain), (Layout::Grid, Word::LayoutGrid)] {
        if ui.selectable_label(state.layout == layout, state.say(word)).clicked() {
            state.layout = layout;
        }
    }
}

fn hint(tool: Tool) -> Word {
    match tool {
        Tool::Navigate => Word::NavigateHint,
        Tool::Measure(MeasurementKind::Distance) => Word::DistanceHint,
        Tool::Measure(MeasurementKind::Angle) => Word::AngleHint,
        Tool::Measure(MeasurementKind::Region) => Word::RegionHint,
        Tool::Shape => Word::ShapeHint,
        Tool::Lasso => Word::LassoHint,
    }
}

/// Shows the oblique plane, or takes it away.
pub fn toggle_oblique(state: &mut State) {
    use crate::slices::Plane;
    state.shows_oblique = !state.shows_oblique;
    let oblique = ViewId::Slice(Plane::Oblique);
    if state.shows_oblique && state.layout == Layout::Main {
        // Four slices beside each other are small.
        state.layout = Layout::Grid;
    }
    if !state.shows_oblique && state.active == oblique {
        state.active = ViewId::ThreeD;
        if state.layout == Layout::One {
            state.layout = state.layout_before;
        }
    }
}

/// Windows that radiologists know by name; of what has no Hounsfield units, by the share of its values.
fn window(ui: &mut Ui, state: &mut State) {
    const KNOWN: [(Word, [f64; 2]); 5] = [
        (Word::WindowSoft, [40.0, 400.0]),
        (Word::WindowLung, [-600.0, 1500.0]),
        (Word::WindowBone, [400.0, 1800.0]),
        (Word::WindowBrain, [40.0, 80.0]),
        (Word::WindowVessels, [300.0, 600.0]),
    ];
    const SHARES: [(Word, [f64; 2]); 3] = [
        (Word::WindowUsual, [0.01, 0.995]),
        (Word::WindowContrast, [0.10, 0.95]),
        (Word::WindowWhole, [0.0, 1.0]),
    ];
    let Some(scan) = state.session.as_ref().map(|session| session.scan().clone()) else { return };
    ui.menu_button(state.say(Word::Window), |ui| {
        if scan.is_hounsfield() {
            for (word, window) in KNOWN {
                if ui.selectable_label(state.window == window, state.say(word)).clicked() {
                    state.window = window;
                    ui.close();
                }
            }
        } else {
            for (word, shares) in SHARES {
                if ui.selectable_label(false, state.say(word)).clicked() {
                    state.window = window_between(&scan, shares);
                    ui.close();
                }
            }
        }
        ui.separator();
        let [low, high] = scan.value_range();
        let speed = (high - low) / 2000.0;
        let reach = (high - low).max(f64::from(f32::MIN_POSITIVE));
        for (place, word, range) in [
            (0, Word::WindowLevel, low - reach..=high + reach),
            (1, Word::WindowWidth, 1e-4 * reach..=4.0 * reach),
        ] {
            ui.horizontal(|ui| {
                let label = ui.label(state.say(word));
                let value =
                    DragValue::new(&mut state.window[place]).range(range).speed(speed).max_decimals(3);
                ui.add(value).labelled_by(label.id);
            });
        }
    });
}

fn slab(ui: &mut Ui, state: &mut State) {
    let own = projection_word(state.slab.projection);
    let name = format!("{}: {}", state.say(Word::Slab), state.say(own));
    ui.menu_button(name, |ui| {
        for projection in Projection::ALL {
            let is_own = state.slab.projection == projection;
            if ui.selectable_label(is_own, state.say(projection_word(projection))).clicked() {
                state.slab.projection = projection;
                ui.close();
            }
        }
    })
    .response
    .on_hover_text(format!("{} (S)", state.say(Word::SlabHint)));
    if state.slab.projection != Projection::Thin {
        let label = ui.label(RichText::new(state.say(Word::SlabThickness)).small());
        let value = DragValue::new(&mut state.slab.thickness_mm).range(0.1..=500.0).speed(0.5).suffix(" mm");
        ui.add(value).labelled_by(label.id);
    }
}
