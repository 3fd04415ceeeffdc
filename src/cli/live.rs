//! The live view in a terminal: image with touches and regions, held outputs, last presses, frame rate and latency.

use std::io::Stdout;
use std::mem::ManuallyDrop;
use std::time::Duration;

use anyhow::Context as _;
use crossterm::{execute, terminal};
use ratatui::backend::CrosstermBackend;
use ratatui::buffer::Buffer;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style, Stylize as _};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Paragraph, Widget};

use super::log;
use super::map::Map;
use crate::pad::Pad;
use crate::platform::terminal::{KeyCommand, Keyboard, TerminalLost, can_write};
use crate::profile::{Profile, Target};
use crate::runtime::View;
use crate::types::{Action, Event, Image, Output, Touch, heat_colour, ms_from_nanos};

/// End of the colour scale, relative change; the image's peak if that is higher.
const FULL_SCALE: f32 = 0.3;
/// Time per character of a press's bar, ms.
const BAR_MS: f64 = 25.0;
/// Longest bar, characters.
const MAX_BAR_CHARS: usize = 24;

/// Source and output of the game, for the footer.
pub(super) struct Title {
    pub source: String,
    pub output: String,
}

/// A terminal in raw mode on its alternate screen; dropping it restores the terminal.
pub(super) struct LiveView {
    /// Never dropped: its `drop` panics if the terminal is closed. [`restore`] shows the cursor.
    terminal: ManuallyDrop<ratatui::Terminal<CrosstermBackend<Stdout>>>,
    keyboard: Keyboard,
    title: Title,
    pad: String,
    pad_mm: [f64; 2],
    /// The last message for the player.
    notice: String,
    /// NO_COLOR is set: the image is drawn with block characters.
    plain: bool,
}

impl LiveView {
    /// Switches the terminal to raw mode and the alternate screen.
    pub(super) fn open(title: Title, pad: &Pad) -> anyhow::Result<Self> {
        terminal::enable_raw_mode().context("the terminal has no raw mode: use --headless")?;
        log::mute(true);
        let mut stdout = std::io::stdout();
        execute!(
            stdout,
            terminal::EnterAlternateScreen,
            crossterm::cursor::Hide
        )?;
        let hook = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            restore();
            hook(info);
        }));
        Ok(Self {
            terminal: ManuallyDrop::new(ratatui::Terminal::new(CrosstermBackend::new(stdout))?),
            keyboard: Keyboard::open(),
            title,
            pad: pad.name.clone(),
            pad_mm: pad.outline.size_mm(),
            notice: String::new(),
            plain: std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty()),
        })
    }

    /// Shows a line in the footer until the next one.
    pub(super) fn show_notice(&mut self, notice: String) {
        self.notice = notice;
    }

    /// Draws a view, then waits for keys, at most `wait`.
    ///
    /// # Errors
    /// The terminal is closed.
    pub(super) fn draw_and_wait(
        &mut self,
        view: &View,
        wait: Duration,
    ) -> Result<Vec<KeyCommand>, TerminalLost> {
        let screen = Screen {
            view,
            title: &self.title,
            pad: &self.pad,
            pad_mm: self.pad_mm,
            profile: &view.profile,
            notice: &self.notice,
            plain: self.plain,
        };
        // A terminal that has stopped reading (Ctrl-S) shows the next view that it takes.
        if can_write(&std::io::stdout(), Duration::ZERO) {
            self.terminal
                .draw(|frame| frame.render_widget(screen, frame.area()))
                .map_err(|_| TerminalLost)?;
        }
        self.keyboard.read(wait)
    }
}

impl Drop for LiveView {
    fn drop(&mut self) {
        restore();
    }
}

/// Restores the terminal; errors are ignored, as the terminal may be closed.
fn restore() {
    log::mute(false);
    if can_write(&std::io::stdout(), Duration::ZERO) {
        let _ = execute!(
            std::io::stdout(),
            terminal::LeaveAlternateScreen,
            crossterm::cursor::Show
        );
    }
    let _ = terminal::disable_raw_mode();
}

/// One drawing of a view.
struct Screen<'a> {
    view: &'a View,
    title: &'a Title,
    pad: &'a str,
    pad_mm: [f64; 2],
    profile: &'a Profile,
    notice: &'a str,
    plain: bool,
}

impl Widget for Screen<'_> {
    fn render(self, area: Rect, buffer: &mut Buffer) {
        let [body, footer] =
            Layout::vertical([Constraint::Min(3), Constraint::Length(2)]).areas(area);
        // The pad's width follows from the height: characters are twice as high as wide.
        let height = body.height.saturating_sub(2);
        let shape = self.pad_mm[0] / self.pad_mm[1];
        let width = (f64::from(height) * 2.0 * shape) as u16 + 2;
        let width = width.min(body.width * 6 / 10).max(12);
        let [left, right] =
            Layout::horizontal([Constraint::Length(width), Constraint::Min(20)]).areas(body);
        self.draw_pad(left, buffer);
        self.draw_side(right, buffer);
        self.draw_footer(footer, buffer);
    }
}

impl Screen<'_> {
    fn draw_pad(&self, area: Rect, buffer: &mut Buffer) {
        let block = Block::bordered().title(format!(" {} ", self.pad));
        let inner = block.inner(area);
        block.render(area, buffer);
        if inner.width < 2 || inner.height < 2 {
            return;
        }
        let map = Map::new(self.pad_mm, usize::from(inner.width)).with_regions(self.profile);
        let rows = map.rows().min(usize::from(inner.height));
        let scale = FULL_SCALE.max(self.view.image.peak());
        for row in 0..rows {
            for column in 0..usize::from(inner.width) {
                let value = |part: f64| {
                    let x = (column as f64 + 0.5) / f64::from(inner.width) * self.pad_mm[0];
                    let y = (1.0 - (row as f64 + part) / map.rows() as f64) * self.pad_mm[1];
                    value_at(&self.view.image, [x, y]) / scale
                };
                let mark = map.get(row, column);
                let cell = &mut buffer[(inner.x + column as u16, inner.y + row as u16)];
                if self.plain {
                    let shown = if mark == ' ' { shade(value(0.5)) } else { mark };
                    cell.set_char(shown);
                    continue;
                }
                // Two pixels a character: the upper is the half block's colour, the lower its background.
                let [upper, lower] = [0.25, 0.75].map(|part| {
                    let [r, g, b] = heat_colour(value(part));
                    Color::Rgb(r, g, b)
                });
                match mark {
                    ' ' => cell.set_char('▀').set_fg(upper).set_bg(lower),
                    mark => cell.set_char(mark).set_fg(Color::Gray).set_bg(lower),
                };
            }
        }
        for touch in &self.view.touches {
            self.draw_touch(touch, inner, rows, map.rows(), buffer);
        }
    }

    fn draw_touch(
        &self,
        touch: &Touch,
        inner: Rect,
        shown: usize,
        rows: usize,
        buffer: &mut Buffer,
    ) {
        let [x, y] = touch.contact.centre_mm;
        let column = (x / self.pad_mm[0] * f64::from(inner.width)) as u16;
        let row = ((1.0 - y / self.pad_mm[1]) * rows as f64) as u16;
        if column < inner.width && usize::from(row) < shown {
            let style = Style::new()
                .fg(Color::Black)
                .bg(Color::White)
                .add_modifier(Modifier::BOLD);
            let label = format!("●{}", touch.id.0);
            let room = usize::from(inner.width - column);
            buffer.set_stringn(inner.x + column, inner.y + row, label, room, style);
        }
    }

    fn draw_side(&self, area: Rect, buffer: &mut Buffer) {
        let bindings = self.profile.bindings.len() as u16 + 2;
        let [held, presses, touches] = Layout::vertical([
            Constraint::Length(bindings),
            Constraint::Min(4),
            Constraint::Length(6),
        ])
        .areas(area);
        let lines: Vec<Line<'_>> = self
            .profile
            .bindings
            .iter()
            .map(|b| self.binding_line(b))
            .collect();
        Paragraph::new(lines)
            .block(Block::bordered().title(format!(" {} ", self.profile.name)))
            .render(held, buffer);
        let lines = press_lines(
            self.view.events.iter(),
            &self.view.held,
            self.view.t_ns,
            usize::from(presses.height.saturating_sub(2)),
        );
        Paragraph::new(lines)
            .block(Block::bordered().title(" press length "))
            .render(presses, buffer);
        let lines: Vec<Line<'_>> = self.view.touches.iter().map(touch_line).collect();
        Paragraph::new(lines)
            .block(Block::bordered().title(" touches "))
            .render(touches, buffer);
    }

    fn binding_line(&self, binding: &crate::profile::Binding) -> Line<'static> {
        let text = format!(
            "{:10} {:12}",
            self.profile.binding_place(binding),
            self.profile.output_names(binding)
        );
        if self.is_held(binding) {
            Line::from(vec![
                Span::raw("■ ").fg(Color::Yellow),
                Span::raw(text).fg(Color::Yellow).bold(),
            ])
        } else {
            Line::from(vec![Span::raw("□ "), Span::raw(text)]).fg(Color::Gray)
        }
    }

    fn is_held(&self, binding: &crate::profile::Binding) -> bool {
        let outputs = binding.targets.iter().filter_map(|target| match target {
            Target::Output(index) => self.profile.outputs.get(*index),
            _ => None,
        });
        outputs
            .into_iter()
            .any(|output| self.view.held.contains(output))
    }

    fn draw_footer(&self, area: Rect, buffer: &mut Buffer) {
        let view = self.view;
        let seconds = ms_from_nanos(view.t_ns) / 1000.0;
        let mut first = format!(
            " {seconds:6.1} s   {} frames   {:.0} frames/s   frame to events {} us",
            view.frames, view.frames_per_s, view.latency_us
        );
        if view.lost_frames > 0 {
            first.push_str(&format!("   {} LOST", view.lost_frames));
        }
        if !view.lost_electrodes.is_empty() {
            let numbers = view
                .lost_electrodes
                .iter()
                .map(|index| (index + 1).to_string());
            let numbers: Vec<String> = numbers.collect();
            first.push_str(&format!("   LOST ELECTRODES {}", numbers.join(", ")));
        }
        if view.late_events > 0 {
            first.push_str(&format!("   {} LATE", view.late_events));
        }
        if view.rumble != [0.0; 2] {
            let [strong, weak] = view.rumble;
            first.push_str(&format!("   RUMBLE {strong:.2} {weak:.2}"));
        }
        if view.paused {
            first.push_str("   PAUSED");
        }
        let second = if self.notice.is_empty() {
            format!(
                " q quits, p pauses, z zeroes   {} -> {}",
                self.title.source, self.title.output
            )
        } else {
            format!(" {}", self.notice)
        };
        Paragraph::new(vec![
            Line::raw(first),
            Line::raw(second).fg(Color::DarkGray),
        ])
        .render(area, buffer);
    }
}

/// A block character for a value 0..1.
fn shade(value: f32) -> char {
    const SHADES: [char; 5] = [' ', '░', '▒', '▓', '█'];
    SHADES[((value * SHADES.len() as f32) as usize).min(SHADES.len() - 1)]
}

/// The image's value at a place; 0 off the pad.
fn value_at(image: &Image, point: [f64; 2]) -> f32 {
    image
        .grid
        .index_at(point)
        .map_or(0.0, |pixel| image.values[pixel])
}

fn touch_line(touch: &Touch) -> Line<'static> {
    let [x, y] = touch.contact.centre_mm;
    Line::raw(format!(
        "{:3}  ({x:5.1}, {y:5.1}) mm   force {:.2}",
        format!("●{}", touch.id.0),
        touch.contact.force
    ))
}

/// The last presses, newest first, each with a bar as long as the press.
fn press_lines<'a>(
    events: impl DoubleEndedIterator<Item = &'a Event>,
    held: &[Output],
    now_ns: u64,
    most: usize,
) -> Vec<Line<'static>> {
    let mut ends: Vec<(Output, u64)> = held.iter().map(|output| (*output, now_ns)).collect();
    let mut lines = Vec::new();
    for event in events.rev() {
        match event.action {
            Action::Release(output) => ends.push((output, event.t_ns)),
            Action::Press(output) => {
                let Some(index) = ends.iter().rposition(|(ended, _)| *ended == output) else {
                    continue;
                };
                let (_, end_ns) = ends.remove(index);
                let ms = ms_from_nanos(end_ns.saturating_sub(event.t_ns));
                let bar = "█".repeat(((ms / BAR_MS).ceil() as usize).clamp(1, MAX_BAR_CHARS));
                let name = output.to_string();
                lines.push(Line::from(vec![
                    Span::raw(format!("{name:10} {ms:5.0} ms ")),
                    Span::raw(bar).fg(Color::Yellow),
                ]));
                if lines.len() == most {
                    break;
                }
            }
            Action::Axis(..) | Action::Motion { .. } | Action::Wheel { .. } => {}
        }
    }
    lines
}
