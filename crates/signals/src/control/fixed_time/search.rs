//! The search problem of tuning: greens in their logarithms to mean delay.

use std::cell::RefCell;

use argmin::core::CostFunction;

use super::super::webster::within;
use super::super::{ControlError, GreenPhase, SignalSpec};
use super::Plan;

/// What the search has done so far.
pub(super) struct SearchState<'a> {
    /// Returns the delay of a plan, one episode.
    pub(super) try_plan: &'a mut dyn FnMut(&Plan) -> Result<f64, ControlError>,
    pub(super) phases: Vec<usize>,
    pub(super) left: u32,
    pub(super) tried: Vec<(f64, Plan)>,
    pub(super) failure: Option<ControlError>,
}

/// The search problem: logarithms of greens to mean delay.
pub(super) struct Search<'a> {
    pub(super) spec: SignalSpec,
    pub(super) state: RefCell<SearchState<'a>>,
}

impl CostFunction for &Search<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, logs: &Vec<f64>) -> Result<f64, argmin::core::Error> {
        let mut guard = self.state.borrow_mut();
        let state = &mut *guard;
        let greens: Vec<f64> = logs.iter().map(|x| x.exp()).collect();
        let greens = within(&self.spec, &state.phases, &greens);
        let phases = state.phases.iter().copied().map(GreenPhase);
        let plan = Plan::Cycle(phases.zip(greens).collect());
        // Rounding to whole seconds makes the same plan come up again.
        if let Some((delay, _)) = state.tried.iter().find(|(_, p)| *p == plan) {
            return Ok(*delay);
        }
        // Not an error: argmin unwraps the costs of the first simplex. A plan that cannot be tried is
        // the worst of all, and the search ends with its iterations.
        if state.left == 0 || state.failure.is_some() {
            return Ok(f64::MAX);
        }
        state.left -= 1;
        match (state.try_plan)(&plan) {
            Ok(delay) => {
                state.tried.push((delay, plan));
                Ok(delay)
            }
            Err(e) => {
                state.failure = Some(e);
                Ok(f64::MAX)
            }
        }
    }
}
