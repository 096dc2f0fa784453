//! `tsc-family completions`: made at run time from the command line's types.

use std::path::Path;

use anyhow::Context;
use clap_complete::Shell;
use clap_complete::env::{CompleteEnv, Shells};

use crate::cli::exit;

/// Environment variable by which a shell's script asks for completions; its value is the shell.
const ASKS: &str = "TSC_FAMILY_COMPLETE";

/// Name of the program on the command line.
const PROGRAM: &str = "tsc-family";

/// Answers the script of a shell and ends the process, if it is that which asks.
pub(super) fn complete(command: fn() -> clap::Command) {
    CompleteEnv::with_factory(command).var(ASKS).bin(PROGRAM).complete();
}

pub(super) fn completions(shell: Shell) -> anyhow::Result<u8> {
    let shells = Shells::builtins();
    let shell = shell.to_string();
    let shell = shells.completer(&shell).with_context(|| format!("no completions for {shell}"))?;
    // Called by its name it is found by its name later too, also where another is installed.
    let called = std::env::args_os().next().unwrap_or_else(|| PROGRAM.into());
    let called = match Path::new(&called).components().count() {
        0 | 1 => called,
        _ => std::path::absolute(&called)?.into_os_string(),
    };
    let mut script = Vec::new();
    let called = called.to_string_lossy();
    shell.write_registration(ASKS, PROGRAM, PROGRAM, &called, &mut script)?;
    super::output::write(&script)?;
    Ok(exit::DONE)
}
