//! Reads the log of `log.lua`, and measures presses, jumps and walks in it.

use anyhow::{Context, Result, bail, ensure};

/// The buttons that the game saw in one frame, and the place of its figure.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Wall clock time, Unix.
    pub time_ms: f64,
    pub a: bool,
    pub left: bool,
    pub right: bool,
    pub x_px: u8,
    /// Grows downwards.
    pub y_px: u8,
}

/// All frames of the game in their order.
#[derive(Debug)]
pub struct Log {
    frames: Vec<Frame>,
}

/// A stretch of frames with a button held, up to the next such stretch.
#[derive(Clone, Copy, Debug)]
pub struct Press {
    pub frames: usize,
    pub height_px: u8,
    /// Positive to the right.
    pub way_px: i16,
    /// Longest time between two frames, from before the press until after it: a busy machine stalls games.
    pub gap_ms: f64,
}

impl Log {
    /// Parses a log that may still grow: an incomplete last line is ignored.
    pub fn parse(text: &str) -> Result<Self> {
        let mut lines = text
            .split_inclusive('\n')
            .filter_map(|line| line.strip_suffix('\n'));
        let Some(header) = lines.next() else {
            return Ok(Self { frames: Vec::new() });
        };
        let columns: Vec<&str> = header.split(',').collect();
        let frames = lines
            .map(|line| {
                Frame::parse(&columns, line).with_context(|| format!("line of the log: {line}"))
            })
            .collect::<Result<_>>()?;
        Ok(Self { frames })
    }

    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// Without the first `count` frames.
    pub fn skip(mut self, count: usize) -> Self {
        self.frames.drain(..count.min(self.frames.len()));
        self
    }

    /// Frame rate of the emulator by the wall clock, over the whole log.
    pub fn rate_hz(&self) -> Result<f64> {
        let intervals = u32::try_from(self.frames.len().saturating_sub(1))?;
        let (Some(first), Some(last)) = (self.frames.first(), self.frames.last()) else {
            bail!("the log is empty");
        };
        let passed_ms = last.time_ms - first.time_ms;
        ensure!(passed_ms > 0.0, "the log covers no time");
        Ok(f64::from(intervals) * 1000.0 / passed_ms)
    }

    /// All presses of a button that is not held when the log starts.
    pub fn presses(&self, held: impl Fn(&Frame) -> bool) -> Vec<Press> {
        // Each stretch starts with the frame before the press, in which the figure has not moved yet.
        let fresh: Vec<usize> = self
            .frames
            .windows(2)
            .enumerate()
            .filter(|(_, pair)| !held(&pair[0]) && held(&pair[1]))
            .map(|(index, _)| index)
            .collect();
        let ends = fresh.iter().skip(1).copied().chain([self.frames.len()]);
        fresh
            .iter()
            .zip(ends)
            .map(|(&start, end)| Press::measure(&self.frames[start..end], &held))
            .collect()
    }
}

impl Press {
    fn measure(stretch: &[Frame], held: impl Fn(&Frame) -> bool) -> Self {
        let (before, after) = (stretch[0], stretch[stretch.len() - 1]);
        let held_frames = stretch.iter().filter(|frame| held(frame)).count();
        let about = &stretch[..stretch.len().min(held_frames + 3)];
        let gaps_ms = about
            .windows(2)
            .map(|pair| pair[1].time_ms - pair[0].time_ms);
        let top_px = stretch.iter().map(|frame| frame.y_px).min();
        Self {
            frames: held_frames,
            gap_ms: gaps_ms.fold(0.0, f64::max),
            height_px: before.y_px - top_px.unwrap_or(before.y_px),
            way_px: i16::from(after.x_px) - i16::from(before.x_px),
        }
    }
}

impl Frame {
    fn parse(columns: &[&str], line: &str) -> Result<Self> {
        let cells: Vec<&str> = line.split(',').collect();
        let cell = |name: &str| {
            let index = columns.iter().position(|&column| column == name);
            index
                .and_then(|index| cells.get(index).copied())
                .with_context(|| format!("no column {name}"))
        };
        let button = |name| cell(name).map(|cell| cell == "1");
        Ok(Self {
            time_ms: cell("time_ms")?.parse().context("time_ms")?,
            a: button("A")?,
            left: button("left")?,
            right: button("right")?,
            x_px: cell("x")?.parse().context("x")?,
            y_px: cell("y")?.parse().context("y")?,
        })
    }
}
