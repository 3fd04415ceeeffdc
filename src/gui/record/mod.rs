//! The record view: record the game, open a recording, and play it back.

mod expectation;
mod list;
mod player;
mod scrub_bar;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};

use egui::{Key, Pos2, Rect, Ui, Vec2};

use self::list::RecordingList;
use self::player::Player;
use super::picture::{Picture, PictureLayers};
use super::playing::Playing;
use super::request::UiAction;
use super::theme;
use crate::app::services::{AppServices, PlayRequest};
use crate::app::timeline::RecordingTimeline;

/// Height of the controls below the pad, points.
const CONTROLS: f32 = 210.0;

/// The state of the view.
#[derive(Default)]
pub struct RecordView {
    opening: Option<(PathBuf, Receiver<Result<RecordingTimeline, String>>)>,
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
        let (sender, receiver) = sync_channel(1);
        let (services, request, path) = (Arc::clone(services), request.clone(), file.to_owned());
        let spawned = std::thread::Builder::new()
            .name("timeline".to_owned())
            .spawn(move || {
                // The receiver is gone when another file was opened meanwhile.
                let _ = sender.send(services.load_timeline(&path, &request));
            });
        match spawned {
            Ok(_) => self.opening = Some((file.to_owned(), receiver)),
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
        self.notice = None;
    }

    fn poll_opening(&mut self) {
        let Some((file, receiver)) = &self.opening else {
            return;
        };
        let result = match receiver.try_recv() {
            Err(TryRecvError::Empty) => return,
            Err(TryRecvError::Disconnected) => {
                Err("The file cannot be read because of a bug in gelpad".to_owned())
            }
            Ok(result) => result,
        };
        let file = file.clone();
        self.opening = None;
        match result {
            Ok(timeline) => self.show(&file, timeline),
            Err(why) => self.notice = Some(why),
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
        row.inner
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
