//! What `coordinated` finds on a street of three signals.

use std::cell::RefCell;

use super::super::nema_coordinated;
use super::super::streets::Street;
use super::super::testing::two_phase_signal;
use super::super::{LaneSpec, Onward};
use super::*;

/// Three signals of a street, 20 and 30 s apart; movement 0 goes along it, 2 comes back, 1 crosses.
fn street() -> Vec<SignalSpec> {
    let signal = |id: usize| {
        let mut spec = two_phase_signal();
        spec.id = format!("s{id}");
        let back = spec.movements[0].clone();
        spec.movements.push(back);
        spec.movements.iter_mut().for_each(|m| m.downstream = Vec::new());
        spec.movements[2].lanes = vec![2];
        spec.lanes.push(LaneSpec { id: "back_0".into(), length_m: 200.0 });
        let along = spec.phases[0].service[0];
        spec.phases[0].service.push(along);
        let across = spec.phases[1].service[0];
        spec.phases[1].service.push(across);
        spec
    };
    let mut signals: Vec<SignalSpec> = (0..3).map(signal).collect();
    let mut lead = |from: usize, movement: usize, signal: usize, lane: usize, travel_s: f64| {
        let onward = Onward { movement, signal, lane, travel_s, distance_m: 10.0 * travel_s };
        signals[from].onward.push(onward);
    };
    lead(0, 0, 1, 0, 20.0);
    lead(1, 0, 2, 0, 30.0);
    lead(2, 2, 1, 2, 30.0);
    lead(1, 2, 0, 2, 20.0);
    signals
}

fn plan(offset_s: u32) -> Option<Timed> {
    Some(Timed { phases: vec![0, 1], greens_s: vec![27.0, 27.0], offset_s, cycle_s: 60 })
}

#[test]
fn a_street_is_followed_in_both_directions() {
    let streets = streets(&street());
    let stops = |street: &Street| -> Vec<(usize, usize, f64)> {
        street.stops.iter().map(|s| (s.signal, s.movement, s.after_s)).collect()
    };
    assert_eq!(streets.len(), 2);
    assert_eq!(stops(&streets[0]), [(0, 0, 0.0), (1, 0, 20.0), (2, 0, 50.0)]);
    assert_eq!(stops(&streets[1]), [(2, 2, 0.0), (1, 2, 30.0), (0, 2, 50.0)]);
}

#[test]
fn a_street_that_leads_round_ends_before_it_comes_back() {
    let mut signals = street();
    let back = Onward { movement: 0, signal: 0, lane: 0, travel_s: 9.0, distance_m: 90.0 };
    signals[2].onward.push(back);
    let lengths: Vec<usize> = streets(&signals).iter().map(|s| s.stops.len()).collect();
    assert_eq!(lengths, [3, 3]);
}

#[test]
fn the_offsets_of_one_direction_are_its_travel_times() {
    let signals = street();
    let mut one_way = streets(&signals);
    one_way.truncate(1);
    let mut plans = vec![plan(0), plan(0), plan(0)];
    let before = efficiency(&signals, (&one_way, &[1.0]), &plans);
    ascend(&signals, (&one_way, &[1.0]), &mut plans);
    let offsets: Vec<i64> = plans.iter().flatten().map(|plan| i64::from(plan.offset_s)).collect();
    let relative = [offsets[1] - offsets[0], offsets[2] - offsets[0]].map(|s| s.rem_euclid(60));
    assert_eq!(relative, [20, 50]);
    // The band is the whole green, 27 of 60 s, and so is what neighbours have in common.
    assert!((efficiency(&signals, (&one_way, &[1.0]), &plans) - 1.1 * 27.0 / 60.0).abs() < 1e-9);
    assert!(before < 0.1, "{before}");
}

#[test]
fn both_directions_have_the_bands_that_trying_all_offsets_finds() {
    let signals = street();
    let both = streets(&signals);
    let both = (both.as_slice(), [1.0, 0.6].as_slice());
    let mut plans = vec![plan(0), plan(0), plan(0)];
    ascend(&signals, both, &mut plans);
    let found = efficiency(&signals, both, &plans);
    let mut most = 0.0_f64;
    for a in 0..60 {
        for b in 0..60 {
            most = most.max(efficiency(&signals, both, &[plan(0), plan(a), plan(b)]));
        }
    }
    assert!((found - most).abs() < 1e-9, "{found} of {most}");
}

#[test]
fn signals_that_lead_to_no_other_have_nothing_to_coordinate() {
    let mut alone = create(&Config::default(), &Setup::default());
    let e = alone.begin(&[two_phase_signal()]).unwrap_err().to_string();
    assert!(e.contains("nothing to coordinate; run fixed-time"), "{e}");
    let mut alone =
        nema_coordinated::create(&nema_coordinated::Config::default(), &Setup::default());
    let e = alone.begin(&[two_phase_signal()]).unwrap_err().to_string();
    assert!(e.contains("nothing to coordinate; run nema"), "{e}");
}

/// A street where delay is the distance from perfect progression along it and from a cycle of 80 s.
struct Corridor {
    signals: Vec<SignalSpec>,
    episodes: RefCell<Vec<u32>>,
    /// What its own programs cost, seconds.
    own_s: f64,
}

impl Trainer for Corridor {
    fn episode(
        &mut self,
        controller: &mut dyn Controller,
        seed: u32,
    ) -> Result<EpisodeOutcome, ControlError> {
        self.episodes.borrow_mut().push(seed);
        let drives = controller.begin(&self.signals)?;
        let timed = |drive: &Drive| match drive {
            Drive::Coordinated(greens, offset_s) => {
                Some((greens.iter().map(|g| g.1).sum::<f64>() + 6.0, *offset_s))
            }
            Drive::CoordinatedRings(_, cycle) => {
                let greens_s = cycle.greens.iter().map(|g| g.1).sum::<f64>();
                Some((greens_s + 6.0, f64::from(cycle.offset_s)))
            }
            _ => None,
        };
        let plans: Option<Vec<(f64, f64)>> = drives.iter().map(timed).collect();
        let delay_s = plans.map_or(self.own_s, |plans| {
            let cycle_s = plans[0].0;
            assert!(plans.iter().all(|plan| plan.0 == cycle_s), "one cycle: {plans:?}");
            let off = |i: usize, after_s: f64| {
                let from_s = (plans[i].1 - plans[0].1 - after_s).rem_euclid(cycle_s);
                from_s.min(cycle_s - from_s)
            };
            10.0 + off(1, 24.0) + off(2, 50.0) + (cycle_s - 80.0).abs() / 10.0
        });
        Ok(EpisodeOutcome { delay_s, lane_flow_vph: vec![vec![500.0, 300.0, 100.0]; 3] })
    }

    fn decisions_per_episode(&self) -> u32 {
        1
    }
}

fn tuned(own_s: f64, simulations: u32) -> (BTreeMap<String, String>, Vec<u32>, Vec<Drive>) {
    let mut corridor = Corridor { signals: street(), episodes: RefCell::default(), own_s };
    let config = Config { simulations, ..Config::default() };
    let mut controller = create(&config, &Setup::default());
    controller.begin(&corridor.signals).unwrap();
    controller.train(&mut corridor).unwrap();
    let drives = controller.begin(&corridor.signals).unwrap();
    (controller.details(), corridor.episodes.into_inner(), drives)
}

#[test]
fn tuning_keeps_to_its_budget_and_finds_the_progression() {
    let (details, episodes, drives) = tuned(200.0, 40);
    // 40 times the root of three.
    assert!(episodes.len() <= 70, "{}", episodes.len());
    assert_eq!(details["simulations"], episodes.len().to_string());
    assert_eq!(episodes.iter().filter(|seed| **seed != SEARCH_SEED).count(), 6);
    let timed = |i: usize| match &drives[i] {
        Drive::Coordinated(greens, offset_s) => {
            (greens.iter().map(|g| g.1).sum::<f64>() + 6.0, *offset_s)
        }
        other => panic!("{other:?}"),
    };
    // The bands are widest at 20 s; the search in simulation finds 24 s.
    let relative_s = (timed(1).1 - timed(0).1).rem_euclid(timed(0).0);
    assert!((relative_s - 24.0).abs() <= 2.0, "{details:?}");
    assert!(details["plan s1"].starts_with("cycle "), "{details:?}");
    assert!(!details.contains_key("tuning"), "{details:?}");
}

#[test]
fn own_programs_stay_where_nothing_is_better() {
    let (details, _, drives) = tuned(1.0, 8);
    assert_eq!(drives, vec![Drive::OwnProgram; 3]);
    assert_eq!(details["plan s0"], OWN);
}

#[test]
fn rings_follow_the_progression_with_the_green_of_the_street_as_the_coordinated_one() {
    let mut corridor = Corridor { signals: street(), episodes: RefCell::default(), own_s: 1.0 };
    let config = nema_coordinated::Config { simulations: 40, passage_s: 3, ..Default::default() };
    let mut controller = nema_coordinated::create(&config, &Setup::default());
    controller.begin(&corridor.signals).unwrap();
    controller.train(&mut corridor).unwrap();
    let drives = controller.begin(&corridor.signals).unwrap();
    let cycles: Vec<&StageCycle> = drives
        .iter()
        .map(|drive| match drive {
            Drive::CoordinatedRings(rings, cycle) => {
                assert_eq!((rings.passage_s, rings.recall), (3, dual_ring::Recall::None));
                cycle
            }
            // The own programs are better here, but no two rings run them.
            other => panic!("{other:?}"),
        })
        .collect();
    for cycle in &cycles {
        assert_eq!(cycle.greens[cycle.coordinated].0, GreenPhase(0), "{cycle:?}");
    }
    let cycle_s = cycles[0].greens.iter().map(|g| g.1).sum::<f64>() + 6.0;
    let relative_s = f64::from(cycles[1].offset_s) - f64::from(cycles[0].offset_s);
    assert!((relative_s.rem_euclid(cycle_s) - 24.0).abs() <= 2.0, "{cycles:?}");
}
