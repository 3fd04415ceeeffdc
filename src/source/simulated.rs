//! The simulated pad: fingers of a script, voltages from the forward model, noise from a seed.
//!
//! It is part of the library because tests, demonstrations and users without a pad share it. Its mesh differs
//! from that of the reconstruction, so that no image is made with the same model as its voltages.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use super::{
    Finger, FingerAction, Noise, Script, ScriptStep, Source, SourceError, SourcePace, SourceReading,
};
use crate::eit::{
    ContactModel, ForwardError, ForwardModel, Mesh, MeshSize, Press, TYPICAL_PRESS_MM2,
};
use crate::pad::{LearnedMaps, Pad, TouchSign};
use crate::types::{Frame, NANOS_PER_MS, Nanos, Part};

/// Time between two frames of every simulated source, ns: 100 frames/s.
pub const SIMULATED_FRAME_NS: Nanos = 10 * NANOS_PER_MS;
/// Radius of a finger, mm, and relative rise of conductivity at its centre, unless a script says otherwise.
pub(super) const FINGER_RADIUS_MM: f64 = 7.0;
pub(super) const FINGER_RISE: f64 = 1.2;

/// A pad that can be pressed and measured.
#[derive(Clone, Debug)]
pub struct SimulatedPad {
    pad: Pad,
    model: ForwardModel,
    /// The voltages of the untouched drawing of a pad that was learned from presses: they are solved once.
    untouched: OnceLock<Vec<f64>>,
}

impl SimulatedPad {
    /// Meshes a pad for simulation.
    ///
    /// # Errors
    /// The conductor or the electrodes of the pad cannot be solved.
    pub fn new(pad: &Pad) -> Result<Self, ForwardError> {
        let mesh = Mesh::from_pad(pad, MeshSize::simulation(pad));
        Ok(Self {
            model: ForwardModel::new(mesh, &ContactModel::from_pad(pad))?,
            pad: pad.clone(),
            untouched: OnceLock::new(),
        })
    }

    /// The voltages under some presses, V/A. On a pad that was learned from presses, those of its drawing change as its maps say.
    ///
    /// # Errors
    /// The forward model cannot be solved for this conductivity.
    pub fn volts(&self, presses: &[Press]) -> Result<Vec<f64>, ForwardError> {
        if let Some(maps) = &self.pad.learned {
            return self.volts_by_maps(maps, presses);
        }
        let mut conductivity = self.model.mesh().mean_over_triangles(|point| {
            let factor: f64 = presses.iter().map(|press| press.factor(point)).product();
            match self.pad.touch_sign {
                TouchSign::Rise => self.pad.background_s_per_m * factor,
                TouchSign::Fall => self.pad.background_s_per_m / factor,
            }
        });
        let mesh = self.model.mesh();
        for (triangle, siemens) in conductivity.iter_mut().enumerate() {
            *siemens *= self.pad.deviations.factor_at(mesh.centroid_mm(triangle));
        }
        let fields = self.model.solve(&conductivity)?;
        Ok(fields.voltages(&self.pad.protocol))
    }

    fn volts_by_maps(
        &self,
        maps: &LearnedMaps,
        presses: &[Press],
    ) -> Result<Vec<f64>, ForwardError> {
        let untouched = match self.untouched.get() {
            Some(untouched) => untouched,
            None => {
                let background = self.model.mesh().background_s_per_m(&self.pad);
                let fields = self.model.solve(&background)?;
                let untouched = fields.voltages(&self.pad.protocol);
                self.untouched.get_or_init(|| untouched)
            }
        };
        let mut factors = vec![1.0; untouched.len()];
        for press in presses {
            let share = press.volume_mm2() / TYPICAL_PRESS_MM2;
            let changes = maps.changes_at(press.centre_mm, self.pad.outline.size_mm());
            for (factor, change) in factors.iter_mut().zip(changes) {
                *factor += share * change;
            }
        }
        let pairs = untouched.iter().zip(factors);
        Ok(pairs.map(|(volt, factor)| volt * factor).collect())
    }
}

/// The simulated pad as a source: plays a script at 100 frames/s, each frame read at one moment, or drive by drive.
pub struct SimulatedSource {
    in_turn: Option<InTurn>,
    states: Vec<Vec<f64>>,
    /// When each state begins, by its index.
    changes: Vec<(Nanos, usize)>,
    end_ns: Nanos,
    next_ns: Nanos,
    noise: Noise,
}

impl SimulatedSource {
    /// Solves the pad for every state of a script in advance, so that playing costs no solution.
    ///
    /// # Errors
    /// A finger is off the pad, or the pad cannot be solved.
    pub fn new(pad: &Pad, script: &Script, noise: Noise) -> Result<Self, SourceError> {
        for step in script.steps() {
            let (id, [x, y]) = match step.kind {
                FingerAction::Down(finger) => (finger.id, finger.press.centre_mm),
                FingerAction::Move { id, centre_mm, .. } => (id, centre_mm),
                FingerAction::Up { .. } => continue,
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
            let presses: Vec<Press> = fingers.iter().map(|finger| finger.press).collect();
            let key = presses.iter().map(bits).collect();
            let state = match known.get(&key) {
                Some(state) => *state,
                None => {
                    states.push(simulated.volts(&presses)?);
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
            in_turn: None,
            states,
            changes,
            end_ns: script.end_ns(),
            next_ns: 0,
            noise,
        })
    }
}

/// Drives that are read one after another.
struct InTurn {
    /// First channel of each drive, and the end of the last.
    bounds: Vec<usize>,
    period_ns: Nanos,
    /// Parts read so far.
    parts: u64,
}

impl InTurn {
    /// The next part's time and channels.
    fn next(&mut self) -> (Nanos, std::ops::Range<usize>) {
        let drives = self.bounds.len() as u64 - 1;
        let drive = (self.parts % drives) as usize;
        self.parts += 1;
        let t_ns = self.parts * self.period_ns / drives;
        (t_ns, self.bounds[drive]..self.bounds[drive + 1])
    }
}

impl SimulatedSource {
    /// Reads the drives of the pad one after another, `frames_per_s` frames a second, as slow boards do.
    #[must_use]
    pub fn in_turn(mut self, pad: &Pad, frames_per_s: u32) -> Self {
        self.in_turn = Some(InTurn {
            bounds: pad.protocol.drive_bounds(),
            period_ns: 1000 * NANOS_PER_MS / Nanos::from(frames_per_s.max(1)),
            parts: 0,
        });
        self
    }

    /// The voltages at a time, V/A, without noise.
    pub(super) fn volts_at(&self, t_ns: Nanos) -> &[f64] {
        let since = self.changes.partition_point(|(from, _)| *from <= t_ns);
        let (_, state) = self.changes[since - 1];
        &self.states[state]
    }

    /// End of the script.
    pub(super) fn end_ns(&self) -> Nanos {
        self.end_ns
    }
}

impl Source for SimulatedSource {
    fn pace(&self) -> SourcePace {
        SourcePace::ByStamp
    }

    fn read(&mut self) -> Result<SourceReading, SourceError> {
        if let Some(in_turn) = &mut self.in_turn {
            let (t_ns, span) = in_turn.next();
            if t_ns > self.end_ns {
                return Ok(SourceReading::End);
            }
            let since = self.changes.partition_point(|(from, _)| *from <= t_ns);
            let (_, state) = self.changes[since - 1];
            let volts = self.noise.read(&self.states[state][span.clone()]);
            let first = span.start;
            return Ok(SourceReading::Part(Part { t_ns, first, volts }));
        }
        if self.next_ns > self.end_ns {
            return Ok(SourceReading::End);
        }
        let t_ns = self.next_ns;
        self.next_ns += SIMULATED_FRAME_NS;
        let since = self.changes.partition_point(|(from, _)| *from <= t_ns);
        let (_, state) = self.changes[since - 1];
        let volts = self.noise.read(&self.states[state]);
        Ok(SourceReading::Frame(Frame { t_ns, volts }))
    }
}

/// The key of a press in the map of solved states.
fn bits(press: &Press) -> [u64; 4] {
    let [x, y] = press.centre_mm;
    [x, y, press.radius_mm, press.rise].map(f64::to_bits)
}

fn apply(fingers: &mut Vec<Finger>, step: &ScriptStep) {
    match step.kind {
        FingerAction::Down(finger) => fingers.push(finger),
        FingerAction::Move {
            id,
            centre_mm,
            radius_mm,
            rise,
        } => {
            for Finger { press, .. } in fingers.iter_mut().filter(|finger| finger.id == id) {
                press.centre_mm = centre_mm;
                press.radius_mm = radius_mm.unwrap_or(press.radius_mm);
                press.rise = rise.unwrap_or(press.rise);
            }
        }
        FingerAction::Up { id } => fingers.retain(|finger| finger.id != id),
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
        let press = Press {
            centre_mm: [50.0, 20.0],
            radius_mm: FINGER_RADIUS_MM,
            rise: FINGER_RISE,
        };
        let touched = pad.volts(&[press]).expect("solved");
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
            while let SourceReading::Frame(frame) = source.read().expect("a frame") {
                frames.push(frame);
            }
            frames
        };
        let frames = play(3);
        assert_eq!(frames.len(), 7);
        assert_eq!(frames, play(3));
        assert_ne!(frames, play(4));
    }

    #[test]
    fn a_pad_that_is_read_in_turn_shows_a_press_within_a_frame() {
        let script =
            Script::parse("s", "t:150 down 1 80 30\nt:450 up 1\nt:500 end").expect("sound");
        let play = |finger: bool| {
            let script = match finger {
                true => script.clone(),
                false => Script::parse("s", "t:600 down 1 80 30\nt:700 end").expect("sound"),
            };
            let source = SimulatedSource::new(&pad(), &script, Noise::new(60.0, 3));
            let mut source = source.expect("solvable").in_turn(&pad(), 10);
            let mut parts = Vec::new();
            while let SourceReading::Part(part) = source.read().expect("a part") {
                parts.push(part);
            }
            parts
        };
        let (pressed, rest) = (play(true), play(false));
        assert_eq!(pressed.len(), 5 * 16);
        assert_eq!(
            (pressed[0].t_ns, pressed[15].t_ns),
            (6_250_000, 100_000_000)
        );
        assert!(pressed.iter().zip(&rest).all(|(a, b)| a.first == b.first));
        let changed: Vec<Nanos> = pressed
            .iter()
            .zip(&rest)
            .filter(|(a, b)| a.volts != b.volts)
            .map(|(part, _)| part.t_ns / NANOS_PER_MS)
            .collect();
        let (first, last) = (changed[0], changed[changed.len() - 1]);
        assert!((150..157).contains(&first) && last < 450, "{changed:?}");
    }
}
