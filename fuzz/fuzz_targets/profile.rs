//! Any text is a valid profile or a list of mistakes with places inside the text; a valid one plays a few touches. Start from
//! the shipped ones: `cargo fuzz run -s none profile fuzz/corpus/profile profiles users`
//! (with RUSTC_BOOTSTRAP=1 without a nightly compiler).

#![no_main]

use std::sync::Arc;

use gelpad::gesture::Gestures;
use gelpad::profile::{Source, find_shipped, read};
use gelpad::types::{Contact, Phase, Touch, TouchId};
use libfuzzer_sys::fuzz_target;

/// Places of the touches, mm.
const PLACES: [[f64; 2]; 4] = [[10.0, 10.0], [50.0, 50.0], [80.0, 50.0], [99.0, 99.0]];

fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    let source = Source {
        name: "fuzzed".to_owned(),
        toml: text.to_owned(),
    };
    match read(source, None, &find_shipped) {
        Err(errors) => {
            assert!(!errors.diagnostics.is_empty());
            for diagnostic in &errors.diagnostics {
                // A place in a base is a place in the base's text, which is in the report.
                assert!(
                    errors.text.get(diagnostic.span.clone()).is_some(),
                    "{diagnostic:?}"
                );
                let _ = errors.line_column(diagnostic.span.start);
            }
        }
        Ok(checked) => {
            let mut gestures = Gestures::new(Arc::new(checked.profile), [100.0, 100.0]);
            let mut events = Vec::new();
            for (step, phase) in [Phase::Down, Phase::Move, Phase::Up]
                .into_iter()
                .enumerate()
            {
                for (finger, centre_mm) in PLACES.into_iter().enumerate() {
                    let touch = Touch {
                        id: TouchId(finger as u64),
                        phase,
                        since_ns: 0,
                        contact: Contact {
                            centre_mm,
                            area_mm2: 150.0,
                            force: 0.6,
                            confidence: 1.0,
                        },
                    };
                    gestures.touches(step as u64 * 100_000_000, &[touch], &mut events);
                }
            }
            gestures.release_all(1_000_000_000, &mut events);
            assert_eq!(gestures.held().count(), 0);
        }
    }
});
