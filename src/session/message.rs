//! What a recording holds, message by message, and each as JSON.
//!
//! A topic a kind, so that any reader of MCAP files can plot what it knows. The engine's inputs stand in the order in which the
//! engine took them; events and touches follow the input that they came of.

use crc::{CRC_32_ISO_HDLC, Crc};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::lines::{Block, ControlLine, EventLine};
use super::volts::{Packer, Unpacker};
use crate::types::{Control, Event, Frame, Nanos, Phase, Touch};

/// No time of a source comes near this: thirty years.
pub(super) const LATEST_NS: Nanos = 1_000_000_000_000_000_000;
/// No count of lost things comes near this.
const MOST_LOST: u64 = 1 << 40;
static CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// One thing that a recording holds.
#[derive(Clone, Debug, PartialEq)]
pub enum Message {
    /// Input: readings of the pad, as they were received.
    Frames(Vec<Frame>),
    /// Input: a due time came.
    Tick(At),
    /// Input: a profile takes over.
    Profile(ProfileTexts),
    /// Input: the player pauses, or goes on.
    Pause(At),
    /// Input: another matrix and other weights; they are the attachment before it.
    Matrix(MatrixName),
    /// Input: the pad counts as untouched.
    Rezero(At),
    /// Input: frames were lost before the engine.
    Lost(Lost),
    /// Input: the source ended, or fell silent.
    End(At),
    /// Inputs that the recorder could not take: what follows cannot be replayed exactly.
    Gap(Gap),
    /// What came of a frame: the touches that are down. Written while there are some, and once when there are none any more.
    Touches(Touches),
    /// What came of an input: an event.
    Event(Event),
    /// Input: what gamepads and switches say.
    Control(Control),
}

/// A time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct At {
    /// In the source's own time, ns.
    pub t_ns: Nanos,
}

/// Texts that a profile was read from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProfileTexts {
    /// When it takes over, ns.
    pub t_ns: Nanos,
    /// The bases that it extends, the lowest first, and last its own.
    pub chain: Vec<NamedText>,
    /// One person's settings over it.
    pub user: Option<NamedText>,
}

/// A text and its name, which is never a path.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NamedText {
    /// The file's name.
    pub name: String,
    /// The text.
    pub toml: String,
}

/// Which attachment.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MatrixName {
    /// Its name.
    pub attachment: String,
}

/// Frames that never reached the engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lost {
    /// How many.
    pub frames: u64,
}

/// Inputs that never reached the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gap {
    /// How many.
    pub inputs: u64,
}

/// Touches of one frame, rounded for people, and a check sum of what they were to the bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Touches {
    /// The frame's time, ns.
    pub t_ns: Nanos,
    /// See [`touches_sum`].
    pub sum: u32,
    /// Those that are down.
    pub touches: Vec<TouchSeen>,
}

/// A touch, rounded for people.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TouchSeen {
    /// Its name.
    pub id: u64,
    /// Centre from the left, mm.
    pub x_mm: f64,
    /// Centre from the bottom, mm.
    pub y_mm: f64,
    /// Footprint, mm2.
    pub area_mm2: f64,
    /// How hard, 0 to 1.
    pub force: f64,
}

impl Touches {
    /// Touches that are down in a frame.
    #[must_use]
    pub fn of(t_ns: Nanos, down: &[Touch]) -> Self {
        let rounded = |value: f64, parts: f64| libm::round(value * parts) / parts;
        let seen = |touch: &Touch| TouchSeen {
            id: touch.id.0,
            x_mm: rounded(touch.contact.centre_mm[0], 1e2),
            y_mm: rounded(touch.contact.centre_mm[1], 1e2),
            area_mm2: rounded(touch.contact.area_mm2, 1e0),
            force: rounded(touch.contact.force, 1e2),
        };
        Self {
            t_ns,
            sum: touches_sum(down),
            touches: down.iter().map(seen).collect(),
        }
    }
}

/// CRC-32 of all that is known of touches, to the bit: for each its name, phase (0 down, 1 move, 2 up), since when, and as f64
/// place, area, force and confidence; little-endian.
#[must_use]
pub fn touches_sum(touches: &[Touch]) -> u32 {
    let mut digest = CRC.digest();
    for touch in touches {
        let phase = match touch.phase {
            Phase::Down => 0u8,
            Phase::Move => 1,
            Phase::Up => 2,
        };
        digest.update(&touch.id.0.to_le_bytes());
        digest.update(&[phase]);
        digest.update(&touch.since_ns.to_le_bytes());
        let contact = &touch.contact;
        let [x, y] = contact.centre_mm;
        for value in [x, y, contact.area_mm2, contact.force, contact.confidence] {
            digest.update(&value.to_bits().to_le_bytes());
        }
    }
    digest.finalize()
}

/// Topics, in the order of their channels' numbers.
pub const TOPICS: [&str; 12] = [
    "/frames", "/tick", "/profile", "/pause", "/matrix", "/rezero", "/lost", "/end", "/gap",
    "/touches", "/event", "/control",
];

/// Bytes that are no message of their topic.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a message on {topic} cannot be read: {why}")]
pub struct BadMessage {
    /// The topic.
    pub topic: String,
    /// What is wrong.
    pub why: String,
}

impl Message {
    /// Its place in [`TOPICS`].
    #[must_use]
    pub fn channel(&self) -> usize {
        match self {
            Self::Frames(_) => 0,
            Self::Tick(_) => 1,
            Self::Profile(_) => 2,
            Self::Pause(_) => 3,
            Self::Matrix(_) => 4,
            Self::Rezero(_) => 5,
            Self::Lost(_) => 6,
            Self::End(_) => 7,
            Self::Gap(_) => 8,
            Self::Touches(_) => 9,
            Self::Event(_) => 10,
            Self::Control(_) => 11,
        }
    }

    /// When, if it says so.
    #[must_use]
    pub fn t_ns(&self) -> Option<Nanos> {
        match self {
            Self::Frames(frames) => frames.last().map(|frame| frame.t_ns),
            Self::Tick(at) | Self::Pause(at) | Self::Rezero(at) | Self::End(at) => Some(at.t_ns),
            Self::Profile(texts) => Some(texts.t_ns),
            Self::Touches(touches) => Some(touches.t_ns),
            Self::Event(event) => Some(event.t_ns),
            Self::Control(control) => Some(control.t_ns),
            Self::Matrix(_) | Self::Lost(_) | Self::Gap(_) => None,
        }
    }

    /// As JSON; frames plain, or packed by a packer.
    #[must_use]
    pub fn to_json(&self, packer: Option<&mut Packer>) -> Vec<u8> {
        match self {
            Self::Frames(frames) => json(&Block::of(frames, packer)),
            Self::Tick(at) | Self::Pause(at) | Self::Rezero(at) | Self::End(at) => json(at),
            Self::Profile(texts) => json(texts),
            Self::Matrix(name) => json(name),
            Self::Lost(lost) => json(lost),
            Self::Gap(gap) => json(gap),
            Self::Touches(touches) => json(touches),
            Self::Event(event) => json(&EventLine::of(event)),
            Self::Control(control) => json(&ControlLine::of(control)),
        }
    }

    /// From JSON; none for a topic that this version does not know.
    ///
    /// # Errors
    /// Bytes that are no such message, or numbers that cannot be.
    pub fn from_json(
        topic: &str,
        bytes: &[u8],
        unpacker: &mut Unpacker,
    ) -> Result<Option<Self>, BadMessage> {
        let bad = |why: String| BadMessage {
            topic: topic.to_owned(),
            why,
        };
        let message = match topic {
            "/frames" => Self::Frames(
                read::<Block>(bytes)
                    .and_then(|block| block.frames(unpacker))
                    .map_err(bad)?,
            ),
            "/tick" => Self::Tick(read(bytes).map_err(bad)?),
            "/profile" => Self::Profile(read(bytes).map_err(bad)?),
            "/pause" => Self::Pause(read(bytes).map_err(bad)?),
            "/matrix" => Self::Matrix(read(bytes).map_err(bad)?),
            "/rezero" => Self::Rezero(read(bytes).map_err(bad)?),
            "/lost" => Self::Lost(read(bytes).map_err(bad)?),
            "/end" => Self::End(read(bytes).map_err(bad)?),
            "/gap" => Self::Gap(read(bytes).map_err(bad)?),
            "/touches" => Self::Touches(read(bytes).map_err(bad)?),
            "/event" => Self::Event(
                read::<EventLine>(bytes)
                    .and_then(|line| line.event())
                    .map_err(bad)?,
            ),
            "/control" => Self::Control(
                read::<ControlLine>(bytes)
                    .and_then(|line| line.control())
                    .map_err(bad)?,
            ),
            _ => return Ok(None),
        };
        let count = match &message {
            Self::Lost(lost) => lost.frames,
            Self::Gap(gap) => gap.inputs,
            _ => 0,
        };
        if message.t_ns().is_some_and(|t_ns| t_ns > LATEST_NS) || count > MOST_LOST {
            return Err(bad("a number out of range".to_owned()));
        }
        Ok(Some(message))
    }
}

fn json(value: &impl Serialize) -> Vec<u8> {
    // Plain structs of numbers, texts and lists: nothing in them can fail.
    serde_json::to_vec(value).unwrap_or_default()
}

fn read<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, String> {
    serde_json::from_slice(bytes).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::{Action, Axis, Contact, TouchId};
    use proptest::prelude::*;

    fn back(message: &Message) -> Message {
        let topic = TOPICS[message.channel()];
        let read = Message::from_json(topic, &message.to_json(None), &mut Unpacker::default());
        read.expect("sound").expect("known")
    }

    proptest! {
        #[test]
        fn events_come_back_to_the_bit(t_ns in 0..LATEST_NS, value in -1.0..1.0f32, dx in any::<i32>(), dy in any::<i32>(), kind in 0..5) {
            let action = match kind {
                0 => Action::Press("key:f".parse().expect("a key")),
                1 => Action::Release("pad:left-shoulder".parse().expect("a button")),
                2 => Action::Axis(Axis::LeftY, value),
                3 => Action::Motion { dx, dy },
                _ => Action::Wheel { dx, dy },
            };
            let message = Message::Event(Event { t_ns, action });
            prop_assert_eq!(back(&message), message);
        }

        #[test]
        fn frames_keep_their_times(times in proptest::collection::vec(0..1_000_000_000u64, 1..20)) {
            let mut t_ns = 0;
            let frames: Vec<Frame> = times.iter().map(|dt| {
                t_ns += dt;
                Frame { t_ns, volts: vec![1.5, -2.0] }
            }).collect();
            let message = Message::Frames(frames);
            prop_assert_eq!(back(&message), message);
        }
    }

    #[test]
    fn the_sum_of_touches_sees_the_last_bit() {
        let touch = |x: f64| Touch {
            id: TouchId(3),
            phase: Phase::Move,
            since_ns: 5,
            contact: Contact {
                centre_mm: [x, 2.0],
                area_mm2: 100.0,
                force: 0.5,
                confidence: 1.0,
            },
        };
        let next = f64::from_bits(50.0f64.to_bits() + 1);
        assert_ne!(touches_sum(&[touch(50.0)]), touches_sum(&[touch(next)]));
    }

    #[test]
    fn numbers_that_cannot_be_are_refused() {
        let read = |topic: &str, text: &str| {
            Message::from_json(topic, text.as_bytes(), &mut Unpacker::default())
        };
        assert!(read("/tick", r#"{"t_ns":18446744073709551615}"#).is_err());
        assert!(read("/lost", r#"{"frames":18446744073709551615}"#).is_err());
        assert!(
            read(
                "/frames",
                r#"{"t_ns":0,"dt_ns":[18446744073709551615],"volts":""}"#
            )
            .is_err()
        );
        assert_eq!(read("/of-a-later-version", "{}"), Ok(None));
    }
}
