//! The simulated board and the decoders: every format over a pseudo-terminal, and every fault.

use std::collections::BTreeSet;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use gelpad::eit::order::Layout;
use gelpad::pad::{Pad, shipped_pad};
use gelpad::source::board::{
    Board, BoardSettings, BoardSignal, CableFaults, FaultyCable, ServePlan, serve,
};
use gelpad::source::serial::{DEFAULT_BAUD, SerialSource};
use gelpad::source::wire::{Decoded, FormatChoice, MOST_HELD_BYTES, WireFormat, Wiring};
use gelpad::source::{SIMULATED_FRAME_NS, Script, Source, SourceReading, plausible_counts};
use rustix::process::{Pid, Signal as Interrupt, kill_process};

const SCRIPT: &str = "t:100 down 1 80 50\nt:180 up 1\nt:200 end";

fn pad(name: &str) -> Pad {
    Pad::from_toml(name, shipped_pad(name).expect("shipped").toml).expect("sound")
}

fn signal(pad: &Pad) -> BoardSignal {
    let script = Script::parse("s", SCRIPT).expect("sound");
    BoardSignal::new(pad, &script, (60.0, 9), 0.0, None).expect("solvable")
}

/// Frames of a signal at the times of a board without a rate.
fn truth(pad: &Pad, frames: usize) -> Vec<Vec<f32>> {
    let mut signal = signal(pad);
    (0..frames)
        .map(|n| signal.read(n as u64 * SIMULATED_FRAME_NS))
        .collect()
}

/// Serves a board on a pseudo-terminal and returns the frames read from it.
fn over_pty(
    pad: &Pad,
    settings: &BoardSettings,
    format: FormatChoice,
    frames: usize,
) -> Vec<Vec<f32>> {
    let folder = tempfile::tempdir().expect("a folder");
    let link = folder.path().join("port");
    let board = Board::new(pad, settings).expect("wired");
    let mut signal = signal(pad);
    let stop = Arc::new(AtomicBool::new(false));
    let stopping = Arc::clone(&stop);
    let plan = ServePlan {
        link: Some(link.clone()),
        frames_per_s: None,
        in_turn: false,
        baud: None,
        frames: None,
        faults: CableFaults::default(),
        other_board: None,
        seed: 1,
    };
    let server = std::thread::Builder::new()
        .spawn(move || serve(board, &mut signal, plan, &stopping, &mut |_| {}).expect("served"))
        .expect("a thread");
    while !link.exists() {
        std::thread::sleep(Duration::from_millis(2));
    }
    let path = link.display().to_string();
    let mut source = SerialSource::open(&path, DEFAULT_BAUD, pad, format).expect("opened");
    let mut got = Vec::new();
    let mut idle = 0;
    while got.len() < frames {
        match source.read().expect("fits the pad") {
            SourceReading::Frame(frame) => got.push(frame.volts),
            SourceReading::Idle => idle += 1,
            other => panic!(
                "{other:?} from a board without faults, after {} frames",
                got.len()
            ),
        }
        assert!(
            idle < 400,
            "{} of {frames} frames and then silence",
            got.len()
        );
    }
    stop.store(true, Ordering::Relaxed);
    drop(source);
    server.join().expect("ended");
    got
}

/// Values as a format with this number of decimals keeps them, in the board's scale.
fn rounded(values: &[Vec<f32>], decimals: usize) -> Vec<Vec<f32>> {
    let keep = |value: &f32| {
        format!("{:.decimals$}", 100.0_f32 * value)
            .parse()
            .expect("a number")
    };
    values
        .iter()
        .map(|frame| frame.iter().map(keep).collect())
        .collect()
}

#[test]
fn each_format_over_a_pty_gives_what_was_measured() {
    const FRAMES: usize = 25;
    let lattice = pad("edinburgh-lattice");
    let sent = truth(&lattice, FRAMES);
    let play =
        |kind: WireFormat| over_pty(&lattice, &BoardSettings::new(kind), kind.into(), FRAMES);
    assert!(play(WireFormat::Gelpad) == sent, "bit for bit");
    assert!(play(WireFormat::Lines) == sent, "bit for bit");
    assert!(
        play(WireFormat::Square) == rounded(&sent, 4),
        "to four decimals"
    );
    assert!(
        play(WireFormat::Request) == rounded(&sent, 5),
        "to five decimals"
    );
    // Differences of potentials that are sums of differences: exact up to the rounding of f32.
    for (got, sent) in play(WireFormat::Sciospec).iter().zip(&sent) {
        let largest = sent.iter().fold(0.0_f32, |most, volt| most.max(volt.abs()));
        for (got, sent) in got.iter().zip(sent) {
            assert!(
                (1e3 * got - sent).abs() <= 3e-6 * largest,
                "{got} of {sent}"
            );
        }
    }
    let spectra = pad("openeit-lattice");
    let magnitudes: Vec<Vec<f32>> = truth(&spectra, FRAMES)
        .iter()
        .map(|frame| frame.iter().map(|volt| volt.abs()).collect())
        .collect();
    let settings = BoardSettings::new(WireFormat::OpenEit);
    let got = over_pty(&spectra, &settings, WireFormat::OpenEit.into(), FRAMES);
    assert!(got == rounded(&magnitudes, 4), "to four decimals");
}

#[test]
fn another_order_of_readings_is_recognised() {
    let lattice = pad("edinburgh-lattice");
    let sent = truth(&lattice, 5);
    for (layout, rotated, flipped) in [
        (Layout::Adjacent, true, false),
        (Layout::Square, true, true),
        (Layout::AdjacentHalf, false, true),
    ] {
        let settings = BoardSettings {
            layout: Some(layout),
            rotated,
            flipped,
            ..BoardSettings::new(WireFormat::Gelpad)
        };
        let got = over_pty(&lattice, &settings, FormatChoice::default(), 5);
        for (got, sent) in got.iter().zip(&sent) {
            for (index, channel) in lattice.protocol.channels.iter().enumerate() {
                let is_there =
                    layout != Layout::AdjacentHalf || channel.measure.0 > channel.drive.0;
                assert!(
                    got[index] == sent[index] || !is_there,
                    "{layout:?}, channel {index}"
                );
            }
        }
    }
}

/// The frames of a stream that arrives in pieces of different lengths.
fn decoded(kind: WireFormat, wiring: &Wiring, stream: &[u8]) -> Vec<Vec<f32>> {
    let mut dialect = kind.dialect(wiring, false);
    let mut found = Vec::new();
    let mut rest = stream;
    let mut size = 1;
    while !rest.is_empty() {
        let (piece, behind) = rest.split_at(size.min(rest.len()));
        dialect.feed(0, piece, &mut found);
        assert!(dialect.held_bytes() <= MOST_HELD_BYTES);
        rest = behind;
        size = size * 7 % 4093 + 1;
    }
    let frame = |one: Decoded| match one {
        Decoded::Frame(frame) => Some(frame.values),
        _ => None,
    };
    found.into_iter().filter_map(frame).collect()
}

/// A stream with faults, followed by undamaged frames: the frames as measured, the bytes, and where the
/// undamaged frames start.
struct Spell {
    wiring: Wiring,
    sent: Vec<Vec<f32>>,
    bytes: Vec<u8>,
    sound_from: usize,
}

const SOUND_FRAMES: usize = 6;

fn spell(kind: WireFormat, faults: CableFaults, frames: usize) -> Spell {
    let name = if kind == WireFormat::OpenEit {
        "openeit-lattice"
    } else {
        "edinburgh-lattice"
    };
    let pad = pad(name);
    let mut board = Board::new(&pad, &BoardSettings::new(kind)).expect("wired");
    let mut signal = signal(&pad);
    let mut cable = FaultyCable::new(faults, 5);
    let mut bytes = board.reset();
    let mut sent = Vec::new();
    for n in 0..frames {
        let volts = signal.read(n as u64 * SIMULATED_FRAME_NS);
        bytes.extend(cable.carry(board.frame(n as u64 * 10_000, &volts)));
        sent.push(volts);
    }
    let sound_from = bytes.len();
    for n in frames..frames + SOUND_FRAMES {
        let volts = signal.read(n as u64 * SIMULATED_FRAME_NS);
        bytes.extend(board.frame(n as u64 * 10_000, &volts));
        sent.push(volts);
    }
    Spell {
        wiring: Wiring::from_pad(&pad),
        sent,
        bytes,
        sound_from,
    }
}

fn bits(frame: &[f32]) -> Vec<u32> {
    frame.iter().map(|value| value.to_bits()).collect()
}

/// Each kind of damage, so heavy that hardly a frame is intact.
fn heavy() -> [CableFaults; 3] {
    [
        CableFaults {
            lost_bytes: 0.01,
            ..CableFaults::default()
        },
        CableFaults {
            flipped_bits: 0.001,
            ..CableFaults::default()
        },
        CableFaults {
            half_frames: 0.5,
            ..CableFaults::default()
        },
    ]
}

#[test]
fn with_a_check_sum_no_wrong_frame_is_accepted() {
    let damage = heavy().into_iter().chain([
        // Light enough that many frames are intact.
        CableFaults {
            lost_bytes: 5e-4,
            flipped_bits: 5e-5,
            half_frames: 0.1,
            ..CableFaults::default()
        },
    ]);
    for faults in damage {
        let Spell {
            wiring,
            sent,
            bytes,
            sound_from,
        } = spell(WireFormat::Gelpad, faults, 3000);
        let known: BTreeSet<Vec<u32>> = sent.iter().map(|frame| bits(frame)).collect();
        let got = decoded(WireFormat::Gelpad, &wiring, &bytes);
        assert!(
            got.iter().all(|frame| known.contains(&bits(frame))),
            "{faults:?}"
        );
        let last = &sent[sent.len() - SOUND_FRAMES..];
        let tail = &got[got.len() - (SOUND_FRAMES - 1)..];
        assert_eq!(tail, &last[1..], "all but the first frame after the damage");
        assert!(decoded(WireFormat::Gelpad, &wiring, &bytes[sound_from..]).len() == SOUND_FRAMES);
    }
}

#[test]
fn without_a_check_sum_no_frame_of_a_wrong_count_is_accepted() {
    for kind in [
        WireFormat::OpenEit,
        WireFormat::Square,
        WireFormat::Request,
        WireFormat::Sciospec,
    ] {
        // The instrument's cycle is learned again after long damage.
        let lost_first = if kind == WireFormat::Sciospec { 2 } else { 1 };
        for faults in heavy() {
            let Spell {
                wiring,
                bytes,
                sound_from,
                ..
            } = spell(kind, faults, 300);
            let whole = decoded(kind, &wiring, &bytes);
            let sound = decoded(kind, &wiring, &bytes[sound_from..]);
            assert_eq!(sound.len(), SOUND_FRAMES, "{kind:?}");
            let tail = SOUND_FRAMES - lost_first;
            assert!(
                whole[whole.len() - tail..] == sound[lost_first..],
                "{kind:?} {faults:?}: other frames"
            );
            // The number of values of a reply is checked against the pad; half of an instrument's drives form
            // a valid cycle.
            let judged = match kind {
                WireFormat::Square => Some(256),
                WireFormat::Sciospec if faults.half_frames == 0.0 => Some(208),
                _ => None,
            };
            if let Some(count) = judged {
                // Six halves and a whole line hold 32 x 32 values, which no pad of 16 electrodes accepts.
                let plausible = plausible_counts(&pad("edinburgh-lattice"));
                let mut taken = whole
                    .iter()
                    .filter(|frame| plausible.contains(&frame.len()));
                assert!(
                    taken.all(|frame| frame.len() == count),
                    "{kind:?} {faults:?}"
                );
            }
        }
    }
}

#[test]
fn another_format_in_mid_stream_gives_no_frame() {
    for kind in [
        WireFormat::Gelpad,
        WireFormat::OpenEit,
        WireFormat::Square,
        WireFormat::Sciospec,
    ] {
        for other in WireFormat::ALL {
            if other == kind {
                continue;
            }
            let ours = spell(kind, CableFaults::default(), 4);
            let alien = spell(other, CableFaults::default(), 20);
            let stream = [&ours.bytes[..], &alien.bytes, &ours.bytes].concat();
            let alone = decoded(kind, &ours.wiring, &ours.bytes);
            let got = decoded(kind, &ours.wiring, &stream);
            let (least, most) = (2 * alone.len() - 2, 2 * alone.len());
            assert!(
                (least..=most).contains(&got.len()),
                "{kind:?} with {other:?}: {}",
                got.len()
            );
            assert_eq!(got[..alone.len()], alone, "{kind:?} before {other:?}");
            let tail = alone.len() - 2;
            assert_eq!(
                got[got.len() - tail..],
                alone[2..],
                "{kind:?} behind {other:?}"
            );
        }
    }
}

/// The programs: lost bytes, flipped bits, half frames, pauses, and a port that disappears and comes back.
#[test]
fn play_continues_through_all_faults_and_holds_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let (port, script) = (
        folder.path().join("port"),
        folder.path().join("touches.txt"),
    );
    std::fs::write(&script, "t:300 down 1 80 50\nt:700 up 1\nt:900 end").expect("written");
    let mut device = Command::new(env!("CARGO_BIN_EXE_gelpad"))
        .args([
            "device", "--format", "gelpad", "--rate", "100", "--frames", "900",
        ])
        .args([
            "--lose-bytes",
            "0.01",
            "--flip-bits",
            "0.001",
            "--half-frames",
            "5",
        ])
        .args(["--pause", "1.5,800", "--hang-up", "3,600", "--script"])
        .arg(&script)
        .arg("--port")
        .arg(&port)
        .stderr(Stdio::piped())
        .spawn()
        .expect("started");
    while !port.exists() {
        std::thread::sleep(Duration::from_millis(10));
    }
    let gelpad = Command::new(env!("CARGO_BIN_EXE_gelpad"))
        .args(["play", "--headless", "--output", "trace", "--source"])
        .arg(format!("serial:{}", port.display()))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("started");
    let sent = device.wait().expect("ended");
    std::thread::sleep(Duration::from_millis(300));
    kill_process(Pid::from_child(&gelpad), Interrupt::TERM).expect("running");
    let output = gelpad.wait_with_output().expect("ended");
    let [trace, told] = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text));
    assert!(sent.success());
    let mut held = BTreeSet::new();
    let mut presses = 0;
    for line in trace.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[1] {
            "press" => {
                presses += 1;
                assert!(held.insert(words[2]), "{line}: it is down\n{trace}");
            }
            "release" => assert!(held.remove(words[2]), "{line}: it is up\n{trace}"),
            _ => {}
        }
    }
    assert!(held.is_empty(), "{held:?} is held\n{trace}");
    assert!(presses >= 5, "{presses} presses\n{trace}\n{told}");
    for expected in [
        "the board speaks gelpad's own packets",
        "skipped input that is not a frame",
        "has been silent for 500 ms: all keys are released",
        "Pad disconnected: waiting for",
        "pad connected again",
        "frames lost",
    ] {
        assert!(told.contains(expected), "{expected:?} is not in:\n{told}");
    }
    assert_eq!(output.status.code(), Some(143), "{told}");
}
