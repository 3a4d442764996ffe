//! What is shown while nothing is open.

use eframe::egui::{self, Color32, RichText, Stroke, StrokeKind, Ui, UiBuilder, vec2};

use crate::archive;
use crate::state::{Action, Ask, State};
use crate::theme::{palette, primary};
use crate::words::Word;

/// Where to drop a scan, and the two ways to choose one.
pub fn show(ui: &mut Ui, state: &mut State) {
    let p = palette(state.settings.is_dark);
    let all = ui.available_rect_before_wrap();
    ui.painter().rect_filled(all, 0.0, p.ground);
    let is_over = ui.input(|input| !input.raw.hovered_files.is_empty());
    let size = vec2((all.width() - 48.0).min(640.0), 312.0);
    let card = egui::Rect::from_center_size(all.center(), size);
    let line = if is_over { p.accent } else { p.line };
    ui.painter().rect(
        card,
        egui::CornerRadius::same(18),
        p.panel,
        Stroke::new(1.5, line),
        StrokeKind::Inside,
    );
    let inside = card.shrink2(vec2(48.0, 44.0));
    ui.scope_builder(UiBuilder::new().max_rect(inside), |ui| {
        ui.vertical_centered(|ui| {
            body(ui, p.accent);
            ui.add_space(14.0);
            ui.label(RichText::new(state.say(Word::DropHere)).size(26.0).strong().color(p.text));
            ui.add_space(2.0);
            ui.label(RichText::new(state.say(Word::DropFormats)).color(p.weak));
            ui.add_space(16.0);
            let [files, folder, from_archive] =
                [Word::OpenFiles, Word::OpenFolder, Word::Archive].map(|word| state.say(word));
            ui.horizontal(|ui| {
                // All of them, in the middle.
                let count = if archive::IS_THERE { 3.0 } else { 2.0 };
                let width = count * 150.0 + (count - 1.0) * ui.spacing().item_spacing.x;
                ui.add_space((ui.available_width() - width).max(0.0) / 2.0);
                if ui.add(primary(&p, folder).min_size(vec2(150.0, 36.0))).clicked() {
                    state.act(Action::Ask(Ask::Folder));
                }
                if ui.add(egui::Button::new(files).min_size(vec2(150.0, 36.0))).clicked() {
                    state.act(Action::Ask(Ask::Files));
                }
                if archive::IS_THERE
                    && ui.add(egui::Button::new(from_archive).min_size(vec2(150.0, 36.0))).clicked()
                {
                    state.act(Action::ArchiveDialog);
                }
            });
            ui.add_space(14.0);
            ui.label(RichText::new(state.say(Word::StaysHere)).small().color(p.weak));
        });
    });
}

/// A mark: slices of a body, one lit.
fn body(ui: &mut Ui, accent: Color32) {
    let (rect, _) = ui.allocate_exact_size(vec2(84.0, 52.0), egui::Sense::hover());
    for (place, share) in [(0.0, 0.30), (1.0, 0.55), (2.0, 1.0)] {
        let center = rect.center() + vec2(0.0, 14.0 - 14.0 * place);
        let color = accent.gamma_multiply(share);
        let ellipse = egui::epaint::EllipseShape::stroke(center, vec2(34.0, 11.0), Stroke::new(2.0, color));
        ui.painter().add(ellipse);
    }
}
