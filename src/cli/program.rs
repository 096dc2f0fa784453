//! The command line as a program: this one, or somebody's that has methods of its own.

use std::ffi::OsString;
use std::process::ExitCode;

use clap::CommandFactory;

use super::{Cli, complain, exit, own, parse, run, shell};
use crate::traffic::domain::Traffic;
use crate::traffic::own::Host;

/// A program that is this command line with something of its own.
#[derive(Default)]
pub struct Program {
    /// Signals, with further methods.
    pub traffic: Traffic,
    /// How the program is started again, as workers are: program and first arguments. Empty for its executable alone.
    pub start: Vec<OsString>,
    /// What opens controllers in another language.
    pub host: Option<Box<dyn Host>>,
}

/// Runs the command line of this process with further methods of signals, and returns its exit code. Workers are the
/// same program, so that they have them too.
///
/// ```no_run
/// use tsc_family::{Traffic, cli};
///
/// fn main() -> std::process::ExitCode {
///     cli::main_with(Traffic::default())
/// }
/// ```
pub fn main_with(traffic: Traffic) -> ExitCode {
    // It answers the script of a shell and ends the process, if it is that which asks.
    shell::complete(Cli::command);
    let program = Program { traffic, ..Program::default() };
    ExitCode::from(main_of(program, std::env::args_os().collect()))
}

/// Runs a command line and returns its exit code; to be called once in a process.
///
/// # Arguments
///
/// * `args` — the program's name and its arguments.
pub fn main_of(program: Program, args: Vec<OsString>) -> u8 {
    let cli = match parse(&args) {
        Ok(cli) => cli,
        Err(code) => return code,
    };
    let done = own::set_up(&cli.command, program).and_then(|()| run(cli));
    done.unwrap_or_else(|error| {
        complain(&error);
        exit::code(error.as_ref())
    })
}
