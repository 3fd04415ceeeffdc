//! The records of an MCAP file in order, in bounded memory.
//!
//! `mcap::sans_io::LinearReader` splits the file into records and unpacks chunks; the limits are ours: no record is longer than
//! the rest of the file, no chunk unpacks to more than a real one. The bodies are parsed here: `mcap::parse_record` (0.26)
//! panics on a short attachment and reserves up to 4 GiB for a damaged text length.

use std::io::{Read, Seek, SeekFrom};

use mcap::McapError;
pub(super) use mcap::records::op;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::types::ByteReader;

/// Most bytes of a record. A response table takes 15 MB, one of 256 channels 60.
pub(super) const MOST_RECORD: usize = 128 << 20;
/// Most bytes of an unpacked chunk; those written here take a twentieth.
pub(super) const MOST_CHUNK: usize = 8 << 20;
/// Largest ratio of unpacked to packed size. Frames pack to a half, an empty session to a hundredth.
pub(super) const MOST_RATIO: u64 = 1000;

/// Bodies of these kinds have a fixed length, bytes.
const FOOTER_LENGTH: u64 = 20;
const DATA_END_LENGTH: u64 = 4;
/// Limit of the bytes that are searched for records within damaged ones, as a multiple of the file's length: it bounds the time that
/// a forged file takes.
const MOST_SEARCHED: u64 = 8;

/// Why the next record cannot be read.
#[derive(Debug)]
pub(super) enum RecordError {
    /// The file cannot be read.
    Io(std::io::Error),
    /// Not an MCAP file.
    NotMcap,
    /// The file ends within a record.
    Cut {
        /// Bytes of the record that are present.
        bytes: u64,
    },
    /// There is no valid record at this offset.
    Damaged {
        /// The reason.
        why: String,
    },
}

/// Reads the records of a file.
pub(super) struct Records<R> {
    file: R,
    /// Length of the file, bytes.
    length: u64,
    /// Offset of the next record.
    pub(super) offset: u64,
    /// Offset of the record in `body`.
    start: u64,
    /// Bytes of records that were searched for others.
    searched: u64,
    /// Offset up to which `reader` was fed.
    fed: u64,
    reader: LinearReader,
    pub(super) body: Vec<u8>,
    /// Whether the file was closed properly.
    pub(super) is_whole: bool,
}

impl<R: Read + Seek> Records<R> {
    /// Checks the magic bytes of a file, unless its damage is to be skipped.
    pub(super) fn new(mut file: R, salvaging: bool) -> Result<Self, RecordError> {
        let length = file.seek(SeekFrom::End(0)).map_err(RecordError::Io)?;
        file.seek(SeekFrom::Start(0)).map_err(RecordError::Io)?;
        let mut magic = [0; 8];
        let short = length < magic.len() as u64;
        let is_unlike = |magic: [u8; 8]| {
            let same = magic
                .iter()
                .zip(mcap::MAGIC)
                .filter(|(own, wanted)| own == wanted);
            same.count() < if salvaging { 4 } else { 8 }
        };
        if short || file.read_exact(&mut magic).is_err() || is_unlike(magic) {
            return Err(RecordError::NotMcap);
        }
        Ok(Self {
            file,
            length,
            offset: 8,
            start: 8,
            searched: 0,
            fed: 8,
            reader: linear_reader(true, MOST_RECORD),
            body: Vec::new(),
            is_whole: false,
        })
    }

    /// Reads the next record into `body` and returns its op code; `None` at the end.
    pub(super) fn next(&mut self) -> Result<Option<u8>, RecordError> {
        if self.is_whole {
            return Ok(None);
        }
        while let Some(event) = self.reader.next_event() {
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
                    let bytes = self.reader.insert(need);
                    self.file.read_exact(bytes).map_err(RecordError::Io)?;
                    // Before what follows the head is read: a forged file has many long ones.
                    if self.fed == self.offset {
                        check_head(bytes)?;
                    }
                    self.reader.notify_read(need);
                    self.fed += need as u64;
                }
                Ok(LinearReadEvent::Record { opcode, data }) => {
                    self.body.clear();
                    self.body.extend_from_slice(data);
                    self.start = self.offset;
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

    /// Whether the last record is the first of the file.
    pub(super) fn is_first(&self) -> bool {
        self.start == mcap::MAGIC.len() as u64
    }

    /// Moves to the next offset where a chain of records begins. Returns the number of bytes skipped, `None` if there is none.
    pub(super) fn resynchronise(&mut self) -> std::io::Result<Option<u64>> {
        self.go_to_chain(self.offset, self.length)
    }

    /// Moves to a chain of records that begins within the last one: its length may be what is damaged. Returns the number of its
    /// bytes that are skipped, `None` if there is no such chain.
    pub(super) fn look_inside(&mut self) -> std::io::Result<Option<u64>> {
        self.searched += self.offset - self.start;
        if self.searched > MOST_SEARCHED * self.length {
            return Ok(None);
        }
        let (next, fed) = (self.offset, self.fed);
        let found = self.go_to_chain(self.start, next)?;
        if found.is_none() {
            self.file.seek(SeekFrom::Start(fed))?;
        }
        Ok(found)
    }

    /// Moves to the first chain of records that begins after `start` and before `end`. Returns its distance from `start`.
    fn go_to_chain(&mut self, start: u64, end: u64) -> std::io::Result<Option<u64>> {
        const WINDOW: usize = 1 << 16;
        let mut window = vec![0; WINDOW];
        let mut at = start + 1;
        while at < end && at + 9 <= self.length {
            let count = (self.length - at).min(WINDOW as u64) as usize;
            self.file.seek(SeekFrom::Start(at))?;
            self.file.read_exact(&mut window[..count])?;
            for head in 0..=count - 9 {
                let place = at + head as u64;
                if place < end
                    && self.plausible(&window[head..head + 9], place).is_some()
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

    /// The end of the record at `place`, if its head is plausible.
    fn plausible(&self, head: &[u8], place: u64) -> Option<u64> {
        let mut head = ByteReader::new(head);
        let code = head.u8()?;
        let length = head.u64()?;
        let end = place.checked_add(9)?.checked_add(length)?;
        (is_possible(code, length) && length <= MOST_RECORD as u64 && end <= self.length)
            .then_some(end)
    }

    /// Whether three records follow each other here, or fewer up to the end of the file.
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
        self.reader = linear_reader(true, MOST_RECORD);
        Ok(())
    }
}

/// Refuses the first bytes of a record that cannot be one.
fn check_head(bytes: &[u8]) -> Result<(), RecordError> {
    let mut head = ByteReader::new(bytes);
    match (head.u8(), head.u64()) {
        (Some(code), Some(length)) if !is_possible(code, length) => Err(RecordError::Damaged {
            why: format!("there is no record of kind {code} with {length} bytes"),
        }),
        _ => Ok(()),
    }
}

/// Whether there are records of a kind with bodies of a length, in bytes.
fn is_possible(code: u8, length: u64) -> bool {
    match code {
        op::FOOTER => length == FOOTER_LENGTH,
        op::DATA_END => length == DATA_END_LENGTH,
        op::HEADER..=op::DATA_END => length > 0,
        _ => false,
    }
}

fn linear_reader(emit_chunks: bool, limit: usize) -> LinearReader {
    LinearReader::new_with_options(
        LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_emit_chunks(emit_chunks)
            .with_prevalidate_chunk_crcs(!emit_chunks)
            .with_record_length_limit(limit),
    )
}

/// Unpacks the body of a chunk into records: op code and body.
pub(super) fn unpack_chunk(body: &[u8]) -> Result<Vec<(u8, Vec<u8>)>, String> {
    let wrong = || "the head of a chunk is damaged".to_owned();
    let mut head = ByteReader::new(body);
    let (_start, _end) = (head.u64().ok_or_else(wrong)?, head.u64().ok_or_else(wrong)?);
    let unpacked = head.u64().ok_or_else(wrong)?;
    let _sum = head.u32().ok_or_else(wrong)?;
    let _compression = head.text().ok_or_else(wrong)?;
    let packed = head.u64().ok_or_else(wrong)?;
    // The reader does not check that records end within their chunk, so no bytes may follow it.
    if packed != head.rest().len() as u64 {
        return Err(wrong());
    }
    if unpacked > MOST_CHUNK as u64 || unpacked > packed.saturating_mul(MOST_RATIO) {
        return Err(format!(
            "a chunk of {packed} bytes claims to unpack to {unpacked} bytes"
        ));
    }
    let mut reader = linear_reader(false, MOST_CHUNK);
    let mut opening = vec![op::CHUNK];
    opening.extend_from_slice(&(body.len() as u64).to_le_bytes());
    let mut feed = opening.as_slice().chain(body);
    let mut records = Vec::new();
    while let Some(event) = reader.next_event() {
        match event {
            Ok(LinearReadEvent::ReadRequest(need)) => {
                let count = feed.read(reader.insert(need)).map_err(|e| e.to_string())?;
                if count == 0 {
                    return Ok(records);
                }
                reader.notify_read(count);
            }
            Ok(LinearReadEvent::Record { opcode, data }) => records.push((opcode, data.to_vec())),
            Err(error) => return Err(error.to_string()),
        }
    }
    Ok(records)
}

/// Whether a body is that of a message index: a channel and a list of times and offsets.
pub(super) fn is_message_index(body: &[u8]) -> bool {
    let mut body = ByteReader::new(body);
    let (_channel, length) = (body.u16(), body.u32());
    length.is_some_and(|length| length as usize == body.rest().len())
}

/// Parses the header: the profile of the file.
pub(super) fn parse_header(body: &[u8]) -> Option<&str> {
    let mut body = ByteReader::new(body);
    let (profile, _library) = (body.text()?, body.text()?);
    body.rest().is_empty().then_some(profile)
}

/// Whether a body is that of a schema: id, name, encoding and text.
pub(super) fn is_schema(body: &[u8]) -> bool {
    let mut body = ByteReader::new(body);
    let mut parse = || {
        let (_id, _name, _encoding) = (body.u16()?, body.text()?, body.text()?);
        let count = body.count()?;
        body.bytes(count)
    };
    parse().is_some() && body.rest().is_empty()
}

/// Parses a channel: id and topic.
pub(super) fn parse_channel(body: &[u8]) -> Option<(u16, String)> {
    let mut body = ByteReader::new(body);
    let id = body.u16()?;
    let _schema = body.u16()?;
    let (topic, _encoding) = (body.text()?, body.text()?);
    let count = body.count()?;
    body.bytes(count)?;
    (body.rest().is_empty() && !topic.is_empty()).then(|| (id, topic.to_owned()))
}

/// Parses a message: channel id, time and payload.
pub(super) fn parse_message(body: &[u8]) -> Option<(u16, u64, &[u8])> {
    let mut body = ByteReader::new(body);
    let id = body.u16()?;
    let (_sequence, log_time, _publish_time) = (body.u32()?, body.u64()?, body.u64()?);
    Some((id, log_time, body.rest()))
}

/// Parses an attachment: name and bytes, if the check sum is right.
pub(super) fn parse_attachment(body: &[u8]) -> Option<(String, &[u8])> {
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

/// Parses a metadata record: its name, and the value of the `wanted` key.
pub(super) fn parse_metadata<'a>(
    body: &'a [u8],
    wanted: &str,
) -> Option<(&'a str, Option<&'a str>)> {
    let mut body = ByteReader::new(body);
    let name = body.text()?;
    let count = body.count()?;
    let mut pairs = ByteReader::new(body.bytes(count)?);
    let mut found = None;
    while !pairs.rest().is_empty() {
        let (key, value) = (pairs.text()?, pairs.text()?);
        if key == wanted {
            found = Some(value);
        }
    }
    body.rest().is_empty().then_some((name, found))
}
