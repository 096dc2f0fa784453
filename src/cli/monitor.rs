//! What `run` says while its workers work: progress, notes and JSON lines.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use serde_json::json;

use super::output::{Progress, line, note};
use crate::run::domain::{Domain, Objective};
use crate::run::effort::TaskEffort;
use crate::run::executor::Event;
use crate::run::method::{Training, find};
use crate::store::manifest::Task;
use crate::store::record::{Outcome, Record, Summary};

/// Episodes over which the objective of a task in progress is averaged: one alone says little of a
/// training that explores.
const RECENT_EPISODES: usize = 5;

/// Units of the progress bar for an expected second of work.
const UNITS_PER_S: f64 = 1000.0;

/// A task to do and how far it is.
struct Work {
    task: Task,
    effort: TaskEffort,
    episodes: u32,
    /// The objective in the last episodes.
    recent: VecDeque<f64>,
}

impl Work {
    fn name(&self) -> String {
        let Task { method, point, replicate, .. } = &self.task;
        match replicate {
            0 => format!("{method} on {point}"),
            _ => format!("{method} on {point} (replicate {replicate})"),
        }
    }

    /// Returns the expected seconds of what is done.
    fn seconds(&self) -> f64 {
        if self.episodes == 0 { 0.0 } else { self.effort.worker_seconds(self.episodes) }
    }

    /// Returns how far the task is; `baseline` is the baseline's objective on its point MDP.
    fn status(&self, objective: Objective, baseline: Option<f64>) -> String {
        let mean = self.recent.iter().sum::<f64>() / self.recent.len() as f64;
        let value = match baseline {
            Some(baseline) if baseline > 0.0 => {
                format!("{:.2} of the baseline's", mean / baseline)
            }
            _ if objective.unit.is_empty() => format!("{mean:.2}"),
            _ => format!("{mean:.1} {}", objective.unit),
        };
        let (name, all) = (self.name(), self.effort.episodes());
        format!("{name}: episode {} of {all}, {} {value}", self.episodes, objective.title)
    }
}

/// Turns events into progress, notes and JSON lines.
pub(super) struct Monitor<'d> {
    progress: Progress,
    /// Expected seconds of what is done.
    done_s: f64,
    work: BTreeMap<usize, Work>,
    /// The baseline's objective by point MDP.
    baselines: BTreeMap<String, f64>,
    domain: &'d dyn Domain,
    /// The task that reported last, while it is in progress.
    latest: Option<usize>,
    /// What learners have said of point MDPs.
    remarks: BTreeSet<String>,
    /// The task for which a reason was told first.
    reasons: BTreeMap<String, usize>,
    finished: usize,
    failed: usize,
    json: bool,
}

impl<'d> Monitor<'d> {
    /// Returns a monitor of the tasks to do.
    pub(super) fn new<'a>(
        todo: impl IntoIterator<Item = (Task, TaskEffort)>,
        domain: &'d dyn Domain,
        done: impl IntoIterator<Item = (&'a Task, &'a Record)>,
        json: bool,
        quiet: bool,
    ) -> Self {
        let work: BTreeMap<usize, Work> = todo
            .into_iter()
            .map(|(task, effort)| {
                (task.task, Work { task, effort, episodes: 0, recent: VecDeque::new() })
            })
            .collect();
        let all_s: f64 = work.values().map(|work| work.effort.whole_seconds()).sum();
        let mut monitor = Self {
            progress: Progress::new((all_s * UNITS_PER_S) as u64, None, quiet || json),
            done_s: 0.0,
            work,
            baselines: BTreeMap::new(),
            domain,
            latest: None,
            remarks: BTreeSet::new(),
            reasons: BTreeMap::new(),
            finished: 0,
            failed: 0,
            json,
        };
        done.into_iter().for_each(|(_, record)| monitor.keep_baseline(&record.summary));
        monitor
    }

    /// Tasks that have their record.
    pub(super) fn finished(&self) -> usize {
        self.finished
    }

    /// Takes note of an event and shows the progress.
    pub(super) fn handle(&mut self, event: Event) {
        match event {
            Event::Progress { task, progress } => {
                let Some(work) = self.work.get_mut(&task) else { return };
                self.done_s -= work.seconds();
                work.episodes = progress.episodes.min(work.effort.episodes());
                self.done_s += work.seconds();
                work.recent.push_back(progress.objective);
                if work.recent.len() > RECENT_EPISODES {
                    work.recent.pop_front();
                }
                self.latest = Some(task);
            }
            Event::Retry { task, reason } => {
                let Some(work) = self.work.get_mut(&task) else { return };
                self.done_s -= work.seconds();
                work.episodes = 0;
                work.recent.clear();
                let name = work.name();
                let reason = self.told(task, reason);
                let text = format!("task {task} ({name}) failed and is tried again: {reason}");
                self.latest = self.latest.filter(|latest| *latest != task);
                self.say(&text);
            }
            Event::Undone { task, reason } => {
                let Some(work) = self.work.get(&task) else { return };
                let (name, Task { method, point, replicate, .. }) =
                    (work.name(), work.task.clone());
                self.latest = self.latest.filter(|latest| *latest != task);
                let told = self.told(task, reason.clone());
                self.say(&format!("task {task} ({name}) is not done: {told}"));
                if self.json {
                    // Tasks go on also where nobody can be told.
                    let _ = line(json!({
                        "event": "undone",
                        "task": task,
                        "method": method,
                        "point": point,
                        "replicate": replicate,
                        "reason": reason,
                    }));
                }
            }
            Event::Finished(record) => self.finish(&record),
        }
        self.progress.set((self.done_s * UNITS_PER_S) as u64, &self.message());
    }

    /// Removes the bar.
    pub(super) fn close(&self) {
        self.progress.finish();
    }

    fn message(&self) -> String {
        let failed =
            if self.failed > 0 { format!(", {} failed", self.failed) } else { String::new() };
        let latest = self.latest.and_then(|task| self.work.get(&task)).map(|work| {
            let baseline = self.baselines.get(&*work.task.point).copied();
            format!(", {}", work.status(self.domain.objective(), baseline))
        });
        let (finished, tasks) = (self.finished, self.work.len());
        format!("{finished}/{tasks} tasks{failed}{}", latest.unwrap_or_default())
    }

    /// Returns a reason as it is told: of many tasks that fail alike, such as with one traceback, once.
    fn told(&mut self, task: usize, reason: String) -> String {
        match self.reasons.get(&reason) {
            Some(first) if *first == task => "for the same reason".to_owned(),
            Some(first) => format!("as task {first}"),
            None => {
                self.reasons.insert(reason.clone(), task);
                reason
            }
        }
    }

    fn finish(&mut self, record: &Record) {
        let summary = &record.summary;
        self.finished += 1;
        self.latest = self.latest.filter(|latest| *latest != summary.task);
        self.keep_baseline(summary);
        if let Some(work) = self.work.get_mut(&summary.task) {
            self.done_s -= work.seconds();
            work.episodes = work.effort.episodes();
            self.done_s += work.seconds();
        }
        let method = find(self.domain.methods(), &summary.method);
        if method.is_ok_and(|m| m.training == Training::Learned) {
            for (what, text) in &summary.details {
                let remark = format!("{}: {what}: {text}", summary.point);
                if self.remarks.insert(remark.clone()) {
                    self.say(&remark);
                }
            }
        }
        if summary.outcome == Outcome::Failed {
            self.failed += 1;
            let reason = summary.reason.as_deref().unwrap_or("unknown reason");
            let reason = self.told(summary.task, reason.to_owned());
            self.say(&format!(
                "task {} ({} on {}) failed: {reason}",
                summary.task, summary.method, summary.point
            ));
        }
        if self.json {
            let metric = self.domain.objective().metric;
            let mut value = json!({
                "event": "task",
                "task": summary.task,
                "method": summary.method,
                "point": summary.point,
                "replicate": summary.replicate,
                "outcome": summary.outcome,
                "reason": summary.reason,
                "wall_s": summary.wall.wall_s,
            });
            value[metric] = json!(summary.metrics.get(metric));
            // Tasks go on also where nobody can be told.
            let _ = line(value);
        }
    }

    fn keep_baseline(&mut self, record: &Summary) {
        let objective = record.metrics.get(self.domain.objective().metric);
        let objective = objective.filter(|_| record.outcome == Outcome::Ok);
        if let (true, Some(objective)) = (self.domain.baseline() == Some(&record.method), objective)
        {
            self.baselines.insert(record.point.clone(), *objective);
        }
    }

    fn say(&self, text: &str) {
        if self.json {
            note(text);
        } else {
            self.progress.note(text);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::testing::effort;
    use crate::domains::domains;
    use crate::run::progress::Progress as Episodes;
    use crate::store::record::TaskResult;
    use crate::store::wall::Wall;

    fn task(task: usize, method: &str, replicate: u32) -> Task {
        Task { task, method: method.into(), point: "p".into(), replicate, seed: 1 }
    }

    fn record(of: &Task, delay_s: f64) -> Box<Record> {
        let mut record = Record::finished(of, "", TaskResult::default());
        record.summary.metrics.insert("delay_s".into(), delay_s);
        Box::new(record)
    }

    fn tasks() -> [Task; 3] {
        [task(0, "baseline", 0), task(1, "idqn", 0), task(2, "idqn", 1)]
    }

    fn monitor(records: &[Record]) -> Monitor<'static> {
        let effort = |t: &Task| match t.method.as_str() {
            "idqn" => effort((100, 2.0), (5, 1.0)),
            _ => effort((0, 0.0), (5, 1.0)),
        };
        let todo: Vec<_> = tasks().into_iter().map(|t| (t.clone(), effort(&t))).collect();
        let tasks = tasks();
        let done = records.iter().map(|record| (&tasks[record.summary.task], record));
        Monitor::new(todo, domains()[0], done, false, true)
    }

    fn progress(task: usize, episodes: u32, delay_s: f64) -> Event {
        Event::Progress { task, progress: Episodes { episodes, objective: delay_s } }
    }

    #[test]
    fn the_task_that_reported_last_is_compared_with_the_baseline() {
        let mut m = monitor(&[]);
        assert_eq!(m.message(), "0/3 tasks");
        m.handle(progress(1, 33, 90.0));
        assert_eq!(m.message(), "0/3 tasks, idqn on p: episode 33 of 105, delay 90.0 s");
        m.handle(progress(0, 5, 50.0));
        assert_eq!(m.message(), "0/3 tasks, baseline on p: episode 5 of 5, delay 50.0 s");
        m.handle(Event::Finished(record(&tasks()[0], 50.0)));
        assert_eq!(m.message(), "1/3 tasks");
        m.handle(progress(1, 34, 10.0));
        let expected = "1/3 tasks, idqn on p: episode 34 of 105, delay 1.00 of the baseline's";
        assert_eq!(m.message(), expected);
    }

    #[test]
    fn the_delay_is_that_of_the_last_five_episodes_only() {
        let mut m = monitor(&[*record(&tasks()[0], 100.0)]);
        for (episode, delay_s) in [900.0, 800.0, 60.0, 60.0, 60.0, 60.0, 70.0].iter().enumerate() {
            m.handle(progress(2, episode as u32 + 1, *delay_s));
        }
        let expected =
            "0/3 tasks, idqn on p (replicate 1): episode 7 of 105, delay 0.62 of the baseline's";
        assert_eq!(m.message(), expected);
    }

    #[test]
    fn a_failed_attempt_starts_anew_and_a_failed_task_counts() {
        let mut m = monitor(&[]);
        m.handle(progress(1, 40, 90.0));
        m.handle(Event::Retry { task: 1, reason: "killed".into() });
        assert_eq!((m.message().as_str(), m.work[&1].episodes), ("0/3 tasks", 0));
        let failed = Record::failed(&tasks()[0], "", "killed".into(), Wall::default());
        m.handle(Event::Finished(Box::new(failed)));
        m.handle(progress(1, 1, 80.0));
        let expected = "1/3 tasks, 1 failed, idqn on p: episode 1 of 105, delay 80.0 s";
        assert_eq!(m.message(), expected);
    }

    #[test]
    fn a_reason_of_many_tasks_is_told_once() {
        let mut m = monitor(&[]);
        let mut told = |task: usize, reason: &str| m.told(task, reason.to_owned());
        assert_eq!(told(1, "Traceback"), "Traceback");
        assert_eq!(told(1, "Traceback"), "for the same reason");
        assert_eq!(told(2, "Traceback"), "as task 1");
        assert_eq!(told(2, "killed"), "killed");
    }
}
