//! `gelpad profile`: the profiles, and what one does.

use std::io::Write as _;

use super::args::ProfileCommand;
use super::exit::Ending;
use super::map::Map;
use super::resolve;
use crate::profile::{Mode, Profile, SHIPPED_PROFILES};
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
            ms_from_nanos(profile.min_hold_ns),
            ms_from_nanos(profile.min_gap_ns)
        ),
    ];
    for binding in &profile.bindings {
        let mode = match binding.mode {
            Mode::Direct => "while touched".to_owned(),
            Mode::Classified(latch) => format!(
                "{:.0} ms, or {:.0} ms if touched for {:.0} ms",
                ms_from_nanos(latch.short_ns),
                ms_from_nanos(latch.long_ns),
                ms_from_nanos(latch.long_after_ns)
            ),
        };
        let region = &profile.regions[binding.region].name;
        let output = profile.outputs[binding.output].to_string();
        lines.push(format!("  {region:12} {output:12} {mode}"));
    }
    lines.join("\n")
}
