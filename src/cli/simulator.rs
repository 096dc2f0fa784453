//! The simulator, and whether it can load what is given.

use std::path::PathBuf;

use crate::traffic::settings::SignalSettings;
use crate::traffic::sim::error::SimError;

/// Returns the simulator's version after loading every imported scenario once, so that one that
/// cannot be simulated is refused before anything is written.
#[cfg(feature = "libsumo")]
pub(super) fn simulator(sumocfgs: &[PathBuf], settings: &SignalSettings) -> anyhow::Result<String> {
    use crate::traffic::env::derive::derive;
    use crate::traffic::sim::libsumo::SumoSim;
    use crate::traffic::sim::{Sim, StartOptions};

    let mut sim = SumoSim::new()?;
    for config in sumocfgs {
        let options = StartOptions { config: config.clone(), ..StartOptions::default() };
        let check = |sim: &mut SumoSim| -> Result<(), SimError> {
            let scene = sim.start(&options)?;
            sim.close()?;
            scene.signals.iter().try_for_each(|signal| derive(&scene, signal, settings).map(drop))
        };
        check(&mut sim).map_err(|e| explained(e, config))?;
    }
    Ok(sim.version()?)
}

/// Returns the error of a scenario that could not be loaded, with its file.
#[cfg(feature = "libsumo")]
pub(super) fn explained(error: SimError, config: &std::path::Path) -> SimError {
    match error {
        SimError::Fatal { message, .. } => SimError::Config {
            path: config.to_path_buf(),
            reason: format!("SUMO cannot load it ({message}); its reason is above"),
        },
        other => other,
    }
}

#[cfg(not(feature = "libsumo"))]
pub(super) fn simulator(
    _sumocfgs: &[PathBuf],
    _settings: &SignalSettings,
) -> anyhow::Result<String> {
    Err(SimError::Unavailable("built without the feature `libsumo`".into()).into())
}
