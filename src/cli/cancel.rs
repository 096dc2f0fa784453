//! `tsc-family cancel`: takes back what batch systems have of a run.

use std::path::PathBuf;

use super::executors::{Count, abroad, system_of};
use super::output::line;
use crate::cli::exit;
use crate::report::format;
use crate::run::batch::{BatchSystem, Script, Standing, submission};
use crate::run::error::RunError;
use crate::run::session::now;
use crate::store::Layout;
use crate::store::manifest::Manifest;

/// `tsc-family cancel`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Records and checkpoints stay; `resume` continues from them.

Example:
  tsc-family cancel results/slc")]
pub struct CancelArgs {
    /// Results directory of the run
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
}

pub(super) fn run(args: &CancelArgs) -> anyhow::Result<u8> {
    let layout = Layout::new(&args.dir);
    Manifest::read(&layout)?;
    let there = abroad(&layout).map_err(RunError::from)?;
    there.say_of_another();
    let ends = |(standing, ..): &Count| *standing == Standing::Ending;
    let (ending, there): (Vec<_>, Vec<_>) =
        there.submissions.into_iter().partition(|(_, counts)| counts.iter().all(ends));
    for (submission, _) in &ending {
        line(format!(
            "submission {} ({}) is ending",
            submission.number,
            submission.ids.join(", ")
        ))?;
    }
    if there.is_empty() && ending.is_empty() {
        let scripts = submission::all(&layout).map_err(RunError::from)?;
        let by_hand = scripts.iter().any(|s| s.executor == Script.name());
        line(if by_hand {
            "no batch system that can be queried has jobs of this run; if you started the script, stop it yourself"
        } else {
            "no batch system has jobs of this run"
        })?;
        return Ok(exit::DONE);
    }
    for (mut submission, counts) in there {
        system_of(&submission)?.cancel(&submission).map_err(RunError::from)?;
        submission.cancelled = Some(now());
        submission::write(&layout, &submission)?;
        let counts = counts.iter().filter(|count| !ends(count));
        let packs: usize = counts.map(|(.., count)| count).sum();
        line(format!(
            "submission {} ({}): {} cancelled; finished tasks stay, and resume continues",
            submission.number,
            submission.ids.join(", "),
            format::count(packs, "pack")
        ))?;
    }
    Ok(exit::DONE)
}
