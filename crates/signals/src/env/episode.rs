//! One whole episode of a controller.

pub use super::metrics::EpisodeMetrics;

use crate::control::{ControlError, Controller, Drive, GreenPhase};
use crate::sim::Sim;
use crate::sim::error::SimError;

use super::signal_env::SignalEnv;

/// Why an episode with a controller failed.
#[derive(Debug, thiserror::Error)]
pub enum EpisodeError {
    /// The simulation failed.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// The controller cannot control a signal.
    #[error(transparent)]
    Control(#[from] ControlError),
}

/// Runs one episode of a controller from reset to the end.
///
/// # Errors
///
/// [`EpisodeError`] when the simulation or the controller fails.
pub fn run_episode<S: Sim>(
    env: &mut SignalEnv<S>,
    controller: &mut dyn Controller,
    seed: u64,
) -> Result<EpisodeMetrics, EpisodeError> {
    env.reset(seed)?;
    let drives = controller.begin(env.signals())?;
    let (given, signals) = (drives.len(), env.signals().len());
    if given != signals {
        let reason = format!(
            "it says what drives {given} signals of {signals}; `begin` has to return one per signal"
        );
        return Err(ControlError::Own { method: controller.name(), reason }.into());
    }
    env.drive(&drives)?;
    let decides = drives.contains(&Drive::Decisions);
    let mut phases = vec![GreenPhase(0); drives.len()];
    loop {
        if decides {
            controller.act(env.observations(), &mut phases)?;
        }
        let truncated = env.step(&phases)?;
        if decides {
            controller.observe(env.observations(), truncated);
        }
        if truncated {
            break;
        }
    }
    Ok(env.finish()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::{ControlError, Observation, SignalSpec};
    use crate::env::testing::env;
    use crate::sim::testing::MockSim;

    /// Plays a fixed list of phases, the last one for ever.
    struct Script(Vec<usize>, usize);

    impl Controller for Script {
        fn name(&self) -> &'static str {
            "script"
        }
        fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
            Ok(vec![Drive::Decisions; signals.len()])
        }
        fn act(
            &mut self,
            _: &[Observation],
            phases: &mut [GreenPhase],
        ) -> Result<(), ControlError> {
            phases[0] = GreenPhase(self.0[self.1.min(self.0.len() - 1)]);
            self.1 += 1;
            Ok(())
        }
    }

    fn letters(env: &mut SignalEnv<MockSim>) -> String {
        env.sim_mut()
            .history
            .iter()
            .map(|s| if s[0].contains('y') { 'y' } else { s[0].chars().next().unwrap() })
            .collect()
    }

    #[test]
    fn a_change_costs_three_seconds_of_yellow_and_staying_costs_none() {
        let dir = tempfile::tempdir().unwrap();
        let mut env = env(vec![], dir.path());
        run_episode(&mut env, &mut Script(vec![0, 1, 1, 0], 0), 1).unwrap();
        assert_eq!(
            letters(&mut env),
            "GGGGGGGGGGyyyrrrrrrrrrrrrrrrrryyyGGGGGGGGGGGGGGGGGGGGGGGGGGG"
        );
    }

    #[test]
    fn a_controller_that_forgets_a_signal_is_refused() {
        struct Forgetful;
        impl Controller for Forgetful {
            fn name(&self) -> &'static str {
                "forgetful"
            }
            fn begin(&mut self, _: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
                Ok(Vec::new())
            }
        }
        let dir = tempfile::tempdir().unwrap();
        let e = run_episode(&mut env(vec![], dir.path()), &mut Forgetful, 1).unwrap_err();
        assert_eq!(
            e.to_string(),
            "forgetful: it says what drives 0 signals of 1; `begin` has to return one per signal"
        );
    }

    #[test]
    fn delay_counts_vehicles_that_never_leave() {
        let dir = tempfile::tempdir().unwrap();
        let mut env = env(vec![(10.0, 1), (20.0, 1)], dir.path());
        let metrics = run_episode(&mut env, &mut Script(vec![0], 0), 1).unwrap();
        assert_eq!(metrics.delay_s(), Some(45.0));
        assert_eq!((metrics.trips.arrived, metrics.trips.running), (0, 2));
        assert_eq!(metrics.max_queue_veh, 2.0);
        assert_eq!(metrics.lane_flow_vph, [[0.0, 120.0]]);
    }

    #[test]
    fn a_failing_simulation_is_an_error_and_the_next_episode_runs() {
        let dir = tempfile::tempdir().unwrap();
        let mut env = env(vec![], dir.path());
        env.sim_mut().fails_at_s = Some(25.0);
        let e = run_episode(&mut env, &mut Script(vec![0], 0), 1).unwrap_err();
        assert_eq!(e.to_string(), "sumo failed in `step`: the mock fails");
        env.sim_mut().fails_at_s = None;
        run_episode(&mut env, &mut Script(vec![0], 0), 1).unwrap();
    }
}
