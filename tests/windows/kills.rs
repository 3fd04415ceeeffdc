//! gelpads that are killed in the middle of a press.
#![allow(
    unsafe_code,
    reason = "processes and the console have no safe interface"
)]

use std::os::windows::process::CommandExt as _;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, ensure};
use windows_sys::Win32::Foundation::{CloseHandle, INVALID_HANDLE_VALUE};
use windows_sys::Win32::System::Console::{
    AllocConsole, CTRL_BREAK_EVENT, GenerateConsoleCtrlEvent,
};
use windows_sys::Win32::System::Diagnostics::ToolHelp::{
    CreateToolhelp32Snapshot, PROCESSENTRY32W, Process32FirstW, Process32NextW, TH32CS_SNAPPROCESS,
};
use windows_sys::Win32::System::Threading::{
    CREATE_NEW_PROCESS_GROUP, OpenProcess, PROCESS_TERMINATE, TerminateProcess,
};
use windows_sys::Win32::UI::Input::KeyboardAndMouse::GetAsyncKeyState;
use windows_sys::Win32::UI::WindowsAndMessaging::{
    FindWindowW, GetWindowThreadProcessId, SMTO_BLOCK, SendMessageTimeoutW, WM_ENDSESSION,
    WM_QUERYENDSESSION,
};

use crate::logger::{KeyMessage, Logger, PATIENCE};

/// Kills without `GELPAD_KILLS`.
const KILLS: usize = 20;
/// Longest time until all keys are up after a kill.
const RELEASED: Duration = Duration::from_secs(10);
/// A finger on `jump` that stays.
const SCRIPT: &str = "t:200 down 1 80 30\nt:600000 up 1\n";

struct Gelpad {
    child: Child,
    _folder: tempfile::TempDir,
}

impl Gelpad {
    /// Starts a gelpad that holds `jump`, and waits until its key is down.
    fn holding(logger: &Logger) -> Result<(Self, KeyMessage)> {
        logger.clear();
        let folder = tempfile::tempdir()?;
        let script = folder.path().join("touches.txt");
        std::fs::write(&script, SCRIPT)?;
        let child = Command::new(env!("CARGO_BIN_EXE_gelpad"))
            .args(["play", "super-mario", "--source"])
            .arg(format!("simulated:{}", script.display()))
            .args(["--output", "keyboard", "--headless", "--seed", "1"])
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::inherit())
            .creation_flags(CREATE_NEW_PROCESS_GROUP)
            .spawn()?;
        let gelpad = Self {
            child,
            _folder: folder,
        };
        // A pad that is not in the cache is solved first.
        let until = Instant::now() + Duration::from_secs(120);
        let down = loop {
            match logger.within(PATIENCE)? {
                Some(message) if message.is_down => break message,
                _ => ensure!(Instant::now() < until, "gelpad presses no key"),
            }
        };
        Ok((gelpad, down))
    }
}

impl Drop for Gelpad {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Waits for the release of a key; returns how long it took.
fn released(logger: &Logger, down: KeyMessage, since: Instant) -> Result<Duration> {
    let until = since + RELEASED;
    loop {
        let left = until.saturating_duration_since(Instant::now());
        let message = logger.within(left)?.context("the key stays down")?;
        if !message.is_down && message.scan_code == down.scan_code {
            // SAFETY: the call takes and returns numbers.
            let state = unsafe { GetAsyncKeyState(i32::from(down.virtual_key)) };
            ensure!(state >= 0, "Windows still counts the key as down");
            return Ok(message.at.saturating_duration_since(since));
        }
    }
}

fn kills() -> usize {
    let given = std::env::var("GELPAD_KILLS").ok();
    given.and_then(|text| text.parse().ok()).unwrap_or(KILLS)
}

/// `TerminateProcess`, as the task manager does.
pub fn killed() -> Result<()> {
    let logger = Logger::open()?;
    let mut longest = Duration::ZERO;
    for number in 0..kills() {
        let (mut gelpad, down) = Gelpad::holding(&logger)?;
        gelpad.child.kill()?;
        let took = released(&logger, down, Instant::now());
        longest = longest.max(took.with_context(|| format!("kill {number}"))?);
    }
    println!(
        "{} kills: all keys up, the last after {} ms",
        kills(),
        longest.as_millis()
    );
    Ok(())
}

/// gelpad and one of its two watchers at once.
pub fn with_a_watcher() -> Result<()> {
    let logger = Logger::open()?;
    for number in 0..2 {
        let (mut gelpad, down) = Gelpad::holding(&logger)?;
        let watchers = children(gelpad.child.id());
        ensure!(watchers.len() == 2, "watchers: {watchers:?}");
        terminate(watchers[number])?;
        gelpad.child.kill()?;
        released(&logger, down, Instant::now()).with_context(|| format!("watcher {number}"))?;
    }
    Ok(())
}

/// Ctrl-Break: gelpad releases the key itself and ends with the code of the event.
pub fn ctrl_break() -> Result<()> {
    // Started from a script there is no console. If there is one, the call fails, and that is used.
    // SAFETY: the call takes nothing.
    unsafe { AllocConsole() };
    let logger = Logger::open()?;
    let (mut gelpad, down) = Gelpad::holding(&logger)?;
    // SAFETY: the calls take numbers.
    let is_sent = unsafe { GenerateConsoleCtrlEvent(CTRL_BREAK_EVENT, gelpad.child.id()) };
    ensure!(
        is_sent != 0,
        "no event: {}",
        std::io::Error::last_os_error()
    );
    released(&logger, down, Instant::now())?;
    ensure!(
        gelpad.child.wait()?.code() == Some(131),
        "another exit code"
    );
    Ok(())
}

/// The end of the session: gelpad lets it happen, releases the key itself and ends with the code of SIGTERM.
pub fn end_of_session() -> Result<()> {
    let logger = Logger::open()?;
    let (mut gelpad, down) = Gelpad::holding(&logger)?;
    let title: Vec<u16> = "gelpad waits for the end of the session\0"
        .encode_utf16()
        .collect();
    let mut owner = 0;
    let send = |window, message, ending| {
        let mut answer = 0;
        // SAFETY: the answer outlives the call; both messages carry numbers.
        let is_answered = unsafe {
            SendMessageTimeoutW(
                window,
                message,
                ending,
                0,
                SMTO_BLOCK,
                5_000,
                &raw mut answer,
            )
        };
        (is_answered != 0).then_some(answer)
    };
    // SAFETY: the title ends with 0 and outlives the call, and so does the number.
    let window = unsafe {
        let window = FindWindowW(std::ptr::null(), title.as_ptr());
        GetWindowThreadProcessId(window, &raw mut owner);
        window
    };
    ensure!(owner == gelpad.child.id(), "gelpad has no such window");
    ensure!(
        send(window, WM_QUERYENDSESSION, 0) == Some(1),
        "gelpad keeps people from logging off"
    );
    // Another program does: play goes on.
    send(window, WM_ENDSESSION, 0);
    ensure!(
        logger
            .within(Duration::from_millis(500))?
            .is_none_or(|key| key.is_down),
        "the key is released although the session goes on"
    );
    // The program ends instead of answering.
    send(window, WM_ENDSESSION, 1);
    released(&logger, down, Instant::now())?;
    ensure!(
        gelpad.child.wait()?.code() == Some(143),
        "another exit code"
    );
    Ok(())
}

fn terminate(process: u32) -> Result<()> {
    // SAFETY: the calls take numbers and a handle that was just opened, which is closed once.
    unsafe {
        let handle = OpenProcess(PROCESS_TERMINATE, 0, process);
        ensure!(!handle.is_null(), "{}", std::io::Error::last_os_error());
        TerminateProcess(handle, 1);
        CloseHandle(handle);
    }
    Ok(())
}

/// Processes that a process has started.
fn children(parent: u32) -> Vec<u32> {
    let mut found = Vec::new();
    // SAFETY: the structure has its size in `dwSize` and outlives the calls; the handle is closed once.
    unsafe {
        let snapshot = CreateToolhelp32Snapshot(TH32CS_SNAPPROCESS, 0);
        if snapshot == INVALID_HANDLE_VALUE {
            return found;
        }
        let mut entry: PROCESSENTRY32W = std::mem::zeroed();
        entry.dwSize = size_of::<PROCESSENTRY32W>() as u32;
        let mut is_there = Process32FirstW(snapshot, &raw mut entry);
        while is_there != 0 {
            if entry.th32ParentProcessID == parent {
                found.push(entry.th32ProcessID);
            }
            is_there = Process32NextW(snapshot, &raw mut entry);
        }
        CloseHandle(snapshot);
    }
    found
}
