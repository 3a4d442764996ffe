//! The series of the study, each with a picture and what it is.

use eframe::egui::{self, Color32, CornerRadius, Rect, RichText, Sense, Stroke, StrokeKind, Ui, vec2};

use crate::state::{Action, State};
use crate::theme::{RADIUS, VIEW_GROUND, palette};
use crate::words::Word;

/// The side of a picture.
const SIDE: f32 = 60.0;

/// All series, the shown one marked.
pub fn show(ui: &mut Ui, state: &mut State) {
    let p = palette(state.settings.is_dark);
    ui.label(RichText::new(state.say(Word::Series)).small().strong().color(p.weak));
    egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        for place in 0..state.strip.series.len() {
            card(ui, state, place);
        }
        let notes = state.session.as_ref().map_or(&[][..], |session| &session.notes);
        if !notes.is_empty() {
            ui.add_space(8.0);
            ui.label(RichText::new(state.say(Word::Notes)).small().strong().color(p.weak));
            for note in notes {
                ui.add(egui::Label::new(RichText::new(note).small().color(p.weak)).wrap());
            }
        }
    });
}

fn card(ui: &mut Ui, state: &mut State, place: usize) {
    let p = palette(state.settings.is_dark);
    let series = &state.strip.series[place];
    let is_chosen = state.strip.chosen == place;
    let width = ui.available_width();
    // What it is called, and what of its description that does not say.
    let rest = series.description.strip_prefix(series.name.as_str()).unwrap_or(&series.description);
    let rest = rest.trim_start_matches([',', ' ']).to_owned();
    let inside = width - SIDE - 26.0;
    let name = ui.painter().layout(series.name.clone(), egui::FontId::proportional(13.5), p.text, inside);
    let detail = ui.painter().layout(rest, egui::FontId::proportional(11.5), p.weak, inside);
    let height = (name.size().y + detail.size().y + 4.0).max(SIDE) + 16.0;
    let (rect, response) = ui.allocate_exact_size(vec2(width, height), Sense::click());
    response.widget_info(|| {
        egui::WidgetInfo::selected(egui::WidgetType::SelectableLabel, true, is_chosen, &series.description)
    });
    let fill = match (is_chosen, response.hovered()) {
        (true, _) => p.raised,
        (false, true) => p.hovered,
        (false, false) => Color32::TRANSPARENT,
    };
    ui.painter().rect_filled(rect, RADIUS, fill);
    if is_chosen || response.has_focus() {
        ui.painter().rect_stroke(rect, RADIUS, Stroke::new(1.5, p.accent), StrokeKind::Inside);
    }
    let picture = Rect::from_min_size(rect.min + vec2(8.0, 8.0), vec2(SIDE, SIDE));
    ui.painter().rect_filled(picture, CornerRadius::same(4), VIEW_GROUND);
    if let Some(texture) = state.strip.thumbnails.get(&place) {
        let [w, h] = texture.size().map(|n| n as f32);
        let scale = SIDE / w.max(h).max(1.0);
        let own = Rect::from_center_size(picture.center(), vec2(w * scale, h * scale));
        egui::Image::new((texture.id(), own.size())).corner_radius(CornerRadius::same(4)).paint_at(ui, own);
    }
    let left = picture.right_top() + vec2(10.0, 0.0);
    let below = left + vec2(0.0, name.size().y + 4.0);
    ui.painter().galley(left, name, p.text);
    ui.painter().galley(below, detail, p.weak);
    if response.clicked() && !is_chosen && state.strip.study.is_some() {
        state.act(Action::Series(place));
    }
}
