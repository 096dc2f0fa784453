//! A hanging pendulum that is to be swung up, judged by the time that takes: the five point MDPs of the paper's first study.
//!
//! The dynamics are those of Inala et al. (ICLR 2020; github.com/jinala/RLBench, `pendulum/pendulum_train.py`), which are
//! gymnasium's with two differences: the cost has no term of velocity, and the angle moves by the velocity before it is cut.
//! An episode ends when the pendulum stands upright or passes the top slowly enough to be seen near it on both sides. The five
//! pairs of mass and length are those of Jayawardana et al. (NeurIPS 2022), which mark one as generic and one as simplified.
//! Observations are gymnasium's.
//! Deviation: the largest torque is 20 N m. The paper does not state its own. With gymnasium's 2 N m even a pendulum of
//! 1.5 kg and 4 m takes more than 500 of the 200 steps there are, but the paper reports that four of five were solved. Any
//! limit from 14 to 45 N m makes the first four solvable and the fifth not. `environment.max_torque_nm = 2` is gymnasium's.

use std::f64::consts::PI;

use crate::episodes::Dynamics;
use crate::methods::{ppo, td3, trpo};
use crate::pendulum::wrap;
use crate::task::{
    Actions, ContextFeature, Direction, Generator, Objective, POSITIVE, PointMdp, Side, Task, all,
    feature, point, scenario, settings,
};

const STEP_S: f64 = 0.05;

const GRAVITY_MPS2: f64 = 10.0;

/// Largest angular velocity, rad/s.
const MAX_SPEED: f64 = 8.0;

/// Angle and angular velocity that an episode starts within, around hanging.
const START: f64 = 0.04;

/// Angle from upright within which the pendulum stands, and within which it may pass the top, rad.
const UPRIGHT: f64 = 0.05;
const PASSING: f64 = 0.2;

/// A pendulum, a uniform rod.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SwingUp {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Length, m.
    pub length_m: f64,
    /// Largest torque, N m.
    pub max_torque_nm: f64,
}

/// Angle from upright (rad) and angular velocity (rad/s).
pub type State = [f64; 2];

impl Dynamics for SwingUp {
    const LABEL: &'static str = "pendulum-swing-up";
    const HORIZON: u32 = 200;
    const WIDTH: usize = 3;
    type State = State;

    fn actions(&self) -> Actions {
        Actions::Continuous { count: 1, limit: self.max_torque_nm as f32 }
    }

    fn start(&self, generator: &mut Generator) -> State {
        [PI, 0.0].map(|middle| middle + START * (2.0 * generator.unit() - 1.0))
    }

    fn observe(&self, [angle, velocity]: &State, observation: &mut [f32]) {
        let numbers = [libm::cos(*angle), libm::sin(*angle), *velocity];
        observation.iter_mut().zip(numbers).for_each(|(o, n)| *o = n as f32);
    }

    fn act(&self, state: &mut State, action: &[f32]) -> (f64, bool) {
        let ([angle, velocity], m, l) = (*state, self.mass_kg, self.length_m);
        let u = f64::from(action[0]).clamp(-self.max_torque_nm, self.max_torque_nm);
        let before = wrap(angle);
        let acceleration =
            3.0 * GRAVITY_MPS2 / (2.0 * l) * libm::sin(angle) + 3.0 / (m * (l * l)) * u;
        let velocity = velocity + acceleration * STEP_S;
        *state = [angle + velocity * STEP_S, velocity.clamp(-MAX_SPEED, MAX_SPEED)];
        let after = wrap(state[0]);
        let passed = before.abs() < PASSING && before * after <= 0.0;
        (-(before * before + 0.001 * (u * u)), after.abs() < UPRIGHT || passed)
    }

    fn score(&self, _: &State, _: f64, steps: u32) -> f64 {
        f64::from(steps)
    }
}

settings! {
    /// Where methods act.
    pub struct Environment, source "our choice, as the paper gives none" {
        /// Largest torque; gymnasium's is 2 N m, with which most of the five cannot be swung up in time.
        max_torque_nm: f64 = 20.0, in 1e-3..=1e4, unit "N m";
    }
}

scenario! {
    /// Hanging pendulums.
    task: SwingUps,
    environment: Environment,
    methods: { ppo, trpo, td3 }
}

impl Task for SwingUps {
    const NAME: &'static str = "pendulum-swing-up";
    const WHAT: &'static str = "a hanging pendulum";
    const SIMULATOR: &'static str = "Pendulum with the equations of Inala et al., 2020";
    const FEATURES: &'static [ContextFeature] = &[
        feature("mass_kg", "kg", 1.0, "m", POSITIVE),
        feature("length_m", "m", 1.0, "l", POSITIVE),
    ];
    const OBJECTIVE: Objective =
        Objective::new("steps_to_upright", "steps to upright", "steps", Direction::Lower);
    // Not upright within the 200 steps of an episode, in nearly all of them.
    const FAILURE: (Side, f64) = (Side::Above, 199.0);
    const STEP_S: f64 = 5e-7;
    const EMBEDDED: &'static str = include_str!("../../../scenarios/pendulum-swing-up.toml");
    const TUNED: &'static str = include_str!("../../../scenarios/presets/pendulum-tuned.toml");
    type Scenario = Scenario;
    type Dynamics = SwingUp;

    fn points() -> Vec<PointMdp> {
        let five = [
            ([1.0, 1.0], ", simplified"),
            ([1.5, 4.0], ""),
            ([1.875, 5.25], ", generic"),
            ([2.0, 6.0], ""),
            ([3.0, 10.0], ""),
        ];
        five.map(|(context, mark)| {
            let title = format!("{} kg, {} m{mark}", context[0], context[1]);
            point(Self::FEATURES, &context, title, 0.2)
        })
        .into()
    }

    fn dynamics(scenario: &Scenario, context: &[f64]) -> SwingUp {
        let [mass_kg, length_m] = all(context);
        SwingUp { mass_kg, length_m, max_torque_nm: scenario.environment.max_torque_nm }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::episodes::Episodes;
    use crate::task::scenario::Settings as _;
    use crate::task::testing::{check_episodes, check_family, check_features};
    use learners::rl::environment::play;

    #[test]
    fn it_is_a_task() {
        check_family::<SwingUps>(5);
        check_episodes::<SwingUps>();
        check_features::<SwingUps>(&Scenario::default());
    }

    /// Steps of a pump, a torque in the direction of the velocity, for each of the five.
    fn pumped(torque: &str) -> Vec<u32> {
        let setting = format!("environment.max_torque_nm={torque}").parse().unwrap();
        let scenario = Scenario::read("", "pendulum-swing-up", &[setting]);
        // The name of a file says nothing here.
        let scenario = scenario.unwrap();
        let steps = SwingUps::points().into_iter().map(|point| {
            let mut environment = Episodes::of(SwingUps::dynamics(&scenario, &point.features));
            let mut pump = |o: &[f32], a: &mut [f32]| a[0] = 100.0f32.copysign(o[2]);
            play(&mut environment, 1, &mut pump).steps
        });
        steps.collect()
    }

    #[test]
    fn four_of_five_can_be_swung_up_with_the_default_torque_and_one_with_gymnasium_s() {
        let ours = pumped("20");
        assert!(ours[..4].iter().all(|steps| *steps < 200) && ours[4] == 200, "{ours:?}");
        let gymnasium = pumped("2");
        assert!(
            gymnasium[0] < 100 && gymnasium[1..].iter().all(|steps| *steps == 200),
            "{gymnasium:?}"
        );
    }

    #[test]
    fn an_episode_ends_upright_or_when_it_passes_the_top() {
        let pendulum = SwingUp { mass_kg: 1.0, length_m: 1.0, max_torque_nm: 20.0 };
        let over = |angle: f64, velocity: f64| pendulum.act(&mut [angle, velocity], &[0.0]).1;
        assert!(over(0.04, 0.0) && over(0.15, -6.0) && !over(0.25, -8.0) && !over(0.15, 0.0));
        // Two turns away is upright too.
        assert!(over(4.0 * PI + 0.01, 0.0));
    }
}
