//! Scripts of jobs, words of `squeue`, lines of users.

use super::*;
use crate::run::executor::Launcher;

fn submission() -> Submission {
    Submission {
        format_version: Submission::VERSION,
        number: 3,
        executor: "slurm".into(),
        results: None,
        manifest: "abc".into(),
        packs: 1500,
        tasks: 2000,
        longest_s: 850.0,
        memory_mb: 500,
        workers: 2,
        stall_timeout_s: 600,
        memory_per_worker_mb: Some(4000),
        has_lines: true,
        ids: vec!["70".into(), "71".into()],
        packs_per_id: PACKS_PER_ARRAY,
        cancelled: None,
    }
}

fn place() -> Place {
    Place {
        results: "/data/my results".into(),
        folder: "/data/my results/jobs/003".into(),
        from: "/home/me".into(),
        prepared: "/data/networks".into(),
        launcher: Launcher::of("/opt/tsc-family"),
        lines: vec!["#SBATCH --partition=long".into()],
    }
}

#[test]
fn a_job_asks_for_what_its_pack_needs_and_queues_itself_again() {
    insta::assert_snapshot!(text(&submission(), &place()));
}

#[test]
fn a_job_has_time_for_its_longest_task_however_many_workers_it_has() {
    let submission = Submission { longest_s: 6600.0, workers: 8, ..submission() };
    let script = text(&submission, &place());
    assert!(script.contains("#SBATCH --time=440\n"), "{script}");
}

#[test]
fn what_squeue_says_is_told_by_pack() {
    let text = "70|0|RUNNING|None\n70|999|PENDING|(Resources)\n71|5|PENDING|(launch failed requeued held)\n\
                99|1|RUNNING|None\n71|500|RUNNING|None\nnonsense\n70|N/A|PENDING|Priority\n71|7|COMPLETING|None\n";
    let waiting = parse(text, &submission());
    let of = |pack, standing, reason: &str| Waiting { pack, standing, reason: reason.into() };
    assert_eq!(
        waiting,
        [
            of(0, Standing::Running, ""),
            of(999, Standing::Queued, "Resources"),
            of(1005, Standing::Held, "launch failed requeued held"),
            of(1007, Standing::Ending, ""),
        ]
    );
}

#[test]
fn lines_of_the_user_s_are_taken_and_nothing_else() {
    let file = tempfile::NamedTempFile::new().unwrap();
    let read = |text: &str| {
        std::fs::write(file.path(), text).unwrap();
        lines(file.path())
            .map_err(|e| e.to_string().split(": ").skip(1).collect::<Vec<_>>().join(": "))
    };
    let taken = read("#!/bin/bash\n# mine\n\n#SBATCH --partition=long\n  #SBATCH -A me\n").unwrap();
    assert_eq!(taken, ["#SBATCH --partition=long", "#SBATCH -A me"]);
    for (text, why) in [
        ("module load sumo", "line 1: \"module load sumo\" is no #SBATCH line"),
        ("\n#SBATCH --array=0-9", "line 2: tsc-family sets array itself"),
        ("#SBATCH -o x", "line 1: tsc-family sets o itself"),
        ("#SBATCH", "line 1: \"#SBATCH\" has no option"),
        ("#SBATCH partition=long", "has no option"),
    ] {
        let e = read(text).unwrap_err();
        assert!(e.contains(why), "{text}: {e}");
    }
}
