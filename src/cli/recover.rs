//! `gelpad recover`: saves the readable part of a damaged recording.

use anyhow::Context as _;

use super::args::RecoverArgs;
use super::exit::Ending;
use super::message::say;
use super::progress::SolveBar;
use crate::app::recovery;
use crate::files;

pub(super) fn recover(args: &RecoverArgs) -> anyhow::Result<Ending> {
    files::refuse_input(&args.file, &args.output)?;
    let bar = SolveBar::default();
    let progress = |done, rows| bar.update(done, rows);
    let recovered = recovery::recover(&args.file, &args.output, args.pad.as_deref(), &progress);
    bar.finish();
    for replaced in &recovered.replaced {
        say(&format!("warning: {replaced}"));
    }
    if recovered.is_pad_ignored {
        say("note: --pad is ignored, since the recording's own pad can be read");
    }
    let salvage = recovered
        .result
        .with_context(|| args.file.display().to_string())?;
    let suffix = if salvage.was_whole {
        ""
    } else {
        "; the file was not closed"
    };
    say(&format!(
        "{}: {} frames, {} other inputs and {} events saved{suffix}",
        args.output.display(),
        salvage.frames,
        salvage.inputs + salvage.controls,
        salvage.events
    ));
    for line in salvage.lost_lines().trim_start().lines() {
        say(line);
    }
    if salvage.dropped_inputs > 0 {
        say(&format!(
            "missing already in the recording: {} inputs",
            salvage.dropped_inputs
        ));
    }
    if !salvage.is_incomplete() && recovered.replaced.is_empty() {
        say("nothing was lost");
        return Ok(Ending::Done);
    }
    Ok(Ending::LostData)
}
