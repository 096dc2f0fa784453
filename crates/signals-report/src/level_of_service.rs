//! Level of service of a signalised intersection by its control delay per vehicle.
//!
//! Deviation: the thresholds are meant for control delay; here they are applied to the delay that the
//! simulator reports, which also contains slowing down behind other vehicles and waiting to enter.
//!
//! Source: Transportation Research Board, "Highway Capacity Manual", 7th edition (2022), exhibit
//! 19-8, without the rule that a volume above capacity is F at any delay.

/// The levels, best first.
pub const LEVELS: [char; 6] = ['A', 'B', 'C', 'D', 'E', 'F'];

/// Longest delay of the levels A to E, seconds per vehicle; anything longer is F.
pub const THRESHOLDS_S: [f64; 5] = [10.0, 20.0, 35.0, 55.0, 80.0];

/// Name of the objective that levels of service are defined for.
pub const DELAY: &str = "delay_s";

/// Returns the position of the level in [`LEVELS`].
pub fn level(delay_s: f64) -> usize {
    THRESHOLDS_S.iter().filter(|t| delay_s > **t).count()
}

/// Returns the letter of a level.
pub fn letter(delay_s: f64) -> char {
    LEVELS[level(delay_s)]
}

/// Returns the share of the weight at each level; all 0 of nothing.
pub fn shares(weighted_delays_s: impl IntoIterator<Item = (f64, f64)>) -> [f64; LEVELS.len()] {
    let mut shares = [0.0; LEVELS.len()];
    let mut total = 0.0;
    for (weight, delay_s) in weighted_delays_s {
        shares[level(delay_s)] += weight;
        total += weight;
    }
    shares.map(|share| if total > 0.0 { share / total } else { 0.0 })
}

/// Returns the range of delays of a level in words.
pub fn range(level: usize) -> String {
    match level {
        0 => format!("at most {} s", THRESHOLDS_S[0]),
        l if l < THRESHOLDS_S.len() => format!("{} to {} s", THRESHOLDS_S[l - 1], THRESHOLDS_S[l]),
        _ => format!("over {} s", THRESHOLDS_S[THRESHOLDS_S.len() - 1]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_threshold_belongs_to_the_better_level() {
        let letters: String =
            [10.0, 10.1, 20.0, 35.0, 55.0, 80.0, 80.1].map(letter).iter().collect();
        assert_eq!(letters, "ABBCDEF");
    }

    #[test]
    fn shares_follow_the_weights() {
        assert_eq!(shares([(1.0, 5.0), (3.0, 90.0)]), [0.25, 0.0, 0.0, 0.0, 0.0, 0.75]);
    }

    #[test]
    fn ranges_read_as_words() {
        assert_eq!([range(0), range(1), range(5)], ["at most 10 s", "10 to 20 s", "over 80 s"]);
    }
}
