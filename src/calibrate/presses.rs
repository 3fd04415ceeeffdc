//! Presses at known places: what a calibration learns from, and its text form.
//!
//! A row is `x_mm,y_mm,d0,d1,...`: the place, and what each channel reads pressed less unpressed, in any unit. What
//! gelpad records itself has three more columns behind the place, `force,model_x_mm,model_y_mm`: how hard the model
//! thought the press was, and where; its differences are relative changes (v - v0) / v0.

use faer::Mat;

use crate::types::PointMm;

/// Fewer presses teach nothing.
pub const FEWEST_PRESSES: usize = 8;
/// Names of the columns that only gelpad's own files have.
const MODEL_COLUMNS: [&str; 3] = ["force", "model_x_mm", "model_y_mm"];

/// What the model of the pad made of a press.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Modelled {
    /// How hard, 0 to 1.
    pub force: f64,
    /// Where, mm.
    pub place_mm: PointMm,
}

/// One press.
#[derive(Clone, Debug, PartialEq)]
pub struct Press {
    /// Where the pad was pressed, mm.
    pub place_mm: PointMm,
    /// What the model made of it, where there is a model.
    pub modelled: Option<Modelled>,
    /// Pressed less unpressed, a value a channel.
    pub changes: Vec<f64>,
}

/// Presses of one pad: all of the same number of channels, and either all modelled or none.
#[derive(Clone, Debug, PartialEq)]
pub struct Presses {
    list: Vec<Press>,
    channels: usize,
}

/// Why presses are refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PressesError {
    /// The header is another one.
    #[error("{name}:1: no presses here: the header must be x_mm,y_mm,d0,d1,...")]
    Header {
        /// The file.
        name: String,
    },
    /// A row holds something else.
    #[error("{name}:{line}: {problem}")]
    Row {
        /// The file.
        name: String,
        /// Its line, from 1.
        line: u64,
        /// What is wrong there.
        problem: String,
    },
    /// Too few to learn from.
    #[error("{name}: {found} presses, but at least {FEWEST_PRESSES} are needed: press more places")]
    TooFew {
        /// The file.
        name: String,
        /// How many there are.
        found: usize,
    },
    /// The presses do not span the pad, or no channel answers to them.
    #[error("{name}: {problem}")]
    Flat {
        /// The file.
        name: String,
        /// What does not vary.
        problem: &'static str,
    },
}

impl Presses {
    /// Takes presses; `name` stands for the file in messages.
    ///
    /// # Errors
    /// Too few presses; rows of different lengths; presses all in one line or without a change.
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
        let presses = Self { list, channels };
        let flat = |problem| {
            Err(PressesError::Flat {
                name: name.to_owned(),
                problem,
            })
        };
        let all: Vec<usize> = (0..presses.len()).collect();
        let places = presses.places(&all);
        let varies = |axis: usize| {
            let first = places[(0, axis)];
            all.iter()
                .any(|row| (places[(*row, axis)] - first).abs() > 1e-6)
        };
        if !varies(0) || !varies(1) {
            return flat("the presses lie on one line: spread them over the pad");
        }
        if presses
            .list
            .iter()
            .all(|press| press.changes.iter().all(|change| *change == 0.0))
        {
            return flat("no channel answers to any press: is the pad connected?");
        }
        Ok(presses)
    }

    /// Reads the text of a file; `name` stands for it in messages.
    ///
    /// # Errors
    /// The first row that is not what it should be; see [`Self::new`].
    pub fn from_csv(name: &str, text: &str) -> Result<Self, PressesError> {
        let header_error = || PressesError::Header {
            name: name.to_owned(),
        };
        let mut reader = csv::ReaderBuilder::new()
            .flexible(true)
            .from_reader(text.as_bytes());
        let header = reader.headers().map_err(|_| header_error())?.clone();
        let titles: Vec<&str> = header.iter().map(str::trim).collect();
        if titles.get(..2) != Some(&["x_mm", "y_mm"]) {
            return Err(header_error());
        }
        let modelled = titles.get(2..5) == Some(&MODEL_COLUMNS);
        let first = if modelled { 5 } else { 2 };
        if titles.get(first) != Some(&"d0") {
            return Err(header_error());
        }
        let mut list = Vec::new();
        for record in reader.records() {
            let problem = |line: u64, problem: String| PressesError::Row {
                name: name.to_owned(),
                line,
                problem,
            };
            let record = record.map_err(|error| {
                let line = error.position().map_or(0, csv::Position::line);
                problem(line, "this is no line of text".to_owned())
            })?;
            let line = record.position().map_or(0, csv::Position::line);
            if record.len() != titles.len() {
                return Err(problem(
                    line,
                    format!(
                        "{} values where the header has {}",
                        record.len(),
                        titles.len()
                    ),
                ));
            }
            let mut row = Vec::with_capacity(record.len());
            for (column, word) in record.iter().enumerate() {
                match word.trim().parse::<f64>() {
                    Ok(value) if value.is_finite() => row.push(value),
                    _ => {
                        let word: String = word.chars().take(20).collect();
                        return Err(problem(
                            line,
                            format!(
                                "column {} ({}): `{word}` is no number",
                                column + 1,
                                titles[column]
                            ),
                        ));
                    }
                }
            }
            list.push(Press {
                place_mm: [row[0], row[1]],
                modelled: modelled.then(|| Modelled {
                    force: row[2],
                    place_mm: [row[3], row[4]],
                }),
                changes: row.split_off(first),
            });
        }
        Self::new(name, list)
    }

    /// The text that [`Self::from_csv`] reads.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let mut text = String::from("x_mm,y_mm");
        if self.is_modelled() {
            for title in MODEL_COLUMNS {
                text.push_str(&format!(",{title}"));
            }
        }
        for channel in 0..self.channels {
            text.push_str(&format!(",d{channel}"));
        }
        text.push('\n');
        for press in &self.list {
            let [x, y] = press.place_mm;
            text.push_str(&format!("{x},{y}"));
            if let Some(Modelled { force, place_mm }) = press.modelled {
                text.push_str(&format!(",{force},{},{}", place_mm[0], place_mm[1]));
            }
            for change in &press.changes {
                text.push_str(&format!(",{change}"));
            }
            text.push('\n');
        }
        text
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether there is none; never so.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Values a press.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Whether they tell what the model made of them.
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

    /// Changes of some presses: presses by channels.
    #[must_use]
    pub fn changes(&self, which: &[usize]) -> Mat<f64> {
        Mat::from_fn(which.len(), self.channels, |row, channel| {
            self.list[which[row]].changes[channel]
        })
    }
}

/// 0 to n - 1 in an order that has nothing to do with the order of recording, always the same.
#[must_use]
pub(super) fn mixed(n: usize) -> Vec<usize> {
    // SplitMix64 (Steele, Lea and Flood 2014): a key a number.
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
            modelled: modelled.then_some(Modelled {
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
    fn a_bad_file_is_refused_at_its_line() {
        let rows = |last: &str| {
            let good: String = (0..9).map(|i| format!("{i},{},1,{i}\n", i * i)).collect();
            format!("x_mm,y_mm,d0,d1\n{good}{last}\n")
        };
        for (text, told) in [
            ("t_ms,v0\n1,2\n".to_owned(), "p:1: no presses here"),
            ("".to_owned(), "p:1: no presses here"),
            (rows("1,2,3"), "p:11: 3 values where the header has 4"),
            (rows("1,2,x,3"), "p:11: column 3 (d0): `x` is no number"),
            (rows("1,2,inf,3"), "p:11: column 3 (d0): `inf` is no number"),
            (
                "x_mm,y_mm,d0\n1,2,3\n".to_owned(),
                "p: 1 presses, but at least 8",
            ),
            (
                format!("x_mm,y_mm,d0\n{}", "1,2,3\n".repeat(9)),
                "p: the presses lie on one line",
            ),
        ] {
            let error = Presses::from_csv("p", &text).expect_err(&text).to_string();
            assert!(error.starts_with(told), "{error}");
        }
    }

    #[test]
    fn a_mixed_order_holds_every_number_once() {
        let mut order = mixed(100);
        assert_ne!(order[..10], (0..10).collect::<Vec<_>>());
        order.sort_unstable();
        assert_eq!(order, (0..100).collect::<Vec<_>>());
    }
}
