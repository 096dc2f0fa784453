//! The search for the greens of a signal that every tuned method uses: Nelder-Mead (crate `argmin`) in their logarithms, which
//! starts again from the best plan so far with a smaller simplex while simulations are left.

use std::cell::RefCell;

use argmin::core::{CostFunction, Executor};
use argmin::solver::neldermead::NelderMead;

use super::ControlError;

/// Factors between the corners of the simplex, one start after the other; below 1 the corners lie
/// on the other side.
const SIMPLEX_FACTORS: [f64; 4] = [1.4, 0.8, 1.15, 0.9];

/// The search problem: logarithms to mean delay.
struct Search<F>(RefCell<F>);

impl<F: FnMut(&[f64]) -> f64> CostFunction for Search<F> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, logs: &Vec<f64>) -> Result<f64, argmin::core::Error> {
        Ok((self.0.borrow_mut())(logs))
    }
}

/// Searches on from the best plan that was tried, with at most so many simulations, and adds all that it tries, the best first.
///
/// # Arguments
///
/// * `logs` — what is searched of a plan; nothing where it cannot be changed.
/// * `with` — a plan with other logarithms.
/// * `simulate` — returns the delay under a plan, seconds.
pub(super) fn search<P: Clone + PartialEq>(
    tried: &mut Vec<(f64, P)>,
    simulations: u32,
    logs: &dyn Fn(&P) -> Option<Vec<f64>>,
    with: &dyn Fn(&P, &[f64]) -> P,
    simulate: &mut dyn FnMut(&P) -> Result<f64, ControlError>,
) -> Result<(), ControlError> {
    let mut left = simulations;
    for factor in SIMPLEX_FACTORS {
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
        let delay_s = |logs: &[f64]| {
            let plan = with(&start, logs);
            // Rounding to whole seconds makes the same plan come up again.
            if let Some((delay_s, _)) = tried.iter().find(|(_, other)| *other == plan) {
                return *delay_s;
            }
            // Not an error: argmin unwraps the costs of the first simplex. A plan that cannot be tried is
            // the worst of all, and the search ends with its iterations.
            if left == 0 || failure.is_some() {
                return f64::MAX;
            }
            left -= 1;
            match simulate(&plan) {
                Ok(delay_s) => {
                    tried.push((delay_s, plan));
                    delay_s
                }
                Err(e) => {
                    failure = Some(e);
                    f64::MAX
                }
            }
        };
        let result = Executor::new(Search(RefCell::new(delay_s)), NelderMead::new(simplex))
            .configure(|state| state.max_iters(iterations))
            .run()
            .map(drop)
            .map_err(|e| ControlError::Episode(e.into()));
        failure.map_or(result, Err)?;
    }
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(())
}
