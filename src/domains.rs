//! The domains that this program can evaluate on; a further one is a file and a line here.

use std::sync::OnceLock;

use control_tasks::acrobot::Acrobots;
use control_tasks::cartpole::CartPoles;
use control_tasks::domain::TaskDomain;
use control_tasks::half_cheetah::HalfCheetahs;
use control_tasks::mountain_car::MountainCars;
use control_tasks::pendulum::Pendulums;
use control_tasks::pendulum_swing_up::SwingUps;
use control_tasks::quad::Quads;
use control_tasks::swimmer::Swimmers;

use crate::analysis::Analysis;
use crate::family::FamilyError;
use crate::report::{Look, Plain, Report, Sections};
use crate::run::domain::Domain;
use crate::run::entry::Entry;
use crate::settings::source::{domain_of, file_of, read_scenario};
use crate::store::Layout;
use crate::store::error::StoreError;
use crate::store::results::Results;
use crate::traffic::domain::Traffic;
use crate::traffic::report::TrafficSections;
use crate::traffic::trial::DELAY;

static TRAFFIC: OnceLock<Traffic> = OnceLock::new();

/// All domains but traffic signals, whose problems need more of the command line.
const OTHERS: &[Entry] = &[
    TaskDomain::<CartPoles>::ENTRY,
    TaskDomain::<Pendulums>::ENTRY,
    TaskDomain::<MountainCars>::ENTRY,
    TaskDomain::<Acrobots>::ENTRY,
    TaskDomain::<SwingUps>::ENTRY,
    TaskDomain::<Quads>::ENTRY,
    TaskDomain::<HalfCheetahs>::ENTRY,
    TaskDomain::<Swimmers>::ENTRY,
];

/// Sets traffic signals with further methods; to be called once, before anything asks for them.
///
/// # Panics
///
/// When somebody has asked for them, who would then know other methods.
pub fn set_traffic(traffic: Traffic) {
    assert!(TRAFFIC.set(traffic).is_ok(), "the methods of signals are known already");
}

/// Returns traffic signals.
pub fn traffic() -> &'static dyn Domain {
    TRAFFIC.get_or_init(Traffic::default)
}

/// Returns all domains but traffic signals.
pub fn others() -> &'static [Entry] {
    OTHERS
}

/// Returns all domains.
pub fn domains() -> Vec<&'static dyn Domain> {
    std::iter::once(traffic()).chain(OTHERS.iter().map(|entry| entry.domain)).collect()
}

/// Returns the domain that reads a scenario; `None` for traffic signals, whose files need not say so.
///
/// # Arguments
///
/// * `scenario` — a path or the name of a carried scenario.
///
/// # Errors
///
/// [`FamilyError::Setting`] for a file of a domain that is not known.
pub fn entry_of(scenario: &str) -> Result<Option<&'static Entry>, FamilyError> {
    if let Some(entry) = OTHERS.iter().find(|entry| entry.scenarios.contains(&scenario)) {
        return Ok(Some(entry));
    }
    let file = file_of(scenario);
    // What cannot be read has no domain: whoever reads the scenario says why.
    let named = read_scenario(&file).ok().and_then(|text| domain_of(&text));
    let Some(named) = named.filter(|named| named != Traffic::NAME) else { return Ok(None) };
    let entry = OTHERS.iter().find(|entry| entry.domain.name() == named);
    entry.map(Some).ok_or_else(|| {
        let names: Vec<&str> = domains().iter().map(|domain| domain.name()).collect();
        let expected = format!("expected one of {}", names.join(", "));
        FamilyError::setting(&file.display().to_string(), "domain", format!("{named:?}"), expected)
    })
}

/// Returns the analysis of some results, with what their domain measures.
///
/// # Errors
///
/// Those of [`sections`].
pub fn analysis(layout: &Layout, results: &Results) -> Result<Analysis, StoreError> {
    Ok(Analysis::new(results, sections(layout, results)?.measures()))
}

/// Returns what the domain of some results adds to reports on them; of one that this program does not know nothing
/// but what follows from the names in the records.
///
/// # Errors
///
/// [`StoreError`] when a file of the domain is damaged.
pub fn sections(layout: &Layout, results: &Results) -> Result<Box<dyn Sections>, StoreError> {
    let identity = &results.manifest.identity;
    let name = identity.domain.as_str();
    if name == Traffic::NAME && identity.objective == DELAY {
        return Ok(Box::new(TrafficSections::read(layout, results)?));
    }
    let Some(domain) = domains().into_iter().find(|domain| domain.name() == name) else {
        return Ok(Box::new(Plain::default()));
    };
    let objective = domain.objective();
    let known = objective.metric == identity.objective;
    let looks = domain.methods().iter().map(|m| {
        let look = Look { color: m.color, dash: m.dash };
        (m.name.to_owned(), look)
    });
    let (row, row_is) = domain.training_row();
    Ok(Box::new(Plain {
        row: Some((row.to_owned(), row_is.to_owned())),
        objective: known.then(|| (objective.title.to_owned(), objective.unit.to_owned())),
        looks: looks.collect(),
        most: objective.most.filter(|_| known),
        failure: domain.failure(),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_says_which_domain_reads_it() {
        let dir = tempfile::tempdir().unwrap();
        let of = |text: &str| {
            std::fs::write(dir.path().join("scenario.toml"), text).unwrap();
            let entry = entry_of(&dir.path().display().to_string());
            entry.map(|e| e.map(|e| e.domain.name())).map_err(|e| e.to_string())
        };
        assert_eq!(of("domain = \"cartpole\""), Ok(Some("cartpole")));
        assert_eq!(of("domain = \"traffic\""), Ok(None));
        assert_eq!(of("name = \"a\""), Ok(None));
        assert_eq!(of("= broken"), Ok(None));
        let e = of("domain = \"moon\"").unwrap_err();
        let expected = "scenario.toml: domain = \"moon\": expected one of traffic, cartpole, pendulum, \
                        mountain-car, acrobot, pendulum-swing-up, quad, half-cheetah, swimmer";
        assert!(e.ends_with(expected), "{e}");
        assert_eq!(entry_of("cartpole").unwrap().map(|e| e.domain.name()), Some("cartpole"));
        assert!(entry_of("smoke").unwrap().is_none() && entry_of("nowhere").unwrap().is_none());
    }
}
