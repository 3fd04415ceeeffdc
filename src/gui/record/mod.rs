//! The record view: record the game, open a recording, and play it back.

mod expectation;
mod list;
mod player;
mod salvage;
mod scrub_bar;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::{Key, Pos2, Rect, Ui, Vec2};

use self::list::RecordingList;
use self::player::Player;
use self::salvage::{Salvage, Salvaged};
use super::background::{Background, take_result};
use super::picture::{Picture, PictureLayers};
use super::playing::Playing;
use super::request::UiAction;
use super::theme;
use crate::app::services::{AppServices, OpenError, PlayRequest};
use crate::app::timeline::RecordingTimeline;

/// Height of the controls below the pad, points.
const CONTROLS: f32 = 210.0;

/// A file, and what it holds.
type Opened = (PathBuf, Result<RecordingTimeline, OpenError>);

/// The state of the view.
#[derive(Default)]
pub struct RecordView {
    opening: Option<Background<Opened>>,
    salvage: Salvage,
    player: Option<Player>,
    picture: Picture,
    list: RecordingList,
    path: String,
    notice: Option<String>,
}

impl RecordView {
    /// Draws the view; returns what the player requested.
    pub fn ui(
        &mut self,
        ui: &mut Ui,
        playing: &Playing,
        services: &Arc<dyn AppServices>,
    ) -> Option<UiAction> {
        self.poll_opening();
        let head = theme::card(ui).show(ui, |ui| {
            ui.set_width(ui.available_width());
            self.head(ui, playing, services)
        });
        ui.add_space(4.0);
        self.open_dropped_file(ui, playing, services);
        if let Some(player) = &mut self.player {
            player.advance(ui);
            let room = ui.available_rect_before_wrap();
            let height = CONTROLS.min(room.height() * 0.55);
            let pad = Rect::from_min_max(room.min, Pos2::new(room.right(), room.bottom() - height));
            let shown = PictureLayers {
                image: true,
                regions: true,
                electrodes: false,
                scale: pad.height() > 220.0,
            };
            let game = player.game();
            self.picture.draw(ui, pad, game, &game.view.profile, shown);
            let below = Rect::from_min_max(pad.left_bottom() + Vec2::new(0.0, 8.0), room.max);
            ui.scope_builder(egui::UiBuilder::new().max_rect(below), |ui| {
                scrub_bar::ui(ui, player);
                player.controls(ui, &mut self.notice);
            });
            ui.advance_cursor_after_rect(room);
        } else {
            if let Some(file) =
                self.list
                    .ui(ui, playing.request.record.as_deref(), services.as_ref())
            {
                self.suggest(&file);
                self.open(&file, &playing.request, services);
            }
            if !self.list.is_empty() {
                return head.inner;
            }
            ui.add_space(30.0);
            ui.vertical_centered(|ui| {
                ui.label(egui::RichText::new("No recording is open").size(18.0));
                ui.weak("Record a game, then open the file here to step through every frame.");
                ui.weak("You can also drop a file onto this window. CSV frames (t_ms,v0,v1,...) work too.");
            });
        }
        head.inner
    }

    /// Reads a file on a thread.
    pub fn open(&mut self, file: &Path, request: &PlayRequest, services: &Arc<dyn AppServices>) {
        self.notice = None;
        self.salvage.offer(None);
        let (services, request, path) = (Arc::clone(services), request.clone(), file.to_owned());
        let started = Background::start("timeline", move || {
            let opened = services.load_timeline(&path, &request);
            (path, opened)
        });
        match started {
            Ok(opening) => self.opening = Some(opening),
            Err(error) => self.notice = Some(format!("The file cannot be read: {error}")),
        }
    }

    /// Shows a recording.
    pub fn show(&mut self, file: &Path, timeline: RecordingTimeline) {
        if timeline.is_empty() {
            self.notice = Some(format!("{}: contains no frames", file.display()));
            return;
        }
        self.player = Some(Player::new(file, timeline));
    }

    fn poll_opening(&mut self) {
        let died = || {
            let reason = "The file cannot be read because of a bug in gelpad".to_owned();
            let is_damaged = false;
            (PathBuf::new(), Err(OpenError { reason, is_damaged }))
        };
        match take_result(&mut self.opening, died) {
            Some((file, Ok(timeline))) => self.show(&file, timeline),
            Some((file, Err(error))) => {
                self.salvage.offer(error.is_damaged.then_some(file));
                self.notice = Some(error.reason);
            }
            None => {}
        }
    }

    /// The record button and the file to open.
    fn head(
        &mut self,
        ui: &mut Ui,
        playing: &Playing,
        services: &Arc<dyn AppServices>,
    ) -> Option<UiAction> {
        let palette = theme::palette_of(ui);
        let row = ui.horizontal_wrapped(|ui| {
            let file = playing.request.record.as_ref();
            let label = file.map_or("⏺ Record", |_| "⏹ Stop recording");
            let clicked = theme::primary(ui, label).clicked();
            if let Some(file) = file {
                ui.colored_label(palette.bad, "⏺ recording");
                ui.weak(file.display().to_string());
            } else {
                ui.weak("starts the pad again, and records it");
            }
            if self.player.is_some() && ui.button("Close this recording").clicked() {
                self.player = None;
                self.notice = None;
                self.salvage.offer(None);
            }
            clicked.then_some(UiAction::Record)
        });
        ui.horizontal(|ui| {
            let label = ui.label("File");
            let field = egui::TextEdit::singleline(&mut self.path)
                .desired_width((ui.available_width() - 90.0).max(80.0))
                .hint_text("recording.mcap");
            let response = ui.add(field).labelled_by(label.id);
            theme::keep_focus_on_enter(ui, &response);
            let entered = response.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
            let ready = !self.path.trim().is_empty();
            if ui.add_enabled(ready, egui::Button::new("Open")).clicked() || (entered && ready) {
                let file = PathBuf::from(self.path.trim());
                self.open(&file, &playing.request, services);
            }
        });
        if self.opening.is_some() {
            ui.horizontal(|ui| {
                ui.spinner();
                ui.label("Reading …");
            });
        }
        if let Some(notice) = &self.notice {
            let color = match notice.chars().next() {
                Some('✔') => palette.good,
                Some('✖') => palette.bad,
                _ => palette.warn,
            };
            let text = egui::RichText::new(notice).color(color);
            ui.add(egui::Label::new(text).wrap());
        }
        self.draw_salvage(ui, playing, services);
        row.inner
    }

    /// The offer to save the readable part of a damaged recording, and what came of it.
    fn draw_salvage(&mut self, ui: &mut Ui, playing: &Playing, services: &Arc<dyn AppServices>) {
        match self.salvage.ui(ui, services) {
            Some(Salvaged {
                result: Ok(saved),
                is_awaited,
            }) => {
                self.suggest(&saved.path);
                if is_awaited && saved.has_frames {
                    self.open(&saved.path, &playing.request, services);
                }
                self.notice = Some(format!("{}: {}", saved.summary, saved.path.display()));
            }
            Some(Salvaged {
                result: Err(why), ..
            }) => self.notice = Some(why),
            None => {}
        }
    }

    /// Opens a file that is dropped onto the window.
    fn open_dropped_file(&mut self, ui: &Ui, playing: &Playing, services: &Arc<dyn AppServices>) {
        let file = ui.input(|input| {
            let dropped = input.raw.dropped_files.first()?;
            Some(dropped.path().to_path_buf())
        });
        if let Some(file) = file {
            self.suggest(&file);
            self.open(&file, &playing.request, services);
        }
    }

    /// The file of the next recording, in the folder of recordings.
    pub fn next_file(services: &dyn AppServices) -> PathBuf {
        let folder = services.recordings_folder().unwrap_or_default();
        // Creating the recording reports a missing folder.
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
}
