//! A generator of random numbers whose state can be kept.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::nn::archive::{Archive, ArchiveError};
use crate::nn::state::State;
use basics::seed::derive;

/// One source of randomness, with a seed of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Generator(ChaCha8Rng);

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
}

/// Its next number follows from a seed and a place of 68 bits, which JSON takes in two halves.
impl State for Generator {
    fn save(&self, prefix: &str, archive: &mut Archive) {
        let place = self.0.get_word_pos();
        archive.put(prefix, (self.0.get_seed(), (place >> 64) as u64, place as u64));
    }

    fn restore(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        let (seed, high, low): ([u8; 32], u64, u64) = archive.get(prefix)?;
        self.0 = ChaCha8Rng::from_seed(seed);
        self.0.set_word_pos(u128::from(high) << 64 | u128::from(low));
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
