//! Renders errors and turns the end of a command into an exit code.

use std::io::Write as _;
use std::process::ExitCode;

use miette::{
    GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteDiagnostic, NamedSource, Report,
    Severity,
};

use crate::app::AppError;
use crate::types::SourceErrors;

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
        cause
            .downcast_ref::<std::io::Error>()
            .is_some_and(|io| io.kind() == std::io::ErrorKind::BrokenPipe)
    })
}

fn print(error: &anyhow::Error) {
    let mut stderr = std::io::stderr().lock();
    // Nothing can be done about a closed stderr.
    let _ = match source_errors(error) {
        Some(errors) => write!(stderr, "{}", render_errors(errors)),
        None => writeln!(stderr, "error: {error:#}"),
    };
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
    let _ = write!(std::io::stderr().lock(), "{text}");
}

/// The mistakes in a text, each drawn under its line.
pub(super) fn render_errors(errors: &SourceErrors) -> String {
    render(errors, Severity::Error)
}

fn render(errors: &SourceErrors, severity: Severity) -> String {
    use std::io::IsTerminal as _;

    let theme = if std::io::stderr().is_terminal() {
        GraphicalTheme::unicode()
    } else {
        GraphicalTheme::unicode_nocolor()
    };
    let handler = GraphicalReportHandler::new_themed(theme).with_links(false);
    let mut text = String::new();
    for fault in &errors.diagnostics {
        let (line, column) = errors.line_column(fault.span.start);
        let title = format!("{}:{line}:{column}: {}", errors.name, fault.message);
        let label = LabeledSpan::new_with_span(Some(fault.label.clone()), fault.span.clone());
        let mut diagnostic = MietteDiagnostic::new(title)
            .with_severity(severity)
            .with_label(label);
        diagnostic.help.clone_from(&fault.help);
        let source = NamedSource::new(&errors.name, errors.text.clone());
        let report = Report::new(diagnostic).with_source_code(source);
        // Writing to a String cannot fail.
        let _ = handler.render_report(&mut text, report.as_ref());
    }
    text
}
