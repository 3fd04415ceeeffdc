//! The view to record and replay in: a record button, and a tape to scrub, step, loop, mark and export.

pub mod tape;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};

use egui::{Key, Modifiers, Pos2, Rect, Sense, Stroke, Ui, Vec2};

use self::tape::Tape;
use super::desk::{Choice, Desk, From};
use super::edit::write_beside;
use super::picture::{Picture, Shown};
use super::play::{Wish, strip};
use super::playing::Playing;
use super::still;
use super::theme;

/// The controls beneath the pad, points.
const CONTROLS: f32 = 210.0;
/// Buckets of the picture of the whole tape.
const BUCKETS: usize = 400;

/// A tape that is shown.
struct Open {
    tape: Tape,
    file: PathBuf,
    /// The game as it was at the frame that is shown.
    playing: Playing,
    frame: usize,
    touched: Vec<bool>,
    /// Begin and end of the piece that is marked.
    marks: [Option<usize>; 2],
    plays: bool,
    loops: bool,
    /// Seconds into the tape, while it plays.
    at_s: f64,
}

/// The view's state.
#[derive(Default)]
pub struct RecordView {
    opening: Option<(PathBuf, Receiver<Result<Tape, String>>)>,
    shown: Option<Open>,
    picture: Picture,
    path: String,
    notice: Option<String>,
}

impl RecordView {
    /// Draws the view; returns what the player wants.
    pub fn ui(&mut self, ui: &mut Ui, playing: &Playing, desk: &Arc<dyn Desk>) -> Option<Wish> {
        self.take_tape();
        let mut wish = None;
        theme::card(ui).show(ui, |ui| {
            ui.set_width(ui.available_width());
            wish = self.head(ui, playing, desk);
        });
        ui.add_space(4.0);
        self.dropped(ui, playing, desk);
        self.advance(ui);
        match &mut self.shown {
            Some(shown) => {
                let room = ui.available_rect_before_wrap();
                let height = CONTROLS.min(room.height() * 0.55);
                let pad =
                    Rect::from_min_max(room.min, Pos2::new(room.right(), room.bottom() - height));
                let parts = Shown {
                    regions: true,
                    electrodes: false,
                    scale: pad.height() > 220.0,
                };
                let profile = Arc::clone(&shown.playing.view.profile);
                self.picture.draw(ui, pad, &shown.playing, &profile, parts);
                let below = Rect::from_min_max(pad.left_bottom() + Vec2::new(0.0, 8.0), room.max);
                ui.scope_builder(egui::UiBuilder::new().max_rect(below), |ui| {
                    shown.controls(ui, &mut self.notice);
                });
                ui.advance_cursor_after_rect(room);
            }
            None => {
                ui.add_space(30.0);
                ui.vertical_centered(|ui| {
                    ui.label(egui::RichText::new("No recording is open").size(18.0));
                    ui.weak("Record what you play, then open it here: every frame can be looked at again.");
                    ui.weak("A file can be dropped onto this window; frames as CSV (t_ms,v0,v1,...) open too.");
                });
            }
        }
        wish
    }

    /// Opens a file, on a thread of its own.
    pub fn open(&mut self, file: &Path, choice: &Choice, desk: &Arc<dyn Desk>) {
        let (sender, receiver) = sync_channel(1);
        let (desk, choice, path) = (Arc::clone(desk), choice.clone(), file.to_owned());
        let spawned = std::thread::Builder::new()
            .name("tape".to_owned())
            .spawn(move || {
                // Whoever wanted it may have gone.
                let _ = sender.send(desk.tape(&path, &choice));
            });
        match spawned {
            Ok(_) => self.opening = Some((file.to_owned(), receiver)),
            Err(error) => self.notice = Some(format!("no thread to read on: {error}")),
        }
    }

    /// Shows a tape.
    pub fn show(&mut self, file: &Path, tape: Tape) {
        if tape.is_empty() {
            self.notice = Some(format!("{}: there is no frame in it", file.display()));
            return;
        }
        let view = still::view_of(&tape.pad, still::profile());
        let mut playing = Playing::still(Choice::default(), tape.pad.clone(), view);
        playing.choice.from = From::Replay(file.to_owned());
        let mut shown = Open {
            touched: tape.touched(BUCKETS),
            tape,
            file: file.to_owned(),
            playing,
            frame: 0,
            marks: [None, None],
            plays: false,
            loops: false,
            at_s: 0.0,
        };
        shown.go_to(0);
        self.shown = Some(shown);
        self.notice = None;
    }

    fn take_tape(&mut self) {
        let Some((file, receiver)) = &self.opening else {
            return;
        };
        match receiver.try_recv() {
            Ok(Ok(tape)) => {
                let file = file.clone();
                self.opening = None;
                self.show(&file, tape);
            }
            Ok(Err(why)) => {
                self.opening = None;
                self.notice = Some(why);
            }
            Err(TryRecvError::Empty) => {}
            Err(TryRecvError::Disconnected) => {
                self.opening = None;
                self.notice = Some("a bug in gelpad kept it from being read".to_owned());
            }
        }
    }

    fn head(&mut self, ui: &mut Ui, playing: &Playing, desk: &Arc<dyn Desk>) -> Option<Wish> {
        let palette = theme::of(ui);
        let mut wish = None;
        ui.horizontal_wrapped(|ui| match &playing.choice.record {
            Some(file) => {
                if theme::primary(ui, "⏹ Stop recording").clicked() {
                    wish = Some(Wish::Record);
                }
                ui.colored_label(palette.bad, "⏺ recording");
                ui.weak(file.display().to_string());
            }
            None => {
                if theme::primary(ui, "⏺ Record").clicked() {
                    wish = Some(Wish::Record);
                }
                ui.weak("what is played now, from its start");
            }
        });
        ui.horizontal(|ui| {
            let label = ui.label("File");
            let field = egui::TextEdit::singleline(&mut self.path)
                .desired_width((ui.available_width() - 90.0).max(80.0))
                .hint_text("recording.mcap");
            let response = ui.add(field).labelled_by(label.id);
            let entered = response.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
            let ready = !self.path.trim().is_empty();
            if ui.add_enabled(ready, egui::Button::new("Open")).clicked() || (entered && ready) {
                let file = PathBuf::from(self.path.trim());
                self.open(&file, &playing.choice, desk);
            }
        });
        if self.opening.is_some() {
            ui.horizontal(|ui| {
                ui.spinner();
                ui.label("reading …");
            });
        }
        if let Some(notice) = &self.notice {
            let words = egui::RichText::new(notice).color(palette.warn);
            ui.add(egui::Label::new(words).wrap());
        }
        wish
    }

    /// A file that is dropped onto the window is opened.
    fn dropped(&mut self, ui: &Ui, playing: &Playing, desk: &Arc<dyn Desk>) {
        let file = ui.input(|input| {
            let dropped = input.raw.dropped_files.first()?;
            Some(dropped.path().to_path_buf())
        });
        if let Some(file) = file {
            self.path = file.display().to_string();
            self.open(&file, &playing.choice, desk);
        }
    }

    /// Where to record to, next to other recordings of the player.
    #[must_use]
    pub fn fresh_file(desk: &dyn Desk) -> PathBuf {
        let folder = desk
            .own_folder()
            .map_or_else(PathBuf::new, |folder| folder.join("recordings"));
        // A folder that cannot be made is told of when the recording begins.
        let _ = std::fs::create_dir_all(&folder);
        (1..10_000)
            .map(|number| folder.join(format!("session-{number:03}.mcap")))
            .find(|file| !file.exists())
            .unwrap_or_else(|| folder.join("session.mcap"))
    }

    /// Suggests a file to open.
    pub fn suggest(&mut self, file: &Path) {
        self.path = file.display().to_string();
    }

    fn advance(&mut self, ui: &Ui) {
        let Some(shown) = &mut self.shown else { return };
        let no_text = !ui.ctx().text_edit_focused();
        let key = |key| no_text && ui.input_mut(|i| i.consume_key(Modifiers::NONE, key));
        if key(Key::Space) {
            shown.plays = !shown.plays;
        }
        if key(Key::Comma) {
            shown.step(-1);
        }
        if key(Key::Period) {
            shown.step(1);
        }
        if shown.plays {
            let dt = f64::from(ui.input(|input| input.stable_dt)).min(0.1);
            shown.advance(dt);
            ui.ctx().request_repaint();
        }
    }
}

impl Open {
    fn last(&self) -> usize {
        self.tape.len() - 1
    }

    /// The piece that is looped and exported: what is marked, else all.
    fn piece(&self) -> (usize, usize) {
        let [from, to] = self.marks;
        let (from, to) = (from.unwrap_or(0), to.unwrap_or(self.last()));
        (from.min(to), from.max(to))
    }

    fn go_to(&mut self, frame: usize) {
        self.frame = frame.min(self.last());
        self.at_s = self.tape.seconds(self.frame);
        let view = self.tape.view(self.frame, self.playing.view.clone());
        self.playing.view = view;
        self.playing.take_view();
    }

    fn step(&mut self, by: isize) {
        self.plays = false;
        self.go_to(self.frame.saturating_add_signed(by));
    }

    fn advance(&mut self, dt_s: f64) {
        let (from, to) = self.piece();
        self.at_s += dt_s;
        if self.at_s > self.tape.seconds(to) {
            if self.loops {
                self.at_s = self.tape.seconds(from);
            } else {
                self.plays = false;
                return self.go_to(to);
            }
        }
        let at_s = self.at_s;
        self.go_to(self.tape.frame_at(at_s));
        self.at_s = at_s;
    }

    fn controls(&mut self, ui: &mut Ui, notice: &mut Option<String>) {
        self.timeline(ui);
        ui.horizontal_wrapped(|ui| {
            let words = if self.plays { "⏸ Pause" } else { "▶ Play" };
            if ui.button(words).on_hover_text("Space").clicked() {
                self.plays = !self.plays;
                if self.plays && self.frame == self.last() {
                    self.go_to(self.piece().0);
                }
            }
            if ui.button("◀ Step back").on_hover_text(",").clicked() {
                self.step(-1);
            }
            if ui.button("Step on ▶").on_hover_text(".").clicked() {
                self.step(1);
            }
            ui.checkbox(&mut self.loops, "Loop");
            ui.separator();
            if ui.button("Mark begin").clicked() {
                self.marks[0] = Some(self.frame);
            }
            if ui.button("Mark end").clicked() {
                self.marks[1] = Some(self.frame);
            }
            if ui
                .add_enabled(self.marks != [None, None], egui::Button::new("Clear marks"))
                .clicked()
            {
                self.marks = [None, None];
            }
            if ui
                .button("Export piece")
                .on_hover_text("the marked frames as CSV beside the recording")
                .clicked()
            {
                *notice = Some(self.export());
            }
        });
        let (from, to) = self.piece();
        ui.horizontal_wrapped(|ui| {
            ui.monospace(format!(
                "{:7.2} s   frame {} of {}",
                self.tape.seconds(self.frame),
                self.frame + 1,
                self.tape.len()
            ));
            if self.marks != [None, None] {
                ui.weak(format!(
                    "piece {:.2} to {:.2} s",
                    self.tape.seconds(from),
                    self.tape.seconds(to)
                ));
            }
        });
        let room = ui.available_rect_before_wrap();
        strip::draw(ui, room, &self.playing);
    }

    /// All of the tape as a line to scrub on; touches are marked on it.
    fn timeline(&mut self, ui: &mut Ui) {
        let palette = theme::of(ui);
        let (rect, response) = ui.allocate_exact_size(
            Vec2::new(ui.available_width(), 26.0),
            Sense::click_and_drag(),
        );
        let position = self.frame as f64;
        response
            .widget_info(|| egui::WidgetInfo::slider(true, position, "Position in the recording"));
        let line = rect.shrink2(Vec2::new(8.0, 9.0));
        if let Some(at) = response.interact_pointer_pos() {
            let share = f64::from((at.x - line.left()) / line.width()).clamp(0.0, 1.0);
            self.plays = false;
            self.go_to((share * self.last() as f64).round() as usize);
        }
        if response.has_focus() {
            for (key, by) in [(Key::ArrowLeft, -1), (Key::ArrowRight, 1)] {
                if ui.input(|input| input.key_pressed(key)) {
                    self.step(by);
                }
            }
            ui.memory_mut(|memory| {
                memory.set_focus_lock_filter(
                    response.id,
                    egui::EventFilter {
                        horizontal_arrows: true,
                        ..Default::default()
                    },
                );
            });
        }
        let painter = ui.painter();
        painter.rect_filled(line, 3.0, palette.line);
        let x_of =
            |frame: usize| line.left() + line.width() * frame as f32 / (self.last().max(1)) as f32;
        for (bucket, touched) in self.touched.iter().enumerate() {
            if *touched {
                let x = line.left() + line.width() * bucket as f32 / BUCKETS as f32;
                let width = line.width() / BUCKETS as f32 + 0.5;
                let part =
                    Rect::from_min_size(Pos2::new(x, line.top()), Vec2::new(width, line.height()));
                painter.rect_filled(part, 0.0, palette.accent.gamma_multiply(0.6));
            }
        }
        for mark in self.marks.into_iter().flatten() {
            painter.vline(x_of(mark), rect.y_range(), Stroke::new(2.0, palette.text));
        }
        let edge = if response.has_focus() { 3.0 } else { 1.5 };
        painter.circle(
            Pos2::new(x_of(self.frame), line.center().y),
            8.0,
            palette.accent,
            Stroke::new(edge, palette.text),
        );
    }

    /// Writes the piece beside the recording; says where.
    fn export(&self) -> String {
        let (from, to) = self.piece();
        let stem = self.file.file_stem().unwrap_or_default().to_string_lossy();
        let name = format!("{stem}-{from}-{to}.csv");
        let file = self.file.with_file_name(name);
        match write_beside(&file, &self.tape.csv(from..=to)) {
            Ok(()) => format!("exported: {}", file.display()),
            Err(error) => format!("{}: {error}", file.display()),
        }
    }
}
