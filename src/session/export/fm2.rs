//! A session as a movie of FCEUX (`.fm2`): which buttons of the NES pad are down in each frame of the game.
//!
//! Format: FCEUX's documentation, "fm2 format": a header of `key value` lines, then `|commands|RLDUTSBA|port 1|port 2|` a frame,
//! letters for buttons that are down. The movie begins at power-on.

use std::fmt::Write as _;

use crate::types::{Action, Axis, Event, Nanos, Output};

/// Frames a second of an NTSC console.
pub const FRAMES_PER_S: f64 = 60.0998;
/// No movie is longer: a day. A damaged time must not fill the memory.
const MOST_FRAMES: usize = 86_400 * 61;
/// A stick counts as pressed from here on.
const STICK_PRESSED: f32 = 0.5;
/// Buttons in the order of a movie's columns.
const LETTERS: [char; 8] = ['R', 'L', 'D', 'U', 'T', 'S', 'B', 'A'];
/// What presses each: the keys that fceux has unless changed, and a gamepad's.
const PRESSED_BY: [&[&str]; 8] = [
    &["key:right", "pad:right"],
    &["key:left", "pad:left"],
    &["key:down", "pad:down"],
    &["key:up", "pad:up"],
    &["key:enter", "pad:start"],
    &["key:s", "pad:select"],
    &["key:d", "pad:b", "pad:x"],
    &["key:f", "pad:a"],
];

/// A movie that is being made of events.
#[derive(Clone, Debug)]
pub struct Movie {
    first_ns: Nanos,
    start_frame: u64,
    /// Changes: when, of which output of a button.
    changes: Vec<(Nanos, usize, Output, bool)>,
    /// What no button of a NES pad stands for, and how often it was pressed.
    strange: Vec<(Output, u64)>,
    sticks: [Option<bool>; 4],
}

impl Movie {
    /// A movie in whose frame `start_frame` the session's time `first_ns` falls.
    #[must_use]
    pub fn new(first_ns: Nanos, start_frame: u64) -> Self {
        Self {
            first_ns,
            start_frame,
            changes: Vec::new(),
            strange: Vec::new(),
            sticks: [None; 4],
        }
    }

    /// Takes the next event.
    pub fn event(&mut self, event: &Event) {
        match event.action {
            Action::Press(output) => self.output(event.t_ns, output, true),
            Action::Release(output) => self.output(event.t_ns, output, false),
            Action::Axis(axis, value) => self.stick(event.t_ns, axis, value),
            Action::Motion { .. } | Action::Wheel { .. } => {}
        }
    }

    fn output(&mut self, t_ns: Nanos, output: Output, down: bool) {
        let name = output.to_string();
        let button = PRESSED_BY
            .iter()
            .position(|names| names.contains(&name.as_str()));
        match (
            button,
            self.strange.iter_mut().find(|(known, _)| *known == output),
        ) {
            (Some(button), _) => self.changes.push((t_ns, button, output, down)),
            (None, Some((_, presses))) => *presses += u64::from(down),
            (None, None) => self.strange.push((output, u64::from(down))),
        }
    }

    /// A stick beyond half its way is an arrow.
    fn stick(&mut self, t_ns: Nanos, axis: Axis, value: f32) {
        let arrows = match axis {
            Axis::LeftX => [(0, 1.0), (1, -1.0)],
            Axis::LeftY => [(3, 1.0), (2, -1.0)],
            _ => return,
        };
        for (button, sign) in arrows {
            let down = value * sign >= STICK_PRESSED;
            if self.sticks[button] != Some(down) {
                let was_down = self.sticks[button].replace(down).unwrap_or(false);
                // The name stands for the stick: no event has it.
                if let (true, Ok(output)) = (was_down != down, PRESSED_BY[button][1].parse()) {
                    self.changes.push((t_ns, button, output, down));
                }
            }
        }
    }

    /// Outputs that no button of a NES pad stands for, and how often each was pressed.
    #[must_use]
    pub fn strange(&self) -> &[(Output, u64)] {
        &self.strange
    }

    /// Which buttons are down in each frame, up to the last change.
    ///
    /// The game looks once a frame, at its start; a press that begins and ends between two looks is seen at the second.
    #[must_use]
    pub fn frames(&self) -> Vec<[bool; 8]> {
        let mut frames = vec![[false; 8]; (self.start_frame as usize).min(MOST_FRAMES)];
        let mut changes = self.changes.iter().peekable();
        let mut down: Vec<(usize, Output)> = Vec::new();
        while frames.len() < MOST_FRAMES && (changes.peek().is_some() || !down.is_empty()) {
            let look_ns = self.look_ns(frames.len() as u64);
            let mut pressed = [false; 8];
            while let Some((_, button, output, is_down)) =
                changes.next_if(|(t_ns, ..)| *t_ns <= look_ns)
            {
                if *is_down {
                    down.push((*button, *output));
                    pressed[*button] = true;
                } else {
                    down.retain(|(_, held)| held != output);
                }
            }
            for (button, _) in &down {
                pressed[*button] = true;
            }
            frames.push(pressed);
            if changes.peek().is_none() && !down.is_empty() {
                // What was never released is, with the session.
                down.clear();
            }
        }
        frames
    }

    /// When the game looks in a frame, in the session's time.
    fn look_ns(&self, frame: u64) -> Nanos {
        let since = frame.saturating_sub(self.start_frame) as f64 / FRAMES_PER_S;
        self.first_ns + libm::round(since * 1e9) as Nanos
    }

    /// The whole file. `rom` is the game's name as FCEUX should show it.
    #[must_use]
    pub fn to_fm2(&self, rom: &str) -> String {
        let mut text = String::from("version 3\nemuVersion 22020\nrerecordCount 0\npalFlag 0\n");
        let rom: String = rom.chars().filter(|c| !c.is_control()).collect();
        let _ = writeln!(text, "romFilename {rom}");
        text.push_str("romChecksum base64:AAAAAAAAAAAAAAAAAAAAAA==\n");
        text.push_str("guid 00000000-0000-0000-0000-000000000000\n");
        text.push_str("fourscore 0\nmicrophone 0\nport0 1\nport1 0\nport2 0\nFDS 0\nNewPPU 0\n");
        for pressed in self.frames() {
            text.push_str("|0|");
            for (letter, down) in LETTERS.iter().zip(pressed) {
                text.push(if down { *letter } else { '.' });
            }
            text.push_str("|||\n");
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(t_ms: u64, press: bool, name: &str) -> Event {
        let output = name.parse().expect("an output");
        Event {
            t_ns: t_ms * 1_000_000,
            action: if press {
                Action::Press(output)
            } else {
                Action::Release(output)
            },
        }
    }

    fn rows(movie: &Movie) -> Vec<String> {
        let text = movie.to_fm2("game");
        text.lines()
            .filter(|line| line.starts_with('|'))
            .map(str::to_owned)
            .collect()
    }

    #[test]
    fn a_press_is_down_in_the_frames_in_which_the_game_looks() {
        let mut movie = Movie::new(1_000_000_000, 2);
        // Looks of the third frame on: 0, 16.6, 33.3, 49.9 ms after the first.
        movie.event(&event(1010, true, "key:f"));
        movie.event(&event(1040, false, "key:f"));
        movie.event(&event(1040, true, "key:z"));
        let none = "|0|........|||";
        let a = "|0|.......A|||";
        assert_eq!(rows(&movie), [none, none, none, a, a, none]);
        assert_eq!(movie.strange(), [("key:z".parse().expect("a key"), 1)]);
    }

    #[test]
    fn a_press_between_two_looks_is_seen_once() {
        let mut movie = Movie::new(0, 0);
        movie.event(&event(2, true, "key:enter"));
        movie.event(&event(9, false, "key:enter"));
        assert_eq!(rows(&movie), ["|0|........|||", "|0|....T...|||"]);
    }

    #[test]
    fn two_outputs_of_one_button_hold_it_together() {
        let mut movie = Movie::new(0, 0);
        for (t_ms, press, name) in [
            (0, true, "key:right"),
            (20, true, "pad:right"),
            (30, false, "key:right"),
            (60, false, "pad:right"),
        ] {
            movie.event(&event(t_ms, press, name));
        }
        assert_eq!(
            rows(&movie).iter().filter(|row| row.contains('R')).count(),
            4
        );
    }
}
