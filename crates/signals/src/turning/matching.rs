//! Which arm of an intersection a direction of travel belongs to.

use osm_signals::angle::turn_degrees;

use crate::family::approaches::Approach;
use crate::vocabulary::Heading;
use crate::vocabulary::MOST_OFF_DEG;

/// Cost of a direction without an arm, as if it were so many degrees off.
const WITHOUT_DEG: f64 = 120.0;

/// Difference of two assignments, degrees in the quadratic mean, below which either may be meant.
const CLOSE_DEG: f64 = 12.0;

/// The arms of directions.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Matching {
    /// Per direction its arm, if there is one.
    pub(crate) arms: Vec<Option<usize>>,
    /// Whether another assignment is nearly as good, as at an intersection whose streets lie at 45 degrees.
    pub(crate) is_ambiguous: bool,
}

/// Returns the arms of an intersection that vehicles with these directions come from, as positions in `arms`. Where the names
/// of all arms that lead to the signal begin with different directions, as those of UTDF do, these count, else the compass.
pub(crate) fn matched_arms(headings: &[Heading], arms: &[Approach], taken: &[usize]) -> Matching {
    let incoming: Vec<usize> = (0..arms.len()).filter(|i| arms[*i].lanes_in > 0).collect();
    if let Some(told) = Heading::told(incoming.iter().map(|i| arms[*i].arm.as_str())) {
        let place = |heading: &Heading| told.iter().position(|other| other == heading);
        let arms = headings.iter().map(|heading| place(heading).map(|i| incoming[i])).collect();
        return Matching { arms, is_ambiguous: false };
    }
    let free: Vec<usize> = incoming.into_iter().filter(|i| !taken.contains(i)).collect();
    let bearings_deg: Vec<f64> = free.iter().map(|i| arms[*i].bearing_deg).collect();
    let found = matching(headings, &bearings_deg);
    let arms = found.arms.into_iter().map(|arm| arm.map(|arm| free[arm])).collect();
    Matching { arms, ..found }
}

/// Returns the arms from which vehicles travel in these directions: each arm once, with the least sum of squared
/// deviations.
fn matching(headings: &[Heading], bearings_deg: &[f64]) -> Matching {
    let mut search = Search { headings, bearings_deg, all: Vec::new() };
    search.extend(&mut Vec::new(), 0.0);
    search.all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let n = headings.len().max(1) as f64;
    let (best, arms) = search.all[0].clone();
    let second = search.all.get(1).map_or(f64::INFINITY, |(cost, _)| *cost);
    let is_ambiguous = (second / n).sqrt() - (best / n).sqrt() < CLOSE_DEG;
    Matching { arms, is_ambiguous }
}

struct Search<'a> {
    headings: &'a [Heading],
    bearings_deg: &'a [f64],
    /// Costs of complete assignments.
    all: Vec<(f64, Vec<Option<usize>>)>,
}

impl Search<'_> {
    fn extend(&mut self, chosen: &mut Vec<Option<usize>>, cost: f64) {
        let Some(heading) = self.headings.get(chosen.len()) else {
            self.all.push((cost, chosen.clone()));
            return;
        };
        for (arm, bearing_deg) in self.bearings_deg.iter().enumerate() {
            let off_deg = turn_degrees(heading.degrees(), bearing_deg + 180.0).abs();
            if off_deg > MOST_OFF_DEG || chosen.contains(&Some(arm)) {
                continue;
            }
            chosen.push(Some(arm));
            self.extend(chosen, cost + off_deg * off_deg);
            chosen.pop();
        }
        chosen.push(None);
        self.extend(chosen, cost + WITHOUT_DEG * WITHOUT_DEG);
        chosen.pop();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Heading::{East, North, NorthEast, South, SouthWest, West};

    #[test]
    fn northbound_traffic_comes_from_the_south() {
        let found = matching(&[North, South, East, West], &[10.0, 95.0, 185.0, 280.0]);
        assert_eq!(found.arms, [Some(2), Some(0), Some(3), Some(1)]);
        assert!(!found.is_ambiguous);
    }

    #[test]
    fn a_skew_street_keeps_its_directions_and_a_missing_arm_is_none() {
        let found = matching(&[North, South, East], &[60.0, 240.0]);
        assert_eq!(found.arms, [None, Some(0), Some(1)]);
        assert_eq!(matching(&[North, South], &[60.0, 240.0]).arms, [Some(1), Some(0)]);
        let diagonal = matching(&[NorthEast, SouthWest], &[45.0, 225.0]);
        assert_eq!(diagonal.arms, [Some(1), Some(0)]);
    }

    #[test]
    fn streets_at_45_degrees_may_be_meant_either_way() {
        assert!(matching(&[North, South, East, West], &[45.0, 135.0, 225.0, 315.0]).is_ambiguous);
    }
}
