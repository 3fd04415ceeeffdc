//! Every view as a screen reader walks it: each control has a role and a name, the keyboard reaches all of them, each once, and from top
//! to bottom within a card.

use std::collections::BTreeMap;

use egui::accesskit::Role;
use egui_kittest::kittest::NodeT as _;
use gelpad::gui::Tab;
use gelpad::gui::setup::Step;

use crate::{Stage, WIDE};

/// Roles of controls that take the focus.
const CONTROLS: [Role; 9] = [
    Role::Button,
    Role::CheckBox,
    Role::RadioButton,
    Role::ComboBox,
    Role::Slider,
    Role::SpinButton,
    Role::TextInput,
    Role::Tab,
    Role::Canvas,
];

/// The views, and each step of the setup.
fn views() -> Vec<(String, Stage)> {
    let mut views = Vec::new();
    for tab in Tab::ALL {
        let mut stage = Stage::with_view(tab, WIDE);
        if tab == Tab::Edit {
            stage.app().edit.select_region("jump");
        }
        stage.steps(3);
        views.push((tab.name().to_owned(), stage));
    }
    for step in Step::ALL {
        let mut stage = Stage::with_view(Tab::SetUp, WIDE);
        stage.app().set_up.step = step;
        stage.steps(3);
        views.push((format!("Set up, {}", step.title()), stage));
    }
    views
}

/// Role and name of the enabled controls, each with the number of controls like it.
fn controls(stage: &Stage) -> BTreeMap<(String, String), usize> {
    let mut found = BTreeMap::new();
    for node in stage.window.root().children_recursive() {
        let node = node.accesskit_node();
        if !CONTROLS.contains(&node.role()) || node.is_disabled() || node.is_hidden() {
            continue;
        }
        let name = node.label().or_else(|| node.value()).unwrap_or_default();
        *found
            .entry((format!("{:?}", node.role()), name))
            .or_insert(0) += 1;
    }
    found
}

#[test]
fn every_control_has_a_name_with_letters() {
    for (view, stage) in views() {
        let controls = controls(&stage);
        assert!(controls.len() > 8, "{view}: {controls:?}");
        for (role, name) in controls.keys() {
            let has_letters = name.chars().any(char::is_alphanumeric);
            assert!(has_letters, "{view}: a {role} is called {name:?}");
        }
    }
}

#[test]
fn the_keyboard_reaches_every_control_and_comes_back() {
    for (view, mut stage) in views() {
        let wanted = controls(&stage);
        let total: usize = wanted.values().sum();
        let mut order = Vec::new();
        for _ in 0..2 * total + 20 {
            stage.key(egui::Key::Tab);
            let root = stage.window.root();
            let focused = root.children_recursive().find(|node| node.is_focused());
            let Some(focused) = focused else { continue };
            let id = focused.accesskit_node().id();
            if order.first() == Some(&id) {
                break;
            }
            assert!(
                !order.contains(&id),
                "{view}: the focus goes in a smaller circle"
            );
            order.push(id);
        }
        // Fields in closed parts and lists are not controls of the tree.
        let reached = order.len();
        assert!(reached * 10 >= total * 9, "{view}: {reached} of {total}");
    }
}
