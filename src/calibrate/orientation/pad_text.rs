//! Changes the numbering in a pad's text: two keys of `[electrodes]`; everything else stays as it is.

use toml_edit::{DocumentMut, value};

use crate::pad::{Direction, Numbering};

/// Why the numbering in a pad's text cannot be changed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NumberingTextError {
    /// Not TOML.
    #[error("the pad file is not valid TOML: {0}")]
    Unreadable(String),
    /// Not a pad.
    #[error("the pad file has no [electrodes] table: is it a pad?")]
    NoElectrodes,
}

/// A pad's text with `first_electrode` and `direction` set; comments and order stay.
///
/// # Errors
/// See [`NumberingTextError`].
pub fn with_numbering(text: &str, numbering: Numbering) -> Result<String, NumberingTextError> {
    let mut document: DocumentMut = text
        .parse()
        .map_err(|error: toml_edit::TomlError| NumberingTextError::Unreadable(error.to_string()))?;
    let electrodes = document
        .get_mut("electrodes")
        .and_then(|electrodes| electrodes.as_table_like_mut())
        .ok_or(NumberingTextError::NoElectrodes)?;
    let Numbering { first, direction } = numbering;
    let mut set = |key: &str, wanted: toml_edit::Item, default: bool| {
        if let Some(there) = electrodes.get_mut(key) {
            // Keeps the comment after the value.
            let decor = there.as_value().map(|value| value.decor().clone());
            *there = wanted;
            if let (Some(value), Some(decor)) = (there.as_value_mut(), decor) {
                *value.decor_mut() = decor;
            }
        } else if !default {
            electrodes.insert(key, wanted);
        }
    };
    set("first_electrode", value(first as i64), first == 0);
    set(
        "direction",
        value(direction.name()),
        direction == Direction::CounterClockwise,
    );
    Ok(document.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::{Pad, SHIPPED_PADS};

    #[test]
    fn only_the_numbering_of_a_text_changes() {
        for shipped in SHIPPED_PADS {
            let clockwise = Numbering {
                first: 5,
                direction: Direction::Clockwise,
            };
            let text = with_numbering(shipped.toml, clockwise).expect("a pad");
            let pad = Pad::from_toml(shipped.name, &text).expect("sound");
            assert_eq!(pad.numbering, clockwise);
            let kept: Vec<&str> = text
                .lines()
                .filter(|line| {
                    !line.starts_with("first_electrode") && !line.starts_with("direction")
                })
                .collect();
            assert_eq!(kept, shipped.toml.lines().collect::<Vec<_>>());
            let back = with_numbering(&text, Numbering::default()).expect("a pad");
            let pad = Pad::from_toml(shipped.name, &back).expect("sound");
            assert_eq!(pad.numbering, Numbering::default());
        }
    }

    #[test]
    fn comments_after_a_changed_value_stay() {
        let text = "[electrodes]\nfirst_electrode = 3 # from the left\n";
        assert_eq!(
            with_numbering(text, Numbering::default()).expect("a table"),
            "[electrodes]\nfirst_electrode = 0 # from the left\n"
        );
        assert_eq!(
            with_numbering("name = 1", Numbering::default()),
            Err(NumberingTextError::NoElectrodes)
        );
    }
}
