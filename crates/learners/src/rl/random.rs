//! A generator of random numbers whose state can be kept.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::nn::archive::{Archive, ArchiveError};
use basics::seed::derive;

/// One source of randomness, with a seed of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Generator(ChaCha8Rng);

/// What a generator's next number follows from.
#[derive(Debug, Serialize, Deserialize)]
struct State {
    seed: [u8; 32],
    /// A number of 68 bits, which JSON readers would round.
    word: String,
}

impl Generator {
    /// Returns the generator for what `labels` name.
    pub fn new(seed: u64, labels: &[&str]) -> Self {
        Self(ChaCha8Rng::seed_from_u64(derive(seed, labels)))
    }

    /// Returns a number from 0 up to but without 1.
    pub fn unit(&mut self) -> f64 {
        self.0.random()
    }

    /// Returns a whole number below `end`.
    pub fn below(&mut self, end: usize) -> usize {
        self.0.random_range(0..end)
    }

    /// Returns a standard normal number (Box and Muller, 1958), the same on every machine.
    pub fn normal(&mut self) -> f64 {
        let radius = libm::sqrt(-2.0 * libm::log(1.0 - self.unit()));
        radius * libm::cos(2.0 * std::f64::consts::PI * self.unit())
    }

    /// The generator itself, for distributions.
    pub fn rng(&mut self) -> &mut ChaCha8Rng {
        &mut self.0
    }

    /// Adds the state to an archive.
    pub fn save(&self, name: &str, archive: &mut Archive) {
        let word = self.0.get_word_pos().to_string();
        archive.put(name, State { seed: self.0.get_seed(), word });
    }

    /// Takes the state from an archive.
    ///
    /// # Errors
    ///
    /// [`ArchiveError::Card`] when it is not there.
    pub fn restore(&mut self, name: &str, archive: &Archive) -> Result<(), ArchiveError> {
        let state: State = archive.get(name)?;
        let word = state.word.parse().map_err(|_| ArchiveError::Card(name.to_owned()))?;
        self.0 = ChaCha8Rng::from_seed(state.seed);
        self.0.set_word_pos(word);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_numbers_have_mean_0_deviation_1_and_tails() {
        let mut generator = Generator::new(1, &[]);
        let numbers: Vec<f64> = (0..100_000).map(|_| generator.normal()).collect();
        let moment = |k| numbers.iter().map(|x| f64::powi(*x, k)).sum::<f64>() / 1e5;
        let found = [moment(1), moment(2), moment(3), moment(4)];
        for (found, expected) in found.into_iter().zip([0.0, 1.0, 0.0, 3.0]) {
            assert!((found - expected).abs() < 0.06, "{found} {expected}");
        }
    }

    #[test]
    fn a_restored_generator_goes_on_as_before() {
        let mut one = Generator::new(1, &["a"]);
        for _ in 0..13 {
            one.unit();
        }
        let mut archive = Archive::default();
        one.save("g", &mut archive);
        let mut other = Generator::new(2, &["b"]);
        other.restore("g", &archive).unwrap();
        assert_eq!(one.unit(), other.unit());
        assert_eq!(one.below(1000), other.below(1000));
        assert!(other.restore("h", &archive).is_err());
    }
}
