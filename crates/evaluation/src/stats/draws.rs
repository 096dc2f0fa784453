//! Indices drawn with replacement, many at a time.
//!
//! A report draws some 10^9 of them. What is drawn is what `random_range` draws one by one, index for index: a word of
//! the generator times the number of values, whose upper half counts. Where the lower half asks for a second word, which
//! happens once in 10^8 draws, the generator goes back and the draws around it are drawn one by one.

use rand::{Rng, RngExt};
use rand_chacha::ChaCha8Rng;

/// Words that are taken from the generator at a time.
const AT_ONCE: usize = 256;

/// What is drawn in one resample, group after group.
pub(super) struct Draws {
    /// Groups of as many values that follow one another: number of values, and of draws.
    runs: Vec<(u32, usize)>,
    len: usize,
}

/// Returns how many of `n` values a resample draws: one less, but the only one where there is one.
pub(super) fn size(n: usize) -> usize {
    if n == 1 { 1 } else { n.saturating_sub(1) }
}

impl Draws {
    /// Returns the draws from groups of so many values each.
    pub(super) fn of(groups: impl Iterator<Item = usize>) -> Self {
        let mut runs: Vec<(u32, usize)> = Vec::new();
        for n in groups.filter(|n| *n > 0) {
            let values = u32::try_from(n).expect("seeds and replicates are numbered with 32 bits");
            match runs.last_mut() {
                Some((of, count)) if *of == values => *count += size(n),
                _ => runs.push((values, size(n))),
            }
        }
        let len = runs.iter().map(|run| run.1).sum();
        Self { runs, len }
    }

    /// Returns the number of indices of a resample.
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// Writes the indices of as many resamples as there is room for.
    pub(super) fn fill(&self, rng: &mut ChaCha8Rng, drawn: &mut [u32]) {
        if let [(values, _)] = self.runs[..] {
            return fill(values, rng, drawn);
        }
        for mut rest in drawn.chunks_exact_mut(self.len.max(1)) {
            for (values, count) in &self.runs {
                let own;
                (own, rest) = rest.split_at_mut(*count);
                fill(*values, rng, own);
            }
        }
    }
}

/// Writes indices below `values`; of one value the only one, for which nothing is drawn.
fn fill(values: u32, rng: &mut ChaCha8Rng, drawn: &mut [u32]) {
    if values < 2 {
        return drawn.fill(0);
    }
    let mut bytes = [0; 4 * AT_ONCE];
    for part in drawn.chunks_mut(AT_ONCE) {
        let before = rng.clone();
        let bytes = &mut bytes[..4 * part.len()];
        rng.fill_bytes(bytes);
        let mut asks_for_more = false;
        for (drawn, word) in part.iter_mut().zip(bytes.as_chunks().0) {
            let product = u64::from(u32::from_le_bytes(*word)) * u64::from(values);
            *drawn = (product >> 32) as u32;
            asks_for_more |= product as u32 > values.wrapping_neg();
        }
        if asks_for_more {
            *rng = before;
            part.iter_mut().for_each(|drawn| *drawn = rng.random_range(0..values));
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;

    /// Returns what a plain generator draws from such groups, resample after resample.
    fn one_by_one(groups: &[usize], rng: &mut ChaCha8Rng, resamples: usize) -> Vec<u32> {
        let draw = |n: &usize| match *n {
            1 => vec![0],
            n => (1..n).map(|_| rng.random_range(0..n) as u32).collect(),
        };
        std::iter::repeat_n(groups, resamples).flatten().flat_map(draw).collect()
    }

    #[test]
    fn what_is_drawn_at_once_is_what_is_drawn_one_by_one() {
        let many = vec![11; 100];
        for groups in [&[2][..], &[1, 1], &[11, 11, 1, 5, 0, 2], &many, &[100_000, 3]] {
            let draws = Draws::of(groups.iter().copied());
            let [mut at_once, mut plain] = [1, 1].map(ChaCha8Rng::seed_from_u64);
            let mut drawn = vec![9; 7 * draws.len()];
            draws.fill(&mut at_once, &mut drawn);
            assert_eq!(drawn, one_by_one(groups, &mut plain, 7));
            assert_eq!(at_once.next_u32(), plain.next_u32());
        }
    }

    #[test]
    fn draws_that_take_a_second_word_are_the_same() {
        // Of so many values nearly half of the draws do.
        let values = 3 << 30;
        let [mut at_once, mut plain] = [2, 2].map(ChaCha8Rng::seed_from_u64);
        let mut drawn = vec![0; 1000];
        fill(values, &mut at_once, &mut drawn);
        let expected: Vec<u32> =
            (0..1000).map(|_| plain.random_range(0..values as usize) as u32).collect();
        assert_eq!(drawn, expected);
        assert_eq!(at_once.next_u32(), plain.next_u32());
    }
}
