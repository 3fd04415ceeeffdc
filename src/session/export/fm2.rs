//! A session as an FCEUX movie (`.fm2`): the buttons of the NES pad that are down in each frame of the game.
//!
//! Format (FCEUX documentation, "fm2 format"): a header of `key value` lines, then one line `|commands|RLDUTSBA|port 1|port 2|`
//! for each frame, with the letters of the buttons that are down. The movie starts at power-on.

use std::fmt::Write as _;

use crate::types::{Action, Axis, Event, Nanos, Output};

/// Frame rate of an NTSC console, 1/s.
pub const FRAMES_PER_S: f64 = 60.0998;
/// Longest movie: a day. A damaged time must not fill the memory.
const MOST_FRAMES: usize = 86_400 * 61;
/// A stick counts as pressed from this value.
const STICK_PRESSED: f32 = 0.5;
/// Buttons in the order of the movie's columns.
const LETTERS: [char; 8] = ['R', 'L', 'D', 'U', 'T', 'S', 'B', 'A'];
/// Outputs that press each button: the default keys of FCEUX, and gamepad buttons.
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

/// A movie, built event by event.
#[derive(Clone, Debug)]
pub struct Fm2Movie {
    first_ns: Nanos,
    start_frame: u64,
    /// Time, button, output, and whether it goes down.
    changes: Vec<(Nanos, usize, Output, bool)>,
    /// Outputs without a button on the NES pad, and how often each was pressed.
    unmapped: Vec<(Output, u64)>,
    sticks: [Option<bool>; 4],
}

impl Fm2Movie {
    /// A movie whose frame `start_frame` is the session's time `first_ns`.
    #[must_use]
    pub fn new(first_ns: Nanos, start_frame: u64) -> Self {
        Self {
            first_ns,
            start_frame,
            changes: Vec::new(),
            unmapped: Vec::new(),
            sticks: [None; 4],
        }
    }

    /// Adds the next event.
    pub fn add_event(&mut self, event: &Event) {
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
            self.unmapped.iter_mut().find(|(known, _)| *known == output),
        ) {
            (Some(button), _) => self.changes.push((t_ns, button, output, down)),
            (None, Some((_, presses))) => *presses += u64::from(down),
            (None, None) => self.unmapped.push((output, u64::from(down))),
        }
    }

    /// A stick beyond [`STICK_PRESSED`] presses an arrow button.
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
                // Stands for the stick; no event has this output.
                if let (true, Ok(output)) = (was_down != down, PRESSED_BY[button][1].parse()) {
                    self.changes.push((t_ns, button, output, down));
                }
            }
        }
    }

    /// Outputs without a button on the NES pad, and how often each was pressed.
    #[must_use]
    pub fn unmapped_outputs(&self) -> &[(Output, u64)] {
        &self.unmapped
    }

    /// The buttons that are down in each frame, up to the last change.
    ///
    /// The game polls once a frame, at its start. A press that begins and ends between two polls counts at the second.
    #[must_use]
    pub fn frames(&self) -> Vec<[bool; 8]> {
        let mut frames = vec![[false; 8]; (self.start_frame as usize).min(MOST_FRAMES)];
        let mut changes = self.changes.iter().peekable();
        let mut down: Vec<(usize, Output)> = Vec::new();
        while frames.len() < MOST_FRAMES && (changes.peek().is_some() || !down.is_empty()) {
            let poll_ns = self.poll_ns(frames.len() as u64);
            let mut pressed = [false; 8];
            while let Some((_, button, output, is_down)) =
                changes.next_if(|(t_ns, ..)| *t_ns <= poll_ns)
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
                // Outputs that were never released are released at the end of the session.
                down.clear();
            }
        }
        frames
    }

    /// Time of the session at which the game polls in a frame.
    fn poll_ns(&self, frame: u64) -> Nanos {
        let since = frame.saturating_sub(self.start_frame) as f64 / FRAMES_PER_S;
        self.first_ns + libm::round(since * 1e9) as Nanos
    }

    /// The text of the file. `rom` is the name of the game that FCEUX shows.
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

    fn rows(movie: &Fm2Movie) -> Vec<String> {
        let text = movie.to_fm2("game");
        text.lines()
            .filter(|line| line.starts_with('|'))
            .map(str::to_owned)
            .collect()
    }

    #[test]
    fn a_press_is_down_in_the_frames_that_poll_it() {
        let mut movie = Fm2Movie::new(1_000_000_000, 2);
        // Polls from the third frame on: 0, 16.6, 33.3, 49.9 ms after the first frame.
        movie.add_event(&event(1010, true, "key:f"));
        movie.add_event(&event(1040, false, "key:f"));
        movie.add_event(&event(1040, true, "key:z"));
        let none = "|0|........|||";
        let a = "|0|.......A|||";
        assert_eq!(rows(&movie), [none, none, none, a, a, none]);
        assert_eq!(
            movie.unmapped_outputs(),
            [("key:z".parse().expect("a key"), 1)]
        );
    }

    #[test]
    fn a_press_between_two_polls_counts_once() {
        let mut movie = Fm2Movie::new(0, 0);
        movie.add_event(&event(2, true, "key:enter"));
        movie.add_event(&event(9, false, "key:enter"));
        assert_eq!(rows(&movie), ["|0|........|||", "|0|....T...|||"]);
    }

    #[test]
    fn a_button_is_down_while_any_of_its_outputs_is() {
        let mut movie = Fm2Movie::new(0, 0);
        for (t_ms, press, name) in [
            (0, true, "key:right"),
            (20, true, "pad:right"),
            (30, false, "key:right"),
            (60, false, "pad:right"),
        ] {
            movie.add_event(&event(t_ms, press, name));
        }
        assert_eq!(
            rows(&movie).iter().filter(|row| row.contains('R')).count(),
            4
        );
    }
}
