//! Writes a recording: message by message as they come, or packed.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{Seek, Write};

use mcap::records::MessageHeader;
use mcap::{Attachment, Compression, McapError, WriteOptions};

use super::message::{MatrixName, Message, TOPICS};
use super::schema::SCHEMAS;
use super::volts::Packer;
use super::{CALIBRATION, FORMAT, PAD, PROFILE, RESPONSES, SENSING, Setup, VERSION};
use crate::types::{Frame, Nanos};

/// Frames that are packed into one message: a message's head is then next to nothing.
const BLOCK_FRAMES: usize = 16;
/// Messages of a chunk: what a damaged byte can spoil of a packed file.
const CHUNK_MESSAGES: usize = 512;
/// How hard zstd tries; what is worth packing has been packed before.
const ZSTD_LEVEL: u32 = 3;

/// Why a recording cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct WriteError(#[from] McapError);

impl WriteError {
    /// What the system said.
    #[must_use]
    pub fn reason(&self) -> String {
        match &self.0 {
            McapError::Io(error) => error.to_string(),
            error => error.to_string(),
        }
    }
}

/// A recording that is being written.
pub struct Writer<W: Write + Seek> {
    file: mcap::Writer<W>,
    packing: Option<Packing>,
    /// The number of each topic's channel.
    channels: Vec<u16>,
    sequence: u32,
    latest_ns: Nanos,
    matrices: u32,
}

#[derive(Default)]
struct Packing {
    packer: Packer,
    /// Frames that wait for a whole block ...
    block: Vec<Frame>,
    /// ... and what came of them.
    outcomes: Vec<Message>,
    messages: usize,
}

impl<W: Write + Seek> Writer<W> {
    /// Begins a recording that is flushed with every message that [`Self::flush`] follows.
    ///
    /// # Errors
    /// What the system says: no space, no such folder.
    pub fn live(file: W, setup: &Setup) -> Result<Self, WriteError> {
        Self::begin(file, setup, None)
    }

    /// Begins a packed recording.
    ///
    /// # Errors
    /// As [`Self::live`].
    pub fn packed(file: W, setup: &Setup) -> Result<Self, WriteError> {
        Self::begin(file, setup, Some(Packing::default()))
    }

    fn begin(file: W, setup: &Setup, packing: Option<Packing>) -> Result<Self, WriteError> {
        let options = WriteOptions::new()
            .profile(FORMAT)
            .library(concat!("gelpad ", env!("CARGO_PKG_VERSION")))
            .use_chunks(packing.is_some())
            .chunk_size(None)
            .compression(packing.is_some().then_some(Compression::Zstd))
            .compression_level(ZSTD_LEVEL)
            .compression_threads(0);
        let mut writer = Self {
            file: options.create(file)?,
            packing,
            channels: Vec::new(),
            sequence: 0,
            latest_ns: 0,
            matrices: 0,
        };
        writer.file.write_metadata(&mcap::records::Metadata {
            name: FORMAT.to_owned(),
            metadata: BTreeMap::from([("version".to_owned(), VERSION.to_string())]),
        })?;
        writer.setup(setup)?;
        Ok(writer)
    }

    fn setup(&mut self, setup: &Setup) -> Result<(), WriteError> {
        self.attach(PAD, setup.pad.as_bytes())?;
        // Texts and a number: nothing in them can fail.
        self.attach(
            PROFILE,
            &serde_json::to_vec(&setup.profile).unwrap_or_default(),
        )?;
        if let Some(calibration) = &setup.calibration {
            self.attach(CALIBRATION, calibration)?;
        }
        self.attach(SENSING, &setup.sensing)?;
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
        self.file.attach(&Attachment {
            log_time: self.latest_ns,
            create_time: self.latest_ns,
            name: name.to_owned(),
            media_type: media_type(name).to_owned(),
            data: Cow::Borrowed(bytes),
        })?;
        Ok(())
    }

    /// Writes a message. A matrix goes by [`Self::matrix`].
    ///
    /// # Errors
    /// What the system says. Nothing should be written after that.
    pub fn write(&mut self, message: &Message) -> Result<(), WriteError> {
        let Some(packing) = &mut self.packing else {
            return self.put(message);
        };
        match message {
            Message::Frames(frames) => {
                for frame in frames {
                    self.pack(frame)?;
                }
                Ok(())
            }
            Message::Touches(_) | Message::Event(_) if !packing.block.is_empty() => {
                packing.outcomes.push(message.clone());
                Ok(())
            }
            _ => {
                self.end_block()?;
                self.put(message)
            }
        }
    }

    /// Writes another matrix and the message that it takes over.
    ///
    /// # Errors
    /// As [`Self::write`].
    pub fn matrix(&mut self, sensing: &[u8]) -> Result<(), WriteError> {
        self.end_block()?;
        self.matrices += 1;
        let name = format!("sensing-{}.bin", self.matrices);
        self.attach(&name, sensing)?;
        if let Some(packing) = &mut self.packing {
            packing.messages = 0;
            packing.packer.restart();
        }
        self.put(&Message::Matrix(MatrixName { attachment: name }))
    }

    /// Hands all that was written to the system; while packing, ends a chunk.
    ///
    /// # Errors
    /// As [`Self::write`].
    pub fn flush(&mut self) -> Result<(), WriteError> {
        self.end_block()?;
        if let Some(packing) = &mut self.packing {
            packing.packer.restart();
            packing.messages = 0;
        }
        Ok(self.file.flush()?)
    }

    /// Ends the recording: what comes after is an index.
    ///
    /// # Errors
    /// As [`Self::write`].
    pub fn finish(mut self) -> Result<W, WriteError> {
        self.end_block()?;
        self.file.finish()?;
        Ok(self.file.into_inner())
    }

    fn pack(&mut self, frame: &Frame) -> Result<(), WriteError> {
        let Some(packing) = &mut self.packing else {
            return Ok(());
        };
        let fits = packing
            .block
            .first()
            .is_none_or(|first| first.volts.len() == frame.volts.len());
        if packing.block.len() == BLOCK_FRAMES || !fits {
            self.end_block()?;
        }
        if let Some(packing) = &mut self.packing {
            packing.block.push(frame.clone());
        }
        Ok(())
    }

    fn end_block(&mut self) -> Result<(), WriteError> {
        match &mut self.packing {
            Some(packing) if !packing.block.is_empty() => {
                let frames = std::mem::take(&mut packing.block);
                let outcomes = std::mem::take(&mut packing.outcomes);
                self.put(&Message::Frames(frames))?;
                outcomes.iter().try_for_each(|outcome| self.put(outcome))
            }
            _ => Ok(()),
        }
    }

    fn put(&mut self, message: &Message) -> Result<(), WriteError> {
        if let Some(packing) = &mut self.packing {
            packing.messages += 1;
            if packing.messages > CHUNK_MESSAGES {
                packing.messages = 1;
                packing.packer.restart();
                self.file.flush()?;
            }
        }
        // Other tools sort by this: it never runs backwards.
        self.latest_ns = self.latest_ns.max(message.t_ns().unwrap_or(0));
        let payload = message.to_json(self.packing.as_mut().map(|packing| &mut packing.packer));
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

fn media_type(name: &str) -> &'static str {
    match name.rsplit_once('.') {
        Some((_, "json")) => "application/json",
        Some((_, "toml")) => "application/toml",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::super::message::{At, Gap, Lost, NamedText, ProfileTexts, Touches};
    use super::super::{ReadError, Reader};
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
        }
    }

    /// Messages of a session, times ascending.
    fn messages() -> impl Strategy<Value = Vec<Message>> {
        let one = (0..9u8, 0..50u64, proptest::collection::vec(-1.0..1.0f32, 3));
        proptest::collection::vec(one, 0..150).prop_map(|all| {
            let mut t_ns = 0;
            let message = |(kind, dt, volts): (u8, u64, Vec<f32>)| {
                t_ns += dt;
                match kind {
                    0 => Message::Tick(At { t_ns }),
                    1 => Message::Rezero(At { t_ns }),
                    2 => Message::Lost(Lost { frames: dt }),
                    3 => Message::Gap(Gap { inputs: dt }),
                    4 => Message::Touches(Touches::of(t_ns, &[])),
                    5 => Message::Event(Event {
                        t_ns,
                        action: Action::Press("key:f".parse().expect("a key")),
                    }),
                    _ => Message::Frames(vec![Frame { t_ns, volts }]),
                }
            };
            all.into_iter().map(message).collect()
        })
    }

    fn is_outcome(message: &Message) -> bool {
        matches!(message, Message::Touches(_) | Message::Event(_))
    }

    /// All messages, frames one by one.
    fn read(bytes: Vec<u8>) -> Vec<Message> {
        let (mut reader, back) = Reader::open(Cursor::new(bytes)).expect("a recording");
        assert_eq!(back, setup());
        let mut all = Vec::new();
        while let Some(message) = reader.next().expect("sound") {
            match message {
                Message::Frames(frames) => {
                    all.extend(frames.into_iter().map(|frame| Message::Frames(vec![frame])));
                }
                message => all.push(message),
            }
        }
        assert!(reader.is_whole());
        all
    }

    proptest! {
        #[test]
        fn live_or_packed_the_messages_come_back(messages in messages()) {
            let mut live = Writer::live(Cursor::new(Vec::new()), &setup()).expect("memory");
            let mut packed = Writer::packed(Cursor::new(Vec::new()), &setup()).expect("memory");
            for message in &messages {
                live.write(message).expect("memory");
                live.flush().expect("memory");
                packed.write(message).expect("memory");
            }
            let live = read(live.finish().expect("memory").into_inner());
            prop_assert_eq!(&live, &messages);
            // Packed, what came of a block of frames follows the block.
            let packed = read(packed.finish().expect("memory").into_inner());
            for outcome in [true, false] {
                let those = |all: &[Message]| -> Vec<Message> {
                    all.iter().filter(|m| is_outcome(m) == outcome).cloned().collect()
                };
                prop_assert_eq!(those(&packed), those(&messages));
            }
        }

        #[test]
        fn a_file_that_is_cut_anywhere_gives_all_before(messages in messages(), cut in 0..3000usize) {
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
    fn a_recording_of_a_later_version_asks_for_a_newer_gelpad() {
        let live = Writer::live(Cursor::new(Vec::new()), &setup()).expect("memory");
        let mut bytes = live.finish().expect("memory").into_inner();
        let key = bytes
            .windows(7)
            .position(|part| part == b"version")
            .expect("a version");
        assert_eq!(bytes[key + 11], b'1');
        bytes[key + 11] = b'2';
        let error = Reader::open(Cursor::new(bytes)).err().expect("refused");
        assert!(error.to_string().contains("take a newer gelpad"), "{error}");
    }
}
