//! Gestures as profiles write them: one file each.
//!
//! To add a gesture, write two files and one line: `profile/gestures/NAME.rs` (its keys, how it is checked and
//! described), `gesture/recognizers/NAME.rs` (what it does), and a line in [`for_each_gesture`].

mod definition;
mod shared_keys;

pub(super) use definition::{BindingReader, PlayedFrom, Warning};

use super::keys::Key;
use super::settings::Settings;
use super::target::Target;
use definition::GestureDefinition;

/// Calls a macro with the list of all gestures: the word in a profile, the module here and in
/// `gesture/recognizers/`, the type, and its recognizer. The first is the default.
macro_rules! for_each_gesture {
    ($then:ident) => {
        $then! {
            "press" press Press PressRecognizer,
            "tap" tap Tap TapRecognizer,
            "hold" hold Hold HoldRecognizer,
            "double-tap" double_tap DoubleTap DoubleTapRecognizer,
            "triple-tap" triple_tap TripleTap TripleTapRecognizer,
            "swipe" swipe Swipe SwipeRecognizer,
            "chord" chord Chord ChordRecognizer,
            "contacts" contacts Contacts ContactsRecognizer,
            "force" force Force ForceRecognizer,
            "dpad" dpad Dpad DpadRecognizer,
            "stick" stick Stick StickRecognizer,
            "trigger" trigger Trigger TriggerRecognizer,
            "pointer" pointer Pointer PointerRecognizer,
            "tap-hold" tap_hold TapHold TapHoldRecognizer,
        }
    };
}
pub(crate) use for_each_gesture;

macro_rules! define_gestures {
    ($($word:literal $module:ident $Type:ident $Recognizer:ident,)+) => {
        $(mod $module;)+
        $(pub use $module::$Type;)+

        /// What a touch must do. Times and distances are half-open: a threshold counts as reached.
        #[derive(Clone, Debug, PartialEq)]
        pub enum Gesture {
            $(
                #[doc = concat!("`gesture = \"", $word, "\"`.")]
                $Type($Type),
            )+
        }

        impl Gesture {
            /// Its word in a profile.
            #[must_use]
            pub fn word(&self) -> &'static str {
                match self { $(Self::$Type(_) => $word,)+ }
            }

            /// What the touch must do, in a few words.
            #[must_use]
            pub fn describe(&self) -> String {
                match self { $(Self::$Type(own) => own.describe(),)+ }
            }

            /// What is driven besides the binding's targets while a touch is held; empty for most gestures.
            #[must_use]
            pub fn hold_targets(&self) -> &[Target] {
                match self { $(Self::$Type(own) => own.hold_targets(),)+ }
            }

            /// All that is driven besides the binding's targets.
            pub(super) fn own_targets(&self) -> Vec<Target> {
                match self { $(Self::$Type(own) => own.own_targets(),)+ }
            }

            /// Names of what is driven besides the binding's targets.
            pub(super) fn output_names(&self, name_of: &dyn Fn(Target) -> String) -> Vec<String> {
                match self { $(Self::$Type(own) => own.output_names(name_of),)+ }
            }

            /// Why no touch can make it under these settings, if so.
            pub(super) fn never_fires(&self, settings: &Settings) -> Option<Warning> {
                match self { $(Self::$Type(own) => own.never_fires(settings),)+ }
            }
        }

        /// The words of all gestures.
        pub(super) const WORDS: &[&str] = &[$($word),+];

        /// All gestures, in the order of [`WORDS`].
        pub(super) const LISTED: &[Listed] = &[$(Listed {
            word: $word,
            keys: $Type::KEYS,
            output: $Type::OUTPUT,
            takes_mode: $Type::TAKES_MODE,
            needs_centre: $Type::NEEDS_CENTRE,
            played_from: $Type::PLAYED_FROM,
            read: |binding| $Type::read(binding).map(Gesture::$Type),
        }),+];
    };
}

/// A gesture as the checks need it: see [`GestureDefinition`].
#[derive(Clone, Copy)]
pub(super) struct Listed {
    pub word: &'static str,
    pub keys: &'static [Key],
    pub output: Option<&'static str>,
    pub takes_mode: bool,
    pub needs_centre: bool,
    pub played_from: PlayedFrom,
    pub read: fn(&mut BindingReader<'_>) -> Option<Gesture>,
}

for_each_gesture!(define_gestures);

pub use shared_keys::Curve;
pub use stick::{DeadZone, Gains};
pub use swipe::Direction;

pub use tap_hold::Flavour;
