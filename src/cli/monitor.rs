//! What `run` says while its workers work: progress, notes and JSON lines.

use std::collections::BTreeMap;

use serde_json::json;

use super::output::{Progress, line, note};
use crate::run::domain::{Domain, Effort};
use crate::run::executor::Event;
use crate::store::manifest::Task;
use crate::store::record::{Outcome, Record};

/// Units of the progress bar for an expected second of work.
const UNITS_PER_S: f64 = 1000.0;

/// A task to do and how far it is.
struct Work {
    task: Task,
    effort: Effort,
    episodes: u32,
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
}

/// Turns events into progress, notes and JSON lines.
pub(super) struct Monitor<'d> {
    progress: Progress,
    /// Expected seconds of what is done.
    done_s: f64,
    work: BTreeMap<usize, Work>,
    domain: &'d dyn Domain,
    /// The task that reported last, while it is in progress, and its objective.
    latest: Option<(usize, f64)>,
    /// The task for which a reason was told first.
    reasons: BTreeMap<String, usize>,
    finished: usize,
    failed: usize,
    json: bool,
}

impl<'d> Monitor<'d> {
    /// Returns a monitor of the tasks to do.
    pub(super) fn new(
        todo: impl IntoIterator<Item = (Task, Effort)>,
        domain: &'d dyn Domain,
        json: bool,
        quiet: bool,
    ) -> Self {
        let work = |(task, effort): (Task, _)| (task.task, Work { task, effort, episodes: 0 });
        let work: BTreeMap<usize, Work> = todo.into_iter().map(work).collect();
        let all_s: f64 = work.values().map(|work| work.effort.whole_seconds()).sum();
        Self {
            progress: Progress::new((all_s * UNITS_PER_S) as u64, None, quiet || json),
            done_s: 0.0,
            work,
            domain,
            latest: None,
            reasons: BTreeMap::new(),
            finished: 0,
            failed: 0,
            json,
        }
    }

    /// Tasks that have their record.
    pub(super) fn finished(&self) -> usize {
        self.finished
    }

    /// Takes note of an event and shows the progress.
    pub(super) fn handle(&mut self, event: Event) {
        match event {
            Event::Progress { task, progress } => {
                self.reached(task, progress.episodes);
                self.latest = Some((task, progress.objective));
            }
            Event::Retry { task, reason } => {
                self.reached(task, 0);
                self.tell(task, "failed and is tried again", &reason);
            }
            Event::Undone { task, reason } => {
                self.latest = self.latest.filter(|(latest, _)| *latest != task);
                self.tell(task, "is not done", &reason);
                let Some(Work { task: t, .. }) = self.work.get(&task) else { return };
                if self.json {
                    // Tasks go on also where nobody can be told.
                    let _ = line(json!({
                        "event": "undone",
                        "task": task,
                        "method": t.method,
                        "point": t.point,
                        "replicate": t.replicate,
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

    /// Takes note of how many episodes of a task are done.
    fn reached(&mut self, task: usize, episodes: u32) {
        self.latest = self.latest.filter(|(latest, _)| *latest != task);
        if let Some(work) = self.work.get_mut(&task) {
            self.done_s -= work.seconds();
            work.episodes = episodes.min(work.effort.episodes());
            self.done_s += work.seconds();
        }
    }

    fn message(&self) -> String {
        let mut text = format!("{}/{} tasks", self.finished, self.work.len());
        if self.failed > 0 {
            text.push_str(&format!(", {} failed", self.failed));
        }
        let latest = self.latest.and_then(|(task, value)| Some((self.work.get(&task)?, value)));
        if let Some((work, value)) = latest {
            let (all, objective) = (work.effort.episodes(), self.domain.objective());
            let (name, episodes) = (work.name(), work.episodes);
            let said = format!("{name}: episode {episodes} of {all}, {}", objective.title);
            text.push_str(format!(", {said} {value:.2} {}", objective.unit).trim_end());
        }
        text
    }

    /// Tells what became of a task; a reason of many tasks, such as one traceback, is told once.
    fn tell(&mut self, task: usize, what: &str, reason: &str) {
        let reason = match self.reasons.get(reason) {
            Some(first) if *first == task => "for the same reason".to_owned(),
            Some(first) => format!("as task {first}"),
            None => {
                self.reasons.insert(reason.to_owned(), task);
                reason.to_owned()
            }
        };
        let name = self.work.get(&task).map(Work::name).unwrap_or_default();
        let text = format!("task {task} ({name}) {what}: {reason}");
        match self.json {
            true => note(text),
            false => self.progress.note(&text),
        }
    }

    fn finish(&mut self, record: &Record) {
        let summary = &record.summary;
        self.finished += 1;
        self.reached(summary.task, u32::MAX);
        if summary.outcome == Outcome::Failed {
            self.failed += 1;
            let reason = summary.reason.as_deref().unwrap_or("unknown reason");
            self.tell(summary.task, "failed", reason);
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domains::domains;
    use crate::run::progress::Progress as Episodes;
    use crate::store::record::TaskResult;
    use crate::store::wall::Wall;

    fn task(task: usize, method: &str) -> Task {
        Task { task, method: method.into(), point: "p".into(), replicate: 0, seed: 1 }
    }

    fn effort(training: u32, evaluation: u32) -> Effort {
        let (training_s, evaluation_s) = (2.0, 1.0);
        Effort { training, training_s, evaluation, evaluation_s, is_informed: true }
    }

    fn progress(task: usize, episodes: u32, objective: f64) -> Event {
        Event::Progress { task, progress: Episodes { episodes, objective } }
    }

    #[test]
    fn finished_and_failed_tasks_and_the_one_that_reported_last_are_said() {
        let todo = [(task(0, "baseline"), effort(0, 5)), (task(1, "idqn"), effort(100, 5))];
        let mut m = Monitor::new(todo, domains()[0], false, true);
        assert_eq!(m.message(), "0/2 tasks");
        m.handle(progress(1, 33, 90.0));
        assert_eq!(m.message(), "0/2 tasks, idqn on p: episode 33 of 105, delay 90.00 s");
        m.handle(Event::Finished(Box::new(Record::finished(
            &task(0, "baseline"),
            "",
            TaskResult::default(),
        ))));
        m.handle(Event::Retry { task: 1, reason: "killed".into() });
        assert_eq!((m.message().as_str(), m.work[&1].episodes), ("1/2 tasks", 0));
        let failed = Record::failed(&task(1, "idqn"), "", "killed".into(), Wall::default());
        m.handle(Event::Finished(Box::new(failed)));
        assert_eq!(m.message(), "2/2 tasks, 1 failed");
    }
}
