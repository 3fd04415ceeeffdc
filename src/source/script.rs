//! Touch scripts: text that says what fingers do on the simulated pad.
//!
//! ```text
//! # comment
//! t:1000 down 1 80 30            a finger at (80, 30) mm, radius 7 mm, rise 1.2
//! t:1000 down 2 20 50 6.5 1.5    the same with a radius (mm) and a relative rise of conductivity
//! t:1040 move 1 82 31            or with a new radius and rise: `move 1 82 31 9 2.0`
//! t:1080 up 1
//! t:2000 end                     without this line the script ends half a second after the last one
//! ```
//! Times are in milliseconds and never run backwards; coordinates are those of the pad, y up.

use super::simulated::{FINGER_RADIUS_MM, FINGER_RISE};
use crate::eit::Press;
use crate::types::{Diagnostic, NANOS_PER_MS, Nanos, PointMm, SourceErrors, nanos_from_ms};

/// The script that plays when gelpad is started without arguments.
const LEVEL_SCRIPT: &str = include_str!("../../scripts/level.txt");

/// Time from the last line to the end of a script without `end`.
const TAIL_NS: Nanos = 500 * NANOS_PER_MS;

/// Width and height of the pad for which the level is written, mm.
const LEVEL_SIDE_MM: f64 = 100.0;

fn stretch_place(place_mm: &mut PointMm, by: [f64; 2]) {
    for (coordinate, by) in place_mm.iter_mut().zip(by) {
        *coordinate *= by;
    }
}

/// A finger on the simulated pad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finger {
    /// Its number in the script.
    pub id: u64,
    /// Where and how it presses.
    pub press: Press,
}

/// One line of a script.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScriptStep {
    /// The time.
    pub t_ns: Nanos,
    /// The action.
    pub kind: FingerAction,
}

/// What a finger does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FingerAction {
    /// It goes down.
    Down(Finger),
    /// It moves to another place.
    Move {
        /// Its number.
        id: u64,
        /// The place.
        centre_mm: PointMm,
        /// Its new radius, mm, if that changes.
        radius_mm: Option<f64>,
        /// Its new rise, if that changes.
        rise: Option<f64>,
    },
    /// It lifts.
    Up {
        /// Its number.
        id: u64,
    },
}

/// A checked script: fingers move and lift only while they are down.
#[derive(Clone, Debug, PartialEq)]
pub struct Script {
    steps: Vec<ScriptStep>,
    end_ns: Nanos,
}

impl Script {
    /// Reads a script; `name` is the file's name for messages.
    ///
    /// # Errors
    /// The first mistake, with its place.
    pub fn parse(name: &str, text: &str) -> Result<Self, SourceErrors> {
        let mut script = Self {
            steps: Vec::new(),
            end_ns: 0,
        };
        let mut end_ns = None;
        let mut down = Vec::new();
        let mut start = 0;
        for line in text.split_inclusive('\n') {
            let words = Words::split(line, start);
            start += line.len();
            script
                .parse_line(&words, &mut down, &mut end_ns)
                .map_err(|fault| SourceErrors::new(name, text, vec![fault]))?;
        }
        if script.steps.is_empty() {
            let fault = Diagnostic::new(0..0, "the script is empty: no finger goes down", "here")
                .help("a line is a time and what a finger does, as in `t:1000 down 1 80 30`");
            return Err(SourceErrors::new(name, text, vec![fault]));
        }
        script.end_ns = end_ns.unwrap_or_else(|| script.last_ns() + TAIL_NS);
        Ok(script)
    }

    /// The built-in level, stretched to a pad of this width and height, mm: regions are shares of the pad, too. On a small pad the
    /// fingers are smaller.
    ///
    /// # Errors
    /// None in practice: the text is tested.
    pub fn level(size_mm: [f64; 2]) -> Result<Self, SourceErrors> {
        let mut level = Self::parse("level", LEVEL_SCRIPT)?;
        let stretch = size_mm.map(|side_mm| side_mm / LEVEL_SIDE_MM);
        let narrow = stretch[0].min(stretch[1]).min(1.0);
        for step in &mut level.steps {
            match &mut step.kind {
                FingerAction::Down(Finger { press, .. }) => {
                    stretch_place(&mut press.centre_mm, stretch);
                    press.radius_mm *= narrow;
                }
                FingerAction::Move {
                    centre_mm,
                    radius_mm,
                    ..
                } => {
                    stretch_place(centre_mm, stretch);
                    *radius_mm = radius_mm.map(|radius_mm| radius_mm * narrow);
                }
                FingerAction::Up { .. } => {}
            }
        }
        Ok(level)
    }

    /// All steps, in the order of time.
    #[must_use]
    pub fn steps(&self) -> &[ScriptStep] {
        &self.steps
    }

    /// The end of the script.
    #[must_use]
    pub fn end_ns(&self) -> Nanos {
        self.end_ns
    }

    fn last_ns(&self) -> Nanos {
        self.steps.last().map_or(0, |step| step.t_ns)
    }

    fn parse_line(
        &mut self,
        words: &Words<'_>,
        down: &mut Vec<u64>,
        end_ns: &mut Option<Nanos>,
    ) -> Result<(), Diagnostic> {
        if words.is_empty() {
            return Ok(());
        }
        if end_ns.is_some() {
            return Err(words.fault(0, "nothing may follow `end`", "after the end"));
        }
        let t_ns = words.time(0)?;
        if t_ns < self.last_ns() {
            let label = "earlier than the line before";
            return Err(words.fault(0, "times must not run backwards", label));
        }
        if words.get(1, "what happens: down, move, up or end")? == "end" {
            words.expect_at_most(2)?;
            *end_ns = Some(t_ns);
            return Ok(());
        }
        let kind = parse_action(words, down)?;
        self.steps.push(ScriptStep { t_ns, kind });
        Ok(())
    }
}

/// What a finger does in a line; `down` holds the fingers that are down.
fn parse_action(words: &Words<'_>, down: &mut Vec<u64>) -> Result<FingerAction, Diagnostic> {
    let centre_mm = || Ok([words.number(3, "x in mm")?, words.number(4, "y in mm")?]);
    match words.get(1, "what happens")? {
        "down" => {
            words.expect_at_most(7)?;
            let id = words.id(2)?;
            if down.contains(&id) {
                return Err(words.fault(2, format!("finger {id} is down already"), "here"));
            }
            down.push(id);
            let press = Press {
                centre_mm: centre_mm()?,
                radius_mm: words.above_zero(5)?.unwrap_or(FINGER_RADIUS_MM),
                rise: words.above_zero(6)?.unwrap_or(FINGER_RISE),
            };
            Ok(FingerAction::Down(Finger { id, press }))
        }
        "move" => {
            words.expect_at_most(7)?;
            Ok(FingerAction::Move {
                id: words.id_among(2, down)?,
                centre_mm: centre_mm()?,
                radius_mm: words.above_zero(5)?,
                rise: words.above_zero(6)?,
            })
        }
        "up" => {
            words.expect_at_most(3)?;
            let id = words.id_among(2, down)?;
            down.retain(|other| *other != id);
            Ok(FingerAction::Up { id })
        }
        other => {
            let message = format!("`{other}` is not an action of a finger");
            Err(words
                .fault(1, message, "here")
                .help("write down, move, up or end"))
        }
    }
}

/// The words of a line and their places in the text.
struct Words<'a> {
    words: Vec<(usize, &'a str)>,
    end: usize,
}

impl<'a> Words<'a> {
    fn split(line: &'a str, start: usize) -> Self {
        let code = line.split('#').next().unwrap_or_default();
        let place = |word: &str| start + (word.as_ptr().addr() - line.as_ptr().addr());
        Self {
            words: code
                .split_whitespace()
                .map(|word| (place(word), word))
                .collect(),
            end: start + code.trim_end().len(),
        }
    }

    fn is_empty(&self) -> bool {
        self.words.is_empty()
    }

    fn fault(&self, index: usize, message: impl Into<String>, label: &str) -> Diagnostic {
        let span = match self.words.get(index) {
            Some((start, word)) => *start..start + word.len(),
            None => self.end..self.end,
        };
        Diagnostic::new(span, message, label)
    }

    fn get(&self, index: usize, what: &str) -> Result<&'a str, Diagnostic> {
        match self.words.get(index) {
            Some((_, word)) => Ok(word),
            None => Err(self.fault(index, format!("the line ends before {what}"), "ends here")),
        }
    }

    fn expect_at_most(&self, count: usize) -> Result<(), Diagnostic> {
        if self.words.len() > count {
            return Err(self.fault(count, "there are too many words", "not expected"));
        }
        Ok(())
    }

    fn time(&self, index: usize) -> Result<Nanos, Diagnostic> {
        let word = self.get(index, "the time")?;
        word.strip_prefix("t:")
            .and_then(|ms| ms.parse::<f64>().ok())
            .filter(|ms| (0.0..=1e9).contains(ms))
            .map(nanos_from_ms)
            .ok_or_else(|| {
                self.fault(index, format!("`{word}` is not a time"), "here")
                    .help("a line starts with t: and milliseconds, as in `t:1000 down 1 80 30`")
            })
    }

    fn number(&self, index: usize, what: &str) -> Result<f64, Diagnostic> {
        let word = self.get(index, what)?;
        word.parse::<f64>()
            .ok()
            .filter(|number| number.is_finite())
            .ok_or_else(|| {
                self.fault(
                    index,
                    format!("`{word}` is not a number: expected {what}"),
                    "here",
                )
            })
    }

    /// A radius or rise, if the line has one at this place.
    fn above_zero(&self, index: usize) -> Result<Option<f64>, Diagnostic> {
        if self.words.len() <= index {
            return Ok(None);
        }
        let number = self.number(index, "a number")?;
        if number > 0.0 {
            Ok(Some(number))
        } else {
            Err(self.fault(
                index,
                "a finger's radius and rise must be above zero",
                "here",
            ))
        }
    }

    fn id(&self, index: usize) -> Result<u64, Diagnostic> {
        let word = self.get(index, "the finger's number")?;
        word.parse()
            .map_err(|_| self.fault(index, format!("`{word}` is not a finger's number"), "here"))
    }

    fn id_among(&self, index: usize, down: &[u64]) -> Result<u64, Diagnostic> {
        let id = self.id(index)?;
        if down.contains(&id) {
            Ok(id)
        } else {
            Err(self.fault(index, format!("finger {id} is not down"), "here"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_script_is_read_line_by_line() {
        let script = Script::parse(
            "s",
            "# two fingers\nt:10 down 1 80 50\nt:20 down 2 20 50 6 1.5 # the other hand\n\nt:30.5 move 1 81 50\nt:90 up 1\nt:90 up 2\n",
        )
        .expect("sound");
        assert_eq!(script.steps().len(), 5);
        assert_eq!(script.steps()[2].t_ns, 30_500_000);
        assert_eq!(script.end_ns(), 590_000_000);
        let FingerAction::Down(finger) = script.steps()[1].kind else {
            panic!("a finger goes down");
        };
        assert_eq!((finger.press.radius_mm, finger.press.rise), (6.0, 1.5));
    }

    #[test]
    fn mistakes_point_at_their_word() {
        let cases = [
            ("t:10 down 1 80", "s:1:15: the line ends before y in mm"),
            (
                "t:10 tap 1 80 50",
                "s:1:6: `tap` is not an action of a finger",
            ),
            ("10 down 1 80 50", "s:1:1: `10` is not a time"),
            (
                "t:10 down 1 80 50\nt:20 up 2",
                "s:2:9: finger 2 is not down",
            ),
            (
                "t:10 down 1 80 50\nt:5 up 1",
                "s:2:1: times must not run backwards",
            ),
            (
                "t:10 down 1 80 x",
                "s:1:16: `x` is not a number: expected y in mm",
            ),
            (
                "t:10 down 1 80 50 -1",
                "s:1:19: a finger's radius and rise must be above zero",
            ),
            ("", "s:1:1: the script is empty: no finger goes down"),
            (
                "t:5 down 1 1 1\nt:10 end\nt:20 end",
                "s:3:1: nothing may follow `end`",
            ),
            (
                "t:10 down 1 80 50 7 1 9",
                "s:1:23: there are too many words",
            ),
        ];
        for (text, message) in cases {
            assert_eq!(
                Script::parse("s", text).expect_err(text).to_string(),
                message
            );
        }
    }

    #[test]
    fn the_level_is_a_sound_script() {
        let written = Script::parse("level", LEVEL_SCRIPT).expect("sound");
        assert_eq!(Script::level([100.0; 2]), Ok(written));
        for size_mm in [[150.0, 80.0], [45.0, 45.0]] {
            let level = Script::level(size_mm).expect("sound");
            for step in level.steps() {
                if let FingerAction::Down(Finger { press, .. }) = step.kind {
                    let [x, y] = press.centre_mm;
                    assert!(x < size_mm[0] && y < size_mm[1], "({x}, {y})");
                }
            }
        }
    }
}
