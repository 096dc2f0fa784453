//! How long a run still takes: what tasks are expected to cost, corrected by what those that are done or
//! in progress have cost, laid out on the workers in the order in which they get them.
//!
//! Tasks are expected to be wrong by a factor for the machine, one for their method and one for their
//! point MDP. Each is the ratio of the seconds that were observed to those expected, with some
//! seconds of faith in the expectation ([`Seen`]). A last long task counts in full, however many workers wait for it.

use std::collections::{BTreeMap, BTreeSet, HashMap, VecDeque};
use std::time::Duration;

use crate::run::effort::{Seen, TaskEffort};

/// Logarithm of the error of a forecast without any observation: a factor of 1.8.
const ERROR: f64 = 0.6;

/// The part of it that stays with any number of observations.
const LEAST_ERROR: f64 = 0.12;

/// Most seconds, minutes that a range is given in.
const MAX_IN_UNIT: f64 = 90.0;

/// By method and point MDP, how much of what was expected counts; `None` if it does not.
type Share<'a> = dyn Fn(&(&str, &str, Seen)) -> Option<f64> + 'a;

/// A task that is not finished.
#[derive(Debug, Clone)]
pub(super) struct Job {
    /// Row of the plan.
    pub(super) task: usize,
    /// Name of the method.
    pub(super) method: String,
    /// Id of the point MDP.
    pub(super) point: String,
    /// What it is expected to cost.
    pub(super) effort: TaskEffort,
}

impl Job {
    fn seconds(&self, episodes: u32) -> f64 {
        self.effort.worker_seconds(episodes)
    }

    fn all(&self) -> f64 {
        self.effort.whole_seconds()
    }
}

/// A task that a worker has.
#[derive(Debug, Clone)]
struct Running {
    job: Job,
    start_s: f64,
    /// Episodes of an earlier attempt that it goes on from, which took no time of this one.
    before: u32,
    /// Episodes done, and when the last of them was.
    done: Option<(u32, f64)>,
}

impl Running {
    /// Returns what was seen of it until then, where a start from nothing would have been expected to take so long.
    fn seen(&self, expected_s: f64, now_s: f64) -> Seen {
        let before_s = self.job.effort.seconds(self.before);
        Seen { observed_s: now_s - self.start_s, expected_s: expected_s - before_s }
    }
}

/// The tasks of a run and what is known of their cost.
#[derive(Debug, Clone)]
pub(super) struct Forecast {
    waiting: VecDeque<Job>,
    running: BTreeMap<usize, Running>,
    /// What finished tasks took, by method and point MDP.
    finished: Vec<(String, String, Seen)>,
    workers: usize,
    /// How much longer everything takes when workers share processors.
    crowding: f64,
}

impl Forecast {
    /// Returns the forecast of tasks in the order in which so many workers get them, on so many
    /// processors.
    pub(super) fn new(jobs: Vec<Job>, workers: usize, processors: usize) -> Self {
        let workers = workers.min(jobs.len()).max(1);
        let crowding = (workers as f64 / processors.max(1) as f64).max(1.0);
        let waiting = jobs.into();
        let running = BTreeMap::new();
        let mut forecast = Self { waiting, running, finished: Vec::new(), workers, crowding };
        (0..workers).for_each(|_| forecast.start(0.0));
        forecast
    }

    fn start(&mut self, now_s: f64) {
        if let Some(job) = self.waiting.pop_front() {
            self.running.insert(job.task, Running { job, start_s: now_s, before: 0, done: None });
        }
    }

    /// Takes note of the episodes that a task has done.
    pub(super) fn episode(&mut self, task: usize, episodes: u32, now_s: f64) {
        if let Some(running) = self.running.get_mut(&task) {
            if running.done.is_none() {
                running.before = episodes.saturating_sub(1);
            }
            running.done = Some((episodes, now_s));
        }
    }

    /// Takes note of a task that starts again.
    pub(super) fn retry(&mut self, task: usize, now_s: f64) {
        if let Some(running) = self.running.get_mut(&task) {
            (running.start_s, running.before, running.done) = (now_s, 0, None);
        }
    }

    /// Takes note of a task that is finished; what it took counts if it went well.
    pub(super) fn finish(&mut self, task: usize, well: bool, now_s: f64) {
        let Some(running) = self.running.remove(&task) else { return };
        if well {
            let seen = running.seen(running.job.all(), now_s);
            self.finished.push((running.job.method, running.job.point, seen));
        }
        self.start(now_s);
    }

    /// Returns what has been seen, by method and point MDP.
    fn seen(&self) -> Vec<(&str, &str, Seen)> {
        let finished = self.finished.iter().map(|(m, p, seen)| (&**m, &**p, *seen));
        let running = self.running.values().filter_map(|r| {
            let (episodes, at_s) = r.done?;
            let seen = r.seen(r.job.seconds(episodes), at_s);
            Some((&*r.job.method, &*r.job.point, seen))
        });
        finished.chain(running).collect()
    }

    /// Returns the shortest and the longest time that the run may still take.
    pub(super) fn left(&self, now_s: f64) -> [Duration; 2] {
        let seen = self.seen();
        let sum = |of: &Share<'_>| {
            seen.iter().fold(Seen::default(), |sum, one| match of(one) {
                None => sum,
                Some(by) => Seen {
                    observed_s: sum.observed_s + one.2.observed_s,
                    expected_s: sum.expected_s + one.2.expected_s * by,
                },
            })
        };
        let crowding = self.crowding;
        let machine = crowding * sum(&|_| Some(crowding)).factor(1.0);
        let of_method =
            |method: &str| machine * sum(&|(m, ..)| (*m == method).then_some(machine)).factor(1.0);
        let known: BTreeSet<&str> = seen.iter().map(|(method, ..)| *method).collect();
        let methods: BTreeMap<&str, f64> =
            known.into_iter().map(|method| (method, of_method(method))).collect();
        let speed = |method: &str| methods.get(method).copied().unwrap_or(machine);
        let mut points: HashMap<&str, Seen> = HashMap::new();
        for (method, point, one) in &seen {
            let sum = points.entry(point).or_default();
            sum.observed_s += one.observed_s;
            sum.expected_s += one.expected_s * speed(method);
        }
        let of_point = |point: &str| points.get(point).copied().unwrap_or_default().factor(1.0);
        let price = |job: &Job| speed(&job.method) * of_point(&job.point);
        let rest = |r: &Running| {
            let (episodes, at_s) = r.done.unwrap_or((0, r.start_s));
            let expected = r.job.all() - r.done.map_or(0.0, |_| r.job.seconds(episodes));
            (expected * price(&r.job) - (now_s - at_s)).max(0.0)
        };
        let mut busy: Vec<f64> = self.running.values().map(rest).collect();
        busy.resize(busy.len().max(self.workers), 0.0);
        for job in &self.waiting {
            let first = busy.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
            let first = first.map_or(0, |(worker, _)| worker);
            busy[first] += job.all() * price(job);
        }
        let left = busy.into_iter().fold(0.0, f64::max);
        let tasks = (seen.len() as f64).sqrt();
        let error = LEAST_ERROR + (ERROR - LEAST_ERROR) / (1.0 + tasks);
        // Congested intersections come late, and cost more than was seen: the upper end is farther.
        [-0.8, 1.2].map(|side| Duration::from_secs_f64(left * (side * error).exp()))
    }
}

/// Returns a range of time for people: `4 to 7 min`, `20 to 35 s`.
pub(super) fn range([low, high]: [Duration; 2]) -> String {
    let (low, high) = (low.as_secs_f64(), high.as_secs_f64());
    let (unit, name, step) = if high <= MAX_IN_UNIT {
        (1.0, "s", if high > 20.0 { 5.0 } else { 1.0 })
    } else if high <= MAX_IN_UNIT * 60.0 {
        (
            60.0,
            "min",
            if high > 1200.0 {
                5.0
            } else if high > 300.0 {
                1.0
            } else {
                0.5
            },
        )
    } else {
        (3600.0, "h", if high > 36_000.0 { 1.0 } else { 0.5 })
    };
    let low = (low / unit / step).floor() * step;
    let high = (high / unit / step).ceil() * step;
    match (low == high, low == 0.0) {
        (true, _) => format!("{low} {name}"),
        // Less than a step is no time of its own.
        (false, true) => format!("up to {high} {name}"),
        (false, false) => format!("{low} to {high} {name}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::testing::effort;
    use crate::run::effort::SECONDS_PER_TASK;

    fn job(task: usize, method: &str, point: &str, seconds: f64) -> Job {
        let effort = effort((0, 0.0), (1, seconds - SECONDS_PER_TASK));
        Job { task, method: method.into(), point: point.into(), effort }
    }

    /// The middle of a forecast.
    fn middle(forecast: &Forecast, now_s: f64) -> f64 {
        let [low, high] = forecast.left(now_s).map(|d| d.as_secs_f64().ln());
        // The sides are unequal.
        (low + (high - low) * 0.4).exp()
    }

    #[test]
    fn the_longest_worker_counts() {
        let jobs = vec![job(0, "a", "p", 10.0), job(1, "a", "q", 10.0), job(2, "b", "q", 60.0)];
        let close = |left: f64, expected: f64| (left - expected).abs() < 1e-6;
        assert!(close(middle(&Forecast::new(jobs.clone(), 2, 2), 0.0), 70.0));
        assert!(close(middle(&Forecast::new(jobs.clone(), 9, 9), 0.0), 60.0));
        // Two workers on one processor take as long as one.
        assert!(close(middle(&Forecast::new(jobs[..2].to_vec(), 2, 1), 0.0), 20.0));
    }

    #[test]
    fn what_tasks_took_changes_what_others_like_them_will() {
        let points = ["p", "q", "r", "s"];
        let jobs: Vec<Job> =
            (0..8).map(|i| job(i, ["a", "b"][i % 2], points[i / 2], 30.0)).collect();
        let mut forecast = Forecast::new(jobs, 1, 1);
        assert!((middle(&forecast, 0.0) - 240.0).abs() < 1e-6);
        forecast.finish(0, true, 30.0);
        // The second method takes three times as long as expected.
        forecast.finish(1, true, 120.0);
        let left = middle(&forecast, 120.0);
        assert!((300.0..420.0).contains(&left), "{left}");
        let of = |forecast: &Forecast| {
            let [low, high] = forecast.left(120.0).map(|d| d.as_secs_f64());
            high / low
        };
        let early = of(&forecast);
        for task in 2..6 {
            let now_s = 120.0 + 30.0 * f64::from(u32::try_from(task).unwrap());
            forecast.finish(task, true, now_s);
        }
        assert!(of(&forecast) < early, "more is known");
    }

    #[test]
    fn episodes_of_an_earlier_attempt_took_no_time() {
        let jobs =
            [0, 1].map(|i| Job { effort: effort((100, 10.0), (1, 10.0)), ..job(i, "a", "p", 1.0) });
        let mut forecast = Forecast::new(jobs.to_vec(), 1, 1);
        let expected = middle(&forecast, 0.0);
        // It goes on from episode 79, and takes what was expected of one more.
        forecast.episode(0, 80, SECONDS_PER_TASK + 10.0);
        let left = middle(&forecast, SECONDS_PER_TASK + 10.0);
        assert!(
            (left - (expected - SECONDS_PER_TASK - 800.0)).abs() < 1e-6,
            "{left} of {expected}"
        );
        forecast.finish(0, true, SECONDS_PER_TASK + 220.0);
        let left = middle(&forecast, SECONDS_PER_TASK + 220.0);
        assert!((left - expected / 2.0).abs() < 1e-6, "{left} of {expected}");
    }

    #[test]
    fn a_task_in_progress_tells_of_itself() {
        let long = Job { effort: effort((9, 10.0), (1, 10.0)), ..job(0, "a", "p", 1.0) };
        let mut forecast = Forecast::new(vec![long], 1, 1);
        // Half of it took twice the time that was expected.
        forecast.episode(0, 1, 20.4);
        forecast.episode(0, 5, 100.4);
        let left = middle(&forecast, 100.4);
        assert!((85.0..100.0).contains(&left), "{left}");
        forecast.retry(0, 100.4);
        assert!((middle(&forecast, 100.4) - 100.2).abs() < 1e-6);
        forecast.finish(0, false, 120.0);
        assert_eq!(forecast.left(120.0), [Duration::ZERO; 2]);
    }

    #[test]
    fn a_range_has_one_unit() {
        let text = |low, high| range([low, high].map(Duration::from_secs));
        assert_eq!(text(0, 0), "0 s");
        assert_eq!(text(3, 7), "3 to 7 s");
        assert_eq!(text(22, 48), "20 to 50 s");
        assert_eq!(text(100, 170), "1.5 to 3 min");
        assert_eq!(text(250, 410), "4 to 7 min");
        assert_eq!(text(3000, 5000), "50 to 85 min");
        assert_eq!(text(5000, 9000), "1 to 2.5 h");
    }
}
