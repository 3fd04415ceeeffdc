//! Modes: how a binding drives its outputs.

use super::macros::{MACRO, TAP_MS};
use crate::profile::gestures::BindingReader;
use crate::profile::keys::{
    FRAMES, Key, MS, NumberKey, Table, WordKey, define_keys, number, time_ms, word,
};
use crate::profile::{Latch, Mode};
use crate::types::nanos_from_ms;

/// Frames per second of the NES (NTSC).
const NES_FRAMES_PER_S: f64 = 60.0988;

define_keys! {
    LONG_MS: NumberKey = time_ms("long_ms", 200.0, "a press that lasts this long is long, a shorter one short (mode classified)");
    SHORT_FRAMES: NumberKey = number("short_frames", Table::Setting, FRAMES, 5.0, "length of a short press, in frames of the NES");
    LONG_FRAMES: NumberKey = number("long_frames", Table::Setting, FRAMES, 32.0, "length of a long press, in frames of the NES");
    /// Whether a classified press goes down when its length is known.
    pub(super) CLASSIFY: WordKey<bool> = word("classify", Table::Setting, &["down", "decided"], &[false, true], "decided: mode classified presses when the length is known, a short press at the lift, a long one after long_ms; for people whose short presses take long");
    LENGTH_MS: NumberKey = number("length_ms", Table::Binding, MS, 100.0, "length of the press");
    TURBO_HZ: NumberKey = number("turbo_hz", Table::Binding, (0.1, 30.0, "Hz"), 8.0, "presses per second");
    REPEAT_DELAY_MS: NumberKey = time_ms("repeat_delay_ms", 500.0, "RepeatKeys: from the first press to the second (mode repeat)");
    REPEAT_MS: NumberKey = time_ms("repeat_ms", 100.0, "RepeatKeys: from each further press to the next");
}

/// A mode as the checks need it.
#[derive(Clone, Copy)]
pub(in crate::profile) struct Listed {
    pub word: &'static str,
    pub keys: &'static [Key],
    pub needs_output: bool,
    pub read: fn(&mut BindingReader<'_>) -> Option<Mode>,
}

const fn mode(
    word: &'static str,
    keys: &'static [Key],
    read: fn(&mut BindingReader<'_>) -> Option<Mode>,
) -> Listed {
    Listed {
        word,
        keys,
        needs_output: true,
        read,
    }
}

/// All modes; the first is the default.
pub(in crate::profile) const LISTED: &[Listed] = &[
    mode("direct", &[], |_| Some(Mode::Direct)),
    mode(
        "classified",
        &[LONG_MS.key, SHORT_FRAMES.key, LONG_FRAMES.key],
        read_classified,
    ),
    mode("latch", &[LENGTH_MS.key], |binding| {
        Some(Mode::Latch(binding.time(&LENGTH_MS)))
    }),
    mode("tap", &[TAP_MS.key], |binding| {
        Some(Mode::Latch(binding.time(&TAP_MS)))
    }),
    mode("toggle", &[], |_| Some(Mode::Toggle)),
    mode("turbo", &[TURBO_HZ.key], |binding| {
        let period_ns = nanos_from_ms(1000.0 / binding.number(&TURBO_HZ));
        Some(Mode::Turbo {
            first_ns: period_ns,
            period_ns,
        })
    }),
    mode("repeat", &[REPEAT_DELAY_MS.key, REPEAT_MS.key], read_repeat),
    mode("sticky", &[], |_| Some(Mode::Sticky)),
    Listed {
        needs_output: false,
        ..mode("macro", &[TAP_MS.key, MACRO], |binding| {
            binding.macro_steps().map(Mode::Macro)
        })
    },
];

/// The words of [`LISTED`].
pub(super) const WORDS: &[&str] = &{
    let mut words = [""; LISTED.len()];
    let mut index = 0;
    while index < words.len() {
        words[index] = LISTED[index].word;
        index += 1;
    }
    words
};

fn read_classified(binding: &mut BindingReader<'_>) -> Option<Mode> {
    let frames = |count: f64| nanos_from_ms(count * 1000.0 / NES_FRAMES_PER_S);
    let top = binding.top;
    Some(Mode::Classified(Latch {
        short_ns: frames(binding.number(&SHORT_FRAMES)),
        long_ns: frames(binding.number(&LONG_FRAMES)),
        long_after_ns: binding.time(&LONG_MS),
        when_decided: binding.reader.choice_or_default(top, &CLASSIFY),
    }))
}

fn read_repeat(binding: &mut BindingReader<'_>) -> Option<Mode> {
    let first_ns = binding.time(&REPEAT_DELAY_MS);
    let period_ns = binding.time(&REPEAT_MS);
    for (key, time_ns) in [("repeat_delay_ms", first_ns), ("repeat_ms", period_ns)] {
        let written = binding.entries.get(key).or_else(|| binding.top.get(key));
        if time_ns == 0
            && let Some(value) = written
        {
            let message = format!("`{key}` must be above 0 in mode repeat");
            let errors = &mut binding.reader.errors;
            errors.push(&value.place, message, "too short");
        }
    }
    Some(Mode::Turbo {
        first_ns: first_ns.max(1),
        period_ns: period_ns.max(1),
    })
}
