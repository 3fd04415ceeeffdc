//! What the arguments of a replay replace in a recording.

use std::path::Path;
use std::sync::Arc;

use crate::app::calibration;
use crate::app::pads::{choose_method, load_pad};
use crate::app::profiles::{load_profile, with_user};
use crate::cli::args::ReplayArgs;
use crate::cli::exit;
use crate::cli::progress::solve_pad;
use crate::engine::{Engine, Input};
use crate::pad::Pad;
use crate::profile::Profile;
use crate::tape::EngineConfig;
use crate::touch::{Correction, SensingBuilder};

/// Parts of a recording that are replaced.
pub(super) struct ReplayOverrides {
    profile: bool,
    /// Matrices are computed instead of read from the recording.
    matrix: bool,
    calibration: bool,
}

impl ReplayOverrides {
    pub(super) fn from_args(args: &ReplayArgs) -> Self {
        Self {
            profile: args.profile.is_some() || args.user.is_some(),
            matrix: args.pad.is_some() || args.method.is_some(),
            calibration: args.calibration.is_some(),
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        !(self.profile || self.matrix || self.calibration)
    }

    /// Whether a recorded input belongs to a replaced part. Ticks belong to the profile; the engine ticks itself at the
    /// next frame.
    pub(super) fn replaces(&self, input: &Input) -> bool {
        match input {
            Input::Profile { .. } | Input::Tick { .. } => self.profile,
            Input::Matrix(_) => self.matrix,
            _ => false,
        }
    }

    /// The engine with the replaced parts, and the builder of its later matrices if the recording's are not used.
    pub(super) fn engine(
        &self,
        args: &ReplayArgs,
        recorded: &EngineConfig,
    ) -> anyhow::Result<(Engine, Option<SensingBuilder>)> {
        let mut config = recorded.clone();
        if let Some(pad) = &args.pad {
            let pad = load_pad(pad)?.pad;
            let (needs, has) = (pad.channels(), config.pad.channels());
            if needs != has {
                anyhow::bail!(
                    "the pad {} has {needs} voltages per frame, the recording {has}\n  help: leave out --pad: a recording contains its own",
                    pad.name
                );
            }
            config.pad = pad;
        }
        if self.profile {
            config.profile = match &args.profile {
                Some(profile) => load_profile_and_warn(profile, args.user.as_deref())?,
                None => Arc::new(with_user(&config.profile, args.user.as_deref())?),
            };
        }
        if args.calibration.is_some() {
            config.correction = load_correction(args.calibration.as_deref(), &config.pad)?;
        }
        if !self.matrix {
            return Ok((config.engine(), None));
        }
        let method = choose_method(args.method, &config.profile, &config.pad);
        let builder = match (&args.pad, &config.table) {
            (None, Some(table)) => {
                SensingBuilder::new(&config.pad, method)?.with_table(Arc::clone(table))
            }
            _ => solve_pad(&config.pad, method)?,
        };
        config.sensing = Arc::new(builder.build_initial()?);
        Ok((config.engine(), Some(builder)))
    }
}

/// Reads a profile and prints its warnings.
pub(super) fn load_profile_and_warn(
    argument: &str,
    user: Option<&str>,
) -> anyhow::Result<Arc<Profile>> {
    let checked = load_profile(argument, user)?;
    checked.warnings.iter().for_each(exit::warn);
    Ok(Arc::new(checked.profile))
}

/// Reads the calibration of `--calibration`, if it is given.
pub(super) fn load_correction(
    file: Option<&Path>,
    pad: &Pad,
) -> anyhow::Result<Option<Correction>> {
    Ok(file.map(|file| calibration::load(file, pad)).transpose()?)
}
