//! The panic gesture: many contacts at once. It is detected before the profile sees the touches. Contacts over
//! `rest_area_mm2` do not count: a forearm may appear as several.

use crate::profile::Settings;
use crate::types::{Phase, Touch, TouchId};

/// Most contacts that are counted.
const MOST_CONTACTS: usize = 32;

/// Counts contacts.
#[derive(Clone, Debug)]
pub(super) struct PanicDetector {
    /// None if switched off.
    contacts: Option<usize>,
    rest_area_mm2: f64,
    down: Vec<TouchId>,
    /// It was detected; every contact must lift before the next panic.
    is_triggered: bool,
}

impl PanicDetector {
    pub(super) fn new(settings: &Settings) -> Self {
        Self {
            contacts: settings.panic_contacts,
            rest_area_mm2: settings.rest_area_mm2.unwrap_or(f64::INFINITY),
            down: Vec::with_capacity(MOST_CONTACTS),
            is_triggered: false,
        }
    }

    /// The same contacts, under another profile.
    pub(super) fn with_settings(self, settings: &Settings) -> Self {
        Self {
            down: self.down,
            is_triggered: self.is_triggered,
            ..Self::new(settings)
        }
    }

    /// Forgets all contacts.
    pub(super) fn clear(&mut self) {
        self.down.clear();
        self.is_triggered = false;
    }

    /// Whether this change makes it a panic.
    pub(super) fn update(&mut self, touch: &Touch) -> bool {
        let rests = touch.contact.area_mm2 > self.rest_area_mm2;
        if touch.phase == Phase::Up || rests {
            self.down.retain(|id| *id != touch.id);
            self.is_triggered &= !self.down.is_empty();
            return false;
        }
        if touch.phase == Phase::Down && self.down.len() < MOST_CONTACTS {
            self.down.push(touch.id);
        }
        let many = self
            .contacts
            .is_some_and(|contacts| self.down.len() >= contacts);
        let starts = many && !self.is_triggered && touch.phase == Phase::Down;
        self.is_triggered |= starts;
        starts
    }
}
