//! Keyboard and mouse of an X11 display, by its XTEST extension.
//!
//! Keys are sent by raw keycode: typing a symbol that the layout lacks would rewrite the keymap. Each event
//! is one request without a reply, each batch one write. If this process is killed, the server keeps what is
//! down; a watcher releases it (`watch/`).

use std::time::Duration;

use x11rb::connection::{Connection as _, RequestConnection as _};
use x11rb::errors::ReplyOrIdError;
use x11rb::protocol::Event as ServerEvent;
use x11rb::protocol::xproto::{
    AtomEnum, BUTTON_PRESS_EVENT, BUTTON_RELEASE_EVENT, ChangeWindowAttributesAux,
    ClientMessageEvent, ConnectionExt as _, CreateWindowAux, EventMask, KEY_PRESS_EVENT,
    KEY_RELEASE_EVENT, MOTION_NOTIFY_EVENT, Window, WindowClass,
};
use x11rb::protocol::xtest::{self, ConnectionExt as _};
use x11rb::rust_connection::RustConnection;

use crate::output::{OutputDevice, OutputError};
use crate::platform::watch::{ReleaseHandle, Watchable};
use crate::types::{Action, Event, MouseButton, Output};

/// The detail of a relative motion.
const RELATIVE: u8 = 1;
/// Buttons of the wheel's notches: up, down, left, right.
const WHEEL: [u8; 4] = [4, 5, 6, 7];

/// How often the end of a window is checked.
const POLL_PERIOD: Duration = Duration::from_millis(2);
/// Longest wait for the server when the connection ends.
const END_WAIT: Duration = Duration::from_secs(2);

/// A connection to a display.
pub struct X11 {
    connection: RustConnection,
    display: String,
    /// An invisible window. It is destroyed when the server has read everything of this connection, which
    /// shows that to a watcher.
    window: Window,
    name: String,
    /// Lowest and highest keycode that the server has.
    keycodes: (u8, u8),
    /// Number of the last confirmation that was requested, and of the last that has arrived.
    requested: u32,
    confirmed: u32,
    /// Whether the server was given its time to read everything.
    is_finished: bool,
}

impl X11 {
    /// Connects to the display that `DISPLAY` names.
    ///
    /// # Errors
    /// There is no display, or it has no XTEST extension.
    pub fn connect() -> Result<Self, OutputError> {
        let Some(display) = std::env::var("DISPLAY")
            .ok()
            .filter(|name| !name.is_empty())
        else {
            return Err(unreachable(
                "DISPLAY is not set: start gelpad in a desktop session, or use --output trace",
            ));
        };
        Self::connect_to(&display)
    }

    /// Connects to a display by its name, for example `:0`.
    ///
    /// # Errors
    /// There is no such display, or it has no XTEST extension.
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
        let window = invisible_window(&connection)
            .map_err(|error| unreachable(&format!("the X11 display {display}: {error}")))?;
        let setup = connection.setup();
        let keycodes = (setup.min_keycode, setup.max_keycode);
        Ok(Self {
            connection,
            display: display.to_owned(),
            window,
            name: format!("keyboard and mouse of the X11 display {display}"),
            keycodes,
            requested: 0,
            confirmed: 0,
            is_finished: false,
        })
    }

    /// Name of the display.
    pub(super) fn display(&self) -> &str {
        &self.display
    }

    /// Takes what the server has sent, without waiting: confirmations, a new keymap, errors.
    fn take_events(&mut self) -> Result<(), OutputError> {
        while let Some(event) = self
            .connection
            .poll_for_event()
            .map_err(|error| refused(&error))?
        {
            self.take_event(&event);
        }
        Ok(())
    }

    fn take_event(&mut self, event: &ServerEvent) {
        match event {
            ServerEvent::ClientMessage(message) if message.window == self.window => {
                self.confirmed = message.data.as_data32()[0];
            }
            ServerEvent::Error(error) => {
                tracing::warn!("the X11 server refused an event: {error:?}");
            }
            _ => {}
        }
    }

    /// Waits until the server has processed everything.
    ///
    /// # Errors
    /// The server is gone.
    pub fn sync(&mut self) -> Result<(), OutputError> {
        use x11rb::wrapper::ConnectionExt as _;

        self.connection.sync().map_err(|error| refused(&error))
    }

    /// Subscribes to the end of another connection's window.
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

    /// Waits until a followed window is destroyed, after all requests of its connection; at most for `timeout`.
    /// Returns whether it was.
    ///
    /// # Errors
    /// The server is gone.
    pub(super) fn wait_for_end_of(
        &mut self,
        window: Window,
        timeout: Duration,
    ) -> Result<bool, OutputError> {
        let mut waited = Duration::ZERO;
        while waited < timeout {
            match self.connection.poll_for_event() {
                Ok(Some(ServerEvent::DestroyNotify(ended))) if ended.window == window => {
                    return Ok(true);
                }
                // It was destroyed before it was followed.
                Ok(Some(ServerEvent::Error(error))) if error.bad_value == window => {
                    return Ok(true);
                }
                Ok(Some(event)) => self.take_event(&event),
                Ok(None) => {
                    std::thread::sleep(POLL_PERIOD);
                    waited += POLL_PERIOD;
                }
                Err(error) => return Err(refused(&error)),
            }
        }
        Ok(false)
    }

    fn fake(&self, kind: u8, detail: u8, (dx, dy): (i16, i16)) -> Result<(), OutputError> {
        // Dropping the cookie means that no reply is requested.
        self.connection
            .xtest_fake_input(kind, detail, x11rb::CURRENT_TIME, x11rb::NONE, dx, dy, 0)
            .map(drop)
            .map_err(|error| refused(&error))
    }

    fn scroll(&self, notches: i32, more: u8, less: u8) -> Result<(), OutputError> {
        let button = if notches > 0 { more } else { less };
        for _ in 0..notches.unsigned_abs() {
            self.fake(BUTTON_PRESS_EVENT, button, (0, 0))?;
            self.fake(BUTTON_RELEASE_EVENT, button, (0, 0))?;
        }
        Ok(())
    }
}

impl OutputDevice for X11 {
    fn name(&self) -> &str {
        &self.name
    }

    fn supports(&self, output: Output) -> bool {
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
                self.fake(MOTION_NOTIFY_EVENT, RELATIVE, (to_i16(dx), to_i16(dy)))
            }
            Action::Wheel { dx, dy } => {
                let [up, down, left, right] = WHEEL;
                self.scroll(dy, up, down)?;
                self.scroll(dx, right, left)
            }
            Action::Press(Output::Button(_))
            | Action::Release(Output::Button(_))
            | Action::Axis(..) => Ok(()),
        }
    }

    fn flush(&mut self) -> Result<(), OutputError> {
        self.connection.flush().map_err(|error| refused(&error))?;
        self.take_events()
    }

    /// Notices at once that the server is gone.
    fn idle(&mut self) -> Result<(), OutputError> {
        self.take_events()
    }
}

impl Drop for X11 {
    fn drop(&mut self) {
        self.finish();
    }
}

impl Watchable for X11 {
    fn release_handle(&self) -> std::io::Result<ReleaseHandle> {
        Ok(ReleaseHandle::X11 {
            display: self.display.clone(),
            window: self.window,
        })
    }

    fn reconnect(&mut self) -> Result<(), OutputError> {
        Ok(())
    }

    /// A message to the own window: the server sends it back after everything before it.
    fn request_confirmation(&mut self) -> Result<Option<u32>, OutputError> {
        self.requested = self.requested.wrapping_add(1);
        let data = [self.requested, 0, 0, 0, 0];
        let message = ClientMessageEvent::new(32, self.window, AtomEnum::INTEGER, data);
        // Without a mask it goes to the client that made the window.
        self.connection
            .send_event(false, self.window, EventMask::NO_EVENT, message)
            .map_err(|error| refused(&error))?;
        Ok(Some(self.requested))
    }

    fn confirmed(&self) -> u32 {
        self.confirmed
    }

    /// Waits until the server has read everything: when a client disconnects, the server drops what it has
    /// not read yet, which may be the release of a key.
    fn finish(&mut self) -> bool {
        if std::mem::replace(&mut self.is_finished, true) {
            return false;
        }
        let wanted = ChangeWindowAttributesAux::new().event_mask(EventMask::STRUCTURE_NOTIFY);
        let own = self.window;
        let requested = self
            .connection
            .change_window_attributes(own, &wanted)
            .is_ok()
            && self.connection.destroy_window(own).is_ok()
            && self.connection.flush().is_ok();
        // A display that is gone holds no key.
        !requested || self.wait_for_end_of(own, END_WAIT).unwrap_or(true)
    }
}

fn invisible_window(connection: &RustConnection) -> Result<Window, ReplyOrIdError> {
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

/// Pixels in the protocol's range.
fn to_i16(pixels: i32) -> i16 {
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
