//! Tests of every view: reachable, labelled for screen readers, no panic whatever happens to the game.

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable as _;
use gelpad::app::services::StartError;
use gelpad::gui::Tab;
use gelpad::gui::still::{self, touch};

use crate::{SMALL, Stage, WIDE};

macro_rules! every_view {
    ($($name:ident: $tab:expr, $has:expr;)+) => {$(
        mod $name {
            use super::*;

            #[test]
            fn opens_from_the_rail() {
                let mut stage = Stage::with_view(Tab::Play, WIDE);
                if $tab == Tab::Play {
                    stage.app().tab = Tab::Signals;
                }
                stage.click(Role::Tab, $tab.name());
                assert_eq!(stage.app().tab, $tab);
                assert!(stage.shows($has), "{:?}", stage.window);
            }

            #[test]
            fn labels_every_control() {
                for size in [WIDE, SMALL] {
                    let stage = Stage::with_view($tab, size);
                    stage.window.check_accessibility();
                }
            }

            #[test]
            fn survives_odd_views_broken_profiles_and_a_disconnected_board() {
                for size in [WIDE, SMALL, [640.0, 400.0]] {
                    survive($tab, size);
                }
            }

            #[test]
            fn is_drawn_in_the_light_theme_and_at_double_size() {
                let mut stage = Stage::with_view($tab, SMALL);
                stage.app().comfort.preferences.theme = egui::ThemePreference::Light;
                stage.steps(2);
                assert!(!stage.window.ctx.global_style().visuals.dark_mode);
                stage.app().comfort.preferences.text_scale = 2.0;
                stage.steps(4);
                assert!((stage.window.ctx.zoom_factor() - 2.0).abs() < 1e-3);
            }
        }
    )+};
}

every_view! {
    play: Tab::Play, "Trial";
    practice: Tab::Practice, "Practice level";
    edit: Tab::Edit, "Bind: press the pad";
    set_up: Tab::SetUp, "Orientation";
    record: Tab::Record, "No recording is open";
    signals: Tab::Signals, "Voltages";
    comfort: Tab::Comfort, "Text size";
}

fn survive(tab: Tab, size: [f32; 2]) {
    let mut stage = Stage::with_view(tab, size);
    // A frame of extreme and invalid values.
    stage.update_view(|view| {
        view.touches = (0..5)
            .map(|i| touch(i, [20.0 * i as f64, 99.9], 2.0))
            .collect();
        view.image.values.fill(f32::NAN);
        view.lost_electrodes = vec![0, 15];
        view.lost_frames = 3;
        view.signals.volts = vec![0.0; 208];
        view.signals.changes = vec![f32::INFINITY; 208];
        view.signals.explained = vec![0.0; 208];
        view.signals.reference = vec![0.0; 208];
        view.signals.noise = vec![f32::INFINITY; 208];
    });
    // Fewer channels than the pad has.
    stage.update_view(|view| view.signals.volts = vec![1.0; 3]);
    // A profile without regions.
    let mut empty = (*still::profile()).clone();
    empty.regions.clear();
    empty.bindings.clear();
    empty.outputs.clear();
    stage.update_view(|view| view.profile = std::sync::Arc::new(empty));
    // A broken profile on disk.
    let path = stage.services.folder.path().join("broken.toml");
    std::fs::write(&path, "schema = 1\nname = [[[").expect("written");
    stage.app().playing.request.profile = path.display().to_string();
    stage.steps(3);
    std::fs::write(&path, "schema = 1\nname = \"x\"\nbogus = 3\n").expect("written");
    stage.steps(3);
    // A round pad, disconnected.
    let round = gelpad::pad::shipped_pad("round-tank").expect("shipped");
    let round = gelpad::pad::Pad::from_toml("round", round.toml).expect("sound");
    let view = still::view_of_pad(&round, still::profile());
    stage.app().playing.pad = round;
    stage.app().playing.view = view;
    stage.update_view(|_| {});
    stage.app().playing.ended = Some("Pad disconnected: waiting for /dev/ttyACM0".to_owned());
    stage.app().failed = Some(StartError::of_game("nothing works"));
    stage.steps(3);
    let _ = stage.window.get_by_role_and_label(Role::Tab, tab.name());
}

#[test]
fn the_function_keys_show_the_views() {
    let mut stage = Stage::with_view(Tab::Play, WIDE);
    for (key, tab) in [
        (egui::Key::F3, Tab::Edit),
        (egui::Key::F7, Tab::Comfort),
        (egui::Key::F1, Tab::Play),
    ] {
        stage.key(key);
        assert_eq!(stage.app().tab, tab);
    }
}

#[test]
fn tab_and_enter_reach_another_view() {
    let mut stage = Stage::with_view(Tab::Play, WIDE);
    assert!(stage.tab_to("Signals"));
    stage.key(egui::Key::Enter);
    assert_eq!(stage.app().tab, Tab::Signals);
}

/// Every control lies within the window from left to right, whatever is long. (Views scroll from top to bottom.)
#[test]
fn long_names_push_no_control_off_the_window() {
    const LONG: &str = "a-very-long-name-of-a-profile-for-my-favourite-game-with-many-keys";
    let controls = [
        Role::Button,
        Role::CheckBox,
        Role::ComboBox,
        Role::RadioButton,
        Role::Slider,
        Role::SpinButton,
        Role::TextInput,
    ];
    for size in [[800.0, 600.0], WIDE] {
        for tab in Tab::ALL {
            let mut stage = Stage::with_view(tab, size);
            let path = stage.services.folder.path().join(format!("{LONG}.toml"));
            let mario = gelpad::profile::shipped_profile("super-mario").expect("shipped");
            std::fs::write(&path, mario.toml).expect("written");
            stage.app().playing.request.profile = path.display().to_string();
            for _ in 0..20 {
                stage.steps(1);
                std::thread::sleep(std::time::Duration::from_millis(10));
            }
            for node in controls
                .iter()
                .flat_map(|role| stage.window.query_all_by_role(*role))
            {
                let rect = node.rect();
                assert!(
                    rect.right() <= size[0] && rect.left() >= 0.0,
                    "{tab:?} at {size:?}: {rect:?} {node:?}"
                );
            }
        }
    }
}

/// Large text in a small window: 800 x 600 at 200 % has room for 400 x 300 points.
#[test]
fn every_view_can_be_reached_with_large_text_in_a_small_window() {
    for tab in gelpad::gui::Tab::ALL {
        let mut stage = Stage::with_view(tab, [400.0, 300.0]);
        stage.steps(3);
        if tab == gelpad::gui::Tab::Play {
            let pad = stage.canvas().rect();
            assert!(pad.width() > 120.0, "{pad:?}");
        }
        stage.key(egui::Key::F7);
        assert_eq!(stage.app().tab, gelpad::gui::Tab::Comfort);
    }
}

/// The same window: the list of views is complete, and nothing is cut at the right edge.
#[test]
fn large_text_in_a_small_window_cuts_nothing() {
    let tabs = [Tab::Play, Tab::Edit, Tab::SetUp, Tab::Signals, Tab::Comfort];
    for tab in tabs {
        let stage = Stage::with_view(tab, [400.0, 300.0]);
        for view in stage.window.query_all_by_role(Role::Tab) {
            let rect = view.rect();
            assert!(rect.bottom() <= 300.0 && rect.height() >= 24.0, "{rect:?}");
        }
        for role in [
            Role::Button,
            Role::ComboBox,
            Role::Slider,
            Role::RadioButton,
        ] {
            for control in stage.window.query_all_by_role(role) {
                let rect = control.rect();
                assert!(rect.right() <= 400.0, "{tab:?}: {rect:?} {control:?}");
            }
        }
    }
    let stage = Stage::with_view(Tab::Play, [400.0, 300.0]);
    let lists = stage
        .window
        .get_by_role_and_label(Role::ComboBox, "Profile");
    let pad = stage.canvas().rect();
    assert!(
        pad.bottom() < lists.rect().top() && pad.top() > 40.0,
        "{pad:?}"
    );
    let stage = Stage::with_view(Tab::SetUp, [400.0, 300.0]);
    for label in ["5 Personal settings", "7 Output", "Next"] {
        let rect = stage.button_rect(label);
        assert!(
            rect.bottom() <= 300.0 && rect.right() <= 400.0,
            "{label}: {rect:?}"
        );
    }
}
