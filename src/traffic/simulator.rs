//! The simulator itself: its version, and whether it can load somebody's scenario.

use std::path::Path;

use super::settings::SignalSettings;
use super::sim::SimError;
pub use super::sim::lights::signals_in;

/// Returns the simulator's version.
///
/// # Errors
///
/// [`SimError::Unavailable`] when it is missing.
#[cfg(feature = "libsumo")]
pub fn version() -> Result<String, SimError> {
    use super::sim::Sim;

    super::sim::libsumo::SumoSim::new()?.version()
}

/// Loads a SUMO scenario once, and looks whether its signals can be controlled; one with files that
/// would write over others, or that draw in what cannot be followed, is not loaded.
///
/// # Errors
///
/// [`SimError`] naming the file.
#[cfg(feature = "libsumo")]
pub fn check(config: &Path, settings: &SignalSettings) -> Result<(), SimError> {
    use super::env::derive::derive;
    use super::sim::libsumo::SumoSim;
    use super::sim::sources::sources;
    use super::sim::sumocfg::SumoConfig;
    use super::sim::{Sim, StartOptions};

    // What SUMO would write is found before it is started.
    sources(&SumoConfig::read(config)?)?;
    let mut sim = SumoSim::new()?;
    let options = StartOptions { config: config.to_path_buf(), ..StartOptions::default() };
    let mut load = || -> Result<(), SimError> {
        let scene = sim.start(&options)?;
        sim.close()?;
        scene.signals.iter().try_for_each(|signal| derive(&scene, signal, settings).map(drop))
    };
    load().map_err(|e| explained(e, config))
}

/// Returns the error of a scenario that could not be loaded, with its file.
#[cfg(feature = "libsumo")]
pub fn explained(error: SimError, config: &Path) -> SimError {
    match error {
        SimError::Fatal { message, .. } => SimError::Config {
            path: config.to_path_buf(),
            reason: format!("SUMO cannot load it ({message}); its reason is above"),
        },
        SimError::Signal { signal, reason } => SimError::Config {
            path: config.to_path_buf(),
            reason: format!("signal {signal}: {reason}"),
        },
        other => other,
    }
}

/// Returns the simulator's version, which this build cannot have.
///
/// # Errors
///
/// [`SimError::Unavailable`].
#[cfg(not(feature = "libsumo"))]
pub fn version() -> Result<String, SimError> {
    Err(SimError::Unavailable("built without the feature `libsumo`".into()))
}

/// Loads a SUMO scenario, which this build cannot.
///
/// # Errors
///
/// [`SimError::Unavailable`].
#[cfg(not(feature = "libsumo"))]
pub fn check(_: &Path, _: &SignalSettings) -> Result<(), SimError> {
    version().map(drop)
}
