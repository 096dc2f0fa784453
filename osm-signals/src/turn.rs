//! Turns across an intersection: which exit lies to the left, straight ahead and to the right.
//!
//! Only bearings decide, so that any number of arms works.
//!
//! Choices where implementations differ:
//! - **Through** is the exit closest to straight ahead, if it is less than
//!   [`THROUGH_LIMIT_DEG`] off; of two that are equally close, the one on the right, in left-hand traffic the one on
//!   the left. Every other exit is a left or a right turn by its side, so there may be several of each.
//! - **U-turns** do not exist.

use serde::Serialize;

use super::angle::{normalise_degrees, turn_degrees};
use super::driving_side::DrivingSide;

/// Largest turn of a movement that goes through, degrees; half of a right angle.
pub const THROUGH_LIMIT_DEG: f64 = 45.0;

/// Category of a movement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Turn {
    /// To the left.
    Left,
    /// Straight on.
    Through,
    /// To the right.
    Right,
}

impl Turn {
    /// Returns its name, such as `left`.
    pub fn name(self) -> &'static str {
        ["left", "through", "right"][self as usize]
    }

    /// Returns the letter that engineers give it, such as that of `NBL`.
    pub fn letter(self) -> char {
        ['L', 'T', 'R'][self as usize]
    }

    /// Returns the turn across opposing traffic, which U-turns count as.
    pub fn across(side: DrivingSide) -> Self {
        if side.is_right() { Self::Left } else { Self::Right }
    }

    /// Returns the turn with left and right exchanged.
    #[must_use]
    pub fn mirrored(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Through => Self::Through,
            Self::Right => Self::Left,
        }
    }
}

/// Turns that exist from an arm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Turns {
    /// Left turns.
    pub left: bool,
    /// Straight on.
    pub through: bool,
    /// Right turns.
    pub right: bool,
}

impl Turns {
    /// All three.
    pub const ALL: Self = Self { left: true, through: true, right: true };

    /// None of them.
    pub const NONE: Self = Self { left: false, through: false, right: false };

    /// Returns whether a turn exists.
    pub fn has(self, turn: Turn) -> bool {
        match turn {
            Turn::Left => self.left,
            Turn::Through => self.through,
            Turn::Right => self.right,
        }
    }

    /// Returns these turns and another one.
    #[must_use]
    pub fn with(self, turn: Turn) -> Self {
        match turn {
            Turn::Left => Self { left: true, ..self },
            Turn::Through => Self { through: true, ..self },
            Turn::Right => Self { right: true, ..self },
        }
    }

    /// Returns the turns with left and right exchanged.
    #[must_use]
    pub fn mirrored(self) -> Self {
        Self { left: self.right, right: self.left, ..self }
    }
}

/// Returns the exits from an arm on the ground with the turns that lead to them, leftmost first. Those of left-hand
/// traffic are decided in the mirror, as in its networks.
pub fn exits_on<Id: Copy>(
    side: DrivingSide,
    from_deg: f64,
    others: impl IntoIterator<Item = (Id, f64)>,
) -> Vec<(Id, Turn)> {
    let right_hand_deg = |bearing_deg: f64| side.bearing_deg(normalise_degrees(bearing_deg));
    let others = others.into_iter().map(|(to, bearing_deg)| (to, right_hand_deg(bearing_deg)));
    let mut found = exits(right_hand_deg(from_deg), others);
    if !side.is_right() {
        found.reverse();
        found.iter_mut().for_each(|(_, turn)| *turn = turn.mirrored());
    }
    found
}

/// Returns the exits from an arm of right-hand traffic with the turns that lead to them, leftmost first.
///
/// * `from_deg` — bearing of the arm that vehicles come from, degrees clockwise from north.
/// * `exits` — the other arms that lead away: whatever names them, and their bearings, degrees.
///
/// # Examples
///
/// ```
/// use osm_signals::turn::{Turn, exits};
///
/// let from_the_north = exits(0.0, [("east", 90.0), ("south", 180.0), ("west", 270.0)]);
/// assert_eq!(from_the_north, [("east", Turn::Left), ("south", Turn::Through), ("west", Turn::Right)]);
/// ```
pub fn exits<Id: Copy>(
    from_deg: f64,
    exits: impl IntoIterator<Item = (Id, f64)>,
) -> Vec<(Id, Turn)> {
    let heading_deg = from_deg + 180.0;
    let others = exits.into_iter();
    let mut exits: Vec<(f64, Id)> =
        others.map(|(to, bearing_deg)| (turn_degrees(heading_deg, bearing_deg), to)).collect();
    exits.sort_by(|a, b| a.0.total_cmp(&b.0));
    let through = exits
        .iter()
        .enumerate()
        .filter(|(_, (turn_deg, _))| turn_deg.abs() < THROUGH_LIMIT_DEG)
        .min_by(|(_, a), (_, b)| a.0.abs().total_cmp(&b.0.abs()).then(b.0.total_cmp(&a.0)))
        .map(|(position, _)| position);
    let turn = |position: usize, turn_deg: f64| match turn_deg {
        _ if through == Some(position) => Turn::Through,
        d if d < 0.0 => Turn::Left,
        _ => Turn::Right,
    };
    let exits = exits.into_iter().enumerate();
    exits.map(|(position, (turn_deg, to))| (to, turn(position, turn_deg))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_two_exits_as_close_to_straight_on_the_outer_side_decides() {
        let from_the_south = |side| exits_on(side, 180.0, [("right", 20.0), ("left", 340.0)]);
        assert_eq!(
            from_the_south(DrivingSide::Right),
            [("left", Turn::Left), ("right", Turn::Through)]
        );
        assert_eq!(
            from_the_south(DrivingSide::Left),
            [("left", Turn::Through), ("right", Turn::Right)]
        );
    }
}
