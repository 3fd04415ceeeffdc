//! Identifies the pad from the presses of the window, beside the game, and saves it among the player's own pads.

use std::path::{Path, PathBuf};
use std::sync::mpsc;

use super::{describe_presses, identify_pad};
use crate::app::AppError;
use crate::app::folders::own_folder;
use crate::app::pads::load_drawn_pad;
use crate::app::table_solver::low_priority_threads;
use crate::calibrate::{GuidedReadings, Presses, free_file_name};
use crate::files::{self, FileError};

/// The saved pad and what was found, or why none was.
pub type FoundFromPresses = Result<(PathBuf, String), String>;

/// Begins to identify a pad; what is found comes later. Nothing comes if the thread cannot start.
pub(in crate::app) fn begin(
    pad: String,
    readings: GuidedReadings,
) -> mpsc::Receiver<FoundFromPresses> {
    let (found_in, found) = mpsc::sync_channel(1);
    let thread = std::thread::Builder::new().name("identify".to_owned());
    let spawned = thread.spawn(move || {
        let folder = own_folder().map(|folder| folder.join("pads"));
        let identified = match folder {
            Some(folder) => identify_and_save(&pad, readings, &folder),
            None => Err(AppError::Unsuitable(
                "there is no folder for your own settings: set HOME".to_owned(),
            )),
        };
        // The window may be gone.
        let _ = found_in.send(identified.map_err(|error| error.to_string()));
    });
    if let Err(error) = spawned {
        tracing::warn!("the pad is not identified: {error}");
    }
    found
}

fn identify_and_save(
    pad: &str,
    GuidedReadings { presses, untouched }: GuidedReadings,
    folder: &Path,
) -> Result<(PathBuf, String), AppError> {
    let drawing = load_drawn_pad(pad)?;
    let presses = Presses::new("the presses", presses)?;
    let threads = low_priority_threads()
        .map_err(|error| AppError::Thread(std::io::Error::other(error.to_string())))?;
    let found =
        threads.install(|| identify_pad(&drawing, &Vec::from(untouched), Some(&presses)))?;
    std::fs::create_dir_all(folder).map_err(|error| FileError::new(folder, error))?;
    let name = free_file_name(&format!("{}-found", drawing.pad.name), "toml", |name| {
        folder.join(name).exists()
    });
    let path = folder.join(name);
    files::write(&path, found.toml.as_bytes())?;
    let [drawn, as_found] = found.found.misfit.map(|share| 100.0 * share);
    let summary = format!(
        "the pad as it is: its readings are {drawn:.1} % off as drawn, {as_found:.2} % as found; presses: {}",
        describe_presses(&found)
    );
    Ok((path, summary))
}

#[cfg(test)]
mod tests {
    use std::collections::VecDeque;

    use super::*;
    use crate::app::places::calibration_places;
    use crate::calibrate::{ModelPrediction, Press};
    use crate::eit::Press as Finger;
    use crate::pad::{DEFAULT_PAD, Deviations, Pad, cell_sites_mm, shipped_pad};
    use crate::source::{Noise, SimulatedPad};

    #[test]
    fn a_pad_is_saved_under_a_name_of_its_own() {
        let toml = shipped_pad(DEFAULT_PAD).expect("shipped").toml;
        let drawing = Pad::from_toml(DEFAULT_PAD, toml).expect("sound");
        let cells = cell_sites_mm(&drawing).into_iter();
        let cells = cells.map(|site| (site, 1.0 + 0.2 * libm::sin(site[0] + 2.0 * site[1])));
        let built = drawing.with_deviations(Deviations::new(cells.collect(), Vec::new()));
        let simulated = SimulatedPad::new(&built).expect("solvable");
        let rest = simulated.volts(&[]).expect("solved");
        let mut noise = Noise::new(60.0, 1);
        let press = |place_mm: [f64; 2]| {
            let finger = Finger {
                centre_mm: place_mm,
                radius_mm: 7.0,
                rise: 1.2,
            };
            let volts = simulated.volts(&[finger]).expect("solved");
            let pairs = volts.iter().zip(&rest);
            Press {
                place_mm,
                modelled: Some(ModelPrediction {
                    force: 0.5,
                    place_mm,
                }),
                changes: pairs.map(|(volt, rest)| volt / rest - 1.0).collect(),
            }
        };
        let readings = GuidedReadings {
            presses: calibration_places(&drawing, 8)
                .into_iter()
                .map(press)
                .collect(),
            untouched: (0..20).map(|_| noise.read(&rest)).collect(),
        };
        let folder = tempfile::tempdir().expect("a folder");
        let taken = folder.path().join("edinburgh-lattice-found.toml");
        std::fs::write(&taken, "mine").expect("written");
        let (path, summary) =
            identify_and_save(DEFAULT_PAD, readings.clone(), folder.path()).expect("found");
        let name = "edinburgh-lattice-found-2.toml";
        assert_eq!(path, folder.path().join(name));
        assert_eq!(std::fs::read_to_string(&taken).expect("there"), "mine");
        assert!(summary.contains("8, all explained"), "{summary}");
        let text = std::fs::read_to_string(&path).expect("written");
        let pad = Pad::from_toml(name, &text).expect("sound");
        assert!(!pad.deviations.cells.is_empty());
        let few = GuidedReadings {
            untouched: VecDeque::new(),
            ..readings
        };
        let error = identify_and_save(DEFAULT_PAD, few, folder.path()).expect_err("no frames");
        assert!(error.to_string().contains("untouched"), "{error}");
    }
}
