//! A keyboard with every key that has a name.

use std::io;

use evdev::uinput::VirtualDevice;
use evdev::{AttributeSet, BusType, EventType, InputId, KeyCode};

use super::{Report, builder};
use crate::types::Key;

/// Name of the device.
const NAME: &str = "gelpad keyboard";

pub(super) struct Keyboard {
    device: VirtualDevice,
    report: Report,
}

impl Keyboard {
    pub(super) fn create() -> io::Result<Self> {
        let keys: AttributeSet<KeyCode> = Key::all().map(|key| KeyCode(key.evdev_code())).collect();
        let device = builder()?
            .name(NAME)
            .input_id(InputId::new(BusType::BUS_VIRTUAL, 0, 0, 1))
            .with_keys(&keys)?
            .build()?;
        Ok(Self {
            device,
            report: Report::default(),
        })
    }

    pub(super) fn key(&mut self, key: Key, is_down: bool) -> io::Result<()> {
        match self
            .report
            .add(EventType::KEY, key.evdev_code(), i32::from(is_down))
        {
            Some(before) => self.device.emit(&before),
            None => Ok(()),
        }
    }

    pub(super) fn flush(&mut self) -> io::Result<()> {
        if self.report.is_empty() {
            return Ok(());
        }
        self.device.emit(&self.report.take())
    }
}
