//! The end of the session: the user logs off, or Windows shuts down.
//!
//! Windows tells it to the windows of a program, and not to the console's handler once a program has loaded the library of windows. So
//! a hidden window waits for it, in a thread of its own. When the window has answered, Windows ends the program: the answer waits.
#![allow(unsafe_code, reason = "windows have no safe interface")]

use std::io;
use std::ptr::{null, null_mut};
use std::sync::{Once, OnceLock};

use windows_sys::Win32::Foundation::{HWND, LPARAM, LRESULT, WPARAM};
use windows_sys::Win32::UI::WindowsAndMessaging::{
    CreateWindowExW, DefWindowProcW, DispatchMessageW, GWLP_WNDPROC, GetMessageW, MSG,
    SetWindowLongPtrW, WM_ENDSESSION, WM_QUERYENDSESSION, WS_OVERLAPPED,
};

/// Title of the hidden window.
const TITLE: &str = "gelpad waits for the end of the session\0";

static STARTED: Once = Once::new();
static ON_END: OnceLock<fn()> = OnceLock::new();

/// Calls a function, once, when the session ends; Windows ends the program after it has returned.
pub(super) fn listen(on_end: fn()) {
    STARTED.call_once(|| {
        ON_END.get_or_init(|| on_end);
        let thread = std::thread::Builder::new().name("session end".to_owned());
        if let Err(error) = thread.spawn(wait_for_messages) {
            tracing::debug!("the end of the session comes without notice: {error}");
        }
    });
}

/// Opens the window and serves it as long as the program runs.
fn wait_for_messages() {
    if let Err(error) = open_window() {
        tracing::debug!("the end of the session comes without notice: {error}");
        return;
    }
    // SAFETY: the structure holds numbers and pointers, for which zero is valid.
    let mut message: MSG = unsafe { std::mem::zeroed() };
    // SAFETY: the structure outlives the calls.
    unsafe {
        while GetMessageW(&raw mut message, null_mut(), 0, 0) > 0 {
            DispatchMessageW(&raw const message);
        }
    }
}

fn open_window() -> io::Result<()> {
    let class: Vec<u16> = "STATIC\0".encode_utf16().collect();
    let title: Vec<u16> = TITLE.encode_utf16().collect();
    // SAFETY: the strings end with 0 and outlive the call; the window belongs to this thread and lives as long.
    let window = unsafe {
        CreateWindowExW(
            0,
            class.as_ptr(),
            title.as_ptr(),
            WS_OVERLAPPED,
            0,
            0,
            0,
            0,
            null_mut(),
            null_mut(),
            null_mut(),
            null(),
        )
    };
    if window.is_null() {
        return Err(io::Error::last_os_error());
    }
    let procedure: unsafe extern "system" fn(HWND, u32, WPARAM, LPARAM) -> LRESULT = handle;
    // SAFETY: the function has the type that Windows calls, and lives as long as the program.
    unsafe { SetWindowLongPtrW(window, GWLP_WNDPROC, procedure as *const () as isize) };
    Ok(())
}

unsafe extern "system" fn handle(
    window: HWND,
    message: u32,
    wide: WPARAM,
    long: LPARAM,
) -> LRESULT {
    match message {
        // gelpad never keeps anybody from logging off.
        WM_QUERYENDSESSION => 1,
        // 0: another program does.
        WM_ENDSESSION if wide != 0 => {
            if let Some(on_end) = ON_END.get() {
                on_end();
            }
            0
        }
        // SAFETY: the arguments are those that Windows passed.
        _ => unsafe { DefWindowProcW(window, message, wide, long) },
    }
}
