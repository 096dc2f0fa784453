//! Trust region policy optimisation (Schulman et al., 2015), as sb3-contrib's `TRPO`.
//!
//! Choices where implementations differ:
//! - **Networks** and advantages are those of [`super::ppo`]; advantages are standardised over all steps of an update.
//! - **Metric**: Fisher's, over all steps, plus a damping. It is exact: the outputs' move `J v`, the distribution's metric
//!   times it, then `J^T u`. At the policy that played it equals the Hessian of the mean divergence, which sb3-contrib
//!   differentiates twice.
//! - **Divergence** of a continuous action is the mean over its numbers, not the sum.
//! - **Direction**: conjugate gradients from a little normal noise, no preconditioning.
//! - **Step**: the longest within twice the target divergence, made shorter until the surrogate improves and the mean
//!   divergence of the new policy from the old is below the target; else the policy stays.
//! - **Value**: Adam on the squared error, in minibatches of a permutation per pass, without cutting the gradient.
//! - **A cut episode** has the value of the state after it.

use basics::setting::settings;
use rand::seq::SliceRandom;

use super::actor_critic::ActorCritic;
use super::on_policy::{Algorithm, Experience, OnPolicy, Play};
use super::ppo::standardise;
use super::rollout::Batch;
use crate::rl::Losses;
use crate::rl::environment::Environment;
use crate::rl::random::Generator;

/// Deviation of the noise that conjugate gradients begin with.
const START: f64 = 1e-4;

/// Squared length of the residual below which they end.
const RESIDUAL: f64 = 1e-10;

settings! {
    /// Hyper-parameters of `trpo`; the defaults are those of sb3-contrib.
    pub struct Settings, source "sb3-contrib 2.9, TRPO" {
        /// Steps of the training, in all environments together; the update that begins before this many
        /// are done is completed.
        total_steps: u64 = 100_000, in 1.0..=1e9, unit "steps",
            source "Jayawardana et al., 2022, give none for most tasks";
        /// Environments side by side.
        environments: usize = 1, in 1.0..=256.0, unit "environments";
        /// Steps per environment and update.
        num_steps: usize = 2048, in 1.0..=1e6, unit "steps";
        /// Steps per gradient step of the value.
        minibatch_size: usize = 128, in 1.0..=1e6, unit "steps";
        /// Passes of the value over the steps of an update.
        critic_epochs: usize = 10, in 1.0..=1000.0, unit "passes";
        /// Step size of Adam, which moves the value only.
        learning_rate: f32 = 1e-3, in 1e-8..=1.0;
        /// Adam's epsilon, added to the root of the second moment.
        adam_epsilon: f32 = 1e-5, in 1e-12..=1.0;
        /// Discount per step.
        gamma: f32 = 0.99, in 0.0..=1.0;
        /// Discount of later advantages within the generalised advantage estimate.
        gae_lambda: f32 = 0.95, in 0.0..=1.0;
        /// Largest mean KL divergence between the policies before and after an update.
        target_kl: f32 = 0.01, in 1e-9..=10.0;
        /// Steps of conjugate gradients per update.
        cg_steps: u32 = 15, in 1.0..=1000.0, unit "steps";
        /// Added to the diagonal of the Fisher information matrix.
        cg_damping: f32 = 0.1, in 0.0..=1e3;
        /// Factor by which a step that does not improve the policy is made shorter.
        line_search_factor: f32 = 0.8, in 0.01..=0.99;
        /// Steps tried before the policy is left as it is.
        line_search_steps: u32 = 10, in 1.0..=1000.0, unit "steps";
        /// Units of both hidden layers, of the policy and of the value.
        hidden: usize = 64, in 1.0..=1024.0, unit "units";
    }
}

/// A training of a policy and its value.
pub type Trpo<E> = OnPolicy<E, TrustRegion>;

/// What the updates are computed with.
#[derive(Debug, Clone)]
pub struct TrustRegion {
    settings: Settings,
    seen: Seen,
    vectors: Vectors,
}

#[derive(Debug, Clone, Default)]
struct Seen {
    batch: Batch,
    /// What the policy said before the update, and the logarithms of its deviations.
    outputs: Vec<f32>,
    log_std: Vec<f32>,
}

/// Vectors over the parameters of the policy: those of its network, then the logarithms of its deviations.
#[derive(Debug, Clone, Default)]
struct Vectors {
    gradient: Vec<f32>,
    direction: Vec<f32>,
    residual: Vec<f32>,
    search: Vec<f32>,
    product: Vec<f32>,
    before: Vec<f32>,
}

impl<E: Environment + Clone> Trpo<E> {
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
        let (seen, vectors) = (Seen::default(), Vectors::default());
        Self::start(play, environment, seed, |_| TrustRegion { seen, vectors, settings })
    }
}

impl Algorithm for TrustRegion {
    #[expect(private_interfaces, reason = "as in the trait")]
    fn update(&mut self, experience: &mut Experience, _: u64, losses: &mut Losses) {
        let entropy = self.improve_policy(experience);
        losses.add(self.improve_value(experience), entropy);
    }
}

impl TrustRegion {
    fn improve_policy(&mut self, experience: &mut Experience) -> f64 {
        let Settings { target_kl, cg_steps, cg_damping, .. } = self.settings;
        let (surrogate, entropy) = self.gradient(experience);
        let Self { seen, vectors, .. } = self;
        let Experience { networks, shuffling, .. } = experience;
        solve(vectors, cg_steps, shuffling, &mut |v, product| {
            fisher(networks, seen, cg_damping, v, product);
        });
        let Vectors { direction, product, before, .. } = vectors;
        fisher(networks, seen, cg_damping, direction, product);
        let longest = (2.0 * f64::from(target_kl) / dot(direction, product)).sqrt();
        let [network, deviations] = networks.of_policy();
        before.clear();
        before.extend_from_slice(&networks.parameters[network.clone()]);
        before.extend_from_slice(&networks.parameters[deviations.clone()]);
        let mut length = longest as f32;
        for _ in 0..self.settings.line_search_steps {
            let places = network.clone().chain(deviations.clone());
            for ((place, before), d) in places.zip(&*before).zip(&*direction) {
                networks.parameters[place] = before + length * d;
            }
            let (new, divergence) = judge(networks, seen);
            if divergence < target_kl && new > surrogate {
                return entropy;
            }
            length *= self.settings.line_search_factor;
        }
        let places = network.chain(deviations);
        places.zip(before).for_each(|(place, before)| networks.parameters[place] = *before);
        entropy
    }

    fn gradient(&mut self, experience: &mut Experience) -> (f32, f64) {
        let Experience { networks, rollout, order, .. } = experience;
        let Seen { batch, outputs, log_std } = &mut self.seen;
        let count = rollout.len();
        order.clear();
        order.extend(0..count);
        batch.gather(rollout, order);
        standardise(&mut batch.advantages, count as f32 - 1.0);
        let [policy, deviations, _] = networks.forward(&batch.states);
        policy.clone_into(outputs);
        deviations.clone_into(log_std);
        batch.by_outputs.resize(outputs.len(), 0.0);
        batch.by_log_std.clear();
        batch.by_log_std.resize(log_std.len(), 0.0);
        let (width, actions) = (outputs.len() / count, batch.actions.len() / count);
        let share = 1.0 / count as f32;
        let (mut surrogate, mut entropies) = (0.0, 0.0);
        let rows = outputs.chunks_exact(width).zip(batch.by_outputs.chunks_exact_mut(width));
        for (place, (outputs, by_outputs)) in rows.enumerate() {
            let action = &batch.actions[place * actions..][..actions];
            let log = networks.distribution.log(outputs, log_std, action);
            let gain = libm::expf(log - batch.logs[place]) * batch.advantages[place];
            surrogate += share * gain;
            let entropy = networks.distribution.gradient(
                outputs, log_std, action, gain, 0.0, share, by_outputs, &mut batch.by_log_std,
            );
            entropies += f64::from(entropy) / count as f64;
        }
        let [network, deviations] = networks.of_policy();
        let gradient = &mut self.vectors.gradient;
        gradient.resize(network.len() + deviations.len(), 0.0);
        let (by_network, by_deviations) = gradient.split_at_mut(network.len());
        networks.back_policy(&batch.states, &batch.by_outputs, by_network);
        by_deviations.copy_from_slice(&batch.by_log_std);
        (surrogate, entropies)
    }

    fn improve_value(&mut self, experience: &mut Experience) -> f64 {
        let batch = &mut self.seen.batch;
        let Experience { networks, rollout, shuffling, order } = experience;
        let Settings { minibatch_size, learning_rate, .. } = self.settings;
        let mut losses = Losses::default();
        order.clear();
        order.extend(0..rollout.len());
        for _ in 0..self.settings.critic_epochs {
            order.shuffle(shuffling.rng());
            for places in order.chunks(minibatch_size) {
                batch.gather(rollout, places);
                let values = networks.values(&batch.states);
                batch.by_values.clear();
                let (mut squares, share) = (0.0, 1.0 / places.len() as f32);
                for (value, target) in values.iter().zip(&batch.returns) {
                    let error = value - target;
                    squares += f64::from(share * error * error);
                    batch.by_values.push(share * 2.0 * error);
                }
                networks.descend_value(&batch.states, &batch.by_values, learning_rate);
                losses.add(squares, 0.0);
            }
        }
        losses.take().0.unwrap_or_default()
    }
}

/// Writes Fisher's metric, with a damping, times a vector.
fn fisher(
    networks: &mut ActorCritic,
    seen: &mut Seen,
    damping: f32,
    v: &[f32],
    product: &mut Vec<f32>,
) {
    let Seen { batch: Batch { states, by_outputs, .. }, outputs, log_std } = seen;
    let [network, _] = networks.of_policy();
    let width = networks.distribution.outputs();
    let share = width as f32 / outputs.len() as f32;
    product.resize(v.len(), 0.0);
    by_outputs.copy_from_slice(networks.tangent(states, &v[..network.len()]));
    let mut by_deviation = 0.0;
    for (outputs, moved) in outputs.chunks_exact(width).zip(by_outputs.chunks_exact_mut(width)) {
        by_deviation = networks.distribution.metric(outputs, log_std, share, moved);
    }
    let (by_network, by_deviations) = product.split_at_mut(network.len());
    networks.back_policy(states, by_outputs, by_network);
    by_deviations.iter_mut().zip(&v[network.len()..]).for_each(|(p, v)| *p = by_deviation * v);
    product.iter_mut().zip(v).for_each(|(p, v)| *p += damping * v);
}

/// Solves `metric direction = gradient` by conjugate gradients.
fn solve(
    vectors: &mut Vectors,
    steps: u32,
    draws: &mut Generator,
    metric: &mut dyn FnMut(&[f32], &mut Vec<f32>),
) {
    let Vectors { gradient, direction, residual, search, product, .. } = vectors;
    direction.clear();
    direction.extend(gradient.iter().map(|_| (START * draws.normal()) as f32));
    metric(direction, product);
    residual.clear();
    residual.extend(gradient.iter().zip(&*product).map(|(g, p)| g - p));
    let mut square = dot(residual, residual);
    search.clone_from(residual);
    for _ in 0..steps {
        if square < RESIDUAL {
            return;
        }
        metric(search, product);
        let alpha = (square / dot(search, product)) as f32;
        direction.iter_mut().zip(&*search).for_each(|(d, s)| *d += alpha * s);
        residual.iter_mut().zip(&*product).for_each(|(r, p)| *r -= alpha * p);
        let new = dot(residual, residual);
        let beta = (new / square) as f32;
        square = new;
        search.iter_mut().zip(&*residual).for_each(|(s, r)| *s = r + beta * *s);
    }
}

/// Returns the surrogate of the policy as it is now, and its mean divergence from that before.
fn judge(networks: &mut ActorCritic, seen: &Seen) -> (f32, f32) {
    let batch = &seen.batch;
    let count = batch.logs.len();
    let (outputs, log_std, distribution) = networks.say(&batch.states);
    let (width, actions) = (outputs.len() / count, batch.actions.len() / count);
    let share = 1.0 / count as f32;
    let (mut surrogate, mut divergence) = (0.0, 0.0);
    let rows = outputs.chunks_exact(width).zip(seen.outputs.chunks_exact(width));
    for (place, (new, old)) in rows.enumerate() {
        let action = &batch.actions[place * actions..][..actions];
        let ratio = libm::expf(distribution.log(new, log_std, action) - batch.logs[place]);
        surrogate += share * ratio * batch.advantages[place];
        divergence += share * distribution.divergence((new, log_std), (old, &seen.log_std));
    }
    (surrogate, divergence)
}

fn dot(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
}

#[cfg(test)]
mod tests {
    use super::super::Trainer;
    use super::super::rollout::Rollout;
    use super::super::testing::{Corridor, Slider, check_trainer, outcome, play, updates};
    use super::*;
    use crate::rl::environment::Actions;

    fn settings() -> Settings {
        Settings {
            total_steps: 6000,
            environments: 3,
            num_steps: 43,
            minibatch_size: 32,
            learning_rate: 3e-3,
            gamma: 0.9,
            hidden: 32,
            ..Settings::default()
        }
    }

    #[test]
    fn a_training_can_stop_after_every_update_and_learns() {
        check_trainer(&Corridor::default(), |seed| {
            Trpo::new(settings(), Corridor::default(), seed)
        });
        check_trainer(&Slider::default(), |seed| Trpo::new(settings(), Slider::default(), seed));
        let mut trpo =
            Trpo::new(Settings { total_steps: 12_000, ..settings() }, Corridor::default(), 3);
        trpo.advance(u64::MAX, &mut |k| u64::from(k));
        assert_eq!(play(&mut trpo), 4);
        let mut trpo =
            Trpo::new(Settings { total_steps: 40_000, ..settings() }, Slider::default(), 3);
        trpo.advance(u64::MAX, &mut |k| u64::from(k));
        let total = outcome(&Slider::default(), &mut trpo);
        assert!(total > -1.3, "{total}");
    }

    #[test]
    fn an_update_is_that_of_sb3_contrib() {
        let all = updates();
        for (name, actions) in [
            ("trpo-numbered", Actions::Numbered(2)),
            ("trpo-continuous", Actions::Continuous { count: 2, limit: 1.0 }),
        ] {
            let update = &all[name];
            let few = Settings { critic_epochs: 2, learning_rate: 0.01, hidden: 5, ..settings() };
            let mut trpo = Trpo::new(few, Slider::default(), 1);
            trpo.experience.networks = ActorCritic::new(3, actions, 5, 1e-5, 1);
            trpo.experience.networks.parameters = update.numbers("before");
            let parts = ["states", "actions", "logs", "advantages", "returns"];
            trpo.experience.rollout = Rollout::of(parts.map(|part| update.numbers(part)));
            trpo.algorithm.improve_policy(&mut trpo.experience);
            trpo.algorithm.improve_value(&mut trpo.experience);
            assert!(trpo.experience.networks.parameters != update.numbers("before"));
            // Conjugate gradients begin with a little noise, which is 0 there.
            update.check("then", &trpo.experience.networks.parameters, 2e-4);
        }
    }

    #[test]
    fn a_step_that_cannot_improve_leaves_the_policy() {
        let update = &updates()["trpo-continuous"];
        let never = Settings { target_kl: 1e-30, hidden: 5, ..settings() };
        let mut trpo = Trpo::new(never, Slider::default(), 1);
        trpo.experience.networks =
            ActorCritic::new(3, Actions::Continuous { count: 2, limit: 1.0 }, 5, 1e-5, 1);
        trpo.experience.networks.parameters = update.numbers("before");
        let parts = ["states", "actions", "logs", "advantages", "returns"];
        trpo.experience.rollout = Rollout::of(parts.map(|part| update.numbers(part)));
        trpo.algorithm.improve_policy(&mut trpo.experience);
        assert_eq!(trpo.experience.networks.parameters, update.numbers("before"));
    }
}
