//! Plays an open recording: play, step, loop, mark a part, export it.

use std::path::{Path, PathBuf};

use egui::{Key, Modifiers, Ui};

use super::expectation;
use crate::app::services::{PlayRequest, SourceChoice};
use crate::app::timeline::RecordingTimeline;
use crate::gui::edit::write_atomically;
use crate::gui::play::strip;
use crate::gui::playing::Playing;
use crate::gui::still;

/// Number of parts that are checked for touches.
pub(super) const PARTS: usize = 400;

/// An open recording and the position in it.
pub(super) struct Player {
    pub(super) timeline: RecordingTimeline,
    file: PathBuf,
    /// The game as it was at the current frame.
    game: Playing,
    pub(super) frame: usize,
    /// Which of the `PARTS` equal parts of the recording have touches.
    pub(super) touched: Vec<bool>,
    /// First and last frame of the marked part.
    pub(super) marks: [Option<usize>; 2],
    plays: bool,
    loops: bool,
    /// Whether the bar of the recording has the focus.
    pub(super) has_bar_focus: bool,
    /// Position, s.
    at_s: f64,
    /// Whether the question is shown that saving would replace other expected events.
    asks_to_replace: bool,
}

impl Player {
    /// Opens a recording, which is not empty, at its first frame.
    pub(super) fn new(file: &Path, timeline: RecordingTimeline) -> Self {
        let view = still::view_of_pad(&timeline.pad, still::profile());
        let request = PlayRequest {
            source: SourceChoice::Replay(file.to_owned()),
            ..PlayRequest::default()
        };
        let mut player = Self {
            touched: timeline.touched_parts(PARTS),
            game: Playing::without_game(request, timeline.pad.clone(), view),
            timeline,
            file: file.to_owned(),
            frame: 0,
            marks: [None, None],
            plays: false,
            loops: false,
            has_bar_focus: false,
            at_s: 0.0,
            asks_to_replace: false,
        };
        player.go_to(0);
        player
    }

    /// The game as it was at the current frame.
    pub(super) fn game(&self) -> &Playing {
        &self.game
    }

    pub(super) fn last(&self) -> usize {
        self.timeline.len() - 1
    }

    /// First and last frame of the marked part, or of the recording.
    fn part(&self) -> (usize, usize) {
        let [from, to] = self.marks;
        let (from, to) = (from.unwrap_or(0), to.unwrap_or(self.last()));
        (from.min(to), from.max(to))
    }

    fn go_to(&mut self, frame: usize) {
        self.frame = frame.min(self.last());
        self.at_s = self.timeline.seconds(self.frame);
        let view = self.timeline.view(self.frame, self.game.view.clone());
        self.game.view = view;
        self.game.record_view();
    }

    /// Stops and goes to a frame.
    pub(super) fn seek(&mut self, frame: usize) {
        self.plays = false;
        self.go_to(frame);
    }

    /// Stops and goes `by` frames forward.
    pub(super) fn step(&mut self, by: isize) {
        self.seek(self.frame.saturating_add_signed(by));
    }

    /// Handles the shortcuts, and moves on by the time since the last repaint.
    pub(super) fn advance(&mut self, ui: &Ui) {
        let no_text = !ui.ctx().text_edit_focused();
        let key = |key| no_text && ui.input_mut(|i| i.consume_key(Modifiers::NONE, key));
        // On another control, Space presses it.
        let is_free = self.has_bar_focus || ui.memory(|memory| memory.focused().is_none());
        if is_free && key(Key::Space) {
            self.plays = !self.plays;
        }
        if key(Key::Comma) {
            self.step(-1);
        }
        if key(Key::Period) {
            self.step(1);
        }
        if self.plays {
            let dt_s = f64::from(ui.input(|input| input.stable_dt)).min(0.1);
            self.play_on(dt_s);
            ui.ctx().request_repaint();
        }
    }

    fn play_on(&mut self, dt_s: f64) {
        let (from, to) = self.part();
        let mut at_s = self.at_s + dt_s;
        if at_s > self.timeline.seconds(to) {
            if !self.loops {
                return self.seek(to);
            }
            at_s = self.timeline.seconds(from);
        }
        self.go_to(self.timeline.frame_at(at_s));
        self.at_s = at_s;
    }

    /// Draws the buttons, the position and the strip chart; export writes `notice`.
    pub(super) fn controls(&mut self, ui: &mut Ui, notice: &mut Option<String>) {
        ui.horizontal_wrapped(|ui| {
            self.play_buttons(ui);
            ui.separator();
            self.mark_buttons(ui);
            let hint = "Saves the marked frames as CSV next to the recording";
            if ui.button("Export part").on_hover_text(hint).clicked() {
                *notice = Some(self.export());
            }
            self.expectation_buttons(ui, notice);
        });
        let (from, to) = self.part();
        let seconds = |frame| self.timeline.seconds(frame);
        ui.horizontal_wrapped(|ui| {
            let (frame, frames) = (self.frame + 1, self.timeline.len());
            let at_s = seconds(self.frame);
            ui.monospace(format!("{at_s:7.2} s   frame {frame} of {frames}"));
            if self.marks != [None, None] {
                ui.weak(format!("part {:.2} to {:.2} s", seconds(from), seconds(to)));
            }
        });
        let room = ui.available_rect_before_wrap();
        strip::draw(ui, room, &self.game);
    }

    fn play_buttons(&mut self, ui: &mut Ui) {
        let label = if self.plays { "⏸ Pause" } else { "▶ Play" };
        if ui.button(label).on_hover_text("Space").clicked() {
            self.plays = !self.plays;
            if self.plays && self.frame == self.last() {
                self.go_to(self.part().0);
            }
        }
        if ui.button("◀ Step back").on_hover_text(",").clicked() {
            self.step(-1);
        }
        if ui.button("Step forward ▶").on_hover_text(".").clicked() {
            self.step(1);
        }
        ui.checkbox(&mut self.loops, "Loop");
    }

    fn mark_buttons(&mut self, ui: &mut Ui) {
        for (mark, label) in self.marks.iter_mut().zip(["Mark start", "Mark end"]) {
            if ui.button(label).clicked() {
                *mark = Some(self.frame);
            }
        }
        let clear = egui::Button::new("Clear marks");
        if ui.add_enabled(self.marks != [None, None], clear).clicked() {
            self.marks = [None, None];
        }
    }

    /// Saves the events as the expected ones, or compares them with those.
    fn expectation_buttons(&mut self, ui: &mut Ui, notice: &mut Option<String>) {
        let save = ui.button("Save expected events");
        let hint = "Writes what was pressed next to the recording, a line an event";
        let mut saves = false;
        if save.on_hover_text(hint).clicked() {
            self.asks_to_replace = expectation::differ(&self.file, &self.timeline.event_lines());
            saves = !self.asks_to_replace;
        }
        if self.asks_to_replace {
            ui.label("Other events are expected so far.");
            saves = ui.button("Replace them").clicked();
            self.asks_to_replace = !(saves || ui.button("Keep them").clicked());
        }
        if saves {
            *notice = Some(expectation::save(&self.file, &self.timeline.event_lines()));
        }
        let exists = expectation::expected_file(&self.file).exists();
        let check = ui.add_enabled(exists, egui::Button::new("Check events"));
        if check
            .on_hover_text("Compares what this version of gelpad presses with the saved events")
            .clicked()
        {
            *notice = Some(expectation::check(&self.file, &self.timeline.event_lines()));
        }
    }

    /// Writes the part next to the recording; returns a message.
    fn export(&self) -> String {
        let (from, to) = self.part();
        let stem = self.file.file_stem().unwrap_or_default().to_string_lossy();
        let name = format!("{stem}-{from}-{to}.csv");
        let file = self.file.with_file_name(name);
        match write_atomically(&file, &self.timeline.csv(from..=to)) {
            Ok(()) => format!("Exported to {}", file.display()),
            Err(error) => error.to_string(),
        }
    }
}
