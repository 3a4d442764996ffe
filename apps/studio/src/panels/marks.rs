//! What is written and drawn over pictures: letters of the patient's sides, a scale, the other planes, the shared point.

use eframe::egui::{
    self, Align2, Color32, CornerRadius, EventFilter, FontId, Key, Modifiers, Painter, Pos2, Rect, Response,
    Stroke, Ui, Vec2, pos2, vec2,
};

use crate::slices::Plane;
use crate::theme::ON_VIEW;

/// The colour of a plane, wherever its line or its name is.
pub fn color_of(plane: Plane) -> Color32 {
    match plane {
        Plane::Axial => Color32::from_rgb(0xf0, 0x7b, 0x6c),
        Plane::Coronal => Color32::from_rgb(0x7f, 0xc9, 0x7a),
        Plane::Sagittal => Color32::from_rgb(0xf0, 0xc9, 0x5e),
        Plane::Oblique => Color32::from_rgb(0xb9, 0x8d, 0xf0),
    }
}

/// A view's name, in its corner.
pub fn title(painter: &Painter, rect: Rect, name: &str, color: Color32) {
    shadowed(painter, rect.min + vec2(10.0, 8.0), Align2::LEFT_TOP, name, FontId::proportional(13.0), color);
}

/// Left, right, top and bottom.
pub fn edge_letters(painter: &Painter, rect: Rect, [left, right, top, bottom]: &[String; 4]) {
    let font = FontId::proportional(14.0);
    let edges = [
        (rect.left_center() + vec2(8.0, 0.0), Align2::LEFT_CENTER, left),
        (rect.right_center() - vec2(8.0, 0.0), Align2::RIGHT_CENTER, right),
        (rect.center_top() + vec2(0.0, 7.0), Align2::CENTER_TOP, top),
        (rect.center_bottom() - vec2(0.0, 7.0), Align2::CENTER_BOTTOM, bottom),
    ];
    for (at, align, letter) in edges {
        shadowed(painter, at, align, letter, font.clone(), ON_VIEW);
    }
}

/// A length that is round, about a fifth of the view.
pub fn scale_bar(painter: &Painter, rect: Rect, mm_per_point: f32) {
    const LENGTHS: [f32; 9] = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0];
    let wanted = rect.width() * 0.22 * mm_per_point;
    let Some(mm) = LENGTHS.into_iter().rev().find(|mm| *mm <= wanted) else { return };
    let start = rect.left_bottom() + vec2(12.0, -12.0);
    let end = start + vec2(mm / mm_per_point, 0.0);
    for (width, color) in [(3.5, Color32::from_black_alpha(150)), (1.5, ON_VIEW)] {
        painter.line_segment([start, end], Stroke::new(width, color));
    }
    let words = if mm >= 10.0 { format!("{} cm", mm / 10.0) } else { format!("{mm} mm") };
    let font = FontId::proportional(11.5);
    shadowed(painter, start - vec2(0.0, 5.0), Align2::LEFT_BOTTOM, &words, font, ON_VIEW);
}

/// Letters that are read on black and on white.
pub fn shadowed(painter: &Painter, at: Pos2, align: Align2, text: &str, font: FontId, color: Color32) {
    painter.text(at + vec2(1.0, 1.0), align, text, font.clone(), Color32::from_black_alpha(190));
    painter.text(at, align, text, font, color);
}

/// Lines of words on a plate of their own, to the right of a place; within the view.
pub fn plate(painter: &Painter, rect: Rect, at: Pos2, lines: &[String], color: Color32) {
    let font = FontId::proportional(12.5);
    let text = lines.join("\n");
    let galley = painter.layout_no_wrap(text, font, color);
    let own =
        Rect::from_min_size(at + vec2(15.0, -0.5 * galley.size().y), galley.size()).expand2(vec2(5.0, 2.0));
    let room = rect.shrink(4.0);
    let inside = |low: f32, high: f32, from: f32, to: f32| (from - low).max(0.0) + (to - high).min(0.0);
    let by = vec2(
        inside(own.left(), own.right(), room.left(), room.right()),
        inside(own.top(), own.bottom(), room.top(), room.bottom()),
    );
    // Where there is no room beside it, it stands below.
    let below = if by.x < 0.0 { 0.5 * own.height() + 14.0 } else { 0.0 };
    let own = own.translate(by + vec2(0.0, below));
    painter.rect_filled(own, CornerRadius::same(4), Color32::from_black_alpha(200));
    painter.galley(own.min + vec2(5.0, 2.0), galley, color);
}

/// A line that is read on black and on white.
pub fn line(painter: &Painter, points: Vec<Pos2>, color: Color32) {
    painter.add(egui::Shape::line(points.clone(), Stroke::new(3.2, Color32::from_black_alpha(140))));
    painter.add(egui::Shape::line(points, Stroke::new(1.6, color)));
}

/// A closed line of dashes: what a cut leaves.
pub fn dashed(painter: &Painter, mut corners: Vec<Pos2>) {
    let line = Stroke::new(1.0, ON_VIEW.gamma_multiply(0.7));
    corners.extend(corners.first().copied());
    painter.extend(egui::Shape::dashed_line(&corners, line, 5.0, 4.0));
}

/// The line of another plane through the shared point, in its colour, open where it is.
pub fn plane_line(painter: &Painter, rect: Rect, at: Pos2, along: Vec2, plane: Plane) {
    const OPEN: f32 = 9.0;
    let far = rect.width() + rect.height();
    let stroke = Stroke::new(1.0, color_of(plane).gamma_multiply(0.75));
    for end in [along, -along] {
        painter.line_segment([at + end * OPEN, at + end * far], stroke);
    }
}

/// The shared point in the 3D view: a ring, for it lies inside.
pub fn mark(painter: &Painter, at: Pos2, color: Color32) {
    painter.circle_stroke(at, 7.0, Stroke::new(2.5, Color32::from_black_alpha(140)));
    painter.circle_stroke(at, 7.0, Stroke::new(1.2, color));
    painter.circle_filled(at, 1.5, color);
}

/// What a line of a name ends at.
pub fn point(painter: &Painter, at: Pos2, color: Color32) {
    painter.circle_filled(at, 3.5, Color32::from_black_alpha(150));
    painter.circle_filled(at, 2.4, color);
}

/// A thing that is dragged in a picture.
pub fn handle(painter: &Painter, at: Pos2, color: Color32, is_hovered: bool) {
    let radius = if is_hovered { 6.5 } else { 5.0 };
    painter.circle_filled(at, radius + 1.5, Color32::from_black_alpha(150));
    painter.circle_filled(at, radius, color);
    if is_hovered {
        painter.circle_filled(at, 2.0, Color32::from_black_alpha(200));
    }
}

/// How far keys move a thing that has the focus: a point, or ten with Shift.
pub fn nudged(ui: &Ui, response: &Response) -> Option<Vec2> {
    if !response.has_focus() {
        return None;
    }
    // Else arrows would take the focus elsewhere.
    let filter = EventFilter { horizontal_arrows: true, vertical_arrows: true, ..EventFilter::default() };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
    let ways = [
        (Key::ArrowLeft, vec2(-1.0, 0.0)),
        (Key::ArrowRight, vec2(1.0, 0.0)),
        (Key::ArrowUp, vec2(0.0, -1.0)),
        (Key::ArrowDown, vec2(0.0, 1.0)),
    ];
    let by = ui.input_mut(|input| {
        ways.into_iter().fold(Vec2::ZERO, |by, (key, way)| {
            let far = input.count_and_consume_key(Modifiers::SHIFT, key) as f32 * 10.0;
            by + way * (far + input.count_and_consume_key(Modifiers::NONE, key) as f32)
        })
    });
    (by != Vec2::ZERO).then_some(by)
}

/// How far the picture is, at the bottom of the view.
pub fn progress(painter: &Painter, rect: Rect, part: f32, color: Color32) {
    let end = rect.left_bottom() + vec2(rect.width() * part, 0.0);
    painter.line_segment([rect.left_bottom(), pos2(end.x, end.y)], Stroke::new(3.0, color));
}
