//! Rows of numbers below a header, as comma-separated text: what files of presses and of several touches share.
//!
//! A row has as many values as the header has titles. Messages name the file, the line, the column and its title.

use csv::StringRecord;

use super::error::PressesError;

/// A row, with the titles of its columns.
pub(super) struct CsvRow<'a> {
    titles: &'a [String],
    record: &'a StringRecord,
}

impl CsvRow<'_> {
    /// A finite number.
    ///
    /// # Errors
    /// Anything else, with its column.
    pub(super) fn number(&self, column: usize) -> Result<f64, String> {
        let text = self.record.get(column).unwrap_or_default().trim();
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => {
                let text: String = text.chars().take(20).collect();
                let (number, title) = (column + 1, &self.titles[column]);
                Err(format!(
                    "column {number} ({title}): `{text}` is not a number"
                ))
            }
        }
    }

    /// The numbers of a column and all that follow.
    ///
    /// # Errors
    /// See [`Self::number`].
    pub(super) fn numbers_from(&self, first: usize) -> Result<Vec<f64>, String> {
        (first..self.titles.len())
            .map(|column| self.number(column))
            .collect()
    }

    /// Whether there is nothing in a column.
    pub(super) fn is_empty(&self, column: usize) -> bool {
        let text = self.record.get(column);
        text.is_none_or(|text| text.trim().is_empty())
    }
}

/// Reads a text; `name` is the file in messages. `header` says what the titles mean, or `None` if it is not a file of this kind.
///
/// # Errors
/// A header that is not understood; the first row that is wrong.
pub(super) fn read<Columns, Row>(
    name: &str,
    text: &str,
    header: impl FnOnce(&[String]) -> Option<Columns>,
    row: impl Fn(&Columns, &CsvRow) -> Result<Row, String>,
) -> Result<(Columns, Vec<Row>), PressesError> {
    let mut reader = csv::ReaderBuilder::new()
        .flexible(true)
        .from_reader(text.as_bytes());
    let titles: Vec<String> = reader
        .headers()
        .map(|titles| titles.iter().map(|title| title.trim().to_owned()).collect())
        .unwrap_or_default();
    let Some(columns) = header(&titles) else {
        return Err(PressesError::Header {
            name: name.to_owned(),
        });
    };
    let mut rows = Vec::new();
    for record in reader.records() {
        let position = match &record {
            Ok(record) => record.position(),
            Err(error) => error.position(),
        };
        let line = position.map_or(0, csv::Position::line);
        let read = match &record {
            Ok(record) if record.len() != titles.len() => Err(format!(
                "{} values where the header has {}",
                record.len(),
                titles.len()
            )),
            Ok(record) => row(
                &columns,
                &CsvRow {
                    titles: &titles,
                    record,
                },
            ),
            Err(_) => Err("not valid UTF-8".to_owned()),
        };
        rows.push(read.map_err(|problem| PressesError::Row {
            name: name.to_owned(),
            line,
            problem,
        })?);
    }
    Ok((columns, rows))
}
