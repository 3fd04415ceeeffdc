//! What the study writes for the workbench: pads with the protocols that it found, and the table of readings for a firmware.

use std::fmt::Write as _;

use toml_edit::{Array, DocumentMut, Item, TableLike, Value, value};

use crate::pad::{Channel, Protocol};
use crate::study::StudyError;

/// The pad's text with its drives in an order.
pub(super) fn pad_with_order(
    text: &str,
    name: &str,
    order: &[usize],
) -> Result<String, StudyError> {
    edited(text, name, |protocol| {
        let numbers = order.iter().map(|drive| *drive as i64);
        protocol.insert("order", value(Array::from_iter(numbers)));
    })
}

/// The pad's text with a list of readings.
pub(super) fn pad_with_channels(
    text: &str,
    name: &str,
    channels: &[Channel],
) -> Result<String, StudyError> {
    edited(text, name, |protocol| {
        for key in [
            "stimulation",
            "measurement",
            "readings",
            "drives",
            "measures",
            "order",
        ] {
            protocol.remove(key);
        }
        let list = channels.iter().map(|channel| {
            let numbers = electrodes(channel).map(|electrode| electrode as i64);
            Value::from(Array::from_iter(numbers))
        });
        protocol.insert("channels", value(Array::from_iter(list)));
    })
}

/// The pad's text without an order of drives.
pub(super) fn without_order(text: &str) -> Result<String, StudyError> {
    let mut document: DocumentMut = text.parse().map_err(StudyError::internal)?;
    if let Some(protocol) = document
        .get_mut("protocol")
        .and_then(Item::as_table_like_mut)
    {
        protocol.remove("order");
    }
    Ok(document.to_string())
}

fn edited(
    text: &str,
    name: &str,
    edit: impl FnOnce(&mut dyn TableLike),
) -> Result<String, StudyError> {
    let mut document: DocumentMut = text.parse().map_err(StudyError::internal)?;
    document["name"] = value(name);
    let protocol = document
        .get_mut("protocol")
        .and_then(Item::as_table_like_mut);
    edit(protocol.ok_or_else(|| StudyError::internal("a pad without a protocol"))?);
    let text = document.to_string();
    crate::study::parse_pad(name, &text)?;
    Ok(text)
}

/// In and out of the current, and the two electrodes of the meter.
fn electrodes(channel: &Channel) -> [usize; 4] {
    let Channel { drive, measure } = channel;
    [drive.0, drive.1, measure.0, measure.1]
}

/// The readings as a C table, for `gelpad_encode_readings` of `wire/gelpad_wire.h`.
pub(super) fn firmware_table(protocol: &Protocol, command: &str) -> String {
    let drives = protocol.drive_bounds();
    let mut text = format!(
        "/* The readings of a frame, in order: current flows into the first electrode and out of the second; the value is the\n \
         * potential of the fourth minus that of the third. Electrodes are counted from 0.\n \
         * Written by: {command} */\n\
         #include <stdint.h>\n\n\
         #define GELPAD_READINGS {}\n\
         #define GELPAD_DRIVES {}\n\n\
         static const uint8_t gelpad_readings[GELPAD_READINGS][4] = {{\n",
        protocol.channels.len(),
        drives.len() - 1
    );
    for bounds in drives.windows(2) {
        let rows = protocol.channels[bounds[0]..bounds[1]].iter();
        let rows: Vec<String> = rows
            .map(electrodes)
            .map(|[a, b, p, q]| format!("{{{a}, {b}, {p}, {q}}}"))
            .collect();
        let _ = writeln!(text, "    {},", rows.join(", "));
    }
    text + "};\n"
}
