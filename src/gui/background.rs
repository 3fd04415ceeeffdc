//! Work on a thread of its own, whose result the window takes while it draws.

use std::io;
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};

/// Work whose result is not taken yet. Dropping it discards the result; the thread ends when its work is done.
pub(super) struct Background<T>(Receiver<T>);

impl<T: Send + 'static> Background<T> {
    /// Starts the work.
    ///
    /// # Errors
    /// The system cannot create a thread.
    pub(super) fn start(name: &str, work: impl FnOnce() -> T + Send + 'static) -> io::Result<Self> {
        Self::start_then(name, work, || ())
    }

    /// As [`Self::start`]; calls `then` on the thread when the result can be taken.
    ///
    /// # Errors
    /// The system cannot create a thread.
    pub(super) fn start_then(
        name: &str,
        work: impl FnOnce() -> T + Send + 'static,
        then: impl FnOnce() + Send + 'static,
    ) -> io::Result<Self> {
        let (sender, receiver) = sync_channel(1);
        let thread = std::thread::Builder::new().name(name.to_owned());
        thread.spawn(move || {
            // The receiver is gone if the result is no longer wanted.
            let _ = sender.send(work());
            then();
        })?;
        Ok(Self(receiver))
    }
}

/// Takes the result when the work has ended; `died` gives that of a thread which panicked.
pub(super) fn take_result<T>(
    work: &mut Option<Background<T>>,
    died: impl FnOnce() -> T,
) -> Option<T> {
    let result = match work.as_ref()?.0.try_recv() {
        Err(TryRecvError::Empty) => return None,
        Err(TryRecvError::Disconnected) => died(),
        Ok(result) => result,
    };
    *work = None;
    Some(result)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wait(work: &mut Option<Background<u32>>) -> u32 {
        loop {
            if let Some(result) = take_result(work, || 0) {
                return result;
            }
            std::thread::yield_now();
        }
    }

    #[test]
    fn the_result_is_taken_once() {
        let mut work = Some(Background::start("test", || 7).expect("a thread"));
        assert_eq!(wait(&mut work), 7);
        assert!(take_result(&mut work, || 0).is_none());
    }

    #[test]
    fn a_thread_that_panics_gives_the_other_result() {
        // Without the message of a panic, and without the hook, which other tests replace.
        let panic = || std::panic::resume_unwind(Box::new("on purpose"));
        let mut work = Some(Background::start("test", panic).expect("a thread"));
        assert_eq!(wait(&mut work), 0);
    }
}
