//! The messages of a recording, and each as JSON.
//!
//! Each kind has its own topic, so any reader of MCAP files can plot the ones it needs. The engine's inputs are in the order
//! in which the engine took them; events and touches follow the input that caused them.

use crc::{CRC_32_ISO_HDLC, Crc};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::lines::{EventLine, FrameBlock, GamepadLine, LATEST_NS};
use super::parts_block::PartBlock;
use super::volts::{VoltsDecoder, VoltsEncoder};
use crate::types::{Control, Event, Frame, Nanos, Part, Phase, Touch};

/// A larger count of lost frames or inputs is damage.
const MOST_LOST: u64 = 1 << 40;
static CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// One message of a recording.
#[derive(Clone, Debug, PartialEq)]
pub enum Message {
    /// Input: readings of the pad, as they were received.
    Frames(Vec<Frame>),
    /// Input: a due time has come.
    Tick(TimeOnly),
    /// Input: a profile takes over.
    Profile(ProfileTexts),
    /// Input: the player pauses or continues.
    Pause(TimeOnly),
    /// Input: a new matrix with its weights, which is the attachment before this message.
    Matrix(MatrixName),
    /// Input: the pad counts as untouched from here on.
    Rezero(TimeOnly),
    /// Input: frames were lost before the engine.
    Lost(LostFrames),
    /// Input: the source ended or stopped sending.
    End(TimeOnly),
    /// Inputs that the recorder dropped: what follows cannot be replayed exactly.
    Gap(Gap),
    /// Output of a frame: the touches that are down. Written while there are any, and once when the last has lifted.
    Touches(Touches),
    /// Output of an input: an event.
    Event(Event),
    /// Input: the state of gamepads and switches.
    Control(Control),
    /// Input: readings of frames that were still being read.
    Parts(Vec<Part>),
    /// The touches of several frames, in a slim recording: the head of a message takes more room than a frame's touches.
    TouchBlock(TouchBlock),
}

/// A message that holds only a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimeOnly {
    /// Time of the source, ns.
    pub t_ns: Nanos,
}

/// The texts that a profile was read from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProfileTexts {
    /// When it takes over, ns.
    pub t_ns: Nanos,
    /// The profiles that it extends, the lowest first, then its own text.
    pub chain: Vec<NamedText>,
    /// User settings applied over it.
    pub user: Option<NamedText>,
}

/// A text and its file name, without folders.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NamedText {
    /// The file's name.
    pub name: String,
    /// The text.
    pub toml: String,
}

/// The attachment that holds a matrix.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MatrixName {
    /// Name of the attachment.
    pub attachment: String,
}

/// Frames that never reached the engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LostFrames {
    /// Number of frames.
    pub frames: u64,
}

/// Inputs that are missing in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gap {
    /// Number of inputs; 0 if unknown.
    pub inputs: u64,
}

/// The touches of one frame, rounded, with a check sum of their exact values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Touches {
    /// The frame's time, ns.
    pub t_ns: Nanos,
    /// See [`touches_sum`].
    pub sum: u32,
    /// The touches that are down.
    pub touches: Vec<RecordedTouch>,
}

/// The touches of several frames.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TouchBlock {
    /// In the order of their times.
    pub frames: Vec<Touches>,
}

/// A touch with rounded values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordedTouch {
    /// Its id, never reused.
    pub id: u64,
    /// Distance of the centre from the left, mm.
    pub x_mm: f64,
    /// Distance of the centre from the bottom, mm.
    pub y_mm: f64,
    /// Footprint, mm2.
    pub area_mm2: f64,
    /// Force, 0 to 1.
    pub force: f64,
}

impl Touches {
    /// From the touches that are down in a frame.
    #[must_use]
    pub fn from_touches(t_ns: Nanos, down: &[Touch]) -> Self {
        let rounded = |value: f64, parts: f64| libm::round(value * parts) / parts;
        let recorded = |touch: &Touch| RecordedTouch {
            id: touch.id.0,
            x_mm: rounded(touch.contact.centre_mm[0], 1e2),
            y_mm: rounded(touch.contact.centre_mm[1], 1e2),
            area_mm2: rounded(touch.contact.area_mm2, 1e0),
            force: rounded(touch.contact.force, 1e2),
        };
        Self {
            t_ns,
            sum: touches_sum(down),
            touches: down.iter().map(recorded).collect(),
        }
    }
}

/// CRC-32 of the exact values of touches: for each its id, phase (0 down, 1 move, 2 up), start time, and as f64 place, area,
/// force and confidence; little-endian.
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

/// The topics, in the order of their channel numbers.
pub const TOPICS: [&str; 14] = [
    "/frames",
    "/tick",
    "/profile",
    "/pause",
    "/matrix",
    "/rezero",
    "/lost",
    "/end",
    "/gap",
    "/touches",
    "/event",
    "/control",
    "/parts",
    "/touch_block",
];

/// Bytes that are not a message of their topic.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a message on {topic} cannot be read: {why}")]
pub struct BadMessage {
    /// The topic.
    pub topic: String,
    /// The reason.
    pub why: String,
}

impl Message {
    /// Index of its topic in [`TOPICS`].
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
            Self::Parts(_) => 12,
            Self::TouchBlock(_) => 13,
        }
    }

    /// Its time, where it has one.
    #[must_use]
    pub fn t_ns(&self) -> Option<Nanos> {
        match self {
            Self::Frames(frames) => frames.last().map(|frame| frame.t_ns),
            Self::Tick(at) | Self::Pause(at) | Self::Rezero(at) | Self::End(at) => Some(at.t_ns),
            Self::Profile(texts) => Some(texts.t_ns),
            Self::Touches(touches) => Some(touches.t_ns),
            Self::Event(event) => Some(event.t_ns),
            Self::Control(control) => Some(control.t_ns),
            Self::Parts(parts) => parts.last().map(|part| part.t_ns),
            Self::TouchBlock(block) => block.frames.last().map(|touches| touches.t_ns),
            Self::Matrix(_) | Self::Lost(_) | Self::Gap(_) => None,
        }
    }

    /// As JSON; with an encoder, frames are compressed.
    #[must_use]
    pub fn to_json(&self, encoder: Option<&mut VoltsEncoder>) -> Vec<u8> {
        match self {
            Self::Frames(frames) => json(&FrameBlock::new(frames, encoder)),
            Self::Tick(at) | Self::Pause(at) | Self::Rezero(at) | Self::End(at) => json(at),
            Self::Profile(texts) => json(texts),
            Self::Matrix(name) => json(name),
            Self::Lost(lost) => json(lost),
            Self::Gap(gap) => json(gap),
            Self::Touches(touches) => json(touches),
            Self::TouchBlock(block) => json(block),
            Self::Event(event) => json(&EventLine::from(event)),
            Self::Control(control) => json(&GamepadLine::from(control)),
            Self::Parts(parts) => json(&PartBlock::new(parts, encoder)),
        }
    }

    /// Reads a message from JSON; `None` for a topic that this version does not define.
    ///
    /// # Errors
    /// Bytes that are not such a message, or numbers out of range.
    pub fn from_json(
        topic: &str,
        bytes: &[u8],
        decoder: &mut VoltsDecoder,
    ) -> Result<Option<Self>, BadMessage> {
        let bad = |why: String| BadMessage {
            topic: topic.to_owned(),
            why,
        };
        let Some(message) = parse(topic, bytes, decoder).map_err(bad)? else {
            return Ok(None);
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

fn parse(topic: &str, bytes: &[u8], decoder: &mut VoltsDecoder) -> Result<Option<Message>, String> {
    Ok(Some(match topic {
        "/frames" => Message::Frames(read::<FrameBlock>(bytes)?.into_frames(decoder)?),
        "/tick" => Message::Tick(read(bytes)?),
        "/profile" => Message::Profile(read(bytes)?),
        "/pause" => Message::Pause(read(bytes)?),
        "/matrix" => Message::Matrix(read(bytes)?),
        "/rezero" => Message::Rezero(read(bytes)?),
        "/lost" => Message::Lost(read(bytes)?),
        "/end" => Message::End(read(bytes)?),
        "/gap" => Message::Gap(read(bytes)?),
        "/touches" => Message::Touches(read(bytes)?),
        "/touch_block" => match read::<TouchBlock>(bytes)? {
            block if block.frames.is_empty() => return Err("a block without frames".to_owned()),
            block => Message::TouchBlock(block),
        },
        "/event" => Message::Event(read::<EventLine>(bytes)?.into_event()?),
        "/parts" => Message::Parts(read::<PartBlock>(bytes)?.into_parts(decoder)?),
        "/control" => Message::Control(read::<GamepadLine>(bytes)?.into_control()?),
        _ => return Ok(None),
    }))
}

fn json(value: &impl Serialize) -> Vec<u8> {
    // Structs of numbers, texts and lists always serialize.
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

    fn round_trip(message: &Message) -> Message {
        let topic = TOPICS[message.channel()];
        let read = Message::from_json(topic, &message.to_json(None), &mut VoltsDecoder::default());
        read.expect("sound").expect("known")
    }

    proptest! {
        #[test]
        fn events_are_read_back_exactly(t_ns in 0..LATEST_NS, value in -1.0..1.0f32, dx in any::<i32>(), dy in any::<i32>(), kind in 0..5) {
            let action = match kind {
                0 => Action::Press("key:f".parse().expect("a key")),
                1 => Action::Release("pad:left-shoulder".parse().expect("a button")),
                2 => Action::Axis(Axis::LeftY, value),
                3 => Action::Motion { dx, dy },
                _ => Action::Wheel { dx, dy },
            };
            let message = Message::Event(Event { t_ns, action });
            prop_assert_eq!(round_trip(&message), message);
        }

        #[test]
        fn frames_keep_their_times(times in proptest::collection::vec(0..1_000_000_000u64, 1..20)) {
            let mut t_ns = 0;
            let frames: Vec<Frame> = times.iter().map(|dt| {
                t_ns += dt;
                Frame { t_ns, volts: vec![1.5, -2.0] }
            }).collect();
            let message = Message::Frames(frames);
            prop_assert_eq!(round_trip(&message), message);
        }
    }

    #[test]
    fn the_sum_of_touches_covers_the_last_bit() {
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
    fn numbers_out_of_range_are_refused() {
        let read = |topic: &str, text: &str| {
            Message::from_json(topic, text.as_bytes(), &mut VoltsDecoder::default())
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
