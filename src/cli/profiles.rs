//! `gelpad profile`: lists, checks, shows and draws profiles.

use std::io::Write;
use std::path::Path;

use super::args::{ProfileCommand, ShowArgs};
use super::drawing;
use super::exit::{self, Ending};
use super::map::Map;
use super::message::for_stdout;
use crate::app::folders::own_texts;
use crate::app::pads::load_pad;
use crate::app::profiles::load_profile;
use crate::app::texts::profile_text;
use crate::files;
use crate::profile::{Checked, Profile, SHIPPED_PROFILES, SHIPPED_USERS, schema};
use crate::types::{ms_from_nanos, printable};

pub(super) fn run(command: &ProfileCommand) -> anyhow::Result<Ending> {
    let mut stdout = std::io::stdout().lock();
    match command {
        ProfileCommand::List => list(&mut stdout)?,
        ProfileCommand::Check {
            profile: argument,
            user,
        } => {
            let checked = load_profile(argument, user.as_deref())?;
            checked.warnings.iter().for_each(exit::warn);
            let warnings: usize = checked
                .warnings
                .iter()
                .map(|faulty| faulty.diagnostics.len())
                .sum();
            writeln!(
                stdout,
                "{}: sound: {} regions, {} bindings{}",
                printable(argument),
                checked.profile.regions.len(),
                checked.profile.bindings.len(),
                match warnings {
                    0 => String::new(),
                    1 => ", 1 warning".to_owned(),
                    _ => format!(", {warnings} warnings"),
                }
            )?;
        }
        ProfileCommand::Schema => write!(stdout, "{}", schema())?,
        ProfileCommand::Show(args) if args.toml => {
            write!(stdout, "{}", for_stdout(&profile_text(&args.profile)?.toml))?;
        }
        ProfileCommand::Show(args) => {
            let checked = load_profile(&args.profile, args.user.as_deref())?;
            let pad_mm = load_pad(&args.pad)?.pad.outline.size_mm();
            let pad_mm = checked.profile.settings.size_as_player_sees_mm(pad_mm);
            if !draw(args, &checked.profile, pad_mm)? {
                let map = Map::new(pad_mm, 60).with_regions(&checked.profile).framed();
                let facts = facts(&checked);
                writeln!(stdout, "{}\n{}", printable(&map), printable(&facts))?;
            }
        }
    }
    Ok(Ending::Done)
}

/// Lists own profiles, shipped ones and the settings of shipped users.
fn list(stdout: &mut impl Write) -> anyhow::Result<()> {
    for path in own_texts("profiles") {
        // One with mistakes is listed too: `check` names them.
        let about = load_profile(&path, None).map(|checked| checked.profile.about);
        let about = about.unwrap_or_else(|_| "has mistakes".to_owned());
        let name = Path::new(&path).file_stem().unwrap_or_default();
        let name = name.to_string_lossy();
        let name = printable(&name);
        writeln!(stdout, "{name:24} {} (yours)", printable(&about))?;
    }
    for shipped in SHIPPED_PROFILES {
        let profile = Profile::from_toml(shipped.name, shipped.toml)?;
        writeln!(stdout, "{:24} {}", profile.name, profile.about)?;
    }
    let shipped = SHIPPED_USERS.iter().map(|user| user.name.to_owned());
    let own = own_texts("users").into_iter().map(|path| {
        let name = Path::new(&path).file_stem().unwrap_or_default();
        format!("{} (yours)", printable(&name.to_string_lossy()))
    });
    let users: Vec<String> = own.chain(shipped).collect();
    writeln!(stdout, "\nwith --user: {}", users.join(", "))?;
    Ok(())
}

/// Writes the requested drawings; returns whether there were any.
fn draw(args: &ShowArgs, profile: &Profile, pad_mm: [f64; 2]) -> anyhow::Result<bool> {
    if let Some(path) = &args.svg {
        files::write(path, drawing::svg(profile, pad_mm).as_bytes())?;
    }
    if let Some(path) = &args.print {
        files::write(path, drawing::print(profile, pad_mm)?.as_bytes())?;
    }
    if let Some(path) = &args.png {
        files::write(path, &drawing::png(profile, pad_mm)?)?;
    }
    Ok(args.svg.is_some() || args.print.is_some() || args.png.is_some())
}

fn facts(checked: &Checked) -> String {
    let profile = &checked.profile;
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
            profile.binding_place(binding),
            profile.output_names(binding),
            profile.describe_binding(binding)
        ));
    }
    if checked.texts.len() > 1 {
        lines.push(format!(
            "read from {}; later ones override earlier ones:",
            checked.texts.join(", ")
        ));
        // These keys describe the texts themselves.
        let heads = ["about", "extends", "name", "schema"];
        let values = profile.origins.iter();
        for origin in values.filter(|origin| !heads.contains(&origin.key.as_str())) {
            let value = if origin.value.is_empty() {
                String::new()
            } else {
                format!(" = {}", origin.value)
            };
            lines.push(format!(
                "  {:40} {}",
                format!("{}{value}", origin.key),
                origin.from
            ));
        }
    }
    lines.join("\n")
}
