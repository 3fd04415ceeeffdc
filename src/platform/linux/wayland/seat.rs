//! The seat of a compositor: its keyboard and keymap.

use std::io::Write as _;
use std::os::fd::OwnedFd;
use std::os::unix::fs::FileExt as _;

use wayland_client::globals::GlobalListContents;
use wayland_client::protocol::wl_keyboard::{self, KeymapFormat, WlKeyboard};
use wayland_client::protocol::wl_registry::{self, WlRegistry};
use wayland_client::protocol::wl_seat::{self, Capability, WlSeat};
use wayland_client::{Connection, Dispatch, QueueHandle, WEnum, delegate_noop};
use wayland_protocols_misc::zwp_virtual_keyboard_v1::client::zwp_virtual_keyboard_manager_v1::ZwpVirtualKeyboardManagerV1;
use wayland_protocols_misc::zwp_virtual_keyboard_v1::client::zwp_virtual_keyboard_v1::ZwpVirtualKeyboardV1;
use wayland_protocols_wlr::virtual_pointer::v1::client::zwlr_virtual_pointer_manager_v1::ZwlrVirtualPointerManagerV1;
use wayland_protocols_wlr::virtual_pointer::v1::client::zwlr_virtual_pointer_v1::ZwlrVirtualPointerV1;

/// The keymap of a plain PC keyboard; the compositor compiles it, so libxkbcommon is not needed here.
const PC_KEYMAP: &str = "xkb_keymap {\n\
    xkb_keycodes { include \"evdev+aliases(qwerty)\" };\n\
    xkb_types { include \"complete\" };\n\
    xkb_compat { include \"complete\" };\n\
    xkb_symbols { include \"pc+us+inet(evdev)\" };\n};\n";
/// What the compositor reports about the seat.
#[derive(Debug, Default)]
pub(super) struct Seat {
    keyboard: Option<WlKeyboard>,
    keymap: Option<Keymap>,
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
            state.keymap = Some(Keymap { file: fd, size });
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

impl Seat {
    /// The seat's keymap; that of a plain PC keyboard if the seat has none.
    pub(super) fn take_keymap(&mut self) -> std::io::Result<Keymap> {
        match self.keymap.take() {
            Some(keymap) => Ok(keymap),
            None => Keymap::pc(),
        }
    }
}

/// A keymap as text in a file in memory.
#[derive(Debug)]
pub(super) struct Keymap {
    pub(super) file: OwnedFd,
    /// Size in bytes, with the zero at the end.
    pub(super) size: u32,
}

impl Keymap {
    fn pc() -> std::io::Result<Self> {
        let memory = rustix::fs::memfd_create("gelpad-keymap", rustix::fs::MemfdFlags::CLOEXEC)?;
        let mut file = std::fs::File::from(memory);
        file.write_all(PC_KEYMAP.as_bytes())?;
        file.write_all(&[0])?;
        Ok(Self {
            file: file.into(),
            size: PC_KEYMAP.len() as u32 + 1,
        })
    }

    /// Whether the right alt key selects the third level of symbols.
    pub(super) fn has_alt_gr(&self) -> bool {
        let mut bytes = vec![0; self.size as usize];
        let Ok(file) = self.file.try_clone().map(std::fs::File::from) else {
            return false;
        };
        if file.read_exact_at(&mut bytes, 0).is_err() {
            return false;
        }
        let text = String::from_utf8_lossy(&bytes);
        text.lines()
            .any(|line| line.contains("<RALT>") && line.contains("ISO_Level3_Shift"))
    }
}
