//! Opacity and colour of the scan's values, over how often it has them: points that are dragged, added and removed.

use eframe::egui::{
    self, Color32, CursorIcon, DragValue, Id, Mesh, PointerButton, Pos2, Rect, RichText, Sense, Shape,
    Stroke, StrokeKind, Ui, pos2, vec2,
};
use lumivox_core::{ColorStop, Ease, Medium, OpacityKnot, TransferFunction, Volume};

use crate::overlay::shown;
use crate::state::{CurvePoint, State};
use crate::theme::{RADIUS, VIEW_GROUND, palette};
use crate::words::Word;

/// Of the curve, and of the bar of colours below it.
const HEIGHT: f32 = 118.0;
const BAR: f32 = 14.0;
/// Columns that the curve and the counts are drawn in.
const COLUMNS: usize = 150;
/// What is under the pointer is as large as that.
const TOUCH: f32 = 15.0;

/// Where values and opacities are in the window. Small opacities have more room: a little of them is seen at once.
struct Plot {
    rect: Rect,
    bar: Rect,
    range: [f64; 2],
}

impl Plot {
    fn x(&self, value: f64) -> f32 {
        let [low, high] = self.range;
        self.rect.left() + self.rect.width() * ((value - low) / (high - low)) as f32
    }

    fn value(&self, x: f32) -> f64 {
        let [low, high] = self.range;
        low + (high - low) * f64::from(((x - self.rect.left()) / self.rect.width()).clamp(0.0, 1.0))
    }

    fn at(&self, value: f64, opacity: f64) -> Pos2 {
        pos2(self.x(value), self.rect.bottom() - self.rect.height() * opacity.sqrt() as f32)
    }

    fn opacity(&self, y: f32) -> f64 {
        f64::from(((self.rect.bottom() - y) / self.rect.height()).clamp(0.0, 1.0)).powi(2)
    }
}

/// The values that the curve is drawn over: nearly all of the scan's, and those of its points.
fn range_of(scan: &Volume, function: &TransferFunction) -> [f64; 2] {
    let [low, high] = if scan.is_hounsfield() { [-1050.0, 1700.0] } else { scan.statistics().range };
    let [first, last] = function.value_range();
    let [low, high] = [low.min(first), high.max(last)];
    let room = 0.02 * (high - low).max(1e-9);
    [low - room, high + room]
}

/// The editor.
pub fn show(ui: &mut Ui, state: &mut State) {
    let Some(session) = &state.session else { return };
    let Some(medium) = session.scene().0.volumes.first().map(|it| it.medium.clone()) else { return };
    let scan = session.scan().clone();
    // What is dragged stays under the pointer.
    if state.curve_range[0] >= state.curve_range[1] || !ui.input(|input| input.pointer.any_down()) {
        state.curve_range = range_of(&scan, &medium.transfer_function);
    }
    let width = ui.available_width();
    let (all, response) = ui.allocate_exact_size(vec2(width, HEIGHT + BAR + 6.0), Sense::click());
    let rect = Rect::from_min_size(all.min, vec2(width, HEIGHT));
    let bar = Rect::from_min_size(rect.left_bottom() + vec2(0.0, 6.0), vec2(width, BAR));
    let plot = Plot {
        rect: rect.shrink2(vec2(7.0, 7.0)),
        bar: bar.shrink2(vec2(7.0, 0.0)),
        range: state.curve_range,
    };
    ui.painter().rect_filled(rect, RADIUS, VIEW_GROUND);
    draw(ui, &plot, &scan, &medium.transfer_function);
    let mut function = Points::of(&medium.transfer_function);
    let before = function.clone();
    knots(ui, &plot, state, &mut function);
    stops(ui, &plot, state, &mut function);
    if let (true, Some(at)) = (response.double_clicked(), response.interact_pointer_pos()) {
        let value = plot.value(at.x);
        state.curve_point = Some(if at.y < rect.bottom() {
            function.add_knot(value, plot.opacity(at.y))
        } else {
            function.add_stop(value, medium.transfer_function.color(value))
        });
    }
    chosen(ui, state, &mut function, &plot, &medium.transfer_function);
    if function != before {
        put(state, Word::Curve, &medium, function);
    }
}

/// Writes a curve out: shift, width and window are in its points from then on.
fn put(state: &mut State, what: Word, medium: &Medium, points: Points) {
    let Ok(function) = TransferFunction::new(points.knots, points.stops) else { return };
    let gradients = medium.gradients.clone();
    state.change(what, |document| {
        if let Some(entry) = document.volumes.first_mut() {
            entry.look.transfer_function = Some(function);
            entry.look.gradients = gradients;
            (entry.look.shift, entry.look.window_scale, entry.look.window) = (None, None, None);
        }
    });
}

/// A transfer function whose points keep their places in the lists.
#[derive(Clone, PartialEq)]
struct Points {
    knots: Vec<OpacityKnot>,
    stops: Vec<ColorStop>,
}

impl Points {
    fn of(function: &TransferFunction) -> Self {
        Self { knots: function.opacity_knots().to_vec(), stops: function.color_stops().to_vec() }
    }

    fn add_knot(&mut self, value: f64, opacity: f64) -> CurvePoint {
        let place = self.knots.partition_point(|knot| knot.value <= value);
        // A curve that bends goes on bending.
        let ease = place.checked_sub(1).map_or(Ease::Linear, |before| self.knots[before].ease);
        self.knots.insert(place, OpacityKnot { value, opacity, ease });
        CurvePoint::Opacity(place)
    }

    fn add_stop(&mut self, value: f64, color: [f64; 3]) -> CurvePoint {
        let place = self.stops.partition_point(|stop| stop.value <= value);
        self.stops.insert(place, ColorStop { value, color });
        CurvePoint::Color(place)
    }
}

/// A value that stays between its neighbours.
fn between(values: &[f64], place: usize, wanted: f64) -> f64 {
    let low = place.checked_sub(1).map_or(f64::NEG_INFINITY, |before| values[before]);
    let high = values.get(place + 1).copied().unwrap_or(f64::INFINITY);
    wanted.clamp(low, high)
}

fn draw(ui: &Ui, plot: &Plot, scan: &Volume, function: &TransferFunction) {
    let painter = ui.painter();
    let column = |i: usize| plot.rect.left() + plot.rect.width() * i as f32 / COLUMNS as f32;
    let value = |i: usize| plot.value(column(i));
    // How often values occur; their logarithm, for most of a scan is air.
    let counts: Vec<f32> = {
        let statistics = scan.statistics();
        let [first, last] = statistics.range;
        let bins = statistics.histogram.len() as f64;
        let bin = |value: f64| ((value - first) / (last - first).max(1e-12) * bins).clamp(0.0, bins) as usize;
        let count = |i: usize| {
            let (low, high) = (value(i), value(i + 1));
            let [a, b] = [bin(low), bin(high)];
            let is_beside = high < first || low > last;
            if is_beside {
                0
            } else {
                statistics.histogram[a.min(bins as usize - 1)..b.max(a + 1).min(bins as usize)]
                    .iter()
                    .sum::<u64>()
            }
        };
        (0..COLUMNS).map(|i| (1.0 + count(i) as f32).ln()).collect()
    };
    let most = counts.iter().copied().fold(1.0, f32::max);
    for (i, count) in counts.iter().enumerate() {
        let top = plot.rect.bottom() - plot.rect.height() * 0.92 * count / most;
        let bar = Rect::from_min_max(pos2(column(i), top), pos2(column(i + 1), plot.rect.bottom()));
        painter.rect_filled(bar, 0.0, Color32::from_gray(38));
    }
    let mut mesh = Mesh::default();
    for i in 0..=COLUMNS {
        let color = shown(function.color(value(i)));
        let top = plot.at(value(i), function.opacity(value(i)));
        mesh.colored_vertex(top, color.gamma_multiply(0.65));
        mesh.colored_vertex(pos2(top.x, plot.rect.bottom()), color.gamma_multiply(0.25));
        let below = [pos2(top.x, plot.bar.top()), pos2(top.x, plot.bar.bottom())];
        below.into_iter().for_each(|at| mesh.colored_vertex(at, color));
        if i > 0 {
            let at = 4 * (i as u32 - 1);
            for [a, b, c] in [[0, 1, 4], [1, 4, 5], [2, 3, 6], [3, 6, 7]] {
                mesh.add_triangle(at + a, at + b, at + c);
            }
        }
    }
    painter.add(Shape::mesh(mesh));
    let fine = 4 * COLUMNS;
    let at = |i: usize| {
        let value = plot.value(plot.rect.left() + plot.rect.width() * i as f32 / fine as f32);
        plot.at(value, function.opacity(value))
    };
    painter.add(Shape::line((0..=fine).map(at).collect(), Stroke::new(1.6, Color32::from_gray(225))));
}

fn knots(ui: &Ui, plot: &Plot, state: &mut State, function: &mut Points) {
    let mut removed = None;
    for place in 0..function.knots.len() {
        let own = function.knots[place];
        let at = plot.at(own.value, own.opacity);
        let name = format!("{} {}", state.say(Word::CurveOpacity), place + 1);
        let (response, is_chosen) = point(ui, state, at, CurvePoint::Opacity(place), &name);
        if let Some(to) = response.interact_pointer_pos().filter(|_| response.dragged()) {
            let values: Vec<f64> = function.knots.iter().map(|knot| knot.value).collect();
            let knot = &mut function.knots[place];
            (knot.value, knot.opacity) = (between(&values, place, plot.value(to.x)), plot.opacity(to.y));
        }
        if response.clicked_by(PointerButton::Secondary) && function.knots.len() > 1 {
            removed = Some(place);
        }
        let p = palette(true);
        let fill = if is_chosen { p.accent } else { Color32::from_gray(230) };
        ui.painter().circle(
            at,
            if response.hovered() { 5.5 } else { 4.5 },
            fill,
            Stroke::new(1.5, Color32::BLACK),
        );
        response.on_hover_cursor(CursorIcon::Grab).on_hover_text(state.say(Word::CurveHint));
    }
    if let Some(place) = removed {
        function.knots.remove(place);
        state.curve_point = None;
    }
}

fn stops(ui: &Ui, plot: &Plot, state: &mut State, function: &mut Points) {
    let mut removed = None;
    for place in 0..function.stops.len() {
        let own = function.stops[place];
        let at = pos2(plot.x(own.value), plot.bar.bottom() - 4.0);
        let name = format!("{} {}", state.say(Word::CurveColor), place + 1);
        let (response, is_chosen) = point(ui, state, at, CurvePoint::Color(place), &name);
        if let Some(to) = response.interact_pointer_pos().filter(|_| response.dragged()) {
            let values: Vec<f64> = function.stops.iter().map(|stop| stop.value).collect();
            function.stops[place].value = between(&values, place, plot.value(to.x));
        }
        if response.clicked_by(PointerButton::Secondary) && function.stops.len() > 1 {
            removed = Some(place);
        }
        let own = Rect::from_center_size(at, vec2(9.0, 12.0));
        let line = if is_chosen { palette(true).accent } else { Color32::from_gray(235) };
        ui.painter().rect_filled(own, 2.0, shown(function.stops[place].color));
        ui.painter().rect_stroke(own, 2.0, Stroke::new(2.0, Color32::BLACK), StrokeKind::Outside);
        ui.painter().rect_stroke(own, 2.0, Stroke::new(1.3, line), StrokeKind::Inside);
        response.on_hover_cursor(CursorIcon::Grab).on_hover_text(state.say(Word::CurveHint));
    }
    if let Some(place) = removed {
        function.stops.remove(place);
        state.curve_point = None;
    }
}

/// A point as a thing that is dragged; pressed, it is the chosen one.
fn point(ui: &Ui, state: &mut State, at: Pos2, which: CurvePoint, name: &str) -> (egui::Response, bool) {
    let place = Rect::from_center_size(at, vec2(TOUCH, TOUCH));
    let response = ui.interact(place, Id::new(("curve", which)), Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Other, true, name));
    if response.is_pointer_button_down_on() || response.clicked() {
        state.curve_point = Some(which);
    }
    (response, state.curve_point == Some(which))
}

/// The chosen point by its numbers; buttons that add and remove.
fn chosen(ui: &mut Ui, state: &mut State, function: &mut Points, plot: &Plot, shown: &TransferFunction) {
    let p = palette(state.settings.is_dark);
    let speed = (plot.range[1] - plot.range[0]) / 400.0;
    let unit = state.session.as_ref().map_or(String::new(), |session| format!(" {}", session.scan().unit()));
    ui.horizontal(|ui| {
        ui.spacing_mut().interact_size.y = 22.0;
        ui.spacing_mut().item_spacing.x = 5.0;
        match state.curve_point {
            Some(CurvePoint::Opacity(place)) if place < function.knots.len() => {
                let values: Vec<f64> = function.knots.iter().map(|knot| knot.value).collect();
                let knot = &mut function.knots[place];
                if ui.add(number(&mut knot.value, speed, &unit)).changed() {
                    knot.value = between(&values, place, knot.value);
                }
                ui.add(DragValue::new(&mut knot.opacity).range(0.0..=1.0).speed(0.005).fixed_decimals(3));
                let is_last = function.knots.len() == 1;
                if ui.add_enabled(!is_last, egui::Button::new(state.say(Word::CurveRemove)).small()).clicked()
                {
                    function.knots.remove(place);
                    state.curve_point = None;
                }
            }
            Some(CurvePoint::Color(place)) if place < function.stops.len() => {
                let values: Vec<f64> = function.stops.iter().map(|stop| stop.value).collect();
                let stop = &mut function.stops[place];
                let mut color = stop.color.map(|c| c as f32);
                if ui.color_edit_button_rgb(&mut color).changed() {
                    stop.color = color.map(|c| f64::from(c.clamp(0.0, 1.0)));
                }
                if ui.add(number(&mut stop.value, speed, &unit)).changed() {
                    stop.value = between(&values, place, stop.value);
                }
                let is_last = function.stops.len() == 1;
                if ui.add_enabled(!is_last, egui::Button::new(state.say(Word::CurveRemove)).small()).clicked()
                {
                    function.stops.remove(place);
                    state.curve_point = None;
                }
            }
            _ => {
                ui.label(RichText::new(state.say(Word::CurveIdle)).small().color(p.weak));
            }
        }
    });
    ui.horizontal(|ui| {
        let middle = 0.5 * (plot.range[0] + plot.range[1]);
        if ui.add(egui::Button::new(state.say(Word::CurveAddPoint)).small()).clicked() {
            state.curve_point = Some(function.add_knot(middle, shown.opacity(middle)));
        }
        if ui.add(egui::Button::new(state.say(Word::CurveAddColor)).small()).clicked() {
            state.curve_point = Some(function.add_stop(middle, shown.color(middle)));
        }
    });
}

fn number<'a>(value: &'a mut f64, speed: f64, unit: &str) -> DragValue<'a> {
    let decimals = if speed > 0.5 { 0 } else { 3 };
    DragValue::new(value).speed(speed).fixed_decimals(decimals).suffix(unit.trim_end().to_owned())
}

/// Moves and widens the look by a drag over the picture, in heights of it: to the right towards higher values, down wider.
pub fn drag(state: &mut State, [right, down]: [f64; 2]) {
    let Some(session) = &state.session else { return };
    let reach = super::look::shift_range(session.scan());
    state.change(Word::Shape, |document| {
        let Some(entry) = document.volumes.first_mut() else { return };
        let look = &mut entry.look;
        let shift = look.shift.unwrap_or(0.0) + right * reach;
        let width = (look.window_scale.unwrap_or(1.0) * (1.5 * down).exp()).clamp(0.05, 20.0);
        (look.shift, look.window_scale, look.window) = (Some(shift), Some(width), None);
    });
}
