//! One task: train a method where it needs training, evaluate it on the held-out seeds, and leave a
//! record, and a model where there is one.

use std::path::PathBuf;
use std::time::Duration;

use crate::files::FileError;
use crate::nn::archive::Archive;
use crate::run::error::EvalError;
use crate::store::Layout;
use crate::store::error::StoreError;
use crate::store::manifest::{Manifest, PointRow, Task};
use crate::store::record::{Metrics, Record, Row, RowKind, TaskResult};
use crate::traffic::control::{ControlError, Controller};
use crate::traffic::controllers::create;
use crate::traffic::env::SignalEnv;
use crate::traffic::env::episode::EpisodeError;
use crate::traffic::sim::Sim;
use crate::traffic::sim::error::SimError;

use super::checkpoint::Keeper;
use super::lab::{Lab, News};
use super::model;
use super::plan::GENERATED;
use crate::traffic::environment::{environment, planned_world, scenario};

/// Training episodes over which RESCO's users see a learner's last performance.
const RESCO_LAST: usize = 10;

/// Where a task works.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Workplace {
    /// The results directory.
    pub layout: Layout,
    /// Folder of the generated networks.
    pub networks: PathBuf,
    /// Folder for files of the running episode.
    pub scratch: PathBuf,
    /// Which attempt at the task this is, from 1.
    pub attempt: u32,
    /// Least wall time between two checkpoints of a training.
    pub checkpoint_every: Duration,
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
/// [`EvalError`] when a file has changed since the plan, the simulation or the method fails; there is
/// no record then, and the checkpoint stays.
pub fn perform<S: Sim>(
    sim: S,
    manifest: &Manifest,
    task: &Task,
    workplace: &Workplace,
    news: &mut dyn FnMut(News),
) -> Result<Record, EvalError> {
    let identity = &manifest.identity;
    let scenario = scenario(identity)?;
    let point = point_of(manifest, task)?;
    let imported = point.environment != GENERATED;
    let world = planned_world(point, &workplace.networks)?;
    let env = environment(sim, world, &scenario, &workplace.scratch);
    let mut controller = create(&task.method, &scenario, imported, task.seed)?;
    let mut baseline = create(&identity.baseline, &scenario, imported, task.seed)?;
    settle(env, controller.as_mut(), baseline.as_mut(), manifest, task, workplace, news)
}

/// Returns the point MDP of a task.
fn point_of<'a>(manifest: &'a Manifest, task: &Task) -> Result<&'a PointRow, StoreError> {
    manifest.identity.points.iter().find(|p| p.point == task.point).ok_or_else(|| {
        let reason = format!("task {} is on {}, which it does not have", task.task, task.point);
        StoreError::Malformed { path: "manifest.json".into(), reason }
    })
}

/// Trains and evaluates a controller, writes its model and commits its record. The baseline beside it
/// is for the model's score.
fn settle<S: Sim>(
    env: SignalEnv<S>,
    controller: &mut dyn Controller,
    baseline: &mut dyn Controller,
    manifest: &Manifest,
    task: &Task,
    workplace: &Workplace,
    news: &mut dyn FnMut(News),
) -> Result<Record, EvalError> {
    let (layout, sha256) = (&workplace.layout, manifest.sha256());
    let keeper = Keeper::new(layout, &sha256, task, workplace.checkpoint_every);
    let mut lab = Lab::new(env, task, workplace.attempt, keeper, news);
    let seeds = point_of(manifest, task)?.evaluation_seeds(&manifest.identity.evaluation_seeds);
    let record = match study(&mut lab, controller, &seeds) {
        Ok((result, model)) => {
            let record = Record::finished(task, &sha256, result);
            if let Some(model) = model {
                let identity = &manifest.identity;
                let scenario = scenario(identity)?;
                // The baseline's record, if there is one, says the same as its episodes.
                let baseline_s = match model::baseline_delay(layout, identity, task, &sha256) {
                    Some(delay_s) => Some(delay_s),
                    None => lab.delay_of(baseline, &seeds)?,
                };
                model::write(layout, identity, &scenario, task, &record, baseline_s, model)?;
            }
            record
        }
        Err(EvalError::Control(e @ ControlError::Diverged { .. })) => {
            Record::failed(task, &sha256, e.to_string(), lab.wall())
        }
        Err(e) => {
            if matches!(e, EvalError::Control(ControlError::Model(_))) {
                lab.forget()?;
            }
            return Err(e);
        }
    };
    record.commit(layout)?;
    Ok(record)
}

fn study<S: Sim>(
    lab: &mut Lab<'_, S>,
    controller: &mut dyn Controller,
    seeds: &[u64],
) -> Result<(TaskResult, Option<Archive>), EvalError> {
    controller.train(lab)?;
    lab.evaluate(controller, seeds)?;
    // Not before an episode has begun: a training that was killed when it was over is restored then.
    let model = controller.model();
    let training = if model.is_some() { resco(&lab.rows) } else { Metrics::new() };
    let (programs, rows) = (lab.programs(), std::mem::take(&mut lab.rows));
    let (details, wall) = (controller.details(), lab.wall());
    Ok((TaskResult { rows, training, details, programs, wall }, model))
}

/// Returns what RESCO reports of a learner: the delay in its best training episode, and beside it the
/// mean over its last ten. Both are of training, on training seeds and with exploration; the best of
/// many episodes is optimistic, and worst for methods that are unstable. Scores do not use them.
///
/// Deviation: RESCO takes the best episode of the curve that is averaged over several trainings;
/// here it is the best of each training.
///
/// Source: RESCO, utils/graph.py (the minimum of the curve for learners, the mean for others).
fn resco(rows: &[Row]) -> Metrics {
    let delays: Vec<f64> = (rows.iter())
        .filter(|r| r.kind == RowKind::Training)
        .filter_map(|r| r.metrics.get("delay_s").copied())
        .collect();
    if delays.is_empty() {
        return Metrics::new();
    }
    let last = &delays[delays.len().saturating_sub(RESCO_LAST)..];
    Metrics::from([
        ("resco_best_delay_s".to_owned(), delays.iter().copied().fold(f64::INFINITY, f64::min)),
        ("resco_last_ten_delay_s".to_owned(), last.iter().sum::<f64>() / last.len() as f64),
    ])
}

/// Returns whether an error concerns the machine and not the task: it would make other tasks fail
/// too, so that the run is better stopped than filled with failed records.
pub fn stops_run(error: &EvalError) -> bool {
    matches!(
        error,
        EvalError::Sim(SimError::Io(_))
            | EvalError::Store(_)
            | EvalError::Io(_)
            | EvalError::Altered { .. }
            | EvalError::Control(ControlError::Checkpoint(_))
    ) || has_file_error(error)
}

/// Whether a file operation is at the bottom of an error, as when a training episode cannot write
/// its vehicles.
fn has_file_error(error: &(dyn std::error::Error + 'static)) -> bool {
    let mut next = Some(error);
    while let Some(error) = next {
        let episode = matches!(error.downcast_ref(), Some(EpisodeError::Sim(SimError::Io(_))));
        if episode || error.is::<FileError>() {
            return true;
        }
        next = error.source();
    }
    false
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::*;
    use crate::run::model::SavedModel;
    use crate::run::plan::tests::planned;
    use crate::run::testing::Learner;
    use crate::store::record::Outcome;
    use crate::traffic::control::baseline::Baseline;
    use crate::traffic::env::testing::env;

    /// A results directory and a task of `idqn` in it.
    struct Place {
        dir: tempfile::TempDir,
        manifest: Manifest,
        task: Task,
        notes: Vec<String>,
        episodes: Vec<u32>,
    }

    impl Place {
        fn new() -> Self {
            let mut manifest = planned(&[]).0;
            manifest.identity.methods.push("idqn".into());
            let task = manifest.identity.tasks().into_iter().find(|t| t.method == "idqn").unwrap();
            let dir = tempfile::tempdir().unwrap();
            Self { dir, manifest, task, notes: vec![], episodes: vec![] }
        }

        fn layout(&self) -> Layout {
            Layout::new(self.dir.path())
        }

        fn settle(&mut self, mut learner: Learner, every: Duration) -> Result<Record, EvalError> {
            let workplace = Workplace {
                layout: self.layout(),
                networks: "networks".into(),
                scratch: self.dir.path().to_path_buf(),
                attempt: 1,
                checkpoint_every: every,
            };
            let arrivals = (0..50).map(|k| (f64::from(k), k % 3 % 2)).collect();
            let env = env(arrivals, self.dir.path());
            let (notes, episodes) = (&mut self.notes, &mut self.episodes);
            let mut news = |news| match news {
                News::Note(note) => notes.push(note),
                News::Episode(progress) => episodes.push(progress.episodes),
            };
            let mut baseline = Baseline { equal_split_green_s: None };
            let (manifest, task) = (&self.manifest, &self.task);
            settle(env, &mut learner, &mut baseline, manifest, task, &workplace, &mut news)
        }

        fn checkpoint(&self) -> PathBuf {
            self.layout().checkpoint(self.task.task)
        }

        fn model(&self) -> Vec<u8> {
            fs::read(self.layout().model(self.task.task)).unwrap()
        }
    }

    fn whole() -> (Place, Record) {
        let mut place = Place::new();
        let record = place.settle(Learner::of(12), Duration::ZERO).unwrap();
        (place, record)
    }

    #[test]
    fn a_killed_training_goes_on_to_the_record_and_model_of_one_that_was_never_killed() {
        let (never_killed, record) = whole();
        let mut place = Place::new();
        for dies_after in [Some(1), Some(5), Some(12)] {
            let learner = Learner { dies_after, ..Learner::of(12) };
            place.settle(learner, Duration::ZERO).unwrap_err();
            assert!(place.checkpoint().exists());
        }
        let resumed = place.settle(Learner::of(12), Duration::ZERO).unwrap();
        assert_eq!(resumed.rows, record.rows);
        assert_eq!(resumed.summary.checksum, record.summary.checksum);
        assert_eq!(place.model(), never_killed.model());
        assert!(!place.checkpoint().exists());
        // Every attempt says first how far the last one came.
        assert_eq!(place.episodes[..7], [1, 1, 2, 3, 4, 5, 5]);
        assert_eq!(place.notes.last().unwrap(), "training goes on after episode 12");
        assert_ne!(record.rows[0].metrics["delay_s"], record.rows[1].metrics["delay_s"]);
    }

    #[test]
    fn no_checkpoint_is_written_before_its_time() {
        let mut place = Place::new();
        let learner = Learner { dies_after: Some(3), ..Learner::of(12) };
        place.settle(learner, Duration::from_secs(60)).unwrap_err();
        assert!(!place.checkpoint().exists());
    }

    #[test]
    fn a_checkpoint_of_another_task_is_named_and_training_starts_from_the_beginning() {
        let (_, record) = whole();
        let mut place = Place::new();
        let learner = Learner { dies_after: Some(3), ..Learner::of(12) };
        place.task.task += 1;
        place.settle(learner, Duration::ZERO).unwrap_err();
        let foreign = place.checkpoint();
        place.task.task -= 1;
        fs::rename(foreign, place.checkpoint()).unwrap();
        place.episodes.clear();
        let again = place.settle(Learner::of(12), Duration::ZERO).unwrap();
        assert_eq!(again.summary.checksum, record.summary.checksum);
        assert_eq!(place.episodes[0], 1);
        let note = &place.notes[0];
        assert!(note.contains("1.safetensors is not used: it is of task 2, not 1"), "{note}");
    }

    #[test]
    fn a_checkpoint_that_the_learner_refuses_is_gone_at_the_next_attempt() {
        let mut place = Place::new();
        let learner = Learner { dies_after: Some(3), ..Learner::of(12) };
        place.settle(learner, Duration::ZERO).unwrap_err();
        let stubborn = Learner { stubborn: true, ..Learner::of(12) };
        let e = place.settle(stubborn.clone(), Duration::ZERO).unwrap_err();
        assert!(e.to_string().starts_with("the model does not fit"), "{e}");
        place.settle(stubborn, Duration::ZERO).unwrap();
    }

    #[test]
    fn a_training_that_diverges_is_a_failed_record_at_once() {
        let mut place = Place::new();
        let learner = Learner { diverges_in: Some(4), ..Learner::of(12) };
        let record = place.settle(learner, Duration::ZERO).unwrap();
        assert_eq!(record.summary.outcome, Outcome::Failed);
        assert_eq!(
            record.summary.reason.as_deref(),
            Some(
                "training diverged in episode 4: the loss is no number any more; try a smaller learning rate"
            )
        );
        let sha256 = place.manifest.sha256();
        let read = Record::read(&place.layout(), &place.task, &sha256).unwrap();
        assert_eq!(read, Some(record));
        assert!(!place.checkpoint().exists());
        assert!(!place.layout().model(place.task.task).exists());
    }

    #[test]
    fn a_training_row_has_the_figures_of_the_learner_that_are_numbers() {
        let (_, record) = whole();
        let metrics = &record.rows[0].metrics;
        assert_eq!(metrics["loss"], 0.5);
        assert!(metrics["delay_s"] > 0.0, "what was measured counts");
        assert!(!metrics.contains_key("epsilon"));
        assert!(!record.evaluations().next().unwrap().metrics.contains_key("loss"));
    }

    #[test]
    fn resco_reports_the_best_training_episode() {
        let (_, record) = whole();
        let delays: Vec<f64> = record.rows[..12].iter().map(|r| r.metrics["delay_s"]).collect();
        let best = delays.iter().copied().fold(f64::INFINITY, f64::min);
        assert_eq!(record.summary.metrics["resco_best_delay_s"], best);
        let last = delays[2..].iter().sum::<f64>() / 10.0;
        assert_eq!(record.summary.metrics["resco_last_ten_delay_s"], last);
        assert!(record.summary.metrics["delay_s"] > 0.0);
        assert_eq!(resco(&[]), Metrics::new());
    }

    #[test]
    fn a_model_says_how_and_how_well_it_was_trained() {
        let mut place = Place::new();
        let identity = &place.manifest.identity;
        let baseline = identity.tasks().into_iter().find(|t| t.point == place.task.point).unwrap();
        assert_eq!(baseline.method, "baseline");
        let metrics = Metrics::from([("delay_s".to_owned(), 8.0)]);
        let rows = vec![Row { kind: RowKind::Evaluation, episode: 0, seed: 1, metrics }];
        let result = TaskResult { rows, ..TaskResult::default() };
        let sha256 = place.manifest.sha256();
        Record::finished(&baseline, &sha256, result).commit(&place.layout()).unwrap();
        let record = place.settle(Learner::of(3), Duration::ZERO).unwrap();

        let path = place.layout().model(place.task.task);
        let card = SavedModel::read(&path).unwrap().card;
        assert_eq!((card.method.as_str(), card.point.as_str()), ("idqn", "quiet"));
        assert_eq!((card.seed, card.training_episodes), (place.task.seed, 3));
        assert_eq!(card.settings["hidden"], 64);
        assert_eq!(card.signal.delta_time_s, 10);
        assert_eq!(card.simulator, "mock");
        let delay_s = record.summary.metrics["delay_s"];
        assert_eq!(card.evaluation.delay_s, delay_s);
        assert_eq!(card.evaluation.score, Some(delay_s / 8.0));
        let seeds: Vec<u64> = record.evaluations().map(|r| r.seed).collect();
        assert_eq!(card.evaluation.seeds, seeds);
    }

    #[test]
    fn a_disk_error_in_a_training_episode_stops_the_run() {
        let file = || FileError::at("write", Path::new("x"))(std::io::Error::other("full"));
        let episode = EpisodeError::Sim(SimError::Io(file()));
        assert!(stops_run(&EvalError::Control(ControlError::Episode(Box::new(episode)))));
        assert!(stops_run(&EvalError::Control(ControlError::Checkpoint(file()))));
        let sumo = EpisodeError::Sim(SimError::NotRunning);
        assert!(!stops_run(&EvalError::Control(ControlError::Episode(Box::new(sumo)))));
    }
}
