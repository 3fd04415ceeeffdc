//! The window by its labels: every view's controls are found as a screen reader finds them, and exercised. Nothing is drawn on
//! a screen here; pictures are compared by `scripts/see-window.sh`.
#![cfg(feature = "gui")]

mod comfort;
mod desk;
mod edit;
mod play;
mod record;
mod set_up;
mod signals;
mod views;

use std::sync::Arc;

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable as _;
use egui_kittest::{Harness, Node};
use gelpad::gui::{App, Tab};

use crate::desk::TestDesk;

pub const WIDE: [f32; 2] = [1280.0, 800.0];
pub const SMALL: [f32; 2] = [800.0, 500.0];

/// The window on a stage.
pub struct Stage {
    pub window: Harness<'static, App>,
    pub desk: Arc<TestDesk>,
}

impl Stage {
    /// The window of a size, showing a view.
    pub fn of(tab: Tab, size: [f32; 2]) -> Self {
        Self::on(Arc::new(TestDesk::new()), tab, size)
    }

    /// The same with a desk that has been laid out.
    pub fn on(desk: Arc<TestDesk>, tab: Tab, size: [f32; 2]) -> Self {
        let mut app = App::new(Arc::clone(&desk) as Arc<dyn gelpad::gui::desk::Desk>);
        app.tab = tab;
        let mut window = Harness::builder()
            .with_size(size)
            .with_context_setup(gelpad::gui::theme::fonts)
            .build_ui_state(|ui, app: &mut App| app.ui(ui), app);
        window.run_steps(3);
        Self { window, desk }
    }

    pub fn app(&mut self) -> &mut App {
        self.window.state_mut()
    }

    /// Changes what the game shows, as a newer view would.
    pub fn see(&mut self, change: impl FnOnce(&mut gelpad::runtime::View)) {
        let playing = &mut self.app().playing;
        change(&mut playing.view);
        playing.view.frames += 1;
        playing.view.t_ns += 10_000_000;
        playing.take_view();
        self.steps(2);
    }

    /// The same without more than one painting.
    pub fn quick(&mut self, change: impl FnOnce(&mut gelpad::runtime::View)) {
        let playing = &mut self.app().playing;
        change(&mut playing.view);
        playing.view.frames += 1;
        playing.view.t_ns += 10_000_000;
        playing.take_view();
        self.steps(1);
    }

    pub fn steps(&mut self, steps: usize) {
        self.window.run_steps(steps);
    }

    /// Whether something has this label.
    pub fn has(&self, label: &str) -> bool {
        self.window.query_all_by_label(label).next().is_some()
    }

    /// Whether something's label holds these words.
    pub fn tells(&self, words: &str) -> bool {
        self.window
            .query_all_by_label_contains(words)
            .next()
            .is_some()
    }

    /// Clicks what has a role and a label.
    pub fn click(&mut self, role: Role, label: &str) {
        self.window.get_by_role_and_label(role, label).click();
        self.settle();
    }

    /// Goes on until a game that was asked for has started, or not.
    pub fn settle(&mut self) {
        self.steps(3);
        for _ in 0..400 {
            if !self.app().is_starting() {
                return;
            }
            std::thread::sleep(std::time::Duration::from_millis(5));
            self.steps(1);
        }
    }

    pub fn button(&mut self, label: &str) {
        self.click(Role::Button, label);
    }

    /// What has a label that begins so.
    pub fn canvas(&self) -> Node<'_> {
        self.window.get_by_role(Role::Canvas)
    }

    /// Presses a key for a moment.
    pub fn key(&mut self, key: egui::Key) {
        self.window.key_press(key);
        self.steps(2);
    }

    /// Goes on with Tab until what is focused has this label; false if it never does.
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
