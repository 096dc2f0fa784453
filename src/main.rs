//! Parses the command line and turns the outcome into an exit code.

use std::process::ExitCode;

use tsc_family::cli::{self, exit};

fn main() -> ExitCode {
    cli::complete();
    match cli::run(cli::parse()) {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            cli::complain(&error);
            ExitCode::from(exit::code(error.as_ref()))
        }
    }
}
