//! What a shell offers when Tab is pressed: asked of bash itself.

use std::path::Path;
use std::process::{Command, Stdio};

use crate::common::{stderr, stdout};

/// Has bash complete the last word of a line in a folder, as at the press of Tab, and returns what it
/// offers. The line is split as bash does, at `=` too.
const PRESS_TAB: &str = r#"
source <("$PROGRAM" completions bash)
COMP_WORDS=("$@")
COMP_CWORD=$(($# - 1))
COMP_TYPE=9
_clap_complete_tsc_family "$1" "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD-1]}"
printf '%s\n' "${COMPREPLY[@]}"
"#;

fn offered(folder: &Path, words: &[&str]) -> Vec<String> {
    let output = Command::new("bash")
        .args(["--norc", "-c", PRESS_TAB, "bash", "tsc-family"])
        .args(words)
        .env("PROGRAM", env!("CARGO_BIN_EXE_tsc-family"))
        .current_dir(folder)
        .stdin(Stdio::null())
        .output()
        .expect("bash is there");
    assert!(output.status.success(), "{words:?}: {}", stderr(&output));
    stdout(&output).lines().map(str::to_owned).filter(|line| !line.is_empty()).collect()
}

/// What bash offers in an empty folder.
fn press_tab(words: &[&str]) -> Vec<String> {
    offered(tempfile::tempdir().unwrap().path(), words)
}

#[test]
fn commands_options_and_their_values_are_offered() {
    assert_eq!(press_tab(&["build"]), ["build-networks"]);
    assert!(!press_tab(&[""]).contains(&"worker".to_owned()), "it is for `run` alone");
    assert_eq!(press_tab(&["run", "--eval"]), ["--eval-seeds"]);
    assert_eq!(press_tab(&["evaluate", "--sum"]), ["--sumocfg"]);
    assert_eq!(press_tab(&["run", "--preset", ""]), ["resco", "field", "sb3", "tuned"]);
}

#[test]
fn every_shell_gets_a_script_that_asks_this_program() {
    let folder = tempfile::tempdir().unwrap();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = crate::common::succeed(folder.path(), &format!("completions {shell}"));
        assert!(script.contains("TSC_FAMILY_COMPLETE"), "{shell}: {script}");
        assert!(script.contains(env!("CARGO_BIN_EXE_tsc-family")), "{shell}: {script}");
    }
}
