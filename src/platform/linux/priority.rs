//! The priority of the threads between a frame and its events.
//!
//! On a busy computer a game and gelpad compete for the processor, and an event waits for the other's turn (12 ms at the 99th
//! percentile with two busy programs on two cores, 4 ms with this). Root and users with a limit of `nice` may ask for more; for
//! all others RealtimeKit does, where a desktop has it for its sound server. It is asked through `busctl`, and nothing waits for
//! its answer.

/// What is asked for; what the desktop's own sound server has.
const NICENESS: i32 = -10;

/// Lets the calling thread run before ordinary programs, if the system allows it; else it stays as it is.
pub fn raise() {
    // On Linux, none stands for the calling thread.
    if rustix::process::setpriority_process(None, NICENESS).is_err()
        && let Err(error) = ask_realtime_kit()
    {
        tracing::debug!("no higher priority: {error}");
    }
}

/// Asks RealtimeKit to raise the calling thread.
fn ask_realtime_kit() -> std::io::Result<()> {
    use std::process::{Command, Stdio};
    // PROCESS/task/THREAD
    let own = std::fs::read_link("/proc/thread-self")?;
    let thread = own.file_name().ok_or(std::io::ErrorKind::NotFound)?;
    let mut request = Command::new("busctl")
        .args(["--system", "call", "org.freedesktop.RealtimeKit1"])
        .args([
            "/org/freedesktop/RealtimeKit1",
            "org.freedesktop.RealtimeKit1",
        ])
        .args(["MakeThreadHighPriorityWithPID", "tti"])
        .arg(std::process::id().to_string())
        .arg(thread)
        .args(["--", &NICENESS.to_string()])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()?;
    let waiting = std::thread::Builder::new().name("priority".to_owned());
    waiting.spawn(move || request.wait()).map(drop)
}

/// What threads that solve pads have: they give way to play and to games.
const LOW_NICENESS: i32 = 10;

/// Lets ordinary programs run before the calling thread.
pub fn lower() {
    if let Err(error) = rustix::process::setpriority_process(None, LOW_NICENESS) {
        tracing::debug!("no lower priority: {error}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_calling_thread_is_raised() {
        let own = || rustix::process::getpriority_process(None).expect("a priority");
        let before = own();
        let other = std::thread::Builder::new().spawn(move || {
            raise();
            own()
        });
        let raised = other.expect("a thread").join().expect("ended");
        // An ordinary user may not be allowed to.
        assert!(raised == NICENESS || raised == before, "{raised}");
        assert_eq!(own(), before);
    }
}
