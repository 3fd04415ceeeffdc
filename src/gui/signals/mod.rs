//! The signals view, for people who build pads: voltage, change, noise, reciprocity error, drift and residual per channel.

pub mod health;
mod health_table;
mod quantity;

use egui::{Rect, Ui, Vec2};
use egui_plot::{Bar, BarChart, HLine, Line, Plot, PlotPoints};

pub use self::health_table::health_table;
pub use self::quantity::Quantity;

use self::health::Health;
use super::focus_ring::follow_focus;
use super::picture::{Picture, PictureLayers};
use super::playing::Playing;
use super::theme;

/// Width of the side panel: share of the window, minimum (that of its table) and maximum in points.
const SIDE: (f32, f32, f32) = (0.32, 282.0, 400.0);
/// Share of the height for the plot in a narrow window.
const PLOT_SHARE: f32 = 0.75;

/// The state of the view.
#[derive(Default)]
pub struct SignalsView {
    /// What the plot shows.
    pub quantity: Quantity,
    picture: Picture,
}

impl SignalsView {
    /// Draws the view.
    pub fn ui(&mut self, ui: &mut Ui, playing: &Playing) {
        let signals = &playing.view.signals;
        let figures =
            health::from_signals(signals, &playing.first_reference, &playing.pad.protocol);
        let room = ui.available_rect_before_wrap();
        if room.width() < theme::COLUMN {
            self.column(ui, room, playing, &figures);
            return;
        }
        let side = (room.width() * SIDE.0).clamp(SIDE.1, SIDE.2);
        let plot_room = Rect::from_min_max(
            room.min,
            egui::pos2(room.right() - side - 12.0, room.bottom()),
        );
        let side_room = Rect::from_min_max(egui::pos2(room.right() - side, room.top()), room.max);
        ui.scope_builder(egui::UiBuilder::new().max_rect(plot_room), |ui| {
            self.choose_quantity(ui);
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

    /// The plot, and the cards below it.
    fn column(&mut self, ui: &mut Ui, room: Rect, playing: &Playing, figures: &Health) {
        let column = egui::ScrollArea::vertical().id_salt("signals column");
        column.auto_shrink(false).show(ui, |ui| {
            self.choose_quantity(ui);
            let size = Vec2::new(ui.available_width(), room.height() * PLOT_SHARE);
            let (plot_room, _) = ui.allocate_exact_size(size, egui::Sense::hover());
            ui.scope_builder(egui::UiBuilder::new().max_rect(plot_room), |ui| {
                self.plot(ui, playing, figures);
            });
            self.side(ui, playing, figures);
            follow_focus(ui);
        });
    }

    fn choose_quantity(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            for quantity in Quantity::ALL {
                ui.selectable_value(&mut self.quantity, quantity, quantity.name());
            }
        });
        ui.weak(self.quantity.about());
    }

    fn plot(&self, ui: &mut Ui, playing: &Playing, figures: &Health) {
        let (values, model) = self.quantity.values(&playing.view.signals, figures);
        if values.is_empty() {
            ui.add_space(40.0);
            ui.vertical_centered(|ui| {
                ui.label("Nothing has been measured yet: the first frames are the reference.")
            });
            return;
        }
        let palette = theme::palette_of(ui);
        let bar = |(channel, value): (usize, &f64)| {
            let excluded = figures.snr_db.get(channel).is_some_and(Option::is_none);
            Bar::new(channel as f64, *value)
                .width(0.8)
                .fill(if excluded {
                    palette.bad
                } else {
                    palette.accent
                })
                .stroke(egui::Stroke::NONE)
        };
        let bars: Vec<Bar> = values.iter().enumerate().map(bar).collect();
        let shown = Plot::new(self.quantity.name())
            .allow_scroll(false)
            // A drag by accident would have no slow way back.
            .allow_drag(false)
            .allow_zoom(false)
            .allow_axis_zoom_drag(false)
            .allow_boxed_zoom(false)
            .show_axes([true, true])
            .x_axis_label("channel")
            .height(ui.available_height())
            .show(ui, |plot| {
                plot.bar_chart(BarChart::new("measured", bars));
                if !model.is_empty() {
                    let points = PlotPoints::from_ys_f64(&model);
                    plot.line(Line::new("model", points).color(palette.text).width(1.5));
                }
                if let Some(limit) = self.quantity.limit() {
                    plot.hline(HLine::new("limit", limit).color(palette.bad));
                }
            });
        let name = chart_name(self.quantity.name(), &values);
        shown
            .response
            .widget_info(|| egui::WidgetInfo::labeled(egui::Role::Canvas, true, &name));
    }

    fn side(&mut self, ui: &mut Ui, playing: &Playing, figures: &Health) {
        theme::titled_card(ui, "Signal quality", |ui| {
            health_table(ui, playing, figures)
        });
        theme::titled_card(ui, "Electrodes", |ui| {
            let size = Vec2::splat(ui.available_width());
            let (rect, _) = ui.allocate_exact_size(size, egui::Sense::hover());
            let shown = PictureLayers {
                image: true,
                regions: false,
                electrodes: true,
                scale: false,
            };
            self.picture
                .draw(ui, rect, playing, &playing.view.profile, shown);
        });
    }
}

/// A chart in words, for screen readers: `Changes, 208 channels, from -0.012 to 0.031, median 0.001`.
fn chart_name(quantity: &str, values: &[f64]) -> String {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let [low, median, high] = [0, sorted.len() / 2, sorted.len() - 1].map(|at| sorted[at]);
    let count = values.len();
    format!("{quantity}, {count} channels, from {low:.3} to {high:.3}, median {median:.3}")
}
