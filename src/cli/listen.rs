//! `gelpad listen`: what a board sends.

use std::fmt::Write as _;
use std::io::Write as _;
use std::time::Duration;

use super::args::ListenArgs;
use super::exit::Ending;
use super::play::Signals;
use crate::eit::order::{Layout, OrderError};
use crate::source::order_told;
use crate::source::serial::{Heard, Listener};
use crate::source::wire::FormatKind;

/// Bytes of a hex dump in a row.
const ROW_BYTES: usize = 16;

pub(super) fn listen(args: &ListenArgs) -> anyhow::Result<Ending> {
    let signals = Signals::listen()?;
    let mut listener = Listener::open(&args.port, args.board.baud, args.board.format, !args.mute)?;
    say(&format!(
        "listening to {} at {} baud; Ctrl-C ends it",
        args.port, args.board.baud
    ));
    let limit = Duration::from_secs_f64(args.seconds);
    let mut told = 0;
    let ending = loop {
        if let Some(signal) = signals.received() {
            break Ok(Ending::Signal(signal));
        }
        match listener.listen() {
            Ok(heard) => {
                for note in &heard.notes[told..] {
                    say(note);
                }
                told = heard.notes.len();
                let has_all = args.frames.is_some_and(|frames| heard.frames >= frames);
                // What is not understood by then is still being tried.
                let is_over = Duration::from_nanos(heard.elapsed_ns) >= limit;
                if has_all || is_over {
                    break Ok(Ending::Done);
                }
            }
            Err(error) => break Err(error),
        }
    };
    let heard = listener.heard().clone();
    drop(listener);
    let mut stdout = std::io::stdout().lock();
    stdout.write_all(report(&heard, &args.port).as_bytes())?;
    stdout.flush()?;
    let ending = ending?;
    if heard.frames == 0 && ending == Ending::Done {
        anyhow::bail!(
            "no frame in {:.1} s\n  help: {}",
            seconds(&heard),
            advice(&heard)
        );
    }
    Ok(ending)
}

fn seconds(heard: &Heard) -> f64 {
    heard.elapsed_ns as f64 * 1e-9
}

fn advice(heard: &Heard) -> &'static str {
    if heard.bytes == 0 {
        "nothing came at all: is it the right port, and is the board powered?"
    } else if heard
        .first_bytes
        .iter()
        .filter(|byte| !byte.is_ascii())
        .count()
        > heard.first_bytes.len() / 4
    {
        "what came is no text: try another --baud, or --format sciospec or gelpad"
    } else {
        "what came is text: name its format with --format, as in docs/wire.md"
    }
}

/// What was heard, for people.
fn report(heard: &Heard, port: &str) -> String {
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "{name:<16}{value}");
    };
    let elapsed = seconds(heard).max(1e-3);
    line(
        "heard",
        format!(
            "{} bytes in {elapsed:.1} s: {:.0} bytes/s",
            heard.bytes,
            heard.bytes as f64 / elapsed
        ),
    );
    if let Some(kind) = heard.kind {
        line(
            "best guess",
            format!("{}: --format {}", kind.about(), kind.name()),
        );
    }
    if heard.frames > 0 {
        let rate = heard
            .frames_per_s()
            .map_or(String::new(), |rate| format!(", {rate:.1} a second"));
        line("frames", format!("{}{rate}", heard.frames));
        if let Some(device_ns) = heard.device_ns.filter(|ns| *ns > 0) {
            let rate = (heard.frames - 1) as f64 / (device_ns as f64 * 1e-9);
            line("", format!("{rate:.1} a second by the board's clock"));
        }
        if heard.missing > 0 {
            line(
                "",
                format!("{} missing by the board's count", heard.missing),
            );
        }
    }
    if heard.garbled > 0 || heard.frames > 0 {
        line("garbled", heard.garbled.to_string());
    }
    if let Some(values) = heard.usual_values() {
        let others: u64 = heard
            .values
            .iter()
            .filter(|(count, _)| **count != values)
            .map(|(_, n)| n)
            .sum();
        let others = if others > 0 {
            format!(" ({others} frames have another number)")
        } else {
            String::new()
        };
        line("values a frame", format!("{values}{others}"));
    }
    if let Some((least, most)) = heard.range {
        line("", format!("from {least} to {most}"));
    }
    let order = heard.order();
    if let Some((electrodes, order)) = &order {
        line("electrodes", electrodes.to_string());
        let told = match order {
            Ok(order) => order_told(order, heard.usual_values().unwrap_or(0)),
            Err(error @ (OrderError::Ambiguous | OrderError::NoneFits(_))) => error.to_string(),
            Err(error) => error.to_string(),
        };
        line("order", told);
    }
    let bytes = match &heard.first_garbled {
        Some((at_ns, reason, bytes)) => {
            line(
                "first bad line",
                format!("after {:.2} s: {reason}", *at_ns as f64 * 1e-9),
            );
            bytes
        }
        None if heard.frames == 0 && heard.bytes > 0 => {
            line("it begins", String::new());
            &heard.first_bytes
        }
        None => &Vec::new(),
    };
    let dump = hex(bytes);
    let _ = write!(text, "{dump}");
    if heard.frames > 0 {
        let layout = order.and_then(|(_, order)| Some(order.ok()?.layout));
        let _ = writeln!(text, "\nplay it:\n  {}", command(heard.kind, layout, port));
    }
    text
}

/// What to type next.
fn command(kind: Option<FormatKind>, layout: Option<Layout>, port: &str) -> String {
    let pad = match layout {
        Some(Layout::Opposite) => " --pad openeit-lattice",
        _ => "",
    };
    let format = kind.map_or(String::new(), |kind| format!(" --format {}", kind.name()));
    format!("gelpad play --source serial:{port}{format}{pad}")
}

/// Rows of bytes, as hex and as text.
fn hex(bytes: &[u8]) -> String {
    let mut text = String::new();
    for row in bytes.chunks(ROW_BYTES) {
        let hex: Vec<String> = row.iter().map(|byte| format!("{byte:02x}")).collect();
        let plain: String = row
            .iter()
            .map(|byte| {
                if byte.is_ascii_graphic() || *byte == b' ' {
                    char::from(*byte)
                } else {
                    '.'
                }
            })
            .collect();
        let width = 3 * ROW_BYTES;
        let _ = writeln!(text, "  {:<width$} {plain}", hex.join(" "));
    }
    text
}

/// A line for whoever waits; a closed stderr is no reason to stop.
fn say(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dump_shows_bytes_and_text_in_columns() {
        assert_eq!(
            hex(b"magnitudes: 1.5,\r\n"),
            "  6d 61 67 6e 69 74 75 64 65 73 3a 20 31 2e 35 2c  magnitudes: 1.5,\n  0d 0a                                            ..\n"
        );
    }
}
