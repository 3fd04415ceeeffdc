//! The table of signal quality.

use egui::Ui;

use super::health::{Health, POOR_RECIPROCITY, POOR_SNR_DB, worst_channels};
use crate::gui::playing::Playing;
use crate::gui::problem::{SLOW_FRAMES_PER_S, electrode_list};
use crate::gui::theme;

/// Number of poor channels that are listed.
const LISTED: usize = 6;

/// A row: name, value, and whether the value is good, where that can be said.
type Row = (&'static str, String, Option<bool>);

/// Draws the table; a mark beside a value says whether it is good.
pub fn health_table(ui: &mut Ui, playing: &Playing, figures: &Health) {
    let palette = theme::palette_of(ui);
    let grid = egui::Grid::new("health").num_columns(3);
    grid.spacing([10.0, 5.0]).show(ui, |ui| {
        let table = view_rows(playing)
            .into_iter()
            .chain(figure_rows(playing, figures));
        for (name, value, good) in table {
            ui.weak(name);
            ui.monospace(value);
            match good {
                Some(true) => theme::mark(ui, palette.good, "✔", "good"),
                Some(false) => theme::mark(ui, palette.warn, "⚠", "poor"),
                None => {}
            }
            ui.end_row();
        }
    });
}

fn view_rows(playing: &Playing) -> Vec<Row> {
    let view = &playing.view;
    let rate = playing.frames_per_s();
    let rate_is_good = (view.frames > 0).then_some(rate >= SLOW_FRAMES_PER_S);
    let lost = &view.lost_electrodes;
    let has_frames = view.frames > 0;
    let lost_list = if !has_frames {
        "not yet known".to_owned()
    } else if lost.is_empty() {
        "none".to_owned()
    } else {
        electrode_list(lost)
    };
    vec![
        ("frame rate", format!("{rate:.0} frames/s"), rate_is_good),
        ("channels", view.signals.volts.len().to_string(), None),
        (
            "lost frames",
            view.lost_frames.to_string(),
            has_frames.then_some(view.lost_frames == 0),
        ),
        (
            "lost electrodes",
            lost_list,
            has_frames.then_some(lost.is_empty()),
        ),
    ]
}

fn figure_rows(playing: &Playing, figures: &Health) -> Vec<Row> {
    // Without a touch, all that changes is noise, and none of it is explained.
    let residual = figures
        .residual
        .filter(|_| !playing.view.touches.is_empty());
    let percent = |share: f64| format!("{:.2} %", share * 100.0);
    let snr_db = figures.median_snr_db;
    let reciprocity = figures.reciprocity;
    let drift = figures.drift.iter().map(|d| d.abs()).fold(0.0, f64::max);
    let mut rows = vec![
        (
            "signal to noise",
            snr_db.map_or("not yet known".to_owned(), |db| format!("{db:.0} dB")),
            snr_db.map(|db| db >= POOR_SNR_DB),
        ),
        (
            "reciprocity error",
            reciprocity.map_or("not measurable".to_owned(), percent),
            reciprocity.map(|share| share < POOR_RECIPROCITY),
        ),
        ("largest drift", percent(drift), None),
        (
            "not explained",
            residual.map_or("no touch found".to_owned(), |r| {
                format!("{:.0} % of the change", r * 100.0)
            }),
            None,
        ),
    ];
    let poor = worst_channels(figures, LISTED);
    if !poor.is_empty() {
        let numbers: Vec<String> = poor.iter().map(ToString::to_string).collect();
        rows.push(("worst channels", numbers.join(", "), Some(false)));
    }
    rows
}
