//! The command line.

use std::process::ExitCode;

use tsc_family::cli;

fn main() -> ExitCode {
    cli::main_with(Default::default())
}
