//! The expected events of a recording: a text beside it, with a line an event, as `gelpad replay FILE --print events` prints them and
//! `--expect` compares them.

use std::path::{Path, PathBuf};

use crate::gui::edit::write_atomically;

/// The file of the expected events of a recording.
pub(super) fn expected_file(recording: &Path) -> PathBuf {
    recording.with_extension("events")
}

/// Whether the saved expected events differ from these.
pub(super) fn differ(recording: &Path, events: &[String]) -> bool {
    let text = std::fs::read_to_string(expected_file(recording));
    text.is_ok_and(|text| {
        !text
            .lines()
            .map(str::trim_end)
            .eq(events.iter().map(String::as_str))
    })
}

/// Writes the events; returns a message with the command that compares them.
pub(super) fn save(recording: &Path, events: &[String]) -> String {
    let file = expected_file(recording);
    let mut text = events.join("\n");
    if !text.is_empty() {
        text.push('\n');
    }
    match write_atomically(&file, &text) {
        Ok(()) => format!(
            "Saved {} events. In a script: gelpad replay {} --expect {}",
            events.len(),
            recording.display(),
            file.display()
        ),
        Err(error) => error.to_string(),
    }
}

/// Compares the events with the saved ones; returns a message.
pub(super) fn check(recording: &Path, events: &[String]) -> String {
    let file = expected_file(recording);
    let text = match std::fs::read_to_string(&file) {
        Ok(text) => text,
        Err(error) => {
            return format!(
                "{}: {error}: save the expected events first",
                file.display()
            );
        }
    };
    let expected: Vec<&str> = text.lines().map(str::trim_end).collect();
    let length = expected.len().max(events.len());
    let difference = (0..length)
        .find(|line| expected.get(*line).copied() != events.get(*line).map(String::as_str));
    let Some(line) = difference else {
        return format!("✔ All {} events are as expected", events.len());
    };
    let was = expected.get(line).copied().unwrap_or("no more");
    let is = events.get(line).map_or("no more", String::as_str);
    format!("✖ Line {} differs: expected {was}, replayed {is}", line + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn saved_events_are_compared_line_by_line() {
        let folder = tempfile::tempdir().expect("a folder");
        let recording = folder.path().join("session.mcap");
        let lines = |texts: &[&str]| {
            texts
                .iter()
                .map(|text| (*text).to_owned())
                .collect::<Vec<_>>()
        };
        let events = lines(&["500.000 press key:f", "800.000 release key:f"]);
        assert!(check(&recording, &events).contains("save the expected events first"));
        assert!(!differ(&recording, &events), "nothing is lost");
        assert!(save(&recording, &events).starts_with("Saved 2 events"));
        assert!(!differ(&recording, &events) && differ(&recording, &events[..1]));
        assert!(check(&recording, &events).starts_with("✔ All 2"));
        let shorter = check(&recording, &events[..1]);
        assert!(
            shorter.contains("Line 2") && shorter.contains("no more"),
            "{shorter}"
        );
        let other = lines(&["500.000 press key:f", "810.000 release key:f"]);
        assert!(check(&recording, &other).contains("expected 800.000 release key:f"));
    }
}
