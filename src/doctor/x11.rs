//! The X11 display: whether it answers, whether programs may press keys on it, and how long that takes.

use std::time::Duration;

use x11rb::connection::{Connection as _, RequestConnection as _};
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    ConnectionExt as _, GrabMode, KEY_PRESS_EVENT, KEY_RELEASE_EVENT, ModMask,
};
use x11rb::protocol::xtest::{ConnectionExt as _, X11_EXTENSION_NAME};
use x11rb::rust_connection::RustConnection;

use super::delay::{Delay, ROUNDS, now};
use super::{Line, Machine};

const SUBJECT: &str = "X11";
/// Longest wait for one key.
const PATIENCE: Duration = Duration::from_millis(500);

/// What is known of the display.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Display {
    /// None is named.
    Unnamed,
    /// It does not answer, and why.
    Silent(String, String),
    /// It lets no program press keys.
    WithoutXtest(String),
    /// It takes keys.
    Works {
        name: String,
        /// Whether only programs for X11 see them: a Wayland desktop's own do not.
        is_xwayland: bool,
        /// From press to a client that reads it; none where no key was spare to be pressed.
        delay: Option<Delay>,
    },
}

impl Display {
    pub(super) fn works(&self) -> bool {
        matches!(self, Self::Works { .. })
    }
}

pub(super) fn look(machine: &Machine) -> Display {
    let Some(name) = machine.setting("DISPLAY").map(str::to_owned) else {
        return Display::Unnamed;
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
            || machine.setting("WAYLAND_DISPLAY").is_some(),
        delay: measure(&connection, &name),
        name,
    }
}

/// Presses a key that types nothing. It is grabbed: nobody else sees it.
fn measure(sender: &RustConnection, name: &str) -> Option<Delay> {
    let (reader, screen) = x11rb::connect(Some(name)).ok()?;
    let key = spare_key(&reader)?;
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
    while start.elapsed() < PATIENCE {
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

/// The highest key that the layout gives no meaning.
fn spare_key(connection: &RustConnection) -> Option<u8> {
    let (least, most) = (
        connection.setup().min_keycode,
        connection.setup().max_keycode,
    );
    let mapping = connection
        .get_keyboard_mapping(least, most - least + 1)
        .ok()?
        .reply()
        .ok()?;
    let width = usize::from(mapping.keysyms_per_keycode).max(1);
    let keys = mapping.keysyms.chunks(width).zip(least..=most);
    let spare = keys.filter(|(symbols, _)| symbols.iter().all(|symbol| *symbol == 0));
    spare.map(|(_, key)| key).next_back()
}

pub(super) fn judge(display: &Display) -> Line {
    match display {
        Display::Unnamed => Line::note(SUBJECT, "DISPLAY is not set: no X11 desktop here")
            .mend("start gelpad from a terminal of the desktop"),
        Display::Silent(name, why) => Line::wrong(
            SUBJECT,
            format!("the display {name} does not answer ({why})"),
            "start gelpad from a terminal of the desktop, as the user who is logged in there",
        ),
        Display::WithoutXtest(name) => Line::wrong(
            SUBJECT,
            format!("the display {name} lets no program press keys: it lacks XTEST"),
            "start the server without `-extension XTEST`, or play through the kernel: gelpad doctor --install-rule",
        ),
        Display::Works {
            name,
            is_xwayland,
            delay,
        } => {
            let delay = delay.map_or(String::new(), |delay| format!("; press to reader: {delay}"));
            let found = format!("the display {name} takes keys (XTEST){delay}");
            match is_xwayland {
                true => Line::note(
                    SUBJECT,
                    format!("{found}; programs of the Wayland desktop do not see them"),
                ),
                false => Line::ok(SUBJECT, found),
            }
        }
    }
}
