//! `gelpad recover`: saves the readable part of a damaged recording.

use anyhow::Context as _;

use super::args::RecoverArgs;
use super::exit::Ending;
use super::message::say;
use super::progress::SolveBar;
use crate::app::restore::Restorer;
use crate::eit::REFERENCE_FRAMES;
use crate::files;
use crate::session;

pub(super) fn recover(args: &RecoverArgs) -> anyhow::Result<Ending> {
    files::refuse_input(&args.file, &args.output)?;
    let bar = SolveBar::default();
    let progress = |done, rows| bar.update(done, rows);
    let mut restorer = Restorer::new(&progress, args.pad.as_deref());
    let least_frames = REFERENCE_FRAMES as u64;
    let salvaged = session::recover(&args.file, &args.output, &mut restorer, least_frames);
    bar.finish();
    // Also where nothing is saved: another pad may be the way on.
    for replaced in &restorer.replaced {
        say(&format!("warning: {replaced}"));
    }
    if restorer.is_pad_ignored {
        say("note: --pad is ignored, since the recording's own pad can be read");
    }
    let salvage = salvaged.with_context(|| args.file.display().to_string())?;
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
    if !salvage.is_incomplete() && restorer.replaced.is_empty() {
        say("nothing was lost");
        return Ok(Ending::Done);
    }
    Ok(Ending::LostData)
}
