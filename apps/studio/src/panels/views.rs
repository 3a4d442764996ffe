//! The four views: the path-traced one and three slices, linked by one point.

use eframe::egui::{
    self, Align2, Color32, CornerRadius, FontId, Painter, PointerButton, Pos2, Rect, Response, Sense, Stroke,
    StrokeKind, TextureOptions, Ui, Vec2, pos2, vec2,
};
use lumivox_core::glam::{DVec2, DVec3};
use lumivox_viewport::{Button, Gesture, Held, Profile, pick};

use crate::live::Live;
use crate::session::Session;
use crate::slices::{self, Geometry, Plane, value_at};
use crate::state::{Action, Layout, Probe, SliceView, State, ViewId};
use crate::theme::{ON_VIEW, VIEW_GROUND, palette};
use crate::words::Word;

/// Between views.
const GAP: f32 = 4.0;

/// All views that the layout shows.
pub fn show(ui: &mut Ui, state: &mut State, mut live: Option<&mut Live>) {
    let all = ui.available_rect_before_wrap();
    let p = palette(state.settings.is_dark);
    ui.painter().rect_filled(all, 0.0, p.ground);
    state.probe = None;
    for (view, rect) in cells(all.shrink(GAP), state.layout, state.active) {
        match view {
            ViewId::ThreeD => three_d(ui, rect, state, live.as_deref_mut()),
            ViewId::Slice(plane) => slice(ui, rect, plane, state),
        }
        if state.active == view && state.layout != Layout::One {
            ui.painter().rect_stroke(
                rect,
                CornerRadius::same(6),
                Stroke::new(1.5, p.accent),
                StrokeKind::Inside,
            );
        }
    }
    view_keys(ui, state);
}

/// Where each view is.
fn cells(all: Rect, layout: Layout, active: ViewId) -> Vec<(ViewId, Rect)> {
    let [x, y] = [all.min.x, all.min.y];
    let part = |left: f32, top: f32, width: f32, height: f32| {
        let at = pos2(x + left * (all.width() + GAP), y + top * (all.height() + GAP));
        Rect::from_min_size(at, vec2(width * (all.width() + GAP) - GAP, height * (all.height() + GAP) - GAP))
    };
    let [three_d, axial, coronal, sagittal] = ViewId::ALL;
    match layout {
        Layout::One => vec![(active, all)],
        Layout::Main => {
            let third = 1.0 / 3.0;
            vec![
                (three_d, part(0.0, 0.0, 0.68, 1.0)),
                (axial, part(0.68, 0.0, 0.32, third)),
                (coronal, part(0.68, third, 0.32, third)),
                (sagittal, part(0.68, 2.0 * third, 0.32, third)),
            ]
        }
        Layout::Grid => vec![
            (axial, part(0.0, 0.0, 0.5, 0.5)),
            (three_d, part(0.5, 0.0, 0.5, 0.5)),
            (coronal, part(0.0, 0.5, 0.5, 0.5)),
            (sagittal, part(0.5, 0.5, 0.5, 0.5)),
        ],
    }
}

/// A view as a thing that is clicked, dragged and spoken of.
fn interact(ui: &Ui, rect: Rect, view: ViewId, state: &mut State) -> Response {
    let response = ui.interact(rect, ui.id().with(view), Sense::click_and_drag());
    let name = state.say(view.word());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Image, true, name));
    if response.double_clicked() {
        state.toggle_one(view);
    } else if response.clicked() || response.drag_started() {
        state.active = view;
    }
    response
}

/// Notches of the wheel over a view, away from the hand.
fn notches(ui: &Ui, response: &Response) -> f64 {
    if !response.hovered() {
        return 0.0;
    }
    ui.input(|input| {
        let of = |event: &egui::Event| match event {
            egui::Event::MouseWheel { unit: egui::MouseWheelUnit::Point, delta, .. } => delta.y / 40.0,
            egui::Event::MouseWheel { delta, .. } => delta.y,
            egui::Event::Zoom(factor) => factor.ln() * 10.0,
            _ => 0.0,
        };
        f64::from(input.events.iter().map(of).sum::<f32>())
    })
}

const BUTTONS: [(PointerButton, Button); 3] = [
    (PointerButton::Primary, Button::Primary),
    (PointerButton::Middle, Button::Middle),
    (PointerButton::Secondary, Button::Secondary),
];

fn three_d(ui: &mut Ui, rect: Rect, state: &mut State, live: Option<&mut Live>) {
    let response = interact(ui, rect, ViewId::ThreeD, state);
    let scale = ui.ctx().pixels_per_point();
    state.view_size = [rect.width(), rect.height()].map(|n| (n * scale).round().max(1.0) as u32);
    let p = palette(state.settings.is_dark);
    ui.painter().rect_filled(rect, CornerRadius::same(6), VIEW_GROUND);
    if let Some(session) = &mut state.session {
        session.fit(f64::from(rect.width() / rect.height()));
    }
    let (Some(session), Some(live)) = (&state.session, live) else { return };
    match live.draw(session, state.view_size) {
        Ok(progress) => state.progress = progress,
        Err(why) => {
            state.progress.rests = true;
            if state.failed.is_none() {
                state.failed = Some((Word::CannotShow, why));
            }
        }
    }
    let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    ui.painter().image(live.texture(), rect, whole, Color32::WHITE);
    if !state.progress.rests {
        ui.ctx().request_repaint();
    }
    let painter = ui.painter_at(rect);
    title(&painter, rect, state.say(Word::ThreeD), p.accent);
    if !state.progress.is_shown {
        let at = rect.center();
        painter.text(
            at,
            Align2::CENTER_CENTER,
            state.say(Word::Preparing),
            FontId::proportional(15.0),
            ON_VIEW,
        );
    } else if state.progress.part < 1.0 && !state.progress.rests {
        let end = rect.left_bottom() + vec2(rect.width() * state.progress.part, 0.0);
        painter.line_segment([rect.left_bottom(), end], Stroke::new(3.0, p.accent));
    }
    let Some(session) = &state.session else { return };
    edge_letters(&painter, rect, directions(session));
    let aspect = f64::from(rect.width() / rect.height());
    if let Some(at) = seen_at(session, state.cross, rect) {
        mark(&painter, at, p.accent);
    }
    let uv =
        |at: Pos2| [(at.x - rect.min.x) / rect.width(), (at.y - rect.min.y) / rect.height()].map(f64::from);
    let picked = |at: Pos2| pick(session.scene().0, &session.camera().with_aspect(aspect), uv(at));
    let mut actions = vec![];
    if let (true, Some(at)) = (response.clicked(), response.interact_pointer_pos())
        && let Some(found) = picked(at)
    {
        actions.push(Action::Cross(in_first(session, found.world)));
    }
    if let (Some(at), false) = (response.hover_pos(), ui.input(|input| input.pointer.any_down()))
        && let Some(found) = picked(at)
    {
        let point = in_first(session, found.world);
        state.probe = Some(Probe { patient_mm: point, value: found.value });
    }
    let mut orbit = session.orbit();
    let before = orbit;
    let held = ui.input(|input| Held { shift: input.modifiers.shift, command: input.modifiers.command });
    for (button, known) in BUTTONS {
        if response.dragged_by(button)
            && let Some(gesture) = Profile::OHIF.gesture(known, held)
        {
            let by = response.drag_delta() / rect.height();
            gesture.apply(&mut orbit, [by.x, by.y].map(f64::from));
        }
    }
    let wheel = notches(ui, &response);
    if wheel != 0.0 {
        Gesture::wheel(&mut orbit, wheel);
    }
    if orbit != before {
        actions.push(Action::Camera(orbit));
    }
    actions.into_iter().for_each(|action| state.act(action));
}

/// A point of the world in the first scan's patient.
fn in_first(session: &Session, world: DVec3) -> DVec3 {
    let first = session.scene().0.volumes.first();
    first.map_or(DVec3::ZERO, |it| it.world_from_patient.inverse().transform_point3(world))
}

/// Where a point of the first scan's patient is seen in the 3D view.
fn seen_at(session: &Session, patient_mm: DVec3, rect: Rect) -> Option<Pos2> {
    let (scene, camera) = (session.scene().0, session.camera());
    let world = scene.volumes.first()?.world_from_patient.transform_point3(patient_mm);
    let own = camera.world_from_camera.inverse().transform_point3(world);
    let half = (camera.vertical_fov / 2.0).tan() * -own.z;
    let at = rect.center() + vec2((own.x / half) as f32, (-own.y / half) as f32) * (rect.height() / 2.0);
    (own.z < 0.0 && rect.contains(at)).then_some(at)
}

/// What lies to the left, right, top and bottom of the 3D view, by the patient's own sides.
fn directions(session: &Session) -> [&'static str; 4] {
    let axes = session.camera().world_from_camera.matrix3;
    let letter = |direction: DVec3| {
        let [x, y, z] = direction.to_array();
        match direction.abs().max_position() {
            0 if x > 0.0 => "L",
            0 => "R",
            1 if y > 0.0 => "H",
            1 => "F",
            _ if z > 0.0 => "A",
            _ => "P",
        }
    };
    [letter(-axes.x_axis), letter(axes.x_axis), letter(axes.y_axis), letter(-axes.y_axis)]
}

/// The colour of a plane, wherever its line or its name is.
fn color_of(plane: Plane) -> Color32 {
    match plane {
        Plane::Axial => Color32::from_rgb(0xf0, 0x7b, 0x6c),
        Plane::Coronal => Color32::from_rgb(0x7f, 0xc9, 0x7a),
        Plane::Sagittal => Color32::from_rgb(0xf0, 0xc9, 0x5e),
    }
}

fn slice(ui: &mut Ui, rect: Rect, plane: Plane, state: &mut State) {
    let response = interact(ui, rect, ViewId::Slice(plane), state);
    ui.painter().rect_filled(rect, CornerRadius::same(6), VIEW_GROUND);
    let Some(scan) = state.session.as_ref().map(|session| session.scan().clone()) else { return };
    let place = Plane::ALL.iter().position(|known| *known == plane).unwrap_or_default();
    let scale = f64::from(ui.ctx().pixels_per_point());
    let size = [rect.width(), rect.height()].map(|n| (f64::from(n) * scale).round().max(1.0) as usize);
    let view = &state.slices[place];
    let geometry = Geometry::new(&scan, plane, state.cross, size, view.zoom, view.moved);
    let in_pixels = |at: Pos2| [at.x - rect.min.x, at.y - rect.min.y].map(|n| f64::from(n) * scale);

    // The wheel goes from slice to slice, away from the hand towards the head, the front or the patient's right.
    let notches = notches(ui, &response);
    if notches != 0.0 {
        state.step(plane, if plane == Plane::Axial { notches } else { -notches });
    }
    if let (true, Some(at)) = (response.clicked(), response.interact_pointer_pos()) {
        state.act(Action::Cross(geometry.point(in_pixels(at))));
    }
    if let Some(at) = response.hover_pos() {
        let point = geometry.point(in_pixels(at));
        state.probe = value_at(&scan, point).map(|value| Probe { patient_mm: point, value });
    }
    let by = response.drag_delta();
    if response.dragged_by(PointerButton::Primary) {
        let shift = ui.input(|input| input.modifiers.shift);
        if let (true, Some(at)) = (shift, response.interact_pointer_pos()) {
            state.act(Action::Cross(geometry.point(in_pixels(at))));
        } else {
            drag_window(&mut state.window, by, rect);
        }
    }
    let view = &mut state.slices[place];
    if response.dragged_by(PointerButton::Middle) {
        view.moved += DVec2::new(by.x.into(), by.y.into()) * scale * geometry.mm_per_pixel;
    }
    if response.dragged_by(PointerButton::Secondary) {
        view.zoom = (view.zoom * (3.0 * f64::from(by.y / rect.height())).exp()).clamp(0.5, 40.0);
    }

    let geometry = Geometry::new(&scan, plane, state.cross, size, view.zoom, view.moved);
    draw_slice(ui, rect, &scan, geometry, state.window, &mut state.slices[place]);
    let painter = ui.painter_at(rect);
    if let Some(session) = &state.session
        && let Some(cut) = session.document().volumes.first().and_then(|entry| entry.clip)
    {
        kept_box(&painter, rect, &scan, cut, &geometry, scale);
    }
    let [x, y] = geometry.pixel(state.cross).map(|n| (n / scale) as f32);
    cross(&painter, rect, rect.min + vec2(x, y), plane);
    title(&painter, rect, state.say(ViewId::Slice(plane).word()), color_of(plane));
    edge_letters(&painter, rect, plane.letters());
    scale_bar(&painter, rect, (geometry.mm_per_pixel * scale) as f32);
    let [level, width] = state.window.map(|n| lumivox_core::words::number((n * 10.0).round() / 10.0));
    let told = format!("{} {level} / {width}", state.say(Word::Window));
    let at = rect.min + vec2(10.0, 26.0);
    shadowed(&painter, at, Align2::LEFT_TOP, &told, FontId::proportional(11.5), ON_VIEW.gamma_multiply(0.8));
    if plane == Plane::Axial && scan.is_hounsfield() {
        windows(ui, rect, state);
    }
}

/// Windows that radiologists know by name.
fn windows(ui: &mut Ui, rect: Rect, state: &mut State) {
    const KNOWN: [(Word, [f64; 2]); 4] = [
        (Word::WindowSoft, [40.0, 400.0]),
        (Word::WindowLung, [-600.0, 1500.0]),
        (Word::WindowBone, [400.0, 1800.0]),
        (Word::WindowBrain, [40.0, 80.0]),
    ];
    let at = Rect::from_min_size(rect.right_top() + vec2(-92.0, 7.0), vec2(84.0, 22.0));
    ui.scope_builder(egui::UiBuilder::new().max_rect(at), |ui| {
        ui.with_layout(egui::Layout::right_to_left(egui::Align::TOP), |ui| {
            ui.spacing_mut().button_padding = vec2(8.0, 2.0);
            ui.spacing_mut().interact_size.y = 20.0;
            let name = egui::RichText::new(state.say(Word::Window)).small();
            ui.menu_button(name, |ui| {
                for (word, window) in KNOWN {
                    if ui.selectable_label(state.window == window, state.say(word)).clicked() {
                        state.window = window;
                        ui.close();
                    }
                }
            });
        });
    });
}

/// To the right wider, down darker, as in OHIF.
fn drag_window(window: &mut [f64; 2], by: Vec2, rect: Rect) {
    let [level, width] = window;
    let scale = 2.0 * width.max(1e-6) / f64::from(rect.height().max(1.0));
    *level += f64::from(by.y) * scale;
    *width = (*width + f64::from(by.x) * scale).max(1e-6);
}

fn draw_slice(
    ui: &Ui,
    rect: Rect,
    scan: &lumivox_core::Volume,
    geometry: Geometry,
    window: slices::Window,
    view: &mut SliceView,
) {
    let is_drawn = matches!(&view.drawn, Some((known, with, _)) if *known == geometry && *with == window);
    if !is_drawn {
        let image = slices::image(scan, &geometry, window);
        match &mut view.drawn {
            Some((known, with, texture)) => {
                texture.set(image, TextureOptions::LINEAR);
                (*known, *with) = (geometry, window);
            }
            None => {
                let texture = ui.ctx().load_texture("slice", image, TextureOptions::LINEAR);
                view.drawn = Some((geometry, window, texture));
            }
        }
    }
    if let Some((_, _, texture)) = &view.drawn {
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        ui.painter_at(rect).image(texture.id(), rect, whole, Color32::WHITE);
    }
}

/// What the clip box leaves, as its outline in the slice.
fn kept_box(
    painter: &Painter,
    rect: Rect,
    scan: &lumivox_core::Volume,
    [low, high]: [[f64; 3]; 2],
    geometry: &Geometry,
    scale: f64,
) {
    let from_box = scan.patient_from_box();
    let corner = |i: usize| {
        let at = [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { high[axis] } else { low[axis] });
        let [x, y] = geometry.pixel(from_box.transform_point3(DVec3::from_array(at)));
        rect.min + vec2((x / scale) as f32, (y / scale) as f32)
    };
    let all =
        (0..8).map(corner).fold(Rect::NOTHING, |all, point| all.union(Rect::from_min_max(point, point)));
    let line = Stroke::new(1.0, ON_VIEW.gamma_multiply(0.7));
    let corners = [all.left_top(), all.right_top(), all.right_bottom(), all.left_bottom(), all.left_top()];
    painter.extend(egui::Shape::dashed_line(&corners, line, 5.0, 4.0));
}

/// The two other planes through the shared point, in their colours, open where it is.
fn cross(painter: &Painter, rect: Rect, at: Pos2, plane: Plane) {
    const OPEN: f32 = 9.0;
    let [vertical, horizontal] = match plane {
        Plane::Axial => [Plane::Sagittal, Plane::Coronal],
        Plane::Coronal => [Plane::Sagittal, Plane::Axial],
        Plane::Sagittal => [Plane::Coronal, Plane::Axial],
    };
    let line = |plane| Stroke::new(1.0, color_of(plane).gamma_multiply(0.75));
    for [from, to] in [[rect.top(), at.y - OPEN], [at.y + OPEN, rect.bottom()]] {
        painter.line_segment([pos2(at.x, from), pos2(at.x, to)], line(vertical));
    }
    for [from, to] in [[rect.left(), at.x - OPEN], [at.x + OPEN, rect.right()]] {
        painter.line_segment([pos2(from, at.y), pos2(to, at.y)], line(horizontal));
    }
}

/// The shared point in the 3D view: a ring, for it lies inside.
fn mark(painter: &Painter, at: Pos2, color: Color32) {
    painter.circle_stroke(at, 7.0, Stroke::new(2.5, Color32::from_black_alpha(140)));
    painter.circle_stroke(at, 7.0, Stroke::new(1.2, color));
    painter.circle_filled(at, 1.5, color);
}

fn title(painter: &Painter, rect: Rect, name: &str, color: Color32) {
    shadowed(painter, rect.min + vec2(10.0, 8.0), Align2::LEFT_TOP, name, FontId::proportional(13.0), color);
}

/// Left, right, top and bottom.
fn edge_letters(painter: &Painter, rect: Rect, [left, right, top, bottom]: [&str; 4]) {
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
fn scale_bar(painter: &Painter, rect: Rect, mm_per_point: f32) {
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
fn shadowed(painter: &Painter, at: Pos2, align: Align2, text: &str, font: FontId, color: Color32) {
    painter.text(at + vec2(1.0, 1.0), align, text, font.clone(), Color32::from_black_alpha(190));
    painter.text(at, align, text, font, color);
}

/// Keys of the active view: arrows turn or step, plus and minus come closer, R frames all.
fn view_keys(ui: &Ui, state: &mut State) {
    use egui::Key;
    let is_free = ui.memory(|memory| memory.focused().is_none());
    let Some(session) = &state.session else { return };
    if !is_free || state.dialog.is_some() {
        return;
    }
    let (held, count) = ui.input(|input| {
        let count = |key| f64::from(u8::from(input.key_pressed(key)));
        (
            input.modifiers,
            [
                count(Key::ArrowRight) - count(Key::ArrowLeft),
                count(Key::ArrowDown) - count(Key::ArrowUp),
                count(Key::Plus) + count(Key::Equals) - count(Key::Minus),
                count(Key::PageUp) - count(Key::PageDown),
                count(Key::R),
            ],
        )
    });
    let [right, down, closer, page, all] = count;
    if held.command || held.alt || count == [0.0; 5] {
        return;
    }
    match state.active {
        ViewId::ThreeD => {
            let mut orbit = session.orbit();
            Gesture::Turn.apply(&mut orbit, [right * 0.04, down * 0.04]);
            Gesture::wheel(&mut orbit, closer);
            state.act(if all > 0.0 {
                Action::Frame(orbit.azimuth.to_degrees(), orbit.elevation.to_degrees())
            } else {
                Action::Camera(orbit)
            });
        }
        ViewId::Slice(plane) => {
            let place = Plane::ALL.iter().position(|known| *known == plane).unwrap_or_default();
            let view = &mut state.slices[place];
            view.zoom = (view.zoom * 1.15_f64.powf(closer)).clamp(0.5, 40.0);
            if all > 0.0 {
                (view.zoom, view.moved) = (1.0, DVec2::ZERO);
            }
            let up = -down + right + 10.0 * page;
            state.step(plane, if plane == Plane::Axial { up } else { -up });
        }
    }
}
