//! Words that whoever builds, simulates and controls signals shares; those of the ground, such as
//! [`Turn`](osm_signals::Turn), are in `osm_signals`.

/// Width of a lane of which a network says nothing, metres (SUMO's default).
pub const DEFAULT_LANE_WIDTH_M: f64 = 3.2;

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_of_greens_read_back_and_others_are_red() {
        for light in [Light::Red, Light::Permissive, Light::Protected] {
            assert_eq!(Light::of_letter(light.letter()), light);
        }
        assert_eq!(['y', 's', 'O'].map(Light::of_letter), [Light::Red; 3]);
    }
}
