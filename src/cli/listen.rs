//! `gelpad listen`: shows what a board sends.

use std::io::Write as _;
use std::time::Duration;

use super::args::ListenArgs;
use super::exit::Ending;
use super::message::say;
use crate::app::port_report::{advice, play_advice, report, seconds};
use crate::platform::signals::Signals;
use crate::source::serial::PortListener;
use crate::types::printable;

pub(super) fn listen(args: &ListenArgs) -> anyhow::Result<Ending> {
    let signals = Signals::listen()?;
    let mut listener =
        PortListener::open(&args.port, args.board.baud, args.board.format, !args.mute)?;
    say(&format!(
        "listening to {} at {} baud; Ctrl-C ends it",
        args.port, args.board.baud
    ));
    let ending = listen_until_done(&mut listener, args, &signals);
    let heard = listener.report().clone();
    drop(listener);
    let mut stdout = std::io::stdout().lock();
    let mut text = report(&heard);
    if let Some(readings) = heard.readings() {
        text += &printable(&play_advice(heard.kind, readings, &args.port));
    }
    stdout.write_all(text.as_bytes())?;
    stdout.flush()?;
    let ending = ending?;
    if heard.frames == 0 && ending == Ending::Done {
        let why = heard
            .first_garbled
            .as_ref()
            .map_or(String::new(), |(_, reason, _)| format!(": {reason}"));
        anyhow::bail!(
            "no frame in {:.1} s{}\n  help: {}",
            seconds(&heard),
            printable(&why),
            advice(&heard)
        );
    }
    Ok(ending)
}

fn listen_until_done(
    listener: &mut PortListener,
    args: &ListenArgs,
    signals: &Signals,
) -> anyhow::Result<Ending> {
    let limit = Duration::from_secs_f64(args.seconds);
    let mut printed_notes = 0;
    loop {
        if let Some(signal) = signals.received() {
            return Ok(Ending::Signal(signal));
        }
        let heard = listener.listen()?;
        for note in &heard.notes[printed_notes..] {
            say(note);
        }
        printed_notes = heard.notes.len();
        let has_all = args.frames.is_some_and(|frames| heard.frames >= frames);
        if has_all || Duration::from_nanos(heard.elapsed_ns) >= limit {
            return Ok(Ending::Done);
        }
    }
}
