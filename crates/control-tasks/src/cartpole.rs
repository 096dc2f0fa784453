//! A pole on a cart, which falls unless the cart is pushed well: CARL's family of 576.
//!
//! The family is that of Jayawardana et al. (NeurIPS 2022), appendix; the values are multiples 0.1 to 10 of gymnasium's
//! constants, as CARL's bounds allow. gymnasium's own force of 10 N is not among them.
//! A reward of 1 for every step, the last one too. An episode ends with the fall, or is cut after 500 steps, so that 500 is
//! the best return. Equations, constants and the order of the arithmetic are those of gymnasium's `CartPole-v1` (1.4.0,
//! `envs/classic_control/cartpole.py`; Barto, Sutton and Anderson, 1983): explicit Euler, in which positions move by the old
//! velocities; `tests/control_tasks/cartpole.rs` compares step by step. Sine and cosine are those of the crate `libm`, so that
//! every machine computes the same bytes.

use serde::{Deserialize, Serialize};

use crate::episodes::{self, Episodes};
use crate::methods::{ars, dqn, ppo, trpo};
use crate::task::{
    Actions, ContextFeature, Generator, NORMALISED_RETURN, Objective, POSITIVE, PointMdp, Scale,
    Side, Task, all, feature, grid, scenario, settings,
};

/// Name of the family, and of the domain.
pub const NAME: &str = "cartpole";

/// Where gymnasium's episodes start: all four numbers uniform within this of 0.
pub const GYMNASIUM_START: f64 = 0.05;

/// Where CARL's episodes start, since 2022-06.
pub const CARL_START: f64 = 0.1;

const STEP_S: f64 = 0.02;

/// Mass of cart and pole that CARL's environment keeps whatever its context, kg.
const TOTAL_MASS_KG: f64 = 1.1;

/// Mass of the pole times half its length that CARL's environment keeps whatever its context, kg m.
const POLE_MOMENT_KG_M: f64 = 0.05;

/// Largest distance of the cart from the middle, m.
const POSITION_LIMIT_M: f64 = 2.4;

/// Largest angle of the pole from upright: 12 degrees in radians, as gymnasium rounds it.
const ANGLE_LIMIT: f64 = 12.0 * 2.0 * std::f64::consts::PI / 360.0;

/// Position (m) and velocity (m/s) of the cart, angle from upright (rad) and its velocity (rad/s).
pub type State = [f64; 4];

/// What one cart and pole differ in from another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Context {
    /// Half the length of the pole, m.
    pub length_m: f64,
    /// Mass of the cart, kg.
    pub masscart_kg: f64,
    /// Mass of the pole, kg.
    pub masspole_kg: f64,
    /// Size of a push, N.
    pub force_n: f64,
    /// Gravity, m/s².
    pub gravity_mps2: f64,
}

impl Default for Context {
    fn default() -> Self {
        Self { length_m: 0.5, masscart_kg: 1.0, masspole_kg: 0.1, force_n: 10.0, gravity_mps2: 9.8 }
    }
}

/// Where a context acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Variant {
    /// As in CARL (0.2.0 and later), which sets attributes of gymnasium's environment after it has
    /// computed the total mass (1.1 kg) and the pole's mass times half its length (0.05 kg m). So
    /// the mass of the cart has no effect, and the mass of the pole and its length have one only
    /// where they enter the pole's inertia. What is published of CARL's family was computed like this.
    #[default]
    CarlCompat,
    /// Everywhere that physics has it.
    Physical,
}

/// A cart and its pole, and where episodes start, which is CARL's unless it is set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dynamics {
    length_m: f64,
    masspole_kg: f64,
    force_n: f64,
    gravity_mps2: f64,
    total_mass_kg: f64,
    pole_moment_kg_m: f64,
    start: f64,
}

impl Dynamics {
    /// Returns the cart and pole of a context.
    pub fn new(context: Context, variant: Variant) -> Self {
        let Context { length_m, masscart_kg, masspole_kg, force_n, gravity_mps2 } = context;
        let (total_mass_kg, pole_moment_kg_m) = match variant {
            Variant::CarlCompat => (TOTAL_MASS_KG, POLE_MOMENT_KG_M),
            Variant::Physical => (masspole_kg + masscart_kg, masspole_kg * length_m),
        };
        let start = CARL_START;
        Self {
            length_m,
            masspole_kg,
            force_n,
            gravity_mps2,
            total_mass_kg,
            pole_moment_kg_m,
            start,
        }
    }

    /// Returns the state after a push to the right or to the left.
    pub fn step(&self, [x, x_velocity, angle, angle_velocity]: State, right: bool) -> State {
        let force = if right { self.force_n } else { -self.force_n };
        let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
        let (mass, moment) = (self.total_mass_kg, self.pole_moment_kg_m);
        let push = (force + moment * (angle_velocity * angle_velocity) * sine) / mass;
        let inertia = self.length_m * (4.0 / 3.0 - self.masspole_kg * (cosine * cosine) / mass);
        let angle_acceleration = (self.gravity_mps2 * sine - cosine * push) / inertia;
        let x_acceleration = push - moment * angle_acceleration * cosine / mass;
        [
            x + STEP_S * x_velocity,
            x_velocity + STEP_S * x_acceleration,
            angle + STEP_S * angle_velocity,
            angle_velocity + STEP_S * angle_acceleration,
        ]
    }
}

/// Whether the pole has fallen or the cart has left; what is no number has.
pub fn fell(state: &State) -> bool {
    !(state[0].abs() <= POSITION_LIMIT_M && state[2].abs() <= ANGLE_LIMIT)
}

/// Episodes of a cart and its pole.
pub type CartPole = Episodes<Dynamics>;

impl CartPole {
    /// Returns an environment whose episodes start within `start` of 0.
    pub fn new(dynamics: Dynamics, start: f64) -> Self {
        Self::of(Dynamics { start, ..dynamics })
    }
}

impl episodes::Dynamics for Dynamics {
    const LABEL: &'static str = NAME;
    const HORIZON: u32 = 500;
    const WIDTH: usize = 4;
    type State = State;

    fn actions(&self) -> Actions {
        Actions::Numbered(2)
    }

    fn start(&self, generator: &mut Generator) -> State {
        std::array::from_fn(|_| self.start * (2.0 * generator.unit() - 1.0))
    }

    fn act(&self, state: &mut State, action: &[f32]) -> (f64, bool) {
        *state = self.step(*state, action[0] == 1.0);
        (1.0, fell(state))
    }
}

settings! {
    /// Where methods act.
    pub struct Environment, source "CARL 0.2.0 and later" {
        /// Which features act: with `carl-compat`, as in CARL, the mass of the cart has no effect, and mass and length
        /// of the pole act in its inertia only; with `physical` all features act.
        dynamics: Variant = Variant::CarlCompat;
        /// Start of episodes: position, velocity, angle (rad) and angular velocity are uniform within this of 0.
        /// Gymnasium has 0.05.
        start: f64 = CARL_START, in 0.0..=0.2;
    }
}

scenario! {
    /// Carts and poles.
    task: CartPoles,
    environment: Environment,
    methods: { ppo, dqn, trpo, ars }
}

impl Task for CartPoles {
    const NAME: &'static str = NAME;
    const WHAT: &'static str = "a cart and pole";
    const SIMULATOR: &'static str = "CartPole with the equations of gymnasium 1.4.0";
    const FEATURES: &'static [ContextFeature] = &[
        feature("length_m", "m", 0.5, "l", POSITIVE),
        feature("masscart_kg", "kg", 1.0, "c", POSITIVE),
        feature("masspole_kg", "kg", 0.1, "p", POSITIVE),
        feature("force_n", "N", 10.0, "f", POSITIVE),
        feature("gravity_mps2", "m/s²", 9.8, "g", POSITIVE),
    ];
    const OBJECTIVE: Objective = Objective { most: Some(1.0), ..NORMALISED_RETURN };
    // The pole falls within 25 of 500 steps.
    const FAILURE: (Side, f64) = (Side::Below, 0.05);
    // Measured, see `benches/README.md`.
    const STEP_S: f64 = 5e-7;
    const LATER: &'static [&'static str] = &["trpo", "ars"];
    const EMBEDDED: &'static str = include_str!("../../../scenarios/cartpole.toml");
    const TUNED: &'static str = include_str!("../../../scenarios/presets/cartpole-tuned.toml");
    type Scenario = Scenario;
    type Dynamics = Dynamics;

    fn points() -> Vec<PointMdp> {
        let values: [&[f64]; 5] = [
            &[0.05, 0.5, 3.0, 5.0],
            &[0.1, 1.0, 6.0, 10.0],
            &[0.01, 0.1, 0.5, 1.0],
            &[1.0, 50.0, 100.0],
            &[0.1, 9.8, 19.6],
        ];
        grid(Self::FEATURES, &values, |c| {
            let (length, cart, pole, force, gravity) = (c[0], c[1], c[2], c[3], c[4]);
            format!(
                "half-length {length} m, pole {pole} kg, cart {cart} kg, push {force} N, gravity {gravity} m/s²"
            )
        })
    }

    fn check(scenario: &Scenario, context: &[f64]) -> Result<(), (usize, String)> {
        // From this mass on the pole has no inertia or a negative one, so that gravity holds it up.
        let heaviest_kg = TOTAL_MASS_KG * 4.0 / 3.0;
        let is_carl = scenario.environment.dynamics == Variant::CarlCompat;
        if is_carl && context[2] >= heaviest_kg {
            return Err((
                2,
                format!(
                    "from {heaviest_kg:.3} kg on the inertia of carl-compat is not above 0; take environment.dynamics = \
                 \"physical\""
                ),
            ));
        }
        Ok(())
    }

    fn without_effect(scenario: &Scenario) -> &'static [&'static str] {
        match scenario.environment.dynamics {
            Variant::CarlCompat => &["masscart_kg"],
            Variant::Physical => &[],
        }
    }

    fn dynamics(scenario: &Scenario, context: &[f64]) -> Dynamics {
        let [length_m, masscart_kg, masspole_kg, force_n, gravity_mps2] = all(context);
        let context = Context { length_m, masscart_kg, masspole_kg, force_n, gravity_mps2 };
        let Environment { dynamics, start } = scenario.environment;
        Dynamics { start, ..Dynamics::new(context, dynamics) }
    }

    fn scale(_: &CartPole) -> Scale {
        Scale { zero: 0.0, one: 500.0, names: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::task::testing::{check_episodes, check_family, check_features};
    use learners::rl::environment::{Environment as _, play};

    const STATE: State = [0.1, -0.2, 0.05, 0.3];

    fn after(context: Context, variant: Variant) -> State {
        Dynamics::new(context, variant).step(STATE, true)
    }

    #[test]
    fn both_variants_agree_on_gymnasium_s_own_context() {
        let [carl, physical] =
            [Variant::CarlCompat, Variant::Physical].map(|v| after(Context::default(), v));
        carl.iter().zip(physical).for_each(|(a, b)| assert!((a - b).abs() < 1e-15));
    }

    #[test]
    fn a_fall_is_beyond_either_limit_or_no_number() {
        assert!(!fell(&[-2.4, 1e9, ANGLE_LIMIT, -1e9]));
        assert!(fell(&[2.41, 0.0, 0.0, 0.0]) && fell(&[0.0, 0.0, -0.21, 0.0]));
        assert!(fell(&[f64::NAN, 0.0, 0.0, 0.0]) && fell(&[0.0, 0.0, f64::NAN, 0.0]));
    }

    fn cart_pole() -> CartPole {
        CartPole::new(Dynamics::new(Context::default(), Variant::Physical), CARL_START)
    }

    #[test]
    fn a_balanced_pole_is_cut_at_the_horizon_and_a_pushed_one_falls() {
        let mut environment = cart_pole();
        let mut lean = |o: &[f32], a: &mut [f32]| {
            a[0] = f32::from(u8::from(0.1 * o[0] + 0.3 * o[1] + o[2] + o[3] > 0.0));
        };
        let balanced = play(&mut environment, 1, &mut lean);
        assert_eq!((balanced.steps, balanced.total), (500, 500.0));
        assert!(!fell(&environment.state));
        let pushed = play(&mut environment, 1, &mut |_, a| a[0] = 1.0);
        assert!(pushed.steps < 20 && pushed.total == f64::from(pushed.steps), "{pushed:?}");
        assert!(fell(&environment.state));
    }

    #[test]
    fn episodes_start_within_the_box_and_reach_its_corners() {
        let (mut cart_pole, mut observation) = (cart_pole(), [0.0f32; 4]);
        let mut largest = [0.0f32; 4];
        for seed in 0..200 {
            cart_pole.reset(seed, &mut observation);
            largest.iter_mut().zip(observation).for_each(|(l, o)| *l = l.max(o.abs()));
        }
        assert!(largest.iter().all(|l| (0.097..=0.1).contains(l)), "{largest:?}");
    }

    #[test]
    fn it_is_a_task() {
        check_family::<CartPoles>(576);
        check_episodes::<CartPoles>();
        check_features::<CartPoles>(&Scenario::default());
        let physical = Environment { dynamics: Variant::Physical, start: CARL_START };
        check_features::<CartPoles>(&Scenario { environment: physical, ..Scenario::default() });
    }
}
