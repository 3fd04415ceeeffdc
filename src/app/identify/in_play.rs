//! Identifies the pad while a game is played: play starts with what is known, and the pad as it is comes in between two touches.
//!
//! ```text
//! engine ─frames of an untouched second─▶ thread of low priority ─builder, notice─▶ PadIdentifier ─command─▶ engine
//! ```
//! What is known is tried first: the pad in use, then the one that was identified on this board before. Only readings that neither
//! explains are identified again; those that no pad explains leave the drawing in use.

use std::sync::Arc;
use std::time::Duration;

use rtrb::{Consumer, Producer, RingBuffer};

use super::kept::KeptPad;
use super::untouched::{UntouchedFrames, UntouchedWindow};
use super::{beside_each_other, text_with};
use crate::app::pads::PadText;
use crate::app::table_solver::{TableInProgress, low_priority_threads};
use crate::cache;
use crate::eit::identify::{GOOD_MISFIT, identify, misfit, rest_medians};
use crate::pad::Pad;
use crate::runtime::{PlayCommand, RunningGame, StepListener};
use crate::stats::rms;
use crate::touch::SensingBuilder;
use crate::types::{Method, NANOS_PER_MS, Nanos};

/// Readings at rest that have changed by less than this (root mean square, relative) are not judged again.
const LEAST_CHANGE: f64 = 3e-3;
/// Readings below this share of the largest count as if they were that large.
const LEAST_SHARE: f64 = 0.01;
/// An identified pad must be closer to the readings than the one in use by this factor.
const WORTH_IT: f64 = 0.7;
/// Time between two judgements at first; it doubles with each, so that a gel that dries is followed, but not all the time.
const FIRST_PAUSE_NS: Nanos = 4000 * NANOS_PER_MS;
/// How often the thread looks for the next window, and for a table that is being solved.
const POLL: Duration = Duration::from_millis(50);
/// Windows that may wait to be judged, and results for the game.
const WINDOWS: usize = 1;
const CHANGES: usize = 4;

/// What the thread starts from.
pub(in crate::app) struct Identification {
    drawing: PadText,
    kept: Option<KeptPad>,
    /// The pad with which touches are located now.
    in_use: Pad,
    /// Whether another pad can come in: a recording contains its pad from the start.
    is_fixed: bool,
}

/// A pad to change to, and what to tell the player.
struct Judgement {
    pad: Option<Pad>,
    notice: String,
}

/// A result on its way to the game.
struct Change {
    builder: Option<Box<SensingBuilder>>,
    notice: String,
}

/// Receives what the thread finds.
pub(crate) struct PadIdentifier {
    changes: Consumer<Change>,
}

impl PadIdentifier {
    /// Hands over a pad that was identified since the last call, and tells the player.
    pub(crate) fn poll(&mut self, running: &mut RunningGame, say: &mut dyn FnMut(String)) {
        while let Ok(Change { builder, notice }) = self.changes.pop() {
            if let Some(builder) = builder
                && !running.send_command(PlayCommand::Pad(builder))
            {
                tracing::warn!("the engine is busy: the identified pad is not used now");
            }
            say(notice);
        }
    }
}

impl Identification {
    /// For a drawing on a board. A board with a serial number starts with the pad that was identified on it before; on others the
    /// kept pad is tried first, since another board may be at the same port.
    pub(in crate::app) fn new(drawing: PadText, board: &str, has_serial: bool) -> (Self, PadText) {
        let kept = KeptPad::new(&drawing.pad, board);
        let known = kept
            .as_ref()
            .filter(|_| has_serial)
            .and_then(|kept| kept.load(&drawing.pad));
        let start = known.unwrap_or_else(|| drawing.clone());
        let identification = Self {
            drawing,
            kept,
            in_use: start.pad.clone(),
            is_fixed: false,
        };
        (identification, start)
    }

    /// For a game that is recorded: what is identified is used from the next start on.
    pub(in crate::app) fn for_next_start(mut self) -> Self {
        self.is_fixed = true;
        self
    }

    /// Starts the thread; it ends with the game. `table` is the drawing's table if it is being solved.
    pub(in crate::app) fn start(
        self,
        method: Method,
        table: Option<Arc<TableInProgress>>,
    ) -> std::io::Result<(Box<dyn StepListener>, PadIdentifier)> {
        let (windows_in, windows) = RingBuffer::new(WINDOWS);
        let (changes_in, changes) = RingBuffer::new(CHANGES);
        let listener = UntouchedFrames::new(windows_in, self.drawing.pad.channels());
        std::thread::Builder::new()
            .name("identify".to_owned())
            .spawn(move || {
                while table.as_ref().is_some_and(|table| !table.has_ended()) {
                    std::thread::sleep(POLL);
                }
                self.run(method, windows, changes_in);
            })?;
        Ok((Box::new(listener), PadIdentifier { changes }))
    }

    fn run(
        mut self,
        method: Method,
        mut windows: Consumer<UntouchedWindow>,
        mut changes: Producer<Change>,
    ) {
        let Ok(threads) = low_priority_threads() else {
            return;
        };
        let mut judged: Vec<f64> = Vec::new();
        let (mut next_ns, mut pause_ns) = (0, FIRST_PAUSE_NS);
        while !windows.is_abandoned() {
            let Ok(window) = windows.pop() else {
                std::thread::sleep(POLL);
                continue;
            };
            let (mut volts, mut deviations) = rest_medians(&window.frames);
            for channel in window.left_out {
                volts[channel] = f64::NAN;
                deviations[channel] = f64::INFINITY;
            }
            if window.end_ns < next_ns || !has_changed(&volts, &judged) {
                continue;
            }
            let change = threads.install(|| {
                let Judgement { pad, notice } = self.judge(&volts, &deviations)?;
                let builder = pad.and_then(|pad| self.builder(&pad, method));
                Some(Change { builder, notice })
            });
            next_ns = window.end_ns.saturating_add(pause_ns);
            pause_ns = pause_ns.saturating_mul(2);
            judged = volts;
            if change.is_some_and(|change| changes.push(change).is_err()) {
                tracing::warn!("the game does not take what was identified");
            }
        }
    }

    /// What to do about readings at rest; `None` if the pad in use explains them.
    fn judge(&mut self, volts: &[f64], deviations: &[f64]) -> Option<Judgement> {
        let own = misfit(&self.in_use, volts).ok()?;
        tracing::debug!("readings at rest: {:.2} % off", 100.0 * own);
        if own <= GOOD_MISFIT {
            return None;
        }
        let kept = self
            .kept
            .as_ref()
            .and_then(|kept| kept.load(&self.drawing.pad));
        if let Some(kept) = kept.filter(|kept| kept.pad != self.in_use)
            && let Ok(as_before) = misfit(&kept.pad, volts)
            && as_before <= GOOD_MISFIT
        {
            let notice = format!(
                "this pad was identified before: its readings are {:.1} % off as drawn, {:.2} % as identified",
                100.0 * own,
                100.0 * as_before
            );
            return Some(self.change_to(kept.pad, notice));
        }
        let found = match identify(&self.drawing.pad, volts, deviations, &beside_each_other) {
            Ok(found) => found,
            Err(error) => {
                let notice = format!("the pad is played as drawn: {error}");
                let drawing = self.drawing.pad.clone();
                if self.in_use == drawing {
                    return Some(Judgement { pad: None, notice });
                }
                // Where an electrode is lost, the pad as identified still explains the other readings better.
                let is_closer = misfit(&drawing, volts).is_ok_and(|as_drawn| as_drawn < own);
                return is_closer.then(|| self.change_to(drawing, notice));
            }
        };
        if found.misfit[1] > WORTH_IT * own {
            return None;
        }
        let toml = text_with(&self.drawing.toml, &found.pad)?;
        // As the text rounds it, so that the next start has the same pad.
        let pad = Pad::from_toml(&self.drawing.pad.name, &toml).ok()?;
        let notice = format!(
            "pad identified: its readings are {:.1} % off as drawn, {:.2} % as identified",
            100.0 * found.misfit[0],
            100.0 * found.misfit[1]
        );
        let identified = PadText { pad, toml };
        if let Some(kept) = &self.kept {
            kept.store(&identified);
        }
        Some(self.change_to(identified.pad, notice))
    }

    fn change_to(&mut self, pad: Pad, notice: String) -> Judgement {
        if self.is_fixed {
            return Judgement {
                pad: None,
                notice: format!("{notice}; not used in this game, since it is recorded"),
            };
        }
        self.in_use = pad.clone();
        Judgement {
            pad: Some(pad),
            notice,
        }
    }

    /// The sensing of a pad, with its table from the cache or solved now.
    fn builder(&self, pad: &Pad, method: Method) -> Option<Box<SensingBuilder>> {
        cache::sensing_builder(pad, method, |_, _| ())
            .inspect_err(|error| tracing::warn!("the identified pad is not used: {error}"))
            .ok()
            .map(Box::new)
    }
}

/// Whether readings differ from those judged before by more than noise and drift that do not matter.
fn has_changed(volts: &[f64], judged: &[f64]) -> bool {
    if judged.is_empty() {
        return true;
    }
    let largest = judged
        .iter()
        .fold(0.0f64, |most, volt| most.max(volt.abs()));
    let changes = volts
        .iter()
        .zip(judged)
        .map(|(now, before)| (now - before) / before.abs().max(LEAST_SHARE * largest));
    rms(changes.filter(|change| change.is_finite())) > LEAST_CHANGE
}
