//! What holds for every view: it is found, it has names for screen readers, and nothing that happens to a game makes it panic.

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable as _;
use gelpad::gui::Tab;
use gelpad::gui::still::{self, touch};

use crate::{SMALL, Stage, WIDE};

macro_rules! every_view {
    ($($name:ident: $tab:expr, $has:expr;)+) => {$(
        mod $name {
            use super::*;

            #[test]
            fn is_found_in_the_rail_by_its_word_and_shows_itself() {
                let mut stage = Stage::of(Tab::Play, WIDE);
                if $tab == Tab::Play {
                    stage.app().tab = Tab::Signals;
                }
                stage.click(Role::Tab, $tab.name());
                assert_eq!(stage.app().tab, $tab);
                assert!(stage.tells($has), "{:?}", stage.window);
            }

            #[test]
            fn has_a_name_for_everything_that_takes_input() {
                for size in [WIDE, SMALL] {
                    let stage = Stage::of($tab, size);
                    stage.window.check_accessibility();
                }
            }

            #[test]
            fn outlives_an_empty_pad_a_broken_profile_and_a_board_that_is_gone() {
                for size in [WIDE, SMALL, [640.0, 400.0]] {
                    survive($tab, size);
                }
            }

            #[test]
            fn is_painted_in_both_themes_and_with_text_twice_as_large() {
                let mut stage = Stage::of($tab, SMALL);
                stage.app().comfort.look.theme = egui::ThemePreference::Light;
                stage.steps(2);
                assert!(!stage.window.ctx.global_style().visuals.dark_mode);
                stage.app().comfort.look.text = 2.0;
                stage.steps(4);
                assert!((stage.window.ctx.zoom_factor() - 2.0).abs() < 1e-3);
            }
        }
    )+};
}

every_view! {
    play: Tab::Play, "A try-out";
    practice: Tab::Practice, "Practice level";
    edit: Tab::Edit, "Bind: press here";
    set_up: Tab::SetUp, "Which way round";
    record: Tab::Record, "No recording is open";
    signals: Tab::Signals, "Voltages";
    comfort: Tab::Feedback, "Size of text";
}

fn survive(tab: Tab, size: [f32; 2]) {
    let mut stage = Stage::of(tab, size);
    // Nothing was measured, then a frame of everything that can be odd.
    stage.see(|view| {
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
    // Readings of another number than the pad has.
    stage.see(|view| view.signals.volts = vec![1.0; 3]);
    // A profile without regions.
    let mut empty = (*still::profile()).clone();
    empty.regions.clear();
    empty.bindings.clear();
    empty.outputs.clear();
    stage.see(|view| view.profile = std::sync::Arc::new(empty));
    // A text that is broken on disk.
    let path = stage.desk.folder.path().join("broken.toml");
    std::fs::write(&path, "schema = 1\nname = [[[").expect("written");
    stage.app().playing.choice.profile = path.display().to_string();
    stage.steps(3);
    std::fs::write(&path, "schema = 1\nname = \"x\"\nbogus = 3\n").expect("written");
    stage.steps(3);
    // A round pad, and one that is gone.
    let round = gelpad::pad::shipped_pad("round-tank").expect("shipped");
    let round = gelpad::pad::Pad::from_toml("round", round.toml).expect("sound");
    let view = still::view_of(&round, still::profile());
    stage.app().playing.pad = round;
    stage.app().playing.view = view;
    stage.see(|_| {});
    stage.app().playing.ended = Some("/dev/ttyACM0: the board is gone".to_owned());
    stage.app().failed = Some("nothing works".to_owned());
    stage.steps(3);
    let _ = stage.window.get_by_role_and_label(Role::Tab, tab.name());
}

#[test]
fn the_function_keys_show_the_views() {
    let mut stage = Stage::of(Tab::Play, WIDE);
    for (key, tab) in [
        (egui::Key::F3, Tab::Edit),
        (egui::Key::F7, Tab::Feedback),
        (egui::Key::F1, Tab::Play),
    ] {
        stage.key(key);
        assert_eq!(stage.app().tab, tab);
    }
}

#[test]
fn tab_and_enter_reach_another_view() {
    let mut stage = Stage::of(Tab::Play, WIDE);
    assert!(stage.tab_to("Signals"));
    stage.key(egui::Key::Enter);
    assert_eq!(stage.app().tab, Tab::Signals);
}
