//! Tuning against delays that are known in closed form.

use super::super::testing::two_phase_signal;
use super::*;
use evaluation::settings::setting::Section;

const CONSTANTS: Constants = Constants { lost_time_s: 4.0, saturation_flow_vph: 1900.0 };

/// Delay is the distance to the greens 30 s and 12 s; the own program is far off.
struct Valley {
    signal: SignalSpec,
    episodes: u32,
    own: f64,
}

fn valley(own: f64) -> Valley {
    Valley { signal: two_phase_signal(), episodes: 0, own }
}

impl Valley {
    fn delay_s(&mut self, drive: &Drive) -> f64 {
        self.episodes += 1;
        match drive {
            Drive::Cycle(g) => 10.0 + (g[0].1 - 30.0).abs() + (g[1].1 - 12.0).abs(),
            _ => self.own,
        }
    }
}

fn tuned(own: f64, simulations: u32) -> (FixedTime, u32) {
    let mut trainer = Valleys(vec![valley(own)]);
    let mut controller = FixedTime::new(CONSTANTS, simulations);
    controller.train(&mut trainer).unwrap();
    (controller, trainer.0[0].episodes)
}

#[test]
fn the_search_finds_the_valley() {
    let (controller, _) = tuned(1000.0, 60);
    let Drive::Cycle(greens) = &controller.plans[0] else { panic!("a cycle is better") };
    assert!((greens[0].1 - 30.0).abs() <= 2.0 && (greens[1].1 - 12.0).abs() <= 2.0, "{greens:?}");
}

/// Signals whose delays add up, each a [`Valley`].
struct Valleys(Vec<Valley>);

impl Trainer for Valleys {
    fn episode(
        &mut self,
        controller: &mut dyn Controller,
        _seed: u32,
    ) -> Result<EpisodeOutcome, ControlError> {
        let signals: Vec<_> = self.0.iter().map(|v| v.signal.clone()).collect();
        let drives = controller.begin(&signals)?;
        let delay = |(valley, drive): (&mut Valley, &Drive)| valley.delay_s(drive);
        let delay_s = self.0.iter_mut().zip(&drives).map(delay).sum();
        let lane_flow_vph = vec![vec![400.0, 400.0]; signals.len()];
        Ok(EpisodeOutcome { delay_s, lane_flow_vph, ..EpisodeOutcome::default() })
    }

    fn decisions_per_episode(&self) -> u32 {
        360
    }
}

#[test]
fn several_signals_are_tuned_within_a_budget_that_grows_with_the_root_of_their_number() {
    let simulations = Config::default().simulations;
    assert_eq!([1, 4, 43].map(|signals| budget(simulations, signals)), [24, 48, 158]);
    for signals in [2, 4, 9] {
        let mut trainer = Valleys((0..signals).map(|_| valley(1000.0)).collect());
        let mut controller = FixedTime::new(CONSTANTS, simulations);
        controller.train(&mut trainer).unwrap();
        assert!(controller.plans.iter().all(|p| *p != Drive::OwnProgram), "{:?}", controller.plans);
        let used = trainer.0[0].episodes;
        assert!(used <= budget(simulations, signals), "{used} for {signals} signals");
        assert_eq!(controller.details()["simulations"], used.to_string());
        let delays = controller.begin(&controller.signals.clone()).unwrap();
        let tuned: f64 = delays.iter().map(|drive| valley(0.0).delay_s(drive)).sum();
        let mut alone = FixedTime::new(CONSTANTS, 8);
        alone.train(&mut Valleys(vec![valley(1000.0)])).unwrap();
        let webster = valley(0.0).delay_s(&alone.plans[0]);
        assert!(tuned < 0.8 * webster * f64::from(signals), "{tuned}, {webster} each before");
    }
}

#[test]
fn a_signal_whose_own_program_is_best_keeps_it_among_others_that_are_tuned() {
    let mut trainer = Valleys(vec![valley(1000.0), valley(1.0), valley(1000.0)]);
    let mut controller = FixedTime::new(CONSTANTS, 24);
    controller.train(&mut trainer).unwrap();
    let own: Vec<bool> = controller.plans.iter().map(|p| *p == Drive::OwnProgram).collect();
    assert_eq!(own, [false, true, false]);
    assert_eq!(kept_start(&controller.details()), Some(false));
}

#[test]
fn the_least_budget_tries_a_plan_and_fewer_simulations_are_refused() {
    let ranges = Config::default().ranges();
    let least = ranges.iter().find(|r| r.name == "simulations").unwrap().low as u32;
    assert_ne!(tuned(1000.0, least).0.plans, [Drive::OwnProgram]);
    assert_eq!(tuned(1000.0, least - 1).0.plans, [Drive::OwnProgram], "less has no effect");
}

#[test]
fn whether_tuning_improved_on_its_start_follows_from_the_details_of_its_record() {
    assert_eq!(kept_start(&tuned(1.0, 30).0.details()), Some(true));
    let improved = tuned(1000.0, 30).0.details();
    assert_eq!(kept_start(&improved), Some(false));
    assert!(!improved.contains_key("tuning"));
    assert_eq!(kept_start(&BTreeMap::from([("phase".into(), "x".into())])), None);
    // Its own program is no choice, and whatever cycle it has is as good.
    let mut trainer = Valleys(vec![valley(1.0), valley(1.0)]);
    trainer.0.iter_mut().for_each(|v| v.signal.limits.own_program = false);
    let mut controller = FixedTime::new(CONSTANTS, 30);
    controller.train(&mut trainer).unwrap();
    let tuned = controller.details();
    controller.plans =
        (controller.signals.iter()).map(|spec| controller.start(spec, &[400.0, 400.0])).collect();
    controller.kept_start = true;
    assert_eq!((kept_start(&tuned), kept_start(&controller.details())), (Some(false), Some(true)));
}

#[test]
fn an_own_program_beyond_the_limits_is_no_choice() {
    for simulations in [1, 8, 30] {
        let mut trainer = Valleys(vec![valley(1.0)]);
        trainer.0[0].signal.limits.own_program = false;
        let mut controller = FixedTime::new(CONSTANTS, simulations);
        controller.train(&mut trainer).unwrap();
        assert_ne!(controller.plans, [Drive::OwnProgram], "{simulations} simulations");
    }
}
