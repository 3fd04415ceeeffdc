//! A sweep of one number of a pad's text: `lattice.width=1..5:0.5`.

use std::str::FromStr;

use serde::{Deserialize, Serialize};
use toml_edit::{DocumentMut, Item, value};

use super::StudyError;
use crate::pad::Pad;

/// Most values of a sweep: a typing error must not start a year of solving.
const MOST: usize = 1000;

/// A number of a pad's text and its values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParameterSweep {
    /// Its path in the text, such as `lattice.width_mm`; the unit may be left out.
    pub path: String,
    /// First value.
    pub from: f64,
    /// Last value.
    pub to: f64,
    /// Step between values.
    pub step: f64,
}

impl FromStr for ParameterSweep {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const FORM: &str = "write PARAMETER=FROM..TO:STEP, as in lattice.width=1..5:0.5";
        let (path, range) = text.split_once('=').ok_or(FORM)?;
        let (ends, step) = range.split_once(':').ok_or(FORM)?;
        let (from, to) = ends.split_once("..").ok_or(FORM)?;
        let number = |word: &str| {
            word.parse::<f64>()
                .ok()
                .filter(|number| number.is_finite())
                .ok_or(format!("`{word}` is not a number: {FORM}"))
        };
        let vary = Self {
            path: path.to_owned(),
            from: number(from)?,
            to: number(to)?,
            step: number(step)?,
        };
        if vary.step <= 0.0 || vary.to < vary.from {
            return Err(format!("the range is empty: {FORM}"));
        }
        if vary.values().len() > MOST {
            return Err(format!("more than {MOST} values: choose a longer step"));
        }
        Ok(vary)
    }
}

impl std::fmt::Display for ParameterSweep {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}={}..{}:{}", self.path, self.from, self.to, self.step)
    }
}

impl ParameterSweep {
    /// The values, from first to last.
    #[must_use]
    pub fn values(&self) -> Vec<f64> {
        // The slack of a millionth absorbs rounding without adding a value.
        let count = ((self.to - self.from) / self.step + 1e-6).floor();
        (0..=count.min(MOST as f64) as usize)
            .map(|i| self.from + i as f64 * self.step)
            .map(|value| (value * 1e9).round() / 1e9)
            .collect()
    }

    /// The pad with the parameter set to a value.
    ///
    /// # Errors
    /// A text without such a number, or a pad that is invalid with it.
    pub fn pad(&self, name: &str, text: &str, number: f64) -> Result<Pad, StudyError> {
        let mut document: DocumentMut = text
            .parse()
            .map_err(|error: toml_edit::TomlError| StudyError::refused(error.to_string()))?;
        let (table, key) = self.path.rsplit_once('.').unwrap_or(("", &self.path));
        let mut item: &mut Item = document.as_item_mut();
        for part in table.split('.').filter(|part| !part.is_empty()) {
            item = item.get_mut(part).ok_or_else(|| {
                StudyError::refused(format!("the pad {name} has no table `{part}` to vary"))
            })?;
        }
        let wanted = [key.to_owned(), format!("{key}_mm")];
        let place = wanted
            .iter()
            .find(|key| {
                item.get(key)
                    .is_some_and(|value| value.is_integer() || value.is_float())
            })
            .ok_or_else(|| {
                StudyError::refused(format!(
                    "the pad {name} has no number `{}` to vary",
                    self.path
                ))
            })?;
        item[place.as_str()] = match item[place.as_str()].is_integer() && number.fract() == 0.0 {
            true => value(number as i64),
            false => value(number),
        };
        let named = format!("{name} ({} = {number})", self.path);
        super::parse_pad(&named, &document.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::{Conductor, DEFAULT_PAD, shipped_pad};

    fn text() -> &'static str {
        shipped_pad(DEFAULT_PAD).expect("shipped").toml
    }

    #[test]
    fn a_range_lists_its_values() {
        let vary: ParameterSweep = "lattice.width=1..3:0.5".parse().expect("a range");
        assert_eq!(vary.values(), [1.0, 1.5, 2.0, 2.5, 3.0]);
        assert_eq!(vary.to_string(), "lattice.width=1..3:0.5");
        for wrong in [
            "lattice.width",
            "w=1..x:1",
            "w=2..1:1",
            "w=1..2:0",
            "w=0..1e9:1",
        ] {
            assert!(wrong.parse::<ParameterSweep>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn only_the_parameter_is_changed() {
        let vary: ParameterSweep = "lattice.width=1..3:1".parse().expect("a range");
        let pad = vary.pad("p", text(), 3.0).expect("sound");
        let Conductor::Lattice(lattice) = &pad.conductor else {
            panic!("a lattice");
        };
        assert_eq!((lattice.width_mm, lattice.x_lines_mm.len()), (3.0, 11));
    }

    #[test]
    fn impossible_values_are_refused_with_the_reason() {
        let vary: ParameterSweep = "lattice.width=1..20:1".parse().expect("a range");
        let said = vary
            .pad("p", text(), 12.0)
            .expect_err("too wide")
            .to_string();
        assert!(said.contains("channels of 12 mm overlap"), "{said}");
        let vary: ParameterSweep = "lattice.colour=1..2:1".parse().expect("a range");
        let said = vary
            .pad("p", text(), 1.0)
            .expect_err("no such thing")
            .to_string();
        assert_eq!(said, "the pad p has no number `lattice.colour` to vary");
    }
}
