//! A scenario of carts and poles: settings and a family.

use std::collections::BTreeSet;

use serde_json::Value;

use super::dynamics::Variant;
use super::family::{self, ContextError};
use super::settings::Scenario;
use basics::hash::sha256;
use evaluation::family::MdpFamily;
use evaluation::run::domain::{Prepared, PreparedPoint, Problem};
use evaluation::run::fault::Cause;

/// What stands in manifests for a simulator.
const SIMULATOR: &str = "CartPole with the equations of gymnasium 1.4.0";

/// A scenario of carts and poles.
#[derive(Debug, Clone)]
pub struct CartPoleProblem {
    scenario: Scenario,
    family: MdpFamily,
}

impl CartPoleProblem {
    /// Returns the problem of a scenario.
    ///
    /// # Arguments
    ///
    /// * `family` — whose features are names of [`family::FEATURES`], gymnasium's values where one is missing;
    ///   `None` takes CARL's.
    ///
    /// # Errors
    ///
    /// [`ContextError`] when a point MDP is no cart and pole.
    pub fn new(scenario: Scenario, family: Option<MdpFamily>) -> Result<Self, ContextError> {
        let mut family = family.unwrap_or_else(|| family::family(&scenario.name));
        let variant = scenario.environment.dynamics;
        for point in &family.points {
            let value = family::context(&family.features, point)?.masspole_kg;
            if let Some(limit) = variant.heaviest_pole_kg().filter(|limit| value >= *limit) {
                return Err(ContextError::Inertia { point: point.id.clone(), value, limit });
            }
        }
        if variant == Variant::CarlCompat {
            family.describing = family::without_effect_left_out(&family);
        }
        Ok(Self { scenario, family })
    }
}

impl Problem for CartPoleProblem {
    fn family(&self) -> &MdpFamily {
        &self.family
    }

    fn settings(&self) -> Value {
        serde_json::to_value(&self.scenario).expect("a scenario is plain data")
    }

    fn prepare(
        &self,
        chosen: &BTreeSet<&str>,
        done: &(dyn Fn(&str) + Sync),
    ) -> Result<Prepared, Cause> {
        let mut prepared = Prepared { simulator: SIMULATOR.to_owned(), ..Prepared::default() };
        for point in self.family.points.iter().filter(|p| chosen.contains(p.id.as_str())) {
            let environment = family::context(&self.family.features, point)?.to_string();
            let content = sha256(format!("cartpole {environment}").as_bytes());
            let made = PreparedPoint { environment, content, ..PreparedPoint::default() };
            prepared.points.insert(point.id.clone(), made);
            done(&point.id);
        }
        Ok(prepared)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use evaluation::family::{Feature, PointMdp};

    fn problem(preset: &str) -> CartPoleProblem {
        let scenario = Scenario::read(&format!("preset = {preset:?}"), "a.toml", &[]).unwrap();
        CartPoleProblem::new(scenario, None).unwrap()
    }

    #[test]
    fn a_pole_without_inertia_is_refused_where_it_has_none() {
        let feature = Feature { name: "masspole_kg".into(), unit: "kg".into() };
        let heavy = PointMdp {
            id: "heavy".into(),
            title: "heavy".into(),
            features: vec![1.5],
            importance: 1.0,
            instances: 1,
        };
        let family = MdpFamily::new("own", vec![feature], vec![heavy], "p.csv").unwrap();
        let of = |dynamics: &str| {
            let text = format!("environment.dynamics = {dynamics:?}");
            let scenario = Scenario::read(&text, "a.toml", &[]).unwrap();
            CartPoleProblem::new(scenario, Some(family.clone())).err().map(|e| e.to_string())
        };
        assert_eq!(of("physical"), None);
        let e = of("carl-compat").unwrap();
        assert!(e.starts_with("masspole_kg of heavy is 1.5: from 1.467 kg on"), "{e}");
    }

    #[test]
    fn samples_look_at_the_mass_of_the_cart_where_it_acts() {
        let carl = problem("sb3");
        assert_eq!(carl.family().describing[0], [0.05, 0.01, 1.0, 0.1]);
        let physical = "environment.dynamics = \"physical\"";
        let scenario = Scenario::read(physical, "a.toml", &[]).unwrap();
        assert!(CartPoleProblem::new(scenario, None).unwrap().family().describing.is_empty());
    }

    #[test]
    fn what_is_prepared_is_the_context_whatever_the_point_is_called() {
        let chosen = BTreeSet::from(["l0.5-c1-p0.1-f50-g9.8"]);
        let prepared = problem("sb3").prepare(&chosen, &|_| {}).unwrap();
        let text = "length_m=0.5 masscart_kg=1 masspole_kg=0.1 force_n=50 gravity_mps2=9.8";
        let (id, made) = prepared.points.first_key_value().unwrap();
        assert_eq!((id.as_str(), made.environment.as_str()), ("l0.5-c1-p0.1-f50-g9.8", text));
        assert_eq!(prepared.points.len(), 1);
        let feature = Feature { name: "force_n".into(), unit: "N".into() };
        let own = PointMdp {
            id: "strong".into(),
            title: "strong".into(),
            features: vec![50.0],
            importance: 1.0,
            instances: 1,
        };
        let family = MdpFamily::new("own", vec![feature], vec![own], "p.csv").unwrap();
        let problem = CartPoleProblem::new(Scenario::default(), Some(family)).unwrap();
        let same = problem.prepare(&BTreeSet::from(["strong"]), &|_| {}).unwrap();
        assert_eq!(same.points["strong"], *made);
    }
}
