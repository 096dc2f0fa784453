//! The first load of a scenario: by plain `sumo`, in a process of its own.
//!
//! - **Crashes.** SUMO ends its process where one of its assertions fails, as Debian's build does, and this process with it.
//! - **Reasons.** SUMO 1.15 writes some of its reasons to standard error only.
//!
//! Where there is no `sumo` of libsumo's version, the first load is that of libsumo.

use std::ffi::{CString, OsStr};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use crate::network::subprocess::output_of;
use crate::network::tool::{find, version_in};
use basics::machine::is_from_outside;

/// How SUMO's errors begin.
const ERROR: &str = "Error: ";

/// Most of them that are quoted.
const QUOTED: usize = 3;

/// Longest time that is waited; libsumo is tried then.
const LIMIT: Duration = Duration::from_secs(3600);

/// What `sumo` said of a scenario.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Said {
    /// Its last line, where it crashed.
    pub(super) crash: Option<String>,
    /// Its first errors; empty without any.
    pub(super) errors: String,
}

/// Has `sumo` load a scenario.
/// * `command_line` — that of an episode that ends after its first step.
/// * `version` — that of libsumo.
pub(super) fn first_load(command_line: &[CString], version: &str) -> Said {
    let found = find("sumo").ok().filter(|(_, own)| version_in(version).as_ref() == Some(own));
    found.map_or_else(Said::default, |(sumo, _)| said(&sumo, command_line))
}

fn said(sumo: &Path, command_line: &[CString]) -> Said {
    let mut command = Command::new(sumo);
    command.args(command_line.iter().skip(1).map(|arg| OsStr::from_bytes(arg.as_bytes())));
    // Where it cannot be started, libsumo says what is wrong.
    let Ok(Some((status, _, text))) = output_of(command, LIMIT) else { return Said::default() };
    let crashed = status.signal().is_some_and(|signal| !is_from_outside(signal));
    let last = text.lines().map(str::trim).rfind(|line| !line.is_empty());
    let crash = crashed.then(|| last.unwrap_or("it said nothing").to_owned());
    Said { crash, errors: errors(&text) }
}

/// Returns the first errors in what SUMO said; an error may go on in the next line, which begins with a blank.
fn errors(text: &str) -> String {
    let mut errors: Vec<String> = Vec::new();
    let mut goes_on = false;
    for line in text.lines() {
        let begins = line.strip_prefix(ERROR);
        goes_on = begins.is_some() || goes_on && line.starts_with(' ');
        match (begins, errors.last_mut()) {
            (Some(error), _) => errors.push(error.trim().to_owned()),
            (None, Some(last)) if goes_on => *last = format!("{last} {}", line.trim()),
            _ => {}
        }
    }
    errors.truncate(QUOTED);
    errors.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is said of a program that does this.
    fn said_by(script: &str) -> Said {
        let arguments = ["sh", "-c", script].map(|arg| CString::new(arg).unwrap());
        said(Path::new("/bin/sh"), &arguments)
    }

    #[test]
    fn a_crash_is_told_with_its_last_line() {
        let crash = "echo 'Warning: slow' >&2; echo 'Assertion failed.' >&2; kill -ABRT $$";
        assert_eq!(said_by(crash).crash.as_deref(), Some("Assertion failed."));
        assert_eq!(said_by("kill -SEGV $$").crash.as_deref(), Some("it said nothing"));
        assert_eq!(said_by("kill -TERM $$").crash, None, "somebody ended it");
        assert_eq!(said_by("echo 'Warning: slow' >&2"), Said::default());
        assert_eq!(said(Path::new("/nowhere/sumo"), &[]), Said::default());
    }

    #[test]
    fn errors_are_told_in_one_text() {
        let script = "printf 'Warning: slow\\n on\\nError: No edge.\\n Quitting\\nQuitting (on error).\\n' >&2; exit 1";
        let refused = said_by(script);
        assert_eq!((refused.crash, refused.errors.as_str()), (None, "No edge. Quitting"));
        assert_eq!(errors(&"Error: a.\n".repeat(5)), "a. a. a.");
        assert_eq!(errors("all is well\n"), "");
    }
}
