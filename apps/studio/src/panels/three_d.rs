//! The path-traced view: its picture, what the mouse does to it, and what is drawn over it.

use eframe::egui::{
    Align2, Color32, CornerRadius, FontId, Painter, PointerButton, Pos2, Rect, Response, Ui, pos2, vec2,
};
use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_viewport::{Gesture, pick};

use super::measure::{self, Gestures, Shown};
use super::views::{BUTTONS, clicked, fingers, held, interact, notches};
use super::{cube, curve, handles, lasso, marks, names};
use crate::live::Live;
use crate::session::Session;
use crate::slices::direction_letters;
use crate::state::{Action, Probe, State, Tool, ViewId};
use crate::theme::{ON_VIEW, VIEW_GROUND, palette};
use crate::words::Word;

/// All of a texture.
const WHOLE: Rect = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));

/// The view.
pub fn show(ui: &mut Ui, rect: Rect, state: &mut State, live: Option<&mut Live>) {
    let response = interact(ui, rect, ViewId::ThreeD, state);
    let scale = ui.ctx().pixels_per_point();
    state.view_size = [rect.width(), rect.height()].map(|n| (n * scale).round().max(1.0) as u32);
    ui.painter().rect_filled(rect, CornerRadius::same(6), VIEW_GROUND);
    if let Some(session) = &mut state.session {
        session.fit(f64::from(rect.width() / rect.height()));
    }
    let (Some(session), Some(live)) = (&state.session, live) else { return };
    if session.is_coming() {
        if live.prepare(session) {
            // What is wrong with it is told once it is there.
            state.progress = live.draw(session, state.view_size).unwrap_or_default();
            if !state.progress.rests {
                ui.ctx().request_repaint();
            }
        }
        let painter = ui.painter_at(rect);
        if state.progress.is_shown {
            painter.image(live.texture(), rect, WHOLE, Color32::WHITE);
        } else {
            prepares(&painter, rect, state);
        }
        return marks::title(&painter, rect, state.say(Word::ThreeD), palette(state.settings.is_dark).accent);
    }
    match live.draw(session, state.view_size) {
        Ok(progress) => state.progress = progress,
        Err(why) => {
            state.progress.rests = true;
            if state.failed.is_none() {
                state.failed = Some((Word::CannotShow, why));
            }
        }
    }
    ui.painter().image(live.texture(), rect, WHOLE, Color32::WHITE);
    if !state.progress.rests {
        ui.ctx().request_repaint();
    }
    over(ui, rect, state);
    point(ui, &response, rect, state);
    turn(ui, &response, rect, state);
    names::show(ui, rect, state);
    measurements(ui, rect, state);
    // They would be in the way of a line that begins on one.
    if state.tool != Tool::Lasso {
        handles::show(ui, rect, state);
    }
    let drawn = |session: &Session, own, points: &[Pos2]| lasso::through_eye(session, own, rect, points);
    lasso::draw(ui, &response, ViewId::ThreeD, &drawn, state);
    lasso::show(ui, rect, ViewId::ThreeD, state);
    cube::show(ui, rect, state);
}

/// What stands over the picture: its name, how far it is, the patient's sides, the shared point.
fn over(ui: &Ui, rect: Rect, state: &State) {
    let Some(session) = &state.session else { return };
    let (painter, p) = (ui.painter_at(rect), palette(state.settings.is_dark));
    marks::title(&painter, rect, state.say(Word::ThreeD), p.accent);
    if !state.progress.is_shown {
        prepares(&painter, rect, state);
    } else if state.progress.part < 1.0 && !state.progress.rests {
        marks::progress(&painter, rect, state.progress.part, p.accent);
    }
    marks::edge_letters(&painter, rect, &directions(session));
    if let Some(at) = seen_at(session, state.cross, rect).filter(|at| rect.contains(*at)) {
        marks::mark(&painter, at, p.accent);
    }
}

fn prepares(painter: &Painter, rect: Rect, state: &State) {
    let words = state.say(Word::Preparing);
    painter.text(rect.center(), Align2::CENTER_CENTER, words, FontId::proportional(15.0), ON_VIEW);
}

/// Clicks find a point of the patient, or place one of a measurement; the pointer tells what is under it.
fn point(ui: &Ui, response: &Response, rect: Rect, state: &mut State) {
    let Some(session) = &state.session else { return };
    let is_free = !ui.input(|input| input.pointer.any_down());
    if let Some(at) = response.hover_pos().filter(|_| is_free) {
        let found = picked(session, rect, at);
        state.probe =
            found.map(|found| Probe { patient_mm: in_first(session, found.world), value: found.value });
    }
    if let Tool::Measure(_) = state.tool {
        let gestures = Gestures::of(ui, response, false, &|at| located(session, rect, at));
        measure::place(&gestures, ViewId::ThreeD, screen_axes(session), state);
    } else if let Some(at) = clicked(ui, response)
        && let Some(point) = located(session, rect, at)
    {
        state.act(Action::Cross(point));
    }
}

/// Drags and the wheel move the camera.
fn turn(ui: &Ui, response: &Response, rect: Rect, state: &mut State) {
    let Some(session) = &state.session else { return };
    let mut orbit = session.orbit();
    let before = orbit;
    let profile = state.settings.mouse.profile();
    if let Some(touch) = fingers(ui, rect, state) {
        let by = touch.translation_delta / rect.height();
        let moved = [by.x, by.y].map(f64::from);
        Gesture::fingers(&mut orbit, moved, touch.zoom_delta.into(), touch.rotation_delta.into());
        if orbit != before {
            state.act(Action::Camera(orbit));
        }
        return;
    }
    let has_alt = ui.input(|input| input.modifiers.alt) && state.tool != Tool::Lasso;
    if (state.tool == Tool::Shape || has_alt) && response.dragged_by(PointerButton::Primary) {
        let by = response.drag_delta() / rect.height();
        return curve::drag(state, [by.x, by.y].map(f64::from));
    }
    for (button, known) in BUTTONS {
        let draws = state.tool == Tool::Lasso && button == PointerButton::Primary;
        if response.dragged_by(button)
            && !draws
            && let Some(gesture) = profile.gesture(known, held(ui))
        {
            let by = response.drag_delta() / rect.height();
            gesture.apply(&mut orbit, [by.x, by.y].map(f64::from));
        }
    }
    let wheel = notches(ui, response);
    if wheel != 0.0 {
        Gesture::wheel(&mut orbit, wheel);
    }
    if orbit != before {
        state.act(Action::Camera(orbit));
    }
}

fn measurements(ui: &Ui, rect: Rect, state: &mut State) {
    let Some(session) = &state.session else { return };
    if session.document().measurements.is_empty() && state.draft.is_none() {
        return;
    }
    let seen = Seen::of(session);
    let axes = screen_axes(session);
    let locate = |at: Pos2| located(session, rect, at);
    let project = |point| seen.at(point, rect);
    let view = ViewId::ThreeD;
    let shown = Shown { rect, view, axes, is_seen: &|_| true, project: &project, locate: &locate };
    let change = measure::show(ui, &shown, state);
    measure::put(change, state);
}

fn aspect(rect: Rect) -> f64 {
    f64::from(rect.width() / rect.height())
}

fn part(rect: Rect, at: Pos2) -> [f64; 2] {
    [(at.x - rect.min.x) / rect.width(), (at.y - rect.min.y) / rect.height()].map(f64::from)
}

fn picked(session: &Session, rect: Rect, at: Pos2) -> Option<lumivox_viewport::Picked> {
    pick(session.scene().0, &session.camera().with_aspect(aspect(rect)), part(rect, at))
}

/// The point of the first scan's patient that is seen at a place.
fn located(session: &Session, rect: Rect, at: Pos2) -> Option<DVec3> {
    picked(session, rect, at).map(|found| in_first(session, found.world))
}

/// A point of the world in the first scan's patient.
fn in_first(session: &Session, world: DVec3) -> DVec3 {
    let first = session.scene().0.volumes.first();
    first.map_or(DVec3::ZERO, |it| it.world_from_patient.inverse().transform_point3(world))
}

/// The picture's right, bottom and depth in the patient: where an ellipse of a picture lies.
fn screen_axes(session: &Session) -> crate::slices::Axes {
    let own = session.camera().world_from_camera.matrix3;
    let into = session.scene().0.volumes.first().map(|it| it.world_from_patient.matrix3.inverse());
    [own.x_axis, -own.y_axis, -own.z_axis]
        .map(|axis| into.map_or(axis, |into| into * axis).normalize_or(DVec3::X))
}

/// How points of a space are seen.
#[derive(Clone, Copy)]
pub struct Seen {
    camera_from_space: DAffine3,
    half_height: f64,
}

impl Seen {
    /// Points of the first scan's patient, by a session's camera.
    pub fn of(session: &Session) -> Self {
        let placed = session.scene().0.volumes.first().map(|it| it.world_from_patient);
        Self::by_camera(session, placed.unwrap_or_default())
    }

    /// Points of the world.
    pub fn of_world(session: &Session) -> Self {
        Self::by_camera(session, DAffine3::IDENTITY)
    }

    /// Points of the world in mm.
    pub fn of_world_mm(session: &Session) -> Self {
        Self::by_camera(session, DAffine3::from_scale(DVec3::splat(1e-3)))
    }

    fn by_camera(session: &Session, world_from_space: DAffine3) -> Self {
        let camera = session.camera();
        Self {
            camera_from_space: camera.world_from_camera.inverse() * world_from_space,
            half_height: (camera.vertical_fov / 2.0).tan(),
        }
    }

    /// Where a point is seen in the window; `None` behind the eye.
    pub fn at(&self, point: DVec3, rect: Rect) -> Option<Pos2> {
        let own = self.camera_from_space.transform_point3(point);
        let half = self.half_height * -own.z;
        let at = rect.center() + vec2((own.x / half) as f32, (-own.y / half) as f32) * (rect.height() / 2.0);
        (own.z < 0.0).then_some(at)
    }

    /// The point that is seen at a place, as deep as another one.
    pub fn point(&self, at: Pos2, rect: Rect, deep_as: DVec3) -> DVec3 {
        let depth = self.camera_from_space.transform_point3(deep_as).z;
        let by = (at - rect.center()) / (rect.height() / 2.0);
        let half = self.half_height * -depth;
        let own = DVec3::new(f64::from(by.x) * half, f64::from(-by.y) * half, depth);
        self.camera_from_space.inverse().transform_point3(own)
    }
}

/// Where a point of the first scan's patient is seen.
pub fn seen_at(session: &Session, patient_mm: DVec3, rect: Rect) -> Option<Pos2> {
    Seen::of(session).at(patient_mm, rect)
}

/// What lies to the left, right, top and bottom of the view, by the patient's own sides.
fn directions(session: &Session) -> [String; 4] {
    let [right, down, _] = screen_axes(session);
    [-right, right, -down, down].map(direction_letters)
}
