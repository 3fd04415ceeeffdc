//! Checks every `crate::` path of `src/` against the table of imports in ARCHITECTURE.md, and that the core has no IO,
//! threads or clocks.

mod support;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Each part of `src/`, a folder or a file, with the parts that it may import.
const TABLE: &[(&str, &[&str])] = &[
    ("types", &[]),
    ("stats", &[]),
    ("platform", &["types", "output"]),
    ("files", &["platform"]),
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
    ("session", &["types", "files"]),
    (
        "tape",
        &[
            "types", "pad", "eit", "touch", "profile", "engine", "session",
        ],
    ),
    ("source", &["types", "pad", "eit", "session", "platform"]),
    ("output", &["types"]),
    (
        "calibrate",
        &[
            "types", "stats", "pad", "eit", "touch", "profile", "gesture",
        ],
    ),
    (
        "study",
        &[
            "types",
            "stats",
            "pad",
            "eit",
            "touch",
            "source",
            "calibrate",
        ],
    ),
    (
        "runtime",
        &[
            "platform", "types", "pad", "eit", "touch", "profile", "gesture", "engine", "session",
            "tape", "source", "output", "files",
        ],
    ),
    ("doctor", &["types", "output", "platform"]),
    (
        "app",
        &[
            "platform",
            "types",
            "files",
            "stats",
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
            "doctor",
        ],
    ),
    (
        "gui",
        &[
            "platform",
            "types",
            "files",
            "stats",
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
            "app",
        ],
    ),
    (
        "cli",
        &[
            "platform",
            "types",
            "files",
            "stats",
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
            "app",
            "doctor",
        ],
    ),
];

/// Parts without IO, threads and clocks, and the paths that they must not use.
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

/// Every source file: part, path, and text without comments.
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

/// The text before the unit tests, which may import more.
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

/// The sibling files that a file names in a path or a `use` list.
fn siblings<'a>(own: &str, code: &str, names: &'a [String]) -> Vec<&'a str> {
    let code = without_tests(code);
    let lists: Vec<&str> = code
        .split("use super::{")
        .skip(1)
        .map(|after| after.split(';').next().unwrap_or_default())
        .collect();
    let names = names.iter().map(String::as_str).filter(|name| *name != own);
    names
        .filter(|name| {
            let path = format!("super::{name}::");
            let listed = lists.iter().any(|list| {
                let words = list.split(|c: char| !c.is_alphanumeric() && c != '_' && c != ':');
                words
                    .into_iter()
                    .any(|word| word == *name || word.starts_with(&format!("{name}::")))
            });
            // `super::super::name` is a file of the folder above.
            code.match_indices(&path)
                .any(|(at, _)| !code[..at].ends_with("super::"))
                || listed
        })
        .collect()
}

#[test]
fn files_of_a_folder_do_not_import_each_other_in_circles() {
    let mut folders: BTreeMap<PathBuf, BTreeMap<String, String>> = BTreeMap::new();
    for (_, file, code) in parts() {
        let folder = file.parent().expect("a folder").to_owned();
        let stem = file
            .file_stem()
            .expect("a name")
            .to_string_lossy()
            .into_owned();
        if stem != "mod" && folder.components().count() > 0 {
            folders.entry(folder).or_default().insert(stem, code);
        }
    }
    let mut circles = Vec::new();
    for (folder, files) in &folders {
        let names: Vec<String> = files.keys().cloned().collect();
        let imports: BTreeMap<&str, Vec<&str>> = files
            .iter()
            .map(|(name, code)| (name.as_str(), siblings(name, code, &names)))
            .collect();
        for name in &names {
            let mut reached: Vec<&str> = imports[name.as_str()].clone();
            let mut next = 0;
            while let Some(file) = reached.get(next).copied() {
                reached.extend(
                    imports[file]
                        .iter()
                        .filter(|more| !reached.contains(more))
                        .copied()
                        .collect::<Vec<_>>(),
                );
                next += 1;
            }
            if reached.contains(&name.as_str()) {
                circles.push(format!("{}/{name}.rs", folder.display()));
            }
        }
    }
    assert!(
        circles.is_empty(),
        "in a circle of imports: {}",
        circles.join(", ")
    );
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

/// The files that ask which system they are compiled for: each chooses one folder per system.
const CHOOSERS: &[&str] = &["platform/mod.rs", "doctor/mod.rs"];

#[test]
fn only_two_files_ask_for_the_operating_system() {
    let mut wrong = Vec::new();
    for (_, file, code) in parts() {
        let name = file.to_string_lossy().replace('\\', "/");
        let asks = [
            "target_os",
            "target_family",
            "cfg(unix",
            "cfg(windows",
            "cfg(not(unix",
            "cfg!(windows",
            "cfg!(unix",
        ];
        if !CHOOSERS.contains(&name.as_str())
            && asks.iter().any(|ask| without_tests(&code).contains(ask))
        {
            wrong.push(name);
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_table_lists_the_parts_of_architecture_md() {
    let written = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("ARCHITECTURE.md"))
        .expect("ARCHITECTURE.md");
    for (part, _) in TABLE {
        assert!(
            written.contains(&format!("`src/{part}")),
            "ARCHITECTURE.md does not name `src/{part}`"
        );
    }
}
