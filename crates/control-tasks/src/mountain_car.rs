//! A car in a valley whose motor is too weak to climb out at once: gymnasium's `MountainCarContinuous-v0`.
//!
//! Equations, constants and the order of the arithmetic are gymnasium's (1.4.0,
//! `envs/classic_control/continuous_mountain_car.py`): the state is rounded to single precision after every step. The paper
//! varies the largest speed, the goal and the power of the motor, but gives no values.
//! Deviation: the grid of values is ours, around gymnasium's.

use crate::episodes::Dynamics;
use crate::methods::{ars, ppo, sac, td3, trpo};
use crate::task::{
    ABOVE_0, Actions, ContextFeature, Generator, Objective, POSITIVE, PointMdp, RETURN, Side, Task,
    all, feature, grid, scenario, settings,
};

const POSITIONS: [f64; 2] = [-1.2, 0.6];

const GRAVITY: f64 = 0.0025;

/// Reward at the goal.
const GOAL: f64 = 100.0;

/// A car and its goal. Positions, speeds and power are in gymnasium's units, per step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MountainCar {
    /// Largest speed.
    pub max_speed: f64,
    /// Position at which an episode ends.
    pub goal: f64,
    /// Speed that the motor adds in a step at most.
    pub power: f64,
    /// Ends of where episodes start.
    pub start: [f64; 2],
}

/// Position and velocity.
pub type State = [f64; 2];

impl MountainCar {
    /// Returns the reward of an action, the state afterwards, and whether the goal is reached.
    /// As numpy does with an action in single precision, sums are in single precision where the state is in it, which is so
    /// after every step but not where an episode starts.
    pub fn step(&self, [position, velocity]: State, action: f32) -> (f64, State, bool) {
        let is_single = f64::from(position as f32) == position;
        let round = |number: f64| if is_single { f64::from(number as f32) } else { number };
        let pull = GRAVITY * libm::cos(round(3.0 * position));
        let push = match action.abs() > 1.0 {
            true => self.power.copysign(f64::from(action)) - pull,
            false => f64::from(action * self.power as f32 - pull as f32),
        };
        let fastest = round(self.max_speed);
        let mut velocity = round(velocity + round(push)).clamp(-fastest, fastest);
        let [low, high] = POSITIONS.map(round);
        let position = round(position + velocity).clamp(low, high);
        if position == low && velocity < 0.0 {
            velocity = 0.0;
        }
        let reached = position >= round(self.goal) && velocity >= 0.0;
        let action = f64::from(action);
        let reward = if reached { GOAL } else { 0.0 } - action * action * 0.1;
        (reward, [position, velocity].map(|n| f64::from(n as f32)), reached)
    }
}

impl Dynamics for MountainCar {
    const LABEL: &'static str = "mountain-car";
    const HORIZON: u32 = 999;
    const WIDTH: usize = 2;
    type State = State;

    fn actions(&self) -> Actions {
        Actions::Continuous { count: 1, limit: 1.0 }
    }

    fn start(&self, generator: &mut Generator) -> State {
        let [low, high] = self.start;
        [low + (high - low) * generator.unit(), 0.0]
    }

    fn act(&self, state: &mut State, action: &[f32]) -> (f64, bool) {
        let (reward, after, reached) = self.step(*state, action[0]);
        *state = after;
        (reward, reached)
    }
}

settings! {
    /// Where methods act.
    pub struct Environment, source "gymnasium 1.4.0, MountainCarContinuous-v0" {
        /// Lowest position at which episodes start.
        start_low: f64 = -0.6, in -1.2..=0.0, at most start_high;
        /// Highest position at which episodes start.
        start_high: f64 = -0.4, in -1.2..=0.0;
    }
}

scenario! {
    /// Mountain cars.
    task: MountainCars,
    environment: Environment,
    methods: { ppo, sac, td3, trpo, ars }
}

impl Task for MountainCars {
    const NAME: &'static str = "mountain-car";
    const WHAT: &'static str = "a mountain car";
    const SIMULATOR: &'static str = "MountainCarContinuous with the equations of gymnasium 1.4.0";
    const FEATURES: &'static [ContextFeature] = &[
        feature("max_speed", "", 0.07, "s", POSITIVE),
        feature("goal_position", "", 0.45, "g", [ABOVE_0, POSITIONS[1]]),
        feature("power", "", 0.0015, "p", POSITIVE),
    ];
    const OBJECTIVE: Objective = RETURN;
    // An episode that reaches the goal has more than 0, and one of full power for all steps -99.9.
    const FAILURE: (Side, f64) = (Side::Below, 0.05);
    const STEP_S: f64 = 5e-7;
    const EMBEDDED: &'static str = include_str!("../../../scenarios/mountain-car.toml");
    const TUNED: &'static str = include_str!("../../../scenarios/presets/mountain-car-tuned.toml");
    type Scenario = Scenario;
    type Dynamics = MountainCar;

    fn points() -> Vec<PointMdp> {
        let values: [&[f64]; 3] = [
            &[0.035, 0.05, 0.07, 0.1],
            &[0.25, 0.35, 0.45, 0.55],
            &[0.0005, 0.001, 0.0015, 0.002, 0.003],
        ];
        grid(Self::FEATURES, &values, |c| {
            format!("speed up to {}, goal at {}, power {}", c[0], c[1], c[2])
        })
    }

    fn dynamics(scenario: &Scenario, context: &[f64]) -> MountainCar {
        let [max_speed, goal, power] = all(context);
        let Environment { start_low, start_high } = scenario.environment;
        MountainCar { max_speed, goal, power, start: [start_low, start_high] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::episodes::Episodes;
    use crate::task::testing::{check_episodes, check_family, check_features};
    use learners::rl::environment::play;

    #[test]
    fn it_is_a_task() {
        check_family::<MountainCars>(80);
        check_episodes::<MountainCars>();
        check_features::<MountainCars>(&Scenario::default());
    }

    /// The push that swings a car out of the valley: with its velocity.
    fn swung(context: &[f64]) -> f64 {
        let mut environment = Episodes::of(MountainCars::dynamics(&Scenario::default(), context));
        let mut policy = |o: &[f32], a: &mut [f32]| a[0] = if o[1] < 0.0 { -1.0 } else { 1.0 };
        play(&mut environment, 1, &mut policy).total
    }

    #[test]
    fn gymnasium_s_car_can_be_swung_out_and_a_weak_one_takes_longer() {
        let own = swung(&[0.07, 0.45, 0.0015]);
        assert!(own > 85.0 && swung(&[0.07, 0.45, 0.0005]) < own, "{own}");
    }
}
