//! Augmented random search (Mania et al., 2018), as sb3-contrib's `ARS` with its `LinearPolicy`.
//!
//! Choices where implementations differ:
//! - **Policy**: a matrix without biases that begins with zeros. Of numbered actions the one with the largest product is
//!   taken, the first of several; continuous actions are cut to what the environment allows.
//! - **Observations** are not normalised (version 1 of the paper).
//! - **A step**: every direction is tried both ways for an episode each; the best directions, by the better of their two
//!   returns, count. The step is divided by their number and the (unbiased) deviation of their returns.
//! - **Training** is the trying: an update takes as many steps as its episodes do.

use basics::setting::settings;

use super::distribution::{Distribution, Flavour};
use super::{Lanes, Progress, Trainer};
use crate::nn::archive::{Archive, ArchiveError};
use crate::nn::state::{Learned, State, kept};
use crate::rl::environment::Environment;
use crate::rl::persist::Persist;
use crate::rl::random::Generator;

/// Added to what a step is divided by.
const STEP_EPSILON: f32 = 1e-6;

settings! {
    /// Hyper-parameters of `ars`; the defaults are those of sb3-contrib.
    pub struct Settings, source "sb3-contrib 2.9, ARS with LinearPolicy" {
        /// Steps of the training; the update that begins before this many are done is completed.
        total_steps: u64 = 100_000, in 1.0..=1e9, unit "steps",
            source "Jayawardana et al., 2022, give none for most tasks";
        /// Directions of an update, each tried both ways for an episode.
        directions: usize = 8, in 1.0..=1e4, unit "directions";
        /// How many directions count: those with the highest return in either way. If there are fewer directions, all
        /// count.
        best_directions: usize = 8, in 1.0..=1e4, unit "directions";
        /// Size of a step.
        learning_rate: f32 = 0.02, in 1e-8..=1e3;
        /// Deviation of what is added to each weight when a direction is tried.
        deviation: f32 = 0.05, in 1e-8..=1e3;
        /// Added to the return for every step of an episode.
        alive_bonus: f32 = 0.0, in -1e3..=1e3;
    }
}

/// A training.
#[derive(Debug, Clone)]
pub struct Ars<E> {
    settings: Settings,
    distribution: Distribution,
    lane: Lanes<E>,
    draws: Generator,
    steps: u64,
    /// Shape `[outputs, observation]`.
    weights: Vec<f32>,
    tried: Vec<f32>,
    directions: Vec<f32>,
    returns: Vec<[f32; 2]>,
    order: Vec<usize>,
    outputs: Vec<f32>,
    action: Vec<f32>,
    after: Vec<f32>,
}

impl<E: Environment> Ars<E> {
    /// Returns a training that has not begun.
    pub fn new(settings: Settings, environment: E, seed: u64) -> Self {
        let lane = Lanes::new(vec![environment]);
        let (width, actions) = (lane.width(), lane.actions());
        let count = width * actions.outputs();
        Self {
            draws: Generator::new(seed, &["directions"]),
            steps: 0,
            weights: vec![0.0; count],
            tried: vec![0.0; count],
            directions: vec![0.0; count * settings.directions],
            returns: vec![[0.0; 2]; settings.directions],
            order: Vec::new(),
            outputs: vec![0.0; actions.outputs()],
            action: vec![0.0; actions.width()],
            after: vec![0.0; width],
            distribution: Distribution::new(actions, Flavour::StableBaselines3),
            lane,
            settings,
        }
    }

    fn play(&mut self, seeds: &mut dyn FnMut(u32) -> u64) -> f32 {
        self.lane.begin(seeds);
        let mut total = 0.0f64;
        loop {
            say(&self.tried, self.lane.observation(0), &mut self.outputs);
            self.distribution.best(&self.outputs, &mut self.action);
            let step = self.lane.step(0, &self.action, &mut self.after, seeds);
            total += f64::from(step.reward + self.settings.alive_bonus);
            self.steps += 1;
            if step.over() {
                return total as f32;
            }
        }
    }

    fn update(&mut self, seeds: &mut dyn FnMut(u32) -> u64) {
        let (count, deviation) = (self.weights.len(), self.settings.deviation);
        let draws = &mut self.draws;
        self.directions.iter_mut().for_each(|d| *d = draws.normal() as f32);
        for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
            for k in 0..self.settings.directions {
                let direction = &self.directions[k * count..][..count];
                let tried = self.tried.iter_mut().zip(&self.weights).zip(direction);
                tried.for_each(|((t, w), d)| *t = w + sign * (d * deviation));
                self.returns[k][side] = self.play(seeds);
            }
        }
        self.step();
    }

    fn step(&mut self) {
        let (count, returns) = (self.weights.len(), &self.returns);
        let best = |k: &usize| returns[*k][0].max(returns[*k][1]);
        self.order.clear();
        self.order.extend(0..returns.len());
        self.order.sort_by(|a, b| best(b).total_cmp(&best(a)));
        self.order.truncate(self.settings.best_directions);
        let numbers = || self.order.iter().flat_map(|k| returns[*k]);
        let number = 2.0 * self.order.len() as f32;
        let mean = numbers().sum::<f32>() / number;
        let squares: f32 = numbers().map(|r| (r - mean) * (r - mean)).sum();
        let spread = (squares / (number - 1.0)).sqrt();
        let size = self.settings.learning_rate / (self.order.len() as f32 * spread + STEP_EPSILON);
        for k in &self.order {
            let gain = size * (returns[*k][0] - returns[*k][1]);
            let direction = &self.directions[k * count..][..count];
            self.weights.iter_mut().zip(direction).for_each(|(w, d)| *w += gain * d);
        }
    }
}

fn say(weights: &[f32], observation: &[f32], outputs: &mut [f32]) {
    for (output, row) in outputs.iter_mut().zip(weights.chunks_exact(observation.len())) {
        *output = row.iter().zip(observation).map(|(w, o)| w * o).sum();
    }
}

impl<E: Environment> Trainer for Ars<E> {
    fn advance(&mut self, steps: u64, seeds: &mut dyn FnMut(u32) -> u64) -> Progress {
        while !self.finished() && self.steps < steps {
            self.update(seeds);
        }
        Progress { steps: self.steps, ..self.lane.report() }
    }

    fn steps(&self) -> u64 {
        self.steps
    }

    fn finished(&self) -> bool {
        self.steps >= self.settings.total_steps
    }

    fn act(&mut self, observation: &[f32], action: &mut [f32]) {
        say(&self.weights, observation, &mut self.outputs);
        self.distribution.best(&self.outputs, action);
    }
}

impl<E: Environment> Persist for Ars<E> {
    fn is_finite(&self) -> bool {
        self.weights.iter().all(|w| w.is_finite())
    }

    /// A matrix that is not zero says something of the state, and none of its units can die.
    fn is_alive(&mut self) -> bool {
        self.weights.iter().any(|w| *w != 0.0)
    }
}

impl<E> Learned for Ars<E> {
    fn learned(&self, prefix: &str, archive: &mut Archive) {
        let shape = [self.outputs.len(), self.after.len()];
        archive.put_f32(format!("{prefix}policy.weight"), &shape, &self.weights);
    }

    fn load(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        let shape = [self.outputs.len(), self.after.len()];
        self.weights = archive.finite(&format!("{prefix}policy.weight"), &shape)?;
        Ok(())
    }
}

impl<E: Environment> State for Ars<E> {
    kept! { State { "steps": steps, "weights": weights, "draws": draws, "": lane } }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Corridor, Slider, check_trainer, outcome, updates};
    use super::*;

    fn settings() -> Settings {
        Settings { total_steps: 4000, directions: 4, best_directions: 3, ..Settings::default() }
    }

    #[test]
    fn a_step_is_that_of_sb3_contrib() {
        let update = &updates()["ars"];
        let mut ars = Ars::new(settings(), Slider::of(3, 2), 1);
        ars.directions = update.numbers("directions");
        let returns = update.numbers("returns");
        ars.returns = (0..4).map(|k| [returns[k], returns[4 + k]]).collect();
        ars.step();
        update.check("then", &ars.weights, 1e-5);
    }

    #[test]
    fn a_training_can_stop_after_every_update_and_learns() {
        check_trainer(&Corridor::default(), |seed| Ars::new(settings(), Corridor::default(), seed));
        check_trainer(&Slider::default(), |seed| Ars::new(settings(), Slider::default(), seed));
        let mut ars =
            Ars::new(Settings { total_steps: 40_000, ..settings() }, Slider::default(), 3);
        ars.advance(u64::MAX, &mut |k| u64::from(k));
        let total = outcome(&Slider::default(), &mut ars);
        assert!(total > -1.5, "{total}");
    }
}
