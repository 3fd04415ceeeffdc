//! Watches text files on a thread of its own: a hung network share delays changes, never the caller.
//!
//! Files are read, not `stat`ed: no clock of a file system, no editor's way of saving and no network share can hide a
//! change. A text is delivered only after two reads at least `SETTLE` apart found it equal, so half-saved files are
//! not.

use std::io::{self, Read as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{Builder, sleep};
use std::time::Duration;

/// Time between reads: 30 a second.
const PERIOD: Duration = Duration::from_millis(33);
/// Time between the two reads of a changed file.
const SETTLE: Duration = Duration::from_millis(20);
/// Undelivered changes; while the queue is full, further changes wait in the thread.
const QUEUE: usize = 16;
/// Larger files are not profiles, bytes.
const MAX_BYTES: u64 = 1 << 20;

/// A file to watch.
#[derive(Clone, Debug)]
pub struct WatchedFile {
    /// Where it is.
    pub path: PathBuf,
    /// The text that the caller already has; `None` delivers whatever the file holds first.
    pub known: Option<String>,
}

/// A file holds another text than before.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileChange {
    /// The file, as given to [`FileWatcher::start`].
    pub path: PathBuf,
    /// The new text, or why the file cannot be read: deleted, for example.
    pub text: Result<String, String>,
}

/// The watching thread; dropping this stops it without waiting for it.
#[derive(Debug)]
pub struct FileWatcher {
    changes: Receiver<FileChange>,
    stop: Arc<AtomicBool>,
}

impl FileWatcher {
    /// Starts to watch. `notify` is called on the thread after a change was queued.
    ///
    /// # Errors
    /// The system cannot create a thread.
    pub fn start(files: Vec<WatchedFile>, notify: impl Fn() + Send + 'static) -> io::Result<Self> {
        let (sender, changes) = sync_channel(QUEUE);
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let mut files: Vec<FileState> = files.into_iter().map(FileState::new).collect();
        Builder::new()
            .name("file-watch".to_owned())
            .spawn(move || {
                while !stopped.load(Ordering::Relaxed) {
                    if poll_files(&mut files, &sender) {
                        notify();
                    }
                    let unsettled = files.iter().any(|file| file.candidate.is_some());
                    sleep(if unsettled { SETTLE } else { PERIOD });
                }
            })?;
        Ok(Self { changes, stop })
    }

    /// The next change, if there is one. Never blocks.
    #[must_use]
    pub fn try_recv(&self) -> Option<FileChange> {
        self.changes.try_recv().ok()
    }
}

impl Drop for FileWatcher {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

/// Text of a file, or why it cannot be read.
type Contents = Result<String, String>;

/// What is known about one file.
struct FileState {
    path: PathBuf,
    /// Delivered last, or known to the caller.
    delivered: Option<Contents>,
    /// Read once and different from `delivered`.
    candidate: Option<Contents>,
}

impl FileState {
    fn new(file: WatchedFile) -> Self {
        Self {
            path: file.path,
            delivered: file.known.map(Ok),
            candidate: None,
        }
    }

    /// Takes what a read found; whether it is new and was also found by the read before.
    fn is_settled_change(&mut self, found: &Contents) -> bool {
        if self.delivered.as_ref() == Some(found) {
            self.candidate = None;
            return false;
        }
        let settled = self.candidate.as_ref() == Some(found);
        self.candidate = Some(found.clone());
        settled
    }
}

/// Reads every file once and queues settled changes; whether there were any.
fn poll_files(files: &mut [FileState], sender: &SyncSender<FileChange>) -> bool {
    let mut queued = false;
    for file in files {
        let found = read_text(&file.path);
        if !file.is_settled_change(&found) {
            continue;
        }
        let change = FileChange {
            path: file.path.clone(),
            text: found.clone(),
        };
        // With a full queue the candidate stays and is queued after a later read.
        if sender.try_send(change).is_ok() {
            file.delivered = Some(found);
            file.candidate = None;
            queued = true;
        }
    }
    queued
}

fn read_text(path: &Path) -> Contents {
    let mut bytes = Vec::new();
    std::fs::File::open(path)
        .and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut bytes))
        .map_err(|error| format!("{}: {error}", path.display()))?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(format!("{}: larger than 1 MB", path.display()));
    }
    String::from_utf8(bytes).map_err(|_| format!("{}: not a UTF-8 text file", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(known: &str) -> FileState {
        FileState::new(WatchedFile {
            path: PathBuf::from("a.toml"),
            known: Some(known.to_owned()),
        })
    }

    fn settled(state: &mut FileState, reads: &[&str]) -> Vec<bool> {
        reads
            .iter()
            .map(|text| state.is_settled_change(&Ok((*text).to_owned())))
            .collect()
    }

    fn wait_for(watcher: &FileWatcher) -> FileChange {
        for _ in 0..1000 {
            if let Some(change) = watcher.try_recv() {
                return change;
            }
            sleep(Duration::from_millis(5));
        }
        panic!("no change within 5 s");
    }

    #[test]
    fn a_half_saved_text_is_never_delivered() {
        let reads = ["old", "half", "whole", "whole"];
        assert_eq!(
            settled(&mut state("old"), &reads),
            [false, false, false, true]
        );
    }

    #[test]
    fn a_text_that_changes_back_is_no_change() {
        let reads = ["new", "old", "new", "old"];
        assert_eq!(settled(&mut state("old"), &reads), [false; 4]);
    }

    #[test]
    fn a_full_queue_keeps_the_change_for_later() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut files: Vec<FileState> = ["a", "b"]
            .iter()
            .map(|name| {
                let path = folder.path().join(name);
                std::fs::write(&path, name).expect("written");
                FileState::new(WatchedFile { path, known: None })
            })
            .collect();
        let (sender, changes) = sync_channel(1);
        assert!(!poll_files(&mut files, &sender), "read once");
        assert!(poll_files(&mut files, &sender));
        assert_eq!(changes.try_recv().expect("a").text, Ok("a".to_owned()));
        assert!(poll_files(&mut files, &sender));
        assert_eq!(changes.try_recv().expect("b").text, Ok("b".to_owned()));
        assert!(!poll_files(&mut files, &sender), "everything is delivered");
    }

    #[test]
    fn saved_and_deleted_files_are_reported_and_a_dropped_watcher_ends_its_thread() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("mine.toml");
        std::fs::write(&path, "old").expect("written");
        let file = WatchedFile {
            path: path.clone(),
            known: Some("old".to_owned()),
        };
        let alive = Arc::new(());
        let in_thread = Arc::clone(&alive);
        let watcher = FileWatcher::start(vec![file], move || {
            let _ = &in_thread;
        })
        .expect("a thread");
        std::fs::write(&path, "new").expect("written");
        assert_eq!(wait_for(&watcher).text, Ok("new".to_owned()));
        std::fs::remove_file(&path).expect("removed");
        let gone = wait_for(&watcher);
        assert!(gone.text.is_err() && gone.path == path, "{gone:?}");
        drop(watcher);
        for _ in 0..1000 {
            if Arc::strong_count(&alive) == 1 {
                return;
            }
            sleep(Duration::from_millis(5));
        }
        panic!("the thread runs on");
    }
}
