//! Whether point MDPs are called by their titles.

use crate::analysis::PointSummary;

/// Whether any point MDP is called otherwise than by its id, so that tables need a column for it.
///
/// # Arguments
///
/// * `titles` — in the order of `points`.
pub fn differ(points: &[PointSummary], titles: &[String]) -> bool {
    points.iter().zip(titles).any(|(p, title)| p.row.point != *title)
}
