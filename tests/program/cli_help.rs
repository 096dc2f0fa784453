//! Every word of the help is a snapshot.

use crate::common::succeed;

fn help(args: &str) -> String {
    succeed(&std::env::temp_dir(), args)
}

#[test]
fn the_help_of_every_command_stays_as_it_is() {
    for (name, args) in [
        ("help", "--help"),
        ("help_list", "list --help"),
        ("help_build_networks", "build-networks --help"),
        ("help_run", "run --help"),
        ("help_train", "train --help"),
        ("help_evaluate", "evaluate --help"),
        ("help_routes", "routes --help"),
        ("help_signals", "signals --help"),
        ("help_report", "report --help"),
        ("help_check", "check --help"),
        ("help_estimate", "estimate --help"),
        ("help_compare", "compare --help"),
        ("help_across", "across --help"),
        ("help_sensitivity", "sensitivity --help"),
        ("help_doctor", "doctor --help"),
        ("help_completions", "completions --help"),
    ] {
        insta::assert_snapshot!(name, help(args));
    }
}
