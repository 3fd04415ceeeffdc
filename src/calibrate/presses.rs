//! Presses at known places: what a calibration learns from, and their CSV form.
//!
//! A row is `x_mm,y_mm,d0,d1,...`: the place, and each channel's reading when pressed minus when untouched, in any unit. One row may
//! have no place: it holds the untouched readings in the same unit, which play needs. Files recorded by gelpad have three more columns
//! after the place, `force,model_x_mm,model_y_mm`: the force and place that the model found. Their differences are relative changes
//! (v - v0) / v0.

use faer::{Mat, MatRef};

use super::csv_rows::{self, CsvRow};
use super::error::{FEWEST_PRESSES, PressesError};
use crate::types::PointMm;

/// Presses lie on one line if their root mean square distance from it is below this share of their spread along it.
const LINE_SHARE: f64 = 0.01;
/// Columns of files recorded by gelpad.
const MODEL_COLUMNS: [&str; 3] = ["force", "model_x_mm", "model_y_mm"];

/// Force and place of a press according to the model, before any correction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelPrediction {
    /// Force, 0 to 1.
    pub force: f64,
    /// Place, mm.
    pub place_mm: PointMm,
}

/// One press.
#[derive(Clone, Debug, PartialEq)]
pub struct Press {
    /// The pressed place, mm.
    pub place_mm: PointMm,
    /// The model's prediction, where there is a model.
    pub modelled: Option<ModelPrediction>,
    /// Reading when pressed minus when untouched, for each channel.
    pub changes: Vec<f64>,
}

/// Presses of one pad: all with the same number of channels, and either all or none with a prediction.
#[derive(Clone, Debug, PartialEq)]
pub struct Presses {
    list: Vec<Press>,
    channels: usize,
    /// What the untouched pad reads, in the unit of the changes.
    untouched: Option<Vec<f64>>,
}

impl Presses {
    /// Checks presses; `name` is the file in messages.
    ///
    /// # Errors
    /// Too few presses; rows of different lengths; a change that is not a number; presses on one line or without any change.
    pub fn new(name: &str, list: Vec<Press>) -> Result<Self, PressesError> {
        if list.len() < FEWEST_PRESSES {
            return Err(PressesError::TooFew {
                name: name.to_owned(),
                found: list.len(),
            });
        }
        let channels = list[0].changes.len();
        let modelled = list[0].modelled.is_some();
        if let Some(odd) = list.iter().position(|press| {
            press.changes.len() != channels || press.modelled.is_some() != modelled
        }) {
            return Err(PressesError::Row {
                name: name.to_owned(),
                line: odd as u64 + 2,
                problem: "has other columns than the first row".to_owned(),
            });
        }
        let is_number = |press: &Press| press.changes.iter().all(|change| change.is_finite());
        if let Some(odd) = list.iter().position(|press| !is_number(press)) {
            return Err(PressesError::Row {
                name: name.to_owned(),
                line: odd as u64 + 2,
                problem: "has a change that is not a number".to_owned(),
            });
        }
        let presses = Self {
            list,
            channels,
            untouched: None,
        };
        let flat = |problem| {
            Err(PressesError::Flat {
                name: name.to_owned(),
                problem,
            })
        };
        let all: Vec<usize> = (0..presses.len()).collect();
        let places = presses.places(&all);
        if lie_on_a_line(places.as_ref()) {
            return flat("the presses lie on one line: spread them over the pad");
        }
        if presses
            .list
            .iter()
            .all(|press| press.changes.iter().all(|change| *change == 0.0))
        {
            return flat("no channel changes with any press: is the pad connected?");
        }
        Ok(presses)
    }

    /// Reads the text of a file; `name` is the file in messages.
    ///
    /// # Errors
    /// The first row that is wrong; see [`Self::new`].
    pub fn from_csv(name: &str, text: &str) -> Result<Self, PressesError> {
        let (_, rows) = csv_rows::read(name, text, Columns::from_header, Columns::row)?;
        let (mut list, mut untouched) = (Vec::new(), Vec::new());
        for row in rows {
            match row {
                PressRow::Press(press) => list.push(press),
                PressRow::Untouched(readings) => untouched.push(readings),
            }
        }
        let presses = Self::new(name, list)?;
        if untouched.len() > 1 {
            return Err(PressesError::Flat {
                name: name.to_owned(),
                problem: "several rows without a place: only one may hold the untouched readings",
            });
        }
        Ok(Self {
            untouched: untouched.pop(),
            ..presses
        })
    }

    /// Some of the presses.
    ///
    /// # Errors
    /// See [`Self::new`].
    pub fn some(&self, which: &[usize]) -> Result<Self, PressesError> {
        let list = which.iter().map(|press| self.list[*press].clone());
        Ok(Self {
            untouched: self.untouched.clone(),
            ..Self::new("the presses", list.collect())?
        })
    }

    /// The text that [`Self::from_csv`] reads.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let mut text = presses_csv(&self.list);
        if let Some(readings) = &self.untouched {
            let empty = if self.is_modelled() { 5 } else { 2 };
            text.push_str(&",".repeat(empty - 1));
            for reading in readings {
                text.push_str(&format!(",{reading}"));
            }
            text.push('\n');
        }
        text
    }

    /// Number of presses.
    #[must_use]
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Never true: there are at least [`FEWEST_PRESSES`].
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Number of channels.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Whether the presses contain the model's predictions.
    #[must_use]
    pub fn is_modelled(&self) -> bool {
        self.list[0].modelled.is_some()
    }

    /// The presses.
    #[must_use]
    pub fn list(&self) -> &[Press] {
        &self.list
    }

    /// Places of some presses, mm: presses by 2.
    #[must_use]
    pub fn places(&self, which: &[usize]) -> Mat<f64> {
        Mat::from_fn(which.len(), 2, |row, axis| {
            self.list[which[row]].place_mm[axis]
        })
    }

    /// Relative changes (v - v0) / v0 of some presses: presses by channels. `None` if the untouched readings v0 are not known.
    #[must_use]
    pub fn relative_changes(&self, which: &[usize]) -> Option<Mat<f64>> {
        let changes = self.changes(which);
        match &self.untouched {
            Some(untouched) => Some(Mat::from_fn(which.len(), self.channels, |row, channel| {
                changes[(row, channel)] / untouched[channel]
            })),
            None if self.is_modelled() => Some(changes),
            None => None,
        }
    }

    /// Changes of some presses: presses by channels.
    #[must_use]
    pub fn changes(&self, which: &[usize]) -> Mat<f64> {
        Mat::from_fn(which.len(), self.channels, |row, channel| {
            self.list[which[row]].changes[channel]
        })
    }
}

/// Presses as the text of a file, also fewer than [`Presses`] needs.
#[must_use]
pub fn presses_csv(list: &[Press]) -> String {
    let mut text = String::from("x_mm,y_mm");
    if list.first().is_some_and(|press| press.modelled.is_some()) {
        for title in MODEL_COLUMNS {
            text.push_str(&format!(",{title}"));
        }
    }
    for channel in 0..list.first().map_or(0, |press| press.changes.len()) {
        text.push_str(&format!(",d{channel}"));
    }
    text.push('\n');
    for press in list {
        let [x, y] = press.place_mm;
        text.push_str(&format!("{x},{y}"));
        if let Some(ModelPrediction { force, place_mm }) = press.modelled {
            text.push_str(&format!(",{force},{},{}", place_mm[0], place_mm[1]));
        }
        for change in &press.changes {
            text.push_str(&format!(",{change}"));
        }
        text.push('\n');
    }
    text
}

/// Whether places (presses by 2) lie on one line, in any direction, or all at one point: what they are spread across the line
/// is below [`LINE_SHARE`] of what they are spread along it.
fn lie_on_a_line(places: MatRef<'_, f64>) -> bool {
    let count = places.nrows() as f64;
    let mean = [0, 1].map(|axis| places.col(axis).sum() / count);
    let sum = |a: usize, b: usize| -> f64 {
        let off = |row: usize, axis: usize| places[(row, axis)] - mean[axis];
        (0..places.nrows())
            .map(|row| off(row, a) * off(row, b))
            .sum()
    };
    let (xx, xy, yy) = (sum(0, 0), sum(0, 1), sum(1, 1));
    // The product of the two principal spreads, and their sum.
    let (determinant, trace) = (xx * yy - xy * xy, xx + yy);
    determinant <= LINE_SHARE * LINE_SHARE * trace * trace
}

/// A row of a file.
enum PressRow {
    Press(Press),
    /// Without a place: the untouched readings.
    Untouched(Vec<f64>),
}

/// The columns of a file.
struct Columns {
    is_modelled: bool,
}

impl Columns {
    /// `None` if this is not the header of a file of presses.
    fn from_header(titles: &[String]) -> Option<Self> {
        let columns = Self {
            is_modelled: titles.get(2..5).is_some_and(|some| some == MODEL_COLUMNS),
        };
        let first = titles.get(columns.first_channel())?;
        (titles[..2] == ["x_mm", "y_mm"] && first == "d0").then_some(columns)
    }

    fn first_channel(&self) -> usize {
        if self.is_modelled { 5 } else { 2 }
    }

    fn row(&self, row: &CsvRow) -> Result<PressRow, String> {
        if !(0..self.first_channel()).all(|column| row.is_empty(column)) {
            return self.press(row).map(PressRow::Press);
        }
        let readings = row.numbers_from(self.first_channel())?;
        match readings.iter().position(|reading| *reading == 0.0) {
            None => Ok(PressRow::Untouched(readings)),
            Some(channel) => Err(format!(
                "channel {channel} of the untouched pad reads 0: leave it out of all rows"
            )),
        }
    }

    fn press(&self, row: &CsvRow) -> Result<Press, String> {
        let place = |column| -> Result<PointMm, String> {
            Ok([row.number(column)?, row.number(column + 1)?])
        };
        let model = || -> Result<ModelPrediction, String> {
            Ok(ModelPrediction {
                force: row.number(2)?,
                place_mm: place(3)?,
            })
        };
        Ok(Press {
            place_mm: place(0)?,
            modelled: self.is_modelled.then(model).transpose()?,
            changes: row.numbers_from(self.first_channel())?,
        })
    }
}

/// 0 to n - 1 in a fixed pseudo-random order.
#[must_use]
pub(super) fn shuffled(n: usize) -> Vec<usize> {
    // Sorted by SplitMix64 (Steele, Lea and Flood 2014).
    let key = |index: usize| {
        let mut z = (index as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by_key(|index| key(*index));
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn press(x: f64, y: f64, changes: &[f64], modelled: bool) -> Press {
        Press {
            place_mm: [x, y],
            modelled: modelled.then_some(ModelPrediction {
                force: 0.5,
                place_mm: [x + 1.0, y],
            }),
            changes: changes.to_vec(),
        }
    }

    proptest! {
        #[test]
        fn a_file_is_read_as_it_was_written(
            rows in proptest::collection::vec((0.0..100.0f64, 0.0..100.0f64, -1.0..1.0f64, -1e9..1e9f64), 8..20),
            modelled: bool,
        ) {
            let list = rows.iter().map(|(x, y, a, b)| press(*x, *y, &[*a, *b], modelled)).collect();
            let presses = Presses::new("p", list).expect("spread");
            prop_assert_eq!(&Presses::from_csv("p", &presses.to_csv()).expect("read"), &presses);
        }
    }

    #[test]
    fn a_wrong_file_is_refused_with_its_line() {
        let rows = |last: &str| {
            let good: String = (0..9).map(|i| format!("{i},{},1,{i}\n", i * i)).collect();
            format!("x_mm,y_mm,d0,d1\n{good}{last}\n")
        };
        for (text, message) in [
            ("t_ms,v0\n1,2\n".to_owned(), "p:1: not a file of presses"),
            ("".to_owned(), "p:1: not a file of presses"),
            (rows("1,2,3"), "p:11: 3 values where the header has 4"),
            (rows("1,2,x,3"), "p:11: column 3 (d0): `x` is not a number"),
            (
                rows("1,2,inf,3"),
                "p:11: column 3 (d0): `inf` is not a number",
            ),
            (
                "x_mm,y_mm,d0\n1,2,3\n".to_owned(),
                "p: 1 presses, but at least 8",
            ),
            (
                format!("x_mm,y_mm,d0\n{}", "1,2,3\n".repeat(9)),
                "p: the presses lie on one line",
            ),
            (
                {
                    let diagonal: String =
                        (0..9).map(|i| format!("{i},{},1,{i}\n", 2 * i)).collect();
                    format!("x_mm,y_mm,d0,d1\n{diagonal}")
                },
                "p: the presses lie on one line",
            ),
        ] {
            let error = Presses::from_csv("p", &text).expect_err(&text).to_string();
            assert!(error.starts_with(message), "{error}");
        }
    }

    #[test]
    fn a_change_that_is_not_a_number_is_refused() {
        let mut list: Vec<Press> = (0..9)
            .map(|i| press(f64::from(i), f64::from(i * i), &[1.0], false))
            .collect();
        list[4].changes[0] = f64::NAN;
        let error = Presses::new("p", list).expect_err("NaN").to_string();
        assert!(error.starts_with("p:6: has a change"), "{error}");
    }

    #[test]
    fn a_shuffled_order_contains_every_number_once() {
        let mut order = shuffled(100);
        assert_ne!(order[..10], (0..10).collect::<Vec<_>>());
        order.sort_unstable();
        assert_eq!(order, (0..100).collect::<Vec<_>>());
    }
}
