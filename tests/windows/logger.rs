//! A window that logs key messages.
#![allow(
    unsafe_code,
    reason = "windows and their messages have no safe interface"
)]

use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail, ensure};
use windows_sys::Win32::UI::Input::KeyboardAndMouse::SetFocus;
use windows_sys::Win32::UI::WindowsAndMessaging::{
    CreateWindowExW, DispatchMessageW, GetForegroundWindow, GetMessageW, MSG, SW_SHOW,
    SetForegroundWindow, ShowWindow, WM_KEYDOWN, WM_KEYUP, WM_SYSKEYDOWN, WM_SYSKEYUP,
    WS_OVERLAPPEDWINDOW, WS_VISIBLE,
};

/// Longest wait for a message.
pub const PATIENCE: Duration = Duration::from_secs(10);

/// A key message.
#[derive(Clone, Copy, Debug)]
pub struct KeyMessage {
    pub is_down: bool,
    pub scan_code: u16,
    pub is_extended: bool,
    pub virtual_key: u16,
    /// When the program had it.
    pub at: Instant,
}

/// The window's messages. The window lives as long as this program.
pub struct Logger {
    messages: Receiver<KeyMessage>,
}

impl Logger {
    /// Opens the window and waits until it has the focus.
    pub fn open() -> Result<Self> {
        let (sender, messages) = sync_channel(100_000);
        let (ready, is_ready) = sync_channel(1);
        std::thread::Builder::new().spawn(move || {
            let class: Vec<u16> = "STATIC\0".encode_utf16().collect();
            // SAFETY: the strings end with 0 and outlive the calls; the window belongs to this thread.
            let has_focus = unsafe {
                let window = CreateWindowExW(
                    0,
                    class.as_ptr(),
                    class.as_ptr(),
                    WS_OVERLAPPEDWINDOW | WS_VISIBLE,
                    10,
                    10,
                    300,
                    200,
                    std::ptr::null_mut(),
                    std::ptr::null_mut(),
                    std::ptr::null_mut(),
                    std::ptr::null(),
                );
                ShowWindow(window, SW_SHOW);
                SetForegroundWindow(window);
                SetFocus(window);
                !window.is_null() && GetForegroundWindow() == window
            };
            let _ = ready.send(has_focus);
            // SAFETY: the structure holds numbers and pointers, for which zero is valid.
            let mut message: MSG = unsafe { std::mem::zeroed() };
            // SAFETY: the structure outlives the calls.
            while unsafe { GetMessageW(&raw mut message, std::ptr::null_mut(), 0, 0) } > 0 {
                if let Some(key) = key_message(&message) {
                    let _ = sender.try_send(key);
                }
                // The system's reactions to Alt and F10 (menus) would take the focus.
                if !matches!(message.message, WM_SYSKEYDOWN | WM_SYSKEYUP) {
                    // SAFETY: it is the message that was just received.
                    unsafe { DispatchMessageW(&raw const message) };
                }
            }
        })?;
        let has_focus = is_ready.recv_timeout(PATIENCE).context("no window")?;
        ensure!(has_focus, "the window has no focus");
        Ok(Self { messages })
    }

    /// The next message.
    pub fn next(&self) -> Result<KeyMessage> {
        self.within(PATIENCE)?.context("no key message arrived")
    }

    /// The next message, if one comes in time.
    pub fn within(&self, limit: Duration) -> Result<Option<KeyMessage>> {
        use std::sync::mpsc::RecvTimeoutError;
        match self.messages.recv_timeout(limit) {
            Ok(message) => Ok(Some(message)),
            Err(RecvTimeoutError::Timeout) => Ok(None),
            Err(RecvTimeoutError::Disconnected) => bail!("the window is gone"),
        }
    }

    /// Drops what has arrived so far.
    pub fn clear(&self) {
        while self.messages.try_recv().is_ok() {}
    }
}

fn key_message(message: &MSG) -> Option<KeyMessage> {
    let is_down = match message.message {
        WM_KEYDOWN | WM_SYSKEYDOWN => true,
        WM_KEYUP | WM_SYSKEYUP => false,
        _ => return None,
    };
    let bits = message.lParam;
    Some(KeyMessage {
        is_down,
        scan_code: ((bits >> 16) & 0xff) as u16,
        is_extended: (bits >> 24) & 1 == 1,
        virtual_key: message.wParam as u16,
        at: Instant::now(),
    })
}
