//! Chooses and opens an output, and checks that it has everything a profile drives.

use std::collections::BTreeSet;

use super::request::OutputChoice;
use crate::output::{OutputDevice, OutputError, Trace};
use crate::platform::Candidate;
use crate::platform::outputs::{GAMEPAD, all, keyboards};
use crate::profile::{Gesture, Profile, Target};
use crate::types::{Button, Key, MouseButton, Output};

/// An opened output.
pub(crate) struct ChosenOutput {
    /// The output.
    pub device: Box<dyn OutputDevice>,
    /// For [`OutputChoice::Auto`]: which output was chosen, and why no better one.
    pub note: Option<String>,
}

/// Opens an output. A trace is printed on stdout, or dropped where a live view has the terminal.
pub(crate) fn open(
    choice: OutputChoice,
    trace_on_stdout: bool,
) -> Result<ChosenOutput, OutputError> {
    let device = match choice {
        OutputChoice::Nothing => trace(false),
        OutputChoice::Trace => trace(trace_on_stdout),
        OutputChoice::Gamepad => (GAMEPAD.open)()?,
        OutputChoice::Keyboard => open_keyboard()?,
        OutputChoice::Auto => return Ok(best_of(&all(), trace_on_stdout)),
    };
    Ok(ChosenOutput { device, note: None })
}

/// The first keyboard that opens.
fn open_keyboard() -> Result<Box<dyn OutputDevice>, OutputError> {
    let (device, reasons) = open_first(&keyboards());
    device.ok_or_else(|| OutputError::NoDevice {
        device: "keyboard",
        reason: reasons.join("; "),
    })
}

fn trace(on_stdout: bool) -> Box<dyn OutputDevice> {
    if on_stdout {
        Box::new(Trace::new(std::io::stdout()))
    } else {
        Box::new(Trace::new(std::io::sink()))
    }
}

/// The first that opens, else text.
fn best_of(candidates: &[Candidate], trace_on_stdout: bool) -> ChosenOutput {
    let (device, reasons) = open_first(candidates);
    let device = device.unwrap_or_else(|| trace(trace_on_stdout));
    let why = match reasons.is_empty() {
        true => String::new(),
        false => format!(" (not {})", reasons.join("; not ")),
    };
    ChosenOutput {
        note: Some(format!("output: {}{why}", device.name())),
        device,
    }
}

/// The first output that opens, and why those before it did not.
fn open_first(candidates: &[Candidate]) -> (Option<Box<dyn OutputDevice>>, Vec<String>) {
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

/// The keys and buttons that an output has.
pub(crate) struct OutputAbilities {
    device: String,
    outputs: BTreeSet<Output>,
}

impl OutputAbilities {
    /// Lists the keys and buttons of an output.
    pub(crate) fn from_device(device: &dyn OutputDevice) -> Self {
        let keys = Key::all().map(Output::Key);
        let buttons = Button::ALL.iter().copied().map(Output::Button);
        let mouse = MouseButton::ALL.iter().copied().map(Output::Mouse);
        let all = keys.chain(buttons).chain(mouse);
        Self {
            device: device.name().to_owned(),
            outputs: all.filter(|output| device.supports(*output)).collect(),
        }
    }

    /// A message about the first key, button or axis that a profile drives and the output does not have.
    pub(crate) fn missing_for(&self, profile: &Profile) -> Option<String> {
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
        let action = match pressed {
            Some(output) => format!("presses {output}"),
            None => format!("moves {}", profile.output_names(moved()?)),
        };
        let advice = match pressed {
            Some(Output::Key(_) | Output::Mouse(_)) => "choose another --output",
            _ => "choose --output gamepad, or bind a key (key:NAME)",
        };
        Some(format!(
            "the profile {} {action}, which the {} does not have\n  help: {advice}",
            profile.name, self.device
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::Event;

    /// A keyboard with a name.
    struct NamedKeyboard(&'static str);

    impl OutputDevice for NamedKeyboard {
        fn name(&self) -> &str {
            self.0
        }

        fn supports(&self, output: Output) -> bool {
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
                reason: "permission denied: do this".to_owned(),
            })
        },
    };
    const NO_DESKTOP: Candidate = Candidate {
        name: "a desktop",
        open: || {
            Err(OutputError::NoDevice {
                device: "desktop",
                reason: "neither WAYLAND_DISPLAY nor DISPLAY is set".to_owned(),
            })
        },
    };
    const KEYS: Candidate = Candidate {
        name: "X11",
        open: || Ok(Box::new(NamedKeyboard("keyboard of :0"))),
    };

    #[test]
    fn the_first_that_opens_is_chosen_and_the_note_says_why_no_better_one() {
        let note = |candidates: &[Candidate]| best_of(candidates, false).note.unwrap_or_default();
        assert_eq!(note(&[KEYS, LOCKED]), "output: keyboard of :0");
        assert_eq!(
            note(&[LOCKED, KEYS]),
            "output: keyboard of :0 (not the kernel's pad: permission denied: do this)"
        );
        assert_eq!(
            note(&[LOCKED, NO_DESKTOP]),
            "output: trace (not the kernel's pad: permission denied: do this; not a desktop: neither WAYLAND_DISPLAY nor \
             DISPLAY is set)"
        );
    }

    #[test]
    fn a_profile_that_drives_what_the_output_lacks_is_refused() {
        let abilities = OutputAbilities::from_device(&NamedKeyboard("keyboard"));
        let missing = |output: &str| {
            let toml = format!(
                "schema = 1\nname = \"p\"\n[[region]]\nname = \"r\"\nx = 0\ny = 0\nw = 1\nh = 1\n\
                 [[binding]]\nregion = \"r\"\noutput = \"{output}\"\n"
            );
            abilities.missing_for(&Profile::from_toml("p", &toml).expect("sound"))
        };
        assert_eq!(missing("key:media-next"), None);
        for (output, what) in [
            ("pad:a", "presses pad:a"),
            ("mouse:left", "presses mouse:left"),
            ("mouse:wheel-up", "moves mouse:wheel-up"),
        ] {
            let said = missing(output).expect("missing");
            assert!(said.contains(what) && said.contains("help: "), "{said}");
        }
    }
}
