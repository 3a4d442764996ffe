//! Measurements in pictures: what a tool's clicks become, lines and words, points that are dragged; and their list.

use eframe::egui::{
    self, Align, Color32, CursorIcon, Id, Painter, PointerButton, Pos2, Rect, Response, RichText, Sense, Ui,
    Vec2, vec2,
};
use lumivox_core::document::{Measurement, MeasurementKind};
use lumivox_core::glam::DVec3;

use super::marks::{handle, line, nudged, plate};
use crate::measuring::{Draft, kind_word, made, moved, placed_points};
use crate::slices::{Axes, Plane, ellipse};
use crate::state::{Action, Ask, State, Tool, ViewId};
use crate::theme::palette;
use crate::words::Word;

/// Of measurements in pictures.
const COLOR: Color32 = Color32::from_rgb(0x8f, 0xe0, 0xff);

/// What the left button did to a view, by points of the patient.
#[derive(Default)]
pub struct Gestures {
    clicked: Option<DVec3>,
    /// Where a drag begins.
    began: Option<DVec3>,
    /// Where it ends.
    ended: Option<DVec3>,
    now: Option<DVec3>,
}

impl Gestures {
    /// Of a view; `locate` says which point of the patient is seen at a place. Where a drag does something else, it is none.
    pub fn of(ui: &Ui, response: &Response, drags: bool, locate: &dyn Fn(Pos2) -> Option<DVec3>) -> Self {
        let button = PointerButton::Primary;
        let at = response.interact_pointer_pos();
        let origin = ui.input(|input| input.pointer.press_origin());
        let is_held = drags && response.dragged_by(button);
        let is_over = drags && response.drag_stopped_by(button);
        Self {
            clicked: at.filter(|_| response.clicked()).and_then(locate),
            began: origin.filter(|_| is_held && response.drag_started_by(button)).and_then(locate),
            ended: at.filter(|_| is_over).and_then(locate),
            now: response.hover_pos().or(at.filter(|_| is_held)).and_then(locate),
        }
    }
}

/// Points that the tool places in a view, and the measurement that becomes of them.
pub fn place(gestures: &Gestures, view: ViewId, axes: Axes, state: &mut State) {
    let Tool::Measure(kind) = state.tool else { return };
    let mut draft = match state.draft.take() {
        Some(draft) if draft.view == view && draft.kind == kind => draft,
        // The pointer may be over another view for a while.
        Some(draft) if gestures.clicked.is_none() && gestures.began.is_none() => {
            state.draft = Some(draft);
            return;
        }
        _ => Draft { kind, view, points: vec![], next: None },
    };
    draft.next = gestures.now.or(draft.next);
    let began = gestures.began.filter(|_| draft.points.is_empty());
    draft.points.extend(began.or(gestures.clicked));
    if let Some(end) = gestures.ended
        && draft.points.len() == 1
    {
        draft.points.push(end);
    }
    if draft.points.len() < placed_points(kind) {
        state.draft = (!draft.points.is_empty()).then_some(draft);
        return;
    }
    if let Some(measurement) = made(kind, &draft.points, axes) {
        state.change(kind_word(kind), |document| document.measurements.push(measurement));
    }
}

/// The tool's next point, where the cross is in a slice.
pub fn place_at_cross(plane: Plane, state: &mut State) {
    let cross = Some(state.cross);
    place(
        &Gestures { clicked: cross, now: cross, ..Gestures::default() },
        ViewId::Slice(plane),
        state.axes(plane),
        state,
    );
}

/// The line of a measurement in the patient: an ellipse is one of many points.
fn outline(measurement: &Measurement) -> Vec<DVec3> {
    let points: Vec<DVec3> = measurement.points.iter().copied().map(DVec3::from_array).collect();
    match (measurement.kind, &points[..]) {
        (MeasurementKind::Region, &[center, first, second]) => {
            ellipse(center, first - center, second - center).collect()
        }
        _ => points,
    }
}

/// How a view shows points of the patient.
pub struct Shown<'a> {
    /// Where it is in the window.
    pub rect: Rect,
    /// Which it is.
    pub view: ViewId,
    /// Its plane.
    pub axes: Axes,
    /// Whether a measurement is seen in it.
    pub is_seen: &'a dyn Fn(&Measurement) -> bool,
    /// Where a point of the patient is seen.
    pub project: &'a dyn Fn(DVec3) -> Option<Pos2>,
    /// Which point of the patient is seen at a place.
    pub locate: &'a dyn Fn(Pos2) -> Option<DVec3>,
}

impl Shown<'_> {
    /// Where a point goes that is dragged to a place: in a slab it keeps its depth, in 3D it stays on what is seen.
    fn locate_beside(&self, at: Pos2, point: DVec3) -> Option<DVec3> {
        let seen = (self.locate)(at)?;
        let normal = self.axes[2];
        let depth = if self.view == ViewId::ThreeD { 0.0 } else { (point - seen).dot(normal) };
        Some(seen + normal * depth)
    }
}

/// All measurements that a view shows, with points that are dragged, and the one that is being made. Which is dragged, by its place,
/// and what it becomes.
pub fn show(ui: &Ui, shown: &Shown<'_>, state: &State) -> Option<(usize, Measurement)> {
    let Shown { rect, view, is_seen, project, .. } = *shown;
    let painter = ui.painter_at(rect);
    let measurements = &state.session.as_ref()?.document().measurements;
    let mut change = None;
    let mut plates = vec![];
    for (index, measurement) in measurements.iter().enumerate().filter(|(_, it)| is_seen(it)) {
        let Some(most) = draw(&painter, measurement, project) else { continue };
        plates.push((most, state.lines(measurement)));
        for (place, point) in measurement.points.iter().copied().map(DVec3::from_array).enumerate() {
            let Some(at) = project(point).filter(|at| rect.contains(*at)) else { continue };
            let id = Id::new(("measurement", index, place, view));
            let response = ui.interact(Rect::from_center_size(at, vec2(16.0, 16.0)), id, Sense::drag());
            response.widget_info(|| {
                let name = format!("{} {}, {}", state.say(Word::Measurement), index + 1, place + 1);
                egui::WidgetInfo::labeled(egui::WidgetType::Other, true, name)
            });
            let is_held = response.hovered() || response.dragged() || response.has_focus();
            handle(&painter, at, COLOR, is_held);
            let to = dragged_to(ui, &response, at).or_else(|| Some(at + nudged(ui, &response)?));
            if let Some(to) = to.and_then(|to| shown.locate_beside(to, point)) {
                change = Some((index, moved(measurement, place, to)));
            }
            response.on_hover_cursor(CursorIcon::Grab);
        }
    }
    for (at, words) in plates {
        plate(&painter, rect, at, &words, COLOR);
    }
    draw_draft(&painter, shown, state);
    change
}

/// Where a handle is dragged to: it stays as far from the pointer as where it was taken. Nothing while it is only pressed.
fn dragged_to(ui: &Ui, response: &Response, at: Pos2) -> Option<Pos2> {
    if response.drag_started() {
        let taken = ui.input(|input| input.pointer.press_origin())?;
        ui.data_mut(|data| data.insert_temp(response.id, at - taken));
    }
    let beside: Vec2 = ui.data(|data| data.get_temp(response.id))?;
    let is_moved = response.dragged() && response.drag_delta() != Vec2::ZERO;
    response.interact_pointer_pos().filter(|_| is_moved).map(|pointer| pointer + beside)
}

/// Makes a measurement what a view says that it becomes.
pub fn put(change: Option<(usize, Measurement)>, state: &mut State) {
    let Some((index, new)) = change else { return };
    state.change(kind_word(new.kind), |document| {
        if let Some(own) = document.measurements.get_mut(index) {
            *own = new;
        }
    });
}

/// The line of a measurement; its place furthest to the right, where words stand.
fn draw(
    painter: &Painter,
    measurement: &Measurement,
    project: &dyn Fn(DVec3) -> Option<Pos2>,
) -> Option<Pos2> {
    let points: Vec<Pos2> = outline(measurement).into_iter().filter_map(project).collect();
    let most = points.iter().copied().max_by(|a, b| a.x.total_cmp(&b.x));
    line(painter, points, COLOR);
    most
}

fn draw_draft(painter: &Painter, shown: &Shown<'_>, state: &State) {
    let Shown { rect, view, axes, project, .. } = *shown;
    let Some(draft) = state.draft.as_ref().filter(|draft| draft.view == view) else { return };
    let mut points = draft.points.clone();
    points.extend(draft.next);
    if let Some(measurement) = made(draft.kind, &points, axes) {
        if let Some(at) = draw(painter, &measurement, project) {
            plate(painter, rect, at, &state.lines(&measurement), COLOR);
        }
    } else {
        line(painter, points.iter().copied().filter_map(project).collect(), COLOR);
    }
    for at in draft.points.iter().copied().filter_map(project) {
        handle(painter, at, COLOR, false);
    }
}

/// All measurements, each with what it says; to find it again, to delete it, to save all as a table.
pub fn list(ui: &mut Ui, state: &mut State) {
    let p = palette(state.settings.is_dark);
    let Some(session) = &state.session else { return };
    let measurements = session.document().measurements.clone();
    let file = session.file_name("csv");
    if measurements.is_empty() {
        ui.add(egui::Label::new(RichText::new(state.say(Word::MeasureHint)).small().color(p.weak)).wrap());
        return;
    }
    for (index, measurement) in measurements.iter().enumerate() {
        let words = state.lines(measurement);
        let name = format!("{} {}", state.say(kind_word(measurement.kind)), index + 1);
        ui.horizontal(|ui| {
            let found = ui.add(egui::Button::new(RichText::new(&name).size(13.0)).frame(false));
            if found.on_hover_text(state.say(Word::MeasureFind)).clicked() {
                let points = measurement.points.iter().copied().map(DVec3::from_array);
                let middle = points.sum::<DVec3>() / measurement.points.len() as f64;
                // Of a region and an angle it is the point that they are of.
                let at = match measurement.kind {
                    MeasurementKind::Distance => middle,
                    MeasurementKind::Angle => DVec3::from_array(measurement.points[1]),
                    MeasurementKind::Region => DVec3::from_array(measurement.points[0]),
                };
                state.act(Action::Cross(at));
            }
            ui.with_layout(egui::Layout::right_to_left(Align::Center), |ui| {
                let delete = format!("{} {}", state.say(Word::Delete), index + 1);
                let button = ui.add(egui::Button::new("\u{d7}").small().frame_when_inactive(false));
                button.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, true, &delete));
                if button.on_hover_text(delete).clicked() {
                    state.change(Word::Delete, |document| {
                        document.measurements.remove(index);
                    });
                }
                let first = words.first().cloned().unwrap_or_default();
                ui.add(egui::Label::new(RichText::new(first).size(13.0).color(p.text)).truncate());
            });
        });
    }
    if ui.button(state.say(Word::SaveTable)).clicked() {
        state.act(Action::Ask(Ask::SaveTable(file)));
    }
}
