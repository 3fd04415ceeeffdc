//! Sciospec's `.eit` text files: one frame a file, with the potential of every electrode for every drive.
//!
//! The first line is the number of header lines. Pairs of lines follow the header: the two driven electrodes,
//! counted from 1, and the real and imaginary part of every electrode's potential. Potentials are
//! single-ended; [`EitFrame::adjacent`] takes the differences of neighbours that gelpad works with.

use std::path::Path;

use super::SourceError;

/// Largest file that is read, bytes: a frame of 16 electrodes takes 12 kB.
const LARGEST_FILE: u64 = 16 << 20;
/// Start of the header line that lists the pad's electrodes, from 1: larger instruments measure all of theirs.
const CHANNELS_LINE: &str = "MeasurementChannels:";
/// Header line (from 0) of the frame rate.
const RATE_LINE: usize = 9;
/// Frame rates that an instrument can have, 1/s.
const RATES_PER_S: std::ops::RangeInclusive<f64> = 1e-3..=1e6;
/// Largest potential, V: differences of such potentials fit an f32.
const LARGEST_V: f64 = 1e30;

/// A frame of the instrument.
#[derive(Clone, Debug, PartialEq)]
pub struct EitFrame {
    /// Frames a second, from the header.
    pub frames_per_s: f64,
    /// The drives, in the file's order.
    pub drives: Vec<EitDrive>,
}

/// One drive of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct EitDrive {
    /// The electrodes where the current goes in and out, from 0.
    pub electrodes: (usize, usize),
    /// Real part of each electrode's potential, V.
    pub real: Vec<f64>,
    /// Imaginary part of each electrode's potential, V.
    pub imaginary: Vec<f64>,
}

impl EitFrame {
    /// Reads a file.
    ///
    /// # Errors
    /// The file cannot be read or is not such a file.
    pub fn open(path: &Path) -> Result<Self, SourceError> {
        use std::io::Read as _;

        let mut text = String::new();
        std::fs::File::open(path)
            .and_then(|file| file.take(LARGEST_FILE).read_to_string(&mut text))
            .map_err(|error| SourceError::file(path, error))?;
        Self::parse(path, &text)
    }

    /// Reads the text of a file; `path` is its name for messages.
    ///
    /// # Errors
    /// The first line that is wrong.
    pub fn parse(path: &Path, text: &str) -> Result<Self, SourceError> {
        let lines: Vec<&str> = text.lines().collect();
        Self::parse_lines(&lines)
            .map_err(|(line, problem)| SourceError::line(path, line as u64 + 1, problem))
    }

    fn parse_lines(lines: &[&str]) -> Result<Self, Problem> {
        let header = Header::parse(lines)?;
        let mut drives: Vec<EitDrive> = Vec::new();
        let body: Vec<(usize, &str)> = (header.lines..lines.len())
            .map(|index| (index, lines[index]))
            .filter(|(_, line)| !line.trim().is_empty())
            .collect();
        for pair in body.chunks(2) {
            let [drive, volts] = *pair else {
                return Err((pair[0].0, "a drive without potentials".to_owned()));
            };
            let electrodes = drives.first().map(|first| first.real.len());
            drives.push(EitDrive::parse(drive, volts, &header, electrodes)?);
        }
        if drives.is_empty() {
            return Err((header.lines, "no reading follows the header".to_owned()));
        }
        Ok(Self {
            frames_per_s: header.frames_per_s,
            drives,
        })
    }

    /// Real parts of the differences of neighbours, V(m) - V(m + 1), drive by drive, without those that
    /// include a driven electrode: the input of [`recognise`](crate::eit::order::recognise_order).
    #[must_use]
    pub fn adjacent(&self) -> Vec<f64> {
        self.drives
            .iter()
            .flat_map(|drive| {
                let count = drive.real.len();
                let (into, out) = drive.electrodes;
                (0..count)
                    .map(move |m| (m, (m + 1) % count))
                    .filter(move |(a, b)| ![into, out].iter().any(|e| e == a || e == b))
                    .map(|(a, b)| drive.real[a] - drive.real[b])
            })
            .collect()
    }
}

/// A line, from 0, and its mistake.
type Problem = (usize, String);

struct Header {
    /// Number of lines.
    lines: usize,
    frames_per_s: f64,
    /// The pad's electrodes among the potentials, from 0; none: all of them.
    channels: Option<Vec<usize>>,
}

impl Header {
    fn parse(lines: &[&str]) -> Result<Self, Problem> {
        let count: usize = lines
            .first()
            .and_then(|line| line.trim().parse().ok())
            .filter(|count| (RATE_LINE + 1..lines.len()).contains(count))
            .ok_or_else(|| {
                (0, "not an .eit file: the first line must be the number of header lines, and readings must follow them".to_owned())
            })?;
        let frames_per_s = lines[RATE_LINE].trim().parse().ok();
        let frames_per_s = frames_per_s
            .filter(|rate| RATES_PER_S.contains(rate))
            .ok_or_else(|| {
                let (least, most) = RATES_PER_S.into_inner();
                let problem =
                    format!("the frame rate is not a number from {least} to {most} frames/s");
                (RATE_LINE, problem)
            })?;
        let listed = lines[..count]
            .iter()
            .enumerate()
            .find_map(|(line, text)| Some((line, text.strip_prefix(CHANNELS_LINE)?)));
        let channels = listed.map(|(line, list)| {
            let problem = "expected the measured electrodes, from 1 and each once, as in `1,2,3`";
            electrodes(list).ok_or_else(|| (line, problem.to_owned()))
        });
        Ok(Self {
            lines: count,
            frames_per_s,
            channels: channels.transpose()?,
        })
    }
}

impl EitDrive {
    /// Reads the two lines of a drive. `electrodes` is the number of potentials of the first drive.
    fn parse(
        (drive_line, drive): (usize, &str),
        (volts_line, volts): (usize, &str),
        header: &Header,
        electrodes: Option<usize>,
    ) -> Result<Self, Problem> {
        let driven = driven(drive).ok_or_else(|| {
            let problem = "expected the two driven electrodes, from 1, as in `1 2`";
            (drive_line, problem.to_owned())
        })?;
        let (real, imaginary) = potentials(volts, header.channels.as_deref())
            .map_err(|problem| (volts_line, problem.to_owned()))?;
        let count = real.len();
        if electrodes.is_some_and(|electrodes| electrodes != count) {
            let problem = format!("{count} potentials where the first drive has another number");
            return Err((volts_line, problem));
        }
        if driven.0.max(driven.1) >= count {
            let problem = format!("drives an electrode beyond the {count} that are read");
            return Err((drive_line, problem));
        }
        Ok(Self {
            electrodes: driven,
            real,
            imaginary,
        })
    }
}

/// The electrodes of a header's list, from 0; none if the list is wrong. An electrode that is listed twice is
/// refused: such a list could make a small file fill the memory.
fn electrodes(list: &str) -> Option<Vec<usize>> {
    let electrodes: Vec<usize> = list
        .split(',')
        .map(|word| word.trim().parse::<usize>().ok()?.checked_sub(1))
        .collect::<Option<_>>()?;
    let mut sorted = electrodes.clone();
    sorted.sort_unstable();
    sorted
        .windows(2)
        .all(|pair| pair[0] < pair[1])
        .then_some(electrodes)
}

/// The two electrodes of a drive's line, from 0.
fn driven(line: &str) -> Option<(usize, usize)> {
    let mut words = line.split_whitespace().map(str::parse::<usize>);
    match (words.next(), words.next(), words.next()) {
        (Some(Ok(into)), Some(Ok(out)), None) if into >= 1 && out >= 1 && into != out => {
            Some((into - 1, out - 1))
        }
        _ => None,
    }
}

/// Real and imaginary parts of a line of potentials, V, of the listed electrodes or of all.
fn potentials(line: &str, listed: Option<&[usize]>) -> Result<(Vec<f64>, Vec<f64>), &'static str> {
    let numbers = line
        .split_whitespace()
        .map(|word| {
            word.parse()
                .ok()
                .filter(|volt: &f64| volt.abs() <= LARGEST_V)
        })
        .collect::<Option<Vec<f64>>>()
        .unwrap_or_default();
    let (all @ [_, ..], []) = numbers.as_chunks::<2>() else {
        return Err("expected a real and an imaginary part for each electrode");
    };
    let of_pad: Vec<[f64; 2]> = match listed {
        None => all.to_vec(),
        Some(listed) => listed
            .iter()
            .map(|electrode| all.get(*electrode).copied())
            .collect::<Option<_>>()
            .ok_or("fewer potentials than the header lists channels")?,
    };
    Ok(of_pad
        .into_iter()
        .map(|[real, imaginary]| (real, imaginary))
        .unzip())
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "12\n2\nsetup\n2025\n1e4\n1e4\n1\n1\n0.005\n20.0\n0\n1\n";

    fn parse(body: &str) -> Result<EitFrame, String> {
        EitFrame::parse(Path::new("f.eit"), &format!("{HEADER}{body}"))
            .map_err(|error| error.to_string())
    }

    #[test]
    fn potentials_become_differences_of_neighbours() {
        let frame = parse("1 2\n9\t0\t8\t0\t5\t1\t3\t0\t2\t0\n2 3\n9\t0\t8\t0\t5\t1\t3\t0\t1\t0\n")
            .expect("sound");
        assert_eq!(frame.frames_per_s, 20.0);
        assert_eq!(frame.drives[1].electrodes, (1, 2));
        // Drive (0, 1) leaves pairs (2, 3) and (3, 4); drive (1, 2) leaves (3, 4) and (4, 0).
        assert_eq!(frame.adjacent(), [2.0, 1.0, 2.0, -8.0]);
    }

    #[test]
    fn a_damaged_header_is_refused_at_its_line() {
        let error_of = |line: usize, text: &str| {
            let mut lines: Vec<&str> = HEADER.lines().collect();
            lines[line] = text;
            let text = format!("{}\n1 2\n9 0 8 0 5 1 3 0\n", lines.join("\n"));
            let error = EitFrame::parse(Path::new("f.eit"), &text).expect_err("refused");
            error.to_string()
        };
        for rate in ["", "0", "-20", "nan", "1e-9", "1e9"] {
            let expected =
                "f.eit:10: the frame rate is not a number from 0.001 to 1000000 frames/s";
            assert_eq!(error_of(9, rate), expected);
        }
        for channels in ["", "0,1", "1,1", "1;2", "1,2,3,2"] {
            let message = error_of(11, &format!("{CHANNELS_LINE}{channels}"));
            assert!(
                message.starts_with("f.eit:12: expected the measured"),
                "{message}"
            );
        }
        for channels in ["5", "18446744073709551615"] {
            let message = error_of(11, &format!("{CHANNELS_LINE} 1,2,{channels}"));
            assert!(
                message.starts_with("f.eit:14: fewer potentials"),
                "{message}"
            );
        }
    }

    #[test]
    fn a_damaged_file_is_refused_at_its_line() {
        for (body, message) in [
            ("1 2\n", "f.eit:13: a drive without potentials"),
            ("0 2\n1 0 2 0\n", "f.eit:13: expected the two driven"),
            ("1 2\n1 0 2\n", "f.eit:14: expected a real"),
            ("1 2\n1 0 x 0\n", "f.eit:14: expected a real"),
            ("1 2\n1 0 1e31 0\n", "f.eit:14: expected a real"),
            ("1 7\n1 0 2 0\n", "f.eit:13: drives an electrode beyond"),
            ("1 2\n1 0 2 0\n2 1\n1 0\n", "f.eit:16: 1 potentials"),
        ] {
            let error = parse(body).expect_err(body);
            assert!(error.starts_with(message), "{error}");
        }
        let short = EitFrame::parse(Path::new("f.eit"), "18\n1\n").expect_err("short");
        assert!(short.to_string().contains("not an .eit file"));
    }
}
