//! Programs as SUMO runs them: which of their phases are greens, and whether they keep to the limits.

use super::Timing;
use crate::needs::Need;

/// Longest time that a state after yellow is taken for all-red although some link stays green in it,
/// seconds; a lagging green lasts longer.
const MAX_LINGERING_S: f64 = 4.0;

impl Timing {
    /// Returns which phases of a program are greens, in their order: some link is green, none yellow, and it
    /// is no all-red in which links stay green that are so before and after.
    ///
    /// Such an all-red is the yellow before it with red for yellow, and as short as ours would be there, or
    /// shorter than any green; a green for those links alone, such as a lagging left turn, may look the same
    /// but lasts longer.
    ///
    /// # Arguments
    ///
    /// * `phases` — state and duration in seconds, as SUMO runs them one after the other.
    pub fn greens(&self, phases: &[(&str, f64)]) -> Vec<usize> {
        let at = |i: usize| phases[i % phases.len()];
        let is_yellow = |state: &str| state.contains(['y', 'Y', 'u']);
        let lingers = |i: usize| {
            let before = i + phases.len() - 1;
            if !is_yellow(at(before).0) || at(before).0.replace(['y', 'Y', 'u'], "r") != at(i).0 {
                return false;
            }
            let from = (1..phases.len()).map(|k| at(before + phases.len() - k).0);
            let from = from.into_iter().find(|state| !is_yellow(state)).unwrap_or_default();
            let ours_s = self.change(from, at(i + 1).0).map_or(0, |change| change.all_red_s);
            at(i).1 <= MAX_LINGERING_S.max(f64::from(ours_s))
        };
        (0..phases.len())
            .filter(|i| {
                let state = phases[*i].0;
                state.contains(['G', 'g']) && !is_yellow(state) && !lingers(*i)
            })
            .collect()
    }

    /// Whether the greens and changes of a program of fixed durations keep to the limits.
    ///
    /// # Arguments
    ///
    /// * `phases` — state and duration in seconds, as SUMO runs them one after the other.
    pub fn keeps(&self, phases: &[(&str, f64)]) -> bool {
        let greens = self.greens(phases);
        if greens.len() < 2 {
            return true;
        }
        let states: Vec<&str> = greens.iter().map(|i| phases[*i].0).collect();
        let needs = self.needs(&states);
        let lasts = |i: usize| {
            let (state, seconds) = phases[i];
            seconds <= self.max_green_s(state).map_or(f64::INFINITY, f64::from)
        };
        // From the green at `start` to the last one in a row that serves a need, changes included.
        let carries = |need: &Need, start: usize| {
            let count = greens.len();
            let row = (start..start + count).take_while(|k| need.served[k % count]);
            let last = greens[row.last().unwrap_or(start) % count];
            let (mut i, mut lasts_s) = (greens[start], phases[greens[start]].1);
            while i != last {
                i = (i + 1) % phases.len();
                lasts_s += phases[i].1;
            }
            lasts_s >= f64::from(need.least_s)
        };
        let serves = |need: &Need| {
            let begins =
                |k: &usize| need.served[*k] && !need.served[(k + greens.len() - 1) % greens.len()];
            (0..greens.len()).filter(begins).all(|start| carries(need, start))
        };
        let changes = |k: usize| {
            let (from, to) = (greens[k], greens[(k + 1) % greens.len()]);
            let (mut yellow_s, mut rest_s) = (0.0, 0.0);
            let mut i = (from + 1) % phases.len();
            while i != to {
                let (state, seconds) = phases[i];
                let time_s = if state.contains(['y', 'Y']) { &mut yellow_s } else { &mut rest_s };
                *time_s += seconds;
                i = (i + 1) % phases.len();
            }
            self.change(phases[from].0, phases[to].0).is_none_or(|least| {
                yellow_s >= f64::from(least.yellow_s) && rest_s >= f64::from(least.all_red_s)
            })
        };
        greens.iter().all(|i| lasts(*i))
            && needs.iter().all(serves)
            && (0..greens.len()).all(changes)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{OTHER, THROUGH, cross, field};
    use crate::settings::SignalSettings;

    #[test]
    fn an_all_red_in_which_a_left_turn_stays_green_is_no_green_but_a_lagging_left_is() {
        let program = |left_s| {
            vec![
                ("GGg", 30.0),
                ("yyg", 4.0),
                ("rrg", left_s),
                ("rrG", 6.0),
                ("rry", 4.0),
                ("rrr", 1.0),
            ]
        };
        let timing = cross(&field());
        assert_eq!(timing.greens(&program(2.0)), [0, 3]);
        assert_eq!(timing.greens(&program(5.0)), [0, 2, 3]);
        // The yellow of the last phase comes before the first.
        assert_eq!(timing.greens(&[("rG", 2.0), ("GG", 9.0), ("yG", 3.0)]), [1]);
        let long = cross(&SignalSettings { all_red_s: 5, ..field() });
        assert_eq!(long.greens(&program(5.0)), [0, 3]);
    }

    #[test]
    fn a_program_keeps_to_the_limits_or_does_not() {
        let keeps = |green_s: f64, yellow_s: f64, red_s: f64| {
            cross(&field()).keeps(&[
                (THROUGH, green_s),
                ("yyyrrryyyrrr", yellow_s),
                ("rrrrrrrrrrrr", red_s),
                (OTHER, 30.0),
                ("rrryyyrrryyy", 4.0),
                ("rrrrrrrrrrrr", 1.0),
            ])
        };
        assert!(keeps(19.0, 4.0, 1.0) && keeps(60.0, 5.0, 2.0));
        assert!(!keeps(18.0, 4.0, 1.0) && !keeps(61.0, 4.0, 1.0));
        assert!(!keeps(30.0, 3.0, 2.0) && !keeps(30.0, 4.0, 0.0));
        assert!(cross(&field()).keeps(&[(THROUGH, 90.0)]));
    }
}
