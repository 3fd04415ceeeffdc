//! Recordings: arbitrary bytes, messages, blocks of frames, records after a valid beginning, and changed attachments are
//! read or refused, quickly and with little memory. A recording that is read makes an engine that takes frames.
//!
//! `cargo fuzz run -s none recording` (with RUSTC_BOOTSTRAP=1 without a nightly compiler).

#![no_main]

use std::io::Cursor;
use std::sync::OnceLock;

use crc::{CRC_32_ISO_HDLC, Crc};
use gelpad::engine::Input;
use gelpad::session::volts::VoltsDecoder;
use gelpad::session::{Message, ProfileTexts, Reader, Setup, TOPICS, Writer};
use gelpad::tape::RecordingPlayer;
use gelpad::types::Frame;
use libfuzzer_sys::fuzz_target;

/// More messages than an input can contain, even unpacked: the reader is in a loop.
const MOST_MESSAGES: usize = 1 << 20;

/// A recording up to its first message.
fn beginning() -> &'static [u8] {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    BYTES.get_or_init(|| {
        let setup = Setup {
            slim: None,
            pad: "schema = 1".to_owned(),
            profile: ProfileTexts {
                t_ns: 0,
                chain: Vec::new(),
                user: None,
            },
            calibration: None,
            sensing: b"gelpadS1".to_vec(),
            responses: None,
        };
        let mut bytes = Cursor::new(Vec::new());
        let mut writer = Writer::live(&mut bytes, &setup).expect("memory");
        writer.flush().expect("memory");
        // The writer would end the file.
        std::mem::forget(writer);
        bytes.into_inner()
    })
}

fn read(bytes: Vec<u8>) {
    if let Ok((mut reader, _)) = Reader::open(Cursor::new(bytes.clone())) {
        let mut messages = 0;
        while let Ok(Some(_)) = reader.next() {
            messages += 1;
            assert!(messages < MOST_MESSAGES);
        }
        assert!(matches!(reader.next(), Ok(None)), "the end is final");
    }
    if let Ok((mut reader, _)) = Reader::salvage(Cursor::new(bytes)) {
        let mut messages = 0;
        while let Ok(Some(_)) = reader.next() {
            messages += 1;
            assert!(messages < MOST_MESSAGES);
        }
    }
}

/// The attachments of a real recording.
fn attachments() -> &'static Setup {
    static SETUP: OnceLock<Setup> = OnceLock::new();
    SETUP.get_or_init(|| {
        let recording = include_bytes!("../../tests/data/recordings/version-1.mcap");
        let (_, setup) = Reader::open(Cursor::new(&recording[..])).expect("a recording");
        setup
    })
}

/// Overwrites parts of matrix and response table (eight bytes per edit: part, offset, value), corrects their checksums, and
/// plays frames with the engine that they make.
fn play_changed(edits: &[u8]) {
    const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);
    let mut setup = attachments().clone();
    let mut parts: Vec<&mut Vec<u8>> = vec![&mut setup.sensing];
    parts.extend(setup.responses.as_mut());
    let count = parts.len();
    for edit in edits.chunks_exact(8) {
        let part = &mut *parts[usize::from(edit[0]) % count];
        let offset = u32::from_le_bytes([edit[1], edit[2], edit[3], 0]) as usize;
        let at = offset % (part.len() - 8);
        part[at..at + 4].copy_from_slice(&edit[4..]);
    }
    for part in parts {
        let body = part.len() - 4;
        let sum = CRC.checksum(&part[..body]);
        part[body..].copy_from_slice(&sum.to_le_bytes());
    }
    let mut bytes = Cursor::new(Vec::new());
    let mut writer = Writer::live(&mut bytes, &setup).expect("memory");
    writer.flush().expect("memory");
    std::mem::forget(writer);
    let Ok((_, config)) = RecordingPlayer::open(Cursor::new(bytes.into_inner())) else {
        return;
    };
    let (mut engine, mut events) = (config.engine(), Vec::new());
    for frame in 0..16 {
        let volt = |channel: usize| {
            let touched = frame > 11 && channel % 3 == 0;
            1.0 + 0.001 * ((channel + frame) % 7) as f32 - 0.02 * f32::from(u8::from(touched))
        };
        let frame = Frame {
            t_ns: frame as u64 * 10_000_000,
            volts: (0..config.pad.channels()).map(volt).collect(),
        };
        engine.input(&Input::Frame(frame), &mut events);
    }
}

/// A record: its code, its length, its body.
fn record(code: u8, body: &[u8]) -> Vec<u8> {
    let mut record = vec![code];
    record.extend_from_slice(&(body.len() as u64).to_le_bytes());
    record.extend_from_slice(body);
    record
}

fuzz_target!(|bytes: &[u8]| {
    let Some((kind, bytes)) = bytes.split_first() else {
        return;
    };
    // Rarely, because an engine takes milliseconds to build.
    if *kind == u8::MAX {
        return play_changed(bytes);
    }
    match kind % 6 {
        0 => read([mcap_magic(), bytes].concat()),
        1 => read([beginning(), bytes].concat()),
        2 => {
            // Records in an unpacked chunk.
            let mut body = vec![0; 16];
            body.extend_from_slice(&(bytes.len() as u64).to_le_bytes());
            body.extend_from_slice(&[0; 8]);
            body.extend_from_slice(&(bytes.len() as u64).to_le_bytes());
            body.extend_from_slice(bytes);
            read([beginning(), &record(6, &body)].concat());
        }
        3 => {
            // A message of some topic.
            let Some((topic, payload)) = bytes.split_first() else {
                return;
            };
            let topic = TOPICS[usize::from(*topic) % TOPICS.len()];
            let mut decoder = VoltsDecoder::default();
            if let Ok(Some(message)) = Message::from_json(topic, payload, &mut decoder) {
                // A message survives a round trip.
                let again = message.to_json(None);
                let back = Message::from_json(topic, &again, &mut VoltsDecoder::default());
                assert_eq!(
                    back.map(|back| back.map(|back| back.to_json(None))),
                    Ok(Some(again))
                );
            }
        }
        4 => {
            let Some((count, block)) = bytes.split_first() else {
                return;
            };
            let _ = VoltsDecoder::default().decode(usize::from(*count), block);
        }
        _ => {
            let channel = [bytes.first().copied().unwrap_or(0) % 12 + 1, 0];
            let body = [&channel[..], &[0; 20], bytes].concat();
            read([beginning(), &record(5, &body)].concat());
        }
    }
});

fn mcap_magic() -> &'static [u8] {
    b"\x89MCAP0\r\n"
}
