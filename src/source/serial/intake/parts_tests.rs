//! Parts from bytes that arrive slowly, sound and damaged.

use std::collections::VecDeque;

use super::FrameIntake;
use crate::pad::{DEFAULT_PAD, Pad, shipped_pad};
use crate::source::wire::gelpad::{Values, encode_part};
use crate::source::wire::lines;
use crate::source::{SimulatedPad, SourceReading};
use crate::types::{NANOS_PER_MS, Nanos};

const DRIVES: usize = 16;
const MS: Nanos = NANOS_PER_MS;

/// A board whose bytes arrive slowly.
struct Bench {
    intake: FrameIntake,
    volts: Vec<f32>,
    now_ns: Nanos,
}

impl Bench {
    fn new(format: &str) -> Self {
        let shipped = shipped_pad(DEFAULT_PAD).expect("shipped");
        let pad = Pad::from_toml("p", shipped.toml).expect("sound");
        let volts = SimulatedPad::new(&pad).and_then(|simulated| simulated.volts(&[]));
        let volts = volts.expect("solved");
        let mut intake = FrameIntake::new(&pad, format.parse().expect("a format"));
        intake.hand_on_parts();
        Self {
            intake,
            volts: volts.into_iter().map(|volt| 1e3 * volt as f32).collect(),
            now_ns: 0,
        }
    }

    /// Feeds pieces, two milliseconds apart.
    fn feed<'a>(&mut self, pieces: impl IntoIterator<Item = &'a [u8]>) -> Vec<SourceReading> {
        let mut readings = VecDeque::new();
        for piece in pieces {
            self.now_ns += 2 * MS;
            self.intake
                .feed(self.now_ns, 0, piece, &mut readings)
                .expect("fits");
        }
        readings.into()
    }

    /// A line of text, in pieces of a drive's length.
    fn feed_line(&mut self, line: &str) -> Vec<SourceReading> {
        let size = line.len().div_ceil(DRIVES);
        self.feed(line.as_bytes().chunks(size))
    }

    fn line(&self) -> String {
        lines::encode(&self.volts, false)
    }

    /// The packets of a frame, one for each drive.
    fn packets(&self, number: u32) -> Vec<Vec<u8>> {
        let count = self.volts.len() / DRIVES;
        (0..DRIVES)
            .map(|drive| {
                let time_us = number * 32_000 + drive as u32 * 2000;
                let part = drive * count..(drive + 1) * count;
                encode_part(Values::F32, number, time_us, &self.volts, part)
            })
            .collect()
    }

    fn feed_packets(&mut self, packets: &[Vec<u8>]) -> Vec<SourceReading> {
        self.feed(packets.iter().map(Vec::as_slice))
    }
}

/// First channels of the parts, and the reasons of what was skipped.
fn summary(readings: &[SourceReading]) -> (Vec<usize>, Vec<&str>) {
    let mut last_ns = 0;
    let mut firsts = Vec::new();
    let mut reasons = Vec::new();
    for reading in readings {
        match reading {
            SourceReading::Part(part) => {
                assert!(part.t_ns >= last_ns, "times never run backwards");
                last_ns = part.t_ns;
                firsts.push(part.first);
            }
            SourceReading::Skipped { reason, .. } => reasons.push(reason.as_str()),
            other => panic!("{other:?}"),
        }
    }
    (firsts, reasons)
}

fn all_firsts() -> Vec<usize> {
    (0..DRIVES).map(|drive| 13 * drive).collect()
}

#[test]
fn a_slow_line_is_handed_on_drive_by_drive_from_the_third_frame_on() {
    let mut bench = Bench::new("lines");
    for _ in 0..6 {
        let line = bench.line();
        bench.feed_line(&line);
    }
    let line = bench.line();
    let readings = bench.feed_line(&line);
    assert_eq!(summary(&readings), (all_firsts(), vec![]));
    // Fast lines come whole again.
    for _ in 0..20 {
        let line = bench.line();
        bench.feed([line.as_bytes()]);
    }
    let readings = bench.feed([line.as_bytes()]);
    assert!(
        matches!(&readings[..], [SourceReading::Frame(_)]),
        "{readings:?}"
    );
}

#[test]
fn a_line_that_lost_bytes_hands_on_nothing_that_is_shifted() {
    let mut bench = Bench::new("lines");
    let line = bench.line();
    for _ in 0..6 {
        bench.feed_line(&line);
    }
    let words: Vec<&str> = line.trim().split(',').collect();
    // One value is missing: what follows is shifted by one.
    let short = format!("{},{}\n", words[..60].join(","), words[61..].join(","));
    // A comma is missing: two values are none.
    let merged = format!("{}{}\n", words[..60].join(","), words[60..].join(","));
    for damaged in [short, merged] {
        let readings = bench.feed_line(&damaged);
        let (firsts, reasons) = summary(&readings);
        assert!(firsts.len() <= 5, "{firsts:?}");
        assert_eq!(reasons.len(), 1);
        for reading in &readings {
            if let SourceReading::Part(part) = reading {
                let own = &bench.volts[part.first..part.first + part.volts.len()];
                assert_eq!(part.volts, own);
            }
        }
        let line = bench.line();
        assert_eq!(summary(&bench.feed_line(&line)), (all_firsts(), vec![]));
    }
    // A damaged start leaves no trace in a line that then arrives at once.
    bench.feed([&line.as_bytes()[..700], b"x\n"]);
    let readings = bench.feed([line.as_bytes()]);
    assert_eq!(summary(&readings).0, all_firsts());
}

#[test]
fn lost_repeated_and_late_packets_are_reported_and_no_part_comes_twice() {
    let mut bench = Bench::new("gelpad");
    for number in 100..108 {
        let packets = bench.packets(number);
        bench.feed_packets(&packets);
    }
    let mut lost = bench.packets(108);
    lost.remove(5);
    let (firsts, reasons) = {
        let readings = bench.feed_packets(&lost);
        let (firsts, reasons) = summary(&readings);
        (firsts, reasons.len())
    };
    assert_eq!((firsts, reasons), (all_firsts()[..5].to_vec(), 1));
    // The gap in the numbers is noticed when the next frame is complete: it is handed on then.
    let whole = bench.packets(109);
    let readings = bench.feed_packets(&whole);
    assert_eq!(summary(&readings).0, all_firsts());
    assert_eq!(summary(&readings).1.len(), 1);
    // A packet twice, and a late frame.
    let mut twice = bench.packets(110);
    twice.insert(4, twice[3].clone());
    let readings = bench.feed_packets(&twice);
    assert_eq!(summary(&readings).0, all_firsts());
    assert_eq!(summary(&readings).1, ["values 39 to 51 of frame 110 again"]);
    let readings = bench.feed_packets(&whole);
    assert_eq!(
        summary(&readings),
        (vec![], vec!["frame number 109 again, or too late"])
    );
    // Two packets change places.
    let mut shuffled = bench.packets(111);
    shuffled.swap(7, 8);
    let readings = bench.feed_packets(&shuffled);
    assert_eq!(summary(&readings).0, all_firsts()[..7]);
    let next = bench.packets(112);
    let readings = bench.feed_packets(&next);
    assert_eq!(summary(&readings).0, all_firsts());
}

#[test]
fn parts_that_arrive_together_are_a_drives_time_apart() {
    let mut bench = Bench::new("lines");
    let line = bench.line();
    for _ in 0..12 {
        bench.feed_line(&line);
    }
    let half = line.len() / 2;
    let readings = bench.feed([&line.as_bytes()[..half], &line.as_bytes()[half..]]);
    let times: Vec<Nanos> = readings
        .iter()
        .filter_map(|reading| match reading {
            SourceReading::Part(part) => Some(part.t_ns),
            _ => None,
        })
        .collect();
    assert_eq!(times.len(), DRIVES);
    assert!(times.windows(2).all(|pair| pair[0] <= pair[1]), "{times:?}");
    assert_eq!(*times.last().expect("some"), bench.now_ns);
    let distinct: std::collections::BTreeSet<Nanos> = times.into_iter().collect();
    assert!(distinct.len() > 2, "{distinct:?}");
}

#[test]
fn the_format_decides_whether_parts_are_wanted() {
    let mut bench = Bench::new("lines:whole");
    for _ in 0..12 {
        let line = bench.line();
        let readings = bench.feed_line(&line);
        let is_part = |reading: &SourceReading| matches!(reading, SourceReading::Part(_));
        assert!(!readings.iter().any(is_part));
    }
}
