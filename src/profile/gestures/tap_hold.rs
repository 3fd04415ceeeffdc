//! One output when tapped, another when held.

use super::definition::{BindingReader, GestureDefinition, Warning};
use super::shared_keys::TAPPING_TERM_MS;
use crate::profile::keys::{Key, KeyKind, NumberKey, Table, WordKey, define_keys, time_ms, word};
use crate::profile::settings::{Activate, Settings};
use crate::profile::target::Target;
use crate::types::{Nanos, ms_from_nanos};

define_keys! {
    TAP: Key = Key::new("tap", Table::Binding, KeyKind::Texts, "output of a tap");
    HOLD: Key = Key::new("hold", Table::Binding, KeyKind::Texts, "output of a hold");
    FLAVOUR: WordKey<Flavour> = word("flavour", Table::Binding, &["speculative", "tap-preferred", "balanced", "hold-preferred"], &[Flavour::Speculative, Flavour::TapPreferred, Flavour::Balanced, Flavour::HoldPreferred], "what decides between tap and hold");
    QUICK_TAP_MS: NumberKey = time_ms("quick_tap_ms", 0.0, "a touch sooner than this after a tap is a tap at once, for as long as it lasts");
    PRIOR_IDLE_MS: NumberKey = time_ms("require_prior_idle_ms", 0.0, "a touch sooner than this after any other press is a tap at once");
}

/// What decides between tap and hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flavour {
    /// Time only: a hold when the tapping term is over.
    TapPreferred,
    /// Also a hold when another touch came and went meanwhile.
    Balanced,
    /// Also a hold when another touch came meanwhile.
    HoldPreferred,
    /// The tap is pressed at once; the hold replaces it when the term is over.
    Speculative,
}

/// One output when tapped, another when held.
#[derive(Clone, Debug, PartialEq)]
pub struct TapHold {
    /// What decides.
    pub flavour: Flavour,
    /// The tapping term.
    pub term_ns: Nanos,
    /// A touch sooner than this after a tap is a tap at once, for as long as it lasts.
    pub quick_tap_ns: Nanos,
    /// A touch sooner than this after any other press is a tap at once.
    pub prior_idle_ns: Nanos,
    /// What the hold drives; the binding's targets are the tap's.
    pub hold: Vec<Target>,
}

impl GestureDefinition for TapHold {
    const KEYS: &'static [Key] = &[
        TAP,
        HOLD,
        FLAVOUR.key,
        TAPPING_TERM_MS.key,
        QUICK_TAP_MS.key,
        PRIOR_IDLE_MS.key,
    ];
    const OUTPUT: Option<&'static str> = Some("tap");
    const TAKES_MODE: bool = false;

    fn read(binding: &mut BindingReader<'_>) -> Option<Self> {
        if !binding.has("hold") {
            binding.mistake_with_help(
                "hold",
                "a tap-hold needs `hold`, the output when it is held",
                "this binding",
                "write `hold = \"key:left-shift\"`",
            );
        }
        Some(Self {
            flavour: binding.choice(&FLAVOUR),
            term_ns: binding.time(&TAPPING_TERM_MS),
            quick_tap_ns: binding.time(&QUICK_TAP_MS),
            prior_idle_ns: binding.time(&PRIOR_IDLE_MS),
            hold: binding.targets(&HOLD),
        })
    }

    fn describe(&self) -> String {
        format!(
            "tap, or hold for {} ms",
            ms_from_nanos(self.term_ns).round()
        )
    }

    fn hold_targets(&self) -> &[Target] {
        &self.hold
    }

    fn output_names(&self, name_of: &dyn Fn(Target) -> String) -> Vec<String> {
        let hold: Vec<String> = self.hold.iter().map(|target| name_of(*target)).collect();
        vec![format!("or {}", hold.join(" + "))]
    }

    fn never_fires(&self, settings: &Settings) -> Option<Warning> {
        (settings.activate == Activate::Up).then_some((
            "with `activate = \"up\"` a touch acts only when it lifts, so nothing is held",
            None,
        ))
    }
}
