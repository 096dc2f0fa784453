//! Retiming: the plan that a signal has today, with splits that a search in simulation finds.
//!
//! Rings, phases, phasing, yellow, all-red and walks of the plan stay. Chosen are, for each point MDP on training seeds only:
//! - of a **pretimed** plan without an offset cycle and splits, the cycle within the limits of `[signal]`;
//! - of a **coordinated** plan, and a pretimed one with an offset, the splits; cycle and offset stay;
//! - of an **actuated** plan the longest greens, within the limits of `[signal]`.
//!
//! Without an existing plan the phases are those of [`nema`](super::nema), whose longest greens are chosen.
//!
//! 1. One episode with the plan as it is counts the vehicles per lane.
//! 2. Splits by flow ratio (Webster) are tried beside the plan's own, and the better ones are searched on.
//! 3. The best of them and the plan as it is are compared on further training seeds. The plan stays as it is unless the mean
//!    saving is more than twice its standard error.
//!
//! Choices:
//! - **No green gets shorter** than its shortest green, or its walk and clearance, unless it is so today; then it stays as long.
//! - **Splits change by whole seconds**, and those of both rings of a side have the same sum.
//! - **Actuated phases** are lengthened together: the last ones of a side, its through phases, and those before them.
//! - **Signals of a network** are tuned one after the other, the busiest first.
//! - **Lost time and saturation flow** in Webster's formula are the settings of [`fixed_time`](super::fixed_time).
//! - **Clearances** are those of the plan. With `legal_clearances` they are those of [`ExistingPlan::legal`](crate::existing), and what
//!   is said of the plan as it is above holds for that one.
//!
//! Source: F. V. Webster, "Traffic signal settings", Road Research Technical Paper 39 (1958); "Signal Timing Manual" (2nd ed.,
//! NCHRP Report 812), chapters 5 to 7.

use std::collections::BTreeMap;

use super::dual_ring;
use super::fixed_time::{self, KEPT, PLAN, SIMULATIONS, TUNING, budget};
use super::webster::fill;
use super::{ControlError, Controller, Drive, RingGreens, Setup, SignalSpec, Trainer};
use evaluation::run::method::{Method, Training};
use evaluation::run::search::{SEARCH_SEED, search};
use evaluation::settings::setting::settings;

/// The method.
pub const METHOD: Method = Method {
    summary: "the existing plan, or that of nema, with splits or longest greens tuned in simulation",
    settings: Config::SETTINGS,
    reads: &["nema", "fixed_time"],
    ..Method::built_in("retime", Training::Tuned { episodes: "retime.simulations" }, "#c048f0")
};

settings! {
    /// Retiming of existing plans.
    pub struct Config, source "our choice" {
        /// Simulated episodes that tuning may use for one signal, a third of them to compare the result with the plan as it
        /// is; for n signals, √n times as many.
        simulations: u32 = 48, in 20.0..=10_000.0, unit "episodes";
        /// Whether yellow, all-red, walk and clearance of the existing plan that are shorter than the limits of `[signal]` become
        /// as long as these. Splits stay where shortest greens and walks allow that; otherwise the cycle gets longer.
        #[serde(skip_serializing_if = "std::ops::Not::not")]
        legal_clearances: bool = false;
    }
}

/// Further seeds on which the best plan is compared with the plan as it is.
const FINAL_SEEDS: std::ops::RangeInclusive<u32> = 1..=8;

/// How many times its standard error a saving has to be.
const STANDARD_ERRORS: f64 = 2.0;

/// Largest sum of flow ratios for which the formula is used, and the smallest ratio of a phase.
const FLOW_RATIOS: [f64; 2] = [0.01, 0.9];

/// Longest greens of actuated phases over greens of Webster's cycle (Signal Timing Manual: 1.25 to 1.5).
const LONGEST_OVER_MEAN: f64 = 1.5;

/// Returns the method, not yet tuned.
pub fn create(config: &Config, setup: &Setup) -> Box<dyn Controller> {
    let (simulations, nema) = (config.simulations, setup.nema.clone());
    let (formula, signals, greens_s) = (setup.fixed_time.clone(), Vec::new(), Vec::new());
    Box::new(Retime { simulations, nema, formula, signals, greens_s, used: 0 })
}

#[derive(Debug)]
struct Retime {
    simulations: u32,
    nema: dual_ring::Config,
    /// Lost time and saturation flow.
    formula: fixed_time::Config,
    signals: Vec<SignalSpec>,
    /// Per signal the greens of its phases; empty as it is.
    greens_s: Vec<Vec<f64>>,
    used: u32,
}

impl Controller for Retime {
    fn name(&self) -> &'static str {
        METHOD.name
    }

    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        if self.signals != signals {
            self.signals = signals.to_vec();
            self.greens_s = vec![Vec::new(); signals.len()];
        }
        let drive = |greens_s: &Vec<f64>| Drive::Retimed(self.nema.clone(), greens_s.clone());
        Ok(self.greens_s.iter().map(drive).collect())
    }

    fn train(&mut self, trainer: &mut dyn Trainer) -> Result<(), ControlError> {
        self.used = 1;
        let first = trainer.episode(self, SEARCH_SEED)?;
        let finals = 2 * FINAL_SEEDS.count() as u32;
        let most = budget(self.simulations, self.signals.len() as u32).saturating_sub(finals);
        let busiest = first.busiest();
        let mut best_s = first.delay_s;
        for (done, signal) in busiest.iter().enumerate() {
            let share = most.saturating_sub(self.used) / (busiest.len() - done) as u32;
            if let Some(rings) = &first.rings[*signal] {
                let flow_vph = &first.lane_flow_vph[*signal];
                best_s = self.tune(trainer, *signal, (rings, flow_vph), share, best_s)?;
            }
        }
        if self.greens_s.iter().any(|greens_s| !greens_s.is_empty()) && !self.is_better(trainer)? {
            self.greens_s.iter_mut().for_each(Vec::clear);
        }
        Ok(())
    }

    fn details(&self) -> BTreeMap<String, String> {
        let mut details = BTreeMap::from([(SIMULATIONS.to_owned(), self.used.to_string())]);
        if self.greens_s.iter().all(Vec::is_empty) {
            details.insert(TUNING.to_owned(), KEPT.to_owned());
        }
        for (signal, greens_s) in self.signals.iter().zip(&self.greens_s) {
            let greens: Vec<String> = greens_s.iter().map(|s| format!("{s} s")).collect();
            let text = match greens.is_empty() {
                true => "as it is".to_owned(),
                false => format!("greens by phase: {}", greens.join(", ")),
            };
            details.insert(format!("{PLAN}{}", signal.id), text);
        }
        details
    }
}

impl Retime {
    /// Finds the greens of one signal while the others keep theirs, and returns the network's delay on the search seed.
    fn tune(
        &mut self,
        trainer: &mut dyn Trainer,
        signal: usize,
        (rings, flow_vph): (&RingGreens, &[f64]),
        simulations: u32,
        best_s: f64,
    ) -> Result<f64, ControlError> {
        let mut tried = vec![(best_s, rings.green_s.clone())];
        let by_flow = rings.by_flow(flow_vph, &self.formula);
        let mut simulate = |greens_s: &Vec<f64>| {
            self.greens_s[signal].clone_from(greens_s);
            self.used += 1;
            trainer.episode(self, SEARCH_SEED).map(|played| played.delay_s)
        };
        let logs = |_: &Vec<f64>| Some(vec![0.0; rings.groups().len()]);
        let with = |greens_s: &Vec<f64>, logs: &[f64]| rings.with(greens_s, logs);
        search(&mut tried, (vec![by_flow], simulations), Some((&logs, &with)), &mut simulate)?;
        let (delay_s, best) = tried.swap_remove(0);
        self.greens_s[signal] = if best == rings.green_s { Vec::new() } else { best };
        Ok(delay_s)
    }

    /// Whether the greens save delay on further seeds, by more than chance.
    fn is_better(&mut self, trainer: &mut dyn Trainer) -> Result<bool, ControlError> {
        let found = self.greens_s.clone();
        let mut saved_s = Vec::new();
        for seed in FINAL_SEEDS {
            self.used += 2;
            let now_s = trainer.episode(self, seed)?.delay_s;
            self.greens_s.iter_mut().for_each(Vec::clear);
            saved_s.push(trainer.episode(self, seed)?.delay_s - now_s);
            self.greens_s.clone_from(&found);
        }
        let count = saved_s.len() as f64;
        let mean_s = saved_s.iter().sum::<f64>() / count;
        let squares = saved_s.iter().map(|s| (s - mean_s).powi(2)).sum::<f64>();
        Ok(mean_s > STANDARD_ERRORS * (squares / (count - 1.0) / count).sqrt())
    }
}

/// Returns what a time has beyond whole seconds, to the thousandth.
fn rest(seconds: f64) -> f64 {
    (seconds * 1000.0).round() % 1000.0 / 1000.0
}

/// What may be chosen of greens, and how it becomes greens.
impl RingGreens {
    /// Returns the splits of a ring together, seconds.
    pub(crate) fn split_s(&self, greens_s: &[f64], ring: &[usize]) -> f64 {
        ring.iter().map(|p| greens_s[*p] + self.change_s[*p]).sum()
    }

    /// Returns the length of a side, seconds.
    pub(crate) fn side_s(&self, greens_s: &[f64], side: &[Vec<usize>; 2]) -> f64 {
        self.split_s(greens_s, &side[0]).max(self.split_s(greens_s, &side[1]))
    }

    /// Returns phases that are lengthened together: of a cycle whole sides, but the last one where the cycle stays, and each
    /// phase before the last one of its ring; of others the last phases of a side, and those before them.
    fn groups(&self) -> Vec<Vec<usize>> {
        let earlier = |side: &[Vec<usize>; 2]| -> Vec<usize> {
            let of_ring = |ring: &Vec<usize>| ring[..ring.len().saturating_sub(1)].to_vec();
            side.iter().flat_map(of_ring).collect()
        };
        let Some([shortest_s, longest_s]) = self.cycle_s else {
            let last =
                |side: &[Vec<usize>; 2]| side.iter().filter_map(|r| r.last().copied()).collect();
            let both = self.sides.iter().flat_map(|side| [last(side), earlier(side)]);
            return both.filter(|group| !group.is_empty()).collect();
        };
        let count = self.sides.len() - usize::from(shortest_s == longest_s);
        let sides = self.sides.iter().take(count).map(|side| side.concat());
        sides.chain(self.sides.iter().flat_map(earlier).map(|p| vec![p])).collect()
    }

    /// Returns other greens.
    /// * `logs` — of the factors of the groups.
    fn with(&self, greens_s: &[f64], logs: &[f64]) -> Vec<f64> {
        let mut wanted_s = greens_s.to_vec();
        for (group, log) in self.groups().iter().zip(logs) {
            group.iter().for_each(|p| wanted_s[*p] *= log.exp());
        }
        self.fit(&wanted_s)
    }

    /// Keeps the last green of a ring that is done before the other one until the barrier, and returns the cycle, seconds.
    pub(crate) fn meet_at_barriers(&mut self) -> f64 {
        let mut cycle_s = 0.0;
        for side in &self.sides {
            let side_s = self.side_s(&self.green_s, side);
            for ring in side {
                let more_s = side_s - self.split_s(&self.green_s, ring);
                ring.last().iter().for_each(|p| self.green_s[**p] += more_s);
            }
            cycle_s += side_s;
        }
        cycle_s
    }

    /// Returns greens within their limits whose splits fill the sides of a cycle in both rings. What greens have beyond whole
    /// seconds stays.
    pub(crate) fn fit(&self, wanted_s: &[f64]) -> Vec<f64> {
        let rest_s: Vec<f64> = self.green_s.iter().map(|s| rest(*s)).collect();
        let whole = |p: usize| (wanted_s[p] - rest_s[p]).max(0.01);
        let least = |p: usize| (self.least_s[p] - rest_s[p]).ceil();
        let all = 0..wanted_s.len();
        let Some([shortest_s, longest_s]) = self.cycle_s else {
            let most = |p: usize| (self.most_s[p] - rest_s[p]).floor();
            return all.map(|p| whole(p).round().min(most(p)).max(least(p)) + rest_s[p]).collect();
        };
        let of_sides = |greens_s: &[f64]| -> Vec<f64> {
            self.sides.iter().map(|side| self.side_s(greens_s, side)).collect()
        };
        let unlimited = [f64::INFINITY; 99];
        let rests: Vec<f64> = of_sides(&self.green_s).into_iter().map(rest).collect();
        let shortest = of_sides(&all.map(|p| least(p) + rest_s[p]).collect::<Vec<_>>());
        let shortest: Vec<f64> =
            shortest.iter().zip(&rests).map(|(s, r)| (s - r).round()).collect();
        let wanted = of_sides(wanted_s);
        let cycle_s = wanted.iter().sum::<f64>().clamp(shortest_s, longest_s);
        let sides = fill(&wanted, &shortest, &unlimited, cycle_s - rests.iter().sum::<f64>());
        let mut greens_s = self.green_s.clone();
        for (side, side_s) in self.sides.iter().zip(sides.iter().zip(&rests).map(|(s, r)| s + r)) {
            for ring in side {
                let of = |seconds: &dyn Fn(usize) -> f64| -> Vec<f64> {
                    ring.iter().map(|p| seconds(*p)).collect()
                };
                let whole_s = side_s - self.split_s(&rest_s, ring);
                let filled = fill(&of(&whole), &of(&least), &unlimited, whole_s);
                ring.iter().zip(filled).for_each(|(p, s)| greens_s[*p] = s + rest_s[*p]);
            }
        }
        greens_s
    }

    /// Returns greens by flow ratio: that of the busiest lane of a phase, of a ring the sum, of a side the larger.
    fn by_flow(&self, flow_vph: &[f64], formula: &fixed_time::Config) -> Vec<f64> {
        let [least, most] = FLOW_RATIOS;
        let ratio = |lane: &usize| flow_vph[*lane] / formula.saturation_flow_vph;
        let busiest = |lanes: &Vec<usize>| lanes.iter().map(ratio).fold(least, f64::max);
        let ratios: Vec<f64> = self.lanes.iter().map(busiest).collect();
        let of_ring = |ring: &Vec<usize>| ring.iter().map(|p| ratios[*p]).sum::<f64>();
        let of_side = |side: &[Vec<usize>; 2]| of_ring(&side[0]).max(of_ring(&side[1]));
        let total: f64 = self.sides.iter().map(of_side).sum();
        let phases = self.sides.iter().map(|side| side[0].len().max(side[1].len()));
        let lost_s = formula.lost_time_s * phases.sum::<usize>() as f64;
        let green_s = (1.5 * lost_s + 5.0) / (1.0 - total.min(most)) - lost_s;
        let longer = if self.cycle_s.is_none() { LONGEST_OVER_MEAN } else { 1.0 };
        let wanted: Vec<f64> = ratios.iter().map(|r| r / total * green_s * longer).collect();
        self.fit(&wanted)
    }
}

#[cfg(test)]
mod tests {
    use super::super::EpisodeOutcome;
    use super::super::fixed_time::kept_start;
    use super::super::testing::two_phase_signal;
    use super::*;

    /// Phases 1, 2 and 5, 6 before a barrier, 4 and 8 after it, with splits of 15, 34 and 25 s and 4.5 s of change in each.
    fn rings(cycle_s: Option<[f64; 2]>) -> RingGreens {
        RingGreens {
            sides: vec![[vec![0, 1], vec![2, 3]], [vec![4], vec![5]]],
            green_s: vec![10.5, 29.5, 10.5, 29.5, 20.5, 20.5],
            least_s: vec![5.0, 21.0, 5.0, 14.0, 7.0, 12.0],
            most_s: vec![60.0; 6],
            change_s: vec![4.5; 6],
            lanes: vec![vec![], vec![0], vec![], vec![], vec![1], vec![]],
            cycle_s,
        }
    }

    #[test]
    fn splits_fill_the_cycle_in_both_rings_within_the_least_greens() {
        for cycle_s in [[74.0; 2], [60.0, 120.0]] {
            let rings = rings(Some(cycle_s));
            let logs = vec![0.0f64; rings.groups().len()];
            assert_eq!(rings.with(&rings.green_s, &logs), rings.green_s, "nothing changes");
            assert_eq!(logs.len(), if cycle_s[0] == cycle_s[1] { 3 } else { 4 });
            for (factor, place) in [(0.1f64, 0), (0.9, 1), (3.0, 2), (20.0, 1), (20.0, 0)] {
                let mut logs = logs.clone();
                logs[place] = factor.ln();
                let greens_s = rings.with(&rings.green_s, &logs);
                let split = |ring: &[usize]| rings.split_s(&greens_s, ring);
                let sides = [split(&[0, 1]), split(&[4])];
                assert_eq!(sides, [split(&[2, 3]), split(&[5])], "{greens_s:?}");
                let total_s: f64 = sides.iter().sum();
                assert!(cycle_s[0] <= total_s && total_s <= cycle_s[1], "{total_s}");
                let mut greens = greens_s.iter().zip(&rings.least_s);
                assert!(greens.all(|(s, least_s)| s >= least_s && s.fract() == 0.5));
            }
        }
    }

    #[test]
    fn flow_ratios_share_the_cycle_and_longest_greens_keep_to_their_limits() {
        let greens_s =
            rings(Some([74.0; 2])).by_flow(&[950.0, 190.0], &fixed_time::Config::default());
        // Side 2 has its shortest green of 12 s, and half a second that stays; side 1 what is left of 74 s.
        assert_eq!(greens_s, [5.5, 42.5, 24.5, 23.5, 12.5, 12.5]);
        let free = rings(None);
        let longer = free.with(&free.green_s, &[20f64.ln(), 0.0, 0.5f64.ln()]);
        assert_eq!(longer, [10.5, 59.5, 10.5, 59.5, 10.5, 12.5]);
    }

    /// Delay is the distance of a green to 30.5 s; on further seeds a saving is of chance, unless it is real.
    struct Valley {
        episodes: u32,
        is_real: bool,
    }

    impl Trainer for Valley {
        fn episode(
            &mut self,
            controller: &mut dyn Controller,
            seed: u32,
        ) -> Result<EpisodeOutcome, ControlError> {
            self.episodes += 1;
            let drives = controller.begin(&[two_phase_signal()])?;
            let Drive::Retimed(_, greens_s) = &drives[0] else { panic!("{drives:?}") };
            let distance_s = (greens_s.get(4).unwrap_or(&20.5) - 30.5).abs();
            let chance_s = if greens_s.is_empty() { f64::from(seed % 2) } else { 0.5 };
            let delay_s = if seed == 0 || self.is_real { 20.0 + distance_s } else { chance_s };
            let (rings, lane_flow_vph) = (vec![Some(rings(Some([74.0; 2])))], vec![vec![400.0; 2]]);
            Ok(EpisodeOutcome { delay_s, lane_flow_vph, rings })
        }

        fn decisions_per_episode(&self) -> u32 {
            360
        }
    }

    #[test]
    fn a_saving_that_is_no_more_than_chance_on_further_seeds_changes_nothing() {
        for is_real in [true, false] {
            let mut valley = Valley { episodes: 0, is_real };
            let setup = Setup::default();
            let mut retime = create(&Config::default(), &setup);
            retime.train(&mut valley).unwrap();
            let details = retime.details();
            assert_eq!(kept_start(&details), Some(!is_real), "{details:?}");
            assert_eq!(details[SIMULATIONS], valley.episodes.to_string());
            assert!(valley.episodes <= Config::default().simulations);
            let drives = retime.begin(&[two_phase_signal()]).unwrap();
            let Drive::Retimed(_, greens_s) = &drives[0] else { panic!("{drives:?}") };
            assert_eq!(greens_s.is_empty(), !is_real);
            assert!(greens_s.get(4).is_none_or(|s| (s - 30.5).abs() <= 2.0), "{greens_s:?}");
        }
    }
}
