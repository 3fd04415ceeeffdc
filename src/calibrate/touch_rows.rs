//! Rows of a test file: the places of one, two or three touches, and the changes that they made together.
//!
//! The header is `x_mm,y_mm[,x2_mm,y2_mm[,x3_mm,y3_mm]],d0,d1,...`; the second and third places may be empty in a row.

use super::csv_rows::{self, CsvRow};
use super::error::PressesError;
use super::presses::Presses;
use super::superposed::MOST_PLACES;
use crate::types::PointMm;

/// Touches that were down at the same time.
#[derive(Clone, Debug, PartialEq)]
pub struct TouchRow {
    /// One to [`MOST_PLACES`] places, mm.
    pub places_mm: Vec<PointMm>,
    /// Reading when touched minus when untouched, for each channel.
    pub changes: Vec<f64>,
}

/// The rows of a file, all with the same number of channels; at least one.
#[derive(Clone, Debug, PartialEq)]
pub struct TouchRows {
    list: Vec<TouchRow>,
    channels: usize,
}

impl TouchRows {
    /// Whether a text has the header of rows with several places.
    #[must_use]
    pub fn has_header(text: &str) -> bool {
        let header = text.lines().next().unwrap_or_default();
        header
            .split(',')
            .nth(2)
            .is_some_and(|title| title.trim() == "x2_mm")
    }

    /// Reads the text of a file; `name` is the file in messages.
    ///
    /// # Errors
    /// The first row that is wrong, or a file without rows.
    pub fn from_csv(name: &str, text: &str) -> Result<Self, PressesError> {
        let (columns, list) = csv_rows::read(name, text, Columns::from_header, Columns::row)?;
        let channels = columns.channels;
        if list.is_empty() {
            return Err(PressesError::Flat {
                name: name.to_owned(),
                problem: "there are no rows below the header",
            });
        }
        Ok(Self { list, channels })
    }

    /// Single presses as rows.
    #[must_use]
    pub fn from_presses(presses: &Presses) -> Self {
        let rows = presses.list().iter().map(|press| TouchRow {
            places_mm: vec![press.place_mm],
            changes: press.changes.clone(),
        });
        Self {
            list: rows.collect(),
            channels: presses.channels(),
        }
    }

    /// The rows.
    #[must_use]
    pub fn list(&self) -> &[TouchRow] {
        &self.list
    }

    /// Number of channels.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.channels
    }
}

/// The columns of a file.
struct Columns {
    /// Most places in a row.
    places: usize,
    channels: usize,
}

impl Columns {
    /// `None` if this is not the header of such a file.
    fn from_header(titles: &[String]) -> Option<Self> {
        const TITLES: [[&str; 2]; MOST_PLACES] =
            [["x_mm", "y_mm"], ["x2_mm", "y2_mm"], ["x3_mm", "y3_mm"]];
        let places = TITLES
            .iter()
            .zip(titles.chunks_exact(2))
            .take_while(|(wanted, found)| wanted[..] == **found)
            .count();
        let first = titles.get(2 * places)?;
        (places > 0 && first == "d0").then(|| Self {
            places,
            channels: titles.len() - 2 * places,
        })
    }

    fn row(&self, row: &CsvRow) -> Result<TouchRow, String> {
        let first_channel = 2 * self.places;
        let mut places_mm = Vec::new();
        for column in (0..first_channel).step_by(2) {
            if column > 0 && (column..first_channel).all(|column| row.is_empty(column)) {
                break;
            }
            places_mm.push([row.number(column)?, row.number(column + 1)?]);
        }
        Ok(TouchRow {
            places_mm,
            changes: row.numbers_from(first_channel)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_one_to_three_places_are_read() {
        let text = "x_mm,y_mm,x2_mm,y2_mm,x3_mm,y3_mm,d0,d1\n1,2,,,,,5,6\n1,2,3,4,,,5,6\n1,2,3,4,7,8,5,6\n";
        assert!(TouchRows::has_header(text));
        let rows = TouchRows::from_csv("t", text).expect("sound");
        let counts: Vec<usize> = rows.list().iter().map(|row| row.places_mm.len()).collect();
        assert_eq!(counts, [1, 2, 3]);
        assert_eq!(rows.list()[2].places_mm[2], [7.0, 8.0]);
        assert_eq!(
            (rows.channels(), &rows.list()[0].changes[..]),
            (2, &[5.0, 6.0][..])
        );
    }

    #[test]
    fn a_wrong_row_is_refused_with_its_line() {
        let header = "x_mm,y_mm,x2_mm,y2_mm,d0\n";
        for (rows, message) in [
            (
                "1,2,3,4,5\n1,2,3,,5\n",
                "t:3: column 4 (y2_mm): `` is not a number",
            ),
            ("1,2,3,4\n", "t:2: 4 values where the header has 5"),
            ("", "t: there are no rows"),
        ] {
            let error = TouchRows::from_csv("t", &format!("{header}{rows}")).expect_err(rows);
            assert!(error.to_string().starts_with(message), "{error}");
        }
        assert!(TouchRows::from_csv("t", "x2_mm,y2_mm,d0\n1,2,3\n").is_err());
    }
}
