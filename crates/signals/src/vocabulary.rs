//! Words that whoever builds, simulates and controls signals shares; those of the ground, such as
//! [`Turn`], are in `osm_signals`.

use std::fmt::{self, Display};

use osm_signals::{DrivingSide, Turn};

/// Width of a lane of which a network says nothing, metres (SUMO's default).
pub const DEFAULT_LANE_WIDTH_M: f64 = 3.2;

/// The order in which engineers list directions, and turns.
const ORDER: ([&str; 8], &str) = (["NB", "SB", "EB", "WB", "NE", "NW", "SE", "SW"], "LTR");

/// A direction of travel: `NB` is northbound, so the vehicles come from the south.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Heading {
    /// Northbound.
    North,
    /// Northeastbound.
    NorthEast,
    /// Eastbound.
    East,
    /// Southeastbound.
    SouthEast,
    /// Southbound.
    South,
    /// Southwestbound.
    SouthWest,
    /// Westbound.
    West,
    /// Northwestbound.
    NorthWest,
}

impl Heading {
    /// All of them, clockwise from north.
    pub const ALL: [Self; 8] = [
        Self::North,
        Self::NorthEast,
        Self::East,
        Self::SouthEast,
        Self::South,
        Self::SouthWest,
        Self::West,
        Self::NorthWest,
    ];

    /// Returns the short name, as in `NBL`.
    pub fn name(self) -> &'static str {
        ["NB", "NE", "EB", "SE", "SB", "SW", "WB", "NW"][self as usize]
    }

    /// Returns the direction with which a name begins, such as that of `NBL` or of the arm `NB Main St`.
    pub fn begins(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|heading| name.starts_with(heading.name()))
    }

    /// Returns the direction and the turn of a movement's name, such as `NBL`; `None` for one that is no movement. A
    /// second left or right (`NBL2`) is one of several exits on that side. U-turns count as the turns across opposing
    /// traffic, which depend on the side that traffic keeps to.
    pub fn of_movement(name: &str, side: DrivingSide) -> Option<(Self, Turn)> {
        let heading = Self::begins(name)?;
        let turn = match &name[heading.name().len()..] {
            "L" | "L2" => Turn::Left,
            "U" => Turn::across(side),
            "T" => Turn::Through,
            "R" | "R2" => Turn::Right,
            _ => return None,
        };
        Some((heading, turn))
    }

    /// Returns the direction of travel, degrees clockwise from north.
    pub fn degrees(self) -> f64 {
        45.0 * f64::from(self as u8)
    }
}

impl Display for Heading {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What a movement sees in a phase, from worst to best.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Light {
    /// Stop.
    Red,
    /// Green after yielding (`g`).
    Permissive,
    /// Green with right of way (`G`).
    Protected,
}

impl Light {
    /// Returns its name, such as `red`.
    pub fn name(self) -> &'static str {
        ["red", "permissive", "protected"][self as usize]
    }

    /// Returns SUMO's letter.
    pub fn letter(self) -> char {
        match self {
            Self::Red => 'r',
            Self::Permissive => 'g',
            Self::Protected => 'G',
        }
    }

    /// Returns what SUMO's letter means; whatever is no green is red.
    pub fn of_letter(letter: char) -> Self {
        match letter {
            'G' => Self::Protected,
            'g' => Self::Permissive,
            _ => Self::Red,
        }
    }
}

/// Whether a green link that yields (`g`) meets another link in a state.
pub fn is_met_by_yielding(state: &str, link: usize, meet: &dyn Fn(usize, usize) -> bool) -> bool {
    state.chars().enumerate().any(|(other, letter)| letter == 'g' && meet(link, other))
}

/// Returns a state with SUMO's `s` in place of red for the links that may be used on red. Beside a green link that yields
/// and meets it, such a link stays red: SUMO refuses two links that yield to each other.
///
/// # Arguments
///
/// * `may` — shape `[L]`; links beyond it may not.
/// * `meet` — whether the paths of two links meet.
pub fn on_red(state: &str, may: &[bool], meet: &dyn Fn(usize, usize) -> bool) -> String {
    let letter = |(link, letter): (usize, char)| match letter {
        'r' if may.get(link) == Some(&true) && !is_met_by_yielding(state, link, meet) => 's',
        _ => letter,
    };
    state.chars().enumerate().map(letter).collect()
}

/// Returns the place of a movement in the order in which engineers list them, by its name.
pub fn listed_before(name: &str) -> (Option<usize>, Option<usize>) {
    let (directions, turns) = ORDER;
    let direction = directions.iter().position(|direction| name.starts_with(direction));
    (direction, name.get(2..3).and_then(|turn| turns.find(turn)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn u_turns_are_turns_across_opposing_traffic() {
        let turn = |side| Heading::of_movement("NBU", side);
        assert_eq!(turn(DrivingSide::Right), Some((Heading::North, Turn::Left)));
        assert_eq!(turn(DrivingSide::Left), Some((Heading::North, Turn::Right)));
    }

    #[test]
    fn letters_of_greens_read_back_and_others_are_red() {
        for light in [Light::Red, Light::Permissive, Light::Protected] {
            assert_eq!(Light::of_letter(light.letter()), light);
        }
        assert_eq!(['y', 's', 'O'].map(Light::of_letter), [Light::Red; 3]);
    }
}
