//! Environments whose answers are known, updates of other programs, and what every trainer must do in it.

use super::Trainer;
use super::off_policy::Batch;
use crate::nn::archive::{Archive, ArchiveError};
use crate::nn::state::State;
use crate::rl::environment::{self, Actions, Environment, Step};

/// Five states in a row, two actions: the right end pays 1 and ends the episode, which is cut after 20 steps.
#[derive(Debug, Clone, Default)]
pub(super) struct Corridor {
    at: usize,
    steps: u32,
}

impl Corridor {
    pub(super) const HORIZON: u32 = 20;

    pub(super) fn one_hot(at: usize) -> [f32; 5] {
        std::array::from_fn(|i| f32::from(u8::from(i == at)))
    }
}

impl Environment for Corridor {
    fn width(&self) -> usize {
        5
    }

    fn actions(&self) -> Actions {
        Actions::Numbered(2)
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) {
        *self = Self { at: (seed % 2) as usize, steps: 0 };
        observation.copy_from_slice(&Self::one_hot(self.at));
    }

    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Step {
        self.at = if action[0] == 1.0 { self.at + 1 } else { self.at.saturating_sub(1) };
        self.steps += 1;
        observation.copy_from_slice(&Self::one_hot(self.at));
        let terminated = self.at == 4;
        let truncated = self.steps >= Self::HORIZON;
        Step { reward: f32::from(u8::from(terminated)), terminated, truncated }
    }
}

impl State for Corridor {
    fn save(&self, prefix: &str, archive: &mut Archive) {
        archive.put(&format!("{prefix}corridor"), (self.at, self.steps));
    }

    fn restore(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        (self.at, self.steps) = archive.get(&format!("{prefix}corridor"))?;
        Ok(())
    }
}

/// A place on a line that every action moves: it costs the square of the place, and a little for the action. Episodes
/// take 20 steps, from 0.8 on either side.
#[derive(Debug, Clone)]
pub(super) struct Slider {
    width: usize,
    actions: usize,
    place: f32,
    steps: u32,
}

impl Default for Slider {
    fn default() -> Self {
        Self::of(1, 1)
    }
}

impl Slider {
    /// Returns one whose observations and actions have further numbers, which mean nothing.
    pub(super) fn of(width: usize, actions: usize) -> Self {
        Self { width, actions, place: 0.0, steps: 0 }
    }
}

impl Environment for Slider {
    fn width(&self) -> usize {
        self.width
    }

    fn actions(&self) -> Actions {
        Actions::Continuous { count: self.actions, limit: 2.0 }
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) {
        self.place = if seed.is_multiple_of(2) { 0.8 } else { -0.8 };
        self.steps = 0;
        observation.fill(0.0);
        observation[0] = self.place;
    }

    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Step {
        assert!(action[0].abs() <= 2.0, "an action beyond the limit: {action:?}");
        let reward = -self.place * self.place - 0.01 * action[0] * action[0];
        self.place = (self.place + 0.25 * action[0]).clamp(-1.0, 1.0);
        self.steps += 1;
        observation[0] = self.place;
        Step { reward, terminated: false, truncated: self.steps >= 20 }
    }
}

impl State for Slider {
    fn save(&self, prefix: &str, archive: &mut Archive) {
        archive.put(&format!("{prefix}slider"), (self.place, self.steps));
    }

    fn restore(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        (self.place, self.steps) = archive.get(&format!("{prefix}slider"))?;
        Ok(())
    }
}

pub(super) struct Update(serde_json::Value);

impl Update {
    pub(super) fn numbers(&self, name: &str) -> Vec<f32> {
        let value = name.split('.').fold(&self.0, |value, part| match part.parse::<usize>() {
            Ok(place) => &value[place],
            Err(_) => &value[part],
        });
        let one = std::slice::from_ref(value);
        let all = value.as_array().map_or(one, Vec::as_slice);
        all.iter().map(|n| n.as_f64().unwrap_or_else(|| panic!("no {name}")) as f32).collect()
    }

    pub(super) fn check(&self, name: &str, found: &[f32], tolerance: f32) {
        let expected = self.numbers(name);
        assert_eq!(found.len(), expected.len(), "{name}");
        for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
            assert!((found - expected).abs() < tolerance, "{name} {i}: {found}, not {expected}");
        }
    }

    pub(super) fn batch(&self) -> Batch {
        let [states, actions, nexts, rewards, follows] =
            ["states", "actions", "nexts", "rewards", "follows"].map(|name| self.numbers(name));
        let rows = rewards.len();
        let (width, count) = (states.len() / rows, actions.len() / rows);
        let pairs =
            states.chunks(width).zip(actions.chunks(count)).flat_map(|(s, a)| [s, a].concat());
        Batch { pairs: pairs.collect(), states, nexts, rewards, follows }
    }
}

pub(super) fn updates() -> std::collections::BTreeMap<String, Update> {
    let text = include_str!("../../../tests/data/sb3-updates.json");
    let all: std::collections::BTreeMap<String, serde_json::Value> =
        serde_json::from_str(text).unwrap();
    all.into_iter().map(|(name, update)| (name, Update(update))).collect()
}

pub(super) fn play(trainer: &mut dyn Trainer) -> u32 {
    episode(&Corridor::default(), trainer).steps
}

pub(super) fn outcome<E: Environment + Clone>(environment: &E, trainer: &mut dyn Trainer) -> f64 {
    episode(environment, trainer).total
}

fn episode<E: Environment + Clone>(
    environment: &E,
    trainer: &mut dyn Trainer,
) -> environment::Outcome {
    let policy = &mut |observation: &[f32], action: &mut [f32]| trainer.act(observation, action);
    environment::play(&mut environment.clone(), 0, policy)
}

fn bytes(save: impl Fn(&mut Archive)) -> Vec<u8> {
    let mut archive = Archive::default();
    save(&mut archive);
    archive.to_bytes()
}

/// Checks that a training that stops and is restored ends in the bytes of one that does not, wherever it
/// stops, and that what it learned can be taken over.
pub(super) fn check_trainer<T: Trainer, E: Environment + Clone>(
    environment: &E,
    new: impl Fn(u64) -> T,
) {
    let seeds = &mut |k| u64::from(k) * 7919;
    let mut whole = new(5);
    whole.advance(u64::MAX, seeds);
    assert!(whole.finished() && whole.is_finite());
    for stop in [1, 333, 1000] {
        let mut first = new(5);
        let progress = first.advance(stop, seeds);
        assert_eq!(progress.steps, first.steps());
        assert!(first.steps() >= stop && !first.finished());
        let mut kept = Archive::default();
        first.save("t.", &mut kept);
        // What another seed began with is all replaced.
        let mut second = new(6);
        second.restore("t.", &kept).unwrap();
        let rest = second.advance(u64::MAX, seeds);
        assert!(rest.episodes > 0 && rest.mean_return.is_some());
        assert_eq!(rest.mean_return, rest.mean_score);
        assert!(bytes(|a| second.save("", a)) == bytes(|a| whole.save("", a)), "{stop}");
        assert!(second.restore("u.", &kept).is_err());
    }
    assert!(bytes(|a| new(6).save("", a)) != bytes(|a| new(5).save("", a)));
    let mut learned = Archive::default();
    whole.learned("m.", &mut learned);
    let mut other = new(6);
    other.load("m.", &learned).unwrap();
    assert!(bytes(|a| other.learned("", a)) == bytes(|a| whole.learned("", a)));
    assert_eq!(episode(environment, &mut other), episode(environment, &mut whole));
    assert!(other.load("n.", &learned).is_err());
}
