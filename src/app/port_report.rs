//! What a board sends, as a report with what to do next: for `gelpad listen` and for the window.

use std::fmt::Write as _;
use std::path::Path;
use std::time::Duration;

use super::folders::own_texts;
use super::pads::load_pad;
use super::request::BoardLine;
use crate::pad::{DEFAULT_PAD, SHIPPED_PADS};
use crate::source::serial::{PortListener, PortReport};
use crate::source::wire::{FormatChoice, WireFormat};
use crate::source::{SourceError, describe_order, plausible_counts};
use crate::types::printable;

/// Bytes per row of a hex dump.
const ROW_BYTES: usize = 16;

/// Shortest and longest time of a diagnosis: some boards start to send after several commands.
const SHORTEST: Duration = Duration::from_millis(2500);
const LONGEST: Duration = Duration::from_secs(10);
/// Frames from which format, order and rate are recognised.
const ENOUGH_FRAMES: u64 = 50;

/// What a port sent for a while, and how to play it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PortDiagnosis {
    /// Format, frames and their rate, values, order and bad lines: a line each, name and value in columns.
    pub report: String,
    /// The first bytes as a hex dump with text.
    pub first_bytes: String,
    /// What to do when no frame came.
    pub advice: Option<&'static str>,
    /// The recognised format.
    pub format: Option<FormatChoice>,
    /// The shipped pad with this number of readings.
    pub pad: Option<String>,
    /// Number of readings in a frame, ...
    pub readings: Option<usize>,
    /// ... and the number of electrodes that they are recognised as.
    pub electrodes: Option<usize>,
}

/// Listens to a port until it has sent frames for a while. Start commands are sent to a silent board.
///
/// # Errors
/// The port cannot be opened, or it disappears.
pub fn diagnose(port: &str, board: BoardLine) -> Result<PortDiagnosis, SourceError> {
    let mut listener = PortListener::open(port, board.baud, board.format, true)?;
    loop {
        let heard = listener.listen()?;
        let elapsed = Duration::from_nanos(heard.elapsed_ns);
        let is_enough = elapsed >= SHORTEST && heard.frames >= ENOUGH_FRAMES;
        if is_enough || elapsed >= LONGEST {
            break;
        }
    }
    let heard = listener.report();
    let format = heard.kind.map(|kind| FormatChoice {
        kind: Some(kind),
        ..board.format
    });
    Ok(PortDiagnosis {
        report: report(heard),
        first_bytes: printable(&hex_dump(&heard.first_bytes)).into_owned(),
        advice: (heard.frames == 0).then(|| advice(heard)),
        format,
        pad: heard.readings().and_then(fitting_pad),
        readings: heard.readings(),
        electrodes: heard.order().map(|(electrodes, _)| electrodes),
    })
}

/// Time that was listened, s.
pub(crate) fn seconds(heard: &PortReport) -> f64 {
    heard.elapsed_ns as f64 * 1e-9
}

/// What to do when no frame came.
pub(crate) fn advice(heard: &PortReport) -> &'static str {
    let bytes = &heard.first_bytes;
    let binary = bytes.iter().filter(|byte| !byte.is_ascii()).count();
    if heard.bytes == 0 {
        "no bytes were received: is this the right port, and is the board powered?"
    } else if binary > bytes.len() / 4 {
        "the bytes are not text: try another --baud, or --format sciospec or gelpad"
    } else {
        "the bytes are text: choose a --format from docs/wire.md"
    }
}

/// What was received, as a report.
pub(crate) fn report(heard: &PortReport) -> String {
    let mut report = Report::default();
    report.transfer(heard);
    report.values(heard);
    let order = heard.order();
    if let Some((electrodes, order)) = &order {
        report.line("electrodes", electrodes.to_string());
        report.line(
            "order",
            match order {
                Ok(order) => describe_order(order, heard.readings().unwrap_or(0)),
                Err(error) => error.to_string(),
            },
        );
    }
    report.bad_bytes(heard);
    printable(&report.0).into_owned()
}

/// A report of lines with a name and a value.
#[derive(Default)]
struct Report(String);

impl Report {
    fn line(&mut self, name: &str, value: String) {
        // Writing to a String cannot fail.
        let _ = writeln!(self.0, "{name:<16}{value}");
    }

    /// Bytes, format, frames and their rate.
    fn transfer(&mut self, heard: &PortReport) {
        let elapsed_s = seconds(heard).max(1e-3);
        let bytes_per_s = heard.bytes as f64 / elapsed_s;
        self.line(
            "received",
            format!(
                "{} bytes in {elapsed_s:.1} s: {bytes_per_s:.0} bytes/s",
                heard.bytes
            ),
        );
        if let Some(kind) = heard.kind.filter(|_| heard.frames > 0) {
            let guess = format!("{}: --format {}", kind.description(), kind.name());
            self.line("best guess", guess);
        }
        if heard.frames > 0 {
            let rate = heard
                .frames_per_s()
                .map_or(String::new(), |rate| format!(", {rate:.1} per second"));
            self.line("frames", format!("{}{rate}", heard.frames));
            if let Some(device_ns) = heard.device_ns.filter(|ns| *ns > 0) {
                let rate = (heard.frames - 1) as f64 / (device_ns as f64 * 1e-9);
                self.line("", format!("{rate:.1} per second by the board's clock"));
            }
            if heard.missing > 0 {
                let missing = format!("{} missing by the board's counter", heard.missing);
                self.line("", missing);
            }
            if heard.late > 0 {
                let late = format!("{} again or too late by the board's counter", heard.late);
                self.line("", late);
            }
            if heard.repeated > 0 {
                let repeated = format!("{} repeat the one before bit for bit", heard.repeated);
                self.line("", repeated);
            }
        }
        if heard.garbled > 0 || heard.frames > 0 {
            self.line("garbled", heard.garbled.to_string());
        }
    }

    /// Number and range of the values of a frame.
    fn values(&mut self, heard: &PortReport) {
        if let Some(values) = heard.most_common_count() {
            let counts = heard.values.iter();
            let others: u64 = counts
                .filter(|(count, _)| **count != values)
                .map(|(_, frames)| frames)
                .sum();
            let others = match others {
                0 => String::new(),
                others => format!(" ({others} frames have another number)"),
            };
            self.line("values a frame", format!("{values}{others}"));
        }
        match heard.leading() {
            0 => {}
            1 => self.line(
                "",
                "1 column before the readings: a counter or a time".to_owned(),
            ),
            columns => {
                let columns = format!("{columns} columns before the readings: a counter, a time");
                self.line("", columns);
            }
        }
        if let Some((least, most)) = heard.range {
            self.line("", format!("from {least} to {most}"));
        }
    }

    /// The first bad line; without any frame, the first bytes.
    fn bad_bytes(&mut self, heard: &PortReport) {
        let bytes = match &heard.first_garbled {
            Some((at_ns, reason, bytes)) => {
                let at_s = *at_ns as f64 * 1e-9;
                self.line("first bad line", format!("after {at_s:.2} s: {reason}"));
                bytes
            }
            None if heard.frames == 0 && heard.bytes > 0 => {
                self.line("first bytes", String::new());
                &heard.first_bytes
            }
            None => return,
        };
        self.0.push_str(&hex_dump(bytes));
    }
}

/// Whether the default pad can be played from this number of readings.
fn default_pad_takes(readings: usize) -> bool {
    load_pad(DEFAULT_PAD).is_ok_and(|loaded| plausible_counts(&loaded.pad).contains(&readings))
}

/// The pad with this number of readings: a shipped one, or one of the player's own.
fn fitting_pad(readings: usize) -> Option<String> {
    let has_so_many =
        |name: &String| load_pad(name).is_ok_and(|loaded| loaded.pad.channels() == readings);
    let shipped = SHIPPED_PADS.iter().map(|pad| pad.name.to_owned());
    let own = own_texts("pads").into_iter().filter_map(|path| {
        let name = Path::new(&path).file_stem()?;
        Some(name.to_string_lossy().into_owned())
    });
    shipped
        .chain(own)
        .find(has_so_many)
        .or(default_pad_takes(readings).then(|| DEFAULT_PAD.to_owned()))
}

/// The command that plays this board: it names a pad with this number of readings.
pub(crate) fn play_advice(kind: Option<WireFormat>, readings: usize, port: &str) -> String {
    let format = kind.map_or(String::new(), |kind| format!(" --format {}", kind.name()));
    let command = format!("gelpad play --source serial:{port}");
    if let Some(name) = fitting_pad(readings) {
        let pad = match name.as_str() {
            DEFAULT_PAD => String::new(),
            name => format!(" --pad {name}"),
        };
        return format!("\nplay it:\n  {command}{format}{pad}\n");
    }
    let may_be_complex = kind == Some(WireFormat::Lines)
        && readings.is_multiple_of(2)
        && default_pad_takes(readings / 2);
    if may_be_complex {
        return format!(
            "\nplay it, if real and imaginary parts alternate:\n  {command} --format lines:complex\n"
        );
    }
    format!(
        "\nno pad has {readings} readings a frame; describe yours in a file, and give it as many electrodes:\n  \
         gelpad pad show {DEFAULT_PAD} --toml > my-pad.toml\n  {command}{format} --pad ./my-pad.toml\n"
    )
}

/// A hex dump with text.
fn hex_dump(bytes: &[u8]) -> String {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_names_a_pad_that_takes_the_readings() {
        let advice = |readings| play_advice(Some(WireFormat::Lines), readings, "P");
        let plays = "\nplay it:\n  gelpad play --source serial:P --format lines";
        assert_eq!(advice(208), format!("{plays}\n"));
        assert_eq!(advice(104), format!("{plays}\n"));
        assert_eq!(advice(192), format!("{plays} --pad openeit-lattice\n"));
        assert!(advice(416).contains("--format lines:complex"));
        for readings in [928, 200] {
            let text = advice(readings);
            assert!(
                text.contains("no pad has") && !text.contains("play it"),
                "{text}"
            );
        }
    }

    #[test]
    fn a_dump_shows_bytes_and_text_in_columns() {
        assert_eq!(
            hex_dump(b"magnitudes: 1.5,\r\n"),
            "  6d 61 67 6e 69 74 75 64 65 73 3a 20 31 2e 35 2c  magnitudes: 1.5,\n  0d 0a                                            ..\n"
        );
    }
}
