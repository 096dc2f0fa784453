//! A scenario of a control task: settings and a family.

use std::collections::BTreeSet;

use serde_json::Value;

use crate::context::{self, ContextError};
use crate::task::scenario::Settings;
use crate::task::{self, Task};
use basics::hash::sha256;
use evaluation::family::MdpFamily;
use evaluation::run::domain::{Prepared, PreparedPoint, Problem};
use evaluation::run::fault::Cause;

/// A scenario of a control task.
#[derive(Debug, Clone)]
pub struct TaskProblem<T: Task> {
    scenario: T::Scenario,
    family: MdpFamily,
}

impl<T: Task> TaskProblem<T> {
    /// Returns the problem of a scenario.
    ///
    /// # Arguments
    ///
    /// * `family` — whose features are those of the task, or some; `None` takes the task's own.
    ///
    /// # Errors
    ///
    /// [`ContextError`] when a point MDP is none of the task.
    pub fn new(scenario: T::Scenario, family: Option<MdpFamily>) -> Result<Self, ContextError> {
        let mut family = family.unwrap_or_else(|| task::family::<T>(scenario.head().1));
        for point in &family.points {
            context::context::<T>(&scenario, &family.features, point)?;
        }
        let without = T::without_effect(&scenario);
        if !without.is_empty() {
            family.describing = left_out(&family, without);
        }
        Ok(Self { scenario, family })
    }
}

/// Returns the features of every point MDP without some; nothing where there is no other feature.
fn left_out(family: &MdpFamily, without: &[&str]) -> Vec<Vec<f64>> {
    let acts = |f: &usize| !without.contains(&family.features[*f].name.as_str());
    let acting: Vec<usize> = (0..family.features.len()).filter(acts).collect();
    let row =
        |point: &evaluation::family::PointMdp| acting.iter().map(|f| point.features[*f]).collect();
    if acting.is_empty() { Vec::new() } else { family.points.iter().map(row).collect() }
}

impl<T: Task> Problem for TaskProblem<T> {
    fn family(&self) -> &MdpFamily {
        &self.family
    }

    fn settings(&self) -> Value {
        let of = |scenario: &T::Scenario| {
            serde_json::to_value(scenario).expect("a scenario is plain data")
        };
        let (mut settings, default) = (of(&self.scenario), of(&T::Scenario::default()));
        let all = settings.as_object_mut().expect("a scenario is a table");
        all.retain(|name, value| !T::LATER.contains(&name.as_str()) || default[name] != *value);
        settings
    }

    fn prepare(
        &self,
        chosen: &BTreeSet<&str>,
        done: &(dyn Fn(&str) + Sync),
    ) -> Result<Prepared, Cause> {
        let mut prepared = Prepared { simulator: T::simulator()?, ..Prepared::default() };
        for point in self.family.points.iter().filter(|p| chosen.contains(p.id.as_str())) {
            let context = context::context::<T>(&self.scenario, &self.family.features, point)?;
            let environment = context::text::<T>(&context);
            let content = sha256(format!("{} {environment}", T::NAME).as_bytes());
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
    use crate::cartpole::{CartPoles, Scenario};
    use evaluation::family::{Feature, PointMdp};

    type CartPoleProblem = TaskProblem<CartPoles>;

    fn problem(preset: &str) -> CartPoleProblem {
        let scenario = Scenario::read(&format!("preset = {preset:?}"), "a.toml", &[]).unwrap();
        CartPoleProblem::new(scenario, None).unwrap()
    }

    #[test]
    fn a_manifest_has_later_methods_only_where_somebody_set_them() {
        let with = |setting: &str| {
            let scenario = Scenario::read("", "a.toml", &[setting.parse().unwrap()]).unwrap();
            CartPoleProblem::new(scenario, None).unwrap().settings()
        };
        let settings = with("trpo.gamma=0.9");
        assert!((settings["trpo"]["gamma"].as_f64().unwrap() - 0.9).abs() < 1e-6);
        assert!(settings.get("ars").is_none() && settings.get("dqn").is_some());
        let read: Scenario = serde_json::from_value(with("trpo.gamma=0.99")).unwrap();
        assert_eq!(read.trpo, Scenario::default().trpo);
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
