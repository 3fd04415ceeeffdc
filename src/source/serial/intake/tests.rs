//! Frames from bytes: losses, order, columns before the readings.

use super::*;
use crate::pad::shipped_pad;
use crate::source::SimulatedPad;
use crate::source::wire::gelpad::{Values, encode};
use crate::source::wire::{WireFormat, openeit};

fn pad(name: &str) -> Pad {
    Pad::from_toml(name, shipped_pad(name).expect("shipped").toml).expect("sound")
}

fn rest(pad: &Pad) -> Vec<f32> {
    let volts = SimulatedPad::new(pad).and_then(|simulated| simulated.volts(&[]));
    let volts = volts.expect("solved");
    volts.into_iter().map(|volt| 1e3 * volt as f32).collect()
}

fn readings_of(intake: &mut FrameIntake, bytes: &[u8]) -> Vec<SourceReading> {
    let mut readings = VecDeque::new();
    intake.feed(5, 0, bytes, &mut readings).expect("fits");
    readings.into()
}

fn frames(readings: &[SourceReading]) -> usize {
    let is_frame = |reading: &&SourceReading| matches!(reading, SourceReading::Frame(_));
    readings.iter().filter(is_frame).count()
}

fn lost(readings: &[SourceReading]) -> u64 {
    let frames = |reading: &SourceReading| match reading {
        SourceReading::Skipped { frames, .. } => *frames,
        _ => 0,
    };
    readings.iter().map(frames).sum()
}

#[test]
fn losses_are_counted_once_by_the_numbers_of_the_board() {
    let pad = pad("edinburgh-lattice");
    let volts = rest(&pad);
    let mut intake = FrameIntake::new(&pad, WireFormat::Gelpad.into());
    let packet = |n: u32| encode(Values::F32, n, n.wrapping_mul(1000), &volts);
    // The count overflows in between.
    let begin: Vec<u8> = (0..5_u32).flat_map(|n| packet(n.wrapping_sub(2))).collect();
    assert_eq!(frames(&readings_of(&mut intake, &begin)), 5);
    let mut damaged = packet(3);
    damaged[100] ^= 0x55;
    // Number 3 is garbled, 4 and 5 never arrive.
    let readings = readings_of(&mut intake, &[damaged, packet(6)].concat());
    assert_eq!((frames(&readings), lost(&readings)), (1, 3));
    // A board that was reset restarts its count: no frame counts as lost.
    let readings = readings_of(&mut intake, &packet(0));
    assert_eq!((frames(&readings), lost(&readings)), (1, 0));
}

#[test]
fn late_and_repeated_packets_are_dropped_and_counted() {
    let pad = pad("edinburgh-lattice");
    let volts = rest(&pad);
    let mut intake = FrameIntake::new(&pad, WireFormat::Gelpad.into());
    let packet = |n: u32| encode(Values::F32, n, n.wrapping_mul(1000), &volts);
    let numbers = [70, 71, 72, 73, 72, 73, 73, 74];
    let bytes: Vec<u8> = numbers.into_iter().flat_map(packet).collect();
    let readings = readings_of(&mut intake, &bytes);
    assert_eq!((frames(&readings), lost(&readings)), (5, 0));
    let is_skip = |one: &&SourceReading| matches!(one, SourceReading::Skipped { .. });
    assert_eq!(readings.iter().filter(is_skip).count(), 3);
}

#[test]
fn columns_before_the_readings_are_ignored() {
    let pad = pad("edinburgh-lattice");
    let volts = rest(&pad);
    let words: Vec<String> = volts.iter().map(|volt| format!("{volt:.5}")).collect();
    let decimal_commas = words.join("\t").replace('.', ",");
    for (line, case) in [
        (format!("@,{}", words.join(",")), "a counter"),
        (
            format!("@;{:.3};{}", 0.5, words.join(";")),
            "a counter and a time",
        ),
        (format!("[{}]", words.join(", ")), "brackets"),
        (
            format!("@ [{}]", words.join(" ")),
            "a counter before brackets",
        ),
        (format!("@\t{decimal_commas}"), "decimal commas"),
    ] {
        for format in ["auto", "lines"] {
            let format = format.parse().expect("a format");
            let mut intake = FrameIntake::new(&pad, format);
            let text: String = (7..17)
                .map(|number| format!("{}\r\n", line.replace('@', &number.to_string())))
                .collect();
            let readings = readings_of(&mut intake, text.as_bytes());
            assert_eq!((frames(&readings), lost(&readings)), (10, 0), "{case}");
            let SourceReading::Frame(frame) = &readings[9] else {
                panic!("{case}: {readings:?}");
            };
            assert!((frame.volts[3] - volts[3]).abs() < 1e-4, "{case}");
        }
    }
}

#[test]
fn a_cut_line_is_never_a_frame_of_another_layout() {
    let pad = pad("openeit-lattice");
    let volts = rest(&pad);
    let mut intake = FrameIntake::new(&pad, WireFormat::OpenEit.into());
    let whole = openeit::encode(&volts);
    let cut = openeit::encode(&volts[..104]);
    let sound: String = std::iter::repeat_n(whole.as_str(), 3).collect();
    assert_eq!(frames(&readings_of(&mut intake, sound.as_bytes())), 3);
    let readings = readings_of(
        &mut intake,
        format!("{cut}{cut}{whole}{cut}{cut}{whole}").as_bytes(),
    );
    assert_eq!((frames(&readings), lost(&readings)), (2, 4));
}

#[test]
fn a_board_of_another_protocol_is_refused_with_a_clear_error() {
    let mut intake = FrameIntake::new(&pad("edinburgh-lattice"), WireFormat::OpenEit.into());
    let text: String =
        std::iter::repeat_n(openeit::encode(&rest(&pad("openeit-lattice"))), 3).collect();
    let error = intake
        .feed(0, 0, text.as_bytes(), &mut VecDeque::new())
        .expect_err("192 for 208");
    assert!(
        error.to_string().contains("192 voltages of opposite drive"),
        "{error}"
    );
}

/// Feeds bytes every 50 ms for 20 s; returns the error, if one comes.
fn error_within_20_s(intake: &mut FrameIntake, bytes: &[u8]) -> Option<String> {
    let mut readings = VecDeque::new();
    (0..400).find_map(|step| {
        let now_ns = step * 50_000_000;
        let fed = intake.feed(now_ns, 0, bytes, &mut readings);
        fed.err().map(|error| error.to_string())
    })
}

#[test]
fn another_baud_rate_ends_waiting_where_frames_are_required() {
    let pad = pad("edinburgh-lattice");
    let noise: Vec<u8> = (0..200_u32).map(|i| (i * 97 % 251) as u8).collect();
    for format in ["auto", "gelpad", "lines", "openeit"] {
        let format = format.parse().expect("a format");
        let mut intake = FrameIntake::new(&pad, format);
        assert_eq!(error_within_20_s(&mut intake, &noise), None, "play waits");
        let mut intake = FrameIntake::new(&pad, format);
        intake.require_frames();
        let error = error_within_20_s(&mut intake, &noise).expect("no frame");
        assert!(error.contains("--baud"), "{error}");
        // A board that comes back starts anew.
        let mut intake = FrameIntake::new(&pad, format);
        let (mut readings, at) = (VecDeque::new(), |s: Nanos| s * 1_000_000_000);
        for (s, reopens) in [(0, false), (10, false), (12, true), (22, false)] {
            intake.require_frames();
            if reopens {
                intake.reopened();
            }
            let fed = intake.feed(at(s), 0, &noise, &mut readings);
            assert!(fed.is_ok(), "{fed:?}");
        }
        let mut intake = FrameIntake::new(&pad, format);
        intake.require_frames();
        assert_eq!(error_within_20_s(&mut intake, &[]), None, "a silent board");
    }
}

#[test]
fn a_board_that_sends_frames_is_waited_for_when_it_is_garbled_later() {
    let pad = pad("edinburgh-lattice");
    let volts = rest(&pad);
    let mut intake = FrameIntake::new(&pad, WireFormat::Gelpad.into());
    intake.require_frames();
    let begin: Vec<u8> = (0..5_u32)
        .flat_map(|n| encode(Values::F32, n, n * 1000, &volts))
        .collect();
    assert_eq!(frames(&readings_of(&mut intake, &begin)), 5);
    assert_eq!(error_within_20_s(&mut intake, &[7; 50]), None);
}
