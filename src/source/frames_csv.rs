//! Frames from a CSV file: `t_ms,v0,v1,...`, a frame a line, times in milliseconds and never backwards.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use super::{Pace, Reading, Source, SourceError};
use crate::types::{Frame, Nanos, nanos_from_ms};

/// A file that is read as it plays.
pub struct FramesCsv {
    path: PathBuf,
    rows: csv::Reader<Box<dyn Read + Send>>,
    row: csv::StringRecord,
    channels: usize,
    last_ns: Nanos,
    any: bool,
}

impl FramesCsv {
    /// Opens a file of frames of so many channels and checks its header.
    ///
    /// # Errors
    /// A file that cannot be read, is empty, or holds something else.
    pub fn open(path: &Path, channels: usize) -> Result<Self, SourceError> {
        let file = File::open(path).map_err(|error| SourceError::File {
            path: path.to_owned(),
            error,
        })?;
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
            last_ns: 0,
            any: false,
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
                "no frames here: the header must begin with t_ms,v0,v1,...",
            ));
        }
        if found != channels {
            return Err(csv.problem(
                1,
                format!("{found} voltages a frame, but the pad gives {channels}: choose its pad with --pad"),
            ));
        }
        Ok(csv)
    }

    fn problem(&self, line: u64, problem: impl Into<String>) -> SourceError {
        SourceError::Line {
            path: self.path.clone(),
            line,
            problem: problem.into(),
        }
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
                let word = shown(&self.row[0]);
                return Err(self.problem(line, format!("column 1 (t_ms): {word} is no time")));
            }
        };
        if self.any && t_ns < self.last_ns {
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
                            "column {} (v{channel}): {} is no voltage",
                            channel + 2,
                            shown(word)
                        ),
                    ));
                }
            }
        }
        Ok(Frame { t_ns, volts })
    }
}

impl Source for FramesCsv {
    fn pace(&self) -> Pace {
        Pace::ByStamp
    }

    fn read(&mut self) -> Result<Reading, SourceError> {
        let more = self
            .rows
            .read_record(&mut self.row)
            .map_err(|error| csv_error(&self.path, &error))?;
        if !more {
            return if self.any {
                Ok(Reading::End)
            } else {
                Err(self.problem(2, "the file ends after its header: it holds no frame"))
            };
        }
        let frame = self.frame()?;
        self.last_ns = frame.t_ns;
        self.any = true;
        Ok(Reading::Frame(frame))
    }
}

/// A reader that refuses a line of over a megabyte: something else than text must not fill the memory.
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
                "a line of over a megabyte: this is no table of frames",
            ));
        }
        Ok(count)
    }
}

/// A word of the file, cut and quoted: random bytes must not flood a terminal.
fn shown(word: &str) -> String {
    let mut short: String = word.chars().take(20).collect();
    if short.len() < word.len() {
        short.push_str("...");
    }
    format!("{short:?}")
}

fn csv_error(path: &Path, error: &csv::Error) -> SourceError {
    let line = error.position().map_or(1, csv::Position::line);
    let problem = match error.kind() {
        csv::ErrorKind::Utf8 { .. } => "this is no text file".to_owned(),
        csv::ErrorKind::Io(error) => error.to_string(),
        _ => error.to_string(),
    };
    SourceError::Line {
        path: path.to_owned(),
        line,
        problem,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn said_of(bytes: &[u8]) -> String {
        let mut file = tempfile::NamedTempFile::new().expect("a file");
        file.write_all(bytes).expect("written");
        let outcome = FramesCsv::open(file.path(), 2).and_then(|mut csv| {
            while csv.read()? != Reading::End {}
            Ok(())
        });
        let said = outcome.expect_err("refused").to_string();
        said.replace(&file.path().display().to_string(), "f.csv")
    }

    #[test]
    fn wrong_files_are_told_by_line_and_column() {
        let cases: &[(&[u8], &str)] = &[
            (
                b"",
                "f.csv:1: the file is empty: expected a header t_ms,v0,v1,...",
            ),
            (
                b"t_ms,v0,v1\n",
                "f.csv:2: the file ends after its header: it holds no frame",
            ),
            (
                b"a,b,c\n1,2,3\n",
                "f.csv:1: no frames here: the header must begin with t_ms,v0,v1,...",
            ),
            (
                b"t_ms,v0\n1,2\n",
                "f.csv:1: 1 voltages a frame, but the pad gives 2: choose its pad with --pad",
            ),
            (
                b"t_ms,v0,v1\n0,1,2\n10,1\n",
                "f.csv:3: 1 voltages where the header has 2",
            ),
            (
                b"t_ms,v0,v1\n0,1,NaN\n",
                "f.csv:2: column 3 (v1): \"NaN\" is no voltage",
            ),
            (
                b"t_ms,v0,v1\nx,1,2\n",
                "f.csv:2: column 1 (t_ms): \"x\" is no time",
            ),
            (
                b"t_ms,v0,v1\n9,1,2\n8,1,2\n",
                "f.csv:3: column 1 (t_ms): the time runs backwards",
            ),
            (
                b"t_ms,v0,v1\n0,1,2\n\xff\xfe,1,2\n",
                "f.csv:3: this is no text file",
            ),
        ];
        for (bytes, said) in cases {
            assert_eq!(&said_of(bytes), said);
        }
    }

    #[test]
    fn a_missing_file_is_named() {
        let said = FramesCsv::open(Path::new("no/such.csv"), 2)
            .err()
            .expect("missing")
            .to_string();
        assert!(said.starts_with("no/such.csv: No such file"), "{said}");
    }
}
