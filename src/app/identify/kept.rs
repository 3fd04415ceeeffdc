//! Identified pads that are kept from one game to the next, beside the solved tables.
//!
//! A kept pad belongs to a drawing and a board: by the board's serial number, or by its port if the system reports none.

use std::path::{Path, PathBuf};

use crc::{CRC_64_XZ, Crc};

use crate::app::pads::PadText;
use crate::cache;
use crate::eit::ResponseBuilder;
use crate::files;
use crate::pad::Pad;

/// Where the identified pads of one drawing on one board are kept.
#[derive(Clone, Debug)]
pub(super) struct KeptPad {
    folder: PathBuf,
    path: PathBuf,
}

impl KeptPad {
    /// In the folder of the tables; none if there is no such folder.
    pub(super) fn new(drawing: &Pad, board: &str) -> Option<Self> {
        Some(Self::in_folder(&cache::folder()?, drawing, board))
    }

    fn in_folder(folder: &Path, drawing: &Pad, board: &str) -> Self {
        const CRC: Crc<u64> = Crc::<u64>::new(&CRC_64_XZ);
        let name = format!("{}\n{board}", ResponseBuilder::key(drawing));
        let sum = CRC.checksum(name.as_bytes());
        Self {
            folder: folder.to_owned(),
            path: folder.join(format!("identified-{sum:016x}.toml")),
        }
    }

    /// The kept pad; none if there is none, or the file is damaged.
    pub(super) fn load(&self, drawing: &Pad) -> Option<PadText> {
        let toml = std::fs::read_to_string(&self.path).ok()?;
        let kept = Pad::from_toml(&drawing.name, &toml).ok()?;
        let fits = kept.drawing() == *drawing && !kept.deviations.is_none();
        fits.then_some(PadText { pad: kept, toml })
    }

    /// Keeps a pad, and removes the table of the one before.
    pub(super) fn store(&self, identified: &PadText) {
        let before = std::fs::read_to_string(&self.path).ok();
        let before = before.and_then(|toml| Pad::from_toml(&identified.pad.name, &toml).ok());
        if let Some(before) = before.filter(|before| *before != identified.pad) {
            cache::remove(&before, &self.folder);
        }
        let stored = std::fs::create_dir_all(&self.folder)
            .map_err(|error| format!("{}: {error}", self.folder.display()))
            .and_then(|()| {
                files::write(&self.path, identified.toml.as_bytes()).map_err(|e| e.to_string())
            });
        if let Err(why) = stored {
            tracing::warn!("{why}: the pad will be identified again at the next start");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::identify::text_with;
    use crate::pad::{DEFAULT_PAD, Deviations, ElectrodeDeviation, shipped_pad};

    #[test]
    fn a_pad_is_kept_for_its_drawing_and_board_and_damage_is_ignored() {
        let folder = tempfile::tempdir().expect("a folder");
        let toml = shipped_pad(DEFAULT_PAD).expect("shipped").toml;
        let drawing = Pad::from_toml("p", toml).expect("sound");
        let shifted = ElectrodeDeviation {
            shift_mm: 0.5,
            stretch_mm: 0.0,
        };
        let electrodes = vec![shifted; drawing.electrodes.len()];
        let deviations = Deviations::new(vec![([10.0, 10.0], 0.9)], electrodes);
        let found = drawing.with_deviations(deviations);
        let toml = text_with(toml, &found).expect("a pad's text");
        let identified = PadText {
            pad: Pad::from_toml("p", &toml).expect("sound"),
            toml,
        };
        let kept = KeptPad::in_folder(folder.path(), &drawing, "board A");
        assert!(kept.load(&drawing).is_none());
        kept.store(&identified);
        assert_eq!(kept.load(&drawing).expect("kept").pad, identified.pad);
        let other = KeptPad::in_folder(folder.path(), &drawing, "board B");
        assert!(other.load(&drawing).is_none());
        std::fs::write(&kept.path, "[found").expect("damaged");
        assert!(kept.load(&drawing).is_none());
        kept.store(&identified);
        assert!(kept.load(&drawing).is_some());
    }
}
