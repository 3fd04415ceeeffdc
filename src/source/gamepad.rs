//! Physical gamepads and switches as a source without images: their buttons and sticks trigger a profile's bindings.
//!
//! The combined state of all devices is returned after every report, and at least ten times a second, so that
//! the engine notices when nobody reads the devices any more. gelpad's own virtual pad is excluded.

use std::time::{Duration, Instant, SystemTime};

use gilrs::ev::Code;
use gilrs::{
    Axis as GamepadAxis, Button as GamepadButton, EventType, GamepadId, Gilrs, GilrsBuilder,
};

use super::clock::now;
use super::{Source, SourceError, SourcePace, SourceReading};
use crate::types::{Axis, Button, Buttons, Control, Nanos};

/// A state is returned at least this often.
const HEARTBEAT: Duration = Duration::from_millis(100);
/// Pause after the library woke up without an event.
const IDLE_PAUSE: Duration = Duration::from_millis(2);
/// How often the devices are listed again while there is none: a device that connects while another
/// disconnects may be missed.
const LIST_PERIOD: Duration = Duration::from_secs(1);
/// Vendor and product of gelpad's own pad, and of many real ones.
const OWN_ID: (Option<u16>, Option<u16>) = (Some(0x045e), Some(0x028e));
/// Codes of buttons without a layout start at a multiple of this in the kernel.
const BLOCK: u32 = 16;

/// The library's names of the buttons.
const BUTTONS: &[(Button, GamepadButton)] = &[
    (Button::A, GamepadButton::South),
    (Button::B, GamepadButton::East),
    (Button::X, GamepadButton::West),
    (Button::Y, GamepadButton::North),
    (Button::LeftShoulder, GamepadButton::LeftTrigger),
    (Button::RightShoulder, GamepadButton::RightTrigger),
    (Button::Select, GamepadButton::Select),
    (Button::Start, GamepadButton::Start),
    (Button::Guide, GamepadButton::Mode),
    (Button::LeftStick, GamepadButton::LeftThumb),
    (Button::RightStick, GamepadButton::RightThumb),
    (Button::Up, GamepadButton::DPadUp),
    (Button::Down, GamepadButton::DPadDown),
    (Button::Left, GamepadButton::DPadLeft),
    (Button::Right, GamepadButton::DPadRight),
];
/// The library's names of the sticks.
const STICKS: &[(Axis, GamepadAxis)] = &[
    (Axis::LeftX, GamepadAxis::LeftStickX),
    (Axis::LeftY, GamepadAxis::LeftStickY),
    (Axis::RightX, GamepadAxis::RightStickX),
    (Axis::RightY, GamepadAxis::RightStickY),
];
/// The library's names of the triggers: buttons with a value.
const TRIGGERS: &[(Axis, GamepadButton)] = &[
    (Axis::LeftTrigger, GamepadButton::LeftTrigger2),
    (Axis::RightTrigger, GamepadButton::RightTrigger2),
];

/// All gamepads and switches that are plugged in, at the start or later.
pub struct GamepadSource {
    gilrs: Gilrs,
    opened: Instant,
    /// Devices whose state counts.
    devices: Vec<GamepadState>,
    own: OwnPad,
    /// The first event after the report that was returned last.
    next: Option<gilrs::Event>,
    /// The state that was returned last.
    last: Option<Control>,
    listed_at: Instant,
}

/// gelpad's own pad: it looks like a real one and is known only by the time at which it appears.
enum OwnPad {
    None,
    Expected,
    Is(GamepadId),
}

/// The events of a device that belong to one report and carry one time; half of a report is not a state. With
/// a coarse clock a whole tap may carry one time too, but no report both presses and releases a button.
struct Report {
    id: GamepadId,
    time: SystemTime,
    buttons: Vec<Code>,
}

impl Report {
    fn from_first(first: &gilrs::Event) -> Self {
        Self {
            id: first.id,
            time: first.time,
            buttons: Vec::from_iter(button_of(&first.event)),
        }
    }

    /// Whether an event belongs to this report.
    fn includes(&mut self, event: &gilrs::Event) -> bool {
        let button = button_of(&event.event);
        let again = button.is_some_and(|button| self.buttons.contains(&button));
        self.buttons.extend(button);
        (event.id, event.time) == (self.id, self.time) && !again
    }
}

/// The button that an event presses or releases.
fn button_of(event: &EventType) -> Option<Code> {
    match *event {
        EventType::ButtonPressed(_, code) | EventType::ButtonReleased(_, code) => Some(code),
        _ => None,
    }
}

struct GamepadState {
    id: GamepadId,
    name: String,
    /// The state after the events taken so far; the library's own state is ahead of them. The buttons of a
    /// switch box, which has no gamepad layout, are a, b, x, y, ... in their order.
    buttons: Buttons,
    axes: [f32; Axis::ALL.len()],
}

impl GamepadSource {
    /// Opens all devices that are plugged in; more may follow later.
    ///
    /// # Errors
    /// The system gives no access to input devices.
    pub fn open() -> Result<Self, SourceError> {
        let mut source = Self {
            gilrs: open_library()?,
            opened: now(),
            devices: Vec::new(),
            own: OwnPad::None,
            next: None,
            last: None,
            listed_at: now(),
        };
        source.add_all();
        if source.devices.is_empty() {
            tracing::warn!("no gamepad is plugged in yet: plug one in at any time");
        }
        Ok(source)
    }

    /// gelpad creates its own pad after this source: the next matching device is that pad, and is ignored.
    #[must_use]
    pub fn ignoring_own_pad(mut self) -> Self {
        self.own = OwnPad::Expected;
        self
    }

    /// Adds all devices that are plugged in.
    fn add_all(&mut self) {
        let ids: Vec<GamepadId> = self.gilrs.gamepads().map(|(id, _)| id).collect();
        for id in ids {
            self.connected(id);
        }
    }

    /// Lists the devices again if there are none.
    fn list_again(&mut self) -> Result<(), SourceError> {
        let alone = self.devices.is_empty() && matches!(self.own, OwnPad::None);
        if alone && self.listed_at.elapsed() > LIST_PERIOD {
            self.listed_at = now();
            self.gilrs = open_library()?;
            self.add_all();
        }
        Ok(())
    }

    fn connected(&mut self, id: GamepadId) {
        if self.devices.iter().any(|device| device.id == id) {
            return;
        }
        let gamepad = self.gilrs.gamepad(id);
        let identity = (gamepad.vendor_id(), gamepad.product_id());
        // XInput names no vendor.
        let looks_own = identity == OWN_ID || identity == (None, None);
        if looks_own && matches!(self.own, OwnPad::Expected) {
            self.own = OwnPad::Is(id);
            return;
        }
        let name = gamepad.name().to_owned();
        tracing::warn!("gamepad: {name}");
        self.devices.push(GamepadState {
            id,
            name,
            buttons: Buttons::default(),
            axes: Default::default(),
        });
    }

    fn disconnected(&mut self, id: GamepadId) {
        if matches!(self.own, OwnPad::Is(own) if own == id) {
            self.own = OwnPad::None;
        }
        let gone = self.devices.iter().position(|device| device.id == id);
        if let Some(index) = gone {
            let name = self.devices.remove(index).name;
            tracing::warn!("gamepad disconnected: {name}: all keys are released until it is back");
        }
    }

    fn handle_event(&mut self, event: &gilrs::Event) {
        match event.event {
            EventType::Connected => return self.connected(event.id),
            EventType::Disconnected => return self.disconnected(event.id),
            _ => {}
        }
        let device = self.devices.iter_mut().find(|device| device.id == event.id);
        if let Some(device) = device {
            device.handle_event(&event.event);
        }
    }

    /// The combined state: a button counts if it is down on any device, an axis has the value furthest from zero.
    fn state(&self) -> Control {
        let mut control = Control {
            t_ns: Nanos::try_from(self.opened.elapsed().as_nanos()).unwrap_or(Nanos::MAX),
            present: !self.devices.is_empty(),
            ..Control::default()
        };
        for device in &self.devices {
            let bits = control.buttons.bits() | device.buttons.bits();
            control.buttons = Buttons::from_bits(bits);
            for (furthest, value) in control.axes.iter_mut().zip(device.axes) {
                if value.abs() > furthest.abs() {
                    *furthest = value;
                }
            }
        }
        control
    }
}

impl GamepadState {
    fn handle_event(&mut self, event: &EventType) {
        match *event {
            EventType::ButtonPressed(GamepadButton::Unknown, code) => {
                self.set_button(switch_button(code.into_u32()), true);
            }
            EventType::ButtonReleased(GamepadButton::Unknown, code) => {
                self.set_button(switch_button(code.into_u32()), false);
            }
            EventType::ButtonPressed(pressed, _) => {
                self.set_button(translated(BUTTONS, pressed), true);
                self.set_axis(translated(TRIGGERS, pressed), 1.0);
            }
            EventType::ButtonReleased(pressed, _) => {
                self.set_button(translated(BUTTONS, pressed), false);
                self.set_axis(translated(TRIGGERS, pressed), 0.0);
            }
            EventType::ButtonChanged(pressed, value, _) => {
                self.set_axis(translated(TRIGGERS, pressed), value);
            }
            EventType::AxisChanged(from, value, _) => {
                self.set_axis(translated(STICKS, from), value)
            }
            _ => {}
        }
    }

    fn set_button(&mut self, button: Option<Button>, is_down: bool) {
        if let Some(button) = button {
            self.buttons = match is_down {
                true => self.buttons.with(button),
                false => self.buttons.without(button),
            };
        }
    }

    fn set_axis(&mut self, axis: Option<Axis>, value: f32) {
        if let Some(axis) = axis {
            self.axes[axis as usize] = value;
        }
    }
}

impl Source for GamepadSource {
    fn pace(&self) -> SourcePace {
        SourcePace::ByDevice
    }

    fn read(&mut self) -> Result<SourceReading, SourceError> {
        self.list_again()?;
        let first = match self.next.take() {
            Some(event) => Some(event),
            None => self.gilrs.next_event_blocking(Some(HEARTBEAT)),
        };
        match first {
            Some(first) => {
                self.handle_event(&first);
                let mut report = Report::from_first(&first);
                while let Some(event) = self.gilrs.next_event() {
                    if !report.includes(&event) {
                        self.next = Some(event);
                        break;
                    }
                    self.handle_event(&event);
                }
            }
            None => std::thread::sleep(IDLE_PAUSE),
        }
        let state = self.state();
        let is_new = match &self.last {
            Some(last) => {
                let long = state.t_ns - last.t_ns >= HEARTBEAT.as_nanos() as Nanos;
                let values_of = |of: &Control| (of.present, of.buttons, of.axes);
                long || values_of(last) != values_of(&state)
            }
            None => true,
        };
        if !is_new {
            return Ok(SourceReading::Idle);
        }
        self.last = Some(state);
        Ok(SourceReading::Control(state))
    }
}

fn open_library() -> Result<Gilrs, SourceError> {
    GilrsBuilder::new()
        .with_force_feedback(false)
        .build()
        .map_err(|error| SourceError::Gamepads {
            reason: error.to_string(),
        })
}

/// Our name for a name of the library.
fn translated<T: Copy, L: Copy + PartialEq>(table: &[(T, L)], theirs: L) -> Option<T> {
    table
        .iter()
        .find(|(_, one)| *one == theirs)
        .map(|(ours, _)| *ours)
}

/// The button for a switch without a layout, by the kernel's code.
fn switch_button(code: u32) -> Option<Button> {
    Button::ALL.get((code % BLOCK) as usize).copied()
}
