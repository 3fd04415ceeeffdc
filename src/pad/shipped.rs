//! The pads that are compiled in, so that their names work in any folder.

/// The default pad.
pub const DEFAULT_PAD: &str = "edinburgh-lattice";

/// A pad that is compiled in.
#[derive(Clone, Copy, Debug)]
pub struct ShippedPad {
    /// Name for `--pad`.
    pub name: &'static str,
    /// The TOML text.
    pub toml: &'static str,
}

/// Every pad that is compiled in.
pub const SHIPPED_PADS: &[ShippedPad] = &[
    ShippedPad {
        name: "edinburgh-lattice",
        toml: include_str!("../../pads/edinburgh-lattice.toml"),
    },
    ShippedPad {
        name: "edinburgh-solid",
        toml: include_str!("../../pads/edinburgh-solid.toml"),
    },
    ShippedPad {
        name: "round-tank",
        toml: include_str!("../../pads/round-tank.toml"),
    },
    ShippedPad {
        name: "openeit-lattice",
        toml: include_str!("../../pads/openeit-lattice.toml"),
    },
];

/// The shipped pad of a name.
#[must_use]
pub fn shipped_pad(name: &str) -> Option<&'static ShippedPad> {
    SHIPPED_PADS.iter().find(|pad| pad.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::Pad;

    #[test]
    fn every_shipped_pad_is_valid_and_named_after_its_file() {
        for shipped in SHIPPED_PADS {
            let pad = Pad::from_toml(shipped.name, shipped.toml).expect(shipped.name);
            assert_eq!(pad.name, shipped.name);
        }
    }
}
