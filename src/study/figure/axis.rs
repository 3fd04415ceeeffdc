//! How heights of a chart are shown: from zero, in decades, or in percent.

use super::{Series, short};

/// At most this many decades are shown.
const MOST_DECADES: i32 = 6;

/// How heights are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Axis {
    /// From zero to a round number, and below zero where values are.
    #[default]
    FromZero,
    /// In decades. What is not above zero has no place on it.
    Log,
    /// Shares from 0 to 1, in percent.
    Percent,
}

/// Heights in pixels, and the heights that are marked.
pub(super) struct Heights {
    axis: Axis,
    /// Lowest and highest value that is shown; of a logarithmic axis, their decimal logarithms.
    ends: [f64; 2],
    pub(super) marked: Vec<(f64, String)>,
}

impl Heights {
    pub(super) fn of(axis: Axis, series: &[Series]) -> Self {
        let values = || {
            series
                .iter()
                .flat_map(|series| series.points.iter().flatten().copied())
                .filter(|value| value.is_finite())
        };
        match axis {
            Axis::FromZero => {
                let farthest = |of: fn(f64, f64) -> f64| values().fold(0.0, of);
                let (least, most) = (farthest(f64::min), farthest(f64::max));
                let (end, steps) = scale(most.max(-least));
                let step = end / steps as f64;
                // Round numbers beyond the values on either side; where there are none, zero.
                let below = (least / step + 1e-6).floor() as i32;
                let above = if least < 0.0 {
                    (most / step - 1e-6).ceil() as i32
                } else {
                    steps as i32
                };
                let at = |line: i32| end * f64::from(line) / steps as f64;
                Self {
                    axis,
                    ends: [at(below), at(above)],
                    marked: (below..=above)
                        .map(|line| (at(line), short(at(line))))
                        .collect(),
                }
            }
            Axis::Percent => Self {
                axis,
                ends: [0.0, 1.0],
                marked: (0..=5)
                    .map(|step| (f64::from(step) / 5.0, format!("{} %", 20 * step)))
                    .collect(),
            },
            Axis::Log => Self::decades(values().filter(|value| *value > 0.0)),
        }
    }

    /// From the last of 1, 2, 5 below all values to the first above them.
    fn decades(values: impl Iterator<Item = f64>) -> Self {
        let [least, most] = values.fold([f64::INFINITY, 0.0], |[least, most], value| {
            [value.min(least), value.max(most)]
        });
        let most = if most > 0.0 { most } else { 1.0 };
        let least = least.min(most).max(most * 10f64.powi(-MOST_DECADES));
        let first = least.log10().floor() as i32;
        let round: Vec<f64> = (first..=most.log10().floor() as i32 + 1)
            .flat_map(|decade| [1.0, 2.0, 5.0].map(|digit| digit * 10f64.powi(decade)))
            .collect();
        let low = round
            .iter()
            .rposition(|value| *value <= least * 1.001)
            .unwrap_or(0);
        let high = round.iter().position(|value| *value >= most * 0.999);
        let marked = &round[low..=high.unwrap_or(round.len() - 1).max(low + 1)];
        // Where there are many decades, only their beginnings are marked.
        let all = marked.len() <= 10;
        Self {
            axis: Axis::Log,
            ends: [marked[0].log10(), marked[marked.len() - 1].log10()],
            marked: marked
                .iter()
                .filter(|value| all || (value.log10() - value.log10().round()).abs() < 1e-9)
                .map(|value| (*value, short(*value)))
                .collect(),
        }
    }

    /// Share of the way up, 0 to 1.
    pub(super) fn share(&self, value: f64) -> f64 {
        let value = match self.axis {
            Axis::Log => value.max(f64::MIN_POSITIVE).log10(),
            Axis::FromZero | Axis::Percent => value,
        };
        ((value - self.ends[0]) / (self.ends[1] - self.ends[0])).clamp(0.0, 1.0)
    }
}

/// A round number at or above a value, and how many steps make it.
fn scale(highest: f64) -> (f64, usize) {
    if highest <= 0.0 || !highest.is_finite() {
        return (1.0, 4);
    }
    let unit = 10f64.powf(highest.log10().floor());
    for (factor, steps) in [
        (1.0, 5),
        (1.5, 3),
        (2.0, 4),
        (3.0, 3),
        (4.0, 4),
        (5.0, 5),
        (6.0, 3),
        (8.0, 4),
    ] {
        if highest <= factor * unit * 1.000_001 {
            return (factor * unit, steps);
        }
    }
    (10.0 * unit, 5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_below_zero_have_their_place() {
        let heights = |values: &[f64]| {
            let series = Series {
                points: values.iter().map(|value| [*value; 3]).collect(),
                ..Series::default()
            };
            Heights::of(Axis::FromZero, &[series])
        };
        let marked = |values: &[f64]| -> Vec<String> {
            let marked = heights(values).marked;
            marked.into_iter().map(|(_, name)| name).collect()
        };
        assert_eq!(marked(&[0.55]), ["0", "0.2", "0.4", "0.6"]);
        assert_eq!(
            marked(&[-1.28, 0.55]),
            ["-1.5", "-1", "-0.5", "0", "0.5", "1"]
        );
        assert_eq!(
            marked(&[-0.5]),
            ["-0.5", "-0.4", "-0.3", "-0.2", "-0.1", "0"]
        );
        let mixed = heights(&[-1.28, 0.55]);
        assert!((mixed.share(0.0) - 0.6).abs() < 1e-12);
        assert!((mixed.share(-1.28) - 0.088).abs() < 1e-12);
    }

    #[test]
    fn decades_begin_and_end_at_round_numbers() {
        let marked = |values: &[f64]| -> Vec<String> {
            let heights = Heights::decades(values.iter().copied());
            heights.marked.into_iter().map(|(_, name)| name).collect()
        };
        assert_eq!(marked(&[0.13, 1.7]), ["0.1", "0.2", "0.5", "1", "2"]);
        assert_eq!(marked(&[3.0]), ["2", "5"]);
        assert_eq!(
            marked(&[1e-4, 70.0]),
            ["0.0001", "0.001", "0.01", "0.1", "1", "10", "100"]
        );
        assert!(
            !marked(&[]).is_empty(),
            "nothing to show is no reason to fail"
        );
        let heights = Heights::decades([0.1, 10.0].into_iter());
        assert!((heights.share(1.0) - 0.5).abs() < 1e-12);
    }
}
