//! The live view in a terminal: the pad as an image with its touches and regions, what is held, the last presses,
//! frames a second and latency.

use std::io::Stdout;
use std::time::Duration;

use anyhow::Context as _;
use crossterm::event::{self, Event as TerminalEvent, KeyCode, KeyModifiers};
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
use crate::profile::{Profile, Target};
use crate::runtime::View;
use crate::types::{Action, Event, Image, Output, Touch, heat, ms_from_nanos};

/// The colour scale ends at this relative rise, or at the image's peak if that is higher.
const FULL_SCALE: f32 = 0.3;
/// Milliseconds of a press for each character of its bar.
const BAR_MS: f64 = 25.0;
/// Bars are cut at this many characters.
const LONGEST_BAR: usize = 24;

/// What is played from where to where.
pub(super) struct Title {
    pub source: String,
    pub output: String,
}

/// What the player asks of the view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wish {
    GoOn,
    /// q or Esc: the end, as planned.
    End,
    /// Ctrl-C.
    Interrupt,
    /// p: pause, or go on.
    Pause,
    /// z: the pad counts as untouched as it is.
    Rezero,
}

/// A terminal in raw mode on its alternate screen; dropping it gives the terminal back.
pub(super) struct LiveView {
    terminal: ratatui::Terminal<CrosstermBackend<Stdout>>,
    title: Title,
    pad: String,
    pad_mm: [f64; 2],
    /// The last thing that the player should know.
    notice: String,
    /// NO_COLOR: the image as shades of characters.
    plain: bool,
}

impl LiveView {
    /// Takes the terminal.
    pub(super) fn open(title: Title, pad: &Pad) -> anyhow::Result<Self> {
        terminal::enable_raw_mode().context("the terminal gives no raw mode: use --headless")?;
        log::hold_back(true);
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
            terminal: ratatui::Terminal::new(CrosstermBackend::new(stdout))?,
            title,
            pad: pad.name.clone(),
            pad_mm: pad.outline.size_mm(),
            notice: String::new(),
            plain: std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty()),
        })
    }

    /// Shows a line beneath until another one comes.
    pub(super) fn tell(&mut self, notice: String) {
        self.notice = notice;
    }

    /// Draws a view, then waits for a while for what the player wants.
    ///
    /// # Errors
    /// The terminal is gone.
    pub(super) fn draw_and_wait(&mut self, view: &View, wait: Duration) -> anyhow::Result<Wish> {
        let screen = Screen {
            view,
            title: &self.title,
            pad: &self.pad,
            pad_mm: self.pad_mm,
            profile: &view.profile,
            notice: &self.notice,
            plain: self.plain,
        };
        self.terminal
            .draw(|frame| frame.render_widget(screen, frame.area()))?;
        if event::poll(wait)? {
            Ok(wish(&event::read()?))
        } else {
            Ok(Wish::GoOn)
        }
    }
}

impl Drop for LiveView {
    fn drop(&mut self) {
        restore();
    }
}

/// Gives the terminal back; nothing can be done where that fails.
fn restore() {
    log::hold_back(false);
    let _ = execute!(
        std::io::stdout(),
        terminal::LeaveAlternateScreen,
        crossterm::cursor::Show
    );
    let _ = terminal::disable_raw_mode();
}

fn wish(event: &TerminalEvent) -> Wish {
    let TerminalEvent::Key(key) = event else {
        return Wish::GoOn;
    };
    match key.code {
        KeyCode::Esc | KeyCode::Char('q') => Wish::End,
        KeyCode::Char('p') => Wish::Pause,
        KeyCode::Char('z') => Wish::Rezero,
        KeyCode::Char('c') if key.modifiers.contains(KeyModifiers::CONTROL) => Wish::Interrupt,
        _ => Wish::GoOn,
    }
}

/// One picture of a view.
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
        // The pad takes what height allows: characters are twice as high as wide.
        let height = body.height.saturating_sub(2);
        let shape = self.pad_mm[0] / self.pad_mm[1];
        let wide = (f64::from(height) * 2.0 * shape) as u16 + 2;
        let wide = wide.min(body.width * 6 / 10).max(12);
        let [left, right] =
            Layout::horizontal([Constraint::Length(wide), Constraint::Min(20)]).areas(body);
        self.pad(left, buffer);
        self.side(right, buffer);
        self.footer(footer, buffer);
    }
}

impl Screen<'_> {
    fn pad(&self, area: Rect, buffer: &mut Buffer) {
        let block = Block::bordered().title(format!(" {} ", self.pad));
        let inner = block.inner(area);
        block.render(area, buffer);
        if inner.width < 2 || inner.height < 2 {
            return;
        }
        let map = Map::new(self.pad_mm, usize::from(inner.width)).regions(self.profile);
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
                    let [r, g, b] = heat(value(part));
                    Color::Rgb(r, g, b)
                });
                match mark {
                    ' ' => cell.set_char('▀').set_fg(upper).set_bg(lower),
                    mark => cell.set_char(mark).set_fg(Color::Gray).set_bg(lower),
                };
            }
        }
        for touch in &self.view.touches {
            self.touch(touch, inner, rows, map.rows(), buffer);
        }
    }

    fn touch(&self, touch: &Touch, inner: Rect, shown: usize, rows: usize, buffer: &mut Buffer) {
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

    fn side(&self, area: Rect, buffer: &mut Buffer) {
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
            .map(|b| self.binding(b))
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
            .block(Block::bordered().title(" how long is how high "))
            .render(presses, buffer);
        let lines: Vec<Line<'_>> = self.view.touches.iter().map(touch_line).collect();
        Paragraph::new(lines)
            .block(Block::bordered().title(" touches "))
            .render(touches, buffer);
    }

    fn binding(&self, binding: &crate::profile::Binding) -> Line<'static> {
        let text = format!(
            "{:10} {:12}",
            self.profile.place_of(binding),
            self.profile.outputs_of(binding)
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

    fn footer(&self, area: Rect, buffer: &mut Buffer) {
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
            first.push_str(&format!("   WITHOUT ELECTRODE {:?}", view.lost_electrodes));
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
                " q ends, p pauses, z zeroes   {} -> {}",
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

/// A value 0..1 without colours.
fn shade(value: f32) -> char {
    const SHADES: [char; 5] = [' ', '░', '▒', '▓', '█'];
    SHADES[((value * SHADES.len() as f32) as usize).min(SHADES.len() - 1)]
}

/// The image's value at a place; zero off the pad.
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

/// The last presses, newest first, each with a bar as long as it was held.
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
                let bar = "█".repeat(((ms / BAR_MS).ceil() as usize).clamp(1, LONGEST_BAR));
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
