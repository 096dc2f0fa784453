//! Slurm: a job array, one element per pack.
//!
//! A worker runs as a step (`srun`), so that the warning before the limit of time and the grace of a preemption reach it;
//! it keeps its training and ends with [`STOPPED`], on which the script queues the element again. What a node that died
//! had is queued again by Slurm. Who is still there is asked of `squeue`, which needs no accounting database; what is
//! done, of the results directory.

use std::path::Path;
use std::process::Command;

use super::script::{command, write_executable};
use super::submission::{Place, Submission, is_number};
use super::{BatchError, BatchSystem, RESTARTS, Standing, Waiting};
use crate::run::STOPPED;
use basics::files::{self, limits};

/// Elements of an array: Slurm takes indices below 1001 unless it was set up otherwise.
pub const PACKS_PER_ARRAY: usize = 1000;

/// Name of the jobs.
const NAME: &str = "tsc-family";

/// Seconds before the limit of time at which a job is told: time for the episode that runs and its checkpoint.
const WARNING_S: u32 = 90;

/// Of these, those that workers are given.
const GRACE_S: u32 = 75;

/// Times the expected time of the longest pack that a job may take; a pack that is not done by then goes on in the next.
const PATIENCE: f64 = 4.0;

/// Least limit of time, minutes.
const LEAST_MINUTES: f64 = 15.0;

/// Memory of a job beside that of its workers, MB.
const OWN_MB: u64 = 100;

/// Options that would take from a job what this needs of it.
const OURS: [&str; 12] =
    ["array", "a", "output", "o", "error", "e", "signal", "wrap", "chdir", "D", "job-name", "J"];

/// Letters of options of `sbatch` without a value.
const FLAGS: &str = "HhkOQsuvVW";

/// The Slurm of this machine.
#[derive(Debug, Clone, Copy)]
pub struct Slurm;

impl BatchSystem for Slurm {
    fn name(&self) -> &'static str {
        "slurm"
    }

    fn submit(&self, submission: &Submission, place: &Place) -> Result<Vec<String>, BatchError> {
        write_executable(place, &text(submission, place))?;
        let output = place.output().join("%A_%a.txt");
        let mut ids: Vec<String> = Vec::new();
        for first in (0..submission.packs).step_by(PACKS_PER_ARRAY) {
            let last = (submission.packs - first).min(PACKS_PER_ARRAY) - 1;
            let mut sbatch = Command::new("sbatch");
            sbatch
                .args(["--parsable", "--job-name", NAME])
                .arg(format!("--array=0-{last}"))
                .arg("--output")
                .arg(&output)
                .arg("--chdir")
                .arg(&place.from)
                .arg(place.script())
                .arg(first.to_string());
            match said("sbatch", &mut sbatch) {
                // With the name of the cluster behind it, where there are several.
                Ok(said) => {
                    let id = said.trim().split(';').next().unwrap_or_default();
                    if !is_number(id) {
                        return Err(BatchError::Refused { command: "sbatch", said });
                    }
                    ids.push(id.to_owned());
                }
                Err(e) => {
                    // All or nothing: what was taken so far could not be found again.
                    if !ids.is_empty() {
                        let _ = said("scancel", Command::new("scancel").args(&ids));
                    }
                    return Err(e);
                }
            }
        }
        Ok(ids)
    }

    fn waiting(&self, submissions: &[Submission]) -> Result<Vec<Vec<Waiting>>, BatchError> {
        if submissions.is_empty() {
            return Ok(Vec::new());
        }
        let format = "--format=%F|%K|%T|%r";
        let mut squeue = Command::new("squeue");
        squeue.args(["--me", "--noheader", "--array", "--name", NAME, format]);
        let text = said("squeue", &mut squeue)?;
        Ok(submissions.iter().map(|submission| parse(&text, submission)).collect())
    }

    fn release(&self, submission: &Submission) -> Result<(), BatchError> {
        said("scontrol", Command::new("scontrol").arg("release").arg(submission.ids.join(",")))
            .map(drop)
    }

    fn cancel(&self, submission: &Submission) -> Result<(), BatchError> {
        // An id that is over is no error.
        said("scancel", Command::new("scancel").arg("--quiet").args(&submission.ids)).map(drop)
    }

    fn how(&self, submission: &Submission, place: &Place) -> String {
        let ids = submission.ids.join(", ");
        format!("Slurm has it as job {ids}; what jobs print is in {}", place.output().display())
    }
}

/// Returns the script of a job.
fn text(submission: &Submission, place: &Place) -> String {
    let Submission { workers, .. } = submission;
    let memory = submission.memory_mb * *workers as u64 + OWN_MB;
    let minutes = (submission.longest_s * PATIENCE / 60.0).max(LEAST_MINUTES);
    let own: String = place.lines.iter().map(|line| format!("{line}\n")).collect();
    let work = command(submission, place);
    let minutes = minutes.ceil() as u64;
    format!(
        "#!/bin/bash\n\
         # Does packs of tasks of a tsc-family run; written and submitted by it.\n\
         #SBATCH --ntasks=1\n\
         #SBATCH --cpus-per-task={workers}\n\
         #SBATCH --mem={memory}M\n\
         #SBATCH --time={minutes}\n\
         #SBATCH --requeue\n\
         #SBATCH --open-mode=append\n\
         #SBATCH --signal=USR1@{WARNING_S}\n\
         {own}\
         # The step hears the signals; this shell only has to outlive it.\n\
         trap : TERM USR1\n\
         pack=$((${{1:?}} + SLURM_ARRAY_TASK_ID))\n\
         srun --ntasks=1 --cpus-per-task={workers} --quiet --kill-on-bad-exit=0 \\\n    \
         {work} --grace {GRACE_S} --pack \"$pack\"\n\
         code=$?\n\
         # Stopped at a checkpoint before the limit of time: the rest is for the next time. Slurm itself queues again\n\
         # what it preempts, and nobody what was cancelled: neither is running any more.\n\
         job=${{SLURM_ARRAY_JOB_ID}}_${{SLURM_ARRAY_TASK_ID}}\n\
         if [ \"$code\" -eq {STOPPED} ] && [ \"${{SLURM_RESTART_COUNT:-0}}\" -lt {RESTARTS} ] &&\n    \
         [ \"$(squeue --noheader --format=%T --jobs=\"$job\")\" = RUNNING ]; then\n    \
         scontrol requeue \"$job\" && sleep 60\n\
         fi\n\
         exit \"$code\"\n"
    )
}

/// Reads lines of the user's for jobs.
///
/// # Errors
///
/// [`BatchError`] when the file cannot be read or has anything else in it.
pub fn lines(path: &Path) -> Result<Vec<String>, BatchError> {
    let text = files::read_text(path, limits::DOCUMENT)?;
    let mut lines = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let refused =
            |reason: String| BatchError::Line { path: path.to_path_buf(), line: number, reason };
        let line = line.trim();
        let Some(option) = line.strip_prefix("#SBATCH") else {
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let reason = format!("{line:?} is no #SBATCH line, and nothing else is taken");
            return Err(refused(reason));
        };
        if !option.trim_start().starts_with('-') {
            return Err(refused(format!("{line:?} has no option")));
        }
        // A line may have several.
        for word in option.split_whitespace().filter(|word| word.starts_with('-')) {
            if let Some(name) = ours(word) {
                return Err(refused(format!("tsc-family sets {name} itself; leave {word} out")));
            }
        }
        lines.push(line.to_owned());
    }
    Ok(lines)
}

/// Returns the option of ours that a word is: its name, what Slurm takes for it when it is cut off, or its letter, also
/// behind letters of options without a value.
fn ours(word: &str) -> Option<&'static str> {
    let known = |matches: &dyn Fn(&str) -> bool| OURS.into_iter().find(|name| matches(name));
    match word.strip_prefix("--") {
        Some(long) => {
            let name = long.split('=').next().unwrap_or_default();
            known(&|own| own.len() > 1 && !name.is_empty() && own.starts_with(name))
        }
        None => {
            let letters = word.trim_start_matches('-').chars();
            let mut valued = letters.skip_while(|letter| FLAGS.contains(*letter));
            let letter = valued.next()?.to_string();
            known(&|own| own == letter)
        }
    }
}

/// Reads `squeue`'s words: the array's id, the index in it, the state and the reason.
fn parse(text: &str, submission: &Submission) -> Vec<Waiting> {
    let waiting = |line: &str| {
        let mut fields = line.trim().splitn(4, '|');
        let (id, index) = (fields.next()?, fields.next()?.parse::<usize>().ok()?);
        let (state, reason) = (fields.next()?, fields.next().unwrap_or_default());
        let array = submission.ids.iter().position(|own| own == id)?;
        let pack = array.checked_mul(submission.packs_per_id)?.checked_add(index)?;
        let standing = match state {
            "COMPLETING" => Standing::Ending,
            "PENDING" if reason.to_ascii_lowercase().contains("held") => Standing::Held,
            "PENDING" | "REQUEUED" | "REQUEUE_HOLD" | "SPECIAL_EXIT" => Standing::Queued,
            _ => Standing::Running,
        };
        let waits = matches!(standing, Standing::Queued | Standing::Held) && reason != "None";
        let reason = if waits { reason } else { "" };
        Some(Waiting { pack, standing, reason: reason.trim_matches(['(', ')']).to_owned() })
    };
    text.lines().filter_map(waiting).filter(|w| w.pack < submission.packs).collect()
}

/// Starts a command of Slurm's and returns what it says.
fn said(name: &'static str, command: &mut Command) -> Result<String, BatchError> {
    let output =
        command.output().map_err(|reason| BatchError::Missing { command: name, reason })?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    let said = String::from_utf8_lossy(&output.stderr).trim().replace('\n', "; ");
    Err(BatchError::Refused { command: name, said })
}

#[cfg(test)]
mod tests;
