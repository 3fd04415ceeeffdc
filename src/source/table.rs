//! A table of numbers as a source: one reading a row and one frame a column, as EIDORS writes them.
//!
//! Numbers are separated by commas, semicolons, tabs or blanks; lines that begin with `%` or `#` are comments. A table
//! with frames as rows is transposed. If columns come in pairs whose second resembles all other seconds but not the
//! first, they are real and imaginary parts, and the real parts are used. A table has no times: it plays at 100 frames/s.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::arrangement::plausible_counts;
use super::{Arrangement, SIMULATED_FRAME_NS, Source, SourceError, SourcePace, SourceReading};
use crate::pad::Pad;
use crate::types::{Frame, Nanos};

/// Largest file that is read, bytes.
const LARGEST_FILE: u64 = 512 << 20;
/// Columns of the same kind differ by less than this (norm of the difference over the norm), columns of
/// different kinds by more.
const KIND_LIMIT: f64 = 0.3;

/// The frames of a table.
pub struct FramesTable {
    frames: std::vec::IntoIter<Vec<f32>>,
    count: u64,
}

impl FramesTable {
    /// Reads a table of a pad's frames.
    ///
    /// # Errors
    /// The file cannot be read, is not a table, or holds frames of another pad.
    pub fn open(path: &Path, pad: &Pad) -> Result<Self, SourceError> {
        let mut text = String::new();
        File::open(path)
            .and_then(|file| {
                if file.metadata()?.len() > LARGEST_FILE {
                    return Err(std::io::Error::other("the table is larger than 512 MB"));
                }
                file.take(LARGEST_FILE).read_to_string(&mut text)
            })
            .map_err(|error| SourceError::file(path, error))?;
        let (frames, summary) = parse_frames(&text, pad)
            .map_err(|(line, problem)| SourceError::line(path, line, problem))?;
        tracing::info!(
            target: "gelpad::told",
            "{}: {} frames, played at {} frames/s because a table has no times; {summary}",
            path.display(),
            frames.len(),
            1_000_000_000 / SIMULATED_FRAME_NS,
        );
        Ok(Self {
            frames: frames.into_iter(),
            count: 0,
        })
    }
}

impl Source for FramesTable {
    fn pace(&self) -> SourcePace {
        SourcePace::ByStamp
    }

    fn read(&mut self) -> Result<SourceReading, SourceError> {
        let Some(volts) = self.frames.next() else {
            return Ok(SourceReading::End);
        };
        let t_ns: Nanos = self.count * SIMULATED_FRAME_NS;
        self.count += 1;
        Ok(SourceReading::Frame(Frame { t_ns, volts }))
    }
}

/// A line, from 1, and its mistake.
type Problem = (u64, String);

/// The frames of a text in the pad's order and a summary, or the first mistake.
fn parse_frames(text: &str, pad: &Pad) -> Result<(Vec<Vec<f32>>, String), Problem> {
    let rows = parse_rows(text)?;
    let (Some(first), counts) = (rows.first(), plausible_counts(pad)) else {
        return Err((1, "the table is empty".to_owned()));
    };
    let (is_transposed, transposed) = match (
        counts.contains(&rows.len()),
        counts.contains(&first.len()),
    ) {
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
    let mut frames = if is_transposed {
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
    let summary = format!("{}{transposed}{parts}", arrangement.summary());
    let frames = frames
        .iter()
        .map(|frame| arrangement.apply(frame))
        .collect();
    Ok((frames, summary))
}

/// The rows of a text, all of the same length.
fn parse_rows(text: &str) -> Result<Vec<Vec<f32>>, (u64, String)> {
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
                        (line, format!("{short:?} is not a number"))
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

/// Whether the frames alternate between two kinds: real and imaginary parts.
fn is_complex(frames: &[Vec<f32>]) -> bool {
    let [first, second, ..] = frames else {
        return false;
    };
    let differ = |a: &[f32], b: &[f32]| {
        let (mut off, mut all) = (0.0, 0.0);
        for (a, b) in a.iter().zip(b) {
            let [a, b] = [f64::from(*a), f64::from(*b)];
            off += (a - b) * (a - b);
            all += a * a;
        }
        off > KIND_LIMIT * KIND_LIMIT * all
    };
    frames.len().is_multiple_of(2)
        && differ(first, second)
        && frames
            .chunks(2)
            .all(|pair| !differ(first, &pair[0]) && !differ(second, &pair[1]))
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
    fn frames_may_be_columns_or_rows_and_complex() {
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
        let summary_of = |text: &str| {
            let (frames, summary) = parse_frames(text, &tank()).expect("a table");
            assert_eq!(frames.len(), 2);
            assert_eq!(frames[0], volts);
            summary
        };
        assert!(
            summary_of(&columns).starts_with("208 voltages a frame: adjacent drive, not rotated")
        );
        assert!(summary_of(&rows).ends_with("frames as rows"));
        assert!(summary_of(&parts).ends_with("real parts of complex values"));
    }

    #[test]
    fn a_mistake_is_reported_with_its_line() {
        let error_of = |text: &str| parse_frames(text, &tank()).expect_err("refused");
        assert_eq!(error_of("\n").1, "the table is empty");
        // As many rows as a frame has voltages, but empty.
        assert_eq!(error_of(&";\n".repeat(208)).1, "the table is empty");
        assert_eq!(
            error_of("1 2\n3\n"),
            (2, "1 numbers where the rows before have 2".to_owned())
        );
        assert_eq!(
            error_of("1 2\n3 x\n"),
            (2, "\"x\" is not a number".to_owned())
        );
        assert!(
            error_of("1 2\n3 4\n")
                .1
                .starts_with("2 rows of 2 numbers, but a frame of the pad")
        );
    }
}
