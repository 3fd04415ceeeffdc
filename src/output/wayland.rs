//! The keyboard and mouse of a Wayland desktop, by the protocols `zwp_virtual_keyboard_v1` and `zwlr_virtual_pointer_v1`.
//!
//! Compositors of the wlroots family (sway, river, Hyprland) have them; GNOME, KDE and weston do not. Spoken here and not by
//! way of a library that types text: a modifier must arrive as a key too, for games bind it. The keymap is the seat's own, and
//! nothing is ever mapped anew; a seat without a keyboard gets the one of a plain PC keyboard, which the compositor compiles
//! (so no libxkbcommon is needed here).
//!
//! A compositor releases what a client holds when its connection ends: a watcher ends it where gelpad is stopped
//! (`watch/`).

use std::io::Write as _;
use std::os::fd::{AsFd as _, OwnedFd};
use std::os::unix::fs::FileExt as _;
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::time::Instant;

use wayland_client::backend::WaylandError;
use wayland_client::globals::{GlobalListContents, registry_queue_init};
use wayland_client::protocol::wl_keyboard::{self, KeymapFormat, WlKeyboard};
use wayland_client::protocol::wl_pointer::{Axis, AxisSource, ButtonState};
use wayland_client::protocol::wl_registry::{self, WlRegistry};
use wayland_client::protocol::wl_seat::{self, Capability, WlSeat};
use wayland_client::{Connection, Dispatch, EventQueue, QueueHandle, WEnum, delegate_noop};
use wayland_protocols_misc::zwp_virtual_keyboard_v1::client::zwp_virtual_keyboard_manager_v1::ZwpVirtualKeyboardManagerV1;
use wayland_protocols_misc::zwp_virtual_keyboard_v1::client::zwp_virtual_keyboard_v1::ZwpVirtualKeyboardV1;
use wayland_protocols_wlr::virtual_pointer::v1::client::zwlr_virtual_pointer_manager_v1::ZwlrVirtualPointerManagerV1;
use wayland_protocols_wlr::virtual_pointer::v1::client::zwlr_virtual_pointer_v1::ZwlrVirtualPointerV1;

use super::watch::{Grip, Watchable};
use super::{Device, OutputError};
use crate::types::{Action, Event, Key, MouseButton, Output};

/// What a PC keyboard means, by the names of the compositor's own rules.
const PC_KEYMAP: &str = "xkb_keymap {\n\
    xkb_keycodes { include \"evdev+aliases(qwerty)\" };\n\
    xkb_types { include \"complete\" };\n\
    xkb_compat { include \"complete\" };\n\
    xkb_symbols { include \"pc+us+inet(evdev)\" };\n};\n";
/// A notch of the wheel, in the protocol's units of motion (as libinput gives it).
const NOTCH: f64 = 15.0;
/// Real modifiers of XKB, whose order is fixed.
const SHIFT: u32 = 1;
const CONTROL: u32 = 1 << 2;
const MOD1: u32 = 1 << 3;
const MOD4: u32 = 1 << 6;
const MOD5: u32 = 1 << 7;

/// A connection to a compositor.
pub struct Wayland {
    connection: Connection,
    queue: EventQueue<Seat>,
    seat: Seat,
    /// The connection's own socket, to be shared with a watcher.
    socket: UnixStream,
    name: String,
    keyboard: ZwpVirtualKeyboardV1,
    pointer: Option<ZwlrVirtualPointerV1>,
    pointed: bool,
    modifiers: Vec<Key>,
    has_alt_gr: bool,
    start: Instant,
    /// Whether the connection was cut: there is nobody to say farewell to.
    is_cut: bool,
}

impl Wayland {
    /// Connects to the compositor that `WAYLAND_DISPLAY` names.
    ///
    /// # Errors
    /// No compositor, or one without a virtual keyboard.
    pub fn connect() -> Result<Self, OutputError> {
        let display = std::env::var_os("WAYLAND_DISPLAY")
            .filter(|name| !name.is_empty())
            .ok_or_else(|| unreachable("WAYLAND_DISPLAY names no Wayland display"))?;
        let shown = display.to_string_lossy().into_owned();
        let no_answer = |error: &dyn std::fmt::Display| {
            unreachable(&format!(
                "the Wayland display {shown} did not answer ({error}): is it running, and may you use it?"
            ))
        };
        let folder = std::env::var_os("XDG_RUNTIME_DIR").unwrap_or_default();
        // An absolute name stands for itself.
        let path = PathBuf::from(folder).join(display);
        let socket = UnixStream::connect(path).map_err(|error| no_answer(&error))?;
        let ours = socket.try_clone().map_err(|error| no_answer(&error))?;
        let connection = Connection::from_socket(ours).map_err(|error| no_answer(&error))?;
        let (globals, mut queue) =
            registry_queue_init::<Seat>(&connection).map_err(|error| no_answer(&error))?;
        let handle = queue.handle();
        let mut seat = Seat::default();
        let keyboards: ZwpVirtualKeyboardManagerV1 =
            globals.bind(&handle, 1..=1, ()).map_err(|_| {
                unreachable(&format!(
                    "the compositor of {shown} has no virtual keyboard (protocol zwp_virtual_keyboard_v1; GNOME, KDE and \
                     weston lack it): use --output gamepad, whose keyboard is the kernel's"
                ))
            })?;
        let wl_seat: WlSeat = globals
            .bind(&handle, 1..=5, ())
            .map_err(|error| no_answer(&error))?;
        let pointers: Option<ZwlrVirtualPointerManagerV1> = globals.bind(&handle, 1..=2, ()).ok();
        // Once for what the seat has, once for its keymap.
        for _ in 0..2 {
            queue
                .roundtrip(&mut seat)
                .map_err(|error| no_answer(&error))?;
        }
        let keyboard = keyboards.create_virtual_keyboard(&wl_seat, &handle, ());
        let (keymap, size) = match seat.keymap.take() {
            Some(keymap) => keymap,
            None => pc_keymap().map_err(|error| no_answer(&error))?,
        };
        let has_alt_gr = has_alt_gr(&keymap, size);
        keyboard.keymap(KeymapFormat::XkbV1 as u32, keymap.as_fd(), size);
        let pointer =
            pointers.map(|pointers| pointers.create_virtual_pointer(Some(&wl_seat), &handle, ()));
        queue
            .roundtrip(&mut seat)
            .map_err(|error| no_answer(&error))?;
        Ok(Self {
            connection,
            queue,
            seat,
            socket,
            name: format!("keyboard and mouse of the Wayland display {shown}"),
            keyboard,
            pointer,
            pointed: false,
            modifiers: Vec::new(),
            has_alt_gr,
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
        // A virtual keyboard's keys do not move the compositor's modifiers: they are told.
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

    /// Takes what the compositor has said.
    fn take(&mut self) -> Result<(), OutputError> {
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

impl Device for Wayland {
    fn name(&self) -> &str {
        &self.name
    }

    fn takes(&self, output: Output) -> bool {
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
        self.take()
    }

    fn idle(&mut self) -> Result<(), OutputError> {
        self.take()
    }
}

impl Watchable for Wayland {
    fn grip(&self) -> std::io::Result<Grip> {
        Ok(Grip::Cut(self.socket.try_clone()?.into()))
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
        // A compositor that is gone has nothing to forget.
        let _ = self.connection.flush();
    }
}

/// What the compositor tells of the seat.
#[derive(Debug, Default)]
struct Seat {
    keyboard: Option<WlKeyboard>,
    keymap: Option<(OwnedFd, u32)>,
}

impl Dispatch<WlSeat, ()> for Seat {
    fn event(
        state: &mut Self,
        seat: &WlSeat,
        event: wl_seat::Event,
        (): &(),
        _: &Connection,
        handle: &QueueHandle<Self>,
    ) {
        if let wl_seat::Event::Capabilities {
            capabilities: WEnum::Value(has),
        } = event
            && has.contains(Capability::Keyboard)
            && state.keyboard.is_none()
        {
            state.keyboard = Some(seat.get_keyboard(handle, ()));
        }
    }
}

impl Dispatch<WlKeyboard, ()> for Seat {
    fn event(
        state: &mut Self,
        _: &WlKeyboard,
        event: wl_keyboard::Event,
        (): &(),
        _: &Connection,
        _: &QueueHandle<Self>,
    ) {
        if let wl_keyboard::Event::Keymap {
            format: WEnum::Value(KeymapFormat::XkbV1),
            fd,
            size,
        } = event
        {
            state.keymap = Some((fd, size));
        }
    }
}

impl Dispatch<WlRegistry, GlobalListContents> for Seat {
    fn event(
        _: &mut Self,
        _: &WlRegistry,
        _: wl_registry::Event,
        _: &GlobalListContents,
        _: &Connection,
        _: &QueueHandle<Self>,
    ) {
    }
}

delegate_noop!(Seat: ZwpVirtualKeyboardManagerV1);
delegate_noop!(Seat: ZwpVirtualKeyboardV1);
delegate_noop!(Seat: ZwlrVirtualPointerManagerV1);
delegate_noop!(Seat: ZwlrVirtualPointerV1);

/// The keymap of a plain PC keyboard in a file of memory, and its size with the zero at its end.
fn pc_keymap() -> std::io::Result<(OwnedFd, u32)> {
    let memory = rustix::fs::memfd_create("gelpad-keymap", rustix::fs::MemfdFlags::CLOEXEC)?;
    let mut file = std::fs::File::from(memory);
    file.write_all(PC_KEYMAP.as_bytes())?;
    file.write_all(&[0])?;
    Ok((file.into(), PC_KEYMAP.len() as u32 + 1))
}

/// Whether the right alt key chooses the third level of symbols.
fn has_alt_gr(keymap: &OwnedFd, size: u32) -> bool {
    let mut bytes = vec![0; size as usize];
    let Ok(file) = keymap.try_clone().map(std::fs::File::from) else {
        return false;
    };
    if file.read_exact_at(&mut bytes, 0).is_err() {
        return false;
    }
    let text = String::from_utf8_lossy(&bytes);
    text.lines()
        .any(|line| line.contains("<RALT>") && line.contains("ISO_Level3_Shift"))
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

#[allow(
    clippy::disallowed_methods,
    reason = "the protocol's events carry the time of a clock"
)]
fn now() -> Instant {
    Instant::now()
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
