//! A control task as a domain of evaluation.

use std::marker::PhantomData;

use serde_json::{Map, Value};

use crate::context;
use crate::episodes::{Dynamics, Episodes};
use crate::task::scenario::Settings;
use crate::task::{Task, scenario_of};
use crate::trial::{TaskTrial, row_steps};
use evaluation::run::domain::{Domain, Effort, EffortOf, Objective, Site, Trial};
use evaluation::run::fault::TrialError;
use evaluation::run::method::Method;
use evaluation::stats::Limit;
use learners::rl::environment::Environment;

/// A control task, judged by its objective.
#[derive(Debug, Clone, Copy, Default)]
pub struct TaskDomain<T>(pub(crate) PhantomData<T>);

impl<T: Task> Domain for TaskDomain<T> {
    fn name(&self) -> &'static str {
        T::NAME
    }

    fn objective(&self) -> Objective {
        T::OBJECTIVE
    }

    fn baseline(&self) -> Option<&'static str> {
        None
    }

    fn training_row(&self) -> (&'static str, &'static str) {
        let about = "A part of a training is 2,000 steps, or one update where that takes more; its figures are \
                     means over the episodes that ended in it.";
        ("part", about)
    }

    fn failure(&self) -> Option<Limit> {
        let (side, value) = T::FAILURE;
        Some(Limit { metric: T::OBJECTIVE.metric.to_owned(), side, value })
    }

    fn methods(&self) -> &[Method] {
        T::Scenario::METHODS
    }

    fn trial(
        &self,
        site: &Site<'_>,
        method: &str,
        seed: u64,
    ) -> Result<Box<dyn Trial>, TrialError> {
        T::simulator().map_err(TrialError::Simulator)?;
        let input = |message: String| TrialError::Input(message.into());
        let scenario = scenario_of::<T>(site.settings).map_err(input)?;
        let context = context::parse::<T>(&site.point.environment).map_err(|e| {
            input(format!("manifest.json: environment of {}: {e}", site.point.point))
        })?;
        let environment = Episodes::of(T::dynamics(&scenario, &context));
        let trial = TaskTrial::<T>::new(environment, &scenario, method, seed);
        let trial = trial.ok_or_else(|| input(format!("there is no method {method:?}")))?;
        Ok(Box::new(trial))
    }

    fn efforts(&self, settings: &Value) -> Result<Box<EffortOf>, String> {
        let scenario = scenario_of::<T>(settings)?;
        let default: Vec<f64> = T::FEATURES.iter().map(|f| f.default).collect();
        let environment = Episodes::of(T::dynamics(&scenario, &default));
        let numbers = environment.width() + environment.actions().outputs();
        Ok(Box::new(move |method, _, _| {
            let steps = scenario.total_steps(method.name).unwrap_or_default();
            let work = scenario.work(method.name, numbers).unwrap_or_default();
            let row_steps = row_steps(steps);
            Effort {
                training: u32::try_from(steps.div_ceil(row_steps)).unwrap_or(u32::MAX),
                training_s: row_steps as f64 * method.decision_s * work,
                evaluation_s: f64::from(T::Dynamics::HORIZON) * T::STEP_S,
                is_informed: true,
            }
        }))
    }

    fn card(&self, settings: &Value, method: &str) -> Result<Map<String, Value>, String> {
        let mut card = Map::new();
        let all = serde_json::to_value(scenario_of::<T>(settings)?).map_err(|e| e.to_string())?;
        for (name, key) in
            [("settings", method), ("preset", "preset"), ("environment", "environment")]
        {
            let value = all.get(key).cloned();
            let value = value.ok_or_else(|| format!("the scenario has no settings of {key}"))?;
            card.insert(name.to_owned(), value);
        }
        Ok(card)
    }
}
