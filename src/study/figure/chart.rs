//! Charts: lines over places or numbers, each point with its range.

use std::ops::Range;

use plotters::coord::ranged1d::{BoldPoints, DefaultFormatting, KeyPointHint, Ranged};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use super::{
    Area, CHART, DASH, Drawn, FONT, Figure, GREY, LINES, Picture, Sign, draw_legend, render, short,
};
use crate::stats::range;
use crate::study::StudyError;

/// Width of the legend, pixels: at least this, and this much for the sign and for each letter.
const LEGEND: (u32, u32, u32) = (180, 70, 7);
/// Distance between the ranges of two lines, as a share of half the mean distance of places.
const RANGE_SHIFT: f64 = 0.05;
/// Most decades of a logarithmic axis.
const MOST_DECADES: i32 = 6;
/// Most names along x.
const MOST_NAMES: usize = 12;

/// Scale of the y axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Axis {
    /// Linear; includes zero.
    #[default]
    FromZero,
    /// Logarithmic. Values that are not above zero are left out.
    Log,
    /// Shares from 0 to 1, shown in percent.
    Percent,
}

/// One line of a chart.
#[derive(Clone, Debug, Default)]
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// At each place: value, and least and greatest value of its range.
    pub points: Vec<[f64; 3]>,
    /// How it is drawn.
    pub look: Look,
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Look {
    /// Index of its colour; by default its place among the lines.
    pub colour: Option<usize>,
    /// Dashed and without dots: a bound or a comparison.
    pub dashed: bool,
}

/// A chart of lines over named places.
#[derive(Clone, Debug, Default)]
pub struct Chart {
    /// File name without ending.
    pub name: String,
    /// Its title.
    pub title: String,
    /// Label of the x axis.
    pub x_label: String,
    /// Label of the y axis, with unit.
    pub y_label: String,
    /// Names of the places along x.
    pub places: Vec<String>,
    /// Positions of the places along x, in any unit; evenly spaced if empty.
    pub positions: Vec<f64>,
    /// The lines.
    pub series: Vec<Series>,
    /// Scale of the y axis.
    pub axis: Axis,
    /// Lines of text under the legend.
    pub notes: Vec<String>,
}

/// A linear axis with marks at given coordinates.
struct Marked {
    range: Range<f64>,
    marks: Vec<f64>,
}

impl Ranged for Marked {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        RangedCoordf64::from(self.range.clone()).map(value, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.marks.clone()
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

impl Axis {
    /// Coordinate of a value.
    fn coordinate(self, value: f64) -> f64 {
        match self {
            Self::Log => value.log10(),
            Self::FromZero | Self::Percent => value,
        }
    }

    /// Text of a mark at a coordinate.
    fn mark(self, coordinate: f64) -> String {
        match self {
            Self::FromZero => short(coordinate),
            Self::Percent => format!("{} %", short(100.0 * coordinate)),
            Self::Log => short(10f64.powf(coordinate)),
        }
    }

    /// The range of coordinates that shows these values, and its marks.
    fn scale(self, values: impl Iterator<Item = f64>) -> Marked {
        let marks = match self {
            Self::Percent => (0..=5).map(|step| f64::from(step) / 5.0).collect(),
            Self::FromZero => linear_marks(range(values.chain([0.0]))),
            Self::Log => log_marks(range(values.filter(|value| *value > 0.0))),
        };
        Marked {
            range: marks[0]..marks[marks.len() - 1],
            marks,
        }
    }
}

/// Round numbers, the first and last at or beyond the ends.
fn linear_marks([least, most]: [f64; 2]) -> Vec<f64> {
    let most = if least < most { most } else { least + 1.0 };
    let inside = RangedCoordf64::from(least..most).key_points(BoldPoints(7));
    // Key points are sums; without their rounding the last mark could miss an end.
    let digits = 10f64.powi(9 - (inside[1] - inside[0]).log10().floor() as i32);
    let step = ((inside[1] - inside[0]) * digits).round() / digits;
    let first = (least / step + 1e-6).floor() as i32;
    let last = (most / step - 1e-6).ceil() as i32;
    (first..=last).map(|line| f64::from(line) * step).collect()
}

/// Decimal logarithms of 1, 2 and 5 times powers of ten, the first and last at or beyond the ends; of powers of ten alone
/// where there are many.
fn log_marks([least, most]: [f64; 2]) -> Vec<f64> {
    let most = if most > 0.0 { most } else { 1.0 };
    let least = least.min(most).max(most * 10f64.powi(-MOST_DECADES));
    let [low, high] = [least, most].map(f64::log10);
    let marks: Vec<f64> = (low.floor() as i32..=high.ceil() as i32)
        .flat_map(|decade| [1.0, 2.0, 5.0].map(|digit: f64| f64::from(decade) + digit.log10()))
        .collect();
    let first = marks
        .iter()
        .rposition(|mark| *mark <= low + 1e-3)
        .unwrap_or(0);
    let last = marks
        .iter()
        .position(|mark| *mark >= high - 1e-3 && *mark > marks[first]);
    let marks = &marks[first..=last.unwrap_or(marks.len() - 1)];
    let (ends, all) = ([0, marks.len() - 1], marks.len() <= 10);
    let is_shown =
        |(index, mark): &(usize, &f64)| all || ends.contains(index) || mark.fract() == 0.0;
    let shown = marks.iter().enumerate().filter(is_shown);
    shown.map(|(_, mark)| *mark).collect()
}

impl Look {
    fn colour(self, index: usize) -> RGBColor {
        LINES[self.colour.unwrap_or(index) % LINES.len()]
    }
}

impl Chart {
    /// Renders the chart.
    ///
    /// # Errors
    /// An error of the drawing library.
    pub fn draw(&self) -> Result<Figure, StudyError> {
        let caption = format!("{}: {} over {}", self.title, self.y_label, self.x_label);
        render(&self.name, &caption, CHART, self)
    }

    /// Positions of the places along x.
    fn x_positions(&self) -> Vec<f64> {
        if self.positions.is_empty() {
            (0..self.places.len()).map(|place| place as f64).collect()
        } else {
            self.positions.clone()
        }
    }

    /// All finite values, and the ends of their ranges.
    fn values(&self) -> impl Iterator<Item = f64> {
        let points = self.series.iter().flat_map(|series| &series.points);
        points.flatten().copied().filter(|value| value.is_finite())
    }

    fn legend_width(&self) -> u32 {
        let names = self.series.iter().map(|series| &series.name);
        let letters = names.chain(&self.notes).map(|name| name.chars().count());
        let (least, sign, letter) = LEGEND;
        least.max(sign + letter * letters.max().unwrap_or(0) as u32)
    }
}

impl Picture for Chart {
    fn draw_on<B: DrawingBackend>(&self, area: &Area<B>) -> Drawn<B> {
        let xs = self.x_positions();
        let [first, last] = range(xs.iter().copied());
        let margin = (last - first) / (2.0 * xs.len().max(2) as f64 - 2.0);
        let margin = if margin > 0.0 { margin } else { 0.5 };
        let named = xs
            .iter()
            .copied()
            .step_by(xs.len().div_ceil(MOST_NAMES).max(1));
        let y_axis = self.axis.scale(self.values());
        let (low, high) = (y_axis.range.start, y_axis.range.end);
        let x_axis = Marked {
            range: first - margin..last + margin,
            marks: named.collect(),
        };
        let area = area.titled(&self.title, (FONT, 19))?;
        let width = area.dim_in_pixel().0.saturating_sub(self.legend_width());
        let (plot, side) = area.split_horizontally(width);
        let mut chart = ChartBuilder::on(&plot)
            .margin(12)
            .x_label_area_size(46)
            .y_label_area_size(70)
            .build_cartesian_2d(x_axis, y_axis)?;
        let name = |x: &f64| {
            let place = xs.iter().position(|place| place == x);
            place
                .and_then(|place| self.places.get(place))
                .cloned()
                .unwrap_or_default()
        };
        chart
            .configure_mesh()
            .disable_x_mesh()
            .axis_style(GREY)
            .bold_line_style(GREY)
            .light_line_style(TRANSPARENT)
            .label_style((FONT, 14))
            .axis_desc_style((FONT, 15))
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .x_label_formatter(&name)
            .y_label_formatter(&|y| self.axis.mark(*y))
            .draw()?;
        self.draw_lines(&mut chart, &xs, [low, high])?;
        let series = self.series.iter().enumerate().map(|(index, series)| {
            let colour = series.look.colour(index);
            let sign = if series.look.dashed {
                Sign::Dashes(colour)
            } else {
                Sign::Line(colour)
            };
            (&series.name, sign)
        });
        let notes = self.notes.iter().map(|note| (note, Sign::None));
        draw_legend(&side, series.chain(notes))
    }
}

impl Chart {
    /// Draws the lines, with their dots and ranges.
    fn draw_lines<'a, B: DrawingBackend + 'a>(
        &self,
        chart: &mut ChartContext<'a, B, Cartesian2d<Marked, Marked>>,
        xs: &[f64],
        [low, high]: [f64; 2],
    ) -> Drawn<B> {
        let at = |x: f64, value: f64| (x, self.axis.coordinate(value).clamp(low, high));
        for (index, series) in self.series.iter().enumerate() {
            let colour = series.look.colour(index);
            let style = colour.stroke_width(2);
            let is_shown =
                |value: f64| value.is_finite() && (self.axis != Axis::Log || value > 0.0);
            let points = || {
                let points = xs.iter().copied().zip(series.points.iter().copied());
                points.filter(|(_, [value, ..])| is_shown(*value))
            };
            let line: Vec<(f64, f64)> = points().map(|(x, [value, ..])| at(x, value)).collect();
            if series.look.dashed {
                chart.draw_series(DashedLineSeries::new(line, DASH.0, DASH.1, style))?;
                continue;
            }
            chart.draw_series(LineSeries::new(line.iter().copied(), style))?;
            // Ranges of several lines stand side by side.
            let shift = RANGE_SHIFT * (2.0 * index as f64 - (self.series.len() - 1) as f64);
            let shift = shift * (xs[xs.len() - 1] - xs[0]) / xs.len() as f64;
            chart.draw_series(points().filter(|(_, [_, least, most])| most > least).map(
                |(x, [_, least, most])| {
                    PathElement::new([at(x + shift, least), at(x + shift, most)], colour)
                },
            ))?;
            chart.draw_series(
                line.iter()
                    .map(|point| Circle::new(*point, 4, colour.filled())),
            )?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn marks(axis: Axis, values: &[f64]) -> Vec<String> {
        let marks = axis.scale(values.iter().copied()).marks;
        marks.into_iter().map(|mark| axis.mark(mark)).collect()
    }

    #[test]
    fn linear_axes_include_zero_and_negative_values() {
        assert_eq!(marks(Axis::FromZero, &[0.55])[0], "0");
        for values in [&[0.55][..], &[-1.28, 0.55], &[-0.5], &[0.0], &[]] {
            let Marked { range, marks } = Axis::FromZero.scale(values.iter().copied());
            assert!(range.contains(&0.0) || range.end == 0.0, "{range:?}");
            assert!(values.iter().all(|v| (range.start..=range.end).contains(v)));
            assert!((3..=12).contains(&marks.len()), "{marks:?}");
        }
    }

    #[test]
    fn logarithmic_axes_begin_and_end_at_round_numbers() {
        assert_eq!(
            marks(Axis::Log, &[0.13, 1.7]),
            ["0.1", "0.2", "0.5", "1", "2"]
        );
        assert_eq!(marks(Axis::Log, &[3.0]), ["2", "5"]);
        assert_eq!(
            marks(Axis::Log, &[1e-4, 100.0]),
            ["0.0001", "0.001", "0.01", "0.1", "1", "10", "100"]
        );
        assert!(
            !marks(Axis::Log, &[]).is_empty(),
            "an empty chart has an axis"
        );
    }

    #[test]
    fn a_chart_is_drawn_in_both_formats_and_the_same_each_time() {
        let line = |dashed| Series {
            name: "one point".to_owned(),
            points: vec![[1.0, 0.5, 1.5], [2.0, 2.0, 2.0]],
            look: Look {
                colour: None,
                dashed,
            },
        };
        let chart = Chart {
            name: "c".to_owned(),
            title: "Title".to_owned(),
            x_label: "width".to_owned(),
            y_label: "change".to_owned(),
            places: vec!["solid".to_owned(), "1 mm".to_owned()],
            series: vec![line(false), line(true)],
            ..Chart::default()
        };
        let (a, b) = (chart.draw().expect("drawn"), chart.draw().expect("drawn"));
        for text in ["Title", "solid", "1 mm", "one point"] {
            assert!(a.svg.contains(text), "{text}");
        }
        assert_eq!(&a.png[1..4], b"PNG");
        assert_eq!((a.svg, a.png), (b.svg, b.png));
    }
}
