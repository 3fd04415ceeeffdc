//! Scan codes (set 1) of the places on a keyboard, by evdev code.
//!
//! A code with the prefix `0xe0` in its upper byte is sent with the extended bit. The codes are those of Microsoft's "USB HID to PS/2 Scan
//! Code Translation Table" and of the W3C's "UI Events KeyboardEvent code Values" for Windows.

use windows_sys::Win32::UI::Input::KeyboardAndMouse::{VK_NUMLOCK, VK_PAUSE};

use crate::types::Key;

/// The prefix of an extended code.
const EXTENDED: u16 = 0xe000;
/// evdev took its first codes from scan code set 1, so these are equal.
const EQUAL: std::ops::RangeInclusive<u16> = 1..=88;
/// evdev codes of the two keys that share a scan code: only the virtual key tells them apart.
const NUM_LOCK: u16 = 69;
const PAUSE: u16 = 119;

/// evdev code and scan code of all other keys that Windows has.
#[rustfmt::skip]
const OTHERS: &[(u16, u16)] = &[
    // Japanese and Korean keyboards.
    (89, 0x73), (90, 0x78), (91, 0x77), (92, 0x79), (93, 0x70), (94, 0x7b), (122, 0x72), (123, 0x71), (124, 0x7d),
    (96, 0xe01c), (97, 0xe01d), (98, 0xe035), (99, 0xe037), (100, 0xe038), (102, 0xe047), (103, 0xe048), (104, 0xe049), (105, 0xe04b),
    (106, 0xe04d), (107, 0xe04f), (108, 0xe050), (109, 0xe051), (110, 0xe052), (111, 0xe053), (113, 0xe020), (114, 0xe02e),
    (115, 0xe030), (117, 0x59), (PAUSE, 0x45), (121, 0x7e), (125, 0xe05b), (126, 0xe05c), (127, 0xe05d),
    (131, 0xe008), (133, 0xe018), (135, 0xe00a), (137, 0xe017), (138, 0xe03b),
    (140, 0xe021), (155, 0xe06c), (158, 0xe06a), (159, 0xe069), (161, 0xe02c), (163, 0xe019), (164, 0xe022), (165, 0xe010),
    (166, 0xe024), (172, 0xe032), (173, 0xe067), (217, 0xe065),
    (183, 0x64), (184, 0x65), (185, 0x66), (186, 0x67), (187, 0x68), (188, 0x69), (189, 0x6a), (190, 0x6b), (191, 0x6c),
    (192, 0x6d), (193, 0x6e), (194, 0x76),
];

/// How Windows names a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ScanCode {
    /// The code without its prefix.
    pub code: u16,
    /// Whether it has the prefix.
    pub is_extended: bool,
    /// The virtual key, where the scan code does not name one.
    pub virtual_key: Option<u16>,
}

/// The scan code of a key; none for keys that Windows does not have.
pub(super) fn scan_code(key: Key) -> Option<ScanCode> {
    let evdev = key.evdev_code();
    let other = OTHERS.iter().find(|(known, _)| *known == evdev);
    let code = match other {
        Some((_, code)) => *code,
        None if EQUAL.contains(&evdev) => evdev,
        None => return None,
    };
    Some(ScanCode {
        code: code & 0xff,
        is_extended: code & EXTENDED == EXTENDED,
        virtual_key: match evdev {
            PAUSE => Some(VK_PAUSE),
            NUM_LOCK => Some(VK_NUMLOCK),
            _ => None,
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn every_key_has_a_code_of_its_own() {
        let mut keys: BTreeMap<(u16, bool, Option<u16>), Key> = BTreeMap::new();
        let mut missing = Vec::new();
        for key in Key::all() {
            match scan_code(key) {
                Some(code) => {
                    let before = keys.insert((code.code, code.is_extended, code.virtual_key), key);
                    assert_eq!(before, None, "{key}");
                }
                None => missing.push(key.to_string()),
            }
        }
        // Keyboards of Windows have no such keys.
        assert_eq!(
            missing,
            [
                "open",
                "find",
                "media-record",
                "media-rewind",
                "keypad-left-paren",
                "keypad-right-paren",
                "media-play",
                "media-fast-forward",
                "brightness-down",
                "brightness-up"
            ]
        );
    }

    #[test]
    fn the_keypad_is_not_the_arrows() {
        let code = |name: &str| scan_code(name.parse().expect("a key")).expect("a code");
        assert_eq!((code("keypad-4").code, code("left").code), (0x4b, 0x4b));
        assert_eq!(
            (code("keypad-4").is_extended, code("left").is_extended),
            (false, true)
        );
        assert!(code("right-ctrl").is_extended && !code("right-shift").is_extended);
    }
}
