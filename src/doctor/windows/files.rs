//! Whether gelpad's files can be written and replaced: virus scanners and protected folders refuse it.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::doctor::CheckLine;
use crate::platform::files::rename;

const SUBJECT: &str = "own files";

pub(super) fn check() -> CheckLine {
    let Some(folders) = directories::ProjectDirs::from("", "", "gelpad") else {
        return CheckLine::wrong(SUBJECT, "this user has no folders", "log in as a user");
    };
    let folder = folders.config_dir().to_owned();
    judge(&folder, replace_a_file(&folder))
}

/// Writes a file, opens it, and replaces it.
fn replace_a_file(folder: &Path) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    let path =
        |end: &str| -> PathBuf { folder.join(format!("doctor-{}.{end}", std::process::id())) };
    let (file, fresh) = (path("tmp"), path("new"));
    let attempt = || {
        fs::write(&file, "old")?;
        let _reader = fs::File::open(&file)?;
        fs::write(&fresh, "new")?;
        rename(&fresh, &file)
    };
    let done = attempt();
    let _ = fs::remove_file(&fresh);
    let _ = fs::remove_file(&file);
    done
}

fn judge(folder: &Path, replaced: io::Result<()>) -> CheckLine {
    match replaced {
        Ok(()) => CheckLine::ok(SUBJECT, format!("{} can be written", folder.display())),
        Err(error) => CheckLine::wrong(
            SUBJECT,
            format!("{}: {error}", folder.display()),
            "allow gelpad in Windows Security: Virus & threat protection, Ransomware protection, Controlled folder access",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_open_file_can_be_replaced() {
        let folder = tempfile::tempdir().expect("a folder");
        replace_a_file(folder.path()).expect("replaced");
        let left = fs::read_dir(folder.path()).expect("read").count();
        assert_eq!(left, 0);
    }
}
