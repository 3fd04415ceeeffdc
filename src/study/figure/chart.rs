//! Lines over places or numbers, each point with its range.

use plotters::style::RGBColor;

use super::axis::{Axis, Heights};
use super::{CHART, Figure, GREY, LINES, Mark, both, text};
use crate::study::StudyError;

/// Lengths of a dash and of the gap behind it, pixels.
const DASH: (f64, f64) = (7.0, 5.0);

/// Room for the names of the lines: at least so much, and so much for their signs and each letter, pixels.
const LEGEND: (i32, i32, i32) = (180, 56, 7);

/// One line of a chart, with the range about each point if it has one.
#[derive(Clone, Debug, Default)]
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// Height at each place along x, least and greatest.
    pub points: Vec<[f64; 3]>,
    /// How it is drawn.
    pub look: Look,
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Look {
    /// Which colour; unless given, its place among the lines.
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
    /// Name of the x axis.
    pub x_label: String,
    /// Name and unit of the y axis.
    pub y_label: String,
    /// Names of the places along x.
    pub places: Vec<String>,
    /// Where along x they lie, in any unit; evenly if there are none.
    pub positions: Vec<f64>,
    /// The lines.
    pub series: Vec<Series>,
    /// How heights are shown.
    pub axis: Axis,
    /// Lines of text under the legend.
    pub notes: Vec<String>,
}

/// The box in which lines run, and pixels of places and heights in it.
struct Plot<'a> {
    chart: &'a Chart,
    heights: Heights,
    left: i32,
    right: i32,
    top: i32,
    bottom: i32,
}

impl Chart {
    /// Draws it.
    ///
    /// # Errors
    /// The drawing library's.
    pub fn draw(&self) -> Result<Figure, StudyError> {
        let caption = format!("{}: {} over {}", self.title, self.y_label, self.x_label);
        both(&self.name, &caption, CHART, |put| {
            self.compose(put);
            Ok(())
        })
    }

    pub(super) fn compose(&self, put: &mut dyn FnMut(Mark)) {
        let letters = self.series.iter().map(|series| series.name.chars().count());
        let (least, signs, letter) = LEGEND;
        let legend = least.max(signs + letter * letters.max().unwrap_or(0) as i32);
        let plot = Plot {
            chart: self,
            heights: Heights::of(self.axis, &self.series),
            left: 84,
            right: CHART.0 as i32 - legend,
            top: 48,
            bottom: CHART.1 as i32 - 58,
        };
        plot.frame(put);
        for (index, series) in self.series.iter().enumerate() {
            plot.line(index, series, put);
            plot.legend(index, series, put);
        }
        let below = plot.top + 10 + 22 * self.series.len() as i32 + 14;
        for (line, note) in self.notes.iter().enumerate() {
            let at = (plot.right + 14, below + 18 * line as i32);
            put(text(at, note, 13.0, -1));
        }
    }
}

impl Plot<'_> {
    fn x_of(&self, place: usize) -> i32 {
        let count = self.chart.places.len().max(1);
        let share = match self.chart.positions.get(place) {
            // Half a step of an even spacing stays free at each end.
            Some(position) => {
                let [least, most] = self.chart.positions.iter().fold(
                    [f64::INFINITY, f64::NEG_INFINITY],
                    |[least, most], value| [value.min(least), value.max(most)],
                );
                let within = if most > least {
                    (position - least) / (most - least)
                } else {
                    0.5
                };
                (0.5 + within * (count as f64 - 1.0)) / count as f64
            }
            None => (place as f64 + 0.5) / count as f64,
        };
        self.left + (f64::from(self.right - self.left) * share) as i32
    }

    fn at(&self, place: usize, value: f64) -> (i32, i32) {
        let up = f64::from(self.bottom - self.top) * self.heights.share(value);
        (self.x_of(place), self.bottom - up as i32)
    }

    /// Title, grid, names of the places and of the axes.
    fn frame(&self, put: &mut dyn FnMut(Mark)) {
        let chart = self.chart;
        let (left, right, bottom) = (self.left, self.right, self.bottom);
        put(text((left, 22), &chart.title, 19.0, -1));
        for (value, name) in &self.heights.marked {
            let (_, y) = self.at(0, *value);
            put(Mark::Line {
                points: vec![(left, y), (right, y)],
                colour: GREY,
                width: 1,
            });
            put(text((left - 8, y), name, 14.0, 1));
        }
        // Names along x, thinned out where they would run into each other.
        let every = chart.places.len().div_ceil(12).max(1);
        for (place, name) in chart.places.iter().enumerate().step_by(every) {
            put(text((self.x_of(place), bottom + 16), name, 14.0, 0));
        }
        put(text(
            ((left + right) / 2, bottom + 42),
            &chart.x_label,
            15.0,
            0,
        ));
        put(Mark::Text {
            at: (20, (self.top + bottom) / 2),
            text: chart.y_label.clone(),
            size: 15.0,
            anchor: 0,
            upright: true,
        });
    }

    fn line(&self, index: usize, series: &Series, put: &mut dyn FnMut(Mark)) {
        let colour = series.look.colour(index);
        let shown = |mean: f64| mean.is_finite() && (self.chart.axis != Axis::Log || mean > 0.0);
        let points = || {
            series
                .points
                .iter()
                .enumerate()
                .filter(|(_, [mean, ..])| shown(*mean))
        };
        let line = points()
            .map(|(place, [mean, ..])| self.at(place, *mean))
            .collect();
        stroke(line, colour, series.look.dashed, put);
        if series.look.dashed {
            return;
        }
        // Ranges of several lines stand side by side.
        let shift = 5 * (index as i32 - self.chart.series.len() as i32 / 2);
        for (place, [mean, least, most]) in points() {
            if most > least {
                let [from, to] = [*least, *most].map(|value| {
                    let (x, y) = self.at(place, value);
                    (x + shift, y)
                });
                put(Mark::Line {
                    points: vec![from, to],
                    colour,
                    width: 1,
                });
            }
            put(Mark::Dot {
                at: self.at(place, *mean),
                radius: 4,
                colour,
            });
        }
    }

    fn legend(&self, index: usize, series: &Series, put: &mut dyn FnMut(Mark)) {
        let y = self.top + 10 + 22 * index as i32;
        let line = vec![(self.right + 14, y), (self.right + 38, y)];
        stroke(line, series.look.colour(index), series.look.dashed, put);
        put(text((self.right + 44, y), &series.name, 14.0, -1));
    }
}

impl Look {
    fn colour(self, index: usize) -> RGBColor {
        LINES[self.colour.unwrap_or(index) % LINES.len()]
    }
}

/// A line, whole or in dashes.
fn stroke(points: Vec<(i32, i32)>, colour: RGBColor, dashed: bool, put: &mut dyn FnMut(Mark)) {
    const WIDTH: u32 = 2;
    if !dashed {
        put(Mark::Line {
            points,
            colour,
            width: WIDTH,
        });
        return;
    }
    let (on, off) = DASH;
    // Dashes run on over the corners.
    let mut along = 0.0;
    for pair in points.windows(2) {
        let [(ax, ay), (bx, by)] = [pair[0], pair[1]].map(|(x, y)| (f64::from(x), f64::from(y)));
        let length = (bx - ax).hypot(by - ay);
        let at = |s: f64| {
            let share = (s / length).clamp(0.0, 1.0);
            let [x, y] = [ax + share * (bx - ax), ay + share * (by - ay)];
            (x.round() as i32, y.round() as i32)
        };
        let mut start = -along;
        while start < length {
            if start + on > 0.0 {
                put(Mark::Line {
                    points: vec![at(start), at(start + on)],
                    colour,
                    width: WIDTH,
                });
            }
            start += on + off;
        }
        along = on + off - (start - length);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dashed_line_leaves_gaps_and_ends_where_it_should() {
        let mut drawn = Vec::new();
        stroke(
            vec![(0, 0), (30, 0), (30, 30)],
            LINES[0],
            true,
            &mut |mark| {
                if let Mark::Line { points, .. } = mark {
                    drawn.push((points[0], points[1]));
                }
            },
        );
        // Dashes of 7 and gaps of 5 along 60 pixels: from 0, 12, 24 (over the corner) and so on.
        let expected = [
            ((0, 0), (7, 0)),
            ((12, 0), (19, 0)),
            ((24, 0), (30, 0)),
            ((30, 0), (30, 1)),
            ((30, 6), (30, 13)),
            ((30, 18), (30, 25)),
        ];
        assert_eq!(drawn, expected);
    }

    #[test]
    fn a_chart_is_drawn_in_both_forms_and_the_same_each_time() {
        let chart = Chart {
            name: "c".to_owned(),
            title: "Title".to_owned(),
            x_label: "width".to_owned(),
            y_label: "change".to_owned(),
            places: vec!["solid".to_owned(), "1 mm".to_owned()],
            series: vec![Series {
                name: "one point".to_owned(),
                points: vec![[1.0, 0.5, 1.5], [2.0, 2.0, 2.0]],
                ..Series::default()
            }],
            ..Chart::default()
        };
        let (a, b) = (chart.draw().expect("drawn"), chart.draw().expect("drawn"));
        assert!(a.svg.contains("Title") && a.svg.starts_with("<svg"));
        assert_eq!(&a.png[1..4], b"PNG");
        assert_eq!((a.svg, a.png), (b.svg, b.png));
    }
}
