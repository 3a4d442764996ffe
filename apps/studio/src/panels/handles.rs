//! Handles of cuts in the 3D view: faces of boxes, depth and tilt of planes, centre and radius of balls are dragged where they are seen.

use eframe::egui::{self, Color32, CursorIcon, Id, Painter, Pos2, Rect, Sense, Stroke, Ui, Vec2, vec2};
use lumivox_core::ClipKind;
use lumivox_core::document::{Shape, affine, rows};
use lumivox_core::glam::{DAffine3, DVec3};

use super::cut::{plane, put, put_box, shapes};
use super::look::entry;
use super::marks;
use super::three_d::Seen;
use crate::slices::ellipse;
use crate::state::{State, Tab};
use crate::words::Word;

/// Of cuts in pictures.
const COLOR: Color32 = Color32::from_rgb(0xff, 0xb0, 0x5c);
/// What is kept is at least so large, as a share of the scan and in mm.
const LEAST_SHARE: f64 = 0.02;
const LEAST_MM: f64 = 2.0;

/// What handles need to know of the view.
struct View<'a> {
    ui: &'a Ui,
    rect: Rect,
    painter: Painter,
    /// How mm of the world are seen.
    seen: Seen,
    name: &'static str,
    count: usize,
}

/// How a handle was dragged.
struct Dragged {
    /// Where it is wanted, and how far from where it is.
    to: Pos2,
    by: Vec2,
    /// How far the pointer went since the frame before.
    pointer: Vec2,
}

impl View<'_> {
    /// A handle at a point; how it was dragged, where it was. It keeps its place under the pointer, wherever it was taken.
    fn handle(&mut self, point: DVec3, id: (&str, usize, usize)) -> Option<Dragged> {
        self.count += 1;
        let at = self.seen.at(point, self.rect).filter(|at| self.rect.shrink(4.0).contains(*at))?;
        let place = Rect::from_center_size(at, vec2(18.0, 18.0));
        let response = self.ui.interact(place, Id::new(("cut", id)), Sense::drag());
        let name = format!("{} {}", self.name, self.count);
        response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Other, true, &name));
        let is_held = response.hovered() || response.dragged() || response.has_focus();
        marks::handle(&self.painter, at, COLOR, is_held);
        if let Some(by) = marks::nudged(self.ui, &response) {
            return Some(Dragged { to: at + by, by, pointer: by });
        }
        let taken = Id::new(("cut taken", id));
        if response.drag_started()
            && let Some(from) = self.ui.input(|input| input.pointer.press_origin())
        {
            self.ui.data_mut(|data| data.insert_temp(taken, from - at));
        }
        let pointer = response.drag_delta();
        let to = response.interact_pointer_pos();
        let is_dragged = response.dragged() && pointer != Vec2::ZERO;
        response.on_hover_cursor(CursorIcon::Grab);
        let off = self.ui.data(|data| data.get_temp::<Vec2>(taken)).unwrap_or_default();
        to.filter(|_| is_dragged).map(|to| Dragged { to: to - off, by: to - off - at, pointer })
    }

    /// How far along an axis of the world a drag goes, in parts of the axis: what of it runs along the axis as that is seen. An axis
    /// that points at the eye is not dragged.
    fn along(&self, point: DVec3, axis: DVec3, by: Vec2) -> Option<f64> {
        const SMALL: f64 = 0.05;
        let (from, to) = (self.seen.at(point, self.rect)?, self.seen.at(point + axis * SMALL, self.rect)?);
        let seen = (to - from) / SMALL as f32;
        (seen.length() >= 4.0).then(|| f64::from(by.dot(seen) / seen.length_sq()))
    }

    fn line(&self, points: impl IntoIterator<Item = DVec3>) {
        let points: Vec<Pos2> =
            points.into_iter().filter_map(|point| self.seen.at(point, self.rect)).collect();
        self.painter.add(egui::Shape::line(points.clone(), Stroke::new(2.4, Color32::from_black_alpha(120))));
        self.painter.add(egui::Shape::line(points, Stroke::new(1.1, COLOR)));
    }

    /// The edges of a cube from -1 to 1 that was placed.
    fn edges(&self, placed: DAffine3) {
        let corner = |i: usize| {
            let at = |axis: usize| if i >> axis & 1 == 1 { 1.0 } else { -1.0 };
            placed.transform_point3(DVec3::new(at(0), at(1), at(2)))
        };
        for i in 0..8 {
            for axis in (0..3).filter(|axis| i >> axis & 1 == 0) {
                self.line([corner(i), corner(i | 1 << axis)]);
            }
        }
    }
}

/// All handles, while cuts are what the panel is about.
pub fn show(ui: &Ui, rect: Rect, state: &mut State) {
    let Some(session) = &state.session else { return };
    if state.tab != Tab::Cut {
        return;
    }
    let seen = Seen::of_world_mm(session);
    let name = state.say(Word::CutHandle);
    let mut view = View { ui, rect, painter: ui.painter_at(rect), seen, name, count: 0 };
    kept_box(&mut view, state);
    for (index, shape) in shapes(state).into_iter().enumerate() {
        let (word, changed) = match shape.kind {
            ClipKind::Plane => (Word::Plane, plane_handles(&mut view, state, index, shape)),
            ClipKind::Box => (Word::Box, box_handles(&mut view, index, shape)),
            ClipKind::Sphere => (Word::Sphere, sphere_handles(&mut view, state, index, shape)),
        };
        if changed.is_some() {
            put(state, word, index, changed);
        }
    }
}

/// The box along the scan's sides.
fn kept_box(view: &mut View<'_>, state: &mut State) {
    let Some(session) = &state.session else { return };
    let Some(first) = session.scene().0.volumes.first() else { return };
    let placed = DAffine3::from_scale(DVec3::splat(1e3))
        * first.world_from_patient
        * session.scan().patient_from_box();
    let Some(clip) = entry(state).map(|entry| entry.clip.unwrap_or([[0.0; 3], [1.0; 3]])) else { return };
    let [low, high] = clip.map(DVec3::from_array);
    let (center, half) = (0.5 * (low + high), 0.5 * (high - low));
    view.edges(placed * DAffine3::from_translation(center) * DAffine3::from_scale(half));
    let mut changed = clip;
    for axis in 0..3 {
        for end in 0..2 {
            let mut at = center;
            at[axis] = clip[end][axis];
            let point = placed.transform_point3(at);
            let along = placed.matrix3.col(axis);
            if let Some(dragged) = view.handle(point, ("side", axis, end)) {
                let wanted = clip[end][axis] + view.along(point, along, dragged.by).unwrap_or(0.0);
                changed[end][axis] = match end {
                    0 => wanted.clamp(0.0, clip[1][axis] - LEAST_SHARE),
                    _ => wanted.clamp(clip[0][axis] + LEAST_SHARE, 1.0),
                };
            }
        }
    }
    if changed != clip {
        put_box(state, Word::Cut, changed);
    }
}

/// The middle of a plane goes along its normal; the end of its arrow tilts it.
fn plane_handles(view: &mut View<'_>, state: &State, index: usize, shape: Shape) -> Option<Shape> {
    let size = state.session.as_ref()?.scan().size_mm().length();
    let placed = affine(shape.from_shape);
    let (point, normal) = (placed.translation, placed.matrix3.z_axis.normalize_or(DVec3::Z));
    let (u, v) = normal.any_orthonormal_pair();
    view.line(ellipse(point, u * 0.28 * size, v * 0.28 * size));
    // Towards what is cut away, where nothing hides it.
    let arrow = if shape.inverted { normal } else { -normal } * 0.2 * size;
    view.line([point, point + arrow]);
    if let Some(dragged) = view.handle(point, ("plane", index, 0)) {
        // Where it faces the eye, down is deeper.
        let faced = || f64::from(dragged.pointer.y / view.rect.height());
        let moved = view.along(point, normal * size, dragged.by).unwrap_or_else(faced) * size;
        return Some(Shape { inverted: shape.inverted, ..plane(point + normal * moved, normal) });
    }
    let dragged = view.handle(point + arrow, ("plane", index, 1))?;
    let tip = view.seen.point(dragged.to, view.rect, point + arrow);
    let tilted = (tip - point).normalize_or(normal);
    let tilted = if shape.inverted { tilted } else { -tilted };
    Some(Shape { inverted: shape.inverted, ..plane(point, tilted) })
}

fn box_handles(view: &mut View<'_>, index: usize, shape: Shape) -> Option<Shape> {
    let placed = affine(shape.from_shape);
    view.edges(placed);
    let mut changed = None;
    for axis in 0..3 {
        for (end, sign) in [-1.0, 1.0].into_iter().enumerate() {
            let half = placed.matrix3.col(axis) * sign;
            let point = placed.translation + half;
            if let Some(dragged) = view.handle(point, ("box", index, 2 * axis + end)) {
                let least = LEAST_MM / half.length() - 2.0;
                // The other face stays.
                let grown = view.along(point, half, dragged.by).unwrap_or(0.0).max(least);
                let mut new = placed;
                new.translation += half * 0.5 * grown;
                *new.matrix3.col_mut(axis) = placed.matrix3.col(axis) * (1.0 + 0.5 * grown);
                changed = Some(Shape { from_shape: rows(new), ..shape });
            }
        }
    }
    if let Some(dragged) = view.handle(placed.translation, ("box", index, 6)) {
        let to = view.seen.point(dragged.to, view.rect, placed.translation);
        let new = DAffine3::from_mat3_translation(placed.matrix3, to);
        changed = Some(Shape { from_shape: rows(new), ..shape });
    }
    changed
}

fn sphere_handles(view: &mut View<'_>, state: &State, index: usize, shape: Shape) -> Option<Shape> {
    let axes = state.session.as_ref()?.camera().world_from_camera.matrix3;
    let placed = affine(shape.from_shape);
    let (center, radius) = (placed.translation, placed.matrix3.x_axis.length());
    view.line(ellipse(center, axes.x_axis * radius, axes.y_axis * radius));
    let edge = center + axes.x_axis * radius;
    let ball = |center: DVec3, radius: f64| {
        let new = DAffine3::from_translation(center) * DAffine3::from_scale(DVec3::splat(radius));
        Some(Shape { from_shape: rows(new), ..shape })
    };
    if let Some(dragged) = view.handle(center, ("ball", index, 0)) {
        return ball(view.seen.point(dragged.to, view.rect, center), radius);
    }
    let dragged = view.handle(edge, ("ball", index, 1))?;
    ball(center, view.seen.point(dragged.to, view.rect, edge).distance(center).max(LEAST_MM))
}
