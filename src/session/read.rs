//! Reads a recording: what the engine is made of, then message after message.
//!
//! Strictly, anything wrong ends it; salvaging, whatever can be read is, and what cannot is noted.

use std::collections::{BTreeMap, VecDeque};
use std::io::{Read, Seek};

use super::message::{Message, ProfileTexts};
use super::records::{self, RecordError, Records, op};
use super::volts::Unpacker;
use super::{CALIBRATION, FORMAT, PAD, PROFILE, RESPONSES, SENSING, Setup, VERSION};

/// Losses that are noted one by one; more are only counted.
const MOST_NOTES: usize = 20;
/// Channels that a file may have.
const MOST_TOPICS: usize = 1024;

/// Why a recording cannot be read, or not further.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file cannot be read.
    #[error("{0}")]
    Io(std::io::Error),
    /// Another kind of file.
    #[error("this is no recording: it does not begin as an MCAP file does")]
    NotMcap,
    /// An MCAP file of somebody else.
    #[error("this MCAP file is no recording of gelpad")]
    NotOurs,
    /// Of a later version.
    #[error(
        "this recording is of version {version}, and this gelpad reads up to {VERSION}: take a newer gelpad"
    )]
    Newer {
        /// Its version.
        version: String,
    },
    /// Cut before an engine could be made of it.
    #[error("the recording is cut before its {missing}: nothing can be replayed")]
    NoSetup {
        /// What is not there.
        missing: &'static str,
    },
    /// The file ends within a record.
    #[error("the recording was cut at its end: {bytes} bytes of a last record")]
    Cut {
        /// Bytes of it that are there.
        bytes: u64,
    },
    /// Something in it is wrong.
    #[error(
        "the recording is damaged at byte {offset}: {why}\n  help: `gelpad recover FILE -o SAVED` saves what it holds"
    )]
    Damaged {
        /// Where.
        offset: u64,
        /// What.
        why: String,
    },
}

/// A recording that is being read.
pub struct Reader<R> {
    records: Records<R>,
    /// Note what is wrong and go on.
    salvaging: bool,
    topics: BTreeMap<u16, String>,
    unpacker: Unpacker,
    /// Records of the chunk at hand.
    chunk: VecDeque<(u8, Vec<u8>)>,
    /// The record that ended the set-up.
    waiting: Option<u8>,
    setup: Parts,
    attachment: Option<(String, Vec<u8>)>,
    notes: Vec<String>,
    losses: u64,
    /// Behind some damage there are no further records.
    exhausted: bool,
    ended: bool,
}

#[derive(Default)]
struct Parts {
    version: Option<String>,
    pad: Option<String>,
    profile: Option<ProfileTexts>,
    calibration: Option<Vec<u8>>,
    sensing: Option<Vec<u8>>,
    responses: Option<Vec<u8>>,
}

impl<R: Read + Seek> Reader<R> {
    /// Opens a recording and reads what its engine is made of.
    ///
    /// # Errors
    /// Another kind of file, one of a later version, or one that is cut before its first message.
    pub fn open(file: R) -> Result<(Self, Setup), ReadError> {
        Self::begin(file, false)
    }

    /// The same, but passes over what is damaged: see [`Self::losses`].
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn salvage(file: R) -> Result<(Self, Setup), ReadError> {
        Self::begin(file, true)
    }

    fn begin(file: R, salvaging: bool) -> Result<(Self, Setup), ReadError> {
        let records = Records::new(file).map_err(|error| match error {
            RecordError::Io(error) => ReadError::Io(error),
            _ => ReadError::NotMcap,
        })?;
        let mut reader = Self {
            records,
            salvaging,
            topics: BTreeMap::new(),
            unpacker: Unpacker::default(),
            chunk: VecDeque::new(),
            waiting: None,
            setup: Parts::default(),
            attachment: None,
            notes: Vec::new(),
            losses: 0,
            exhausted: false,
            ended: false,
        };
        let setup = reader.read_setup()?;
        Ok((reader, setup))
    }

    /// The next message; none at the end.
    ///
    /// # Errors
    /// [`ReadError::Cut`] or [`ReadError::Damaged`], unless salvaging; there is nothing after that.
    #[allow(
        clippy::should_implement_trait,
        reason = "it borrows nothing and may fail for good"
    )]
    pub fn next(&mut self) -> Result<Option<Message>, ReadError> {
        let outcome = self.step();
        if !matches!(outcome, Ok(Some(_))) {
            self.ended = true;
        }
        outcome
    }

    /// The attachment that came last, if it has this name: a matrix message names it.
    #[must_use]
    pub fn attachment(&self, name: &str) -> Option<&[u8]> {
        let (last, bytes) = self.attachment.as_ref()?;
        (last == name).then_some(bytes)
    }

    /// Whether the file was closed as it should be: known at its end.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.records.is_whole
    }

    /// What was passed over: so many things, and the first of them in words.
    #[must_use]
    pub fn losses(&self) -> (u64, &[String]) {
        (self.losses, &self.notes)
    }

    fn read_setup(&mut self) -> Result<Setup, ReadError> {
        while let Some(code) = self.record()? {
            match code {
                op::MESSAGE | op::CHUNK | op::DATA_END | op::FOOTER => {
                    self.waiting = Some(code);
                    break;
                }
                _ => self.take_opening(code)?,
            }
        }
        let parts = std::mem::take(&mut self.setup);
        match &parts.version {
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
        let missing = |missing| ReadError::NoSetup { missing };
        Ok(Setup {
            pad: parts.pad.ok_or(missing("pad"))?,
            profile: parts.profile.ok_or(missing("profile"))?,
            calibration: parts.calibration,
            sensing: parts.sensing.ok_or(missing("matrix"))?,
            responses: parts.responses,
        })
    }

    fn take_opening(&mut self, code: u8) -> Result<(), ReadError> {
        match code {
            op::METADATA if self.setup.version.is_none() => {
                if let Some((name, Some(version))) =
                    records::metadata(&self.records.body, "version")
                    && name == FORMAT
                {
                    self.setup.version = Some(version.to_owned());
                }
                Ok(())
            }
            op::ATTACHMENT => {
                let Some((name, bytes)) = records::attachment(&self.records.body) else {
                    return self.wrong("an attachment is damaged".to_owned());
                };
                let parts = &mut self.setup;
                match name.as_str() {
                    PAD => parts.pad = String::from_utf8(bytes.to_vec()).ok(),
                    PROFILE => parts.profile = serde_json::from_slice(bytes).ok(),
                    CALIBRATION => parts.calibration = Some(bytes.to_vec()),
                    SENSING => parts.sensing = Some(bytes.to_vec()),
                    RESPONSES => parts.responses = Some(bytes.to_vec()),
                    _ => self.attachment = Some((name, bytes.to_vec())),
                }
                Ok(())
            }
            op::CHANNEL => {
                self.take_channel(None);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn step(&mut self) -> Result<Option<Message>, ReadError> {
        if self.ended {
            return Ok(None);
        }
        loop {
            while let Some((code, body)) = self.chunk.pop_front() {
                match code {
                    op::CHANNEL => self.take_channel(Some(&body)),
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
                None => self.record()?,
            };
            match code {
                None => return Ok(None),
                // The index that follows serves others.
                Some(op::DATA_END | op::FOOTER) => {
                    self.records.is_whole = true;
                    return Ok(None);
                }
                Some(op::CHUNK) => match records::unpack_chunk(&self.records.body) {
                    Ok(records) => self.chunk = records.into(),
                    Err(why) => self.wrong(why)?,
                },
                Some(op::MESSAGE) => {
                    if let Some(message) = self.take_message(None)? {
                        return Ok(Some(message));
                    }
                }
                Some(code) => self.take_opening(code)?,
            }
        }
    }

    /// The next record, past damage if salvaging.
    fn record(&mut self) -> Result<Option<u8>, ReadError> {
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
                    format!("{bytes} bytes of a record that is not whole")
                }
                Err(RecordError::Damaged { why }) => why,
            };
            self.wrong(why)?;
            match self.records.resynchronise().map_err(ReadError::Io)? {
                Some(bytes) => {
                    self.note(format!("{bytes} bytes from {offset} on were passed over"))
                }
                None => self.exhausted = true,
            }
        }
        Ok(None)
    }

    fn take_channel(&mut self, body: Option<&[u8]>) {
        if let Some((id, topic)) = records::channel(body.unwrap_or(&self.records.body))
            && self.topics.len() < MOST_TOPICS
        {
            self.topics.insert(id, topic);
        }
    }

    /// A message of a known topic.
    fn take_message(&mut self, body: Option<&[u8]>) -> Result<Option<Message>, ReadError> {
        let body = body.unwrap_or(&self.records.body);
        let read = match records::message(body) {
            None => Err("a message's head is damaged".to_owned()),
            Some((id, payload)) => match self.topics.get(&id) {
                None => Err(format!("a message of the unknown channel {id}")),
                Some(topic) => Message::from_json(topic, payload, &mut self.unpacker)
                    .map_err(|error| error.to_string()),
            },
        };
        match read {
            Ok(message) => Ok(message),
            Err(why) => self.wrong(why).map(|()| None),
        }
    }

    /// Something is wrong: the end, or a note.
    fn wrong(&mut self, why: String) -> Result<(), ReadError> {
        let offset = self.records.offset;
        if !self.salvaging {
            return Err(ReadError::Damaged { offset, why });
        }
        self.losses += 1;
        self.note(format!("at byte {offset}: {why}"));
        Ok(())
    }

    fn note(&mut self, text: String) {
        if self.notes.len() < MOST_NOTES {
            self.notes.push(text);
        }
    }
}
