//! The keys of an X server.

use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use x11rb::protocol::xproto::{ConnectionExt as _, KEY_PRESS_EVENT, KEY_RELEASE_EVENT};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;
use x11rb::{CURRENT_TIME, NONE};

/// A client that reads the keys.
pub struct Display {
    connection: RustConnection,
    pub name: String,
}

impl Display {
    pub fn open(name: &str) -> Result<Self> {
        let (connection, _) = x11rb::connect(Some(name)).context("the X server does not answer")?;
        Ok(Self {
            connection,
            name: name.to_owned(),
        })
    }

    /// Keycodes that are down.
    pub fn down(&self) -> Result<Vec<u8>> {
        let bits = self.connection.query_keymap()?.reply()?.keys;
        let is_down = |code: &u8| bits[usize::from(code / 8)] >> (code % 8) & 1 == 1;
        Ok((0..=u8::MAX).filter(is_down).collect())
    }

    /// Presses or releases a key as another keyboard would.
    pub fn press(&self, code: u8, is_down: bool) -> Result<()> {
        let kind = if is_down {
            KEY_PRESS_EVENT
        } else {
            KEY_RELEASE_EVENT
        };
        let sent = self
            .connection
            .xtest_fake_input(kind, code, CURRENT_TIME, NONE, 0, 0, 0)?;
        Ok(sent.check()?)
    }

    /// Waits until keys are down (`any`) or all are up; returns how long that took.
    pub fn wait(&self, any: bool, patience: Duration) -> Result<Duration> {
        let start = Instant::now();
        loop {
            let down = self.down()?;
            if down.is_empty() != any {
                return Ok(start.elapsed());
            }
            ensure!(
                start.elapsed() < patience,
                "after {patience:?} the keys that are down: {down:?}"
            );
            std::thread::sleep(Duration::from_micros(500));
        }
    }

    /// The keymap and the modifiers, byte for byte.
    pub fn keymap(&self) -> Result<Vec<u32>> {
        use x11rb::connection::Connection as _;

        let setup = self.connection.setup();
        let count = setup.max_keycode - setup.min_keycode + 1;
        let reply = self
            .connection
            .get_keyboard_mapping(setup.min_keycode, count)?
            .reply()?;
        let mut all = vec![u32::from(reply.keysyms_per_keycode)];
        all.extend(reply.keysyms);
        let modifiers = self.connection.get_modifier_mapping()?.reply()?;
        all.extend(modifiers.keycodes.into_iter().map(u32::from));
        Ok(all)
    }
}
