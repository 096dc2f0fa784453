//! The search that every tuned method uses: it tries given plans, then goes on from the best of them with Nelder-Mead (crate
//! `argmin`) in the logarithms of its greens, which starts again from the best plan so far with a smaller simplex while
//! simulations are left.
//!
//! Settings of a method are tuned with it, too: one setting after the other takes its declared values beside the best ones
//! of the others, until none is better, or no simulation is left. The two best choices and the one that it began with are
//! then compared on further training seeds.

use std::cell::RefCell;

use argmin::core::{CostFunction, Executor};
use argmin::solver::neldermead::NelderMead;

/// Factors between the corners of the simplex, one start after the other; below 1 the corners lie
/// on the other side.
const SIMPLEX_FACTORS: [f64; 4] = [1.4, 0.8, 1.15, 0.9];

/// Seed of the episodes that a search compares plans on.
pub const SEARCH_SEED: u32 = 0;

/// Further seeds for the final comparison.
const FINAL_SEEDS: [u32; 2] = [1, 2];

/// Plans in the final comparison, the one that a search began with included.
const FINALISTS: usize = 3;

/// Episodes of the final comparison.
pub const FINALS: u32 = (FINALISTS * FINAL_SEEDS.len()) as u32;

/// How often each setting is tuned, at most.
const ROUNDS: usize = 3;

/// Values of settings by their names.
pub type Choice<'a> = Vec<(&'a str, f64)>;

/// What is searched of a plan, and a plan with other logarithms.
type On<'a, P> = (&'a dyn Fn(&P) -> Option<Vec<f64>>, &'a dyn Fn(&P, &[f64]) -> P);

/// The search problem: logarithms to the objective.
struct Search<F>(RefCell<F>);

impl<F: FnMut(&[f64]) -> f64> CostFunction for Search<F> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, logs: &Vec<f64>) -> Result<f64, argmin::core::Error> {
        Ok((self.0.borrow_mut())(logs))
    }
}

/// Tries plans, searches on from the best that was tried, and adds all that it tries, the best first.
///
/// # Arguments
///
/// * `plans` — those to be tried, and the most simulations.
/// * `on` — how to search on: what is searched of a plan, if it can be changed, and a plan with other logarithms.
/// * `simulate` — returns the objective under a plan, of which less is better.
///
/// # Errors
///
/// That of a simulation, which ends the search.
pub fn search<P: Clone + PartialEq, E>(
    tried: &mut Vec<(f64, P)>,
    (plans, simulations): (Vec<P>, u32),
    on: Option<On<'_, P>>,
    simulate: &mut dyn FnMut(&P) -> Result<f64, E>,
) -> Result<(), E> {
    let mut left = simulations;
    for plan in plans {
        if left > 0 && !tried.iter().any(|(_, other)| *other == plan) {
            tried.push((simulate(&plan)?, plan));
            left -= 1;
        }
    }
    for (factor, (logs, with)) in SIMPLEX_FACTORS.into_iter().zip(on.into_iter().cycle()) {
        tried.sort_by(|a, b| a.0.total_cmp(&b.0));
        let start = tried.iter().find_map(|(_, plan)| Some((logs(plan)?, plan.clone())));
        let Some((logs, start)) = start else { break };
        if (left as usize) <= logs.len() {
            continue;
        }
        // One corner changes the whole cycle, the others one green each against the rest.
        let step = factor.ln();
        let mut simplex = vec![logs.iter().map(|x| x - step).collect::<Vec<_>>()];
        for i in 0..logs.len() {
            let mut corner = logs.clone();
            corner[i] += step;
            simplex.push(corner);
        }
        let (iterations, mut failure) = (u64::from(left), None);
        let cost = |logs: &[f64]| {
            let plan = with(&start, logs);
            // Rounding to whole seconds makes the same plan come up again.
            if let Some((cost, _)) = tried.iter().find(|(_, other)| *other == plan) {
                return *cost;
            }
            // Not an error: argmin unwraps the costs of the first simplex. A plan that cannot be tried is
            // the worst of all, and the search ends with its iterations.
            if left == 0 || failure.is_some() {
                return f64::MAX;
            }
            left -= 1;
            let cost = simulate(&plan).unwrap_or_else(|e| {
                failure = Some(e);
                f64::MAX
            });
            tried.push((cost, plan));
            cost
        };
        let solved = Executor::new(Search(RefCell::new(cost)), NelderMead::new(simplex))
            .configure(|state| state.max_iters(iterations))
            .run()
            .map(drop);
        failure.map_or(Ok(()), Err)?;
        solved.expect("costs and limits do not fail");
    }
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(())
}

/// Returns the plan that is best on further seeds, of equal ones the first: of the one that the search began with and
/// the best others. Without further seeds that on the search seed decides.
///
/// # Errors
///
/// That of a simulation.
pub fn decide<P: PartialEq, E>(
    tried: Vec<(f64, P)>,
    start: &P,
    with_finals: bool,
    simulate: &mut dyn FnMut(&P, u32) -> Result<f64, E>,
) -> Result<P, E> {
    let (mut finalists, mut others): (Vec<_>, Vec<_>) =
        tried.into_iter().partition(|(_, plan)| plan == start);
    others.sort_by(|a, b| a.0.total_cmp(&b.0));
    finalists.extend(others.into_iter().take(FINALISTS - 1));
    finalists.dedup_by(|a, b| a.1 == b.1);
    if with_finals {
        for (total_s, plan) in &mut finalists {
            *total_s = 0.0;
            for seed in FINAL_SEEDS {
                *total_s += simulate(plan, seed)?;
            }
        }
    }
    let best = finalists.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    Ok(best.expect("there is at least one plan").1)
}

/// Returns the best choice, after at most so many simulations.
///
/// # Arguments
///
/// * `start` — what the settings are.
/// * `tunes` — what they may be.
///
/// # Errors
///
/// That of a simulation.
pub fn tune<'a, E>(
    start: &Choice<'a>,
    tunes: &[(&'a str, &[f64])],
    simulations: u32,
    simulate: &mut dyn FnMut(&Choice<'a>, u32) -> Result<f64, E>,
) -> Result<Choice<'a>, E> {
    let (most, mut tried) = (simulations.saturating_sub(FINALS), Vec::new());
    for axis in (0..tunes.len()).cycle().take(ROUNDS * tunes.len()) {
        let best = tried.first().map_or(start, |(_, choice)| choice).clone();
        let with = |value: &f64| {
            let mut choice = best.clone();
            choice[axis].1 = *value;
            choice
        };
        let choices = std::iter::once(start.clone()).chain(tunes[axis].1.iter().map(with));
        let plans = (choices.collect(), most - tried.len() as u32);
        search(&mut tried, plans, None, &mut |choice| simulate(choice, SEARCH_SEED))?;
    }
    decide(tried, start, true, simulate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_simulation_that_fails_ends_the_search_with_its_error() {
        let (logs, with) = (|_: &f64| Some(vec![0.0]), |_: &f64, logs: &[f64]| logs[0]);
        let (mut tried, on) = (vec![(1.0, 0.0)], Some((&logs as &dyn Fn(&_) -> _, &with as _)));
        let found = search(&mut tried, (vec![], 30), on, &mut |_| Err("planned failure"));
        assert_eq!(found, Err("planned failure"));
    }

    #[test]
    fn settings_take_the_values_that_hold_on_further_seeds() {
        let tunes: [(&str, &[f64]); 2] = [("a", &[1.0, 2.0, 4.0]), ("b", &[5.0, 6.0, 7.0])];
        let start = vec![("a", 3.0), ("b", 5.0)];
        let mut simulations = 0;
        let mut tuned = |luck: f64| {
            tune(&start, &tunes, 24, &mut |choice: &Choice<'_>, seed| {
                simulations += 1;
                let (a, b) = (choice[0].1, choice[1].1);
                // On the search seed alone the last value is better.
                let is_lucky = seed == SEARCH_SEED && a == 4.0;
                Ok::<_, ()>(
                    (a - 1.0).abs() + (b - 6.0 * a).abs() - if is_lucky { luck } else { 0.0 },
                )
            })
        };
        // The better b is known once a is, and the other way round.
        assert_eq!(tuned(0.0), Ok(vec![("a", 1.0), ("b", 6.0)]));
        assert_eq!(tuned(100.0), Ok(start.clone()));
        assert!(simulations <= 48, "{simulations}");
    }
}
