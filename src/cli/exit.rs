//! Renders errors and turns the end of a command into an exit code.

use std::io::Write as _;
use std::process::ExitCode;

use miette::{
    GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteDiagnostic, NamedSource, Report,
    Severity,
};

use super::message::{Stderr, say};
use crate::app::AppError;
use crate::files::FileError;
use crate::types::{Diagnostic, SourceErrors, printable, printable_in_place};

/// Mistakes of one text that are drawn; the others are counted.
const MOST_DRAWN: usize = 20;
/// Longest line that is drawn with a mistake in it, bytes.
const DRAWN_LINE_BYTES: usize = 1000;

/// How a command ended that did not fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ending {
    /// Success.
    Done,
    /// It finished, but data was lost; a message has said which.
    LostData,
    /// A signal ended it (2: Ctrl-C, 15: SIGTERM, 1: closed terminal); all keys are released.
    Signal(i32),
}

/// Prints the error, if there is one; returns the exit code.
pub(super) fn code(outcome: anyhow::Result<Ending>) -> ExitCode {
    match outcome {
        Ok(Ending::Done) => ExitCode::SUCCESS,
        Ok(Ending::LostData) => ExitCode::from(3),
        Ok(Ending::Signal(signal)) => ExitCode::from(128 + signal as u8),
        Err(error) if is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            print(&error);
            ExitCode::FAILURE
        }
    }
}

/// Whether the reader of stdout has closed the pipe, as `head` does: no failure.
fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| {
        let of_file = match cause.downcast_ref::<AppError>() {
            Some(AppError::Write(error)) => Some(error),
            _ => cause.downcast_ref::<FileError>(),
        };
        let of_stream = cause.downcast_ref::<std::io::Error>();
        of_file.is_some_and(FileError::is_closed_pipe)
            || of_stream.is_some_and(|io| io.kind() == std::io::ErrorKind::BrokenPipe)
    })
}

fn print(error: &anyhow::Error) {
    match source_errors(error) {
        // Nothing can be done about a closed stderr.
        Some(errors) => drop(write!(Stderr, "{}", render_errors(errors))),
        None => say(&format!("error: {error:#}")),
    }
}

/// The mistakes in a text, if an error consists of them.
fn source_errors(error: &anyhow::Error) -> Option<&SourceErrors> {
    match error.downcast_ref::<AppError>() {
        Some(AppError::Text(errors)) => Some(errors),
        _ => error.downcast_ref(),
    }
}

/// Prints the warnings about a text.
pub(super) fn warn(warnings: &SourceErrors) {
    let text = render(warnings, Severity::Warning);
    let _ = write!(Stderr, "{text}");
}

/// The mistakes in a text, each drawn under its line.
pub(super) fn render_errors(errors: &SourceErrors) -> String {
    render(errors, Severity::Error)
}

/// Whether the text around a mistake can be drawn: the renderer cannot count columns beyond 65,535, and nobody reads a line
/// of that length.
fn is_drawable(text: &str, fault: &Diagnostic) -> bool {
    let bytes = text.as_bytes();
    let end = fault.span.end.min(bytes.len());
    let start = fault.span.start.min(end);
    let line_start = |at: usize| {
        let newline = bytes[..at].iter().rposition(|byte| *byte == b'\n');
        newline.map_or(0, |newline| newline + 1)
    };
    let line_end = |at: usize| {
        let newline = bytes[at..].iter().position(|byte| *byte == b'\n');
        newline.map_or(bytes.len(), |newline| at + newline)
    };
    // The lines of the mistake and one on each side.
    let first = line_start(line_start(start).saturating_sub(1));
    let last = line_end((line_end(end) + 1).min(bytes.len()));
    let mut lines = bytes[first..last].split(|byte| *byte == b'\n');
    lines.all(|line| line.len() <= DRAWN_LINE_BYTES)
}

fn render(errors: &SourceErrors, severity: Severity) -> String {
    use std::io::IsTerminal as _;

    let name = printable(&errors.name);
    let drawn = printable_in_place(&errors.text);
    let theme = if std::io::stderr().is_terminal() {
        GraphicalTheme::unicode()
    } else {
        GraphicalTheme::unicode_nocolor()
    };
    let handler = GraphicalReportHandler::new_themed(theme).with_links(false);
    let mut text = String::new();
    for fault in errors.diagnostics.iter().take(MOST_DRAWN) {
        let (line, column) = errors.line_column(fault.span.start);
        let message = printable(&fault.message);
        let title = format!("{name}:{line}:{column}: {message}");
        let mut diagnostic = MietteDiagnostic::new(title).with_severity(severity);
        diagnostic.help = fault
            .help
            .as_deref()
            .map(|help| printable(help).into_owned());
        let report = if is_drawable(&errors.text, fault) {
            let label = printable(&fault.label).into_owned();
            diagnostic =
                diagnostic.with_label(LabeledSpan::new_with_span(Some(label), fault.span.clone()));
            let source = NamedSource::new(&name, drawn.clone().into_owned());
            Report::new(diagnostic).with_source_code(source)
        } else {
            Report::new(diagnostic)
        };
        // Writing to a String cannot fail.
        let _ = handler.render_report(&mut text, report.as_ref());
    }
    if let Some(more) = errors.diagnostics.len().checked_sub(MOST_DRAWN + 1) {
        text.push_str(&format!("  and {} more\n", more + 1));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::{Profile, SHIPPED_PROFILES};

    fn rendered(text: &str, span: std::ops::Range<usize>) -> String {
        let fault = Diagnostic::new(span, "wrong \u{1b}[31m", "here \u{7}");
        render_errors(&SourceErrors::new("f\u{1b}.toml", text, vec![fault]))
    }

    #[test]
    fn a_mistake_far_to_the_right_is_reported_without_its_line() {
        for length in [998, 999, 1000, 1001, 65_529, 65_536, 200_000] {
            let text = format!("x = 1\n{}!\ny = 2\n", "a".repeat(length));
            let at = 6 + length;
            let said = rendered(&text, at..at + 1);
            assert!(said.contains(&format!(":2:{}:", length + 1)), "{said:.200}");
            assert_eq!(said.contains("y = 2"), length < 1000, "{length}");
            rendered(&text, 0..text.len());
            rendered(&text, at..at);
            rendered(&text, text.len()..text.len() + 9);
        }
    }

    #[test]
    fn no_control_character_reaches_the_terminal() {
        let said = rendered("a = \u{1b}]0;x\u{7}\u{9b}\n", 4..5);
        let harmful = |c: char| c.is_control() && c != '\n';
        assert!(!said.chars().any(harmful), "{said:?}");
    }

    /// Texts as an editor, or damage, may leave them: whatever is saved during play, reading and drawing it ends.
    /// `GELPAD_MUTATIONS` sets the number.
    #[test]
    fn no_text_of_a_user_ends_play() {
        let count = std::env::var("GELPAD_MUTATIONS").ok();
        let count = count.and_then(|text| text.parse().ok()).unwrap_or(300);
        let mut state = 7_u64;
        let mut below = |end: usize| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % end.max(1)
        };
        let pieces: [&[u8]; 8] = [
            b"\n",
            b"\"",
            b"[[region]]\n",
            b"\x1b[31m",
            b"=",
            b"\xf0\x9f\x98\x80",
            b"1e999",
            b"\0",
        ];
        for _ in 0..count {
            let shipped = &SHIPPED_PROFILES[below(SHIPPED_PROFILES.len())];
            let mut bytes = shipped.toml.as_bytes().to_vec();
            for _ in 0..=below(4) {
                let at = below(bytes.len());
                match below(5) {
                    0 => bytes.truncate(at),
                    1 => drop(bytes.drain(at..(at + below(40)).min(bytes.len()))),
                    2 => drop(bytes.splice(at..at, pieces[below(pieces.len())].iter().copied())),
                    3 => drop(bytes.splice(at..at, vec![b'x'; 70_000])),
                    _ => bytes
                        .iter_mut()
                        .skip(at)
                        .take(1)
                        .for_each(|byte| *byte ^= 1 << below(8)),
                }
            }
            let text = String::from_utf8_lossy(&bytes).into_owned();
            let errors = match Profile::from_toml("mine.toml", &text) {
                Ok(_) => continue,
                Err(errors) => errors,
            };
            let said = render_errors(&errors);
            let harmful = |c: char| c.is_control() && !matches!(c, '\n' | '\t');
            assert!(!said.chars().any(harmful), "{said:?}");
        }
    }

    #[test]
    fn many_mistakes_are_counted() {
        let fault = |at: usize| Diagnostic::new(at..at + 1, "wrong", "here");
        let text = "x".repeat(50);
        let errors = SourceErrors::new("f", &text, (0..50).map(fault).collect());
        assert!(render_errors(&errors).ends_with("  and 30 more\n"));
    }
}
