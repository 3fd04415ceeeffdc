//! Holds every `crate::` path of `src/` against the table of imports in ARCHITECTURE.md, and the core against IO,
//! threads and clocks.

mod support;

use std::fs;
use std::path::{Path, PathBuf};

/// Each part and what of ours it may import. A part is a folder or a file of `src/`.
const TABLE: &[(&str, &[&str])] = &[
    ("types", &[]),
    ("pad", &["types"]),
    ("eit", &["types", "pad"]),
    ("touch", &["types", "pad", "eit"]),
    ("profile", &["types"]),
    ("gesture", &["types", "profile"]),
    (
        "engine",
        &["types", "pad", "eit", "touch", "profile", "gesture"],
    ),
    ("cache", &["types", "pad", "eit", "touch"]),
    ("session", &["types"]),
    (
        "tape",
        &[
            "types", "pad", "eit", "touch", "profile", "engine", "session",
        ],
    ),
    ("source", &["types", "pad", "eit", "session"]),
    ("output", &["types"]),
    (
        "calibrate",
        &["types", "pad", "eit", "touch", "profile", "gesture"],
    ),
    ("study", &["types", "pad", "eit", "touch", "source"]),
    (
        "runtime",
        &[
            "types", "pad", "eit", "touch", "profile", "gesture", "engine", "session", "tape",
            "source", "output",
        ],
    ),
    ("doctor", &["types", "output"]),
    (
        "gui",
        &[
            "types",
            "pad",
            "eit",
            "touch",
            "profile",
            "gesture",
            "engine",
            "session",
            "tape",
            "source",
            "output",
            "runtime",
            "calibrate",
        ],
    ),
    (
        "cli",
        &[
            "types",
            "pad",
            "eit",
            "touch",
            "profile",
            "gesture",
            "engine",
            "session",
            "tape",
            "source",
            "output",
            "runtime",
            "cache",
            "calibrate",
            "study",
            "gui",
            "doctor",
        ],
    ),
];

/// Parts that do no IO, start no thread and read no clock, and what would be that.
const CORE: &[&str] = &[
    "types", "pad", "eit", "touch", "profile", "gesture", "engine",
];
const BANNED_IN_CORE: &[&str] = &[
    "std::fs",
    "std::io",
    "std::net",
    "std::thread",
    "std::time",
    "std::env",
    "std::process",
    "println!",
    "eprintln!",
];

/// Every source file with the part that it belongs to and its text without comments.
fn parts() -> Vec<(String, PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    support::files(&root, "rs")
        .into_iter()
        .filter_map(|path| {
            let inside = path.strip_prefix(&root).expect("inside src").to_owned();
            let first = inside.components().next().expect("a name");
            let part = first
                .as_os_str()
                .to_string_lossy()
                .trim_end_matches(".rs")
                .to_owned();
            let code: String = fs::read_to_string(&path)
                .expect("text")
                .lines()
                .filter(|line| !line.trim_start().starts_with("//"))
                .map(|line| format!("{line}\n"))
                .collect();
            (part != "lib" && part != "main").then_some((part, inside, code))
        })
        .collect()
}

/// What production code names: unit tests at a file's end may use more.
fn without_tests(code: &str) -> &str {
    code.split("#[cfg(test)]\nmod tests").next().unwrap_or(code)
}

#[test]
fn parts_import_only_what_the_table_allows() {
    let mut wrong = Vec::new();
    for (part, file, code) in parts() {
        let Some((_, allowed)) = TABLE.iter().find(|(name, _)| *name == part) else {
            panic!(
                "{}: `{part}` is not in the table: add it here and to ARCHITECTURE.md",
                file.display()
            );
        };
        for after in without_tests(&code).split("crate::").skip(1) {
            let name: String = after
                .chars()
                .take_while(|c| c.is_alphanumeric() || *c == '_')
                .collect();
            let known = TABLE.iter().any(|(part, _)| *part == name);
            if known && name != part && !allowed.contains(&name.as_str()) {
                wrong.push(format!(
                    "{}: `{part}` may not import `{name}`",
                    file.display()
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_core_does_no_io_and_reads_no_clock() {
    let mut wrong = Vec::new();
    for (part, file, code) in parts() {
        if !CORE.contains(&part.as_str()) {
            continue;
        }
        for banned in BANNED_IN_CORE {
            if without_tests(&code).contains(banned) {
                wrong.push(format!("{}: `{banned}`", file.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_table_is_the_one_that_is_written_down() {
    let written = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("ARCHITECTURE.md"))
        .expect("ARCHITECTURE.md");
    for (part, _) in TABLE {
        assert!(
            written.contains(&format!("`src/{part}")),
            "ARCHITECTURE.md does not name `src/{part}`"
        );
    }
}
