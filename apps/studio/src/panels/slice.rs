//! A slice: its picture, what the mouse does to it, the lines of the other planes, and the handles that turn the oblique one.

use eframe::egui::{
    self, Align2, Color32, CornerRadius, CursorIcon, FontId, Id, PointerButton, Pos2, Rect, Response, Sense,
    TextureOptions, Ui, Vec2, pos2, vec2,
};
use lumivox_core::Volume;
use lumivox_core::document::Measurement;
use lumivox_core::glam::{DQuat, DVec2, DVec3};
use lumivox_viewport::SliceGesture;

use super::measure::{self, Gestures, Shown};
use super::views::{BUTTONS, clicked, fingers, held, interact, notches};
use super::{lasso, marks};
use crate::session::Session;
use crate::slices::{self, Geometry, Plane, Projection, edge_letters, reach_mm, step_mm, value_at};
use crate::state::{Action, Drawn, Probe, SliceView, State, Tool, ViewId};
use crate::theme::{ON_VIEW, VIEW_GROUND};
use crate::words::Word;

/// A slice in a place of the window.
struct Place {
    rect: Rect,
    /// Pixels of a point of the window.
    scale: f64,
    geometry: Geometry,
}

impl Place {
    fn locate(&self, at: Pos2) -> DVec3 {
        let pixel = [at.x - self.rect.min.x, at.y - self.rect.min.y].map(|n| f64::from(n) * self.scale);
        self.geometry.point(pixel)
    }

    fn project(&self, point: DVec3) -> Pos2 {
        let [x, y] = self.geometry.pixel(point).map(|n| (n / self.scale) as f32);
        self.rect.min + vec2(x, y)
    }

    /// A direction of the patient in the window; `None` where it goes into the picture.
    fn direction(&self, direction: DVec3) -> Option<Vec2> {
        let [right, down, _] = self.geometry.axes;
        let along = vec2(direction.dot(right) as f32, direction.dot(down) as f32);
        (along.length() > 1e-3).then(|| along.normalized())
    }
}

/// The slice of a plane.
pub fn show(ui: &mut Ui, rect: Rect, plane: Plane, state: &mut State) {
    let view = ViewId::Slice(plane);
    let response = interact(ui, rect, view, state);
    ui.painter().rect_filled(rect, CornerRadius::same(6), VIEW_GROUND);
    let Some(scan) = state.session.as_ref().map(|session| session.scan().clone()) else { return };
    let scale = f64::from(ui.ctx().pixels_per_point());
    let size = [rect.width(), rect.height()].map(|n| (f64::from(n) * scale).round().max(1.0) as usize);
    let axes = state.axes(plane);
    let place = |state: &State| {
        let own = &state.slices[plane.index()];
        Place { rect, scale, geometry: Geometry::new(&scan, axes, state.cross, size, own.zoom, own.moved) }
    };
    let before = place(state);

    // The wheel goes from slice to slice, away from the hand towards the head, the front or the patient's right.
    let (notches, zooms) = (notches(ui, &response), ui.input(|input| input.modifiers.command));
    if notches != 0.0 && zooms {
        zoom(&mut state.slices[plane.index()], 0.4 * notches);
    } else if notches != 0.0 {
        state.step(plane, if plane == Plane::Axial { notches } else { -notches });
    }
    if let Some(at) = response.hover_pos() {
        let point = before.locate(at);
        let value = value_at(&scan, point, axes[2], state.slab);
        state.probe = value.map(|value| Probe { patient_mm: point, value });
    }
    match state.tool {
        Tool::Measure(_) => {
            let gestures = Gestures::of(ui, &response, true, &|at| Some(before.locate(at)));
            measure::place(&gestures, view, axes, state);
        }
        _ => {
            if let Some(at) = clicked(ui, &response) {
                state.act(Action::Cross(before.locate(at)));
            }
        }
    }
    let drawn = |_: &Session, own, points: &[Pos2]| {
        lasso::through_slice(own, &before.geometry, points, &|at| before.locate(at))
    };
    lasso::draw(ui, &response, view, &drawn, state);
    drag(ui, &response, &before, &scan, plane, state);

    let now = place(state);
    draw(ui, rect, &scan, now.geometry, plane, state);
    let painter = ui.painter_at(rect);
    if let Some(session) = &state.session
        && let Some(cut) = session.document().volumes.first().and_then(|entry| entry.clip)
    {
        let corners = slices::outline(&scan, cut, &now.geometry);
        marks::dashed(&painter, corners.into_iter().map(|corner| now.project(corner)).collect());
    }
    let cross = now.project(state.cross);
    for other in shown_planes(state).filter(|other| *other != plane) {
        let along = now.direction(state.axes(other)[2].cross(axes[2]));
        if let Some(along) = along {
            marks::plane_line(&painter, rect, cross, along, other);
        }
    }
    marks::title(&painter, rect, state.say(view.word()), marks::color_of(plane));
    marks::edge_letters(&painter, rect, &edge_letters(axes));
    marks::scale_bar(&painter, rect, (now.geometry.mm_per_pixel * scale) as f32);
    let at = rect.min + vec2(10.0, 26.0);
    let font = FontId::proportional(11.5);
    marks::shadowed(&painter, at, Align2::LEFT_TOP, &caption(state), font, ON_VIEW.gamma_multiply(0.8));
    if state.shows_oblique && plane != Plane::Oblique {
        turn_handles(ui, &now, plane, state);
    }
    // What lies within half a slice is seen.
    let near_mm = state.slab.half_mm().max(0.5 * step_mm(&scan, axes[2])) + 1e-6;
    let is_seen = |measurement: &Measurement| {
        let mut points = measurement.points.iter().copied().map(DVec3::from_array);
        points.all(|point| now.geometry.distance_mm(point) <= near_mm)
    };
    let (project, locate) = (|point| Some(now.project(point)), |at| Some(now.locate(at)));
    let shown = Shown { rect, view, axes, is_seen: &is_seen, project: &project, locate: &locate };
    let change = measure::show(ui, &shown, state);
    measure::put(change, state);
    lasso::show(ui, rect, view, state);
}

/// The planes that have a view.
fn shown_planes(state: &State) -> impl Iterator<Item = Plane> {
    let shows_oblique = state.shows_oblique;
    Plane::ALL.into_iter().filter(move |plane| *plane != Plane::Oblique || shows_oblique)
}

/// Window and slab.
fn caption(state: &State) -> String {
    let [level, width] = state.window.map(|n| lumivox_core::words::number((n * 10.0).round() / 10.0));
    let window = format!("{} {level} / {width}", state.say(Word::Window));
    match state.slab.projection {
        Projection::Thin => window,
        kind => format!("{window}\n{} {:.0} mm", state.say(projection_word(kind)), state.slab.thickness_mm),
    }
}

/// What a way to look at slabs is called.
pub fn projection_word(projection: Projection) -> Word {
    match projection {
        Projection::Thin => Word::SlabThin,
        Projection::Maximum => Word::SlabMaximum,
        Projection::Mean => Word::SlabMean,
        Projection::Minimum => Word::SlabMinimum,
    }
}

/// What dragging does, as the mouse's profile says. While a tool has the left button, the right one has the window.
fn drag(ui: &Ui, response: &Response, place: &Place, scan: &Volume, plane: Plane, state: &mut State) {
    let profile = state.settings.mouse.profile();
    let is_taken = matches!(state.tool, Tool::Measure(_) | Tool::Lasso);
    let by = response.drag_delta();
    // Of the window's points.
    let in_mm = |by: Vec2| DVec2::new(by.x.into(), by.y.into()) * place.scale * place.geometry.mm_per_pixel;
    if let Some(touch) = fingers(ui, place.rect, state) {
        let own = &mut state.slices[plane.index()];
        own.moved += in_mm(touch.translation_delta);
        return zoom(own, f64::from(touch.zoom_delta.max(1e-3)).ln());
    }
    // A finger has no wheel, and no second button.
    if ui.input(egui::InputState::any_touches) && !is_taken && response.dragged() {
        let [low, high] = reach_mm(scan, place.geometry.axes[2]);
        let slices = (high - low) / step_mm(scan, place.geometry.axes[2]);
        let by = f64::from(-by.y / place.rect.height()) * slices;
        return state.step(plane, if plane == Plane::Axial { by } else { -by });
    }
    for (button, known) in BUTTONS.into_iter().filter(|(button, _)| response.dragged_by(*button)) {
        let gesture = match button {
            PointerButton::Primary if is_taken => None,
            PointerButton::Secondary if is_taken => Some(SliceGesture::Window),
            _ => profile.slice_gesture(known, held(ui)),
        };
        let own = &mut state.slices[plane.index()];
        match gesture {
            Some(SliceGesture::Window) => drag_window(&mut state.window, by, place.rect),
            Some(SliceGesture::Pan) => {
                own.moved += in_mm(by);
            }
            Some(SliceGesture::Zoom) => zoom(own, 3.0 * f64::from(by.y / place.rect.height())),
            Some(SliceGesture::Cross) => {
                if let Some(at) = response.interact_pointer_pos() {
                    state.act(Action::Cross(place.locate(at)));
                }
            }
            None => {}
        }
    }
}

/// Larger by so many e-foldings.
fn zoom(view: &mut SliceView, by: f64) {
    view.zoom = (view.zoom * by.exp()).clamp(0.5, 40.0);
}

/// To the right wider, down darker, as in OHIF.
fn drag_window(window: &mut [f64; 2], by: Vec2, rect: Rect) {
    let [level, width] = window;
    let scale = 2.0 * width.max(1e-6) / f64::from(rect.height().max(1.0));
    *level += f64::from(by.y) * scale;
    *width = (*width + f64::from(by.x) * scale).max(1e-6);
}

fn draw(ui: &Ui, rect: Rect, scan: &Volume, geometry: Geometry, plane: Plane, state: &mut State) {
    let overlay = state.overlay.as_ref().map(|(_, overlay)| overlay.clone());
    let wanted = Drawn { geometry, window: state.window, slab: state.slab, overlay };
    let view = &mut state.slices[plane.index()];
    if !matches!(&view.drawn, Some((known, _)) if *known == wanted) {
        let image = slices::image(scan, &geometry, wanted.window, wanted.slab, wanted.overlay.as_deref());
        match &mut view.drawn {
            Some((known, texture)) => {
                texture.set(image, TextureOptions::LINEAR);
                *known = wanted;
            }
            None => {
                let texture = ui.ctx().load_texture("slice", image, TextureOptions::LINEAR);
                view.drawn = Some((wanted, texture));
            }
        }
    }
    if let Some((_, texture)) = &view.drawn {
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        ui.painter_at(rect).image(texture.id(), rect, whole, Color32::WHITE);
    }
}

/// Handles on the oblique plane's line: dragged, they turn it about the shared point.
fn turn_handles(ui: &Ui, place: &Place, plane: Plane, state: &mut State) {
    let [right, down, normal] = place.geometry.axes;
    let Some(along) = place.direction(state.axes(Plane::Oblique)[2].cross(normal)) else { return };
    let cross = place.project(state.cross);
    let reach = 0.34 * place.rect.width().min(place.rect.height());
    for (end, along) in [along, -along].into_iter().enumerate() {
        let at = cross + along * reach;
        if !place.rect.shrink(6.0).contains(at) {
            continue;
        }
        let id = Id::new(("turn", plane, end));
        let response = ui.interact(Rect::from_center_size(at, vec2(18.0, 18.0)), id, Sense::drag());
        response.widget_info(|| {
            let name =
                format!("{} ({})", state.say(Word::ObliqueTurn), state.say(ViewId::Slice(plane).word()));
            egui::WidgetInfo::labeled(egui::WidgetType::Other, true, name)
        });
        let is_held = response.hovered() || response.dragged() || response.has_focus();
        marks::handle(&ui.painter_at(place.rect), at, marks::color_of(Plane::Oblique), is_held);
        let dragged = response.interact_pointer_pos().filter(|_| response.dragged());
        if let Some(to) = dragged.or_else(|| Some(at + marks::nudged(ui, &response)?)) {
            let to = to - cross;
            let angle = f64::from(along.x * to.y - along.y * to.x).atan2(f64::from(along.dot(to)));
            // From the image's right towards its bottom.
            state.oblique = (DQuat::from_axis_angle(right.cross(down), angle) * state.oblique).normalize();
        }
        response.on_hover_cursor(CursorIcon::Grab).on_hover_text(state.say(Word::ObliqueTurn));
    }
}
