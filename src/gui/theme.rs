//! Colours of the dark and the light theme, text sizes, spacing.
//!
//! Colour is never the only cue: there is always a mark, a word or a thicker edge too. Touch colours can be distinguished with any
//! colour vision (Okabe and Ito 2008).

use egui::{Color32, CornerRadius, FontFamily, FontId, Margin, Stroke, TextStyle, Theme, Visuals};

/// The colours of a theme.
#[derive(Clone, Copy, Debug)]
pub struct Palette {
    /// The background.
    pub ground: Color32,
    /// Cards and panels.
    pub card: Color32,
    /// Thin lines.
    pub line: Color32,
    /// Text.
    pub text: Color32,
    /// Secondary text.
    pub weak: Color32,
    /// Selected, held or highlighted.
    pub accent: Color32,
    /// Text on the accent.
    pub on_accent: Color32,
    /// Works.
    pub good: Color32,
    /// Warning.
    pub warn: Color32,
    /// Error.
    pub bad: Color32,
}

/// Width of a scroll bar, points.
const SCROLL_BAR_POINTS: f32 = 14.0;

/// How far the pointer may move within a click, points: hands that shake. Dragging begins beyond.
const CLICK_POINTS: f32 = 12.0;

const DARK: Palette = Palette {
    ground: Color32::from_rgb(0x12, 0x12, 0x1a),
    card: Color32::from_rgb(0x1c, 0x1c, 0x27),
    line: Color32::from_rgb(0x3a, 0x3a, 0x4c),
    text: Color32::from_rgb(0xee, 0xec, 0xf2),
    weak: Color32::from_rgb(0xa9, 0xa6, 0xb8),
    accent: Color32::from_rgb(0xf9, 0xa0, 0x2c),
    on_accent: Color32::from_rgb(0x1a, 0x12, 0x08),
    good: Color32::from_rgb(0x4f, 0xd0, 0x9b),
    warn: Color32::from_rgb(0xf3, 0xc9, 0x4b),
    bad: Color32::from_rgb(0xff, 0x7a, 0x70),
};

const LIGHT: Palette = Palette {
    ground: Color32::from_rgb(0xf5, 0xf3, 0xef),
    card: Color32::from_rgb(0xff, 0xff, 0xff),
    line: Color32::from_rgb(0xcd, 0xc8, 0xc0),
    text: Color32::from_rgb(0x22, 0x1f, 0x2b),
    weak: Color32::from_rgb(0x66, 0x61, 0x70),
    accent: Color32::from_rgb(0xb4, 0x52, 0x09),
    on_accent: Color32::from_rgb(0xff, 0xff, 0xff),
    good: Color32::from_rgb(0x0a, 0x74, 0x50),
    warn: Color32::from_rgb(0x8a, 0x5b, 0x00),
    bad: Color32::from_rgb(0xb3, 0x26, 0x1e),
};

/// Colours of touches, used in turn. Light, as the picture of the pad is dark in both themes.
const TOUCHES: [Color32; 6] = [
    Color32::from_rgb(0x56, 0xb4, 0xe9),
    Color32::from_rgb(0x8d, 0xe0, 0xa6),
    Color32::from_rgb(0xf0, 0xe4, 0x42),
    Color32::from_rgb(0xff, 0xa8, 0xd6),
    Color32::from_rgb(0xb8, 0xa6, 0xff),
    Color32::from_rgb(0xff, 0xff, 0xff),
];

/// Corner radius of cards and buttons, points.
pub const ROUND: u8 = 7;
/// Smallest side of a button, points: a smaller one is hard to hit.
pub const MIN_TARGET: f32 = 24.0;
/// Pages narrower than this show their parts below each other, points: large text in a small window.
pub const COLUMN: f32 = 500.0;

/// The palette of the theme that a `Ui` is drawn with.
pub fn palette_of(ui: &egui::Ui) -> Palette {
    palette(ui.visuals().dark_mode)
}

/// The palette of a theme.
pub fn palette(dark: bool) -> Palette {
    if dark { DARK } else { LIGHT }
}

/// The colour of a touch on the picture of the pad.
pub fn touch(id: u64) -> Color32 {
    TOUCHES[(id % TOUCHES.len() as u64) as usize]
}

/// Adds a fallback font for arrows, dots and triangles. Call before the first pass.
pub fn install_fonts(ctx: &egui::Context) {
    let mut fonts = egui::FontDefinitions::default();
    if let Some(family) = fonts.families.get_mut(&FontFamily::Proportional) {
        family.push("Hack".to_owned());
    }
    ctx.set_fonts(fonts);
}

/// Sets the style of both themes. A click may take as long as it likes: slow hands.
pub fn apply_style(ctx: &egui::Context) {
    ctx.options_mut(|options| {
        options.input_options.max_click_duration = f64::INFINITY;
        options.input_options.max_click_dist = CLICK_POINTS;
    });
    for theme in [Theme::Dark, Theme::Light] {
        ctx.style_mut_of(theme, |style| {
            style.visuals = visuals(theme == Theme::Dark);
            let font = |size| FontId::new(size, FontFamily::Proportional);
            style.text_styles = [
                (TextStyle::Small, font(12.0)),
                (TextStyle::Body, font(14.5)),
                (TextStyle::Button, font(14.5)),
                (TextStyle::Heading, font(21.0)),
                (
                    TextStyle::Monospace,
                    FontId::new(13.0, FontFamily::Monospace),
                ),
            ]
            .into();
            style.spacing.item_spacing = egui::vec2(8.0, 7.0);
            // Bars that are always seen and wide enough to be hit: not everybody has a wheel.
            style.spacing.scroll = egui::style::ScrollStyle {
                bar_width: SCROLL_BAR_POINTS,
                floating_width: 0.6 * SCROLL_BAR_POINTS,
                floating_allocated_width: SCROLL_BAR_POINTS,
                handle_min_length: 3.0 * SCROLL_BAR_POINTS,
                dormant_background_opacity: 0.2,
                dormant_handle_opacity: 0.5,
                ..egui::style::ScrollStyle::floating()
            };
            // A hand that shakes never holds the pointer still over something.
            style.interaction.show_tooltips_only_when_still = false;
            style.interaction.tooltip_delay = 0.0;
            style.spacing.button_padding = egui::vec2(11.0, 6.0);
            style.spacing.interact_size.y = 28.0;
            style.spacing.slider_width = 150.0;
        });
    }
}

/// Draws text around a point.
pub fn centred_text(
    painter: &egui::Painter,
    at: egui::Pos2,
    text: impl ToString,
    size: f32,
    colour: Color32,
) {
    let font = FontId::proportional(size);
    painter.text(at, egui::Align2::CENTER_CENTER, text, font, colour);
}

/// A card: a rounded background.
pub fn card(ui: &egui::Ui) -> egui::Frame {
    let palette = palette_of(ui);
    egui::Frame::new()
        .fill(palette.card)
        .stroke(Stroke::new(1.0, palette.line.gamma_multiply(0.6)))
        .corner_radius(CornerRadius::same(ROUND + 2))
        .inner_margin(Margin::symmetric(12, 10))
}

/// A highlighted button: the main action.
pub fn primary(ui: &mut egui::Ui, text: &str) -> egui::Response {
    let palette = palette_of(ui);
    let text = egui::RichText::new(text).color(palette.on_accent);
    ui.add(egui::Button::new(text).fill(palette.accent))
}

/// A button that is highlighted while it is the way on.
pub fn way_on(ui: &mut egui::Ui, text: &str, is_way_on: bool) -> egui::Response {
    match is_way_on {
        true => primary(ui, text),
        false => ui.button(text),
    }
}

/// A button with small text, large enough to be hit.
pub fn small_button(ui: &mut egui::Ui, text: &str) -> egui::Response {
    let size = egui::Vec2::splat(MIN_TARGET);
    ui.add(egui::Button::new(text).small().min_size(size))
}

/// Keeps the focus in a line of text when Enter ends it: otherwise Tab would start from the top of the window.
pub fn keep_focus_on_enter(ui: &egui::Ui, field: &egui::Response) {
    if field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter)) {
        field.request_focus();
    }
}

/// A coloured symbol with a word for screen readers and as its tooltip.
pub fn mark(ui: &mut egui::Ui, colour: Color32, symbol: &str, word: &str) {
    let response = ui.colored_label(colour, symbol);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, word));
    response.on_hover_text(word);
}

/// The title of a card or of a part of a view.
pub fn title(ui: &mut egui::Ui, text: &str) -> egui::Response {
    let palette = palette_of(ui);
    ui.label(
        egui::RichText::new(text)
            .size(12.5)
            .color(palette.weak)
            .strong(),
    )
}

/// A card as wide as the room, with a title.
pub fn titled_card<R>(
    ui: &mut egui::Ui,
    text: &str,
    contents: impl FnOnce(&mut egui::Ui) -> R,
) -> R {
    let card = card(ui).show(ui, |ui| {
        ui.set_width(ui.available_width());
        title(ui, text);
        contents(ui)
    });
    card.inner
}

fn visuals(dark: bool) -> Visuals {
    let palette = palette(dark);
    let mut visuals = if dark {
        Visuals::dark()
    } else {
        Visuals::light()
    };
    visuals.panel_fill = palette.ground;
    visuals.window_fill = palette.card;
    visuals.window_stroke = Stroke::new(1.0, palette.line);
    visuals.extreme_bg_color = if dark {
        Color32::from_rgb(0x0d, 0x0d, 0x13)
    } else {
        Color32::from_rgb(0xfb, 0xfa, 0xf8)
    };
    visuals.faint_bg_color = palette.card;
    visuals.weak_text_color = Some(palette.weak);
    visuals.hyperlink_color = palette.accent;
    visuals.warn_fg_color = palette.warn;
    visuals.error_fg_color = palette.bad;
    visuals.selection.bg_fill = palette
        .accent
        .gamma_multiply(if dark { 0.35 } else { 0.25 });
    visuals.selection.stroke = Stroke::new(1.5, palette.accent);
    visuals.slider_trailing_fill = true;
    style_widgets(&mut visuals.widgets, &palette, dark);
    visuals
}

/// Fill, edge and corners of buttons and other widgets in each state.
fn style_widgets(widgets: &mut egui::style::Widgets, palette: &Palette, dark: bool) {
    let lift = |colour: Color32, by: i16| {
        let [r, g, b, _] = colour.to_array().map(i16::from);
        let shift = |c: i16| (c + by).clamp(0, 255) as u8;
        Color32::from_rgb(shift(r), shift(g), shift(b))
    };
    let step = if dark { 14 } else { -12 };
    for (widget, fill, edge) in [
        (&mut widgets.noninteractive, palette.card, palette.line),
        (
            &mut widgets.inactive,
            lift(palette.card, step),
            palette.line,
        ),
        (
            &mut widgets.hovered,
            lift(palette.card, 2 * step),
            palette.weak,
        ),
        (
            &mut widgets.active,
            lift(palette.card, 3 * step),
            palette.accent,
        ),
        (&mut widgets.open, lift(palette.card, step), palette.weak),
    ] {
        widget.bg_fill = fill;
        widget.weak_bg_fill = fill;
        widget.bg_stroke = Stroke::new(1.0, edge);
        widget.fg_stroke = Stroke::new(1.2, palette.text);
        widget.corner_radius = CornerRadius::same(ROUND);
        widget.expansion = 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Contrast ratio of two colours (WCAG 2.2).
    fn contrast(a: Color32, b: Color32) -> f64 {
        let luminance = |colour: Color32| {
            let linear = |c: u8| {
                let c = f64::from(c) / 255.0;
                if c <= 0.04045 {
                    c / 12.92
                } else {
                    ((c + 0.055) / 1.055).powf(2.4)
                }
            };
            0.2126 * linear(colour.r()) + 0.7152 * linear(colour.g()) + 0.0722 * linear(colour.b())
        };
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn every_text_colour_is_readable_on_every_background() {
        for dark in [true, false] {
            let p = palette(dark);
            for ground in [p.ground, p.card] {
                for text in [p.text, p.weak, p.accent, p.good, p.warn, p.bad] {
                    let ratio = contrast(text, ground);
                    assert!(
                        ratio >= 4.5,
                        "dark {dark}: {text:?} on {ground:?}: {ratio:.2}"
                    );
                }
            }
            assert!(contrast(p.on_accent, p.accent) >= 4.5);
        }
    }
}
