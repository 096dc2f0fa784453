//! How a worker is started: a program with what comes before and after the subcommand.

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::Command;

/// A program that answers the subcommands of workers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Launcher {
    /// The program.
    pub program: PathBuf,
    /// Arguments before the subcommand, as of an interpreter.
    pub first: Vec<OsString>,
    /// Arguments after all others: the methods that are not the program's own.
    pub last: Vec<OsString>,
}

impl Launcher {
    /// Returns a program that needs nothing before and after the subcommand.
    pub fn of(program: impl Into<PathBuf>) -> Self {
        Self { program: program.into(), first: Vec::new(), last: Vec::new() }
    }

    /// Returns a subcommand with its arguments.
    pub fn command(&self, subcommand: &str, arguments: &[OsString]) -> Command {
        let mut command = Command::new(&self.program);
        command.args(&self.first).arg(subcommand).args(arguments).args(&self.last);
        command
    }
}
