//! Records presses: shows a place, waits for the press, shows the next. What the pad reads between them is kept, too.

use anyhow::bail;

use super::map::Map;
use super::message::say;
use crate::app::error_estimate::ErrorEstimate;
use crate::calibrate::{GuidedReadings, PressRecorder, RecordedPress, Touching, UntouchedLevel};
use crate::pad::{Numbering, Pad};
use crate::source::{SkipLog, Source, SourceReading};
use crate::touch::Detector;
use crate::types::{Frame, PointMm};

/// Width of the map, characters.
const MAP_COLUMNS: usize = 40;

/// Who presses the pad.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Presser {
    /// A person, who repeats a press that was refused.
    Person,
    /// A robot or a file, which always goes on to the next place.
    Script,
}

/// Records presses at places until all are pressed, the source ends or a signal comes, which is returned. What was recorded before an
/// error is in `recorded`, too.
///
/// # Errors
/// A source that fails; a script that ends with fewer presses than places, since it is then unknown which one is missing.
pub(super) fn record(
    pad: &Pad,
    detector: Detector,
    source: &mut dyn Source,
    (presser, places): (Presser, &[PointMm]),
    recorded: &mut GuidedReadings,
    interrupted: &dyn Fn() -> Option<i32>,
) -> anyhow::Result<Option<i32>> {
    let mut recorder = DetectedPresses::new(detector);
    let (mut index, mut refused) = (0, 0);
    let mut log = SkipLog::default();
    let mut estimate = ErrorEstimate::default();
    say("do not touch the pad for a moment, then press each place once, as you usually do");
    show(pad, places, index);
    while index < places.len() {
        if let Some(signal) = interrupted() {
            return Ok(Some(signal));
        }
        if let Some(expected) = estimate.poll() {
            say(&expected.to_string());
        }
        let before = index;
        match source.read()? {
            SourceReading::Frame(frame) => {
                log.frame();
                let press = recorder.take_frame(&frame, places[index]);
                if recorder.level.is_untouched() {
                    recorded.take_untouched(&frame.volts);
                }
                match press {
                    RecordedPress::Pending => {}
                    RecordedPress::Refused(why) => {
                        refused += 1;
                        say(why);
                        index += usize::from(presser == Presser::Script);
                    }
                    RecordedPress::Complete(press) => {
                        recorded.presses.push(press);
                        estimate.begin(&recorded.presses, pad.outline.size_mm());
                        // The terminal's bell: the person looks at the pad.
                        say("\u{7}taken");
                        index += 1;
                    }
                }
            }
            SourceReading::Skipped { reason, .. } => log.skip(reason)?,
            SourceReading::Disconnected { reason } => tracing::warn!("{reason}"),
            // Boards are read frame by frame here.
            SourceReading::Part(_) | SourceReading::Control(_) | SourceReading::Idle => {}
            SourceReading::End if presser == Presser::Script => bail!(
                "{} presses were accepted and {refused} refused for {} places, and it is unknown which are missing\n  help: press harder or longer, or give the number of presses in the file with --points",
                recorded.presses.len(),
                places.len()
            ),
            SourceReading::End => break,
        }
        if index > before && index < places.len() {
            show(pad, places, index);
        }
    }
    if recorded.presses.len() < places.len() {
        say(&format!(
            "{} of {} places were pressed",
            recorded.presses.len(),
            places.len()
        ));
    }
    Ok(None)
}

/// Presses as a detector without a correction sees them.
struct DetectedPresses {
    detector: Detector,
    recorder: PressRecorder,
    level: UntouchedLevel,
}

impl DetectedPresses {
    fn new(detector: Detector) -> Self {
        Self {
            detector,
            recorder: PressRecorder::default(),
            level: UntouchedLevel::default(),
        }
    }

    fn take_frame(&mut self, frame: &Frame, shown_mm: PointMm) -> RecordedPress {
        self.detector.process_frame(frame, &mut Vec::new());
        let down = self.detector.touches_down().len();
        let touching = Touching::from_contacts(down, self.detector.uncorrected_contacts());
        let (changes, _) = self.detector.changes_and_explained();
        let is_turned = self.detector.board_numbering().0 != Numbering::default();
        let volts = (!is_turned).then_some(frame.volts.as_slice());
        let changes = self.level.take_frame(down > 0, volts, changes);
        self.recorder.take_frame(touching, changes, shown_mm)
    }
}

fn show(pad: &Pad, places: &[PointMm], index: usize) {
    let place = places[index];
    let map = Map::new(pad.outline.size_mm(), MAP_COLUMNS)
        .with_pad(pad)
        .with_mark(place, '✕');
    say(&format!(
        "{}\nplace {} of {}: press ✕ at ({}, {}) mm from the bottom-left",
        map.framed(),
        index + 1,
        places.len(),
        place[0],
        place[1]
    ));
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::app::places::calibration_places;
    use crate::calibrate::{Presses, fit_correction};
    use crate::eit::Reconstruction;
    use crate::pad::shipped_pad;
    use crate::source::{Noise, RobotSource, SimulatedPad};
    use crate::types::Method;

    #[test]
    fn presses_of_a_robot_correct_the_model() {
        let shipped = shipped_pad("openeit-lattice").expect("shipped");
        let pad = Pad::from_toml(shipped.name, shipped.toml).expect("sound");
        let matrix = Reconstruction::from_pad(&pad, Method::default()).expect("a matrix");
        let places = calibration_places(&pad, 40);
        // The electrodes of the pressed pad are shifted; those of the model are not.
        let mut shifted = pad.clone();
        for electrode in &mut shifted.electrodes {
            electrode.start_mm += 4.0;
        }
        let mut robot =
            RobotSource::new(&shifted, places.clone(), Noise::new(60.0, 3), 3).expect("solvable");
        let mut recorded = GuidedReadings::default();
        record(
            &pad,
            Detector::new(Arc::new(matrix)),
            &mut robot,
            (Presser::Script, &places),
            &mut recorded,
            &|| None,
        )
        .expect("recorded");
        let GuidedReadings { presses, untouched } = recorded;
        assert!(presses.len() >= 36, "{} presses", presses.len());
        let rest = SimulatedPad::new(&shifted).expect("solvable");
        let rest = rest.volts(&[]).expect("solved");
        assert!(untouched.len() >= 50, "{} frames", untouched.len());
        for volts in &untouched {
            let pairs = volts.iter().zip(&rest);
            let off = crate::stats::rms(pairs.map(|(volt, rest)| f64::from(*volt) / rest - 1.0));
            assert!(off < 3e-3, "a frame that was kept is {off} off");
        }
        let presses = Presses::new("recorded", presses).expect("spread");
        let fitted = fit_correction(&presses, pad.outline.size_mm()).expect("learned");
        assert!(
            fitted.lone.mean_mm < 0.8 * fitted.model.mean_mm,
            "{:?} {:?}",
            fitted.model,
            fitted.lone
        );
    }
}
