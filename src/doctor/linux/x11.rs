//! The X11 display: whether it answers and accepts keys from programs, and the delay of a key.

use std::time::Duration;

use x11rb::connection::{Connection as _, RequestConnection as _};
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    ConnectionExt as _, GrabMode, KEY_PRESS_EVENT, KEY_RELEASE_EVENT, ModMask,
};
use x11rb::protocol::xtest::{ConnectionExt as _, X11_EXTENSION_NAME};
use x11rb::rust_connection::RustConnection;

use super::Machine;
use super::delay::{Delay, ROUNDS, now};
use crate::doctor::CheckLine;

const SUBJECT: &str = "X11";
/// Longest wait for a key.
const TIMEOUT: Duration = Duration::from_millis(500);

/// CheckStatus of the X11 display.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Display {
    /// `DISPLAY` is not set.
    NotSet,
    /// Does not answer: name, reason.
    Silent(String, String),
    /// Lacks the XTEST extension.
    WithoutXtest(String),
    /// Accepts keys.
    Works {
        name: String,
        /// Under Wayland: native Wayland programs do not see the keys.
        is_xwayland: bool,
        /// From sending a key to a client that reads it; `None` if the layout has no unused key.
        delay: Option<Delay>,
    },
}

impl Display {
    pub(super) fn works(&self) -> bool {
        matches!(self, Self::Works { .. })
    }
}

pub(super) fn examine(machine: &Machine) -> Display {
    let Some(name) = machine.variable("DISPLAY").map(str::to_owned) else {
        return Display::NotSet;
    };
    let (connection, _) = match x11rb::connect(Some(&name)) {
        Ok(connected) => connected,
        Err(error) => return Display::Silent(name, error.to_string()),
    };
    match connection.extension_information(X11_EXTENSION_NAME) {
        Ok(Some(_)) => {}
        Ok(None) => return Display::WithoutXtest(name),
        Err(error) => return Display::Silent(name, error.to_string()),
    }
    let xwayland = connection.extension_information("XWAYLAND");
    Display::Works {
        is_xwayland: matches!(xwayland, Ok(Some(_)))
            || machine.variable("WAYLAND_DISPLAY").is_some(),
        delay: measure_delay(&connection, &name),
        name,
    }
}

/// Presses an unused key, grabbed so that no other program sees it.
fn measure_delay(sender: &RustConnection, name: &str) -> Option<Delay> {
    let (reader, screen) = x11rb::connect(Some(name)).ok()?;
    let key = unused_key(&reader)?;
    let root = reader.setup().roots.get(screen)?.root;
    reader
        .grab_key(
            false,
            root,
            ModMask::ANY,
            key,
            GrabMode::ASYNC,
            GrabMode::ASYNC,
        )
        .ok()?
        .check()
        .ok()?;
    let mut times = Vec::with_capacity(ROUNDS);
    for _ in 0..ROUNDS {
        let start = now();
        for kind in [KEY_PRESS_EVENT, KEY_RELEASE_EVENT] {
            sender
                .xtest_fake_input(kind, key, x11rb::CURRENT_TIME, x11rb::NONE, 0, 0, 0)
                .ok()?;
            sender.flush().ok()?;
            wait_for(&reader, kind, key)?;
            if kind == KEY_PRESS_EVENT {
                times.push(start.elapsed());
            }
        }
    }
    Delay::of(times)
}

fn wait_for(reader: &RustConnection, kind: u8, key: u8) -> Option<()> {
    let start = now();
    while start.elapsed() < TIMEOUT {
        let seen = match reader.poll_for_event().ok()? {
            Some(Event::KeyPress(seen)) if kind == KEY_PRESS_EVENT => seen,
            Some(Event::KeyRelease(seen)) if kind == KEY_RELEASE_EVENT => seen,
            _ => continue,
        };
        if seen.detail == key {
            return Some(());
        }
    }
    None
}

/// The highest key code without a symbol in the layout.
fn unused_key(connection: &RustConnection) -> Option<u8> {
    let (min, max) = (
        connection.setup().min_keycode,
        connection.setup().max_keycode,
    );
    let mapping = connection
        .get_keyboard_mapping(min, max - min + 1)
        .ok()?
        .reply()
        .ok()?;
    let width = usize::from(mapping.keysyms_per_keycode).max(1);
    let keys = mapping.keysyms.chunks(width).zip(min..=max);
    let unused = keys.filter(|(symbols, _)| symbols.iter().all(|symbol| *symbol == 0));
    unused.map(|(_, key)| key).next_back()
}

pub(super) fn judge(display: &Display) -> CheckLine {
    match display {
        Display::NotSet => CheckLine::note(SUBJECT, "no X11 desktop: DISPLAY is not set")
            .with_fix("start gelpad from a terminal of the desktop"),
        Display::Silent(name, why) => CheckLine::wrong(
            SUBJECT,
            format!("display {name} does not answer ({why})"),
            "start gelpad from a terminal of the desktop, as the logged-in user",
        ),
        Display::WithoutXtest(name) => CheckLine::wrong(
            SUBJECT,
            format!("display {name} does not let programs press keys: it lacks XTEST"),
            "start the X server without `-extension XTEST`, or use kernel devices: gelpad doctor --install-rule",
        ),
        Display::Works {
            name,
            is_xwayland,
            delay,
        } => {
            let delay = delay.map_or(String::new(), |delay| {
                format!("; delay to a program: {delay}")
            });
            let found = format!("display {name} accepts keys (XTEST){delay}");
            match is_xwayland {
                true => CheckLine::note(
                    SUBJECT,
                    format!("{found}; native Wayland programs do not see them"),
                ),
                false => CheckLine::ok(SUBJECT, found),
            }
        }
    }
}
