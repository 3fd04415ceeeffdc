//! The window: play, practise, edit, set up, record and inspect signals. One file or folder per view; `app.rs` joins them.
//!
//! Logic without drawing has its own files: the pad on screen (`place.rs`), recent touches and presses (`history.rs`),
//! fingers on the simulated pad (`fingers.rs`), problems (`problem.rs`).
//!
//! Invariants: the window reads the newest view and sends commands; neither the window nor the engine waits for the other.
//! The window repaints only when something has changed (`repaint_rate.rs`). It never receives gelpad's own keys (`src/app/focus_gate.rs`).

pub mod app;
mod background;
mod choice;
mod closing;
pub mod comfort;
pub mod edit;
mod file_dialog;
pub mod fingers;
mod focus_ring;
mod held_keys;
pub mod history;
mod overlay;
mod pad_nodes;
pub mod pad_window;
pub mod picture;
pub mod place;
pub mod play;
pub mod playing;
pub mod practice;
pub mod press;
pub mod problem;
mod quiet_panics;
mod rail;
pub mod record;
pub mod regions;
pub mod repaint_rate;
mod request;
mod screen_reader;
pub mod setup;
pub mod signals;
pub mod still;
pub mod tab;
pub mod theme;
mod timing_settings;
pub mod waker;

pub use app::App;
pub use playing::Playing;
pub use tab::Tab;

use std::sync::Arc;

use crate::app::services::{AppServices, WindowArguments};

/// Initial size of the window and its minimum, points. With its title bar, the window fits on a screen of 1280 x 800.
const SIZE: [f32; 2] = [1240.0, 730.0];
const MIN_SIZE: [f32; 2] = [640.0, 400.0];

/// The window could not be opened.
#[derive(Debug, thiserror::Error)]
#[error("no window: {0}")]
pub struct WindowError(String);

/// What the window shows and plays when it opens.
pub struct WindowOptions {
    /// Starts games, finds profiles and pads.
    pub services: Arc<dyn AppServices>,
    /// Changes the game that is played first, which is that of the last session.
    pub arguments: WindowArguments,
    /// Whether a signal has asked the program to end.
    pub interrupted: Box<dyn Fn() -> bool>,
}

/// Installs the fonts and the plugin for screen readers in an egui context. Call it before the first frame is drawn.
pub fn prepare_context(ctx: &egui::Context) {
    theme::install_fonts(ctx);
    ctx.add_plugin(screen_reader::ScreenReaderTree);
}

/// Opens the window and returns when it is closed.
///
/// # Errors
/// There is no display, no OpenGL, or a system library is missing; no game was started.
pub fn open(opening: WindowOptions) -> Result<(), WindowError> {
    crate::platform::memory::return_freed_blocks();
    let mut app = App::new(opening.services);
    let can_be_transparent = crate::platform::desktop::can_be_transparent();
    app.pad_window.can_be_transparent = can_be_transparent;
    let size = app.comfort.preferences.size.unwrap_or(SIZE);
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("gelpad")
            .with_app_id("gelpad")
            .with_inner_size(size)
            .with_min_inner_size(MIN_SIZE)
            // For the pad window: all windows share the configuration of OpenGL. This one stays opaque.
            .with_transparent(can_be_transparent),
        // Half of the time of a software renderer, for gradients that the window does not have.
        dithering: false,
        ..Default::default()
    };
    // winit and glutin panic when a system library is missing.
    let opened = quiet_panics::catch(|quiet| {
        eframe::run_native(
            "gelpad",
            options,
            Box::new(move |creation| {
                quiet.restore();
                prepare_context(&creation.egui_ctx);
                app.start_waker(&creation.egui_ctx)?;
                app.play(opening.arguments.apply(app.last_game()));
                Ok(Box::new(Window {
                    app,
                    interrupted: opening.interrupted,
                    repaints: RepaintCounter::default(),
                    size: None,
                }))
            }),
        )
    });
    let error = match opened {
        Ok(Ok(())) => return Ok(()),
        Ok(Err(error)) => error.to_string(),
        Err(panic_message) => panic_message,
    };
    let one_line = error.split_whitespace().collect::<Vec<_>>().join(" ");
    Err(WindowError(one_line))
}

/// The application in eframe's window.
struct Window {
    app: App,
    interrupted: Box<dyn Fn() -> bool>,
    repaints: RepaintCounter,
    /// Size of the window, points.
    size: Option<egui::Vec2>,
}

/// Logs repaints per second; `scripts/window-cost.sh` reads the log.
#[derive(Default)]
struct RepaintCounter {
    since_s: f64,
    count: u32,
    plays: bool,
}

impl RepaintCounter {
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
            self.app.closing.forced = true;
            ctx.send_viewport_cmd(egui::ViewportCommand::Close);
        }
        self.app.poll(ctx);
    }

    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        let inner = ui.ctx().input(|input| input.viewport().inner_rect);
        self.size = inner.map(|inner| inner.size()).or(self.size);
        self.app.ui(ui);
        let plays = self.app.playing.view.frames > 0;
        self.repaints.count(ui.ctx().time(), plays);
    }

    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        theme::palette(visuals.dark_mode)
            .ground
            .to_normalized_gamma_f32()
    }

    fn on_exit(&mut self, _: Option<&eframe::glow::Context>) {
        self.app.close(self.size);
    }
}
