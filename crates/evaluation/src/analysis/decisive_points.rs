//! What the first place rests on: the fewest point MDPs without which another method would be first.
//!
//! An interval over evaluation seeds says nothing of a single training that failed. Where a lead that no seed explains
//! comes from one point MDP of a hundred, a reader must know which.

use super::method::MethodSummary;
use super::whole::Analysis;
use crate::stats::score::weighted_mean;

/// Largest share of the weight that is called few.
const FEW: f64 = 0.05;

/// Few point MDPs without which another method would be first.
#[derive(Debug, Clone, PartialEq)]
pub struct DecisivePoints {
    /// Their positions in [`Analysis::points`], the one that matters most first.
    pub points: Vec<usize>,
    /// Their share of the weight.
    pub share: f64,
    /// Position in [`Analysis::methods`] of the method that would be first.
    pub method: usize,
    /// Its overall performance without them, and that of the first.
    pub without: (f64, f64),
}

impl Analysis {
    /// Returns the fewest point MDPs without which another method would be ahead of the first; `None` where more than a
    /// twentieth of the weight would have to go, or where the first is not ahead by the weighted mean alone.
    pub fn decisive_points(&self) -> Option<DecisivePoints> {
        let first = self.methods.first().filter(|m| m.rank.is_some())?;
        let others = self.methods.iter().enumerate().skip(1).filter(|(_, m)| m.rank.is_some());
        let found = others.filter_map(|(position, other)| self.turned(first, (position, other)));
        found.min_by(|a, b| a.share.total_cmp(&b.share))
    }

    fn turned(
        &self,
        first: &MethodSummary,
        (method, other): (usize, &MethodSummary),
    ) -> Option<DecisivePoints> {
        let score = |p: usize, m: usize| self.points[p].results[m].as_ref().and_then(|r| r.score);
        let direction = self.manifest.identity.direction;
        let mut rows: Vec<(usize, f64, f64, f64)> = (0..self.points.len())
            .filter_map(|p| {
                let scores = (score(p, first.index)?, score(p, other.index)?);
                Some((p, self.points[p].weight, scores.0, scores.1))
            })
            .collect();
        let ahead = |r: &(usize, f64, f64, f64)| r.1 * direction.ahead(r.2, r.3);
        rows.sort_by(|a, b| ahead(b).total_cmp(&ahead(a)));
        let total: f64 = rows.iter().map(|r| r.1).sum();
        let mut left: f64 = rows.iter().map(ahead).sum();
        if left <= 0.0 {
            return None;
        }
        let (mut gone, mut taken) = (0.0, 0);
        while left >= 0.0 {
            let row = rows.get(taken)?;
            (gone, left, taken) = (gone + row.1, left - ahead(row), taken + 1);
            if gone > FEW * total {
                return None;
            }
        }
        let rest = &rows[taken..];
        let without = (
            weighted_mean(rest.iter().map(|r| (r.1, r.3)))?,
            weighted_mean(rest.iter().map(|r| (r.1, r.2)))?,
        );
        let points = rows[..taken].iter().map(|r| r.0).collect();
        Some(DecisivePoints { points, share: gone / total, method, without })
    }
}
