//! Models of learners that control signals: what it takes to set one up again.

use serde_json::Value;

use super::control::Controller;
use super::control::registry::METHODS;
use super::controllers::create;
use super::error::TrafficError;
use super::settings::check::check;
use super::settings::{Preset, Scenario, SignalSettings};
use evaluation::run::RunError;
use evaluation::run::fault::TrialError;
use evaluation::run::method::find;
use evaluation::run::model::SavedModel;
use evaluation::settings::overrides::Override;

/// A model with what its card says of signals.
#[derive(Debug, Clone, PartialEq)]
pub struct SignalModel {
    /// The model.
    pub saved: SavedModel,
    /// The method's section of the scenario that it was trained in, defaults included.
    pub settings: Value,
    /// The preset of that scenario.
    pub preset: Preset,
    /// How its signals were timed and what the method saw.
    pub signal: SignalSettings,
}

impl SignalModel {
    /// Returns a model after looking at its card.
    ///
    /// # Errors
    ///
    /// [`RunError::Model`] when it is of another domain or damaged.
    pub fn new(saved: SavedModel) -> Result<Self, RunError> {
        let method = saved.card.method.as_str();
        if !METHODS.iter().any(|m| m.name == method) {
            let reason = format!("it is a model of {method}, which is no method for signals");
            return Err(saved.fail(reason));
        }
        let damaged = |what: &str| saved.fail(format!("its card is damaged: no valid {what}"));
        let get = |name: &str| saved.domain.get(name).cloned();
        let settings = get("settings").ok_or_else(|| damaged("settings"))?;
        let preset = match get("preset") {
            None => Preset::default(),
            Some(preset) => serde_json::from_value(preset).map_err(|_| damaged("preset"))?,
        };
        let signal = get("signal").and_then(|signal| serde_json::from_value(signal).ok());
        let signal = signal.ok_or_else(|| damaged("signal"))?;
        Ok(Self { settings, preset, signal, saved })
    }

    /// Returns a scenario with the method's and the signals' settings of the model, and settings to
    /// replace in that.
    ///
    /// # Errors
    ///
    /// [`RunError::Model`] when the method is unknown or cannot use the model, or when a setting does
    /// not exist or is out of range.
    pub fn scenario(
        &self,
        scenario: &Scenario,
        overrides: &[Override],
    ) -> Result<Scenario, TrafficError> {
        let method = find(METHODS, &self.saved.card.method);
        let method = method.map_err(|e| self.saved.fail(format!("of an {e}")))?;
        let mut scenario = scenario.clone();
        scenario.signal = self.signal.clone();
        let mut settings = serde_json::to_value(&scenario).expect("a scenario is plain data");
        // A method without settings has no section.
        if let Some(own) = settings.get_mut(method.section()) {
            *own = self.settings.clone();
        }
        let mut scenario: Scenario = serde_json::from_value(settings)
            .map_err(|e| self.saved.fail(format!("its settings are of another version: {e}")))?;
        for setting in overrides {
            scenario = setting.apply(&scenario)?;
        }
        check(&scenario, "its settings").map_err(|e| self.saved.fail(e.to_string()))?;
        // What makes it unusable on any signal is said before anything is built or simulated.
        self.controller(&scenario, false)?;
        Ok(scenario)
    }

    /// Returns the controller that the model makes, in a scenario with its settings.
    ///
    /// # Errors
    ///
    /// [`RunError::Model`] when the method cannot use it.
    pub fn controller(
        &self,
        scenario: &Scenario,
        imported: bool,
    ) -> Result<Box<dyn Controller>, RunError> {
        let card = &self.saved.card;
        let mut controller = create(&card.method, scenario, imported, card.seed)?;
        controller.load(self.saved.archive.clone()).map_err(|e| self.saved.fail(e.to_string()))?;
        Ok(controller)
    }

    /// Returns the error of an evaluation, with the file's name and a way out if the model is the
    /// cause.
    pub fn explain(&self, error: TrialError, point: &str) -> RunError {
        match error {
            TrialError::Model(e) => self.saved.fail(format!(
                "the model does not fit the signals of {point}: {e}; it was trained on {}, choose an \
                 intersection with as many lanes and phases",
                self.saved.card.point
            )),
            other => other.into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use evaluation::run::model::{MODEL, ModelCard};
    use learners::nn::archive::{Archive, ArchiveError};
    use serde_json::Map;

    #[test]
    fn a_model_of_other_signals_says_where_it_was_trained() {
        let card = ModelCard {
            kind: MODEL.into(),
            format_version: 1,
            method: "idqn".into(),
            point: "quiet".into(),
            replicate: 0,
            seed: 1,
            training_episodes: 1,
            policy_row: None,
            tsc_family: String::new(),
            git: String::new(),
            simulator: String::new(),
            evaluation: Map::new(),
        };
        let archive = Archive::default();
        let saved = SavedModel { path: "m".into(), card, domain: Map::new(), archive };
        let model = SignalModel {
            saved,
            settings: Value::Null,
            preset: Preset::default(),
            signal: SignalSettings::default(),
        };
        let shape =
            ArchiveError::Shape { name: "w".into(), found: vec![8, 64], wanted: vec![6, 64] };
        let e = model.explain(TrialError::Model(shape), "busy").to_string();
        assert_eq!(
            e,
            "m: the model does not fit the signals of busy: tensor \"w\" has shape [8, 64], but \
             [6, 64] is needed; it was trained on quiet, choose an intersection with as many lanes \
             and phases"
        );
    }
}
