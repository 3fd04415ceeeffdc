//! The panic gesture: so many contacts at once. It is seen before the profile and whatever it does with touches.

use crate::types::{Phase, Touch};

/// Counts contacts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Panic {
    /// None: switched off.
    contacts: Option<usize>,
    down: usize,
    /// It was seen; every contact must lift before it is seen again.
    seen: bool,
}

impl Panic {
    pub(super) fn new(contacts: Option<usize>) -> Self {
        Self {
            contacts,
            down: 0,
            seen: false,
        }
    }

    /// The same contacts, under another profile.
    pub(super) fn with_count(self, contacts: Option<usize>) -> Self {
        Self { contacts, ..self }
    }

    /// Every contact is gone.
    pub(super) fn clear(&mut self) {
        *self = Self::new(self.contacts);
    }

    /// Whether this change is the one that makes it a panic.
    pub(super) fn sees(&mut self, touch: &Touch) -> bool {
        match touch.phase {
            Phase::Down => self.down += 1,
            Phase::Move => return false,
            Phase::Up => {
                self.down = self.down.saturating_sub(1);
                self.seen &= self.down > 0;
                return false;
            }
        }
        let panic = !self.seen && self.contacts.is_some_and(|contacts| self.down >= contacts);
        self.seen |= panic;
        panic
    }
}
