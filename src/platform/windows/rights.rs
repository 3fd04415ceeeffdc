//! Rights of programs: Windows drops keys that a program sends to one with more rights (user interface privilege isolation).
#![allow(
    unsafe_code,
    reason = "no safe interface reads the rights of a process"
)]

use std::os::windows::io::{AsRawHandle as _, FromRawHandle as _, OwnedHandle};

use windows_sys::Win32::Foundation::HANDLE;
use windows_sys::Win32::Security::{
    GetTokenInformation, TOKEN_ELEVATION, TOKEN_QUERY, TokenElevation,
};
use windows_sys::Win32::System::Threading::{
    GetCurrentProcess, OpenProcess, OpenProcessToken, PROCESS_QUERY_LIMITED_INFORMATION,
};
use windows_sys::Win32::UI::WindowsAndMessaging::{GetForegroundWindow, GetWindowThreadProcessId};

/// What a program may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rights {
    /// What its user may do.
    User,
    /// Everything.
    Administrator,
}

/// Rights of this program.
#[must_use]
pub fn own_rights() -> Rights {
    // SAFETY: the handle stands for this process and needs no closing.
    let own = unsafe { GetCurrentProcess() };
    token_rights(own).unwrap_or(Rights::User)
}

/// Rights of the program in the foreground; none without one. A program that does not let itself be examined has more rights.
#[must_use]
pub fn foreground_rights() -> Option<Rights> {
    let mut process = 0;
    // SAFETY: the window may be gone by the second call, which then leaves the number 0.
    unsafe {
        let window = GetForegroundWindow();
        if window.is_null() {
            return None;
        }
        GetWindowThreadProcessId(window, &raw mut process);
    }
    if process == 0 {
        return None;
    }
    // SAFETY: the call takes numbers and returns a handle, or null.
    let handle = unsafe { OpenProcess(PROCESS_QUERY_LIMITED_INFORMATION, 0, process) };
    if handle.is_null() {
        return Some(Rights::Administrator);
    }
    // SAFETY: nobody else has the handle.
    let handle = unsafe { OwnedHandle::from_raw_handle(handle) };
    Some(token_rights(handle.as_raw_handle()).unwrap_or(Rights::Administrator))
}

/// Rights of a process; none if they cannot be read.
fn token_rights(process: HANDLE) -> Option<Rights> {
    let mut token: HANDLE = std::ptr::null_mut();
    // SAFETY: the process's handle is open, and `token` outlives the call.
    if unsafe { OpenProcessToken(process, TOKEN_QUERY, &raw mut token) } == 0 {
        return None;
    }
    // SAFETY: nobody else has the handle.
    let token = unsafe { OwnedHandle::from_raw_handle(token) };
    let mut elevation = TOKEN_ELEVATION { TokenIsElevated: 0 };
    let mut length = 0;
    // SAFETY: the structure is the one that this class fills, its size is given, and it outlives the call.
    let is_read = unsafe {
        GetTokenInformation(
            token.as_raw_handle(),
            TokenElevation,
            (&raw mut elevation).cast(),
            size_of::<TOKEN_ELEVATION>() as u32,
            &raw mut length,
        )
    };
    (is_read != 0).then_some(match elevation.TokenIsElevated {
        0 => Rights::User,
        _ => Rights::Administrator,
    })
}
