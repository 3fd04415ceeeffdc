//! Arguments of `gelpad pad` and `gelpad profile`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

#[derive(Debug, Subcommand)]
#[command(after_help = "Example: gelpad pad check ./my-pad.toml")]
pub(in crate::cli) enum PadCommand {
    /// List the shipped pads
    #[command(after_help = "Example: gelpad pad list")]
    List,
    /// Check a pad's text, and whether the pad gives an image
    #[command(after_help = "Example: gelpad pad check ./my-pad.toml")]
    Check {
        /// A shipped pad, or a file
        #[arg(default_value = crate::pad::DEFAULT_PAD)]
        pad: String,
    },
    /// Show a pad: drawing and dimensions; --toml prints its text, to copy and edit
    #[command(after_help = "Example: gelpad pad show edinburgh-lattice --toml > my-pad.toml")]
    Show {
        /// A shipped pad, or a file
        #[arg(default_value = crate::pad::DEFAULT_PAD)]
        pad: String,
        /// Print its text
        #[arg(long)]
        toml: bool,
    },
}

#[derive(Debug, Subcommand)]
#[command(after_help = "Example: gelpad profile check ./mine.toml")]
pub(in crate::cli) enum ProfileCommand {
    /// List the shipped profiles and user settings
    #[command(after_help = "Example: gelpad profile list")]
    List,
    /// Check a profile: errors and warnings
    #[command(after_help = "Example: gelpad profile check ./mine.toml --user anna")]
    Check {
        /// A shipped profile, or a file
        #[arg(default_value = crate::profile::DEFAULT_PROFILE)]
        profile: String,
        /// Apply the settings of one user
        #[arg(long, value_name = "NAME")]
        user: Option<String>,
    },
    /// Print the JSON schema of profiles, for editors
    #[command(after_help = "Example: gelpad profile schema > profile.schema.json")]
    Schema,
    /// Show a profile: map, bindings, and where each value comes from
    #[command(after_help = "\
Examples:
  gelpad profile show super-mario --toml > mine.toml      prints its text, to copy and edit
  gelpad profile show ./mine.toml --print regions.svg     draws a sheet to print, cut out and lay on the pad")]
    Show(ShowArgs),
}

#[derive(Args, Debug)]
pub(in crate::cli) struct ShowArgs {
    /// A shipped profile, or a file
    #[arg(default_value = crate::profile::DEFAULT_PROFILE)]
    pub profile: String,
    /// Apply the settings of one user
    #[arg(long, value_name = "NAME")]
    pub user: Option<String>,
    /// Print its text
    #[arg(long, conflicts_with_all = ["svg", "png", "print"])]
    pub toml: bool,
    /// Draw the regions as SVG
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// Draw the regions as PNG
    #[arg(long, value_name = "FILE")]
    pub png: Option<PathBuf>,
    /// Draw the regions as SVG at true scale on an A4 sheet, with a ruler
    #[arg(long, value_name = "FILE")]
    pub print: Option<PathBuf>,
    /// The pad that gives the drawings their size
    #[arg(long, default_value = crate::pad::DEFAULT_PAD)]
    pub pad: String,
}
