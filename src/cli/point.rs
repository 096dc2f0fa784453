//! A point MDP that is named on the command line.

use std::collections::BTreeSet;

use crate::suggest::did_you_mean;
use crate::traffic::error::TrafficError;
use crate::traffic::family::load::LoadedScenario;

/// Point MDPs that an error names.
const NAMED_POINTS: usize = 3;

/// Returns the error for a point MDP that a scenario does not have.
pub fn unknown_point(point: &str, loaded: &LoadedScenario, scenario: &str) -> TrafficError {
    let points = &loaded.family.points;
    let named: Vec<&str> = points.iter().take(NAMED_POINTS).map(|p| p.id.as_str()).collect();
    let mut some = named.join(", ");
    if points.len() > named.len() {
        let more = points.len() - named.len();
        some.push_str(&format!(" and {more} more, which `tsc-family list {scenario}` shows"));
    }
    let names = points.iter().flat_map(|p| [p.id.as_str(), p.title.as_str()]);
    some.push_str(&did_you_mean(point, names.collect::<BTreeSet<_>>()));
    TrafficError::NoPoint { scenario: loaded.family.name.clone(), point: point.to_owned(), some }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::traffic::family::load::load_with;

    #[test]
    fn an_unknown_point_names_some_that_exist() {
        let e =
            |scenario| unknown_point("x", &load_with(scenario, &[]).unwrap(), scenario).to_string();
        assert_eq!(e("smoke"), "scenario smoke has no point MDP \"x\"; it has quiet, busy");
        assert!(
            e("salt-lake-city").ends_with("161 more, which `tsc-family list salt-lake-city` shows")
        );
    }
}
