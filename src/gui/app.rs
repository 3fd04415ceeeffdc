//! The application: joins the views, starts games, and passes the player's wishes on.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};

use egui::{Align2, CornerRadius, FontId, Key, Rect, Sense, Stroke, Ui, Vec2};

use super::comfort::Comfort;
use super::desk::{Choice, Desk, From, Started, To};
use super::edit::{EditView, Learning};
use super::pad_window::PadWindow;
use super::picture::Picture;
use super::play::{self, Names, Wish};
use super::playing::Playing;
use super::practice::PracticeTab;
use super::problem::{self, Around, Mend};
use super::record::RecordView;
use super::setup::SetUpView;
use super::signals::SignalsView;
use super::theme;
use super::waker::Waker;
use crate::runtime::Command;

/// The rail of the views, wide and narrow, points.
const RAIL: (f32, f32) = (92.0, 70.0);
/// A window narrower than this has the narrow rail, points.
const NARROW: f32 = 1000.0;
/// The line at the bottom, points.
const STATUS: f32 = 26.0;

/// The views.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tab {
    /// The pad and what it does.
    Play,
    /// The level of our own.
    Practice,
    /// Regions, bindings, thresholds.
    Edit,
    /// From port to play.
    SetUp,
    /// Recordings.
    Record,
    /// Voltages.
    Signals,
    /// How the window looks and answers.
    Feedback,
}

impl Tab {
    /// All, in the order of the rail.
    pub const ALL: [Self; 7] = [
        Self::Play,
        Self::Practice,
        Self::Edit,
        Self::SetUp,
        Self::Record,
        Self::Signals,
        Self::Feedback,
    ];

    /// Its word in the rail.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Play => "Play",
            Self::Practice => "Practice",
            Self::Edit => "Edit",
            Self::SetUp => "Set up",
            Self::Record => "Record",
            Self::Signals => "Signals",
            Self::Feedback => "Comfort",
        }
    }

    fn icon(self) -> &'static str {
        match self {
            Self::Play => "▶",
            Self::Practice => "★",
            Self::Edit => "✏",
            Self::SetUp => "🔧",
            Self::Record => "⏺",
            Self::Signals => "📈",
            Self::Feedback => "🔔",
        }
    }

    fn key(self) -> Key {
        match self {
            Self::Play => Key::F1,
            Self::Practice => Key::F2,
            Self::Edit => Key::F3,
            Self::SetUp => Key::F4,
            Self::Record => Key::F5,
            Self::Signals => Key::F6,
            Self::Feedback => Key::F7,
        }
    }
}

/// Everything that the window shows.
pub struct App {
    /// The view that is shown.
    pub tab: Tab,
    /// The game.
    pub playing: Playing,
    /// Why the last start failed.
    pub failed: Option<String>,
    /// The pad in a window of its own.
    pub pad_window: PadWindow,
    /// The practice level.
    pub practice: PracticeTab,
    /// The editor.
    pub edit: EditView,
    /// The wizard.
    pub set_up: SetUpView,
    /// Recordings.
    pub record: RecordView,
    /// Voltages.
    pub signals: SignalsView,
    /// How the window looks and answers.
    pub comfort: Comfort,
    desk: Arc<dyn Desk>,
    names: Names,
    starting: Option<(Choice, Receiver<Result<Started, String>>)>,
    waker: Option<Waker>,
    picture: Picture,
    dressed: bool,
    /// When the last new view came, by egui's time, s.
    last_view_s: f64,
}

impl App {
    /// A window on nothing yet.
    #[must_use]
    pub fn new(desk: Arc<dyn Desk>) -> Self {
        let names = Names {
            profiles: desk.profiles(),
            pads: desk.pads(),
            users: desk.users(),
            ports: desk.ports(),
        };
        let comfort = Comfort::of(desk.as_ref());
        let mut practice = PracticeTab::default();
        practice.practice.set_best_s(comfort.look.best_s);
        Self {
            set_up: SetUpView::default(),
            record: RecordView::default(),
            signals: SignalsView::default(),
            practice,
            comfort,
            tab: Tab::Play,
            playing: Playing::nothing(),
            failed: None,
            pad_window: PadWindow::default(),
            edit: EditView::default(),
            desk,
            names,
            starting: None,
            waker: None,
            picture: Picture::default(),
            dressed: false,
            last_view_s: 0.0,
        }
    }

    /// Lets games wake the window of a context.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn wake_by(&mut self, ctx: &egui::Context) -> std::io::Result<()> {
        self.waker = Some(Waker::start(ctx.clone())?);
        Ok(())
    }

    /// Plays something else, as soon as it has started; what was played ends now.
    pub fn play(&mut self, choice: Choice) {
        self.playing.end();
        self.failed = None;
        let (sender, receiver) = sync_channel(1);
        let desk = Arc::clone(&self.desk);
        let wanted = choice.clone();
        let waker = self.waker.as_ref().and_then(Waker::thread);
        let spawned = std::thread::Builder::new()
            .name("start".to_owned())
            .spawn(move || {
                // Whoever wanted it may have gone.
                let _ = sender.send(desk.start(&wanted));
                if let Some(waker) = waker {
                    waker.unpark();
                }
            });
        match spawned {
            Ok(_) => self.starting = Some((choice, receiver)),
            Err(error) => self.failed = Some(format!("no thread to start on: {error}")),
        }
    }

    /// Whether a game is being started.
    #[must_use]
    pub fn is_starting(&self) -> bool {
        self.starting.is_some()
    }

    /// Looks at what is new; draws nothing.
    pub fn look(&mut self, ctx: &egui::Context) {
        if let Some((choice, receiver)) = &self.starting {
            match receiver.try_recv() {
                Ok(Ok(started)) => {
                    self.playing = Playing::of(choice.clone(), started);
                    if let (Some(running), Some(thread)) = (
                        self.playing.running(),
                        self.waker.as_ref().and_then(Waker::thread),
                    ) {
                        running.wake(thread);
                    }
                    self.starting = None;
                    self.last_view_s = ctx.time();
                }
                Ok(Err(why)) => {
                    self.playing.choice = choice.clone();
                    self.failed = Some(why);
                    self.starting = None;
                }
                Err(TryRecvError::Empty) => {}
                Err(TryRecvError::Disconnected) => {
                    self.failed = Some("a bug in gelpad kept it from starting".to_owned());
                    self.starting = None;
                }
            }
        }
        if self.playing.look() {
            self.last_view_s = ctx.time();
        }
        self.practice.take(&self.playing.view);
        self.comfort.look.best_s = self.practice.practice.best_s();
        let focused = ctx.input_for(egui::ViewportId::ROOT, |input| input.focused);
        // While it checks the output, the window wants to see its own keys.
        self.playing.hush(focused && !self.checks_keys());
    }

    /// Draws the window.
    pub fn ui(&mut self, ui: &mut Ui) {
        if !self.dressed {
            theme::dress(ui.ctx());
            self.dressed = true;
        }
        self.comfort.dress(ui.ctx());
        self.look(&ui.ctx().clone());
        self.keys(ui);
        let palette = theme::of(ui);
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
        self.rail(ui, rail);
        self.status(ui, status);
        let mut body_ui = ui.new_child(
            egui::UiBuilder::new()
                .id_salt(self.tab.name())
                .max_rect(body)
                .layout(egui::Layout::top_down(egui::Align::Min)),
        );
        body_ui.set_clip_rect(body.expand(10.0));
        if let Some(wish) = self.view(&mut body_ui) {
            self.fulfil(wish);
        }
        let ctx = ui.ctx().clone();
        self.pad_window.show(&ctx, &mut self.playing);
        self.comfort.sign(ui, &self.playing);
    }

    /// The worst problem now.
    #[must_use]
    pub fn problem(&self, ctx: &egui::Context) -> Option<problem::Problem> {
        let around = Around {
            failed: self.failed.as_deref(),
            starting: self.starting.is_some(),
            silent_s: ctx.time() - self.last_view_s,
        };
        problem::worst(&self.playing, around)
    }

    fn view(&mut self, ui: &mut Ui) -> Option<Wish> {
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
            Tab::Edit => self.edit.ui(ui, &mut self.playing, self.desk.as_ref()),
            Tab::SetUp => self
                .set_up
                .ui(ui, &mut self.playing, &self.desk, &mut self.names),
            Tab::Record => self.record.ui(ui, &self.playing, &self.desk),
            Tab::Signals => {
                self.signals.ui(ui, &self.playing);
                None
            }
            Tab::Feedback => {
                self.comfort.ui(ui, &self.playing);
                None
            }
        }
    }

    fn fulfil(&mut self, wish: Wish) {
        match wish {
            Wish::Play(choice) => self.play(choice),
            Wish::PadWindow => self.pad_window.open = true,
            Wish::Record => self.record(),
            Wish::ShowPlay => self.tab = Tab::Play,
            Wish::Mend(mend) => self.mend(&mend),
        }
    }

    /// Begins a recording, or ends it: the game starts anew, as a recording begins with the untouched pad.
    fn record(&mut self) {
        let mut choice = self.playing.choice.clone();
        match choice.record.take() {
            Some(file) => self.record.suggest(&file),
            None => choice.record = Some(RecordView::fresh_file(self.desk.as_ref())),
        }
        self.play(choice);
    }

    fn mend(&mut self, mend: &Mend) {
        let mut choice = self.playing.choice.clone();
        match mend {
            Mend::Again => self.play(choice),
            Mend::GoOn => self.playing.ask(Command::Pause),
            Mend::SetUp => self.tab = Tab::SetUp,
            Mend::Signals => self.tab = Tab::Signals,
            Mend::Send => {
                choice.to = To::Auto;
                self.play(choice);
            }
            Mend::PadWindow => self.pad_window.open = true,
            Mend::Simulate => {
                choice.from = From::Hand;
                self.play(choice);
            }
            Mend::Read => self.playing.notice = None,
        }
    }

    fn checks_keys(&self) -> bool {
        self.tab == Tab::SetUp && self.set_up.checks_keys()
    }

    /// F1 to F7 show views.
    fn keys(&mut self, ui: &Ui) {
        if self.checks_keys() {
            self.set_up.take_keys(ui);
        }
        if self.tab == Tab::Edit && matches!(self.edit.learning, Learning::Key(_)) {
            // The next key is an answer.
            return;
        }
        for tab in Tab::ALL {
            if ui.input_mut(|input| input.consume_key(egui::Modifiers::NONE, tab.key())) {
                self.tab = tab;
            }
        }
    }

    fn rail(&mut self, ui: &mut Ui, room: Rect) {
        let palette = theme::of(ui);
        ui.painter().rect_filled(room, 0.0, palette.card);
        ui.painter().vline(
            room.right(),
            room.y_range(),
            Stroke::new(1.0, palette.line.gamma_multiply(0.6)),
        );
        let mut rail = ui.new_child(
            egui::UiBuilder::new()
                .id_salt("rail")
                .max_rect(room.shrink(6.0)),
        );
        rail.spacing_mut().item_spacing.y = 4.0;
        let size = (((room.height() - 60.0) / Tab::ALL.len() as f32) - 4.0).clamp(44.0, 62.0);
        let (name, _) =
            rail.allocate_exact_size(Vec2::new(room.width() - 12.0, 30.0), Sense::hover());
        rail.painter().text(
            name.center(),
            Align2::CENTER_CENTER,
            "gelpad",
            FontId::proportional(if room.width() > 80.0 { 19.0 } else { 16.0 }),
            palette.accent,
        );
        for tab in Tab::ALL {
            if rail_button(&mut rail, tab, self.tab == tab, size) {
                self.tab = tab;
            }
        }
    }

    /// What plays from where to where, and how well.
    fn status(&mut self, ui: &mut Ui, room: Rect) {
        let palette = theme::of(ui);
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
            playing.choice.source_words(),
            playing.output,
            view.profile.name,
            view.frames_per_s,
            view.latency_us as f64 / 1e3,
        );
        ui.add(egui::Label::new(egui::RichText::new(words).size(12.5)).truncate());
    }
}

/// A view's button in the rail; whether it was clicked.
fn rail_button(ui: &mut Ui, tab: Tab, chosen: bool, height: f32) -> bool {
    let palette = theme::of(ui);
    let (rect, response) =
        ui.allocate_exact_size(Vec2::new(ui.available_width(), height), Sense::click());
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::Tab, true, chosen, tab.name()));
    let painter = ui.painter();
    let round = CornerRadius::same(theme::ROUND);
    if chosen {
        painter.rect_filled(rect, round, palette.accent.gamma_multiply(0.18));
        let mark = Rect::from_min_size(
            rect.left_top() + Vec2::new(0.0, 8.0),
            Vec2::new(3.0, height - 16.0),
        );
        painter.rect_filled(mark, 2.0, palette.accent);
    } else if response.hovered() {
        painter.rect_filled(rect, round, palette.line.gamma_multiply(0.4));
    }
    if response.has_focus() {
        let line = Stroke::new(2.0, palette.accent);
        painter.rect_stroke(rect, round, line, egui::StrokeKind::Inside);
    }
    let colour = if chosen { palette.accent } else { palette.text };
    painter.text(
        rect.center() - Vec2::new(0.0, height * 0.14),
        Align2::CENTER_CENTER,
        tab.icon(),
        FontId::proportional(19.0),
        colour,
    );
    painter.text(
        rect.center() + Vec2::new(0.0, height * 0.28),
        Align2::CENTER_CENTER,
        tab.name(),
        FontId::proportional(12.5),
        colour,
    );
    let key = format!("{:?}", tab.key());
    response.on_hover_text(key).clicked()
}
