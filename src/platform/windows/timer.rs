//! Sleeps that end on time: without a request they end at the next tick of 15.6 ms.
#![allow(unsafe_code, reason = "no safe interface sets the period of the timer")]

use windows_sys::Win32::Media::{timeBeginPeriod, timeEndPeriod};

/// Requested period, ms: the shortest that Windows has.
const PERIOD_MS: u32 = 1;

/// Fine sleeps for as long as it lives.
#[derive(Debug)]
pub struct FineTimer(());

impl FineTimer {
    /// Requests fine sleeps.
    #[must_use]
    pub fn request() -> Self {
        // SAFETY: the call takes a number; it is undone when this is dropped.
        unsafe { timeBeginPeriod(PERIOD_MS) };
        Self(())
    }
}

impl Drop for FineTimer {
    fn drop(&mut self) {
        // SAFETY: it matches the request.
        unsafe { timeEndPeriod(PERIOD_MS) };
    }
}
