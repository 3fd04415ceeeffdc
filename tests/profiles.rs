//! Texts of profiles: mistakes are reported at their place; schema and guide match the reader.

use std::path::Path;
use std::process::Command;

use gelpad::profile::{KeyKind, Source, Table, find_shipped, keys, read, schema};
use gelpad::types::Key;

/// Profiles with one mistake each: the replacement that makes it, then `line:column`, the underlined text, and a part of
/// the message.
const BASE: &str = "schema = 1\nname = \"p\"\n[[region]]\nname = \"jump\"\nx = 0.1\ny = 0.1\nw = 0.4\nh = 0.4\n[[region]]\nname = \"run\"\nx = 0.6\ny = 0.6\nw = 0.4\nh = 0.4\n[[binding]]\nregion = \"jump\"\noutput = \"key:f\"\n";

struct Case {
    from: &'static str,
    to: &'static str,
    at: &'static str,
    word: &'static str,
    said: &'static str,
}

const fn case(
    from: &'static str,
    to: &'static str,
    at: &'static str,
    word: &'static str,
    said: &'static str,
) -> Case {
    Case {
        from,
        to,
        at,
        word,
        said,
    }
}

#[rustfmt::skip]
const CASES: &[Case] = &[
    // TOML syntax.
    case("name = \"p\"", "name = \"p", "2:10", "", "invalid basic string"),
    case("x = 0.1", "x = ", "5:5", "", "string values must be quoted, expected literal string"),
    case("[[region]]", "[[region]", "3:10", "", "unclosed array table, expected `]`"),
    case("schema = 1", "schema = 1\nschema = 1", "2:1", "schema", "duplicate key"),
    // Keys.
    case("x = 0.1", "z = 0.1", "5:1", "z", "unknown key `z` in a region | did you mean `order`"),
    case("output = ", "outptu = ", "17:1", "outptu", "unknown key `outptu` in a binding | did you mean `output`"),
    case("output = ", "key = ", "17:1", "key", "did you mean `output`"),
    case("name = \"p\"", "name = \"p\"\ntaping_term_ms = 200", "3:1", "taping_term_ms", "did you mean `tapping_term_ms`? (a touch that lifts sooner is a tap)"),
    case("name = \"p\"", "name = \"p\"\ndebounce_ms = 20", "3:1", "debounce_ms", "did you mean `bounce_keys_ms`"),
    case("name = \"p\"", "name = \"p\"\nqwertyuiop = 20", "3:1", "qwertyuiop", "known keys: schema, name"),
    case("[[binding]]", "[[bindings]]", "15:3", "bindings", "unknown key `bindings` at the top of a profile | did you mean `binding`"),
    case("[[region]]\nname = \"run\"", "[region2]\nname = \"run\"", "9:2", "region2", "did you mean `region`"),
    case("w = 0.4", "width = 0.4", "7:1", "width", "did you mean `w`? (width)"),
    // Kinds.
    case("x = 0.1", "x = \"0.1\"", "5:5", "\"0.1\"", "`x` must be a number without quotes, but this is a text"),
    case("x = 0.1", "x = true", "5:5", "true", "`x` must be a number without quotes, but this is true or false"),
    case("x = 0.1", "x = [0.1]", "5:5", "[0.1]", "`x` must be a number without quotes, but this is a list"),
    case("output = \"key:f\"", "output = 5", "17:10", "5", "`output` must be a text in quotes, or a list of them"),
    case("region = \"jump\"", "region = 1", "16:10", "1", "`region` must be a text in quotes, or a list of them"),
    case("name = \"p\"", "name = \"p\"\nsticky_keys = \"yes\"", "3:15", "\"yes\"", "`sticky_keys` must be true or false without quotes"),
    case("name = \"p\"", "name = 7", "2:8", "7", "`name` must be a text in quotes"),
    case("name = \"p\"", "name = \"p\"\nvars = 3", "3:8", "3", "`vars` must be a table"),
    case("schema = 1", "schema = 1.5", "1:10", "1.5", "`schema` = 1.5 is out of range: it must be 1"),
    // Ranges.
    case("schema = 1", "schema = 7", "1:10", "7", "`schema` = 7 is out of range: it must be 1"),
    case("x = 0.1", "x = 1.1", "5:5", "1.1", "`x` = 1.1 is out of range: it must be 0 to 1 of the pad"),
    case("x = 0.1", "x = nan", "5:5", "nan", "out of range"),
    case("w = 0.4", "w = 0", "7:5", "0", "out of range"),
    case("w = 0.4", "w = 0.95", "7:5", "0.95", "the region ends at 1.050, off the pad on the right"),
    case("h = 0.4", "h = 0.95", "8:5", "0.95", "off the pad on the top"),
    case("name = \"p\"", "name = \"p\"\nmin_hold_ms = -1", "3:15", "-1", "`min_hold_ms` = -1 is out of range: it must be 0 to 60000 ms"),
    case("name = \"p\"", "name = \"p\"\npanic_contacts = 2.5", "3:18", "2.5", "a whole number from 0 to 20"),
    case("name = \"p\"", "name = \"p\"\nrotate = 45", "3:10", "45", "not a quarter turn: write 0, 90, 180 or 270"),
    case("name = \"p\"", "name = \"p\"\narea_x = 0.6\narea_w = 0.6", "4:10", "0.6", "ends at 1.200, off the pad on the right"),
    // Words.
    case("name = \"p\"", "name = \"p\"\nmethod = \"nosr\"", "3:10", "\"nosr\"", "unknown method `nosr` | did you mean `noser`"),
    case("name = \"p\"", "name = \"p\"\nactivate = \"UP\"", "3:12", "\"UP\"", "did you mean `up`"),
    case("x = 0.1", "shape = \"circel\"", "5:9", "\"circel\"", "unknown shape `circel` | did you mean `circle`"),
    case("output = \"key:f\"", "gesture = \"doubletap\"\noutput = \"key:f\"", "17:11", "\"doubletap\"", "did you mean `double-tap`"),
    case("output = \"key:f\"", "mode = \"drect\"\noutput = \"key:f\"", "17:8", "\"drect\"", "did you mean `direct`"),
    case("output = \"key:f\"", "gesture = \"tap-hold\"\ntap = \"key:f\"\nhold = \"key:g\"\nflavour = \"permissive\"", "20:11", "\"permissive\"", "`flavour` is one of speculative, tap-preferred, balanced, hold-preferred"),
    // Names.
    case("region = \"jump\"", "region = \"jmup\"", "16:10", "\"jmup\"", "no region is named `jmup` | did you mean `jump`"),
    case("name = \"run\"", "name = \"jump\"", "10:8", "\"jump\"", "two regions are named `jump`"),
    case("output = \"key:f\"", "output = \"key:ff\"", "17:10", "\"key:ff\"", "no key is named `ff`"),
    case("output = \"key:f\"", "output = \"f\"", "17:10", "\"f\"", "`f` names no device"),
    case("output = \"key:f\"", "output = \"pad:lefft\"", "17:10", "\"pad:lefft\"", "no gamepad button is named `lefft` | did you mean `left`"),
    case("output = \"key:f\"", "output = [\"key:f\", \"key:spcae\"]", "17:20", "\"key:spcae\"", "did you mean `space`"),
    case("output = \"key:f\"", "output = \"gelpad:pasue\"", "17:10", "\"gelpad:pasue\"", "write `gelpad:pause`"),
    case("output = \"key:f\"", "output = \"layer:aim\"", "17:10", "\"layer:aim\"", "no binding is on the layer `aim`"),
    case("output = \"key:f\"", "output = \"$go\"\n[vars]\ngo = \"key:spcae\"", "19:6", "\"key:spcae\"", "did you mean `space`"),
    case("name = \"p\"", "name = \"p\"\nvars = { hold = -3 }\nmin_hold_ms = \"$hold\"", "3:17", "-3", "`min_hold_ms` = -3 is out of range"),
    case("x = 0.1", "x = \"$edge\"", "5:5", "\"$edge\"", "unknown variable `$edge` | add `edge = ...` under [vars]"),
    case("name = \"p\"", "name = \"p\"\nextends = \"super-maria\"", "3:11", "\"super-maria\"", "no shipped profile is named `super-maria`"),
    // Missing or contradictory values.
    case("w = 0.4\n", "", "4:8", "\"jump\"", "the region `jump` needs `w`"),
    case("output = \"key:f\"\n", "", "15:1", "[[binding]]", "the binding has no `output`"),
    case("schema = 1\n", "", "1:1", "name", "has no `schema`"),
    case("name = \"p\"\n", "", "1:1", "schema", "the profile has no `name`"),
    case("x = 0.1", "x = 0.1\nr = 0.1", "6:5", "0.1", "`r` does not apply to a rect"),
    case("output = \"key:f\"", "turbo_hz = 8\noutput = \"key:f\"", "17:12", "8", "`turbo_hz` does not apply to the gesture press in mode direct"),
    case("output = \"key:f\"", "gesture = \"swipe\"\noutput = \"key:f\"", "15:1", "[[binding]]", "a swipe needs a `direction`"),
    case("output = \"key:f\"", "gesture = \"swipe\"\ndirection = \"up-left\"\nways = 4\noutput = \"key:f\"", "18:13", "\"up-left\"", "a swipe with `ways = 4` cannot be diagonal"),
    case("output = \"key:f\"", "gesture = \"chord\"\noutput = \"key:f\"", "16:10", "\"jump\"", "a chord needs at least two regions or buttons"),
    case("output = \"key:f\"", "gesture = \"stick\"\naxis_x = \"pad:left-z\"", "18:10", "\"pad:left-z\"", "unknown axis `pad:left-z`"),
    case("output = \"key:f\"", "gesture = \"force\"\nforce = 0.3\nforce_release = 0.5\noutput = \"key:f\"", "19:17", "0.5", "`force_release` must not be above `force`"),
    case("output = \"key:f\"", "from = \"pad:strat\"\noutput = \"key:f\"", "17:8", "\"pad:strat\"", "no part of a gamepad is named `pad:strat` | did you mean `pad:start`"),
    case("output = \"key:f\"", "gesture = \"swipe\"\ndirection = \"up\"\nfrom = \"pad:a\"\noutput = \"key:f\"", "19:8", "\"pad:a\"", "a gamepad cannot play the gesture swipe"),
    case("output = \"key:f\"", "gesture = \"stick\"\naxis_x = \"pad:left-x\"\nfrom = \"pad:a\"", "19:8", "\"pad:a\"", "the gesture stick needs directions, and `pad:a` has none"),
    case("output = \"key:f\"", "gesture = \"force\"\nfrom = \"stick:left\"\noutput = \"key:f\"", "18:8", "\"stick:left\"", "the gesture force needs pressure, and `stick:left` has none"),
    case("output = \"key:f\"", "gesture = \"stick\"\nstick = \"floating\"\naxis_x = \"pad:left-x\"\nfrom = \"stick:left\"", "18:9", "\"floating\"", "the stick of a gamepad cannot be floating"),
    case("output = \"key:f\"", "mode = \"macro\"\nmacro = [\"press key:a\"]", "18:9", "[\"press key:a\"]", "the macro ends with an output still pressed"),
    case("output = \"key:f\"", "mode = \"macro\"\nmacro = [\"wait soon\"]", "18:10", "\"wait soon\"", "`soon` is not a time to wait"),
    case("output = \"key:f\"", "mode = \"macro\"\nmacro = [\"jump key:a\"]", "18:10", "\"jump key:a\"", "unknown macro step `jump`"),
    case("x = 0.1\ny = 0.1\nw = 0.4\nh = 0.4\n[[region]]", "shape = \"polygon\"\npoints = [[0.1, 0.1], [0.2]]\n[[region]]", "6:23", "[0.2]", "a corner must be two numbers"),
];

fn source(toml: String) -> Source {
    Source {
        name: "p.toml".to_owned(),
        toml,
    }
}

#[test]
fn each_mistake_is_reported_at_its_place() {
    assert!(CASES.len() >= 40);
    let mut wrong = Vec::new();
    for case in CASES {
        assert!(BASE.contains(case.from), "{}", case.from);
        let faulty = read(
            source(BASE.replacen(case.from, case.to, 1)),
            None,
            &find_shipped,
        )
        .expect_err(case.to);
        let found = faulty.diagnostics.iter().any(|fault| {
            let (line, column) = faulty.line_column(fault.span.start);
            let help = fault.help.as_deref().unwrap_or_default();
            let said = format!("{} | {help}", fault.message);
            format!("{line}:{column}") == case.at
                && faulty.text.get(fault.span.clone()) == Some(case.word)
                && case.said.split(" | ").all(|part| said.contains(part))
        });
        if !found {
            let got: Vec<String> = faulty
                .diagnostics
                .iter()
                .map(|fault| {
                    let (line, column) = faulty.line_column(fault.span.start);
                    format!(
                        "{line}:{column} <{}> {} | {}",
                        &faulty.text[fault.span.clone()],
                        fault.message,
                        fault.help.clone().unwrap_or_default()
                    )
                })
                .collect();
            wrong.push(format!(
                "{:?}: {} <{}> {}\n  got {}",
                case.to,
                case.at,
                case.word,
                case.said,
                got.join("\n      ")
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_command_line_shows_each_mistake_and_fails() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("p.toml");
    for case in CASES {
        std::fs::write(&file, BASE.replacen(case.from, case.to, 1)).expect("written");
        let output = Command::new(env!("CARGO_BIN_EXE_gelpad"))
            .args(["profile", "check"])
            .arg(&file)
            .output()
            .expect("started");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{}: {stderr}", case.to);
        let place = format!("{}:{}: ", file.display(), case.at);
        // Long messages are wrapped; the place stays at the start of a line.
        let whole = stderr.replace("\n  │ ", "");
        assert!(
            whole.contains(&place) && !stderr.contains("panicked"),
            "{}: {place} in\n{stderr}",
            case.to
        );
    }
}

#[test]
fn all_mistakes_are_reported_together() {
    let text = BASE.replacen("x = 0.1", "x = 1.1", 1).replacen(
        "output = \"key:f\"",
        "output = \"key:b1\"\nmoed = \"direct\"",
        1,
    );
    let faulty = read(source(text), None, &find_shipped).expect_err("a mistake");
    assert_eq!(
        faulty.to_string(),
        "p.toml:18:1: unknown key `moed` in a binding",
        "keys first: what they hold is read next"
    );
    let text = BASE
        .replacen("x = 0.1", "x = 1.1", 1)
        .replacen("\"key:f\"", "\"key:b1\"", 1)
        .replacen("region = \"jump\"", "region = \"jmup\"", 1);
    let faulty = read(source(text), None, &find_shipped).expect_err("three mistakes");
    assert_eq!(faulty.diagnostics.len(), 3, "{faulty}");
}

#[test]
fn a_mistake_in_a_base_is_reported_in_the_base() {
    let base = BASE.replacen("x = 0.1", "x = 2", 1);
    let find = |_: &str| -> Result<Source, String> {
        Ok(Source {
            name: "base.toml".to_owned(),
            toml: base.clone(),
        })
    };
    let top = source("schema = 1\nname = \"top\"\nextends = \"./base.toml\"\n".to_owned());
    let faulty = read(top, None, &find).expect_err("a mistake in the base");
    assert_eq!(
        faulty.to_string(),
        "base.toml:5:5: `x` = 2 is out of range: it must be 0 to 1 of the pad"
    );
    let itself = source("schema = 1\nname = \"top\"\nextends = \"./p.toml\"\n".to_owned());
    let again = itself.clone();
    let faulty = read(itself, None, &move |_| Ok(again.clone())).expect_err("a circle");
    assert!(
        faulty
            .to_string()
            .starts_with("p.toml:3:11: `./p.toml` extends itself"),
        "{faulty}"
    );
}

#[test]
fn warnings_do_not_stop_a_profile() {
    let warned = |from: &str, to: &str| -> String {
        let text = BASE.replacen(from, to, 1);
        let checked = read(source(text), None, &find_shipped).expect("sound");
        checked.warnings.iter().map(ToString::to_string).collect()
    };
    for (from, to, said) in [
        (
            "x = 0.6",
            "x = 0.6",
            "p.toml:10:8: nothing is bound to the region `run`",
        ),
        (
            "x = 0.1\ny = 0.1\nw = 0.4\nh = 0.4",
            "order = -1\nx = 0.7\ny = 0.7\nw = 0.2\nh = 0.2",
            "p.toml:4:8: the region `jump` is hidden",
        ),
        (
            "name = \"p\"",
            "name = \"p\"\ntapping_term_ms = 80",
            "p.toml:3:19: a tapping term of 80 ms is short",
        ),
        (
            "output = ",
            "layer = \"aim\"\noutput = ",
            "p.toml:15:1: this binding can never fire: nothing turns its layer `aim` on",
        ),
        (
            "output = ",
            "gesture = \"tap\"\ntapping_term_ms = 0\noutput = ",
            "this binding can never fire: its tapping term is 0",
        ),
        (
            "w = 0.4",
            "w = 0.4\nrest = true",
            "this binding can never fire: its region ignores touches",
        ),
        (
            "output = ",
            "mode = \"turbo\"\nturbo_hz = 30\noutput = ",
            "faster than min_hold_ms and min_gap_ms allow",
        ),
        (
            "region = \"jump\"\n",
            "gesture = \"contacts\"\nfingers = 5\n",
            "this many contacts are the panic gesture",
        ),
    ] {
        let warnings = warned(from, to);
        assert!(warnings.contains(said), "{to:?}: {warnings:?}");
    }
}

#[test]
fn the_schema_in_the_repository_is_current() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("profiles/profile.schema.json");
    if std::env::var_os("GELPAD_BLESS").is_some() {
        std::fs::write(&path, schema()).expect("written");
    }
    let kept = std::fs::read_to_string(&path).expect("the schema");
    assert_eq!(
        kept,
        schema(),
        "run this test with GELPAD_BLESS=1 and look at what changes"
    );
}

/// The guide's table of all keys.
fn key_table() -> String {
    let mut text = String::new();
    let tables = [
        ("At the top of a profile", Table::Profile),
        (
            "At the top of a profile, or of a person's text",
            Table::Setting,
        ),
        ("In a person's text alone", Table::User),
        ("In `[match]`", Table::Match),
        ("In `[[region]]`", Table::Region),
        ("In `[[binding]]`", Table::Binding),
    ];
    for (title, table) in tables {
        text.push_str(&format!("\n### {title}\n\n| key | value | without it | what it is for |\n| --- | --- | --- | --- |\n"));
        for key in keys().iter().filter(|key| key.table == table) {
            let value = match key.kind {
                KeyKind::Number(least, most, unit) => {
                    format!("{least} to {most} {unit}").trim().to_owned()
                }
                KeyKind::Count(least, most) => format!("{least} to {most}"),
                KeyKind::Word(words) => words.join(", "),
                KeyKind::Text => "text".to_owned(),
                KeyKind::Texts => "text or list".to_owned(),
                KeyKind::Flag => "true or false".to_owned(),
                KeyKind::Points => "list of [x, y]".to_owned(),
            };
            let only = if key.only.is_empty() {
                String::new()
            } else {
                format!(" ({})", key.only.join(", "))
            };
            text.push_str(&format!(
                "| `{}` | {value} | {} | {}{only} |\n",
                key.name, key.default, key.about
            ));
        }
    }
    text
}

#[test]
fn the_guide_lists_every_key() {
    const START: &str = "<!-- keys: made by `GELPAD_BLESS=1 cargo test --test profiles` -->\n";
    const END: &str = "<!-- end of keys -->";
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/profiles.md");
    let guide = std::fs::read_to_string(&path).expect("the guide");
    let (before, rest) = guide.split_once(START).expect("where the table begins");
    let (_, after) = rest.split_once(END).expect("where it ends");
    let fresh = format!("{before}{START}{}\n{END}{after}", key_table());
    if std::env::var_os("GELPAD_BLESS").is_some() {
        std::fs::write(&path, &fresh).expect("written");
        return;
    }
    assert!(
        guide == fresh,
        "the table of keys has drifted: run this test with GELPAD_BLESS=1"
    );
}

#[test]
fn the_guide_names_every_key_and_no_other() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/profiles.md");
    let guide = std::fs::read_to_string(path).expect("the guide");
    let (_, section) = guide.split_once("## Names of keys").expect("a section");
    let table: String = section
        .lines()
        .filter(|line| line.starts_with('|'))
        .collect();
    let is_range = |key: &str| {
        let number = key.trim_start_matches(|c: char| !c.is_ascii_digit());
        key.len() == 1
            || key
                .strip_suffix(number)
                .is_some_and(|head| ["f", "keypad-"].contains(&head))
    };
    let unnamed: Vec<String> = Key::all()
        .map(|key| key.to_string())
        .filter(|key| !is_range(key) && !table.contains(&format!("`{key}`")))
        .collect();
    assert!(unnamed.is_empty(), "{unnamed:?}");
    for name in table.split('`').skip(1).step_by(2) {
        assert!(name.parse::<Key>().is_ok(), "`{name}` is not a key");
    }
}
