//! A cheetah of two legs in a plane, which runs: gymnasium's `HalfCheetah-v5` in the paper's family of 120.
//!
//! Sizes, joints, motors, reward and start are gymnasium's (1.4.0, `envs/mujoco/half_cheetah_v5.py` and its model), and MuJoCo
//! computes them. The family is that of Jayawardana et al. (NeurIPS 2022), appendix: gravity, mass of the torso, and friction, as
//! CARL sets them.
//!
//! Deviation: CARL's half cheetah runs in Brax, and is another one: 21.2 kg in all instead of 14 kg, other joints, friction of a
//! contact squared. So two features are translated, such that CARL's default is gymnasium's cheetah:
//! - `torso_mass_kg` is the mass of Brax's torso, 9.457333 kg by default. The torso here has the same share of its own default,
//!   6.25 kg, and its inertia goes with its mass; CARL leaves the inertia as it was.
//! - `friction` is Brax's, 0.6 by default. The friction of contacts here is 0.4 times the square of its share of that.
//!
//! Deviation: the score is the return. There is no policy that is known to solve every point MDP, which a normalisation needs.

use std::f64::consts::PI;

use crate::episodes::Dynamics;
use crate::methods::{ars, ppo, sac, td3, trpo};
use crate::mujoco::{self, Lazy};
use crate::task::{
    ABOVE_0, Actions, Cause, ContextFeature, Generator, Objective, PointMdp, RETURN, Side, Task,
    all, feature, grid, scenario, settings,
};

/// Steps of the model per action, and what they take, s.
const STEPS: u32 = 5;
const STEP_S: f64 = 0.05;

/// Mass of the whole cheetah, kg.
const MASS_KG: f64 = 14.0;

const RADIUS_M: f64 = 0.046;

/// Half the lengths of the capsules without their caps, of torso and head and of the links of the hind and the front leg, m.
const TORSO_M: [f64; 2] = [0.5, 0.15];
const LEGS_M: [f64; 6] = [0.145, 0.15, 0.094, 0.133, 0.106, 0.07];

/// The model in MJCF, but for gravity, friction and the density of the torso. Masses are right up to a factor, see
/// [`HalfCheetah::mass_kg`].
const MODEL: &str = include_str!("../models/half-cheetah.xml");

/// Friction of contacts, and Brax's friction and mass of the torso (kg) that belong to gymnasium's cheetah.
const FRICTION: f64 = 0.4;
const BRAX_FRICTION: f64 = 0.6;
const BRAX_TORSO_KG: f64 = 9.457333;

/// Amount and deviation of the noise on positions and velocities where an episode starts.
const START: f64 = 0.1;

/// A cheetah.
#[derive(Debug, Clone)]
pub struct HalfCheetah {
    /// What a unit of squared torque costs.
    pub control_cost: f64,
    model: Lazy<27>,
}

/// Positions along x and z, pitch and angles of the six joints; their velocities; and where the solver starts.
pub type State = [f64; 27];

fn volume(half_m: f64) -> f64 {
    PI * RADIUS_M * RADIUS_M * (2.0 * half_m + 4.0 / 3.0 * RADIUS_M)
}

impl HalfCheetah {
    /// Returns a cheetah; gravity in m/s², Brax's mass of the torso in kg, Brax's friction, and what a unit of squared
    /// torque costs.
    pub fn new(gravity_mps2: f64, torso_mass_kg: f64, friction: f64, control_cost: f64) -> Self {
        let friction = FRICTION * (friction / BRAX_FRICTION).powi(2);
        let density = 1000.0 * (torso_mass_kg / BRAX_TORSO_KG);
        let mjcf = MODEL
            .replace("GRAVITY", &gravity_mps2.to_string())
            .replace("FRICTION", &friction.to_string())
            .replace("DENSITY", &density.to_string());
        Self { control_cost, model: Lazy::new(mjcf, 6, Some(Self::mass_kg(torso_mass_kg))) }
    }

    /// Returns the mass of the whole cheetah, kg: gymnasium's, but for the torso.
    fn mass_kg(torso_mass_kg: f64) -> f64 {
        let torso: f64 = TORSO_M.into_iter().map(volume).sum();
        let legs: f64 = LEGS_M.into_iter().map(volume).sum();
        MASS_KG * (1.0 + (torso_mass_kg / BRAX_TORSO_KG - 1.0) * (torso / (torso + legs)))
    }

    /// Returns the state of positions and velocities; the rest of what is given does not count.
    pub fn begin(&self, state: State) -> State {
        self.model.begin(state)
    }
}

impl Dynamics for HalfCheetah {
    const LABEL: &'static str = "half-cheetah";
    const HORIZON: u32 = 1000;
    const WIDTH: usize = 17;
    type State = State;
    const FIRST_SEEN: usize = 1;

    fn actions(&self) -> Actions {
        Actions::Continuous { count: 6, limit: 1.0 }
    }

    fn start(&self, generator: &mut Generator) -> State {
        let mut state = State::default();
        state[..9].fill_with(|| START * (2.0 * generator.unit() - 1.0));
        state[9..18].fill_with(|| START * generator.normal());
        self.begin(state)
    }

    fn act(&self, state: &mut State, action: &[f32]) -> (f64, bool) {
        let before = state[0];
        let control: [f64; 6] = std::array::from_fn(|i| f64::from(action[i]));
        self.model.step(state, &control, STEPS);
        let cost: f64 = control.iter().map(|c| c * c).sum();
        ((state[0] - before) / STEP_S - self.control_cost * cost, false)
    }
}

settings! {
    /// Where methods act.
    pub struct Environment, source "gymnasium 1.4.0, HalfCheetah-v5" {
        /// What a unit of squared torque costs, where every motor's largest torque is 1.
        control_cost: f64 = 0.1, in 0.0..=1e3;
    }
}

scenario! {
    /// Half cheetahs.
    task: HalfCheetahs,
    environment: Environment,
    methods: { ppo, sac, td3, trpo, ars }
}

impl Task for HalfCheetahs {
    const NAME: &'static str = "half-cheetah";
    const WHAT: &'static str = "a half cheetah";
    const SIMULATOR: &'static str = "MuJoCo";
    // Beyond these MuJoCo's steps of 0.01 s are too long, or nothing holds the cheetah together.
    const FEATURES: &'static [ContextFeature] = &[
        feature("gravity_mps2", "m/s²", 9.81, "g", [ABOVE_0, 100.0]),
        feature("torso_mass_kg", "kg", BRAX_TORSO_KG, "m", [ABOVE_0, 1000.0]),
        feature("friction", "", BRAX_FRICTION, "f", [ABOVE_0, 10.0]),
    ];
    const OBJECTIVE: Objective = RETURN;
    // Less than 1 m/s on average.
    const FAILURE: (Side, f64) = (Side::Below, 1000.0);
    const STEP_S: f64 = 1.5e-5;
    const EMBEDDED: &'static str = include_str!("../../../scenarios/half-cheetah.toml");
    const TUNED: &'static str = include_str!("../../../scenarios/presets/half-cheetah-tuned.toml");
    type Scenario = Scenario;
    type Dynamics = HalfCheetah;

    fn simulator() -> Result<String, Cause> {
        Ok(format!("{} {}", Self::SIMULATOR, mujoco::version()?.0))
    }

    fn points() -> Vec<PointMdp> {
        let values: [&[f64]; 3] = [
            &[2.0, 5.0, 9.8, 12.0, 15.0],
            &[0.5, 2.0, 5.0, 9.457, 12.0, 15.0],
            &[0.1, 0.3, 0.6, 1.0],
        ];
        grid(Self::FEATURES, &values, |c| {
            format!("gravity {} m/s², torso {} kg, friction {}", c[0], c[1], c[2])
        })
    }

    fn dynamics(scenario: &Scenario, context: &[f64]) -> HalfCheetah {
        let [gravity_mps2, torso_mass_kg, friction] = all(context);
        let Environment { control_cost } = scenario.environment;
        HalfCheetah::new(gravity_mps2, torso_mass_kg, friction, control_cost)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::task::testing::{check_episodes, check_family, check_features};

    #[test]
    fn it_is_a_task() {
        check_family::<HalfCheetahs>(120);
        if let Err(e) = mujoco::version() {
            eprintln!("skipped: {e}");
            return;
        }
        check_episodes::<HalfCheetahs>();
        check_features::<HalfCheetahs>(&Scenario::default());
    }

    #[test]
    fn a_torso_of_another_mass_leaves_the_legs_as_they_are() {
        let mass = HalfCheetah::mass_kg;
        assert_eq!(mass(BRAX_TORSO_KG), 14.0);
        // Gymnasium's torso has 6.250209 kg.
        assert!((mass(2.0 * BRAX_TORSO_KG) - 20.250209).abs() < 1e-6);
    }
}
