//! The views, linked by one point: how they share the room, and what keys and wheel do to them.

use eframe::egui::{
    self, CornerRadius, Id, PointerButton, Pos2, Rect, Response, Sense, Stroke, StrokeKind, Ui, pos2, vec2,
};
use lumivox_core::glam::DVec2;
use lumivox_viewport::{Button, Gesture, Held};

use super::{measure, slice, three_d};
use crate::live::Live;
use crate::slices::Plane;
use crate::state::{Action, Layout, State, ViewId};
use crate::theme::palette;

/// Between views.
const GAP: f32 = 4.0;

/// All views that the layout shows.
pub fn show(ui: &mut Ui, state: &mut State, mut live: Option<&mut Live>) {
    let all = ui.available_rect_before_wrap();
    let p = palette(state.settings.is_dark);
    ui.painter().rect_filled(all, 0.0, p.ground);
    state.probe = None;
    state.follow_labels();
    for (view, rect) in cells(all.shrink(GAP), state.layout, state.active, state.shows_oblique) {
        match view {
            ViewId::ThreeD => three_d::show(ui, rect, state, live.as_deref_mut()),
            ViewId::Slice(plane) => slice::show(ui, rect, plane, state),
        }
        if state.active == view {
            state.active_rect = rect;
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
    let (are_two, are_none) =
        ui.input(|input| (input.multi_touch().is_some(), !input.any_touches() && !input.pointer.any_down()));
    if are_two || are_none {
        ui.data_mut(|data| data.insert_temp(Id::new(TWO_FINGERS), are_two));
    }
}

const TWO_FINGERS: &str = "two fingers";

/// Whether two fingers were down since there was none the last time.
fn were_two(ui: &Ui) -> bool {
    ui.data(|data| data.get_temp(Id::new(TWO_FINGERS))).unwrap_or(false)
}

/// Whether two fingers are down, or were since there was none the last time.
pub fn are_two(ui: &Ui) -> bool {
    were_two(ui) || ui.input(|input| input.multi_touch().is_some())
}

/// Where a view was clicked. The first of two fingers clicks nothing, when it leaves.
pub fn clicked(ui: &Ui, response: &Response) -> Option<Pos2> {
    response.interact_pointer_pos().filter(|_| response.clicked() && !were_two(ui))
}

/// Where each view is.
fn cells(all: Rect, layout: Layout, active: ViewId, shows_oblique: bool) -> Vec<(ViewId, Rect)> {
    let [x, y] = [all.min.x, all.min.y];
    let part = |left: f32, top: f32, width: f32, height: f32| {
        let at = pos2(x + left * (all.width() + GAP), y + top * (all.height() + GAP));
        Rect::from_min_size(at, vec2(width * (all.width() + GAP) - GAP, height * (all.height() + GAP) - GAP))
    };
    let [three_d, axial, coronal, sagittal, oblique] = ViewId::ALL;
    let third = 1.0 / 3.0;
    match layout {
        Layout::One => vec![(active, all)],
        Layout::Main => {
            let mut slices = vec![axial, coronal, sagittal];
            slices.extend(shows_oblique.then_some(oblique));
            let height = 1.0 / slices.len() as f32;
            let beside = slices
                .into_iter()
                .zip(0_u8..)
                .map(|(view, i)| (view, part(0.68, f32::from(i) * height, 0.32, height)));
            std::iter::once((three_d, part(0.0, 0.0, 0.68, 1.0))).chain(beside).collect()
        }
        Layout::Grid if shows_oblique => vec![
            (axial, part(0.0, 0.0, third, 0.5)),
            (coronal, part(third, 0.0, third, 0.5)),
            (sagittal, part(2.0 * third, 0.0, third, 0.5)),
            (oblique, part(0.0, 0.5, third, 0.5)),
            (three_d, part(third, 0.5, 2.0 * third, 0.5)),
        ],
        Layout::Grid => vec![
            (axial, part(0.0, 0.0, 0.5, 0.5)),
            (three_d, part(0.5, 0.0, 0.5, 0.5)),
            (coronal, part(0.0, 0.5, 0.5, 0.5)),
            (sagittal, part(0.5, 0.5, 0.5, 0.5)),
        ],
    }
}

/// A view as a thing that is clicked, dragged and spoken of.
pub fn interact(ui: &Ui, rect: Rect, view: ViewId, state: &mut State) -> Response {
    let response = ui.interact(rect, ui.id().with(view), Sense::click_and_drag());
    let name = state.say(view.word());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Image, true, name));
    if response.double_clicked() && !were_two(ui) {
        state.toggle_one(view);
    } else if response.clicked() || response.drag_started() {
        state.active = view;
    }
    response
}

/// Keys that are held.
pub fn held(ui: &Ui) -> Held {
    ui.input(|input| Held { shift: input.modifiers.shift, command: input.modifiers.command })
}

/// What two fingers do that began on a view.
pub fn fingers(ui: &Ui, rect: Rect, state: &State) -> Option<egui::MultiTouchInfo> {
    let touch = ui.input(|input| input.multi_touch());
    touch.filter(|touch| rect.contains(touch.start_pos) && state.dialog.is_none())
}

/// Notches of the wheel over a view, away from the hand.
pub fn notches(ui: &Ui, response: &Response) -> f64 {
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

/// Buttons of the mouse, as the interface and the profiles know them.
pub const BUTTONS: [(PointerButton, Button); 3] = [
    (PointerButton::Primary, Button::Primary),
    (PointerButton::Middle, Button::Middle),
    (PointerButton::Secondary, Button::Secondary),
];

/// Keys of the active view: arrows turn or step, with Alt they move a slice's cross; plus and minus come closer, R frames all; Enter
/// places a measurement's point at the cross.
fn view_keys(ui: &Ui, state: &mut State) {
    use egui::Key;
    let is_free = ui.memory(|memory| memory.focused().is_none());
    if !is_free || state.dialog.is_some() || state.session.is_none() {
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
    if let ViewId::Slice(plane) = state.active
        && !held.command
    {
        if ui.input(|input| input.key_pressed(Key::Enter)) {
            measure::place_at_cross(plane, state);
        }
        if held.alt {
            return state.move_cross(plane, [right, down]);
        }
    }
    if held.command || held.alt || count == [0.0; 5] {
        return;
    }
    match state.active {
        ViewId::ThreeD => {
            let Some(mut orbit) = state.session.as_ref().map(|session| session.orbit()) else { return };
            Gesture::Turn.apply(&mut orbit, [right * 0.04, down * 0.04]);
            Gesture::wheel(&mut orbit, closer);
            state.act(if all > 0.0 {
                Action::Frame(orbit.azimuth.to_degrees(), orbit.elevation.to_degrees())
            } else {
                Action::Camera(orbit)
            });
        }
        ViewId::Slice(plane) => {
            let view = &mut state.slices[plane.index()];
            view.zoom = (view.zoom * 1.15_f64.powf(closer)).clamp(0.5, 40.0);
            if all > 0.0 {
                (view.zoom, view.moved) = (1.0, DVec2::ZERO);
            }
            let up = -down + right + 10.0 * page;
            state.step(plane, if plane == Plane::Axial { up } else { -up });
        }
    }
}
