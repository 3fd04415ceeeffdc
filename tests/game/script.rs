//! Writes the touch scripts that the simulated pad plays.

use std::fmt;

/// A place on the pad, from its bottom left corner.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    pub x_mm: u32,
    pub y_mm: u32,
}

/// Touches that stay in place; `to_string` gives the script's text.
#[derive(Debug, Default)]
pub struct Script {
    touches: Vec<Touch>,
}

#[derive(Debug)]
struct Touch {
    place: Place,
    start_ms: u32,
    end_ms: u32,
}

impl Script {
    /// Adds a finger that is down from `start_ms` for `length_ms`.
    pub fn press(&mut self, place: Place, start_ms: u32, length_ms: u32) {
        let end_ms = start_ms + length_ms;
        self.touches.push(Touch {
            place,
            start_ms,
            end_ms,
        });
    }

    /// When the last finger is lifted.
    pub fn end_ms(&self) -> u32 {
        let ends = self.touches.iter().map(|touch| touch.end_ms);
        ends.max().unwrap_or_default()
    }
}

impl fmt::Display for Script {
    /// Events are in the order of time, also for fingers that overlap.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut events = Vec::new();
        for (id, touch) in self.touches.iter().enumerate() {
            let Place { x_mm, y_mm } = touch.place;
            events.push((touch.start_ms, format!("down {id} {x_mm} {y_mm}")));
            events.push((touch.end_ms, format!("up {id}")));
        }
        events.sort_by_key(|&(time_ms, _)| time_ms);
        for (time_ms, event) in events {
            writeln!(f, "t:{time_ms} {event}")?;
        }
        Ok(())
    }
}
