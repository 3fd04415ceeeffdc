//! A profile for the program that runs: the first whose `[match]` names it plays until that program ends, and then
//! the former one again.

use std::collections::BTreeSet;

use super::resolve;
use crate::profile::SHIPPED_PROFILES;

/// Looks at the processes are so many rounds of 33 ms apart: about a second.
const ROUNDS: u32 = 30;
/// Linux cuts the names of processes there.
const NAME_BYTES: usize = 15;

/// A profile and the programs that it is for.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Candidate {
    argument: String,
    processes: Vec<String>,
}

/// Chooses among profiles by what runs.
pub(super) struct Picker {
    /// What plays while none of the programs runs.
    former: String,
    candidates: Vec<Candidate>,
    playing: Option<usize>,
    round: u32,
}

impl Picker {
    /// All profiles with a `[match]`: one's own first, then the shipped.
    pub(super) fn new(former: &str) -> Self {
        let own = own_profiles();
        let shipped = SHIPPED_PROFILES
            .iter()
            .map(|profile| profile.name.to_owned());
        let candidates = own
            .into_iter()
            .chain(shipped)
            .filter_map(|argument| {
                let processes = resolve::checked(&argument, None).ok()?.profile.processes;
                (!processes.is_empty()).then_some(Candidate {
                    argument,
                    processes,
                })
            })
            .collect();
        Self {
            former: former.to_owned(),
            candidates,
            playing: None,
            round: 0,
        }
    }

    /// Now and then looks at what runs; another profile to play, if one is due.
    pub(super) fn look(&mut self) -> Option<String> {
        self.round += 1;
        if self.round < ROUNDS {
            return None;
        }
        self.round = 0;
        self.choose(&running())
    }

    fn choose(&mut self, running: &BTreeSet<String>) -> Option<String> {
        let runs = |candidate: &Candidate| {
            candidate
                .processes
                .iter()
                .any(|name| running.contains(cut(name)))
        };
        // What plays stays while its program runs, whatever else is started.
        if self
            .playing
            .is_some_and(|index| runs(&self.candidates[index]))
        {
            return None;
        }
        let before = self.playing;
        self.playing = self.candidates.iter().position(runs);
        match self.playing {
            Some(index) => Some(self.candidates[index].argument.clone()),
            None if before.is_some() => Some(self.former.clone()),
            None => None,
        }
    }
}

fn cut(name: &str) -> &str {
    let mut end = name.len().min(NAME_BYTES);
    while !name.is_char_boundary(end) {
        end -= 1;
    }
    &name[..end]
}

/// Profiles in the player's own folder, by path.
fn own_profiles() -> Vec<String> {
    let Some(folder) = resolve::own_folder() else {
        return Vec::new();
    };
    let Ok(entries) = std::fs::read_dir(folder.join("profiles")) else {
        return Vec::new();
    };
    let mut paths: Vec<String> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "toml")
        })
        .map(|path| path.display().to_string())
        .collect();
    paths.sort();
    paths
}

/// Names of the processes that run; none where the system has no /proc.
fn running() -> BTreeSet<String> {
    let Ok(entries) = std::fs::read_dir("/proc") else {
        return BTreeSet::new();
    };
    entries
        .filter_map(|entry| std::fs::read_to_string(entry.ok()?.path().join("comm")).ok())
        .map(|name| name.trim_end().to_owned())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_picks_its_profile_and_gives_the_former_back() {
        let candidate = |argument: &str, process: &str| Candidate {
            argument: argument.to_owned(),
            processes: vec![process.to_owned()],
        };
        let mut picker = Picker {
            former: "desktop".to_owned(),
            candidates: vec![
                candidate("mario", "fceux"),
                candidate("tux", "supertux2-with-a-long-name"),
            ],
            playing: None,
            round: 0,
        };
        let mut choose =
            |names: &[&str]| picker.choose(&names.iter().map(|name| (*name).to_owned()).collect());
        assert_eq!(choose(&["bash"]), None);
        assert_eq!(choose(&["bash", "supertux2-with-"]), Some("tux".to_owned()));
        assert_eq!(
            choose(&["fceux", "supertux2-with-"]),
            None,
            "what plays stays"
        );
        assert_eq!(choose(&["fceux"]), Some("mario".to_owned()));
        assert_eq!(choose(&[]), Some("desktop".to_owned()));
        assert_eq!(choose(&[]), None);
    }
}
