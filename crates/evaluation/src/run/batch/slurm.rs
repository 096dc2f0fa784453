//! Slurm: a job array, one element per pack.
//!
//! A worker runs as a step (`srun`), so that the warning before the limit of time and the grace of a preemption reach it;
//! it keeps its training and ends with [`STOPPED`], on which the script queues the element again. What a node that died
//! had is queued again by Slurm. What is done is asked of the results directory.

use std::path::Path;
use std::process::Command;

use super::{RESTARTS, Submission};
use crate::run::STOPPED;
use crate::run::error::RunError;
use basics::files::{self, limits};
use basics::hash::sha256;

/// Elements of an array: Slurm takes indices below 1001 unless it was set up otherwise.
pub const PACKS_PER_ARRAY: usize = 1000;

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

/// Returns the name of the jobs of a results directory, by which `scancel --name` finds them.
///
/// # Arguments
///
/// * `results` — absolute, so that a copy has another name.
pub fn name(results: &Path) -> String {
    let sha256 = sha256(results.as_os_str().as_encoded_bytes());
    format!("tsc-family-{}", &sha256[..8])
}

/// Hands all packs of a submission over, and returns the ids that Slurm knows them by.
///
/// # Errors
///
/// [`RunError`] when it does not take them.
pub fn submit(submission: &Submission) -> Result<Vec<String>, RunError> {
    submission.write_executable(&text(submission))?;
    let output = submission.output().join("%A_%a.txt");
    let mut ids: Vec<String> = Vec::new();
    for first in (0..submission.packs).step_by(PACKS_PER_ARRAY) {
        let last = (submission.packs - first).min(PACKS_PER_ARRAY) - 1;
        let mut sbatch = Command::new("sbatch");
        sbatch
            .args(["--parsable", "--job-name", &name(&submission.results)])
            // What is said here counts more than lines of the user's.
            .arg(format!("--signal=USR1@{WARNING_S}"))
            .arg(format!("--array=0-{last}"))
            .arg("--output")
            .arg(&output)
            .arg("--chdir")
            .arg(&submission.from)
            .arg(submission.script())
            .arg(first.to_string());
        match said("sbatch", &mut sbatch) {
            // With the name of the cluster behind it, where there are several.
            Ok(said) => ids.push(said.trim().split(';').next().unwrap_or_default().to_owned()),
            Err(e) => {
                // All or nothing.
                if !ids.is_empty() {
                    let _ = said("scancel", Command::new("scancel").args(&ids));
                }
                return Err(e);
            }
        }
    }
    Ok(ids)
}

/// Returns how many jobs of a results directory are queued or running.
///
/// # Errors
///
/// [`RunError`] when Slurm does not answer.
pub fn in_queue(results: &Path) -> Result<usize, RunError> {
    let mut squeue = Command::new("squeue");
    squeue.args(["--me", "--noheader", "--array", "--format=%i", "--name", &name(results)]);
    Ok(said("squeue", &mut squeue)?.lines().count())
}

/// Returns the script of a job.
fn text(submission: &Submission) -> String {
    let Submission { workers, .. } = submission;
    let memory = submission.memory_mb * *workers as u64 + OWN_MB;
    let minutes = (submission.longest_s * PATIENCE / 60.0).max(LEAST_MINUTES);
    let own: String = submission.lines.iter().map(|line| format!("{line}\n")).collect();
    let work = submission.command();
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
pub fn lines(path: &Path) -> Result<Vec<String>, RunError> {
    let text = files::read_text(path, limits::DOCUMENT)?;
    let mut lines = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let refused = |reason: String| {
            RunError::Refused(format!("{}: line {number}: {reason}", path.display()))
        };
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
        lines.push(line.to_owned());
    }
    Ok(lines)
}

/// Starts a command of Slurm's and returns what it says.
fn said(name: &'static str, command: &mut Command) -> Result<String, RunError> {
    let output =
        command.output().map_err(|reason| {
            RunError::Refused(format!(
                "cannot start {name}: {reason}; this has to run where the batch system takes jobs, such as a login node"
            ))
        })?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    let said = String::from_utf8_lossy(&output.stderr).trim().replace('\n', "; ");
    Err(RunError::Batch(format!("{name} failed: {said}")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::executor::Launcher;

    #[test]
    fn a_job_asks_for_what_its_pack_needs_and_queues_itself_again() {
        let submission = Submission {
            number: 3,
            results: "/data/my results".into(),
            from: "/home/me".into(),
            prepared: "/data/networks".into(),
            launcher: Launcher::of("/opt/tsc-family"),
            lines: vec!["#SBATCH --partition=long".into()],
            packs: 1500,
            longest_s: 850.0,
            workers: 2,
            memory_mb: 500,
            memory_per_worker_mb: Some(4000),
            stall_timeout_s: 600,
        };
        insta::assert_snapshot!(text(&submission));
    }

    #[test]
    fn lines_of_the_user_s_are_taken_and_nothing_else() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let read = |text: &str| {
            std::fs::write(file.path(), text).unwrap();
            lines(file.path())
        };
        let taken = read("#!/bin/bash\n# mine\n\n#SBATCH --partition=long\n  #SBATCH -A me\n");
        assert_eq!(taken.unwrap(), ["#SBATCH --partition=long", "#SBATCH -A me"]);
        for (text, number) in
            [("module load sumo", 1), ("\n#SBATCH", 2), ("#SBATCH partition=long", 1)]
        {
            let e = read(text).unwrap_err();
            assert!(e.to_string().contains(&format!("line {number}: ")), "{text}: {e}");
        }
    }
}
