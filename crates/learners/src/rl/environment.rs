//! What an algorithm learns in: states as vectors of numbers, actions that are numbered or vectors, rewards.

use crate::nn::state::State;

/// What an action led to, beside the state after it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Reward received.
    pub reward: f32,
    /// Whether nothing can follow: the state after is worth nothing.
    pub terminated: bool,
    /// Whether the episode was cut by a limit of time: the state after has its value.
    pub truncated: bool,
}

impl Step {
    /// Whether the episode is over, for either reason.
    pub fn over(&self) -> bool {
        self.terminated || self.truncated
    }
}

/// What an agent can do in a step. In either case an action is a slice of [`Actions::width`] numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Actions {
    /// One of so many, numbered from 0.
    Numbered(usize),
    /// Numbers, each from `-limit` to `limit`.
    Continuous {
        /// How many numbers.
        count: usize,
        /// The largest of them, in the environment's unit.
        limit: f32,
    },
}

impl Actions {
    /// Returns how many numbers an action has.
    pub fn width(self) -> usize {
        match self {
            Self::Numbered(_) => 1,
            Self::Continuous { count, .. } => count,
        }
    }

    /// Returns how many numbers a policy gives for a state: a logit or value per numbered action, or the action itself.
    pub fn outputs(self) -> usize {
        match self {
            Self::Numbered(count) | Self::Continuous { count, .. } => count,
        }
    }
}

/// A decision process of one agent, as in gymnasium. Its state is that of a running episode.
pub trait Environment: State {
    /// Numbers of an observation.
    fn width(&self) -> usize;

    /// What an agent can do.
    fn actions(&self) -> Actions;

    /// Begins the episode of a seed and writes its first observation.
    fn reset(&mut self, seed: u64, observation: &mut [f32]);

    /// Takes an action and writes the observation after it.
    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Step;

    /// Returns what an episode that is over, with this sum of rewards, came to in the unit that methods are judged by.
    fn score(&self, total: f64) -> f64 {
        total
    }
}

/// What an episode came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// Sum of rewards.
    pub total: f64,
    /// What [`Environment::score`] says of it.
    pub score: f64,
    /// Steps it took.
    pub steps: u32,
}

/// Plays the episode of a seed with a policy.
pub fn play(
    environment: &mut dyn Environment,
    seed: u64,
    policy: &mut dyn FnMut(&[f32], &mut [f32]),
) -> Outcome {
    let mut observation = vec![0.0; environment.width()];
    let mut action = vec![0.0; environment.actions().width()];
    environment.reset(seed, &mut observation);
    let mut outcome = Outcome { total: 0.0, score: 0.0, steps: 0 };
    loop {
        policy(&observation, &mut action);
        let step = environment.step(&action, &mut observation);
        outcome.total += f64::from(step.reward);
        outcome.steps += 1;
        if step.over() {
            outcome.score = environment.score(outcome.total);
            return outcome;
        }
    }
}
