//! Physical gamepads and switches as a source without image: their buttons and sticks play a profile's bindings.
//!
//! What all devices say together is handed up as a whole at every report, and ten times a second besides, so that the
//! engine knows from silence that nobody reads the devices any more. gelpad's own virtual pad is never among them.

use std::time::{Duration, Instant, SystemTime};

use gilrs::ev::Code;
use gilrs::{Axis as From, Button as Pressed, EventType, GamepadId, Gilrs, GilrsBuilder};

use super::{Pace, Reading, Source, SourceError};
use crate::types::{Axis, Button, Buttons, Control, Nanos};

/// A state is handed up at least this often.
const HEARTBEAT: Duration = Duration::from_millis(100);
/// Where the library wakes for nothing, it is asked again after this.
const NAP: Duration = Duration::from_millis(2);
/// While no device is there, they are looked for anew this often: one that comes while another goes may be missed.
const LOOK: Duration = Duration::from_secs(1);
/// The maker and kind of gelpad's own pad, and of many that are not.
const OWN_ID: (Option<u16>, Option<u16>) = (Some(0x045e), Some(0x028e));
/// Buttons without a layout count up from a multiple of this in the kernel's codes.
const BLOCK: u32 = 16;

/// What the buttons of a gamepad are to the library.
const BUTTONS: &[(Button, Pressed)] = &[
    (Button::A, Pressed::South),
    (Button::B, Pressed::East),
    (Button::X, Pressed::West),
    (Button::Y, Pressed::North),
    (Button::LeftShoulder, Pressed::LeftTrigger),
    (Button::RightShoulder, Pressed::RightTrigger),
    (Button::Select, Pressed::Select),
    (Button::Start, Pressed::Start),
    (Button::Guide, Pressed::Mode),
    (Button::LeftStick, Pressed::LeftThumb),
    (Button::RightStick, Pressed::RightThumb),
    (Button::Up, Pressed::DPadUp),
    (Button::Down, Pressed::DPadDown),
    (Button::Left, Pressed::DPadLeft),
    (Button::Right, Pressed::DPadRight),
];
/// And its sticks.
const STICKS: &[(Axis, From)] = &[
    (Axis::LeftX, From::LeftStickX),
    (Axis::LeftY, From::LeftStickY),
    (Axis::RightX, From::RightStickX),
    (Axis::RightY, From::RightStickY),
];
/// And its triggers: as buttons that are pressed more or less.
const TRIGGERS: &[(Axis, Pressed)] = &[
    (Axis::LeftTrigger, Pressed::LeftTrigger2),
    (Axis::RightTrigger, Pressed::RightTrigger2),
];

/// All gamepads and switches that are plugged in, now or later.
pub struct GamepadSource {
    gilrs: Gilrs,
    opened: Instant,
    /// Devices that count.
    devices: Vec<Device>,
    own: Own,
    /// What came after the report that was handed up last.
    next: Option<gilrs::Event>,
    /// The last state, and when it was handed up.
    told: Option<Control>,
    looked: Instant,
}

/// The pad that gelpad itself has made: nothing tells it from a real one but that it comes when it is expected.
enum Own {
    None,
    Expected,
    Is(GamepadId),
}

/// The events of a device that belong together: half of a report is no state. They carry one time; but where the
/// clock is coarse a whole tap does too, and no report presses a button and releases it.
struct Report {
    id: GamepadId,
    time: SystemTime,
    buttons: Vec<Code>,
}

impl Report {
    fn of(first: &gilrs::Event) -> Self {
        Self {
            id: first.id,
            time: first.time,
            buttons: Vec::from_iter(button_of(&first.event)),
        }
    }

    /// Whether an event is one more of this report.
    fn takes(&mut self, event: &gilrs::Event) -> bool {
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

struct Device {
    id: GamepadId,
    name: String,
    /// As far as its events have been taken: the library's own state is ahead of them. The buttons of a switch box, which
    /// has no gamepad's layout, are a, b, x, y, ... in their order.
    buttons: Buttons,
    axes: [f32; Axis::ALL.len()],
}

impl GamepadSource {
    /// Opens whatever is plugged in; more may come later.
    ///
    /// # Errors
    /// Input devices cannot be watched at all.
    #[allow(
        clippy::disallowed_methods,
        reason = "what a gamepad says is stamped on arrival"
    )]
    pub fn open() -> Result<Self, SourceError> {
        let mut source = Self {
            gilrs: library()?,
            opened: Instant::now(),
            devices: Vec::new(),
            own: Own::None,
            next: None,
            told: None,
            looked: Instant::now(),
        };
        source.take_all();
        if source.devices.is_empty() {
            tracing::warn!("no gamepad is plugged in yet: plug one in whenever you like");
        }
        Ok(source)
    }

    /// Since this was opened gelpad has made a pad of its own: the next one of its kind to come is that, and plays
    /// nothing.
    #[must_use]
    pub fn beside_own_pad(mut self) -> Self {
        self.own = Own::Expected;
        self
    }

    /// Takes whatever is plugged in.
    fn take_all(&mut self) {
        let there: Vec<GamepadId> = self.gilrs.gamepads().map(|(id, _)| id).collect();
        for id in there {
            self.connected(id);
        }
    }

    /// Looks for devices anew, if there are none.
    #[allow(clippy::disallowed_methods, reason = "by the clock, not at every call")]
    fn look_again(&mut self) -> Result<(), SourceError> {
        let alone = self.devices.is_empty() && matches!(self.own, Own::None);
        if alone && self.looked.elapsed() > LOOK {
            self.looked = Instant::now();
            self.gilrs = library()?;
            self.take_all();
        }
        Ok(())
    }

    fn connected(&mut self, id: GamepadId) {
        if self.devices.iter().any(|device| device.id == id) {
            return;
        }
        let gamepad = self.gilrs.gamepad(id);
        let looks_own = (gamepad.vendor_id(), gamepad.product_id()) == OWN_ID;
        if looks_own && matches!(self.own, Own::Expected) {
            self.own = Own::Is(id);
            return;
        }
        let name = gamepad.name().to_owned();
        tracing::warn!("gamepad: {name}");
        self.devices.push(Device {
            id,
            name,
            buttons: Buttons::default(),
            axes: Default::default(),
        });
    }

    fn disconnected(&mut self, id: GamepadId) {
        if matches!(self.own, Own::Is(own) if own == id) {
            self.own = Own::None;
        }
        let gone = self.devices.iter().position(|device| device.id == id);
        if let Some(index) = gone {
            let name = self.devices.remove(index).name;
            tracing::warn!("the gamepad {name} is gone: all keys are up until it is back");
        }
    }

    fn take(&mut self, event: &gilrs::Event) {
        match event.event {
            EventType::Connected => return self.connected(event.id),
            EventType::Disconnected => return self.disconnected(event.id),
            _ => {}
        }
        let device = self.devices.iter_mut().find(|own| own.id == event.id);
        if let Some(device) = device {
            device.take(&event.event);
        }
    }

    /// What all devices say together: a button of any of them, the axis that is moved furthest.
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

impl Device {
    fn take(&mut self, event: &EventType) {
        match *event {
            EventType::ButtonPressed(Pressed::Unknown, code) => {
                self.button(switch(code.into_u32()), true);
            }
            EventType::ButtonReleased(Pressed::Unknown, code) => {
                self.button(switch(code.into_u32()), false);
            }
            EventType::ButtonPressed(pressed, _) => {
                self.button(found(BUTTONS, pressed), true);
                self.axis(found(TRIGGERS, pressed), 1.0);
            }
            EventType::ButtonReleased(pressed, _) => {
                self.button(found(BUTTONS, pressed), false);
                self.axis(found(TRIGGERS, pressed), 0.0);
            }
            EventType::ButtonChanged(pressed, value, _) => {
                self.axis(found(TRIGGERS, pressed), value);
            }
            EventType::AxisChanged(from, value, _) => self.axis(found(STICKS, from), value),
            _ => {}
        }
    }

    fn button(&mut self, button: Option<Button>, is_down: bool) {
        if let Some(button) = button {
            self.buttons = match is_down {
                true => self.buttons.with(button),
                false => self.buttons.without(button),
            };
        }
    }

    fn axis(&mut self, axis: Option<Axis>, value: f32) {
        if let Some(axis) = axis {
            self.axes[axis as usize] = value;
        }
    }
}

impl Source for GamepadSource {
    fn pace(&self) -> Pace {
        Pace::ByDevice
    }

    fn read(&mut self) -> Result<Reading, SourceError> {
        self.look_again()?;
        let first = match self.next.take() {
            Some(event) => Some(event),
            None => self.gilrs.next_event_blocking(Some(HEARTBEAT)),
        };
        match first {
            Some(first) => {
                self.take(&first);
                let mut report = Report::of(&first);
                while let Some(event) = self.gilrs.next_event() {
                    if !report.takes(&event) {
                        self.next = Some(event);
                        break;
                    }
                    self.take(&event);
                }
            }
            None => std::thread::sleep(NAP),
        }
        let state = self.state();
        let news = match &self.told {
            Some(told) => {
                let long = state.t_ns - told.t_ns >= HEARTBEAT.as_nanos() as Nanos;
                let said = |of: &Control| (of.present, of.buttons, of.axes);
                long || said(told) != said(&state)
            }
            None => true,
        };
        if !news {
            return Ok(Reading::Idle);
        }
        self.told = Some(state);
        Ok(Reading::Control(state))
    }
}

fn library() -> Result<Gilrs, SourceError> {
    GilrsBuilder::new()
        .with_force_feedback(false)
        .build()
        .map_err(|error| SourceError::Gamepads {
            reason: error.to_string(),
        })
}

/// What something of the library's is to us.
fn found<T: Copy, L: Copy + PartialEq>(table: &[(T, L)], theirs: L) -> Option<T> {
    table
        .iter()
        .find(|(_, one)| *one == theirs)
        .map(|(own, _)| *own)
}

/// The button that a switch without a layout is, by the kernel's code.
fn switch(code: u32) -> Option<Button> {
    Button::ALL.get((code % BLOCK) as usize).copied()
}
