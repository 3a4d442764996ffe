//! How the scan looks: tiles of looks, light and colour, cuts, and what the camera frames.

use eframe::egui::{self, Color32, Rect, RichText, Sense, Slider, Stroke, StrokeKind, Ui, vec2};
use lumivox_core::document::{Entry, Keep, Rows, Shape, Space, affine, rows};
use lumivox_core::glam::{DAffine3, DMat3, DVec3};
use lumivox_core::{ClipKind, Preset, Volume, placement};

use crate::session::Session;
use crate::state::{Action, State};
use crate::theme::{RADIUS, VIEW_GROUND, palette};
use crate::words::{self, Word};

/// Tiles beside each other.
const COLUMNS: usize = 4;

/// The room of a tile's name.
const NAME: f32 = 19.0;

/// The whole panel.
pub fn show(ui: &mut Ui, state: &mut State) {
    egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 6.0;
        heading(ui, state, Word::Looks);
        tiles(ui, state);
        everything(ui, state);
        heading(ui, state, Word::Light);
        light(ui, state);
        heading(ui, state, Word::Cut);
        cuts(ui, state);
        heading(ui, state, Word::Camera);
        camera(ui, state);
        ui.add_space(10.0);
    });
}

fn heading(ui: &mut Ui, state: &State, word: Word) {
    let p = palette(state.settings.is_dark);
    ui.add_space(8.0);
    ui.label(RichText::new(state.say(word)).strong().size(14.5).color(p.text));
}

fn entry(state: &State) -> Option<&Entry> {
    state.session.as_ref()?.document().volumes.first()
}

fn tiles(ui: &mut Ui, state: &mut State) {
    let chosen = entry(state).and_then(|entry| entry.look.preset);
    let mut looks = state.looks.clone();
    // A scene's file may have one of another kind.
    looks.extend(chosen.filter(|chosen| !looks.contains(chosen)));
    let gap = 6.0;
    let side = ((ui.available_width() - gap * (COLUMNS - 1) as f32) / COLUMNS as f32).floor();
    // Two rows and a part of the third, which says that there are more.
    let height = 2.6 * (side + NAME + gap);
    egui::ScrollArea::vertical().id_salt("looks").max_height(height).auto_shrink([false, true]).show(
        ui,
        |ui| {
            egui::Grid::new("looks").num_columns(COLUMNS).spacing(vec2(gap, gap)).show(ui, |ui| {
                for (place, preset) in looks.into_iter().enumerate() {
                    tile(ui, state, preset, chosen == Some(preset), side);
                    if place % COLUMNS == COLUMNS - 1 {
                        ui.end_row();
                    }
                }
            });
        },
    );
}

fn tile(ui: &mut Ui, state: &mut State, preset: Preset, is_chosen: bool, side: f32) {
    let p = palette(state.settings.is_dark);
    let name = words::look(preset).map_or(preset.name(), |word| state.say(word));
    let (rect, response) = ui.allocate_exact_size(vec2(side, side + NAME), Sense::click());
    response
        .widget_info(|| egui::WidgetInfo::selected(egui::WidgetType::SelectableLabel, true, is_chosen, name));
    let picture = Rect::from_min_size(rect.min, vec2(side, side));
    ui.painter().rect_filled(picture, RADIUS, VIEW_GROUND);
    match state.tiles.get(&preset) {
        Some(texture) => {
            egui::Image::new((texture.id(), picture.size())).corner_radius(RADIUS).paint_at(ui, picture);
        }
        None => {
            let center = picture.center();
            for x in [-8.0, 0.0, 8.0] {
                ui.painter().circle_filled(center + vec2(x, 0.0), 1.8, Color32::from_gray(90));
            }
        }
    }
    let line = match (is_chosen, response.hovered() || response.has_focus()) {
        (true, _) => Stroke::new(2.0, p.accent),
        (false, true) => Stroke::new(1.5, p.weak),
        (false, false) => Stroke::NONE,
    };
    ui.painter().rect_stroke(picture, RADIUS, line, StrokeKind::Inside);
    let color = if is_chosen { p.text } else { p.weak };
    let galley = ui.painter().layout_no_wrap(name.to_owned(), egui::FontId::proportional(11.0), color);
    let shown = galley.size().x.min(side);
    let at = egui::pos2(picture.center().x - shown / 2.0, picture.bottom() + 3.0);
    ui.painter().with_clip_rect(rect).galley(at, galley, color);
    if response.clone().on_hover_text(preset.description()).clicked() {
        state.act(Action::Look(preset));
    }
}

fn everything(ui: &mut Ui, state: &mut State) {
    let Some(keep) = entry(state).map(|entry| entry.scan.keep) else { return };
    let mut all = keep == Keep::Everything;
    let (word, hint) = (state.say(Word::Everything), state.say(Word::EverythingHint));
    if ui.checkbox(&mut all, word).on_hover_text(hint).changed() {
        let keep = if all { Keep::Everything } else { Keep::Patient };
        state.change(Word::Everything, |document| {
            document.volumes.iter_mut().for_each(|entry| entry.scan.keep = keep);
        });
    }
}

/// The room of a slider's number, with the gap before it.
const NUMBER: f32 = 78.0;

/// A slider with its name before it, in a row; true when it was moved.
fn slider(ui: &mut Ui, name: &str, slider: Slider<'_>) -> bool {
    ui.horizontal(|ui| {
        let left = egui::Layout::left_to_right(egui::Align::Center);
        let words = egui::Label::new(RichText::new(name).size(13.0)).truncate();
        let label = ui.allocate_ui_with_layout(vec2(96.0, 22.0), left, |ui| {
            ui.set_min_width(96.0);
            ui.add(words)
        });
        // What is left beside the number.
        let room = ui.available_width() - NUMBER;
        ui.spacing_mut().interact_size = vec2(NUMBER - 8.0, 22.0);
        ui.spacing_mut().slider_width = room.max(60.0);
        ui.add(slider).labelled_by(label.inner.id).changed()
    })
    .inner
}

fn light(ui: &mut Ui, state: &mut State) {
    let Some(session) = &state.session else { return };
    let mut exposure = session.document().display.exposure;
    let stops = format!(" {}", state.say(Word::Stops));
    let bar = Slider::new(&mut exposure, -4.0..=4.0).fixed_decimals(1).suffix(stops);
    if slider(ui, state.say(Word::Exposure), bar) {
        state.change(Word::Exposure, |document| document.display.exposure = exposure);
    }
    let Some(session) = &state.session else { return };
    let reach = shift_range(session.scan());
    let Some(look) = entry(state).map(|entry| entry.look.clone()) else { return };
    let mut shift = look.shift.unwrap_or(0.0);
    let bar = Slider::new(&mut shift, -reach..=reach).fixed_decimals(if reach > 20.0 { 0 } else { 2 });
    if slider(ui, state.say(Word::Shift), bar) {
        state.change(Word::Shift, |document| {
            if let Some(entry) = document.volumes.first_mut() {
                (entry.look.shift, entry.look.window) = ((shift != 0.0).then_some(shift), None);
            }
        });
    }
    let mut width = look.window_scale.unwrap_or(1.0);
    let bar = Slider::new(&mut width, 0.2..=5.0).logarithmic(true).fixed_decimals(2).suffix("\u{d7}");
    if slider(ui, state.say(Word::Width), bar) {
        state.change(Word::Width, |document| {
            if let Some(entry) = document.volumes.first_mut() {
                (entry.look.window_scale, entry.look.window) = ((width != 1.0).then_some(width), None);
            }
        });
    }
}

/// How far a look can be moved: over what tissues differ by in a CT, else over most of the values.
fn shift_range(scan: &Volume) -> f64 {
    if scan.is_hounsfield() {
        return 500.0;
    }
    let [low, high] = scan.value_range();
    (0.5 * (high - low)).max(1e-6)
}

fn cuts(ui: &mut Ui, state: &mut State) {
    let Some(session) = &state.session else { return };
    let scan = session.scan().clone();
    let Some((clip, plane)) = entry(state).map(|entry| (entry.clip, plane_of(entry).copied())) else {
        return;
    };
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
        let kept = placement::clip_box(&scan, low, high);
        let kept = (kept != whole).then(|| kept.map(|corner| corner.to_array()));
        state.change(what, |document| {
            // Scans of one place are cut alike only where they fill the same box: the others stay whole.
            if let Some(entry) = document.volumes.first_mut() {
                entry.clip = kept;
            }
        });
    }
    match plane {
        Some(shape) => plane_controls(ui, state, shape),
        None => {
            if ui.button(state.say(Word::PlaneAdd)).clicked()
                && let Some(shape) = state.session.as_ref().map(|session| facing(session, state.cross))
            {
                change_plane(state, Word::PlaneAdd, Some(shape));
            }
        }
    }
    if (clip.is_some() || plane.is_some()) && ui.button(state.say(Word::CutNothing)).clicked() {
        state.change(Word::CutNothing, |document| {
            for entry in &mut document.volumes {
                entry.clip = None;
                entry.clip_shapes.clear();
            }
        });
    }
}

/// The plane that these controls are for: the first in the world's space.
fn plane_of(entry: &Entry) -> Option<&Shape> {
    entry.clip_shapes.iter().find(|shape| is_own(shape))
}

fn is_own(shape: &Shape) -> bool {
    shape.kind == ClipKind::Plane && shape.space == Space::World
}

/// A plane in mm of the world that keeps what lies along `normal`.
fn plane(point: DVec3, normal: DVec3) -> Shape {
    let (u, v) = normal.any_orthonormal_pair();
    let turn = DMat3::from_cols(u, v, normal);
    let turn = if turn.determinant() < 0.0 { DMat3::from_cols(v, u, normal) } else { turn };
    let from_shape: Rows = rows(DAffine3::from_mat3_translation(turn, point));
    Shape { kind: ClipKind::Plane, from_shape, space: Space::World, inverted: false }
}

/// Through the shared point, with what is before it cut away.
fn facing(session: &Session, cross: DVec3) -> Shape {
    let (scene, _) = session.scene();
    let point = scene.volumes.first().map_or(DVec3::ZERO, |it| it.world_from_patient.transform_point3(cross));
    let forward = -session.camera().world_from_camera.matrix3.z_axis;
    plane(point * 1e3, forward.normalize_or(DVec3::NEG_Z))
}

fn change_plane(state: &mut State, what: Word, shape: Option<Shape>) {
    state.change(what, |document| {
        // All scans of the scene are cut: they lie in one world.
        for entry in &mut document.volumes {
            match (entry.clip_shapes.iter().position(is_own), shape) {
                (Some(place), Some(shape)) => entry.clip_shapes[place] = shape,
                (Some(place), None) => {
                    entry.clip_shapes.remove(place);
                }
                (None, Some(shape)) => entry.clip_shapes.push(shape),
                (None, None) => {}
            }
        }
    });
}

fn plane_controls(ui: &mut Ui, state: &mut State, shape: Shape) {
    let Some(session) = &state.session else { return };
    let (center, reach) = (session.center() * 1e3, 0.5 * session.scan().size_mm().length());
    let from_shape = affine(shape.from_shape);
    let (point, normal) = (from_shape.translation, from_shape.matrix3.z_axis.normalize_or(DVec3::Z));
    let before = (point - center).dot(normal);
    let mut offset = before;
    let bar = Slider::new(&mut offset, -reach..=reach).fixed_decimals(0).suffix(" mm");
    if slider(ui, state.say(Word::PlaneOffset), bar) {
        change_plane(state, Word::PlaneOffset, Some(plane(point + normal * (offset - before), normal)));
    }
    ui.horizontal(|ui| {
        if ui.button(state.say(Word::PlaneFlip)).clicked() {
            change_plane(state, Word::PlaneFlip, Some(plane(point, -normal)));
        }
        if ui.button(state.say(Word::PlaneRemove)).clicked() {
            change_plane(state, Word::PlaneRemove, None);
        }
    });
}

fn camera(ui: &mut Ui, state: &mut State) {
    const SIDES: [(Word, [f64; 2]); 5] = [
        (Word::Front, [0.0, 0.0]),
        (Word::Left, [90.0, 0.0]),
        (Word::Right, [-90.0, 0.0]),
        (Word::Back, [180.0, 0.0]),
        (Word::Above, [0.0, 89.0]),
    ];
    ui.horizontal_wrapped(|ui| {
        for (word, [azimuth, elevation]) in SIDES {
            if ui.button(state.say(word)).clicked() {
                state.act(Action::Frame(azimuth, elevation));
            }
        }
        let orbit = state.session.as_ref().map(Session::orbit);
        if let (true, Some(orbit)) =
            (ui.button(state.say(Word::FrameAll)).on_hover_text("R").clicked(), orbit)
        {
            state.act(Action::Frame(orbit.azimuth.to_degrees(), orbit.elevation.to_degrees()));
        }
    });
}
