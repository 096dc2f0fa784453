//! Proximal policy optimisation (Schulman et al., 2017), as Stable-Baselines3's `PPO`.
//!
//! Choices where implementations differ:
//! - **Networks**: policy and value apart, hyperbolic tangents, orthogonal weights (gains √2, 0.01 and 1).
//! - **Loss**: clipped surrogate, plus the squared error of the value (not halved, not clipped), less the
//!   entropy; the gradient of both networks together is cut to a norm.
//! - **Advantages** are standardised per minibatch, with the unbiased deviation.
//! - **Minibatches** come from one permutation per pass; the last one may be smaller.
//! - **A cut episode** has the value of the state after it.

mod loss;
mod rollout;
mod settings;

use rand::seq::SliceRandom;

use self::loss::{Losses, Minibatch};
use self::rollout::Rollout;
pub use self::settings::Settings;
use super::actor_critic::ActorCritic;
use super::lanes::Lanes;
use super::{Progress, Schedule, Trainer, largest};
use crate::nn::archive::{Archive, ArchiveError};
use crate::rl::environment::Environment;
use crate::rl::persist::depends_on_both;
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
    /// Logarithms of the probabilities of the actions in one state.
    logs: Vec<f32>,
    /// State after a step.
    after: Vec<f32>,
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
            rollout: Rollout::new(lanes.count(), settings.num_steps, width),
            order: Vec::new(),
            minibatch: Minibatch::default(),
            logs: vec![0.0; actions],
            after: vec![0.0; width],
            lanes,
            settings,
        }
    }

    /// Plays the steps of an update.
    fn collect(&mut self, seeds: &mut dyn FnMut(u32) -> u64) {
        self.lanes.begin(seeds);
        self.rollout.clear();
        for time in 0..self.settings.num_steps {
            for lane in 0..self.lanes.count() {
                let state = self.lanes.observation(lane);
                let place = self.rollout.place(lane, time);
                self.rollout.see(place, state);
                loss::log_softmax(self.networks.logits(state), &mut self.logs);
                let action = draw(&self.logs, &mut self.sampling);
                let step = self.lanes.step(lane, action, &mut self.after, seeds);
                self.rollout.act(place, action, self.logs[action], step, &self.after);
                self.steps += 1;
            }
        }
        for lane in 0..self.lanes.count() {
            self.rollout.cut(lane, self.lanes.observation(lane));
        }
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
                let (logits, values) = self.networks.forward(&self.minibatch.states);
                self.minibatch.loss(logits, values, &self.settings, clip_range, losses);
                let Minibatch { states, by_logits, by_values, .. } = &self.minibatch;
                let max_grad_norm = self.settings.max_grad_norm;
                self.networks.descend(states, by_logits, by_values, learning_rate, max_grad_norm);
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

    fn act(&mut self, observation: &[f32]) -> usize {
        largest(self.networks.logits(observation))
    }

    fn is_finite(&self) -> bool {
        self.networks.is_finite()
    }

    fn is_alive(&mut self) -> bool {
        let states = self.rollout.probes();
        let (logits, _) = self.networks.forward(&states);
        depends_on_both(logits, self.logs.len())
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

/// Draws an action from the logarithms of probabilities.
fn draw(logs: &[f32], generator: &mut Generator) -> usize {
    let mut left = generator.unit() as f32;
    for (action, log) in logs.iter().enumerate() {
        left -= libm::expf(*log);
        if left < 0.0 {
            return action;
        }
    }
    // Rounding may leave a trace: the last action that can happen.
    logs.iter().rposition(|log| *log > f32::NEG_INFINITY).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Corridor, check_trainer, play};
    use super::*;

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
        check_trainer(trainer);
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

    #[test]
    fn actions_are_drawn_as_often_as_they_are_likely() {
        let mut generator = Generator::new(1, &[]);
        let logs = [0.25f32.ln(), 0.75f32.ln()];
        let count = (0..10_000).filter(|_| draw(&logs, &mut generator) == 1).count();
        assert!((7350..7650).contains(&count), "{count}");
    }
}
