//! `gelpad profile`: the profiles, and what one does.

use std::io::Write as _;

use super::args::ProfileCommand;
use super::exit::Ending;
use super::map::Map;
use super::resolve;
use crate::profile::{Profile, SHIPPED_PROFILES};
use crate::types::ms_from_nanos;

/// A map is drawn for a pad of any size: regions are shares of it.
const SQUARE_MM: [f64; 2] = [100.0, 100.0];

pub(super) fn run(command: &ProfileCommand) -> anyhow::Result<Ending> {
    let mut stdout = std::io::stdout().lock();
    match command {
        ProfileCommand::List => {
            for shipped in SHIPPED_PROFILES {
                let profile = Profile::from_toml(shipped.name, shipped.toml)?;
                writeln!(stdout, "{:24} {}", profile.name, profile.about)?;
            }
        }
        ProfileCommand::Check { profile: argument } => {
            let profile = resolve::profile(argument)?;
            writeln!(
                stdout,
                "{argument}: sound: {} regions, {} bindings",
                profile.regions.len(),
                profile.bindings.len()
            )?;
        }
        ProfileCommand::Show {
            profile,
            toml: true,
        } => write!(stdout, "{}", resolve::profile_text(profile)?.toml)?,
        ProfileCommand::Show {
            profile,
            toml: false,
        } => {
            let profile = resolve::profile(profile)?;
            writeln!(
                stdout,
                "{}",
                Map::new(SQUARE_MM, 60).regions(&profile).framed()
            )?;
            writeln!(stdout, "{}", facts(&profile))?;
        }
    }
    Ok(Ending::Done)
}

fn facts(profile: &Profile) -> String {
    let mut lines = vec![
        format!("{}: {}", profile.name, profile.about),
        format!(
            "shortest press {} ms, shortest gap {} ms",
            ms_from_nanos(profile.settings.min_hold_ns),
            ms_from_nanos(profile.settings.min_gap_ns)
        ),
    ];
    for binding in &profile.bindings {
        lines.push(format!(
            "  {:12} {:12} {}",
            profile.place_of(binding),
            profile.outputs_of(binding),
            profile.how(binding)
        ));
    }
    lines.join("\n")
}
