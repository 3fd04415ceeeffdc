//! `gelpad doctor`: whether this machine can play, and what to do where it cannot.

use std::io::{IsTerminal as _, Write as _};
use std::path::Path;

use anyhow::{Context as _, bail};
use crossterm::style::Stylize as _;

use super::args::DoctorArgs;
use super::exit::Ending;
use crate::doctor::{Boards, Line, Machine, Report, State, examine, rule};

/// Room for the word that says how something is.
const WORD_WIDTH: usize = 7;

pub(super) fn run(args: &DoctorArgs) -> anyhow::Result<Ending> {
    let mut out = std::io::stdout().lock();
    if args.install_rule {
        return install(&mut out);
    }
    let report = examine(&Machine::here());
    let colours = std::io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    write!(out, "{}", told(&report, colours))?;
    if report.plays() {
        return Ok(Ending::Done);
    }
    drop(out);
    bail!("play would not work here: {}", why_not(&report));
}

fn why_not(report: &Report) -> &'static str {
    match report.boards {
        Boards::Unreadable if !report.outputs.is_empty() => "the board cannot be read",
        _ => {
            "no output reaches a game; mend one that is `wrong` above (--output trace prints events all the same)"
        }
    }
}

/// The report as text: a word, what it is about, what was found, and under it what to do.
fn told(report: &Report, colours: bool) -> String {
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
            text.push_str(&told_line(line, subject_width, colours));
        }
        text.push('\n');
    }
    let outputs = report.outputs.join(", or ");
    text.push_str(&match report.outputs.len() {
        0 => "Nothing here takes what gelpad plays.\n".to_owned(),
        _ => format!("gelpad can play by the {outputs}.\n"),
    });
    if lines().any(mends_by_rule) {
        text.push_str(&format!(
            "\nThe rule that `gelpad doctor --install-rule` writes to {}:\n\n{}",
            rule::RULE_PATH,
            indented(rule::RULE)
        ));
    }
    text
}

fn mends_by_rule(line: &Line) -> bool {
    line.mend
        .as_ref()
        .is_some_and(|mend| mend.contains("--install-rule"))
}

fn told_line(line: &Line, subject_width: usize, colours: bool) -> String {
    let word = match line.state {
        State::Ok => "ok",
        State::Note => "note",
        State::Wrong => "wrong",
    };
    let padded = format!("{word:WORD_WIDTH$}");
    let word = match (colours, line.state) {
        (false, _) => padded,
        (true, State::Ok) => padded.green().to_string(),
        (true, State::Note) => padded.yellow().to_string(),
        (true, State::Wrong) => padded.red().bold().to_string(),
    };
    let mut text = format!("  {word}{:subject_width$}  {}\n", line.subject, line.found);
    if let Some(mend) = &line.mend {
        let margin = WORD_WIDTH + subject_width + 4;
        text.push_str(&format!("{:margin$}-> {mend}\n", ""));
    }
    text
}

fn indented(text: &str) -> String {
    text.lines().map(|line| format!("    {line}\n")).collect()
}

/// Says what will be done, then does it.
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
        "and runs, so that it holds at once:\n\n{}",
        commands.concat()
    )?;
    out.flush()?;
    if let Err(error) = rule::write(Path::new("/")) {
        if error.kind() == std::io::ErrorKind::PermissionDenied {
            let own = std::env::current_exe();
            let own = own.map_or("gelpad".to_owned(), |path| path.display().to_string());
            bail!("only root may do that\n  help: sudo {own} doctor --install-rule");
        }
        return Err(error).context(rule::RULE_PATH);
    }
    let failed = rule::apply();
    if failed.is_empty() {
        writeln!(out, "Done. Plug boards in again; then ask `gelpad doctor`.")?;
    } else {
        writeln!(
            out,
            "Written. It holds from the next start of this machine on, for udev did not take it up:"
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
    use crate::doctor::Section;

    fn line(state: State, subject: &str, mend: Option<&str>) -> Line {
        Line {
            state,
            subject: subject.to_owned(),
            found: "found".to_owned(),
            mend: mend.map(str::to_owned),
        }
    }

    #[test]
    fn a_report_is_aligned_and_says_what_to_do_under_what_is_wrong() {
        let report = Report {
            sections: vec![Section {
                title: "Desktop",
                lines: vec![
                    line(State::Ok, "session", None),
                    line(State::Wrong, "X11", Some("do it")),
                ],
            }],
            outputs: vec!["one", "other"],
            boards: Boards::None,
        };
        assert_eq!(
            told(&report, false),
            "Desktop\n  ok     session  found\n  wrong  X11      found\n                  -> do it\n\ngelpad can play by the one, or other.\n"
        );
    }

    #[test]
    fn play_needs_an_output_and_a_board_that_can_be_read() {
        let report = |outputs: Vec<&'static str>, boards| Report {
            sections: Vec::new(),
            outputs,
            boards,
        };
        assert!(report(vec!["x"], Boards::None).plays());
        assert!(!report(Vec::new(), Boards::Readable).plays());
        let unreadable = report(vec!["x"], Boards::Unreadable);
        assert!(!unreadable.plays() && why_not(&unreadable).contains("board"));
    }
}
