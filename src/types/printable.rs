//! Text from files, boards and file names, made safe for a terminal.

use std::borrow::Cow;

/// A text without control characters except line ends and tabs: a terminal would obey them. Each is replaced by its picture
/// (`␛` for ESC), those without one by `�`.
#[must_use]
pub fn printable(text: &str) -> Cow<'_, str> {
    if text.chars().any(is_harmful) {
        Cow::Owned(text.chars().map(replacement).collect())
    } else {
        Cow::Borrowed(text)
    }
}

/// The same with as many bytes, so that places in the text stay: each byte of such a character becomes `?`.
#[must_use]
pub fn printable_in_place(text: &str) -> Cow<'_, str> {
    if !text.chars().any(is_harmful) {
        return Cow::Borrowed(text);
    }
    let mut safe = String::with_capacity(text.len());
    for character in text.chars() {
        match is_harmful(character) {
            true => (0..character.len_utf8()).for_each(|_| safe.push('?')),
            false => safe.push(character),
        }
    }
    Cow::Owned(safe)
}

/// Control characters, and those that change the direction of the text around them.
fn is_harmful(character: char) -> bool {
    let reverses = matches!(character, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    (character.is_control() && !matches!(character, '\n' | '\t')) || reverses
}

fn replacement(character: char) -> char {
    match character {
        '\0'..='\u{1f}' if is_harmful(character) => {
            char::from_u32(0x2400 + u32::from(character)).unwrap_or('\u{fffd}')
        }
        '\u{7f}' => '\u{2421}',
        _ if is_harmful(character) => '\u{fffd}',
        _ => character,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_replaced_and_the_rest_stays() {
        assert_eq!(printable("Größe 5 mm\n\tx"), "Größe 5 mm\n\tx");
        assert!(matches!(printable("plain"), Cow::Borrowed(_)));
        assert_eq!(
            printable("a\u{1b}]0;title\u{7}b\r\u{7f}\u{9b}c\u{202e}"),
            "a␛]0;title␇b␍␡\u{fffd}c\u{fffd}"
        );
        let text = "ä\u{1b}[\u{9b}\u{202e}x";
        assert_eq!(printable_in_place(text), "ä?[?????x");
    }
}
