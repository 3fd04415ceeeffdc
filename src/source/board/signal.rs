//! The voltages that a board measures: the simulated pad under a script that restarts when it ends, with
//! noise, drift and an electrode that comes loose.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use crate::pad::Pad;
use crate::source::{Noise, Script, SimulatedSource, SourceError};
use crate::types::Nanos;

const MINUTE_NS: f64 = 60e9;

/// An electrode that comes loose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LostElectrode {
    /// The electrode, from 0.
    pub electrode: usize,
    /// When it comes loose.
    pub from_ns: Nanos,
}

/// The pad's voltages over time.
pub struct BoardSignal {
    pad: SimulatedSource,
    /// First channel of each drive, and the end of the last.
    drives: Vec<usize>,
    noise: Noise,
    drift_per_min: f64,
    lost: Option<LostElectrode>,
    /// Channels of the loose electrode.
    loose: Vec<usize>,
    random: ChaCha8Rng,
}

impl BoardSignal {
    /// A pad under a script, with noise. `drift_per_min` is the relative rise of all voltages per minute.
    ///
    /// # Errors
    /// A finger is off the pad, or the pad cannot be solved.
    pub fn new(
        pad: &Pad,
        script: &Script,
        (snr_db, seed): (f64, u64),
        drift_per_min: f64,
        lost: Option<LostElectrode>,
    ) -> Result<Self, SourceError> {
        let is_in =
            |electrode: usize, pair: crate::pad::Pair| pair.0 == electrode || pair.1 == electrode;
        let loose = match lost {
            Some(LostElectrode { electrode, .. }) => (0..pad.channels())
                .filter(|index| {
                    let channel = pad.protocol.channels[*index];
                    is_in(electrode, channel.drive) || is_in(electrode, channel.measure)
                })
                .collect(),
            None => Vec::new(),
        };
        Ok(Self {
            pad: SimulatedSource::new(pad, script, Noise::new(snr_db, seed))?,
            drives: pad.protocol.drive_bounds(),
            noise: Noise::new(snr_db, seed),
            drift_per_min,
            lost,
            loose,
            random: ChaCha8Rng::seed_from_u64(seed ^ 0x5eed),
        })
    }

    /// One noisy reading of the whole pad at a moment.
    pub fn read(&mut self, t_ns: Nanos) -> Vec<f32> {
        let script_ns = t_ns % (self.pad.end_ns() + 1);
        let volts = self.noise.read(self.pad.volts_at(script_ns));
        self.disturb(volts, t_ns)
    }

    /// One noisy reading of the pad, drive after drive from one time to another: the last drive is read at the end.
    pub fn read_in_turn(&mut self, from_ns: Nanos, to_ns: Nanos) -> Vec<f32> {
        let count = self.drives.len() as Nanos - 1;
        let span_ns = to_ns.saturating_sub(from_ns);
        let mut volts = Vec::new();
        for (drive, span) in (1..).zip(self.drives.windows(2)) {
            let t_ns = from_ns + span_ns * drive / count;
            let script_ns = t_ns % (self.pad.end_ns() + 1);
            volts.extend_from_slice(&self.pad.volts_at(script_ns)[span[0]..span[1]]);
        }
        let volts = self.noise.read(&volts);
        self.disturb(volts, to_ns)
    }

    fn disturb(&mut self, mut volts: Vec<f32>, t_ns: Nanos) -> Vec<f32> {
        let gain = 1.0 + self.drift_per_min * t_ns as f64 / MINUTE_NS;
        for volt in &mut volts {
            *volt *= gain as f32;
        }
        if self.lost.is_some_and(|lost| t_ns >= lost.from_ns) {
            for channel in &self.loose {
                // An open input picks up noise that does not depend on the pad.
                let n: f64 = StandardNormal.sample(&mut self.random);
                volts[*channel] *= 3.0 * n as f32;
            }
        }
        volts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::{DEFAULT_PAD, shipped_pad};

    #[test]
    fn the_script_restarts_and_a_lost_electrode_changes_only_its_channels() {
        let pad =
            Pad::from_toml("p", shipped_pad(DEFAULT_PAD).expect("shipped").toml).expect("sound");
        let script =
            Script::parse("s", "t:100 down 1 50 30\nt:200 up 1\nt:300 end").expect("sound");
        let lost = LostElectrode {
            electrode: 3,
            from_ns: 900_000_000,
        };
        let mut signal =
            BoardSignal::new(&pad, &script, (300.0, 1), 0.0, Some(lost)).expect("solvable");
        let ms = |t: u64| t * 1_000_000;
        let [rest, pressed] = [signal.read(0), signal.read(ms(150))];
        assert_ne!(rest, pressed);
        assert_eq!(signal.read(ms(451)), pressed, "the second time round");
        let damaged = signal.read(ms(903));
        let changed: Vec<usize> = (0..208).filter(|i| damaged[*i] != rest[*i]).collect();
        // Two drives with 13 measurements each, and two measurements of each other drive, less those in common.
        assert!(changed.iter().all(|index| {
            let channel = pad.protocol.channels[*index];
            [channel.drive, channel.measure]
                .iter()
                .any(|pair| pair.0 == 3 || pair.1 == 3)
        }));
        assert!(changed.len() > 40, "{}", changed.len());
    }
}
