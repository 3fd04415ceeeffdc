//! What a board's converter sees: the simulated pad under a script that begins again when it ends, with noise, drift and an
//! electrode that comes loose.

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
    /// Which, from 0.
    pub electrode: usize,
    /// From when on.
    pub from_ns: Nanos,
}

/// The pad's voltages over time.
pub struct Signal {
    pad: SimulatedSource,
    noise: Noise,
    drift_per_min: f64,
    lost: Option<LostElectrode>,
    /// Channels that the lost electrode is in.
    loose: Vec<usize>,
    random: ChaCha8Rng,
}

impl Signal {
    /// A pad under a script, with noise. `drift_per_min` is the relative rise of all voltages in a minute.
    ///
    /// # Errors
    /// A finger off the pad; a pad that cannot be solved.
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
            noise: Noise::new(snr_db, seed),
            drift_per_min,
            lost,
            loose,
            random: ChaCha8Rng::seed_from_u64(seed ^ 0x5eed),
        })
    }

    /// One noisy reading of the pad at a time.
    pub fn read(&mut self, t_ns: Nanos) -> Vec<f32> {
        let gain = 1.0 + self.drift_per_min * t_ns as f64 / MINUTE_NS;
        let mut volts = self
            .noise
            .read(self.pad.volts_at(t_ns % (self.pad.end_ns() + 1)));
        for volt in &mut volts {
            *volt *= gain as f32;
        }
        if self.lost.is_some_and(|lost| t_ns >= lost.from_ns) {
            for channel in &self.loose {
                // What an open input picks up has nothing to do with the pad.
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
    fn the_script_begins_again_and_a_lost_electrode_spoils_its_channels_only() {
        let pad =
            Pad::from_toml("p", shipped_pad(DEFAULT_PAD).expect("shipped").toml).expect("sound");
        let script =
            Script::parse("s", "t:100 down 1 50 30\nt:200 up 1\nt:300 end").expect("sound");
        let lost = LostElectrode {
            electrode: 3,
            from_ns: 900_000_000,
        };
        let mut signal = Signal::new(&pad, &script, (300.0, 1), 0.0, Some(lost)).expect("solvable");
        let ms = |t: u64| t * 1_000_000;
        let [rest, pressed] = [signal.read(0), signal.read(ms(150))];
        assert_ne!(rest, pressed);
        assert_eq!(signal.read(ms(451)), pressed, "the second time round");
        let spoilt = signal.read(ms(903));
        let changed: Vec<usize> = (0..208).filter(|i| spoilt[*i] != rest[*i]).collect();
        // Two drives of 13 and two measurements of each of the others, less what they share.
        assert!(changed.iter().all(|index| {
            let channel = pad.protocol.channels[*index];
            [channel.drive, channel.measure]
                .iter()
                .any(|pair| pair.0 == 3 || pair.1 == 3)
        }));
        assert!(changed.len() > 40, "{}", changed.len());
    }
}
