//! `gelpad device`: a simulated board on a pseudo-terminal.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::Builder;
use std::time::Duration;

use anyhow::Context as _;

use super::args::{DeviceArgs, LayoutArg};
use super::exit::Ending;
use super::play::Signals;
use super::resolve;
use crate::eit::order::Layout;
use crate::pad::Pad;
use crate::source::board::{
    Board, BoardSettings, Every, Faults, LostElectrode, Plan, Signal, serve,
};
use crate::source::wire::Format;
use crate::source::{LEVEL_SCRIPT, Script};

/// How often signals are looked at.
const LOOK: Duration = Duration::from_millis(30);

pub(super) fn device(args: &DeviceArgs) -> anyhow::Result<Ending> {
    let pad = resolve::pad(&args.pad)?;
    let script = match &args.script {
        Some(path) => Script::parse(&path.display().to_string(), &resolve::read(path)?)?,
        None => Script::parse("level", LEVEL_SCRIPT)?,
    };
    let board = wired(args, args.format, &pad)?;
    let between = match &args.between {
        Some(Between(format, every)) => Some((wired(args, *format, &pad)?, *every)),
        None => None,
    };
    let lost = match args.lose_electrode {
        Some(Loose { electrode, from_s }) if electrode < pad.protocol.electrodes => {
            Some(LostElectrode {
                electrode,
                from_ns: (from_s * 1e9) as u64,
            })
        }
        Some(Loose { electrode, .. }) => anyhow::bail!(
            "the pad {} has no electrode {electrode}: they are 0 to {}",
            pad.name,
            pad.protocol.electrodes - 1
        ),
        None => None,
    };
    let mut signal = Signal::new(
        &pad,
        &script,
        (args.snr, args.seed),
        args.drift / 100.0,
        lost,
    )?;
    let plan = Plan {
        link: args.port.clone(),
        frames_per_s: (args.rate > 0.0).then_some(args.rate),
        frames: args.frames,
        faults: Faults {
            lost_bytes: args.lose_bytes / 100.0,
            turned_bits: args.flip_bits / 100.0,
            half_frames: args.half_frames / 100.0,
            pause: args.pause,
            hang_up: args.hang_up,
        },
        between,
        seed: args.seed,
    };
    let signals = Signals::listen()?;
    let stop = Arc::new(AtomicBool::new(false));
    let stopping = Arc::clone(&stop);
    let name = args.format.to_string();
    say(&format!(
        "a {name} board with the pad {}; Ctrl-C ends it",
        pad.name
    ));
    let served = Builder::new()
        .name("board".to_owned())
        .spawn(move || serve(board, &mut signal, plan, &stopping, &mut say))
        .context("no thread for the board")?;
    let mut received = None;
    while !served.is_finished() {
        if let Some(signal) = signals.received() {
            received = Some(signal);
            stop.store(true, Ordering::Relaxed);
        }
        std::thread::sleep(LOOK);
    }
    let served = served
        .join()
        .map_err(|_| anyhow::anyhow!("a bug in gelpad ended the board's thread"))?
        .with_context(|| {
            format!(
                "port {}",
                args.port
                    .as_deref()
                    .map_or("".into(), |path| path.to_string_lossy())
            )
        })?;
    say(&format!(
        "{} frames, {} bytes sent; {} bytes lost, {} bits turned; opened {} times, hung up {} times",
        served.frames,
        served.bytes,
        served.lost_bytes,
        served.turned_bits,
        served.opened,
        served.hang_ups
    ));
    Ok(received.map_or(Ending::Done, Ending::Signal))
}

fn wired(args: &DeviceArgs, format: Format, pad: &Pad) -> anyhow::Result<Board> {
    let Some(kind) = format.kind else {
        anyhow::bail!("a board speaks one format: write which, as in --format gelpad");
    };
    let declared = format.order.unwrap_or_default();
    let plain = BoardSettings::new(kind);
    let layout = match args.layout {
        Some(LayoutArg::Full) => Some(Layout::Adjacent),
        Some(LayoutArg::Half) => Some(Layout::AdjacentHalf),
        Some(LayoutArg::Square) => Some(Layout::Square),
        Some(LayoutArg::Opposite) => Some(Layout::Opposite),
        // Rotated is meant of a layout.
        None if declared.rotated => plain
            .layout
            .or(Layout::of(pad.channels(), pad.protocol.electrodes)),
        None => plain.layout,
    };
    Ok(Board::new(
        pad,
        &BoardSettings {
            complex: format.complex,
            layout,
            rotated: declared.rotated,
            flipped: declared.flipped,
            counts: args.counts,
            menu: plain.menu && !args.no_menu,
            seed: args.seed,
            ..plain
        },
    )?)
}

/// `FORMAT,S,MS`.
#[derive(Clone, Debug)]
pub(super) struct Between(Format, Every);

impl std::str::FromStr for Between {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (format, every) = text
            .split_once(',')
            .ok_or("write a format, how often and how long, as in openeit,5,500")?;
        Ok(Self(format.parse()?, every.parse()?))
    }
}

/// `N[@S]`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Loose {
    electrode: usize,
    from_s: f64,
}

impl std::str::FromStr for Loose {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (electrode, from_s) = text.split_once('@').unwrap_or((text, "0"));
        match (electrode.parse(), from_s.parse::<f64>()) {
            (Ok(electrode), Ok(from_s)) if (0.0..1e6).contains(&from_s) => {
                Ok(Self { electrode, from_s })
            }
            _ => Err("write an electrode (from 0) and from which second on, as in 5@10".to_owned()),
        }
    }
}

/// A line for whoever waits; a closed stderr is no reason to stop.
fn say(text: &str) {
    use std::io::Write as _;

    let _ = writeln!(std::io::stderr(), "{text}");
}
