//! A control task as a domain of evaluation.

use std::marker::PhantomData;

use serde_json::{Map, Value};

use crate::context;
use crate::episodes::{Dynamics, Episodes};
use crate::methods::Begin;
use crate::task::scenario::Settings;
use crate::task::{Scale, Task};
use basics::seed;
use evaluation::run::domain::{Course, Domain, Effort, EffortOf, Objective, Played, Site, Trial};
use evaluation::run::fault::TrialError;
use evaluation::run::method::Method;
use evaluation::stats::Limit;
use evaluation::store::record::Metrics;
use learners::nn::archive::Archive;
use learners::rl::environment::{Environment, play};
use learners::rl::sb3::{Progress, Trainer};

/// A control task, judged by its objective.
#[derive(Debug, Clone, Copy, Default)]
pub struct TaskDomain<T>(pub(crate) PhantomData<T>);

impl<T: Task> Domain for TaskDomain<T> {
    fn name(&self) -> &'static str {
        T::NAME
    }

    fn objective(&self) -> Objective {
        T::OBJECTIVE
    }

    fn baseline(&self) -> Option<&'static str> {
        None
    }

    fn training_row(&self) -> (&'static str, &'static str) {
        let about = "A part of a training is 2,000 steps, or one update where that takes more; its figures are \
                     means over the episodes that ended in it.";
        ("part", about)
    }

    fn failure(&self) -> Option<Limit> {
        let (side, value) = T::FAILURE;
        Some(Limit { metric: T::OBJECTIVE.metric.to_owned(), side, value })
    }

    fn methods(&self) -> &[Method] {
        T::Scenario::METHODS
    }

    fn trial(
        &self,
        site: &Site<'_>,
        method: &str,
        seed: u64,
    ) -> Result<Box<dyn Trial>, TrialError> {
        T::simulator().map_err(TrialError::Simulator)?;
        let input = |message: String| TrialError::Input(message.into());
        let scenario = scenario_of::<T>(site.settings).map_err(input)?;
        let context = context::parse::<T>(&site.point.environment).map_err(|e| {
            input(format!("manifest.json: environment of {}: {e}", site.point.point))
        })?;
        let environment = Episodes::of(T::dynamics(&scenario, &context));
        let trial = TaskTrial::<T>::new(environment, &scenario, method, seed);
        let trial = trial.ok_or_else(|| input(format!("there is no method {method:?}")))?;
        Ok(Box::new(trial))
    }

    fn efforts(&self, settings: &Value) -> Result<Box<EffortOf>, String> {
        let scenario = scenario_of::<T>(settings)?;
        let default: Vec<f64> = T::FEATURES.iter().map(|f| f.default).collect();
        let environment = Episodes::of(T::dynamics(&scenario, &default));
        let numbers = environment.width() + environment.actions().outputs();
        Ok(Box::new(move |method, _, _| {
            let steps = scenario.total_steps(method.name).unwrap_or_default();
            let work = scenario.work(method.name, numbers).unwrap_or_default();
            let row_steps = row_steps(steps);
            Effort {
                training: u32::try_from(steps.div_ceil(row_steps)).unwrap_or(u32::MAX),
                training_s: row_steps as f64 * method.decision_s * work,
                evaluation: 0,
                evaluation_s: f64::from(T::Dynamics::HORIZON) * T::STEP_S,
                is_informed: true,
            }
        }))
    }

    fn card(&self, settings: &Value, method: &str) -> Result<Map<String, Value>, String> {
        let mut card = Map::new();
        let all = serde_json::to_value(scenario_of::<T>(settings)?).map_err(|e| e.to_string())?;
        for (name, key) in
            [("settings", method), ("preset", "preset"), ("environment", "environment")]
        {
            let value = all.get(key).cloned();
            let value = value.ok_or_else(|| format!("the scenario has no settings of {key}"))?;
            card.insert(name.to_owned(), value);
        }
        Ok(card)
    }
}

fn scenario_of<T: Task>(settings: &Value) -> Result<T::Scenario, String> {
    serde_json::from_value(settings.clone()).map_err(|e| format!("manifest.json: settings: {e}"))
}

/// Returns the steps of training that a row of the record stands for, in a training of so many steps: a fiftieth, but 2,000
/// at most. A row may have a few more, because an update is not cut.
/// So also a short training has rows enough for validation to choose among its policies.
fn row_steps(total_steps: u64) -> u64 {
    (total_steps / 50).clamp(1, 2000)
}

struct TaskTrial<T: Task> {
    environment: Episodes<T::Dynamics>,
    scale: Scale,
    seed: u64,
    row_steps: u64,
    begin: Box<Begin>,
    trainer: Box<dyn Trainer>,
}

impl<T: Task> TaskTrial<T> {
    fn new(
        environment: Episodes<T::Dynamics>,
        scenario: &T::Scenario,
        method: &str,
        seed: u64,
    ) -> Option<Self> {
        let begin = scenario.begin(method, environment.clone())?;
        let trainer = begin(seed);
        let row_steps = row_steps(scenario.total_steps(method)?);
        Some(Self { scale: T::scale(&environment), environment, seed, row_steps, begin, trainer })
    }

    /// Returns the row of a part of a training; objective and return are those of the episodes that ended in it, with
    /// the actions of training.
    fn row(&self, progress: &Progress) -> Metrics {
        let Progress { steps, episodes, mean_return, mean_score, loss, entropy, epsilon, begun: _ } =
            *progress;
        named([
            ("return", mean_return),
            (T::OBJECTIVE.metric, mean_score.map(|score| scaled(&self.scale, score))),
            ("episodes", Some(f64::from(episodes))),
            ("steps", Some(steps as f64)),
            ("loss", loss.filter(|l| l.is_finite())),
            ("entropy", entropy.filter(|e| e.is_finite())),
            ("epsilon", epsilon),
        ])
    }
}

impl<T: Task> Trial for TaskTrial<T> {
    fn train(&mut self, course: &mut dyn Course) -> Result<(), TrialError> {
        if let Some(saved) = course.saved() {
            self.trainer = (self.begin)(seed::restart(self.seed, course.restarts()));
            self.trainer.restore("", &saved).map_err(TrialError::Model)?;
        }
        while !course.stops() && !self.trainer.finished() {
            let steps = self.trainer.steps() + self.row_steps;
            let progress = self.trainer.advance(steps, &mut |k| course.seed(k));
            // That of the episode that began last, in this part or before.
            let seed = course.seed(progress.begun.saturating_sub(1));
            course.episode(seed, self.row(&progress));
            let finite = progress.loss.is_none_or(f64::is_finite);
            if !finite || !self.trainer.is_finite() {
                let what = if finite { "a parameter" } else { "the loss" };
                return Err(TrialError::Diverged(format!(
                    "training diverged before step {}: {what} is no number any more; try a smaller \
                     learning rate",
                    progress.steps
                )));
            }
            if course.starts_again(progress.loss.is_none() || self.trainer.is_alive()) {
                self.trainer = (self.begin)(seed::restart(self.seed, course.restarts()));
                continue;
            }
            // Acting draws nothing at random, and the training's own environments are others.
            course.validate(&mut Played(self))?;
            let trainer = &self.trainer;
            course.checkpoint(
                &|| {
                    let mut archive = Archive::default();
                    trainer.save("", &mut archive);
                    archive
                },
                0.0,
            )?;
        }
        Ok(())
    }

    fn episode(&mut self, seed: u64) -> Result<Metrics, TrialError> {
        let Self { environment, trainer, scale, .. } = self;
        let outcome =
            play(environment, seed, &mut |observation, action| trainer.act(observation, action));
        let [zero, one] = scale.names.unwrap_or_default();
        Ok(named([
            ("return", Some(outcome.total)),
            (T::OBJECTIVE.metric, Some(scaled(scale, outcome.score))),
            (zero, scale.names.map(|_| scale.zero)),
            (one, scale.names.map(|_| scale.one)),
        ]))
    }

    fn model(&self) -> Option<Archive> {
        let mut archive = Archive::default();
        self.trainer.learned("", &mut archive);
        Some(archive)
    }

    fn load(&mut self, model: &Archive) -> Result<(), TrialError> {
        self.trainer.load("", model).map_err(TrialError::Model)
    }
}

fn named<const N: usize>(metrics: [(&str, Option<f64>); N]) -> Metrics {
    metrics.into_iter().filter_map(|(name, value)| Some((name.to_owned(), value?))).collect()
}

fn scaled(scale: &Scale, score: f64) -> f64 {
    (score - scale.zero) / (scale.one - scale.zero)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cartpole::{CARL_START, CartPole, CartPoles, Context, Dynamics, Scenario, Variant};
    use crate::methods::{dqn, ppo, trpo};
    use evaluation::run::fault::CheckpointError;

    #[derive(Default)]
    struct Kept {
        saved: Option<Archive>,
        rows: Vec<(u64, Metrics)>,
        states: Vec<Archive>,
        stops: bool,
    }

    impl Course for Kept {
        fn seed(&self, index: u32) -> u64 {
            1000 + u64::from(index)
        }
        fn episode(&mut self, seed: u64, metrics: Metrics) {
            self.rows.push((seed, metrics));
        }
        fn saved(&mut self) -> Option<Archive> {
            self.saved.take()
        }
        fn stops(&self) -> bool {
            self.stops
        }
        fn checkpoint(
            &mut self,
            state: &dyn Fn() -> Archive,
            _: f64,
        ) -> Result<(), CheckpointError> {
            self.states.push(state());
            Ok(())
        }
    }

    fn trial(method: &str, settings: &[&str]) -> TaskTrial<CartPoles> {
        let dynamics = Dynamics::new(Context::default(), Variant::CarlCompat);
        let short = [
            "ppo.total_steps=6000", "dqn.total_steps=6000", "trpo.total_steps=6000",
            "ppo.num_steps=500", "trpo.num_steps=500",
        ];
        let overrides: Vec<_> = short.iter().chain(settings).map(|s| s.parse().unwrap()).collect();
        let scenario = Scenario::read("", "a.toml", &overrides).unwrap();
        TaskTrial::new(CartPole::new(dynamics, CARL_START), &scenario, method, 7).unwrap()
    }

    #[test]
    fn a_row_is_a_fiftieth_of_a_training_but_2000_steps_at_most() {
        assert_eq!([1, 10_000, 100_000, 5_000_000].map(row_steps), [1, 200, 2000, 2000]);
    }

    fn some<T>(all: &[T]) -> impl Iterator<Item = (usize, &T)> {
        all.iter().enumerate().step_by(all.len().div_ceil(5))
    }

    #[test]
    fn a_training_has_its_rows_and_goes_on_from_them_with_the_same_bytes() {
        for method in [ppo::METHOD.name, dqn::METHOD.name, trpo::METHOD.name] {
            let (mut whole, mut kept) = (trial(method, &[]), Kept::default());
            whole.train(&mut kept).unwrap();
            let steps: Vec<f64> = kept.rows.iter().map(|(_, m)| m["steps"]).collect();
            // An update of the methods with a rollout is 500 steps.
            let of_row = if method == dqn::METHOD.name { 120.0 } else { 500.0 };
            let expected: Vec<f64> =
                (1..=(6000.0 / of_row) as u32).map(|i| f64::from(i) * of_row).collect();
            assert_eq!(steps, expected, "{method}");
            for (seed, metrics) in &kept.rows {
                assert!(*seed >= 1000 && metrics["episodes"] > 0.0);
                assert_eq!(metrics["normalised_return"], metrics["return"] / 500.0);
                assert!(metrics.iter().all(|(_, v)| v.is_finite()));
            }
            let model = whole.model().unwrap();
            for (i, state) in some(&kept.states) {
                let mut rest = Kept { saved: Some(state.clone()), ..Kept::default() };
                let mut resumed = trial(method, &[]);
                resumed.train(&mut rest).unwrap();
                assert!(resumed.model().unwrap().to_bytes() == model.to_bytes());
                assert_eq!(rest.rows, kept.rows[i + 1..]);
            }
            let state = kept.states[1].clone();
            let mut stopped = trial(method, &[]);
            let mut none = Kept { saved: Some(state), stops: true, ..Kept::default() };
            stopped.train(&mut none).unwrap();
            assert!(
                none.rows.is_empty(),
                "what was kept where the training stops early is not trained further"
            );
            assert!(stopped.model().unwrap().to_bytes() != model.to_bytes());
            let mut loaded = trial(method, &[]);
            loaded.load(&model).unwrap();
            assert_eq!(loaded.episode(3).unwrap(), whole.episode(3).unwrap());
        }
    }

    #[test]
    fn a_score_is_between_that_of_the_random_and_of_the_solved_policy() {
        use crate::pendulum::{Pendulums, Scenario};
        let scenario = Scenario::default();
        let environment = Episodes::of(Pendulums::dynamics(&scenario, &[1.0, 1.0, 10.0]));
        let mut trial = TaskTrial::<Pendulums>::new(environment, &scenario, "sac", 7).unwrap();
        let metrics = trial.episode(3).unwrap();
        let (random, solved) = (metrics["random_return"], metrics["solved_return"]);
        let score = (metrics["return"] - random) / (solved - random);
        assert_eq!(metrics["normalised_return"], score);
    }

    #[test]
    fn a_training_that_diverges_says_when_and_what_to_do() {
        let mut trial =
            trial(ppo::METHOD.name, &["ppo.learning_rate=1.0", "ppo.max_grad_norm=1e9"]);
        let mut archive = trial.model().unwrap();
        let name = "policy.layer0.bias";
        archive.put_f32(name, &[64], &[f32::INFINITY; 64]);
        assert!(trial.load(&archive).is_err(), "a model of a training that diverged is refused");
        let mut state = Archive::default();
        trial.trainer.save("", &mut state);
        let count = 2 * (5 * 64 + 65 * 64) + 65 * 3;
        state.put_f32("parameters", &[count], &vec![f32::NAN; count]);
        let mut kept = Kept { saved: Some(state), ..Kept::default() };
        let e = trial.train(&mut kept).unwrap_err();
        let expected = "training diverged before step 500: the loss is no number any more; try a \
                        smaller learning rate";
        assert!(matches!(&e, TrialError::Diverged(text) if text == expected), "{e}");
        assert!(kept.states.is_empty());
    }
}
