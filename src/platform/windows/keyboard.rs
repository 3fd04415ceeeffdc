//! Keyboard and mouse of Windows, through `SendInput`.
//!
//! Keys are sent as scan codes: games read those, and they name places whatever the layout. The virtual key is sent along, for
//! programs that translate nothing (and wine 8). All events of a batch go out in one call, which no other program's events
//! interrupt. Windows keeps what a killed program left down; a watcher releases it (`watch/`).
//!
//! Windows refuses events while the screen is locked, and drops them silently where a program that runs as administrator has the focus.
//! A refused release is sent again until it is accepted.
#![allow(unsafe_code, reason = "no safe interface sends scan codes")]

use std::time::{Duration, Instant};

use windows_sys::Win32::UI::Input::KeyboardAndMouse::{
    INPUT, INPUT_0, INPUT_KEYBOARD, INPUT_MOUSE, KEYBD_EVENT_FLAGS, KEYBDINPUT,
    KEYEVENTF_EXTENDEDKEY, KEYEVENTF_KEYUP, KEYEVENTF_SCANCODE, MAPVK_VSC_TO_VK_EX,
    MOUSE_EVENT_FLAGS, MOUSEEVENTF_HWHEEL, MOUSEEVENTF_LEFTDOWN, MOUSEEVENTF_LEFTUP,
    MOUSEEVENTF_MIDDLEDOWN, MOUSEEVENTF_MIDDLEUP, MOUSEEVENTF_MOVE, MOUSEEVENTF_RIGHTDOWN,
    MOUSEEVENTF_RIGHTUP, MOUSEEVENTF_WHEEL, MOUSEEVENTF_XDOWN, MOUSEEVENTF_XUP, MOUSEINPUT,
    MapVirtualKeyW, SendInput,
};

use super::rights::{Rights, foreground_rights, own_rights};
use super::scan_codes::{ScanCode, scan_code};
use super::watch::ReleaseHandle;
use crate::output::{OutputDevice, OutputError, now};
use crate::platform::watch::Watchable;
use crate::types::{Action, Event, MouseButton, Output};

/// One notch of the wheel.
const NOTCH: i32 = 120;
/// Thumb buttons: back and forward.
const THUMB: [u32; 2] = [1, 2];

/// How often the rights of the program in the foreground are looked at.
const LOOK_PERIOD: Duration = Duration::from_secs(2);

/// The keyboard and mouse of this session.
pub(super) struct WindowsKeyboard {
    /// Events of the current batch.
    batch: Vec<Sent>,
    /// Releases that Windows has refused.
    refused: Vec<Sent>,
    has_warned: bool,
    /// When the rights of the program in the foreground are looked at again.
    next_look: Instant,
    /// Whether it has more rights than gelpad.
    is_out_of_reach: bool,
}

/// An event as Windows takes it.
#[derive(Clone, Copy)]
struct Sent {
    input: INPUT,
    is_release: bool,
}

impl WindowsKeyboard {
    /// The keyboard and mouse of this session.
    pub(super) fn connect() -> Self {
        Self {
            batch: Vec::new(),
            refused: Vec::new(),
            has_warned: false,
            next_look: now(),
            is_out_of_reach: false,
        }
    }

    /// Warns when a program that gets no keys comes to the foreground.
    fn look_at_foreground(&mut self) {
        if now() < self.next_look {
            return;
        }
        self.next_look = now() + LOOK_PERIOD;
        let is_out_of_reach =
            own_rights() == Rights::User && foreground_rights() == Some(Rights::Administrator);
        if is_out_of_reach && !self.is_out_of_reach {
            tracing::warn!(
                "the program in the foreground runs as administrator and gets no keys\n  help: start it without administrator rights, or gelpad with them"
            );
        }
        self.is_out_of_reach = is_out_of_reach;
    }

    fn add(&mut self, input: INPUT, is_release: bool) {
        self.batch.push(Sent { input, is_release });
    }

    fn change(&mut self, output: Output, is_release: bool) {
        match output {
            Output::Key(key) => {
                if let Some(code) = scan_code(key) {
                    self.add(key_input(code, is_release), is_release);
                }
            }
            Output::Mouse(button) => self.add(button_input(button, is_release), is_release),
            Output::Button(_) => {}
        }
    }

    /// Sends the batch, after the releases that were refused before.
    fn send_batch(&mut self) {
        let mut events = std::mem::take(&mut self.refused);
        events.append(&mut self.batch);
        if events.is_empty() {
            return;
        }
        let inputs: Vec<INPUT> = events.iter().map(|one| one.input).collect();
        let accepted = send_inputs(&inputs);
        if accepted == events.len() {
            self.has_warned = false;
            return;
        }
        if !self.has_warned {
            self.has_warned = true;
            tracing::warn!(
                "Windows refuses keys now ({}): the screen is locked, or a dialog of the system is open",
                std::io::Error::last_os_error()
            );
        }
        let rest = events.into_iter().skip(accepted);
        self.refused = rest.filter(|one| one.is_release).collect();
    }
}

// SAFETY: `INPUT` is plain numbers; nothing in it belongs to a thread.
unsafe impl Send for WindowsKeyboard {}

impl OutputDevice for WindowsKeyboard {
    fn name(&self) -> &str {
        "keyboard and mouse of Windows"
    }

    fn supports(&self, output: Output) -> bool {
        match output {
            Output::Key(key) => scan_code(key).is_some(),
            Output::Mouse(_) => true,
            Output::Button(_) => false,
        }
    }

    fn send(&mut self, event: &Event) -> Result<(), OutputError> {
        match event.action {
            Action::Press(output) => self.change(output, false),
            Action::Release(output) => self.change(output, true),
            Action::Motion { dx, dy } => {
                self.add(mouse_input(MOUSEEVENTF_MOVE, [dx, dy], 0), false)
            }
            Action::Wheel { dx, dy } => {
                for (flag, notches) in [(MOUSEEVENTF_WHEEL, dy), (MOUSEEVENTF_HWHEEL, dx)] {
                    if notches != 0 {
                        self.add(mouse_input(flag, [0; 2], notches * NOTCH), false);
                    }
                }
            }
            Action::Axis(..) => {}
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), OutputError> {
        self.send_batch();
        Ok(())
    }

    fn idle(&mut self) -> Result<(), OutputError> {
        self.send_batch();
        self.look_at_foreground();
        Ok(())
    }
}

impl Watchable for WindowsKeyboard {
    fn release_handle(&self) -> std::io::Result<ReleaseHandle> {
        Ok(ReleaseHandle)
    }

    fn reconnect(&mut self) -> Result<(), OutputError> {
        Ok(())
    }
}

/// Whether Windows takes events now: sends a motion of nothing.
#[must_use]
pub fn is_accepting() -> bool {
    send_inputs(&[mouse_input(MOUSEEVENTF_MOVE, [0; 2], 0)]) == 1
}

/// Number of events that Windows has accepted.
fn send_inputs(inputs: &[INPUT]) -> usize {
    // SAFETY: pointer and length are those of the slice, the size that of its elements.
    let accepted = unsafe {
        SendInput(
            inputs.len() as u32,
            inputs.as_ptr(),
            size_of::<INPUT>() as i32,
        )
    };
    accepted as usize
}

fn key_input(code: ScanCode, is_release: bool) -> INPUT {
    let mut flags: KEYBD_EVENT_FLAGS = 0;
    if code.is_extended {
        flags |= KEYEVENTF_EXTENDEDKEY;
    }
    if is_release {
        flags |= KEYEVENTF_KEYUP;
    }
    let virtual_key = match code.virtual_key {
        Some(key) => key,
        None => {
            flags |= KEYEVENTF_SCANCODE;
            let prefix = if code.is_extended { 0xe000 } else { 0 };
            // SAFETY: the call takes and returns numbers; 0 stands for none.
            let found =
                unsafe { MapVirtualKeyW(u32::from(prefix | code.code), MAPVK_VSC_TO_VK_EX) };
            u16::try_from(found).unwrap_or(0)
        }
    };
    INPUT {
        r#type: INPUT_KEYBOARD,
        Anonymous: INPUT_0 {
            ki: KEYBDINPUT {
                wVk: virtual_key,
                wScan: code.code,
                dwFlags: flags,
                time: 0,
                dwExtraInfo: 0,
            },
        },
    }
}

fn button_input(button: MouseButton, is_release: bool) -> INPUT {
    let [down, up, data] = match button {
        MouseButton::Left => [MOUSEEVENTF_LEFTDOWN, MOUSEEVENTF_LEFTUP, 0],
        MouseButton::Right => [MOUSEEVENTF_RIGHTDOWN, MOUSEEVENTF_RIGHTUP, 0],
        MouseButton::Middle => [MOUSEEVENTF_MIDDLEDOWN, MOUSEEVENTF_MIDDLEUP, 0],
        MouseButton::Back => [MOUSEEVENTF_XDOWN, MOUSEEVENTF_XUP, THUMB[0]],
        MouseButton::Forward => [MOUSEEVENTF_XDOWN, MOUSEEVENTF_XUP, THUMB[1]],
    };
    mouse_input(
        if is_release { up } else { down },
        [0; 2],
        data.cast_signed(),
    )
}

fn mouse_input(flags: MOUSE_EVENT_FLAGS, [dx, dy]: [i32; 2], data: i32) -> INPUT {
    INPUT {
        r#type: INPUT_MOUSE,
        Anonymous: INPUT_0 {
            mi: MOUSEINPUT {
                dx,
                dy,
                mouseData: data.cast_unsigned(),
                dwFlags: flags,
                time: 0,
                dwExtraInfo: 0,
            },
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::Key;

    #[test]
    fn a_key_is_its_scan_code_with_the_extended_bit() {
        let input = |name: &str, is_release| {
            let key: Key = name.parse().expect("a key");
            let sent = key_input(scan_code(key).expect("a code"), is_release);
            // SAFETY: it is a keyboard's.
            let key = unsafe { sent.Anonymous.ki };
            (key.wScan, key.dwFlags)
        };
        assert_eq!(input("keypad-4", false), (0x4b, KEYEVENTF_SCANCODE));
        assert_eq!(
            input("left", true),
            (
                0x4b,
                KEYEVENTF_SCANCODE | KEYEVENTF_EXTENDEDKEY | KEYEVENTF_KEYUP
            )
        );
    }
}
