//! Which output plays, why no better one does, and whether it has what a profile drives.

use std::collections::BTreeSet;

use super::args::{OutputArg, SourceArg};
use crate::output::{Device, OutputError, Trace, Uinput, X11};
use crate::profile::{Gesture, Profile, Target};
use crate::types::{Button, Key, MouseButton, Output};

/// The output that was chosen.
pub(super) struct Chosen {
    pub device: Box<dyn Device>,
    /// A line for the player where it was for gelpad to choose: which, and why no better one.
    pub told: Option<String>,
}

/// Opens the output that was asked for, or the best that there is. What a trace prints is held back where a live view has
/// the terminal.
///
/// # Errors
/// What was asked for cannot be opened.
pub(super) fn open(
    output: OutputArg,
    source: &SourceArg,
    live: bool,
) -> Result<Chosen, OutputError> {
    let told = None;
    let device: Box<dyn Device> = match (output, source) {
        (OutputArg::Trace, _) => trace(live),
        (OutputArg::Gamepad, _) => Box::new(Uinput::create()?),
        (OutputArg::Keyboard, _) => desktop()?,
        // A demonstration must not type into whatever has the focus.
        (OutputArg::Auto, SourceArg::Simulated(_)) => trace(live),
        (OutputArg::Auto, _) => return Ok(best(live)),
    };
    Ok(Chosen { device, told })
}

/// Events as text.
pub(super) fn trace(live: bool) -> Box<dyn Device> {
    if live {
        Box::new(Trace::new(std::io::sink()))
    } else {
        Box::new(Trace::new(std::io::stdout()))
    }
}

/// Keys and mouse of the desktop that we are in; of the kernel where there is none.
fn desktop() -> Result<Box<dyn Device>, OutputError> {
    if std::env::var_os("DISPLAY").is_none_or(|name| name.is_empty())
        && let Ok(device) = Uinput::without_pad()
    {
        return Ok(Box::new(device));
    }
    Ok(Box::new(X11::connect()?))
}

/// The first that opens: devices of the kernel reach every program and are released by it; then the desktop's own; then
/// nothing but text.
pub(super) fn best(live: bool) -> Chosen {
    let mut reasons = Vec::new();
    let device: Box<dyn Device> = match Uinput::create() {
        Ok(device) => Box::new(device),
        Err(error) => {
            reasons.push(OutputError::from(error).to_string());
            match desktop() {
                Ok(device) => device,
                Err(error) => {
                    reasons.push(error.to_string());
                    trace(live)
                }
            }
        }
    };
    let mut told = format!("output: {}", device.name());
    for reason in reasons {
        told.push_str(&format!("; {reason}"));
    }
    Chosen {
        device,
        told: Some(told),
    }
}

/// What a device has, asked before it is handed over.
pub(super) struct Takes {
    device: String,
    outputs: BTreeSet<Output>,
}

impl Takes {
    pub(super) fn of(device: &dyn Device) -> Self {
        let keys = Key::all().map(Output::Key);
        let buttons = Button::ALL.iter().copied().map(Output::Button);
        let mouse = MouseButton::ALL.iter().copied().map(Output::Mouse);
        let all = keys.chain(buttons).chain(mouse);
        Self {
            device: device.name().to_owned(),
            outputs: all.filter(|output| device.takes(*output)).collect(),
        }
    }

    /// What a profile drives and the device does not have, as a message.
    pub(super) fn lacking(&self, profile: &Profile) -> Option<String> {
        let has_pad = self.outputs.contains(&Output::Button(Button::A));
        let has_mouse = self.outputs.contains(&Output::Mouse(MouseButton::Left));
        let mut pressed = profile.outputs.iter();
        let pressed = pressed.find(|output| !self.outputs.contains(output));
        let moved = || {
            profile.bindings.iter().find(|binding| {
                let turns = |target: &Target| matches!(target, Target::Wheel { .. });
                match binding.gesture {
                    Gesture::Stick(_) | Gesture::Trigger(_) => !has_pad,
                    Gesture::Pointer(_) => !has_mouse,
                    _ => !has_mouse && binding.targets.iter().any(turns),
                }
            })
        };
        let what = match pressed {
            Some(output) => format!("presses {output}"),
            None => format!("moves {}", profile.outputs_of(moved()?)),
        };
        let instead = match pressed {
            Some(Output::Key(_) | Output::Mouse(_)) => "choose another --output",
            _ => "choose --output gamepad, or bind a key (key:NAME)",
        };
        Some(format!(
            "the profile {} {what}, which the {} does not have\n  help: {instead}",
            profile.name, self.device
        ))
    }
}
