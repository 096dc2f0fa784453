//! Soft actor-critic (Haarnoja et al., 2018), as Stable-Baselines3's `SAC`.
//!
//! Choices where implementations differ, beside those of `off_policy.rs`:
//! - **Policy**: one network gives mean and logarithm of the deviation of a normal number per action, the logarithm cut
//!   to -20..2; its hyperbolic tangent is the action. The density has 1e-6 added where it is divided by.
//! - **Critics**: half the mean squared error each, towards the smaller target value less the entropy's cost.
//! - **Entropy coefficient**: learned in its logarithm, towards an entropy of minus the number of actions; the losses of an
//!   update use the coefficient from before the update. With [`Settings::learned_entropy_coefficient`] off it is fixed.
//! - **Order**: coefficient, critics, policy (against the critics just moved), targets.

use basics::setting::settings;

use super::off_policy::{Batch, Critics, Learner, OffPolicy, Play, followed, network};
use crate::nn::Activation;
use crate::nn::adam::Adam;
use crate::nn::sequential::Sequential;
use crate::nn::state::{Learned, State, kept};
use crate::rl::Followed;
use crate::rl::environment::Environment;
use crate::rl::random::Generator;

/// Range of the logarithm of a deviation.
const LOG_STD: [f32; 2] = [-20.0, 2.0];

/// Added to what the density of an action is divided by.
const DENSITY_EPSILON: f32 = 1e-6;

/// Half the logarithm of 2 pi.
const HALF_LOG_TAU: f32 = 0.918_938_5;

settings! {
    /// Hyper-parameters of `sac`; the defaults are those of Stable-Baselines3.
    pub struct Settings extends Play, source "Stable-Baselines3 2.9, SAC" {
        /// Steps of the training.
        total_steps: u64 = 20_000, in 1.0..=1e9, unit "steps",
            source "rl-baselines3-zoo 2.9 for Pendulum-v1";
        /// Step size of Adam, for policy, critics and entropy coefficient.
        learning_rate: f32 = 3e-4, in 1e-8..=1.0;
        /// Adam's epsilon, added to the root of the second moment.
        adam_epsilon: f32 = 1e-8, in 1e-12..=1.0;
        /// Discount per step.
        gamma: f32 = 0.99, in 0.0..=1.0;
        /// Share by which the slow copies follow at each update.
        tau: f32 = 0.005, in 1e-6..=1.0;
        /// Steps in the replay buffer.
        buffer_size: usize = 1_000_000, in 1.0..=1e8, unit "steps";
        /// Steps per update, drawn with replacement.
        batch_size: usize = 256, in 1.0..=4096.0, unit "steps";
        /// Steps before the first update, in which actions are random.
        learning_starts: u64 = 100, in 0.0..=1e9, unit "steps";
        /// Steps between two blocks of updates.
        train_frequency: u64 = 1, in 1.0..=1e6, unit "steps";
        /// Updates of a block.
        gradient_steps: u32 = 1, in 1.0..=1e6, unit "updates";
    } and {
        /// Weight of the entropy, at first.
        entropy_coefficient: f32 = 1.0, in 1e-6..=1e3;
        /// Whether the weight of the entropy is learned, towards an entropy of minus the number of action dimensions.
        learned_entropy_coefficient: bool = true;
        /// Units of both hidden layers of every network.
        hidden: usize = 256, in 1.0..=1024.0, unit "units";
    }
}

/// A training.
pub type Sac<E> = OffPolicy<E, SoftActorCritic>;

/// What is learned.
#[derive(Debug, Clone)]
pub struct SoftActorCritic {
    settings: Settings,
    actions: usize,
    policy: Followed<Sequential>,
    critics: Critics,
    /// Logarithm of the entropy coefficient.
    log_coefficient: Vec<f32>,
    adam: Adam,
    now: Drawn,
    after: Drawn,
    by_outputs: Vec<f32>,
}

#[derive(Debug, Clone, Default)]
struct Drawn {
    noise: Vec<f32>,
    pairs: Vec<f32>,
    logs: Vec<f32>,
}

impl<E: Environment> Sac<E> {
    /// Returns a training that has not begun; panics when actions are numbered.
    pub fn new(settings: Settings, environment: E, seed: u64) -> Self {
        Self::start(Play::from(&settings), environment, seed, |width, actions| {
            SoftActorCritic::new(settings, width, actions, seed)
        })
    }
}

impl SoftActorCritic {
    fn new(settings: Settings, width: usize, actions: usize, seed: u64) -> Self {
        let Settings { learning_rate, adam_epsilon, hidden, .. } = settings;
        let hidden = [hidden, hidden];
        let policy = network(width, &hidden, 2 * actions, Activation::None);
        Self {
            policy: followed(policy, learning_rate, adam_epsilon, seed, "policy"),
            critics: Critics::new(width + actions, &hidden, learning_rate, adam_epsilon, seed),
            log_coefficient: vec![libm::logf(settings.entropy_coefficient)],
            adam: Adam::new(1, learning_rate, adam_epsilon),
            now: Drawn::default(),
            after: Drawn::default(),
            by_outputs: Vec::new(),
            actions,
            settings,
        }
    }

    /// One update with given normal numbers, in [`Self::now`] and [`Self::after`].
    fn learn(&mut self, batch: &Batch) -> f64 {
        let (count, actions) = (batch.rewards.len(), self.actions);
        let share = 1.0 / count as f32;
        let Self { settings, policy, critics, .. } = self;
        self.after.draw(policy.forward(&batch.nexts), &batch.nexts, actions);
        let outputs = policy.forward(&batch.states);
        self.now.draw(outputs, &batch.states, actions);
        self.by_outputs.clear();
        self.by_outputs.extend_from_slice(outputs);
        let coefficient = libm::expf(self.log_coefficient[0]);
        if settings.learned_entropy_coefficient {
            let target = -(actions as f32);
            let slope = -share * self.now.logs.iter().map(|log| log + target).sum::<f32>();
            self.adam.step(&mut self.log_coefficient, &[slope], None);
        }
        self.after.logs.iter_mut().for_each(|log| *log *= coefficient);
        let squares =
            critics.learn(batch, &self.after.pairs, &self.after.logs, settings.gamma, 0.5);
        let (_, by_actions) = critics.by_actions(&self.now.pairs, actions, false);
        let rows =
            self.by_outputs.chunks_exact_mut(2 * actions).zip(by_actions.chunks_exact(actions));
        let width = self.now.pairs.len() / count;
        for (i, (outputs, by_action)) in rows.enumerate() {
            for k in 0..actions {
                let action = self.now.pairs[(i + 1) * width - actions + k];
                let flat = 1.0 - action * action;
                // By the number before the tangent: of the density, and of the value.
                let by_log = 2.0 * action * flat / (flat + DENSITY_EPSILON);
                let slope = share * (coefficient * by_log - by_action[k] * flat);
                let log_std = outputs[actions + k];
                let deviation = libm::expf(log_std.clamp(LOG_STD[0], LOG_STD[1]));
                let inside = (LOG_STD[0]..=LOG_STD[1]).contains(&log_std);
                let by_log_std =
                    slope * self.now.noise[i * actions + k] * deviation - share * coefficient;
                outputs[k] = slope;
                outputs[actions + k] = if inside { by_log_std } else { 0.0 };
            }
        }
        policy.descend(&batch.states, &self.by_outputs, None);
        critics.follow(settings.tau);
        0.5 * squares
    }
}

impl Drawn {
    fn roll(&mut self, count: usize, draws: &mut Generator) {
        self.noise.clear();
        self.noise.extend((0..count).map(|_| draws.normal() as f32));
    }

    fn draw(&mut self, outputs: &[f32], states: &[f32], actions: usize) {
        self.pairs.clear();
        self.logs.clear();
        let rows = outputs.chunks_exact(2 * actions).zip(self.noise.chunks_exact(actions));
        let count = rows.len();
        for ((outputs, noise), state) in rows.zip(states.chunks_exact(states.len() / count)) {
            self.pairs.extend_from_slice(state);
            let mut log = 0.0;
            for (k, noise) in noise.iter().enumerate() {
                let log_std = outputs[actions + k].clamp(LOG_STD[0], LOG_STD[1]);
                let action = libm::tanhf(outputs[k] + libm::expf(log_std) * noise);
                log += -0.5 * noise * noise - log_std - HALF_LOG_TAU;
                log -= libm::logf(1.0 - action * action + DENSITY_EPSILON);
                self.pairs.push(action);
            }
            self.logs.push(log);
        }
    }
}

impl Learner for SoftActorCritic {
    fn explore(&mut self, observation: &[f32], draws: &mut Generator, action: &mut [f32]) {
        let outputs = self.policy.values(observation);
        for (k, action) in action.iter_mut().enumerate() {
            let log_std = outputs[self.actions + k].clamp(LOG_STD[0], LOG_STD[1]);
            *action = libm::tanhf(outputs[k] + libm::expf(log_std) * draws.normal() as f32);
        }
    }

    fn best(&mut self, observation: &[f32], action: &mut [f32]) {
        let outputs = self.policy.values(observation);
        action.iter_mut().zip(outputs).for_each(|(action, mean)| *action = libm::tanhf(*mean));
    }

    fn outputs(&mut self, observations: &[f32]) -> &[f32] {
        self.policy.forward(observations)
    }

    #[expect(private_interfaces, reason = "only algorithms of this folder are learners")]
    fn update(&mut self, batch: &Batch, draws: &mut Generator) -> f64 {
        let count = batch.rewards.len() * self.actions;
        self.now.roll(count, draws);
        self.after.roll(count, draws);
        self.learn(batch)
    }

    fn is_finite(&self) -> bool {
        self.policy.is_finite() && self.critics.is_finite() && self.log_coefficient[0].is_finite()
    }
}

impl Learned for SoftActorCritic {
    kept! { Learned { "policy.": policy, "": critics } }
}

impl State for SoftActorCritic {
    kept! { State {
        "policy.": policy, "": critics, "log_coefficient": log_coefficient, "coefficient.": adam,
    } }
}

#[cfg(test)]
mod tests {
    use super::super::Trainer;
    use super::super::testing::{Slider, check_trainer, outcome, updates};
    use super::*;

    fn settings() -> Settings {
        Settings {
            total_steps: 1600,
            learning_rate: 3e-3,
            gamma: 0.9,
            tau: 0.02,
            buffer_size: 500,
            batch_size: 32,
            learning_starts: 50,
            train_frequency: 2,
            hidden: 16,
            ..Settings::default()
        }
    }

    #[test]
    fn a_training_can_stop_after_every_update_and_learns() {
        check_trainer(&Slider::default(), |seed| Sac::new(settings(), Slider::default(), seed));
        let mut sac = Sac::new(settings(), Slider::default(), 3);
        sac.advance(u64::MAX, &mut |k| u64::from(k));
        let total = outcome(&Slider::default(), &mut sac);
        assert!(total > -1.2, "{total}");
    }

    fn before(settings: Settings) -> SoftActorCritic {
        let update = &updates()["sac"];
        let mut learner = SoftActorCritic::new(settings, 3, 2, 1);
        learner.policy.parameters = update.numbers("before.policy");
        for (k, critic) in learner.critics.both.iter_mut().enumerate() {
            critic.parameters = update.numbers(&format!("before.critics.{k}"));
            critic.target = update.numbers(&format!("before.targets.{k}"));
        }
        learner.now.noise = update.numbers("now");
        learner.after.noise = update.numbers("after");
        learner
    }

    #[test]
    fn an_update_is_that_of_stable_baselines3() {
        let update = &updates()["sac"];
        let mut learner = before(Settings {
            learning_rate: 0.01,
            gamma: 0.99,
            tau: 0.005,
            hidden: 5,
            ..settings()
        });
        learner.learn(&update.batch());
        update.check("then.policy", &learner.policy.parameters, 1e-5);
        for (k, critic) in learner.critics.both.iter().enumerate() {
            update.check(&format!("then.critics.{k}"), &critic.parameters, 1e-5);
            update.check(&format!("then.targets.{k}"), &critic.target, 1e-5);
        }
        update.check("then.log_coefficient", &learner.log_coefficient, 1e-6);
    }

    #[test]
    fn a_fixed_coefficient_stays() {
        let fixed =
            Settings { learned_entropy_coefficient: false, entropy_coefficient: 0.2, ..settings() };
        let mut sac = Sac::new(fixed, Slider::default(), 3);
        sac.advance(200, &mut |k| u64::from(k));
        assert_eq!(sac.learner.log_coefficient, [libm::logf(0.2)]);
    }
}
