//! What `coordinated` finds on a street of three signals.

use super::super::testing::two_phase_signal;
use super::super::{EpisodeOutcome, LaneSpec, Onward};
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

#[test]
fn offsets_along_a_street_are_its_travel_times_whatever_phase_comes_first() {
    let signals = street();
    let streets = streets(&signals);
    let coordinated = Coordinated {
        signals,
        streets: streets.into_iter().map(|street| (0.0, street)).collect(),
        ..Coordinated::default()
    };
    let plan = |phases: [usize; 2]| {
        let (phases, greens_s) = (phases.to_vec(), vec![27.0, 27.0]);
        Some(Timed { phases, greens_s, offset_s: 0, cycle_s: 60 })
    };
    let offsets = |first: usize| -> Vec<u32> {
        let plans = vec![plan([0, 1]), plan([1, 0]), plan([0, 1])];
        let plans = coordinated.progression(plans, &coordinated.streets[first].1);
        plans.iter().flatten().map(|plan| plan.offset_s).collect()
    };
    // The street's green of the second signal begins 30 s after its first one.
    assert_eq!(offsets(0), [0, 50, 50]);
    assert_eq!(offsets(1), [50, 0, 0]);
}

/// A street where delay is the distance from a cycle of 35 s.
struct Corridor {
    signals: Vec<SignalSpec>,
    episodes: u32,
}

impl Trainer for Corridor {
    fn episode(
        &mut self,
        controller: &mut dyn Controller,
        _seed: u32,
    ) -> Result<EpisodeOutcome, ControlError> {
        self.episodes += 1;
        let cycles_s: Vec<f64> =
            controller.begin(&self.signals)?.iter().filter_map(cycle).map(cycle_s).collect();
        assert!(cycles_s.windows(2).all(|pair| pair[0] == pair[1]), "one cycle: {cycles_s:?}");
        let delay_s = cycles_s.first().map_or(200.0, |cycle_s| 10.0 + (cycle_s - 35.0).abs());
        let lane_flow_vph = vec![vec![500.0, 300.0, 100.0]; 3];
        Ok(EpisodeOutcome { delay_s, lane_flow_vph, ..EpisodeOutcome::default() })
    }

    fn decisions_per_episode(&self) -> u32 {
        1
    }
}

fn cycle(drive: &Drive) -> Option<&RingStages> {
    if let Drive::CoordinatedRings(_, cycle) = drive { Some(cycle) } else { None }
}

fn cycle_s(cycle: &RingStages) -> f64 {
    cycle.greens.iter().map(|g| g.duration_s).sum::<f64>() + 6.0
}

#[test]
fn rings_follow_the_progression_of_the_best_cycle_with_the_green_of_the_street_as_the_coordinated_one()
 {
    let mut corridor = Corridor { signals: street(), episodes: 0 };
    let config = Config { simulations: 40, passage_s: 3, ..Default::default() };
    let mut controller = create(&config, &Setup::default());
    controller.begin(&corridor.signals).unwrap();
    controller.train(&mut corridor).unwrap();
    let drives = controller.begin(&corridor.signals).unwrap();
    let details = controller.details();
    // 40 times the root of three.
    assert!(corridor.episodes <= 70 && details["simulations"] == corridor.episodes.to_string());
    let Drive::CoordinatedRings(rings, _) = &drives[0] else { panic!("{drives:?}") };
    assert_eq!((rings.passage_s, rings.recall), (3, Recall::None));
    let along = &corridor.signals[0].phases[0].state;
    let cycles: Vec<&RingStages> = drives.iter().filter_map(cycle).collect();
    assert!(cycles.iter().all(|c| c.greens[c.coordinated].state == *along), "{cycles:?}");
    assert!((cycle_s(cycles[0]) - 35.0).abs() <= 5.0, "{cycles:?}");
    let relative_s = f64::from(cycles[1].offset_s) - f64::from(cycles[0].offset_s);
    let along_s = relative_s.rem_euclid(cycle_s(cycles[0]));
    // In the one or the other direction.
    let back_s = cycle_s(cycles[0]) - along_s;
    assert!([along_s, back_s].contains(&20.0), "{cycles:?}");
}
