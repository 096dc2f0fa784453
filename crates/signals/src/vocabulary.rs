//! Words that whoever builds, simulates and controls signals shares; those of the ground, such as
//! [`Turn`], are in `osm_signals`.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::{self, Display};

use osm_signals::angle::normalise_degrees;
use osm_signals::{DrivingSide, Turn};

/// Width of a lane of which a network says nothing, metres (SUMO's default).
pub const DEFAULT_LANE_WIDTH_M: f64 = 3.2;

/// Most degrees between a direction of travel that has a name and the way in which vehicles travel that it may be.
pub const MOST_OFF_DEG: f64 = 80.0;

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

    /// Returns the directions with which the names of arms begin, such as that of `NB Main St`; `None` unless each begins
    /// with another one.
    pub fn told<'a>(names: impl Iterator<Item = &'a str>) -> Option<Vec<Self>> {
        let told = names.map(|name| {
            let first = name.split_whitespace().next()?;
            Self::ALL.into_iter().find(|heading| heading.name() == first)
        });
        told.collect::<Option<Vec<Self>>>().filter(|told| are_distinct(told))
    }

    /// Returns the directions of the approaches of a signal: the four of the compass as long as they tell the approaches
    /// apart, else eight.
    ///
    /// # Arguments
    ///
    /// * `headings_deg` — how their vehicles travel, on the ground.
    pub fn of_approaches(headings_deg: &[f64]) -> Vec<Self> {
        let nearest = |parts: usize| -> Vec<Self> {
            let step_deg = 360.0 / parts as f64;
            let part = |deg: &f64| (normalise_degrees(*deg) / step_deg).round() as usize % parts;
            let every = Self::ALL.len() / parts;
            headings_deg.iter().map(|deg| Self::ALL[part(deg) * every]).collect()
        };
        let four = nearest(4);
        if are_distinct(&four) { four } else { nearest(Self::ALL.len()) }
    }

    /// Returns the direction and the turn of a movement's name, such as `NBL`; `None` for one that is no movement. One with
    /// a number (`NBL2`) is one of several exits, see [`movement_names`]. U-turns count as the turns across opposing
    /// traffic, which depend on the side that traffic keeps to.
    pub fn of_movement(name: &str, side: DrivingSide) -> Option<(Self, Turn)> {
        let heading = Self::begins(name)?;
        let rest = &name[heading.name().len()..];
        if rest == "U" {
            return Some((heading, Turn::across(side)));
        }
        let mut turns = [Turn::Left, Turn::Through, Turn::Right].into_iter();
        let turn = turns.find(|turn| rest.starts_with(turn.letter()))?;
        let (written, number) = (&rest[1..], number_in(name));
        let is_plain = written.is_empty() || number > 1 && written == number.to_string();
        is_plain.then_some((heading, turn))
    }

    /// Returns the direction so many eighths of a circle clockwise.
    pub fn clockwise(self, eighths: usize) -> Self {
        Self::ALL[(self as usize + eighths) % Self::ALL.len()]
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

fn are_distinct(headings: &[Heading]) -> bool {
    headings.iter().collect::<BTreeSet<_>>().len() == headings.len()
}

/// Returns the names of the movements of a signal, such as `NBL`: of several that have one name, the later ones get a number
/// (`NBL2`).
///
/// # Arguments
///
/// * `movements` — direction of travel and turn on the ground, in the order of their links.
pub fn movement_names(movements: impl Iterator<Item = (Heading, Turn)>) -> Vec<String> {
    let mut named: BTreeMap<(Heading, Turn), u32> = BTreeMap::new();
    let mut names = Vec::new();
    for (heading, turn) in movements {
        let count = named.entry((heading, turn)).or_default();
        *count += 1;
        let number = if *count > 1 { count.to_string() } else { String::new() };
        names.push(format!("{heading}{}{number}", turn.letter()));
    }
    names
}

/// Returns which of several movements of one name a movement is: 2 for `NBL2`, and 1 for `NBL`.
pub fn number_in(name: &str) -> u32 {
    let number = name.trim_start_matches(|letter: char| !letter.is_ascii_digit());
    number.parse().unwrap_or(1)
}

/// Returns a turn on the ground as right-hand traffic has it, or the other way round.
pub fn on_side(turn: Turn, side: DrivingSide) -> Turn {
    if side.is_right() { turn } else { turn.mirrored() }
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

/// Returns names of movements as engineers list them, each once.
pub fn listed<'a>(names: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut listed: Vec<String> = Vec::new();
    for name in names {
        if !listed.iter().any(|other| other == name) {
            listed.push(name.to_owned());
        }
    }
    listed.sort_by_key(|name| listed_before(name));
    listed
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
    fn names_of_movements_read_back_with_their_numbers() {
        let all = [
            (Heading::North, Turn::Right),
            (Heading::North, Turn::Through),
            (Heading::North, Turn::Through),
            (Heading::North, Turn::Left),
            (Heading::SouthWest, Turn::Left),
            (Heading::North, Turn::Left),
            (Heading::North, Turn::Left),
        ];
        let names = movement_names(all.into_iter());
        assert_eq!(names, ["NBR", "NBT", "NBT2", "NBL", "SWL", "NBL2", "NBL3"]);
        for (name, way) in names.iter().zip(all) {
            assert_eq!(Heading::of_movement(name, DrivingSide::Right), Some(way), "{name}");
        }
        assert_eq!(["NBL", "NBT2", "NBL3"].map(number_in), [1, 2, 3]);
        for name in ["NB", "NBX", "NBL1", "NBL02", "NBL+2", "NBLL", "NBU2", "NB\u{c4}", "L2"] {
            assert_eq!(Heading::of_movement(name, DrivingSide::Right), None, "{name}");
        }
    }

    #[test]
    fn approaches_have_four_directions_or_eight_or_those_of_their_arms() {
        use Heading::{East, North, NorthWest, South, SouthWest, West};
        let of = Heading::of_approaches;
        assert_eq!(of(&[182.0, 85.0]), [South, East]);
        assert_eq!(of(&[182.0, 215.0, 320.0, 275.0]), [South, SouthWest, NorthWest, West]);
        let told = |names: &[&str]| Heading::told(names.iter().copied());
        assert_eq!(told(&["NB Main St", "EB"]), Some(vec![North, East]));
        assert_eq!(told(&["NB Main St", "NB 5th"]), None);
        assert_eq!(told(&["NB Main St", "A"]), None);
        assert_eq!(told(&["NBound"]), None);
    }

    #[test]
    fn letters_of_greens_read_back_and_others_are_red() {
        for light in [Light::Red, Light::Permissive, Light::Protected] {
            assert_eq!(Light::of_letter(light.letter()), light);
        }
        assert_eq!(['y', 's', 'O'].map(Light::of_letter), [Light::Red; 3]);
    }
}
