//! A plan with clearances that are as long as the limits want them.

use super::{Control, ExistingPlan, PlanPhase, STEP_S};
use crate::control::RingGreens;
use crate::timing::{Timing, WALK_S, tenths};

impl ExistingPlan {
    /// Returns for each phase the approach with the longest crosswalk that people cross in it; none without a walk.
    ///
    /// # Arguments
    ///
    /// * `states` — per phase the state in which its links are green, and no other.
    /// * `n` — approaches with a crosswalk.
    pub fn crosswalks(&self, timing: &Timing, states: &[String], n: usize) -> Vec<Option<usize>> {
        let walk = |(phase, state): (&PlanPhase, &String)| phase.walk_s.map(|_| state.clone());
        let walks: Vec<Option<String>> = self.phases.iter().zip(states).map(walk).collect();
        let walkers: Vec<_> = (0..n).map(|c| timing.walker(&walks, c)).collect();
        let of = |phase: usize| {
            let own = (0..n).filter(|c| walkers[*c] == Some(phase));
            own.max_by(|a, b| timing.crosswalk_m(*a).total_cmp(&timing.crosswalk_m(*b)))
        };
        (0..walks.len()).map(of).collect()
    }

    /// Returns the plan with yellow, all-red, walk and clearance of the phases that have them as long as the limits, where these
    /// are longer. Splits stay, as far as shortest greens and walks allow; otherwise the cycle gets longer.
    ///
    /// # Arguments
    ///
    /// * `states` — per phase the state in which its links are green, and no other.
    pub fn legal(&self, timing: &Timing, states: &[String]) -> Self {
        let (mut plan, mut greens) = (self.clone(), RingGreens::default());
        let crosswalks = self.crosswalks(timing, states, timing.crossings());
        let changes = states.iter().zip(self.after(states));
        for ((phase, (state, after)), crosswalk) in
            plan.phases.iter_mut().zip(changes).zip(crosswalks)
        {
            let (split_s, [yellow_s, red_s]) = (phase.split_s(), phase.change_s());
            let change_s = timing.exact_change_s(state, &after);
            if let Some([own_s, own_red_s]) = change_s.filter(|_| yellow_s > 0.0) {
                phase.yellow_s = yellow_s.max(own_s);
                // What a yellow is longer counts as all-red.
                phase.all_red_s = red_s.max(tenths(own_s + own_red_s - phase.yellow_s));
            }
            if let Some(([walk_s, clear_s], crossing)) = phase.walk_s.as_mut().zip(crosswalk) {
                *walk_s = walk_s.max(WALK_S.into());
                *clear_s = clear_s.max(f64::from(timing.crossing_s(crossing)) - *walk_s);
            }
            let change_s: f64 = phase.change_s().iter().sum();
            let walk_s: f64 = phase.walk_s.unwrap_or_default().iter().sum();
            let least_s = phase.min_green_s.max(phase.min_split_s.unwrap_or_default() - change_s);
            let is_actuated = self.control == Control::Actuated;
            greens.least_s.push(least_s.min(phase.max_green_s).max(walk_s).max(STEP_S));
            greens.green_s.push(if is_actuated { phase.max_green_s } else { split_s - change_s });
            greens.most_s.push(f64::INFINITY);
            greens.change_s.push(change_s);
        }
        if self.control != Control::Actuated {
            greens.sides = self.sides();
            greens.cycle_s = Some([greens.meet_at_barriers(); 2]);
        }
        let plan = plan.retimed(&greens.fit(&greens.green_s));
        let cycle_s = plan.cycle_s.filter(|_| self.control == Control::Coordinated);
        let longer_s = cycle_s.map(|cycle_s| cycle_s.max(tenths(plan.sum_s())));
        Self { cycle_s: longer_s.or(plan.cycle_s), ..plan }
    }
}
