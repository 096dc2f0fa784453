//! Results that are made in a tenth of a second.

use std::path::Path;
use std::process::Command;

/// The run, which does what is missing.
pub(crate) const RUN: &str = "run cartpole --methods ppo --budget 3 --eval-seeds 2 --set ppo.total_steps=600 --out results --quiet";

/// Makes the results of a learner on some carts in `DIR/results`.
pub(crate) fn quick_results(folder: &Path) {
    let mut program = Command::new(env!("CARGO_BIN_EXE_tsc-family"));
    let output =
        program.current_dir(folder).args(RUN.split_whitespace()).output().expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
