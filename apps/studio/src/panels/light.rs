//! The light: what shines from around, a key light that a ball turns, and how bright the picture is.

use std::path::{Path, PathBuf};

use eframe::egui::{
    self, Color32, Mesh, Pos2, Rect, Sense, Shape, Slider, SliderClamping, Stroke, Ui, pos2, vec2,
};
use lumivox_core::document::Lighting;
use lumivox_core::glam::{DMat3, DVec3};

use super::look::slider;
use super::marks::nudged;
use crate::state::{Action, Ask, State};
use crate::theme::palette;
use crate::words::Word;

/// Of a key light that was just lit: about as bright as a white wall around.
const IRRADIANCE: f64 = 3.0;
/// Its radius in the sky, in degrees: shadows have soft edges.
const DEGREES: f64 = 6.0;
/// That it is turned by an arrow key.
const NUDGE_DEGREES: f64 = 2.0;
/// The ball's side.
const BALL: f32 = 86.0;

/// Environments that need no file.
const ENVIRONMENTS: [(Word, &str); 3] = [
    (Word::EnvironmentStudio, "studio"),
    (Word::EnvironmentEven, "uniform"),
    (Word::EnvironmentSky, "gradient"),
];

/// All of it.
pub fn show(ui: &mut Ui, state: &mut State) {
    let Some(session) = &state.session else { return };
    let mut exposure = session.document().display.exposure;
    let stops = format!(" {}", state.say(Word::Stops));
    let bar = Slider::new(&mut exposure, -4.0..=4.0).fixed_decimals(1).suffix(stops);
    if slider(ui, state.say(Word::Exposure), bar) {
        state.change(Word::Exposure, |document| document.display.exposure = exposure);
    }
    environment(ui, state);
    key_light(ui, state);
}

/// Light of a panorama in a file.
pub fn open(state: &mut State, file: PathBuf) {
    state.change(Word::Environment, |document| document.environment.source = file);
}

fn environment(ui: &mut Ui, state: &mut State) {
    let Some(session) = &state.session else { return };
    let own = session.document().environment.clone();
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        for (word, source) in ENVIRONMENTS {
            let is_own = own.source == Path::new(source);
            if ui.selectable_label(is_own, state.say(word)).clicked() && !is_own {
                state.change(Word::Environment, |document| document.environment.source = source.into());
            }
        }
        let button = ui.selectable_label(own.file().is_some(), state.say(Word::EnvironmentFile));
        if button.on_hover_text(state.say(Word::EnvironmentFileHint)).clicked() {
            state.act(Action::Ask(Ask::Light));
        }
    });
    if let Some(file) = own.file() {
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        ui.add(egui::Label::new(egui::RichText::new(name).small()).truncate());
    }
    let mut strength = own.strength;
    let bar = Slider::new(&mut strength, 0.0..=4.0).fixed_decimals(2);
    if slider(ui, state.say(Word::EnvironmentStrength), bar) {
        state.change(Word::EnvironmentStrength, |document| document.environment.strength = strength);
    }
    let mut rotation = own.rotation;
    let bar = Slider::new(&mut rotation, -180.0..=180.0).fixed_decimals(0).suffix("\u{b0}");
    if slider(ui, state.say(Word::EnvironmentRotation), bar) {
        state.change(Word::EnvironmentRotation, |document| document.environment.rotation = rotation);
    }
}

/// The first light from afar: where it comes from, by the camera's own right, up and back; and how bright it is.
fn key_of(lights: &[Lighting], axes: DMat3) -> Option<(usize, DVec3, f64)> {
    lights.iter().enumerate().find_map(|(place, light)| match light {
        Lighting::Sun { direction, irradiance, .. } => {
            let from = axes.transpose() * -DVec3::from_array(*direction).normalize_or(DVec3::NEG_Y);
            Some((place, from, irradiance.iter().copied().fold(0.0, f64::max)))
        }
        _ => None,
    })
}

fn key_light(ui: &mut Ui, state: &mut State) {
    let Some(session) = &state.session else { return };
    let axes = session.camera().world_from_camera.matrix3;
    let key = key_of(&session.document().lights, axes);
    ui.horizontal(|ui| {
        let (rect, response) = ui.allocate_exact_size(vec2(BALL, BALL), Sense::click_and_drag());
        response.widget_info(|| {
            egui::WidgetInfo::labeled(egui::WidgetType::Other, true, state.say(Word::KeyLightBall))
        });
        draw_ball(ui, rect, key.map(|(_, from, _)| from), response.has_focus(), state);
        let pressed = response.dragged() || response.clicked();
        if let Some(at) = response.interact_pointer_pos().filter(|_| pressed) {
            let direction = axes * -from_of(rect, at);
            shine(state, direction, key.map_or(IRRADIANCE, |(_, _, bright)| bright));
        }
        if let (Some(by), Some((_, from, bright))) = (nudged(ui, &response), key) {
            let [right, down] = [by.x, by.y].map(|by| (f64::from(by) * NUDGE_DEGREES).to_radians());
            shine(
                state,
                axes * -(DMat3::from_rotation_y(right) * DMat3::from_rotation_x(down) * from),
                bright,
            );
        }
        response.on_hover_text(state.say(Word::KeyLightHint));
        ui.vertical(|ui| {
            let mut is_lit = key.is_some();
            if ui.checkbox(&mut is_lit, state.say(Word::KeyLight)).changed() {
                if is_lit {
                    shine(state, axes * -DVec3::new(-0.5, 0.6, 0.62), IRRADIANCE);
                } else if let Some((place, _, _)) = key {
                    state.change(Word::KeyLight, |document| {
                        document.lights.remove(place);
                    });
                }
            }
            if let Some((_, from, mut bright)) = key {
                ui.spacing_mut().slider_width = 96.0;
                let bar = Slider::new(&mut bright, 0.0..=12.0).fixed_decimals(1);
                let bar = bar.clamping(SliderClamping::Edits);
                let slider = ui.add(bar);
                slider.widget_info(|| {
                    egui::WidgetInfo::slider(true, bright, state.say(Word::KeyLightStrength))
                });
                if slider.on_hover_text(state.say(Word::KeyLightStrength)).changed() {
                    shine(state, axes * -from, bright);
                }
            }
        });
    });
}

/// Lights the key light, or turns it.
fn shine(state: &mut State, direction: DVec3, bright: f64) {
    let of = |color: [f64; 3]| {
        let most = color.iter().copied().fold(0.0, f64::max);
        if most > 0.0 { color.map(|c| c / most * bright) } else { [bright; 3] }
    };
    state.change(Word::KeyLight, |document| {
        let known = document.lights.iter_mut().find(|light| matches!(light, Lighting::Sun { .. }));
        match known {
            Some(Lighting::Sun { direction: own, irradiance, .. }) => {
                (*own, *irradiance) = (direction.to_array(), of(*irradiance));
            }
            _ => document.lights.insert(
                0,
                Lighting::Sun {
                    direction: direction.to_array(),
                    irradiance: [bright; 3],
                    degrees: DEGREES,
                    layers: u32::MAX,
                },
            ),
        }
    });
}

/// Where light comes from by a place on the ball: in its middle from the eye, at its edge from the side, beyond that from behind.
fn from_of(rect: Rect, at: Pos2) -> DVec3 {
    let by = (at - rect.center()) / (0.5 * rect.width());
    let by = vec2(by.x, -by.y);
    let length = by.length();
    let (side, depth) = if length <= 1.0 {
        (length, (1.0 - length * length).sqrt())
    } else {
        let behind = (2.0 - length).clamp(0.0, 1.0);
        (behind, -(1.0 - behind * behind).sqrt())
    };
    let along = if length > 1e-6 { by / length } else { vec2(0.0, 0.0) };
    DVec3::new((along.x * side).into(), (along.y * side).into(), depth.into()).normalize_or(DVec3::Z)
}

fn draw_ball(ui: &Ui, rect: Rect, from: Option<DVec3>, has_focus: bool, state: &State) {
    const RINGS: u32 = 12;
    const AROUND: u32 = 36;
    let p = palette(state.settings.is_dark);
    let radius = 0.5 * rect.width() - 3.0;
    let light = from.unwrap_or(DVec3::new(-0.3, 0.4, 0.87).normalize());
    let most = if from.is_some() { 1.0 } else { 0.35 };
    let mut mesh = Mesh::default();
    for ring in 0..=RINGS {
        let out = f64::from(ring) / f64::from(RINGS);
        for step in 0..AROUND {
            let (sin, cos) = (f64::from(step) / f64::from(AROUND) * std::f64::consts::TAU).sin_cos();
            let normal = DVec3::new(out * cos, out * sin, (1.0 - out * out).max(0.0).sqrt());
            let bright = 0.08 + most * 0.92 * normal.dot(light).max(0.0);
            let at = rect.center() + vec2(normal.x as f32, -normal.y as f32) * radius;
            mesh.colored_vertex(at, Color32::from_gray((255.0 * bright.min(1.0).powf(0.6)) as u8));
            if ring > 0 {
                let [a, b] = [ring * AROUND + step, ring * AROUND + (step + 1) % AROUND];
                mesh.add_triangle(a, b, a - AROUND);
                mesh.add_triangle(b, a - AROUND, b - AROUND);
            }
        }
    }
    ui.painter().add(Shape::mesh(mesh));
    let edge = if has_focus { p.accent } else { p.line };
    ui.painter().circle_stroke(rect.center(), radius, Stroke::new(1.2, edge));
    if let Some(from) = from {
        let at = pos2(rect.center().x + from.x as f32 * radius, rect.center().y - from.y as f32 * radius);
        // Behind the ball it is open.
        let fill = if from.z >= 0.0 { p.accent } else { Color32::TRANSPARENT };
        ui.painter().circle(at, 4.0, fill, Stroke::new(1.6, p.accent));
    }
}
