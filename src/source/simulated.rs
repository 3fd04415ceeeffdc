//! The simulated pad: fingers of a script, voltages from the real forward model, noise from a seed.
//!
//! It lives in the library because tests, demonstrations and users without a pad share it. It is solved on a mesh
//! other than the reconstruction's, so that no image is made with the model that made its voltages.

use std::collections::BTreeMap;

use super::{Finger, Noise, Pace, Reading, Script, Source, SourceError, Step, StepKind};
use crate::eit::{ContactModel, ForwardError, ForwardModel, Mesh, MeshSize};
use crate::pad::{Pad, TouchSign};
use crate::types::{Frame, NANOS_PER_MS, Nanos};

/// 100 frames a second.
const FRAME_NS: Nanos = 10 * NANOS_PER_MS;

/// A pad that can be touched and read.
#[derive(Clone, Debug)]
pub struct SimulatedPad {
    pad: Pad,
    model: ForwardModel,
}

impl SimulatedPad {
    /// Meshes a pad for simulation.
    ///
    /// # Errors
    /// A pad whose conductor or electrodes cannot be solved.
    pub fn new(pad: &Pad) -> Result<Self, ForwardError> {
        let mesh = Mesh::of_pad(pad, MeshSize::simulation(pad));
        Ok(Self {
            model: ForwardModel::new(mesh, &ContactModel::of_pad(pad))?,
            pad: pad.clone(),
        })
    }

    /// The voltages, V/A, while the fingers press.
    ///
    /// # Errors
    /// A conductivity that leaves the model unsolvable.
    pub fn volts(&self, fingers: &[Finger]) -> Result<Vec<f64>, ForwardError> {
        let conductivity = self.model.mesh().mean_over_triangles(|[x, y]| {
            let factor: f64 = fingers
                .iter()
                .map(|finger| {
                    let [dx, dy] = [x - finger.centre_mm[0], y - finger.centre_mm[1]];
                    let share = (dx * dx + dy * dy) / (finger.radius_mm * finger.radius_mm);
                    1.0 + finger.rise * (1.0 - share).max(0.0)
                })
                .product();
            match self.pad.touch_sign {
                TouchSign::Rise => self.pad.background_s_per_m * factor,
                TouchSign::Fall => self.pad.background_s_per_m / factor,
            }
        });
        let fields = self.model.solve(&conductivity)?;
        Ok(fields.voltages(&self.pad.protocol))
    }
}

/// The simulated pad as a source: plays a script at 100 frames a second.
pub struct SimulatedSource {
    states: Vec<Vec<f64>>,
    /// From when on which state holds.
    changes: Vec<(Nanos, usize)>,
    end_ns: Nanos,
    next_ns: Nanos,
    noise: Noise,
}

impl SimulatedSource {
    /// Solves the pad for every state of a script, ahead of time: playing then takes none.
    ///
    /// # Errors
    /// A finger off the pad; a pad that cannot be solved.
    pub fn new(pad: &Pad, script: &Script, noise: Noise) -> Result<Self, SourceError> {
        for step in script.steps() {
            let (id, [x, y]) = match step.kind {
                StepKind::Down(finger) => (finger.id, finger.centre_mm),
                StepKind::Move { id, centre_mm, .. } => (id, centre_mm),
                StepKind::Up { .. } => continue,
            };
            if !pad.outline.contains([x, y]) {
                let [width, height] = pad.outline.size_mm();
                return Err(SourceError::OffPad {
                    id,
                    x,
                    y,
                    width,
                    height,
                });
            }
        }
        let simulated = SimulatedPad::new(pad)?;
        let mut known: BTreeMap<Vec<[u64; 4]>, usize> = BTreeMap::new();
        let mut states = Vec::new();
        let mut fingers: Vec<Finger> = Vec::new();
        let mut changes = Vec::new();
        let mut enter = |t_ns: Nanos, fingers: &[Finger]| -> Result<(), ForwardError> {
            let key = fingers.iter().map(bits).collect();
            let state = match known.get(&key) {
                Some(state) => *state,
                None => {
                    states.push(simulated.volts(fingers)?);
                    known.insert(key, states.len() - 1);
                    states.len() - 1
                }
            };
            changes.push((t_ns, state));
            Ok(())
        };
        enter(0, &[])?;
        for steps in script.steps().chunk_by(|a, b| a.t_ns == b.t_ns) {
            for step in steps {
                apply(&mut fingers, step);
            }
            enter(steps[0].t_ns, &fingers)?;
        }
        Ok(Self {
            states,
            changes,
            end_ns: script.end_ns(),
            next_ns: 0,
            noise,
        })
    }
}

impl SimulatedSource {
    /// The voltages at a time, V/A, without noise.
    pub(super) fn volts_at(&self, t_ns: Nanos) -> &[f64] {
        let since = self.changes.partition_point(|(from, _)| *from <= t_ns);
        let (_, state) = self.changes[since - 1];
        &self.states[state]
    }

    /// When the script is over.
    pub(super) fn end_ns(&self) -> Nanos {
        self.end_ns
    }
}

impl Source for SimulatedSource {
    fn pace(&self) -> Pace {
        Pace::ByStamp
    }

    fn read(&mut self) -> Result<Reading, SourceError> {
        if self.next_ns > self.end_ns {
            return Ok(Reading::End);
        }
        let t_ns = self.next_ns;
        self.next_ns += FRAME_NS;
        let since = self.changes.partition_point(|(from, _)| *from <= t_ns);
        let (_, state) = self.changes[since - 1];
        let volts = self.noise.read(&self.states[state]);
        Ok(Reading::Frame(Frame { t_ns, volts }))
    }
}

/// A finger as a key: the same finger has the same bits.
fn bits(finger: &Finger) -> [u64; 4] {
    [
        finger.centre_mm[0],
        finger.centre_mm[1],
        finger.radius_mm,
        finger.rise,
    ]
    .map(f64::to_bits)
}

fn apply(fingers: &mut Vec<Finger>, step: &Step) {
    match step.kind {
        StepKind::Down(finger) => fingers.push(finger),
        StepKind::Move {
            id,
            centre_mm,
            radius_mm,
            rise,
        } => {
            for finger in fingers.iter_mut().filter(|finger| finger.id == id) {
                finger.centre_mm = centre_mm;
                finger.radius_mm = radius_mm.unwrap_or(finger.radius_mm);
                finger.rise = rise.unwrap_or(finger.rise);
            }
        }
        StepKind::Up { id } => fingers.retain(|finger| finger.id != id),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::{DEFAULT_PAD, shipped_pad};

    fn pad() -> Pad {
        Pad::from_toml("p", shipped_pad(DEFAULT_PAD).expect("shipped").toml).expect("sound")
    }

    #[test]
    fn a_finger_lowers_the_voltages_near_it() {
        let pad = SimulatedPad::new(&pad()).expect("solvable");
        let rest = pad.volts(&[]).expect("solved");
        let finger = Finger {
            id: 1,
            centre_mm: [50.0, 20.0],
            radius_mm: 7.0,
            rise: 1.2,
        };
        let touched = pad.volts(&[finger]).expect("solved");
        let change = |i: usize| (touched[i] - rest[i]) / rest[i];
        let mean = (0..208).map(change).sum::<f64>() / 208.0;
        assert!(mean < -1e-3, "the pad conducts better: {mean}");
    }

    #[test]
    fn the_same_seed_gives_the_same_frames() {
        let script = Script::parse("s", "t:20 down 1 80 30\nt:50 up 1\nt:60 end").expect("sound");
        let play = |seed| {
            let mut source =
                SimulatedSource::new(&pad(), &script, Noise::new(60.0, seed)).expect("solvable");
            let mut frames = Vec::new();
            while let Reading::Frame(frame) = source.read().expect("a frame") {
                frames.push(frame);
            }
            frames
        };
        let frames = play(3);
        assert_eq!(frames.len(), 7);
        assert_eq!(frames, play(3));
        assert_ne!(frames, play(4));
    }
}
