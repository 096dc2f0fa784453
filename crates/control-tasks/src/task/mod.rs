//! What a control task has to say of itself.

pub mod scenario;

use self::scenario::Settings;
use crate::episodes::{Dynamics, Episodes};
use evaluation::family::MdpFamily;

pub(crate) use self::scenario::scenario;
pub(crate) use evaluation::family::PointMdp;
pub(crate) use evaluation::run::domain::Objective;
pub(crate) use evaluation::run::fault::Cause;
pub(crate) use evaluation::settings::setting::settings;
pub(crate) use evaluation::stats::{Direction, Side};
pub(crate) use learners::rl::environment::Actions;
pub(crate) use learners::rl::random::Generator;

pub(crate) const NORMALISED_RETURN: Objective =
    Objective::new("normalised_return", "normalised return", "", Direction::Higher);

pub(crate) const RETURN: Objective = Objective::new("return", "return", "", Direction::Higher);

/// A number that one point MDP of a family differs in from another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContextFeature {
    /// Name, which ends in the unit where there is one.
    pub name: &'static str,
    /// Unit; empty where it has none.
    pub unit: &'static str,
    /// Its value where a table does not give one.
    pub default: f64,
    /// Abbreviation in the ids of point MDPs.
    pub short: &'static str,
    /// The least and the largest value that it may have.
    pub range: [f64; 2],
}

/// The least value of what has to be above 0.
pub(crate) const ABOVE_0: f64 = f64::MIN_POSITIVE;

pub(crate) const POSITIVE: [f64; 2] = [ABOVE_0, f64::MAX];

pub(crate) const fn feature(
    name: &'static str,
    unit: &'static str,
    default: f64,
    short: &'static str,
    range: [f64; 2],
) -> ContextFeature {
    ContextFeature { name, unit, default, short, range }
}

/// A kind of control task with its family.
pub trait Task: std::fmt::Debug + Clone + Copy + Default + Send + Sync + 'static {
    /// Stable name: of the domain, and of the family that the program carries.
    const NAME: &'static str;
    /// What it is, for messages: `a cart and pole`.
    const WHAT: &'static str;
    /// What stands in manifests for a simulator.
    const SIMULATOR: &'static str;
    /// The features of a context.
    const FEATURES: &'static [ContextFeature];
    /// What scores compare.
    const OBJECTIVE: Objective;
    /// Beyond which value of the objective a method counts as failed.
    const FAILURE: (Side, f64);
    /// Processor time of a step of evaluation, seconds; a first guess.
    const STEP_S: f64;
    /// Sections of methods that came after results were published: manifests have them only where they are not the
    /// defaults, so that what is published can be continued and computed again with the same bytes.
    const LATER: &'static [&'static str] = &[];
    /// The scenario that the program carries, as TOML.
    const EMBEDDED: &'static str;
    /// The settings of the preset `tuned`, as TOML.
    const TUNED: &'static str;

    /// The scenario.
    type Scenario: Settings<Task = Self>;
    /// What happens in a step.
    type Dynamics: Dynamics + Clone + 'static;

    /// Looks for the simulator, where it is not a part of this program, and returns what stands in manifests for it.
    /// The error is what is missing, and the way out.
    fn simulator() -> Result<String, Cause> {
        Ok(Self::SIMULATOR.to_owned())
    }

    /// Returns the point MDPs of the family, whose importances sum to 1.
    fn points() -> Vec<PointMdp>;

    /// Checks a context beyond the ranges of its values.
    /// The error is the place of a feature, and what is wrong with its value and the way out.
    fn check(_scenario: &Self::Scenario, _context: &[f64]) -> Result<(), (usize, String)> {
        Ok(())
    }

    /// Returns features without effect, which samples ignore.
    fn without_effect(_scenario: &Self::Scenario) -> &'static [&'static str] {
        &[]
    }

    /// Returns the dynamics of a context, in the order of [`Self::FEATURES`].
    fn dynamics(scenario: &Self::Scenario, context: &[f64]) -> Self::Dynamics;

    /// Returns what turns the score of an episode into the objective; by default nothing does.
    fn scale(_environment: &Episodes<Self::Dynamics>) -> Scale {
        Scale { zero: 0.0, one: 1.0, names: None }
    }
}

pub(crate) fn all<const N: usize>(context: &[f64]) -> [f64; N] {
    context.try_into().expect("a context has all features")
}

/// What turns the score of an episode into the objective: `(score - zero) / (one - zero)`.
#[derive(Debug, Clone, PartialEq)]
pub struct Scale {
    /// The score that counts 0.
    pub zero: f64,
    /// The score that counts 1.
    pub one: f64,
    /// Names under which the two stand in records; `None` where they are the same for all point MDPs.
    pub names: Option<[&'static str; 2]>,
}

/// Returns a point MDP per combination of values, the last feature changing first, all equally important. An id has a
/// feature's abbreviation before every value.
pub fn grid(
    features: &[ContextFeature],
    values: &[&[f64]],
    title: impl Fn(&[f64]) -> String,
) -> Vec<PointMdp> {
    let count: usize = values.iter().map(|v| v.len()).product();
    let point = |number: usize| {
        let mut left = number;
        let mut context = vec![0.0; values.len()];
        for (place, values) in values.iter().enumerate().rev() {
            context[place] = values[left % values.len()];
            left /= values.len();
        }
        point(features, &context, title(&context), 1.0 / count as f64)
    };
    (0..count).map(point).collect()
}

/// Returns the point MDP of a context.
pub fn point(
    features: &[ContextFeature],
    context: &[f64],
    title: String,
    importance: f64,
) -> PointMdp {
    let words: Vec<String> =
        features.iter().zip(context).map(|(f, v)| format!("{}{v}", f.short)).collect();
    PointMdp { id: words.join("-"), title, features: context.to_vec(), importance, instances: 1 }
}

pub(crate) fn family<T: Task>(name: &str) -> MdpFamily {
    let features = T::FEATURES
        .iter()
        .map(|f| evaluation::family::Feature { name: f.name.into(), unit: f.unit.into() });
    MdpFamily::new(name, features.collect(), T::points(), name).expect("equal shares sum to 1")
}

#[cfg(test)]
pub(crate) mod testing {
    //! What every task has to pass.

    use std::collections::BTreeSet;

    use learners::nn::state::State as _;
    use learners::rl::environment::{Environment, play};

    use super::*;

    /// Checks a family: as many different points as there should be, of importances that sum to 1, whose ids are plain.
    pub(crate) fn check_family<T: Task>(count: usize) {
        let family = family::<T>(T::NAME);
        let ids: BTreeSet<_> = family.points.iter().map(|p| p.id.as_str()).collect();
        assert_eq!((family.points.len(), ids.len()), (count, count));
        let safe = |c: char| c.is_ascii_alphanumeric() || "-.".contains(c);
        assert!(ids.iter().all(|id| id.chars().all(safe)), "{ids:?}");
        assert!(family.points.iter().all(|p| p.features.len() == T::FEATURES.len()));
        let scenario = T::Scenario::read(T::EMBEDDED, "a.toml", &[]).unwrap();
        assert!(family.points.iter().all(|p| T::check(&scenario, &p.features).is_ok()));
    }

    /// Returns the observations and rewards of some episodes, whose actions are random where they are numbered, and the
    /// largest in the direction of the last number of an observation, a velocity, where they are not.
    fn trace<T: Task>(scenario: &T::Scenario, context: &[f64]) -> Vec<f32> {
        let mut environment = Episodes::of(T::dynamics(scenario, context));
        let mut draw = Generator::new(5, &[]);
        let actions = environment.actions();
        let mut all = Vec::new();
        let mut observation = vec![0.0; environment.width()];
        let mut action = vec![0.0; actions.width()];
        for episode in 0..3 {
            environment.reset(episode, &mut observation);
            loop {
                all.extend_from_slice(&observation);
                match actions {
                    Actions::Numbered(_) => random(actions, &mut draw, &mut action),
                    Actions::Continuous { limit, .. } => {
                        action.fill(limit.copysign(observation[observation.len() - 1]));
                    }
                }
                let step = environment.step(&action, &mut observation);
                all.push(step.reward);
                if step.over() {
                    break;
                }
            }
        }
        all
    }

    pub(crate) fn random(actions: Actions, draw: &mut Generator, action: &mut [f32]) {
        match actions {
            Actions::Numbered(count) => action[0] = draw.below(count) as f32,
            Actions::Continuous { limit, .. } => {
                action.iter_mut().for_each(|a| *a = limit * (2.0 * draw.unit() - 1.0) as f32);
            }
        }
    }

    /// Checks that every feature changes what happens, but those that are said not to.
    pub(crate) fn check_features<T: Task>(scenario: &T::Scenario) {
        let default: Vec<f64> = T::FEATURES.iter().map(|f| f.default).collect();
        let before = trace::<T>(scenario, &default);
        for (i, feature) in T::FEATURES.iter().enumerate() {
            let mut context = default.clone();
            context[i] *= 0.7;
            let changed = trace::<T>(scenario, &context) != before;
            let without = T::without_effect(scenario).contains(&feature.name);
            assert_eq!(changed, !without, "{}", feature.name);
        }
    }

    pub(crate) fn check_episodes<T: Task>() {
        let scenario = T::Scenario::default();
        let default: Vec<f64> = T::FEATURES.iter().map(|f| f.default).collect();
        let new = || Episodes::of(T::dynamics(&scenario, &default));
        let (mut one, mut draw) = (new(), Generator::new(3, &[]));
        let actions = one.actions();
        let mut observation = vec![0.0; one.width()];
        let mut action = vec![0.0; actions.width()];
        one.reset(7, &mut observation);
        for _ in 0..5 {
            random(actions, &mut draw, &mut action);
            one.step(&action, &mut observation);
        }
        let mut archive = learners::nn::archive::Archive::default();
        one.save("a.", &mut archive);
        let mut other = new();
        other.restore("a.", &archive).unwrap();
        let mut after = observation.clone();
        assert_eq!(one.step(&action, &mut observation), other.step(&action, &mut after));
        assert_eq!(observation, after);
        assert!(other.restore("b.", &archive).is_err());
        let mut still = |_: &[f32], action: &mut [f32]| action.fill(0.0);
        let outcome = play(&mut new(), 3, &mut still);
        assert_eq!(outcome, play(&mut new(), 3, &mut still));
        assert!(outcome.steps <= T::Dynamics::HORIZON && outcome.steps > 0);
    }
}
