//! Silences panic messages while the window opens: the panic becomes an error with a message of its own.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind, set_hook, take_hook};
use std::rc::Rc;

type Hook = Box<dyn Fn(&PanicHookInfo<'_>) + Sync + Send + 'static>;

/// The panic hook that was installed before.
pub(super) struct QuietPanics(Cell<Option<Hook>>);

impl QuietPanics {
    fn install() -> Self {
        let previous = take_hook();
        set_hook(Box::new(|_| {}));
        Self(Cell::new(Some(previous)))
    }

    /// Prints panics again, from here on.
    pub(super) fn restore(&self) {
        if let Some(previous) = self.0.take() {
            set_hook(previous);
        }
    }
}

/// Runs `start` with panics silenced until `start` restores the hook or ends in any way.
///
/// # Errors
/// The message of the panic that ended `start`.
pub(super) fn catch<T>(start: impl FnOnce(Rc<QuietPanics>) -> T) -> Result<T, String> {
    let quiet = Rc::new(QuietPanics::install());
    let inner = Rc::clone(&quiet);
    let result = catch_unwind(AssertUnwindSafe(|| start(inner)));
    quiet.restore();
    result.map_err(|panic| {
        let text = panic.downcast_ref::<&str>().copied();
        let text = text.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
        text.unwrap_or("a library is missing").to_owned()
    })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    /// Counts this thread's panics from here on.
    fn count_panics() -> Arc<AtomicUsize> {
        let count = Arc::new(AtomicUsize::new(0));
        let (counter, thread, previous) =
            (Arc::clone(&count), std::thread::current().id(), take_hook());
        set_hook(Box::new(move |info| {
            if std::thread::current().id() == thread {
                counter.fetch_add(1, Ordering::Relaxed);
            }
            previous(info);
        }));
        count
    }

    #[test]
    fn the_panic_hook_is_restored_when_a_start_fails_panics_or_succeeds() {
        let count = count_panics();
        let panic = || drop(catch_unwind(|| panic!("counted")));
        assert_eq!(
            catch(|_quiet| Err::<(), _>("no display")),
            Ok(Err("no display"))
        );
        panic();
        assert_eq!(count.load(Ordering::Relaxed), 1, "after an early error");
        let missing: Result<(), _> = catch(|_quiet| panic!("lib{} is missing", "xkbcommon"));
        assert_eq!(missing, Err("libxkbcommon is missing".to_owned()));
        panic();
        assert_eq!(count.load(Ordering::Relaxed), 2, "after a silent panic");
        let restored = catch(|quiet| {
            quiet.restore();
            panic();
        });
        assert_eq!((restored, count.load(Ordering::Relaxed)), (Ok(()), 3));
    }
}
