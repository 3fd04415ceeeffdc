//! Whether gelpad's gamepad is complete for a game: looked up through gilrs, a gamepad library that games use.

use std::thread::sleep;
use std::time::Duration;

use gilrs::{Axis, Button, Gamepad, Gilrs};

use super::delay::now;
use crate::doctor::CheckLine;
use crate::platform::linux::uinput::{PAD_PRODUCT, PAD_VENDOR};

const SUBJECT: &str = "seen by games";
/// Longest wait until udev reports the device.
const TIMEOUT: Duration = Duration::from_secs(1);
const POLL_PERIOD: Duration = Duration::from_millis(20);

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

/// Looks for the test gamepad, which must exist.
pub(super) fn check_gilrs() -> CheckLine {
    let mut gilrs = match Gilrs::new() {
        Ok(gilrs) => gilrs,
        Err(error) => return CheckLine::note(SUBJECT, format!("cannot start gilrs ({error})")),
    };
    let start = now();
    loop {
        while gilrs.next_event().is_some() {}
        let own = |(_, pad): &(_, Gamepad<'_>)| {
            (pad.vendor_id(), pad.product_id()) == (Some(PAD_VENDOR), Some(PAD_PRODUCT))
        };
        if let Some((_, pad)) = gilrs.gamepads().find(own) {
            return judge(pad.name(), missing_controls(&pad));
        }
        if start.elapsed() > TIMEOUT {
            return judge_not_found();
        }
        sleep(POLL_PERIOD);
    }
}

/// Buttons and axes that gilrs does not map.
fn missing_controls(pad: &Gamepad<'_>) -> Vec<String> {
    let buttons = BUTTONS.iter().chain(&TRIGGERS);
    let buttons = buttons.filter(|button| pad.button_code(**button).is_none());
    let sticks = STICKS.iter().filter(|axis| pad.axis_code(**axis).is_none());
    buttons
        .map(|button| format!("{button:?}"))
        .chain(sticks.map(|axis| format!("{axis:?}")))
        .collect()
}

fn judge(name: &str, missing: Vec<String>) -> CheckLine {
    if missing.is_empty() {
        let (buttons, triggers) = (BUTTONS.len(), TRIGGERS.len());
        return CheckLine::ok(
            SUBJECT,
            format!("{name}, with {buttons} buttons, 2 sticks and {triggers} triggers (gilrs)"),
        );
    }
    CheckLine::wrong(
        SUBJECT,
        format!("{name} lacks {} (gilrs)", missing.join(", ")),
        "unset SDL_GAMECONTROLLERCONFIG: it changes the mapping",
    )
}

fn judge_not_found() -> CheckLine {
    CheckLine::wrong(
        SUBJECT,
        "gilrs does not find the gamepad",
        "sudo usermod -aG input $USER, then log in again; without udev: set GILRS_DISABLE_UDEV=1",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::CheckStatus;

    #[test]
    fn a_missing_button_or_gamepad_is_wrong() {
        assert_eq!(judge("pad", Vec::new()).state, CheckStatus::Ok);
        let line = judge("pad", vec!["DPadUp".to_owned()]);
        assert!(line.state == CheckStatus::Wrong && line.found.contains("DPadUp"));
        assert_eq!(judge_not_found().state, CheckStatus::Wrong);
    }
}
