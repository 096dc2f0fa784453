//! Parses the command line and turns the outcome into an exit code.

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;
use tsc_family::cli::{self, exit};

fn main() -> ExitCode {
    cli::complete();
    match cli::run(cli::Cli::parse()) {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            // Nothing can be done about a closed standard error.
            let _ = writeln!(std::io::stderr(), "error: {error:#}");
            ExitCode::from(exit::code(error.as_ref()))
        }
    }
}
