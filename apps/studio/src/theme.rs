//! How the interface looks: few colours, one accent, dark as reading rooms are, or bright.

use eframe::egui::{
    self, Color32, CornerRadius, FontFamily, FontId, Margin, Shadow, Stroke, TextStyle, Theme, Visuals,
    style::WidgetVisuals,
};

/// The colours of a theme.
#[derive(Clone, Copy, Debug)]
pub struct Palette {
    /// Behind everything.
    pub ground: Color32,
    /// Of panels.
    pub panel: Color32,
    /// Of what lies on panels: cards, buttons.
    pub raised: Color32,
    /// The same under the pointer.
    pub hovered: Color32,
    /// Lines between parts.
    pub line: Color32,
    /// Letters.
    pub text: Color32,
    /// Letters that are less important.
    pub weak: Color32,
    /// What is chosen, and the one thing to press.
    pub accent: Color32,
    /// Letters on the accent.
    pub on_accent: Color32,
    /// What must not be overlooked.
    pub warning: Color32,
    /// Behind that.
    pub warning_ground: Color32,
}

const DARK: Palette = Palette {
    ground: Color32::from_rgb(0x0a, 0x0d, 0x12),
    panel: Color32::from_rgb(0x12, 0x16, 0x1d),
    raised: Color32::from_rgb(0x1c, 0x22, 0x2c),
    hovered: Color32::from_rgb(0x28, 0x31, 0x3e),
    line: Color32::from_rgb(0x24, 0x2b, 0x36),
    text: Color32::from_rgb(0xdc, 0xe3, 0xec),
    weak: Color32::from_rgb(0x8e, 0x9a, 0xab),
    accent: Color32::from_rgb(0x3d, 0xb8, 0xae),
    on_accent: Color32::from_rgb(0x04, 0x1a, 0x18),
    warning: Color32::from_rgb(0xf2, 0xbd, 0x56),
    warning_ground: Color32::from_rgb(0x2b, 0x24, 0x14),
};

const LIGHT: Palette = Palette {
    ground: Color32::from_rgb(0xe3, 0xe7, 0xec),
    panel: Color32::from_rgb(0xf6, 0xf8, 0xfa),
    raised: Color32::from_rgb(0xe7, 0xeb, 0xf0),
    hovered: Color32::from_rgb(0xd8, 0xdf, 0xe7),
    line: Color32::from_rgb(0xd2, 0xd9, 0xe1),
    text: Color32::from_rgb(0x1a, 0x22, 0x2d),
    weak: Color32::from_rgb(0x5b, 0x68, 0x79),
    accent: Color32::from_rgb(0x0f, 0x7f, 0x78),
    on_accent: Color32::WHITE,
    warning: Color32::from_rgb(0x7a, 0x52, 0x00),
    warning_ground: Color32::from_rgb(0xfd, 0xf0, 0xd0),
};

/// Behind slices and their letters, in both themes: pictures are judged on black.
pub const VIEW_GROUND: Color32 = Color32::from_rgb(0x05, 0x06, 0x08);
/// Letters on pictures.
pub const ON_VIEW: Color32 = Color32::from_rgb(0xc8, 0xd2, 0xde);

/// The colours in use.
pub fn palette(is_dark: bool) -> Palette {
    if is_dark { DARK } else { LIGHT }
}

/// Rounding of cards and buttons.
pub const RADIUS: CornerRadius = CornerRadius::same(7);

/// Sets both themes up; which is in use is up to [`choose`].
pub fn apply(context: &egui::Context) {
    for (theme, is_dark) in [(Theme::Dark, true), (Theme::Light, false)] {
        context.style_mut_of(theme, |style| {
            style.visuals = visuals(is_dark);
            let sizes = [
                (TextStyle::Small, 12.0),
                (TextStyle::Body, 14.0),
                (TextStyle::Button, 14.0),
                (TextStyle::Heading, 19.0),
            ];
            for (name, size) in sizes {
                style.text_styles.insert(name, FontId::new(size, FontFamily::Proportional));
            }
            style.text_styles.insert(TextStyle::Monospace, FontId::new(12.5, FontFamily::Monospace));
            let spacing = &mut style.spacing;
            spacing.item_spacing = egui::vec2(8.0, 8.0);
            spacing.button_padding = egui::vec2(11.0, 6.0);
            spacing.interact_size = egui::vec2(40.0, 28.0);
            spacing.menu_margin = Margin::same(8);
            spacing.slider_width = 132.0;
            spacing.slider_rail_height = 4.0;
            spacing.scroll = egui::style::ScrollStyle::thin();
        });
    }
}

/// Shows one of the themes.
pub fn choose(context: &egui::Context, is_dark: bool) {
    context.set_theme(if is_dark { Theme::Dark } else { Theme::Light });
}

fn visuals(is_dark: bool) -> Visuals {
    let p = palette(is_dark);
    let mut visuals = if is_dark { Visuals::dark() } else { Visuals::light() };
    let widget = |fill: Color32, line: Color32, text: Color32| WidgetVisuals {
        bg_fill: fill,
        weak_bg_fill: fill,
        bg_stroke: Stroke::new(1.0, line),
        corner_radius: RADIUS,
        fg_stroke: Stroke::new(1.2, text),
        expansion: 0.0,
    };
    visuals.widgets.noninteractive = widget(p.panel, p.line, p.text);
    visuals.widgets.inactive = widget(p.raised, p.hovered, p.text);
    visuals.widgets.hovered = widget(p.hovered, p.line, p.text);
    visuals.widgets.active = widget(p.hovered, p.accent, p.text);
    visuals.widgets.open = widget(p.hovered, p.line, p.text);
    visuals.selection.bg_fill = p.accent.gamma_multiply(if is_dark { 0.55 } else { 0.75 });
    visuals.selection.stroke = Stroke::new(1.2, if is_dark { p.text } else { Color32::WHITE });
    visuals.hyperlink_color = p.accent;
    visuals.weak_text_color = Some(p.weak);
    visuals.panel_fill = p.panel;
    visuals.window_fill = p.panel;
    visuals.window_stroke = Stroke::new(1.0, p.line);
    visuals.window_corner_radius = CornerRadius::same(12);
    visuals.menu_corner_radius = CornerRadius::same(9);
    visuals.extreme_bg_color = p.ground;
    visuals.faint_bg_color = p.raised;
    visuals.warn_fg_color = p.warning;
    visuals.error_fg_color = p.warning;
    visuals.popup_shadow =
        Shadow { offset: [0, 6], blur: 18, spread: 0, color: Color32::from_black_alpha(70) };
    visuals.window_shadow =
        Shadow { offset: [0, 10], blur: 30, spread: 0, color: Color32::from_black_alpha(90) };
    visuals.slider_trailing_fill = true;
    visuals.handle_shape = egui::style::HandleShape::Circle;
    visuals
}

/// The one thing to press: a button of the accent's colour.
pub fn primary(p: &Palette, text: &str) -> egui::Button<'static> {
    egui::Button::new(egui::RichText::new(text).color(p.on_accent).strong()).fill(p.accent)
}
