//! How a command ends: one place that prints an error and turns it into a code.

use std::io::Write as _;
use std::process::ExitCode;

use miette::{
    Diagnostic, GraphicalReportHandler, GraphicalTheme, LabeledSpan, NamedSource, Severity,
};

use crate::types::{Fault, Faulty};

/// How a command that did not fail has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ending {
    /// All went well.
    Done,
    /// It finished, but data was lost; what and how much has been said.
    LostData,
    /// A signal ended it (2: Ctrl-C, 15: SIGTERM); the keys are up.
    Signal(i32),
}

/// Prints what went wrong, if anything did, and gives the exit code.
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

/// Whoever read our output has enough: no failure of ours.
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
    let _ = match error.downcast_ref::<Faulty>() {
        Some(faulty) => write!(stderr, "{}", drawn(faulty, Severity::Error)),
        None => writeln!(stderr, "error: {error:#}"),
    };
}

/// Prints what is odd about a text that can be used.
pub(super) fn warn(faulty: &Faulty) {
    let _ = write!(
        std::io::stderr().lock(),
        "{}",
        drawn(faulty, Severity::Warning)
    );
}

/// Every fault under the user's own line.
pub(super) fn drawn(faulty: &Faulty, severity: Severity) -> String {
    use std::io::IsTerminal as _;

    let theme = if std::io::stderr().is_terminal() {
        GraphicalTheme::unicode()
    } else {
        GraphicalTheme::unicode_nocolor()
    };
    let handler = GraphicalReportHandler::new_themed(theme).with_links(false);
    let mut text = String::new();
    for fault in &faulty.faults {
        let (line, column) = faulty.line_column(fault.span.start);
        let shown = Shown {
            title: format!("{}:{line}:{column}: {}", faulty.name, fault.message),
            source: NamedSource::new(&faulty.name, faulty.text.clone()),
            fault,
            severity,
        };
        // Writing to a String cannot fail.
        let _ = handler.render_report(&mut text, &shown);
    }
    text
}

/// A fault as miette draws it.
#[derive(Debug)]
struct Shown<'a> {
    title: String,
    source: NamedSource<String>,
    fault: &'a Fault,
    severity: Severity,
}

impl std::fmt::Display for Shown<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.title)
    }
}

impl std::error::Error for Shown<'_> {}

impl Diagnostic for Shown<'_> {
    fn severity(&self) -> Option<Severity> {
        Some(self.severity)
    }

    fn help<'a>(&'a self) -> Option<Box<dyn std::fmt::Display + 'a>> {
        let help = self.fault.help.as_ref()?;
        Some(Box::new(help))
    }

    fn source_code(&self) -> Option<&dyn miette::SourceCode> {
        Some(&self.source)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let span = self.fault.span.clone();
        let label = LabeledSpan::new_with_span(Some(self.fault.label.clone()), span);
        Some(Box::new(std::iter::once(label)))
    }
}
