//! CARL's family of carts and poles: 576 point MDPs, all of the same importance.
//!
//! Source: Jayawardana et al. (NeurIPS 2022), appendix; the values are multiples 0.1 to 10 of
//! gymnasium's constants, as CARL's bounds allow. gymnasium's own force of 10 N is not among them.

use super::dynamics::Context;
use crate::family::{Feature, MdpFamily, PointMdp};

/// Name of the family.
pub const NAME: &str = "cartpole";

/// Names and units of the context features.
pub const FEATURES: [(&str, &str); 5] = [
    ("length_m", "m"),
    ("masscart_kg", "kg"),
    ("masspole_kg", "kg"),
    ("force_n", "N"),
    ("gravity_mps2", "m/s²"),
];

const LENGTHS_M: [f64; 4] = [0.05, 0.5, 3.0, 5.0];
const CART_MASSES_KG: [f64; 4] = [0.1, 1.0, 6.0, 10.0];
const POLE_MASSES_KG: [f64; 4] = [0.01, 0.1, 0.5, 1.0];
const FORCES_N: [f64; 3] = [1.0, 50.0, 100.0];
const GRAVITIES_MPS2: [f64; 3] = [0.1, 9.8, 19.6];

/// Returns the family.
pub fn family() -> MdpFamily {
    let mut contexts = Vec::new();
    for length_m in LENGTHS_M {
        for masscart_kg in CART_MASSES_KG {
            for masspole_kg in POLE_MASSES_KG {
                for force_n in FORCES_N {
                    for gravity_mps2 in GRAVITIES_MPS2 {
                        contexts.push(Context {
                            length_m,
                            masscart_kg,
                            masspole_kg,
                            force_n,
                            gravity_mps2,
                        });
                    }
                }
            }
        }
    }
    let importance = 1.0 / contexts.len() as f64;
    let points = contexts.iter().map(|context| point(context, importance)).collect();
    let features = FEATURES.map(|(name, unit)| Feature { name: name.into(), unit: unit.into() });
    MdpFamily::new(NAME, features.to_vec(), points, NAME).expect("equal shares sum to 1")
}

/// Returns the point MDP of a context.
pub fn point(context: &Context, importance: f64) -> PointMdp {
    let features @ [length, cart, pole, force, gravity] = context.features();
    PointMdp {
        id: format!("l{length}-c{cart}-p{pole}-f{force}-g{gravity}"),
        title: format!(
            "pole {length} m, {pole} kg; cart {cart} kg; push {force} N; gravity {gravity} m/s²"
        ),
        features: features.to_vec(),
        importance,
        instances: 1,
    }
}

impl Context {
    /// Returns the context as features, in the order of [`FEATURES`].
    pub fn features(&self) -> [f64; 5] {
        [self.length_m, self.masscart_kg, self.masspole_kg, self.force_n, self.gravity_mps2]
    }

    /// Returns the context of features in the order of [`FEATURES`].
    pub fn from_features(features: [f64; 5]) -> Self {
        let [length_m, masscart_kg, masspole_kg, force_n, gravity_mps2] = features;
        Self { length_m, masscart_kg, masspole_kg, force_n, gravity_mps2 }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn the_family_has_576_different_points_of_equal_importance() {
        let family = family();
        let ids: BTreeSet<_> = family.points.iter().map(|p| p.id.as_str()).collect();
        assert_eq!((family.points.len(), ids.len()), (576, 576));
        assert!(family.points.iter().all(|p| p.importance == 1.0 / 576.0));
        let safe = |c: char| c.is_ascii_alphanumeric() || "-.".contains(c);
        assert!(ids.iter().all(|id| id.chars().all(safe)), "{ids:?}");
    }

    #[test]
    fn a_point_names_its_context() {
        let context = Context { force_n: 50.0, gravity_mps2: 0.1, ..Context::default() };
        let family = family();
        let point = &family.points[family.position("l0.5-c1-p0.1-f50-g0.1").unwrap()];
        let features: [f64; 5] = point.features.clone().try_into().unwrap();
        assert_eq!(Context::from_features(features), context);
        assert_eq!(point.title, "pole 0.5 m, 0.1 kg; cart 1 kg; push 50 N; gravity 0.1 m/s²");
    }
}
