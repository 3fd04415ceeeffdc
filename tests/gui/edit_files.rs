//! The editor's files: read, watched, saved, copied, renamed and deleted.

use std::path::PathBuf;

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable as _;
use gelpad::gui::Tab;
use gelpad::profile::shipped_profile;

use crate::edit::{contains, diff, drag, stage, wait_until};
use crate::{Stage, WIDE};

/// A profile in the player's own folder.
fn own_profile(stage: &Stage, name: &str) -> PathBuf {
    let folder = stage.services.folder.path();
    folder.join(format!("profiles/{name}.toml"))
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
