//! Records of an MCAP file, one after the other, in bounded memory.
//!
//! The walk is the library's (`mcap::sans_io::LinearReader`); the limits are ours: no record is longer than what is left of the
//! file, no chunk unpacks to more than a real one. What a record's body says is read here byte by byte, since a
//! hostile one may say anything.

use std::io::{Read, Seek, SeekFrom};

use mcap::McapError;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::types::ByteReader;

/// No record is longer: a table of responses takes 15 MB, one of 256 channels 60.
const MOST_RECORD: usize = 128 << 20;
/// No chunk unpacks to more; those written here to a twentieth.
pub(super) const MOST_CHUNK: usize = 8 << 20;
/// Nor to so many times its packed size: frames pack to a half, the emptiest of sessions to a hundredth.
const MOST_RATIO: u64 = 1000;

/// Codes of the records that matter here.
pub(super) mod op {
    pub(in crate::session) const FOOTER: u8 = 0x02;
    pub(in crate::session) const CHANNEL: u8 = 0x04;
    pub(in crate::session) const MESSAGE: u8 = 0x05;
    pub(in crate::session) const CHUNK: u8 = 0x06;
    pub(in crate::session) const ATTACHMENT: u8 = 0x09;
    pub(in crate::session) const METADATA: u8 = 0x0C;
    pub(in crate::session) const DATA_END: u8 = 0x0F;
}

/// Why there is no further record.
#[derive(Debug)]
pub(super) enum RecordError {
    /// The file cannot be read.
    Io(std::io::Error),
    /// No MCAP file.
    NotMcap,
    /// The file ends within a record.
    Cut {
        /// Bytes of it that are there.
        bytes: u64,
    },
    /// No record stands here.
    Damaged {
        /// Why.
        why: String,
    },
}

/// Walks a file's records.
pub(super) struct Records<R> {
    file: R,
    /// Length of the file.
    length: u64,
    /// Where the next record begins.
    pub(super) offset: u64,
    /// Bytes handed to the walker so far, counted from the file's start.
    fed: u64,
    walker: LinearReader,
    pub(super) body: Vec<u8>,
    /// Whether the file was closed as it should be.
    pub(super) is_whole: bool,
}

impl<R: Read + Seek> Records<R> {
    /// The records of a file from its start.
    pub(super) fn new(mut file: R) -> Result<Self, RecordError> {
        let length = file.seek(SeekFrom::End(0)).map_err(RecordError::Io)?;
        file.seek(SeekFrom::Start(0)).map_err(RecordError::Io)?;
        let mut magic = [0; 8];
        let short = length < magic.len() as u64;
        if short || file.read_exact(&mut magic).is_err() || magic != *mcap::MAGIC {
            return Err(RecordError::NotMcap);
        }
        Ok(Self {
            file,
            length,
            offset: 8,
            fed: 8,
            walker: walker(true, MOST_RECORD),
            body: Vec::new(),
            is_whole: false,
        })
    }

    /// The next record's code; its body is in `body`. None at the end.
    pub(super) fn next(&mut self) -> Result<Option<u8>, RecordError> {
        if self.is_whole {
            return Ok(None);
        }
        while let Some(event) = self.walker.next_event() {
            match event {
                Ok(LinearReadEvent::ReadRequest(need)) => {
                    let left = self.length - self.fed;
                    if need as u64 > left {
                        let bytes = self.length - self.offset;
                        return if bytes == 0 {
                            Ok(None)
                        } else {
                            Err(RecordError::Cut { bytes })
                        };
                    }
                    self.file
                        .read_exact(self.walker.insert(need))
                        .map_err(RecordError::Io)?;
                    self.walker.notify_read(need);
                    self.fed += need as u64;
                }
                Ok(LinearReadEvent::Record { opcode, data }) => {
                    self.body.clear();
                    self.body.extend_from_slice(data);
                    self.offset += 9 + data.len() as u64;
                    self.is_whole = opcode == op::FOOTER;
                    return Ok(Some(opcode));
                }
                Err(McapError::Io(error)) => return Err(RecordError::Io(error)),
                Err(error) => {
                    return Err(RecordError::Damaged {
                        why: error.to_string(),
                    });
                }
            }
        }
        Ok(None)
    }

    /// Goes to the next place where records seem to stand; how many bytes were passed over, none if there is no such place.
    pub(super) fn resynchronise(&mut self) -> std::io::Result<Option<u64>> {
        const WINDOW: usize = 1 << 16;
        let start = self.offset;
        let mut window = vec![0; WINDOW];
        let mut at = start + 1;
        while at + 9 <= self.length {
            let count = (self.length - at).min(WINDOW as u64) as usize;
            self.file.seek(SeekFrom::Start(at))?;
            self.file.read_exact(&mut window[..count])?;
            for head in 0..=count - 9 {
                let place = at + head as u64;
                if self.plausible(&window[head..head + 9], place).is_some()
                    && self.chain_holds(place)?
                {
                    self.go_to(place)?;
                    return Ok(Some(place - start));
                }
            }
            at += (count - 8) as u64;
        }
        Ok(None)
    }

    /// Where the record at a place would end, if it looks like one.
    fn plausible(&self, head: &[u8], place: u64) -> Option<u64> {
        let mut head = ByteReader::new(head);
        let code = head.u8()?;
        let length = head.u64()?;
        let end = place.checked_add(9)?.checked_add(length)?;
        ((1..=0x0F).contains(&code)
            && length <= MOST_RECORD as u64
            && length > 0
            && end <= self.length)
            .then_some(end)
    }

    /// Whether three records stand in a row here, or fewer and then the end of the file.
    fn chain_holds(&mut self, place: u64) -> std::io::Result<bool> {
        let mut place = place;
        for _ in 0..3 {
            if place == self.length {
                return Ok(true);
            }
            let mut head = [0; 9];
            self.file.seek(SeekFrom::Start(place))?;
            if self.file.read_exact(&mut head).is_err() {
                return Ok(false);
            }
            match self.plausible(&head, place) {
                Some(_) if head[0] == op::FOOTER => return Ok(true),
                Some(end) => place = end,
                None => return Ok(false),
            }
        }
        Ok(true)
    }

    fn go_to(&mut self, place: u64) -> std::io::Result<()> {
        self.file.seek(SeekFrom::Start(place))?;
        self.offset = place;
        self.fed = place;
        self.walker = walker(true, MOST_RECORD);
        Ok(())
    }
}

fn walker(emit_chunks: bool, limit: usize) -> LinearReader {
    LinearReader::new_with_options(
        LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_emit_chunks(emit_chunks)
            .with_prevalidate_chunk_crcs(!emit_chunks)
            .with_record_length_limit(limit),
    )
}

/// The records of a chunk's body, each with its code.
pub(super) fn unpack_chunk(body: &[u8]) -> Result<Vec<(u8, Vec<u8>)>, String> {
    let wrong = || "a chunk's head is damaged".to_owned();
    let mut head = ByteReader::new(body);
    let (_start, _end) = (head.u64().ok_or_else(wrong)?, head.u64().ok_or_else(wrong)?);
    let unpacked = head.u64().ok_or_else(wrong)?;
    let _sum = head.u32().ok_or_else(wrong)?;
    let _compression = head.text().ok_or_else(wrong)?;
    let packed = head.u64().ok_or_else(wrong)?;
    // The walker trusts that no record runs out of its chunk: it must not find bytes beyond.
    if packed != head.rest().len() as u64 {
        return Err(wrong());
    }
    if unpacked > MOST_CHUNK as u64 || unpacked > packed.saturating_mul(MOST_RATIO) {
        return Err(format!(
            "a chunk claims to unpack from {packed} to {unpacked} bytes"
        ));
    }
    let mut walker = walker(false, MOST_CHUNK);
    let mut opening = vec![op::CHUNK];
    opening.extend_from_slice(&(body.len() as u64).to_le_bytes());
    let mut feed = opening.iter().chain(body).copied();
    let mut left = opening.len() + body.len();
    let mut records = Vec::new();
    while let Some(event) = walker.next_event() {
        match event {
            Ok(LinearReadEvent::ReadRequest(need)) => {
                if left == 0 {
                    return Ok(records);
                }
                let count = need.min(left);
                for (slot, byte) in walker.insert(count).iter_mut().zip(&mut feed) {
                    *slot = byte;
                }
                walker.notify_read(count);
                left -= count;
            }
            Ok(LinearReadEvent::Record { opcode, data }) => records.push((opcode, data.to_vec())),
            Err(error) => return Err(error.to_string()),
        }
    }
    Ok(records)
}

/// A channel: its number and topic.
pub(super) fn channel(body: &[u8]) -> Option<(u16, String)> {
    let mut body = ByteReader::new(body);
    let id = body.u16()?;
    let _schema = body.u16()?;
    Some((id, body.text()?.to_owned()))
}

/// A message: its channel and payload.
pub(super) fn message(body: &[u8]) -> Option<(u16, &[u8])> {
    let mut body = ByteReader::new(body);
    let id = body.u16()?;
    let (_sequence, _log_time, _publish_time) = (body.u32()?, body.u64()?, body.u64()?);
    Some((id, body.rest()))
}

/// An attachment: its name and bytes, if its check sum is right.
pub(super) fn attachment(body: &[u8]) -> Option<(String, &[u8])> {
    const CRC: crc::Crc<u32, crc::Table<16>> =
        crc::Crc::<u32, crc::Table<16>>::new(&crc::CRC_32_ISO_HDLC);
    let mut reader = ByteReader::new(body);
    let (_log_time, _create_time) = (reader.u64()?, reader.u64()?);
    let name = reader.text()?.to_owned();
    let _media_type = reader.text()?;
    let count = usize::try_from(reader.u64()?).ok()?;
    let bytes = reader.bytes(count)?;
    let sum = reader.u32()?;
    let before = &body[..body.len() - 4];
    (reader.rest().is_empty() && (sum == 0 || CRC.checksum(before) == sum)).then_some((name, bytes))
}

/// A metadata record: its name, and the value of a key.
pub(super) fn metadata<'a>(body: &'a [u8], wanted: &str) -> Option<(&'a str, Option<&'a str>)> {
    let mut body = ByteReader::new(body);
    let name = body.text()?;
    let count = body.count()?;
    let mut pairs = ByteReader::new(body.bytes(count)?);
    while !pairs.rest().is_empty() {
        let (key, value) = (pairs.text()?, pairs.text()?);
        if key == wanted {
            return Some((name, Some(value)));
        }
    }
    Some((name, None))
}
