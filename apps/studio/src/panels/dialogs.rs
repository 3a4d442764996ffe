//! What lies over everything: the notice at first start, About, pictures for files, what went wrong.

use std::path::PathBuf;

use eframe::egui::{self, Align, DragValue, Id, Key, Margin, Modal, RichText, Ui};

use crate::archive;
use crate::darkroom::ExportDraft;
use crate::errands;
use crate::settings::Mouse;
use crate::sharing::SIDES;
use crate::state::{Action, Ask, Dialog, State};
use crate::theme::{palette, primary};
use crate::words::Word;

/// Pictures are no larger on a side; 8K is 7680.
const MOST_SIDE: u32 = 8192;

/// The dialog that there is, if there is one.
pub fn show(context: &egui::Context, state: &mut State) {
    if !state.settings.has_agreed {
        notice(context, state);
    } else if let Some((word, why)) = state.failed.clone() {
        failed(context, state, word, &why);
    } else {
        match state.dialog.clone() {
            Some(Dialog::About) => about(context, state),
            Some(Dialog::Export(draft)) => export(context, state, draft),
            Some(Dialog::Share(side, may)) => share(context, state, (side, may)),
            Some(Dialog::Restore(_)) => restore(context, state),
            Some(Dialog::Overwrite { file, steps, there }) => {
                overwrite(context, state, (file, steps), &there)
            }
            Some(Dialog::Leave { opens }) => leave(context, state, opens),
            // It is drawn by who asks.
            Some(Dialog::Archive) | None => {}
        }
    }
}

pub fn modal<T>(
    context: &egui::Context,
    state: &State,
    width: f32,
    content: impl FnOnce(&mut Ui) -> T,
) -> (T, bool) {
    let p = palette(state.settings.is_dark);
    let frame = egui::Frame::window(&context.global_style()).fill(p.panel).inner_margin(Margin::same(26));
    let shown = Modal::new(Id::new("dialog")).frame(frame).show(context, |ui| {
        ui.set_width(width);
        content(ui)
    });
    let leaves = shown.should_close();
    (shown.inner, leaves)
}

pub fn heading(ui: &mut Ui, text: &str) {
    ui.label(RichText::new(text).heading().strong());
    ui.add_space(6.0);
}

/// Right-aligned buttons at a dialog's end.
pub fn buttons<T>(ui: &mut Ui, content: impl FnOnce(&mut Ui) -> T) -> T {
    ui.add_space(14.0);
    let room = egui::vec2(ui.available_width(), 34.0);
    ui.allocate_ui_with_layout(room, egui::Layout::right_to_left(Align::Center), content).inner
}

fn notice(context: &egui::Context, state: &mut State) {
    let p = palette(state.settings.is_dark);
    let (agreed, _) = modal(context, state, 460.0, |ui| {
        heading(ui, "Lumivox Studio");
        ui.label(RichText::new(state.say(Word::NoDevice)).size(15.0).color(p.warning));
        ui.label(state.say(Word::NoDeviceLong));
        ui.label(RichText::new(state.say(Word::StaysHere)).color(p.weak));
        buttons(ui, |ui| ui.add(primary(&p, state.say(Word::Understood))).clicked())
    });
    if agreed || context.input(|input| input.key_pressed(Key::Enter)) {
        state.act(Action::Agree);
    }
}

fn failed(context: &egui::Context, state: &mut State, word: Word, why: &str) {
    let p = palette(state.settings.is_dark);
    let (closed, leaves) = modal(context, state, 520.0, |ui| {
        heading(ui, state.say(word));
        ui.add(egui::Label::new(why).wrap().selectable(true));
        buttons(ui, |ui| ui.add(primary(&p, state.say(Word::Close))).clicked())
    });
    if closed || leaves {
        state.failed = None;
    }
}

fn about(context: &egui::Context, state: &mut State) {
    let p = palette(state.settings.is_dark);
    let keys = [
        ("Ctrl+O   Ctrl+Shift+O", Word::KeyOpen),
        ("Ctrl+Shift+A", Word::ArchiveTitle),
        ("Ctrl+S   Ctrl+E", Word::KeySave),
        ("Ctrl+Shift+E   Ctrl+C", Word::KeyShare),
        ("Ctrl+Z   Ctrl+Y", Word::KeyUndo),
        ("1 \u{2013} 5   G   M   Space", Word::KeyViews),
        ("Arrows   Page Up/Down", Word::KeyTurn),
        ("+   \u{2212}   R", Word::KeyZoom),
        ("V   D   A   E   W   L", Word::KeyTools),
        ("Alt+Arrows   Enter", Word::KeyCross),
        ("O   S   Delete", Word::KeySlices),
    ];
    let (closed, leaves) = modal(context, state, 560.0, |ui| {
        heading(ui, "Lumivox Studio");
        ui.label(state.say(Word::AboutText));
        let version = format!("{} {}", state.say(Word::Version), env!("CARGO_PKG_VERSION"));
        ui.label(RichText::new(version).small().color(p.weak));
        ui.add_space(6.0);
        ui.label(RichText::new(state.say(Word::NoDevice)).color(p.warning));
        ui.label(state.say(Word::NoDeviceLong));
        ui.label(state.say(Word::StaysHere));
        ui.add_space(10.0);
        ui.label(RichText::new(state.say(Word::Keys)).strong());
        egui::Grid::new("keys").num_columns(2).spacing([24.0, 6.0]).show(ui, |ui| {
            for (key, word) in
                keys.into_iter().filter(|(_, word)| archive::IS_THERE || *word != Word::ArchiveTitle)
            {
                ui.label(RichText::new(key).monospace().color(p.accent));
                ui.label(state.say(word));
                ui.end_row();
            }
        });
        ui.add_space(6.0);
        ui.label(RichText::new(state.say(Word::Mouse)).strong());
        ui.label(state.say(Word::Mouse3D));
        ui.label(state.say(match state.settings.mouse {
            Mouse::Ohif => Word::Mouse2D,
            Mouse::Slicer => Word::MouseSlicer2D,
        }));
        ui.label(state.say(Word::MouseTools));
        ui.label(state.say(Word::Fingers));
        buttons(ui, |ui| ui.add(primary(&p, state.say(Word::Close))).clicked())
    });
    if closed || leaves {
        state.dialog = None;
    }
}

/// Work that another run left: it is opened or thrown away, and stays until that is said.
fn restore(context: &egui::Context, state: &mut State) {
    let p = palette(state.settings.is_dark);
    let ([restores, discards], _) = modal(context, state, 460.0, |ui| {
        heading(ui, state.say(Word::Restore));
        ui.label(state.say(Word::RestoreWhy));
        buttons(ui, |ui| {
            let restores = ui.add(primary(&p, state.say(Word::RestoreIt))).clicked();
            [restores, ui.button(state.say(Word::Discard)).clicked()]
        })
    });
    if restores || discards {
        state.dialog = None;
        state.act(Action::Restore(restores));
    }
}

/// Asks before the pictures of a turn replace files: the file dialog asked for the one name alone.
fn overwrite(context: &egui::Context, state: &mut State, (file, steps): (PathBuf, u32), there: &str) {
    let p = palette(state.settings.is_dark);
    let ([replaces, cancels], leaves) = modal(context, state, 460.0, |ui| {
        heading(ui, state.say(Word::Overwrite));
        ui.add(egui::Label::new(there).wrap());
        buttons(ui, |ui| {
            let replaces = ui.add(primary(&p, state.say(Word::OverwriteIt))).clicked();
            [replaces, ui.button(state.say(Word::Cancel)).clicked()]
        })
    });
    if replaces || cancels || leaves {
        state.dialog = None;
    }
    if replaces {
        state.act(Action::Turn(file, steps));
    }
}

/// Asks what becomes of unsaved work, before something else `opens` or the window closes.
fn leave(context: &egui::Context, state: &mut State, opens: bool) {
    let [title, anyway] = match opens {
        true => [Word::Replace, Word::ReplaceAnyway],
        false => [Word::Leave, Word::LeaveAnyway],
    };
    let p = palette(state.settings.is_dark);
    let ([saves, closes, cancels], leaves) = modal(context, state, 480.0, |ui| {
        heading(ui, state.say(title));
        ui.label(state.say(Word::LeaveWhy));
        buttons(ui, |ui| {
            let saves = ui.add(primary(&p, state.say(Word::SaveScene))).clicked();
            let closes = ui.button(state.say(anyway)).clicked();
            [saves, closes, ui.button(state.say(Word::Cancel)).clicked()]
        })
    });
    if saves || closes || cancels || leaves {
        state.dialog = None;
    }
    if saves {
        state.act(Action::SaveAndClose);
    } else if closes {
        state.act(Action::Close);
    }
}

fn export(context: &egui::Context, state: &mut State, mut draft: ExportDraft) {
    let p = palette(state.settings.is_dark);
    let (pressed, leaves) = modal(context, state, 420.0, |ui| {
        heading(ui, state.say(Word::Picture));
        egui::Grid::new("picture").num_columns(2).spacing([18.0, 10.0]).show(ui, |ui| {
            let suffix = format!(" {}", state.say(Word::Pixels));
            for (axis, word) in [(0, Word::PictureWidth), (1, Word::PictureHeight)] {
                let label = ui.label(state.say(word));
                let value =
                    DragValue::new(&mut draft.size[axis]).range(16..=MOST_SIDE).suffix(&suffix).speed(8);
                ui.add_sized([110.0, 26.0], value).labelled_by(label.id);
                ui.end_row();
            }
            let label = ui.label(state.say(Word::Samples));
            let value = DragValue::new(&mut draft.samples).range(1..=65_536).speed(8);
            ui.add_sized([110.0, 26.0], value).labelled_by(label.id);
            ui.end_row();
        });
        ui.checkbox(&mut draft.transparent, state.say(Word::Transparent));
        ui.checkbox(&mut draft.denoise, state.say(Word::Denoise));
        turn(ui, state, &mut draft);
        ui.label(RichText::new(state.say(Word::NoDevice)).small().color(p.warning));
        buttons(ui, |ui| {
            let word = if draft.turn.is_some() { Word::SaveTurn } else { Word::SavePicture };
            let saves = ui.add(primary(&p, state.say(word))).clicked();
            let copies = ui.button(state.say(Word::CopyView)).on_hover_text("Ctrl+C").clicked();
            (saves, copies, ui.button(state.say(Word::Cancel)).clicked())
        })
    });
    let (saves, copies, cancels) = pressed;
    state.dialog = Some(Dialog::Export(draft));
    if saves {
        state.dialog = None;
        state.change(Word::Picture, |document| draft.put_into(document));
        let name = state.session.as_ref().map(|session| session.file_name("png")).unwrap_or_default();
        state.act(Action::Ask(match draft.turn {
            Some(steps) => Ask::SaveTurn(name, steps),
            None => Ask::SavePicture(name),
        }));
    } else if copies {
        state.dialog = None;
        state.act(Action::Copy);
    } else if cancels || leaves {
        state.dialog = None;
    }
}

/// A page for others: what is in it is said, and who may have it is asked, before anything is written.
fn share(context: &egui::Context, state: &mut State, (mut side, mut may): (usize, bool)) {
    let p = palette(state.settings.is_dark);
    let ([saves, cancels], leaves) = modal(context, state, 480.0, |ui| {
        heading(ui, state.say(Word::ShareTitle));
        ui.label(state.say(Word::ShareWhat));
        ui.add_space(6.0);
        ui.horizontal(|ui| {
            ui.label(state.say(Word::ShareSide));
            for own in SIDES {
                ui.selectable_value(&mut side, own, own.to_string());
            }
        });
        ui.add_space(6.0);
        ui.label(RichText::new(state.say(Word::ShareFace)).color(p.warning));
        ui.checkbox(&mut may, state.say(Word::ShareMay));
        ui.label(RichText::new(state.say(Word::NoDevice)).small().color(p.warning));
        buttons(ui, |ui| {
            let saves = ui.add_enabled(may, primary(&p, state.say(Word::ShareSave))).clicked();
            [saves, ui.button(state.say(Word::Cancel)).clicked()]
        })
    });
    state.dialog = Some(Dialog::Share(side, may));
    if saves {
        let name = state.session.as_ref().map(|session| session.file_name("html")).unwrap_or_default();
        state.act(Action::Ask(Ask::SavePage(name, side)));
    }
    if saves || cancels || leaves {
        state.dialog = None;
    }
}

/// Whether it is a turn around the scan, and in how many pictures.
fn turn(ui: &mut Ui, state: &State, draft: &mut ExportDraft) {
    /// Three seconds of a film.
    const USUAL: u32 = 72;
    if !errands::MAKES_TURNS {
        return;
    }
    ui.horizontal(|ui| {
        let mut turns = draft.turn.is_some();
        if ui.checkbox(&mut turns, state.say(Word::Turntable)).changed() {
            draft.turn = turns.then_some(USUAL);
        }
        if let Some(steps) = &mut draft.turn {
            let suffix = format!(" {}", state.say(Word::Pictures));
            let value = ui.add(DragValue::new(steps).range(2..=720).suffix(suffix));
            value.on_hover_text(state.say(Word::TurntableHint));
        }
    });
}
