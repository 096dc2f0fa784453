//! Models of learners that control signals: what it takes to set one up again, and to play it elsewhere.

use std::collections::BTreeMap;

use serde_json::Value;

use super::control::registry::METHODS;
use super::control::{ControlError, Controller, Drive, GreenPhase, Observation, SignalSpec};
use super::controllers::create;
use super::error::TrafficError;
use super::settings::check::check;
use super::settings::{Preset, Scenario, SignalSettings};
use evaluation::run::RunError;
use evaluation::run::method::{Method, Training, find};
use evaluation::run::model::SavedModel;
use evaluation::store::own::said;

/// Entry of a card with the method that one of somebody's own is but for what it sees or is paid for.
pub(crate) const BUILT_ON: &str = "built_on";

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
    /// # Arguments
    ///
    /// * `methods` — those that it may be of.
    ///
    /// # Errors
    ///
    /// [`RunError::Model`] when it is of another domain or method, or damaged.
    pub fn new(saved: SavedModel, methods: &[Method]) -> Result<Self, RunError> {
        let name = saved.card.method.as_str();
        match find(methods, name) {
            Err(_) => {
                return Err(saved.fail(format!(
                    "it is a model of {name}, which is no method for signals here; if {name} is a class of your own, give it \
                     too, with --controller {name}=FILE.py:CLASS"
                )));
            }
            Ok(method) if method.training != Training::Learned => {
                return Err(saved.fail(format!("it is a model of {name}, which does not learn")));
            }
            Ok(_) => {}
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

    /// Refuses a model that its method cannot use, or whose settings do not exist or are out of range.
    ///
    /// # Errors
    ///
    /// [`RunError::Model`] with the reason.
    pub fn check(&self, scenario: &Scenario) -> Result<(), TrafficError> {
        let mut scenario = self.with_settings(scenario)?;
        scenario.signal = self.signal.clone();
        check(&scenario, "its settings").map_err(|e| self.saved.fail(e.to_string()))?;
        // What makes it unusable on any signal is said before anything is built or simulated.
        if METHODS.iter().any(|m| m.name == self.saved.card.method) {
            self.loaded(create(&self.saved.card.method, &scenario, false, self.saved.card.seed)?)?;
        }
        Ok(())
    }

    /// Returns a scenario with the method's settings of the model.
    fn with_settings(&self, scenario: &Scenario) -> Result<Scenario, RunError> {
        let mut settings = serde_json::to_value(scenario).expect("a scenario is plain data");
        // A method without settings has no section.
        let learner = self.saved.domain.get(BUILT_ON).and_then(Value::as_str);
        let section = learner.unwrap_or(&self.saved.card.method).replace('-', "_");
        if let Some(own) = settings.get_mut(section) {
            *own = self.settings.clone();
        }
        serde_json::from_value(settings)
            .map_err(|e| self.saved.fail(format!("its settings are of another version: {e}")))
    }

    /// Returns how the timing of signals or what methods see differs in a scenario from where the model was trained, in
    /// words; `None` where nothing does.
    pub fn difference(&self, scenario: &Scenario) -> Option<String> {
        difference(&self.signal, &scenario.signal)
    }

    /// Returns a controller with what was learned.
    fn loaded(&self, mut learner: Box<dyn Controller>) -> Result<Box<dyn Controller>, RunError> {
        learner.load(self.saved.archive.clone()).map_err(|e| self.saved.fail(e.to_string()))?;
        Ok(learner)
    }

    /// Returns the controller that plays the model: it neither trains nor explores.
    ///
    /// # Arguments
    ///
    /// * `name` — what the model is called as a method.
    /// * `create` — makes the learner from the scenario with the model's settings and its seed.
    ///
    /// # Errors
    ///
    /// [`RunError::Model`] when the method cannot use it.
    pub fn controller(
        &self,
        name: &'static str,
        scenario: &Scenario,
        create: impl FnOnce(&Scenario, u64) -> Result<Box<dyn Controller>, RunError>,
    ) -> Result<Box<dyn Controller>, RunError> {
        let card = &self.saved.card;
        let learner = self.loaded(create(&self.with_settings(scenario)?, card.seed)?)?;
        Ok(Box::new(Learned { name, learner, trained_on: card.point.clone() }))
    }
}

/// Returns how the timing of signals or what methods see differs, in words; `None` where nothing does.
fn difference(there: &SignalSettings, here: &SignalSettings) -> Option<String> {
    let plain = |signal| serde_json::to_value(signal).expect("settings are plain data");
    said("signal", &plain(there), &plain(here))
}

/// What a learner has learned, as a method that does not learn.
struct Learned {
    name: &'static str,
    learner: Box<dyn Controller>,
    trained_on: String,
}

impl Controller for Learned {
    fn name(&self) -> &'static str {
        self.name
    }

    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        self.learner.begin(signals).map_err(|e| match e {
            ControlError::Model(reason) => {
                ControlError::Unfit { reason, trained_on: self.trained_on.clone() }
            }
            other => other,
        })
    }

    fn act(
        &mut self,
        observations: &[Observation],
        phases: &mut [GreenPhase],
    ) -> Result<(), ControlError> {
        self.learner.act(observations, phases)
    }

    fn observe(&mut self, observations: &[Observation], truncated: bool) {
        self.learner.observe(observations, truncated);
    }

    fn details(&self) -> BTreeMap<String, String> {
        self.learner.details()
    }

    fn set_validation(&mut self, is_validation: bool) {
        self.learner.set_validation(is_validation);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use learners::nn::archive::{Archive, ArchiveError};

    /// A learner whose network has eight inputs, where six are needed.
    struct Narrow;

    impl Controller for Narrow {
        fn name(&self) -> &'static str {
            "narrow"
        }
        fn begin(&mut self, _: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
            let (found, wanted) = (vec![8, 64], vec![6, 64]);
            Err(ArchiveError::Shape { name: "w".into(), found, wanted }.into())
        }
        fn model(&self) -> Option<Archive> {
            Some(Archive::default())
        }
    }

    #[test]
    fn settings_at_their_defaults_differ_from_others_in_both_directions() {
        let plain = SignalSettings::default();
        let limited = SignalSettings { max_green_s: Some(40), turn_on_red: true, ..plain.clone() };
        let words = [difference(&plain, &limited), difference(&limited, &plain)];
        assert_eq!(
            words.map(Option::unwrap),
            [
                "signal.max_green_s is not set there and 40 now; signal.turn_on_red is not set there and true now",
                "signal.max_green_s is 40 there and not set now; signal.turn_on_red is true there and not set now",
            ]
        );
        assert_eq!(difference(&limited, &limited.clone()), None);
    }

    #[test]
    fn a_model_of_other_signals_says_what_does_not_fit_and_where_it_was_trained() {
        let learner = Box::new(Narrow);
        let mut learned = Learned { name: "idqn-of-quiet", learner, trained_on: "quiet".into() };
        assert!(learned.model().is_none(), "it is no new model");
        assert_eq!(
            learned.begin(&[]).unwrap_err().to_string(),
            "the model does not fit these signals: tensor \"w\" has shape [8, 64], but [6, 64] is needed; \
             it was trained on quiet, choose an intersection with as many lanes and phases"
        );
    }
}
