//! Keyboard and mouse of macOS, through enigo, by the system's code of each place on the keyboard.
//!
//! Not tested on a Mac: the table is from Apple's `HIToolbox/Events.h`. If gelpad is killed, the system keeps what is down.

use enigo::{Axis, Button, Coordinate, Direction, Enigo, Keyboard as _, Mouse as _, Settings};

use crate::output::{OutputDevice, OutputError};
use crate::types::{Action, Event, Key, MouseButton, Output};

/// A connection to the system.
pub struct SystemKeyboard {
    enigo: Enigo,
}

impl SystemKeyboard {
    /// Connects to the system.
    ///
    /// # Errors
    /// The system does not let gelpad type (macOS needs the permission "Accessibility").
    pub fn connect() -> Result<Self, OutputError> {
        let enigo = Enigo::new(&Settings::default()).map_err(|error| OutputError::NoDevice {
            device: "keyboard",
            reason: format!(
                "{error}\
  help: allow gelpad to control this computer (macOS: System Settings, Privacy, Accessibility)"
            ),
        })?;
        Ok(Self { enigo })
    }
}

impl OutputDevice for SystemKeyboard {
    fn name(&self) -> &str {
        "keyboard and mouse of this computer"
    }

    fn supports(&self, output: Output) -> bool {
        match output {
            Output::Key(key) => code(key).is_some(),
            Output::Mouse(_) => true,
            Output::Button(_) => false,
        }
    }

    fn send(&mut self, event: &Event) -> Result<(), OutputError> {
        let result = match event.action {
            Action::Press(output) => self.change(output, Direction::Press),
            Action::Release(output) => self.change(output, Direction::Release),
            Action::Motion { dx, dy } => self.enigo.move_mouse(dx, dy, Coordinate::Rel),
            Action::Wheel { dx, dy } => self
                .enigo
                .scroll(-dy, Axis::Vertical)
                .and_then(|()| self.enigo.scroll(dx, Axis::Horizontal)),
            Action::Axis(..) => Ok(()),
        };
        result.map_err(|error| OutputError::Refused {
            device: "keyboard",
            reason: error.to_string(),
        })
    }
}

impl SystemKeyboard {
    fn change(&mut self, output: Output, direction: Direction) -> enigo::InputResult<()> {
        match output {
            Output::Key(key) => match code(key) {
                Some(code) => self.enigo.raw(code, direction),
                None => Ok(()),
            },
            Output::Mouse(MouseButton::Left) => self.enigo.button(Button::Left, direction),
            Output::Mouse(MouseButton::Right) => self.enigo.button(Button::Right, direction),
            Output::Mouse(MouseButton::Middle) => self.enigo.button(Button::Middle, direction),
            Output::Mouse(MouseButton::Back) => self.enigo.button(Button::Back, direction),
            Output::Mouse(MouseButton::Forward) => self.enigo.button(Button::Forward, direction),
            Output::Button(_) => Ok(()),
        }
    }
}

/// The system's code of a key, if there is one.
fn code(key: Key) -> Option<u16> {
    let evdev = key.evdev_code();
    let found = CODES.iter().find(|(known, _)| *known == evdev);
    found.map(|(_, code)| *code)
}

#[rustfmt::skip]
const CODES: &[(u16, u16)] = &[
    (1, 53), (2, 18), (3, 19), (4, 20), (5, 21), (6, 23), (7, 22), (8, 26), (9, 28), (10, 25), (11, 29), (12, 27), (13, 24),
    (14, 51), (15, 48), (16, 12), (17, 13), (18, 14), (19, 15), (20, 17), (21, 16), (22, 32), (23, 34), (24, 31), (25, 35),
    (26, 33), (27, 30), (28, 36), (29, 59), (30, 0), (31, 1), (32, 2), (33, 3), (34, 5), (35, 4), (36, 38), (37, 40), (38, 37),
    (39, 41), (40, 39), (41, 50), (42, 56), (43, 42), (44, 6), (45, 7), (46, 8), (47, 9), (48, 11), (49, 45), (50, 46),
    (51, 43), (52, 47), (53, 44), (54, 60), (55, 67), (56, 58), (57, 49), (58, 57), (59, 122), (60, 120), (61, 99), (62, 118),
    (63, 96), (64, 97), (65, 98), (66, 100), (67, 101), (68, 109), (71, 89), (72, 91), (73, 92), (74, 78), (75, 86), (76, 87),
    (77, 88), (78, 69), (79, 83), (80, 84), (81, 85), (82, 82), (83, 65), (86, 10), (87, 103), (88, 111), (96, 76), (97, 62),
    (98, 75), (100, 61), (102, 115), (103, 126), (104, 116), (105, 123), (106, 124), (107, 119), (108, 125), (109, 121),
    (111, 117), (117, 81), (125, 55), (126, 54), (138, 114), (183, 105), (184, 107), (185, 113), (186, 106), (187, 64),
];
