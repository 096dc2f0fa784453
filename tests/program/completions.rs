//! What a shell offers when Tab is pressed: asked of bash itself.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::common::{stderr, stdout};
use tsc_family::domains::{domains, others};
use tsc_family::settings::named::Named;
use tsc_family::traffic::control::registry::METHODS;
use tsc_family::traffic::family::load::EMBEDDED;
use tsc_family::traffic::settings::Scenario;

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
fn methods_are_offered_and_of_a_list_the_last_is_completed() {
    let names = || domains().into_iter().flat_map(|domain| domain.methods()).map(|m| m.name);
    let all: Vec<&str> = names().chain(["all"]).collect();
    assert_eq!(press_tab(&["run", "--methods", ""]), all);
    assert_eq!(press_tab(&["run", "smoke", "--methods", "actu"]), ["actuated"]);
    let second = press_tab(&["run", "--methods", "baseline,fixed"]);
    assert_eq!(second, ["baseline,fixed-time"]);
    let against: Vec<&str> = names().collect();
    assert_eq!(press_tab(&["report", "results", "--against", ""]), against);
    assert_eq!(press_tab(&["run", "--against", "actu"]), ["actuated"]);
    assert_eq!(press_tab(&["across", "results", "--methods", ""]), against);
}

#[test]
fn settings_are_offered_with_their_equals_sign() {
    let others = others().iter().flat_map(|entry| (entry.names)());
    let all: BTreeSet<String> =
        Scenario::names().iter().chain(others).map(|name| format!("{name}=")).collect();
    assert!(all.contains("ppo.gamma=") && all.contains("idqn.gamma="));
    let mut found = press_tab(&["run", "--set", ""]);
    found.sort();
    assert_eq!(found, all.into_iter().collect::<Vec<_>>());
    for command in ["list", "build-networks", "run", "evaluate", "routes", "signals"] {
        assert_eq!(
            press_tab(&[command, "--set", "demand.hor"]),
            ["demand.horizon_s="],
            "{command}"
        );
    }
    assert!(press_tab(&["run", "--set", "nowhere"]).is_empty());
}

#[test]
fn scenarios_are_offered_besides_files_and_folders() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("networks")).unwrap();
    for file in ["my-city.toml", "notes.txt"] {
        fs::write(folder.path().join(file), "").unwrap();
    }
    let others = others().iter().flat_map(|entry| entry.scenarios).copied();
    let embedded = EMBEDDED.iter().map(|(name, _)| *name).chain(others);
    for command in ["list", "run", "build-networks"] {
        let found = offered(folder.path(), &[command, ""]);
        let scenarios: Vec<&str> =
            found.iter().map(String::as_str).filter(|f| !f.starts_with('-')).collect();
        let all: Vec<&str> = embedded.clone().chain(["my-city.toml", "networks/"]).collect();
        let mut sorted = all.clone();
        sorted.sort_unstable();
        let mut found = scenarios;
        found.sort_unstable();
        assert_eq!(found, sorted, "{command}");
    }
    assert_eq!(offered(folder.path(), &["run", "sm"]), ["smoke"]);
    assert_eq!(offered(folder.path(), &["signals", "no"]), ["notes.txt"]);
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

#[test]
fn zsh_and_fish_are_told_what_a_method_does() {
    let asked = |shell: &str| {
        let mut program = crate::common::program(&std::env::temp_dir());
        program.args(["--", "tsc-family", "run", "--methods", "actu"]);
        program.env("TSC_FAMILY_COMPLETE", shell).env("_CLAP_COMPLETE_INDEX", "3");
        stdout(&program.output().unwrap())
    };
    let summary = METHODS.iter().find(|m| m.name == "actuated").unwrap().summary;
    assert_eq!(asked("fish"), format!("actuated\t{summary}\n"));
    assert_eq!(asked("zsh"), format!("actuated:{summary}"));
}
