//! `gelpad doctor`: checks whether this computer can play, and prints what to fix.

use std::io::{IsTerminal as _, Write as _};
use std::path::Path;

use anyhow::{Context as _, bail};
use crossterm::style::Stylize as _;

use super::args::DoctorArgs;
use super::exit::Ending;
use crate::doctor::{BoardAccess, CheckLine, CheckStatus, DoctorReport, check_this_computer, rule};

/// Width of the column with the state.
const WORD_WIDTH: usize = 7;

pub(super) fn run(args: &DoctorArgs) -> anyhow::Result<Ending> {
    let mut out = std::io::stdout().lock();
    if args.install_rule {
        if rule::RULE.is_empty() {
            bail!("udev rules belong to Linux: nothing needs to be installed here");
        }
        return install(&mut out);
    }
    let report = check_this_computer();
    let colours = std::io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    write!(out, "{}", report_text(&report, colours))?;
    if report.can_play() {
        return Ok(Ending::Done);
    }
    drop(out);
    bail!("play would not work here: {}", why_not(&report));
}

fn why_not(report: &DoctorReport) -> &'static str {
    match report.boards {
        BoardAccess::Unreadable if !report.outputs.is_empty() => "the board cannot be read",
        _ => {
            "no output reaches a game; fix one that is `wrong` above (--output trace works without)"
        }
    }
}

/// The report as text: a line per check with state, subject and finding, and below it how to fix a problem.
fn report_text(report: &DoctorReport, colours: bool) -> String {
    let lines = || report.sections.iter().flat_map(|section| &section.lines);
    let subject_width = lines()
        .map(|line| line.subject.chars().count())
        .max()
        .unwrap_or(0);
    let mut text = String::new();
    for section in &report.sections {
        let title = section.title;
        match colours {
            true => text.push_str(&format!("{}\n", title.bold())),
            false => text.push_str(&format!("{title}\n")),
        }
        for line in &section.lines {
            text.push_str(&line_text(line, subject_width, colours));
        }
        text.push('\n');
    }
    let outputs = report.outputs.join(", or ");
    text.push_str(&match report.outputs.len() {
        0 => "gelpad has no output on this computer.\n".to_owned(),
        _ => format!("gelpad can play through the {outputs}.\n"),
    });
    if lines().any(is_fixed_by_rule) {
        text.push_str(&format!(
            "\nThe rule that `gelpad doctor --install-rule` writes to {}:\n\n{}",
            rule::RULE_PATH,
            indented(rule::RULE)
        ));
    }
    text
}

fn is_fixed_by_rule(line: &CheckLine) -> bool {
    line.fix
        .as_ref()
        .is_some_and(|fix| fix.contains("--install-rule"))
}

fn line_text(line: &CheckLine, subject_width: usize, colours: bool) -> String {
    let word = match line.state {
        CheckStatus::Ok => "ok",
        CheckStatus::Note => "note",
        CheckStatus::Wrong => "wrong",
    };
    let padded = format!("{word:WORD_WIDTH$}");
    let word = match (colours, line.state) {
        (false, _) => padded,
        (true, CheckStatus::Ok) => padded.green().to_string(),
        (true, CheckStatus::Note) => padded.yellow().to_string(),
        (true, CheckStatus::Wrong) => padded.red().bold().to_string(),
    };
    let mut text = format!("  {word}{:subject_width$}  {}\n", line.subject, line.found);
    if let Some(fix) = &line.fix {
        let margin = WORD_WIDTH + subject_width + 4;
        text.push_str(&format!("{:margin$}-> {fix}\n", ""));
    }
    text
}

fn indented(text: &str) -> String {
    text.lines().map(|line| format!("    {line}\n")).collect()
}

/// Prints what will be done, then does it.
fn install(out: &mut impl std::io::Write) -> anyhow::Result<Ending> {
    writeln!(
        out,
        "This writes {}:\n\n{}",
        rule::RULE_PATH,
        indented(rule::RULE)
    )?;
    let commands: Vec<String> = rule::COMMANDS
        .iter()
        .map(|command| format!("    {}\n", command.join(" ")))
        .collect();
    writeln!(
        out,
        "and runs, to apply it immediately:\n\n{}",
        commands.concat()
    )?;
    out.flush()?;
    if let Err(error) = rule::write(Path::new("/")) {
        if error.kind() == std::io::ErrorKind::PermissionDenied {
            let own = std::env::current_exe();
            let own = own.map_or("gelpad".to_owned(), |path| path.display().to_string());
            bail!("only root can do this\n  help: sudo {own} doctor --install-rule");
        }
        return Err(error).context(rule::RULE_PATH);
    }
    let failed = rule::apply();
    if failed.is_empty() {
        writeln!(
            out,
            "Done. Unplug boards and plug them in again, then run `gelpad doctor`."
        )?;
    } else {
        writeln!(
            out,
            "Written, but udev did not apply it: it takes effect after a restart:"
        )?;
        for line in failed {
            writeln!(out, "    {line}")?;
        }
    }
    Ok(Ending::Done)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::ReportSection;

    fn line(state: CheckStatus, subject: &str, fix: Option<&str>) -> CheckLine {
        CheckLine {
            state,
            subject: subject.to_owned(),
            found: "found".to_owned(),
            fix: fix.map(str::to_owned),
        }
    }

    #[test]
    fn problems_are_followed_by_their_fix() {
        let report = DoctorReport {
            sections: vec![ReportSection {
                title: "Desktop",
                lines: vec![
                    line(CheckStatus::Ok, "session", None),
                    line(CheckStatus::Wrong, "X11", Some("do it")),
                ],
            }],
            outputs: vec!["one", "other"],
            boards: BoardAccess::None,
        };
        assert_eq!(
            report_text(&report, false),
            "Desktop\n  ok     session  found\n  wrong  X11      found\n                  -> do it\n\ngelpad can play through the one, or other.\n"
        );
    }

    #[test]
    fn play_needs_an_output_and_a_board_that_can_be_read() {
        let report = |outputs: Vec<&'static str>, boards| DoctorReport {
            sections: Vec::new(),
            outputs,
            boards,
        };
        assert!(report(vec!["x"], BoardAccess::None).can_play());
        assert!(!report(Vec::new(), BoardAccess::Readable).can_play());
        let unreadable = report(vec!["x"], BoardAccess::Unreadable);
        assert!(!unreadable.can_play() && why_not(&unreadable).contains("board"));
    }
}
