//! What a push does to cart and pole in one step.
//!
//! Equations, constants and the order of the arithmetic are those of gymnasium's `CartPole-v1`
//! (1.4.0, `envs/classic_control/cartpole.py`; Barto, Sutton and Anderson, 1983): explicit Euler, in
//! which positions move by the old velocities. `tests/cartpole/dynamics.rs` compares step by step. Sine and
//! cosine are those of the crate `libm`, so that every machine computes the same bytes.

use serde::{Deserialize, Serialize};

/// Time of a step, s.
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
    /// Returns gymnasium's.
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

/// A cart and its pole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dynamics {
    length_m: f64,
    masspole_kg: f64,
    force_n: f64,
    gravity_mps2: f64,
    total_mass_kg: f64,
    pole_moment_kg_m: f64,
}

impl Variant {
    /// Returns the mass from which on a pole has no inertia or a negative one, so that gravity holds it up, kg;
    /// `None` where there is no such mass.
    pub fn heaviest_pole_kg(self) -> Option<f64> {
        (self == Self::CarlCompat).then_some(TOTAL_MASS_KG * 4.0 / 3.0)
    }
}

impl Dynamics {
    /// Returns the cart and pole of a context.
    pub fn new(context: Context, variant: Variant) -> Self {
        let Context { length_m, masscart_kg, masspole_kg, force_n, gravity_mps2 } = context;
        let (total_mass_kg, pole_moment_kg_m) = match variant {
            Variant::CarlCompat => (TOTAL_MASS_KG, POLE_MOMENT_KG_M),
            Variant::Physical => (masspole_kg + masscart_kg, masspole_kg * length_m),
        };
        Self { length_m, masspole_kg, force_n, gravity_mps2, total_mass_kg, pole_moment_kg_m }
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

#[cfg(test)]
mod tests {
    use super::*;

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
    fn the_mass_of_the_cart_acts_in_the_physical_variant_only() {
        let heavy = Context { masscart_kg: 10.0, ..Context::default() };
        let moved = |v| after(heavy, v) != after(Context::default(), v);
        assert!(!moved(Variant::CarlCompat) && moved(Variant::Physical));
    }

    #[test]
    fn a_fall_is_beyond_either_limit_or_no_number() {
        assert!(!fell(&[-2.4, 1e9, ANGLE_LIMIT, -1e9]));
        assert!(fell(&[2.41, 0.0, 0.0, 0.0]) && fell(&[0.0, 0.0, -0.21, 0.0]));
        assert!(fell(&[f64::NAN, 0.0, 0.0, 0.0]) && fell(&[0.0, 0.0, f64::NAN, 0.0]));
    }
}
