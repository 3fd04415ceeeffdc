//! Sciospec's `.eit` text files: one frame a file, potentials of every electrode for every drive.
//!
//! The first line gives the number of header lines; then come pairs of lines: the two driven electrodes, counted from 1,
//! and the real and imaginary part of every electrode's potential. Potentials are single-ended: what gelpad works
//! with are differences of neighbours, which [`EitFrame::adjacent`] takes.

use std::path::Path;

use super::SourceError;

/// A larger file is no frame, bytes: a frame of 16 electrodes takes 12 kB.
const LARGEST_FILE: u64 = 16 << 20;
/// The header's line that lists the electrodes, from 1, whose potentials are of the pad: larger instruments list all theirs.
const CHANNELS_LINE: &str = "MeasurementChannels:";
/// Header line (from 0) of the frame rate.
const RATE_LINE: usize = 9;
/// Frame rates that an instrument can have, 1/s: one frame in a quarter of an hour is none any more.
const RATES_PER_S: std::ops::RangeInclusive<f64> = 1e-3..=1e6;
/// A potential beyond this is none, V: differences of such fit a single float.
const MOST_V: f64 = 1e30;

/// A frame as the instrument wrote it.
#[derive(Clone, Debug, PartialEq)]
pub struct EitFrame {
    /// Frames a second, as the header says.
    pub frames_per_s: f64,
    /// What each drive gave, in the file's order.
    pub drives: Vec<EitDrive>,
}

/// One drive of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct EitDrive {
    /// The electrodes where current goes in and out, from 0.
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
    /// A file that cannot be read or holds something else.
    pub fn open(path: &Path) -> Result<Self, SourceError> {
        use std::io::Read as _;

        let mut text = String::new();
        std::fs::File::open(path)
            .and_then(|file| file.take(LARGEST_FILE).read_to_string(&mut text))
            .map_err(|error| SourceError::File {
                path: path.to_owned(),
                error,
            })?;
        Self::parse(path, &text)
    }

    /// Reads the text of a file; `path` stands for it in messages.
    ///
    /// # Errors
    /// The first line that is not what it should be.
    pub fn parse(path: &Path, text: &str) -> Result<Self, SourceError> {
        let lines: Vec<&str> = text.lines().collect();
        let problem = |line: usize, problem: String| SourceError::Line {
            path: path.to_owned(),
            line: line as u64 + 1,
            problem,
        };
        let header: usize = lines
            .first()
            .and_then(|line| line.trim().parse().ok())
            .filter(|count| (RATE_LINE + 1..lines.len()).contains(count))
            .ok_or_else(|| {
                problem(0, "no .eit file: the first line must be the number of header lines, and readings follow them".to_owned())
            })?;
        let frames_per_s: f64 = lines[RATE_LINE]
            .trim()
            .parse()
            .ok()
            .filter(|rate| RATES_PER_S.contains(rate))
            .ok_or_else(|| {
                let (least, most) = RATES_PER_S.into_inner();
                problem(
                    RATE_LINE,
                    format!("the frame rate is no number from {least} to {most} frames/s"),
                )
            })?;
        // Without such a line, all are.
        let channels = lines[..header]
            .iter()
            .enumerate()
            .find_map(|(line, text)| Some((line, text.strip_prefix(CHANNELS_LINE)?)))
            .map(|(line, list)| {
                electrodes(list).ok_or_else(|| {
                    problem(
                        line,
                        "expected the measured electrodes, from 1 and each once, as in `1,2,3`"
                            .to_owned(),
                    )
                })
            })
            .transpose()?;
        let mut drives: Vec<EitDrive> = Vec::new();
        let body: Vec<(usize, &str)> = lines
            .iter()
            .enumerate()
            .skip(header)
            .filter(|(_, line)| !line.trim().is_empty())
            .map(|(index, line)| (index, *line))
            .collect();
        for pair in body.chunks(2) {
            let [(drive_line, drive), (volts_line, volts)] = *pair else {
                return Err(problem(pair[0].0, "a drive without potentials".to_owned()));
            };
            let driven = driven(drive).ok_or_else(|| {
                problem(
                    drive_line,
                    "expected the two driven electrodes, from 1, as in `1 2`".to_owned(),
                )
            })?;
            let (real, imaginary) = potentials(volts, channels.as_deref())
                .map_err(|wrong| problem(volts_line, wrong.to_owned()))?;
            let count = real.len();
            if drives
                .first()
                .is_some_and(|first| first.real.len() != count)
            {
                return Err(problem(
                    volts_line,
                    format!("{count} potentials where the first drive has another number"),
                ));
            }
            if driven.0.max(driven.1) >= count {
                return Err(problem(
                    drive_line,
                    format!("drives an electrode beyond the {count} that are read"),
                ));
            }
            drives.push(EitDrive {
                electrodes: driven,
                real,
                imaginary,
            });
        }
        if drives.is_empty() {
            return Err(problem(header, "no reading follows the header".to_owned()));
        }
        Ok(Self {
            frames_per_s,
            drives,
        })
    }

    /// Real parts of the differences of neighbours, V(m) - V(m + 1), drive by drive, those that meet the drive left out:
    /// what [`recognise`](crate::eit::order::recognise) takes.
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

/// The electrodes of a header's list, from 0. One that is listed twice would let a small file fill the memory.
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

/// Real and imaginary parts of a line of potentials, V: of the electrodes that the header lists, or of all.
fn potentials(line: &str, listed: Option<&[usize]>) -> Result<(Vec<f64>, Vec<f64>), &'static str> {
    let numbers = line
        .split_whitespace()
        .map(|word| word.parse().ok().filter(|volt: &f64| volt.abs() <= MOST_V))
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
        let said = |line: usize, text: &str| {
            let mut lines: Vec<&str> = HEADER.lines().collect();
            lines[line] = text;
            let text = format!("{}\n1 2\n9 0 8 0 5 1 3 0\n", lines.join("\n"));
            let error = EitFrame::parse(Path::new("f.eit"), &text).expect_err("refused");
            error.to_string()
        };
        for rate in ["", "0", "-20", "nan", "1e-9", "1e9"] {
            let told = "f.eit:10: the frame rate is no number from 0.001 to 1000000 frames/s";
            assert_eq!(said(9, rate), told);
        }
        for channels in ["", "0,1", "1,1", "1;2", "1,2,3,2"] {
            let told = said(11, &format!("{CHANNELS_LINE}{channels}"));
            assert!(
                told.starts_with("f.eit:12: expected the measured"),
                "{told}"
            );
        }
        for channels in ["5", "18446744073709551615"] {
            let told = said(11, &format!("{CHANNELS_LINE} 1,2,{channels}"));
            assert!(told.starts_with("f.eit:14: fewer potentials"), "{told}");
        }
    }

    #[test]
    fn a_damaged_file_is_refused_at_its_line() {
        for (body, told) in [
            ("1 2\n", "f.eit:13: a drive without potentials"),
            ("0 2\n1 0 2 0\n", "f.eit:13: expected the two driven"),
            ("1 2\n1 0 2\n", "f.eit:14: expected a real"),
            ("1 2\n1 0 x 0\n", "f.eit:14: expected a real"),
            ("1 2\n1 0 1e31 0\n", "f.eit:14: expected a real"),
            ("1 7\n1 0 2 0\n", "f.eit:13: drives an electrode beyond"),
            ("1 2\n1 0 2 0\n2 1\n1 0\n", "f.eit:16: 1 potentials"),
        ] {
            let error = parse(body).expect_err(body);
            assert!(error.starts_with(told), "{error}");
        }
        let short = EitFrame::parse(Path::new("f.eit"), "18\n1\n").expect_err("short");
        assert!(short.to_string().contains("no .eit file"));
    }
}
