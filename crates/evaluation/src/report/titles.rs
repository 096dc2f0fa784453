//! What point MDPs are called: by their titles, and by their ids behind them where those differ.

use crate::analysis::PointSummary;

/// Returns a title with the id of its point MDP behind it, for those who have to type that.
pub fn with_id(title: String, point: &str) -> String {
    if title == point { title } else { format!("{title} ({point})") }
}

/// Whether any point MDP is called otherwise than by its id, so that tables need a column for it.
///
/// # Arguments
///
/// * `titles` — in the order of `points`.
pub fn differ(points: &[PointSummary], titles: &[String]) -> bool {
    points.iter().zip(titles).any(|(p, title)| p.row.point != *title)
}
