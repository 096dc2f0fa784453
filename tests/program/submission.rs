//! `tsc-family check --submission`: honest records pass, forged ones are found, and what was not verified is said.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::common::{run, stderr, stdout, succeed};
use serde_json::Value;
use tsc_family::store::Layout;
use tsc_family::store::manifest::Manifest;
use tsc_family::store::record::{Record, Row, RowKind, TaskResult};

/// A run of four tasks: the baseline and another method on two point MDPs.
const RUN: &str = "run smoke --methods max-pressure --eval-seeds 2 --set demand.horizon_s=300 --quiet --out honest";

/// A folder with that run.
fn honest() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), RUN);
    folder
}

/// Copies the run and changes the record of a task; checksums are made for it as a forger would.
fn forged(folder: &Path, name: &str, task: usize, change: impl Fn(&mut TaskResult)) {
    let copied = Command::new("cp").args(["-r", "honest", name]).current_dir(folder).status();
    assert!(copied.unwrap().success());
    let layout = Layout::new(folder.join(name));
    let manifest = Manifest::read(&layout).unwrap();
    let (sha256, tasks) = (manifest.sha256(), manifest.identity.tasks());
    let record = Record::read(&layout, &tasks[task], &sha256).unwrap().unwrap();
    let summary = record.summary.clone();
    let mut result = TaskResult {
        rows: record.rows,
        details: summary.details,
        programs: summary.programs,
        parts: summary.parts,
        wall: summary.wall,
        ..TaskResult::default()
    };
    change(&mut result);
    fs::remove_file(layout.record(task)).unwrap();
    Record::finished(&tasks[task], &sha256, result).commit(&layout).unwrap();
}

/// Adds to a metric of an episode.
fn add(row: &mut Row, metric: &str, more: f64) {
    let value = row.metrics.get(metric).unwrap() + more;
    row.metrics.insert(metric.to_owned(), value);
}

/// Verifies a run and returns the exit code and what is said.
fn verified(folder: &Path, args: &str) -> (Option<i32>, String) {
    let output = run(folder, &format!("check --submission {args}"));
    assert!(!stdout(&output).is_empty(), "{}", stderr(&output));
    (output.status.code(), stdout(&output))
}

#[test]
fn honest_records_pass_and_what_was_not_verified_is_said() {
    let folder = honest();
    let (code, text) = verified(folder.path(), "honest --sample-seed 1");
    assert_eq!(code, Some(0), "{text}");
    for words in [
        "verified: hashes: 4 records are whole and of this manifest",
        "verified: completeness: all 4 tasks have a record",
        "verified: seeds: 8 evaluation episodes have the manifest's seeds",
        "verified: means: 4 summaries are the means of their episodes",
        "verified: vehicles: 8 episodes have as many vehicles as their seeds give",
        "not verified: family: whether the point MDPs",
        "verified: re-simulation: 1 of 4 tasks, drawn at random (--sample-seed 1), gave the same records again",
        "not verified: re-simulation: the other 3 of 4 tasks",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    assert!(!text.contains("wrong:"), "{text}");
    // Packed records are verified as they are; another seed draws others.
    let pack = "tar -cJf records.tar.xz done && rm -r done";
    let in_run = folder.path().join("honest");
    let packed = Command::new("sh").args(["-c", pack]).current_dir(in_run).status();
    assert!(packed.unwrap().success());
    let (code, text) = verified(folder.path(), "honest --sample-seed 2 --resimulate 75 --json");
    assert_eq!(code, Some(0), "{text}");
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let again = lines.iter().find(|l| l["what"] == "re-simulation" && l["verdict"] == "verified");
    assert!(again.unwrap()["text"].as_str().unwrap().starts_with("3 of 4 tasks"), "{text}");
    assert!(!folder.path().join("honest/done").exists());
}

#[test]
fn a_forged_record_is_found_by_doing_it_again() {
    let folder = honest();
    // Max pressure is better by a second than it was, with means and checksums to match.
    forged(folder.path(), "forged", 3, |result| {
        for row in result.rows.iter_mut().filter(|row| row.kind == RowKind::Evaluation) {
            add(row, "delay_s", -1.0);
        }
    });
    let whole = run(folder.path(), "check forged");
    assert!(whole.status.success(), "hashes do not tell: {}", stdout(&whole));
    let (code, text) = verified(folder.path(), "forged --resimulate 100");
    assert_eq!(code, Some(2), "{text}");
    let found = text.lines().find(|line| line.starts_with("wrong: ")).unwrap();
    let words =
        "wrong: re-simulation: task 3 (max-pressure on busy): the evaluation episode with seed ";
    assert!(found.starts_with(words) && found.contains("has delay_s = "), "{found}");
    assert_eq!(text.matches("wrong: ").count(), 1, "the other three are as they were: {text}");
    // A part finds it if it draws it: one of four tasks, so with some seeds.
    let by_seed = |seed: u32| verified(folder.path(), &format!("forged --sample-seed {seed}")).0;
    let codes = (0..30).map(by_seed);
    let mut seen: Vec<Option<i32>> = Vec::new();
    for code in codes {
        seen.push(code);
        if seen.contains(&Some(2)) && seen.contains(&Some(0)) {
            break;
        }
    }
    assert!(seen.contains(&Some(2)) && seen.contains(&Some(0)), "{seen:?}");
    assert_eq!(by_seed(0), seen[0], "a seed draws the same tasks");
}

#[test]
fn other_vehicles_seeds_means_and_baselines_are_found_without_simulation() {
    let folder = honest();
    let of = |name: &str| {
        let (code, text) = verified(folder.path(), &format!("{name} --sample-seed 1"));
        assert_eq!(code, Some(2), "{text}");
        text
    };
    forged(folder.path(), "vehicles", 1, |result| {
        add(&mut result.rows[0], "vehicles_veh", -3.0);
    });
    let text = of("vehicles");
    assert!(
        text.contains("wrong: vehicles: task 1 (max-pressure on quiet): vehicles_veh is "),
        "{text}"
    );
    forged(folder.path(), "seeds", 1, |result| result.rows[1].seed += 1);
    let text = of("seeds");
    assert!(
        text.contains(
            "wrong: seeds: task 1 (max-pressure on quiet): evaluation episode 1 has the seed"
        ),
        "{text}"
    );
    forged(folder.path(), "trained", 1, |result| {
        let training = result.rows[0].clone();
        result.rows.insert(0, Row { kind: RowKind::Training, ..training });
    });
    assert!(of("trained").contains("it was trained on the evaluation seed "));
    // A baseline that is worse than the published one makes every score better.
    forged(folder.path(), "baseline", 0, |result| {
        add(&mut result.rows[0], "delay_s", 9.0);
    });
    succeed(folder.path(), &RUN.replace("max-pressure", "actuated").replace("honest", "published"));
    let text = of("baseline --published published");
    assert!(
        text.contains("wrong: family: the records of baseline are not those of published"),
        "{text}"
    );
    let (code, text) = verified(folder.path(), "honest --published published");
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains(
        "verified: family: point MDPs, importance, seeds and the records of the baseline"
    ));
    // Without its networks neither vehicles nor delays can be told.
    fs::remove_dir_all(folder.path().join("networks")).unwrap();
    let (_, text) = verified(folder.path(), "honest");
    assert!(
        text.contains("not verified: vehicles: the networks are not those of the manifest"),
        "{text}"
    );
    assert!(text.contains("not verified: re-simulation: the networks are not there"), "{text}");
}

#[test]
fn a_method_of_somebody_s_own_is_done_again_only_where_it_is_given() {
    let folder = tempfile::tempdir().unwrap();
    let scores = "point,seed,delay_s\n";
    fs::write(folder.path().join("scores.csv"), scores).unwrap();
    let run_it =
        "run smoke --methods baseline --eval-seeds 1 --set demand.horizon_s=60 --quiet --out out";
    succeed(folder.path(), run_it);
    let layout = Layout::new(folder.path().join("out"));
    let seeds: Vec<String> = (Manifest::read(&layout).unwrap().identity.points.iter())
        .map(|point| {
            format!(
                "{},{},9.5\n",
                point.point,
                point.evaluation_seeds(&Manifest::read(&layout).unwrap().identity.evaluation_seeds)
                    [0]
            )
        })
        .collect();
    fs::write(folder.path().join("scores.csv"), format!("{scores}{}", seeds.concat())).unwrap();
    succeed(folder.path(), &format!("{run_it} --controller-results theirs=scores.csv"));
    let (code, text) = verified(folder.path(), "out --resimulate 100");
    assert_eq!(code, Some(0), "{text}");
    assert!(
        text.contains("not verified: re-simulation: theirs: its scores were measured elsewhere"),
        "{text}"
    );
    assert!(text.contains("verified: re-simulation: 2 of 4 tasks"), "{text}");
}
