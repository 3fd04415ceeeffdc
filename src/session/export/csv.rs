//! Frames as CSV: `t_ms,v0,v1,...`, which `gelpad replay` reads back exactly.

use std::io::{self, Write};

use crate::types::Frame;

/// Writes the header for frames of `channels` voltages.
///
/// # Errors
/// The output cannot be written.
pub fn write_header(out: &mut impl Write, channels: usize) -> io::Result<()> {
    write!(out, "t_ms")?;
    for channel in 0..channels {
        write!(out, ",v{channel}")?;
    }
    writeln!(out)
}

/// Writes a frame: its time to the nanosecond, each voltage with the fewest digits that give the same f32.
///
/// # Errors
/// The output cannot be written.
pub fn write_frame(out: &mut impl Write, frame: &Frame) -> io::Result<()> {
    let (ms, ns) = (frame.t_ns / 1_000_000, frame.t_ns % 1_000_000);
    if ns == 0 {
        write!(out, "{ms}")?;
    } else {
        write!(out, "{ms}.{ns:06}")?;
    }
    for value in &frame.volts {
        write!(out, ",{value}")?;
    }
    writeln!(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn values_and_times_are_read_back_exactly(bits in any::<u32>(), t_ns in 0..1_000_000_000_000u64) {
            let value = f32::from_bits(bits);
            prop_assume!(value.is_finite());
            let mut out = Vec::new();
            write_frame(&mut out, &Frame { t_ns, volts: vec![value] }).expect("written");
            let line = String::from_utf8(out).expect("text");
            let (t_ms, volt) = line.trim().split_once(',').expect("two columns");
            let back: f32 = volt.parse().expect("a number");
            prop_assert_eq!(back.to_bits(), bits);
            prop_assert_eq!(crate::types::nanos_from_ms(t_ms.parse().expect("a time")), t_ns);
        }
    }
}
