//! `tsc-family completions`: made at run time from the command line's types.

use std::path::Path;

use anyhow::Context;
use clap_complete::env::{CompleteEnv, Shells};

use crate::cli::exit;

/// Environment variable by which a shell's script asks for completions; its value is the shell.
const ASKS: &str = "TSC_FAMILY_COMPLETE";

/// Name of the program on the command line.
const PROGRAM: &str = "tsc-family";

/// `tsc-family completions`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  tsc-family completions bash > ~/.local/share/bash-completion/completions/tsc-family
  echo 'source <(tsc-family completions zsh)' >> ~/.zshrc
  tsc-family completions fish > ~/.config/fish/completions/tsc-family.fish")]
pub struct CompletionsArgs {
    /// The shell
    pub shell: clap_complete::Shell,
}

/// Answers the script of a shell and ends the process, if it is that which asks.
pub(super) fn complete(command: fn() -> clap::Command) {
    CompleteEnv::with_factory(command).var(ASKS).bin(PROGRAM).complete();
}

pub(super) fn completions(args: &CompletionsArgs) -> anyhow::Result<u8> {
    let shells = Shells::builtins();
    let shell = args.shell.to_string();
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
    print(&script)
}

fn print(text: &[u8]) -> anyhow::Result<u8> {
    super::output::write(text)?;
    Ok(exit::DONE)
}
