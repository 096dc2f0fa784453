//! One task: train a method where it needs training, evaluate it on the held-out seeds, and leave a
//! record, and a model where there is one.

use std::path::PathBuf;
use std::time::Duration;

use super::checkpoint::Keeper;
use super::domain::{Domain, Site, Trial};
use super::error::RunError;
use super::fault::TrialError;
use super::model::{self, SavedModel};
use super::progress::News;
use super::selection::Selection;
use super::stop::Stop;
use super::task_run::{TaskRun, held_out};
use crate::store::manifest::{Identity, Manifest, PointRow, Task};
use crate::store::record::{Metrics, Record, Row, RowKind, TaskResult, mean_metrics};
use crate::store::{Layout, Remedy, StoreError};
use basics::files::numbers::{check_all, is_usable};
use learners::nn::archive::Archive;

/// Where a task is worked on.
#[derive(Debug, Clone)]
pub struct Workplace {
    /// The results directory.
    pub layout: Layout,
    /// Folder of what was prepared.
    pub prepared: PathBuf,
    /// Folder for files of the running episode.
    pub scratch: PathBuf,
    /// Which attempt at the task this is, from 1.
    pub attempt: u32,
    /// Least wall time between two checkpoints of a training.
    pub checkpoint_every: Duration,
    /// Says whether the task is to stop.
    pub stop: Stop,
}

/// Does one task and commits its record, after the model where the method has one.
///
/// A training that diverges is a failed record at once: another attempt would diverge as well.
///
/// # Arguments
///
/// * `news` — called after every episode, and when there is something to say.
///
/// # Errors
///
/// [`RunError`] when a file has changed since the plan, an episode or the method fails; there is no
/// record then, and the checkpoint stays.
pub fn do_task(
    domain: &dyn Domain,
    manifest: &Manifest,
    task: &Task,
    workplace: &Workplace,
    news: &mut dyn FnMut(News),
) -> Result<Record, RunError> {
    let identity = &manifest.identity;
    let (layout, sha256) = (&workplace.layout, manifest.sha256());
    let point = point_of(identity, task)?;
    let site = Site {
        settings: &identity.settings,
        point,
        prepared: &workplace.prepared,
        scratch: &workplace.scratch,
    };
    let seeds = point.evaluation_seeds(&identity.evaluation_seeds);
    let keeper = Keeper::new(layout, &sha256, task, workplace.checkpoint_every);
    let (attempt, stop) = (workplace.attempt, workplace.stop.clone());
    let selection = Selection::of(&identity.settings);
    let selection = selection.map_err(|reason| RunError::Prepare(reason.into()))?;
    let objective = (identity.objective.as_str(), domain.objective().direction);
    let mut course = TaskRun::new(task, objective, selection, attempt, keeper, stop, news);
    let mut trial = domain.trial(&site, &task.method, task.seed)?;
    let more = match kept(layout, task, &sha256) {
        None => None,
        Some((before, model)) => {
            match course.play_more(trial.as_mut(), before, &model, &seeds).transpose() {
                None | Some(Err(TrialError::Model(_))) => {
                    course.note("the model is not that of the record: it is trained again".into());
                    // There is one simulation per process.
                    drop(trial);
                    trial = domain.trial(&site, &task.method, task.seed)?;
                    None
                }
                Some(played) => Some(played.map(|result| (result, Some(model)))),
            }
        }
    };
    let result = more.unwrap_or_else(|| {
        train_and_evaluate(trial.as_mut(), &mut course, &seeds, &identity.objective)
    });
    // Whatever came of files that were written meanwhile says nothing of the method.
    let result = trial.verify().and(result);
    let record = match result {
        Ok((result, learned)) => {
            let record = Record::finished(task, &sha256, result);
            if let Some(learned) = learned {
                // There is one simulation per process, and the baseline may need it.
                drop(trial);
                let baseline = baseline_objective(domain, identity, &site, task, layout, &sha256)?;
                let card = model::card(domain, identity, task, &record, baseline);
                let path = layout.model(task.task);
                let card = card.map_err(|reason| RunError::Model { path, reason })?;
                model::write(layout, task, card, learned)?;
            }
            record
        }
        Err(TrialError::Diverged(reason)) => {
            Record::failed(task, &sha256, reason, course.wall(trial.simulator_s()))
        }
        Err(error) => {
            if matches!(error, TrialError::Model(_)) {
                course.forget()?;
            }
            return Err(error.into());
        }
    };
    record.commit(layout)?;
    Ok(record)
}

/// Returns the record of a task on fewer evaluation seeds and what was learned; `None` unless both are sound.
fn kept(layout: &Layout, task: &Task, manifest: &str) -> Option<(Record, Archive)> {
    let record = Record::read_at(layout.before(task.task), task, manifest).ok()??;
    Some((record, SavedModel::read(&layout.model(task.task)).ok()?.archive))
}

/// Returns the point MDP of a task.
fn point_of<'a>(identity: &'a Identity, task: &Task) -> Result<&'a PointRow, StoreError> {
    identity.points.iter().find(|p| *p.point == *task.point).ok_or_else(|| {
        let reason = format!("task {} is on {}, which it does not have", task.task, task.point);
        StoreError::damaged("manifest.json", reason, Remedy::Begin)
    })
}

fn train_and_evaluate(
    trial: &mut dyn Trial,
    course: &mut TaskRun<'_>,
    seeds: &[u64],
    objective: &str,
) -> Result<(TaskResult, Option<Archive>), TrialError> {
    trial.train(course)?;
    course.evaluate(trial, seeds)?;
    let rows = course.take_rows();
    numbers(&rows, objective)?;
    // Not before an episode has begun: a training that was killed when it was over is restored then.
    let learned = trial.model();
    let mut training = Metrics::new();
    if learned.is_some() {
        training.extend(trial.training_metrics(&rows));
        training.extend(course.figures(&rows));
    }
    let (programs, parts) = (trial.programs(), trial.parts());
    let (details, wall) = (trial.details(), course.wall(trial.simulator_s()));
    Ok((TaskResult { rows, training, details, programs, parts, wall }, learned))
}

/// Checks that every metric is a number that a record may have, and that evaluation has the objective.
fn numbers(rows: &[Row], objective: &str) -> Result<(), TrialError> {
    let failed = |what: String| Err(TrialError::Failed(what.into()));
    for row in rows {
        if let Some((name, value)) = row.metrics.iter().find(|(_, value)| !is_usable(**value)) {
            let of = format!("{name} of the episode with seed {}", row.seed);
            return failed(format!("{of} is {value:e}, not from -1e100 to 1e100"));
        }
        let held_out = matches!(row.kind, RowKind::Evaluation | RowKind::Last);
        if held_out && !row.metrics.contains_key(objective) {
            return failed(format!("the episode with seed {} has no {objective}", row.seed));
        }
    }
    check_all(&mean_metrics(rows)).or_else(|reason| failed(format!("mean of {reason}")))
}

/// Returns the baseline's mean objective on the seeds of a task, recorded or else measured now; `None` without a baseline.
fn baseline_objective(
    domain: &dyn Domain,
    identity: &Identity,
    site: &Site<'_>,
    task: &Task,
    layout: &Layout,
    manifest: &str,
) -> Result<Option<f64>, RunError> {
    let Some(baseline) = domain.baseline() else { return Ok(None) };
    // A record that is damaged is for `run` and `report` to name.
    let recorded = (identity.tasks_of(|_, point| point == task.point).iter())
        .filter(|t| &*t.method == baseline)
        .find_map(|t| Record::read(layout, t, manifest).ok().flatten())
        .and_then(|record| record.summary.metrics.get(&identity.objective).copied());
    if recorded.is_some() {
        return Ok(recorded);
    }
    let mut trial = domain.trial(site, baseline, task.seed)?;
    let seeds = site.point.evaluation_seeds(&identity.evaluation_seeds);
    let rows = held_out(trial.as_mut(), &seeds, &mut |_| {})?;
    Ok(mean_metrics(&rows).get(&identity.objective).copied())
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::sync::atomic::Ordering;

    use super::*;
    use crate::run::checkpoint::LEARNER;
    use crate::run::progress::{Failure, Fault};
    use crate::run::testing::{Counting, Toy, planned};
    use crate::store::record::Outcome;

    /// A results directory and a task of `learner` in it.
    struct Desk {
        dir: tempfile::TempDir,
        manifest: Manifest,
        task: Task,
        stop: Stop,
        notes: Vec<String>,
        episodes: Vec<u32>,
    }

    impl Desk {
        fn new() -> Self {
            let (manifest, tasks) = planned(2);
            let task = tasks.into_iter().find(|t| t.method == "learner").unwrap();
            let dir = tempfile::tempdir().unwrap();
            Self { dir, manifest, task, stop: Stop::default(), notes: vec![], episodes: vec![] }
        }

        fn layout(&self) -> Layout {
            Layout::new(self.dir.path())
        }

        fn work(&mut self, learner: Counting, every: Duration) -> Result<Record, RunError> {
            let workplace = Workplace {
                layout: self.layout(),
                prepared: "prepared".into(),
                scratch: self.dir.path().to_path_buf(),
                attempt: 1,
                checkpoint_every: every,
                stop: self.stop.clone(),
            };
            let (notes, episodes) = (&mut self.notes, &mut self.episodes);
            let mut news = |news| match news {
                News::Note(note) => notes.push(note),
                News::Episode(progress) => episodes.push(progress.episodes),
            };
            do_task(&Toy { learner }, &self.manifest, &self.task, &workplace, &mut news)
        }

        fn checkpoint(&self) -> PathBuf {
            self.layout().checkpoint(self.task.task)
        }

        fn model(&self) -> Vec<u8> {
            fs::read(self.layout().model(self.task.task)).unwrap()
        }
    }

    #[test]
    fn metrics_that_are_no_numbers_or_lack_the_objective_fail() {
        let row = |metrics: &[(&str, f64)]| Row {
            kind: RowKind::Evaluation,
            episode: 0,
            seed: 7,
            metrics: metrics.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect(),
        };
        let said =
            |metrics: &[(&str, f64)]| numbers(&[row(metrics)], "score").map_err(|e| e.to_string());
        assert_eq!(said(&[("score", 1.0), ("steps", 3.0)]), Ok(()));
        assert_eq!(said(&[("steps", 3.0)]), Err("the episode with seed 7 has no score".into()));
        let e = said(&[("score", 1.0), ("steps", -1e101)]).unwrap_err();
        assert!(e.contains("with seed 7 is -1e101, not from -1e100 to 1e100"), "{e}");
        assert!(said(&[("score", 1.0), ("steps", f64::NAN)]).unwrap_err().contains("NaN"));
        let training = Row { kind: RowKind::Training, ..row(&[("loss", 0.5)]) };
        assert!(numbers(&[training], "score").is_ok());
    }

    fn whole() -> (Desk, Record) {
        let mut desk = Desk::new();
        let record = desk.work(Counting::of(12), Duration::ZERO).unwrap();
        (desk, record)
    }

    #[test]
    fn a_killed_training_goes_on_to_the_record_and_model_of_one_that_was_never_killed() {
        let (never_killed, record) = whole();
        let mut desk = Desk::new();
        for dies_after in [Some(1), Some(5), Some(12)] {
            let learner = Counting { dies_after, ..Counting::of(12) };
            desk.work(learner, Duration::ZERO).unwrap_err();
            assert!(desk.checkpoint().exists());
        }
        let resumed = desk.work(Counting::of(12), Duration::ZERO).unwrap();
        assert_eq!(resumed.rows, record.rows);
        assert_eq!(resumed.summary.checksum, record.summary.checksum);
        assert_eq!(desk.model(), never_killed.model());
        assert!(!desk.checkpoint().exists());
        // Every attempt says first how far the last one came.
        assert_eq!(desk.episodes[..7], [1, 1, 2, 3, 4, 5, 5]);
        assert_eq!(desk.notes.last().unwrap(), "training continues after episode 12");
        assert_ne!(record.rows[0].metrics["score"], record.rows[1].metrics["score"]);
    }

    #[test]
    fn no_checkpoint_is_written_before_its_time() {
        let mut desk = Desk::new();
        let learner = Counting { dies_after: Some(3), ..Counting::of(12) };
        desk.work(learner, Duration::from_secs(60)).unwrap_err();
        assert!(!desk.checkpoint().exists());
    }

    #[test]
    fn a_checkpoint_of_another_task_is_named_and_training_starts_from_the_beginning() {
        let (_, record) = whole();
        let mut desk = Desk::new();
        let learner = Counting { dies_after: Some(3), ..Counting::of(12) };
        let own = desk.task.task;
        desk.task.task += 1;
        desk.work(learner, Duration::ZERO).unwrap_err();
        let foreign = desk.checkpoint();
        desk.task.task -= 1;
        fs::rename(foreign, desk.checkpoint()).unwrap();
        desk.episodes.clear();
        let again = desk.work(Counting::of(12), Duration::ZERO).unwrap();
        assert_eq!(again.summary.checksum, record.summary.checksum);
        assert_eq!(desk.episodes[0], 1);
        let note = &desk.notes[0];
        assert!(note.contains("is not used: another build, manifest or task"), "{note}");
    }

    #[test]
    fn a_checkpoint_that_the_method_refuses_is_gone_at_the_next_attempt() {
        let mut desk = Desk::new();
        let learner = Counting { dies_after: Some(3), ..Counting::of(12) };
        desk.work(learner, Duration::ZERO).unwrap_err();
        let stubborn = Counting { stubborn: true, ..Counting::of(12) };
        let e = desk.work(stubborn.clone(), Duration::ZERO).unwrap_err();
        assert!(e.to_string().starts_with("the model does not fit"), "{e}");
        assert_eq!(Failure::of(&e).fault, Fault::Task, "it is tried again");
        desk.work(stubborn, Duration::ZERO).unwrap();
    }

    #[test]
    fn a_training_that_diverges_is_a_failed_record_at_once() {
        let mut desk = Desk::new();
        let learner = Counting { diverges_in: Some(4), ..Counting::of(12) };
        let record = desk.work(learner, Duration::ZERO).unwrap();
        assert_eq!(record.summary.outcome, Outcome::Failed);
        assert_eq!(record.summary.reason.as_deref(), Some("it diverged in 4"));
        let sha256 = desk.manifest.sha256();
        let read = Record::read(&desk.layout(), &desk.task, &sha256).unwrap();
        assert_eq!(read, Some(record));
        assert!(!desk.checkpoint().exists());
        assert!(!desk.layout().model(desk.task.task).exists());
    }

    #[test]
    fn a_task_that_is_asked_to_stop_does_so_at_a_checkpoint_and_ends_in_the_same_record() {
        let (never_stopped, record) = whole();
        let mut desk = Desk::new();
        desk.stop.asked().store(true, Ordering::Relaxed);
        // Nothing would be kept for an hour otherwise.
        let every = Duration::from_secs(3600);
        for k in 1..=11 {
            let e = desk.work(Counting::of(12), every).unwrap_err();
            assert_eq!(Failure::of(&e).fault, Fault::Disturbed);
            assert!(matches!(e, RunError::Trial(TrialError::Stopped)), "{e}");
            assert_eq!(desk.episodes.last(), Some(&k));
            assert!(!desk.stop.at_once().load(Ordering::Relaxed), "it has something to keep");
        }
        desk.stop = Stop::default();
        assert_eq!(desk.work(Counting::of(12), every).unwrap().rows, record.rows);
        assert_eq!(desk.model(), never_stopped.model());
        assert!(desk.stop.at_once().load(Ordering::Relaxed), "an evaluation is not kept");
    }

    #[test]
    fn a_full_disk_is_no_failed_record() {
        let mut desk = Desk::new();
        let learner = Counting { disk_full: true, ..Counting::of(12) };
        let e = desk.work(learner, Duration::ZERO).unwrap_err();
        assert_eq!(Failure::of(&e).fault, Fault::Machine);
        assert!(!desk.layout().record(desk.task.task).exists());
    }

    #[test]
    fn a_model_says_how_and_how_well_it_was_trained() {
        let mut desk = Desk::new();
        let tasks = desk.manifest.identity.tasks();
        let baseline = tasks.iter().find(|t| t.point == desk.task.point).unwrap();
        assert_eq!(baseline.method, "zero");
        let metrics = Metrics::from([("score".to_owned(), 8.0)]);
        let rows = vec![Row { kind: RowKind::Evaluation, episode: 0, seed: 1, metrics }];
        let result = TaskResult { rows, ..TaskResult::default() };
        let sha256 = desk.manifest.sha256();
        Record::finished(baseline, &sha256, result).commit(&desk.layout()).unwrap();
        let record = desk.work(Counting::of(3), Duration::ZERO).unwrap();

        let saved = SavedModel::read(&desk.layout().model(desk.task.task)).unwrap();
        let card = &saved.card;
        assert_eq!((card.method.as_str(), card.point.as_str()), ("learner", "quiet"));
        assert_eq!((card.seed, card.training_episodes), (desk.task.seed, 3));
        assert_eq!(
            (card.simulator.as_str(), &saved.domain["settings"]["hidden"]),
            ("none", &64.into())
        );
        let objective = record.summary.metrics["score"];
        assert_eq!(card.evaluation["score"], objective / 8.0);
        let seeds: Vec<u64> = record.evaluations().map(|r| r.seed).collect();
        assert_eq!(card.evaluation["seeds"], serde_json::json!(seeds));
        assert_eq!(saved.archive.get::<u32>("done").unwrap(), 3);
        assert!(saved.domain.contains_key(LEARNER));
    }

    #[test]
    fn a_baseline_without_a_record_is_measured_for_the_card() {
        let (desk, record) = whole();
        let saved = SavedModel::read(&desk.layout().model(desk.task.task)).unwrap();
        let score = saved.card.evaluation["score"].as_f64().unwrap();
        let rows = held_out(
            &mut Counting::default(),
            &record.evaluations().map(|r| r.seed).collect::<Vec<_>>(),
            &mut |_| {},
        );
        let baseline = mean_metrics(&rows.unwrap())["score"];
        assert_eq!(score, record.summary.metrics["score"] / baseline);
    }
}
