//! Reads a recording: the setup, then message by message.
//!
//! A strict reader stops at the first damage. A salvaging reader skips damage and notes it.

use std::collections::{BTreeMap, VecDeque};
use std::io::{Read, Seek};

use super::attachment;
use super::message::{Message, TOPICS};
use super::records::{self, RecordError, Records, op};
use super::setup::{
    CALIBRATION, FORMAT, PAD, PROFILE, RESPONSES, SENSING, SLIM, Setup, SetupParts, VERSION,
};
use super::volts::VoltsDecoder;

/// Losses that are described; more are only counted.
const MOST_NOTES: usize = 20;
/// Most channels of a file.
const MOST_CHANNELS: usize = 1024;

/// Why a recording cannot be read, or not beyond some point.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file cannot be read.
    #[error("{0}")]
    Io(std::io::Error),
    /// Not an MCAP file.
    #[error("not a recording: the file is not an MCAP file")]
    NotMcap,
    /// An MCAP file of another program.
    #[error("not a recording: this MCAP file is not from gelpad")]
    NotOurs,
    /// A format version that this program does not read.
    #[error(
        "the recording has format version {version}, this gelpad reads up to {VERSION}: use a newer gelpad"
    )]
    Newer {
        /// The version of the recording.
        version: String,
    },
    /// The file ends before the setup is complete.
    #[error("the recording ends before its {missing}: nothing can be replayed")]
    NoSetup {
        /// The missing part.
        missing: &'static str,
    },
    /// The file ends within a record.
    #[error(
        "the recording ends within a record: {bytes} bytes of it are present\n  help: `gelpad recover FILE -o SAVED` saves what can be read"
    )]
    Cut {
        /// Bytes of the record that are present.
        bytes: u64,
    },
    /// The file is damaged.
    #[error(
        "the recording is damaged at byte {offset}: {why}\n  help: `gelpad recover FILE -o SAVED` saves what can be read"
    )]
    Damaged {
        /// Offset of the damage, bytes.
        offset: u64,
        /// The reason.
        why: String,
    },
}

impl ReadError {
    /// Whether a recording of gelpad is cut off or damaged, so that a part of it may be saved.
    #[must_use]
    pub fn is_damage(&self) -> bool {
        matches!(self, Self::Cut { .. } | Self::Damaged { .. })
    }
}

/// Reads a recording.
pub struct Reader<R> {
    records: Records<R>,
    /// Whether to note damage and continue.
    salvaging: bool,
    topics: BTreeMap<u16, String>,
    decoder: VoltsDecoder,
    /// Records left in the current chunk.
    chunk: VecDeque<(u8, Vec<u8>)>,
    /// The record that ended the setup.
    waiting: Option<u8>,
    /// Whether the recording is packed.
    has_chunks: bool,
    /// Whether the header names gelpad.
    is_ours: bool,
    version: Option<String>,
    setup: SetupParts,
    attachment: Option<(String, Vec<u8>)>,
    notes: Vec<String>,
    losses: u64,
    /// There are no further records after some damage.
    exhausted: bool,
    ended: bool,
}

impl<R: Read + Seek> Reader<R> {
    /// Opens a recording and reads its setup.
    ///
    /// # Errors
    /// Another kind of file, a later version, or a file that ends before its first message.
    pub fn open(file: R) -> Result<(Self, Setup), ReadError> {
        let (reader, parts) = Self::start(file, false)?;
        let setup = parts.complete();
        Ok((
            reader,
            setup.map_err(|missing| ReadError::NoSetup { missing })?,
        ))
    }

    /// Opens a recording and skips damage, also in its setup: see [`Self::losses`].
    ///
    /// # Errors
    /// Another kind of file, or a later version.
    pub fn salvage(file: R) -> Result<(Self, SetupParts), ReadError> {
        Self::start(file, true)
    }

    fn start(file: R, salvaging: bool) -> Result<(Self, SetupParts), ReadError> {
        let records = Records::new(file, salvaging).map_err(|error| match error {
            RecordError::Io(error) => ReadError::Io(error),
            _ => ReadError::NotMcap,
        })?;
        let mut reader = Self {
            records,
            salvaging,
            topics: BTreeMap::new(),
            decoder: VoltsDecoder::default(),
            chunk: VecDeque::new(),
            waiting: None,
            has_chunks: false,
            is_ours: false,
            version: None,
            setup: SetupParts::default(),
            attachment: None,
            notes: Vec::new(),
            losses: 0,
            exhausted: false,
            ended: false,
        };
        let setup = reader.read_setup()?;
        Ok((reader, setup))
    }

    /// Reads the next message; `None` at the end.
    ///
    /// # Errors
    /// [`ReadError::Cut`] or [`ReadError::Damaged`], unless salvaging. Nothing can be read after an error.
    #[allow(clippy::should_implement_trait, reason = "an error ends it")]
    pub fn next(&mut self) -> Result<Option<Message>, ReadError> {
        let message = self.read_message();
        self.ended = !matches!(message, Ok(Some(_)));
        message
    }

    /// The last attachment, if it has this name; a matrix message names the one before it.
    #[must_use]
    pub fn attachment(&self, name: &str) -> Option<&[u8]> {
        let (last, bytes) = self.attachment.as_ref()?;
        (last == name).then_some(bytes)
    }

    /// Whether the file was closed properly; known at its end.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.records.is_whole
    }

    /// The number of losses, and a description of the first of them.
    #[must_use]
    pub fn losses(&self) -> (u64, &[String]) {
        (self.losses, &self.notes)
    }

    fn read_setup(&mut self) -> Result<SetupParts, ReadError> {
        while let Some(code) = self.next_record()? {
            match code {
                op::MESSAGE | op::CHUNK if self.salvaging && !self.is_readable(code) => {
                    self.skip_damage("a message within the setup".to_owned())?;
                }
                op::MESSAGE | op::CHUNK | op::DATA_END | op::FOOTER => {
                    self.waiting = Some(code);
                    break;
                }
                _ => self.take_other(code)?,
            }
        }
        let parts = std::mem::take(&mut self.setup);
        match &self.version {
            // The record of the version may be what is damaged.
            None if self.salvaging
                && (self.losses > 0 || self.is_ours)
                && parts != SetupParts::default() =>
            {
                self.report_damage("the format's version cannot be read".to_owned())?;
            }
            None => return Err(ReadError::NotOurs),
            Some(version)
                if version
                    .parse::<u32>()
                    .is_ok_and(|v| (1..=VERSION).contains(&v)) => {}
            Some(version) => {
                let version = version.chars().take(20).collect();
                return Err(ReadError::Newer { version });
            }
        }
        Ok(parts)
    }

    /// Whether the first message or chunk can be read: the kind of another record may be damaged.
    fn is_readable(&self, code: u8) -> bool {
        let body = &self.records.body;
        if code == op::CHUNK {
            return records::unpack_chunk(body).is_ok();
        }
        let message = records::parse_message(body).and_then(|(id, _, payload)| {
            let topic = self.topic_of(id)?;
            Message::from_json(&topic, payload, &mut VoltsDecoder::default()).ok()
        });
        message.is_some()
    }

    /// Takes a record that is neither a message nor a chunk.
    fn take_other(&mut self, code: u8) -> Result<(), ReadError> {
        match code {
            op::METADATA => match records::parse_metadata(&self.records.body, "version") {
                Some((FORMAT, Some(version))) if self.version.is_none() => {
                    self.version = Some(version.to_owned());
                    Ok(())
                }
                Some(_) => Ok(()),
                None => self.skip_damage("a metadata record is damaged".to_owned()),
            },
            op::ATTACHMENT => {
                let stored = records::parse_attachment(&self.records.body);
                let restored = stored
                    .as_ref()
                    .and_then(|(name, bytes)| attachment::restored(name, bytes));
                let Some((name, bytes)) = restored else {
                    return self.skip_damage("an attachment is damaged".to_owned());
                };
                let parts = &mut self.setup;
                match name {
                    PAD => parts.pad = String::from_utf8(bytes.into_owned()).ok(),
                    PROFILE => parts.profile = serde_json::from_slice(&bytes).ok(),
                    CALIBRATION => parts.calibration = Some(bytes.into_owned()),
                    SENSING => parts.sensing = Some(bytes.into_owned()),
                    RESPONSES => parts.responses = Some(bytes.into_owned()),
                    SLIM => parts.slim = serde_json::from_slice(&bytes).ok(),
                    _ => self.attachment = Some((name.to_owned(), bytes.into_owned())),
                }
                Ok(())
            }
            op::CHANNEL => match records::parse_channel(&self.records.body) {
                Some((id, topic)) if self.add_topic(id, &topic) => Ok(()),
                _ => self.skip_damage("a channel is damaged".to_owned()),
            },
            op::HEADER if self.records.is_first() => {
                match records::parse_header(&self.records.body) {
                    Some(profile) => {
                        self.is_ours = profile == FORMAT;
                        Ok(())
                    }
                    None => self.skip_damage("the header is damaged".to_owned()),
                }
            }
            // For other tools.
            op::SCHEMA if records::is_schema(&self.records.body) => Ok(()),
            op::MESSAGE_INDEX
                if self.has_chunks && records::is_message_index(&self.records.body) =>
            {
                Ok(())
            }
            _ => self.skip_damage(format!("a record of kind {code} does not belong here")),
        }
    }

    fn read_message(&mut self) -> Result<Option<Message>, ReadError> {
        if self.ended {
            return Ok(None);
        }
        loop {
            while let Some((code, body)) = self.chunk.pop_front() {
                match code {
                    op::CHANNEL => {
                        if let Some((id, topic)) = records::parse_channel(&body) {
                            self.add_topic(id, &topic);
                        }
                    }
                    op::MESSAGE => {
                        if let Some(message) = self.take_message(Some(&body))? {
                            return Ok(Some(message));
                        }
                    }
                    _ => {}
                }
            }
            let code = match self.waiting.take() {
                Some(code) => Some(code),
                None => self.next_record()?,
            };
            match code {
                None => return Ok(None),
                // Only other tools need the index that follows.
                Some(op::DATA_END | op::FOOTER) => {
                    self.records.is_whole = true;
                    return Ok(None);
                }
                Some(op::CHUNK) => {
                    self.has_chunks = true;
                    match records::unpack_chunk(&self.records.body) {
                        Ok(records) => self.chunk = records.into(),
                        Err(why) => self.skip_damage(why)?,
                    }
                }
                Some(op::MESSAGE) => {
                    if let Some(message) = self.take_message(None)? {
                        return Ok(Some(message));
                    }
                }
                Some(code) => self.take_other(code)?,
            }
        }
    }

    /// Reads the next record; skips damage if salvaging.
    fn next_record(&mut self) -> Result<Option<u8>, ReadError> {
        while !self.exhausted {
            let offset = self.records.offset;
            let why = match self.records.next() {
                Ok(code) => return Ok(code),
                Err(RecordError::Io(error)) => return Err(ReadError::Io(error)),
                Err(RecordError::NotMcap) => return Err(ReadError::NotMcap),
                Err(RecordError::Cut { bytes }) if !self.salvaging => {
                    return Err(ReadError::Cut { bytes });
                }
                Err(RecordError::Cut { bytes }) => {
                    format!("an incomplete record of {bytes} bytes")
                }
                Err(RecordError::Damaged { why }) => why,
            };
            self.report_damage(why)?;
            match self.records.resynchronise().map_err(ReadError::Io)? {
                Some(bytes) => self.note(format!("skipped {bytes} bytes from byte {offset}")),
                None => self.exhausted = true,
            }
        }
        Ok(None)
    }

    /// Adds a channel. Returns false if it is known with another topic: a channel's topic never changes.
    fn add_topic(&mut self, id: u16, topic: &str) -> bool {
        if let Some(known) = self.topics.get(&id) {
            return known == topic;
        }
        if self.topics.len() < MOST_CHANNELS {
            self.topics.insert(id, topic.to_owned());
        }
        true
    }

    /// Parses a message; `None` for an unknown topic.
    fn take_message(&mut self, body: Option<&[u8]>) -> Result<Option<Message>, ReadError> {
        let is_in_chunk = body.is_some();
        let body = body.unwrap_or(&self.records.body);
        let read = match records::parse_message(body) {
            None => Err("the head of a message is damaged".to_owned()),
            Some((id, log_ns, payload)) => match self.topic_of(id) {
                None => Err(format!("a message of unknown channel {id}")),
                Some(topic) => Message::from_json(&topic, payload, &mut self.decoder)
                    .map_err(|error| error.to_string())
                    .and_then(|message| self.check_time(message, log_ns)),
            },
        };
        match read {
            Ok(message) => Ok(message),
            Err(why) if is_in_chunk => self.report_damage(why).map(|()| None),
            Err(why) => self.skip_damage(why).map(|()| None),
        }
    }

    /// The topic of a channel. Where the channels were in a damaged part, they are numbered as gelpad does.
    fn topic_of(&self, id: u16) -> Option<String> {
        let known = self.topics.get(&id).cloned();
        known.or_else(|| {
            let index = usize::from(id).checked_sub(1)?;
            let topic = TOPICS.get(index).filter(|_| self.salvaging)?;
            Some((*topic).to_owned())
        })
    }

    /// Refuses a message whose own time is later than that of its record: one of them is damaged.
    fn check_time(&self, message: Option<Message>, log_ns: u64) -> Result<Option<Message>, String> {
        let t_ns = message.as_ref().and_then(Message::t_ns);
        if self.salvaging && t_ns.is_some_and(|t_ns| t_ns > log_ns) {
            return Err("a time that differs from that of its record".to_owned());
        }
        Ok(message)
    }

    /// Counts a message as lost, although it could be read.
    pub(super) fn reject(&mut self, why: &str) {
        self.losses += 1;
        self.note(format!("at byte {}: {why}", self.records.offset));
    }

    /// Reports damage: an error, or a note if salvaging.
    fn report_damage(&mut self, why: String) -> Result<(), ReadError> {
        let offset = self.records.offset;
        if !self.salvaging {
            return Err(ReadError::Damaged { offset, why });
        }
        self.losses += 1;
        self.note(format!("at byte {offset}: {why}"));
        Ok(())
    }

    /// Reports that the last record is damaged. Its length may be wrong, so reading continues at the next record within it, if there
    /// is one.
    fn skip_damage(&mut self, why: String) -> Result<(), ReadError> {
        self.report_damage(why)?;
        if let Some(bytes) = self.records.look_inside().map_err(ReadError::Io)? {
            self.note(format!("its length is wrong: skipped {bytes} bytes of it"));
        }
        Ok(())
    }

    fn note(&mut self, text: String) {
        if self.notes.len() < MOST_NOTES {
            self.notes.push(text);
        }
    }
}
