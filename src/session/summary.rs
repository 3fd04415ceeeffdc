//! What a list of recordings shows of one, without reading its frames: its length and the game it was played with.

use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::Path;
use std::time::Duration;

use mcap::read::parse_record;
use mcap::records::{AttachmentIndex, Record};
use mcap::sans_io::summary_reader::{SummaryReadEvent, SummaryReader};

use super::message::ProfileTexts;
use super::setup::PROFILE;

/// Code and length before the body of a record, bytes.
const HEAD: u64 = 9;
/// A longer attachment is no profile, bytes.
const LONGEST_PROFILE: u64 = 16 << 20;

/// The summary of a finished recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordingSummary {
    /// From the first message to the last.
    pub length: Duration,
    /// File name of the profile at the start; none if it cannot be read.
    pub profile: Option<String>,
}

impl RecordingSummary {
    /// Reads the index at the end of a recording; none for a file without one.
    #[must_use]
    pub fn read(path: &Path) -> Option<Self> {
        let mut file = File::open(path).ok()?;
        let mut reader = SummaryReader::new();
        while let Some(event) = reader.next_event() {
            match event.ok()? {
                SummaryReadEvent::ReadRequest(bytes) => {
                    let read = file.read(reader.insert(bytes)).ok()?;
                    reader.notify_read(read);
                }
                SummaryReadEvent::SeekRequest(to) => {
                    let position = file.seek(to).ok()?;
                    reader.notify_seeked(position);
                }
            }
        }
        let summary = reader.finish()?;
        let statistics = summary.stats?;
        let length_ns = statistics
            .message_end_time
            .checked_sub(statistics.message_start_time)?;
        let mut indexes = summary.attachment_indexes.iter();
        let profile = indexes.find(|index| index.name == PROFILE);
        Some(Self {
            length: Duration::from_nanos(length_ns),
            profile: profile.and_then(|index| profile_name(&mut file, index)),
        })
    }
}

/// The name of the profile in an attachment.
fn profile_name(file: &mut File, index: &AttachmentIndex) -> Option<String> {
    if !(HEAD..LONGEST_PROFILE).contains(&index.length) {
        return None;
    }
    let mut record = vec![0; usize::try_from(index.length).ok()?];
    file.seek(SeekFrom::Start(index.offset)).ok()?;
    file.read_exact(&mut record).ok()?;
    let (head, body) = record.split_at(HEAD as usize);
    let Record::Attachment { data, .. } = parse_record(head[0], body).ok()? else {
        return None;
    };
    let texts: ProfileTexts = serde_json::from_slice(&data).ok()?;
    texts.chain.last().map(|text| text.name.clone())
}
