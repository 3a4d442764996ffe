//! How the scan looks: tiles of looks, the curve of opacity and colour, light.

use eframe::egui::{
    self, Color32, Rect, RichText, Sense, Slider, SliderClamping, Stroke, StrokeKind, Ui, vec2,
};
use lumivox_core::document::{Entry, Keep};
use lumivox_core::{Preset, Volume};

use super::{curve, light};
use crate::state::{Action, State};
use crate::theme::{RADIUS, VIEW_GROUND, palette};
use crate::words::{self, Word};

/// Tiles beside each other.
const COLUMNS: usize = 4;

/// Where there are names alone: so many beside each other, of that height.
const NAMED_COLUMNS: usize = 2;
const NAMED: f32 = 28.0;

/// The room of a tile's name.
const NAME: f32 = 19.0;

/// The looks of the scan, its curve, its light.
pub fn show(ui: &mut Ui, state: &mut State) {
    tiles(ui, state);
    everything(ui, state);
    heading(ui, state, Word::Curve);
    curve::show(ui, state);
    shape(ui, state);
    heading(ui, state, Word::Light);
    light::show(ui, state);
    ui.add_space(10.0);
}

pub fn heading(ui: &mut Ui, state: &State, word: Word) {
    let p = palette(state.settings.is_dark);
    ui.add_space(8.0);
    ui.label(RichText::new(state.say(word)).strong().size(14.5).color(p.text));
}

pub fn entry(state: &State) -> Option<&Entry> {
    state.session.as_ref()?.document().volumes.first()
}

fn tiles(ui: &mut Ui, state: &mut State) {
    let chosen = entry(state).and_then(|entry| entry.look.preset);
    let mut looks = state.looks.clone();
    // A scene's file may have one of another kind.
    looks.extend(chosen.filter(|chosen| !looks.contains(chosen)));
    let gap = 6.0;
    let columns = if state.has_tiles { COLUMNS } else { NAMED_COLUMNS };
    let side = ((ui.available_width() - gap * (columns - 1) as f32) / columns as f32).floor();
    // Rows and a part of the next, which says that there are more.
    let height = if state.has_tiles { 2.6 * (side + NAME + gap) } else { 4.6 * (NAMED + gap) };
    egui::ScrollArea::vertical().id_salt("looks").max_height(height).auto_shrink([false, true]).show(
        ui,
        |ui| {
            egui::Grid::new("looks").num_columns(columns).spacing(vec2(gap, gap)).show(ui, |ui| {
                for (place, preset) in looks.into_iter().enumerate() {
                    tile(ui, state, preset, chosen == Some(preset), side);
                    if place % columns == columns - 1 {
                        ui.end_row();
                    }
                }
            });
        },
    );
}

fn tile(ui: &mut Ui, state: &mut State, preset: Preset, is_chosen: bool, side: f32) {
    let p = palette(state.settings.is_dark);
    let name = words::look(preset).map_or(preset.name(), |word| state.say(word));
    let size = if state.has_tiles { vec2(side, side + NAME) } else { vec2(side, NAMED) };
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    response
        .widget_info(|| egui::WidgetInfo::selected(egui::WidgetType::SelectableLabel, true, is_chosen, name));
    // Where there are no pictures the name has their place.
    let picture = if state.has_tiles { Rect::from_min_size(rect.min, vec2(side, side)) } else { rect };
    ui.painter().rect_filled(picture, RADIUS, VIEW_GROUND);
    match state.tiles.get(&preset) {
        _ if !state.has_tiles => {}
        Some(texture) => {
            egui::Image::new((texture.id(), picture.size())).corner_radius(RADIUS).paint_at(ui, picture);
        }
        None => {
            let center = picture.center();
            for x in [-8.0, 0.0, 8.0] {
                ui.painter().circle_filled(center + vec2(x, 0.0), 1.8, Color32::from_gray(90));
            }
        }
    }
    let line = match (is_chosen, response.hovered() || response.has_focus()) {
        (true, _) => Stroke::new(2.0, p.accent),
        (false, true) => Stroke::new(1.5, p.weak),
        (false, false) => Stroke::NONE,
    };
    ui.painter().rect_stroke(picture, RADIUS, line, StrokeKind::Inside);
    let color = if is_chosen { p.text } else { p.weak };
    let galley = ui.painter().layout_no_wrap(name.to_owned(), egui::FontId::proportional(11.0), color);
    let shown = galley.size().x.min(side);
    let top =
        if state.has_tiles { picture.bottom() + 3.0 } else { picture.center().y - galley.size().y / 2.0 };
    let at = egui::pos2(picture.center().x - shown / 2.0, top);
    ui.painter().with_clip_rect(rect).galley(at, galley, color);
    if response.clone().on_hover_text(preset.description()).clicked() {
        state.act(Action::Look(preset));
    }
}

fn everything(ui: &mut Ui, state: &mut State) {
    let Some(keep) = entry(state).map(|entry| entry.scan.keep) else { return };
    let mut all = keep == Keep::Everything;
    let (word, hint) = (state.say(Word::Everything), state.say(Word::EverythingHint));
    if ui.checkbox(&mut all, word).on_hover_text(hint).changed() {
        let keep = if all { Keep::Everything } else { Keep::Patient };
        state.change(Word::Everything, |document| {
            document.volumes.iter_mut().for_each(|entry| entry.scan.keep = keep);
        });
    }
}

/// The room of a slider's number, with the gap before it.
const NUMBER: f32 = 78.0;

/// A slider with its name before it, in a row; true when it was moved.
pub fn slider(ui: &mut Ui, name: &str, slider: Slider<'_>) -> bool {
    ui.horizontal(|ui| {
        let left = egui::Layout::left_to_right(egui::Align::Center);
        let words = egui::Label::new(RichText::new(name).size(13.0)).truncate();
        let label = ui.allocate_ui_with_layout(vec2(96.0, 22.0), left, |ui| {
            ui.set_min_width(96.0);
            ui.add(words)
        });
        // What is left beside the number.
        let room = ui.available_width() - NUMBER;
        ui.spacing_mut().interact_size = vec2(NUMBER - 8.0, 22.0);
        ui.spacing_mut().slider_width = room.max(60.0);
        // What came otherwise is not rounded by being shown.
        let slider = slider.clamping(SliderClamping::Edits);
        ui.add(slider).labelled_by(label.inner.id).changed()
    })
    .inner
}

/// Shift and width of the look.
fn shape(ui: &mut Ui, state: &mut State) {
    let Some(session) = &state.session else { return };
    let reach = shift_range(session.scan());
    let Some(look) = entry(state).map(|entry| entry.look.clone()) else { return };
    let mut shift = look.shift.unwrap_or(0.0);
    let bar = Slider::new(&mut shift, -reach..=reach).fixed_decimals(if reach > 20.0 { 0 } else { 2 });
    if slider(ui, state.say(Word::Shift), bar) {
        state.change(Word::Shift, |document| {
            if let Some(entry) = document.volumes.first_mut() {
                (entry.look.shift, entry.look.window) = ((shift != 0.0).then_some(shift), None);
            }
        });
    }
    let mut width = look.window_scale.unwrap_or(1.0);
    let bar = Slider::new(&mut width, 0.2..=5.0).logarithmic(true).fixed_decimals(2).suffix("\u{d7}");
    if slider(ui, state.say(Word::Width), bar) {
        state.change(Word::Width, |document| {
            if let Some(entry) = document.volumes.first_mut() {
                (entry.look.window_scale, entry.look.window) = ((width != 1.0).then_some(width), None);
            }
        });
    }
}

/// How far a look can be moved: over what tissues differ by in a CT, else over most of the values.
pub fn shift_range(scan: &Volume) -> f64 {
    if scan.is_hounsfield() {
        return 500.0;
    }
    let [low, high] = scan.value_range();
    (0.5 * (high - low)).max(1e-6)
}
