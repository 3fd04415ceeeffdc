//! Recording presses: shows a place, waits for a touch, takes its mean, goes on to the next.
//!
//! A press counts while exactly one touch is down: its first frames are left out, as the finger still sinks in, and the mean
//! of the following ones is taken. What the untouched pad reads is the mean of the last frames before the press.

use std::collections::VecDeque;
use std::io::Write as _;

use anyhow::bail;

use crate::calibrate::{Modelled, Press};
use crate::cli::map::Map;
use crate::pad::Pad;
use crate::source::{Reading, Source};
use crate::touch::Detector;
use crate::types::{Frame, PointMm, Touch};

/// Frames of a press that are left out while the finger sinks in, and frames whose mean is taken.
const SETTLE_FRAMES: usize = 5;
const TAKEN_FRAMES: usize = 15;
/// Frames of the untouched pad whose mean is taken, and those just before a press that are left out.
const REST_FRAMES: usize = 20;
const EVE_FRAMES: usize = 2;
/// Places keep this share of the pad's shorter side from its edge.
const EDGE_SHARE: f64 = 0.08;
/// Characters across the map.
const MAP_COLUMNS: usize = 40;

/// Places spread evenly over a pad, in an order that jumps about.
pub(in crate::cli) fn places(pad: &Pad, count: usize) -> Vec<PointMm> {
    // The R2 sequence (Roberts 2018): powers of the inverse of the plastic number.
    const STEP: [f64; 2] = [0.754_877_666_246_693, 0.569_840_290_998_053];
    let size = pad.outline.size_mm();
    let edge = EDGE_SHARE * size[0].min(size[1]);
    let clear = |[x, y]: PointMm| {
        [[edge, 0.0], [-edge, 0.0], [0.0, edge], [0.0, -edge]]
            .into_iter()
            .all(|[dx, dy]| pad.outline.contains([x + dx, y + dy]))
    };
    (0..)
        .map(|index| [0, 1].map(|axis| (0.5 + f64::from(index) * STEP[axis]).fract() * size[axis]))
        .filter(|place| clear(*place))
        .map(|place| place.map(|value: f64| value.round()))
        .take(count)
        .collect()
}

/// Who presses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Presser {
    /// Someone who presses a place again when told to.
    Listens,
    /// A robot or a file: it goes on to the next place, whatever is said.
    GoesOn,
}

/// Records presses at places until all are pressed or the source ends.
///
/// # Errors
/// A source that fails; one that goes on by itself and of whose presses some were not seen: then nobody knows which.
pub(super) fn record(
    pad: &Pad,
    detector: Detector,
    source: &mut dyn Source,
    presser: Presser,
    places: &[PointMm],
) -> anyhow::Result<Vec<Press>> {
    let mut recorder = Recorder {
        detector,
        rest: VecDeque::new(),
        taken: Taken::default(),
        seen: 0,
    };
    let mut presses: Vec<Press> = Vec::new();
    let mut index = 0;
    say("leave the pad alone for a moment, then press each place once, as you usually do");
    show(pad, places, index);
    while index < places.len() {
        let before = index;
        match source.read()? {
            Reading::Frame(frame) => match recorder.frame(&frame) {
                Outcome::Nothing => {}
                Outcome::Unfit(why) => {
                    say(why);
                    index += usize::from(presser == Presser::GoesOn);
                }
                Outcome::Press { changes, modelled } => {
                    presses.push(Press {
                        place_mm: places[index],
                        modelled: Some(modelled),
                        changes,
                    });
                    // The terminal's bell: eyes are on the pad.
                    say("\u{7}taken");
                    index += 1;
                }
            },
            Reading::Skipped { reason, .. } => tracing::warn!("skipped what is no frame: {reason}"),
            Reading::Gone { reason } => tracing::warn!("{reason}"),
            Reading::Control(_) | Reading::Idle => {}
            Reading::End if presser == Presser::GoesOn => bail!(
                "{index} presses were seen for {} places: one that was missed cannot be told from its neighbours\n  help: press harder or longer, or give the file's own number with --points",
                places.len()
            ),
            Reading::End => break,
        }
        if index > before && index < places.len() {
            show(pad, places, index);
        }
    }
    if presses.len() < places.len() {
        say(&format!(
            "{} of {} places were pressed",
            presses.len(),
            places.len()
        ));
    }
    Ok(presses)
}

/// What a frame completed.
enum Outcome {
    Nothing,
    /// A press that cannot be used, and why.
    Unfit(&'static str),
    Press {
        changes: Vec<f64>,
        modelled: Modelled,
    },
}

struct Recorder {
    detector: Detector,
    /// The last frames of the untouched pad.
    rest: VecDeque<Vec<f32>>,
    taken: Taken,
    /// Frames of this press so far, those left out too.
    seen: usize,
}

/// What was taken of a press.
#[derive(Default)]
struct Taken {
    volts: Vec<Vec<f32>>,
    contacts: Vec<(PointMm, f64)>,
    several: bool,
}

impl Recorder {
    fn frame(&mut self, frame: &Frame) -> Outcome {
        let mut changed: Vec<Touch> = Vec::new();
        self.detector.frame(frame, &mut changed);
        let down = self.detector.state().down;
        match down {
            [] if self.seen == 0 => {
                self.rest.push_back(frame.volts.clone());
                if self.rest.len() > REST_FRAMES + EVE_FRAMES {
                    self.rest.pop_front();
                }
                Outcome::Nothing
            }
            [] => {
                let taken = std::mem::take(&mut self.taken);
                self.seen = 0;
                let outcome = if taken.several {
                    Outcome::Unfit("several touches at once: press with one finger")
                } else {
                    self.press(&taken)
                };
                self.rest.clear();
                outcome
            }
            [touch] => {
                self.seen += 1;
                let wanted = SETTLE_FRAMES + 1..=SETTLE_FRAMES + TAKEN_FRAMES;
                if wanted.contains(&self.seen) {
                    let contact = touch.contact;
                    self.taken.volts.push(frame.volts.clone());
                    self.taken.contacts.push((contact.centre_mm, contact.force));
                }
                Outcome::Nothing
            }
            _ => {
                self.seen += 1;
                self.taken.several = true;
                Outcome::Nothing
            }
        }
    }

    fn press(&self, taken: &Taken) -> Outcome {
        let rest_frames = self.rest.len().saturating_sub(EVE_FRAMES);
        if taken.volts.is_empty() || rest_frames == 0 {
            return Outcome::Unfit("too short: press a little longer");
        }
        let rest = mean(self.rest.iter().take(rest_frames));
        let pressed = mean(taken.volts.iter());
        let changes = pressed
            .iter()
            .zip(&rest)
            // A dead channel reads nothing and changes by nothing.
            .map(|(v, v0)| if *v0 == 0.0 { 0.0 } else { (v - v0) / v0 })
            .collect();
        let count = taken.contacts.len() as f64;
        let mean_of = |of: &dyn Fn(&(PointMm, f64)) -> f64| {
            taken.contacts.iter().map(of).sum::<f64>() / count
        };
        Outcome::Press {
            changes,
            modelled: Modelled {
                force: mean_of(&|(_, force)| *force),
                place_mm: [
                    mean_of(&|(place, _)| place[0]),
                    mean_of(&|(place, _)| place[1]),
                ],
            },
        }
    }
}

fn mean<'a>(frames: impl Iterator<Item = &'a Vec<f32>>) -> Vec<f64> {
    let mut sums: Vec<f64> = Vec::new();
    let mut count = 0.0;
    for frame in frames {
        sums.resize(frame.len(), 0.0);
        for (sum, volt) in sums.iter_mut().zip(frame) {
            *sum += f64::from(*volt);
        }
        count += 1.0;
    }
    sums.iter().map(|sum| sum / count).collect()
}

fn show(pad: &Pad, places: &[PointMm], index: usize) {
    let place = places[index];
    let map = Map::new(pad.outline.size_mm(), MAP_COLUMNS)
        .pad(pad)
        .marked(place, '✕');
    say(&format!(
        "{}\nplace {} of {}: press ✕ at ({}, {}) mm from the bottom-left",
        map.framed(),
        index + 1,
        places.len(),
        place[0],
        place[1]
    ));
}

fn say(text: &str) {
    // A closed stderr is no reason to stop.
    let _ = writeln!(std::io::stderr(), "{text}");
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::calibrate::{Presses, correction};
    use crate::eit::Reconstruction;
    use crate::pad::{SHIPPED_PADS, shipped_pad};
    use crate::source::{Noise, Robot};
    use crate::types::Method;

    #[test]
    fn places_lie_on_every_pad_and_apart() {
        for shipped in SHIPPED_PADS {
            let pad = Pad::from_toml(shipped.name, shipped.toml).expect("sound");
            let places = places(&pad, 50);
            assert_eq!(places.len(), 50);
            for (i, a) in places.iter().enumerate() {
                assert!(pad.outline.contains(*a), "{}: {a:?}", pad.name);
                let size = pad.outline.size_mm();
                for b in &places[..i] {
                    let gap = (a[0] - b[0]).hypot(a[1] - b[1]);
                    assert!(gap > 0.05 * size[0].min(size[1]), "{a:?} {b:?}");
                }
            }
        }
    }

    #[test]
    fn what_a_robot_presses_is_recorded_and_sets_the_model_right() {
        let shipped = shipped_pad("openeit-lattice").expect("shipped");
        let pad = Pad::from_toml(shipped.name, shipped.toml).expect("sound");
        let matrix = Reconstruction::of_pad(&pad, Method::default()).expect("a matrix");
        let places = places(&pad, 40);
        // The pad that is pressed has its electrodes askew, which its model does not know.
        let mut askew = pad.clone();
        for electrode in &mut askew.electrodes {
            electrode.start_mm += 4.0;
        }
        let mut robot =
            Robot::new(&askew, places.clone(), Noise::new(60.0, 3), 3).expect("solvable");
        let presses = record(
            &pad,
            Detector::new(Arc::new(matrix)),
            &mut robot,
            Presser::GoesOn,
            &places,
        )
        .expect("recorded");
        assert!(presses.len() >= 36, "{} presses", presses.len());
        let presses = Presses::new("recorded", presses).expect("spread");
        let fitted = correction(&presses, pad.outline.size_mm()).expect("learned");
        assert!(
            fitted.lone.mean_mm < 0.8 * fitted.model.mean_mm,
            "{:?} {:?}",
            fitted.model,
            fitted.lone
        );
    }
}
