//! A gamepad is made for a moment, pressed, and read back as a game would.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;
use std::sync::mpsc::sync_channel;
use std::thread::{Builder, sleep};
use std::time::{Duration, Instant};

use evdev::EventType;

use super::Line;
use super::delay::{Delay, ROUNDS, now};
use super::node::Node;
use crate::output::uinput::PAD_NAME;
use crate::output::{Device as _, OutputError, Uinput};
use crate::types::{Action, Button, Event, Output};

const SUBJECT: &str = "test gamepad";
/// udev needs a moment to let the user read a new device.
const PATIENCE: Duration = Duration::from_secs(1);
const LOOK: Duration = Duration::from_millis(20);
/// Between two presses: a reader is asleep when one comes, as a game is.
const PAUSE: Duration = Duration::from_millis(1);
const INPUTS: &str = "/sys/class/input";

/// What became of it.
#[derive(Debug)]
pub(super) enum Tried {
    /// It was not: `/dev/uinput` is not to be had.
    No,
    /// The kernel refused it.
    Refused(String),
    /// It was made.
    Made {
        /// Its name under `/dev/input`.
        node: Option<String>,
        read_back: Result<Option<Delay>, String>,
        /// What a game saw, if one was asked.
        game: Option<Line>,
    },
}

impl Tried {
    pub(super) fn works(&self) -> bool {
        matches!(self, Self::Made { .. })
    }
}

pub(super) fn look(node: &Node) -> Tried {
    if *node != Node::Writable {
        return Tried::No;
    }
    let before = inputs();
    let mut pad = match Uinput::create() {
        Ok(pad) => pad,
        Err(error) => return Tried::Refused(error.to_string()),
    };
    let Some(node) = wait_for(|| fresh(&before)) else {
        return Tried::Made {
            node: None,
            read_back: Err("the kernel shows no device: a container?".to_owned()),
            game: None,
        };
    };
    let path = PathBuf::from("/dev/input").join(&node);
    let mut why = String::new();
    let device = wait_for(|| match evdev::Device::open(&path) {
        Ok(device) => Some(device),
        Err(error) => {
            why = error.to_string();
            None
        }
    });
    Tried::Made {
        read_back: match device {
            Some(device) => measure(&mut pad, device),
            None => Err(why),
        },
        #[cfg(feature = "gilrs")]
        game: Some(super::game::sees()),
        #[cfg(not(feature = "gilrs"))]
        game: None,
        node: Some(node),
    }
}

/// Event devices.
fn inputs() -> BTreeSet<String> {
    let Ok(entries) = fs::read_dir(INPUTS) else {
        return BTreeSet::new();
    };
    entries
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| name.starts_with("event"))
        .collect()
}

/// The gamepad among the devices that have come since.
fn fresh(before: &BTreeSet<String>) -> Option<String> {
    let is_pad = |node: &String| {
        let name = fs::read_to_string(format!("{INPUTS}/{node}/device/name"));
        name.is_ok_and(|name| name.trim() == PAD_NAME)
    };
    inputs()
        .into_iter()
        .find(|node| !before.contains(node) && is_pad(node))
}

fn wait_for<T>(mut look: impl FnMut() -> Option<T>) -> Option<T> {
    let start = now();
    loop {
        let found = look();
        if found.is_some() || start.elapsed() > PATIENCE {
            return found;
        }
        sleep(LOOK);
    }
}

/// Presses again and again; another thread reads, as a game does.
fn measure(pad: &mut Uinput, mut device: evdev::Device) -> Result<Option<Delay>, String> {
    let (seen, sees) = sync_channel::<Instant>(1);
    // Reads as many reports as are sent, then ends.
    let reader = Builder::new().name("reader".to_owned()).spawn(move || {
        let mut left = 2 * ROUNDS;
        while left > 0 {
            let Ok(events) = device.fetch_events() else {
                return;
            };
            let at = now();
            let reports = events.filter(|event| event.event_type() == EventType::SYNCHRONIZATION);
            for _ in reports {
                left = left.saturating_sub(1);
                if seen.send(at).is_err() {
                    return;
                }
            }
        }
    });
    let reader = reader.map_err(|error| error.to_string())?;
    let mut times = Vec::with_capacity(2 * ROUNDS);
    let output = Output::Button(Button::RightStick);
    for _ in 0..ROUNDS {
        for action in [Action::Press(output), Action::Release(output)] {
            sleep(PAUSE);
            let start = now();
            press(pad, action).map_err(|error| error.to_string())?;
            match sees.recv_timeout(PATIENCE) {
                Ok(at) => times.push(at.saturating_duration_since(start)),
                // The reader still waits for an event: it ends with the device.
                Err(_) => return Err("a press did not come back".to_owned()),
            }
        }
    }
    drop(sees);
    let _ = reader.join();
    Ok(Delay::of(times))
}

fn press(pad: &mut Uinput, action: Action) -> Result<(), OutputError> {
    pad.send(&Event { t_ns: 0, action })?;
    pad.flush()
}

pub(super) fn judge(tried: &Tried) -> Vec<Line> {
    let (node, read_back, game) = match tried {
        Tried::No => return vec![Line::note(SUBJECT, "not tried: see above")],
        Tried::Refused(why) => {
            return vec![Line::wrong(
                SUBJECT,
                format!("the kernel refused it ({why})"),
                "sudo modprobe -r uinput, then sudo modprobe uinput",
            )];
        }
        Tried::Made {
            node,
            read_back,
            game,
        } => (node, read_back, game),
    };
    let name = node
        .as_ref()
        .map_or(String::new(), |node| format!(" as /dev/input/{node}"));
    let line = match read_back {
        Ok(delay) => {
            let delay = delay.map_or(String::new(), |delay| format!("; write to read: {delay}"));
            Line::ok(SUBJECT, format!("made{name} and read back{delay}"))
        }
        Err(why) => Line::note(SUBJECT, format!("made{name}, but not read back ({why})")).mend(
            "sudo usermod -aG input $USER, and log in again: games that may not read it see no gamepad",
        ),
    };
    std::iter::once(line).chain(game.clone()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::State;

    #[test]
    fn a_pad_that_cannot_be_made_or_read_is_named() {
        assert_eq!(judge(&Tried::No)[0].state, State::Note);
        let refused = &judge(&Tried::Refused("no space".to_owned()))[0];
        assert!(refused.state == State::Wrong && refused.found.contains("no space"));
        let unread = Tried::Made {
            node: Some("event7".to_owned()),
            read_back: Err("Permission denied".to_owned()),
            game: None,
        };
        assert!(unread.works(), "games of others may read it");
        let line = &judge(&unread)[0];
        assert!(
            line.mend
                .as_ref()
                .is_some_and(|mend| mend.contains("-aG input"))
        );
    }
}
