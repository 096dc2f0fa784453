//! Twin delayed deep deterministic policy gradient (Fujimoto et al., 2018), as Stable-Baselines3's `TD3`.
//!
//! Choices where implementations differ, beside those of `off_policy.rs`:
//! - **Policy**: a network whose last layer has a hyperbolic tangent; its slow copy gives the actions of targets.
//! - **Exploration**: normal noise on the action, cut to -1..1. Stable-Baselines3's default is none.
//! - **Targets**: the slow policy's action with cut normal noise, and the smaller of the slow critics' values.
//! - **Critics**: the mean squared error each.
//! - **Delay**: the policy, by the first critic, and all slow copies move at every second update, the second one first.

use basics::setting::settings;

use super::off_policy::{Batch, Critics, Learner, OffPolicy, Play, followed, network};
use crate::nn::sequential::Sequential;
use crate::nn::state::{Learned, State, kept};
use crate::nn::{Activation, Network};
use crate::rl::Followed;
use crate::rl::environment::Environment;
use crate::rl::random::Generator;

settings! {
    /// Hyper-parameters of `td3`; the defaults are those of Stable-Baselines3.
    pub struct Settings extends Play, source "Stable-Baselines3 2.9, TD3" {
        /// Steps of the training.
        total_steps: u64 = 20_000, in 1.0..=1e9, unit "steps",
            source "rl-baselines3-zoo 2.9 for Pendulum-v1";
        /// Step size of Adam, for policy and critics.
        learning_rate: f32 = 1e-3, in 1e-8..=1.0;
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
        /// Updates of the critics per update of the policy.
        policy_delay: u32 = 2, in 1.0..=1e6, unit "updates";
        /// Deviation of the noise on actions while learning, as a share of the largest action.
        action_noise: f32 = 0.0, in 0.0..=10.0;
        /// Deviation of the noise on the actions of targets, as a share of the largest action.
        target_noise: f32 = 0.2, in 0.0..=10.0;
        /// Largest noise on the actions of targets, as a share of the largest action.
        target_noise_clip: f32 = 0.5, in 0.0..=10.0;
        /// Units of the first hidden layer of every network.
        hidden: usize = 400, in 1.0..=1024.0, unit "units";
        /// Units of the second hidden layer of every network.
        second_hidden: usize = 300, in 1.0..=1024.0, unit "units";
    }
}

/// A training.
pub type Td3<E> = OffPolicy<E, TwinDelayed>;

/// What is learned.
#[derive(Debug, Clone)]
pub struct TwinDelayed {
    settings: Settings,
    actions: usize,
    policy: Followed<Sequential>,
    critics: Critics,
    updates: u32,
    noise: Vec<f32>,
    pairs: Vec<f32>,
    costs: Vec<f32>,
    by_outputs: Vec<f32>,
}

impl<E: Environment> Td3<E> {
    /// Returns a training that has not begun; panics when actions are numbered.
    pub fn new(settings: Settings, environment: E, seed: u64) -> Self {
        Self::start(Play::from(&settings), environment, seed, |width, actions| {
            TwinDelayed::new(settings, width, actions, seed)
        })
    }
}

impl TwinDelayed {
    fn new(settings: Settings, width: usize, actions: usize, seed: u64) -> Self {
        let Settings { learning_rate, adam_epsilon, hidden, second_hidden, .. } = settings;
        let hidden = [hidden, second_hidden];
        let policy = network(width, &hidden, actions, Activation::Tanh);
        Self {
            policy: followed(policy, learning_rate, adam_epsilon, seed, "policy"),
            critics: Critics::new(width + actions, &hidden, learning_rate, adam_epsilon, seed),
            updates: 0,
            noise: Vec::new(),
            pairs: Vec::new(),
            costs: Vec::new(),
            by_outputs: Vec::new(),
            actions,
            settings,
        }
    }

    /// One update with given normal numbers, in [`Self::noise`].
    fn learn(&mut self, batch: &Batch) -> f64 {
        let Self { settings, policy, critics, actions, .. } = self;
        let (count, actions) = (batch.rewards.len(), *actions);
        self.updates += 1;
        let limit = settings.target_noise_clip;
        let outputs = policy.network.forward(&policy.target, &batch.nexts);
        beside(&batch.nexts, outputs, count, &mut self.pairs, |i, action| {
            let noise = (settings.target_noise * self.noise[i]).clamp(-limit, limit);
            (action + noise).clamp(-1.0, 1.0)
        });
        self.costs.resize(count, 0.0);
        let loss = critics.learn(batch, &self.pairs, &self.costs, settings.gamma, 1.0);
        if self.updates.is_multiple_of(settings.policy_delay) {
            let outputs = policy.forward(&batch.states);
            beside(&batch.states, outputs, count, &mut self.pairs, |_, action| action);
            let (_, by_actions) = critics.by_actions(&self.pairs, actions, true);
            self.by_outputs.clear();
            self.by_outputs.extend(by_actions.iter().map(|g| -g / count as f32));
            policy.descend(&batch.states, &self.by_outputs, None);
            critics.follow(settings.tau);
            policy.follow(settings.tau);
        }
        loss
    }
}

fn beside(
    states: &[f32],
    actions: &[f32],
    count: usize,
    pairs: &mut Vec<f32>,
    change: impl Fn(usize, f32) -> f32,
) {
    let (width, numbers) = (states.len() / count, actions.len() / count);
    pairs.clear();
    for (row, state) in states.chunks_exact(width).enumerate() {
        pairs.extend_from_slice(state);
        pairs.extend((row * numbers..(row + 1) * numbers).map(|i| change(i, actions[i])));
    }
}

impl Learner for TwinDelayed {
    fn explore(&mut self, observation: &[f32], draws: &mut Generator, action: &mut [f32]) {
        self.best(observation, action);
        if self.settings.action_noise > 0.0 {
            for action in action {
                let noise = self.settings.action_noise * draws.normal() as f32;
                *action = (*action + noise).clamp(-1.0, 1.0);
            }
        }
    }

    fn best(&mut self, observation: &[f32], action: &mut [f32]) {
        action.copy_from_slice(self.policy.values(observation));
    }

    fn outputs(&mut self, observations: &[f32]) -> &[f32] {
        self.policy.forward(observations)
    }

    #[expect(private_interfaces, reason = "only algorithms of this folder are learners")]
    fn update(&mut self, batch: &Batch, draws: &mut Generator) -> f64 {
        self.noise.clear();
        self.noise.extend((0..batch.rewards.len() * self.actions).map(|_| draws.normal() as f32));
        self.learn(batch)
    }

    fn is_finite(&self) -> bool {
        self.policy.is_finite() && self.critics.is_finite()
    }
}

impl Learned for TwinDelayed {
    kept! { Learned { "policy.": policy, "": critics } }
}

impl State for TwinDelayed {
    kept! { State { "policy.": policy, "": critics, "updates": updates } }
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
            learning_starts: 200,
            action_noise: 0.1,
            hidden: 16,
            second_hidden: 12,
            ..Settings::default()
        }
    }

    #[test]
    fn a_training_can_stop_after_every_update_and_learns() {
        check_trainer(&Slider::default(), |seed| Td3::new(settings(), Slider::default(), seed));
        let mut td3 = Td3::new(settings(), Slider::default(), 3);
        td3.advance(u64::MAX, &mut |k| u64::from(k));
        let total = outcome(&Slider::default(), &mut td3);
        assert!(total > -1.2, "{total}");
    }

    #[test]
    fn an_update_is_that_of_stable_baselines3() {
        let update = &updates()["td3"];
        let same = Settings {
            learning_rate: 0.01,
            gamma: 0.99,
            tau: 0.005,
            hidden: 5,
            second_hidden: 5,
            policy_delay: 1,
            ..settings()
        };
        let mut learner = TwinDelayed::new(same, 3, 2, 1);
        learner.policy.parameters = update.numbers("before.policy");
        learner.policy.target = update.numbers("before.policy_target");
        for (k, critic) in learner.critics.both.iter_mut().enumerate() {
            critic.parameters = update.numbers(&format!("before.critics.{k}"));
            critic.target = update.numbers(&format!("before.targets.{k}"));
        }
        learner.noise = update.numbers("noise");
        learner.learn(&update.batch());
        update.check("then.policy", &learner.policy.parameters, 1e-5);
        update.check("then.policy_target", &learner.policy.target, 1e-5);
        for (k, critic) in learner.critics.both.iter().enumerate() {
            update.check(&format!("then.critics.{k}"), &critic.parameters, 1e-5);
            update.check(&format!("then.targets.{k}"), &critic.target, 1e-5);
        }
    }

    #[test]
    fn the_policy_moves_at_every_second_update() {
        let mut td3 = Td3::new(settings(), Slider::default(), 3);
        td3.advance(200, &mut |k| u64::from(k));
        let mut moved = Vec::new();
        for _ in 0..4 {
            let (policy, critic) = (
                td3.learner.policy.parameters.clone(),
                td3.learner.critics.both[0].parameters.clone(),
            );
            td3.update();
            assert!(td3.learner.critics.both[0].parameters != critic);
            moved.push(td3.learner.policy.parameters != policy);
        }
        assert_eq!(moved, [false, true, false, true]);
    }
}
