//! To which exits the counted turns of an approach lead where its street bends.
//!
//! Bearings make at most one exit the way straight on, and none that is 45 degrees off. The names of directions know more:
//! northbound vehicles that go straight on leave by the arm that southbound ones come from.

use osm_signals::Turn;

use crate::family::approaches::MOST_EXITS;
use crate::vocabulary::Heading;

/// Turns from left to right.
const TURNS: [Turn; 3] = [Turn::Left, Turn::Through, Turn::Right];

/// Eighths of a circle from a direction to that of the vehicles which come from the arms on its left, ahead and on its right.
const FACING: [usize; 3] = [2, 4, 6];

/// Eighths of a circle from which a street has another direction.
const OTHER: usize = 2;

/// Directions of travel and the arms that they come from.
pub(super) struct Directions<'a> {
    /// The directions.
    pub(super) headings: &'a [Heading],
    /// Per direction its arm, if there is one.
    pub(super) arms: &'a [Option<usize>],
}

impl Directions<'_> {
    /// Whether the three exits of an approach are left, ahead and right by the names of directions, and not by bearings.
    pub(super) fn name_exits(&self, heading: Heading, exits: &[(usize, Turn)]) -> bool {
        let by_name = FACING.map(|eighths| self.arm_of(turned(heading, eighths)));
        exits.len() == TURNS.len()
            && exits.iter().zip(TURNS).any(|((_, turn), named)| *turn != named)
            && exits.iter().zip(by_name).all(|((arm, _), named)| Some(*arm) == named)
    }

    /// Returns the direction of the vehicles that come from where those of another one go straight on, if it is not that of
    /// the opposite street.
    pub(super) fn ahead(&self, heading: Heading, exits: &[(usize, Turn)]) -> Option<Heading> {
        let (ahead, _) = exits.iter().find(|(_, turn)| *turn == Turn::Through)?;
        let mut known = self.headings.iter().zip(self.arms);
        let (found, _) = known.find(|(_, arm)| **arm == Some(*ahead))?;
        let [_, straight, _] = FACING;
        let off = (*found as usize).abs_diff(turned(heading, straight) as usize);
        (off.min(Heading::ALL.len() - off) >= OTHER).then_some(*found)
    }

    fn arm_of(&self, heading: Heading) -> Option<usize> {
        let place = self.headings.iter().position(|other| *other == heading)?;
        self.arms.get(place).copied().flatten()
    }
}

/// Returns the direction so many eighths of a circle clockwise from another.
fn turned(heading: Heading, eighths: usize) -> Heading {
    heading.clockwise(eighths)
}

/// Returns vehicles to exits as the turns that bearings make of these, and as exits of a table.
pub(super) fn by_turn(volumes: [f64; 3], exits: &[(usize, Turn)]) -> ([f64; 3], [f64; MOST_EXITS]) {
    let (mut turns, mut exits_vph) = ([0.0; 3], [0.0; MOST_EXITS]);
    for (((_, turn), vph), exit) in exits.iter().zip(volumes).zip(&mut exits_vph) {
        turns[*turn as usize] += vph;
        *exit = vph;
    }
    (turns, exits_vph)
}

#[cfg(test)]
mod tests {
    use super::*;
    use Heading::{East, North, South, SouthWest, West};
    use Turn::{Left, Right, Through};

    #[test]
    fn a_bent_street_goes_on_by_the_names_of_directions() {
        // Arms in the north-east, south-east, south and west.
        let headings = [North, South, East, West];
        let directions =
            Directions { headings: &headings, arms: &[Some(2), Some(0), Some(3), Some(1)] };
        let northbound = [(3, Left), (0, Right), (1, Right)];
        assert!(directions.name_exits(North, &northbound));
        assert_eq!(
            by_turn([100.0, 400.0, 50.0], &northbound),
            ([100.0, 0.0, 450.0], [100.0, 400.0, 50.0, 0.0, 0.0])
        );
        let southbound = [(1, Left), (2, Left), (3, Through)];
        assert!(directions.name_exits(South, &southbound));
        assert_eq!(directions.ahead(South, &southbound), Some(East));
        // Bearings that agree, and exits in another order.
        assert!(!directions.name_exits(North, &[(3, Left), (0, Through), (1, Right)]));
        assert!(!directions.name_exits(North, &[(0, Left), (3, Right), (1, Right)]));
        let skew = Directions { headings: &[North, SouthWest], arms: &[Some(1), Some(0)] };
        assert_eq!(skew.ahead(North, &[(0, Through)]), None);
    }
}
