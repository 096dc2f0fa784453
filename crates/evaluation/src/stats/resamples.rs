//! Resamples of what was measured: seeds, replicates and the choice of point MDPs drawn anew, many times over.
//!
//! What a resample is, is said in [`super::bootstrap`]. A report takes thousands of resamples of every method and of
//! every two, so here nothing is allocated per resample: what was measured lies in one list, and means are written
//! over those of the resample before.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::draws::{Draws, size};
use super::{PointMeans, PointObjectives, Resampling};

/// Stream of the generator that the choice of point MDPs is drawn from; seeds are drawn from stream 0.
const CHOICE: u64 = 1;

/// One resample: means after seeds and replicates were drawn anew, and the same with moved weights.
pub(super) struct Resample<'a> {
    /// Seeds and replicates drawn anew.
    pub(super) within: &'a [PointMeans],
    /// The same with the weights that the design gives; `None` where no point MDP is drawn anew.
    pub(super) moved: Option<&'a [PointMeans]>,
    /// The factor by which the change from the first to the second is multiplied.
    pub(super) factor: f64,
}

/// Resamples what was measured `count` times; not at all when the spread cannot be estimated or there is none.
///
/// # Arguments
///
/// Those of [`super::bootstrap_all`]; `whole` are the means of the points, `take` gets every resample.
pub(super) fn resample(
    (points, whole): (&[PointObjectives], &[PointMeans]),
    resampling: &Resampling,
    rng: &mut ChaCha8Rng,
    trainings: u64,
    count: usize,
    take: &mut dyn FnMut(&Resample<'_>),
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
        take(&Resample { within: &within, moved: between.then_some(&moved[..]), factor });
    }
}

/// Whether seeds or replicates can be drawn anew.
fn has_noise(points: &[PointObjectives]) -> bool {
    points.iter().any(|p| p.baseline.len() > 1 || p.method.len() > 1)
}

/// Returns the source of replicates: methods differ in these but not in their seeds.
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

    /// Returns room for the indices of a resample.
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
            resample((&points, &whole), resampling, &mut rng, 0, 20, &mut |resample| {
                seen.extend(resample.within.to_vec());
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
        resample((&points, &whole), &Resampling::whole(), &mut rng, 0, 20, &mut |resample| {
            let of = |m: &PointMeans| (m.baseline, m.method / m.baseline);
            seen.extend(resample.within.iter().map(of));
        });
        assert_eq!(seen.len(), 60);
        for (i, (baseline, score)) in seen.into_iter().enumerate() {
            assert_eq!(baseline, [10.0, 20.0, 40.0][i % 3]);
            assert!((score - 0.1).abs() < 1e-12 || (score - 0.3).abs() < 1e-12, "{score}");
        }
    }
}
