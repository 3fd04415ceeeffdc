//! Flipped bits and cuts: what is outside of the damaged chunk comes back, and what is saved replays.
//!
//! `GELPAD_FLIPS` and `GELPAD_CUTS` set the numbers (default: a small sample).

use std::fs;
use std::io::Cursor;
use std::ops::Range;
use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use gelpad::session::{Message, Reader, SetupParts};

use crate::sessions::straight;
use crate::{gelpad, said};

const FLIPS: u64 = 10;
const CUTS: u64 = 4;
/// Fewer frames cannot be replayed.
const REFERENCE_FRAMES: u64 = 10;
/// Op codes of records.
const CHUNK: u8 = 6;
const ATTACHMENT: u8 = 9;
const DATA_END: u8 = 15;

/// Kind, beginning and end of every record.
fn records(bytes: &[u8]) -> Result<Vec<(u8, usize, usize)>> {
    let (mut at, mut records) = (8, Vec::new());
    while let Some(head) = bytes.get(at..at + 9) {
        let length = u64::from_le_bytes(head[1..].try_into()?) as usize;
        let end = at + 9 + length;
        if end > bytes.len() {
            break;
        }
        records.push((head[0], at, end));
        at = end;
    }
    Ok(records)
}

/// Saves a damaged recording and replays what was saved; returns the number of frames.
fn saved(folder: &Path, bytes: &[u8]) -> Result<u64> {
    fs::write(folder.join("damaged.mcap"), bytes)?;
    let _ = fs::remove_file(folder.join("saved.mcap"));
    let output = gelpad(folder, &["recover", "damaged.mcap", "-o", "saved.mcap"]);
    let text = said(&output);
    ensure!(
        matches!(output.status.code(), Some(0 | 3)),
        "recover: {:?}\n{text}",
        output.status
    );
    let replayed = gelpad(folder, &["replay", "saved.mcap", "--print", "events"]);
    ensure!(
        matches!(replayed.status.code(), Some(0 | 3)),
        "replay: {:?}\n{}",
        replayed.status,
        said(&replayed)
    );
    let frames = text.split("saved.mcap: ").nth(1);
    let frames = frames.and_then(|rest| rest.split(' ').next());
    Ok(frames.context("how many")?.parse()?)
}

fn number(name: &str, default: u64) -> u64 {
    let text = std::env::var(name).ok();
    text.and_then(|text| text.parse().ok()).unwrap_or(default)
}

pub fn flips_and_cuts() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let folder = folder.path();
    let packed = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/data/recordings/version-1.mcap"
    );
    straight(&folder.join("live.mcap"), 60, false)?;
    straight(&folder.join("packed.mcap"), 900, true)?;
    for file in [
        fs::read(packed)?,
        fs::read(folder.join("packed.mcap"))?,
        fs::read(folder.join("live.mcap"))?,
    ] {
        one_file(folder, &file)?;
    }
    Ok(())
}

fn one_file(folder: &Path, whole: &[u8]) -> Result<()> {
    let all = saved(folder, whole)?;
    let records = records(whole)?;
    let data_end = records.last().map_or(0, |(_, _, end)| *end);
    // What is left when a whole chunk is gone.
    let mut without = Vec::new();
    for (code, start, end) in &records {
        if *code == CHUNK {
            let mut bytes = whole.to_vec();
            bytes[start + 60..*end].fill(0);
            without.push((*start, *end, saved(folder, &bytes).unwrap_or(0)));
        }
    }
    let mut random = 0x9e37_79b9_7f4a_7c15_u64;
    let mut below = |end: usize| {
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (random >> 33) as usize % end
    };
    for flip in 0..number("GELPAD_FLIPS", FLIPS) {
        // Every second one hits the messages, which are the smaller part.
        let first_message = records
            .iter()
            .rfind(|(code, ..)| *code == ATTACHMENT)
            .map_or(0, |(_, _, end)| *end);
        let at = match flip % 2 {
            0 => first_message + below(data_end - first_message),
            _ => below(whole.len()),
        };
        let mut bytes = whole.to_vec();
        bytes[at] ^= 1 << below(8);
        let hit = without
            .iter()
            .find(|(start, end, _)| (*start..*end).contains(&at));
        // In a file without chunks, a message is hit.
        let least = hit.map_or(all - 1, |(_, _, frames)| *frames);
        if least < REFERENCE_FRAMES {
            // The only chunk is hit.
            continue;
        }
        let frames = saved(folder, &bytes).with_context(|| format!("a flip at byte {at}"))?;
        ensure!(
            frames >= least,
            "a flip at byte {at} cost {} of {all} frames",
            all - frames
        );
    }
    for _ in 0..number("GELPAD_CUTS", CUTS) {
        let set_up = records
            .iter()
            .rfind(|(code, ..)| *code == ATTACHMENT)
            .map_or(0, |(_, _, end)| *end);
        let length = set_up + (whole.len() - set_up) / 2 + below((whole.len() - set_up) / 2);
        // A packed file that is cut within its first chunk holds no frame.
        if without.is_empty() || without.iter().any(|(_, end, _)| *end <= length) {
            saved(folder, &whole[..length]).with_context(|| format!("a cut at byte {length}"))?;
        }
    }
    Ok(())
}

/// Every bit of the heads of records of every kind: a wrong length or kind costs the record, not those that follow, and is never
/// silent.
pub fn damaged_heads() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("s.mcap");
    for is_packed in [false, true] {
        straight(&path, if is_packed { 900 } else { 60 }, is_packed)?;
        let whole = fs::read(&path)?;
        let records = records(&whole)?;
        let intact = readable(&whole)?.parts;
        // A file that was not closed has no end of its data, and no index after it.
        let data_end = records.iter().position(|(code, ..)| *code == DATA_END);
        let data = &records[..data_end.map_or(records.len(), |last| last + 1)];
        for code in 1..=DATA_END {
            let of_kind: Vec<_> = data.iter().filter(|(kind, ..)| *kind == code).collect();
            let first_and_last = [of_kind.first(), of_kind.last()];
            for (_, start, end) in first_and_last.into_iter().flatten() {
                flip_head(&whole, &intact, *start..*end)
                    .with_context(|| format!("kind {code}, packed: {is_packed}"))?;
            }
        }
    }
    Ok(())
}

fn flip_head(whole: &[u8], intact: &SetupParts, record: Range<usize>) -> Result<()> {
    let mut without = whole.to_vec();
    without.drain(record.clone());
    let least = readable(&without)?;
    for bit in 0..9 * 8 {
        let mut bytes = whole.to_vec();
        bytes[record.start + bit / 8] ^= 1 << (bit % 8);
        let read = readable(&bytes).with_context(|| format!("bit {bit}"))?;
        ensure!(
            read.frames >= least.frames,
            "bit {bit}: {} frames, not {}",
            read.frames,
            least.frames
        );
        ensure!(read.losses > 0, "bit {bit}: no loss is reported");
        ensure!(
            read.parts == least.parts || read.parts == *intact,
            "bit {bit}: other parts of the setup"
        );
        let strict = Reader::open(Cursor::new(&bytes)).and_then(|(mut reader, _)| {
            while reader.next()?.is_some() {}
            Ok(reader.is_whole())
        });
        ensure!(
            !matches!(strict, Ok(true)),
            "bit {bit}: read as a whole recording"
        );
    }
    Ok(())
}

/// What can be read of a damaged recording.
struct Readable {
    frames: u64,
    losses: u64,
    parts: SetupParts,
}

fn readable(bytes: &[u8]) -> Result<Readable> {
    let (mut reader, parts) = Reader::salvage(Cursor::new(bytes))?;
    let mut frames = 0;
    while let Some(message) = reader.next()? {
        if let Message::Frames(block) = message {
            frames += block.len() as u64;
        }
    }
    let losses = reader.losses().0;
    Ok(Readable {
        frames,
        losses,
        parts,
    })
}

/// A table that cannot be read is solved again from the pad, which is said.
pub fn damaged_table() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let folder = folder.path();
    straight(&folder.join("s.mcap"), 60, true)?;
    let whole = fs::read(folder.join("s.mcap"))?;
    let all = saved(folder, &whole)?;
    let mut has_own_pad = false;
    for (code, start, end) in records(&whole)? {
        if code != ATTACHMENT {
            continue;
        }
        let mut bytes = whole.clone();
        bytes[(start + end) / 2] ^= 1;
        let frames = saved(folder, &bytes)?;
        ensure!(frames == all, "{frames} of {all} frames");
        fs::write(folder.join("damaged.mcap"), &bytes)?;
        let output = gelpad(folder, &["recover", "damaged.mcap", "-o", "saved.mcap"]);
        ensure!(output.status.code() == Some(3), "{:?}", output.status);
        ensure!(said(&output).contains("warning: "), "{}", said(&output));
        if said(&output).contains("the pad cannot be read") {
            refuses_another_pad(folder)?;
            has_own_pad = true;
        }
    }
    ensure!(has_own_pad, "no damage to the pad was tried");
    ignores_a_pad(folder, &whole)?;
    Ok(())
}

/// A pad is named for a recording whose own can be read: that is not used, and nothing is lost.
fn ignores_a_pad(folder: &Path, whole: &[u8]) -> Result<()> {
    fs::write(folder.join("whole.mcap"), whole)?;
    let arguments = [
        "recover",
        "whole.mcap",
        "-o",
        "saved.mcap",
        "--pad",
        "openeit-lattice",
    ];
    let output = gelpad(folder, &arguments);
    let text = said(&output);
    ensure!(output.status.code() == Some(0), "{text}");
    ensure!(text.contains("--pad is ignored"), "{text}");
    Ok(())
}

/// With a pad of other readings no frame can be saved: that is an error, and what was saved before stays.
fn refuses_another_pad(folder: &Path) -> Result<()> {
    let before = fs::read(folder.join("saved.mcap"))?;
    let arguments = [
        "recover",
        "damaged.mcap",
        "-o",
        "saved.mcap",
        "--pad",
        "openeit-lattice",
    ];
    let output = gelpad(folder, &arguments);
    let text = said(&output);
    ensure!(output.status.code() == Some(1), "{:?}", output.status);
    ensure!(text.contains("only 0 frames can be read"), "{text}");
    // What helps is said, too.
    ensure!(text.contains("recover --pad` names another"), "{text}");
    ensure!(
        fs::read(folder.join("saved.mcap"))? == before,
        "the file was replaced"
    );
    Ok(())
}
