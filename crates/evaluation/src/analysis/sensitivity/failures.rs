//! Point MDPs on which a method fails: those where a metric is beyond a limit.

use crate::analysis::board::Board;
use crate::analysis::error::AnalysisError;
use crate::analysis::failing::is_beyond;
use crate::analysis::whole::Analysis;
use crate::stats::Limit;

/// Where methods fail.
#[derive(Debug, Clone, PartialEq)]
pub struct Failures {
    /// What a failure is: the mean of a metric over evaluation seeds and replicates beyond a limit.
    pub limit: Limit,
    /// Per method, those of the board first, then the baseline, if there is one.
    pub methods: Vec<FailuresOf>,
    /// Point MDPs of the board on which at least half of those of its methods fail of which it is known, as positions
    /// there.
    pub by_half: Vec<usize>,
    /// Number of point MDPs of the board on which all of these fail.
    pub by_all: usize,
    /// Number of point MDPs of the board on which some of its methods fails.
    pub by_any: usize,
}

/// Where a method fails.
#[derive(Debug, Clone, PartialEq)]
pub struct FailuresOf {
    /// The method.
    pub method: String,
    /// Point MDPs on which it fails, as positions in [`Analysis::points`].
    pub points: Vec<usize>,
    /// Number of point MDPs of which it is known whether it fails.
    pub known: usize,
    /// Share that the failures have of the weight of these; `None` where it is known of none.
    pub importance: Option<f64>,
}

/// Returns where methods fail.
///
/// # Errors
///
/// [`AnalysisError::Unknown`] for a metric that no record has.
pub fn failures(
    analysis: &Analysis,
    board: &Board,
    limit: &Limit,
) -> Result<Failures, AnalysisError> {
    analysis.check_metric(&limit.metric)?;
    let names = &analysis.manifest.identity.methods;
    let fails = |point: usize, method: usize| is_beyond(limit, &analysis.points[point], method);
    let positions: Vec<usize> = board
        .methods
        .iter()
        .filter_map(|name| names.iter().position(|other| other == name))
        .collect();
    let reference = analysis.reference.index.filter(|m| !positions.contains(m));
    let of = |method: &usize| {
        let known: Vec<usize> =
            (0..analysis.points.len()).filter(|p| fails(*p, *method).is_some()).collect();
        let points: Vec<usize> =
            known.iter().copied().filter(|p| fails(*p, *method) == Some(true)).collect();
        let weight =
            |points: &[usize]| points.iter().map(|p| analysis.points[*p].weight).sum::<f64>();
        let all = weight(&known);
        FailuresOf {
            method: names[*method].clone(),
            importance: (all > 0.0).then(|| weight(&points) / all),
            known: known.len(),
            points,
        }
    };
    // Per point MDP, how many methods fail, and of how many it is known.
    let failing: Vec<(usize, usize)> = board
        .points
        .iter()
        .map(|p| {
            let known = || positions.iter().filter_map(|m| fails(p.index, *m));
            (known().filter(|fails| *fails).count(), known().count())
        })
        .collect();
    let is_by_half = |(fail, known): (usize, usize)| known > 0 && 2 * fail >= known;
    Ok(Failures {
        limit: limit.clone(),
        methods: positions.iter().chain(&reference).map(of).collect(),
        by_half: (0..failing.len()).filter(|p| is_by_half(failing[*p])).collect(),
        by_all: failing.iter().filter(|(fail, known)| *known > 0 && fail == known).count(),
        by_any: failing.iter().filter(|(fail, _)| *fail > 0).count(),
    })
}
