//! Faults between board and host, from a seed.

use std::time::Duration;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// A fault that is repeated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RepeatedFault {
    /// From the end of one occurrence to the start of the next.
    pub period: Duration,
    /// How long it lasts.
    pub length: Duration,
}

impl std::str::FromStr for RepeatedFault {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |word: &str| {
            word.parse::<f64>()
                .ok()
                .filter(|n| *n > 0.0 && *n <= 86_400_000.0)
        };
        let parts = text.split_once(',').map(|(s, ms)| (number(s), number(ms)));
        match parts {
            Some((Some(every_s), Some(lasts_ms))) => Ok(Self {
                period: Duration::from_secs_f64(every_s),
                length: Duration::from_secs_f64(lasts_ms / 1e3),
            }),
            _ => {
                Err("write period and length as seconds,milliseconds, for example 5,200".to_owned())
            }
        }
    }
}

/// Kinds and rates of faults.
#[derive(Clone, Copy, Debug, Default)]
pub struct CableFaults {
    /// Share of bytes that are lost, 0..1.
    pub lost_bytes: f64,
    /// Share of bits that are flipped, 0..1.
    pub flipped_bits: f64,
    /// Share of frames that are cut in half, 0..1.
    pub half_frames: f64,
    /// The board stops sending for a while.
    pub pause: Option<RepeatedFault>,
    /// The port disappears for a while.
    pub hang_up: Option<RepeatedFault>,
}

/// The cable: loses bytes and flips bits.
#[derive(Clone, Debug)]
pub struct FaultyCable {
    faults: CableFaults,
    random: ChaCha8Rng,
    lost_bytes: u64,
    flipped_bits: u64,
}

impl FaultyCable {
    /// A cable with faults. The same seed gives the same faults.
    #[must_use]
    pub fn new(faults: CableFaults, seed: u64) -> Self {
        Self {
            faults,
            random: ChaCha8Rng::seed_from_u64(seed),
            lost_bytes: 0,
            flipped_bits: 0,
        }
    }

    /// The bytes that arrive when these are sent as one frame.
    pub fn carry(&mut self, bytes: Vec<u8>) -> Vec<u8> {
        let CableFaults {
            lost_bytes,
            flipped_bits,
            half_frames,
            ..
        } = self.faults;
        let mut bytes = bytes;
        if half_frames > 0.0 && self.chance(half_frames) {
            bytes.truncate(bytes.len() / 2);
        }
        if lost_bytes > 0.0 {
            let before = bytes.len();
            bytes.retain(|_| !self.chance(lost_bytes));
            self.lost_bytes += (before - bytes.len()) as u64;
        }
        if flipped_bits > 0.0 {
            for byte in &mut bytes {
                for bit in 0..8 {
                    if self.chance(flipped_bits) {
                        *byte ^= 1 << bit;
                        self.flipped_bits += 1;
                    }
                }
            }
        }
        bytes
    }

    /// Number of bytes lost and bits flipped so far.
    #[must_use]
    pub fn damage(&self) -> (u64, u64) {
        (self.lost_bytes, self.flipped_bits)
    }

    fn chance(&mut self, share: f64) -> bool {
        f64::from(self.random.next_u32()) < share * f64::from(u32::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_occur_at_their_rates() {
        let faults = CableFaults {
            lost_bytes: 0.01,
            flipped_bits: 0.001,
            ..CableFaults::default()
        };
        let mut cable = FaultyCable::new(faults, 3);
        let arrived = cable.carry(vec![0; 1_000_000]);
        let (lost, turned) = cable.damage();
        assert_eq!(arrived.len() as u64, 1_000_000 - lost);
        assert!((9_500..10_500).contains(&lost), "{lost}");
        assert!((7_500..8_400).contains(&turned), "{turned}");
        let set: u32 = arrived.iter().map(|byte| byte.count_ones()).sum();
        assert_eq!(u64::from(set), turned);
        assert_eq!(
            FaultyCable::new(CableFaults::default(), 3).carry(vec![7; 100]),
            [7; 100]
        );
    }

    #[test]
    fn a_repeated_fault_is_written_as_seconds_and_milliseconds() {
        let every: RepeatedFault = "2.5,200".parse().expect("sound");
        assert_eq!(
            (every.period, every.length),
            (Duration::from_millis(2500), Duration::from_millis(200))
        );
        assert!("5".parse::<RepeatedFault>().is_err());
        assert!("5,-1".parse::<RepeatedFault>().is_err());
    }
}
