//! Resampled means of scores of several sets of objectives on the same point MDPs, from the same draws.
//!
//! A report compares every two methods, so that most of its time would go into drawing the same seeds and replicates
//! for one method after the other, and into adding up what was drawn, one number after the other. Here sets that draw the
//! same lie side by side, and every number of one is added where those of the others are. Several resamples are computed
//! while what was measured on a point MDP is at hand. Every sum has the order that [`super::resamples`] gives it, and so
//! the same last digit.

use pulp::{Arch, Simd, WithSimd};
use rand_chacha::ChaCha8Rng;

use super::bootstrap::RESAMPLES;
use super::draws::{Draws, size};
use super::resamples::{has_noise, replicates};
use super::summary::{Statistic, mean_of_scores};
use super::{Bootstrap, PointMeans, PointObjectives, Resampling, StatsError, bootstrap_all, means};

/// Most sets that are computed side by side.
const LANES: usize = 8;

/// Indices that are in memory at once, but for those of a resample of a large family.
const INDICES: usize = 1 << 22;

/// What an empty sum is, so that adding to it changes not even the sign of a zero.
const NOTHING: f64 = -0.0;

/// Estimates the overall performance of a method and resamples it [`super::bootstrap::RESAMPLES`] times.
///
/// # Arguments
///
/// Those of [`super::bootstrap_all`].
///
/// # Errors
///
/// [`StatsError`] without points, for weights that sum to 0, and where a score is undefined.
pub fn bootstrap(
    points: &[PointObjectives],
    resampling: &Resampling,
    rng: &ChaCha8Rng,
    trainings: u64,
) -> Result<Bootstrap, StatsError> {
    let mut all = bootstrap_each(&[points], resampling, rng, (trainings, RESAMPLES));
    all.pop().expect("there is one result for each")
}

/// Estimates the mean of scores of each of several sets of objectives as [`super::bootstrap_all`] does it, each from a generator
/// in the same state. Sets that draw the same from it are drawn once.
///
/// # Arguments
///
/// * `sets` — the evaluated point MDPs of each.
///
/// The others are those of [`super::bootstrap_all`]. The results are in the order of the sets; each is an error without points,
/// for weights that sum to 0, and where a score is undefined.
pub fn bootstrap_each(
    sets: &[&[PointObjectives]],
    resampling: &Resampling,
    rng: &ChaCha8Rng,
    (trainings, count): (u64, usize),
) -> Vec<Result<Bootstrap, StatsError>> {
    let alone = |points: &[PointObjectives]| {
        let of_scores: Statistic<'_> = &mean_of_scores;
        let rng = &mut rng.clone();
        let mut all = bootstrap_all(points, resampling, rng, (trainings, count), &[of_scores])?;
        all.pop().flatten().ok_or(StatsError::Empty("the list of point MDPs with a weight"))
    };
    let mut found: Vec<Option<Result<Bootstrap, StatsError>>> = vec![None; sets.len()];
    while let Some(first) = found.iter().position(Option::is_none) {
        let open = (first..sets.len()).filter(|i| found[*i].is_none());
        let like: Vec<usize> =
            open.filter(|i| draw_alike(sets[first], sets[*i])).take(LANES).collect();
        let whole: Result<Vec<_>, _> = like.iter().map(|i| means(sets[*i])).collect();
        let estimates = |whole: &[Vec<PointMeans>]| -> Option<Vec<f64>> {
            whole.iter().map(|means| mean_of_scores(means)).collect()
        };
        let is_drawn =
            !resampling.draws_points() && resampling.is_known() && has_noise(sets[first]);
        let drawn = whole.ok().filter(|_| is_drawn).and_then(|whole| {
            let estimates = estimates(&whole)?;
            let both: Vec<_> =
                like.iter().map(|i| sets[*i]).zip(whole.iter().map(Vec::as_slice)).collect();
            let resamples = means_of_scores(&both, &mut rng.clone(), (trainings, count));
            Some(estimates.into_iter().zip(resamples))
        });
        match drawn {
            Some(drawn) => {
                for (i, (estimate, resamples)) in like.into_iter().zip(drawn) {
                    found[i] = Some(Ok(Bootstrap { estimate, resamples }));
                }
            }
            None => like.into_iter().for_each(|i| found[i] = Some(alone(sets[i]))),
        }
    }
    found.into_iter().flatten().collect()
}

/// Returns whether the same is drawn for two sets, and with the same weights.
fn draw_alike(a: &[PointObjectives], b: &[PointObjectives]) -> bool {
    let same = |(a, b): (&PointObjectives, &PointObjectives)| {
        a.weight.to_bits() == b.weight.to_bits()
            && (a.baseline.len(), a.method.len()) == (b.baseline.len(), b.method.len())
    };
    a.len() == b.len() && a.iter().zip(b).all(same)
}

/// Returns the means of scores after drawing seeds and replicates anew, shape `[sets, count]`.
///
/// # Arguments
///
/// * `sets` — at most [`LANES`] that draw alike and whose weights do not sum to 0, each with its means.
/// * `rng`, `trainings`, `count` — those of [`super::bootstrap_all`].
fn means_of_scores(
    sets: &[(&[PointObjectives], &[PointMeans])],
    rng: &mut ChaCha8Rng,
    (trainings, count): (u64, usize),
) -> Vec<Vec<f64>> {
    let source = replicates(rng, trainings);
    match sets.len() {
        0 => Vec::new(),
        1 => Lanes::<1>::of(sets).means((rng, source), count, 1),
        n @ 2..=4 => Lanes::<4>::of(sets).means((rng, source), count, n),
        n => Lanes::<LANES>::of(sets).means((rng, source), count, n),
    }
}

/// What was measured on a point MDP, in all sets.
struct Shape {
    weight: f64,
    seeds: usize,
    replicates: usize,
}

/// Sets side by side.
struct Lanes<const N: usize> {
    shapes: Vec<Shape>,
    /// Per point MDP the score without drawing anew, the baseline's objectives by seed, then those of every replicate.
    values: Vec<[f64; N]>,
}

impl<const N: usize> Lanes<N> {
    /// Takes sets, the first one also for those that there are too few of.
    fn of(sets: &[(&[PointObjectives], &[PointMeans])]) -> Self {
        let lane = |i: usize| sets.get(i).unwrap_or(&sets[0]);
        let of = |p: &PointObjectives| Shape {
            weight: p.weight,
            seeds: p.baseline.len(),
            replicates: p.method.len(),
        };
        let shapes: Vec<Shape> = sets[0].0.iter().map(of).collect();
        let room = shapes.iter().map(|s| 1 + s.seeds * (1 + s.replicates)).sum();
        let mut values = Vec::with_capacity(room);
        let lanes: [_; N] = std::array::from_fn(lane);
        for (point, shape) in shapes.iter().enumerate() {
            values.push(lanes.map(|lane| lane.1[point].score));
            for seed in 0..shape.seeds {
                values.push(lanes.map(|lane| lane.0[point].baseline[seed]));
            }
            for r in 0..shape.replicates {
                for seed in 0..shape.seeds {
                    values.push(lanes.map(|lane| lane.0[point].method[r][seed]));
                }
            }
        }
        Self { shapes, values }
    }

    /// Returns the means of scores of the first `lanes` sets.
    fn means(
        &self,
        (rng, mut source): (&mut ChaCha8Rng, ChaCha8Rng),
        count: usize,
        lanes: usize,
    ) -> Vec<Vec<f64>> {
        let of_seeds = Draws::of(self.shapes.iter().map(|s| s.seeds));
        let of_replicates = Draws::of(self.shapes.iter().map(|s| s.replicates));
        let of_one = of_seeds.len() + of_replicates.len();
        let at_once = (INDICES / of_one.max(1)).clamp(4, 512).min(count.max(1));
        let weight = self.shapes.iter().fold(0.0, |sum, shape| sum + shape.weight);
        let mut seeds = vec![0; at_once * of_seeds.len()];
        let mut replicates = vec![0; at_once * of_replicates.len()];
        let mut sums = vec![[0.0; N]; at_once];
        let mut all: Vec<Vec<f64>> = (0..lanes).map(|_| Vec::with_capacity(count)).collect();
        for first in (0..count).step_by(at_once) {
            let now = at_once.min(count - first);
            let seeds = &mut seeds[..now * of_seeds.len()];
            let replicates = &mut replicates[..now * of_replicates.len()];
            of_seeds.fill(rng, seeds);
            of_replicates.fill(&mut source, replicates);
            let sums = &mut sums[..now];
            sums.fill([0.0; N]);
            let seeds = (&*seeds, of_seeds.len());
            let replicates = (&*replicates, of_replicates.len());
            Arch::new().dispatch(Adding { lanes: self, seeds, replicates, sums: &mut *sums });
            for sum in sums.iter() {
                all.iter_mut().zip(sum).for_each(|(of_set, sum)| of_set.push(sum / weight));
            }
        }
        all
    }
}

/// Weight times score of every point MDP, added for as many resamples as there are sums.
struct Adding<'a, const N: usize> {
    lanes: &'a Lanes<N>,
    /// What is drawn, and how many of it belong to a resample.
    seeds: (&'a [u32], usize),
    replicates: (&'a [u32], usize),
    sums: &'a mut [[f64; N]],
}

impl<const N: usize> WithSimd for Adding<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self {
            lanes,
            seeds: (seeds, all_seeds),
            replicates: (replicates, all_replicates),
            sums,
        } = self;
        let mut rest = &lanes.values[..];
        let (mut first_seed, mut first_replicate) = (0, 0);
        for Shape { weight, seeds: n, replicates: r } in &lanes.shapes {
            let (whole, others) = rest.split_at(1);
            let (baseline, others) = others.split_at(*n);
            let (method, others) = others.split_at(n * r);
            rest = others;
            for (resample, sum) in sums.iter_mut().enumerate() {
                let seeds = &seeds[resample * all_seeds + first_seed..][..size(*n)];
                let replicates =
                    &replicates[resample * all_replicates + first_replicate..][..size(*r)];
                let (mut top, mut bottom) = ([NOTHING; N], [NOTHING; N]);
                for seed in seeds {
                    add(&mut bottom, &baseline[*seed as usize]);
                }
                for replicate in replicates {
                    let of_replicate = &method[*replicate as usize * n..][..*n];
                    let mut of_seeds = [NOTHING; N];
                    for seed in seeds {
                        add(&mut of_seeds, &of_replicate[*seed as usize]);
                    }
                    add(&mut top, &of_seeds);
                }
                let drawn = replicates.len() as f64;
                for lane in 0..N {
                    // Only a point MDP where some seeds bring no delay at all can come here with 0.
                    let score = match bottom[lane] <= 0.0 {
                        true => whole[0][lane],
                        false => top[lane] / drawn / bottom[lane],
                    };
                    sum[lane] += weight * score;
                }
            }
            first_seed += size(*n);
            first_replicate += size(*r);
        }
    }
}

#[inline(always)]
fn add<const N: usize>(sum: &mut [f64; N], values: &[f64; N]) {
    for (sum, value) in sum.iter_mut().zip(values) {
        *sum += value;
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use rand::SeedableRng;

    use super::super::testing::any_points;
    use super::*;

    fn rng(seed: u64) -> ChaCha8Rng {
        ChaCha8Rng::seed_from_u64(seed)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        #[test]
        fn several_at_once_have_the_resamples_of_each(
            points in any_points(), more in prop::collection::vec(0.1f64..9.0, 0..11), differs in any::<bool>(),
        ) {
            let scaled = |by: &f64| {
                let mut other = points.clone();
                other.iter_mut().flat_map(|p| &mut p.method).flatten().for_each(|x| *x = *x * by - 1.0);
                other.iter_mut().flat_map(|p| &mut p.baseline).for_each(|x| *x = (*x - by).max(0.0));
                if differs && *by < 3.0 {
                    other[0].method.push(vec![1.0; 3]);
                }
                other
            };
            let sets: Vec<Vec<PointObjectives>> = std::iter::once(points.clone()).chain(more.iter().map(scaled)).collect();
            let sets: Vec<&[PointObjectives]> = sets.iter().map(Vec::as_slice).collect();
            for resampling in [Resampling::whole(), Resampling::draws(&points)] {
                let of_scores: Statistic<'_> = &mean_of_scores;
                let alone = |points: &&[PointObjectives]| {
                    let all = bootstrap_all(points, &resampling, &mut rng(3), (2, 99), &[of_scores]);
                    all.map(|mut all| all.pop().flatten().unwrap())
                };
                let each = bootstrap_each(&sets, &resampling, &rng(3), (2, 99));
                prop_assert_eq!(each, sets.iter().map(alone).collect::<Vec<_>>());
            }
        }
    }
}
