//! An environment whose answer is known, and what every trainer must do in it.

use super::Trainer;
use crate::nn::archive::{Archive, ArchiveError};
use crate::rl::environment::{self, Environment, Step};

/// Five states in a row, two actions: the right end pays 1 and ends the episode, which is cut after 20 steps.
#[derive(Debug, Clone, Default)]
pub(super) struct Corridor {
    at: usize,
    steps: u32,
}

impl Corridor {
    /// Steps after which an episode is cut.
    pub(super) const HORIZON: u32 = 20;

    /// Returns a state as it is observed.
    pub(super) fn one_hot(at: usize) -> [f32; 5] {
        std::array::from_fn(|i| f32::from(u8::from(i == at)))
    }
}

impl Environment for Corridor {
    fn width(&self) -> usize {
        5
    }

    fn actions(&self) -> usize {
        2
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) {
        *self = Self { at: (seed % 2) as usize, steps: 0 };
        observation.copy_from_slice(&Self::one_hot(self.at));
    }

    fn step(&mut self, action: usize, observation: &mut [f32]) -> Step {
        self.at = if action == 1 { self.at + 1 } else { self.at.saturating_sub(1) };
        self.steps += 1;
        observation.copy_from_slice(&Self::one_hot(self.at));
        let terminated = self.at == 4;
        let truncated = self.steps >= Self::HORIZON;
        Step { reward: f32::from(u8::from(terminated)), terminated, truncated }
    }

    fn save(&self, prefix: &str, archive: &mut Archive) {
        archive.put(&format!("{prefix}corridor"), (self.at, self.steps));
    }

    fn restore(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        (self.at, self.steps) = archive.get(&format!("{prefix}corridor"))?;
        Ok(())
    }
}

/// Returns the steps from the left end to the right one.
pub(super) fn play(trainer: &mut dyn Trainer) -> u32 {
    environment::play(&mut Corridor::default(), 0, &mut |observation| trainer.act(observation))
        .steps
}

fn bytes(save: impl Fn(&mut Archive)) -> Vec<u8> {
    let mut archive = Archive::default();
    save(&mut archive);
    archive.to_bytes()
}

/// Checks that a training that stops and is restored ends in the bytes of one that does not, wherever it
/// stops, and that what it learned can be taken over.
pub(super) fn check_trainer<T: Trainer>(new: impl Fn(u64) -> T) {
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
        assert!(rest.episodes > 0 && rest.mean_return.is_some() && rest.loss.is_some());
        assert!(bytes(|a| second.save("", a)) == bytes(|a| whole.save("", a)), "{stop}");
        assert!(second.restore("u.", &kept).is_err());
    }
    assert!(bytes(|a| new(6).save("", a)) != bytes(|a| new(5).save("", a)));
    let mut learned = Archive::default();
    whole.learned("m.", &mut learned);
    let mut other = new(6);
    other.load("m.", &learned).unwrap();
    assert!(bytes(|a| other.learned("", a)) == bytes(|a| whole.learned("", a)));
    assert_eq!(play(&mut other), play(&mut whole));
    assert!(other.load("n.", &learned).is_err());
}
