//! The context of a point MDP: a value per feature of its task, as numbers and as text in manifests.

use crate::task::{ABOVE_0, ContextFeature, Task};
use basics::suggest::did_you_mean;
use evaluation::family::{Feature, PointMdp};

#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum ContextError {
    #[error("{what} has no feature {feature:?}, only {known}{meant}")]
    Feature { what: &'static str, feature: String, known: String, meant: String },
    #[error("{feature} of {point} is {value}: {message}")]
    Value { point: String, feature: &'static str, value: f64, message: String },
}

fn known<T: Task>() -> String {
    T::FEATURES.iter().map(|f| f.name).collect::<Vec<_>>().join(", ")
}

/// Returns the context of a point MDP; a feature that its family does not have has its default.
/// Fails with [`ContextError`] for a feature that does not exist or a value that is not positive or that the task refuses.
pub(crate) fn context<T: Task>(
    scenario: &T::Scenario,
    features: &[Feature],
    point: &PointMdp,
) -> Result<Vec<f64>, ContextError> {
    let mut numbers: Vec<f64> = T::FEATURES.iter().map(|f| f.default).collect();
    let wrong = |place: usize, value, message| {
        let (point, feature) = (point.id.clone(), T::FEATURES[place].name);
        ContextError::Value { point, feature, value, message }
    };
    for (feature, value) in features.iter().zip(&point.features) {
        let name = &feature.name;
        let place = T::FEATURES.iter().position(|known| known.name == name);
        let place = place.ok_or_else(|| ContextError::Feature {
            what: T::WHAT,
            feature: name.clone(),
            known: known::<T>(),
            meant: did_you_mean(name, T::FEATURES.iter().map(|known| known.name)),
        })?;
        let [least, most] = T::FEATURES[place].range;
        if !(least..=most).contains(value) {
            let message = match *value > most && value.is_finite() {
                true => format!("expected {most} or less"),
                false if least > ABOVE_0 => format!("expected {least} or more"),
                false => "expected a number above 0".to_owned(),
            };
            return Err(wrong(place, *value, message));
        }
        numbers[place] = *value;
    }
    match T::check(scenario, &numbers) {
        Ok(()) => Ok(numbers),
        Err((place, message)) => Err(wrong(place, numbers[place], message)),
    }
}

pub(crate) fn text<T: Task>(context: &[f64]) -> String {
    let words = T::FEATURES.iter().zip(context).map(|(f, v)| format!("{}={v}", f.name));
    words.collect::<Vec<_>>().join(" ")
}

pub(crate) fn parse<T: Task>(text: &str) -> Result<Vec<f64>, String> {
    let words: Vec<&str> = text.split(' ').collect();
    let value = |(word, feature): (&&str, &ContextFeature)| {
        word.strip_prefix(feature.name)?.strip_prefix('=')?.parse().ok()
    };
    let numbers: Option<Vec<f64>> = words.iter().zip(T::FEATURES).map(value).collect();
    numbers.filter(|_| words.len() == T::FEATURES.len()).ok_or_else(|| {
        format!("expected {}=NUMBER, not {text:?}", known::<T>().replace(", ", "=NUMBER "))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cartpole::{CartPoles, Scenario};
    use crate::task::family;

    #[test]
    fn a_table_may_have_some_of_the_features_and_no_others() {
        let feature = |name: &str| vec![Feature { name: name.into(), unit: String::new() }];
        let of = |name: &str, value| {
            let point = PointMdp { features: vec![value], ..CartPoles::points().remove(0) };
            context::<CartPoles>(&Scenario::default(), &feature(name), &point)
        };
        assert_eq!(of("masspole_kg", 0.7).unwrap(), [0.5, 1.0, 0.7, 10.0, 9.8]);
        let e = of("masspole", 0.7).unwrap_err().to_string();
        assert!(e.starts_with("a cart and pole has no feature \"masspole\""), "{e}");
        assert!(e.contains("only length_m, ") && e.ends_with("; did you mean masspole_kg?"), "{e}");
        for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(of("force_n", value).is_err());
        }
        let e = of("masspole_kg", 1.5).unwrap_err().to_string();
        assert!(
            e.contains(" is 1.5: from 1.467 kg on the inertia of carl-compat is not above 0"),
            "{e}"
        );
    }

    #[test]
    fn a_context_is_read_as_it_is_written() {
        for point in &family::<CartPoles>("a").points {
            assert_eq!(
                parse::<CartPoles>(&text::<CartPoles>(&point.features)),
                Ok(point.features.clone())
            );
        }
        let default = "length_m=0.5 masscart_kg=1 masspole_kg=0.1 force_n=10 gravity_mps2=9.8";
        assert_eq!(parse::<CartPoles>(default).unwrap(), [0.5, 1.0, 0.1, 10.0, 9.8]);
        for wrong in ["", &default[1..], "length_m=0.5", &default.replace("=10", "=ten")] {
            assert!(parse::<CartPoles>(wrong).is_err(), "{wrong}");
        }
    }
}
