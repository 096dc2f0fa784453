//! What a shell offers when Tab is pressed: asked of bash itself.

use std::process::{Command, Stdio};

use crate::common::{stderr, stdout};
use crate::folder::Folder;

/// Has bash complete the last word of a line in a folder, as at the press of Tab. The line is split as bash does, at `=` too.
const PRESS_TAB: &str = r#"
source <("$PROGRAM" completions bash)
COMP_WORDS=("$@")
COMP_CWORD=$(($# - 1))
COMP_TYPE=9
_clap_complete_tsc_family "$1" "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD-1]}"
printf '%s\n' "${COMPREPLY[@]}"
"#;

fn offered(folder: &Folder, line: &str) -> Vec<String> {
    let output = Command::new("bash")
        .args(["--norc", "-c", PRESS_TAB, "bash", "tsc-family"])
        .args(line.split(' '))
        .env("PROGRAM", env!("CARGO_BIN_EXE_tsc-family"))
        .current_dir(folder.path())
        .stdin(Stdio::null())
        .output()
        .expect("bash is there");
    assert!(output.status.success(), "{line}: {}", stderr(&output));
    stdout(&output).lines().map(str::to_owned).filter(|line| !line.is_empty()).collect()
}

#[test]
fn commands_options_and_their_values_are_offered() {
    let folder = Folder::with(&[("my-city.toml", ""), ("notes.txt", "")]);
    for (line, expected) in [
        ("build", &["build-networks"][..]),
        ("run --eval", &["--eval-seeds"]),
        ("run --preset tun", &["tuned"]),
    ] {
        assert_eq!(offered(&folder, line), expected, "{line}");
    }
}

#[test]
fn every_shell_gets_a_script_that_asks_this_program() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = Folder::new().run(&format!("completions {shell}"));
        assert!(script.contains(env!("CARGO_BIN_EXE_tsc-family")), "{shell}: {script}");
    }
}
