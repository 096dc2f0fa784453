//! Results by movement, as records keep them: means over the evaluation episodes of a task.

use serde::{Deserialize, Serialize};

use super::env::by_movement::MovementTotals;
use super::existing::{ExistingPlan, PlanPhase, schedule};
use super::vocabulary::Light;
use basics::units::SECONDS_PER_HOUR;

/// Queues whose percentiles are kept.
const PERCENTILES: [f64; 2] = [0.5, 0.95];

/// How a movement fared, means over evaluation episodes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MovementResult {
    /// SUMO's id of the edge from which its vehicles come.
    pub from: String,
    /// SUMO's id of the edge to which they go.
    pub to: String,
    /// Its name on the ground, such as `NBL`.
    pub movement: String,
    /// SUMO's id of its signal.
    pub signal: String,
    /// Its link indices at the signal: places in the states of programs.
    pub links: Vec<usize>,
    /// Vehicles per episode.
    pub vehicles_veh: f64,
    /// Vehicles per episode that had not arrived at the end.
    pub unfinished_veh: f64,
    /// Mean delay per vehicle, seconds; absent without vehicles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub delay_s: Option<f64>,
    /// Mean number of stops per vehicle; absent without vehicles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stops: Option<f64>,
    /// Queue that half of the decisions do not exceed, vehicles.
    pub queue_50_veh: f64,
    /// Queue that 95% of the decisions do not exceed, vehicles.
    pub queue_95_veh: f64,
    /// Length of its turn lanes where they are shorter than the street, metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub storage_m: Option<f64>,
    /// Mean delay of those who cross its approach, seconds; absent where pedestrians do not count, nobody came or is served.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crosswalk_delay_s: Option<f64>,
    /// Whether people would cross its approach, but never had WALK.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub crosswalk_unserved: bool,
    /// What decides its capacity; absent in records of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub supply: Option<Supply>,
}

/// Lanes and green of a movement, means over evaluation episodes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Supply {
    /// Names of the movements of its lane group, between blanks.
    pub group: String,
    /// Lanes from which it can be made.
    pub lanes: u32,
    /// Lanes of its lane group.
    pub group_lanes: u32,
    /// Share of the time with green and the right of way.
    pub protected_share: f64,
    /// Share of the time with green that yields.
    pub permissive_share: f64,
    /// How often green begins, per hour.
    pub greens_per_h: f64,
}

/// Returns the results of some episodes, by movement in the order in which they first appear.
pub fn results(episodes: &[Vec<MovementTotals>]) -> Vec<MovementResult> {
    let mut totals: Vec<MovementTotals> = Vec::new();
    for one in episodes.iter().flatten() {
        match totals.iter_mut().find(|t| (&t.from, &t.to) == (&one.from, &one.to)) {
            None => totals.push(one.clone()),
            Some(all) => {
                all.vehicles += one.vehicles;
                all.unfinished += one.unfinished;
                all.delay_s += one.delay_s;
                all.stops += one.stops;
                all.queue_veh.extend(&one.queue_veh);
                all.lights.add(one.lights);
                all.crosswalk += one.crosswalk;
            }
        }
    }
    let episodes = episodes.len().max(1) as f64;
    let of = |t: &MovementTotals| {
        let mean = |sum: f64| (t.vehicles > 0).then(|| sum / f64::from(t.vehicles));
        let [queue_50_veh, queue_95_veh] = PERCENTILES.map(|share| percentile(&t.queue_veh, share));
        MovementResult {
            from: t.from.clone(),
            to: t.to.clone(),
            movement: t.name.clone(),
            signal: t.signal.clone(),
            links: t.links.clone(),
            vehicles_veh: f64::from(t.vehicles) / episodes,
            unfinished_veh: f64::from(t.unfinished) / episodes,
            delay_s: mean(t.delay_s),
            stops: mean(t.stops),
            queue_50_veh,
            queue_95_veh,
            storage_m: t.storage_m,
            crosswalk_delay_s: t.crosswalk.delay_s(),
            crosswalk_unserved: t.crosswalk.unserved > 0,
            supply: supply(t),
        }
    };
    totals.iter().map(of).collect()
}
/// Returns lanes and green of a movement; `None` where nothing was noted of its lights.
fn supply(t: &MovementTotals) -> Option<Supply> {
    let seconds = f64::from(t.lights.seconds);
    let share = |of: u32| f64::from(of) / seconds;
    (seconds > 0.0).then(|| Supply {
        group: t.group.clone(),
        lanes: t.lanes[0],
        group_lanes: t.lanes[1],
        protected_share: share(t.lights.protected_s),
        permissive_share: share(t.lights.permissive_s),
        greens_per_h: share(t.lights.greens) * SECONDS_PER_HOUR,
    })
}

/// Returns results with the greens of a plan, if each phase lasts its split, in place of those that were shown.
pub fn supplied(plan: &ExistingPlan, results: &[MovementResult]) -> Vec<MovementResult> {
    // Cabinets have tenths of seconds, schedules whole numbers.
    let tenfold = |phase: &PlanPhase| PlanPhase {
        max_green_s: 10.0 * phase.max_green_s,
        yellow_s: 10.0 * phase.yellow_s,
        all_red_s: 10.0 * phase.all_red_s,
        ..phase.clone()
    };
    let phases = plan.phases.iter().map(tenfold).collect();
    let (timed, cycle) = schedule(&ExistingPlan { phases, ..plan.clone() });
    let is_green =
        |p: usize, at: u32| (at + cycle - timed[p].begin_s % cycle) % cycle < timed[p].green_s;
    let of = |m: &MovementResult| {
        let way = (m.from.clone(), m.to.clone());
        let has = |names: &[String]| {
            names.iter().filter_map(|n| plan.ways.get(n)).any(|ways| ways.contains(&way))
        };
        let light = |phase: &PlanPhase| match has(&phase.movements) {
            true => Light::Protected,
            false if has(&phase.yielding) => Light::Permissive,
            false => Light::Red,
        };
        let of_phases: Vec<Light> = plan.phases.iter().map(light).collect();
        let shown = |at: u32| {
            let green = (0..timed.len()).filter(|p| is_green(*p, at));
            green.map(|p| of_phases[p]).max().unwrap_or(Light::Red)
        };
        let lights: Vec<Light> = (0..cycle).map(shown).collect();
        let count = |of: &dyn Fn(usize) -> bool| (0..lights.len()).filter(|at| of(*at)).count();
        let share = |of: Light| count(&|at| lights[at] == of) as f64 / f64::from(cycle);
        let was_red = |at: usize| lights[(at + lights.len() - 1) % lights.len()] == Light::Red;
        let greens = count(&|at| lights[at] != Light::Red && was_red(at)) as f64;
        let supply = m.supply.as_ref().map(|supply| Supply {
            protected_share: share(Light::Protected),
            permissive_share: share(Light::Permissive),
            greens_per_h: greens * 10.0 * SECONDS_PER_HOUR / f64::from(cycle),
            ..supply.clone()
        });
        MovementResult { supply, ..m.clone() }
    };
    results.iter().map(of).collect()
}

/// Returns the least value that a share of the values does not exceed; 0 of nothing.
fn percentile(values: &[f64], share: f64) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    let rank = (share * values.len() as f64).ceil() as usize;
    values.get(rank.saturating_sub(1)).copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn episode(vehicles: u32, delay_s: f64, queue_veh: &[f64]) -> Vec<MovementTotals> {
        let totals = MovementTotals {
            from: "in0".into(),
            to: "out2".into(),
            name: "SBT".into(),
            vehicles,
            delay_s,
            queue_veh: queue_veh.to_vec(),
            ..MovementTotals::default()
        };
        vec![totals]
    }

    #[test]
    fn delays_are_means_over_vehicles_and_queues_percentiles_over_decisions() {
        let queues = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0];
        let result = &results(&[episode(1, 10.0, &[0.0; 10]), episode(3, 90.0, &queues)])[0];
        assert_eq!((result.vehicles_veh, result.delay_s), (2.0, Some(25.0)));
        assert_eq!((result.queue_50_veh, result.queue_95_veh), (0.0, 9.0));
    }
}
