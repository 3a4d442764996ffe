//! The orientation cube in the 3D view: how the patient is turned; a click on a side turns to it.

use std::f64::consts::{FRAC_PI_2, PI};

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

/// A side: its letter, the way out of it in the world, and the camera's azimuth and elevation that see it.
struct Side {
    letter: &'static str,
    normal: DVec3,
    angles: [f64; 2],
}

/// The world's x is the patient's left, y the head, z the front. Straight from above the vertical has no direction.
const STEEP: f64 = FRAC_PI_2 - 0.01;
const SIDES: [Side; 6] = [
    Side { letter: "A", normal: DVec3::Z, angles: [0.0, 0.0] },
    Side { letter: "P", normal: DVec3::NEG_Z, angles: [PI, 0.0] },
    Side { letter: "L", normal: DVec3::X, angles: [FRAC_PI_2, 0.0] },
    Side { letter: "R", normal: DVec3::NEG_X, angles: [-FRAC_PI_2, 0.0] },
    Side { letter: "H", normal: DVec3::Y, angles: [0.0, STEEP] },
    Side { letter: "F", normal: DVec3::NEG_Y, angles: [0.0, -STEEP] },
];

/// The cube in the view's lower right corner.
pub fn show(ui: &Ui, rect: Rect, state: &mut State) {
    let Some(session) = &state.session else { return };
    if rect.width() < 3.0 * PLACE || rect.height() < 3.0 * PLACE {
        return;
    }
    let place = Rect::from_min_size(rect.right_bottom() - vec2(PLACE + 6.0, PLACE + 6.0), vec2(PLACE, PLACE));
    let response = ui.interact(place, Id::new("cube"), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(WidgetType::Other, true, state.say(Word::Cube)));
    let (painter, p) = (ui.painter_at(place), palette(state.settings.is_dark));
    let camera_from_world = session.camera().world_from_camera.matrix3.transpose();
    let pointer = response.hover_pos();
    let pressed = response.interact_pointer_pos().filter(|_| response.clicked());
    let mut turned = None;
    for side in SIDES {
        let facing = (camera_from_world * side.normal).z;
        if facing < 0.02 {
            continue;
        }
        let corners = corners(place.center(), camera_from_world, side.normal);
        let is_over = pointer.is_some_and(|at| holds(&corners, at));
        let shade = (46.0 + 70.0 * facing) as u8;
        let fill = if is_over { p.accent } else { Color32::from_rgb(shade, shade + 6, shade + 14) };
        let edge = Stroke::new(1.0, Color32::from_black_alpha(200));
        painter.add(Shape::convex_polygon(corners.to_vec(), fill, edge));
        let middle = corners.iter().fold(vec2(0.0, 0.0), |sum, at| sum + at.to_vec2()) / 4.0;
        let font = FontId::proportional(9.0 + 7.0 * facing as f32);
        painter.text(middle.to_pos2(), Align2::CENTER_CENTER, side.letter, font, ON_VIEW);
        if pressed.is_some_and(|at| holds(&corners, at)) {
            turned = Some(side.angles);
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
fn corners(center: Pos2, camera_from_world: DMat3, normal: DVec3) -> [Pos2; 4] {
    let [u, v] = match normal.abs().max_position() {
        0 => [DVec3::Y, DVec3::Z],
        1 => [DVec3::Z, DVec3::X],
        _ => [DVec3::X, DVec3::Y],
    };
    [u + v, v - u, -u - v, u - v].map(|along| {
        let own = camera_from_world * (normal + along);
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
