//! Frames from a CSV file: `t_ms,v0,v1,...`, one frame a line, times in milliseconds that never run backwards.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use super::{Source, SourceError, SourcePace, SourceReading};
use crate::types::{Frame, Nanos, ms_from_nanos, nanos_from_ms};

/// After this many frames their rate shows whether the times are seconds.
const UNIT_FRAMES: usize = 20;
/// No board measures faster: times in seconds look a thousand times shorter, for 1 to 5,000 frames per second.
const SHORTEST_STEP_MS: f64 = 0.2;

/// A file that is read while it plays.
pub struct FramesCsv {
    path: PathBuf,
    rows: csv::Reader<Box<dyn Read + Send>>,
    row: csv::StringRecord,
    channels: usize,
    first_ns: Nanos,
    last_ns: Nanos,
    frames: usize,
}

impl FramesCsv {
    /// Opens a file of frames with this number of channels and checks its header.
    ///
    /// # Errors
    /// The file cannot be read, is empty, or is not such a CSV file.
    pub fn open(path: &Path, channels: usize) -> Result<Self, SourceError> {
        let file = File::open(path).map_err(|error| SourceError::file(path, error))?;
        let input: Box<dyn Read + Send> = Box::new(ShortLines {
            input: BufReader::new(file),
            since_newline: 0,
        });
        let mut csv = Self {
            path: path.to_owned(),
            rows: csv::ReaderBuilder::new()
                .flexible(true)
                .quoting(false)
                .from_reader(input),
            row: csv::StringRecord::new(),
            channels,
            first_ns: 0,
            last_ns: 0,
            frames: 0,
        };
        let header = csv.rows.headers().map_err(|e| csv_error(&csv.path, &e))?;
        let named = header.get(0) == Some("t_ms");
        let found = header.len().saturating_sub(1);
        if header.is_empty() {
            return Err(csv.problem(1, "the file is empty: expected a header t_ms,v0,v1,..."));
        }
        if !named {
            return Err(csv.problem(
                1,
                "this is not a file of frames: the header must be t_ms,v0,v1,...",
            ));
        }
        if found != channels {
            return Err(csv.problem(
                1,
                format!("{found} voltages a frame, but the pad has {channels}: choose another pad with --pad"),
            ));
        }
        Ok(csv)
    }

    /// Warns, once, of times that are probably seconds.
    fn check_unit(&mut self, t_ns: Nanos) {
        if self.frames == 1 {
            self.first_ns = t_ns;
        }
        let played_ns = t_ns - self.first_ns;
        if self.frames == UNIT_FRAMES && played_ns > 0 {
            let step_ms = ms_from_nanos(played_ns) / (UNIT_FRAMES - 1) as f64;
            if step_ms < SHORTEST_STEP_MS {
                tracing::warn!(
                    "{}: {:.0} frames per second by the column t_ms: are its times seconds?\n  help: multiply them by 1000",
                    self.path.display(),
                    1e3 / step_ms
                );
            }
        }
    }

    fn problem(&self, line: u64, problem: impl Into<String>) -> SourceError {
        SourceError::line(&self.path, line, problem.into())
    }

    fn frame(&self) -> Result<Frame, SourceError> {
        let line = self.row.position().map_or(0, csv::Position::line);
        if self.row.len() != self.channels + 1 {
            let found = self.row.len() - 1;
            return Err(self.problem(
                line,
                format!("{found} voltages where the header has {}", self.channels),
            ));
        }
        let t_ns = match self.row[0].trim().parse::<f64>() {
            Ok(t_ms) if (0.0..1e12).contains(&t_ms) => nanos_from_ms(t_ms),
            _ => {
                let word = quoted(&self.row[0]);
                return Err(self.problem(line, format!("column 1 (t_ms): {word} is not a time")));
            }
        };
        if self.frames > 0 && t_ns < self.last_ns {
            return Err(self.problem(line, "column 1 (t_ms): the time runs backwards"));
        }
        let mut volts = Vec::with_capacity(self.channels);
        for (channel, word) in self.row.iter().skip(1).enumerate() {
            match word.trim().parse::<f32>() {
                Ok(volt) if volt.is_finite() => volts.push(volt),
                _ => {
                    return Err(self.problem(
                        line,
                        format!(
                            "column {} (v{channel}): {} is not a voltage",
                            channel + 2,
                            quoted(word)
                        ),
                    ));
                }
            }
        }
        Ok(Frame { t_ns, volts })
    }
}

impl Source for FramesCsv {
    fn pace(&self) -> SourcePace {
        SourcePace::ByStamp
    }

    fn read(&mut self) -> Result<SourceReading, SourceError> {
        let more = self
            .rows
            .read_record(&mut self.row)
            .map_err(|error| csv_error(&self.path, &error))?;
        if !more {
            return if self.frames > 0 {
                Ok(SourceReading::End)
            } else {
                Err(self.problem(2, "the file holds no frame, only a header"))
            };
        }
        let frame = self.frame()?;
        self.last_ns = frame.t_ns;
        self.frames += 1;
        self.check_unit(frame.t_ns);
        Ok(SourceReading::Frame(frame))
    }
}

/// A reader that refuses lines of over a megabyte, so that a file that is not text cannot fill the memory.
struct ShortLines<R> {
    input: R,
    since_newline: usize,
}

impl<R: Read> Read for ShortLines<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        const LONGEST_LINE: usize = 1 << 20;
        let count = self.input.read(buffer)?;
        match buffer[..count].iter().rposition(|byte| *byte == b'\n') {
            Some(newline) => self.since_newline = count - newline - 1,
            None => self.since_newline += count,
        }
        if self.since_newline > LONGEST_LINE {
            return Err(std::io::Error::other(
                "a line of over 1 MB: this is not a table of frames",
            ));
        }
        Ok(count)
    }
}

/// A word of the file, shortened and quoted, so that random bytes cannot flood a terminal.
fn quoted(word: &str) -> String {
    let mut short: String = word.chars().take(20).collect();
    if short.len() < word.len() {
        short.push_str("...");
    }
    format!("{short:?}")
}

fn csv_error(path: &Path, error: &csv::Error) -> SourceError {
    let line = error.position().map_or(1, csv::Position::line);
    let problem = match error.kind() {
        csv::ErrorKind::Utf8 { .. } => "this is not a text file".to_owned(),
        csv::ErrorKind::Io(error) => error.to_string(),
        _ => error.to_string(),
    };
    SourceError::line(path, line, problem)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn error_of(bytes: &[u8]) -> String {
        let mut file = tempfile::NamedTempFile::new().expect("a file");
        file.write_all(bytes).expect("written");
        let result = FramesCsv::open(file.path(), 2).and_then(|mut csv| {
            while csv.read()? != SourceReading::End {}
            Ok(())
        });
        let message = result.expect_err("refused").to_string();
        message.replace(&file.path().display().to_string(), "f.csv")
    }

    #[test]
    fn mistakes_are_reported_with_line_and_column() {
        let cases: &[(&[u8], &str)] = &[
            (
                b"",
                "f.csv:1: the file is empty: expected a header t_ms,v0,v1,...",
            ),
            (
                b"t_ms,v0,v1\n",
                "f.csv:2: the file holds no frame, only a header",
            ),
            (
                b"a,b,c\n1,2,3\n",
                "f.csv:1: this is not a file of frames: the header must be t_ms,v0,v1,...",
            ),
            (
                b"t_ms,v0\n1,2\n",
                "f.csv:1: 1 voltages a frame, but the pad has 2: choose another pad with --pad",
            ),
            (
                b"t_ms,v0,v1\n0,1,2\n10,1\n",
                "f.csv:3: 1 voltages where the header has 2",
            ),
            (
                b"t_ms,v0,v1\n0,1,NaN\n",
                "f.csv:2: column 3 (v1): \"NaN\" is not a voltage",
            ),
            (
                b"t_ms,v0,v1\nx,1,2\n",
                "f.csv:2: column 1 (t_ms): \"x\" is not a time",
            ),
            (
                b"t_ms,v0,v1\n9,1,2\n8,1,2\n",
                "f.csv:3: column 1 (t_ms): the time runs backwards",
            ),
            (
                b"t_ms,v0,v1\n0,1,2\n\xff\xfe,1,2\n",
                "f.csv:3: this is not a text file",
            ),
        ];
        for (bytes, message) in cases {
            assert_eq!(&error_of(bytes), message);
        }
    }

    #[test]
    fn a_missing_file_is_named() {
        let message = FramesCsv::open(Path::new("no/such.csv"), 2)
            .err()
            .expect("missing")
            .to_string();
        assert!(
            message.starts_with("no/such.csv: ") && message.contains("os error"),
            "{message}"
        );
    }
}
