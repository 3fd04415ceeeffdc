//! What this gelpad was installed from: whoever reports a fault, or removes it, wants to know.

use std::path::Path;

use super::CheckLine;

const SUBJECT: &str = "installed from";

/// Names the package of this program by the place where its file lies.
pub(super) fn check() -> CheckLine {
    match std::env::current_exe() {
        Ok(own) => CheckLine::ok(SUBJECT, describe(&own, &|path| path.exists())),
        Err(error) => CheckLine::note(SUBJECT, format!("unknown: {error}")),
    }
}

/// `exists` tells whether a file is there.
fn describe(own: &Path, exists: &dyn Fn(&Path) -> bool) -> String {
    let beside = |name: &str| {
        own.parent()
            .is_some_and(|folder| exists(&folder.join(name)))
    };
    let holds = |name: &str| own.components().any(|part| part.as_os_str() == name);
    let kind = if exists(Path::new("/var/lib/dpkg/info/gelpad.list"))
        && own == Path::new("/usr/bin/gelpad")
    {
        "the Debian package"
    } else if beside("uninstall.exe") {
        "the installer"
    } else if beside("profile.schema.json") {
        "the zip file"
    } else if holds(".cargo") {
        "cargo install"
    } else if holds("target") {
        "built here"
    } else if beside("../share/gelpad/profile.schema.json") {
        "the tar.gz, by its script"
    } else {
        "a copied file"
    };
    format!(
        "{kind}: {} ({}; {})",
        own.display(),
        env!("GELPAD_COMMIT"),
        env!("GELPAD_FEATURES")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_place_of_the_program_names_its_package() {
        let kind = |own: &str, files: &[&str]| {
            let exists = |path: &Path| files.iter().any(|file| path == Path::new(file));
            let text = describe(Path::new(own), &exists);
            text.split(": ").next().unwrap_or_default().to_owned()
        };
        let list = "/var/lib/dpkg/info/gelpad.list";
        assert_eq!(kind("/usr/bin/gelpad", &[list]), "the Debian package");
        assert_eq!(kind("/home/a/.cargo/bin/gelpad", &[list]), "cargo install");
        assert_eq!(kind("/src/target/debug/gelpad", &[]), "built here");
        assert_eq!(
            kind("/apps/gelpad", &["/apps/uninstall.exe"]),
            "the installer"
        );
        assert_eq!(
            kind("/apps/gelpad", &["/apps/profile.schema.json"]),
            "the zip file"
        );
        assert_eq!(kind("/opt/gelpad", &[]), "a copied file");
    }
}
