//! The command line.

use std::process::ExitCode;

use tsc_family::{Traffic, cli};

fn main() -> ExitCode {
    cli::main_with(Traffic::default())
}
