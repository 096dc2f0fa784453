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

use std::cell::OnceCell;
use std::f64::consts::PI;

use crate::episodes::Dynamics;
use crate::methods::{ars, ppo, sac, td3, trpo};
use crate::mujoco::{self, Simulation};
use crate::task::scenario::scenario;
use crate::task::{ContextFeature, Task, grid};
use evaluation::family::PointMdp;
use evaluation::run::domain::Objective;
use evaluation::run::fault::Cause;
use evaluation::settings::setting::settings;
use evaluation::stats::{Direction, Side};
use learners::rl::environment::Actions;
use learners::rl::random::Generator;

/// Steps of the model per action, and what they take, s.
const STEPS: u32 = 5;
const STEP_S: f64 = 0.05;

/// Mass of the whole cheetah, kg.
const MASS_KG: f64 = 14.0;

/// Radius of all capsules, m.
const RADIUS_M: f64 = 0.046;

/// Half the length of the capsules of torso and head without their caps, m.
const TORSO_M: [f64; 2] = [0.5, 0.15];

/// Friction of contacts, and Brax's friction and mass of the torso (kg) that belong to gymnasium's cheetah.
const FRICTION: f64 = 0.4;
const BRAX_FRICTION: f64 = 0.6;
const BRAX_TORSO_KG: f64 = 9.457333;

/// Amount and deviation of the noise on positions and velocities where an episode starts.
const START: f64 = 0.1;

/// A part of a leg. Places are x and z from the joint above, m; angles are about y, rad.
struct Link {
    name: &'static str,
    place: [f64; 2],
    range: [f64; 2],
    stiffness: f64,
    damping: f64,
    torque_nm: f64,
    middle: [f64; 2],
    angle: f64,
    half_m: f64,
}

/// The hind leg and the front leg, from thigh to foot.
#[rustfmt::skip]
const LEGS: [[Link; 3]; 2] = [
    [
        Link { name: "bthigh", place: [-0.5, 0.0], range: [-0.52, 1.05], stiffness: 240.0, damping: 6.0,
               torque_nm: 120.0, middle: [0.1, -0.13], angle: -3.8, half_m: 0.145 },
        Link { name: "bshin", place: [0.16, -0.25], range: [-0.785, 0.785], stiffness: 180.0, damping: 4.5,
               torque_nm: 90.0, middle: [-0.14, -0.07], angle: -2.03, half_m: 0.15 },
        Link { name: "bfoot", place: [-0.28, -0.14], range: [-0.4, 0.785], stiffness: 120.0, damping: 3.0,
               torque_nm: 60.0, middle: [0.03, -0.097], angle: -0.27, half_m: 0.094 },
    ],
    [
        Link { name: "fthigh", place: [0.5, 0.0], range: [-1.0, 0.7], stiffness: 180.0, damping: 4.5,
               torque_nm: 120.0, middle: [-0.07, -0.12], angle: 0.52, half_m: 0.133 },
        Link { name: "fshin", place: [-0.14, -0.24], range: [-1.2, 0.87], stiffness: 120.0, damping: 3.0,
               torque_nm: 60.0, middle: [0.065, -0.09], angle: -0.6, half_m: 0.106 },
        Link { name: "ffoot", place: [0.13, -0.18], range: [-0.5, 0.5], stiffness: 60.0, damping: 1.5,
               torque_nm: 30.0, middle: [0.045, -0.07], angle: -0.6, half_m: 0.07 },
    ],
];

/// A cheetah.
#[derive(Debug, Clone)]
pub struct HalfCheetah {
    /// Gravity, m/s².
    pub gravity_mps2: f64,
    /// Mass of Brax's torso, kg.
    pub torso_mass_kg: f64,
    /// Brax's friction.
    pub friction: f64,
    /// What a unit of squared torque costs.
    pub control_cost: f64,
    /// Made when it is needed: most of what asks about a cheetah does not need MuJoCo.
    simulation: OnceCell<Simulation<27>>,
}

/// Positions along x and z, pitch and angles of the six joints; their velocities; and where the solver starts.
pub type State = [f64; 27];

/// Returns the volume of a capsule, m³.
fn volume(half_m: f64) -> f64 {
    PI * RADIUS_M * RADIUS_M * (2.0 * half_m + 4.0 / 3.0 * RADIUS_M)
}

/// Returns the MJCF of the rest of a leg.
fn leg(links: &[Link]) -> String {
    let [link, rest @ ..] = links else { return String::new() };
    let Link { name, place: [x, z], range: [low, high], stiffness, damping, .. } = link;
    let Link { middle: [mx, mz], angle, half_m, .. } = link;
    let rest = leg(rest);
    format!(
        r#"<body pos="{x} 0 {z}">
<joint name="{name}" axis="0 1 0" range="{low} {high}" stiffness="{stiffness}" damping="{damping}" armature="0.1"
  limited="true" solreflimit="0.02 1" solimplimit="0 0.8 0.03"/>
<geom type="capsule" size="{RADIUS_M} {half_m}" pos="{mx} 0 {mz}" axisangle="0 1 0 {angle}"/>
{rest}</body>
"#
    )
}

impl HalfCheetah {
    /// Returns a cheetah; gravity in m/s², Brax's mass of the torso in kg, Brax's friction, and what a unit of squared
    /// torque costs.
    pub fn new(gravity_mps2: f64, torso_mass_kg: f64, friction: f64, control_cost: f64) -> Self {
        let simulation = OnceCell::new();
        Self { gravity_mps2, torso_mass_kg, friction, control_cost, simulation }
    }

    /// How heavy the torso is, as a share of gymnasium's.
    fn share(&self) -> f64 {
        self.torso_mass_kg / BRAX_TORSO_KG
    }

    /// Returns the model in MJCF. Masses are right up to a factor, see [`Self::mass_kg`].
    pub fn mjcf(&self) -> String {
        let friction = FRICTION * (self.friction / BRAX_FRICTION).powi(2);
        let density = 1000.0 * self.share();
        let [body, head] = TORSO_M;
        let [hind, front] = LEGS.each_ref().map(|links| leg(links));
        let motor = |link: &Link| {
            let Link { name, torque_nm, .. } = link;
            format!(
                r#"<motor joint="{name}" gear="{torque_nm}" ctrllimited="true" ctrlrange="-1 1"/>"#
            )
        };
        let motors: String = LEGS.as_flattened().iter().map(motor).collect();
        format!(
            r#"<mujoco>
<compiler angle="radian" inertiafromgeom="true"/>
<option timestep="0.01" gravity="0 0 -{gravity}"/>
<default>
<geom contype="1" conaffinity="0" condim="3" friction="{friction} 0.1 0.1" solref="0.02 1" solimp="0 0.8 0.01"/>
</default>
<worldbody>
<geom type="plane" size="40 40 40" conaffinity="1"/>
<body pos="0 0 0.7">
<joint type="slide" axis="1 0 0"/>
<joint type="slide" axis="0 0 1"/>
<joint type="hinge" axis="0 1 0"/>
<geom type="capsule" density="{density}" size="{RADIUS_M}" fromto="-{body} 0 0 {body} 0 0"/>
<geom type="capsule" density="{density}" size="{RADIUS_M} {head}" pos="0.6 0 0.1" axisangle="0 1 0 0.87"/>
{hind}{front}</body>
</worldbody>
<actuator>{motors}</actuator>
</mujoco>"#,
            gravity = self.gravity_mps2,
        )
    }

    /// Returns the mass of the whole cheetah, kg: gymnasium's, but for the torso.
    pub fn mass_kg(&self) -> f64 {
        let torso: f64 = TORSO_M.into_iter().map(volume).sum();
        let legs: f64 = LEGS.as_flattened().iter().map(|link| volume(link.half_m)).sum();
        MASS_KG * (1.0 + (self.share() - 1.0) * (torso / (torso + legs)))
    }

    fn simulation(&self) -> &Simulation<27> {
        self.simulation.get_or_init(|| {
            Simulation::new(&self.mjcf(), 6, Some(self.mass_kg()))
                .expect("the library is there, which a trial checks first, and the model is ours")
        })
    }

    /// Returns the state of positions and velocities; the rest of what is given does not count.
    pub fn begin(&self, state: State) -> State {
        self.simulation().begin(state)
    }
}

impl Dynamics for HalfCheetah {
    const LABEL: &'static str = "half-cheetah";
    const HORIZON: u32 = 1000;
    const WIDTH: usize = 17;
    type State = State;

    fn actions(&self) -> Actions {
        Actions::Continuous { count: 6, limit: 1.0 }
    }

    fn start(&self, generator: &mut Generator) -> State {
        let mut state = State::default();
        state[..9].fill_with(|| START * (2.0 * generator.unit() - 1.0));
        state[9..18].fill_with(|| START * generator.normal());
        self.begin(state)
    }

    fn observe(&self, state: &State, observation: &mut [f32]) {
        observation.iter_mut().zip(&state[1..18]).for_each(|(o, s)| *o = *s as f32);
    }

    fn act(&self, state: &mut State, action: &[f32]) -> (f64, bool) {
        let before = state[0];
        let mut control = [0.0; 6];
        control.iter_mut().zip(action).for_each(|(c, a)| *c = f64::from(*a));
        self.simulation().step(state, &control, STEPS);
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
    task: HalfCheetahs,
    environment: Environment,
    methods: { ppo, sac, td3, trpo, ars }
}

/// Half cheetahs.
#[derive(Debug, Clone, Copy, Default)]
pub struct HalfCheetahs;

impl Task for HalfCheetahs {
    const NAME: &'static str = "half-cheetah";
    const WHAT: &'static str = "a half cheetah";
    const SIMULATOR: &'static str = "MuJoCo";
    const FEATURES: &'static [ContextFeature] = &[
        ContextFeature { name: "gravity_mps2", unit: "m/s²", default: 9.81, short: "g" },
        ContextFeature { name: "torso_mass_kg", unit: "kg", default: BRAX_TORSO_KG, short: "m" },
        ContextFeature { name: "friction", unit: "", default: BRAX_FRICTION, short: "f" },
    ];
    const OBJECTIVE: Objective =
        Objective { metric: "return", title: "return", unit: "", direction: Direction::Higher };
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

    fn check(_: &Scenario, context: &[f64]) -> Result<(), (usize, String)> {
        // Beyond these MuJoCo's steps of 0.01 s are too long, or nothing holds the cheetah together.
        let most = [100.0, 1000.0, 10.0];
        match context.iter().zip(most).position(|(value, most)| *value > most) {
            Some(place) => Err((place, format!("give {} or less", most[place]))),
            None => Ok(()),
        }
    }

    fn dynamics(scenario: &Scenario, context: &[f64]) -> HalfCheetah {
        let &[gravity_mps2, torso_mass_kg, friction] = context else {
            unreachable!("a context has all features");
        };
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
        let mass = |torso| HalfCheetah::new(9.81, torso, 0.6, 0.1).mass_kg();
        assert_eq!(mass(BRAX_TORSO_KG), 14.0);
        // Gymnasium's torso has 6.250209 kg.
        assert!((mass(2.0 * BRAX_TORSO_KG) - 20.250209).abs() < 1e-6);
    }

    #[test]
    fn what_would_fly_apart_is_refused() {
        let e = HalfCheetahs::check(&Scenario::default(), &[9.8, 9.5, 11.0]).unwrap_err();
        assert_eq!(e, (2, "give 10 or less".to_owned()));
    }
}
