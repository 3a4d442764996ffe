//! The lasso: a line that is drawn around something in a view, which then is cut away as deep as the scan is; and the list of those
//! that were drawn.

use eframe::egui::{PointerButton, Pos2, Rect, Response, Ui};
use lumivox_core::Lasso;
use lumivox_core::document::Entry;
use lumivox_core::glam::{DAffine3, DMat3, DVec3};
use lumivox_core::lasso::{MOST_LASSO_POINTS, MOST_LASSOS};

use super::look::entry;
use super::marks;
use super::views::are_two;
use crate::session::Session;
use crate::slices::Geometry;
use crate::state::{State, Tool, ViewId};
use crate::theme::palette;
use crate::words::Word;

/// A line that is being drawn, by points of the window.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    view: ViewId,
    points: Vec<Pos2>,
}

/// Nearer points of the window are one.
const NEAR: f32 = 2.0;

/// Lines around less, in square points of the window, were not meant.
const LEAST_AREA: f32 = 30.0;

/// What the left button draws in a view while the tool is taken. `lasso` makes of the line what it cuts out of a scan that is placed
/// like that in the first one's patient.
pub fn draw(
    ui: &Ui,
    response: &Response,
    view: ViewId,
    lasso: &dyn Fn(&Session, DAffine3, &[Pos2]) -> Lasso,
    state: &mut State,
) {
    let button = PointerButton::Primary;
    if state.tool != Tool::Lasso {
        return;
    }
    // Two fingers move the view, the first of which is a pointer, too.
    if are_two(ui) {
        state.lasso = None;
        return;
    }
    if response.drag_started_by(button) {
        let origin = ui.input(|input| input.pointer.press_origin());
        state.lasso = Some(Drawing { view, points: origin.into_iter().collect() });
    }
    let Some(mut drawing) = state.lasso.take_if(|drawing| drawing.view == view) else { return };
    if let Some(at) = response.interact_pointer_pos()
        && drawing.points.last().is_none_or(|last| last.distance(at) > NEAR)
        && drawing.points.len() < MOST_LASSO_POINTS
    {
        drawing.points.push(at);
    }
    if !response.drag_stopped_by(button) {
        state.lasso = Some(drawing);
        return;
    }
    if area(&drawing.points) < LEAST_AREA {
        return;
    }
    let Some(session) = &state.session else { return };
    let placed: Vec<DAffine3> = session.scene().0.volumes.iter().map(|it| it.world_from_patient).collect();
    let Some(first) = placed.first() else { return };
    let drawn: Vec<Lasso> =
        placed.iter().map(|own| lasso(session, own.inverse() * *first, &drawing.points)).collect();
    // All scans of the scene are cut.
    state.change(Word::Lasso, |document| {
        for (entry, lasso) in document.volumes.iter_mut().zip(drawn) {
            if entry.lassos.len() < MOST_LASSOS {
                entry.lassos.push(lasso);
            }
        }
    });
}

/// What a line passes over, seen from where it begins: nothing of a straight one, and all of one that crosses itself.
fn area(points: &[Pos2]) -> f32 {
    let Some(first) = points.first() else { return 0.0 };
    let over = |pair: &[Pos2]| {
        let [a, b] = [pair[0] - *first, pair[1] - *first];
        (a.x * b.y - b.x * a.y).abs()
    };
    0.5 * points.windows(2).map(over).sum::<f32>()
}

/// The line as far as it is drawn, closed by a line of dashes.
pub fn show(ui: &Ui, rect: Rect, view: ViewId, state: &State) {
    let Some(Drawing { points, .. }) = state.lasso.as_ref().filter(|own| own.view == view) else { return };
    let (painter, color) = (ui.painter_at(rect), palette(state.settings.is_dark).accent);
    marks::line(&painter, points.clone(), color);
    if let [first, .., last] = points[..] {
        marks::dashed(&painter, vec![first, last]);
    }
}

/// What a line in the 3D view cuts out of a scan that the first one's patient is placed in like that.
pub fn through_eye(session: &Session, own_from_first: DAffine3, rect: Rect, points: &[Pos2]) -> Lasso {
    let camera = session.camera();
    let placed = session.scene().0.volumes.first().map_or(DAffine3::IDENTITY, |it| it.world_from_patient);
    // The camera's space is of metres.
    let first_from_picture = placed.inverse() * camera.world_from_camera * millimetres();
    let half = (0.5 * camera.vertical_fov).tan();
    let corner = |at: &Pos2| {
        let by = (*at - rect.center()) / (0.5 * rect.height());
        [f64::from(by.x) * half, f64::from(-by.y) * half]
    };
    Lasso::new(own_from_first * first_from_picture, false, points.iter().map(corner).collect())
}

fn millimetres() -> DAffine3 {
    DAffine3::from_scale(DVec3::splat(1e-3))
}

/// What a line in a slice cuts out, square to that; `locate` says where a point of the window lies in the first scan's patient.
pub fn through_slice(
    own_from_first: DAffine3,
    geometry: &Geometry,
    points: &[Pos2],
    locate: &dyn Fn(Pos2) -> DVec3,
) -> Lasso {
    let [right, down, _] = geometry.axes;
    let up = -down;
    let first_from_picture =
        DAffine3::from_mat3_translation(DMat3::from_cols(right, up, right.cross(up)), geometry.center);
    let corner = |at: &Pos2| {
        let by = locate(*at) - geometry.center;
        [by.dot(right), by.dot(up)]
    };
    Lasso::new(own_from_first * first_from_picture, true, points.iter().map(corner).collect())
}

/// The list of lines that were drawn, and what becomes of them.
pub fn list(ui: &mut Ui, state: &mut State) {
    for index in 0..entry(state).map_or(0, |entry| entry.lassos.len()) {
        ui.horizontal(|ui| {
            ui.label(format!("{} {}", state.say(Word::Lasso), index + 1));
            if ui.button(state.say(Word::CutFlip)).clicked() {
                put(state, Word::CutFlip, index, |lassos, place| {
                    lassos[place].inverted = !lassos[place].inverted;
                });
            }
            if ui.button(state.say(Word::CutRemove)).clicked() {
                put(state, Word::CutRemove, index, |lassos, place| _ = lassos.remove(place));
            }
        });
    }
    if ui.button(state.say(Word::LassoDraw)).on_hover_text(state.say(Word::LassoHint)).clicked() {
        state.take(Tool::Lasso);
    }
}

/// Changes a lasso of the first scan, and in the others those that were drawn with it.
fn put(state: &mut State, what: Word, index: usize, change: impl Fn(&mut Vec<Lasso>, usize)) {
    state.change(what, |document| {
        let Some(before) = document.volumes.first().and_then(|entry| entry.lassos.get(index)).cloned() else {
            return;
        };
        let is_it = |own: &Lasso| {
            (own.parallel, own.inverted) == (before.parallel, before.inverted) && own.points == before.points
        };
        for (number, Entry { lassos, .. }) in document.volumes.iter_mut().enumerate() {
            let place = if number == 0 { Some(index) } else { lassos.iter().position(is_it) };
            if let Some(place) = place {
                change(lassos, place);
            }
        }
    });
}
