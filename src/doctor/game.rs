//! What a game sees of gelpad's gamepad, by a library that games use.

use std::thread::sleep;
use std::time::Duration;

use gilrs::{Axis, Button, Gamepad, Gilrs};

use super::Line;
use super::delay::now;
use crate::output::uinput::{PAD_PRODUCT, PAD_VENDOR};

const SUBJECT: &str = "seen by a game";
/// The library learns of a new device by way of udev.
const PATIENCE: Duration = Duration::from_secs(1);
const LOOK: Duration = Duration::from_millis(20);

const BUTTONS: [Button; 15] = [
    Button::South,
    Button::East,
    Button::West,
    Button::North,
    Button::LeftTrigger,
    Button::RightTrigger,
    Button::Select,
    Button::Start,
    Button::Mode,
    Button::LeftThumb,
    Button::RightThumb,
    Button::DPadUp,
    Button::DPadDown,
    Button::DPadLeft,
    Button::DPadRight,
];
const STICKS: [Axis; 4] = [
    Axis::LeftStickX,
    Axis::LeftStickY,
    Axis::RightStickX,
    Axis::RightStickY,
];
const TRIGGERS: [Button; 2] = [Button::LeftTrigger2, Button::RightTrigger2];

/// Looks for the pad while it is there.
pub(super) fn sees() -> Line {
    let mut gilrs = match Gilrs::new() {
        Ok(gilrs) => gilrs,
        Err(error) => return Line::note(SUBJECT, format!("gilrs does not start ({error})")),
    };
    let start = now();
    loop {
        while gilrs.next_event().is_some() {}
        let own = |(_, pad): &(_, Gamepad<'_>)| {
            (pad.vendor_id(), pad.product_id()) == (Some(PAD_VENDOR), Some(PAD_PRODUCT))
        };
        if let Some((_, pad)) = gilrs.gamepads().find(own) {
            return judge(pad.name(), missing(&pad));
        }
        if start.elapsed() > PATIENCE {
            return judge_unseen();
        }
        sleep(LOOK);
    }
}

/// What the library's map of the pad lacks.
fn missing(pad: &Gamepad<'_>) -> Vec<String> {
    let buttons = BUTTONS.iter().chain(&TRIGGERS);
    let buttons = buttons.filter(|button| pad.button_code(**button).is_none());
    let sticks = STICKS.iter().filter(|axis| pad.axis_code(**axis).is_none());
    buttons
        .map(|button| format!("{button:?}"))
        .chain(sticks.map(|axis| format!("{axis:?}")))
        .collect()
}

fn judge(name: &str, missing: Vec<String>) -> Line {
    if missing.is_empty() {
        let (buttons, triggers) = (BUTTONS.len(), TRIGGERS.len());
        return Line::ok(
            SUBJECT,
            format!("{name}, with {buttons} buttons, 2 sticks and {triggers} triggers (gilrs)"),
        );
    }
    Line::wrong(
        SUBJECT,
        format!("{name}, without {} (gilrs)", missing.join(", ")),
        "unset SDL_GAMECONTROLLERCONFIG, which maps it otherwise",
    )
}

fn judge_unseen() -> Line {
    Line::wrong(
        SUBJECT,
        "nothing: gilrs finds no such gamepad",
        "sudo usermod -aG input $USER, and log in again; without udev set GILRS_DISABLE_UDEV=1",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::State;

    #[test]
    fn a_pad_without_a_button_is_no_pad() {
        assert_eq!(judge("pad", Vec::new()).state, State::Ok);
        let line = judge("pad", vec!["DPadUp".to_owned()]);
        assert!(line.state == State::Wrong && line.found.contains("DPadUp"));
        assert_eq!(judge_unseen().state, State::Wrong);
    }
}
