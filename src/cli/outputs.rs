//! Which output plays, why no better one does, and whether it has what a profile drives.

use std::collections::BTreeSet;

use super::args::{OutputArg, SourceArg};
use super::candidates::{Candidate, KERNEL, KERNEL_KEYBOARD, desktop};
use crate::output::{Device, OutputError, Trace};
use crate::profile::{Gesture, Profile, Target};
use crate::types::{Button, Key, MouseButton, Output};

/// The output that was chosen.
pub(super) struct Chosen {
    pub device: Box<dyn Device>,
    /// For the player, where it was for gelpad to choose: which, and why no better one.
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
    let device: Box<dyn Device> = match (output, source) {
        (OutputArg::Trace, _) => trace(live),
        (OutputArg::Gamepad, _) => (KERNEL.open)()?,
        (OutputArg::Keyboard, _) => keyboard()?,
        // A demonstration must not type into whatever has the focus.
        (OutputArg::Auto, SourceArg::Simulated(_)) => trace(live),
        (OutputArg::Auto, _) => return Ok(best(live)),
    };
    Ok(Chosen { device, told: None })
}

/// Keys of this desktop; of the kernel where there is none.
fn keyboard() -> Result<Box<dyn Device>, OutputError> {
    let (has_wayland, has_x11) = (set("WAYLAND_DISPLAY"), set("DISPLAY"));
    let mut candidates = desktop(has_wayland, has_x11);
    if !has_wayland && !has_x11 {
        candidates.insert(0, NO_DESKTOP);
    }
    let (device, reasons) = first(&candidates);
    device.ok_or_else(|| OutputError::NoDevice {
        device: "keyboard",
        reason: reasons.join("; "),
    })
}

/// Events as text.
pub(super) fn trace(live: bool) -> Box<dyn Device> {
    if live {
        Box::new(Trace::new(std::io::sink()))
    } else {
        Box::new(Trace::new(std::io::stdout()))
    }
}

/// The first that opens: devices of the kernel reach every program and are released by it; then the desktop's own; then
/// nothing but text.
pub(super) fn best(live: bool) -> Chosen {
    let (has_wayland, has_x11) = (set("WAYLAND_DISPLAY"), set("DISPLAY"));
    let mut candidates = vec![KERNEL];
    if has_wayland || has_x11 {
        let of_desktop = desktop(has_wayland, has_x11);
        let others = of_desktop.into_iter();
        // Where the pad cannot be made, the keyboard cannot either.
        candidates.extend(others.filter(|one| one.name != KERNEL_KEYBOARD.name));
    } else {
        candidates.push(NO_DESKTOP);
    }
    best_of(&candidates, live)
}

const NO_DESKTOP: Candidate = Candidate {
    name: "a desktop",
    open: || {
        Err(OutputError::NoDevice {
            device: "desktop",
            reason: "neither WAYLAND_DISPLAY nor DISPLAY is set".to_owned(),
        })
    },
};

fn best_of(candidates: &[Candidate], live: bool) -> Chosen {
    let (device, reasons) = first(candidates);
    let device = device.unwrap_or_else(|| trace(live));
    let why = match reasons.is_empty() {
        true => String::new(),
        false => format!(" (not {})", reasons.join("; not ")),
    };
    Chosen {
        told: Some(format!("output: {}{why}", device.name())),
        device,
    }
}

/// The first that opens, and why those before did not.
fn first(candidates: &[Candidate]) -> (Option<Box<dyn Device>>, Vec<String>) {
    let mut reasons = Vec::new();
    for candidate in candidates {
        match (candidate.open)() {
            Ok(device) => return (Some(device), reasons),
            Err(OutputError::NoDevice { reason, .. }) => {
                reasons.push(format!("{}: {reason}", candidate.name));
            }
            Err(error) => reasons.push(format!("{}: {error}", candidate.name)),
        }
    }
    (None, reasons)
}

/// Whether a variable of the environment says something.
fn set(variable: &str) -> bool {
    std::env::var_os(variable).is_some_and(|value| !value.is_empty())
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::Event;

    /// A device with a name, and with keys if the name says so.
    struct Named(&'static str);

    impl Device for Named {
        fn name(&self) -> &str {
            self.0
        }

        fn takes(&self, output: Output) -> bool {
            matches!(output, Output::Key(_))
        }

        fn send(&mut self, _: &Event) -> Result<(), OutputError> {
            Ok(())
        }
    }

    const LOCKED: Candidate = Candidate {
        name: "the kernel's pad",
        open: || {
            Err(OutputError::NoDevice {
                device: "uinput",
                reason: "not yours to write: do this".to_owned(),
            })
        },
    };
    const KEYS: Candidate = Candidate {
        name: "X11",
        open: || Ok(Box::new(Named("keyboard of :0"))),
    };

    #[test]
    fn the_first_that_opens_is_chosen_and_the_line_says_why_no_better_one() {
        let told = |candidates: &[Candidate]| best_of(candidates, true).told.unwrap_or_default();
        assert_eq!(told(&[KEYS, LOCKED]), "output: keyboard of :0");
        assert_eq!(
            told(&[LOCKED, KEYS]),
            "output: keyboard of :0 (not the kernel's pad: not yours to write: do this)"
        );
        assert_eq!(
            told(&[LOCKED, NO_DESKTOP]),
            "output: trace (not the kernel's pad: not yours to write: do this; not a desktop: neither WAYLAND_DISPLAY nor \
             DISPLAY is set)"
        );
    }

    #[test]
    fn what_a_profile_drives_and_the_device_lacks_is_told() {
        let takes = Takes::of(&Named("keyboard"));
        let lacking = |output: &str| {
            let toml = format!(
                "schema = 1\nname = \"p\"\n[[region]]\nname = \"r\"\nx = 0\ny = 0\nw = 1\nh = 1\n\
                 [[binding]]\nregion = \"r\"\noutput = \"{output}\"\n"
            );
            takes.lacking(&Profile::from_toml("p", &toml).expect("sound"))
        };
        assert_eq!(lacking("key:media-next"), None);
        for (output, what) in [
            ("pad:a", "presses pad:a"),
            ("mouse:left", "presses mouse:left"),
            ("mouse:wheel-up", "moves mouse:wheel-up"),
        ] {
            let said = lacking(output).expect("lacking");
            assert!(said.contains(what) && said.contains("help: "), "{said}");
        }
    }
}
