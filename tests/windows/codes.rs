//! What a window of Windows sees of each key: the values of the W3C's "UI Events KeyboardEvent code Values", written down here
//! independently of gelpad's own table.

/// Name, scan code (with 0xe0 as the upper byte if extended).
#[rustfmt::skip]
pub const CODES: &[(&str, u16)] = &[
    ("escape", 0x01), ("1", 0x02), ("2", 0x03), ("3", 0x04), ("4", 0x05), ("5", 0x06), ("6", 0x07), ("7", 0x08), ("8", 0x09),
    ("9", 0x0a), ("0", 0x0b), ("minus", 0x0c), ("equal", 0x0d), ("backspace", 0x0e), ("tab", 0x0f), ("q", 0x10), ("w", 0x11),
    ("e", 0x12), ("r", 0x13), ("t", 0x14), ("y", 0x15), ("u", 0x16), ("i", 0x17), ("o", 0x18), ("p", 0x19),
    ("left-bracket", 0x1a), ("right-bracket", 0x1b), ("enter", 0x1c), ("left-ctrl", 0x1d), ("a", 0x1e), ("s", 0x1f), ("d", 0x20),
    ("f", 0x21), ("g", 0x22), ("h", 0x23), ("j", 0x24), ("k", 0x25), ("l", 0x26), ("semicolon", 0x27), ("apostrophe", 0x28),
    ("grave", 0x29), ("left-shift", 0x2a), ("backslash", 0x2b), ("z", 0x2c), ("x", 0x2d), ("c", 0x2e), ("v", 0x2f), ("b", 0x30),
    ("n", 0x31), ("m", 0x32), ("comma", 0x33), ("period", 0x34), ("slash", 0x35), ("right-shift", 0x36), ("keypad-multiply", 0x37),
    ("left-alt", 0x38), ("space", 0x39), ("caps-lock", 0x3a), ("f1", 0x3b), ("f2", 0x3c), ("f3", 0x3d), ("f4", 0x3e), ("f5", 0x3f),
    ("f6", 0x40), ("f7", 0x41), ("f8", 0x42), ("f9", 0x43), ("f10", 0x44), ("num-lock", 0x45), ("scroll-lock", 0x46),
    ("keypad-7", 0x47), ("keypad-8", 0x48), ("keypad-9", 0x49), ("keypad-minus", 0x4a), ("keypad-4", 0x4b), ("keypad-5", 0x4c),
    ("keypad-6", 0x4d), ("keypad-plus", 0x4e), ("keypad-1", 0x4f), ("keypad-2", 0x50), ("keypad-3", 0x51), ("keypad-0", 0x52),
    ("keypad-period", 0x53), ("intl-backslash", 0x56), ("f11", 0x57), ("f12", 0x58), ("intl-ro", 0x73), ("katakana", 0x78),
    ("hiragana", 0x77), ("convert", 0x79), ("kana-mode", 0x70), ("non-convert", 0x7b), ("keypad-enter", 0xe01c),
    ("right-ctrl", 0xe01d), ("keypad-divide", 0xe035), ("print-screen", 0xe037), ("right-alt", 0xe038), ("home", 0xe047),
    ("up", 0xe048), ("page-up", 0xe049), ("left", 0xe04b), ("right", 0xe04d), ("end", 0xe04f), ("down", 0xe050),
    ("page-down", 0xe051), ("insert", 0xe052), ("delete", 0xe053), ("mute", 0xe020), ("volume-down", 0xe02e), ("volume-up", 0xe030),
    ("keypad-equal", 0x59), ("pause", 0x45), ("keypad-comma", 0x7e), ("hangul", 0x72), ("hanja", 0x71), ("intl-yen", 0x7d),
    ("left-meta", 0xe05b), ("right-meta", 0xe05c), ("menu", 0xe05d), ("undo", 0xe008), ("copy", 0xe018), ("paste", 0xe00a),
    ("cut", 0xe017), ("help", 0xe03b), ("calculator", 0xe021), ("mail", 0xe06c), ("browser-back", 0xe06a),
    ("browser-forward", 0xe069), ("eject", 0xe02c), ("media-next", 0xe019), ("media-play-pause", 0xe022), ("media-previous", 0xe010),
    ("media-stop", 0xe024), ("browser-home", 0xe032), ("browser-refresh", 0xe067), ("f13", 0x64), ("f14", 0x65), ("f15", 0x66),
    ("f16", 0x67), ("f17", 0x68), ("f18", 0x69), ("f19", 0x6a), ("f20", 0x6b), ("f21", 0x6c), ("f22", 0x6d), ("f23", 0x6e),
    ("f24", 0x76), ("browser-search", 0xe065),
];

/// Keys without a virtual key in the American layout, or in wine's: only the scan code names them.
pub const WITHOUT_VIRTUAL_KEY: &[&str] = &[
    "intl-ro",
    "katakana",
    "hiragana",
    "keypad-equal",
    "keypad-comma",
    "hangul",
    "hanja",
    "intl-yen",
    "f24",
];

/// Keys that keyboards of Windows do not have: gelpad refuses profiles that press them.
pub const ABSENT: &[&str] = &[
    "open",
    "find",
    "media-record",
    "media-rewind",
    "keypad-left-paren",
    "keypad-right-paren",
    "media-play",
    "media-fast-forward",
    "brightness-down",
    "brightness-up",
];
