//! A folder of Sciospec's `.eit` files as a source: one frame a file, in the order of the numbers in the
//! names, at the frame rate of the header.

use std::fs;
use std::path::{Path, PathBuf};

use super::eit_text::EitFrame;
use super::{Arrangement, Source, SourceError, SourcePace, SourceReading};
use crate::pad::{Channel, Pad, Pair};
use crate::types::{Frame, Nanos};

/// The files of a folder, read one after the other.
pub struct EitFolder {
    paths: std::vec::IntoIter<PathBuf>,
    arrangement: Arrangement,
    frame_s: f64,
    count: u64,
}

impl EitFolder {
    /// Opens a folder of frames of a pad, or one file.
    ///
    /// # Errors
    /// The folder cannot be read or holds no `.eit` file, or the frames are of another pad.
    pub fn open(path: &Path, pad: &Pad) -> Result<Self, SourceError> {
        let paths = files(path)?;
        let first = EitFrame::open(&paths[0])?;
        let listing: Vec<Channel> = listing(&first);
        let arrangement = Arrangement::find(&values(&first), Some(&listing), None, pad)
            .map_err(|error| SourceError::line(&paths[0], 1, error.to_string()))?;
        tracing::info!(
            target: "gelpad::told",
            "{}: {} frames, {} frames/s; {}",
            path.display(),
            paths.len(),
            first.frames_per_s,
            arrangement.summary()
        );
        Ok(Self {
            paths: paths.into_iter(),
            arrangement,
            frame_s: 1.0 / first.frames_per_s,
            count: 0,
        })
    }
}

impl Source for EitFolder {
    fn pace(&self) -> SourcePace {
        SourcePace::ByStamp
    }

    fn read(&mut self) -> Result<SourceReading, SourceError> {
        let Some(path) = self.paths.next() else {
            return Ok(SourceReading::End);
        };
        let values = values(&EitFrame::open(&path)?);
        if values.len() != self.arrangement.values() {
            return Err(SourceError::Line {
                path,
                line: 1,
                problem: format!(
                    "{} differences of neighbours where the first file has {}",
                    values.len(),
                    self.arrangement.values()
                ),
            });
        }
        let t_ns = (self.count as f64 * self.frame_s * 1e9).round() as Nanos;
        self.count += 1;
        Ok(SourceReading::Frame(Frame {
            t_ns,
            volts: self.arrangement.apply(&values),
        }))
    }
}

/// The differences with gelpad's sign: second electrode minus first.
fn values(frame: &EitFrame) -> Vec<f32> {
    frame.adjacent().iter().map(|volt| -volt as f32).collect()
}

/// The channels in the order of [`EitFrame::adjacent`].
fn listing(frame: &EitFrame) -> Vec<Channel> {
    frame
        .drives
        .iter()
        .flat_map(|drive| {
            let count = drive.real.len();
            let drive = Pair(drive.electrodes.0, drive.electrodes.1);
            (0..count)
                .map(move |m| Channel {
                    drive,
                    measure: Pair(m, (m + 1) % count),
                })
                .filter(|channel| !channel.drive.shares_electrode(channel.measure))
        })
        .collect()
}

/// The `.eit` files of a folder, at least one, in the order of their numbers.
fn files(path: &Path) -> Result<Vec<PathBuf>, SourceError> {
    let failed = |error| SourceError::file(path, error);
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let mut files: Vec<(u64, PathBuf)> = Vec::new();
    for entry in fs::read_dir(path).map_err(failed)? {
        let file = entry.map_err(failed)?.path();
        if file.extension().is_some_and(|extension| extension == "eit") {
            files.push((number(&file), file));
        }
    }
    files.sort();
    if files.is_empty() {
        return Err(failed(std::io::Error::other(
            "no .eit files in this folder",
        )));
    }
    Ok(files.into_iter().map(|(_, file)| file).collect())
}

/// The number at the end of a name, as in `setup_00017.eit`.
fn number(file: &Path) -> u64 {
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    let digits = name.len() - name.trim_end_matches(|c: char| c.is_ascii_digit()).len();
    name[name.len() - digits..].parse().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::shipped_pad;

    const HEADER: &str = "12\n2\nsetup\n2025\n1e4\n1e4\n1\n1\n0.005\n20.0\n0\n1\n";

    fn tank() -> Pad {
        Pad::from_toml("p", shipped_pad("round-tank").expect("shipped").toml).expect("sound")
    }

    /// Potentials rise from the second driven electrode round to the first.
    fn text(drive_step: usize, scale: f64) -> String {
        let drives = (0..16).map(|drive| {
            let volts: Vec<String> = (0..16)
                .map(|e| format!("{}\t0.1", scale * ((e + 15 - drive) % 16) as f64))
                .collect();
            format!(
                "{} {}\n{}\n",
                drive + 1,
                (drive + drive_step) % 16 + 1,
                volts.join("\t")
            )
        });
        HEADER.to_owned() + &drives.collect::<String>()
    }

    #[test]
    fn a_folder_is_played_in_the_order_of_its_numbers_at_its_rate() {
        let folder = tempfile::tempdir().expect("a folder");
        // In the alphabet 10 would come before 9.
        for n in 8..11 {
            let path = folder.path().join(format!("setup_{n}.eit"));
            fs::write(path, text(1, n as f64)).expect("written");
        }
        let mut source = EitFolder::open(folder.path(), &tank()).expect("opened");
        for n in 8..11_u64 {
            let Ok(SourceReading::Frame(frame)) = source.read() else {
                panic!("no frame {n}")
            };
            assert_eq!(frame.t_ns, (n - 8) * 50_000_000);
            assert_eq!(frame.volts, [n as f32; 208]);
        }
        assert_eq!(source.read().expect("all read"), SourceReading::End);
    }

    #[test]
    fn an_empty_folder_and_other_drives_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let error_of = |path: &Path| {
            EitFolder::open(path, &tank())
                .err()
                .expect("refused")
                .to_string()
        };
        assert!(error_of(folder.path()).contains("no .eit files"));
        let path = folder.path().join("opposite.eit");
        fs::write(&path, text(8, 1.0)).expect("written");
        assert!(
            error_of(&path)
                .contains("the pad round-tank is measured with another protocol (208 voltages)")
        );
    }
}
