//! Three links in a viscous liquid, which are to swim to a goal: the five point MDPs of the paper's first study.
//!
//! The model is gymnasium's `Swimmer` (1.4.0, `envs/mujoco/swimmer_v5.py` and its model), and MuJoCo computes it. As in Inala et
//! al. (ICLR 2020; github.com/jinala/RLBench, `swimmer/swimmer_train.py`), an episode ends when the joint at the head is beyond
//! 10 m, or after 5,000 steps. The five point MDPs are those of Jayawardana et al. (NeurIPS 2022): the radii of the links.

use crate::episodes::Dynamics;
use crate::methods::{ppo, td3, trpo};
use crate::mujoco::{self, Lazy};
use crate::task::{
    ABOVE_0, Actions, Cause, ContextFeature, Direction, Generator, Objective, PointMdp, Side, Task,
    all, feature, point, scenario, settings,
};

/// Steps of the model per action, and what they take, s.
const STEPS: u32 = 4;
const STEP_S: f64 = 0.04;

/// Amount of the noise on positions and velocities where an episode starts.
const START: f64 = 0.1;

/// Radii of a link, m; its length is 1 m.
const RADII_M: [f64; 2] = [ABOVE_0, 0.5];

/// A swimmer.
#[derive(Debug, Clone)]
pub struct Swimmer {
    /// How far the goal is, m.
    pub goal_m: f64,
    /// What a unit of squared torque costs.
    pub control_cost: f64,
    model: Lazy<15>,
}

/// Positions along x and y, direction and angles of both joints; their velocities; and where the solver starts.
pub type State = [f64; 15];

/// The model in MJCF, but for the radii. Nothing touches anything.
const MODEL: &str = include_str!("../models/swimmer.xml");

impl Swimmer {
    /// Returns a swimmer; radii of the links from the head on, goal in m, and what a unit of squared torque costs.
    pub fn new(radii_m: [f64; 3], goal_m: f64, control_cost: f64) -> Self {
        let [head, middle, tail] = radii_m.map(|radius| radius.to_string());
        let mjcf = MODEL.replace("HEAD", &head).replace("MIDDLE", &middle).replace("TAIL", &tail);
        Self { goal_m, control_cost, model: Lazy::new(mjcf, 2, None) }
    }

    /// Returns the state of positions and velocities; the rest of what is given does not count.
    pub fn begin(&self, state: State) -> State {
        self.model.begin(state)
    }
}

impl Dynamics for Swimmer {
    const LABEL: &'static str = "swimmer";
    const HORIZON: u32 = 5000;
    const WIDTH: usize = 8;
    type State = State;
    const FIRST_SEEN: usize = 2;

    fn actions(&self) -> Actions {
        Actions::Continuous { count: 2, limit: 1.0 }
    }

    fn start(&self, generator: &mut Generator) -> State {
        let mut state = State::default();
        state[..10].fill_with(|| START * (2.0 * generator.unit() - 1.0));
        self.begin(state)
    }

    fn act(&self, state: &mut State, action: &[f32]) -> (f64, bool) {
        let before = state[0];
        let control = [f64::from(action[0]), f64::from(action[1])];
        self.model.step(state, &control, STEPS);
        let cost = control[0] * control[0] + control[1] * control[1];
        let reward = (state[0] - before) / STEP_S - self.control_cost * cost;
        (reward, state[0] > self.goal_m)
    }

    fn score(&self, _: &State, _: f64, steps: u32) -> f64 {
        f64::from(steps)
    }
}

settings! {
    /// Where methods act.
    pub struct Environment, source "Inala et al., 2020" {
        /// How far the goal is.
        goal_m: f64 = 10.0, in 0.1..=1e6, unit "m";
        /// What a unit of squared torque costs, where the largest torque is 1.
        control_cost: f64 = 1e-4, in 0.0..=1e3, source "gymnasium 1.4.0, Swimmer-v5";
    }
}

scenario! {
    /// Swimmers.
    task: Swimmers,
    environment: Environment,
    methods: { ppo, trpo, td3 }
}

impl Task for Swimmers {
    const NAME: &'static str = "swimmer";
    const WHAT: &'static str = "a swimmer";
    const SIMULATOR: &'static str = "MuJoCo";
    const FEATURES: &'static [ContextFeature] = &[
        feature("head_radius_m", "m", 0.1, "a", RADII_M),
        feature("middle_radius_m", "m", 0.1, "b", RADII_M),
        feature("tail_radius_m", "m", 0.1, "c", RADII_M),
    ];
    const OBJECTIVE: Objective =
        Objective::new("steps_to_goal", "steps to the goal", "steps", Direction::Lower);
    // Not at the goal within the steps of an episode, in nearly all of them.
    const FAILURE: (Side, f64) = (Side::Above, 4999.0);
    const STEP_S: f64 = 1.5e-5;
    const EMBEDDED: &'static str = include_str!("../../../scenarios/swimmer.toml");
    const TUNED: &'static str = include_str!("../../../scenarios/presets/swimmer-tuned.toml");
    type Scenario = Scenario;
    type Dynamics = Swimmer;

    fn simulator() -> Result<String, Cause> {
        Ok(format!("{} {}", Self::SIMULATOR, mujoco::version()?.0))
    }

    fn points() -> Vec<PointMdp> {
        let five = [
            ([0.1, 0.1, 0.1], ""),
            ([0.15, 0.15, 0.15], ""),
            ([0.1, 0.15, 0.1], ""),
            ([0.05, 0.05, 0.05], ", simplified"),
            ([0.1, 0.1125, 0.1], ", generic"),
        ];
        five.map(|(context, mark)| {
            let [head, middle, tail] = context;
            let title = format!("links of {head}, {middle} and {tail} m{mark}");
            point(Self::FEATURES, &context, title, 0.2)
        })
        .into()
    }

    fn dynamics(scenario: &Scenario, context: &[f64]) -> Swimmer {
        let radii_m = all(context);
        let Environment { goal_m, control_cost } = scenario.environment;
        Swimmer::new(radii_m, goal_m, control_cost)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::task::testing::{check_episodes, check_family, check_features};

    #[test]
    fn it_is_a_task() {
        check_family::<Swimmers>(5);
        if let Err(e) = mujoco::version() {
            eprintln!("skipped: {e}");
            return;
        }
        check_episodes::<Swimmers>();
        check_features::<Swimmers>(&Scenario::default());
    }
}
