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

use basics::setting::settings;
use rand::seq::SliceRandom;

use self::loss::Minibatch;
use super::Schedule;
use super::on_policy::{Algorithm, Experience, Losses, OnPolicy, Play};
use crate::rl::environment::Environment;

settings! {
    /// Hyper-parameters of `ppo`; the defaults are Stable-Baselines3's.
    pub struct Settings, source "Stable-Baselines3 2.9, PPO" {
        /// Steps of the training, in all environments together; the update that begins before this many
        /// are done is completed.
        total_steps: u64 = 100_000, in 1.0..=1e9, unit "steps",
            source "Jayawardana et al., 2022, give none for this task";
        /// Environments side by side.
        environments: usize = 1, in 1.0..=256.0, unit "environments";
        /// Steps per environment and update.
        num_steps: usize = 2048, in 1.0..=1e6, unit "steps";
        /// Steps per gradient step.
        minibatch_size: usize = 64, in 1.0..=1e6, unit "steps";
        /// Passes over the steps of an update.
        update_epochs: usize = 10, in 1.0..=1000.0, unit "passes";
        /// Step size of Adam.
        learning_rate: f32 = 3e-4, in 1e-8..=1.0;
        /// Schedule of the learning rate: `constant`, or `linear` to 0 at the end of the training.
        learning_rate_schedule: Schedule = Schedule::Constant;
        /// Adam's epsilon, added to the root of the second moment.
        adam_epsilon: f32 = 1e-5, in 1e-12..=1.0;
        /// Discount per step.
        gamma: f32 = 0.99, in 0.0..=1.0;
        /// Discount of later advantages within the generalised advantage estimate.
        gae_lambda: f32 = 0.95, in 0.0..=1.0;
        /// Largest relative change of an action's probability that an update rewards.
        clip_range: f32 = 0.2, in 1e-6..=10.0;
        /// Schedule of the clip range: `constant`, or `linear` to 0 at the end of the training.
        clip_range_schedule: Schedule = Schedule::Constant;
        /// Weight of the entropy bonus.
        entropy_coefficient: f32 = 0.0, in 0.0..=1e3;
        /// Weight of the squared error of the value.
        value_coefficient: f32 = 0.5, in 0.0..=1e3;
        /// Largest Euclidean norm of the gradient of policy and value together.
        max_grad_norm: f32 = 0.5, in 1e-6..=1e9;
        /// Units of both hidden layers, of the policy and of the value.
        hidden: usize = 64, in 1.0..=1024.0, unit "units";
    }
}

/// A training of a policy and its value.
pub type Ppo<E> = OnPolicy<E, ProximalPolicy>;

/// What the updates are computed with.
#[derive(Debug, Clone)]
pub struct ProximalPolicy {
    settings: Settings,
    minibatch: Minibatch,
}

impl<E: Environment + Clone> Ppo<E> {
    /// Returns a training that has not begun.
    pub fn new(settings: Settings, environment: E, seed: u64) -> Self {
        let play = Play {
            total_steps: settings.total_steps,
            environments: settings.environments,
            num_steps: settings.num_steps,
            gamma: settings.gamma,
            gae_lambda: settings.gae_lambda,
            hidden: settings.hidden,
            adam_epsilon: settings.adam_epsilon,
        };
        Self::start(play, environment, seed, |actions| ProximalPolicy {
            minibatch: Minibatch::new(actions),
            settings,
        })
    }
}

impl Algorithm for ProximalPolicy {
    #[expect(private_interfaces, reason = "as in the trait")]
    fn update(&mut self, experience: &mut Experience, steps: u64, losses: &mut Losses) {
        let Self { settings, minibatch } = self;
        let Experience { networks, rollout, shuffling, order } = experience;
        let at = |schedule: Schedule, start| schedule.at(start, steps, settings.total_steps);
        let learning_rate = at(settings.learning_rate_schedule, settings.learning_rate);
        let clip_range = at(settings.clip_range_schedule, settings.clip_range);
        order.clear();
        order.extend(0..rollout.len());
        for _ in 0..settings.update_epochs {
            order.shuffle(shuffling.rng());
            for places in order.chunks(settings.minibatch_size) {
                minibatch.gather(rollout, places);
                let outputs = networks.forward(&minibatch.states);
                minibatch.loss(outputs, settings, clip_range, losses);
                let Minibatch { states, by_outputs, by_log_std, by_values, .. } = &*minibatch;
                networks.back(states, by_outputs, by_log_std, by_values);
                networks.descend(learning_rate, settings.max_grad_norm);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Trainer;
    use super::super::actor_critic::ActorCritic;
    use super::super::testing::{Corridor, Slider, check_trainer, outcome, play, updates};
    use super::*;
    use crate::rl::environment::Actions;
    use crate::rl::persist::Persist;

    fn settings() -> Settings {
        Settings {
            total_steps: 6000,
            environments: 3,
            num_steps: 43,
            minibatch_size: 32,
            learning_rate: 3e-3,
            learning_rate_schedule: Schedule::Linear,
            gamma: 0.9,
            clip_range_schedule: Schedule::Linear,
            hidden: 32,
            ..Settings::default()
        }
    }

    fn trainer(seed: u64) -> Ppo<Corridor> {
        Ppo::new(settings(), Corridor::default(), seed)
    }

    #[test]
    fn a_corridor_is_learned_to_its_exact_values() {
        let mut ppo = trainer(3);
        ppo.advance(u64::MAX, &mut |k| u64::from(k));
        assert_eq!(play(&mut ppo), 4);
        for state in 0..4 {
            let value = ppo.experience.networks.values(&Corridor::one_hot(state))[0];
            let exact = 0.9f32.powi(3 - state as i32);
            assert!((value - exact).abs() < 0.1, "{state}: {value}, {exact}");
        }
    }

    #[test]
    fn a_training_can_stop_after_every_update() {
        check_trainer(&Corridor::default(), trainer);
        check_trainer(&Slider::default(), |seed| Ppo::new(settings(), Slider::default(), seed));
    }

    #[test]
    fn a_slider_is_learned() {
        let mut ppo =
            Ppo::new(Settings { total_steps: 20_000, ..settings() }, Slider::default(), 3);
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
        let mut order = ppo.experience.order.clone();
        order.sort_unstable();
        assert!(order.iter().copied().eq(0..129));
        assert!(ppo.is_finite());
    }
}
