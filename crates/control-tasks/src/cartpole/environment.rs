//! Episodes of a cart and its pole.
//!
//! A reward of 1 for every step, the last one too. An episode ends with the fall, or is cut after
//! [`HORIZON`] steps, so that 500 is the best return.

use super::dynamics::{Dynamics, State, fell};
use basics::pulse;
use learners::nn::archive::{Archive, ArchiveError};
use learners::rl::environment::{Environment, Step};
use learners::rl::random::Generator;

/// Steps after which an episode is cut.
pub const HORIZON: u32 = 500;

/// Where gymnasium's episodes start: all four numbers uniform within this of 0.
pub const GYMNASIUM_START: f64 = 0.05;

/// Where CARL's episodes start, since 2022-06.
pub const CARL_START: f64 = 0.1;

/// A cart and its pole, episode after episode.
#[derive(Debug, Clone, PartialEq)]
pub struct CartPole {
    dynamics: Dynamics,
    start: f64,
    state: State,
    steps: u32,
}

impl CartPole {
    /// Returns an environment whose episodes start within `start` of 0.
    pub fn new(dynamics: Dynamics, start: f64) -> Self {
        Self { dynamics, start, state: [0.0; 4], steps: 0 }
    }

    fn observe(&self, observation: &mut [f32]) {
        observation.iter_mut().zip(self.state).for_each(|(o, s)| *o = s as f32);
    }
}

impl Environment for CartPole {
    fn width(&self) -> usize {
        self.state.len()
    }

    fn actions(&self) -> usize {
        2
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) {
        let mut generator = Generator::new(seed, &["cartpole", "start"]);
        self.state = std::array::from_fn(|_| self.start * (2.0 * generator.unit() - 1.0));
        self.steps = 0;
        self.observe(observation);
    }

    fn step(&mut self, action: usize, observation: &mut [f32]) -> Step {
        pulse::beat(1);
        self.state = self.dynamics.step(self.state, action == 1);
        self.steps += 1;
        self.observe(observation);
        Step { reward: 1.0, terminated: fell(&self.state), truncated: self.steps >= HORIZON }
    }

    fn save(&self, prefix: &str, archive: &mut Archive) {
        archive.put(&format!("{prefix}state"), self.state);
        archive.put(&format!("{prefix}steps"), self.steps);
    }

    fn restore(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        self.state = archive.get(&format!("{prefix}state"))?;
        self.steps = archive.get(&format!("{prefix}steps"))?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::dynamics::{Context, Variant};
    use super::*;
    use learners::rl::environment::play;

    fn cart_pole() -> CartPole {
        CartPole::new(Dynamics::new(Context::default(), Variant::Physical), CARL_START)
    }

    #[test]
    fn a_balanced_pole_is_cut_at_the_horizon_and_a_pushed_one_falls() {
        let mut environment = cart_pole();
        let mut lean = |o: &[f32]| usize::from(0.1 * o[0] + 0.3 * o[1] + o[2] + o[3] > 0.0);
        let balanced = play(&mut environment, 1, &mut lean);
        assert_eq!((balanced.steps, balanced.total), (HORIZON, 500.0));
        assert!(!fell(&environment.state));
        let pushed = play(&mut environment, 1, &mut |_| 1);
        assert!(pushed.steps < 20 && pushed.total == f64::from(pushed.steps), "{pushed:?}");
        assert!(fell(&environment.state));
    }

    #[test]
    fn episodes_start_within_the_box_and_reach_its_corners() {
        let (mut cart_pole, mut observation) = (cart_pole(), [0.0f32; 4]);
        let mut largest = [0.0f32; 4];
        for seed in 0..200 {
            cart_pole.reset(seed, &mut observation);
            largest.iter_mut().zip(observation).for_each(|(l, o)| *l = l.max(o.abs()));
        }
        assert!(largest.iter().all(|l| (0.097..=0.1).contains(l)), "{largest:?}");
    }

    #[test]
    fn a_restored_episode_goes_on_as_before() {
        let (mut one, mut observation) = (cart_pole(), [0.0; 4]);
        one.reset(7, &mut observation);
        for action in [0, 1, 1, 0, 1] {
            one.step(action, &mut observation);
        }
        let mut archive = Archive::default();
        one.save("a.", &mut archive);
        let mut other = cart_pole();
        other.restore("a.", &archive).unwrap();
        assert_eq!(one, other);
        assert!(other.restore("b.", &archive).is_err());
    }
}
