//! `gelpad recover`: saves the readable part of a damaged recording.

use anyhow::Context as _;

use super::args::RecoverArgs;
use super::exit::Ending;
use super::message::say;
use crate::files;
use crate::session;

pub(super) fn recover(args: &RecoverArgs) -> anyhow::Result<Ending> {
    files::refuse_input(&args.file, &args.output)?;
    let salvage = session::recover(&args.file, &args.output)
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
        salvage.inputs,
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
    if !salvage.is_incomplete() {
        say("nothing was lost");
        return Ok(Ending::Done);
    }
    Ok(Ending::LostData)
}
