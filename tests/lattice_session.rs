//! Thirty seconds of play from an independent simulator, unchanged and degraded: every press is found and no other.

mod lattice;

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use gelpad::pad::{Channel, DEFAULT_PAD, Pair};
use gelpad::source::{FramesCsv, Noise, Source, SourceReading};
use gelpad::touch::Detector;
use gelpad::types::{Frame, Nanos, TouchId};
use lattice::{Press, builder, data, pad, session_presses};
use serde::Deserialize;

/// A touch within this distance of a press is that press, mm.
const FOUND_MM: f64 = 10.0;
const NANOS_PER_MS: f64 = 1e6;
const NANOS_PER_S: Nanos = 1_000_000_000;
/// Times at which an electrode comes off, s: while a finger lands beside another, 20 ms after the last one lifted, and while two lie there.
/// `GELPAD_FULL=1` tries every second from 6 to 23.
const OFF_AT_S: [Nanos; 3] = [10, 12, 16];
/// Presses within this time after it need not be found.
const EXEMPT_S: f64 = 1.0;

fn session() -> Vec<Frame> {
    let mut source = FramesCsv::open(&data("session.csv"), pad().channels()).expect("the session");
    let mut frames = Vec::new();
    while let SourceReading::Frame(frame) = source.read().expect("a frame") {
        frames.push(frame);
    }
    frames
}

/// A touch from its first frame to its last.
#[derive(Clone, Debug)]
struct Track {
    first_ms: f64,
    last_ms: f64,
    frames: usize,
    sum_mm: [f64; 2],
}

impl Track {
    fn off_mm(&self, press: &Press) -> f64 {
        let [x, y] = self.sum_mm.map(|sum| sum / self.frames as f64);
        (x - press.x).hypot(y - press.y)
    }
}

/// Lost electrodes from a time on, ms.
type Lost = Vec<(f64, Vec<usize>)>;

/// The touches and lost electrodes that the detector reports.
fn played(frames: &[Frame]) -> (BTreeMap<TouchId, Track>, Lost) {
    let first = builder().build_initial().expect("a matrix");
    let mut detector = Detector::for_pad(Arc::new(first), &pad().protocol);
    let mut tracks = BTreeMap::new();
    let mut lost = Lost::new();
    let mut changed = Vec::new();
    for frame in frames {
        detector.process_frame(frame, &mut changed);
        if let Some(deviations) = detector.wanted() {
            let sensing = builder().build(deviations).expect("a matrix");
            detector.set_sensing(Arc::new(sensing));
        }
        let t_ms = frame.t_ns as f64 / NANOS_PER_MS;
        let out = detector.lost_electrodes();
        if lost.last().map(|(_, out)| out) != Some(&out) {
            lost.push((t_ms, out));
        }
        for touch in detector.touches_down() {
            let track = tracks.entry(touch.id).or_insert(Track {
                first_ms: t_ms,
                last_ms: t_ms,
                frames: 0,
                sum_mm: [0.0; 2],
            });
            track.last_ms = t_ms;
            track.frames += 1;
            for (sum, at) in track.sum_mm.iter_mut().zip(touch.contact.centre_mm) {
                *sum += at;
            }
        }
    }
    (tracks, lost)
}

/// Compares tracks with presses: each press is one track in the frames in which it was down, give or take one frame at
/// either end, and no track is left over.
fn compare_with_presses(
    label: &str,
    frames: &[Frame],
    mut tracks: BTreeMap<TouchId, Track>,
    presses: &[Press],
    exempt: impl Fn(&Press) -> bool,
) {
    let frame_ms = (frames[1].t_ns - frames[0].t_ns) as f64 / NANOS_PER_MS;
    let (mut found, mut worst_frames, mut worst_mm) = (0, 0, 0.0f64);
    for press in presses {
        let (t0_ms, t1_ms) = (press.t0 * 1e3, press.t1 * 1e3);
        let during: Vec<f64> = frames
            .iter()
            .map(|frame| frame.t_ns as f64 / NANOS_PER_MS)
            .filter(|t_ms| (t0_ms..t1_ms).contains(t_ms))
            .collect();
        let own: Vec<TouchId> = tracks
            .iter()
            .filter(|(_, track)| {
                track.first_ms < t1_ms + 1.5 * frame_ms
                    && track.last_ms > t0_ms - 1.5 * frame_ms
                    && track.off_mm(press) < FOUND_MM
            })
            .map(|(id, _)| *id)
            .collect();
        if exempt(press) || during.len() < 2 {
            for id in own {
                tracks.remove(&id);
            }
            continue;
        }
        let [id] = own[..] else {
            panic!(
                "{label}: the {} press at {t0_ms} ms is {} touches",
                press.kind,
                own.len()
            );
        };
        let track = tracks.remove(&id).expect("just found");
        let held = ((track.last_ms - track.first_ms) / frame_ms).round() as usize + 1;
        assert_eq!(
            track.frames, held,
            "{label}: the touch at {t0_ms} ms has no hole"
        );
        let off = held.abs_diff(during.len());
        assert!(
            off <= 1,
            "{label}: {off} frames off in length at {t0_ms} ms"
        );
        found += 1;
        worst_frames = worst_frames.max(off);
        worst_mm = worst_mm.max(track.off_mm(press));
    }
    println!(
        "{label}: {found} of {} presses, none false; at worst {worst_frames} frame off in length, {worst_mm:.2} mm off",
        presses.len()
    );
    assert!(tracks.is_empty(), "{label}: made up: {tracks:?}");
}

fn check_session(label: &str, frames: &[Frame]) {
    let (tracks, lost) = played(frames);
    assert!(
        lost.iter().all(|(_, out)| out.is_empty()),
        "{label}: {lost:?}"
    );
    compare_with_presses(label, frames, tracks, &session_presses(), |_| false);
}

#[test]
fn unchanged_and_through_the_command_line() {
    let frames = session();
    check_session("unchanged", &frames);

    #[derive(Deserialize)]
    struct Line {
        t_ms: f64,
        touches: Vec<SeenTouch>,
    }
    #[derive(Deserialize)]
    struct SeenTouch {
        id: u64,
        x_mm: f64,
        y_mm: f64,
    }
    let output = Command::new(env!("CARGO_BIN_EXE_gelpad"))
        .args(["replay", "--pad", DEFAULT_PAD, "--print", "touches"])
        .arg(data("session.csv"))
        .output()
        .expect("started");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let mut tracks = BTreeMap::new();
    for line in String::from_utf8(output.stdout).expect("text").lines() {
        let line: Line = serde_json::from_str(line).expect("a JSON line");
        for seen in line.touches {
            let track = tracks.entry(TouchId(seen.id)).or_insert(Track {
                first_ms: line.t_ms,
                last_ms: line.t_ms,
                frames: 0,
                sum_mm: [0.0; 2],
            });
            track.last_ms = line.t_ms;
            track.frames += 1;
            track.sum_mm[0] += seen.x_mm;
            track.sum_mm[1] += seen.y_mm;
        }
    }
    compare_with_presses("gelpad replay", &frames, tracks, &session_presses(), |_| {
        false
    });
}

#[test]
fn with_45_db() {
    for seed in [1, 2, 3] {
        let mut noise = Noise::new(45.0, seed);
        let frames: Vec<Frame> = session()
            .into_iter()
            .map(|frame| Frame {
                volts: noise.read(
                    &frame
                        .volts
                        .iter()
                        .map(|v| f64::from(*v))
                        .collect::<Vec<_>>(),
                ),
                ..frame
            })
            .collect();
        check_session(&format!("45 dB, seed {seed}"), &frames);
    }
}

#[test]
fn with_ten_percent_of_drift_per_minute() {
    let drifting = |of_channel: &dyn Fn(usize) -> f64| -> Vec<Frame> {
        let drifted = |frame: Frame| {
            let minutes = frame.t_ns as f64 / NANOS_PER_MS / 60e3;
            let volts =
                frame.volts.iter().enumerate().map(|(channel, volt)| {
                    volt * (1.0 + 0.1 * minutes * of_channel(channel)) as f32
                });
            Frame {
                t_ns: frame.t_ns,
                volts: volts.collect(),
            }
        };
        session().into_iter().map(drifted).collect()
    };
    check_session("a common gain rises", &drifting(&|_| 1.0));
    check_session("a common gain falls", &drifting(&|_| -1.0));
    // A different value between -1 and 1 for each channel.
    let own = |channel: usize| ((channel * 7919) % 208) as f64 / 104.0 - 1.0;
    check_session("each channel differently", &drifting(&own));
}

#[test]
fn thinned_to_slow_boards() {
    let all = session();
    for step in [2, 5, 10] {
        for first in 0..step {
            let frames: Vec<Frame> = all.iter().skip(first).step_by(step).cloned().collect();
            check_session(
                &format!("{} frames/s, from frame {first}", 100 / step),
                &frames,
            );
        }
    }
}

/// What the channels of an electrode read that is off.
#[derive(Clone, Copy, Debug)]
enum Reads {
    Nothing,
    /// Noise as large as the largest reading.
    Noise,
}

#[test]
fn with_any_electrode_of_the_first_half_off() {
    off_at_any_time(0..pad().protocol.electrodes / 2);
}

#[test]
fn with_any_electrode_of_the_second_half_off() {
    let electrodes = pad().protocol.electrodes;
    off_at_any_time(electrodes / 2..electrodes);
}

fn off_at_any_time(electrodes: Range<usize>) {
    let times_s = match std::env::var_os("GELPAD_FULL") {
        Some(_) => (6..24).collect(),
        None => OFF_AT_S.to_vec(),
    };
    let session = session();
    for electrode in electrodes {
        for at_s in &times_s {
            for reads in [Reads::Nothing, Reads::Noise] {
                let label = format!("electrode {electrode} off at {at_s} s, reads {reads:?}");
                let frames = with_electrode_off(&session, electrode, at_s * NANOS_PER_S, reads);
                check_electrode_off(&label, &frames, electrode, *at_s as f64);
            }
        }
    }
}

/// The frames with what the channels of an electrode read from a time on.
fn with_electrode_off(
    frames: &[Frame],
    electrode: usize,
    off_at_ns: Nanos,
    reads: Reads,
) -> Vec<Frame> {
    let protocol = pad().protocol;
    let uses_it = |pair: Pair| pair.0 == electrode || pair.1 == electrode;
    let is_off = |channel: usize| {
        let Channel { drive, measure } = protocol.channels[channel];
        uses_it(drive) || uses_it(measure)
    };
    let full_scale = (frames[0].volts.iter()).fold(0.0f32, |most, volt| most.max(volt.abs()));
    // A reading of one with noise, minus one: noise alone.
    let mut noise = Noise::new(0.0, electrode as u64);
    let mut frames = frames.to_vec();
    for frame in frames.iter_mut().filter(|frame| frame.t_ns >= off_at_ns) {
        let wild = noise.read(&vec![1.0; frame.volts.len()]);
        for channel in (0..frame.volts.len()).filter(|channel| is_off(*channel)) {
            frame.volts[channel] = match reads {
                Reads::Nothing => 0.0,
                Reads::Noise => (wild[channel] - 1.0) * full_scale,
            };
        }
    }
    frames
}

/// The electrode is named within a second, and no other; all presses are found but those of that second.
fn check_electrode_off(label: &str, frames: &[Frame], electrode: usize, off_at_s: f64) {
    let (tracks, lost) = played(frames);
    let [(_, before), (at_ms, after)] = &lost[..] else {
        panic!("{label}: {lost:?}");
    };
    let is_named = before.is_empty() && *after == [electrode];
    assert!(is_named, "{label}: {lost:?}");
    assert!(*at_ms <= 1e3 * (off_at_s + 1.0), "{label}: at {at_ms} ms");
    let exempt = |press: &Press| press.t0 < off_at_s + EXEMPT_S && press.t1 > off_at_s;
    compare_with_presses(label, frames, tracks, &session_presses(), exempt);
}

#[test]
fn the_session_is_complete() {
    assert!(Path::new(&data("session.csv")).is_file());
    assert_eq!((session().len(), session_presses().len()), (3000, 42));
}
