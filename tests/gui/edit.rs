//! The editor: which lines of the file it changes, and how it loads files.

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
fn contains(stage: &mut Stage, line: &str) -> bool {
    let text = stage.app().edit.text();
    text.is_some_and(|text| text.contains(line))
}

/// Lines of the file that differ from the shipped text: number, old, new.
fn diff(path: &PathBuf) -> Vec<(usize, String, String)> {
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
fn a_shipped_profile_is_saved_as_a_copy_that_is_played() {
    let mut stage = Stage::with_view(Tab::Edit, WIDE);
    assert!(stage.shows("saving makes your own copy"));
    drag(&mut stage, (0.80, 0.50), (0.70, 0.50));
    stage.button("Save my copy");
    let path = own_profile(&stage, "my-super-mario");
    let names: Vec<String> = diff(&path).into_iter().map(|(_, _, new)| new).collect();
    assert_eq!(names.len(), 2, "{names:?}");
    assert_eq!(names[0], "name = \"my-super-mario\"");
    let played = stage.services.last_request().expect("a start").profile;
    assert_eq!(played, path.display().to_string());
    stage.button("Undo");
    let undone = stage.app().edit.text().expect("a text");
    let shipped = shipped_profile("super-mario").expect("shipped").toml;
    let renamed = shipped.replacen("name = \"super-mario\"", "name = \"my-super-mario\"", 1);
    assert_eq!(undone, renamed, "changes from before saving can be undone");
}

/// A profile in the player's own folder.
fn own_profile(stage: &Stage, name: &str) -> PathBuf {
    let folder = stage.services.folder.path();
    folder.join(format!("profiles/{name}.toml"))
}

#[test]
fn saving_a_copy_replaces_no_other_copy() {
    let mut stage = Stage::with_view(Tab::Edit, WIDE);
    let first = own_profile(&stage, "my-super-mario");
    std::fs::create_dir_all(first.parent().expect("a folder")).expect("a folder");
    std::fs::write(&first, "# mine").expect("written");
    drag(&mut stage, (0.80, 0.50), (0.70, 0.50));
    stage.button("Save my copy");
    assert_eq!(std::fs::read_to_string(&first).expect("a file"), "# mine");
    assert!(own_profile(&stage, "my-super-mario-2").exists());
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
fn unsaved_changes_are_kept_when_another_profile_is_chosen() {
    let mut stage = Stage::with_view(Tab::Edit, WIDE);
    drag(&mut stage, (0.80, 0.50), (0.70, 0.50));
    let changed = stage.app().edit.text();
    stage.app().playing.request.profile = "racing".to_owned();
    stage.steps(3);
    assert!(!stage.app().edit.is_unsaved());
    assert!(
        stage.shows("Also not saved: super-mario"),
        "{:?}",
        stage.window
    );
    stage.app().playing.request.profile = "super-mario".to_owned();
    stage.steps(3);
    assert_eq!(stage.app().edit.text(), changed);
    assert!(stage.app().edit.is_unsaved());
}

/// Asks the window to close, as its close button does; returns whether it may.
fn close(stage: &mut Stage) -> bool {
    let input = stage.window.input_mut();
    let root = input.viewports.entry(egui::ViewportId::ROOT).or_default();
    root.events.push(egui::ViewportEvent::Close);
    stage.window.step();
    let input = stage.window.input_mut();
    let root = input.viewports.entry(egui::ViewportId::ROOT).or_default();
    root.events.clear();
    let commands = &stage.window.output().viewport_output[&egui::ViewportId::ROOT].commands;
    let is_held_back = commands.contains(&egui::ViewportCommand::CancelClose);
    stage.steps(2);
    !is_held_back
}

#[test]
fn closing_asks_about_unsaved_changes() {
    let (mut stage, path) = stage();
    assert!(close(&mut stage), "nothing to save");
    drag(&mut stage, (0.80, 0.50), (0.70, 0.50));
    assert!(!close(&mut stage));
    assert!(stage.shows("Not saved: mine"), "{:?}", stage.window);
    stage.button("Keep editing");
    assert!(!stage.shows("Not saved: mine"));
    assert!(!close(&mut stage));
    stage.button("Save and close");
    assert_eq!(diff(&path).len(), 1);
    assert!(close(&mut stage));
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
fn changes_by_another_program_are_loaded() {
    let (mut stage, path) = stage();
    let text = std::fs::read_to_string(&path).expect("a file");
    std::fs::write(&path, text.replace("x = 0.62", "x = 0.60")).expect("written");
    wait_until(&mut stage, |stage| contains(stage, "x = 0.60"));
    assert!(!stage.app().edit.is_unsaved());
}

#[test]
fn conflicting_changes_are_reported_and_kept() {
    let (mut stage, path) = stage();
    drag(&mut stage, (0.80, 0.50), (0.70, 0.50));
    let text = std::fs::read_to_string(&path).expect("a file");
    std::fs::write(&path, text.replace("min_gap_ms = 34", "min_gap_ms = 50")).expect("written");
    wait_until(&mut stage, |stage| {
        stage.shows("changed by another program")
    });
    assert!(stage.app().edit.is_unsaved());
}

#[test]
fn a_mistake_in_the_file_is_reported_with_its_line() {
    let (mut stage, path) = stage();
    let text = std::fs::read_to_string(&path).expect("a file");
    std::fs::write(&path, text.replace("min_hold_ms = 34", "min_hold_ms = -1")).expect("written");
    wait_until(&mut stage, |stage| contains(stage, "min_hold_ms = -1"));
    let line = text.lines().position(|line| line == "min_hold_ms = 34");
    let number = format!("line {}", line.expect("a line") + 1);
    assert!(stage.shows(&number), "{number}: {:?}", stage.window);
}

/// A named pipe that nobody writes to blocks its reader, as a hung network share does.
#[test]
fn a_file_that_hangs_does_not_freeze_the_window() {
    let mut stage = Stage::with_view(Tab::Edit, WIDE);
    let path = stage.services.folder.path().join("hung.toml");
    let made = std::process::Command::new("mkfifo").arg(&path).status();
    assert!(made.expect("mkfifo").success());
    stage.app().playing.request.profile = path.display().to_string();
    stage.steps(30);
    assert!(stage.shows("Opening"), "{:?}", stage.window);
    assert!(stage.app().edit.text().is_none());
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

#[test]
fn unsaved_changes_go_along_with_a_new_name_and_into_a_duplicate() {
    let (mut stage, path) = stage();
    stage.app().edit.select_region("jump");
    stage.steps(2);
    stage.button("Choose …");
    stage.steps(10);
    stage.button("key space");
    assert!(stage.shows("not saved"));
    let before = std::fs::read_to_string(&path).expect("a file");
    stage.button("Duplicate");
    let copy = path.with_file_name("mine-2.toml");
    let text = std::fs::read_to_string(&copy).expect("a file");
    assert!(text.contains("output = \"key:space\""), "{text}");
    assert_eq!(std::fs::read_to_string(&path).expect("a file"), before);
    // Back to the first one, which is still not saved.
    let mut request = stage.services.last_request().expect("a start");
    request.profile = path.display().to_string();
    stage.app().play(request);
    stage.wait_for_start();
    stage.steps(4);
    assert!(stage.shows("not saved"));
    stage.button("Rename");
    stage.steps(10);
    stage.window.event(egui::Event::Text("other".to_owned()));
    stage.steps(2);
    stage.key(egui::Key::Enter);
    stage.wait_for_start();
    stage.steps(4);
    let other = path.with_file_name("other.toml");
    assert!(other.exists() && !path.exists());
    assert!(stage.shows("not saved"), "{:?}", stage.window);
    stage.button("Save");
    let text = std::fs::read_to_string(&other).expect("a file");
    assert!(text.contains("output = \"key:space\""), "{text}");
    assert!(text.contains("name = \"other\""), "{text}");
}

#[test]
fn an_own_profile_is_renamed_duplicated_and_deleted() {
    let (mut stage, path) = stage();
    stage.button("Duplicate");
    let copy = path.with_file_name("mine-2.toml");
    assert!(copy.exists());
    let played = |stage: &Stage| stage.services.last_request().expect("a start").profile;
    assert_eq!(played(&stage), copy.display().to_string());
    wait_until(&mut stage, |stage| contains(stage, "name = \"mine-2\""));
    stage.button("Delete");
    assert!(stage.shows("mine-2.toml cannot be restored"));
    let delete = stage
        .window
        .get_all_by_role_and_label(Role::Button, "Delete");
    delete.last().expect("the dialog's").click();
    stage.wait_for_start();
    assert!(!copy.exists());
    assert_eq!(played(&stage), "super-mario");
}
