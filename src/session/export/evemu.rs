//! A session as an evemu 1.3 recording: the description of a device, and its kernel events.
//!
//! Format (README of evemu): `N:` name; `I:` bus, vendor, product, version; `P:` properties; `B:` bits of each event type; `A:`
//! axis index, minimum, maximum, fuzz, flat, resolution; `E:` seconds, type, code, value. Codes: `input-event-codes.h`.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use crate::types::{Action, Axis, Button, Event, MouseButton, Nanos, Output};

const EV_SYN: u16 = 0;
const EV_KEY: u16 = 1;
const EV_REL: u16 = 2;
const EV_ABS: u16 = 3;
const REL_X: u16 = 0;
const REL_Y: u16 = 1;
const REL_HWHEEL: u16 = 6;
const REL_WHEEL: u16 = 8;
/// Range of the sticks (either way) and triggers (from 0) of an Xbox 360 pad.
const STICK_RANGE: f32 = 32_767.0;
const TRIGGER_RANGE: f32 = 255.0;

/// An evemu recording, built event by event.
#[derive(Clone, Debug, Default)]
pub struct EvemuRecording {
    first_ns: Option<Nanos>,
    keys: BTreeSet<u16>,
    relative: BTreeSet<u16>,
    axes: BTreeSet<Axis>,
    lines: String,
}

impl EvemuRecording {
    /// Adds the next event.
    pub fn add_event(&mut self, event: &Event) {
        let first_ns = *self.first_ns.get_or_insert(event.t_ns);
        let us = event.t_ns.saturating_sub(first_ns) / 1000;
        let mut events = Vec::new();
        match event.action {
            Action::Press(output) => events.push((EV_KEY, code(output), 1)),
            Action::Release(output) => events.push((EV_KEY, code(output), 0)),
            Action::Axis(axis, value) => {
                let (code, value) = absolute(axis, value);
                self.axes.insert(axis);
                events.push((EV_ABS, code, value));
            }
            // As on screens, y grows downwards; the wheel's up is positive.
            Action::Motion { dx, dy } => events.extend([(EV_REL, REL_X, dx), (EV_REL, REL_Y, dy)]),
            Action::Wheel { dx, dy } => {
                events.extend([(EV_REL, REL_HWHEEL, dx), (EV_REL, REL_WHEEL, dy)])
            }
        }
        events.retain(|(kind, _, value)| *kind != EV_REL || *value != 0);
        for (kind, code, _) in &events {
            match *kind {
                EV_KEY => self.keys.insert(*code),
                EV_REL => self.relative.insert(*code),
                _ => true,
            };
        }
        events.push((EV_SYN, 0, 0));
        for (kind, code, value) in events {
            let _ = writeln!(
                self.lines,
                "E: {:06}.{:06} {kind:04x} {code:04x} {value}",
                us / 1_000_000,
                us % 1_000_000
            );
        }
    }

    /// The text of the file.
    #[must_use]
    pub fn to_evemu(&self) -> String {
        let mut text = String::from("# EVEMU 1.3\nN: gelpad\nI: 0003 045e 028e 0110\n");
        let axes: BTreeSet<u16> = self
            .axes
            .iter()
            .map(|axis| absolute(*axis, 0.0).0)
            .collect();
        let mut types: BTreeSet<u16> = BTreeSet::from([EV_SYN]);
        for (kind, codes) in [
            (EV_KEY, &self.keys),
            (EV_REL, &self.relative),
            (EV_ABS, &axes),
        ] {
            if !codes.is_empty() {
                types.insert(kind);
            }
        }
        text.push_str("P: 00 00 00 00 00 00 00 00\n");
        push_bits(&mut text, EV_SYN, &types, 8);
        push_bits(&mut text, EV_KEY, &self.keys, 96);
        push_bits(&mut text, EV_REL, &self.relative, 8);
        push_bits(&mut text, EV_ABS, &axes, 8);
        for axis in &self.axes {
            let (code, one) = absolute(*axis, 1.0);
            let other = absolute(*axis, -1.0).1;
            let (least, most) = (one.min(other), one.max(other));
            let (fuzz, flat) = if most == TRIGGER_RANGE as i32 {
                (0, 0)
            } else {
                (16, 128)
            };
            let _ = writeln!(text, "A: {code:02x} {least} {most} {fuzz} {flat} 0");
        }
        text.push_str(&self.lines);
        text
    }
}

/// Appends the `B:` lines of an event type, eight bytes each.
fn push_bits(text: &mut String, kind: u16, codes: &BTreeSet<u16>, bytes: u16) {
    for line in (0..bytes).step_by(8) {
        let _ = write!(text, "B: {kind:02x}");
        for byte in line..line + 8 {
            let set = (0..8).filter(|bit| codes.contains(&(8 * byte + bit)));
            let _ = write!(text, " {:02x}", set.fold(0u8, |sum, bit| sum | 1 << bit));
        }
        text.push('\n');
    }
}

/// The kernel's code of a key or button.
fn code(output: Output) -> u16 {
    match output {
        Output::Key(key) => key.evdev_code(),
        Output::Button(button) => match button {
            Button::A => 304,
            Button::B => 305,
            // BTN_NORTH is X on an Xbox pad, BTN_WEST is Y.
            Button::X => 307,
            Button::Y => 308,
            Button::LeftShoulder => 310,
            Button::RightShoulder => 311,
            Button::Select => 314,
            Button::Start => 315,
            Button::Guide => 316,
            Button::LeftStick => 317,
            Button::RightStick => 318,
            Button::Up => 544,
            Button::Down => 545,
            Button::Left => 546,
            Button::Right => 547,
        },
        Output::Mouse(button) => match button {
            MouseButton::Left => 272,
            MouseButton::Right => 273,
            MouseButton::Middle => 274,
            MouseButton::Back => 275,
            MouseButton::Forward => 276,
        },
    }
}

/// The kernel's code and value of an axis; its y grows downwards.
fn absolute(axis: Axis, value: f32) -> (u16, i32) {
    let stick = |value: f32| libm::roundf(value * STICK_RANGE) as i32;
    let trigger = |value: f32| libm::roundf(value.max(0.0) * TRIGGER_RANGE) as i32;
    match axis {
        Axis::LeftX => (0, stick(value)),
        Axis::LeftY => (1, stick(-value)),
        Axis::LeftTrigger => (2, trigger(value)),
        Axis::RightX => (3, stick(value)),
        Axis::RightY => (4, stick(-value)),
        Axis::RightTrigger => (5, trigger(value)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_press_and_a_stick_are_written_as_by_the_kernel() {
        let mut recording = EvemuRecording::default();
        for (t_ms, action) in [
            (1000, Action::Press("key:space".parse().expect("a key"))),
            (1080, Action::Release("key:space".parse().expect("a key"))),
            (1100, Action::Axis(Axis::LeftY, 1.0)),
        ] {
            recording.add_event(&Event {
                t_ns: t_ms * 1_000_000,
                action,
            });
        }
        let text = recording.to_evemu();
        let events: Vec<&str> = text.lines().filter(|line| line.starts_with("E:")).collect();
        assert_eq!(
            events,
            [
                "E: 000000.000000 0001 0039 1",
                "E: 000000.000000 0000 0000 0",
                "E: 000000.080000 0001 0039 0",
                "E: 000000.080000 0000 0000 0",
                "E: 000000.100000 0003 0001 -32767",
                "E: 000000.100000 0000 0000 0",
            ]
        );
        assert!(text.starts_with("# EVEMU 1.3\nN: gelpad\n"), "{text}");
        // Key 57 is bit 1 of byte 7; types 0, 1 and 3 are present.
        assert!(text.contains("B: 01 00 00 00 00 00 00 00 02\n"), "{text}");
        assert!(text.contains("B: 00 0b 00"), "{text}");
        assert!(text.contains("A: 01 -32767 32767 16 128 0\n"), "{text}");
    }
}
