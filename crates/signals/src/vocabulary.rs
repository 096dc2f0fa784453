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
