//! Compares the events with expected ones: a text with a line per event, or another recording.

use std::io::Write as _;
use std::path::Path;

use anyhow::{Context as _, bail};

use crate::app::recording::{is_recording, open_recording};
use crate::cli::args::ReplayArgs;
use crate::cli::exit::Ending;
use crate::files;
use crate::tape::RecordedItem;

use super::overrides::ReplayOverrides;

/// Equal lines shown before the first difference.
const CONTEXT_LINES: usize = 3;

/// Saves the events, or compares them; the error shows the first difference.
pub(super) fn save_or_compare(args: &ReplayArgs, lines: &[String]) -> anyhow::Result<()> {
    if let Some(path) = &args.update {
        return save(path, lines);
    }
    let Some(path) = &args.expect else {
        return Ok(());
    };
    if is_verified(args) {
        return Ok(());
    }
    let expected = expected_lines(path, args)?;
    let Some(index) = first_difference(&expected, lines, args.tolerance_ms) else {
        return Ok(());
    };
    let mut text = format!(
        "{}: the events differ at line {}\n",
        path.display(),
        index + 1
    );
    for line in &expected[index.saturating_sub(CONTEXT_LINES)..index] {
        text.push_str(&format!("    {line}\n"));
    }
    let shown = |line: Option<&String>| line.map_or("(no more)", String::as_str).to_owned();
    text.push_str(&format!("  - {}\n", shown(expected.get(index))));
    text.push_str(&format!("  + {}\n", shown(lines.get(index))));
    bail!(
        "{text}  - expected ({} events in total), + replayed ({})",
        expected.len(),
        lines.len()
    );
}

/// Whether `--expect` names the recording that is replayed and nothing of it is replaced: it was compared bit for bit while it was
/// played (`verify`). With replaced parts, the events are compared like those of any other recording.
fn is_verified(args: &ReplayArgs) -> bool {
    args.expect.as_deref() == Some(args.file.as_path())
        && ReplayOverrides::from_args(args).is_empty()
}

/// The first line that differs by more than the tolerance.
fn first_difference(expected: &[String], lines: &[String], tolerance_ms: f64) -> Option<usize> {
    let length = expected.len().max(lines.len());
    (0..length).find(|index| match (expected.get(*index), lines.get(*index)) {
        (Some(was), Some(is)) => !is_equal(was, is, tolerance_ms),
        _ => true,
    })
}

fn is_equal(was: &str, is: &str, tolerance_ms: f64) -> bool {
    let parts = |line: &str| {
        let (t_ms, rest) = line.split_once(' ')?;
        Some((t_ms.parse::<f64>().ok()?, rest.to_owned()))
    };
    match (parts(was), parts(is)) {
        // Times are written to the microsecond.
        (Some((t, action)), Some((u, other))) => {
            action == other && (t - u).abs() <= tolerance_ms + 1e-6
        }
        _ => was == is,
    }
}

/// The expected lines, limited to the replayed range of a recording.
fn expected_lines(path: &Path, args: &ReplayArgs) -> anyhow::Result<Vec<String>> {
    if !is_recording(path)? {
        let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
        let lines = text.lines().map(str::trim_end);
        return Ok(lines
            .filter(|line| !line.is_empty() && !line.starts_with('#'))
            .map(str::to_owned)
            .collect());
    }
    let (mut player, _) = open_recording(path)?;
    let range = args.from.unwrap_or(0.0)..=args.to.unwrap_or(f64::MAX);
    let mut lines = Vec::new();
    while let Some(played) = player.next().with_context(|| path.display().to_string())? {
        if let RecordedItem::Event(event) = played
            && range.contains(&(event.t_ns as f64 * 1e-9))
        {
            lines.push(event.to_string());
        }
    }
    Ok(lines)
}

fn save(path: &Path, lines: &[String]) -> anyhow::Result<()> {
    let mut text = lines.join("\n");
    if !text.is_empty() {
        text.push('\n');
    }
    Ok(files::write(path, text.as_bytes())?)
}

/// Writes the result as JUnit XML with one test case.
pub(super) fn write_junit(
    path: &Path,
    args: &ReplayArgs,
    outcome: &anyhow::Result<Ending>,
) -> anyhow::Result<()> {
    let mut xml = Vec::new();
    let failure = match outcome {
        Ok(Ending::Done) => None,
        Ok(Ending::LostData) => Some("the recording has lost data".to_owned()),
        Ok(Ending::Signal(signal)) => Some(format!("ended by signal {signal}")),
        Err(error) => Some(format!("{error:#}")),
    };
    let failures = usize::from(failure.is_some());
    let name = escaped(&args.file.display().to_string());
    writeln!(xml, r#"<?xml version="1.0" encoding="UTF-8"?>"#)?;
    writeln!(xml, r#"<testsuites tests="1" failures="{failures}">"#)?;
    writeln!(
        xml,
        r#"  <testsuite name="gelpad replay" tests="1" failures="{failures}">"#
    )?;
    writeln!(
        xml,
        r#"    <testcase classname="gelpad.replay" name="{name}">"#
    )?;
    if let Some(failure) = failure {
        let first = escaped(failure.lines().next().unwrap_or_default());
        writeln!(
            xml,
            r#"      <failure message="{first}">{}</failure>"#,
            escaped(&failure)
        )?;
    }
    writeln!(xml, "    </testcase>\n  </testsuite>\n</testsuites>")?;
    Ok(files::write(path, &xml)?)
}

fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for character in text.chars() {
        match character {
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '&' => escaped.push_str("&amp;"),
            '"' => escaped.push_str("&quot;"),
            '\n' | '\t' => escaped.push(character),
            // XML allows no other control characters.
            _ if character < ' ' => escaped.push('?'),
            _ => escaped.push(character),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(lines: &[&str]) -> Vec<String> {
        lines.iter().map(|line| (*line).to_owned()).collect()
    }

    #[test]
    fn times_within_the_tolerance_are_the_same() {
        let was = lines(&["1000.000 press key:f", "1080.000 release key:f"]);
        let is = lines(&["1000.000 press key:f", "1090.000 release key:f"]);
        assert_eq!(first_difference(&was, &was, 0.0), None);
        assert_eq!(first_difference(&was, &is, 0.0), Some(1));
        assert_eq!(first_difference(&was, &is, 10.0), None);
        assert_eq!(first_difference(&was, &is[..1], 10.0), Some(1));
        let other = lines(&["1000.000 press key:d"]);
        assert_eq!(first_difference(&other, &is, 1000.0), Some(0));
    }

    #[test]
    fn control_characters_and_markup_are_escaped() {
        assert_eq!(
            escaped("a<b>&\"c\"\u{1b}[m"),
            "a&lt;b&gt;&amp;&quot;c&quot;?[m"
        );
    }
}
