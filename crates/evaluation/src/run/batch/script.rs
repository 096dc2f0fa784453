//! A script that does one pack by its number, for whatever starts scripts: GNU parallel, PBS, Kubernetes' indexed jobs.

use std::fs;
use std::os::unix::fs::PermissionsExt;

use super::submission::{Place, Submission};
use super::{BatchError, BatchSystem, Waiting};
use crate::run::executor::Launcher;
use basics::files::{FileError, quoted, write_atomically};

/// Writes a script and leaves the rest to people.
#[derive(Debug, Clone, Copy)]
pub struct Script;

impl BatchSystem for Script {
    fn name(&self) -> &'static str {
        "script"
    }

    fn submit(&self, submission: &Submission, place: &Place) -> Result<Vec<String>, BatchError> {
        let text = format!(
            "#!/bin/sh\n\
             # Does one pack of tasks of a tsc-family run: job.sh PACK, from 0 to {last}.\n\
             # PBS and Kubernetes' indexed jobs give the number by themselves. Exit code 75: stopped at a checkpoint,\n\
             # start it again. A pack that is over ends at once, and one that runs twice does no harm.\n\
             pack=${{1:-${{PBS_ARRAY_INDEX:-$JOB_COMPLETION_INDEX}}}}\n\
             case $pack in\n\
             '' | *[!0-9]*) echo \"usage: $0 PACK, from 0 to {last}\" >&2; exit 2 ;;\n\
             esac\n\
             cd {from} || exit 1\n\
             exec {work} --pack \"$pack\"\n",
            last = submission.packs.saturating_sub(1),
            from = quoted(&place.from),
            work = command(submission, place),
        );
        write_executable(place, &text)?;
        Ok(Vec::new())
    }

    fn waiting(&self, _: &[Submission]) -> Result<Vec<Vec<Waiting>>, BatchError> {
        Ok(Vec::new())
    }

    fn release(&self, _: &Submission) -> Result<(), BatchError> {
        Ok(())
    }

    fn cancel(&self, _: &Submission) -> Result<(), BatchError> {
        Ok(())
    }

    fn how(&self, submission: &Submission, place: &Place) -> String {
        let (script, last) = (quoted(&place.script()), submission.packs.saturating_sub(1));
        let log = quoted(&place.folder.join("joblog"));
        let pbs = for_pbs(&script, last);
        format!(
            "{script} does one pack, from 0 to {last}; for instance\n  \
             seq 0 {last} | parallel --joblog {log} --retries 3 {script}\n  \
             seq 0 {last} | parallel --sshlogin 4/one,4/two --retries 3 {script}\n  \
             {pbs}\n  \
             and in Kubernetes an indexed Job with completions: {packs} and backoffLimitPerIndex",
            packs = submission.packs
        )
    }
}

/// Returns the command that has PBS do the packs from 0 to `last`; it has no arrays of one.
fn for_pbs(script: &str, last: usize) -> String {
    match last {
        0 => format!("qsub -- {script} 0"),
        _ => format!("qsub -J 0-{last} {script}"),
    }
}

/// Returns a program with what comes before its subcommand, for a shell.
fn launched(launcher: &Launcher) -> String {
    let first = launcher.first.iter().map(|argument| quoted(argument.as_ref()));
    std::iter::once(quoted(&launcher.program)).chain(first).collect::<Vec<_>>().join(" ")
}

/// Returns the command that does packs of a submission, without the pack's number.
pub(super) fn command(submission: &Submission, place: &Place) -> String {
    let mut command = format!(
        "{} work {} --submission {} --jobs {} --stall-timeout {}",
        launched(&place.launcher),
        quoted(&place.results),
        submission.number,
        submission.workers,
        submission.stall_timeout_s,
    );
    if let Some(memory_mb) = submission.memory_per_worker_mb {
        command.push_str(&format!(" --memory-per-worker {memory_mb}"));
    }
    if !place.prepared.as_os_str().is_empty() {
        command.push_str(&format!(" --prepared {}", quoted(&place.prepared)));
    }
    for argument in place.launcher.last() {
        command.push_str(&format!(" {}", quoted(argument.as_ref())));
    }
    command
}

/// Writes the script of a submission so that it can be started.
pub(super) fn write_executable(place: &Place, text: &str) -> Result<(), FileError> {
    let path = place.script();
    write_atomically(&path, text.as_bytes())?;
    let executable = fs::Permissions::from_mode(0o755);
    fs::set_permissions(&path, executable).map_err(FileError::at("make executable", &path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pbs_is_given_no_array_of_one_pack() {
        assert_eq!(for_pbs("a/job.sh", 0), "qsub -- a/job.sh 0");
        assert_eq!(for_pbs("a/job.sh", 1), "qsub -J 0-1 a/job.sh");
    }
}
