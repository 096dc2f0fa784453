//! From a method and a scenario to a controller, and how long it is trained.

use crate::control::fixed_time::budget;
use crate::control::registry::{METHODS, methods};
use crate::control::{self, Controller, Setup};
use crate::settings::Scenario;
use evaluation::run::RunError;
use evaluation::run::method::{Method, Training, find};
use evaluation::settings::setting::NoSettings;

/// The settings of a method, if it has any.
macro_rules! settings_of {
    ($scenario:ident $method:ident $config:ident) => {
        &$scenario.$method
    };
    ($scenario:ident $method:ident) => {
        &NoSettings
    };
}

macro_rules! make {
    ($(super::$first:ident $(::$a:ident)?),*; $(super::$then:ident $(::$b:ident)?),*) => {
        fn make(name: &str, scenario: &Scenario, setup: &Setup) -> Option<Box<dyn Controller>> {
            $(if name == control::$first::METHOD.name {
                return Some(control::$first::create(settings_of!(scenario $first $($a)?), setup));
            })*
            $(if name == control::$then::METHOD.name {
                return Some(control::$then::create(settings_of!(scenario $then $($b)?), setup));
            })*
            None
        }
    };
}
methods!(make);

/// Returns a controller by name, not yet trained.
///
/// # Arguments
///
/// * `imported` — whether the network is an imported one.
/// * `seed` — of everything random in it.
///
/// # Errors
///
/// [`RunError::Method`] for a name that no method has.
pub fn create(
    name: &str,
    scenario: &Scenario,
    imported: bool,
    seed: u64,
) -> Result<Box<dyn Controller>, RunError> {
    let setup = setup(scenario, imported, seed);
    let method = find(METHODS, name)?;
    Ok(make(method.name, scenario, &setup).expect("both follow from the list of methods"))
}

/// Returns what a controller is set up with in a scenario, beside the settings of its method.
pub fn setup(scenario: &Scenario, imported: bool, seed: u64) -> Setup {
    let decision_s = scenario.signal.delta_time_s;
    Setup { seed, episodes: scenario.training.episodes, imported, decision_s }
}

/// Returns the episodes that a method is trained or tuned for in a scenario with so many signals, at most:
/// signals learn together, and tuning has [`budget`].
pub fn training_episodes(method: &Method, scenario: &Scenario, signals: u32) -> u32 {
    match method.training {
        Training::None => 0,
        Training::Learned => scenario.training.episodes,
        Training::Tuned { episodes } => {
            let (own, sections) = (method.section(), scenario.sections());
            let ranges = sections.iter().find(|(name, _)| *name == own).map(|(_, s)| s.ranges());
            let setting = ranges.into_iter().flatten().find(|r| r.name == episodes);
            let each = setting.expect("the registry's test has looked it up").value as u32;
            budget(each, signals)
        }
    }
}
