//! The panic gesture: so many contacts at once. It is seen before the profile and whatever it does with touches; only what
//! rests (contacts over `rest_area_mm2`) does not count: a forearm may lie there as several.

use crate::profile::Settings;
use crate::types::{Phase, Touch, TouchId};

/// Contacts that are counted at most.
const MOST_CONTACTS: usize = 32;

/// Counts contacts.
#[derive(Clone, Debug)]
pub(super) struct Panic {
    /// None: switched off.
    contacts: Option<usize>,
    rest_area_mm2: f64,
    down: Vec<TouchId>,
    /// It was seen; every contact must lift before it is seen again.
    seen: bool,
}

impl Panic {
    pub(super) fn new(settings: &Settings) -> Self {
        Self {
            contacts: settings.panic_contacts,
            rest_area_mm2: settings.rest_area_mm2.unwrap_or(f64::INFINITY),
            down: Vec::with_capacity(MOST_CONTACTS),
            seen: false,
        }
    }

    /// The same contacts, under another profile.
    pub(super) fn under(self, settings: &Settings) -> Self {
        Self {
            down: self.down,
            seen: self.seen,
            ..Self::new(settings)
        }
    }

    /// Every contact is gone.
    pub(super) fn clear(&mut self) {
        self.down.clear();
        self.seen = false;
    }

    /// Whether this change is the one that makes it a panic.
    pub(super) fn sees(&mut self, touch: &Touch) -> bool {
        let rests = touch.contact.area_mm2 > self.rest_area_mm2;
        if touch.phase == Phase::Up || rests {
            self.down.retain(|id| *id != touch.id);
            self.seen &= !self.down.is_empty();
            return false;
        }
        if touch.phase == Phase::Down && self.down.len() < MOST_CONTACTS {
            self.down.push(touch.id);
        }
        let many = self
            .contacts
            .is_some_and(|contacts| self.down.len() >= contacts);
        let panic = many && !self.seen && touch.phase == Phase::Down;
        self.seen |= panic;
        panic
    }
}
