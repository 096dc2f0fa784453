//! The scores of some methods on the point MDPs that all of them have, as a table: what rankings under other
//! importance, and across families, are computed from.

use super::error::AnalysisError;
use super::whole::Analysis;
use crate::stats::Direction;
use basics::suggest::did_you_mean;

/// Most names that a message lists.
const LISTED: usize = 12;

/// The scores of some methods on the point MDPs that all of them have.
#[derive(Debug, Clone, PartialEq)]
pub struct Board {
    /// Names of the methods.
    pub methods: Vec<String>,
    /// Whether less or more of a score is better.
    pub direction: Direction,
    /// The point MDPs, in the order of the family.
    pub points: Vec<BoardPoint>,
    /// Number of point MDPs that were to be evaluated.
    pub chosen: usize,
    /// Number of the family's point MDPs.
    pub family_size: usize,
    /// Methods without a score on some of these, and on how many.
    pub lacking: Vec<(String, usize)>,
}

/// A point MDP on which all methods have a score.
#[derive(Debug, Clone, PartialEq)]
pub struct BoardPoint {
    /// Position in [`Analysis::points`].
    pub index: usize,
    /// Its id.
    pub id: String,
    /// Weight in the run's estimates, above 0; the importance where the whole family was evaluated.
    pub weight: f64,
    /// Score of every method.
    pub scores: Vec<f64>,
}

impl Board {
    /// Returns the names of the methods that are compared unless others are asked for: all with results, without
    /// what scores are divided by.
    pub fn methods_of(analysis: &Analysis) -> Vec<String> {
        let identity = &analysis.manifest.identity;
        let has = |m: usize| analysis.results_of(m).next().is_some();
        let compared = |m: &usize| Some(*m) != analysis.reference.index && has(*m);
        (0..identity.methods.len()).filter(compared).map(|m| identity.methods[m].clone()).collect()
    }

    /// Returns the scores of these methods.
    ///
    /// # Errors
    ///
    /// [`AnalysisError::Unknown`] for a method that is not in the run, [`AnalysisError::NothingInCommon`] when no
    /// point MDP has a score of each.
    pub fn new(analysis: &Analysis, methods: &[String]) -> Result<Self, AnalysisError> {
        let all = &analysis.manifest.identity.methods;
        let positions = methods
            .iter()
            .map(|name| position("method", name, all.iter().map(String::as_str)))
            .collect::<Result<Vec<usize>, _>>()?;
        let score = |point: usize, method: usize| {
            let result = analysis.points[point].results[method].as_ref()?;
            result.score.filter(|score| score.is_finite())
        };
        let chosen = analysis.points.len();
        let lacking: Vec<(String, usize)> = positions
            .iter()
            .map(|m| (all[*m].clone(), (0..chosen).filter(|p| score(*p, *m).is_none()).count()))
            .filter(|(_, count)| *count > 0)
            .collect();
        let points: Vec<BoardPoint> = (0..chosen)
            .filter(|p| analysis.points[*p].weight > 0.0)
            .filter_map(|index| {
                let scores: Option<Vec<f64>> = positions.iter().map(|m| score(index, *m)).collect();
                let point = &analysis.points[index];
                Some(BoardPoint {
                    index,
                    id: point.row.point.clone(),
                    weight: point.weight,
                    scores: scores?,
                })
            })
            .collect();
        if points.is_empty() {
            let lacking = lacking.iter().map(|(m, n)| format!("{m} lacks {n} of {chosen}"));
            return Err(AnalysisError::NothingInCommon {
                methods: methods.join(", "),
                lacking: lacking.collect::<Vec<_>>().join(", "),
            });
        }
        let direction = analysis.direction();
        let family_size = analysis.manifest.identity.sample.family_size;
        Ok(Self { methods: methods.to_vec(), direction, points, chosen, family_size, lacking })
    }

    /// Returns the position of a point MDP, by its id or by what it is called.
    ///
    /// # Errors
    ///
    /// [`AnalysisError::Unknown`], and [`AnalysisError::Lacking`] for one on which a method has no score.
    pub fn position(&self, analysis: &Analysis, name: &str) -> Result<usize, AnalysisError> {
        let rows = || analysis.points.iter().map(|p| &p.row);
        let ids = rows().map(|row| row.point.as_str());
        let index = rows().position(|row| row.point == name || row.title == name);
        let index = index.map_or_else(|| position("point MDP", name, ids), Ok)?;
        let found = self.points.iter().position(|p| p.index == index);
        found.ok_or_else(|| AnalysisError::Lacking { point: name.to_owned() })
    }

    /// Returns the weights, which sum to 1.
    pub fn weights(&self) -> Vec<f64> {
        let total: f64 = self.points.iter().map(|p| p.weight).sum();
        self.points.iter().map(|p| p.weight / total).collect()
    }

    /// Says how many point MDPs of the family were evaluated; `None` when all were.
    pub fn sampled(&self) -> Option<String> {
        let (chosen, all) = (self.chosen, self.family_size);
        (chosen < all).then(|| format!("{chosen} of {all} point MDPs were evaluated"))
    }

    /// Says which methods lack how many point MDPs, and what is compared then; `None` when none lacks any.
    pub fn lacks(&self) -> Option<String> {
        if self.lacking.is_empty() {
            return None;
        }
        let of = |(name, n): &(String, usize)| format!("{name} {n}");
        let lacking: Vec<String> = self.lacking.iter().map(of).collect();
        Some(format!(
            "of {} point MDPs {} are compared, on which all methods have a score; lacking: {}",
            self.chosen,
            self.points.len(),
            lacking.join(", ")
        ))
    }
}

/// Returns the position of a name.
///
/// # Errors
///
/// [`AnalysisError::Unknown`] with what may have been meant.
pub(super) fn position<'a>(
    what: &'static str,
    name: &str,
    all: impl Iterator<Item = &'a str> + Clone,
) -> Result<usize, AnalysisError> {
    all.clone().position(|other| other == name).ok_or_else(|| {
        let mut there: Vec<&str> = all.clone().take(LISTED).collect();
        let more = all.clone().count() - there.len();
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        if there.is_empty() {
            there.push("none");
        }
        AnalysisError::Unknown {
            what,
            name: name.to_owned(),
            there: format!("{}{more}", there.join(", ")),
            meant: did_you_mean(name, all),
        }
    })
}
