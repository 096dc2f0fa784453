//! One task: train a method where it needs training, evaluate it on the held-out seeds, and leave a
//! record, and a model where there is one.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use super::checkpoint::{Candidate, Keeper, Validated, judged};
use super::domain::{Course, Domain, Policy, Site, Trial};
use super::error::RunError;
use super::fault::{CheckpointError, TrialError};
use super::model::{self, SavedModel};
use super::progress::{News, Progress};
use super::selection::{MAX_RESTARTS, Restart, Selection};
use super::stop::Stop;
use crate::stats::Direction;
use crate::store::figures::{
    DEAD, DISCARDED_EPISODES, LAST_PREFIX, POLICY_ROW, RESTARTS, VALIDATION_EPISODES,
};
use crate::store::manifest::{GIT, Identity, Manifest, PointRow, Task};
use crate::store::record::{Metrics, Record, Row, RowKind, TaskResult, mean_metrics, means_of};
use crate::store::wall::Wall;
use crate::store::{Layout, Remedy, StoreError};
use basics::files::FileError;
use basics::files::numbers::{check_all, is_usable};
use basics::{machine, seed};
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

/// Keeps the rows of a task, and where its training stands.
struct TaskRun<'a> {
    task: &'a Task,
    /// Name of the metric that progress shows.
    objective: &'a str,
    direction: Direction,
    selection: Selection,
    keeper: Keeper,
    stop: Stop,
    news: &'a mut dyn FnMut(News),
    start: Instant,
    attempt: u32,
    /// Time that earlier attempts took up to the checkpoint.
    earlier: Wall,
    resumed: bool,
    /// Rows of training.
    rows: Vec<Row>,
    /// What validation has found so far.
    validated: Validated,
}

impl<'a> TaskRun<'a> {
    /// Returns the course of a task's `attempt`-th attempt.
    fn new(
        task: &'a Task,
        (objective, direction): (&'a str, Direction),
        selection: Selection,
        attempt: u32,
        keeper: Keeper,
        stop: Stop,
        news: &'a mut dyn FnMut(News),
    ) -> Self {
        Self {
            task,
            objective,
            direction,
            selection,
            keeper,
            stop,
            news,
            start: Instant::now(),
            attempt,
            earlier: Wall::default(),
            resumed: false,
            rows: Vec::new(),
            validated: Validated::default(),
        }
    }

    /// Removes a checkpoint that the method could not use, so that another attempt starts from the beginning.
    fn forget(&self) -> Result<(), FileError> {
        if self.resumed { self.keeper.remove() } else { Ok(()) }
    }

    /// Evaluates a trial: chooses among the policies that validation has kept and the last one, and plays the chosen one on the
    /// held-out seeds; the last one too, where another is chosen.
    fn evaluate(&mut self, trial: &mut dyn Trial, seeds: &[u64]) -> Result<(), TrialError> {
        self.stop.keeps(false);
        if let Some(chosen) = self.choose(trial)? {
            self.hold_out(trial, seeds, RowKind::Last)?;
            trial.load(&chosen.model)?;
            self.validated.chosen = Some(chosen.row);
        }
        self.hold_out(trial, seeds, RowKind::Evaluation)
    }

    /// Plays the held-out seeds with a model, whose task has a record on fewer of them; `None` where the model does not repeat
    /// the episodes of that record.
    fn play_more(
        &mut self,
        trial: &mut dyn Trial,
        before: Record,
        model: &Archive,
        seeds: &[u64],
    ) -> Result<Option<TaskResult>, TrialError> {
        self.stop.keeps(false);
        trial.load(model)?;
        self.hold_out(trial, seeds, RowKind::Evaluation)?;
        let played = self.take_rows();
        if !before.evaluations().eq(played.iter().take(before.evaluations().count())) {
            return Ok(None);
        }
        let means = mean_metrics(&before.rows);
        let Record { summary, mut rows } = before;
        rows.retain(|row| row.kind != RowKind::Evaluation);
        let mut training = summary.metrics;
        training.retain(|name, _| !means.contains_key(name));
        if !rows.iter().any(|row| row.kind == RowKind::Last)
            && let Some(last) = training.get_mut(&format!("{LAST_PREFIX}{}", self.objective))
            && let Some(mean) = mean_metrics(&played).get(self.objective)
        {
            *last = *mean;
        }
        rows.extend(played);
        self.earlier = summary.wall;
        let (programs, parts) = (trial.programs(), trial.parts());
        let wall = self.wall(trial.simulator_s());
        Ok(Some(TaskResult { rows, training, details: summary.details, programs, parts, wall }))
    }

    /// Says something to people.
    fn note(&mut self, text: String) {
        (self.news)(News::Note(text));
    }

    /// Plays the held-out seeds and keeps a row of each.
    fn hold_out(
        &mut self,
        trial: &mut dyn Trial,
        seeds: &[u64],
        kind: RowKind,
    ) -> Result<(), TrialError> {
        let (before, objective) = (self.episodes(), self.objective);
        let news = &mut *self.news;
        let mut done = 0;
        let rows = held_out(trial, seeds, &mut |row| {
            done += 1;
            progress(before + done, row, objective).into_iter().for_each(&mut *news);
        })?;
        self.validated.rows.extend(rows.into_iter().map(|row| Row { kind, ..row }));
        Ok(())
    }

    /// Returns the policy to evaluate in place of the last one; `None` for the last one itself.
    fn choose(&mut self, trial: &mut dyn Trial) -> Result<Option<Candidate>, TrialError> {
        let last_row = self.rows.len() as u32;
        let candidates = std::mem::take(&mut self.validated.candidates);
        // Without a validation of its own the last policy is not screened: it meets the others in the final.
        let last = self.validated.of(last_row, self.objective);
        let finalists: Vec<Candidate> = (candidates.into_iter())
            .filter(|c| c.row != last_row)
            .filter(|c| last.is_none_or(|last| self.is_better(c.objective, last)))
            .collect();
        if finalists.is_empty() {
            return Ok(None);
        }
        // A training that was killed when it was over is restored when its first episode begins, and has a model only then.
        let last = self.play_final(trial, last_row)?;
        let Some(model) = trial.model() else { return Ok(None) };
        let mut best: Option<(Candidate, f64)> = None;
        for finalist in finalists {
            trial.load(&finalist.model)?;
            let objective = self.play_final(trial, finalist.row)?;
            let leads = |other: f64| self.direction.is_worse(other, objective);
            if self.is_better(objective, last) && best.as_ref().is_none_or(|(_, b)| leads(*b)) {
                best = Some((finalist, objective));
            }
        }
        trial.load(&model)?;
        Ok(best.map(|(candidate, _)| candidate))
    }

    /// Plays the seeds of the final with the policy of a row and returns its mean objective.
    fn play_final(&mut self, trial: &mut dyn Trial, row: u32) -> Result<f64, TrialError> {
        let first = self.selection.validation_seeds;
        let seeds = first..first + self.selection.finalist_seeds;
        self.play(row, seeds, &mut |seed| trial.validate(seed))
    }

    /// Plays validation seeds with the policy of a row of training, keeps a row of each and returns the mean objective.
    fn play(
        &mut self,
        row: u32,
        seeds: std::ops::Range<u32>,
        episode: &mut dyn FnMut(u64) -> Result<Metrics, TrialError>,
    ) -> Result<f64, TrialError> {
        let (mut sum, count) = (0.0, seeds.len() as f64);
        for k in seeds {
            let seed = seed::validation(self.task.seed, k);
            let metrics = episode(seed)?;
            let value = judged(&metrics, self.objective);
            sum += value.ok_or_else(|| {
                let text = format!("the episode with seed {seed} has no {}", self.objective);
                TrialError::Failed(text.into())
            })?;
            let row = Row { kind: RowKind::Validation, episode: row, seed, metrics };
            self.validated.rows.push(row);
            let row = self.validated.rows.last().expect("one was added");
            progress(self.episodes(), row, self.objective).into_iter().for_each(&mut *self.news);
        }
        Ok(sum / count)
    }

    fn is_better(&self, value: f64, than: f64) -> bool {
        self.selection.is_better(value, than, self.direction)
    }

    /// Episodes of all kinds so far, those of attempts that were given up included.
    fn episodes(&self) -> usize {
        self.rows.len() + self.validated.rows.len() + self.validated.discarded as usize
    }

    /// Returns the rows of the record, and takes them.
    fn take_rows(&mut self) -> Vec<Row> {
        let mut rows = std::mem::take(&mut self.rows);
        rows.append(&mut self.validated.rows);
        rows
    }

    /// Returns what the record says of the choice of the policy and of restarts, from its rows.
    fn figures(&self, rows: &[Row]) -> Metrics {
        let mut figures = Metrics::new();
        let mut put = |name: &str, value: f64| figures.insert(name.to_owned(), value);
        let count = |kind| rows.iter().filter(|row| row.kind == kind).count() as u32;
        if self.selection.validates() {
            let chosen = self.validated.chosen;
            put(POLICY_ROW, f64::from(chosen.unwrap_or_else(|| count(RowKind::Training))));
            put(VALIDATION_EPISODES, f64::from(count(RowKind::Validation)));
            let kind = if chosen.is_some() { RowKind::Last } else { RowKind::Evaluation };
            if let Some(last) = means_of(rows, kind).get(self.objective) {
                put(&format!("{LAST_PREFIX}{}", self.objective), *last);
            }
        }
        if self.selection.restart == Restart::Dead {
            put(RESTARTS, f64::from(self.validated.restarts));
            put(DISCARDED_EPISODES, f64::from(self.validated.discarded));
        }
        put(DEAD, f64::from(u8::from(self.validated.is_dead)));
        figures
    }

    /// Returns the time that the task has taken so far.
    fn wall(&self, simulator_s: f64) -> Wall {
        Wall {
            wall_s: self.earlier.wall_s + self.start.elapsed().as_secs_f64(),
            simulator_s: self.earlier.simulator_s + simulator_s,
            attempts: self.attempt,
            peak_memory_mb: machine::peak_memory_mb(),
            git: GIT.to_owned(),
            ..Wall::default()
        }
    }
}

impl Course for TaskRun<'_> {
    fn seed(&self, index: u32) -> u64 {
        seed::training(self.task.seed, index)
    }

    fn episode(&mut self, seed: u64, metrics: Metrics) {
        let episode = self.rows.len() as u32;
        let row = Row { kind: RowKind::Training, episode, seed, metrics };
        progress(self.episodes() + 1, &row, self.objective).into_iter().for_each(&mut *self.news);
        self.rows.push(row);
    }

    fn saved(&mut self) -> Option<Archive> {
        self.stop.keeps(true);
        match self.keeper.restore() {
            Ok(None) => None,
            Ok(Some((state, kept))) => {
                self.earlier.wall_s = kept.wall_s;
                self.earlier.simulator_s = kept.simulator_s;
                self.rows = kept.rows;
                self.validated = kept.validated;
                self.resumed = true;
                let done = self.rows.len();
                (self.news)(News::Note(format!("training continues after episode {done}")));
                let episodes = self.episodes();
                let last = self.rows.last().and_then(|row| progress(episodes, row, self.objective));
                last.into_iter().for_each(&mut *self.news);
                Some(state)
            }
            Err(reason) => {
                (self.news)(News::Note(reason));
                None
            }
        }
    }

    fn validate(&mut self, policy: &mut dyn Policy) -> Result<(), TrialError> {
        let row = self.rows.len() as u32;
        if !self.selection.is_due(row) {
            return Ok(());
        }
        let seeds = 0..self.selection.validation_seeds;
        let objective = self.play(row, seeds, &mut |seed| policy.episode(seed))?;
        if let Some(model) = policy.model() {
            let candidate = Candidate { row, objective, model };
            self.validated.keep(candidate, self.selection.finalists, self.direction);
        }
        Ok(())
    }

    fn stops(&self) -> bool {
        let patience = self.selection.patience as usize;
        patience > 0 && self.validated.since_best(self.objective, self.direction) >= patience
    }

    fn restarts(&self) -> u32 {
        self.validated.restarts
    }

    fn starts_again(&mut self, is_alive: bool) -> bool {
        let may = self.selection.restart == Restart::Dead && self.validated.restarts < MAX_RESTARTS;
        let again = !is_alive && may;
        self.validated.is_dead = !is_alive;
        if again {
            let rows = self.rows.len() as u32;
            (self.news)(News::Note(format!(
                "the network is dead after episode {rows}: training starts again from another seed"
            )));
            let (restarts, discarded) = (self.validated.restarts, self.validated.discarded);
            let discarded = discarded + rows + self.validated.rows.len() as u32;
            self.validated =
                Validated { restarts: restarts + 1, discarded, ..Validated::default() };
            self.rows.clear();
        }
        again
    }

    fn checkpoint(
        &mut self,
        state: &dyn Fn() -> Archive,
        simulator_s: f64,
    ) -> Result<(), CheckpointError> {
        let stops = self.stop.is_asked();
        if stops || self.keeper.is_due() {
            let wall = self.wall(simulator_s);
            self.keeper.keep(
                state(),
                &self.rows,
                &self.validated,
                wall.wall_s,
                wall.simulator_s,
            )?;
        }
        if stops { Err(CheckpointError::Stopped) } else { Ok(()) }
    }
}

/// Runs one evaluation episode per seed and returns a row of each.
///
/// # Arguments
///
/// * `seeds` — as the episodes get them.
/// * `done` — called with the row of every episode.
///
/// # Errors
///
/// [`TrialError`] when an episode fails.
fn held_out(
    trial: &mut dyn Trial,
    seeds: &[u64],
    done: &mut dyn FnMut(&Row),
) -> Result<Vec<Row>, TrialError> {
    let mut rows = Vec::with_capacity(seeds.len());
    for (k, &seed) in seeds.iter().enumerate() {
        let metrics = trial.episode(seed)?;
        let row = Row { kind: RowKind::Evaluation, episode: k as u32, seed, metrics };
        done(&row);
        rows.push(row);
    }
    Ok(rows)
}

/// Returns the news of an episode; a row from a checkpoint might lack its objective.
fn progress(episodes: usize, row: &Row, objective: &str) -> Option<News> {
    let objective = row.metrics.get(objective).copied()?;
    Some(News::Episode(Progress { episodes: episodes as u32, objective }))
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

#[cfg(test)]
mod course {
    use std::path::Path;
    use std::time::Duration;

    use super::*;
    use crate::run::domain::Played;
    use crate::run::selection::Select;
    use crate::run::testing::{Counting, planned};
    use crate::store::Layout;

    #[test]
    fn a_row_has_the_seed_that_its_episode_had() {
        let dir = tempfile::tempdir().unwrap();
        let (manifest, tasks) = planned(2);
        let task = tasks.iter().find(|t| t.method == "learner").unwrap();
        let keeper = Keeper::new(&Layout::new(dir.path()), "", task, Duration::MAX);
        let mut news = |_| {};
        let (objective, selection) = (("score", Direction::Higher), Selection::default());
        let mut course =
            TaskRun::new(task, objective, selection, 1, keeper, Stop::default(), &mut news);
        let mut trial = Counting::of(2);
        trial.train(&mut course).unwrap();
        let point = manifest.identity.points.iter().find(|p| p.point == task.point).unwrap();
        let seeds = point.evaluation_seeds(&manifest.identity.evaluation_seeds);
        course.evaluate(&mut trial, &seeds).unwrap();
        let rows: Vec<u64> = course.take_rows().iter().map(|r| r.seed).collect();
        assert_eq!((rows.len(), &rows), (4, &trial.seeds));
        assert_eq!(rows[2..], seeds);
    }

    /// Learns a number per episode of training: the objective of the policy after it.
    #[derive(Clone)]
    struct Swings {
        objectives: Vec<f64>,
        done: usize,
        /// What an episode is to begin with, as learners take over a checkpoint.
        pending: Option<usize>,
        /// Episodes, from 1, after which the network is dead.
        dies_after: Vec<usize>,
        /// Rows after which it fails as if it had been killed.
        killed_after: usize,
        /// Whether its policies can be kept.
        keeps: bool,
    }

    impl Swings {
        fn of(objectives: &[f64]) -> Self {
            let (objectives, dies_after) = (objectives.to_vec(), Vec::new());
            Self {
                objectives,
                done: 0,
                pending: None,
                dies_after,
                killed_after: usize::MAX,
                keeps: true,
            }
        }

        fn archive(&self) -> Archive {
            let mut archive = Archive::default();
            archive.put_u32("done", &[1], &[self.done as u32]);
            archive
        }

        fn restore(&mut self, archive: &Archive) {
            self.done = archive.u32("done", &[1]).unwrap()[0] as usize;
        }
    }

    impl Trial for Swings {
        fn train(&mut self, course: &mut dyn Course) -> Result<(), TrialError> {
            course.saved().iter().for_each(|saved| self.restore(saved));
            self.pending = Some(self.done).filter(|done| *done > 0);
            while !course.stops() && self.done < self.objectives.len() {
                self.pending = None;
                course.episode(self.done as u64, Metrics::from([("delay".to_owned(), 99.0)]));
                self.done += 1;
                let is_dead = self.dies_after.first() == Some(&self.done);
                if course.starts_again(!is_dead) {
                    self.dies_after.remove(0);
                    self.done = 0;
                    continue;
                }
                course.validate(&mut Played(self))?;
                course.checkpoint(&|| self.archive(), 0.0)?;
                if self.done == self.killed_after {
                    return Err(TrialError::Failed("killed".into()));
                }
            }
            Ok(())
        }

        fn episode(&mut self, seed: u64) -> Result<Metrics, TrialError> {
            self.pending = None;
            let objective = self.objectives[self.done - 1] + (seed % 3) as f64 * 0.1;
            Ok(Metrics::from([("delay".to_owned(), objective)]))
        }

        fn model(&self) -> Option<Archive> {
            (self.keeps && self.pending.is_none()).then(|| self.archive())
        }

        fn load(&mut self, model: &Archive) -> Result<(), TrialError> {
            self.restore(model);
            Ok(())
        }
    }

    const HELD_OUT: [u64; 2] = [3, 6];

    fn selection() -> Selection {
        Selection {
            select: Select::Validation,
            validation_start: 2,
            validation_interval: 2,
            validation_seeds: 2,
            finalists: 2,
            finalist_seeds: 3,
            margin: 0.05,
            restart: Restart::Dead,
            ..Selection::default()
        }
    }

    /// Returns the rows of a task in a folder, what the record says of the choice, and the trial afterwards.
    fn done(
        dir: &Path,
        mut trial: Swings,
        selection: Selection,
    ) -> Option<(Vec<Row>, Metrics, Swings)> {
        let (_, tasks) = planned(2);
        let task = tasks.iter().find(|t| t.method == "learner").unwrap();
        let keeper = Keeper::new(&Layout::new(dir), "", task, Duration::ZERO);
        let mut news = |_| {};
        let objective = ("delay", Direction::Lower);
        let mut course =
            TaskRun::new(task, objective, selection, 1, keeper, Stop::default(), &mut news);
        trial.train(&mut course).ok()?;
        course.evaluate(&mut trial, &HELD_OUT).unwrap();
        let rows = course.take_rows();
        let figures = course.figures(&rows);
        Some((rows, figures, trial))
    }

    fn whole(trial: Swings, selection: Selection) -> (Vec<Row>, Metrics, Swings) {
        done(tempfile::tempdir().unwrap().path(), trial, selection).unwrap()
    }

    fn values(rows: &[Row], kind: RowKind) -> Vec<f64> {
        rows.iter().filter(|r| r.kind == kind).map(|r| r.metrics["delay"]).collect()
    }

    #[test]
    fn the_policy_that_validation_finds_best_is_evaluated_and_the_last_one_beside_it() {
        let (rows, figures, trial) =
            whole(Swings::of(&[50.0, 40.0, 9.0, 20.0, 70.0, 30.0, 60.0]), selection());
        assert_eq!(values(&rows, RowKind::Evaluation), [20.0, 20.0], "9 was never validated");
        assert_eq!(values(&rows, RowKind::Last), [60.0, 60.0]);
        assert_eq!((figures["policy_row"], figures["last_delay"]), (4.0, 60.0));
        assert_eq!(trial.done, 4, "the model is the policy that was evaluated");
        // Three validations of two, then two finalists and the last policy with three each.
        assert_eq!(figures["validation_episodes"], 6.0 + 9.0);
        let of: Vec<u32> =
            rows.iter().filter(|r| r.kind == RowKind::Validation).map(|r| r.episode).collect();
        assert_eq!(of, [2, 2, 4, 4, 6, 6, 7, 7, 7, 4, 4, 4, 6, 6, 6]);
        let seeds = |row: u32| -> Vec<u64> {
            rows.iter()
                .filter(|r| r.kind == RowKind::Validation && r.episode == row)
                .map(|r| r.seed)
                .collect()
        };
        assert_eq!(seeds(4), seeds(6), "every finalist meets the same episodes");
        assert_eq!(seeds(4)[2..], seeds(7), "the last policy too");
    }

    #[test]
    fn the_last_policy_is_kept_unless_another_is_better_by_more_than_the_margin() {
        let (rows, figures, _) = whole(Swings::of(&[50.0, 19.5, 30.0, 20.0]), selection());
        assert_eq!(values(&rows, RowKind::Evaluation), [20.0, 20.0]);
        assert!(values(&rows, RowKind::Last).is_empty());
        assert_eq!((figures["policy_row"], figures["last_delay"]), (4.0, 20.0));
        assert_eq!(figures["validation_episodes"], 4.0, "nobody is compared again");
    }

    #[test]
    fn without_validation_the_last_policy_is_evaluated_and_nothing_is_added() {
        let (rows, figures, _) = whole(Swings::of(&[50.0, 19.0, 30.0]), Selection::default());
        assert_eq!(values(&rows, RowKind::Evaluation), [30.0, 30.0]);
        assert_eq!((rows.len(), figures), (5, Metrics::from([("dead".to_owned(), 0.0)])));
    }

    #[test]
    fn training_stops_after_so_many_validations_without_a_better_one() {
        let patient = Selection { patience: 2, ..selection() };
        let trial = Swings::of(&[50.0, 20.0, 9.0, 25.0, 9.0, 30.0, 9.0, 8.0]);
        // Also where no policy can be kept.
        for (keeps, chosen) in [(true, 2.0), (false, 6.0)] {
            let (rows, figures, _) = whole(Swings { keeps, ..trial.clone() }, patient.clone());
            assert_eq!(values(&rows, RowKind::Training).len(), 6);
            assert_eq!((figures["policy_row"], figures["last_delay"]), (chosen, 30.0));
        }
    }

    #[test]
    fn a_training_with_a_dead_network_starts_again_and_says_how_often() {
        let trial = Swings { dies_after: vec![3, 2], ..Swings::of(&[50.0, 40.0, 30.0, 20.0]) };
        let (rows, figures, _) = whole(trial.clone(), selection());
        assert_eq!(values(&rows, RowKind::Training).len(), 4);
        // Three rows and a validation of two, then two rows.
        assert_eq!((figures["restarts"], figures["discarded_episodes"]), (2.0, 3.0 + 2.0 + 2.0));
        assert_eq!(figures["dead"], 0.0);
        let dead = Swings { dies_after: vec![4], ..trial };
        let (rows, figures, _) = whole(dead, Selection { restart: Restart::Never, ..selection() });
        assert_eq!((figures["dead"], figures.contains_key("restarts")), (1.0, false));
        assert_eq!(values(&rows, RowKind::Training).len(), 4);
    }

    #[test]
    fn a_task_that_was_killed_ends_in_the_rows_of_one_that_was_not() {
        let trial = Swings {
            dies_after: vec![3],
            ..Swings::of(&[50.0, 40.0, 9.0, 20.0, 70.0, 30.0, 60.0, 65.0])
        };
        let (rows, figures, _) = whole(trial.clone(), selection());
        for killed_after in 1..=8 {
            let dir = tempfile::tempdir().unwrap();
            let killed = Swings { killed_after, ..trial.clone() };
            assert!(done(dir.path(), killed, selection()).is_none());
            let mut again = trial.clone();
            again.dies_after = if killed_after <= 2 { trial.dies_after.clone() } else { vec![] };
            let (resumed, said, _) = done(dir.path(), again, selection()).unwrap();
            assert_eq!((&resumed, &said), (&rows, &figures), "killed after {killed_after}");
        }
    }

    #[test]
    fn a_training_that_was_killed_where_it_stops_early_does_not_go_on() {
        let patient = Selection { patience: 2, ..selection() };
        let trial = Swings::of(&[50.0, 20.0, 9.0, 25.0, 9.0, 30.0, 9.0, 8.0]);
        let (rows, figures, _) = whole(trial.clone(), patient.clone());
        assert_eq!(values(&rows, RowKind::Training).len(), 6);
        for killed_after in 1..=6 {
            let dir = tempfile::tempdir().unwrap();
            assert!(
                done(dir.path(), Swings { killed_after, ..trial.clone() }, patient.clone())
                    .is_none()
            );
            let (resumed, said, _) = done(dir.path(), trial.clone(), patient.clone()).unwrap();
            assert_eq!((&resumed, &said), (&rows, &figures), "killed after {killed_after}");
        }
    }
}
