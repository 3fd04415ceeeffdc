//! The editor: which lines of the file it changes.

use std::path::PathBuf;

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable as _;
use gelpad::gui::Tab;
use gelpad::gui::edit::BindStep;
use gelpad::gui::still::touch;
use gelpad::profile::shipped_profile;

use crate::{Stage, WIDE};

/// The editor with a user's file open.
pub fn stage() -> (Stage, PathBuf) {
    let mut stage = Stage::with_view(Tab::Edit, WIDE);
    let path = stage.services.copy_profile("super-mario");
    stage.app().playing.request.profile = path.display().to_string();
    wait_until(&mut stage, |stage| stage.app().edit.text().is_some());
    (stage, path)
}

/// Repaints until something is so: files are read on another thread.
pub fn wait_until(stage: &mut Stage, mut is_so: impl FnMut(&mut Stage) -> bool) {
    for _ in 0..1000 {
        stage.steps(1);
        if is_so(stage) {
            stage.steps(2);
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    panic!("not within 5 s: {:?}", stage.window);
}

/// Whether the edited text contains a line.
pub fn contains(stage: &mut Stage, line: &str) -> bool {
    let text = stage.app().edit.text();
    text.is_some_and(|text| text.contains(line))
}

/// Lines of the file that differ from the shipped text: number, old, new.
pub fn diff(path: &PathBuf) -> Vec<(usize, String, String)> {
    let before = shipped_profile("super-mario").expect("shipped").toml;
    let after = std::fs::read_to_string(path).expect("a file");
    assert_eq!(
        before.lines().count(),
        after.lines().count(),
        "the number of lines stays"
    );
    before
        .lines()
        .zip(after.lines())
        .enumerate()
        .filter(|(_, (a, b))| a != b)
        .map(|(line, (a, b))| (line + 1, a.to_owned(), b.to_owned()))
        .collect()
}

/// A point of the pad's picture, as fractions from the bottom left.
fn at(stage: &Stage, x: f32, y: f32) -> egui::Pos2 {
    let rect = stage.canvas().rect();
    egui::pos2(
        rect.left() + rect.width() * x,
        rect.bottom() - rect.height() * y,
    )
}

pub fn drag(stage: &mut Stage, from: (f32, f32), to: (f32, f32)) {
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

/// Exactly this line differs.
fn assert_one_line(path: &PathBuf, old: &str, new: &str) {
    let diff = diff(path);
    let [(_, was, is)] = diff.as_slice() else {
        panic!("{diff:?}");
    };
    assert_eq!((was.as_str(), is.as_str()), (old, new));
}

#[test]
fn moving_a_region_changes_only_its_position_in_the_file() {
    let (mut stage, path) = stage();
    // `jump` is at x = 0.62, y = 0.20 and 0.38 wide, 0.64 high: moved left by 0.1.
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
fn dragging_the_right_edge_changes_only_the_width() {
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
fn changes_are_not_written_before_saving() {
    let (mut stage, path) = stage();
    drag(&mut stage, (0.80, 0.50), (0.70, 0.50));
    assert!(stage.shows("not saved"));
    assert!(diff(&path).is_empty());
}

#[test]
fn a_drag_is_one_step_of_undo_and_redo() {
    let (mut stage, _) = stage();
    let text = |stage: &mut Stage| stage.app().edit.text().expect("a text");
    let before = text(&mut stage);
    drag(&mut stage, (0.80, 0.50), (0.70, 0.50));
    let after = text(&mut stage);
    assert_ne!(before, after);
    stage.button("Undo");
    assert_eq!(text(&mut stage), before);
    stage.button("Redo");
    assert_eq!(text(&mut stage), after);
}

#[test]
fn undo_and_save_have_keyboard_shortcuts() {
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
fn a_cell_of_a_grid_is_moved_after_the_grid_is_separated() {
    let mut stage = Stage::with_view(Tab::Edit, WIDE);
    stage.app().playing.request.profile = "large-buttons".to_owned();
    stage.steps(3);
    drag(&mut stage, (0.25, 0.75), (0.35, 0.65));
    assert!(!stage.app().edit.is_unsaved(), "nothing is broken");
    assert!(stage.shows("Separate the cells?"), "{:?}", stage.window);
    stage.button("Separate");
    assert!(stage.app().edit.is_unsaved());
    assert!(!stage.shows("error:"), "no mistakes: {:?}", stage.window);
    drag(&mut stage, (0.25, 0.75), (0.35, 0.65));
    assert!(!stage.shows("Separate the cells?"), "asked once");
    let text = stage.app().edit.text().expect("a text");
    let profile = gelpad::profile::Profile::from_toml("p", &text).expect("valid");
    let shapes: Vec<_> = profile
        .regions
        .iter()
        .map(|r| (&*r.name, &r.shape))
        .collect();
    let moved = gelpad::profile::Shape::Rect {
        x: 0.1,
        y: 0.4,
        w: 0.5,
        h: 0.5,
    };
    assert_eq!(shapes[0], ("buttons-1", &moved));
    assert_eq!(shapes.len(), 4);
}

#[test]
fn escape_cancels_binding() {
    let (mut stage, _) = stage();
    stage.button("Bind: press the pad, then a key");
    stage.key(egui::Key::Escape);
    assert_eq!(stage.app().edit.bind_step, BindStep::No);
    stage.button("Bind: press the pad, then a key");
    stage.update_view(|view| view.touches = vec![touch(1, [80.0, 50.0], 0.5)]);
    stage.key(egui::Key::Escape);
    assert_eq!(stage.app().edit.bind_step, BindStep::No);
    assert!(!stage.app().edit.is_unsaved(), "Esc is not bound");
}

#[test]
fn a_press_and_a_key_bind_a_region() {
    let (mut stage, path) = stage();
    stage.button("Bind: press the pad, then a key");
    assert_eq!(stage.app().edit.bind_step, BindStep::Region);
    stage.update_view(|view| view.touches = vec![touch(1, [80.0, 50.0], 0.5)]);
    assert!(
        stage.shows("now press the key for `jump`"),
        "{:?}",
        stage.window
    );
    stage.update_view(|view| view.touches.clear());
    stage.key(egui::Key::Space);
    assert_eq!(stage.app().edit.bind_step, BindStep::No);
    stage.button("Save");
    assert_one_line(&path, "output = \"$a\"", "output = \"key:space\"");
}

#[test]
fn a_slider_sets_a_timing_and_keeps_its_comment() {
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
fn a_slider_adds_a_missing_timing() {
    let (mut stage, path) = stage();
    stage
        .window
        .get_by_role_and_label(Role::Slider, "Bounce keys")
        .set_value_accesskit(120.0);
    stage.steps(3);
    stage.button("Save");
    let text = std::fs::read_to_string(&path).expect("a file");
    let profile = gelpad::profile::Profile::from_toml("p", &text).expect("valid");
    assert_eq!(profile.settings.bounce_keys_ns, 120_000_000);
}

/// Types a text into a field in place of what it holds.
pub fn replace_text(stage: &mut Stage, field: &str, text: &str) {
    stage
        .window
        .get_by_role_and_label(Role::TextInput, field)
        .focus();
    stage.steps(2);
    stage
        .window
        .key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    stage.window.event(egui::Event::Text(text.to_owned()));
    stage.steps(3);
}

#[test]
fn an_invalid_output_is_reported_at_its_field() {
    let (mut stage, path) = stage();
    stage.app().edit.select_region("jump");
    stage.steps(2);
    replace_text(&mut stage, "presses", "key:spcae");
    assert!(stage.shows("did you mean `space`?"), "{:?}", stage.window);
    assert!(diff(&path).is_empty());
    stage.key(egui::Key::Enter);
    let field = stage
        .window
        .get_by_role_and_label(Role::TextInput, "presses");
    assert!(field.is_focused(), "Tab goes on from here");
    // A change that could be saved must not discard the field.
    drag(&mut stage, (0.80, 0.50), (0.70, 0.50));
    stage.app().edit.select_region("jump");
    stage.steps(2);
    replace_text(&mut stage, "presses", "key:spcae");
    stage.button("Save");
    assert!(diff(&path).is_empty(), "nothing is saved");
    assert!(stage.shows("correct the red field"), "{:?}", stage.window);
    assert!(stage.shows("did you mean `space`?"), "{:?}", stage.window);
}

#[test]
fn a_new_region_is_added_and_selected() {
    let (mut stage, _) = stage();
    stage.button("+ New");
    assert_eq!(stage.app().edit.selected.as_deref(), Some("region-1"));
    let text = stage.app().edit.text().expect("a text");
    assert!(text.contains("name = \"region-1\""));
}

#[test]
fn number_fields_move_a_region() {
    let (mut stage, path) = stage();
    stage.app().edit.select_region("jump");
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
fn the_mouse_alone_chooses_a_key() {
    let (mut stage, path) = stage();
    stage.app().edit.select_region("jump");
    stage.steps(2);
    stage.button("Choose …");
    // The dialog grows to its size.
    stage.steps(10);
    stage.button("key space");
    stage.button("Save");
    assert_one_line(&path, "output = \"$a\"", "output = \"key:space\"");
}
