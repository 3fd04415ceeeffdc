//! `gelpad recover`: saves the readable part of a damaged recording.

use anyhow::{Context as _, bail};

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
    let mut restorer = Restorer::new(&progress);
    let salvage = session::recover(&args.file, &args.output, &mut restorer)
        .with_context(|| args.file.display().to_string())?;
    bar.finish();
    for replaced in &restorer.replaced {
        say(&format!("warning: {replaced}"));
    }
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
    for note in &salvage.notes {
        say(&format!("lost: {note}"));
    }
    let printed = salvage.notes.len() as u64;
    if salvage.losses > printed {
        say(&format!("lost: and {} more", salvage.losses - printed));
    }
    if salvage.dropped_inputs > 0 {
        say(&format!(
            "missing already in the recording: {} inputs",
            salvage.dropped_inputs
        ));
    }
    if salvage.controls == 0 && salvage.frames < REFERENCE_FRAMES as u64 {
        bail!(
            "{}: too few frames to replay: the first {REFERENCE_FRAMES} are the reference",
            args.output.display()
        );
    }
    if !salvage.is_incomplete() && restorer.replaced.is_empty() {
        say("nothing was lost");
        return Ok(Ending::Done);
    }
    Ok(Ending::LostData)
}
