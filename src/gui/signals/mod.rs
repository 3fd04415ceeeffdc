//! The view for those who build pads: voltages, changes, noise, reciprocity, drift and residual, channel by channel.

pub mod health;

use egui::{Color32, Rect, Ui, Vec2};
use egui_plot::{Bar, BarChart, HLine, Line, Plot, PlotPoints};

use self::health::{Health, POOR_RECIPROCITY, POOR_SNR_DB, worst_channels};
use super::picture::{Picture, Shown};
use super::playing::Playing;
use super::theme;

/// Bad channels that are named.
const NAMED: usize = 6;

/// What the plot shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kind {
    /// Voltages of the newest frame, and of the untouched pad.
    #[default]
    Voltages,
    /// Relative changes, and what touches explain of them.
    Changes,
    /// Signal-to-noise ratios.
    Noise,
    /// How far reciprocal channels differ.
    Reciprocity,
    /// Change of the untouched pad since the start.
    Drift,
    /// What touches do not explain.
    Residual,
}

impl Kind {
    const ALL: [Self; 6] = [
        Self::Voltages,
        Self::Changes,
        Self::Noise,
        Self::Reciprocity,
        Self::Drift,
        Self::Residual,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::Voltages => "Voltages",
            Self::Changes => "Changes",
            Self::Noise => "Noise",
            Self::Reciprocity => "Reciprocity",
            Self::Drift => "Drift",
            Self::Residual => "Residual",
        }
    }

    fn about(self) -> &'static str {
        match self {
            Self::Voltages => {
                "V/A or the board's unit: bars are the newest frame, the line is the untouched pad"
            }
            Self::Changes => {
                "percent against the untouched pad: bars are measured, the line is what touches explain"
            }
            Self::Noise => {
                "signal-to-noise ratio of each channel from frame to frame, dB: below the line is poor"
            }
            Self::Reciprocity => {
                "percent by which a channel differs from the one with drive and reading swapped"
            }
            Self::Drift => "percent by which the untouched pad has moved since the start",
            Self::Residual => "percent that touches do not explain",
        }
    }
}

/// The view's state.
#[derive(Default)]
pub struct SignalsView {
    /// What the plot shows.
    pub kind: Kind,
    picture: Picture,
}

impl SignalsView {
    /// Draws the view.
    pub fn ui(&mut self, ui: &mut Ui, playing: &Playing) {
        let signals = &playing.view.signals;
        let figures = health::health(signals, &playing.first_reference, &playing.pad.protocol);
        let room = ui.available_rect_before_wrap();
        let side = (room.width() * 0.32).clamp(220.0, 400.0);
        let plot_room = Rect::from_min_max(
            room.min,
            egui::pos2(room.right() - side - 12.0, room.bottom()),
        );
        let side_room = Rect::from_min_max(egui::pos2(room.right() - side, room.top()), room.max);
        ui.scope_builder(egui::UiBuilder::new().max_rect(plot_room), |ui| {
            ui.horizontal_wrapped(|ui| {
                for kind in Kind::ALL {
                    ui.selectable_value(&mut self.kind, kind, kind.name());
                }
            });
            ui.weak(self.kind.about());
            self.plot(ui, playing, &figures);
        });
        ui.scope_builder(egui::UiBuilder::new().max_rect(side_room), |ui| {
            egui::ScrollArea::vertical()
                .id_salt("signals side")
                .auto_shrink(false)
                .show(ui, |ui| {
                    ui.set_width(side - 6.0);
                    self.side(ui, playing, &figures);
                });
        });
        ui.advance_cursor_after_rect(room);
    }

    fn plot(&self, ui: &mut Ui, playing: &Playing, figures: &Health) {
        let palette = theme::of(ui);
        let signals = &playing.view.signals;
        let percent =
            |values: &[f32]| -> Vec<f64> { values.iter().map(|v| f64::from(*v) * 100.0).collect() };
        let plain = |values: &[f32]| -> Vec<f64> { values.iter().map(|v| f64::from(*v)).collect() };
        let (bars, line) = match self.kind {
            Kind::Voltages => (plain(&signals.volts), Some(plain(&signals.reference))),
            Kind::Changes => (percent(&signals.changes), Some(percent(&signals.explained))),
            Kind::Noise => {
                let ratios = figures.snr_db.iter().map(|snr| snr.unwrap_or(0.0));
                (ratios.collect(), None)
            }
            Kind::Reciprocity => {
                let shares = figures
                    .reciprocity_of
                    .iter()
                    .map(|r| r.unwrap_or(0.0) * 100.0);
                (shares.collect(), None)
            }
            Kind::Drift => (figures.drift.iter().map(|d| d * 100.0).collect(), None),
            Kind::Residual => {
                let rest: Vec<f32> = signals
                    .changes
                    .iter()
                    .zip(&signals.explained)
                    .map(|(change, explained)| change - explained)
                    .collect();
                (percent(&rest), None)
            }
        };
        if bars.is_empty() {
            ui.add_space(40.0);
            ui.vertical_centered(|ui| {
                ui.label("Nothing has been measured yet: the first frames are the untouched pad.")
            });
            return;
        }
        let muted = |channel: usize| figures.snr_db.get(channel).is_some_and(Option::is_none);
        let colour = |channel: usize| {
            if muted(channel) {
                palette.bad
            } else {
                palette.accent
            }
        };
        let chart: Vec<Bar> = bars
            .iter()
            .enumerate()
            .map(|(channel, value)| {
                Bar::new(channel as f64, *value)
                    .width(0.8)
                    .fill(colour(channel))
                    .stroke(egui::Stroke::NONE)
            })
            .collect();
        let limit = match self.kind {
            Kind::Noise => Some(POOR_SNR_DB),
            Kind::Reciprocity => Some(POOR_RECIPROCITY * 100.0),
            _ => None,
        };
        Plot::new(self.kind.name())
            .allow_scroll(false)
            .show_axes([true, true])
            .x_axis_label("channel")
            .height(ui.available_height())
            .show(ui, |plot| {
                plot.bar_chart(BarChart::new("measured", chart));
                if let Some(line) = line.filter(|line| !line.is_empty()) {
                    let points: PlotPoints<'_> = line
                        .iter()
                        .enumerate()
                        .map(|(channel, value)| [channel as f64, *value])
                        .collect();
                    plot.line(Line::new("model", points).color(palette.text).width(1.5));
                }
                if let Some(limit) = limit {
                    plot.hline(HLine::new("limit", limit).color(palette.bad));
                }
            });
    }

    fn side(&mut self, ui: &mut Ui, playing: &Playing, figures: &Health) {
        theme::card(ui).show(ui, |ui| {
            ui.set_width(ui.available_width());
            theme::title(ui, "health of the readings");
            rows(ui, playing, figures);
        });
        theme::card(ui).show(ui, |ui| {
            ui.set_width(ui.available_width());
            theme::title(ui, "electrodes");
            let width = ui.available_width();
            let (rect, _) = ui.allocate_exact_size(Vec2::new(width, width), egui::Sense::hover());
            let shown = Shown {
                regions: false,
                electrodes: true,
                scale: false,
            };
            self.picture
                .draw(ui, rect, playing, &playing.view.profile, shown);
        });
    }
}

/// The figures in words, each with a mark that does not depend on colour.
pub fn rows(ui: &mut Ui, playing: &Playing, figures: &Health) {
    let palette = theme::of(ui);
    let mark = |good: bool| -> (&'static str, Color32) {
        if good {
            ("✔", palette.good)
        } else {
            ("⚠", palette.warn)
        }
    };
    egui::Grid::new("health")
        .num_columns(3)
        .spacing([10.0, 5.0])
        .show(ui, |ui| {
            let mut row = |what: &str, value: String, good: Option<bool>| {
                ui.weak(what);
                ui.monospace(value);
                if let Some(good) = good {
                    let (sign, colour) = mark(good);
                    ui.colored_label(colour, sign);
                }
                ui.end_row();
            };
            let view = &playing.view;
            row(
                "rate",
                format!("{:.0} frames/s", view.frames_per_s),
                (view.frames > 0).then_some(view.frames_per_s >= 25.0),
            );
            row("channels", view.signals.volts.len().to_string(), None);
            let snr = figures.median_snr_db;
            row(
                "noise",
                snr.map_or("not yet".to_owned(), |db| format!("{db:.0} dB")),
                snr.map(|db| db >= POOR_SNR_DB),
            );
            let reciprocity = figures.reciprocity;
            row(
                "reciprocity",
                reciprocity.map_or("no pairs".to_owned(), |share| {
                    format!("{:.2} %", share * 100.0)
                }),
                reciprocity.map(|share| share < POOR_RECIPROCITY),
            );
            let drift = figures
                .drift
                .iter()
                .fold(0.0f64, |most, d| most.max(d.abs()));
            row("drift, at most", format!("{:.2} %", drift * 100.0), None);
            let residual = figures
                .residual
                .map_or("none".to_owned(), |r| format!("{:.0} %", r * 100.0));
            row("residual", residual, None);
            row(
                "lost frames",
                view.lost_frames.to_string(),
                Some(view.lost_frames == 0),
            );
            let lost: Vec<String> = view
                .lost_electrodes
                .iter()
                .map(|e| (e + 1).to_string())
                .collect();
            let words = if lost.is_empty() {
                "none".to_owned()
            } else {
                lost.join(", ")
            };
            row("lost electrodes", words, Some(lost.is_empty()));
            let bad = worst_channels(figures, NAMED);
            if !bad.is_empty() {
                let names: Vec<String> = bad.iter().map(ToString::to_string).collect();
                row("worst channels", names.join(", "), Some(false));
            }
        });
}
