//! Carts and poles as a domain of evaluation.

use serde_json::{Map, Value};

use super::dynamics::{Context, Dynamics};
use super::environment::{CartPole, HORIZON};
use super::family::NAME;
use super::settings::Scenario;
use super::trial::{NORMALISED_RETURN, PoleTrial, ROW_STEPS};
use super::{dqn, ppo};
use evaluation::run::domain::{Domain, Effort, EffortOf, Objective, Site, Trial};
use evaluation::run::fault::TrialError;
use evaluation::run::method::Method;
use evaluation::stats::{Direction, Limit, Side};

/// The methods.
const METHODS: [Method; 2] = [ppo::METHOD, dqn::METHOD];

/// Normalised return below which a point MDP is not solved: the pole falls within 25 of 500 steps.
const UNSOLVED: f64 = 0.05;

/// Processor time of a step of evaluation, seconds; measured, see `benches/README.md`.
const STEP_S: f64 = 5e-7;

/// Carts and poles, judged by the share of the best return.
#[derive(Debug, Clone, Copy, Default)]
pub struct CartPoles;

impl Domain for CartPoles {
    fn name(&self) -> &'static str {
        NAME
    }

    fn objective(&self) -> Objective {
        Objective {
            metric: NORMALISED_RETURN,
            title: "normalised return",
            unit: "",
            direction: Direction::Higher,
        }
    }

    fn baseline(&self) -> Option<&'static str> {
        None
    }

    fn training_row(&self) -> (&'static str, &'static str) {
        let what = "A part of a training is 2,000 steps, or one update where that takes more; its normalised return is \
                    the mean over the episodes that ended in it.";
        ("part", what)
    }

    fn failure(&self) -> Option<Limit> {
        let metric = NORMALISED_RETURN.to_owned();
        Some(Limit { metric, side: Side::Below, value: UNSOLVED })
    }

    fn methods(&self) -> &[Method] {
        &METHODS
    }

    fn trial(
        &self,
        site: &Site<'_>,
        method: &str,
        seed: u64,
    ) -> Result<Box<dyn Trial>, TrialError> {
        let input = |message: String| TrialError::Input(message.into());
        let scenario = scenario_of(site.settings).map_err(input)?;
        let context: Context = site.point.environment.parse().map_err(|e: String| {
            input(format!("manifest.json: environment of {}: {e}", site.point.point))
        })?;
        let dynamics = Dynamics::new(context, scenario.environment.dynamics);
        let environment = CartPole::new(dynamics, scenario.environment.start);
        let trial = PoleTrial::new(environment, &scenario, method, seed);
        let trial = trial.ok_or_else(|| input(format!("there is no method {method:?}")))?;
        Ok(Box::new(trial))
    }

    fn efforts(&self, settings: &Value) -> Result<Box<EffortOf>, String> {
        let Scenario { ppo, dqn, .. } = scenario_of(settings)?;
        Ok(Box::new(move |method, _, _| {
            let (steps, work) = match method.name == dqn::METHOD.name {
                true => (dqn.total_steps, dqn.work() / dqn::Config::default().work()),
                false => (ppo.total_steps, ppo.work() / ppo::Config::default().work()),
            };
            Effort {
                training: u32::try_from(steps.div_ceil(ROW_STEPS)).unwrap_or(u32::MAX),
                training_s: ROW_STEPS as f64 * method.decision_s * work,
                evaluation_s: f64::from(HORIZON) * STEP_S,
                is_informed: true,
            }
        }))
    }

    fn card(&self, settings: &Value, method: &str) -> Result<Map<String, Value>, String> {
        let mut card = Map::new();
        for (name, key) in
            [("settings", method), ("preset", "preset"), ("environment", "environment")]
        {
            let value = settings.get(key).cloned();
            let value = value.ok_or_else(|| format!("the scenario has no settings of {key}"))?;
            card.insert(name.to_owned(), value);
        }
        Ok(card)
    }
}

/// Returns the scenario of a manifest's settings.
fn scenario_of(settings: &Value) -> Result<Scenario, String> {
    serde_json::from_value(settings.clone()).map_err(|e| format!("manifest.json: settings: {e}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn effort(preset: &str, method: &Method) -> Effort {
        let scenario = Scenario::read(&format!("preset = {preset:?}"), "a.toml", &[]).unwrap();
        let settings = serde_json::to_value(scenario).unwrap();
        CartPoles.efforts(&settings).unwrap()(method, 1, &|_| None)
    }

    #[test]
    fn the_effort_of_a_training_is_about_what_was_measured() {
        // Processor time of whole trainings, benches/cartpole.rs.
        let cases = [("sb3", 0, 0.52), ("sb3", 1, 0.33), ("tuned", 0, 0.9), ("tuned", 1, 6.0)];
        for (preset, method, measured) in cases {
            let method = [ppo::METHOD, dqn::METHOD][method];
            let effort = effort(preset, &method);
            let expected = f64::from(effort.training) * effort.training_s;
            let ratio = expected / measured;
            assert!((0.5..2.0).contains(&ratio), "{preset} {}: {expected} s", method.name);
        }
    }
}
