//! Any bytes are a recording or are refused, soon and without much memory; so is any message, any block of frames, and whatever
//! follows an honest beginning: `cargo fuzz run -s none recording` (with RUSTC_BOOTSTRAP=1 where there is no nightly compiler).

#![no_main]

use std::io::Cursor;
use std::sync::OnceLock;

use gelpad::session::volts::Unpacker;
use gelpad::session::{Message, ProfileTexts, Reader, Setup, TOPICS, Writer};
use libfuzzer_sys::fuzz_target;

/// More than an input can hold, even unpacked: whoever gets so many messages runs in circles.
const MOST_MESSAGES: usize = 1 << 20;

/// A recording up to its first message.
fn beginning() -> &'static [u8] {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    BYTES.get_or_init(|| {
        let setup = Setup {
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
        assert!(matches!(reader.next(), Ok(None)), "an end is an end");
    }
    if let Ok((mut reader, _)) = Reader::salvage(Cursor::new(bytes)) {
        let mut messages = 0;
        while let Ok(Some(_)) = reader.next() {
            messages += 1;
            assert!(messages < MOST_MESSAGES);
        }
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
            let mut unpacker = Unpacker::default();
            if let Ok(Some(message)) = Message::from_json(topic, payload, &mut unpacker) {
                // What can be read can be written, and is then the same.
                let again = message.to_json(None);
                let back = Message::from_json(topic, &again, &mut Unpacker::default());
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
            let _ = Unpacker::default().unpack(usize::from(*count), block);
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
