//! Creates a test gamepad, presses a button and reads it back as a game would.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;
use std::sync::mpsc::sync_channel;
use std::thread::{Builder, sleep};
use std::time::{Duration, Instant};

use evdev::EventType;

use super::delay::{Delay, ROUNDS, now};
use super::node::Node;
use crate::doctor::CheckLine;
use crate::output::{OutputDevice as _, OutputError};
use crate::platform::linux::uinput::{PAD_NAME, Uinput};
use crate::types::{Action, Button, Event, Output};

const SUBJECT: &str = "test gamepad";
/// Longest wait until udev gives access to a new device.
const TIMEOUT: Duration = Duration::from_secs(1);
const POLL_PERIOD: Duration = Duration::from_millis(20);
/// Between presses, so that the reader sleeps when one arrives, as a game does.
const PAUSE: Duration = Duration::from_millis(1);
const INPUTS: &str = "/sys/class/input";

/// Result of the test.
#[derive(Debug)]
pub(super) enum PadTest {
    /// Skipped: `/dev/uinput` is not writable.
    Skipped,
    /// The kernel refused to create a gamepad.
    Refused(String),
    /// The gamepad was created.
    Created {
        /// Its name under `/dev/input`.
        node: Option<String>,
        read_back: Result<Option<Delay>, String>,
        /// Result of the check through gilrs.
        game: Option<CheckLine>,
    },
}

impl PadTest {
    pub(super) fn works(&self) -> bool {
        matches!(self, Self::Created { .. })
    }
}

pub(super) fn examine(node: &Node) -> PadTest {
    if *node != Node::Writable {
        return PadTest::Skipped;
    }
    let before = event_devices();
    let mut pad = match Uinput::create() {
        Ok(pad) => pad,
        Err(error) => return PadTest::Refused(error.to_string()),
    };
    let Some(node) = wait_for(|| new_gamepad(&before)) else {
        return PadTest::Created {
            node: None,
            read_back: Err("its device file is missing (a container?)".to_owned()),
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
    PadTest::Created {
        read_back: match device {
            Some(device) => measure_delay(&mut pad, device),
            None => Err(why),
        },
        #[cfg(gamepads)]
        game: Some(super::game::check_gilrs()),
        #[cfg(not(gamepads))]
        game: None,
        node: Some(node),
    }
}

/// Names of all event devices.
fn event_devices() -> BTreeSet<String> {
    let Ok(entries) = fs::read_dir(INPUTS) else {
        return BTreeSet::new();
    };
    entries
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| name.starts_with("event"))
        .collect()
}

/// The gamepad among the devices that are new.
fn new_gamepad(before: &BTreeSet<String>) -> Option<String> {
    let is_pad = |node: &String| {
        let name = fs::read_to_string(format!("{INPUTS}/{node}/device/name"));
        name.is_ok_and(|name| name.trim() == PAD_NAME)
    };
    event_devices()
        .into_iter()
        .find(|node| !before.contains(node) && is_pad(node))
}

fn wait_for<T>(mut find: impl FnMut() -> Option<T>) -> Option<T> {
    let start = now();
    loop {
        let found = find();
        if found.is_some() || start.elapsed() > TIMEOUT {
            return found;
        }
        sleep(POLL_PERIOD);
    }
}

/// Presses a button [`ROUNDS`] times while another thread reads, as a game does.
fn measure_delay(pad: &mut Uinput, mut device: evdev::Device) -> Result<Option<Delay>, String> {
    let (sender, receiver) = sync_channel::<Instant>(1);
    // Ends after as many reports as are sent.
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
                if sender.send(at).is_err() {
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
            match receiver.recv_timeout(TIMEOUT) {
                Ok(at) => times.push(at.saturating_duration_since(start)),
                // The reader still waits for an event; it ends with the device.
                Err(_) => return Err("a press was not received".to_owned()),
            }
        }
    }
    drop(receiver);
    let _ = reader.join();
    Ok(Delay::of(times))
}

fn press(pad: &mut Uinput, action: Action) -> Result<(), OutputError> {
    pad.send(&Event { t_ns: 0, action })?;
    pad.flush()
}

pub(super) fn judge(test: &PadTest) -> Vec<CheckLine> {
    let (node, read_back, game) = match test {
        PadTest::Skipped => return vec![CheckLine::note(SUBJECT, "skipped: see above")],
        PadTest::Refused(why) => {
            return vec![CheckLine::wrong(
                SUBJECT,
                format!("the kernel refused to create it ({why})"),
                "sudo modprobe -r uinput, then sudo modprobe uinput",
            )];
        }
        PadTest::Created {
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
            CheckLine::ok(SUBJECT, format!("created{name} and read back{delay}"))
        }
        Err(why) => CheckLine::note(SUBJECT, format!("created{name}, but not readable ({why})")).with_fix(
            "sudo usermod -aG input $USER, then log in again: without read access, games see no gamepad",
        ),
    };
    std::iter::once(line).chain(game.clone()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::CheckStatus;

    #[test]
    fn gamepads_that_cannot_be_created_or_read_are_reported() {
        assert_eq!(judge(&PadTest::Skipped)[0].state, CheckStatus::Note);
        let refused = &judge(&PadTest::Refused("no space".to_owned()))[0];
        assert!(refused.state == CheckStatus::Wrong && refused.found.contains("no space"));
        let unread = PadTest::Created {
            node: Some("event7".to_owned()),
            read_back: Err("Permission denied".to_owned()),
            game: None,
        };
        assert!(unread.works(), "other programs may be able to read it");
        let line = &judge(&unread)[0];
        assert!(
            line.fix
                .as_ref()
                .is_some_and(|fix| fix.contains("-aG input"))
        );
    }
}
