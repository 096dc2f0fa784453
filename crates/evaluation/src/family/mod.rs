//! MDP families: point MDPs, their context features and their importance.
//!
//! A family knows neither its task nor what its features mean.

pub mod columns;
pub mod doubt;
pub mod error;
pub mod names;
pub mod points;
#[cfg(test)]
pub(crate) mod testing;

use std::collections::{BTreeSet, HashMap};

use serde::{Deserialize, Serialize};

pub use error::FamilyError;

/// How far the importance of a family may be from 1 in total.
pub const IMPORTANCE_TOLERANCE: f64 = 1e-9;

/// A context feature of a family: a name and a unit.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Feature {
    /// Name, with the unit as a suffix where it has one (`speed_mph`).
    pub name: String,
    /// Unit in words, empty for counts.
    pub unit: String,
}

/// One member of a family.
#[derive(Debug, Clone, PartialEq)]
pub struct PointMdp {
    /// Stable id, safe in file names.
    pub id: String,
    /// What people call it; the id where it has no other name.
    pub title: String,
    /// Context features, in the order of [`MdpFamily::features`].
    pub features: Vec<f64>,
    /// Probability of this point MDP in the family.
    pub importance: f64,
    /// How many real instances (intersections) it stands for.
    pub instances: u32,
}

/// Point MDPs with an importance that sums to 1.
///
/// Source: Jayawardana et al. (NeurIPS 2022), section 3.
#[derive(Debug, Clone, PartialEq)]
pub struct MdpFamily {
    /// Name of the scenario.
    pub name: String,
    /// Names and units of the context features; any number.
    pub features: Vec<Feature>,
    /// The members, most important first, then by id.
    pub points: Vec<PointMdp>,
    /// What k-means compares, a row per point MDP in their order; empty where the context features
    /// describe them.
    pub describing: Vec<Vec<f64>>,
    positions: HashMap<String, usize>,
}

impl MdpFamily {
    /// Returns a family after checking that it is one.
    ///
    /// # Arguments
    ///
    /// * `source` — the file named in errors.
    ///
    /// # Errors
    ///
    /// [`FamilyError::Empty`] without points, [`FamilyError::Point`] for an id that is not safe or comes twice, a
    /// feature too many or too few, a negative importance, [`FamilyError::NotADistribution`] when the importance
    /// does not sum to 1 within [`IMPORTANCE_TOLERANCE`].
    pub fn new(
        name: impl Into<String>,
        features: Vec<Feature>,
        mut points: Vec<PointMdp>,
        source: &str,
    ) -> Result<Self, FamilyError> {
        if points.is_empty() {
            return Err(FamilyError::Empty { file: source.to_owned() });
        }
        let mut ids = BTreeSet::new();
        for point in &points {
            let wrong = |message: String| {
                Err(FamilyError::Point {
                    file: source.to_owned(),
                    point: point.id.clone(),
                    message,
                })
            };
            if let Err(message) = names::check_id("id", &point.id) {
                return wrong(message);
            }
            if !ids.insert(point.id.as_str()) {
                return wrong("there is another of that id".to_owned());
            }
            if point.features.len() != features.len() {
                let (own, all) = (point.features.len(), features.len());
                return wrong(format!("it has {own} features, the family {all}"));
            }
            if point.importance.is_nan() || point.importance < 0.0 {
                return wrong(format!("its importance is {}", point.importance));
            }
        }
        let sum: f64 = points.iter().map(|p| p.importance).sum();
        if (sum - 1.0).abs() > IMPORTANCE_TOLERANCE {
            return Err(FamilyError::NotADistribution {
                file: source.to_owned(),
                sum,
                column: String::new(),
            });
        }
        points.sort_by(|a, b| b.importance.total_cmp(&a.importance).then_with(|| a.id.cmp(&b.id)));
        let mut positions: HashMap<String, usize> =
            points.iter().enumerate().map(|(i, p)| (p.id.clone(), i)).collect();
        for (i, point) in points.iter().enumerate() {
            positions.entry(point.title.clone()).or_insert(i);
        }
        Ok(Self { name: name.into(), features, points, describing: Vec::new(), positions })
    }

    /// Returns the importance of every point MDP, in order.
    pub fn importance(&self) -> Vec<f64> {
        self.points.iter().map(|p| p.importance).collect()
    }

    /// Returns the index of a point MDP by its id, or else by what people call it.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.positions.get(name).copied()
    }

    /// Returns the importance-weighted mean and standard deviation of each feature.
    pub fn moments(&self) -> Vec<(f64, f64)> {
        (0..self.features.len())
            .map(|f| {
                let mean: f64 = self.points.iter().map(|p| p.importance * p.features[f]).sum();
                let variance: f64 =
                    self.points.iter().map(|p| p.importance * (p.features[f] - mean).powi(2)).sum();
                (mean, variance.sqrt())
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(id: &str, importance: f64, x: f64) -> PointMdp {
        PointMdp { id: id.into(), title: id.into(), features: vec![x], importance, instances: 1 }
    }

    fn feature() -> Vec<Feature> {
        vec![Feature { name: "x".into(), unit: String::new() }]
    }

    #[test]
    fn importance_that_does_not_sum_to_one_is_refused() {
        let e = MdpFamily::new("f", feature(), vec![point("a", 0.6, 0.0)], "p.csv").unwrap_err();
        assert!(matches!(e, FamilyError::NotADistribution { sum, .. } if sum == 0.6));
    }

    #[test]
    fn points_that_cannot_be_in_a_family_are_refused() {
        let more = PointMdp { features: vec![0.0, 1.0], ..point("a", 1.0, 0.0) };
        for (points, expected) in [
            (vec![point("a", 0.5, 0.0), point("a", 0.5, 1.0)], "there is another of that id"),
            (vec![point("../a", 1.0, 0.0)], "expected 1 to"),
            (vec![more], "it has 2 features, the family 1"),
            (vec![point("a", 1.5, 0.0), point("b", -0.5, 0.0)], "its importance is -0.5"),
            (vec![point("a", f64::NAN, 0.0)], "its importance is NaN"),
        ] {
            let e = MdpFamily::new("f", feature(), points, "p.csv").unwrap_err().to_string();
            assert!(e.starts_with("p.csv: point \"") && e.contains(expected), "{e}");
        }
    }

    #[test]
    fn points_are_ordered_by_importance_then_id() {
        let points = vec![point("c", 0.25, 0.0), point("b", 0.25, 0.0), point("a", 0.5, 0.0)];
        let family = MdpFamily::new("f", feature(), points, "p.csv").unwrap();
        let ids: Vec<_> = family.points.iter().map(|p| p.id.as_str()).collect();
        assert_eq!(ids, ["a", "b", "c"]);
    }

    #[test]
    fn moments_are_weighted_by_importance() {
        let points = vec![point("a", 0.75, 0.0), point("b", 0.25, 4.0)];
        let family = MdpFamily::new("f", feature(), points, "p.csv").unwrap();
        assert_eq!(family.moments(), vec![(1.0, 3.0_f64.sqrt())]);
    }
}
