//! Timing and tremor settings as sliders, beside what the player does right now: for the editor and for one person's settings.

use egui::Ui;

use super::playing::Playing;
use super::press;
use super::theme;
use crate::profile::Settings;
use crate::types::ms_from_nanos;

/// Steps of the slider for a notch of the wheel, and for a click of a button beside it.
const COARSE_STEPS: f64 = 10.0;
/// Width of the number beside a slider: of `2000 ms`.
const NUMBER_WIDTH: f32 = 70.0;

/// A setting with a slider. Its unit, ms or mm, is the end of its key.
pub(super) struct TimingSetting {
    pub(super) key: &'static str,
    pub(super) label: &'static str,
    pub(super) hint: &'static str,
    max: f64,
    /// Value in the profile.
    pub(super) value: fn(&Settings) -> f64,
    /// What the player does right now, in the same unit.
    pub(super) live: fn(&Playing) -> Option<f64>,
}

/// All settings, in the order of the sliders.
pub(super) const SETTINGS: [TimingSetting; 7] = [
    TimingSetting {
        key: "min_hold_ms",
        label: "Shortest press",
        hint: "A key stays down at least this long, so that every game sees it.",
        max: 200.0,
        value: |s| ms_from_nanos(s.min_hold_ns),
        live: last_press_ms,
    },
    TimingSetting {
        key: "min_gap_ms",
        label: "Shortest release",
        hint: "A key stays up at least this long between two presses.",
        max: 200.0,
        value: |s| ms_from_nanos(s.min_gap_ns),
        live: last_gap_ms,
    },
    TimingSetting {
        key: "slow_keys_ms",
        label: "Slow keys",
        hint: "A touch counts only after it was held this long.",
        max: 1000.0,
        value: |s| ms_from_nanos(s.slow_keys_ns),
        live: touch_age_ms,
    },
    TimingSetting {
        key: "bounce_keys_ms",
        label: "Bounce keys",
        hint: "A new press this soon after the last one is ignored.",
        max: 500.0,
        value: |s| ms_from_nanos(s.bounce_keys_ns),
        live: last_gap_ms,
    },
    TimingSetting {
        key: "dwell_ms",
        label: "Dwell",
        hint: "A touch counts only after it stayed in one place this long.",
        max: 2000.0,
        value: |s| ms_from_nanos(s.dwell_ns),
        live: touch_age_ms,
    },
    TimingSetting {
        key: "tremor_mm",
        label: "Tremor filter: distance",
        hint: "Movements shorter than this are ignored.",
        max: 20.0,
        value: |s| s.tremor_mm,
        live: moved_mm,
    },
    TimingSetting {
        key: "tremor_ms",
        label: "Tremor filter: time",
        hint: "A finger that lifts and comes back within this time counts as held.",
        max: 300.0,
        value: |s| ms_from_nanos(s.tremor_ns),
        live: last_gap_ms,
    },
];

/// Where the explanation of a setting stands.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum HintPlace {
    /// Shown while the pointer is over the label.
    Hover,
    /// In small letters below the slider.
    Below,
}

/// Draws a slider with buttons; the wheel turns it too. Returns its value and whether a change has ended.
pub(super) fn draw_slider(
    ui: &mut Ui,
    setting: &TimingSetting,
    value: f64,
    live: Option<f64>,
    hint: HintPlace,
) -> (f64, bool) {
    let unit = if setting.key.ends_with("_mm") {
        " mm"
    } else {
        " ms"
    };
    ui.horizontal(|ui| {
        let label = ui.label(setting.label);
        if hint == HintPlace::Hover {
            label.on_hover_text(setting.hint);
        }
        if let Some(live) = live {
            let side = if live >= value { "above" } else { "below" };
            let text = format!("you: {live:.0}{}, {side}", unit);
            let text = egui::RichText::new(text)
                .small()
                .color(theme::palette_of(ui).weak);
            ui.label(text);
        }
    });
    let step = if unit == " mm" { 0.5 } else { 1.0 };
    let row = ui.horizontal(|ui| {
        // The number and the two buttons stand beside the slider.
        ui.spacing_mut().slider_width = (ui.available_width() - 200.0).clamp(60.0, 420.0);
        // As wide as the widest number, so that the buttons stay where they are.
        ui.spacing_mut().interact_size.x = NUMBER_WIDTH;
        let mut wanted = value;
        let slider = egui::Slider::new(&mut wanted, 0.0..=setting.max)
            .suffix(unit)
            .custom_formatter(|value, _| short_number(value))
            .step_by(step);
        let response = ui.add(slider);
        response.widget_info(|| egui::WidgetInfo::slider(true, wanted, setting.label));
        // Coarse steps: a hand that shakes reaches a value in a few.
        let coarse = COARSE_STEPS * step;
        let by = coarse * wheel_notches(ui, &response) + coarse * clicked_steps(ui, setting.label);
        wanted = (wanted + by).clamp(0.0, setting.max);
        let (is_held, is_released) =
            ui.input(|input| (input.pointer.any_down(), input.pointer.any_released()));
        let is_final = response.drag_stopped() || is_released || (by != 0.0 && !is_held);
        (wanted, is_final)
    });
    if hint == HintPlace::Below {
        let text = egui::RichText::new(setting.hint).small().weak();
        ui.add(egui::Label::new(text).wrap());
    }
    row.inner
}

/// Steps of the buttons beside a slider: one a click, more while one is held.
pub(super) fn clicked_steps(ui: &mut Ui, label: &str) -> f64 {
    let mut steps = 0.0;
    for (symbol, word, by) in [("−", "Less", -1.0), ("+", "More", 1.0)] {
        let button = theme::small_button(ui, symbol);
        let name = format!("{word}: {label}");
        button.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, name.clone()));
        steps += by * f64::from(press::button_steps(ui, &button));
    }
    steps
}

/// Notches of the wheel over a slider that was clicked before; the page does not scroll then. Other sliders leave the wheel to the
/// page: scrolling past one changes nothing.
fn wheel_notches(ui: &Ui, slider: &egui::Response) -> f64 {
    if slider.clicked() || slider.drag_started() {
        slider.request_focus();
    }
    if !slider.hovered() || !slider.has_focus() {
        return 0.0;
    }
    ui.input_mut(|input| {
        input.smooth_scroll_delta = egui::Vec2::ZERO;
        let turned = input.events.iter().map(|event| match event {
            egui::Event::MouseWheel { unit, delta, .. } => press::notches(*unit, delta.y),
            _ => 0.0,
        });
        turned.sum::<f64>().round()
    })
}

fn last_press_ms(playing: &Playing) -> Option<f64> {
    let press = playing.history.last_press()?;
    Some(ms_from_nanos(press.length_ns(playing.history.now_ns)))
}

/// From the last release of an output to its next press.
fn last_gap_ms(playing: &Playing) -> Option<f64> {
    let presses = &playing.history.presses;
    let last = presses.back()?;
    let before = presses
        .iter()
        .rev()
        .skip(1)
        .find(|press| press.output == last.output)?;
    Some(ms_from_nanos(last.from_ns.saturating_sub(before.until_ns?)))
}

fn touch_age_ms(playing: &Playing) -> Option<f64> {
    let touch = playing.view.touches.last()?;
    let age_ns = playing.view.t_ns.saturating_sub(touch.since_ns);
    Some(ms_from_nanos(age_ns))
}

/// Distance of the newest touch from where it started.
fn moved_mm(playing: &Playing) -> Option<f64> {
    let stroke = playing.history.strokes.back()?;
    let (first, last) = (stroke.moments.front()?, stroke.moments.back()?);
    let [dx, dy] = [0, 1].map(|i| last.place_mm[i] - first.place_mm[i]);
    Some(dx.hypot(dy))
}

/// A number with one decimal, where it has one: `34`, `0.5`.
fn short_number(value: f64) -> String {
    match value.fract() == 0.0 {
        true => format!("{value:.0}"),
        false => format!("{value:.1}"),
    }
}
