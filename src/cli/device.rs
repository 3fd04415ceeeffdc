//! `gelpad device`: a simulated board on a pseudo-terminal.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::Builder;
use std::time::Duration;

use anyhow::Context as _;

use super::args::{DeviceArgs, LayoutArg};
use super::exit::Ending;
use super::message::say;
use crate::app::pads::load_pad;
use crate::app::source::load_script;
use crate::eit::order::Layout;
use crate::pad::Pad;
use crate::platform::signals::Signals;
use crate::source::board::{
    Board, BoardSettings, BoardSignal, CableFaults, LostElectrode, ServePlan, serve,
};
use crate::source::wire::{FormatChoice, WireFormat};

/// Period of the checks for signals.
const PERIOD: Duration = Duration::from_millis(30);

pub(super) fn device(args: &DeviceArgs) -> anyhow::Result<Ending> {
    let pad = load_pad(&args.pad)?.pad;
    let script = load_script(args.script.as_deref(), &pad)?;
    let board = board(args, args.format, &pad)?;
    let plan = plan(args, &pad)?;
    let noise = (args.snr, args.seed);
    let lost = lost_electrode(args, &pad)?;
    let mut signal = BoardSignal::new(&pad, &script, noise, args.drift / 100.0, lost)?;
    let signals = Signals::listen()?;
    say(&format!(
        "{} with the pad {}; Ctrl-C ends it",
        board_name(args.format),
        pad.name
    ));
    let stop = Arc::new(AtomicBool::new(false));
    let stopping = Arc::clone(&stop);
    let served = Builder::new()
        .name("board".to_owned())
        .spawn(move || serve(board, &mut signal, plan, &stopping, &mut say))
        .context("cannot start a thread")?;
    let mut received = None;
    while !served.is_finished() {
        if let Some(signal) = signals.received() {
            received = Some(signal);
            stop.store(true, Ordering::Relaxed);
        }
        std::thread::sleep(PERIOD);
    }
    let port = args.port.as_deref();
    let port = port.map_or("".into(), |path| path.to_string_lossy());
    let served = served
        .join()
        .map_err(|_| anyhow::anyhow!("a bug in gelpad ended the board's thread"))?
        .with_context(|| format!("port {port}"))?;
    say(&format!(
        "{} frames, {} bytes sent; {} bytes lost, {} bits flipped; opened {} times, hung up {} times",
        served.frames,
        served.bytes,
        served.lost_bytes,
        served.turned_bits,
        served.opened,
        served.hang_ups
    ));
    Ok(received.map_or(Ending::Done, Ending::Signal))
}

/// A board of a format with its article.
fn board_name(format: FormatChoice) -> String {
    match format.kind {
        Some(WireFormat::OpenEit) => "an OpenEIT board".to_owned(),
        Some(WireFormat::Sciospec) => "a Sciospec board".to_owned(),
        _ => format!("a board with the format {format}"),
    }
}

/// Port, rate and faults of the board.
fn plan(args: &DeviceArgs, pad: &Pad) -> anyhow::Result<ServePlan> {
    let other_board = match &args.between {
        Some(interval) => Some((board(args, interval.format, pad)?, interval.every)),
        None => None,
    };
    Ok(ServePlan {
        link: args.port.clone(),
        frames_per_s: (args.rate > 0.0).then_some(args.rate),
        in_turn: !args.moments,
        baud: args.baud,
        frames: args.frames,
        faults: CableFaults {
            lost_bytes: args.lose_bytes / 100.0,
            flipped_bits: args.flip_bits / 100.0,
            half_frames: args.half_frames / 100.0,
            pause: args.pause,
            hang_up: args.hang_up,
        },
        other_board,
        seed: args.seed,
    })
}

fn lost_electrode(args: &DeviceArgs, pad: &Pad) -> anyhow::Result<Option<LostElectrode>> {
    let Some(lost) = args.lose_electrode else {
        return Ok(None);
    };
    let electrodes = pad.protocol.electrodes;
    anyhow::ensure!(
        lost.number <= electrodes,
        "the pad {} has no electrode {}: choose 1 to {electrodes}",
        pad.name,
        lost.number
    );
    Ok(Some(LostElectrode {
        electrode: lost.number - 1,
        from_ns: (lost.from_s * 1e9) as u64,
    }))
}

/// A board that reads a pad and sends a format.
fn board(args: &DeviceArgs, format: FormatChoice, pad: &Pad) -> anyhow::Result<Board> {
    let Some(kind) = format.kind else {
        anyhow::bail!("a board sends one format: choose it, for example --format gelpad");
    };
    let declared = format.order.unwrap_or_default();
    let plain = BoardSettings::new(kind);
    let layout = match args.layout {
        Some(LayoutArg::Full) => Some(Layout::Adjacent),
        Some(LayoutArg::Half) => Some(Layout::AdjacentHalf),
        Some(LayoutArg::Square) => Some(Layout::Square),
        Some(LayoutArg::Opposite) => Some(Layout::Opposite),
        // Only a known layout can be rotated.
        None if declared.rotated => plain
            .layout
            .or(Layout::from_count(pad.channels(), pad.protocol.electrodes)),
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
            by_drive: args.by_drive,
            menu: plain.menu && !args.no_menu,
            seed: args.seed,
            ..plain
        },
    )?)
}
