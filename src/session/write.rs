//! Writes a recording: live, message by message, or packed.

use std::collections::BTreeMap;
use std::io::{Seek, Write};

use mcap::records::MessageHeader;
use mcap::{Attachment, Compression, McapError, WriteOptions};

use super::attachment;
use super::message::{MatrixName, Message, TOPICS, TouchBlock};
use super::parts_block::MOST_VOLTS;
use super::schema::SCHEMAS;
use super::setup::{CALIBRATION, FORMAT, PAD, PROFILE, RESPONSES, SENSING, SLIM, Setup, VERSION};
use super::volts::VoltsEncoder;
use crate::types::{Frame, Nanos, Part};

/// Frames in one message of a packed file; the head of a message then hardly counts.
const BLOCK_FRAMES: usize = 16;
/// Most messages in a chunk of a packed file, which is what one damaged byte can destroy, ...
const CHUNK_MESSAGES: usize = 512;
/// ... and most blocks of frames: 8 s at 100 frames/s.
const CHUNK_BLOCKS: usize = 50;
/// Level of zstd: higher ones save a hundredth more. The voltages are compressed already.
const ZSTD_LEVEL: u32 = 9;

/// Why a recording cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct WriteError(#[from] McapError);

impl WriteError {
    /// The error of the system or the library.
    #[must_use]
    pub fn reason(&self) -> String {
        match &self.0 {
            McapError::Io(error) => error.to_string(),
            error => error.to_string(),
        }
    }
}

/// Writes a recording.
pub struct Writer<W: Write + Seek> {
    file: mcap::Writer<W>,
    /// For a packed recording.
    packed: Option<PackedState>,
    /// Channel number of each topic.
    channels: Vec<u16>,
    sequence: u32,
    latest_ns: Nanos,
    matrices: u32,
}

#[derive(Default)]
struct PackedState {
    encoder: VoltsEncoder,
    /// Frames of the incomplete block, ...
    block: Vec<Frame>,
    /// ... or parts; never both.
    parts: Vec<Part>,
    /// Touches and events of these frames.
    outputs: Vec<Message>,
    /// Whether the touches of a block become one message.
    joins_touches: bool,
    /// Messages of the chunk, ...
    messages: usize,
    /// ... and those that hold frames.
    blocks: usize,
}

impl PackedState {
    /// Whether no block is incomplete.
    fn is_empty(&self) -> bool {
        self.block.is_empty() && self.parts.is_empty()
    }
}

impl<W: Write + Seek> Writer<W> {
    /// Starts a live recording: after [`Self::flush`], all messages so far are readable.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn live(file: W, setup: &Setup) -> Result<Self, WriteError> {
        Self::start(file, setup, None)
    }

    /// Starts a packed recording.
    ///
    /// # Errors
    /// As [`Self::live`].
    pub fn packed(file: W, setup: &Setup) -> Result<Self, WriteError> {
        let packed = PackedState {
            joins_touches: setup.slim.is_some(),
            ..PackedState::default()
        };
        Self::start(file, setup, Some(packed))
    }

    fn start(file: W, setup: &Setup, packed: Option<PackedState>) -> Result<Self, WriteError> {
        let options = WriteOptions::new()
            .profile(FORMAT)
            .library(concat!("gelpad ", env!("CARGO_PKG_VERSION")))
            .use_chunks(packed.is_some())
            .chunk_size(None)
            .compression(packed.is_some().then_some(Compression::Zstd))
            .compression_level(ZSTD_LEVEL)
            .compression_threads(0);
        let mut writer = Self {
            file: options.create(file)?,
            packed,
            channels: Vec::new(),
            sequence: 0,
            latest_ns: 0,
            matrices: 0,
        };
        writer.file.write_metadata(&mcap::records::Metadata {
            name: FORMAT.to_owned(),
            metadata: BTreeMap::from([("version".to_owned(), VERSION.to_string())]),
        })?;
        writer.write_setup(setup)?;
        Ok(writer)
    }

    fn write_setup(&mut self, setup: &Setup) -> Result<(), WriteError> {
        self.attach(PAD, setup.pad.as_bytes())?;
        // Texts and a number always serialize.
        self.attach(
            PROFILE,
            &serde_json::to_vec(&setup.profile).unwrap_or_default(),
        )?;
        if let Some(calibration) = &setup.calibration {
            self.attach(CALIBRATION, calibration)?;
        }
        match &setup.slim {
            Some(slim) => self.attach(SLIM, &serde_json::to_vec(slim).unwrap_or_default())?,
            None => self.attach(SENSING, &setup.sensing)?,
        }
        if let Some(responses) = &setup.responses {
            self.attach(RESPONSES, responses)?;
        }
        for (topic, (schema, text)) in TOPICS.iter().zip(SCHEMAS) {
            let schema = self
                .file
                .add_schema(schema, "jsonschema", text.as_bytes())?;
            let channel = self
                .file
                .add_channel(schema, topic, "json", &BTreeMap::new())?;
            self.channels.push(channel);
        }
        Ok(())
    }

    fn attach(&mut self, name: &str, bytes: &[u8]) -> Result<(), WriteError> {
        let (name, media_type, data) = attachment::stored(name, bytes).map_err(McapError::from)?;
        self.file.attach(&Attachment {
            log_time: self.latest_ns,
            create_time: self.latest_ns,
            name,
            media_type: media_type.to_owned(),
            data,
        })?;
        Ok(())
    }

    /// Writes a message. A matrix is written by [`Self::write_matrix`].
    ///
    /// # Errors
    /// The file cannot be written; the recording ends there.
    pub fn write(&mut self, message: &Message) -> Result<(), WriteError> {
        let Some(packed) = &mut self.packed else {
            return self.put(message);
        };
        match message {
            Message::Frames(frames) => {
                for frame in frames {
                    self.add_to_block(frame)?;
                }
                Ok(())
            }
            Message::Parts(parts) => parts.iter().try_for_each(|part| self.add_part(part)),
            Message::Touches(_) | Message::Event(_) if !packed.is_empty() => {
                packed.outputs.push(message.clone());
                Ok(())
            }
            _ => {
                self.end_block()?;
                self.put(message)
            }
        }
    }

    /// Writes a new matrix and the message that it is used from here on.
    ///
    /// # Errors
    /// As [`Self::write`].
    pub fn write_matrix(&mut self, sensing: &[u8]) -> Result<(), WriteError> {
        self.end_block()?;
        self.matrices += 1;
        let name = format!("sensing-{}.bin", self.matrices);
        self.attach(&name, sensing)?;
        self.restart_chunk();
        self.put(&Message::Matrix(MatrixName { attachment: name }))
    }

    /// Passes all messages to the system; in a packed recording, ends the chunk.
    ///
    /// # Errors
    /// As [`Self::write`].
    pub fn flush(&mut self) -> Result<(), WriteError> {
        self.end_block()?;
        self.restart_chunk();
        Ok(self.file.flush()?)
    }

    /// Ends the recording and writes the index.
    ///
    /// # Errors
    /// As [`Self::write`].
    pub fn finish(mut self) -> Result<W, WriteError> {
        self.end_block()?;
        self.file.finish()?;
        Ok(self.file.into_inner())
    }

    /// The next message begins a chunk, which must be readable alone.
    fn restart_chunk(&mut self) {
        if let Some(packed) = &mut self.packed {
            packed.messages = 0;
            packed.blocks = 0;
            packed.encoder.restart();
        }
    }

    fn add_to_block(&mut self, frame: &Frame) -> Result<(), WriteError> {
        let Some(packed) = &mut self.packed else {
            return Ok(());
        };
        let fits = packed
            .block
            .first()
            .is_none_or(|first| first.volts.len() == frame.volts.len());
        if packed.block.len() == BLOCK_FRAMES || !fits || !packed.parts.is_empty() {
            self.end_block()?;
        }
        if let Some(packed) = &mut self.packed {
            packed.block.push(frame.clone());
        }
        Ok(())
    }

    fn add_part(&mut self, part: &Part) -> Result<(), WriteError> {
        let Some(packed) = &mut self.packed else {
            return Ok(());
        };
        let begins_frame = |part: &&Part| part.first == 0;
        let frames = packed.parts.iter().filter(begins_frame).count();
        let volts: usize = packed.parts.iter().map(|part| part.volts.len()).sum();
        let is_full = begins_frame(&part) && frames == BLOCK_FRAMES;
        if !packed.block.is_empty() || is_full || volts + part.volts.len() > MOST_VOLTS {
            self.end_block()?;
        }
        if let Some(packed) = &mut self.packed {
            packed.parts.push(part.clone());
        }
        Ok(())
    }

    fn end_block(&mut self) -> Result<(), WriteError> {
        match &mut self.packed {
            Some(packed) if !packed.is_empty() => {
                let frames = std::mem::take(&mut packed.block);
                let parts = std::mem::take(&mut packed.parts);
                let mut outputs = std::mem::take(&mut packed.outputs);
                if packed.joins_touches {
                    outputs = join_touches(outputs);
                }
                self.put(&match parts.is_empty() {
                    true => Message::Frames(frames),
                    false => Message::Parts(parts),
                })?;
                outputs.iter().try_for_each(|output| self.put(output))
            }
            _ => Ok(()),
        }
    }

    fn put(&mut self, message: &Message) -> Result<(), WriteError> {
        if let Some(packed) = &mut self.packed {
            let holds_frames = matches!(message, Message::Frames(_) | Message::Parts(_));
            packed.messages += 1;
            packed.blocks += usize::from(holds_frames);
            if packed.messages > CHUNK_MESSAGES || packed.blocks > CHUNK_BLOCKS {
                packed.messages = 1;
                packed.blocks = usize::from(holds_frames);
                packed.encoder.restart();
                self.file.flush()?;
            }
        }
        // Other tools sort by this time, so it never decreases.
        self.latest_ns = self.latest_ns.max(message.t_ns().unwrap_or(0));
        let payload = message.to_json(self.packed.as_mut().map(|packed| &mut packed.encoder));
        let header = MessageHeader {
            channel_id: self.channels[message.channel()],
            sequence: self.sequence,
            log_time: self.latest_ns,
            publish_time: self.latest_ns,
        };
        self.sequence = self.sequence.wrapping_add(1);
        Ok(self.file.write_to_known_channel(&header, &payload)?)
    }
}

/// One message for all touches, before the others.
fn join_touches(outputs: Vec<Message>) -> Vec<Message> {
    let mut frames = Vec::new();
    let mut others = Vec::new();
    for output in outputs {
        match output {
            Message::Touches(touches) => frames.push(touches),
            other => others.push(other),
        }
    }
    if !frames.is_empty() {
        others.insert(0, Message::TouchBlock(TouchBlock { frames }));
    }
    others
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::super::message::{Gap, LostFrames, NamedText, ProfileTexts, TimeOnly, Touches};
    use super::super::read::{ReadError, Reader};
    use super::*;
    use crate::types::{Action, Event};
    use proptest::prelude::*;

    fn setup() -> Setup {
        let text = NamedText {
            name: "mine.toml".to_owned(),
            toml: "schema = 1".to_owned(),
        };
        Setup {
            pad: "name = \"p\"".to_owned(),
            profile: ProfileTexts {
                t_ns: 0,
                chain: vec![text],
                user: None,
            },
            calibration: None,
            sensing: vec![1, 2, 3],
            responses: Some(vec![4; 5000]),
            slim: None,
        }
    }

    /// Messages of a session, in the order of their times.
    fn messages() -> impl Strategy<Value = Vec<Message>> {
        let one = (
            0..13u8,
            0..50u64,
            proptest::collection::vec(-1.0..1.0f32, 3),
        );
        proptest::collection::vec(one, 0..150).prop_map(|all| {
            let mut t_ns = 0;
            let message = |(kind, dt, volts): (u8, u64, Vec<f32>)| {
                t_ns += dt;
                match kind {
                    0 => Message::Tick(TimeOnly { t_ns }),
                    1 => Message::Rezero(TimeOnly { t_ns }),
                    2 => Message::Lost(LostFrames { frames: dt }),
                    3 => Message::Gap(Gap { inputs: dt }),
                    4 => Message::Touches(Touches::from_touches(t_ns, &[])),
                    5 => Message::Event(Event {
                        t_ns,
                        action: Action::Press("key:f".parse().expect("a key")),
                    }),
                    6..9 => Message::Frames(vec![Frame { t_ns, volts }]),
                    kind => Message::Parts(vec![Part {
                        t_ns,
                        first: 3 * usize::from(kind % 2),
                        volts,
                    }]),
                }
            };
            all.into_iter().map(message).collect()
        })
    }

    fn is_output(message: &Message) -> bool {
        matches!(message, Message::Touches(_) | Message::Event(_))
    }

    /// All messages of a recording, one frame or part each.
    fn read(bytes: Vec<u8>) -> Vec<Message> {
        let (mut reader, back) = Reader::open(Cursor::new(bytes)).expect("a recording");
        assert_eq!(back, setup());
        let mut all = Vec::new();
        while let Some(message) = reader.next().expect("sound") {
            match message {
                Message::Frames(frames) => {
                    all.extend(frames.into_iter().map(|frame| Message::Frames(vec![frame])));
                }
                Message::Parts(parts) => {
                    all.extend(parts.into_iter().map(|part| Message::Parts(vec![part])));
                }
                message => all.push(message),
            }
        }
        assert!(reader.is_whole());
        all
    }

    proptest! {
        #[test]
        fn messages_are_read_back_from_live_and_packed_files(messages in messages()) {
            let mut live = Writer::live(Cursor::new(Vec::new()), &setup()).expect("memory");
            let mut packed = Writer::packed(Cursor::new(Vec::new()), &setup()).expect("memory");
            for message in &messages {
                live.write(message).expect("memory");
                live.flush().expect("memory");
                packed.write(message).expect("memory");
            }
            let live = read(live.finish().expect("memory").into_inner());
            prop_assert_eq!(&live, &messages);
            // In a packed file, touches and events follow their block of frames.
            let packed = read(packed.finish().expect("memory").into_inner());
            for is_wanted in [true, false] {
                let those = |all: &[Message]| -> Vec<Message> {
                    all.iter().filter(|m| is_output(m) == is_wanted).cloned().collect()
                };
                prop_assert_eq!(those(&packed), those(&messages));
            }
        }

        #[test]
        fn a_file_cut_anywhere_is_read_up_to_the_cut(messages in messages(), cut in 0..3000usize) {
            let mut live = Writer::live(Cursor::new(Vec::new()), &setup()).expect("memory");
            for message in &messages {
                live.write(message).expect("memory");
            }
            let bytes = live.finish().expect("memory").into_inner();
            let length = bytes.len() - cut.min(bytes.len() / 2);
            match Reader::open(Cursor::new(&bytes[..length])) {
                Err(error) => prop_assert!(matches!(error, ReadError::NoSetup { .. } | ReadError::Cut { .. }), "{error}"),
                Ok((mut reader, _)) => {
                    let mut read = 0;
                    let end = loop {
                        match reader.next() {
                            Ok(Some(message)) => {
                                prop_assert_eq!(&message, &messages[read]);
                                read += 1;
                            }
                            end => break end,
                        }
                    };
                    prop_assert!(matches!(end, Ok(None) | Err(ReadError::Cut { .. })), "{end:?}");
                }
            }
        }
    }

    #[test]
    fn a_recording_of_a_later_version_is_refused() {
        let live = Writer::live(Cursor::new(Vec::new()), &setup()).expect("memory");
        let mut bytes = live.finish().expect("memory").into_inner();
        let key = bytes
            .windows(7)
            .position(|part| part == b"version")
            .expect("a version");
        assert_eq!(bytes[key + 11], b'0' + VERSION as u8);
        bytes[key + 11] += 1;
        let error = Reader::open(Cursor::new(bytes)).err().expect("refused");
        assert!(error.to_string().contains("use a newer gelpad"), "{error}");
    }
}
