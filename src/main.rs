//! The command line.

use std::process::ExitCode;

use tsc_family::cli;

/// A report of a million tasks is made of small things: with it that takes a fifth to two fifths less of the processor.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    cli::main_with(Default::default())
}
