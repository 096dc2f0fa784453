//! Tuning against delays that are known in closed form.

use super::super::testing::two_phase_signal;
use super::*;

const CONSTANTS: Constants = Constants { lost_time_s: 4.0, saturation_flow_vph: 1900.0 };

/// Delay is the distance to the greens 30 s and 12 s; the own program is far off.
struct Valley {
    signal: SignalSpec,
    episodes: u32,
    own: f64,
    fails_at: u32,
}

fn valley(own: f64) -> Valley {
    Valley { signal: two_phase_signal(), episodes: 0, own, fails_at: u32::MAX }
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

impl Trainer for Valley {
    fn episode(
        &mut self,
        controller: &mut dyn Controller,
        _seed: u32,
    ) -> Result<EpisodeOutcome, ControlError> {
        if self.episodes == self.fails_at {
            return Err(ControlError::Episode("planned failure".into()));
        }
        let drives = controller.begin(std::slice::from_ref(&self.signal))?;
        let delay_s = self.delay_s(&drives[0]);
        Ok(EpisodeOutcome { delay_s, lane_flow_vph: vec![vec![400.0, 400.0]] })
    }

    fn decisions_per_episode(&self) -> u32 {
        360
    }
}

fn tuned(own: f64, simulations: u32) -> (FixedTime, u32) {
    let mut trainer = valley(own);
    let mut controller = FixedTime::new(CONSTANTS, simulations);
    controller.train(&mut trainer).unwrap();
    (controller, trainer.episodes)
}

#[test]
fn the_search_finds_the_valley() {
    let (controller, _) = tuned(1000.0, 60);
    let Plan::Cycle(greens) = &controller.plans[0] else { panic!("a cycle is better") };
    assert!((greens[0].1 - 30.0).abs() <= 2.0 && (greens[1].1 - 12.0).abs() <= 2.0, "{greens:?}");
}

#[test]
fn no_more_simulations_are_used_than_allowed() {
    for budget in [1, 5, 8, 30] {
        let (controller, episodes) = tuned(1000.0, budget);
        assert!(episodes <= budget.max(1), "{episodes} of {budget}");
        assert_eq!(controller.details()["simulations"], episodes.to_string());
    }
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
        Ok(EpisodeOutcome { delay_s, lane_flow_vph: vec![vec![400.0, 400.0]; signals.len()] })
    }

    fn decisions_per_episode(&self) -> u32 {
        360
    }
}

#[test]
fn every_signal_of_several_is_tuned_as_one_alone_is() {
    for signals in [2, 4, 9] {
        let mut trainer = Valleys((0..signals).map(|_| valley(1000.0)).collect());
        let mut controller = FixedTime::new(CONSTANTS, Config::default().simulations);
        controller.train(&mut trainer).unwrap();
        assert!(controller.plans.iter().all(|p| *p != Plan::Own), "{:?}", controller.plans);
        let used = trainer.0[0].episodes;
        assert!((8 * signals..=24 * signals).contains(&used), "{used} for {signals} signals");
    }
}

#[test]
fn a_training_episode_that_fails_is_an_error() {
    for fails_at in 0..20 {
        let mut trainer = Valley { fails_at, ..valley(1000.0) };
        let e = FixedTime::new(CONSTANTS, 30).train(&mut trainer).unwrap_err();
        assert!(e.to_string().contains("planned failure"), "{e}");
    }
}

#[test]
fn an_own_program_beyond_the_limits_is_no_choice() {
    for simulations in [1, 8, 30] {
        let mut trainer = valley(1.0);
        trainer.signal.limits.own_program = false;
        let mut controller = FixedTime::new(CONSTANTS, simulations);
        controller.train(&mut trainer).unwrap();
        assert_ne!(controller.plans, [Plan::Own], "{simulations} simulations");
    }
}

#[test]
fn the_own_program_is_kept_when_nothing_beats_it() {
    assert_eq!(tuned(1.0, 30).0.plans, [Plan::Own]);
}
