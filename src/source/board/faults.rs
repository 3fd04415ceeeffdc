//! What goes wrong on the way from a board to the host, from a seed.

use std::time::Duration;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Something that happens again and again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Every {
    /// From one time to the next.
    pub every: Duration,
    /// How long it lasts.
    pub lasts: Duration,
}

impl std::str::FromStr for Every {
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
                every: Duration::from_secs_f64(every_s),
                lasts: Duration::from_secs_f64(lasts_ms / 1e3),
            }),
            _ => Err("write how often and how long: seconds,milliseconds, as in 5,200".to_owned()),
        }
    }
}

/// What goes wrong, and how often.
#[derive(Clone, Copy, Debug, Default)]
pub struct Faults {
    /// Share of bytes that are lost, 0..1.
    pub lost_bytes: f64,
    /// Share of bits that are turned, 0..1.
    pub turned_bits: f64,
    /// Share of frames of which only the first half comes, 0..1.
    pub half_frames: f64,
    /// The board stops sending.
    pub pause: Option<Every>,
    /// The port goes away.
    pub hang_up: Option<Every>,
}

/// The cable: loses bytes and turns bits.
#[derive(Clone, Debug)]
pub struct Cable {
    faults: Faults,
    random: ChaCha8Rng,
    lost_bytes: u64,
    turned_bits: u64,
}

impl Cable {
    /// A cable with faults. The same seed gives the same ones.
    #[must_use]
    pub fn new(faults: Faults, seed: u64) -> Self {
        Self {
            faults,
            random: ChaCha8Rng::seed_from_u64(seed),
            lost_bytes: 0,
            turned_bits: 0,
        }
    }

    /// What arrives of bytes that are sent as one frame.
    pub fn carry(&mut self, bytes: Vec<u8>) -> Vec<u8> {
        let Faults {
            lost_bytes,
            turned_bits,
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
        if turned_bits > 0.0 {
            for byte in &mut bytes {
                for bit in 0..8 {
                    if self.chance(turned_bits) {
                        *byte ^= 1 << bit;
                        self.turned_bits += 1;
                    }
                }
            }
        }
        bytes
    }

    /// Bytes that were lost and bits that were turned so far.
    #[must_use]
    pub fn damage(&self) -> (u64, u64) {
        (self.lost_bytes, self.turned_bits)
    }

    fn chance(&mut self, share: f64) -> bool {
        f64::from(self.random.next_u32()) < share * f64::from(u32::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_much_goes_wrong_as_is_asked_for() {
        let faults = Faults {
            lost_bytes: 0.01,
            turned_bits: 0.001,
            ..Faults::default()
        };
        let mut cable = Cable::new(faults, 3);
        let arrived = cable.carry(vec![0; 1_000_000]);
        let (lost, turned) = cable.damage();
        assert_eq!(arrived.len() as u64, 1_000_000 - lost);
        assert!((9_500..10_500).contains(&lost), "{lost}");
        assert!((7_500..8_400).contains(&turned), "{turned}");
        let set: u32 = arrived.iter().map(|byte| byte.count_ones()).sum();
        assert_eq!(u64::from(set), turned);
        assert_eq!(
            Cable::new(Faults::default(), 3).carry(vec![7; 100]),
            [7; 100]
        );
    }

    #[test]
    fn what_happens_again_is_written_as_seconds_and_milliseconds() {
        let every: Every = "2.5,200".parse().expect("sound");
        assert_eq!(
            (every.every, every.lasts),
            (Duration::from_millis(2500), Duration::from_millis(200))
        );
        assert!("5".parse::<Every>().is_err());
        assert!("5,-1".parse::<Every>().is_err());
    }
}
