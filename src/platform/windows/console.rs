//! The console: colours in cmd.exe and PowerShell, and no console window behind gelpad's own.
#![allow(unsafe_code, reason = "no safe interface changes a console")]

use windows_sys::Win32::Foundation::{HANDLE, INVALID_HANDLE_VALUE};
use windows_sys::Win32::System::Console::{
    ENABLE_VIRTUAL_TERMINAL_PROCESSING, FreeConsole, GetConsoleMode, GetConsoleProcessList,
    GetStdHandle, STD_ERROR_HANDLE, STD_OUTPUT_HANDLE, SetConsoleMode,
};

/// Prepares the console for coloured text. A file or a pipe stays as it is.
pub fn prepare() {
    for stream in [STD_OUTPUT_HANDLE, STD_ERROR_HANDLE] {
        // SAFETY: the call takes a number and returns a handle that stays the process's.
        let handle: HANDLE = unsafe { GetStdHandle(stream) };
        if handle.is_null() || handle == INVALID_HANDLE_VALUE {
            continue;
        }
        let mut mode = 0;
        // SAFETY: `mode` outlives the call; a handle that is not a console is refused.
        if unsafe { GetConsoleMode(handle, &raw mut mode) } != 0 {
            // SAFETY: as above. Consoles before Windows 10 refuse, and colours stay off.
            unsafe { SetConsoleMode(handle, mode | ENABLE_VIRTUAL_TERMINAL_PROCESSING) };
        }
    }
}

/// Closes a console that was opened for this program alone: one started from the Explorer has a window of its own.
pub fn close_own() {
    let mut users = [0; 2];
    // SAFETY: the length is that of the array.
    let count = unsafe { GetConsoleProcessList(users.as_mut_ptr(), users.len() as u32) };
    if count == 1 {
        // SAFETY: the standard library ignores writes to a console that is gone.
        unsafe { FreeConsole() };
    }
}
