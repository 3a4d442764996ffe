//! The orientation cube in the 3D view: how the patient is turned; a click on a side turns to it.

use eframe::egui::{
    Align2, Color32, CornerRadius, FontId, Id, Pos2, Rect, Sense, Shape, Stroke, StrokeKind, Ui, WidgetInfo,
    WidgetType, vec2,
};
use lumivox_core::glam::{DMat3, DVec3};

use crate::state::{Action, State};
use crate::theme::{ON_VIEW, palette};
use crate::words::Word;

/// The place that it has, and half of an edge.
const PLACE: f32 = 92.0;
const HALF: f32 = 25.0;

/// Sides of the patient: letter, axis (LPS), and whether it is where that grows.
const SIDES: [(&str, usize, bool); 6] =
    [("R", 0, false), ("L", 0, true), ("A", 1, false), ("P", 1, true), ("F", 2, false), ("H", 2, true)];

/// Where it is in a view, if there is room for it: in its lower right corner.
pub fn place(rect: Rect) -> Option<Rect> {
    let has_room = rect.width() >= 3.0 * PLACE && rect.height() >= 3.0 * PLACE;
    let at = rect.right_bottom() - vec2(PLACE + 6.0, PLACE + 6.0);
    has_room.then(|| Rect::from_min_size(at, vec2(PLACE, PLACE)))
}

/// The cube.
pub fn show(ui: &Ui, rect: Rect, state: &mut State) {
    let (Some(session), Some(place)) = (&state.session, place(rect)) else { return };
    let response = ui.interact(place, Id::new("cube"), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(WidgetType::Other, true, state.say(Word::Cube)));
    let (painter, p) = (ui.painter_at(place), palette(state.settings.is_dark));
    let camera_from_patient = session.camera().world_from_camera.matrix3.transpose() * session.patient_axes();
    let pointer = response.hover_pos();
    let pressed = response.interact_pointer_pos().filter(|_| response.clicked());
    let mut turned = None;
    for (letter, axis, grows) in SIDES {
        let mut side = DVec3::ZERO;
        side[axis] = if grows { 1.0 } else { -1.0 };
        let facing = (camera_from_patient * side).z;
        if facing < 0.02 {
            continue;
        }
        let corners = corners(place.center(), camera_from_patient, axis, side);
        let is_over = pointer.is_some_and(|at| holds(&corners, at));
        let shade = (46.0 + 70.0 * facing) as u8;
        let fill = if is_over { p.accent } else { Color32::from_rgb(shade, shade + 6, shade + 14) };
        let edge = Stroke::new(1.0, Color32::from_black_alpha(200));
        painter.add(Shape::convex_polygon(corners.to_vec(), fill, edge));
        let middle = corners.iter().fold(vec2(0.0, 0.0), |sum, at| sum + at.to_vec2()) / 4.0;
        let font = FontId::proportional(9.0 + 7.0 * facing as f32);
        painter.text(middle.to_pos2(), Align2::CENTER_CENTER, letter, font, ON_VIEW);
        if pressed.is_some_and(|at| holds(&corners, at)) {
            turned = Some(session.angles_of(side));
        }
    }
    if response.has_focus() {
        painter.rect_stroke(place, CornerRadius::same(6), Stroke::new(1.0, p.accent), StrokeKind::Inside);
    }
    if let Some([azimuth, elevation]) = turned {
        let orbit = lumivox_core::Orbit { azimuth, elevation, ..session.orbit() };
        state.act(Action::Camera(orbit));
    }
    response.on_hover_text(state.say(Word::CubeHint));
}

/// A side's corners in the window, around.
fn corners(center: Pos2, camera_from_patient: DMat3, axis: usize, side: DVec3) -> [Pos2; 4] {
    let [u, v] = [1, 2].map(|next| DVec3::AXES[(axis + next) % 3]);
    [u + v, v - u, -u - v, u - v].map(|along| {
        let own = camera_from_patient * (side + along);
        center + vec2(own.x as f32, -own.y as f32) * HALF
    })
}

/// Whether a place lies within a convex quadrilateral.
fn holds(corners: &[Pos2; 4], at: Pos2) -> bool {
    let sides = (0..4).map(|i| {
        let (a, b) = (corners[i], corners[(i + 1) % 4]);
        let (edge, to) = (b - a, at - a);
        edge.x * to.y - edge.y * to.x
    });
    let sides: Vec<f32> = sides.collect();
    sides.iter().all(|side| *side > 0.0) || sides.iter().all(|side| *side < 0.0)
}
