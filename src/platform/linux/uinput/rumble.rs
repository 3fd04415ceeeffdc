//! Rumble effects of games. The pad has no motors: effects are accepted, logged, and their strength can be queried.
//!
//! A game that uploads an effect waits for the answer, so a separate thread gives it. The thread ends when
//! its pipe closes.

use std::collections::BTreeMap;
use std::io;
use std::os::fd::OwnedFd;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use evdev::uinput::VirtualDevice;
use evdev::{EventSummary, FFEffectKind, FFStatusCode, InputEvent, UInputCode};
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::output::now;

/// Full strength of a motor.
const FULL: f32 = u16::MAX as f32;
const PLAYING: i32 = FFStatusCode::FF_STATUS_PLAYING.0 as i32;

/// The motors' state and the thread that maintains it.
pub(super) struct Rumble {
    state: Arc<AtomicU32>,
    thread: Option<(OwnedFd, JoinHandle<()>)>,
}

/// An effect that a game has uploaded.
#[derive(Clone, Copy, Debug)]
struct Effect {
    strong: u16,
    weak: u16,
    length: Duration,
}

impl Rumble {
    /// Starts the thread for a device.
    pub(super) fn listen(device: &Arc<Mutex<VirtualDevice>>) -> io::Result<Self> {
        let state = Arc::new(AtomicU32::new(0));
        let fd = {
            let device = device.lock().unwrap_or_else(PoisonError::into_inner);
            let flags = rustix::fs::fcntl_getfl(&*device)?;
            rustix::fs::fcntl_setfl(&*device, flags | rustix::fs::OFlags::NONBLOCK)?;
            rustix::io::fcntl_dupfd_cloexec(&*device, 0)?
        };
        let (ending, end) = rustix::pipe::pipe_with(rustix::pipe::PipeFlags::CLOEXEC)?;
        let (device, shown) = (Arc::downgrade(device), Arc::clone(&state));
        let thread = Builder::new().name("rumble".to_owned()).spawn(move || {
            let mut motors = Motors {
                effects: BTreeMap::new(),
                shown,
                ends: None,
            };
            while motors.wait(&fd, &ending) {
                let Some(device) = device.upgrade() else {
                    return;
                };
                let mut device = device.lock().unwrap_or_else(PoisonError::into_inner);
                if let Err(error) = motors.answer(&mut device) {
                    tracing::debug!("rumble: {error}");
                    return;
                }
            }
        })?;
        Ok(Self {
            state,
            thread: Some((end, thread)),
        })
    }

    /// Strength of the strong and the weak motor, 0..1.
    pub(super) fn strength(&self) -> [f32; 2] {
        let state = self.state.load(Ordering::Relaxed);
        [state >> 16, state & 0xffff].map(|strength| strength as f32 / FULL)
    }
}

impl Drop for Rumble {
    fn drop(&mut self) {
        if let Some((end, thread)) = self.thread.take() {
            drop(end);
            // The thread returns nothing; a panic was already reported.
            let _ = thread.join();
        }
    }
}

struct Motors {
    effects: BTreeMap<u16, Effect>,
    shown: Arc<AtomicU32>,
    /// When the effect that plays ends, if it has a length.
    ends: Option<Instant>,
}

impl Motors {
    /// Waits until a game sends something or an effect ends; returns whether to continue.
    fn wait(&mut self, fd: &OwnedFd, ending: &OwnedFd) -> bool {
        let left = self.ends.map(|ends| ends.saturating_duration_since(now()));
        let left = left.and_then(|left| Timespec::try_from(left).ok());
        let mut waited = [
            PollFd::new(fd, PollFlags::IN),
            PollFd::new(ending, PollFlags::IN),
        ];
        // An interrupted wait is simply repeated.
        let _ = poll(&mut waited, left.as_ref());
        let is_over = !waited[1].revents().is_empty();
        if self.ends.is_some_and(|ends| ends <= now()) {
            self.stop();
        }
        !is_over
    }

    fn answer(&mut self, device: &mut VirtualDevice) -> io::Result<()> {
        let events: Vec<InputEvent> = match device.fetch_events() {
            Ok(events) => events.collect(),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => return Ok(()),
            Err(error) => return Err(error),
        };
        for event in events {
            match event.destructure() {
                EventSummary::UInput(event, UInputCode::UI_FF_UPLOAD, _) => {
                    let mut upload = device.process_ff_upload(event)?;
                    let effect = upload.effect();
                    if let FFEffectKind::Rumble {
                        strong_magnitude,
                        weak_magnitude,
                    } = effect.kind
                    {
                        let effect = Effect {
                            strong: strong_magnitude,
                            weak: weak_magnitude,
                            length: Duration::from_millis(effect.replay.length.into()),
                        };
                        self.effects.insert(upload.effect_id() as u16, effect);
                        upload.set_retval(0);
                    } else {
                        upload.set_retval(-rustix::io::Errno::INVAL.raw_os_error());
                    }
                }
                EventSummary::UInput(event, UInputCode::UI_FF_ERASE, _) => {
                    let mut erase = device.process_ff_erase(event)?;
                    self.effects.remove(&(erase.effect_id() as u16));
                    erase.set_retval(0);
                }
                EventSummary::ForceFeedback(_, effect, value) => {
                    self.play(effect.0, value == PLAYING)
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn play(&mut self, id: u16, is_on: bool) {
        let Some(effect) = self.effects.get(&id).copied().filter(|_| is_on) else {
            return self.stop();
        };
        let state = u32::from(effect.strong) << 16 | u32::from(effect.weak);
        self.shown.store(state, Ordering::Relaxed);
        // Without a length the effect plays until it is stopped.
        self.ends = (!effect.length.is_zero()).then(|| now() + effect.length);
        tracing::info!(
            "rumble: strong {:.2}, weak {:.2}, {} ms",
            f32::from(effect.strong) / FULL,
            f32::from(effect.weak) / FULL,
            effect.length.as_millis()
        );
    }

    fn stop(&mut self) {
        self.shown.store(0, Ordering::Relaxed);
        self.ends = None;
    }
}
