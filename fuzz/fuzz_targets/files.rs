//! Any bytes are a file of frames or are refused with a message, quickly and with little memory; frames have
//! the pad's channels, finite values and times that never run backwards. The first byte chooses the start of
//! the file:
//! `cargo fuzz run -s none files -- -max_len=1024 -dict=fuzz/files.dict`
//! (with RUSTC_BOOTSTRAP=1 without a nightly compiler). Files go through `TMPDIR`, which should be in memory,
//! as in `scripts/fuzz.sh`.

#![no_main]

use std::fs;
use std::path::PathBuf;
use std::sync::OnceLock;

use gelpad::pad::{Pad, shipped_pad};
use gelpad::source::{SourceReading, open_file};
use libfuzzer_sys::fuzz_target;

/// A valid `.eit` header.
const EIT_HEADER: &[u8] = b"12\n2\nsetup\n2025\n1e4\n1e4\n1\n1\n0.005\n20.0\n0\n1\n";
/// A valid CSV header for [`pad`].
const CSV_HEADER: &[u8] = b"t_ms,v0,v1,v2,v3,v4,v5,v6,v7,v8,v9\n";

/// A pad with short frames, which mutations reach: five electrodes, ten voltages.
fn pad() -> &'static Pad {
    static PAD: OnceLock<Pad> = OnceLock::new();
    PAD.get_or_init(|| {
        let tank = shipped_pad("round-tank").expect("shipped").toml;
        let toml = tank.replace("count = 16", "count = 5");
        Pad::from_toml("fuzzed", &toml).expect("sound")
    })
}

/// Path of the file with an extension.
fn path(ending: &str) -> PathBuf {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let folder = std::env::temp_dir().join(format!("gelpad-fuzz-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        folder
    });
    folder.join("fuzzed").with_extension(ending)
}

fuzz_target!(|bytes: &[u8]| {
    let Some((choice, bytes)) = bytes.split_first() else {
        return;
    };
    let (ending, header): (&str, &[u8]) = match choice % 5 {
        0 => ("csv", b""),
        1 => ("csv", CSV_HEADER),
        2 => ("eit", b""),
        3 => ("eit", EIT_HEADER),
        _ => ("txt", b"% a table\n"),
    };
    let path = path(ending);
    fs::write(&path, [header, bytes].concat()).expect("written");
    let mut source = match open_file(&path, pad()) {
        Ok(source) => source,
        Err(error) => {
            assert!(!error.to_string().is_empty());
            return;
        }
    };
    let mut last_ns = 0;
    // A frame takes at least one byte of the file.
    for _ in 0..=header.len() + bytes.len() {
        match source.read() {
            Ok(SourceReading::Frame(frame)) => {
                assert_eq!(frame.volts.len(), pad().channels());
                assert!(frame.volts.iter().all(|volt| volt.is_finite()));
                assert!(frame.t_ns >= last_ns);
                last_ns = frame.t_ns;
            }
            Ok(SourceReading::End) | Err(_) => return,
            Ok(_) => {}
        }
    }
    panic!("no end of frames");
});
