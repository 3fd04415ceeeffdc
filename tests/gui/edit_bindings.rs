//! The editor's cards: fields keep the focus while they are typed into, nothing moves, and every target is large enough.

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable as _;
use gelpad::gui::Tab;
use gelpad::gui::theme::{MIN_TARGET, palette};
use gelpad::profile::{Source, find_shipped};

use crate::edit::{stage, wait_until};
use crate::{Stage, WIDE};

/// The text of the edited profile.
fn text(stage: &mut Stage) -> String {
    stage.app().edit.text().expect("a text")
}

/// Opens the binding of `jump`.
fn open_binding(stage: &mut Stage) {
    stage.app().edit.select_region("jump");
    stage.steps(2);
    stage.window.get_by_label("press to $a").click_accesskit();
    stage.steps(20);
}

fn type_slowly(stage: &mut Stage, text: &str) {
    for letter in text.chars() {
        stage.window.event(egui::Event::Text(letter.to_string()));
        stage.steps(3);
    }
}

#[test]
fn a_binding_is_typed_slowly_into_its_field() {
    let (mut stage, _) = stage();
    open_binding(&mut stage);
    let field = stage
        .window
        .get_by_role_and_label(Role::TextInput, "output");
    field.focus();
    stage.steps(2);
    stage
        .window
        .key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    stage.steps(2);
    type_slowly(&mut stage, "k");
    assert!(
        stage.shows("error: line"),
        "invalid for now: {:?}",
        stage.window
    );
    type_slowly(&mut stage, "ey:k");
    assert!(text(&mut stage).contains("output = \"key:k\""));
    assert!(!stage.shows("error: line"), "{:?}", stage.window);
    // A second output: its comma stays while it is typed.
    type_slowly(&mut stage, ", key:l");
    let written = text(&mut stage);
    assert!(
        written.contains("output = [\"key:k\", \"key:l\"]"),
        "{written}"
    );
    let field = stage
        .window
        .get_by_role_and_label(Role::TextInput, "output");
    assert!(field.is_focused());
}

#[test]
fn choosing_a_key_replaces_the_one_of_a_held_binding() {
    let (mut stage, _) = stage();
    open_binding(&mut stage);
    stage.click(Role::ComboBox, "gesture");
    stage.window.get_by_label("hold").click_accesskit();
    stage.steps(4);
    let before = text(&mut stage).matches("[[binding]]").count();
    assert!(text(&mut stage).contains("gesture = \"hold\""));
    stage.button("Choose …");
    stage.steps(10);
    stage.button("key k");
    let after = text(&mut stage);
    assert_eq!(after.matches("[[binding]]").count(), before, "{after}");
    assert!(after.contains("output = \"key:k\""), "{after}");
    assert!(stage.shows("hold to key:k"), "{:?}", stage.window);
}

/// The editor with a profile of this text open, and a region selected.
fn stage_with(text: &str, region: &str) -> Stage {
    let mut stage = Stage::with_view(Tab::Edit, WIDE);
    let path = stage.services.copy_profile("super-mario");
    std::fs::write(&path, text).expect("written");
    stage.app().playing.request.profile = path.display().to_string();
    wait_until(&mut stage, |stage| stage.app().edit.text().is_some());
    stage.app().edit.select_region(region);
    stage.steps(2);
    stage
}

fn choose_k(stage: &mut Stage) -> String {
    stage.button("Choose …");
    stage.steps(10);
    stage.button("key k");
    assert!(!stage.shows("error:"), "{:?}", stage.window);
    text(stage)
}

#[test]
fn choosing_a_key_finds_the_binding_of_a_list_of_one_region() {
    let before = "schema = 1\nname = \"mine\"\n[[region]]\nname = \"jump\"\nshape = \"rect\"\nx = 0.1\ny = 0.1\nw = 0.3\nh = 0.3\n\
        [[binding]]\nregion = [\"jump\"]\ngesture = \"hold\"\noutput = \"key:a\"\n";
    let mut stage = stage_with(before, "jump");
    assert_eq!(choose_k(&mut stage), before.replace("key:a", "key:k"));
}

#[test]
fn choosing_a_key_overrides_the_gesture_of_the_base() {
    let own = "schema = 1\nname = \"mine\"\nextends = \"falling-blocks\"\n";
    let mut stage = stage_with(own, "strokes");
    let written = choose_k(&mut stage);
    let added = "[[binding]]\nregion = \"strokes\"\ngesture = \"swipe\"\ndirection = \"down\"\noutput = \"key:k\"\n";
    assert_eq!(written.replace(added, "").trim_end(), own.trim_end());
    let read = |name: &str, toml: &str| {
        let source = Source {
            name: name.to_owned(),
            toml: toml.to_owned(),
        };
        let read = gelpad::profile::read(source, None, &find_shipped);
        read.expect("sound").profile.bindings
    };
    let base = find_shipped("falling-blocks").expect("shipped");
    let (before, after) = (read("base", &base.toml), read("mine", &written));
    assert_eq!(after.len(), before.len(), "overridden, not added");
    // The next choice changes the same one.
    assert_eq!(choose_k(&mut stage).matches("[[binding]]").count(), 1);
}

#[test]
fn the_first_change_and_saving_move_nothing() {
    let (mut stage, _) = stage();
    let button = "More: Shortest press";
    let before = stage.button_rect(button);
    stage.window.get_by_label(button).click_accesskit();
    stage.steps(3);
    assert!(stage.app().edit.is_unsaved());
    assert_eq!(stage.button_rect(button), before);
    stage.button("Save");
    stage.steps(3);
    assert_eq!(stage.button_rect(button), before);
    assert_eq!(stage.colour_of("✔ saved: "), Some(palette(true).good));
}

#[test]
fn rename_opens_with_its_text_selected() {
    let (mut stage, path) = stage();
    stage.button("Rename");
    stage.steps(10);
    let field = stage
        .window
        .get_by_role_and_label(Role::TextInput, "New name");
    assert!(field.is_focused());
    stage.window.event(egui::Event::Text("other".to_owned()));
    stage.steps(2);
    stage.key(egui::Key::Enter);
    stage.wait_for_start();
    assert!(
        path.with_file_name("other.toml").exists(),
        "{:?}",
        stage.window
    );
}

#[test]
fn every_button_is_large_enough_to_be_hit() {
    let (edit, _) = stage();
    let comfort = Stage::with_view(Tab::Comfort, WIDE);
    for stage in [edit, comfort] {
        for button in stage.window.query_all_by_role(Role::Button) {
            let size = button.rect().size();
            assert!(size.min_elem() >= MIN_TARGET - 0.5, "{size:?}: {button:?}");
        }
    }
}

#[test]
fn titles_begin_with_a_capital() {
    let (mut stage, _) = stage();
    stage.app().edit.select_region("jump");
    stage.steps(2);
    for title in [
        "Region",
        "Bindings of jump",
        "Timing, beside what you do now",
        "Games",
    ] {
        assert!(stage.has_label(title), "{title}");
    }
}
