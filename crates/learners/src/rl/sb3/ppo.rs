//! Proximal policy optimisation (Schulman et al., 2017), as Stable-Baselines3's `PPO`.
//!
//! Choices where implementations differ:
//! - **Networks**: policy and value apart, hyperbolic tangents, orthogonal weights (gains √2, 0.01 and 1).
//! - **Loss**: clipped surrogate, plus the squared error of the value (not halved, not clipped), less the
//!   entropy; the gradient of both networks together is cut to a norm.
//! - **Advantages** are standardised per minibatch, with the unbiased deviation.
//! - **Minibatches** come from one permutation per pass; the last one may be smaller.
//! - **A cut episode** has the value of the state after it.

pub(super) mod loss;
mod settings;

use rand::seq::SliceRandom;

use self::loss::{Losses, Minibatch};
pub use self::settings::Settings;
use super::actor_critic::ActorCritic;
use super::lanes::Lanes;
use super::rollout::Rollout;
use super::{Progress, Schedule, Trainer};
use crate::nn::archive::{Archive, ArchiveError};
use crate::rl::environment::Environment;
use crate::rl::random::Generator;

/// A training of a policy and its value.
#[derive(Debug, Clone)]
pub struct Ppo<E> {
    settings: Settings,
    networks: ActorCritic,
    lanes: Lanes<E>,
    sampling: Generator,
    shuffling: Generator,
    steps: u64,
    rollout: Rollout,
    order: Vec<usize>,
    minibatch: Minibatch,
}

impl<E: Environment> Ppo<E> {
    /// Returns a training that has not begun; `environment` makes the environments side by side.
    pub fn new(settings: Settings, environment: impl Fn() -> E, seed: u64) -> Self {
        let lanes = Lanes::new((0..settings.environments.max(1)).map(|_| environment()).collect());
        let (width, actions) = (lanes.width(), lanes.actions());
        Self {
            networks: ActorCritic::new(
                width,
                actions,
                settings.hidden,
                settings.adam_epsilon,
                seed,
            ),
            sampling: Generator::new(seed, &["sampling"]),
            shuffling: Generator::new(seed, &["shuffling"]),
            steps: 0,
            rollout: Rollout::new(lanes.count(), settings.num_steps, width, actions.width()),
            order: Vec::new(),
            minibatch: Minibatch::new(actions),
            lanes,
            settings,
        }
    }

    /// Plays the steps of an update.
    fn collect(&mut self, seeds: &mut dyn FnMut(u32) -> u64) {
        self.rollout.collect(&mut self.networks, &mut self.lanes, &mut self.sampling, seeds);
        self.steps += self.rollout.len() as u64;
    }

    /// Learns from the steps of an update.
    fn update(&mut self, losses: &mut Losses) {
        let Settings { total_steps, gamma, gae_lambda, .. } = self.settings;
        let at = |schedule: Schedule, start| schedule.at(start, self.steps, total_steps);
        let learning_rate = at(self.settings.learning_rate_schedule, self.settings.learning_rate);
        let clip_range = at(self.settings.clip_range_schedule, self.settings.clip_range);
        self.rollout.estimate(&mut self.networks, gamma, gae_lambda);
        let mut order = std::mem::take(&mut self.order);
        order.clear();
        order.extend(0..self.rollout.len());
        for _ in 0..self.settings.update_epochs {
            order.shuffle(self.shuffling.rng());
            for places in order.chunks(self.settings.minibatch_size) {
                self.minibatch.gather(&self.rollout, places);
                let outputs = self.networks.forward(&self.minibatch.states);
                self.minibatch.loss(outputs, &self.settings, clip_range, losses);
                let Minibatch { states, by_outputs, by_log_std, by_values, .. } = &self.minibatch;
                let max_grad_norm = self.settings.max_grad_norm;
                self.networks.back(states, by_outputs, by_log_std, by_values);
                self.networks.descend(learning_rate, max_grad_norm);
            }
        }
        self.order = order;
    }
}

impl<E: Environment> Trainer for Ppo<E> {
    fn advance(&mut self, steps: u64, seeds: &mut dyn FnMut(u32) -> u64) -> Progress {
        let mut losses = Losses::default();
        while !self.finished() && self.steps < steps {
            self.collect(seeds);
            self.update(&mut losses);
        }
        let (loss, entropy) = losses.means();
        Progress { steps: self.steps, loss, entropy, ..self.lanes.report() }
    }

    fn steps(&self) -> u64 {
        self.steps
    }

    fn finished(&self) -> bool {
        self.steps >= self.settings.total_steps
    }

    fn act(&mut self, observation: &[f32], action: &mut [f32]) {
        self.networks.best(observation, action);
    }

    fn is_finite(&self) -> bool {
        self.networks.is_finite()
    }

    fn is_alive(&mut self) -> bool {
        let states = self.rollout.probes();
        self.networks.is_alive(&states)
    }

    fn learned(&self, prefix: &str, archive: &mut Archive) {
        self.networks.learned(prefix, archive);
    }

    fn load(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        self.networks.load(prefix, archive)
    }

    fn save(&self, prefix: &str, archive: &mut Archive) {
        archive.put(&format!("{prefix}steps"), self.steps);
        self.networks.save(prefix, archive);
        self.sampling.save(&format!("{prefix}sampling"), archive);
        self.shuffling.save(&format!("{prefix}shuffling"), archive);
        self.lanes.save(prefix, archive);
    }

    fn restore(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        self.steps = archive.get(&format!("{prefix}steps"))?;
        self.networks.restore(prefix, archive)?;
        self.sampling.restore(&format!("{prefix}sampling"), archive)?;
        self.shuffling.restore(&format!("{prefix}shuffling"), archive)?;
        self.lanes.restore(prefix, archive)
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Corridor, Slider, check_trainer, outcome, play, updates};
    use super::*;
    use crate::rl::environment::Actions;

    fn settings() -> Settings {
        Settings {
            total_steps: 6000,
            environments: 3,
            num_steps: 43,
            minibatch_size: 32,
            update_epochs: 10,
            learning_rate: 3e-3,
            learning_rate_schedule: Schedule::Linear,
            adam_epsilon: 1e-5,
            gamma: 0.9,
            gae_lambda: 0.95,
            clip_range: 0.2,
            clip_range_schedule: Schedule::Linear,
            entropy_coefficient: 0.0,
            value_coefficient: 0.5,
            max_grad_norm: 0.5,
            hidden: 32,
        }
    }

    fn trainer(seed: u64) -> Ppo<Corridor> {
        Ppo::new(settings(), Corridor::default, seed)
    }

    #[test]
    fn a_corridor_is_learned_to_its_exact_values() {
        let mut ppo = trainer(3);
        ppo.advance(u64::MAX, &mut |k| u64::from(k));
        assert_eq!(play(&mut ppo), 4);
        for state in 0..4 {
            let value = ppo.networks.values(&Corridor::one_hot(state))[0];
            let exact = 0.9f32.powi(3 - state as i32);
            assert!((value - exact).abs() < 0.1, "{state}: {value}, {exact}");
        }
    }

    #[test]
    fn a_training_can_stop_after_every_update() {
        check_trainer(&Corridor::default(), trainer);
        check_trainer(&Slider::default(), |seed| Ppo::new(settings(), Slider::default, seed));
    }

    #[test]
    fn a_slider_is_learned() {
        let mut ppo = Ppo::new(Settings { total_steps: 20_000, ..settings() }, Slider::default, 3);
        ppo.advance(u64::MAX, &mut |k| u64::from(k));
        let total = outcome(&Slider::default(), &mut ppo);
        // The best is about -1.03.
        assert!(total > -1.2, "{total}");
    }

    #[test]
    fn a_gradient_step_is_that_of_stable_baselines3() {
        let all = updates();
        for (name, actions) in [
            ("ppo-numbered", Actions::Numbered(2)),
            ("ppo-continuous", Actions::Continuous { count: 2, limit: 1.0 }),
        ] {
            let update = &all[name];
            let settings =
                Settings { entropy_coefficient: 0.2, max_grad_norm: 0.3, hidden: 5, ..settings() };
            let mut networks = ActorCritic::new(3, actions, 5, 1e-5, 1);
            networks.parameters = update.numbers("before");
            let mut minibatch = Minibatch::of(
                actions,
                ["states", "actions", "logs", "advantages", "returns"]
                    .map(|part| update.numbers(part)),
            );
            let outputs = networks.forward(&minibatch.states);
            minibatch.loss(outputs, &settings, 0.2, &mut Losses::default());
            let Minibatch { states, by_outputs, by_log_std, by_values, .. } = &minibatch;
            networks.back(states, by_outputs, by_log_std, by_values);
            networks.descend(0.01, settings.max_grad_norm);
            update.check("then", &networks.parameters, 1e-5);
        }
    }

    #[test]
    fn an_update_takes_every_step_once_per_pass() {
        // 3 * 43 = 129 steps: four minibatches of 32 and one of a single step, ten times.
        let mut ppo = trainer(3);
        let mut losses = Losses::default();
        ppo.collect(&mut |k| u64::from(k));
        ppo.update(&mut losses);
        assert_eq!((ppo.steps, losses.count()), (129, 50));
        let mut order = ppo.order.clone();
        order.sort_unstable();
        assert!(order.iter().copied().eq(0..129));
        assert!(ppo.is_finite());
    }
}
