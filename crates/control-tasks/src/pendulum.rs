//! A pendulum that a motor swings up and holds: gymnasium's `Pendulum-v1` in the paper's family of 180.
//!
//! Equations, constants and the order of the arithmetic are gymnasium's (1.4.0, `envs/classic_control/pendulum.py`); the
//! family is that of Jayawardana et al. (NeurIPS 2022), appendix: mass, length and gravity as CARL sets them. The torque is
//! limited as in gymnasium and CARL, so most of the heavy pendulums cannot be held upright: what counts is how much of what
//! is possible a method reaches, see [`references`].

use std::f64::consts::PI;

use crate::episodes::{Dynamics, Episodes};
use crate::methods::{ars, ppo, sac, td3, trpo};
use crate::task::{
    Actions, ContextFeature, Generator, NORMALISED_RETURN, Objective, POSITIVE, PointMdp, Scale,
    Side, Task, all, feature, grid, scenario, settings,
};
use learners::rl::environment::Environment as _;

const STEP_S: f64 = 0.05;

/// Largest angular velocity, rad/s.
const MAX_SPEED: f64 = 8.0;

/// A pendulum, a uniform rod.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pendulum {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Length, m.
    pub length_m: f64,
    /// Gravity, m/s².
    pub gravity_mps2: f64,
    /// Largest torque, N m.
    pub max_torque_nm: f64,
}

/// Angle from upright (rad), which grows beyond a turn, and angular velocity (rad/s).
pub type State = [f64; 2];

/// Returns an angle from -pi up to but without pi; the sign of the remainder is the divisor's, as in numpy.
pub(crate) fn wrap(angle: f64) -> f64 {
    let turn = 2.0 * PI;
    let rest = (angle + PI) % turn;
    (if rest < 0.0 { rest + turn } else { rest }) - PI
}

impl Pendulum {
    /// Returns the reward of a torque, which is cut to the limit, and the state afterwards.
    /// Deviation: all arithmetic is in double precision, as in gymnasium with an action in double precision; there a torque in
    /// single precision is squared and scaled in single precision.
    pub fn step(&self, [angle, velocity]: State, torque: f64) -> (f64, State) {
        let (m, l, g) = (self.mass_kg, self.length_m, self.gravity_mps2);
        let u = torque.clamp(-self.max_torque_nm, self.max_torque_nm);
        let wrapped = wrap(angle);
        let cost = wrapped * wrapped + 0.1 * (velocity * velocity) + 0.001 * (u * u);
        let acceleration = 3.0 * g / (2.0 * l) * libm::sin(angle) + 3.0 / (m * (l * l)) * u;
        let velocity = (velocity + acceleration * STEP_S).clamp(-MAX_SPEED, MAX_SPEED);
        (-cost, [angle + velocity * STEP_S, velocity])
    }
}

impl Dynamics for Pendulum {
    const LABEL: &'static str = "pendulum";
    const HORIZON: u32 = 200;
    const WIDTH: usize = 3;
    type State = State;

    fn actions(&self) -> Actions {
        Actions::Continuous { count: 1, limit: self.max_torque_nm as f32 }
    }

    fn start(&self, generator: &mut Generator) -> State {
        [PI, 1.0].map(|most| most * (2.0 * generator.unit() - 1.0))
    }

    fn observe(&self, [angle, velocity]: &State, observation: &mut [f32]) {
        let numbers = [libm::cos(*angle), libm::sin(*angle), *velocity];
        observation.iter_mut().zip(numbers).for_each(|(o, n)| *o = n as f32);
    }

    fn act(&self, state: &mut State, action: &[f32]) -> (f64, bool) {
        let (reward, after) = self.step(*state, f64::from(action[0]));
        *state = after;
        (reward, false)
    }
}

const EPISODES: u64 = 64;

const TORQUES: usize = 9;

/// Places of the grid: angles around the turn, and velocities from one limit to the other.
const ANGLES: usize = 120;
const VELOCITIES: usize = 101;

/// Returns mean returns of two policies over the same episodes, between which a score is measured.
///
/// - **random**: every torque is uniform within the limit.
/// - **solved**: the best of `TORQUES` torques by values that were computed backwards from the last step on a grid of
///   angles and velocities. It knows the dynamics, so no method that learns is expected to do much better; a score can exceed
///   1 a little, as the grid and the torques are coarse.
///
/// Source: ours. The paper does not say how it normalises.
pub fn references(pendulum: &Pendulum) -> [f64; 2] {
    let mut environment = Episodes::of(*pendulum);
    let mut mean = |policy: &mut dyn FnMut(&State, u32) -> f64| {
        let mut total = 0.0;
        let mut observation = [0.0; 3];
        for episode in 0..EPISODES {
            environment.reset(episode, &mut observation);
            for time in 0..Pendulum::HORIZON {
                let (reward, after) =
                    pendulum.step(environment.state, policy(&environment.state, time));
                total += reward;
                environment.state = after;
            }
        }
        total / EPISODES as f64
    };
    let mut draw = Generator::new(0, &["pendulum", "random policy"]);
    let random = mean(&mut |_, _| pendulum.max_torque_nm * (2.0 * draw.unit() - 1.0));
    let values = values(pendulum);
    let solved = mean(&mut |state, time| {
        let later = &values[time as usize + 1];
        let worth = |torque: &f64| {
            let (reward, after) = pendulum.step(*state, *torque);
            reward + at(later, after)
        };
        let torques = torques(pendulum).map(|torque| (worth(&torque), torque));
        torques.into_iter().fold((f64::NEG_INFINITY, 0.0), |a, b| if b.0 > a.0 { b } else { a }).1
    });
    [random, solved]
}

fn torques(pendulum: &Pendulum) -> [f64; TORQUES] {
    let share = |i: usize| 2.0 * i as f64 / (TORQUES - 1) as f64 - 1.0;
    std::array::from_fn(|i| pendulum.max_torque_nm * share(i))
}

fn values(pendulum: &Pendulum) -> Vec<Vec<f32>> {
    let places = (0..ANGLES * VELOCITIES).map(|place| {
        let angle = (place / VELOCITIES) as f64 * 2.0 * PI / ANGLES as f64 - PI;
        let velocity =
            (place % VELOCITIES) as f64 * 2.0 * MAX_SPEED / (VELOCITIES - 1) as f64 - MAX_SPEED;
        [angle, velocity]
    });
    // What follows a torque at a place is the same at all times.
    let moves: Vec<(f32, [usize; 4], [f32; 4])> = places
        .flat_map(|state| {
            torques(pendulum).map(|torque| {
                let (reward, after) = pendulum.step(state, torque);
                let (corners, weights) = corners(after);
                (reward as f32, corners, weights)
            })
        })
        .collect();
    let mut values = vec![vec![0.0f32; ANGLES * VELOCITIES]; Pendulum::HORIZON as usize + 1];
    for time in (0..Pendulum::HORIZON as usize).rev() {
        let (now, later) = values.split_at_mut(time + 1);
        for (value, moves) in now[time].iter_mut().zip(moves.chunks_exact(TORQUES)) {
            let worth = |(reward, corners, weights): &(f32, [usize; 4], [f32; 4])| {
                let later: f32 = corners.iter().zip(weights).map(|(c, w)| later[0][*c] * w).sum();
                reward + later
            };
            *value = moves.iter().map(worth).fold(f32::NEG_INFINITY, f32::max);
        }
    }
    values
}

fn corners([angle, velocity]: State) -> ([usize; 4], [f32; 4]) {
    let across = (wrap(angle) + PI) / (2.0 * PI) * ANGLES as f64;
    let up = (velocity + MAX_SPEED) / (2.0 * MAX_SPEED) * (VELOCITIES - 1) as f64;
    let (a, v) = (across.floor(), up.floor().min((VELOCITIES - 2) as f64));
    let (right, higher) = ((across - a) as f32, (up - v) as f32);
    let (a, v) = (a as usize % ANGLES, v as usize);
    let place = |a: usize, v: usize| a % ANGLES * VELOCITIES + v;
    (
        [place(a, v), place(a, v + 1), place(a + 1, v), place(a + 1, v + 1)],
        [
            (1.0 - right) * (1.0 - higher),
            (1.0 - right) * higher,
            right * (1.0 - higher),
            right * higher,
        ],
    )
}

fn at(values: &[f32], state: State) -> f64 {
    let (corners, weights) = corners(state);
    f64::from(corners.iter().zip(weights).map(|(c, w)| values[*c] * w).sum::<f32>())
}

settings! {
    /// Where methods act.
    pub struct Environment, source "gymnasium 1.4.0, Pendulum-v1" {
        /// Largest torque. With gymnasium's, pendulums whose mass times length is large cannot be swung up within an
        /// episode.
        max_torque_nm: f64 = 2.0, in 1e-3..=1e4, unit "N m";
    }
}

scenario! {
    /// Pendulums.
    task: Pendulums,
    environment: Environment,
    methods: { ppo, sac, td3, trpo, ars }
}

impl Task for Pendulums {
    const NAME: &'static str = "pendulum";
    const WHAT: &'static str = "a pendulum";
    const SIMULATOR: &'static str = "Pendulum with the equations of gymnasium 1.4.0";
    const FEATURES: &'static [ContextFeature] = &[
        feature("mass_kg", "kg", 1.0, "m", POSITIVE),
        feature("length_m", "m", 1.0, "l", POSITIVE),
        feature("gravity_mps2", "m/s²", 10.0, "g", POSITIVE),
    ];
    const OBJECTIVE: Objective = NORMALISED_RETURN;
    // Less than half of what is possible.
    const FAILURE: (Side, f64) = (Side::Below, 0.5);
    const STEP_S: f64 = 5e-7;
    const EMBEDDED: &'static str = include_str!("../../../scenarios/pendulum.toml");
    const TUNED: &'static str = include_str!("../../../scenarios/presets/pendulum-tuned.toml");
    type Scenario = Scenario;
    type Dynamics = Pendulum;

    fn points() -> Vec<PointMdp> {
        let values: [&[f64]; 3] = [
            &[0.4, 1.0, 1.5, 2.0, 3.0, 4.0],
            &[0.5, 1.0, 2.0, 4.0, 7.0, 10.0],
            &[2.0, 5.0, 10.0, 12.0, 15.0],
        ];
        grid(Self::FEATURES, &values, |c| format!("{} kg, {} m, gravity {} m/s²", c[0], c[1], c[2]))
    }

    fn dynamics(scenario: &Scenario, context: &[f64]) -> Pendulum {
        let [mass_kg, length_m, gravity_mps2] = all(context);
        Pendulum {
            mass_kg,
            length_m,
            gravity_mps2,
            max_torque_nm: scenario.environment.max_torque_nm,
        }
    }

    fn scale(environment: &Episodes<Pendulum>) -> Scale {
        let [random, solved] = references(&environment.dynamics);
        Scale { zero: random, one: solved, names: Some(["random_return", "solved_return"]) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::task::testing::{check_episodes, check_family, check_features};

    #[test]
    fn it_is_a_task() {
        check_family::<Pendulums>(180);
        check_episodes::<Pendulums>();
        check_features::<Pendulums>(&Scenario::default());
    }

    #[test]
    fn angles_are_wrapped_as_numpy_does() {
        for (angle, wrapped) in
            [(0.0, 0.0), (PI, -PI), (-PI, -PI), (3.5, 3.5 - 2.0 * PI), (-3.5, 2.0 * PI - 3.5)]
        {
            assert!((wrap(angle) - wrapped).abs() < 1e-15, "{angle}: {}", wrap(angle));
        }
    }

    #[test]
    fn the_solved_policy_solves_gymnasium_s_pendulum_and_is_never_worse_than_the_random_one() {
        let own = Pendulum { mass_kg: 1.0, length_m: 1.0, gravity_mps2: 10.0, max_torque_nm: 2.0 };
        let [random, solved] = references(&own);
        assert!(
            (-1350.0..-1100.0).contains(&random) && (-170.0..-120.0).contains(&solved),
            "{random} {solved}"
        );
        let mut least = f64::INFINITY;
        for point in Pendulums::points().iter().step_by(45) {
            let [random, solved] =
                references(&Pendulums::dynamics(&Scenario::default(), &point.features));
            least = least.min(solved - random);
        }
        assert!(least > 5.0, "{least}");
    }
}
