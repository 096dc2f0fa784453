//! Proximal policy optimisation (Schulman et al., 2017) with numbered actions, fed step by step.
//!
//! It is [`super::sb3::ppo`] with PFRL's choices, which RESCO uses:
//! - **Network**: one gives the logits of all actions and, last, the value of the state.
//! - **Advantages** are standardised once per update, over all its steps.
//! - **Minibatches** come from fresh permutations; what one leaves over goes to the next minibatch.
//! - **Probabilities** to compare with are the network's just before the update.

use super::Losses;
use super::environment::Step;
use super::persist::Persist;
use super::random::Generator;
use super::sb3::actor_critic::ActorCritic;
use super::sb3::on_policy::{Algorithm as _, Experience};
use super::sb3::ppo::ProximalPolicy;
use super::sb3::rollout::Rollout;
use crate::nn::Network as _;
use crate::nn::sequential::Sequential;
use crate::nn::state::{Learned, State, kept};

pub use super::sb3::ppo::Settings;

/// A learner of a policy and its value.
#[derive(Debug, Clone)]
pub struct Ppo {
    settings: Settings,
    algorithm: ProximalPolicy,
    experience: Experience,
    sampling: Generator,
    losses: Losses,
}

impl Ppo {
    /// Returns a learner that starts from these parameters; `seed` and `labels` name its randomness.
    pub fn new(
        network: Sequential,
        parameters: Vec<f32>,
        settings: Settings,
        seed: u64,
        labels: &[&str],
    ) -> Self {
        let generator = |last: &'static str| Generator::new(seed, &[labels, &[last]].concat());
        let rollout = Rollout::new(1, settings.num_steps, network.inputs(), 1);
        let networks = ActorCritic::joint(network, parameters, settings.adam_epsilon);
        Self {
            algorithm: ProximalPolicy::new(settings.clone(), &networks),
            experience: Experience::new(networks, rollout, generator("shuffling")),
            sampling: generator("sampling"),
            losses: Losses::default(),
            settings,
        }
    }

    /// Draws an action; `generator` replaces the one of training, so that evaluation leaves that as it is.
    pub fn sample(&mut self, state: &[f32], generator: Option<&mut Generator>) -> usize {
        let mut action = [0.0];
        let generator = generator.unwrap_or(&mut self.sampling);
        self.experience.networks.draw(state, generator, &mut action);
        action[0] as usize
    }

    /// Returns the most probable action, the first of several.
    pub fn mode(&mut self, state: &[f32]) -> usize {
        let mut action = [0.0];
        self.experience.networks.best(state, &mut action);
        action[0] as usize
    }

    /// Stores a step, and updates when enough are there; the last step of an unfinished episode is cut then.
    pub fn observe(&mut self, state: &[f32], action: usize, step: Step, next: &[f32]) {
        let Experience { networks, rollout, .. } = &mut self.experience;
        if rollout.push(state, &[action as f32], step, next) {
            rollout.estimate(networks, self.settings.gamma, self.settings.gae_lambda);
            self.algorithm.update(&mut self.experience, 0, &mut self.losses);
            self.experience.rollout.clear();
        }
    }

    /// Returns mean loss and entropy of the gradient steps since it was last asked for; `None` without any.
    pub fn take_loss(&mut self) -> Option<(f64, f64)> {
        let (loss, entropy) = self.losses.take();
        loss.zip(entropy)
    }
}

impl Persist for Ppo {
    fn is_finite(&self) -> bool {
        self.experience.networks.is_finite()
    }

    fn is_alive(&mut self) -> bool {
        let states = self.experience.rollout.probes();
        self.experience.networks.is_alive(&states)
    }
}

impl Learned for Ppo {
    kept! { Learned { "": experience.networks } }
}

impl State for Ppo {
    kept! { State {
        "": experience.networks, "rollout.": experience.rollout, "sampling": sampling,
        "shuffling": experience.shuffling,
    } }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nn::Activation;
    use crate::nn::archive::Archive;
    use crate::nn::init::Init;

    fn learner(num_steps: usize) -> Ppo {
        let network = Sequential::new(5).linear(32, Activation::Relu).linear(3, Activation::None);
        let mut draw = Generator::new(3, &["initial"]);
        let parameters = network.initial(&|_| Init::Uniform, draw.rng());
        let settings = Settings {
            learning_rate: 3e-3,
            adam_epsilon: 1e-5,
            gamma: 0.9,
            gae_lambda: 0.95,
            num_steps,
            update_epochs: 4,
            minibatch_size: 24,
            clip_range: 0.2,
            value_coefficient: 1.0,
            entropy_coefficient: 0.001,
            max_grad_norm: 0.5,
            ..Settings::default()
        };
        Ppo::new(network, parameters, settings, 3, &[])
    }

    fn one_hot(state: usize) -> [f32; 5] {
        std::array::from_fn(|i| f32::from(u8::from(i == state)))
    }

    fn walk(ppo: &mut Ppo, decisions: usize, state: &mut usize) {
        for _ in 0..decisions {
            let action = ppo.sample(&one_hot(*state), None);
            let next = if action == 1 { *state + 1 } else { state.saturating_sub(1) };
            let terminated = next == 4;
            let reward = f32::from(u8::from(terminated));
            let step = Step { reward, terminated, truncated: false };
            ppo.observe(&one_hot(*state), action, step, &one_hot(next));
            *state = if terminated { 0 } else { next };
        }
    }

    #[test]
    fn a_tabular_problem_is_solved() {
        let mut ppo = learner(128);
        walk(&mut ppo, 128 * 60, &mut 0);
        for state in 0..4 {
            assert_eq!(ppo.mode(&one_hot(state)), 1);
            let value = ppo.experience.networks.values(&one_hot(state))[0];
            let best = 0.9f32.powi(3 - state as i32);
            assert!((value - best).abs() < 0.1, "{state}: {value}, {best}");
        }
    }

    #[test]
    fn every_step_is_used_once_per_epoch_even_when_minibatches_do_not_fit() {
        // 40 steps, minibatches of 24: 4 epochs are 160 steps, rounded up to 7 minibatches.
        let mut ppo = learner(40);
        walk(&mut ppo, 40, &mut 0);
        assert_eq!(ppo.losses.count, 7);
        assert!(ppo.experience.rollout.probes().is_empty());
        let (loss, entropy) = ppo.take_loss().unwrap();
        assert!(loss.is_finite() && entropy > 0.0 && entropy <= 2f64.ln());
        assert_eq!(ppo.take_loss(), None);
    }

    #[test]
    fn a_restored_learner_goes_on_with_the_same_bytes() {
        let mut one = learner(128);
        let mut state = 0;
        walk(&mut one, 300, &mut state);
        let mut archive = Archive::default();
        one.save("a.", &mut archive);
        let mut other = learner(128);
        other.restore("a.", &archive).unwrap();
        let mut same = state;
        walk(&mut one, 300, &mut state);
        walk(&mut other, 300, &mut same);
        let (mut a, mut b) = (Archive::default(), Archive::default());
        one.save("", &mut a);
        other.save("", &mut b);
        assert!(a.to_bytes() == b.to_bytes());
    }
}
