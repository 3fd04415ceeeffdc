//! The window: see the pad, play, edit, set up, understand. One file or folder a view, a small application that joins them.
//!
//! Logic that can be pure is kept apart from drawing: where the pad lies (`place.rs`), what happened (`story.rs`), which
//! fingers press (`fingers.rs`), what is wrong (`problem.rs`).
//!
//! Invariants: the window reads the newest view and asks for things; it never waits for the engine, and the engine never for
//! it. It is repainted when something has changed. It gets no keys of its own (`hush.rs`).

pub mod app;
pub mod comfort;
pub mod desk;
pub mod edit;
pub mod fingers;
pub mod hush;
pub mod pad_window;
pub mod picture;
pub mod place;
pub mod play;
pub mod playing;
pub mod practice;
pub mod press;
pub mod problem;
pub mod record;
pub mod regions;
pub mod setup;
pub mod signals;
pub mod still;
pub mod story;
pub mod theme;
pub mod waker;

pub use app::{App, Tab};
pub use playing::Playing;

use std::panic::AssertUnwindSafe;
use std::sync::Arc;

use desk::{Choice, Desk};

/// Size of the window when it opens, and least size, points.
const SIZE: [f32; 2] = [1280.0, 800.0];
const LEAST_SIZE: [f32; 2] = [640.0, 400.0];

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
#[error("no window: {0}")]
pub struct NoWindow(String);

/// What opens.
pub struct Opening {
    /// Who starts games.
    pub desk: Arc<dyn Desk>,
    /// What is played first.
    pub choice: Choice,
    /// The view that is shown first.
    pub tab: Tab,
    /// Whether the program has been asked to end.
    pub interrupted: Box<dyn Fn() -> bool>,
}

/// Opens the window and shows it until it is closed.
///
/// # Errors
/// No display, no GL, or a library that is missing; nothing has been played then.
pub fn open(opening: Opening) -> Result<(), NoWindow> {
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("gelpad")
            .with_app_id("gelpad")
            .with_inner_size(SIZE)
            .with_min_inner_size(LEAST_SIZE),
        ..Default::default()
    };
    // A library that the system lacks is told of by a panic.
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| {}));
    let opened = std::panic::catch_unwind(AssertUnwindSafe(|| {
        eframe::run_native(
            "gelpad",
            options,
            Box::new(move |creation| {
                std::panic::set_hook(hook);
                theme::fonts(&creation.egui_ctx);
                let mut app = App::new(opening.desk);
                app.wake_by(&creation.egui_ctx)?;
                app.tab = opening.tab;
                app.play(opening.choice);
                Ok(Box::new(Window {
                    app,
                    interrupted: opening.interrupted,
                    repaints: Repaints::default(),
                }))
            }),
        )
    }));
    match opened {
        Ok(Ok(())) => Ok(()),
        Ok(Err(error)) => Err(NoWindow(in_one_line(&error.to_string()))),
        Err(panic) => {
            let _ = std::panic::take_hook();
            let words = panic
                .downcast_ref::<String>()
                .map(String::as_str)
                .or_else(|| panic.downcast_ref::<&str>().copied());
            Err(NoWindow(in_one_line(
                words.unwrap_or("a library is missing"),
            )))
        }
    }
}

fn in_one_line(words: &str) -> String {
    words.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The application in eframe's window.
struct Window {
    app: App,
    interrupted: Box<dyn Fn() -> bool>,
    repaints: Repaints,
}

/// Counts repaints, for who measures.
#[derive(Default)]
struct Repaints {
    since_s: f64,
    count: u32,
    plays: bool,
}

impl Repaints {
    fn count(&mut self, now_s: f64, plays: bool) {
        if plays && !self.plays {
            self.plays = true;
            tracing::debug!("the pad plays");
        }
        self.count += 1;
        let elapsed_s = now_s - self.since_s;
        if elapsed_s >= 1.0 {
            let rate = f64::from(self.count) / elapsed_s;
            tracing::debug!("repaints: {rate:.0} a second");
            self.since_s = now_s;
            self.count = 0;
        }
    }
}

impl eframe::App for Window {
    fn logic(&mut self, ctx: &egui::Context, _: &mut eframe::Frame) {
        if (self.interrupted)() {
            ctx.send_viewport_cmd(egui::ViewportCommand::Close);
        }
        self.app.look(ctx);
    }

    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        self.app.ui(ui);
        let plays = self.app.playing.view.frames > 0;
        self.repaints.count(ui.ctx().time(), plays);
    }

    fn on_exit(&mut self, _: Option<&eframe::glow::Context>) {
        self.app.playing.end();
    }
}
