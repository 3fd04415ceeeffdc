//! Recommended settings in words, and as the text of the file that is saved.

use egui::Ui;

use crate::calibrate::recommend::{Recommendation, RecommendedSettings, TrialScore};

/// Draws the settings as a table; their text can be opened below.
pub(super) fn draw(ui: &mut Ui, found: &Recommendation) {
    let grid = egui::Grid::new("recommended").num_columns(2);
    grid.spacing([14.0, 3.0]).show(ui, |ui| {
        for (name, value) in rows(&found.overlay) {
            ui.weak(name);
            ui.label(value);
            ui.end_row();
        }
    });
    egui::CollapsingHeader::new("As text").show(ui, |ui| {
        let text = found.toml();
        ui.add(
            egui::TextEdit::multiline(&mut text.as_str())
                .code_editor()
                .desired_rows(6)
                .desired_width(f32::INFINITY),
        );
    });
}

fn rows(settings: &RecommendedSettings) -> Vec<(&'static str, String)> {
    let ms_or_off = |ms: u32| match ms {
        0 => "off".to_owned(),
        ms => format!("{ms} ms"),
    };
    let tremor = match settings.tremor_ms {
        0 => "off".to_owned(),
        ms => format!("{ms} ms, {} mm", settings.tremor_mm),
    };
    let moment = match settings.when_decided {
        true => "when it is known to be short or long",
        false => "at once",
    };
    let mut rows = vec![
        ("A press is long from", format!("{} ms", settings.long_ms)),
        ("A press is sent", moment.to_owned()),
        ("Tremor filter", tremor),
        ("Slow keys", ms_or_off(settings.slow_keys_ms)),
        ("Bounce keys", ms_or_off(settings.bounce_keys_ms)),
    ];
    if let Some(ms) = settings.double_tap_ms {
        rows.push(("Longest pause in a double tap", format!("{ms} ms")));
    }
    if let Some([least, most]) = settings.force_range {
        let text = format!("{least:.2} counts as none, {most:.2} as full");
        rows.push(("Force", text));
    }
    rows
}

/// What the presses come out as with the settings of now and with those found. `person` names the settings of now.
pub(super) fn outcome_words(found: &Recommendation, person: Option<&str>) -> String {
    let (before, after) = (&found.before, &found.after);
    let percent = |score: &TrialScore| score.share() * 100.0;
    let now = match person {
        Some(person) => format!("with the settings of {person}"),
        None => "before".to_owned(),
    };
    let now = now.as_str();
    let mut words = format!(
        "{:.0} % of your presses were right {now}, {:.0} % with the new settings",
        percent(before),
        percent(after)
    );
    if before.wrong > 0 || after.wrong > 0 {
        words.push_str(&format!(
            "; unintended: {} {now}, {} with the new ones",
            before.wrong, after.wrong
        ));
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> RecommendedSettings {
        RecommendedSettings {
            long_ms: 350,
            when_decided: false,
            tremor_ms: 0,
            tremor_mm: 4,
            slow_keys_ms: 120,
            bounce_keys_ms: 0,
            double_tap_ms: Some(450),
            force_range: None,
        }
    }

    #[test]
    fn settings_are_told_in_words() {
        let rows = rows(&settings());
        let value = |name: &str| {
            let row = rows.iter().find(|row| row.0 == name);
            row.map(|row| row.1.as_str())
        };
        assert_eq!(value("Slow keys"), Some("120 ms"));
        assert_eq!(value("Tremor filter"), Some("off"));
        assert_eq!(value("Longest pause in a double tap"), Some("450 ms"));
        assert_eq!(value("Force"), None);
    }

    #[test]
    fn the_settings_of_now_are_named() {
        let score = |right| TrialScore {
            requested: 24,
            right,
            wrong: 0,
        };
        let found = Recommendation {
            overlay: settings(),
            before: score(12),
            after: score(24),
        };
        assert_eq!(
            outcome_words(&found, Some("tremor")),
            "50 % of your presses were right with the settings of tremor, 100 % with the new settings"
        );
    }
}
