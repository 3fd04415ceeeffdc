//! Selects a profile by the programs that run: the first profile whose `[match]` names a running program plays until
//! that program ends, then the original profile again.

use std::collections::BTreeSet;

use super::folders::own_texts;
use super::profiles::load_profile;
use crate::platform::processes::{listed_name, running_names};
use crate::profile::SHIPPED_PROFILES;

/// Calls of [`ProfileMatcher::poll`] between two looks at the processes: about a second at 33 ms.
const POLLS_PER_LOOK: u32 = 30;

/// A profile and the programs that select it.
#[derive(Clone, Debug, PartialEq, Eq)]
struct MatchedProfile {
    argument: String,
    processes: Vec<String>,
}

/// Selects among profiles by running programs.
pub(super) struct ProfileMatcher {
    /// Plays while none of the programs runs.
    original: String,
    candidates: Vec<MatchedProfile>,
    playing: Option<usize>,
    polls: u32,
}

impl ProfileMatcher {
    /// Reads all profiles with a `[match]`: the user's own first, then the shipped ones.
    pub(super) fn new(original: &str) -> Self {
        let shipped = SHIPPED_PROFILES
            .iter()
            .map(|shipped| shipped.name.to_owned());
        let candidates = own_texts("profiles")
            .into_iter()
            .chain(shipped)
            .filter_map(|argument| {
                let processes = load_profile(&argument, None).ok()?.profile.processes;
                (!processes.is_empty()).then_some(MatchedProfile {
                    argument,
                    processes,
                })
            })
            .collect();
        Self {
            original: original.to_owned(),
            candidates,
            playing: None,
            polls: 0,
        }
    }

    /// Returns the profile to play next, if it changes. Reads the list of processes about once a second.
    pub(super) fn poll(&mut self) -> Option<String> {
        self.polls += 1;
        if self.polls < POLLS_PER_LOOK {
            return None;
        }
        self.polls = 0;
        self.choose(&running_names())
    }

    fn choose(&mut self, running: &BTreeSet<String>) -> Option<String> {
        let runs = |candidate: &MatchedProfile| {
            candidate
                .processes
                .iter()
                .any(|name| running.contains(&*listed_name(name)))
        };
        // The current profile stays while its program runs, whatever else starts.
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
            None if before.is_some() => Some(self.original.clone()),
            None => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_selects_its_profile_until_it_ends() {
        let candidate = |argument: &str, process: &str| MatchedProfile {
            argument: argument.to_owned(),
            processes: vec![process.to_owned()],
        };
        let mut matcher = ProfileMatcher {
            original: "desktop".to_owned(),
            candidates: vec![
                candidate("mario", "fceux"),
                candidate("tux", "supertux2-with-a-long-name"),
            ],
            playing: None,
            polls: 0,
        };
        // As the system lists it: Linux cuts long names.
        let tux = &*listed_name("supertux2-with-a-long-name");
        let mut choose =
            |names: &[&str]| matcher.choose(&names.iter().map(|name| (*name).to_owned()).collect());
        assert_eq!(choose(&["bash"]), None);
        assert_eq!(choose(&["bash", tux]), Some("tux".to_owned()));
        assert_eq!(choose(&["fceux", tux]), None, "the current profile stays");
        assert_eq!(choose(&["fceux"]), Some("mario".to_owned()));
        assert_eq!(choose(&[]), Some("desktop".to_owned()));
        assert_eq!(choose(&[]), None);
    }
}
