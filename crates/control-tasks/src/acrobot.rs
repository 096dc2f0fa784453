//! Two links that hang from a joint and are to be swung up by a motor between them: gymnasium's `Acrobot-v1`.
//!
//! Equations, constants and the order of the arithmetic are gymnasium's (1.4.0, `envs/classic_control/acrobot.py`, with the
//! equations of Sutton and Barto's book). The paper lists acrobot among the tasks whose point MDPs papers leave open; it computes
//! no family of it.
//! Deviation: the family is ours, around gymnasium's values. The middle of a link is its centre of mass, so that a longer link
//! has it further out; the moments of inertia and the height of the goal stay gymnasium's.

use std::f64::consts::PI;

use crate::episodes::Dynamics;
use crate::methods::{ars, dqn, ppo, trpo};
use crate::task::{
    Actions, ContextFeature, Generator, Objective, PointMdp, RETURN, Side, Task, all, feature,
    grid, scenario, settings,
};

const STEP_S: f64 = 0.2;

/// Gravity, m/s².
const GRAVITY_MPS2: f64 = 9.8;

/// Moment of inertia of each link, kg m².
const INERTIA: f64 = 1.0;

/// Largest angular velocities of the links, rad/s.
const MAX_SPEEDS: [f64; 2] = [4.0 * PI, 9.0 * PI];

/// An acrobot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Acrobot {
    /// Lengths of the links, m.
    pub lengths_m: [f64; 2],
    /// Masses of the links, kg.
    pub masses_kg: [f64; 2],
    /// Torque of the motor, N m.
    pub torque_nm: f64,
    /// Angles and angular velocities that episodes start within.
    pub start: f64,
}

/// Angle of the first link from hanging and of the second from the first (rad), and their velocities (rad/s).
pub type State = [f64; 4];

/// Angle beyond which whole turns are divided out, where gymnasium takes them off one by one: extreme links turn so fast
/// that this would take for ever. Radians.
const MANY_TURNS_RAD: f64 = 1000.0;

/// Lengths and masses of links, within which a step of 0.2 s is short enough.
const LINKS: [f64; 2] = [0.1, 10.0];

fn wrap(mut angle: f64) -> f64 {
    if angle.is_nan() || angle.abs() > MANY_TURNS_RAD {
        return (angle + PI).rem_euclid(2.0 * PI) - PI;
    }
    while angle > PI {
        angle -= 2.0 * PI;
    }
    while angle < -PI {
        angle += 2.0 * PI;
    }
    angle
}

impl Acrobot {
    fn change(&self, [first, second, speed, second_speed]: State, torque: f64) -> State {
        let ([l1, l2], [m1, m2], g) = (self.lengths_m, self.masses_kg, GRAVITY_MPS2);
        let (c1, c2) = (l1 / 2.0, l2 / 2.0);
        let (sin, cos) = (libm::sin(second), libm::cos(second));
        let d1 =
            m1 * (c1 * c1) + m2 * (l1 * l1 + c2 * c2 + 2.0 * l1 * c2 * cos) + INERTIA + INERTIA;
        let d2 = m2 * (c2 * c2 + l1 * c2 * cos) + INERTIA;
        let phi2 = m2 * c2 * g * libm::cos(first + second - PI / 2.0);
        let phi1 = -m2 * l1 * c2 * (second_speed * second_speed) * sin
            - 2.0 * m2 * l1 * c2 * second_speed * speed * sin
            + (m1 * c1 + m2 * l1) * g * libm::cos(first - PI / 2.0)
            + phi2;
        let second_rate = (torque + d2 / d1 * phi1 - m2 * l1 * c2 * (speed * speed) * sin - phi2)
            / (m2 * (c2 * c2) + INERTIA - d2 * d2 / d1);
        [speed, second_speed, -(d2 * second_rate + phi1) / d1, second_rate]
    }

    /// Returns the state after a torque, and whether the end is high enough.
    pub fn step(&self, state: State, torque: f64) -> (State, bool) {
        let moved =
            |by: State, time: f64| -> State { std::array::from_fn(|i| state[i] + time * by[i]) };
        let k1 = self.change(state, torque);
        let k2 = self.change(moved(k1, STEP_S / 2.0), torque);
        let k3 = self.change(moved(k2, STEP_S / 2.0), torque);
        let k4 = self.change(moved(k3, STEP_S), torque);
        let sum = std::array::from_fn(|i| k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        let [first, second, speed, second_speed] = moved(sum, STEP_S / 6.0);
        let [fastest, second_fastest] = MAX_SPEEDS;
        let after = [
            wrap(first),
            wrap(second),
            speed.clamp(-fastest, fastest),
            second_speed.clamp(-second_fastest, second_fastest),
        ];
        (after, -libm::cos(after[0]) - libm::cos(after[1] + after[0]) > 1.0)
    }
}

impl Dynamics for Acrobot {
    const LABEL: &'static str = "acrobot";
    const HORIZON: u32 = 500;
    const WIDTH: usize = 6;
    type State = State;

    fn actions(&self) -> Actions {
        Actions::Numbered(3)
    }

    fn start(&self, generator: &mut Generator) -> State {
        // Gymnasium rounds where an episode starts, and nothing afterwards.
        std::array::from_fn(|_| f64::from((self.start * (2.0 * generator.unit() - 1.0)) as f32))
    }

    fn observe(&self, [first, second, speed, second_speed]: &State, observation: &mut [f32]) {
        let angles = [*first, *second].map(|angle| [libm::cos(angle), libm::sin(angle)]);
        let numbers = angles.as_flattened().iter().chain([speed, second_speed]);
        observation.iter_mut().zip(numbers).for_each(|(o, n)| *o = *n as f32);
    }

    fn act(&self, state: &mut State, action: &[f32]) -> (f64, bool) {
        let (after, is_high) = self.step(*state, self.torque_nm * (f64::from(action[0]) - 1.0));
        *state = after;
        (if is_high { 0.0 } else { -1.0 }, is_high)
    }
}

settings! {
    /// Where methods act.
    pub struct Environment, source "gymnasium 1.4.0, Acrobot-v1" {
        /// Torque of the motor.
        torque_nm: f64 = 1.0, in 1e-3..=1e4, unit "N m";
        /// Angles and angular velocities that episodes start within.
        start: f64 = 0.1, in 0.0..=3.0, unit "rad, rad/s";
    }
}

scenario! {
    /// Acrobots.
    task: Acrobots,
    environment: Environment,
    methods: { ppo, dqn, trpo, ars }
}

impl Task for Acrobots {
    const NAME: &'static str = "acrobot";
    const WHAT: &'static str = "an acrobot";
    const SIMULATOR: &'static str = "Acrobot with the equations of gymnasium 1.4.0";
    const FEATURES: &'static [ContextFeature] = &[
        feature("first_length_m", "m", 1.0, "l", LINKS),
        feature("second_length_m", "m", 1.0, "k", LINKS),
        feature("first_mass_kg", "kg", 1.0, "m", LINKS),
        feature("second_mass_kg", "kg", 1.0, "n", LINKS),
    ];
    const OBJECTIVE: Objective = RETURN;
    // Not at the goal within the 500 steps of an episode, in nearly all of them.
    const FAILURE: (Side, f64) = (Side::Below, -499.0);
    const STEP_S: f64 = 1e-6;
    const EMBEDDED: &'static str = include_str!("../../../scenarios/acrobot.toml");
    const TUNED: &'static str = include_str!("../../../scenarios/presets/acrobot-tuned.toml");
    type Scenario = Scenario;
    type Dynamics = Acrobot;

    fn points() -> Vec<PointMdp> {
        let (lengths, masses): (&[f64], &[f64]) = (&[0.5, 1.0, 1.5], &[0.5, 1.0, 2.0]);
        grid(Self::FEATURES, &[lengths, lengths, masses, masses], |c| {
            format!("links of {} and {} m, {} and {} kg", c[0], c[1], c[2], c[3])
        })
    }

    fn dynamics(scenario: &Scenario, context: &[f64]) -> Acrobot {
        let [first, second, mass, second_mass] = all(context);
        let Environment { torque_nm, start } = scenario.environment;
        Acrobot { lengths_m: [first, second], masses_kg: [mass, second_mass], torque_nm, start }
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
        check_family::<Acrobots>(81);
        check_episodes::<Acrobots>();
        check_features::<Acrobots>(&Scenario::default());
    }

    #[test]
    fn no_angle_takes_for_ever() {
        for angle in [1e20, -1e300, 1e9] {
            assert!(wrap(angle).abs() <= PI, "{angle}");
        }
        assert!(wrap(f64::NAN).is_nan() && wrap(f64::INFINITY).is_nan());
    }

    #[test]
    fn a_pump_swings_gymnasium_s_acrobot_up_and_no_torque_does_not() {
        let played = |policy: &mut dyn FnMut(&[f32], &mut [f32])| {
            let own = Acrobots::dynamics(&Scenario::default(), &[1.0; 4]);
            play(&mut Episodes::of(own), 1, policy)
        };
        let pumped = played(&mut |o, a| a[0] = if o[4] > 0.0 { 0.0 } else { 2.0 });
        assert!(pumped.steps < 200 && pumped.total == 1.0 - f64::from(pumped.steps), "{pumped:?}");
        assert_eq!(played(&mut |_, a| a[0] = 1.0).total, -500.0);
    }
}
