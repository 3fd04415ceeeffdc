//! The `gelpad` command: see `gelpad --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    gelpad::cli::main()
}
