//! Touch scripts: what fingers do to the simulated pad, as a text.
//!
//! ```text
//! # comment
//! t:1000 down 1 80 30            a finger at (80, 30) mm, radius 7 mm, rise 1.2
//! t:1000 down 2 20 50 6.5 1.5    the same with its radius (mm) and relative rise of conductivity
//! t:1040 move 1 82 31            or with a new radius and rise: `move 1 82 31 9 2.0`
//! t:1080 up 1
//! t:2000 end                     else the script ends half a second after its last line
//! ```
//! Times are milliseconds, ascending; coordinates are the pad's, y up.

use crate::types::{Fault, Faulty, NANOS_PER_MS, Nanos, PointMm, nanos_from_ms};

/// The level that plays when gelpad is started without arguments.
pub const LEVEL_SCRIPT: &str = include_str!("../../scripts/level.txt");

/// Radius of a finger, mm, and relative rise of conductivity in its middle, where a script gives none.
const FINGER: (f64, f64) = (7.0, 1.2);
/// How long a script goes on after its last line.
const TAIL_NS: Nanos = 500 * NANOS_PER_MS;

/// A finger on the simulated pad. It multiplies the conductivity by 1 + rise (1 - (d / radius)^2) within its radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finger {
    /// Its number in the script.
    pub id: u64,
    /// Where it presses, mm.
    pub centre_mm: PointMm,
    /// Radius of its footprint, mm.
    pub radius_mm: f64,
    /// Relative rise of conductivity in its middle.
    pub rise: f64,
}

/// One line of a script.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// When.
    pub t_ns: Nanos,
    /// What.
    pub kind: StepKind,
}

/// What happens to a finger.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepKind {
    /// It goes down.
    Down(Finger),
    /// It is at another place from now on.
    Move {
        /// Its number.
        id: u64,
        /// Where.
        centre_mm: PointMm,
        /// Its radius (mm) from now on, if it changes.
        radius_mm: Option<f64>,
        /// Its rise from now on, if it changes.
        rise: Option<f64>,
    },
    /// It lifts.
    Up {
        /// Its number.
        id: u64,
    },
}

/// A whole script, checked: fingers move and lift only while they are down.
#[derive(Clone, Debug, PartialEq)]
pub struct Script {
    steps: Vec<Step>,
    end_ns: Nanos,
}

impl Script {
    /// Reads a script; `name` stands for the file in messages.
    ///
    /// # Errors
    /// The first mistake, at its word.
    pub fn parse(name: &str, text: &str) -> Result<Self, Faulty> {
        let mut script = Self {
            steps: Vec::new(),
            end_ns: 0,
        };
        let mut end_ns = None;
        let mut down = Vec::new();
        let mut start = 0;
        for line in text.split_inclusive('\n') {
            let words = Words::of(line, start);
            start += line.len();
            script
                .line(&words, &mut down, &mut end_ns)
                .map_err(|fault| Faulty::new(name, text, vec![fault]))?;
        }
        if script.steps.is_empty() {
            let fault = Fault::new(0..0, "the script is empty: no finger goes down", "here")
                .help("a line is a time and what a finger does, as in `t:1000 down 1 80 30`");
            return Err(Faulty::new(name, text, vec![fault]));
        }
        script.end_ns = end_ns.unwrap_or_else(|| script.last_ns() + TAIL_NS);
        Ok(script)
    }

    /// What happens, in the order of time.
    #[must_use]
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// When it is over.
    #[must_use]
    pub fn end_ns(&self) -> Nanos {
        self.end_ns
    }

    fn last_ns(&self) -> Nanos {
        self.steps.last().map_or(0, |step| step.t_ns)
    }

    fn line(
        &mut self,
        words: &Words<'_>,
        down: &mut Vec<u64>,
        end_ns: &mut Option<Nanos>,
    ) -> Result<(), Fault> {
        if words.is_empty() {
            return Ok(());
        }
        if end_ns.is_some() {
            return Err(words.fault(0, "nothing may follow `end`", "after the end"));
        }
        let t_ns = words.time(0)?;
        if t_ns < self.last_ns() {
            return Err(words.fault(
                0,
                "times must not run backwards",
                "earlier than the line before",
            ));
        }
        let kind = match words.get(1, "what happens: down, move, up or end")? {
            "end" => {
                words.at_most(2)?;
                *end_ns = Some(t_ns);
                return Ok(());
            }
            "down" => {
                words.at_most(7)?;
                let id = words.id(2)?;
                if down.contains(&id) {
                    return Err(words.fault(2, format!("finger {id} is down already"), "here"));
                }
                down.push(id);
                StepKind::Down(Finger {
                    id,
                    centre_mm: [words.number(3, "x in mm")?, words.number(4, "y in mm")?],
                    radius_mm: words.above_zero(5, FINGER.0)?,
                    rise: words.above_zero(6, FINGER.1)?,
                })
            }
            "move" => {
                words.at_most(7)?;
                StepKind::Move {
                    id: words.id_among(2, down)?,
                    centre_mm: [words.number(3, "x in mm")?, words.number(4, "y in mm")?],
                    radius_mm: words.changed(5)?,
                    rise: words.changed(6)?,
                }
            }
            "up" => {
                words.at_most(3)?;
                let id = words.id_among(2, down)?;
                down.retain(|other| *other != id);
                StepKind::Up { id }
            }
            other => {
                return Err(words
                    .fault(
                        1,
                        format!("`{other}` is nothing that a finger does"),
                        "here",
                    )
                    .help("write down, move, up or end"));
            }
        };
        self.steps.push(Step { t_ns, kind });
        Ok(())
    }
}

/// The words of a line and where they stand in the text.
struct Words<'a> {
    words: Vec<(usize, &'a str)>,
    end: usize,
}

impl<'a> Words<'a> {
    fn of(line: &'a str, start: usize) -> Self {
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

    fn fault(&self, index: usize, message: impl Into<String>, label: &str) -> Fault {
        let span = match self.words.get(index) {
            Some((start, word)) => *start..start + word.len(),
            None => self.end..self.end,
        };
        Fault::new(span, message, label)
    }

    fn get(&self, index: usize, what: &str) -> Result<&'a str, Fault> {
        match self.words.get(index) {
            Some((_, word)) => Ok(word),
            None => Err(self.fault(index, format!("the line ends before {what}"), "ends here")),
        }
    }

    fn at_most(&self, count: usize) -> Result<(), Fault> {
        if self.words.len() > count {
            return Err(self.fault(count, "this word is too many", "too many"));
        }
        Ok(())
    }

    fn time(&self, index: usize) -> Result<Nanos, Fault> {
        let word = self.get(index, "the time")?;
        word.strip_prefix("t:")
            .and_then(|ms| ms.parse::<f64>().ok())
            .filter(|ms| (0.0..=1e9).contains(ms))
            .map(nanos_from_ms)
            .ok_or_else(|| {
                self.fault(index, format!("`{word}` is no time"), "here")
                    .help("a line begins with t: and milliseconds, as in `t:1000 down 1 80 30`")
            })
    }

    /// A radius or rise, if the line has one there.
    fn changed(&self, index: usize) -> Result<Option<f64>, Fault> {
        match self.words.get(index) {
            Some(_) => self.above_zero(index, 0.0).map(Some),
            None => Ok(None),
        }
    }

    fn number(&self, index: usize, what: &str) -> Result<f64, Fault> {
        let word = self.get(index, what)?;
        word.parse::<f64>()
            .ok()
            .filter(|number| number.is_finite())
            .ok_or_else(|| {
                self.fault(
                    index,
                    format!("`{word}` is no number: expected {what}"),
                    "here",
                )
            })
    }

    fn above_zero(&self, index: usize, default: f64) -> Result<f64, Fault> {
        if self.words.len() <= index {
            return Ok(default);
        }
        let number = self.number(index, "a number")?;
        if number > 0.0 {
            Ok(number)
        } else {
            Err(self.fault(index, "a finger's radius and rise are above zero", "here"))
        }
    }

    fn id(&self, index: usize) -> Result<u64, Fault> {
        let word = self.get(index, "the finger's number")?;
        word.parse()
            .map_err(|_| self.fault(index, format!("`{word}` is no finger's number"), "here"))
    }

    fn id_among(&self, index: usize, down: &[u64]) -> Result<u64, Fault> {
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
        let StepKind::Down(finger) = script.steps()[1].kind else {
            panic!("a finger goes down");
        };
        assert_eq!((finger.radius_mm, finger.rise), (6.0, 1.5));
    }

    #[test]
    fn mistakes_point_at_their_word() {
        let cases = [
            ("t:10 down 1 80", "s:1:15: the line ends before y in mm"),
            (
                "t:10 tap 1 80 50",
                "s:1:6: `tap` is nothing that a finger does",
            ),
            ("10 down 1 80 50", "s:1:1: `10` is no time"),
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
                "s:1:16: `x` is no number: expected y in mm",
            ),
            (
                "t:10 down 1 80 50 -1",
                "s:1:19: a finger's radius and rise are above zero",
            ),
            ("", "s:1:1: the script is empty: no finger goes down"),
            (
                "t:5 down 1 1 1\nt:10 end\nt:20 end",
                "s:3:1: nothing may follow `end`",
            ),
            ("t:10 down 1 80 50 7 1 9", "s:1:23: this word is too many"),
        ];
        for (text, said) in cases {
            assert_eq!(Script::parse("s", text).expect_err(text).to_string(), said);
        }
    }

    #[test]
    fn the_level_is_a_sound_script() {
        assert!(Script::parse("level", LEVEL_SCRIPT).is_ok());
    }
}
