//! `tsc-family completions`: made at run time from the command line's types.
//!
//! The script of a shell asks this program what fits, at every press of Tab: so methods, scenarios and
//! settings are those of the program that is installed, and of `a,b` the last one is completed.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::Path;

use anyhow::Context;
use clap::Arg;
use clap_complete::engine::{
    ArgValueCompleter, CompletionCandidate, PathCompleter, ValueCompleter,
};
use clap_complete::env::{CompleteEnv, Shells};

use crate::cli::exit;
use crate::domains::{domains, others};
use crate::run::method::Method;
use crate::settings::named::Named;
use crate::traffic::family::load::EMBEDDED;
use crate::traffic::settings::{Scenario, table};

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
    CompleteEnv::with_factory(|| with_candidates(command())).var(ASKS).bin(PROGRAM).complete();
}

/// Returns the command line with what fits where clap cannot know it.
fn with_candidates(command: clap::Command) -> clap::Command {
    let known = |command: clap::Command| command.mut_args(with_values);
    known(command).mut_subcommands(known)
}

/// Returns an argument with its values; other values stay allowed.
fn with_values(arg: Arg) -> Arg {
    let completer = match arg.get_id().as_str() {
        "scenario" => ArgValueCompleter::new(|word: &OsStr| {
            let others = others().iter().flat_map(|entry| entry.scenarios).copied();
            let carried = EMBEDDED.iter().map(|(name, _)| *name).chain(others);
            let names = starting(word, carried.map(str::to_owned));
            let files = PathCompleter::any().filter(is_scenario).complete(word);
            names.into_iter().chain(files).collect()
        }),
        "set" => ArgValueCompleter::new(|word: &OsStr| {
            let others = others().iter().flat_map(|entry| (entry.names)());
            let names: BTreeSet<&String> = Scenario::names().iter().chain(others).collect();
            let fits = |name: &&String| word.to_str().is_some_and(|w| name.starts_with(w));
            names.into_iter().filter(fits).map(setting).collect()
        }),
        "methods" => ArgValueCompleter::new(|word: &OsStr| {
            methods(word).into_iter().chain(starting(word, ["all".to_owned()])).collect()
        }),
        "against" | "compared" => ArgValueCompleter::new(methods),
        "budget" => ArgValueCompleter::new(|word: &OsStr| starting(word, ["all".to_owned()])),
        // Either the path of a file or something else.
        "place" | "boundary" => ArgValueCompleter::new(PathCompleter::any()),
        _ => return arg,
    };
    arg.add(completer)
}

/// Returns the methods that start with what is typed, each with its summary.
fn methods(word: &OsStr) -> Vec<CompletionCandidate> {
    let all = domains().into_iter().flat_map(|domain| domain.methods());
    let fitting = all.filter(|m| word.to_str().is_some_and(|w| m.name.starts_with(w)));
    let with_summary = |m: &Method| CompletionCandidate::new(m.name).help(Some(m.summary.into()));
    fitting.map(with_summary).collect()
}

/// Returns a setting with its equals sign and what it is.
fn setting(name: &String) -> CompletionCandidate {
    let others = || others().iter().find_map(|entry| (entry.setting)(name));
    let what = table::find(name).or_else(others).map(|setting| setting.headline().into());
    CompletionCandidate::new(format!("{name}=")).help(what)
}

/// Whether a file may be a scenario; folders on the way to one are offered in any case.
fn is_scenario(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "toml")
}

/// Returns the values that start with what is typed.
fn starting(word: &OsStr, values: impl IntoIterator<Item = String>) -> Vec<CompletionCandidate> {
    let Some(word) = word.to_str() else { return Vec::new() };
    let fitting = values.into_iter().filter(|value| value.starts_with(word));
    fitting.map(CompletionCandidate::new).collect()
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
