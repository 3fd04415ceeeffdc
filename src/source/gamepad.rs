//! Physical gamepads and switches as a source without image: their buttons and sticks play a profile's bindings.
//!
//! What all devices say together is handed up as a whole at every report, and ten times a second besides, so that the
//! engine knows from silence that nobody reads the devices any more. gelpad's own virtual pad is never among them.

use std::time::{Duration, Instant};

use gilrs::{Axis as From, Button as Pressed, EventType, Gamepad, GamepadId, Gilrs, GilrsBuilder};

use super::{Pace, Reading, Source, SourceError};
use crate::types::{Axis, Button, Buttons, Control, Nanos};

/// A state is handed up at least this often.
const HEARTBEAT: Duration = Duration::from_millis(100);
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
}

/// The pad that gelpad itself has made: nothing tells it from a real one but that it comes when it is expected.
enum Own {
    None,
    Expected,
    Is(GamepadId),
}

struct Device {
    id: GamepadId,
    name: String,
    /// Buttons of a switch box that has no gamepad's layout: in their order they are a, b, x, y, ...
    switches: Buttons,
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
        let gilrs = GilrsBuilder::new()
            .with_force_feedback(false)
            .build()
            .map_err(|error| SourceError::Gamepads {
                reason: error.to_string(),
            })?;
        let mut source = Self {
            gilrs,
            opened: Instant::now(),
            devices: Vec::new(),
            own: Own::None,
            next: None,
        };
        let there: Vec<GamepadId> = source.gilrs.gamepads().map(|(id, _)| id).collect();
        for id in there {
            source.connected(id);
        }
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

    fn connected(&mut self, id: GamepadId) {
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
            switches: Buttons::default(),
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
            EventType::Connected => self.connected(event.id),
            EventType::Disconnected => self.disconnected(event.id),
            EventType::ButtonPressed(Pressed::Unknown, code) => {
                self.switch(event.id, code.into_u32(), true);
            }
            EventType::ButtonReleased(Pressed::Unknown, code) => {
                self.switch(event.id, code.into_u32(), false);
            }
            _ => {}
        }
    }

    fn switch(&mut self, id: GamepadId, code: u32, is_down: bool) {
        let device = self.devices.iter_mut().find(|device| device.id == id);
        let button = Button::ALL.get((code % BLOCK) as usize);
        if let (Some(device), Some(button)) = (device, button) {
            device.switches = match is_down {
                true => device.switches.with(*button),
                false => device.switches.without(*button),
            };
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
            let gamepad = self.gilrs.gamepad(device.id);
            for button in Button::ALL {
                if is_pressed(&gamepad, *button) || device.switches.contains(*button) {
                    control.buttons = control.buttons.with(*button);
                }
            }
            for axis in Axis::ALL {
                let value = value(&gamepad, *axis);
                let furthest = &mut control.axes[*axis as usize];
                if value.abs() > furthest.abs() {
                    *furthest = value;
                }
            }
        }
        control
    }
}

impl Source for GamepadSource {
    fn pace(&self) -> Pace {
        Pace::ByDevice
    }

    fn read(&mut self) -> Result<Reading, SourceError> {
        let first = match self.next.take() {
            Some(event) => Some(event),
            None => self.gilrs.next_event_blocking(Some(HEARTBEAT)),
        };
        if let Some(first) = first {
            self.take(&first);
            // The events of one report carry one time: half of a report is no state.
            while let Some(event) = self.gilrs.next_event() {
                if (event.id, event.time) != (first.id, first.time) {
                    self.next = Some(event);
                    break;
                }
                self.take(&event);
            }
        }
        Ok(Reading::Control(self.state()))
    }
}

fn is_pressed(gamepad: &Gamepad<'_>, button: Button) -> bool {
    BUTTONS
        .iter()
        .find(|(own, _)| *own == button)
        .is_some_and(|(_, pressed)| gamepad.is_pressed(*pressed))
}

fn value(gamepad: &Gamepad<'_>, axis: Axis) -> f32 {
    let stick = STICKS.iter().find(|(own, _)| *own == axis);
    let trigger = TRIGGERS.iter().find(|(own, _)| *own == axis);
    match (stick, trigger) {
        (Some((_, from)), _) => gamepad.value(*from),
        (_, Some((_, pressed))) => gamepad
            .button_data(*pressed)
            .map_or(0.0, gilrs::ev::state::ButtonData::value),
        _ => 0.0,
    }
}
