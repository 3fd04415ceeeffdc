//! The Wayland desktop: whether it lets programs press keys.
//!
//! Lists the compositor's protocols with two requests of the wire protocol (wayland-book.com, "Wire protocol": object,
//! size and opcode, arguments; words in native byte order).

use std::io::{self, Read as _, Write as _};
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::time::Duration;

use super::Machine;
use crate::doctor::CheckLine;

const SUBJECT: &str = "Wayland";
/// The protocol for pressing keys.
const PROTOCOL: &str = "zwp_virtual_keyboard_manager_v1";
/// Longest wait for an answer.
const TIMEOUT: Duration = Duration::from_secs(2);
/// Object ids: the display is always 1, the others are ours.
const DISPLAY: u32 = 1;
const REGISTRY: u32 = 2;
const CALLBACK: u32 = 3;
/// Requests of the display.
const SYNC: u32 = 0;
const GET_REGISTRY: u32 = 1;

/// CheckStatus of the Wayland compositor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Compositor {
    /// `WAYLAND_DISPLAY` is not set.
    NotSet,
    /// Does not answer: name, reason.
    Silent(String, String),
    /// Lacks [`PROTOCOL`].
    WithoutProtocol(String),
    /// Accepts keys.
    Works(String),
}

impl Compositor {
    pub(super) fn works(&self) -> bool {
        matches!(self, Self::Works(_))
    }
}

pub(super) fn examine(machine: &Machine) -> Compositor {
    let Some(name) = machine.variable("WAYLAND_DISPLAY").map(str::to_owned) else {
        return Compositor::NotSet;
    };
    // An absolute name replaces the folder.
    let folder = machine.variable("XDG_RUNTIME_DIR").unwrap_or("/run");
    let socket = PathBuf::from(folder).join(&name);
    match globals(&socket) {
        Ok(globals) if globals.iter().any(|global| global == PROTOCOL) => Compositor::Works(name),
        Ok(_) => Compositor::WithoutProtocol(name),
        Err(error) => Compositor::Silent(name, error.to_string()),
    }
}

/// Names of the protocols that a compositor offers.
fn globals(socket: &std::path::Path) -> io::Result<Vec<String>> {
    let mut stream = UnixStream::connect(socket)?;
    stream.set_read_timeout(Some(TIMEOUT))?;
    let mut requests = Vec::new();
    for (opcode, object) in [(GET_REGISTRY, REGISTRY), (SYNC, CALLBACK)] {
        for word in [DISPLAY, 12 << 16 | opcode, object] {
            requests.extend(word.to_ne_bytes());
        }
    }
    stream.write_all(&requests)?;
    let mut globals = Vec::new();
    loop {
        let mut head = [0; 8];
        stream.read_exact(&mut head)?;
        let object = word(&head, 0);
        let (size, opcode) = (word(&head, 4) >> 16, word(&head, 4) & 0xffff);
        let mut body = vec![0; (size as usize).saturating_sub(head.len())];
        stream.read_exact(&mut body)?;
        match (object, opcode) {
            // The sync callback: the list is complete.
            (CALLBACK, _) => return Ok(globals),
            // A global: number, length of its name with the final NUL, name, version.
            (REGISTRY, 0) if body.len() > 8 => {
                let length = (word(&body, 4) as usize).saturating_sub(1);
                let name = body.get(8..8 + length).unwrap_or_default();
                globals.push(String::from_utf8_lossy(name).into_owned());
            }
            (DISPLAY, 0) => return Err(io::Error::other("the request was refused")),
            _ => {}
        }
    }
}

fn word(bytes: &[u8], at: usize) -> u32 {
    let mut word = [0; 4];
    word.copy_from_slice(&bytes[at..at + 4]);
    u32::from_ne_bytes(word)
}

pub(super) fn judge(compositor: &Compositor, built_in: bool) -> CheckLine {
    match compositor {
        Compositor::NotSet => {
            CheckLine::note(SUBJECT, "no Wayland desktop: WAYLAND_DISPLAY is not set")
        }
        Compositor::Silent(name, why) => CheckLine::wrong(
            SUBJECT,
            format!("desktop {name} does not answer ({why})"),
            "start gelpad from a terminal of the desktop, as the logged-in user",
        ),
        Compositor::WithoutProtocol(name) => CheckLine::wrong(
            SUBJECT,
            format!("desktop {name} does not let programs press keys: it lacks {PROTOCOL}"),
            "use kernel devices, which work on every desktop: gelpad doctor --install-rule",
        ),
        Compositor::Works(name) if built_in => {
            CheckLine::ok(SUBJECT, format!("desktop {name} accepts keys ({PROTOCOL})"))
        }
        Compositor::Works(name) => CheckLine::note(
            SUBJECT,
            format!("desktop {name} would accept keys, but this gelpad was built without Wayland"),
        )
        .with_fix("install libxkbcommon-dev, then cargo install --path . --features wayland"),
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::net::UnixListener;

    use super::*;
    use crate::doctor::CheckStatus;

    fn message(object: u32, opcode: u32, body: &[u8]) -> Vec<u8> {
        let size = (8 + body.len()) as u32;
        let words = [object, size << 16 | opcode].map(u32::to_ne_bytes);
        [words.concat().as_slice(), body].concat()
    }

    fn global(number: u32, name: &str) -> Vec<u8> {
        let length = name.len() + 1;
        let mut body = [number, length as u32].map(u32::to_ne_bytes).concat();
        body.extend(name.bytes());
        body.resize(8 + length.next_multiple_of(4), 0);
        body.extend(1_u32.to_ne_bytes());
        message(REGISTRY, 0, &body)
    }

    /// What is found about a compositor that offers these protocols.
    fn compositor_with(offered: &[&str]) -> Compositor {
        let folder = tempfile::tempdir().expect("a folder");
        let listener = UnixListener::bind(folder.path().join("wayland-9")).expect("a socket");
        let mut answer: Vec<u8> = offered
            .iter()
            .zip(1..)
            .flat_map(|(name, i)| global(i, name))
            .collect();
        answer.extend(message(CALLBACK, 0, &7_u32.to_ne_bytes()));
        std::thread::scope(|scope| {
            scope.spawn(|| {
                let (mut stream, _) = listener.accept().expect("a client");
                stream.write_all(&answer).expect("sent");
                // Wait until the client has read everything.
                let _ = stream.read(&mut [0; 64]);
                let _ = stream.read(&mut [0; 64]);
            });
            let settings = [
                ("WAYLAND_DISPLAY", "wayland-9"),
                ("XDG_RUNTIME_DIR", folder.path().to_str().expect("a path")),
            ];
            examine(&Machine::at_root(std::path::Path::new("/"), &settings))
        })
    }

    #[test]
    fn the_protocol_decides_whether_keys_are_accepted() {
        let sway = compositor_with(&["wl_compositor", PROTOCOL, "wl_seat"]);
        assert_eq!(sway, Compositor::Works("wayland-9".to_owned()));
        assert_eq!(judge(&sway, true).state, CheckStatus::Ok);
        let unbuilt = judge(&sway, false);
        assert!(
            unbuilt
                .fix
                .is_some_and(|fix| fix.contains("--features wayland"))
        );
        let weston = compositor_with(&["wl_compositor", "wl_seat"]);
        let line = judge(&weston, true);
        assert!(line.state == CheckStatus::Wrong && line.found.contains(PROTOCOL));
        assert!(line.fix.is_some_and(|fix| fix.contains("--install-rule")));
    }

    #[test]
    fn a_dead_desktop_is_a_fault_and_no_desktop_is_not() {
        let nowhere = [("WAYLAND_DISPLAY", "/nowhere/at-all")];
        let gone = examine(&Machine::at_root(std::path::Path::new("/"), &nowhere));
        assert_eq!(judge(&gone, true).state, CheckStatus::Wrong);
        let none = examine(&Machine::at_root(std::path::Path::new("/"), &[]));
        assert_eq!(judge(&none, true).state, CheckStatus::Note);
    }
}
