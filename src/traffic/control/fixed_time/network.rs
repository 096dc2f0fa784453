//! Tuning the signals of a network together.
//!
//! 1. Webster's plans of all signals are tried at once, set of phases by set of phases.
//! 2. From the best network so far, one signal after the other searches its plan, those with most vehicles first, each
//!    with an equal share of what is left but enough to turn its simplex once.
//! 3. The start, the best network of step 1 and that of step 2 are compared on further training seeds.

use super::super::phase_sets::covering;
use super::super::{ControlError, EpisodeOutcome, Trainer};
use super::{
    FINAL_SEEDS, FINALISTS, FixedTime, Plan, SEARCH_SEED, SETS_SHARE, SIMPLEX_FACTORS, budget,
};

/// Episodes that a signal has at least, beyond one for each of its greens: for a corner more and a step of the search.
const LEAST_BEYOND_GREENS: u32 = 3;

impl FixedTime {
    /// Finds the plans of several signals.
    ///
    /// # Arguments
    ///
    /// * `first` — of the episode with the signals' own programs.
    pub(super) fn tune_network(
        &mut self,
        trainer: &mut dyn Trainer,
        start: &[Plan],
        first: &EpisodeOutcome,
    ) -> Result<(), ControlError> {
        let flow_vph = &first.lane_flow_vph;
        let finals = (FINALISTS * FINAL_SEEDS.len()) as u32;
        let most = budget(self.simulations, self.signals.len() as u32).saturating_sub(finals);
        let start_s = match start.iter().all(|plan| *plan == Plan::Own) {
            true => first.delay_s,
            false => self.try_network(trainer, start, SEARCH_SEED)?,
        };
        let (mut best_s, mut best) = (start_s, start.to_vec());
        let most_sets =
            (f64::from(self.simulations.saturating_sub(finals + 1)) * SETS_SHARE).ceil();
        for network in self.joint(flow_vph, most_sets as usize) {
            if self.used < most && network != start {
                let delay_s = self.try_network(trainer, &network, SEARCH_SEED)?;
                if delay_s < best_s {
                    (best_s, best) = (delay_s, network);
                }
            }
        }
        let joint = best.clone();
        self.plans.clone_from(&best);
        let mut busiest: Vec<usize> = (0..self.signals.len()).collect();
        let inflow_vph = |signal: &usize| flow_vph[*signal].iter().sum::<f64>();
        busiest.sort_by(|a, b| inflow_vph(b).total_cmp(&inflow_vph(a)));
        for (done, signal) in busiest.iter().enumerate() {
            let left = most.saturating_sub(self.used);
            let share = left / (busiest.len() - done) as u32;
            best_s = self.tune_one(trainer, *signal, (share, left), &flow_vph[*signal], best_s)?;
        }
        let mut finalists = vec![start.to_vec()];
        for network in [joint, self.plans.clone()] {
            if !finalists.contains(&network) {
                finalists.push(network);
            }
        }
        self.plans = self.decide_network(trainer, finalists)?;
        Ok(())
    }

    /// Returns networks in which every signal has Webster's plan for its first set of phases, for its second and so on;
    /// one with fewer sets keeps its last.
    fn joint(&self, flow_vph: &[Vec<f64>], most: usize) -> Vec<Vec<Plan>> {
        let sets: Vec<Vec<Vec<usize>>> = self.signals.iter().map(covering).collect();
        let rounds = sets.iter().map(Vec::len).max().unwrap_or(0).min(most);
        let plan = |signal: usize, round: usize| {
            let set = &sets[signal][round.min(sets[signal].len() - 1)];
            self.webster(&self.signals[signal], set.clone(), &flow_vph[signal])
        };
        (0..rounds).map(|round| (0..sets.len()).map(|s| plan(s, round)).collect()).collect()
    }

    /// Finds the plan of one signal while the others keep theirs, and returns the network's delay on the search seed.
    fn tune_one(
        &mut self,
        trainer: &mut dyn Trainer,
        signal: usize,
        (share, left): (u32, u32),
        flow_vph: &[f64],
        best_s: f64,
    ) -> Result<f64, ControlError> {
        let spec = self.signals[signal].clone();
        let sets = covering(&spec);
        let least = sets[0].len() as u32 + LEAST_BEYOND_GREENS;
        let share = share.max(least).min(left);
        let most_sets = (f64::from(share) * SETS_SHARE).ceil() as usize;
        let mut tried = vec![(best_s, self.plans[signal].clone())];
        let own = spec.limits.own_program.then_some(Plan::Own);
        let webster = sets.into_iter().map(|set| self.webster(&spec, set, flow_vph));
        let others: Vec<Plan> = own.into_iter().chain(webster).take(most_sets).collect();
        for plan in others {
            if !tried.iter().any(|(_, other)| *other == plan) {
                let delay_s = self.try_plan(trainer, signal, &plan, SEARCH_SEED)?;
                tried.push((delay_s, plan));
            }
        }
        for factor in SIMPLEX_FACTORS {
            tried.sort_by(|a, b| a.0.total_cmp(&b.0));
            let cycle = tried.iter().find_map(|(_, plan)| match plan {
                Plan::Cycle(greens) => Some(greens.clone()),
                Plan::Own => None,
            });
            let Some(cycle) = cycle else { break };
            // The plan that it started with cost nothing.
            let left = share.saturating_sub(tried.len() as u32 - 1);
            tried = self.search(trainer, signal, &cycle, factor, left, tried)?;
        }
        tried.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (delay_s, plan) = tried.swap_remove(0);
        self.plans[signal] = plan;
        Ok(delay_s)
    }

    /// Returns the network with the least delay on further seeds, of equal ones the first.
    fn decide_network(
        &mut self,
        trainer: &mut dyn Trainer,
        mut finalists: Vec<Vec<Plan>>,
    ) -> Result<Vec<Plan>, ControlError> {
        let (mut least_s, mut winner) = (f64::INFINITY, 0);
        if finalists.len() > 1 {
            for (i, network) in finalists.iter().enumerate() {
                let mut total_s = 0.0;
                for seed in FINAL_SEEDS {
                    total_s += self.try_network(trainer, network, seed)?;
                }
                if total_s < least_s {
                    (least_s, winner) = (total_s, i);
                }
            }
        }
        Ok(finalists.swap_remove(winner))
    }

    fn try_network(
        &mut self,
        trainer: &mut dyn Trainer,
        plans: &[Plan],
        seed: u32,
    ) -> Result<f64, ControlError> {
        self.plans = plans.to_vec();
        Ok(self.run(trainer, seed)?.delay_s)
    }
}
