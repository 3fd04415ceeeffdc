//! Keyboard and mouse of a Wayland desktop, by the protocols `zwp_virtual_keyboard_v1` and `zwlr_virtual_pointer_v1`.
//!
//! Compositors of the wlroots family (sway, river, Hyprland) have them; GNOME, KDE and weston do not. A
//! library that types text would not do: games bind modifiers, so those must arrive as keys too. The keymap
//! is the seat's own and is never changed.
//!
//! A compositor releases what a client holds when its connection ends. When gelpad is stopped, the watcher
//! ends it (`watch/`).

mod seat;

use std::os::fd::AsFd as _;
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::time::Instant;

use wayland_client::backend::WaylandError;
use wayland_client::globals::registry_queue_init;
use wayland_client::protocol::wl_keyboard::KeymapFormat;
use wayland_client::protocol::wl_pointer::{Axis, AxisSource, ButtonState};
use wayland_client::protocol::wl_seat::WlSeat;
use wayland_client::{Connection, EventQueue};
use wayland_protocols_misc::zwp_virtual_keyboard_v1::client::zwp_virtual_keyboard_manager_v1::ZwpVirtualKeyboardManagerV1;
use wayland_protocols_misc::zwp_virtual_keyboard_v1::client::zwp_virtual_keyboard_v1::ZwpVirtualKeyboardV1;
use wayland_protocols_wlr::virtual_pointer::v1::client::zwlr_virtual_pointer_manager_v1::ZwlrVirtualPointerManagerV1;
use wayland_protocols_wlr::virtual_pointer::v1::client::zwlr_virtual_pointer_v1::ZwlrVirtualPointerV1;

use crate::output::{OutputDevice, OutputError, now};
use crate::platform::watch::{ReleaseHandle, Watchable};
use crate::types::{Action, Event, Key, MouseButton, Output};
use seat::Seat;

/// Motion of one notch of the wheel, in the protocol's unit (as libinput reports it).
const NOTCH: f64 = 15.0;
/// Masks of the real modifiers of XKB; their order is fixed.
const SHIFT: u32 = 1;
const CONTROL: u32 = 1 << 2;
const MOD1: u32 = 1 << 3;
const MOD4: u32 = 1 << 6;
const MOD5: u32 = 1 << 7;

/// Why the virtual keyboard could not be created.
enum SetupError {
    NoVirtualKeyboard,
    NoAnswer(Box<dyn std::error::Error>),
}

impl<E: std::error::Error + 'static> From<E> for SetupError {
    fn from(error: E) -> Self {
        Self::NoAnswer(Box::new(error))
    }
}

/// A connection to a compositor.
pub struct Wayland {
    connection: Connection,
    queue: EventQueue<Seat>,
    seat: Seat,
    /// The connection's socket, to be shared with a watcher.
    socket: UnixStream,
    name: String,
    keyboard: ZwpVirtualKeyboardV1,
    pointer: Option<ZwlrVirtualPointerV1>,
    pointed: bool,
    modifiers: Vec<Key>,
    has_alt_gr: bool,
    start: Instant,
    /// Whether the watcher has shut down the connection: nothing can be sent any more.
    is_cut: bool,
}

impl Wayland {
    /// Connects to the compositor that `WAYLAND_DISPLAY` names.
    ///
    /// # Errors
    /// There is no compositor, or it has no virtual keyboard.
    pub fn connect() -> Result<Self, OutputError> {
        let display = std::env::var_os("WAYLAND_DISPLAY")
            .filter(|name| !name.is_empty())
            .ok_or_else(|| {
                unreachable("WAYLAND_DISPLAY is not set: start gelpad in a Wayland session")
            })?;
        let shown = display.to_string_lossy().into_owned();
        let folder = directories::BaseDirs::new()
            .and_then(|folders| folders.runtime_dir().map(PathBuf::from))
            .unwrap_or_default();
        // An absolute name replaces the folder.
        let socket = UnixStream::connect(folder.join(&display));
        socket
            .map_err(SetupError::from)
            .and_then(|socket| Self::over(socket, &shown))
            .map_err(|error| match error {
                SetupError::NoVirtualKeyboard => unreachable(&format!(
                    "the compositor of {shown} has no virtual keyboard (protocol zwp_virtual_keyboard_v1; GNOME, KDE \
                     and weston lack it): use --output gamepad, whose keyboard is a device of the kernel"
                )),
                SetupError::NoAnswer(error) => unreachable(&format!(
                    "the Wayland display {shown} did not answer ({error}): is it running, and may you use it?"
                )),
            })
    }

    /// Creates the virtual keyboard and pointer over a connected socket.
    fn over(socket: UnixStream, display: &str) -> Result<Self, SetupError> {
        let connection = Connection::from_socket(socket.try_clone()?)?;
        let (globals, mut queue) = registry_queue_init::<Seat>(&connection)?;
        let handle = queue.handle();
        let mut seat = Seat::default();
        let keyboards: ZwpVirtualKeyboardManagerV1 = globals
            .bind(&handle, 1..=1, ())
            .map_err(|_| SetupError::NoVirtualKeyboard)?;
        let wl_seat: WlSeat = globals.bind(&handle, 1..=5, ())?;
        let pointers: Option<ZwlrVirtualPointerManagerV1> = globals.bind(&handle, 1..=2, ()).ok();
        // The first roundtrip reports the seat's capabilities, the second its keymap.
        for _ in 0..2 {
            queue.roundtrip(&mut seat)?;
        }
        let keyboard = keyboards.create_virtual_keyboard(&wl_seat, &handle, ());
        let keymap = seat.take_keymap()?;
        keyboard.keymap(KeymapFormat::XkbV1 as u32, keymap.file.as_fd(), keymap.size);
        let pointer =
            pointers.map(|pointers| pointers.create_virtual_pointer(Some(&wl_seat), &handle, ()));
        queue.roundtrip(&mut seat)?;
        Ok(Self {
            connection,
            queue,
            seat,
            socket,
            name: format!("keyboard and mouse of the Wayland display {display}"),
            keyboard,
            pointer,
            pointed: false,
            modifiers: Vec::new(),
            has_alt_gr: keymap.has_alt_gr(),
            start: now(),
            is_cut: false,
        })
    }

    fn key(&mut self, key: Key, is_down: bool) {
        self.keyboard
            .key(self.time(), key.evdev_code().into(), is_down.into());
        if !key.is_modifier() {
            return;
        }
        // The compositor does not derive modifiers from a virtual keyboard's keys: they are sent separately.
        self.modifiers.retain(|one| *one != key);
        if is_down {
            self.modifiers.push(key);
        }
        let masks = self.modifiers.iter().map(|key| self.mask(*key));
        let depressed = masks.fold(0, |all, one| all | one);
        self.keyboard.modifiers(depressed, 0, 0, 0);
    }

    fn mask(&self, key: Key) -> u32 {
        match key.to_string().as_str() {
            "left-shift" | "right-shift" => SHIFT,
            "left-ctrl" | "right-ctrl" => CONTROL,
            "left-meta" | "right-meta" => MOD4,
            "right-alt" if self.has_alt_gr => MOD5,
            _ => MOD1,
        }
    }

    fn point(&mut self, action: impl Fn(&ZwlrVirtualPointerV1, u32)) {
        if let Some(pointer) = &self.pointer {
            action(pointer, self.time());
            self.pointed = true;
        }
    }

    /// The protocol's time stamp, ms.
    fn time(&self) -> u32 {
        now().saturating_duration_since(self.start).as_millis() as u32
    }

    /// Reads and dispatches the compositor's messages.
    fn dispatch(&mut self) -> Result<(), OutputError> {
        if let Some(guard) = self.queue.prepare_read() {
            match guard.read() {
                Ok(_) => {}
                Err(WaylandError::Io(error)) if error.kind() == std::io::ErrorKind::WouldBlock => {}
                Err(error) => return Err(refused(&error)),
            }
        }
        self.queue
            .dispatch_pending(&mut self.seat)
            .map(drop)
            .map_err(|error| refused(&error))
    }
}

impl OutputDevice for Wayland {
    fn name(&self) -> &str {
        &self.name
    }

    fn supports(&self, output: Output) -> bool {
        match output {
            Output::Key(_) => true,
            Output::Mouse(_) => self.pointer.is_some(),
            Output::Button(_) => false,
        }
    }

    fn send(&mut self, event: &Event) -> Result<(), OutputError> {
        match event.action {
            Action::Press(Output::Key(key)) => self.key(key, true),
            Action::Release(Output::Key(key)) => self.key(key, false),
            Action::Press(Output::Mouse(which)) => {
                self.point(|pointer, time| {
                    pointer.button(time, button(which), ButtonState::Pressed)
                });
            }
            Action::Release(Output::Mouse(which)) => {
                self.point(|pointer, time| {
                    pointer.button(time, button(which), ButtonState::Released)
                });
            }
            Action::Motion { dx, dy } => {
                self.point(|pointer, time| pointer.motion(time, dx.into(), dy.into()));
            }
            Action::Wheel { dx, dy } => {
                for (axis, notches) in [(Axis::HorizontalScroll, dx), (Axis::VerticalScroll, -dy)] {
                    if notches != 0 {
                        self.point(|pointer, time| {
                            pointer.axis_source(AxisSource::Wheel);
                            pointer.axis_discrete(time, axis, NOTCH * f64::from(notches), notches);
                        });
                    }
                }
            }
            Action::Press(Output::Button(_))
            | Action::Release(Output::Button(_))
            | Action::Axis(..) => {}
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), OutputError> {
        if let Some(pointer) = self.pointer.as_ref().filter(|_| self.pointed) {
            pointer.frame();
            self.pointed = false;
        }
        self.connection.flush().map_err(|error| refused(&error))?;
        self.dispatch()
    }

    fn idle(&mut self) -> Result<(), OutputError> {
        self.dispatch()
    }
}

impl Watchable for Wayland {
    fn release_handle(&self) -> std::io::Result<ReleaseHandle> {
        Ok(ReleaseHandle::Connection(self.socket.try_clone()?.into()))
    }

    fn reconnect(&mut self) -> Result<(), OutputError> {
        self.is_cut = true;
        *self = Self::connect()?;
        Ok(())
    }
}

impl Drop for Wayland {
    fn drop(&mut self) {
        if self.is_cut {
            return;
        }
        self.keyboard.destroy();
        if let Some(pointer) = &self.pointer {
            pointer.destroy();
        }
        // If the compositor is gone, nothing is left to do.
        let _ = self.connection.flush();
    }
}

/// Buttons by their evdev codes (`BTN_LEFT` and so on).
fn button(which: MouseButton) -> u32 {
    match which {
        MouseButton::Left => 0x110,
        MouseButton::Right => 0x111,
        MouseButton::Middle => 0x112,
        MouseButton::Back => 0x113,
        MouseButton::Forward => 0x114,
    }
}

fn unreachable(reason: &str) -> OutputError {
    OutputError::NoDevice {
        device: "Wayland",
        reason: reason.to_owned(),
    }
}

fn refused(error: &dyn std::fmt::Display) -> OutputError {
    OutputError::Refused {
        device: "Wayland display",
        reason: error.to_string(),
    }
}
