//! Which policy of a training is evaluated, and what happens to a training whose network is dead.
//!
//! The last policy of a training is a draw where the policy swings from one episode to the next. So a third stream of
//! seeds judges policies while they are learned:
//!
//! 1. From [`Selection::validation_start`] on, every [`Selection::validation_interval`] rows of training, the policy plays
//!    [`Selection::validation_seeds`] episodes without exploring and without learning. The best few policies are kept.
//! 2. When training is over, each of them that was better than the last policy by more than [`Selection::margin`] is a
//!    finalist. The finalists and the last policy play [`Selection::finalist_seeds`] further episodes, the same for all.
//! 3. The best finalist is evaluated in place of the last policy if it is still better by more than the margin. The
//!    last policy is evaluated too, and both are recorded.
//!
//! Validation seeds are neither training nor evaluation seeds, and validation changes nothing that training depends on: the
//! last policy is the same with and without it.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::stats::Direction;

/// Name of the section of a scenario, and of manifests, that holds these settings.
const SECTION: &str = "training";

/// How often a training with a dead network is started again, at most.
pub const MAX_RESTARTS: u32 = 3;

/// Which policy of a training is evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Select {
    /// The one that validation finds best, the last one where none is better by more than the margin.
    Validation,
    /// The last one, whatever it is like.
    #[default]
    Last,
}

/// Whether a training whose network is dead is started again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Restart {
    /// From another seed, [`MAX_RESTARTS`] times at most.
    Dead,
    /// Never: it goes on to its end.
    #[default]
    Never,
}

/// Declares the settings of a domain's trainings: its own, then those of [`Selection`].
#[doc(hidden)]
#[macro_export]
macro_rules! __training_settings {
    ({ $($head:tt)* } $($own:tt)*) => {
        $crate::settings::setting::settings! {
            $($head)* {
                $($own)*
                /// Which policy of a training is evaluated: `validation`, the one that further episodes show to be
                /// the best, or `last`.
                select: $crate::run::selection::Select =
                    $crate::run::selection::Select::Validation, source "our choice";
                /// Rows of training before the first validation; a training that has fewer is evaluated by its last
                /// policy.
                validation_start: u32 = 20, in 1.0..=1e6, unit "rows", source "our choice, measured";
                /// Rows of training between two validations.
                validation_interval: u32 = 5, in 1.0..=1e6, unit "rows", source "our choice, measured";
                /// Episodes of each validation.
                validation_seeds: u32 = 2, in 1.0..=1000.0, unit "episodes", source "our choice, measured";
                /// Policies that are compared again with the last one when training is over, at most.
                finalists: u32 = 3, in 1.0..=100.0, unit "policies", source "our choice, measured";
                /// Episodes of each finalist and of the last policy in that comparison.
                finalist_seeds: u32 = 5, in 1.0..=1000.0, unit "episodes", source "our choice, measured";
                /// Share of the last policy's objective by which another has to be better to replace it.
                margin: f64 = 0.05, in 0.0..=1.0, source "our choice, measured";
                /// Validations in a row without a better one after which training stops early; 0 never stops it.
                patience: u32 = 0, in 0.0..=1e6, unit "validations", source "off, as in RESCO";
                /// Whether a training whose network is dead (its values no longer depend on state or action)
                /// starts again from another seed: `dead`, or `never`.
                restart: $crate::run::selection::Restart =
                    $crate::run::selection::Restart::Dead, source "our choice";
            }
        }
    };
}
pub use crate::__training_settings as training_settings;

/// Which policy of a training is evaluated: the settings of `[training]` that every domain has.
///
/// A manifest from before there was a choice lacks them: its trainings were evaluated by their last policy.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Selection {
    /// Which policy is evaluated.
    pub select: Select,
    /// Rows of training before the first validation.
    pub validation_start: u32,
    /// Rows of training between two validations.
    pub validation_interval: u32,
    /// Episodes of each validation.
    pub validation_seeds: u32,
    /// Policies that are compared with the last one again, at most.
    pub finalists: u32,
    /// Episodes of each of them in that comparison.
    pub finalist_seeds: u32,
    /// Share of the last policy's objective by which another has to be better.
    pub margin: f64,
    /// Validations in a row without a better one that end training; 0 for never.
    pub patience: u32,
    /// Whether a training with a dead network starts again.
    pub restart: Restart,
}

impl Default for Selection {
    fn default() -> Self {
        Self {
            select: Select::Last,
            validation_start: 1,
            validation_interval: 1,
            validation_seeds: 1,
            finalists: 1,
            finalist_seeds: 1,
            margin: 0.0,
            patience: 0,
            restart: Restart::Never,
        }
    }
}

impl Selection {
    /// Returns that of a manifest's settings.
    pub fn of(settings: &Value) -> Result<Self, String> {
        match settings.get(SECTION) {
            None => Ok(Self::default()),
            Some(section) => Self::deserialize(section).map_err(|e| format!("{SECTION}: {e}")),
        }
    }

    /// Whether validation chooses.
    pub fn validates(&self) -> bool {
        self.select == Select::Validation
    }

    /// Whether the policy is to be validated after so many rows of training.
    pub fn is_due(&self, rows: u32) -> bool {
        let past = rows.checked_sub(self.validation_start);
        self.validates() && past.is_some_and(|past| past.is_multiple_of(self.validation_interval))
    }

    /// Returns how many episodes validation takes at most in a training of so many rows.
    pub fn most_episodes(&self, rows: u32) -> u32 {
        if !self.validates() || rows < self.validation_start {
            return 0;
        }
        let times = (rows - self.validation_start) / self.validation_interval + 1;
        // The last policy plays beside the finalists.
        times * self.validation_seeds + (self.finalists.min(times) + 1) * self.finalist_seeds
    }

    /// Whether `value` is better than `than` by more than the margin.
    pub fn is_better(&self, value: f64, than: f64, direction: Direction) -> bool {
        let margin = self.margin * than.abs();
        match direction {
            Direction::Lower => value < than - margin,
            Direction::Higher => value > than + margin,
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn selection() -> Selection {
        Selection {
            select: Select::Validation,
            validation_start: 20,
            validation_interval: 5,
            validation_seeds: 2,
            finalists: 3,
            finalist_seeds: 5,
            margin: 0.05,
            ..Selection::default()
        }
    }

    #[test]
    fn settings_from_before_there_was_a_choice_mean_the_last_policy() {
        assert_eq!(Selection::of(&json!({})), Ok(Selection::default()));
        let old = Selection::of(&json!({"training": {"episodes": 100}})).unwrap();
        assert_eq!((old.select, old.restart), (Select::Last, Restart::Never));
        let new = Selection::of(&json!({"training": {"select": "validation", "restart": "dead"}}));
        assert_eq!(new.map(|s| (s.validates(), s.restart)), Ok((true, Restart::Dead)));
        let wrong = Selection::of(&json!({"training": {"select": "best"}})).unwrap_err();
        assert!(wrong.starts_with("training: unknown variant `best`"), "{wrong}");
    }

    #[test]
    fn validation_is_due_from_its_start_on_at_its_interval() {
        let due: Vec<u32> = (0..=36).filter(|rows| selection().is_due(*rows)).collect();
        assert_eq!(due, [20, 25, 30, 35]);
        assert!(!Selection::default().is_due(20));
    }

    #[test]
    fn the_most_episodes_are_all_validations_and_a_full_final() {
        // 17 validations of 2 episodes; 3 finalists and the last policy with 5 each.
        assert_eq!(selection().most_episodes(100), 34 + 20);
        assert_eq!((selection().most_episodes(19), selection().most_episodes(20)), (0, 2 + 10));
        assert_eq!(Selection::default().most_episodes(100), 0);
    }

    #[test]
    fn better_means_by_more_than_the_margin_in_the_objective_s_direction() {
        let better =
            |value, than, direction: Direction| selection().is_better(value, than, direction);
        assert!(better(94.0, 100.0, Direction::Lower) && !better(95.5, 100.0, Direction::Lower));
        assert!(
            better(106.0, 100.0, Direction::Higher) && !better(104.0, 100.0, Direction::Higher)
        );
        // Returns may be negative: -94 is better than -100 by 6%.
        assert!(better(-94.0, -100.0, Direction::Higher));
        assert!(!better(-96.0, -100.0, Direction::Higher));
    }
}
