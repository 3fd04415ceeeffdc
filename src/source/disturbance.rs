//! The names of what boards, cables and mains do to readings.
//!
//! One list for the simulated pad (`--disturb`), for `gelpad accuracy --real`, for tests and for the documentation: a name with an
//! optional value, as in `adc:12,gain:60`. What each does is in `disturber`.

use std::fmt;
use std::str::FromStr;

use crate::pad::{Direction, Numbering};

/// One disturbance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Disturbance {
    /// `adc:BITS`: readings are rounded to steps of the converter; full scale is 1.25 times the largest reading at rest.
    Adc(u32),
    /// `saturated:SHARE`: larger readings than this share of the largest at rest read as that.
    Saturated(f64),
    /// `gain:DB`: every reading of a frame is multiplied by the same noise.
    Gain(f64),
    /// `drive:DB`: every reading of a drive is multiplied by the same noise.
    Drive(f64),
    /// `flicker:DB`: 1/f noise on each channel.
    Flicker(f64),
    /// `noisy-channel:SHARE`: one channel has this relative noise.
    NoisyChannel(f64),
    /// `dead-channel`: one channel reads 0.
    DeadChannel,
    /// `mains:SHARE`: the source's amplitude ripples at the mains' frequency.
    Mains(f64),
    /// `spikes:SIGMA`: in 1 % of the frames every reading has this relative noise.
    Spikes(f64),
    /// `surge:SHARE`: in 1 % of the frames every reading is multiplied by 1 + SHARE.
    Surge(f64),
    /// `bad-start:FACTOR`: the second frame is multiplied by a factor.
    BadStart(f64),
    /// `garbage-start`: the second frame is random numbers.
    GarbageStart,
    /// `bad-frame:FACTOR`: one frame is multiplied by a factor, three seconds after the start.
    BadFrame(f64),
    /// `repeated-start:FRAMES`: the board repeats its first frame while it wakes.
    RepeatedStart(usize),
    /// `gain-step:SHARE`: three seconds after the start all readings are multiplied by 1 + SHARE and stay so.
    GainStep(f64),
    /// `lost-pair`: from three seconds after the start two neighbouring electrodes have no contact.
    LostPair,
    /// `stuck-frame`: from three seconds after the start the board repeats one frame.
    StuckFrame,
    /// `unplugged:SECONDS`: three seconds after the start the pad is unplugged for a while: the board reads its own noise.
    Unplugged(f64),
    /// `turned:PLACES`: from three seconds after the start the board's electrode 0 is at another place.
    Turned(usize),
    /// `mirrored:PLACES`: the same, and its numbers run clockwise.
    Mirrored(usize),
}

/// Values are never NaN: reading one refuses it.
impl Eq for Disturbance {}

/// Why a text names no disturbance.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown disturbance `{text}`: known are {}", DISTURBANCE_NAMES.join(", "))]
pub struct UnknownDisturbance {
    text: String,
}

/// Every name, as written in help and errors.
pub const DISTURBANCE_NAMES: &[&str] = &[
    "adc:BITS",
    "saturated:SHARE",
    "gain:DB",
    "drive:DB",
    "flicker:DB",
    "noisy-channel:SHARE",
    "dead-channel",
    "mains:SHARE",
    "spikes:SIGMA",
    "surge:SHARE",
    "bad-start:FACTOR",
    "garbage-start",
    "bad-frame:FACTOR",
    "repeated-start:FRAMES",
    "gain-step:SHARE",
    "lost-pair",
    "stuck-frame",
    "unplugged:SECONDS",
    "turned:PLACES",
    "mirrored:PLACES",
];

impl FromStr for Disturbance {
    type Err = UnknownDisturbance;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let wrong = || UnknownDisturbance {
            text: text.to_owned(),
        };
        let (name, value) = match text.split_once(':') {
            Some((name, value)) => (name, Some(value)),
            None => (text, None),
        };
        let number = |default: f64| match value {
            None => Ok(default),
            Some(value) => value
                .parse::<f64>()
                .ok()
                .filter(|value| value.is_finite())
                .ok_or_else(wrong),
        };
        let count = |default: u32, least: u32, most: u32| match value {
            None => Ok(default),
            Some(value) => value
                .parse::<u32>()
                .ok()
                .filter(|value| (least..=most).contains(value))
                .ok_or_else(wrong),
        };
        Ok(match name {
            "adc" => Self::Adc(count(12, 4, 24)?),
            "saturated" => Self::Saturated(number(0.8)?),
            "gain" => Self::Gain(number(60.0)?),
            "drive" => Self::Drive(number(50.0)?),
            "flicker" => Self::Flicker(number(40.0)?),
            "noisy-channel" => Self::NoisyChannel(number(0.1)?),
            "dead-channel" => Self::DeadChannel,
            "mains" => Self::Mains(number(0.003)?),
            "spikes" => Self::Spikes(number(1.0)?),
            "surge" => Self::Surge(number(0.3)?),
            "bad-start" => Self::BadStart(number(2.0)?),
            "garbage-start" => Self::GarbageStart,
            "bad-frame" => Self::BadFrame(number(1.6)?),
            "repeated-start" => Self::RepeatedStart(count(10, 1, 1000)? as usize),
            "gain-step" => Self::GainStep(number(0.2)?),
            "lost-pair" => Self::LostPair,
            "stuck-frame" => Self::StuckFrame,
            "unplugged" => Self::Unplugged(number(1.0)?),
            "turned" => Self::Turned(count(4, 0, 1000)? as usize),
            "mirrored" => Self::Mirrored(count(0, 0, 1000)? as usize),
            _ => return Err(wrong()),
        })
    }
}

impl fmt::Display for Disturbance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Adc(bits) => write!(f, "adc:{bits}"),
            Self::Saturated(share) => write!(f, "saturated:{share}"),
            Self::Gain(db) => write!(f, "gain:{db}"),
            Self::Drive(db) => write!(f, "drive:{db}"),
            Self::Flicker(db) => write!(f, "flicker:{db}"),
            Self::NoisyChannel(share) => write!(f, "noisy-channel:{share}"),
            Self::DeadChannel => write!(f, "dead-channel"),
            Self::Mains(share) => write!(f, "mains:{share}"),
            Self::Spikes(sigma) => write!(f, "spikes:{sigma}"),
            Self::Surge(share) => write!(f, "surge:{share}"),
            Self::BadStart(factor) => write!(f, "bad-start:{factor}"),
            Self::GarbageStart => write!(f, "garbage-start"),
            Self::BadFrame(factor) => write!(f, "bad-frame:{factor}"),
            Self::RepeatedStart(frames) => write!(f, "repeated-start:{frames}"),
            Self::GainStep(share) => write!(f, "gain-step:{share}"),
            Self::LostPair => write!(f, "lost-pair"),
            Self::StuckFrame => write!(f, "stuck-frame"),
            Self::Unplugged(seconds) => write!(f, "unplugged:{seconds}"),
            Self::Turned(places) => write!(f, "turned:{places}"),
            Self::Mirrored(places) => write!(f, "mirrored:{places}"),
        }
    }
}

impl Disturbance {
    /// The numbering with which the board is plugged in again, on a pad of so many electrodes.
    pub(super) fn numbering(self, electrodes: usize) -> Option<Numbering> {
        let (places, direction) = match self {
            Self::Turned(places) => (places, Direction::CounterClockwise),
            Self::Mirrored(places) => (places, Direction::Clockwise),
            _ => return None,
        };
        Some(Numbering {
            first: places % electrodes,
            direction,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_read_and_printed_alike() {
        for name in DISTURBANCE_NAMES {
            let bare = name.split(':').next().expect("a name");
            let disturbance: Disturbance = bare.parse().expect("known");
            assert_eq!(disturbance.to_string().parse(), Ok(disturbance), "{name}");
        }
        let error = "adc:3".parse::<Disturbance>().expect_err("too few bits");
        assert!(error.to_string().contains("adc:BITS"), "{error}");
        assert!("gain:loud".parse::<Disturbance>().is_err());
    }
}
