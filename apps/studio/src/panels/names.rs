//! Names of structures beside the 3D picture, with lines to where they are seen.

use std::collections::BTreeMap;
use std::sync::Arc;

use eframe::egui::{self, Color32, FontId, Galley, Id, Painter, Rect, Sense, Ui, pos2, vec2};
use lumivox_core::glam::DVec3;
use lumivox_core::{PerspectiveCamera, UNLABELLED};
use lumivox_viewport::pick;
use rayon::prelude::*;

use super::cube;
use super::marks;
use super::three_d::Seen;
use crate::leaders::{Point, places};
use crate::overlay::Overlay;
use crate::session::Session;
use crate::state::{Action, State};
use crate::theme::ON_VIEW;

/// Rays across the view by which it is found what is seen.
const RAYS_ACROSS: usize = 56;
/// Of a line of text, with what is left free.
const ROW: f32 = 19.0;
/// From the view's edge, where letters say the patient's sides.
const INSET: f32 = 34.0;
/// Below the view's name, and above its lower edge.
const TOP: f32 = 32.0;
const BOTTOM: f32 = 16.0;
/// The share of the view that a name may take.
const WIDEST: f32 = 0.24;
/// Views that are narrower or lower have no names.
const LEAST: f32 = 280.0;

/// What was seen of structures, and from where.
#[derive(Default)]
pub struct Named {
    /// From where it was looked at last, and whether that is what is known.
    seen_from: Option<SeenFrom>,
    is_known: bool,
    found: Vec<Found>,
}

/// Whether two views show the same.
#[derive(Clone, PartialEq)]
struct SeenFrom {
    version: u64,
    camera: PerspectiveCamera,
    aspect: f32,
}

/// A structure that is seen.
struct Found {
    value: u8,
    name: String,
    color: Color32,
    /// Where it is pointed at, in the world and in the first scan's patient.
    world: DVec3,
    patient_mm: DVec3,
    /// How many rays meet it.
    rays: usize,
}

impl Named {
    /// The names that are shown.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.found.iter().map(|found| found.name.as_str())
    }

    /// Looks anew, once what is seen stays as it is for a frame. Whether that is to come.
    fn follow(&mut self, session: &Session, overlay: &Overlay, rect: Rect) -> bool {
        let (scene, version) = session.scene();
        let aspect = rect.width() / rect.height();
        let now = SeenFrom { version, camera: *session.camera(), aspect };
        if self.seen_from.as_ref() != Some(&now) {
            // Another scene has other structures; those that were seen from elsewhere keep their points until then.
            if self.seen_from.as_ref().is_none_or(|before| before.version != version) {
                self.found.retain(|found| overlay.shows(found.value));
            }
            (self.seen_from, self.is_known) = (Some(now), false);
            return true;
        }
        if !self.is_known {
            self.found = look(scene, &now, overlay);
            self.is_known = true;
        }
        false
    }
}

/// What of structures is seen, by rays through a grid of the view.
fn look(scene: &lumivox_core::Scene, from: &SeenFrom, overlay: &Overlay) -> Vec<Found> {
    let camera = from.camera.with_aspect(f64::from(from.aspect));
    let rows = (RAYS_ACROSS as f32 / from.aspect).ceil().max(1.0) as usize;
    let met = |ray: usize| {
        let at = [ray % RAYS_ACROSS, ray / RAYS_ACROSS].map(|n| n as f64 + 0.5);
        let at = [at[0] / RAYS_ACROSS as f64, at[1] / rows as f64];
        let picked = pick(scene, &camera, at).filter(|picked| picked.volume == 0)?;
        let value = overlay.value_at(picked.patient_mm).filter(|value| *value != UNLABELLED)?;
        Some((value, [at[0] * f64::from(from.aspect), at[1]], picked))
    };
    let rays: Vec<_> = (0..RAYS_ACROSS * rows).into_par_iter().filter_map(met).collect();
    let mut by_value: BTreeMap<u8, Vec<_>> = BTreeMap::new();
    for (value, at, picked) in rays {
        by_value.entry(value).or_default().push((at, picked));
    }
    let found = by_value.into_iter().filter_map(|(value, rays)| {
        let (name, color) = overlay.named(value)?;
        let mean = [0, 1].map(|axis| rays.iter().map(|(at, _)| at[axis]).sum::<f64>() / rays.len() as f64);
        let far = |at: &[f64; 2]| (at[0] - mean[0]).hypot(at[1] - mean[1]);
        // What is bent around something else is pointed at where it is, not in its middle.
        let (_, picked) = rays.iter().min_by(|(a, _), (b, _)| far(a).total_cmp(&far(b)))?;
        let (world, patient_mm) = (picked.world, picked.patient_mm);
        Some(Found { value, name, color, world, patient_mm, rays: rays.len() })
    });
    found.collect()
}

/// The names, where somebody wants them.
pub fn show(ui: &Ui, rect: Rect, state: &mut State) {
    let (Some(session), Some((_, overlay))) = (&state.session, &state.overlay) else {
        return state.named = Named::default();
    };
    if !state.settings.shows_names || rect.width() < LEAST || rect.height() < LEAST {
        return;
    }
    let mut named = std::mem::take(&mut state.named);
    if named.follow(session, overlay, rect) {
        ui.ctx().request_repaint();
    }
    let seen = Seen::of_world(session);
    let visible = |found: &Found| {
        let at = seen.at(found.world, rect).filter(|at| rect.shrink(2.0).contains(*at))?;
        Some(Point { at, weight: found.rays as f64 })
    };
    let (found, points): (Vec<&Found>, Vec<Point>) =
        named.found.iter().filter_map(|found| Some((found, visible(found)?))).unzip();
    let painter = ui.painter_at(rect);
    let mut chosen = None;
    let columns = columns(rect);
    for place in places(&points, columns, ROW) {
        let (own, point) = (found[place.point], points[place.point]);
        let text = fitting(&painter, &own.name, columns[0].width());
        // Level to the column's edge, and from there to the point.
        let (from, bend, x) = if place.is_left {
            let from = columns[0].left() + text.size().x + 5.0;
            (from, (point.at.x - 8.0).min(columns[0].right()).max(from), columns[0].left())
        } else {
            let from = columns[1].right() - text.size().x - 5.0;
            (from, (point.at.x + 8.0).max(columns[1].left()).min(from), columns[1].right() - text.size().x)
        };
        let line = [pos2(from, place.y), pos2(bend, place.y), point.at];
        let box_of = Rect::from_min_size(pos2(x, place.y - 0.5 * text.size().y), text.size());
        let response = ui.interact(box_of.expand(2.0), Id::new(("name", own.value)), Sense::click());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Link, true, &own.name));
        if response.clicked() {
            chosen = Some(own.patient_mm);
        }
        marks::line(&painter, line.into(), own.color.gamma_multiply(0.9));
        marks::point(&painter, point.at, own.color);
        painter.galley(box_of.min + vec2(1.0, 1.0), text.clone(), Color32::PLACEHOLDER);
        let color = if response.hovered() || response.has_focus() { own.color } else { ON_VIEW };
        painter.galley_with_override_text_color(box_of.min, text, color);
    }
    state.named = named;
    if let Some(point) = chosen {
        state.act(Action::Cross(point));
    }
}

/// Where names may stand: not over the patient's sides, the view's name and the cube.
fn columns(rect: Rect) -> [Rect; 2] {
    let width = WIDEST * rect.width();
    let [low, high] = [rect.top() + TOP, rect.bottom() - BOTTOM];
    let above_cube = cube::place(rect).map_or(high, |cube| cube.top() - 4.0);
    [
        Rect::from_min_max(pos2(rect.left() + INSET, low), pos2(rect.left() + INSET + width, high)),
        Rect::from_min_max(
            pos2(rect.right() - INSET - width, low),
            pos2(rect.right() - INSET, above_cube.max(low)),
        ),
    ]
}

/// A name as it fits, shortened where it does not. Its own colour is that of its shadow.
fn fitting(painter: &Painter, name: &str, width: f32) -> Arc<Galley> {
    let shadow = Color32::from_black_alpha(190);
    let mut job =
        egui::text::LayoutJob::simple_singleline(name.to_owned(), FontId::proportional(13.0), shadow);
    job.wrap = egui::text::TextWrapping::truncate_at_width(width);
    painter.layout_job(job)
}
