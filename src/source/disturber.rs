//! What the disturbances of boards, cables and mains do to readings, frame by frame.
//!
//! They act in the order in which they are named, but the end of the converter's range (`saturated`) and its steps (`adc`) always last. The
//! same seed gives the same disturbance.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rand_distr::{Distribution, StandardNormal};

use super::disturbance::Disturbance;
use crate::pad::{Channel, Protocol, Renumbered};

/// Full scale of the converter, as a multiple of the largest reading of the untouched pad.
const ADC_HEADROOM: f64 = 1.25;
/// Share of frames that a spike hits.
const SPIKE_SHARE: f64 = 0.01;
/// Frequency of the mains, Hz: not a multiple of common frame rates' fractions, as real mains drift.
const MAINS_HZ: f64 = 50.07;
/// Octaves of the flicker noise: components with time constants of 1, 4, 16, ... frames.
const FLICKER_OCTAVES: usize = 6;
/// What an unplugged board reads, as a share of full scale.
const OPEN_NOISE: f64 = 1e-4;
/// When a gain step, a bad frame or a repeated stretch happens, seconds after the first frame.
const EVENT_S: f64 = 3.0;

/// Applies disturbances to frames, one after the other.
#[derive(Clone, Debug)]
pub struct Disturber {
    disturbances: Vec<Disturbance>,
    /// Size of the converter's full scale, V.
    full_scale: f64,
    /// Drive of each channel.
    drives: Vec<u16>,
    /// The board's numbering after it was plugged in again.
    replugged: Option<Renumbered>,
    /// Of each channel, whether it uses one of the electrodes that `lost-pair` hits.
    is_lost: Vec<bool>,
    /// The channel that `noisy-channel` and `dead-channel` hit.
    victim: usize,
    /// Flicker noise: components by channel.
    flicker: Vec<[f64; FLICKER_OCTAVES]>,
    phase: f64,
    random: ChaCha8Rng,
    frames: usize,
    repeated: Vec<f64>,
}

impl Disturber {
    /// Disturbances of a pad with a protocol that reads `rest` volts untouched.
    #[must_use]
    pub fn new(disturbances: &[Disturbance], rest: &[f64], protocol: &Protocol, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let largest = rest.iter().fold(0.0_f64, |most, volt| most.max(volt.abs()));
        let victim = (random.next_u64() % rest.len().max(1) as u64) as usize;
        let phase = uniform(&mut random) * TAU;
        let first = victim % protocol.electrodes;
        let lost = [first, (first + 1) % protocol.electrodes];
        let is_lost = |channel: &Channel| {
            [channel.drive, channel.measure]
                .iter()
                .any(|pair| lost.contains(&pair.0) || lost.contains(&pair.1))
        };
        // The converter comes last on a board, wherever it is named.
        let mut disturbances = disturbances.to_vec();
        disturbances.sort_by_key(|disturbance| match disturbance {
            Disturbance::Saturated(_) => 1,
            Disturbance::Adc(_) => 2,
            _ => 0,
        });
        Self {
            full_scale: ADC_HEADROOM * largest,
            drives: protocol.drives(),
            replugged: disturbances
                .iter()
                .find_map(|disturbance| disturbance.numbering(protocol.electrodes))
                .and_then(|numbering| Renumbered::new(protocol, numbering)),
            is_lost: protocol.channels.iter().map(is_lost).collect(),
            disturbances,
            victim,
            flicker: vec![[0.0; FLICKER_OCTAVES]; rest.len()],
            phase,
            random,
            frames: 0,
            repeated: Vec::new(),
        }
    }

    /// Changes the readings of the next frame, taken `t_s` seconds after the first.
    pub fn apply(&mut self, t_s: f64, volts: &mut [f64]) {
        let disturbances = std::mem::take(&mut self.disturbances);
        for disturbance in &disturbances {
            self.apply_one(*disturbance, t_s, volts);
        }
        self.disturbances = disturbances;
        self.frames += 1;
    }

    fn apply_one(&mut self, disturbance: Disturbance, t_s: f64, volts: &mut [f64]) {
        match disturbance {
            Disturbance::Adc(bits) => self.quantise(bits, volts),
            Disturbance::Saturated(share) => {
                let most = (share * self.full_scale / ADC_HEADROOM).abs();
                volts
                    .iter_mut()
                    .for_each(|volt| *volt = volt.clamp(-most, most));
            }
            Disturbance::Gain(db) => scale(volts, 1.0 + deviation(db) * self.normal()),
            Disturbance::Drive(db) => self.disturb_drives(db, volts),
            Disturbance::Flicker(db) => self.add_flicker(db, volts),
            Disturbance::NoisyChannel(share) => {
                let factor = 1.0 + share * self.normal();
                volts[self.victim] *= factor;
            }
            Disturbance::DeadChannel => volts[self.victim] = 0.0,
            Disturbance::Mains(share) => {
                scale(
                    volts,
                    1.0 + share * libm::sin(TAU * MAINS_HZ * t_s + self.phase),
                );
            }
            Disturbance::Spikes(sigma) => {
                if self.is_hit() {
                    for volt in volts {
                        *volt *= 1.0 + sigma * self.normal();
                    }
                }
            }
            Disturbance::Surge(share) => {
                if self.is_hit() {
                    scale(volts, 1.0 + share);
                }
            }
            Disturbance::BadStart(factor) if self.frames == 1 => scale(volts, factor),
            Disturbance::GarbageStart if self.frames == 1 => {
                for volt in volts {
                    *volt = self.full_scale * self.normal();
                }
            }
            Disturbance::BadFrame(factor) if self.is_event(t_s) => {
                self.repeated = vec![0.0];
                scale(volts, factor);
            }
            Disturbance::RepeatedStart(frames) => {
                if self.frames == 0 {
                    self.repeated = volts.to_vec();
                } else if self.frames < frames {
                    volts.copy_from_slice(&self.repeated);
                }
            }
            Disturbance::GainStep(share) if t_s >= EVENT_S => scale(volts, 1.0 + share),
            Disturbance::LostPair if t_s >= EVENT_S => self.lose_pair(volts),
            Disturbance::StuckFrame if t_s >= EVENT_S => {
                if self.repeated.is_empty() {
                    self.repeated = volts.to_vec();
                }
                volts.copy_from_slice(&self.repeated);
            }
            Disturbance::Unplugged(seconds) if (EVENT_S..EVENT_S + seconds).contains(&t_s) => {
                for volt in volts {
                    *volt = OPEN_NOISE * self.full_scale * self.normal();
                }
            }
            Disturbance::Turned(_) | Disturbance::Mirrored(_) if t_s >= EVENT_S => {
                if let Some(order) = &self.replugged {
                    volts.copy_from_slice(&order.apply(volts));
                }
            }
            Disturbance::BadStart(_)
            | Disturbance::GarbageStart
            | Disturbance::BadFrame(_)
            | Disturbance::GainStep(_)
            | Disturbance::LostPair
            | Disturbance::StuckFrame
            | Disturbance::Unplugged(_)
            | Disturbance::Turned(_)
            | Disturbance::Mirrored(_) => {}
        }
    }

    /// Whether the single event of a run happens in this frame.
    fn is_event(&self, t_s: f64) -> bool {
        t_s >= EVENT_S && self.repeated.is_empty()
    }

    fn is_hit(&mut self) -> bool {
        uniform(&mut self.random) < SPIKE_SHARE
    }

    fn quantise(&self, bits: u32, volts: &mut [f64]) {
        let step = 2.0 * self.full_scale / libm::exp2(f64::from(bits));
        for volt in volts {
            *volt = libm::rint(volt.clamp(-self.full_scale, self.full_scale) / step) * step;
        }
    }

    /// Inputs without contact float: they read anything.
    fn lose_pair(&mut self, volts: &mut [f64]) {
        for (channel, volt) in volts.iter_mut().enumerate() {
            if self.is_lost[channel] {
                *volt = self.full_scale * self.normal();
            }
        }
    }

    fn disturb_drives(&mut self, db: f64, volts: &mut [f64]) {
        let count = self
            .drives
            .iter()
            .max()
            .map_or(0, |last| usize::from(*last) + 1);
        let factors: Vec<f64> = (0..count)
            .map(|_| 1.0 + deviation(db) * self.normal())
            .collect();
        for (volt, drive) in volts.iter_mut().zip(&self.drives) {
            *volt *= factors[usize::from(*drive)];
        }
    }

    /// A sum of first-order processes with time constants of 1, 4, 16, ... frames: 1/f over six octaves of four.
    fn add_flicker(&mut self, db: f64, volts: &mut [f64]) {
        let size = deviation(db) / libm::sqrt(FLICKER_OCTAVES as f64);
        for (channel, volt) in volts.iter_mut().enumerate() {
            let mut sum = 0.0;
            for octave in 0..FLICKER_OCTAVES {
                let keep = libm::exp(-1.0 / libm::pow(4.0, octave as f64));
                let kick: f64 = StandardNormal.sample(&mut self.random);
                let component = &mut self.flicker[channel][octave];
                *component = keep * *component + libm::sqrt(1.0 - keep * keep) * kick;
                sum += *component;
            }
            *volt *= 1.0 + size * sum;
        }
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.random)
    }
}

fn scale(volts: &mut [f64], factor: f64) {
    for volt in volts {
        *volt *= factor;
    }
}

/// Relative deviation of noise of an SNR.
fn deviation(snr_db: f64) -> f64 {
    libm::pow(10.0, -snr_db / 20.0)
}

fn uniform(random: &mut ChaCha8Rng) -> f64 {
    (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::{DEFAULT_PAD, Pad, shipped_pad};

    fn protocol() -> Protocol {
        let shipped = shipped_pad(DEFAULT_PAD).expect("shipped");
        let pad = Pad::from_toml(shipped.name, shipped.toml).expect("valid");
        pad.protocol
    }

    #[test]
    fn the_converter_rounds_what_the_gain_has_changed_wherever_it_is_named() {
        let rest = [1.0, 0.01, -0.3];
        let read = |list: &str| {
            let disturbances: Vec<Disturbance> = list
                .split(',')
                .map(|name| name.parse().expect("known"))
                .collect();
            let mut volts = rest.to_vec();
            Disturber::new(&disturbances, &rest, &protocol(), 1).apply(0.0, &mut volts);
            volts
        };
        assert_eq!(read("adc:10,gain:20"), read("gain:20,adc:10"));
    }

    #[test]
    fn readings_of_a_converter_are_multiples_of_its_step() {
        let rest = [1.0, 0.01, -0.3];
        let mut disturber = Disturber::new(&[Disturbance::Adc(10)], &rest, &protocol(), 1);
        let mut volts = rest.to_vec();
        disturber.apply(0.0, &mut volts);
        let step = 2.5 / 1024.0;
        for (volt, exact) in volts.iter().zip(rest) {
            assert!(
                ((volt / step).rem_euclid(1.0)).min(1.0 - (volt / step).rem_euclid(1.0)) < 1e-9
            );
            assert!((volt - exact).abs() <= step / 2.0 + 1e-12);
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_frames() {
        let rest = vec![1.0; protocol().channels.len()];
        let all: Vec<Disturbance> = "gain:40,drive:40,flicker:40,spikes:1,surge:0.3,lost-pair"
            .split(',')
            .map(|name| name.parse().expect("known"))
            .collect();
        let run = |seed| {
            let mut disturber = Disturber::new(&all, &rest, &protocol(), seed);
            let mut volts = rest.clone();
            for frame in 0..200 {
                volts.clone_from(&rest);
                disturber.apply(f64::from(frame) * 0.02, &mut volts);
            }
            volts
        };
        assert_eq!(run(3), run(3));
        assert_ne!(run(3), run(4));
    }
}
