//! The Wayland desktop: whether it lets programs press keys.
//!
//! Asked in Wayland's own wire format, which takes two requests: which protocols are there? (wayland-book.com, "Wire
//! protocol": object, size and opcode, arguments; all words in the machine's byte order.)

use std::io::{self, Read as _, Write as _};
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::time::Duration;

use super::{Line, Machine};

const SUBJECT: &str = "Wayland";
/// The protocol by which a program presses keys.
const PROTOCOL: &str = "zwp_virtual_keyboard_manager_v1";
/// Longest wait for an answer.
const PATIENCE: Duration = Duration::from_secs(2);
/// Objects: the display is 1; we name the registry and the callback.
const DISPLAY: u32 = 1;
const REGISTRY: u32 = 2;
const CALLBACK: u32 = 3;
/// Requests of the display.
const SYNC: u32 = 0;
const GET_REGISTRY: u32 = 1;

/// What is known of the desktop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Compositor {
    /// None is named.
    Unnamed,
    /// It does not answer, and why.
    Silent(String, String),
    /// It lets no program press keys.
    WithoutProtocol(String),
    /// It would take keys.
    Works(String),
}

impl Compositor {
    pub(super) fn works(&self) -> bool {
        matches!(self, Self::Works(_))
    }
}

pub(super) fn look(machine: &Machine) -> Compositor {
    let Some(name) = machine.setting("WAYLAND_DISPLAY").map(str::to_owned) else {
        return Compositor::Unnamed;
    };
    // An absolute name stands for itself.
    let folder = machine.setting("XDG_RUNTIME_DIR").unwrap_or("/run");
    let socket = PathBuf::from(folder).join(&name);
    match globals(&socket) {
        Ok(globals) if globals.iter().any(|global| global == PROTOCOL) => Compositor::Works(name),
        Ok(_) => Compositor::WithoutProtocol(name),
        Err(error) => Compositor::Silent(name, error.to_string()),
    }
}

/// The protocols that a compositor offers.
fn globals(socket: &std::path::Path) -> io::Result<Vec<String>> {
    let mut stream = UnixStream::connect(socket)?;
    stream.set_read_timeout(Some(PATIENCE))?;
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
            // The callback: everything has been told.
            (CALLBACK, _) => return Ok(globals),
            // A global: number, length of its name with the final zero, name, version.
            (REGISTRY, 0) if body.len() > 8 => {
                let length = (word(&body, 4) as usize).saturating_sub(1);
                let name = body.get(8..8 + length).unwrap_or_default();
                globals.push(String::from_utf8_lossy(name).into_owned());
            }
            (DISPLAY, 0) => return Err(io::Error::other("it refused the question")),
            _ => {}
        }
    }
}

fn word(bytes: &[u8], at: usize) -> u32 {
    let mut word = [0; 4];
    word.copy_from_slice(&bytes[at..at + 4]);
    u32::from_ne_bytes(word)
}

pub(super) fn judge(compositor: &Compositor, built_in: bool) -> Line {
    match compositor {
        Compositor::Unnamed => Line::note(
            SUBJECT,
            "WAYLAND_DISPLAY is not set: no Wayland desktop here",
        ),
        Compositor::Silent(name, why) => Line::wrong(
            SUBJECT,
            format!("the desktop {name} does not answer ({why})"),
            "start gelpad from a terminal of the desktop, as the user who is logged in there",
        ),
        Compositor::WithoutProtocol(name) => Line::wrong(
            SUBJECT,
            format!("the desktop {name} lets no program press keys: it lacks {PROTOCOL}"),
            "play through the kernel, which reaches every desktop: gelpad doctor --install-rule",
        ),
        Compositor::Works(name) if built_in => Line::ok(
            SUBJECT,
            format!("the desktop {name} takes keys ({PROTOCOL})"),
        ),
        Compositor::Works(name) => Line::note(
            SUBJECT,
            format!(
                "the desktop {name} would take keys, but this gelpad was built without Wayland"
            ),
        )
        .mend("install libxkbcommon-dev, then cargo install --path . --features wayland"),
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::net::UnixListener;

    use super::*;
    use crate::doctor::State;

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

    /// A desktop that offers some protocols, as the format's description says.
    fn asked(offered: &[&str]) -> Compositor {
        let folder = tempfile::tempdir().expect("a folder");
        let listener = UnixListener::bind(folder.path().join("wayland-9")).expect("a socket");
        let mut said: Vec<u8> = offered
            .iter()
            .zip(1..)
            .flat_map(|(name, i)| global(i, name))
            .collect();
        said.extend(message(CALLBACK, 0, &7_u32.to_ne_bytes()));
        std::thread::scope(|scope| {
            scope.spawn(|| {
                let (mut stream, _) = listener.accept().expect("someone");
                stream.write_all(&said).expect("told");
                // Until it has read everything.
                let _ = stream.read(&mut [0; 64]);
                let _ = stream.read(&mut [0; 64]);
            });
            let settings = [
                ("WAYLAND_DISPLAY", "wayland-9"),
                ("XDG_RUNTIME_DIR", folder.path().to_str().expect("a path")),
            ];
            look(&Machine::under(std::path::Path::new("/"), &settings))
        })
    }

    #[test]
    fn a_desktop_takes_keys_if_it_offers_the_protocol() {
        let sway = asked(&["wl_compositor", PROTOCOL, "wl_seat"]);
        assert_eq!(sway, Compositor::Works("wayland-9".to_owned()));
        assert_eq!(judge(&sway, true).state, State::Ok);
        let unbuilt = judge(&sway, false);
        assert!(
            unbuilt
                .mend
                .is_some_and(|mend| mend.contains("--features wayland"))
        );
        let weston = asked(&["wl_compositor", "wl_seat"]);
        let line = judge(&weston, true);
        assert!(line.state == State::Wrong && line.found.contains(PROTOCOL));
        assert!(
            line.mend
                .is_some_and(|mend| mend.contains("--install-rule"))
        );
    }

    #[test]
    fn a_desktop_that_is_gone_is_told_from_none() {
        let nowhere = [("WAYLAND_DISPLAY", "/nowhere/at-all")];
        let gone = look(&Machine::under(std::path::Path::new("/"), &nowhere));
        assert_eq!(judge(&gone, true).state, State::Wrong);
        let none = look(&Machine::under(std::path::Path::new("/"), &[]));
        assert_eq!(judge(&none, true).state, State::Note);
    }
}
