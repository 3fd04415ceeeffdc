//! Every dialect decodes any bytes as frames, garbled input or nothing, with bounded memory; frames have
//! finite values and a possible number of them. The first byte chooses the format and the length of the
//! pieces in which the rest arrives; `GELPAD_FUZZ_FORMAT` (a name of `--format`, or `auto`) sets the format
//! for all inputs:
//! `GELPAD_FUZZ_FORMAT=sciospec cargo fuzz run -s none wire -- -max_len=600 -dict=fuzz/wire.dict`
//! (with RUSTC_BOOTSTRAP=1 without a nightly compiler). `scripts/fuzz.sh` runs every decoder.

#![no_main]

use std::sync::OnceLock;

use gelpad::source::wire::{
    Auto, Decoded, Dialect, MOST_HELD_BYTES, MOST_VALUES, SHOWN_BYTES, WireFormat, Wiring,
};
use libfuzzer_sys::fuzz_target;

const STEP_NS: u64 = 300_000_000;

/// The format of all inputs: the outer option is none if each input chooses, the inner for `auto`.
fn chosen() -> Option<Option<WireFormat>> {
    static CHOSEN: OnceLock<Option<Option<WireFormat>>> = OnceLock::new();
    *CHOSEN.get_or_init(|| {
        let name = std::env::var("GELPAD_FUZZ_FORMAT").ok()?;
        let kind = WireFormat::ALL.into_iter().find(|kind| kind.name() == name);
        assert!(kind.is_some() || name == "auto", "no format {name:?}");
        Some(kind)
    })
}

fuzz_target!(|bytes: &[u8]| {
    let Some((choice, bytes)) = bytes.split_first() else {
        return;
    };
    let wiring = Wiring::adjacent(if choice & 8 == 0 { 16 } else { 32 });
    let kind = chosen().unwrap_or_else(|| WireFormat::ALL.get(usize::from(choice & 7)).copied());
    let mut dialect: Box<dyn Dialect> = match kind {
        Some(kind) => kind.dialect(&wiring, choice & 16 != 0),
        None => Box::new(Auto::new(wiring)),
    };
    let size = 1 + usize::from(choice >> 5) * 37;
    let mut decoded = Vec::new();
    let mut now_ns = 0;
    dialect.hand_up_readings();
    for piece in bytes.chunks(size) {
        dialect.feed(now_ns, piece, &mut decoded);
        assert!(dialect.held_bytes() <= MOST_HELD_BYTES);
        if let Some(command) = dialect.poll_command(now_ns) {
            assert!(!command.is_empty() && command.len() < 64);
        }
        now_ns += STEP_NS;
    }
    for one in &decoded {
        match one {
            Decoded::Frame(frame) => {
                assert!((1..=MOST_VALUES).contains(&frame.values.len()));
                assert!(frame.values.iter().all(|value| value.is_finite()));
                if let Some(listing) = &frame.listing {
                    assert_eq!(listing.len(), frame.values.len());
                }
            }
            Decoded::Readings(readings) => {
                assert!(readings.first + readings.values.len() <= MOST_VALUES);
                assert!(readings.values.iter().all(|value| value.is_finite()));
            }
            Decoded::Garbled { reason, bytes } => {
                assert!(!reason.is_empty() && bytes.len() <= SHOWN_BYTES);
            }
            Decoded::Note(text) => assert!(!text.is_empty()),
        }
    }
    dialect.reopened();
    assert!(dialect.held_bytes() <= MOST_HELD_BYTES);
});
