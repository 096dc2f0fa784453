//! The domains that this program can evaluate on; a further one is a folder and a line here.

use std::sync::LazyLock;

use crate::cartpole::domain::CartPoles;
use crate::report::{Look, Plain, Report, Sections};
use crate::run::domain::Domain;
use crate::store::Layout;
use crate::store::error::StoreError;
use crate::store::results::Results;
use crate::traffic::domain::Traffic;
use crate::traffic::report::TrafficSections;

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

/// Returns what the domain of some results adds to reports on them; of one that this program does not know nothing
/// but what follows from the names in the records.
///
/// # Errors
///
/// [`StoreError`] when a file of the domain is damaged.
pub fn sections(layout: &Layout, results: &Results) -> Result<Box<dyn Sections>, StoreError> {
    let name = results.manifest.identity.domain.as_str();
    if name == Traffic::NAME {
        return Ok(Box::new(TrafficSections::read(layout, results)?));
    }
    let Some(domain) = domains().into_iter().find(|domain| domain.name() == name) else {
        return Ok(Box::new(Plain::default()));
    };
    let objective = domain.objective();
    let known = objective.metric == results.manifest.identity.objective;
    let looks = domain.methods().iter().map(|m| {
        let look = Look { color: m.color, dash: m.dash };
        (m.name.to_owned(), look)
    });
    Ok(Box::new(Plain {
        objective: known.then(|| (objective.title.to_owned(), objective.unit.to_owned())),
        looks: looks.collect(),
    }))
}

/// Returns the report on results, with scores relative to their baseline, if they have one.
///
/// # Errors
///
/// Those of [`sections`].
pub fn report(layout: &Layout, results: &Results) -> Result<Report, StoreError> {
    Ok(Report::new(results, sections(layout, results)?))
}
