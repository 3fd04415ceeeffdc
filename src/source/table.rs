//! A table of numbers as a source: a reading a row and a frame a column, as EIDORS and its kin keep them.
//!
//! Numbers stand between commas, semicolons, tabs or blanks; lines that begin with `%` or `#` are comments. A table whose
//! rows are the frames is turned. Where columns come in pairs of which the second is like its kind and unlike the first, they are
//! real and imaginary parts, and the real ones are taken. Such tables know no times: they play at [`FRAMES_PER_S`].

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::arrangement::plausible_counts;
use super::{Arrangement, Pace, Reading, Source, SourceError};
use crate::pad::Pad;
use crate::types::{Frame, Nanos};

/// A table has no times.
const FRAMES_PER_S: u64 = 100;
/// A larger file is no table to be read at once, bytes.
const LARGEST_FILE: u64 = 512 << 20;
/// Columns of the same kind differ by less than this (norm of the difference over the norm), those of another by more.
const UNLIKE: f64 = 0.3;

/// A table that was read.
pub struct FramesTable {
    frames: std::vec::IntoIter<Vec<f32>>,
    count: u64,
}

impl FramesTable {
    /// Reads a table of a pad's frames.
    ///
    /// # Errors
    /// A file that cannot be read, holds something else, or another pad's frames.
    pub fn open(path: &Path, pad: &Pad) -> Result<Self, SourceError> {
        let mut text = String::new();
        File::open(path)
            .and_then(|file| {
                if file.metadata()?.len() > LARGEST_FILE {
                    return Err(std::io::Error::other("a table of over 512 MB"));
                }
                file.take(LARGEST_FILE).read_to_string(&mut text)
            })
            .map_err(|error| SourceError::File {
                path: path.to_owned(),
                error,
            })?;
        let (frames, told) =
            frames_of(&text, pad).map_err(|(line, problem)| SourceError::Line {
                path: path.to_owned(),
                line,
                problem,
            })?;
        tracing::info!(
            target: "gelpad::told",
            "{}: {} frames at {FRAMES_PER_S} frames/s, as tables have no times; {told}",
            path.display(),
            frames.len()
        );
        Ok(Self {
            frames: frames.into_iter(),
            count: 0,
        })
    }
}

impl Source for FramesTable {
    fn pace(&self) -> Pace {
        Pace::ByStamp
    }

    fn read(&mut self) -> Result<Reading, SourceError> {
        let Some(volts) = self.frames.next() else {
            return Ok(Reading::End);
        };
        let t_ns: Nanos = self.count * (1_000_000_000 / FRAMES_PER_S);
        self.count += 1;
        Ok(Reading::Frame(Frame { t_ns, volts }))
    }
}

/// A line, from 1, and what is wrong there.
type Problem = (u64, String);

/// The frames of a text in the pad's order, and what was found; or the first problem.
fn frames_of(text: &str, pad: &Pad) -> Result<(Vec<Vec<f32>>, String), Problem> {
    let rows = rows_of(text)?;
    let (Some(first), counts) = (rows.first(), plausible_counts(pad)) else {
        return Err((1, "the table is empty".to_owned()));
    };
    let (is_turned, turned) = match (counts.contains(&rows.len()), counts.contains(&first.len())) {
        (true, _) => (false, ""),
        (false, true) => (true, ", frames as rows"),
        (false, false) => {
            return Err((
                1,
                format!(
                    "{} rows of {} numbers, but a frame of the pad {} has {} voltages: choose its pad with --pad",
                    rows.len(),
                    first.len(),
                    pad.name,
                    pad.channels()
                ),
            ));
        }
    };
    let mut frames = if is_turned {
        rows
    } else {
        (0..first.len())
            .map(|column| rows.iter().map(|row| row[column]).collect())
            .collect()
    };
    let mut parts = "";
    if is_complex(&frames) {
        frames = frames.into_iter().step_by(2).collect();
        parts = ", real parts of complex values";
    }
    let arrangement =
        Arrangement::find(&frames[0], None, None, pad).map_err(|error| (1, error.to_string()))?;
    let told = format!("{}{turned}{parts}", arrangement.told());
    let frames = frames
        .iter()
        .map(|frame| arrangement.apply(frame))
        .collect();
    Ok((frames, told))
}

/// Rows of the same length.
fn rows_of(text: &str) -> Result<Vec<Vec<f32>>, (u64, String)> {
    let mut rows: Vec<Vec<f32>> = Vec::new();
    for (line, row) in text.lines().enumerate() {
        let line = line as u64 + 1;
        if row.starts_with(['#', '%']) {
            continue;
        }
        let numbers = row
            .split([',', ';', '\t', ' '])
            .filter(|word| !word.trim().is_empty())
            .map(|word| {
                word.trim()
                    .parse::<f32>()
                    .ok()
                    .filter(|number| number.is_finite())
                    .ok_or_else(|| {
                        let short: String = word.chars().take(20).collect();
                        (line, format!("{short:?} is no number"))
                    })
            })
            .collect::<Result<Vec<f32>, _>>()?;
        if numbers.is_empty() {
            continue;
        }
        if let Some(first) = rows.first()
            && first.len() != numbers.len()
        {
            return Err((
                line,
                format!(
                    "{} numbers where the rows before have {}",
                    numbers.len(),
                    first.len()
                ),
            ));
        }
        rows.push(numbers);
    }
    Ok(rows)
}

/// Whether every second frame is like its kind and unlike the first.
fn is_complex(frames: &[Vec<f32>]) -> bool {
    let [first, second, ..] = frames else {
        return false;
    };
    let unlike = |a: &[f32], b: &[f32]| {
        let (mut off, mut all) = (0.0, 0.0);
        for (a, b) in a.iter().zip(b) {
            let [a, b] = [f64::from(*a), f64::from(*b)];
            off += (a - b) * (a - b);
            all += a * a;
        }
        off > UNLIKE * UNLIKE * all
    };
    frames.len().is_multiple_of(2)
        && unlike(first, second)
        && frames
            .chunks(2)
            .all(|pair| !unlike(first, &pair[0]) && !unlike(second, &pair[1]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::shipped_pad;
    use crate::source::SimulatedPad;

    fn tank() -> Pad {
        Pad::from_toml("p", shipped_pad("round-tank").expect("shipped").toml).expect("sound")
    }

    fn volts() -> Vec<f32> {
        let volts = SimulatedPad::new(&tank()).and_then(|pad| pad.volts(&[]));
        volts
            .expect("solved")
            .iter()
            .map(|volt| *volt as f32)
            .collect()
    }

    #[test]
    fn columns_or_rows_are_frames_and_parts_are_told_from_them() {
        let volts = volts();
        let columns: String = volts
            .iter()
            .map(|volt| format!("{volt} {}\n", volt * 1.01))
            .collect();
        let words: Vec<String> = volts.iter().map(f32::to_string).collect();
        let rows = format!("% a comment\n{0}\n{0}\n", words.join("\t"));
        let parts: String = volts
            .iter()
            .map(|volt| format!("{volt},{},{},{}\n", -0.3 * volt, volt * 1.01, -0.29 * volt))
            .collect();
        let told = |text: &str| {
            let (frames, told) = frames_of(text, &tank()).expect("a table");
            assert_eq!(frames.len(), 2);
            assert_eq!(frames[0], volts);
            told
        };
        assert!(told(&columns).starts_with("208 voltages a frame: adjacent drive, not rotated"));
        assert!(told(&rows).ends_with("frames as rows"));
        assert!(told(&parts).ends_with("real parts of complex values"));
    }

    #[test]
    fn what_is_no_table_of_the_pad_is_told_at_its_line() {
        let said = |text: &str| frames_of(text, &tank()).expect_err("refused");
        assert_eq!(said("\n").1, "the table is empty");
        // As many rows as a frame has voltages, and nothing in them.
        assert_eq!(said(&";\n".repeat(208)).1, "the table is empty");
        assert_eq!(
            said("1 2\n3\n"),
            (2, "1 numbers where the rows before have 2".to_owned())
        );
        assert_eq!(said("1 2\n3 x\n"), (2, "\"x\" is no number".to_owned()));
        assert!(
            said("1 2\n3 4\n")
                .1
                .starts_with("2 rows of 2 numbers, but a frame of the pad")
        );
    }
}
