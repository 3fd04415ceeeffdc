//! Converts engine inputs to messages.

use std::collections::BTreeSet;

use crate::engine::Input;
use crate::profile::{Profile, Source, Texts};
use crate::session::{LostFrames, Message, NamedText, ProfileTexts, TimeOnly};
use crate::types::Nanos;

/// The message of an input; `None` for a matrix, which is an attachment.
#[must_use]
pub fn message_from_input(input: &Input) -> Option<Message> {
    Some(match input {
        Input::Frame(frame) => Message::Frames(vec![frame.clone()]),
        Input::Part(part) => Message::Parts(vec![part.clone()]),
        Input::Control(control) => Message::Control(*control),
        Input::Tick { due_ns } => Message::Tick(TimeOnly { t_ns: *due_ns }),
        Input::Profile { t_ns, profile } => Message::Profile(profile_texts(profile, *t_ns)),
        Input::Pause { t_ns } => Message::Pause(TimeOnly { t_ns: *t_ns }),
        Input::Matrix(_) => return None,
        Input::Rezero { t_ns } => Message::Rezero(TimeOnly { t_ns: *t_ns }),
        Input::Lost { frames } => Message::Lost(LostFrames { frames: *frames }),
        Input::End { t_ns } => Message::End(TimeOnly { t_ns: *t_ns }),
    })
}

/// The texts of a profile that takes over at `t_ns`. Folders are removed from the names: a recording contains no paths.
#[must_use]
pub fn profile_texts(profile: &Profile, t_ns: Nanos) -> ProfileTexts {
    let Texts { chain, user } = &profile.texts;
    let mut used = BTreeSet::new();
    let mut named = |source: &Source| {
        let own = source.name.rsplit(['/', '\\']).next().unwrap_or_default();
        let mut name = own.to_owned();
        // Two texts of the same name would look like one that extends itself.
        for number in 2.. {
            if used.insert(name.clone()) {
                break;
            }
            name = format!("{own} ({number})");
        }
        NamedText {
            name,
            toml: source.toml.clone(),
        }
    };
    ProfileTexts {
        t_ns,
        chain: chain.iter().map(&mut named).collect(),
        user: user.as_ref().map(&mut named),
    }
}

/// The texts of a recorded profile.
#[must_use]
pub fn texts_from_message(texts: &ProfileTexts) -> Texts {
    let source = |text: &NamedText| Source {
        name: text.name.clone(),
        toml: text.toml.clone(),
    };
    Texts {
        chain: texts.chain.iter().map(source).collect(),
        user: texts.user.as_ref().map(source),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::read;

    fn source(name: &str, toml: &str) -> Source {
        Source {
            name: name.to_owned(),
            toml: toml.to_owned(),
        }
    }

    #[test]
    fn a_profile_with_bases_and_user_settings_is_read_back() {
        let shipped = crate::profile::shipped_profile("super-mario").expect("shipped");
        let find = |name: &str| match name {
            "../base/mine.toml" => Ok(source("/home/me/base/mine.toml", shipped.toml)),
            _ => Err("no such base".to_owned()),
        };
        let own = source(
            "/home/me/mine.toml",
            "schema = 1\nname = \"mine\"\nextends = \"../base/mine.toml\"\n",
        );
        let user = source("/home/me/users/anna.toml", "slow_keys_ms = 40\n");
        let profile = read(own, Some(user), &find).expect("sound").profile;
        let texts = profile_texts(&profile, 7);
        let names: Vec<&str> = texts.chain.iter().map(|text| text.name.as_str()).collect();
        assert_eq!(names, ["mine.toml", "mine.toml (2)"]);
        let mut back = texts_from_message(&texts).read().expect("sound").profile;
        // Only the file names differ.
        back.texts = profile.texts.clone();
        back.origins.clone_from(&profile.origins);
        assert_eq!(back, profile);
    }
}
