//! The application: joins the views, starts games, performs what a view requests.

use std::sync::Arc;

use egui::{Rect, Stroke, Ui, Vec2};

use super::background::{Background, take_result};
use super::closing::Closing;
use super::comfort::Comfort;
use super::comfort::last_game::{LastGame, kept_output};
use super::edit::{BindStep, EditView};
use super::focus_ring::FocusRing;
use super::held_keys;
use super::pad_window::PadWindow;
use super::picture::Picture;
use super::play;
use super::playing::{Playing, SILENT_S};
use super::practice::PracticeTab;
use super::problem::{self, UiContext};
use super::rail;
use super::record::RecordView;
use super::repaint_rate::RepaintRate;
use super::request::{Names, UiAction, output_words};
use super::setup::SetUpView;
use super::signals::SignalsView;
use super::tab::Tab;
use super::theme;
use super::waker::Waker;
use crate::app::services::{AppServices, OutputChoice, PlayRequest, StartError, Started};
use crate::pad::DEFAULT_PAD;
use crate::runtime::PlayCommand;

/// Width of the list of views at the left, in a wide and a narrow window, points.
const RAIL: (f32, f32) = (92.0, 70.0);
/// Windows narrower than this have the narrow rail, points.
const NARROW: f32 = 1000.0;
/// Smallest size of a view with a pad beside a panel, and of the others, points: large text in a small window leaves less room.
const MIN_PAGE: (Vec2, Vec2) = (Vec2::new(theme::COLUMN, 320.0), Vec2::new(300.0, 240.0));
/// Height of the status line at the bottom, points.
const STATUS: f32 = 26.0;

/// State of the window.
pub struct App {
    /// The current view.
    pub tab: Tab,
    /// The game.
    pub playing: Playing,
    /// Why the last start failed.
    pub failed: Option<StartError>,
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
    /// The question about unsaved changes.
    pub closing: Closing,
    services: Arc<dyn AppServices>,
    names: Names,
    starting: Option<Background<(PlayRequest, Result<Started, StartError>)>>,
    waker: Option<Waker>,
    picture: Picture,
    focus_ring: FocusRing,
    repaint_rate: RepaintRate,
    /// Whether the player chose an output in this session.
    has_chosen_output: bool,
    styled: bool,
    /// Arrival of the newest view, egui time, s.
    last_view_s: f64,
}

impl App {
    /// The window before the first game.
    pub fn new(services: Arc<dyn AppServices>) -> Self {
        let names = Names::find(services.as_ref(), DEFAULT_PAD);
        let comfort = Comfort::load(services.as_ref());
        let mut practice = PracticeTab::default();
        practice.practice.set_best_s(comfort.preferences.best_s);
        Self {
            set_up: SetUpView::default(),
            record: RecordView::default(),
            signals: SignalsView::default(),
            practice,
            tab: comfort.preferences.tab,
            playing: Playing::idle(),
            failed: None,
            pad_window: PadWindow::from_preferences(&comfort.preferences),
            comfort,
            edit: EditView::default(),
            closing: Closing::default(),
            services,
            names,
            starting: None,
            waker: None,
            picture: Picture::default(),
            focus_ring: FocusRing::default(),
            repaint_rate: RepaintRate::default(),
            has_chosen_output: false,
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
        // The lists and the status line show what is starting.
        self.playing.request = request.clone();
        self.playing.output = output_words(request.output).to_owned();
        self.failed = None;
        let services = Arc::clone(&self.services);
        let waker = self.waker.as_ref().and_then(Waker::thread);
        let start = move || {
            let started = services.start(&request);
            (request, started)
        };
        let started = Background::start_then("start", start, move || {
            if let Some(waker) = waker {
                waker.unpark();
            }
            crate::platform::memory::trim_heaps();
        });
        match started {
            Ok(starting) => self.starting = Some(starting),
            Err(error) => {
                self.failed = Some(StartError::of_game(format!(
                    "the game cannot start: {error}"
                )));
            }
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
        self.playing.silent_s = ctx.time() - self.last_view_s;
        if self.playing.is_running() && self.playing.silent_s <= SILENT_S {
            // No view may come that would repaint the window.
            ctx.request_repaint_after(std::time::Duration::from_secs_f64(SILENT_S + 0.05));
        }
        if self.tab == Tab::Practice {
            self.practice.play_new_events(&self.playing.view);
        } else {
            self.practice.skip_events(&self.playing.view);
        }
        self.remember();
        self.set_repaint_rate(ctx);
        let focused = ctx.input_for(egui::ViewportId::ROOT, |input| input.focused);
        // The setup's key check needs the keys in this window.
        self.playing.block_keys(focused && !self.checks_keys());
    }

    fn set_repaint_rate(&mut self, ctx: &egui::Context) {
        let minimised = ctx.input_for(egui::ViewportId::ROOT, |input| input.viewport().minimized);
        let is_hidden = minimised == Some(true) && !self.pad_window.open;
        let view = &self.playing.view;
        let interval = self.repaint_rate.interval(view, ctx.time(), is_hidden);
        if let Some(waker) = &self.waker {
            waker.set_interval(interval);
        }
    }

    /// Takes into the preferences what the next start restores.
    fn remember(&mut self) {
        let kept = &mut self.comfort.preferences;
        kept.best_s = self.practice.practice.best_s();
        kept.tab = self.tab;
        self.pad_window.store(kept);
        if self.playing.is_running() {
            let before = kept.last_game.clone();
            kept.last_game = LastGame::from_request(&self.playing.request);
            // The trial at the start of the next session is not the player's choice.
            kept.last_game.was_sent |= before.was_sent && !self.has_chosen_output;
            kept.last_game.output = kept.last_game.output.or(before.output);
        }
    }

    /// The game of the last session.
    #[must_use]
    pub fn last_game(&self) -> PlayRequest {
        self.comfort.preferences.last_game.to_request()
    }

    /// Stops the game and saves the preferences, when the window closes.
    pub fn close(&mut self, size: Option<Vec2>) {
        self.playing.stop();
        if let Some(size) = size {
            self.comfort.preferences.size = Some([size.x, size.y]);
        }
        self.comfort.save();
    }

    /// Takes over the game that was starting, if it has started or failed.
    fn poll_start(&mut self, now_s: f64) {
        let died = || {
            let why = "the game cannot start because of a bug in gelpad";
            let request = self.playing.request.clone();
            (request, Err(StartError::of_game(why)))
        };
        match take_result(&mut self.starting, died) {
            None => {}
            Some((request, Ok(started))) => {
                self.playing = Playing::from_started(request, started);
                if let Some(waker) = &self.waker
                    && let Some(thread) = waker.thread()
                {
                    self.playing.wake_with(thread, waker.changes());
                }
                self.last_view_s = now_s;
                // Saved profiles, people and calibrations may be new.
                self.names = Names::find(self.services.as_ref(), &self.playing.pad.name);
            }
            Some((request, Err(why))) => {
                self.playing.request = request;
                self.failed = Some(why);
            }
        }
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
        let whole = ui.max_rect();
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
        let ended = self.status(ui, status);
        if let Some(action) = self.page(ui, body).or(ended) {
            self.perform(action);
        }
        let ctx = ui.ctx().clone();
        self.pad_window.show(&ctx, &mut self.playing);
        self.comfort.show_feedback(ui, &self.playing);
        self.closing.show(&ctx, &mut self.edit, &self.services);
        self.focus_ring.draw(ui);
    }

    /// The current view. In a window too small for it, the page scrolls.
    fn page(&mut self, ui: &mut Ui, body: Rect) -> Option<UiAction> {
        let layout = egui::Layout::top_down(egui::Align::Min);
        let place = |rect: Rect, name: &str| {
            let builder = egui::UiBuilder::new().id_salt(name);
            builder.max_rect(rect).layout(layout)
        };
        let mut body_ui = ui.new_child(place(body, self.tab.name()));
        body_ui.set_clip_rect(body.expand(10.0));
        let is_column = body.width() < theme::COLUMN;
        let smallest = match self.tab {
            // These have a layout of their own for narrow windows.
            Tab::Play | Tab::Edit | Tab::SetUp | Tab::Signals if is_column => Vec2::ZERO,
            Tab::Play | Tab::Edit | Tab::SetUp | Tab::Signals => MIN_PAGE.0,
            Tab::Practice | Tab::Record | Tab::Comfort => MIN_PAGE.1,
        };
        let size = body.size().max(smallest);
        if size == body.size() {
            return self.view(&mut body_ui);
        }
        let scroll = egui::ScrollArea::both().id_salt("page").auto_shrink(false);
        let shown = scroll.show(&mut body_ui, |ui| {
            let (rect, _) = ui.allocate_exact_size(size, egui::Sense::hover());
            self.view(&mut ui.new_child(place(rect, "page")))
        });
        shown.inner
    }

    /// The most severe problem of this moment.
    pub fn problem(&self) -> Option<problem::Problem> {
        problem::most_severe(&self.playing, self.problem_context())
    }

    fn problem_context(&self) -> UiContext<'_> {
        UiContext {
            failed: self.failed.as_ref().map(|failed| failed.reason.as_str()),
            starting: self.starting.is_some(),
            was_sent: self.comfort.preferences.last_game.was_sent,
            last_output: self.comfort.preferences.last_game.output,
            is_pad_open: self.pad_window.shows_pad(),
        }
    }

    fn view(&mut self, ui: &mut Ui) -> Option<UiAction> {
        if self.tab != Tab::SetUp {
            self.set_up.leave();
        }
        match self.tab {
            Tab::Play => {
                let problem = self.problem();
                play::ui(
                    ui,
                    &mut self.picture,
                    &mut self.playing,
                    problem.as_ref(),
                    &self.names,
                    self.pad_window.shows_pad(),
                )
            }
            Tab::Practice => {
                self.practice.ui(ui, &mut self.picture, &mut self.playing);
                None
            }
            Tab::Edit => self.edit.ui(ui, &mut self.playing, self.services.as_ref()),
            Tab::SetUp => {
                let failed = self.failed.as_ref();
                let (services, names) = (&self.services, &mut self.names);
                self.set_up
                    .ui(ui, &mut self.playing, services, names, failed)
            }
            Tab::Record => self.record.ui(ui, &self.playing, &self.services),
            Tab::Signals => {
                self.signals.ui(ui, &self.playing);
                None
            }
            Tab::Comfort => self.comfort.ui(ui, &self.playing, self.services.as_ref()),
        }
    }

    fn perform(&mut self, action: UiAction) {
        match action {
            UiAction::Play(request) => {
                self.choose_output(request.output);
                self.play(request);
            }
            UiAction::PadWindow => self.pad_window.toggle_pad(),
            UiAction::Overlay => self.pad_window.toggle_overlay(),
            UiAction::Record => self.toggle_recording(),
            UiAction::Show(tab) => self.tab = tab,
            UiAction::Pause => self.playing.send_command(PlayCommand::Pause),
            UiAction::Dismiss => self.playing.notice = None,
        }
    }

    /// Keeps an output that the player chose, whether it can be opened now or not. With the first one of a session, the pad window
    /// opens again.
    fn choose_output(&mut self, output: OutputChoice) {
        if output == self.playing.request.output {
            return;
        }
        self.has_chosen_output = true;
        if let Some(output) = kept_output(output) {
            self.comfort.preferences.last_game.output = Some(output);
            self.pad_window.reopen();
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
        held_keys::drop_repeated_clicks(ui);
        if self.checks_keys() {
            let sent = &self.playing.view.profile.outputs;
            self.set_up.take_keys(ui, sent);
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
    fn status(&mut self, ui: &mut Ui, room: Rect) -> Option<UiAction> {
        let palette = theme::palette_of(ui);
        let line = Stroke::new(1.0, palette.line.gamma_multiply(0.6));
        ui.painter().hline(room.x_range(), room.top(), line);
        let mut ui = ui.new_child(
            egui::UiBuilder::new()
                .id_salt("status")
                .max_rect(room.shrink2(Vec2::new(12.0, 1.0)))
                .layout(egui::Layout::left_to_right(egui::Align::Center)),
        );
        let playing = &self.playing;
        let (mark, colour, state) = if self.starting.is_some() {
            ("…", palette.warn, "starting")
        } else if self.failed.is_some() || playing.ended.is_some() {
            ("✖", palette.bad, "stopped")
        } else if playing.view.paused {
            ("⏸", palette.warn, "paused")
        } else if playing.is_silent() {
            ("○", palette.warn, "no data")
        } else if playing.waits_for_frames() {
            ("…", palette.warn, "waiting for the pad")
        } else {
            ("●", palette.good, "playing")
        };
        ui.label(egui::RichText::new(mark).color(colour));
        let view = &playing.view;
        let words = format!(
            "{state}   ·   {:.0} frames/s   ·   {:.2} ms delay   ·   {} → {}   ·   {}",
            playing.frames_per_s(),
            view.latency_us as f64 / 1e3,
            playing.request.source_label(),
            playing.output,
            view.profile.name,
        );
        let stops = playing.request.record.is_some() && draw_recording_badge(&mut ui);
        let continues = self.continues(&mut ui);
        if let Some(share) = playing.table.as_ref().map(|table| table.share()) {
            draw_table_progress(&mut ui, share);
        }
        ui.add(egui::Label::new(egui::RichText::new(words).size(12.5)).truncate());
        stops.then_some(UiAction::Record).or(continues)
    }

    /// The way on with the game of the last session, where Play does not show it.
    fn continues(&self, ui: &mut Ui) -> Option<UiAction> {
        let is_way_on = |fix: &(&str, UiAction)| fix.0 == problem::CONTINUE;
        let shown = self.problem().and_then(|problem| problem.fix);
        if self.starting.is_some()
            || (self.tab == Tab::Play && shown.as_ref().is_some_and(is_way_on))
        {
            return None;
        }
        let trial = problem::trial(&self.playing, self.problem_context())?;
        let (label, action) = trial.fix.filter(is_way_on)?;
        theme::small_button(ui, label).clicked().then_some(action)
    }
}

/// Says on every page that the game is recorded; returns whether it was clicked, which ends the recording.
fn draw_recording_badge(ui: &mut Ui) -> bool {
    let palette = theme::palette_of(ui);
    let text = egui::RichText::new("⏺ recording: stop").color(palette.bad);
    let size = Vec2::splat(theme::MIN_TARGET);
    ui.add(egui::Button::new(text.size(12.5)).small().min_size(size))
        .on_hover_text("Ends the recording; the game starts again")
        .clicked()
}

/// How much of the pad's response table is solved.
fn draw_table_progress(ui: &mut Ui, share: f32) {
    let text = format!("preparing the pad: {:.0} %", share * 100.0);
    let bar = egui::ProgressBar::new(share)
        .desired_width(190.0)
        .desired_height(18.0)
        .text(egui::RichText::new(text).size(12.0));
    ui.add(bar).on_hover_text(
        "You can play already. Places of touches become exact when the pad is prepared, which happens once.",
    );
}
