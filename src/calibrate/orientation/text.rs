//! A pad's text with another numbering: two keys of `[electrodes]`, everything else as it was.

use toml_edit::{DocumentMut, value};

use crate::pad::{Direction, Numbering};

/// Why a pad's text cannot be renumbered.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NumberingTextError {
    /// It is no TOML.
    #[error("the pad's text cannot be read: {0}")]
    Unreadable(String),
    /// It is no pad.
    #[error("the pad's text has no [electrodes]: is it a pad?")]
    NoElectrodes,
}

/// The text of a pad with `first_electrode` and `direction` as found; comments and order stay.
///
/// # Errors
/// See [`NumberingTextError`].
pub fn numbered(text: &str, numbering: Numbering) -> Result<String, NumberingTextError> {
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
            // The comment behind the value stays.
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
        value(direction.word()),
        direction == Direction::CounterClockwise,
    );
    Ok(document.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::{Pad, SHIPPED_PADS};

    #[test]
    fn a_renumbered_text_differs_in_its_numbering_alone() {
        for shipped in SHIPPED_PADS {
            let clockwise = Numbering {
                first: 5,
                direction: Direction::Clockwise,
            };
            let text = numbered(shipped.toml, clockwise).expect("a pad");
            let pad = Pad::from_toml(shipped.name, &text).expect("sound");
            assert_eq!(pad.numbering, clockwise);
            let kept: Vec<&str> = text
                .lines()
                .filter(|line| {
                    !line.starts_with("first_electrode") && !line.starts_with("direction")
                })
                .collect();
            assert_eq!(kept, shipped.toml.lines().collect::<Vec<_>>());
            let back = numbered(&text, Numbering::default()).expect("a pad");
            let pad = Pad::from_toml(shipped.name, &back).expect("sound");
            assert_eq!(pad.numbering, Numbering::default());
        }
    }

    #[test]
    fn comments_behind_a_changed_value_stay() {
        let text = "[electrodes]\nfirst_electrode = 3 # from the left\n";
        assert_eq!(
            numbered(text, Numbering::default()).expect("a table"),
            "[electrodes]\nfirst_electrode = 0 # from the left\n"
        );
        assert_eq!(
            numbered("name = 1", Numbering::default()),
            Err(NumberingTextError::NoElectrodes)
        );
    }
}
