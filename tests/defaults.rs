//! Every default is the same in the list of keys, the checker, the schema and the guide: a key that is written with its
//! default gives the profile that is read without it.

use gelpad::profile::{Key, KeyKind, Profile, Source, Table, find_shipped, keys, read, schema};
use serde_json::Value;

const REGION: &str = "name = \"r\"\n";
const SHAPES: &[(&str, &str)] = &[
    ("rect", "x = 0\ny = 0\nw = 0.5\nh = 0.5\n"),
    ("circle", "shape = \"circle\"\nx = 0.5\ny = 0.5\nr = 0.2\n"),
    (
        "ellipse",
        "shape = \"ellipse\"\nx = 0.5\ny = 0.5\nw = 0.2\nh = 0.2\n",
    ),
    (
        "polygon",
        "shape = \"polygon\"\npoints = [[0, 0], [1, 0], [0, 1]]\n",
    ),
    (
        "grid",
        "shape = \"grid\"\nx = 0\ny = 0\nw = 1\nh = 1\ncolumns = 2\nrows = 1\n",
    ),
];
/// What a binding must hold besides `gesture`, where an output is not enough.
const GESTURES: &[(&str, &str)] = &[
    ("swipe", "direction = \"left\"\noutput = \"key:a\"\n"),
    ("contacts", "fingers = 2\noutput = \"key:a\"\n"),
    ("dpad", "left = \"key:a\"\n"),
    ("stick", "axis_x = \"pad:left-x\"\n"),
    ("trigger", "axis = \"pad:left-trigger\"\n"),
    ("pointer", ""),
    ("tap-hold", "tap = \"key:a\"\nhold = \"key:b\"\n"),
];
const MODES: &[(&str, &str)] = &[("macro", "macro = [\"tap key:a\"]\n")];

fn words(name: &str) -> &'static [&'static str] {
    let key = keys().iter().find(|key| key.name == name);
    match key.expect("a key of this name").kind {
        KeyKind::Word(words) => words,
        _ => panic!("`{name}` is not a choice of words"),
    }
}

fn needs(list: &[(&str, &'static str)], word: &str) -> &'static str {
    let found = list.iter().find(|(other, _)| *other == word);
    found.map_or("output = \"key:a\"\n", |(_, text)| text)
}

/// A binding of each gesture and one of each mode: the word that keys name it by, and the text.
fn bindings() -> Vec<(&'static str, String)> {
    let gestures = words("gesture").iter().map(|word| {
        let region = if *word == "chord" {
            "[\"r\", \"s\"]"
        } else {
            "\"r\""
        };
        let own = needs(GESTURES, word);
        (
            *word,
            format!("region = {region}\ngesture = \"{word}\"\n{own}"),
        )
    });
    let modes = words("mode").iter().map(|word| {
        let own = needs(MODES, word);
        (*word, format!("region = \"r\"\nmode = \"{word}\"\n{own}"))
    });
    gestures.chain(modes).collect()
}

/// What a profile does, without the texts that it was read from.
fn meaning(top: &str, region: &str, binding: &str, user: &str) -> Profile {
    let source = |name: &str, toml: String| Source {
        name: name.to_owned(),
        toml,
    };
    let toml = format!(
        "schema = 1\nname = \"p\"\n{top}\n[[region]]\n{REGION}{region}\n[[region]]\nname = \"s\"\nx = 0.6\ny = 0.6\nw = 0.2\nh = 0.2\n{binding}"
    );
    let shown = toml.clone();
    let checked = read(
        source("p.toml", toml),
        Some(source("user.toml", user.to_owned())),
        &find_shipped,
    );
    let profile = checked
        .unwrap_or_else(|errors| panic!("{errors}\n{shown}"))
        .profile;
    Profile {
        origins: Vec::new(),
        texts: Default::default(),
        ..profile
    }
}

fn all_bindings() -> String {
    let texts = bindings();
    texts
        .iter()
        .map(|(_, text)| format!("[[binding]]\n{text}"))
        .collect()
}

/// The key with its default as a line of TOML, if the default is a value.
fn written(key: &Key) -> Option<String> {
    let default = key.default.to_string();
    match key.kind {
        KeyKind::Number(..) | KeyKind::Count(..) => default.parse::<f64>().is_ok(),
        KeyKind::Flag => default.parse::<bool>().is_ok(),
        KeyKind::Word(words) => {
            let known = words.contains(&default.as_str());
            return known.then(|| format!("{} = \"{default}\"\n", key.name));
        }
        KeyKind::Text | KeyKind::Texts | KeyKind::Points => false,
    }
    .then(|| format!("{} = {default}\n", key.name))
}

#[test]
fn a_key_with_its_default_changes_nothing() {
    let rect = SHAPES[0].1;
    let mut compared = 0;
    let mut wrong = Vec::new();
    let mut compare = |key: &Key, what: &str, without: Profile, with: Profile| {
        compared += 1;
        if without != with {
            wrong.push(format!(
                "`{}` = {} {what} is not the default",
                key.name, key.default
            ));
        }
    };
    for key in keys() {
        let Some(line) = written(key) else { continue };
        let takes = |word: &str| key.only.is_empty() || key.only.contains(&word);
        match key.table {
            Table::Profile | Table::Setting => {
                let all = all_bindings();
                compare(
                    key,
                    "at the top",
                    meaning("", rect, &all, ""),
                    meaning(&line, rect, &all, ""),
                );
            }
            Table::User => {
                let all = all_bindings();
                compare(
                    key,
                    "in user settings",
                    meaning("", rect, &all, ""),
                    meaning("", rect, &all, &line),
                );
            }
            Table::Region => {
                for (shape, text) in SHAPES.iter().filter(|(shape, _)| takes(shape)) {
                    let shape_key = key.name == "shape";
                    if shape_key && *shape != "rect" {
                        continue;
                    }
                    let other = if *shape == "grid" {
                        "region = \"r-1\"\noutput = \"key:a\"\n"
                    } else {
                        "region = \"r\"\noutput = \"key:a\"\n"
                    };
                    let other = format!("[[binding]]\n{other}");
                    compare(
                        key,
                        shape,
                        meaning("", text, &other, ""),
                        meaning("", &format!("{text}{line}"), &other, ""),
                    );
                }
            }
            Table::Binding => {
                for (word, text) in bindings().iter().filter(|(word, _)| takes(word)) {
                    if text.contains(&format!("{} = ", key.name)) {
                        continue;
                    }
                    // A gesture that drives its outputs has no mode.
                    if key.name == "mode" && *word != "press" {
                        continue;
                    }
                    compare(
                        key,
                        word,
                        meaning("", rect, &format!("[[binding]]\n{text}"), ""),
                        meaning("", rect, &format!("[[binding]]\n{text}{line}"), ""),
                    );
                }
            }
            Table::Match => {}
        }
    }
    assert!(compared > 70, "only {compared} defaults compared");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_schema_and_the_guide_show_the_default_of_the_list() {
    let schema: Value = serde_json::from_str(&schema()).expect("JSON");
    let guide = include_str!("../docs/profiles.md");
    for key in keys() {
        let default = key.default.to_string();
        let properties = match key.table {
            Table::Profile | Table::Setting => &schema["properties"],
            Table::Match => &schema["properties"]["match"]["properties"],
            Table::Region => &schema["properties"]["region"]["items"]["properties"],
            Table::Binding => &schema["properties"]["binding"]["items"]["properties"],
            Table::User => continue,
        };
        let description = properties[key.name]["description"]
            .as_str()
            .unwrap_or_default();
        assert!(
            default.is_empty() || description.contains(&format!("(default: {default})")),
            "{}: {description}",
            key.name
        );
        let row = format!("| {default} | {}", key.about);
        assert!(
            guide
                .lines()
                .any(|line| line.starts_with(&format!("| `{}` |", key.name)) && line.contains(&row)),
            "{}: {row}",
            key.name
        );
    }
}
