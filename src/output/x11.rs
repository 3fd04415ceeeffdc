//! The keyboard and mouse of an X11 display, by its XTEST extension.
//!
//! By raw keycode: typing a symbol that the layout lacks would rewrite the keymap. One request an event and one write a
//! batch; nothing is asked back. The server keeps what is down when this process is killed: a watcher releases it
//! (`watch.rs`).

use std::time::Duration;

use x11rb::connection::{Connection as _, RequestConnection as _};
use x11rb::errors::ReplyOrIdError;
use x11rb::protocol::Event as Said;
use x11rb::protocol::xproto::{
    BUTTON_PRESS_EVENT, BUTTON_RELEASE_EVENT, ChangeWindowAttributesAux, ConnectionExt as _,
    CreateWindowAux, EventMask, KEY_PRESS_EVENT, KEY_RELEASE_EVENT, MOTION_NOTIFY_EVENT, Window,
    WindowClass,
};
use x11rb::protocol::xtest::{self, ConnectionExt as _};
use x11rb::rust_connection::RustConnection;

use super::watch::{Grip, Watchable};
use super::{Device, OutputError};
use crate::types::{Action, Event, MouseButton, Output};

/// The detail of a motion that is relative to where the pointer is.
const RELATIVE: u8 = 1;
/// Buttons that are notches of the wheel: up, down, left, right.
const WHEEL: [u8; 4] = [4, 5, 6, 7];

/// How often it is looked whether a window has gone.
const LOOK: Duration = Duration::from_millis(2);
/// A display that does not answer keeps nobody for longer than this.
const FAREWELL: Duration = Duration::from_secs(2);

/// A connection to a display.
pub struct X11 {
    connection: RustConnection,
    display: String,
    /// A window that is never seen. It goes when the server is done with this connection: so a watcher knows.
    window: Window,
    name: String,
    /// Lowest and highest keycode that the server has.
    keycodes: (u8, u8),
}

impl X11 {
    /// Connects to the display that `DISPLAY` names.
    ///
    /// # Errors
    /// No display, or one that takes no events.
    pub fn connect() -> Result<Self, OutputError> {
        let Some(display) = std::env::var("DISPLAY")
            .ok()
            .filter(|name| !name.is_empty())
        else {
            return Err(unreachable(
                "DISPLAY names no X11 display: start gelpad in a desktop session, or use --output trace",
            ));
        };
        Self::connect_to(&display)
    }

    /// Connects to a display by its name, as `:0`.
    ///
    /// # Errors
    /// No such display, or one that takes no events.
    pub fn connect_to(display: &str) -> Result<Self, OutputError> {
        let (connection, _) = x11rb::connect(Some(display)).map_err(|error| {
            unreachable(&format!(
                "the X11 display {display} did not answer ({error}): is it running, and may you use it?"
            ))
        })?;
        match connection.extension_information(xtest::X11_EXTENSION_NAME) {
            Ok(Some(_)) => {}
            Ok(None) => {
                return Err(unreachable(&format!(
                    "the X11 display {display} lacks the XTEST extension: use another server, or --output gamepad"
                )));
            }
            Err(error) => {
                return Err(unreachable(&format!("the X11 display {display}: {error}")));
            }
        }
        let window = unseen_window(&connection)
            .map_err(|error| unreachable(&format!("the X11 display {display}: {error}")))?;
        let setup = connection.setup();
        let keycodes = (setup.min_keycode, setup.max_keycode);
        Ok(Self {
            connection,
            display: display.to_owned(),
            window,
            name: format!("keyboard and mouse of the X11 display {display}"),
            keycodes,
        })
    }

    /// Waits until the server has carried out everything.
    ///
    /// # Errors
    /// The server is gone.
    pub fn sync(&mut self) -> Result<(), OutputError> {
        use x11rb::wrapper::ConnectionExt as _;

        self.connection.sync().map_err(|error| refused(&error))
    }

    /// Asks to be told when another connection's window goes.
    ///
    /// # Errors
    /// The server is gone.
    pub(super) fn follow(&mut self, window: Window) -> Result<(), OutputError> {
        let wanted = ChangeWindowAttributesAux::new().event_mask(EventMask::STRUCTURE_NOTIFY);
        self.connection
            .change_window_attributes(window, &wanted)
            .map(drop)
            .map_err(|error| refused(&error))?;
        self.sync()
    }

    /// Waits until a window that is followed has gone, with all that its connection had sent: not for longer than told.
    ///
    /// # Errors
    /// The server is gone.
    pub(super) fn wait_for_end_of(
        &mut self,
        window: Window,
        patience: Duration,
    ) -> Result<(), OutputError> {
        let mut waited = Duration::ZERO;
        while waited < patience {
            match self.connection.poll_for_event() {
                Ok(Some(Said::DestroyNotify(gone))) if gone.window == window => return Ok(()),
                // It had gone before it was followed.
                Ok(Some(Said::Error(error))) if error.bad_value == window => return Ok(()),
                Ok(Some(_)) => {}
                Ok(None) => {
                    std::thread::sleep(LOOK);
                    waited += LOOK;
                }
                Err(error) => return Err(refused(&error)),
            }
        }
        Ok(())
    }

    fn fake(&self, kind: u8, detail: u8, (dx, dy): (i16, i16)) -> Result<(), OutputError> {
        // Its cookie asks for no answer.
        self.connection
            .xtest_fake_input(kind, detail, x11rb::CURRENT_TIME, x11rb::NONE, dx, dy, 0)
            .map(drop)
            .map_err(|error| refused(&error))
    }

    fn turn(&self, notches: i32, more: u8, less: u8) -> Result<(), OutputError> {
        let button = if notches > 0 { more } else { less };
        for _ in 0..notches.unsigned_abs() {
            self.fake(BUTTON_PRESS_EVENT, button, (0, 0))?;
            self.fake(BUTTON_RELEASE_EVENT, button, (0, 0))?;
        }
        Ok(())
    }
}

impl Device for X11 {
    fn name(&self) -> &str {
        &self.name
    }

    fn takes(&self, output: Output) -> bool {
        match output {
            Output::Key(key) => (self.keycodes.0..=self.keycodes.1).contains(&key.x11_keycode()),
            Output::Mouse(_) => true,
            Output::Button(_) => false,
        }
    }

    fn send(&mut self, event: &Event) -> Result<(), OutputError> {
        match event.action {
            Action::Press(Output::Key(key)) => {
                self.fake(KEY_PRESS_EVENT, key.x11_keycode(), (0, 0))
            }
            Action::Release(Output::Key(key)) => {
                self.fake(KEY_RELEASE_EVENT, key.x11_keycode(), (0, 0))
            }
            Action::Press(Output::Mouse(which)) => {
                self.fake(BUTTON_PRESS_EVENT, button(which), (0, 0))
            }
            Action::Release(Output::Mouse(which)) => {
                self.fake(BUTTON_RELEASE_EVENT, button(which), (0, 0))
            }
            Action::Motion { dx, dy } => {
                self.fake(MOTION_NOTIFY_EVENT, RELATIVE, (short(dx), short(dy)))
            }
            Action::Wheel { dx, dy } => {
                let [up, down, left, right] = WHEEL;
                self.turn(dy, up, down)?;
                self.turn(dx, right, left)
            }
            Action::Press(Output::Button(_))
            | Action::Release(Output::Button(_))
            | Action::Axis(..) => Ok(()),
        }
    }

    fn flush(&mut self) -> Result<(), OutputError> {
        self.connection.flush().map_err(|error| refused(&error))?;
        // What the server says unasked (a new keymap, an error) must not pile up.
        while let Some(said) = self
            .connection
            .poll_for_event()
            .map_err(|error| refused(&error))?
        {
            if let Said::Error(error) = said {
                tracing::warn!("the X11 server refused an event: {error:?}");
            }
        }
        Ok(())
    }
}

impl Drop for X11 {
    /// Waits until the server has read everything: of a client that hangs up it forgets what it has not read yet, and that
    /// may be the release of a key.
    fn drop(&mut self) {
        let wanted = ChangeWindowAttributesAux::new().event_mask(EventMask::STRUCTURE_NOTIFY);
        let own = self.window;
        let asked = self
            .connection
            .change_window_attributes(own, &wanted)
            .is_ok()
            && self.connection.destroy_window(own).is_ok()
            && self.connection.flush().is_ok();
        if asked {
            // A display that is gone holds no key.
            let _ = self.wait_for_end_of(own, FAREWELL);
        }
    }
}

impl Watchable for X11 {
    fn grip(&self) -> std::io::Result<Grip> {
        Ok(Grip::X11 {
            display: self.display.clone(),
            window: self.window,
        })
    }

    fn reconnect(&mut self) -> Result<(), OutputError> {
        Ok(())
    }
}

fn unseen_window(connection: &RustConnection) -> Result<Window, ReplyOrIdError> {
    let root = connection
        .setup()
        .roots
        .first()
        .map_or(x11rb::NONE, |screen| screen.root);
    let window = connection.generate_id()?;
    connection
        .create_window(
            0,
            window,
            root,
            -1,
            -1,
            1,
            1,
            0,
            WindowClass::INPUT_ONLY,
            x11rb::COPY_FROM_PARENT,
            &CreateWindowAux::new().override_redirect(1),
        )?
        .check()?;
    Ok(window)
}

fn button(which: MouseButton) -> u8 {
    match which {
        MouseButton::Left => 1,
        MouseButton::Middle => 2,
        MouseButton::Right => 3,
        MouseButton::Back => 8,
        MouseButton::Forward => 9,
    }
}

/// Pixels as the protocol has them.
fn short(pixels: i32) -> i16 {
    pixels.clamp(i16::MIN.into(), i16::MAX.into()) as i16
}

fn unreachable(reason: &str) -> OutputError {
    OutputError::NoDevice {
        device: "X11",
        reason: reason.to_owned(),
    }
}

fn refused(error: &dyn std::fmt::Display) -> OutputError {
    OutputError::Refused {
        device: "X11 display",
        reason: error.to_string(),
    }
}
