//! How point MDPs came to be in the sample: draws, probabilities, and where they lie.

use std::borrow::Borrow;
use std::collections::{BTreeSet, HashMap};

use super::estimator::Chosen;
use super::points::PointSummary;
use crate::sample::kmeans::standardise;
use crate::sample::{Design, Draw, Look};
use crate::store::manifest::Identity;

/// Returns the first look that has all of some point MDPs; `None` where the sample does not grow.
pub(super) fn look_of<'a>(
    identity: &'a Identity,
    points: &[impl Borrow<PointSummary>],
) -> Option<&'a Look> {
    let ids: BTreeSet<&str> = points.iter().map(|p| p.borrow().row.point.as_str()).collect();
    identity.sample.first_look_with(&ids).map(|(_, look)| look)
}

fn draws_of<'a>(
    identity: &'a Identity,
    points: &[impl Borrow<PointSummary>],
) -> HashMap<&'a str, &'a Draw> {
    let draws = look_of(identity, points).map_or(&identity.sample.draws, |look| &look.draws);
    draws.iter().map(|d| (d.point.as_str(), d)).collect()
}

/// Returns the weights of point MDPs, in their order, as those of the look that they are.
pub(super) fn weights(identity: &Identity, points: &[impl Borrow<PointSummary>]) -> Vec<f64> {
    let draws = draws_of(identity, points);
    let weight = |id: &str| draws.get(id).map_or(0.0, |draw| draw.weight);
    points.iter().map(|p| weight(p.borrow().row.point.as_str())).collect()
}

/// Returns how point MDPs came to be in the sample, in their order.
pub(super) fn choice(
    identity: &Identity,
    design: Option<&Design>,
    points: &[impl Borrow<PointSummary>],
) -> Vec<Chosen> {
    let draws = draws_of(identity, points);
    let rows: Option<HashMap<&str, usize>> = design.map(|design| {
        design.points.iter().enumerate().map(|(row, p)| (p.point.as_str(), row)).collect()
    });
    let coordinates = design.map(Design::coordinates);
    let of = |point: &PointSummary| -> Option<Chosen> {
        let id = point.row.point.as_str();
        let row = rows.as_ref().map(|rows| rows.get(id).copied());
        let row = match row {
            // A point MDP that the design does not have is one of which nothing is known.
            Some(row) => Some(row?),
            None => None,
        };
        let at = row.zip(coordinates.as_ref()).map(|(row, all)| all[row].clone());
        let draw = draws.get(id);
        Some(Chosen {
            count: draw.map_or(1, |d| d.count),
            inclusion: draw.and_then(|d| d.inclusion),
            importance: point.row.importance,
            row,
            at: at.unwrap_or_default(),
        })
    };
    let mut chosen: Vec<Chosen> =
        points.iter().map(|p| of(p.borrow()).unwrap_or_default()).collect();
    if design.is_none() {
        let rows: Vec<Vec<f64>> = points.iter().map(|p| p.borrow().row.features.clone()).collect();
        for (chosen, at) in chosen.iter_mut().zip(standardise(&rows)) {
            chosen.at = at;
        }
    }
    chosen
}
