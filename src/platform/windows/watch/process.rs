//! A watcher process: `gelpad watch` or `gelpad guard`, started by gelpad only. The protocol is described in `platform/watch/mod.rs`.
//!
//! Two things tell that the parent has ended: its process, of which this one has a handle, and the pipe. Nothing that the parent sent
//! with `SendInput` can arrive after that.

use std::io::{self, Read as _, Write as _};
use std::os::windows::io::OwnedHandle;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread::Builder;
use std::time::{Duration, Instant};

use crate::output::{HeldOutputs, OutputDevice as _, OutputError, now};
use crate::platform::ReleaseMethod;
use crate::platform::watch::parent_state::ParentState;
use crate::platform::watch::state::{self, StateFile};
use crate::platform::watch::{BEAT_LINE, READY, RELEASED, STOPPED};
use crate::platform::windows::keyboard::{WindowsKeyboard, is_accepting};
use crate::platform::windows::processes;
use crate::types::{Action, Event};

/// Name of the session's keyboard in the files of what is held.
const DISPLAY: &str = "windows";
/// After the parent's process has ended, its last lines are read for this long.
const LAST_LINES: Duration = Duration::from_millis(500);
/// While Windows refuses keys, because the screen is locked, releases are tried again for so long.
const LAST_WAIT: Duration = Duration::from_secs(3600);
const RETRY: Duration = Duration::from_millis(100);
/// Messages that wait.
const QUEUE: usize = 64;

enum Message {
    Bytes(Vec<u8>),
    ParentEnded,
}

/// Watches until the parent has ended.
///
/// # Errors
/// The way is not that of Windows, or there are no threads.
pub fn run_watcher(way: ReleaseMethod) -> Result<(), OutputError> {
    let ReleaseMethod::Keys { parent } = way else {
        return Err(OutputError::NoDevice {
            device: "watcher",
            reason: "displays are for Linux".to_owned(),
        });
    };
    let process = processes::open(parent);
    let messages = listen(process).map_err(pipe_error)?;
    let state = state::folder().and_then(|folder| {
        StateFile::create(&folder, DISPLAY, i32::try_from(parent).unwrap_or(0)).ok()
    });
    let mut releaser = Releaser {
        keyboard: WindowsKeyboard::connect(),
        state,
    };
    releaser.release_left_down(false)?;
    answer(READY, 1).map_err(pipe_error)?;
    let mut watched = ParentState::default();
    let mut last_read = now();
    let mut is_silent = false;
    loop {
        // While nothing is down, silence does not matter.
        let matters = !watched.held.is_empty() && !is_silent;
        let limit = matters.then(|| last_read + STOPPED);
        match next(&messages, limit) {
            Some(Message::Bytes(bytes)) => {
                last_read = now();
                is_silent = false;
                let beats = watched.feed(&bytes);
                releaser.record(&watched.held, false);
                // If the parent has ended, the next message shows it.
                let _ = answer(BEAT_LINE, beats);
            }
            None => {
                is_silent = true;
                releaser.release(&watched.held)?;
                let _ = answer(RELEASED, 1);
            }
            Some(Message::ParentEnded) => {
                let until = now() + LAST_LINES;
                while let Some(Message::Bytes(bytes)) = next(&messages, Some(until)) {
                    watched.feed(&bytes);
                }
                if !watched.held.is_empty() {
                    releaser.record(&watched.held, true);
                    releaser.release(&watched.held)?;
                }
                return releaser.release_left_down(true);
            }
        }
    }
}

/// Messages of the pipe and of the parent's process, each of which has a thread that waits for it.
fn listen(process: Option<OwnedHandle>) -> io::Result<Receiver<Message>> {
    let (sender, receiver) = sync_channel(QUEUE);
    let from_pipe = SyncSender::clone(&sender);
    Builder::new().name("pipe".to_owned()).spawn(move || {
        let mut input = io::stdin().lock();
        let mut bytes = [0; 4096];
        while let Ok(count) = input.read(&mut bytes)
            && count > 0
            && from_pipe
                .send(Message::Bytes(bytes[..count].to_vec()))
                .is_ok()
        {}
        let _ = from_pipe.send(Message::ParentEnded);
    })?;
    if let Some(process) = process {
        Builder::new().name("parent".to_owned()).spawn(move || {
            while !processes::wait(&process, u32::MAX) {}
            let _ = sender.send(Message::ParentEnded);
        })?;
    }
    Ok(receiver)
}

/// The next message; none if the limit passes before.
fn next(messages: &Receiver<Message>, limit: Option<Instant>) -> Option<Message> {
    let Some(limit) = limit else {
        return Some(messages.recv().unwrap_or(Message::ParentEnded));
    };
    match messages.recv_timeout(limit.saturating_duration_since(now())) {
        Ok(message) => Some(message),
        Err(RecvTimeoutError::Timeout) => None,
        Err(RecvTimeoutError::Disconnected) => Some(Message::ParentEnded),
    }
}

/// Sends a line some times.
fn answer(line: &str, times: usize) -> io::Result<()> {
    let mut output = io::stdout().lock();
    output.write_all(format!("{line}\n").repeat(times).as_bytes())?;
    output.flush()
}

/// Releases what is down.
struct Releaser {
    keyboard: WindowsKeyboard,
    state: Option<StateFile>,
}

impl Releaser {
    /// Releases what killed gelpads have left down.
    fn release_left_down(&mut self, parent_has_ended: bool) -> Result<(), OutputError> {
        let Some(state) = &self.state else {
            return Ok(());
        };
        for (path, held) in state.left_down(parent_has_ended) {
            self.send_releases(&held)?;
            state::remove(&path);
        }
        Ok(())
    }

    /// Records what is down on disk.
    fn record(&mut self, held: &HeldOutputs, has_ended: bool) {
        if let Some(state) = &mut self.state {
            state.set(held, has_ended);
        }
    }

    fn release(&mut self, held: &HeldOutputs) -> Result<(), OutputError> {
        let mut held = held.clone();
        if let Some(state) = &self.state {
            let others = state.held_by_others();
            others.iter().for_each(|output| held.release(output));
        }
        self.send_releases(&held)
    }

    /// Sends releases, as soon as Windows takes them.
    fn send_releases(&mut self, held: &HeldOutputs) -> Result<(), OutputError> {
        let until = now() + LAST_WAIT;
        while !is_accepting() && now() < until {
            std::thread::sleep(RETRY);
        }
        for output in held.iter() {
            self.keyboard.send(&Event {
                t_ns: 0,
                action: Action::Release(output),
            })?;
        }
        self.keyboard.flush()
    }
}

fn pipe_error(error: io::Error) -> OutputError {
    OutputError::Refused {
        device: "watcher's pipe",
        reason: error.to_string(),
    }
}
