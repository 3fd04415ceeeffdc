//! The application: joins the views, starts games, performs what a view requests.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};

use egui::{Rect, Stroke, Ui, Vec2};

use super::comfort::Comfort;
use super::edit::{BindStep, EditView};
use super::pad_window::PadWindow;
use super::picture::Picture;
use super::play;
use super::playing::Playing;
use super::practice::PracticeTab;
use super::problem::{self, UiContext};
use super::rail;
use super::record::RecordView;
use super::request::{Names, UiAction};
use super::setup::SetUpView;
use super::signals::SignalsView;
use super::tab::Tab;
use super::theme;
use super::waker::Waker;
use crate::app::services::{AppServices, PlayRequest, Started};
use crate::runtime::PlayCommand;

/// Width of the list of views at the left, in a wide and a narrow window, points.
const RAIL: (f32, f32) = (92.0, 70.0);
/// Windows narrower than this have the narrow rail, points.
const NARROW: f32 = 1000.0;
/// Height of the status line at the bottom, points.
const STATUS: f32 = 26.0;

/// State of the window.
pub struct App {
    /// The current view.
    pub tab: Tab,
    /// The game.
    pub playing: Playing,
    /// Why the last start failed.
    pub failed: Option<String>,
    /// The small pad-only window.
    pub pad_window: PadWindow,
    /// The practice view.
    pub practice: PracticeTab,
    /// The profile editor.
    pub edit: EditView,
    /// The setup wizard.
    pub set_up: SetUpView,
    /// The recording view.
    pub record: RecordView,
    /// The signals view.
    pub signals: SignalsView,
    /// Appearance and feedback.
    pub comfort: Comfort,
    services: Arc<dyn AppServices>,
    names: Names,
    starting: Option<(PlayRequest, Receiver<Result<Started, String>>)>,
    waker: Option<Waker>,
    picture: Picture,
    styled: bool,
    /// Arrival of the newest view, egui time, s.
    last_view_s: f64,
}

impl App {
    /// The window before the first game.
    pub fn new(services: Arc<dyn AppServices>) -> Self {
        let names = Names {
            profiles: services.profiles(),
            pads: services.pads(),
            users: services.users(),
            ports: services.ports(),
        };
        let comfort = Comfort::load(services.as_ref());
        let mut practice = PracticeTab::default();
        practice.practice.set_best_s(comfort.preferences.best_s);
        Self {
            set_up: SetUpView::default(),
            record: RecordView::default(),
            signals: SignalsView::default(),
            practice,
            comfort,
            tab: Tab::Play,
            playing: Playing::idle(),
            failed: None,
            pad_window: PadWindow::default(),
            edit: EditView::default(),
            services,
            names,
            starting: None,
            waker: None,
            picture: Picture::default(),
            styled: false,
            last_view_s: 0.0,
        }
    }

    /// Starts the thread that repaints the window when a game has a new view.
    ///
    /// # Errors
    /// The thread cannot be started.
    pub fn start_waker(&mut self, ctx: &egui::Context) -> std::io::Result<()> {
        self.waker = Some(Waker::start(ctx.clone())?);
        Ok(())
    }

    /// Ends the current game and starts another on a thread.
    pub fn play(&mut self, request: PlayRequest) {
        self.playing.stop();
        self.failed = None;
        let (sender, receiver) = sync_channel(1);
        let services = Arc::clone(&self.services);
        let to_start = request.clone();
        let waker = self.waker.as_ref().and_then(Waker::thread);
        let spawned = std::thread::Builder::new()
            .name("start".to_owned())
            .spawn(move || {
                // The receiver is gone when another game was requested meanwhile.
                let _ = sender.send(services.start(&to_start));
                if let Some(waker) = waker {
                    waker.unpark();
                }
            });
        match spawned {
            Ok(_) => self.starting = Some((request, receiver)),
            Err(error) => self.failed = Some(format!("The game cannot start: {error}")),
        }
    }

    /// Whether a game is being started.
    pub fn is_starting(&self) -> bool {
        self.starting.is_some()
    }

    /// Polls the starting and the running game; draws nothing.
    pub fn poll(&mut self, ctx: &egui::Context) {
        self.poll_start(ctx.time());
        if self.playing.poll() {
            self.last_view_s = ctx.time();
        }
        self.practice.play_new_events(&self.playing.view);
        self.comfort.preferences.best_s = self.practice.practice.best_s();
        let focused = ctx.input_for(egui::ViewportId::ROOT, |input| input.focused);
        // The setup's key check needs the keys in this window.
        self.playing.block_keys(focused && !self.checks_keys());
    }

    /// Takes over the game that was starting, if it has started or failed.
    fn poll_start(&mut self, now_s: f64) {
        let Some((request, receiver)) = &self.starting else {
            return;
        };
        match receiver.try_recv() {
            Ok(Ok(started)) => {
                self.playing = Playing::from_started(request.clone(), started);
                if let Some(thread) = self.waker.as_ref().and_then(Waker::thread) {
                    self.playing.wake_with(thread);
                }
                self.last_view_s = now_s;
            }
            Ok(Err(why)) => {
                self.playing.request = request.clone();
                self.failed = Some(why);
            }
            Err(TryRecvError::Empty) => return,
            Err(TryRecvError::Disconnected) => {
                self.failed = Some("The game cannot start because of a bug in gelpad".to_owned());
            }
        }
        self.starting = None;
    }

    /// Draws the window.
    pub fn ui(&mut self, ui: &mut Ui) {
        if !self.styled {
            theme::apply_style(ui.ctx());
            self.styled = true;
        }
        self.comfort.apply(ui.ctx());
        self.poll(&ui.ctx().clone());
        self.handle_keys(ui);
        let palette = theme::palette_of(ui);
        let whole = ui.max_rect();
        ui.painter().rect_filled(whole, 0.0, palette.ground);
        let rail_width = if whole.width() < NARROW {
            RAIL.1
        } else {
            RAIL.0
        };
        let rail = Rect::from_min_size(whole.min, Vec2::new(rail_width, whole.height()));
        let status =
            Rect::from_min_max(egui::pos2(rail.right(), whole.bottom() - STATUS), whole.max);
        let body =
            Rect::from_min_max(rail.right_top(), status.right_top()).shrink2(Vec2::new(12.0, 12.0));
        rail::draw(ui, rail, &mut self.tab);
        self.status(ui, status);
        let mut body_ui = ui.new_child(
            egui::UiBuilder::new()
                .id_salt(self.tab.name())
                .max_rect(body)
                .layout(egui::Layout::top_down(egui::Align::Min)),
        );
        body_ui.set_clip_rect(body.expand(10.0));
        if let Some(action) = self.view(&mut body_ui) {
            self.perform(action);
        }
        let ctx = ui.ctx().clone();
        self.pad_window.show(&ctx, &mut self.playing);
        self.comfort.show_feedback(ui, &self.playing);
    }

    /// The most severe problem of this moment.
    pub fn problem(&self, ctx: &egui::Context) -> Option<problem::Problem> {
        let context = UiContext {
            failed: self.failed.as_deref(),
            starting: self.starting.is_some(),
            silent_s: ctx.time() - self.last_view_s,
        };
        problem::most_severe(&self.playing, context)
    }

    fn view(&mut self, ui: &mut Ui) -> Option<UiAction> {
        match self.tab {
            Tab::Play => {
                let problem = self.problem(ui.ctx());
                play::ui(
                    ui,
                    &mut self.picture,
                    &mut self.playing,
                    problem.as_ref(),
                    &self.names,
                )
            }
            Tab::Practice => {
                self.practice.ui(ui, &mut self.picture, &mut self.playing);
                None
            }
            Tab::Edit => self.edit.ui(ui, &mut self.playing, self.services.as_ref()),
            Tab::SetUp => self
                .set_up
                .ui(ui, &mut self.playing, &self.services, &mut self.names),
            Tab::Record => self.record.ui(ui, &self.playing, &self.services),
            Tab::Signals => {
                self.signals.ui(ui, &self.playing);
                None
            }
            Tab::Comfort => {
                self.comfort.ui(ui, &self.playing);
                None
            }
        }
    }

    fn perform(&mut self, action: UiAction) {
        match action {
            UiAction::Play(request) => self.play(request),
            UiAction::PadWindow => self.pad_window.open = true,
            UiAction::Record => self.toggle_recording(),
            UiAction::Show(tab) => self.tab = tab,
            UiAction::Pause => self.playing.send_command(PlayCommand::Pause),
            UiAction::Dismiss => self.playing.notice = None,
        }
    }

    /// Starts or stops recording. The game restarts: a recording begins with the untouched pad.
    fn toggle_recording(&mut self) {
        let mut request = self.playing.request.clone();
        match request.record.take() {
            Some(file) => self.record.suggest(&file),
            None => request.record = Some(RecordView::next_file(self.services.as_ref())),
        }
        self.play(request);
    }

    fn checks_keys(&self) -> bool {
        self.tab == Tab::SetUp && self.set_up.captures_keys()
    }

    /// F1 to F7 switch views.
    fn handle_keys(&mut self, ui: &Ui) {
        if self.checks_keys() {
            self.set_up.take_keys(ui);
        }
        if self.tab == Tab::Edit && matches!(self.edit.bind_step, BindStep::Key(_)) {
            // The next key becomes the binding.
            return;
        }
        for tab in Tab::ALL {
            if ui.input_mut(|input| input.consume_key(egui::Modifiers::NONE, tab.key())) {
                self.tab = tab;
            }
        }
    }

    /// Source, output, profile, frame rate and latency.
    fn status(&mut self, ui: &mut Ui, room: Rect) {
        let palette = theme::palette_of(ui);
        let line = Stroke::new(1.0, palette.line.gamma_multiply(0.6));
        ui.painter().hline(room.x_range(), room.top(), line);
        let mut ui = ui.new_child(
            egui::UiBuilder::new()
                .id_salt("status")
                .max_rect(room.shrink2(Vec2::new(12.0, 2.0)))
                .layout(egui::Layout::left_to_right(egui::Align::Center)),
        );
        let playing = &self.playing;
        let (mark, colour, state) = if self.starting.is_some() {
            ("…", palette.warn, "starting")
        } else if self.failed.is_some() || playing.ended.is_some() {
            ("✖", palette.bad, "stopped")
        } else if playing.view.paused {
            ("⏸", palette.warn, "paused")
        } else {
            ("●", palette.good, "playing")
        };
        ui.label(egui::RichText::new(mark).color(colour));
        let view = &playing.view;
        let words = format!(
            "{state}   {} → {}   ·   {}   ·   {:.0} frames/s   ·   {:.2} ms",
            playing.request.source_label(),
            playing.output,
            view.profile.name,
            view.frames_per_s,
            view.latency_us as f64 / 1e3,
        );
        ui.add(egui::Label::new(egui::RichText::new(words).size(12.5)).truncate());
    }
}
