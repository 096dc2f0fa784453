//! Carts and poles as a domain of evaluation.

use serde_json::{Map, Value};

use super::dynamics::{Context, Dynamics};
use super::environment::CartPole;
use super::family::NAME;
use super::settings::Scenario;
use super::trial::{NORMALISED_RETURN, PoleTrial};
use super::{dqn, ppo};
use crate::run::domain::{Domain, Objective, Site, Trial};
use crate::run::fault::TrialError;
use crate::run::method::Method;
use crate::stats::{Direction, Limit, Side};

/// The methods.
const METHODS: [Method; 2] = [ppo::METHOD, dqn::METHOD];

/// Normalised return below which a point MDP is not solved: the pole falls within 25 of 500 steps.
const UNSOLVED: f64 = 0.05;

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
        let scenario: Scenario = serde_json::from_value(site.settings.clone())
            .map_err(|e| input(format!("manifest.json: settings: {e}")))?;
        let context: Context = site.point.environment.parse().map_err(|e: String| {
            input(format!("manifest.json: environment of {}: {e}", site.point.point))
        })?;
        let dynamics = Dynamics::new(context, scenario.environment.dynamics);
        let environment = CartPole::new(dynamics, scenario.environment.start);
        let trial = PoleTrial::new(environment, &scenario, method, seed);
        let trial = trial.ok_or_else(|| input(format!("there is no method {method:?}")))?;
        Ok(Box::new(trial))
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
