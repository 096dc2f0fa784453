//! The domains that this program can evaluate on; a further one is a folder and a line here.

use std::sync::LazyLock;

use crate::cartpole::domain::CartPoles;
use crate::run::domain::Domain;
use crate::traffic::domain::Traffic;

static TRAFFIC: LazyLock<Traffic> = LazyLock::new(Traffic::default);

/// Returns traffic signals.
pub fn traffic() -> &'static dyn Domain {
    &*TRAFFIC
}

/// Returns carts and poles.
pub fn cartpole() -> &'static dyn Domain {
    &CartPoles
}

/// Returns all domains.
pub fn domains() -> [&'static dyn Domain; 2] {
    [traffic(), cartpole()]
}
