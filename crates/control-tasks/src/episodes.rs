//! Episodes of dynamics.

use std::fmt::Debug;

use basics::heartbeat;
use learners::nn::archive::{Archive, ArchiveError};
use learners::nn::state::State;
use learners::rl::environment::{Actions, Environment, Step};
use learners::rl::random::Generator;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// What happens in a step, in double precision; networks see observations in single precision.
pub trait Dynamics {
    /// Name in the label of the generator that draws where episodes start.
    const LABEL: &'static str;
    /// Steps after which an episode is cut.
    const HORIZON: u32;
    /// Numbers of an observation.
    const WIDTH: usize;

    /// What a step changes.
    type State: Copy + Default + PartialEq + Debug + Serialize + DeserializeOwned + AsRef<[f64]>;

    /// The first number of a state that an agent sees, by default.
    const FIRST_SEEN: usize = 0;

    /// What an agent can do.
    fn actions(&self) -> Actions;

    /// Returns where an episode starts.
    fn start(&self, generator: &mut Generator) -> Self::State;

    /// Writes what an agent sees: by default as many numbers of the state as an observation has.
    fn observe(&self, state: &Self::State, observation: &mut [f32]) {
        let numbers = &state.as_ref()[Self::FIRST_SEEN..];
        observation.iter_mut().zip(numbers).for_each(|(o, s)| *o = *s as f32);
    }

    /// Takes an action; returns the reward, and whether nothing can follow.
    fn act(&self, state: &mut Self::State, action: &[f32]) -> (f64, bool);

    /// Returns what an episode that is over came to, of its last state, the sum of its rewards and its steps.
    fn score(&self, _state: &Self::State, total: f64, _steps: u32) -> f64 {
        total
    }
}

/// Dynamics, episode after episode.
#[derive(Debug, Clone, PartialEq)]
pub struct Episodes<D: Dynamics> {
    pub(crate) dynamics: D,
    pub(crate) state: D::State,
    steps: u32,
}

impl<D: Dynamics> Episodes<D> {
    /// Returns an environment before its first episode.
    pub fn of(dynamics: D) -> Self {
        Self { dynamics, state: D::State::default(), steps: 0 }
    }
}

impl<D: Dynamics> Environment for Episodes<D> {
    fn width(&self) -> usize {
        D::WIDTH
    }

    fn actions(&self) -> Actions {
        self.dynamics.actions()
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) {
        self.state = self.dynamics.start(&mut Generator::new(seed, &[D::LABEL, "start"]));
        self.steps = 0;
        self.dynamics.observe(&self.state, observation);
    }

    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Step {
        heartbeat::beat(1);
        let (reward, terminated) = self.dynamics.act(&mut self.state, action);
        self.steps += 1;
        self.dynamics.observe(&self.state, observation);
        Step { reward: reward as f32, terminated, truncated: self.steps >= D::HORIZON }
    }

    fn score(&self, total: f64) -> f64 {
        self.dynamics.score(&self.state, total, self.steps)
    }
}

impl<D: Dynamics> State for Episodes<D> {
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
