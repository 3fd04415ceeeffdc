//! What the source does not say: the commit that is built, and whether gamepads are read.

use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed=GELPAD_COMMIT");
    let variable = |name: &str| std::env::var(name).ok();
    // Gamepads need a system package on Linux, and so a feature; on Windows they need nothing.
    println!("cargo:rustc-check-cfg=cfg(gamepads)");
    let is_windows = variable("CARGO_CFG_WINDOWS").is_some();
    if is_windows || variable("CARGO_FEATURE_GILRS").is_some() {
        println!("cargo:rustc-cfg=gamepads");
    }
    // A development build is not rebuilt at each commit, so it names none.
    let is_release = variable("PROFILE").is_some_and(|profile| profile == "release");
    let commit = variable("GELPAD_COMMIT").or_else(|| is_release.then(checked_out).flatten());
    let commit = commit.unwrap_or_else(|| "development build".to_owned());
    println!("cargo:rustc-env=GELPAD_COMMIT={commit}");
    let mut features: Vec<&str> = ["gui", "wayland"]
        .into_iter()
        .filter(|name| variable(&format!("CARGO_FEATURE_{}", name.to_uppercase())).is_some())
        .filter(|name| !(is_windows && *name == "wayland"))
        .collect();
    if is_windows || variable("CARGO_FEATURE_GILRS").is_some() {
        features.push("gamepads");
    }
    if is_windows && variable("CARGO_FEATURE_VIGEM").is_some() {
        features.push("virtual gamepad");
    }
    println!("cargo:rustc-env=GELPAD_FEATURES={}", features.join(", "));
}

/// The commit of the working folder: of git, or of the file that `cargo package` writes.
fn checked_out() -> Option<String> {
    // `HEAD` names a branch, and its log grows with each commit. A file that is missing would mean a build each time.
    for watched in [".git/HEAD", ".git/logs/HEAD"] {
        if std::path::Path::new(watched).exists() {
            println!("cargo:rerun-if-changed={watched}");
        }
    }
    if let Ok(text) = std::fs::read_to_string(".cargo_vcs_info.json") {
        let after = text.split("\"sha1\": \"").nth(1)?;
        return after.get(..12).map(str::to_owned);
    }
    let git = Command::new("git")
        .args([
            "describe",
            "--always",
            "--dirty",
            "--abbrev=12",
            "--exclude=*",
        ])
        .output()
        .ok()?;
    let commit = String::from_utf8(git.stdout).ok()?.trim().to_owned();
    (git.status.success() && !commit.is_empty()).then_some(commit)
}
