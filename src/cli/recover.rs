//! `gelpad recover`: what a damaged recording holds, saved.

use anyhow::Context as _;

use super::args::RecoverArgs;
use super::exit::Ending;
use super::play::say;
use crate::session;

pub(super) fn recover(args: &RecoverArgs) -> anyhow::Result<Ending> {
    let salvage = session::recover(&args.file, &args.output)
        .with_context(|| args.file.display().to_string())?;
    let ended = if salvage.was_whole {
        ""
    } else {
        "; it was not closed"
    };
    say(&format!(
        "{}: {} frames, {} other inputs and {} events saved{ended}",
        args.output.display(),
        salvage.frames,
        salvage.inputs,
        salvage.events
    ));
    for note in &salvage.notes {
        say(&format!("lost: {note}"));
    }
    let told = salvage.notes.len() as u64;
    if salvage.losses > told {
        say(&format!("lost: and {} more", salvage.losses - told));
    }
    if salvage.left_out > 0 {
        say(&format!(
            "missing since it was recorded: {} inputs",
            salvage.left_out
        ));
    }
    if !salvage.has_lost() {
        say("nothing was lost");
        return Ok(Ending::Done);
    }
    Ok(Ending::LostData)
}
