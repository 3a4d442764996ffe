//! What is cut away: a box along the scan's sides, what lies near the skin, planes, boxes and balls as they lie in the world, and what a
//! lasso was drawn around.

use eframe::egui::{RichText, Slider, Ui};
use lumivox_core::document::{Entry, Rows, Shape, Space, affine, rows};
use lumivox_core::glam::{DAffine3, DMat3, DVec3};
use lumivox_core::{ClipKind, MOST_CLIP_SHAPES, placement};

use super::lasso;
use super::look::{entry, slider};
use crate::session::Session;
use crate::state::State;
use crate::theme::palette;
use crate::words::Word;

/// All cuts.
pub fn show(ui: &mut Ui, state: &mut State) {
    let p = palette(state.settings.is_dark);
    ui.label(RichText::new(state.say(Word::CutHint)).small().color(p.weak));
    sides(ui, state);
    peel(ui, state);
    ui.add_space(4.0);
    for index in 0..shapes(state).len() {
        shape(ui, state, index);
    }
    add(ui, state);
    lasso::list(ui, state);
    let is_cut = entry(state).is_some_and(|entry| {
        let is_peeled = entry.peel.is_some_and(|mm| mm > 0.0);
        is_peeled || entry.clip.is_some() || !entry.clip_shapes.is_empty() || !entry.lassos.is_empty()
    });
    if is_cut && ui.button(state.say(Word::CutNothing)).clicked() {
        state.change(Word::CutNothing, |document| {
            for entry in &mut document.volumes {
                (entry.clip, entry.peel) = (None, None);
                entry.clip_shapes.clear();
                entry.lassos.clear();
            }
        });
    }
}

/// Six sliders, one from each side.
fn sides(ui: &mut Ui, state: &mut State) {
    let Some(session) = &state.session else { return };
    let scan = session.scan().clone();
    let Some(clip) = entry(state).map(|entry| entry.clip) else { return };
    let whole = [DVec3::ZERO, DVec3::ONE];
    let own = clip.map_or(whole, |[low, high]| [DVec3::from_array(low), DVec3::from_array(high)]);
    // Left, head and front are where x, y and z grow.
    let [mut low, mut high] = placement::node_clip(&scan, own);
    let before = [low, high];
    let sides = [
        (Word::CutFront, 2, true),
        (Word::CutBack, 2, false),
        (Word::CutRight, 0, false),
        (Word::CutLeft, 0, true),
        (Word::CutHead, 1, true),
        (Word::CutFeet, 1, false),
    ];
    let mut what = Word::Cut;
    for (word, axis, from_high) in sides {
        let mut percent = 100.0 * if from_high { 1.0 - high[axis] } else { low[axis] };
        let bar = Slider::new(&mut percent, 0.0..=98.0).fixed_decimals(0).suffix(" %");
        if slider(ui, state.say(word), bar) {
            what = word;
            let room = 0.02;
            if from_high {
                high[axis] = (1.0 - percent / 100.0).max(low[axis] + room);
            } else {
                low[axis] = (percent / 100.0).min(high[axis] - room);
            }
        }
    }
    if [low, high] != before {
        let kept = placement::clip_box(&scan, low, high).map(|corner| corner.to_array());
        put_box(state, what, kept);
    }
}

/// Millimetres that are taken off from the skin at most. What lies deeper is for planes and boxes.
const DEEPEST_PEEL: f64 = 30.0;

/// How deep below the skin the picture begins. Skin is found in CTs alone.
fn peel(ui: &mut Ui, state: &mut State) {
    let Some(session) = &state.session else { return };
    let scan = session.scan();
    if !scan.is_hounsfield() && !scan.may_be_hounsfield() {
        return;
    }
    let Some(peel) = entry(state).map(|entry| entry.peel.unwrap_or(0.0)) else { return };
    let mut mm = peel;
    let bar = Slider::new(&mut mm, 0.0..=DEEPEST_PEEL.max(peel)).step_by(0.5).suffix(" mm");
    let response = ui.scope(|ui| slider(ui, state.say(Word::Peel), bar));
    response.response.on_hover_text(state.say(Word::PeelHint));
    if response.inner {
        state.change(Word::Peel, |document| {
            document.volumes.iter_mut().take(1).for_each(|entry| entry.peel = (mm > 0.0).then_some(mm));
        });
    }
}

/// What is kept of the first scan, in fractions along its axes. Scans of one place are cut alike only where they fill the same box:
/// the others stay whole.
pub fn put_box(state: &mut State, what: Word, kept: [[f64; 3]; 2]) {
    let kept = (kept != [[0.0; 3], [1.0; 3]]).then_some(kept);
    state.change(what, |document| {
        if let Some(entry) = document.volumes.first_mut() {
            entry.clip = kept;
        }
    });
}

fn is_own(shape: &Shape) -> bool {
    shape.space == Space::World
}

/// The shapes that this panel and the handles are for: those in the world's space.
pub fn shapes(state: &State) -> Vec<Shape> {
    entry(state)
        .map_or(vec![], |entry: &Entry| entry.clip_shapes.iter().filter(|it| is_own(it)).copied().collect())
}

/// Changes one of these shapes or takes it away, in all scans that it cuts: they lie in one world.
pub fn put(state: &mut State, what: Word, index: usize, shape: Option<Shape>) {
    let Some(before) = shapes(state).get(index).copied() else { return };
    state.change(what, |document| {
        for (number, entry) in document.volumes.iter_mut().enumerate() {
            let cuts = &mut entry.clip_shapes;
            let own = (0..cuts.len()).filter(|place| is_own(&cuts[*place])).nth(index);
            // Another scan may have others, or fewer.
            let same = || cuts.iter().position(|cut| *cut == before);
            let Some(place) = (if number == 0 { own } else { same() }) else { continue };
            match shape {
                Some(shape) => cuts[place] = shape,
                None => _ = cuts.remove(place),
            }
        }
    });
}

/// A plane in mm of the world that keeps what lies along `normal`.
pub fn plane(point: DVec3, normal: DVec3) -> Shape {
    let (u, v) = normal.any_orthonormal_pair();
    let turn = DMat3::from_cols(u, v, normal);
    let turn = if turn.determinant() < 0.0 { DMat3::from_cols(v, u, normal) } else { turn };
    let from_shape: Rows = rows(DAffine3::from_mat3_translation(turn, point));
    Shape { kind: ClipKind::Plane, from_shape, space: Space::World, inverted: false }
}

fn add(ui: &mut Ui, state: &mut State) {
    let Some(session) = &state.session else { return };
    let (center, size) = (session.center() * 1e3, session.scan().size_mm());
    let point = in_world(session, state.cross);
    let forward = (-session.camera().world_from_camera.matrix3.z_axis).normalize_or(DVec3::NEG_Z);
    let solid = |kind, half: f64, at, inverted| {
        let from_shape = rows(DAffine3::from_translation(at) * DAffine3::from_scale(DVec3::splat(half)));
        Shape { kind, from_shape, space: Space::World, inverted }
    };
    let new = [
        (Word::PlaneAdd, plane(point, forward)),
        (Word::BoxAdd, solid(ClipKind::Box, 0.36 * size.min_element(), center, false)),
        (Word::SphereAdd, solid(ClipKind::Sphere, 0.2 * size.min_element(), point, true)),
    ];
    let count = shapes(state).len();
    for (word, shape) in new {
        if ui.add_enabled(count < MOST_CLIP_SHAPES, eframe::egui::Button::new(state.say(word))).clicked() {
            // All scans of the scene are cut.
            state.change(word, |document| {
                document.volumes.iter_mut().for_each(|entry| entry.clip_shapes.push(shape));
            });
        }
    }
}

/// A point of the first scan's patient in the world, in mm.
fn in_world(session: &Session, patient_mm: DVec3) -> DVec3 {
    let first = session.scene().0.volumes.first();
    first.map_or(DVec3::ZERO, |it| it.world_from_patient.transform_point3(patient_mm)) * 1e3
}

/// A shape's row: what it is, how deep a plane lies, and what becomes of it.
fn shape(ui: &mut Ui, state: &mut State, index: usize) {
    let Some(shape) = shapes(state).get(index).copied() else { return };
    let (word, offset) = match shape.kind {
        ClipKind::Plane => (Word::Plane, true),
        ClipKind::Box => (Word::Box, false),
        ClipKind::Sphere => (Word::Sphere, false),
    };
    let Some(session) = &state.session else { return };
    if offset {
        let (center, reach) = (session.center() * 1e3, 0.5 * session.scan().size_mm().length());
        let from_shape = affine(shape.from_shape);
        let (point, normal) = (from_shape.translation, from_shape.matrix3.z_axis.normalize_or(DVec3::Z));
        let before = (point - center).dot(normal);
        let mut offset = before;
        let bar = Slider::new(&mut offset, -reach..=reach).fixed_decimals(0).suffix(" mm");
        if slider(ui, &format!("{} {}", state.say(word), index + 1), bar) {
            let moved =
                Shape { inverted: shape.inverted, ..plane(point + normal * (offset - before), normal) };
            put(state, word, index, Some(moved));
        }
    }
    ui.horizontal(|ui| {
        if !offset {
            ui.label(format!("{} {}", state.say(word), index + 1));
        }
        if ui.button(state.say(Word::CutFlip)).clicked() {
            put(state, Word::CutFlip, index, Some(Shape { inverted: !shape.inverted, ..shape }));
        }
        if ui.button(state.say(Word::CutRemove)).clicked() {
            put(state, Word::CutRemove, index, None);
        }
    });
}
