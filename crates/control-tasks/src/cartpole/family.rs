//! CARL's family of carts and poles: 576 point MDPs, all of the same importance.
//!
//! Source: Jayawardana et al. (NeurIPS 2022), appendix; the values are multiples 0.1 to 10 of
//! gymnasium's constants, as CARL's bounds allow. gymnasium's own force of 10 N is not among them.

use std::fmt;
use std::str::FromStr;

use super::dynamics::Context;
use basics::suggest::did_you_mean;
use evaluation::family::{Feature, MdpFamily, PointMdp};

/// Name of the family, and of the domain.
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

/// Returns the family under a name.
pub fn family(name: &str) -> MdpFamily {
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
    MdpFamily::new(name, features.to_vec(), points, name).expect("equal shares sum to 1")
}

/// Returns the point MDP of a context.
pub fn point(context: &Context, importance: f64) -> PointMdp {
    let features @ [length, cart, pole, force, gravity] = context.features();
    PointMdp {
        id: format!("l{length}-c{cart}-p{pole}-f{force}-g{gravity}"),
        title: format!(
            "half-length {length} m, pole {pole} kg, cart {cart} kg, push {force} N, gravity {gravity} m/s²"
        ),
        features: features.to_vec(),
        importance,
        instances: 1,
    }
}

/// Why a point MDP is no cart and pole.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ContextError {
    /// A feature that none of them has.
    #[error("a cart and pole has no feature {feature:?}, only {}{meant}", known())]
    Feature {
        /// The feature.
        feature: String,
        /// A similar name, in words.
        meant: String,
    },
    /// A pole without inertia.
    #[error(
        "masspole_kg of {point} is {value}: from {limit:.3} kg on the inertia of carl-compat is not above 0; take \
         environment.dynamics = \"physical\""
    )]
    Inertia {
        /// Id of the point MDP.
        point: String,
        /// Its mass, kg.
        value: f64,
        /// The mass from which on there is none, kg.
        limit: f64,
    },
    /// A value that none of them can have.
    #[error("{feature} of {point} is {value}; expected a number above 0")]
    Value {
        /// Id of the point MDP.
        point: String,
        /// The feature.
        feature: String,
        /// Its value.
        value: f64,
    },
}

/// Returns the names of all features.
fn known() -> String {
    FEATURES.map(|(name, _)| name).join(", ")
}

/// Returns the context of a point MDP; a feature that its family does not have is gymnasium's.
///
/// # Errors
///
/// [`ContextError`] for a feature that does not exist or a value that is not positive.
pub fn context(features: &[Feature], point: &PointMdp) -> Result<Context, ContextError> {
    let mut numbers = Context::default().features();
    for (feature, value) in features.iter().zip(&point.features) {
        let name = &feature.name;
        let place = FEATURES.iter().position(|(known, _)| known == name);
        let place = place.ok_or_else(|| ContextError::Feature {
            feature: name.clone(),
            meant: did_you_mean(name, FEATURES.iter().map(|(known, _)| *known)),
        })?;
        if !(value.is_finite() && *value > 0.0) {
            let (point, feature) = (point.id.clone(), name.clone());
            return Err(ContextError::Value { point, feature, value: *value });
        }
        numbers[place] = *value;
    }
    Ok(Context::from_features(numbers))
}

/// Returns the features of every point MDP without the mass of the cart, which has no effect in CARL's environment;
/// nothing where there is no other feature.
pub fn without_effect_left_out(family: &MdpFamily) -> Vec<Vec<f64>> {
    let acts = |f: &usize| family.features[*f].name != "masscart_kg";
    let acting: Vec<usize> = (0..family.features.len()).filter(acts).collect();
    let row = |point: &PointMdp| acting.iter().map(|f| point.features[*f]).collect();
    if acting.is_empty() { Vec::new() } else { family.points.iter().map(row).collect() }
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

impl fmt::Display for Context {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words =
            FEATURES.iter().zip(self.features()).map(|((name, _), v)| format!("{name}={v}"));
        f.write_str(&words.collect::<Vec<_>>().join(" "))
    }
}

impl FromStr for Context {
    type Err = String;

    /// Reads what [`fmt::Display`] writes.
    fn from_str(text: &str) -> Result<Self, String> {
        let wrong =
            || format!("expected {}=NUMBER, not {text:?}", known().replace(", ", "=NUMBER "));
        let words: Vec<&str> = text.split(' ').collect();
        let words: [&str; 5] = words.try_into().map_err(|_| wrong())?;
        let mut numbers = [0.0; 5];
        for ((word, (name, _)), number) in words.iter().zip(FEATURES).zip(&mut numbers) {
            let value = word.strip_prefix(name).and_then(|rest| rest.strip_prefix('='));
            *number = value.and_then(|v| v.parse().ok()).ok_or_else(wrong)?;
        }
        Ok(Self::from_features(numbers))
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn the_family_has_576_different_points_of_equal_importance() {
        let family = family(NAME);
        let ids: BTreeSet<_> = family.points.iter().map(|p| p.id.as_str()).collect();
        assert_eq!((family.points.len(), ids.len()), (576, 576));
        assert!(family.points.iter().all(|p| p.importance == 1.0 / 576.0));
        let safe = |c: char| c.is_ascii_alphanumeric() || "-.".contains(c);
        assert!(ids.iter().all(|id| id.chars().all(safe)), "{ids:?}");
    }

    #[test]
    fn a_point_names_its_context() {
        let context = Context { force_n: 50.0, gravity_mps2: 0.1, ..Context::default() };
        let family = family(NAME);
        let point = &family.points[family.position("l0.5-c1-p0.1-f50-g0.1").unwrap()];
        let features: [f64; 5] = point.features.clone().try_into().unwrap();
        assert_eq!(Context::from_features(features), context);
        assert_eq!(
            point.title,
            "half-length 0.5 m, pole 0.1 kg, cart 1 kg, push 50 N, gravity 0.1 m/s²"
        );
    }
    #[test]
    fn a_table_may_have_some_of_the_features_and_no_others() {
        let feature = |name: &str| vec![Feature { name: name.into(), unit: String::new() }];
        let point = |value| PointMdp { features: vec![value], ..point(&Context::default(), 1.0) };
        let heavy = context(&feature("masspole_kg"), &point(0.7)).unwrap();
        assert_eq!(heavy, Context { masspole_kg: 0.7, ..Context::default() });
        let e = context(&feature("masspole"), &point(0.7)).unwrap_err().to_string();
        assert!(e.starts_with("a cart and pole has no feature \"masspole\""), "{e}");
        assert!(e.contains("only length_m, ") && e.ends_with("; did you mean masspole_kg?"), "{e}");
        for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(context(&feature("force_n"), &point(value)).is_err());
        }
    }

    #[test]
    fn a_context_is_read_as_it_is_written() {
        for point in &family(NAME).points {
            let context = Context::from_features(point.features.clone().try_into().unwrap());
            assert_eq!(context.to_string().parse(), Ok(context));
        }
        let text = "length_m=0.5 masscart_kg=1 masspole_kg=0.1 force_n=10 gravity_mps2=9.8";
        assert_eq!(Context::default().to_string(), text);
        for wrong in ["", &text[1..], "length_m=0.5", &text.replace("=10", "=ten")] {
            assert!(wrong.parse::<Context>().is_err(), "{wrong}");
        }
    }
}
