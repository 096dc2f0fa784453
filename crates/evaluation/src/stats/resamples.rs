//! Resamples of what was measured: seeds, replicates and the choice of point MDPs drawn anew, many times over.
//!
//! What a resample is, is said in [`super::bootstrap`]. A report takes thousands of resamples of every method and of
//! every two, so here nothing is allocated per resample: what was measured lies in one list, and means are written
//! over those of the resample before.
//!
//! A report draws some 10^9 of them. What is drawn is what `random_range` draws one by one, index for index: a word of
//! the generator times the number of values, whose upper half counts. Where the lower half asks for a second word, which
//! happens once in 10^8 draws, the generator goes back and the draws around it are drawn one by one.

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{PointMeans, PointObjectives, Resampling};

/// Stream of the generator that the choice of point MDPs is drawn from; seeds are drawn from stream 0.
const CHOICE: u64 = 1;

/// Takes a resample: the means after seeds and replicates were drawn anew, the same with the weights that the design gives, where
/// it gives others, and the factor by which the change from the first to the second is multiplied.
type Take<'a> = dyn FnMut(&[PointMeans], Option<&[PointMeans]>, f64) + 'a;

/// Resamples what was measured `count` times; not at all when the spread cannot be estimated or there is none.
pub(super) fn resample(
    (points, whole): (&[PointObjectives], &[PointMeans]),
    resampling: &Resampling,
    rng: &mut ChaCha8Rng,
    trainings: u64,
    count: usize,
    take: &mut Take<'_>,
) {
    let between = resampling.draws_points();
    if !resampling.is_known() || !(between || has_noise(points)) {
        return;
    }
    let weights: Vec<f64> = points.iter().map(|p| p.weight).collect();
    let mut replicates = replicates(rng, trainings);
    let mut choice = choice(rng);
    let measured = Measured::of(points);
    let mut drawn = measured.drawn();
    let mut within = whole.to_vec();
    let mut moved = if between { whole.to_vec() } else { Vec::new() };
    let mut new_weights = Vec::with_capacity(weights.len());
    for _ in 0..count {
        let mut factor = 1.0;
        if between {
            factor = resampling.factor(&mut choice);
            resampling.moved(&weights, &mut choice, &mut new_weights);
        }
        measured.draw_anew(whole, (rng, &mut replicates), &mut drawn, &mut within);
        for ((moved, within), weight) in moved.iter_mut().zip(&within).zip(&new_weights) {
            *moved = PointMeans { weight: *weight, ..*within };
        }
        take(&within, between.then_some(&moved[..]), factor);
    }
}

/// Whether seeds or replicates can be drawn anew.
fn has_noise(points: &[PointObjectives]) -> bool {
    points.iter().any(|p| p.baseline.len() > 1 || p.method.len() > 1)
}

fn replicates(rng: &mut ChaCha8Rng, trainings: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(rng.next_u64().wrapping_add(trainings))
}

/// Returns the source of the choice of point MDPs, apart from that of the seeds: so methods of which the choice is drawn anew
/// have the same seeds as others.
fn choice(rng: &ChaCha8Rng) -> ChaCha8Rng {
    let mut choice = rng.clone();
    choice.set_stream(CHOICE);
    choice
}

/// What was measured on all point MDPs, in one list.
struct Measured {
    /// Per point MDP the baseline's objectives by seed, then those of every replicate.
    values: Vec<f64>,
    /// Number of seeds and of replicates of every point MDP.
    shapes: Vec<(usize, usize)>,
    /// What the baseline's drawn seeds sum to, where it is the same on all seeds of a point MDP, as with shares of wins.
    sums: Vec<Option<f64>>,
}

/// Indices that are drawn in a resample; kept so that there is one list for all.
struct Drawn {
    of_seeds: Draws,
    of_replicates: Draws,
    seeds: Vec<u32>,
    replicates: Vec<u32>,
}

impl Measured {
    fn of(points: &[PointObjectives]) -> Self {
        let mut values = Vec::new();
        for point in points {
            values.extend(&point.baseline);
            point.method.iter().for_each(|replicate| values.extend(replicate));
        }
        let shapes = points.iter().map(|p| (p.baseline.len(), p.method.len())).collect();
        let sum = |p: &PointObjectives| {
            let first = p.baseline.first()?;
            let same = p.baseline.iter().all(|b| b == first);
            same.then(|| std::iter::repeat_n(first, size(p.baseline.len())).sum())
        };
        Self { values, shapes, sums: points.iter().map(sum).collect() }
    }

    fn drawn(&self) -> Drawn {
        let of_seeds = Draws::of(self.shapes.iter().map(|shape| shape.0));
        let of_replicates = Draws::of(self.shapes.iter().map(|shape| shape.1));
        let (seeds, replicates) = (vec![0; of_seeds.len()], vec![0; of_replicates.len()]);
        Drawn { of_seeds, of_replicates, seeds, replicates }
    }

    /// Writes the means after drawing seeds and replicates anew; `whole` is what all of them give.
    fn draw_anew(
        &self,
        whole: &[PointMeans],
        (seeds, replicates): (&mut ChaCha8Rng, &mut ChaCha8Rng),
        drawn: &mut Drawn,
        means: &mut [PointMeans],
    ) {
        drawn.of_seeds.fill(seeds, &mut drawn.seeds);
        drawn.of_replicates.fill(replicates, &mut drawn.replicates);
        let (mut seeds, mut replicates) = (&drawn.seeds[..], &drawn.replicates[..]);
        let mut rest = &self.values[..];
        let points = self.shapes.iter().zip(&self.sums);
        for ((mean, whole), ((n, r), same)) in means.iter_mut().zip(whole).zip(points) {
            let (baseline, others) = rest.split_at(*n);
            let (method, others) = others.split_at(n * r);
            rest = others;
            let (of_seeds, other_seeds) = seeds.split_at(size(*n));
            let (of_replicates, other_replicates) = replicates.split_at(size(*r));
            (seeds, replicates) = (other_seeds, other_replicates);
            let (bottom, sum) = match of_seeds {
                [seed] => {
                    let of_seed = &method[*seed as usize..];
                    let of = |r: &u32| of_seed[*r as usize * n];
                    (baseline[*seed as usize], of_replicates.iter().map(of).sum::<f64>())
                }
                _ => {
                    let of_drawn =
                        |values: &[f64]| of_seeds.iter().map(|k| values[*k as usize]).sum::<f64>();
                    let of = |r: &u32| of_drawn(&method[*r as usize * n..][..*n]);
                    let bottom = same.unwrap_or_else(|| of_drawn(baseline));
                    (bottom, of_replicates.iter().map(of).sum::<f64>())
                }
            };
            let top = sum / of_replicates.len() as f64;
            // Only a point MDP where some seeds bring no delay at all can come here with 0.
            *mean = if bottom <= 0.0 {
                *whole
            } else {
                let n = of_seeds.len() as f64;
                PointMeans { method: top / n, baseline: bottom / n, score: top / bottom, ..*whole }
            };
        }
    }
}

/// Words that are taken from the generator at a time.
const AT_ONCE: usize = 256;

/// What is drawn in one resample, group after group.
struct Draws {
    /// Groups of as many values that follow one another: number of values, and of draws.
    runs: Vec<(u32, usize)>,
    len: usize,
}

/// Returns how many of `n` values a resample draws: one less, but the only one where there is one.
fn size(n: usize) -> usize {
    if n == 1 { 1 } else { n.saturating_sub(1) }
}

impl Draws {
    /// Returns the draws from groups of so many values each.
    fn of(groups: impl Iterator<Item = usize>) -> Self {
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
    fn len(&self) -> usize {
        self.len
    }

    /// Writes the indices of as many resamples as there is room for.
    fn fill(&self, rng: &mut ChaCha8Rng, drawn: &mut [u32]) {
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
    use super::*;

    #[test]
    fn seeds_without_any_delay_leave_the_means_as_they_are() {
        let p = PointObjectives {
            weight: 2.0,
            draws: 1,
            method: vec![vec![4.0, 0.0]],
            baseline: vec![8.0, 0.0],
        };
        let whole = [p.means(0).unwrap()];
        let (mut seeds, mut replicates) =
            (ChaCha8Rng::seed_from_u64(1), ChaCha8Rng::seed_from_u64(2));
        let measured = Measured::of(&[p]);
        for _ in 0..20 {
            let mut means = whole;
            let rngs = (&mut seeds, &mut replicates);
            measured.draw_anew(&whole, rngs, &mut measured.drawn(), &mut means);
            assert_eq!(means[0].score, 0.5);
            assert!(means == whole || means[0].baseline == 8.0, "{means:?}");
        }
    }

    #[test]
    fn the_choice_of_point_mdps_leaves_the_seeds_as_they_are() {
        let one = |level: f64| PointObjectives {
            weight: 1.0,
            draws: 1,
            method: vec![vec![level, 2.0 * level, 4.0 * level]],
            baseline: vec![1.0; 3],
        };
        let points = [one(1.0), one(3.0), one(5.0)];
        let whole: Vec<PointMeans> =
            points.iter().enumerate().map(|(i, p)| p.means(i).unwrap()).collect();
        let seeds_of = |resampling: &Resampling| {
            let mut rng = ChaCha8Rng::seed_from_u64(3);
            let mut seen = Vec::new();
            resample((&points, &whole), resampling, &mut rng, 0, 20, &mut |within, _, _| {
                seen.extend(within.to_vec());
            });
            seen
        };
        let drawn = seeds_of(&Resampling::draws(&points));
        assert_eq!((drawn.len(), drawn), (60, seeds_of(&Resampling::whole())));
    }

    #[test]
    fn what_is_drawn_for_a_point_mdp_is_its_own() {
        let one = |level: f64, seeds: usize| PointObjectives {
            weight: 1.0,
            draws: 1,
            method: vec![vec![level; seeds], vec![3.0 * level; seeds]],
            baseline: vec![10.0 * level; seeds],
        };
        let points = [one(1.0, 3), one(2.0, 1), one(4.0, 2)];
        let whole: Vec<PointMeans> =
            points.iter().enumerate().map(|(i, p)| p.means(i).unwrap()).collect();
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut seen = Vec::new();
        resample((&points, &whole), &Resampling::whole(), &mut rng, 0, 20, &mut |within, _, _| {
            let of = |m: &PointMeans| (m.baseline, m.method / m.baseline);
            seen.extend(within.iter().map(of));
        });
        assert_eq!(seen.len(), 60);
        for (i, (baseline, score)) in seen.into_iter().enumerate() {
            assert_eq!(baseline, [10.0, 20.0, 40.0][i % 3]);
            assert!((score - 0.1).abs() < 1e-12 || (score - 0.3).abs() < 1e-12, "{score}");
        }
    }

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
