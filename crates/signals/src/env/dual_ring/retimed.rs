//! The greens of a signal's rings, with what a method that chooses them may choose.

use super::existing::{rings, whole_s};
use super::plan::longest_s;
use super::{DualRing, planned};
use crate::control::RingGreens;
use crate::control::dual_ring::Config;
use crate::env::derive::DerivedSignal;
use crate::existing::{Control, ExistingPlan};
use crate::sim::{Scene, SignalInfo};

impl DualRing {
    /// Returns the greens of an existing plan on a signal, or of the phases that follow from its programs.
    pub fn ring_greens(
        scene: &Scene,
        signal: &SignalInfo,
        derived: &DerivedSignal,
        existing: Option<&ExistingPlan>,
        config: &Config,
    ) -> Result<RingGreens, String> {
        let timing = &derived.timing;
        let (links, plan) = match existing {
            Some(plan) => rings(plan, scene, signal, timing)?,
            None => planned(scene, signal, derived, config),
        };
        let lane = |lane: usize| derived.lanes.iter().position(|own| *own == lane);
        let mut greens = RingGreens { sides: plan.sides, ..RingGreens::default() };
        for (index, phase) in plan.phases.iter().enumerate() {
            let people_s = longest_s(&phase.crossings);
            let mut least_s = f64::from(phase.min_s.max(people_s));
            let mut green_s = f64::from(phase.max_s);
            let mut change_s = f64::from(phase.change.total_s());
            let mut limit_s = phase.limit_s;
            if let Some(own) = existing.map(|plan| &plan.phases[index]) {
                green_s = own.max_green_s;
                if existing.is_some_and(|plan| plan.control == Control::Actuated) {
                    green_s = green_s.max(phase.min_s.into());
                    limit_s = timing.max_green_s(&links.plain(&phase.links));
                }
                change_s = own.yellow_s + own.all_red_s;
                let walk_s = f64::from(own.walk_s.map_or(0, whole_s));
                let split_s = own.min_split_s.unwrap_or_default() - change_s;
                least_s = least_s.max(own.min_green_s).max(walk_s).max(split_s).min(green_s);
            }
            greens.green_s.push(green_s);
            greens.least_s.push(least_s);
            greens.most_s.push(limit_s.map_or(f64::INFINITY, f64::from).max(green_s));
            greens.change_s.push(change_s);
            greens.lanes.push(phase.detectors.iter().filter_map(|d| lane(d.lane)).collect());
        }
        if let Some(plan) = existing.filter(|plan| plan.control != Control::Actuated) {
            let cycle_s = greens.meet_at_barriers();
            let stays = plan.control == Control::Coordinated
                || plan.offset_s.is_some_and(|offset_s| offset_s != 0.0);
            let limits = &derived.spec.limits;
            greens.cycle_s = Some(match stays {
                true => [cycle_s; 2],
                false => [limits.min_cycle_s.min(cycle_s), limits.max_cycle_s.max(cycle_s)],
            });
        }
        Ok(greens)
    }
}
