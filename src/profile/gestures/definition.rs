//! What each gesture defines about how it is written.

use crate::profile::entries::Entries;
use crate::profile::keys::{CountKey, Key, NumberKey, Table, WordKey};
use crate::profile::reader::Reader;
use crate::profile::settings::Settings;
use crate::profile::target::Target;
use crate::types::{Axis, Nanos, nanos_from_ms};

/// How a gesture is written in a profile.
pub(super) trait GestureDefinition: Sized {
    /// Its keys in a binding. Those of [`Table::Setting`] may stand at the top of a profile too.
    const KEYS: &'static [Key] = &[];
    /// The key that names the binding's targets, if it must have some.
    const OUTPUT: Option<&'static str> = Some("output");
    /// Whether `mode` may say how its targets are driven.
    const TAKES_MODE: bool = true;
    /// Whether it needs a region or a stick, whose centre it measures from.
    const NEEDS_CENTRE: bool = false;
    /// Which parts of a gamepad can make it.
    const PLAYED_FROM: PlayedFrom = PlayedFrom::AnyPart;

    /// Reads it from a binding; none after a mistake that leaves nothing to go on with.
    fn read(binding: &mut BindingReader<'_>) -> Option<Self>;

    /// What the touch must do, in a few words.
    fn describe(&self) -> String;

    /// What is driven besides the binding's targets while a touch is held.
    fn hold_targets(&self) -> &[Target] {
        &[]
    }

    /// All that is driven besides the binding's targets.
    fn own_targets(&self) -> Vec<Target> {
        self.hold_targets().to_vec()
    }

    /// Names of what is driven besides the binding's targets.
    fn output_names(&self, name_of: &dyn Fn(Target) -> String) -> Vec<String> {
        self.own_targets().into_iter().map(name_of).collect()
    }

    /// Why no touch can make it under these settings, if so.
    fn never_fires(&self, _settings: &Settings) -> Option<Warning> {
        None
    }
}

/// The parts of a gamepad that can make a gesture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::profile) enum PlayedFrom {
    AnyPart,
    /// None: only touches can.
    TouchesOnly,
    Sticks,
    /// Parts that are pressed: buttons and triggers.
    Pressed,
}

/// Why a binding can never fire, and what to do about it.
pub(in crate::profile) type Warning = (&'static str, Option<&'static str>);

/// Reads the values of one binding.
pub(in crate::profile) struct BindingReader<'a> {
    pub reader: &'a mut Reader,
    /// The top of the profile, for keys that the binding leaves out.
    pub top: &'a Entries,
    pub entries: &'a Entries,
    /// Regions and parts of gamepads that it names.
    pub places: usize,
}

impl BindingReader<'_> {
    pub(in crate::profile) fn has(&self, key: &str) -> bool {
        self.entries.has(key)
    }

    /// The binding's own number.
    pub(in crate::profile) fn own_number(&mut self, key: &Key) -> Option<f64> {
        self.reader.number(self.entries, key)
    }

    /// The binding's number; else that of the profile, where the key may stand there; else the default.
    pub(in crate::profile) fn number(&mut self, key: &NumberKey) -> f64 {
        let own = self.own_number(&key.key);
        let inherited = match (own, key.key.table) {
            (None, Table::Setting) => self.reader.number(self.top, &key.key),
            _ => own,
        };
        inherited.unwrap_or(key.default)
    }

    /// As [`Self::number`], of milliseconds.
    pub(in crate::profile) fn time(&mut self, key: &NumberKey) -> Nanos {
        nanos_from_ms(self.number(key))
    }

    pub(in crate::profile) fn count(&mut self, key: &CountKey) -> u32 {
        self.reader.count_or_default(self.entries, key)
    }

    pub(in crate::profile) fn choice<T: Copy>(&mut self, key: &WordKey<T>) -> T {
        self.reader.choice_or_default(self.entries, key)
    }

    pub(in crate::profile) fn axis(&mut self, key: &Key) -> Option<Axis> {
        self.reader.axis(self.entries, key.name)
    }

    pub(in crate::profile) fn targets(&mut self, key: &Key) -> Vec<Target> {
        self.reader.targets(self.entries, key.name)
    }

    pub(in crate::profile) fn target(&mut self, key: &Key) -> Option<Target> {
        let (text, place) = self.reader.text(self.entries, key.name)?;
        self.reader.target(&text, &place)
    }

    /// Reports a mistake at a key, or at the binding if it does not have the key.
    pub(in crate::profile) fn mistake(&mut self, key: &str, message: &str, label: &str) {
        let place = self.entries.place_of(key);
        self.reader.errors.push(place, message, label);
    }

    /// As [`Self::mistake`], with what to do about it.
    pub(in crate::profile) fn mistake_with_help(
        &mut self,
        key: &str,
        message: &str,
        label: &str,
        help: &str,
    ) {
        let place = self.entries.place_of(key);
        self.reader.errors.help(place, message, label, help);
    }
}
