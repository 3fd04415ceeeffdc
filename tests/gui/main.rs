//! The window without a display: controls are found by role and label, as a screen reader finds them, and used.
//! `scripts/see-window.sh` takes pictures of the window.
#![cfg(feature = "gui")]

mod comfort;
mod edit;
mod edit_bindings;
mod edit_files;
mod edit_text;
mod names;
mod play;
mod record;
mod restart;
mod services;
mod set_up;
mod set_up_presses;
mod signals;
mod views;
mod walks;

use std::sync::Arc;

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable as _;
use egui_kittest::{Harness, Node};
use gelpad::gui::{App, Tab};

use crate::services::TestServices;

pub const WIDE: [f32; 2] = [1280.0, 800.0];
pub const SMALL: [f32; 2] = [800.0, 500.0];

/// The window under test with its services.
pub struct Stage {
    pub window: Harness<'static, App>,
    pub services: Arc<TestServices>,
}

impl Stage {
    /// A window of `size` that shows `tab`.
    pub fn with_view(tab: Tab, size: [f32; 2]) -> Self {
        Self::with_services(Arc::new(TestServices::new()), tab, size)
    }

    /// The same with prepared services.
    pub fn with_services(services: Arc<TestServices>, tab: Tab, size: [f32; 2]) -> Self {
        let mut app =
            App::new(Arc::clone(&services) as Arc<dyn gelpad::app::services::AppServices>);
        app.tab = tab;
        let mut window = Harness::builder()
            .with_size(size)
            .with_context_setup(gelpad::gui::prepare_context)
            .build_ui_state(|ui, app: &mut App| app.ui(ui), app);
        window.run_steps(3);
        Self { window, services }
    }

    pub fn app(&mut self) -> &mut App {
        self.window.state_mut()
    }

    /// Changes the view of the game, as the next frame would, and repaints.
    pub fn update_view(&mut self, change: impl FnOnce(&mut gelpad::runtime::View)) {
        self.update_view_once(change);
        self.steps(1);
    }

    /// The same with a single repaint.
    pub fn update_view_once(&mut self, change: impl FnOnce(&mut gelpad::runtime::View)) {
        let playing = &mut self.app().playing;
        change(&mut playing.view);
        playing.view.frames += 1;
        playing.view.t_ns += 10_000_000;
        playing.record_view();
        self.steps(1);
    }

    pub fn steps(&mut self, steps: usize) {
        self.window.run_steps(steps);
    }

    /// Whether there is exactly this label.
    pub fn has_label(&self, label: &str) -> bool {
        self.window.query_all_by_label(label).next().is_some()
    }

    /// Whether a label contains this text.
    pub fn shows(&self, text: &str) -> bool {
        self.window
            .query_all_by_label_contains(text)
            .next()
            .is_some()
    }

    /// Clicks the control of a role and a label.
    pub fn click(&mut self, role: Role, label: &str) {
        self.window.get_by_role_and_label(role, label).click();
        self.wait_for_start();
    }

    /// Repaints until the requested game has started or failed, 20 s at most.
    pub fn wait_for_start(&mut self) {
        self.steps(3);
        for _ in 0..4000 {
            if !self.app().is_starting() {
                return;
            }
            std::thread::sleep(std::time::Duration::from_millis(5));
            self.steps(1);
        }
    }

    /// Repaints until something is so, 30 s at most.
    pub fn wait_until(&mut self, is_so: impl Fn(&mut Self) -> bool) {
        for _ in 0..1500 {
            if is_so(self) {
                return;
            }
            std::thread::sleep(std::time::Duration::from_millis(20));
            self.steps(1);
        }
        panic!("not within 30 s");
    }

    pub fn button(&mut self, label: &str) {
        self.click(Role::Button, label);
    }

    /// The pad.
    pub fn canvas(&self) -> Node<'_> {
        self.window.get_by_role(Role::Canvas)
    }

    /// Presses and releases a key.
    pub fn key(&mut self, key: egui::Key) {
        self.window.key_press(key);
        self.steps(2);
    }

    /// The colour of the first letter of a text that was painted.
    pub fn colour_of(&self, text: &str) -> Option<egui::Color32> {
        let shapes = self.window.output().shapes.iter();
        shapes
            .filter_map(|clipped| match &clipped.shape {
                egui::Shape::Text(painted) => Some(painted),
                _ => None,
            })
            .find(|painted| painted.galley.text().starts_with(text))
            .map(|painted| painted.galley.job.sections[0].format.color)
    }

    /// The enabled button of this label.
    pub fn button_rect(&self, label: &str) -> egui::Rect {
        self.window
            .get_by_role_and_label(Role::Button, label)
            .rect()
    }

    /// Presses Tab until the control of this label has the focus; returns whether it was reached.
    pub fn tab_to(&mut self, label: &str) -> bool {
        for _ in 0..120 {
            self.key(egui::Key::Tab);
            let found = self
                .window
                .query_all_by_label(label)
                .any(|node| node.is_focused());
            if found {
                return true;
            }
        }
        false
    }
}

/// Test threads are not the main thread, where winit opens windows only: it panics before it needs a display.
#[test]
fn a_window_that_does_not_open_restores_the_panic_hook() {
    use std::sync::atomic::{AtomicUsize, Ordering};
    let count = Arc::new(AtomicUsize::new(0));
    let (counter, thread) = (Arc::clone(&count), std::thread::current().id());
    let previous = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if std::thread::current().id() == thread {
            counter.fetch_add(1, Ordering::Relaxed);
        } else {
            previous(info);
        }
    }));
    let opened = gelpad::gui::open(gelpad::gui::WindowOptions {
        services: Arc::new(TestServices::new()),
        arguments: gelpad::app::services::WindowArguments::default(),
        interrupted: Box::new(|| false),
    });
    assert!(opened.is_err());
    assert_eq!(count.load(Ordering::Relaxed), 0, "the failure is silent");
    let _ = std::panic::catch_unwind(|| panic!("counted"));
    assert_eq!(
        count.load(Ordering::Relaxed),
        1,
        "panics are reported again"
    );
}
