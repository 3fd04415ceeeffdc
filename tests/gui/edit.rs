//! The view to edit in: what it writes, and what it leaves alone.

use std::path::PathBuf;

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable as _;
use gelpad::gui::Tab;
use gelpad::gui::edit::Learning;
use gelpad::gui::still::touch;
use gelpad::profile::shipped_profile;

use crate::{Stage, WIDE};

/// The editor on a file of one's own.
fn stage() -> (Stage, PathBuf) {
    let mut stage = Stage::of(Tab::Edit, WIDE);
    let path = stage.desk.own_profile("super-mario");
    stage.app().playing.choice.profile = path.display().to_string();
    stage.steps(3);
    (stage, path)
}

/// Lines of the file that differ from the shipped text: line number, old, new.
fn diff(path: &PathBuf) -> Vec<(usize, String, String)> {
    let before = shipped_profile("super-mario").expect("shipped").toml;
    let after = std::fs::read_to_string(path).expect("a file");
    assert_eq!(
        before.lines().count(),
        after.lines().count(),
        "no line comes or goes"
    );
    before
        .lines()
        .zip(after.lines())
        .enumerate()
        .filter(|(_, (a, b))| a != b)
        .map(|(line, (a, b))| (line + 1, a.to_owned(), b.to_owned()))
        .collect()
}

/// A place on the pad's picture, in shares from the bottom-left.
fn at(stage: &Stage, x: f32, y: f32) -> egui::Pos2 {
    let rect = stage.canvas().rect();
    egui::pos2(
        rect.left() + rect.width() * x,
        rect.bottom() - rect.height() * y,
    )
}

fn drag(stage: &mut Stage, from: (f32, f32), to: (f32, f32)) {
    let start = at(stage, from.0, from.1);
    let end = at(stage, to.0, to.1);
    stage.window.drag_at(start);
    stage.steps(1);
    for step in 1..=4 {
        stage
            .window
            .hover_at(start + (end - start) * step as f32 / 4.0);
        stage.steps(1);
    }
    stage.window.drop_at(end);
    stage.steps(3);
}

/// One line differs, so.
fn assert_one_line(path: &PathBuf, old: &str, new: &str) {
    let diff = diff(path);
    let [(_, was, is)] = diff.as_slice() else {
        panic!("{diff:?}");
    };
    assert_eq!((was.as_str(), is.as_str()), (old, new));
}

#[test]
fn moving_a_region_changes_the_file_at_that_value_alone() {
    let (mut stage, path) = stage();
    // `jump` is at x = 0.62, y = 0.20, 0.38 wide, 0.64 high: to the left by a tenth.
    drag(&mut stage, (0.80, 0.50), (0.70, 0.50));
    stage.button("Save");
    let diff = diff(&path);
    let [(_, old, new)] = diff.as_slice() else {
        panic!("{diff:?}");
    };
    assert_eq!(old, "x = 0.62");
    let x: f64 = new
        .strip_prefix("x = ")
        .expect("x")
        .parse()
        .expect("a number");
    assert!((x - 0.52).abs() < 0.01, "{x}");
}

#[test]
fn dragging_an_edge_changes_the_width_alone() {
    let (mut stage, path) = stage();
    // The right edge of `left`: x = 0.02, w = 0.22.
    drag(&mut stage, (0.238, 0.57), (0.198, 0.57));
    stage.button("Save");
    let diff = diff(&path);
    let [(_, old, new)] = diff.as_slice() else {
        panic!("{diff:?}");
    };
    assert_eq!(old, "w = 0.22");
    assert!(new.starts_with("w = 0.1"), "{new}");
}

#[test]
fn nothing_is_written_before_it_is_saved() {
    let (mut stage, path) = stage();
    drag(&mut stage, (0.80, 0.50), (0.70, 0.50));
    assert!(stage.tells("not saved"));
    assert!(diff(&path).is_empty());
}

#[test]
fn a_drag_is_undone_and_done_again_in_one_step_each() {
    let (mut stage, _) = stage();
    let text = |stage: &mut Stage| stage.app().edit.text().expect("a text");
    let before = text(&mut stage);
    drag(&mut stage, (0.80, 0.50), (0.70, 0.50));
    let after = text(&mut stage);
    assert_ne!(before, after);
    stage.button("⟲ Undo");
    assert_eq!(text(&mut stage), before);
    stage.button("⟳ Redo");
    assert_eq!(text(&mut stage), after);
}

#[test]
fn undo_and_save_have_keys() {
    let (mut stage, path) = stage();
    drag(&mut stage, (0.80, 0.50), (0.70, 0.50));
    let command = egui::Modifiers::COMMAND;
    stage.window.key_press_modifiers(command, egui::Key::Z);
    stage.steps(3);
    assert!(!stage.app().edit.is_unsaved());
    drag(&mut stage, (0.80, 0.50), (0.70, 0.50));
    stage.window.key_press_modifiers(command, egui::Key::S);
    stage.steps(3);
    assert_eq!(diff(&path).len(), 1);
}

#[test]
fn a_shipped_profile_is_saved_as_a_copy_that_is_played() {
    let mut stage = Stage::of(Tab::Edit, WIDE);
    assert!(stage.tells("saving makes a copy"));
    drag(&mut stage, (0.80, 0.50), (0.70, 0.50));
    stage.button("Save my copy");
    let path = stage.desk.folder.path().join("profiles/super-mario.toml");
    assert_eq!(diff(&path).len(), 1);
    let played = stage.desk.last().expect("a start").profile;
    assert_eq!(played, path.display().to_string());
}

#[test]
fn press_here_then_the_key_binds_it() {
    let (mut stage, path) = stage();
    stage.button("Bind: press here, then the key");
    assert_eq!(stage.app().edit.learning, Learning::Region);
    stage.see(|view| view.touches = vec![touch(1, [80.0, 50.0], 0.5)]);
    assert!(
        stage.tells("now press the key for `jump`"),
        "{:?}",
        stage.window
    );
    stage.see(|view| view.touches.clear());
    stage.key(egui::Key::Space);
    assert_eq!(stage.app().edit.learning, Learning::No);
    stage.button("Save");
    assert_one_line(&path, "output = \"$a\"", "output = \"key:space\"");
}

#[test]
fn a_threshold_is_set_by_its_slider_and_its_comment_stays() {
    let (mut stage, path) = stage();
    stage
        .window
        .get_by_role_and_label(Role::Slider, "Shortest press")
        .set_value_accesskit(60.0);
    stage.steps(3);
    stage.button("Save");
    assert_one_line(&path, "min_hold_ms = 34", "min_hold_ms = 60");
}

#[test]
fn a_threshold_that_was_not_there_is_added_and_holds() {
    let (mut stage, path) = stage();
    stage
        .window
        .get_by_role_and_label(Role::Slider, "Re-press ignored for")
        .set_value_accesskit(120.0);
    stage.steps(3);
    stage.button("Save");
    let text = std::fs::read_to_string(&path).expect("a file");
    let profile = gelpad::profile::Profile::from_toml("p", &text).expect("sound");
    assert_eq!(profile.settings.bounce_keys_ns, 120_000_000);
}

#[test]
fn what_is_wrong_with_an_output_is_told_at_its_field() {
    let (mut stage, path) = stage();
    stage.app().edit.choose("jump");
    stage.steps(2);
    stage
        .window
        .get_by_role_and_label(Role::TextInput, "presses")
        .focus();
    stage.steps(2);
    stage
        .window
        .key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    stage
        .window
        .event(egui::Event::Text("key:spcae".to_owned()));
    stage.steps(3);
    assert!(stage.tells("did you mean `space`?"), "{:?}", stage.window);
    assert!(diff(&path).is_empty());
}

#[test]
fn a_new_region_is_added_and_chosen() {
    let (mut stage, _) = stage();
    stage.button("+ New");
    assert_eq!(stage.app().edit.chosen.as_deref(), Some("region-1"));
    let text = stage.app().edit.text().expect("a text");
    assert!(text.contains("name = \"region-1\""));
}

#[test]
fn numbers_move_a_region_without_a_mouse() {
    let (mut stage, path) = stage();
    stage.app().edit.choose("jump");
    stage.steps(2);
    stage
        .window
        .get_by_label("x of jump, percent of the pad")
        .set_value_accesskit(60.0);
    stage.steps(3);
    stage.button("Save");
    let diff = diff(&path);
    let [(_, _, new)] = diff.as_slice() else {
        panic!("{diff:?}");
    };
    assert_eq!(new, "x = 0.6");
}

#[test]
fn what_is_saved_elsewhere_comes_in() {
    let (mut stage, path) = stage();
    let text = std::fs::read_to_string(&path).expect("a file");
    std::fs::write(&path, text.replace("x = 0.62", "x = 0.60")).expect("written");
    // The file is looked at twice a second, by the window's time.
    stage.steps(60);
    let text = stage.app().edit.text().expect("a text");
    assert!(text.contains("x = 0.60"));
    assert!(!stage.app().edit.is_unsaved());
}

#[test]
fn changes_on_both_sides_are_told_and_none_is_lost() {
    let (mut stage, path) = stage();
    drag(&mut stage, (0.80, 0.50), (0.70, 0.50));
    let text = std::fs::read_to_string(&path).expect("a file");
    std::fs::write(&path, text.replace("min_gap_ms = 34", "min_gap_ms = 50")).expect("written");
    stage.steps(60);
    assert!(stage.tells("changed elsewhere"));
    assert!(stage.app().edit.is_unsaved());
}

#[test]
fn a_mistake_in_the_file_is_told_with_its_line() {
    let (mut stage, path) = stage();
    let text = std::fs::read_to_string(&path).expect("a file");
    std::fs::write(&path, text.replace("min_hold_ms = 34", "min_hold_ms = -1")).expect("written");
    stage.steps(60);
    let line = text.lines().position(|line| line == "min_hold_ms = 34");
    let told = format!("line {}", line.expect("a line") + 1);
    assert!(stage.tells(&told), "{told}: {:?}", stage.window);
}
