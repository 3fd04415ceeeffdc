//! Changes since the last report of a device.

use evdev::{EventType, InputEvent};

/// Changes that are sent together.
#[derive(Debug, Default)]
pub(super) struct Report {
    changes: Vec<InputEvent>,
}

impl Report {
    /// Adds a change. If the key is in the report already, returns that report, which must be sent first.
    pub(super) fn add(
        &mut self,
        kind: EventType,
        code: u16,
        value: i32,
    ) -> Option<Vec<InputEvent>> {
        let known = self
            .changes
            .iter()
            .position(|change| change.event_type() == kind && change.code() == code);
        let before = match (known, kind) {
            (Some(_), EventType::KEY) => Some(self.take()),
            (Some(index), EventType::RELATIVE) => {
                let sum = self.changes[index].value().saturating_add(value);
                self.changes[index] = InputEvent::new(kind.0, code, sum);
                return None;
            }
            (Some(index), _) => {
                self.changes[index] = InputEvent::new(kind.0, code, value);
                return None;
            }
            (None, _) => None,
        };
        self.changes.push(InputEvent::new(kind.0, code, value));
        before
    }

    /// The changes; the report is empty afterwards.
    pub(super) fn take(&mut self) -> Vec<InputEvent> {
        std::mem::take(&mut self.changes)
    }

    /// Whether nothing has changed.
    pub(super) fn is_empty(&self) -> bool {
        self.changes.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changes_of(changes: &[InputEvent]) -> Vec<(u16, i32)> {
        changes
            .iter()
            .map(|change| (change.code(), change.value()))
            .collect()
    }

    #[test]
    fn a_key_changes_once_a_report_and_motions_add_up() {
        let mut report = Report::default();
        assert!(report.add(EventType::KEY, 30, 1).is_none());
        assert!(report.add(EventType::KEY, 31, 1).is_none());
        assert!(report.add(EventType::RELATIVE, 30, 4).is_none());
        assert!(report.add(EventType::RELATIVE, 30, -1).is_none());
        assert!(report.add(EventType::ABSOLUTE, 0, 100).is_none());
        assert!(report.add(EventType::ABSOLUTE, 0, 90).is_none());
        let first = report
            .add(EventType::KEY, 30, 0)
            .expect("must go out first");
        assert_eq!(changes_of(&first), [(30, 1), (31, 1), (30, 3), (0, 90)]);
        assert_eq!(changes_of(&report.take()), [(30, 0)]);
        assert!(report.is_empty());
    }
}
