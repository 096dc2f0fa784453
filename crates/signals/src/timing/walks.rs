//! When pedestrians begin to walk under a program.
//!
//! - **Greens in a row** that serve a crosswalk are one walk, whatever yellow and red lies between them. It begins with the
//!   first of them.
//! - **Room**: walk and clearance must be over before somebody who is in the way gets green. Yellow and red before that
//!   belong to the clearance (MUTCD, section 4E.06). A row without room shows no walk.
//! - A crosswalk for which **no row** of a cycle has room is served in the longest one. Else its pedestrians would wait for
//!   ever. Our choice.

use super::{Timing, WALK_S, is_green};

/// What a phase of a program is to a crosswalk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Walk {
    /// Nobody may walk.
    No,
    /// A walk begins with it.
    Begins,
    /// A walk that began before goes on.
    GoesOn,
}

/// Phases in a row with one walk.
struct Row {
    /// The phase with which it begins.
    begin: usize,
    /// The phases after that one, to the last green.
    rest: Vec<usize>,
    /// Time from its begin until somebody who is in the way gets green, seconds.
    room_s: f64,
}

impl Timing {
    /// Returns what each phase of a program is to a crosswalk.
    ///
    /// # Arguments
    ///
    /// * `phases` — state and shortest duration in seconds, as they are shown one after the other.
    pub fn walks(&self, phases: &[(&str, f64)], crossing: usize) -> Vec<Walk> {
        let mut walks = vec![Walk::No; phases.len()];
        let rows = self.rows(phases, crossing);
        let longest_s = rows.iter().map(|row| row.room_s).fold(0.0, f64::max);
        let least_s = f64::from(self.crossing_s(crossing)).min(longest_s);
        for row in rows.iter().filter(|row| row.room_s >= least_s) {
            walks[row.begin] = Walk::Begins;
            row.rest.iter().for_each(|phase| walks[*phase] = Walk::GoesOn);
        }
        walks
    }

    /// Returns for each phase of a program walk and clearance, seconds: of the crosswalks whose walk begins with it and has
    /// room, the one that takes longest; `None` where none begins. Left turns with an arrow of their own always count.
    ///
    /// # Arguments
    ///
    /// * `phases` — as those of [`Self::walks`].
    pub fn longest_walks(&self, phases: &[(&str, f64)]) -> Vec<Option<[u32; 2]>> {
        let strict = Self { counts_unopposed_arrows: true, ..self.clone() };
        let mut longest: Vec<Option<u32>> = vec![None; phases.len()];
        for crossing in 0..strict.crossings() {
            let takes_s = strict.crossing_s(crossing);
            let rows = strict.rows(phases, crossing);
            for row in rows.iter().filter(|row| row.room_s >= f64::from(takes_s)) {
                longest[row.begin] = longest[row.begin].max(Some(takes_s));
            }
        }
        longest.into_iter().map(|takes_s| Some([WALK_S, takes_s? - WALK_S])).collect()
    }

    /// Returns the rows of phases that serve a crosswalk. Where every green serves it, each is a row.
    fn rows(&self, phases: &[(&str, f64)], crossing: usize) -> Vec<Row> {
        // Red from which vehicles may turn is red.
        let plain: Vec<(String, f64)> =
            phases.iter().map(|(state, s)| (state.replace('s', "r"), *s)).collect();
        let plain: Vec<(&str, f64)> = plain.iter().map(|(state, s)| (state.as_str(), *s)).collect();
        let greens = self.greens(&plain);
        let serves: Vec<bool> =
            greens.iter().map(|green| self.serves_crossing(plain[*green].0, crossing)).collect();
        let count = greens.len();
        let served = |place: usize| serves[place % count];
        let all = serves.iter().all(|served| *served);
        let begins = |place: &usize| served(*place) && (all || !served(place + count - 1));
        let row = |first: usize| {
            let length = if all { 1 } else { (first..).take_while(|p| served(*p)).count() };
            let (begin, last) = (greens[first], greens[(first + length - 1) % count]);
            let steps = (last + phases.len() - begin) % phases.len();
            Row {
                begin,
                rest: (1..=steps).map(|step| (begin + step) % phases.len()).collect(),
                room_s: self.room_s(phases, begin, crossing),
            }
        };
        (0..count).filter(begins).map(row).collect()
    }

    /// Returns the time from the begin of a phase until somebody who is in the way of a crosswalk gets green, seconds.
    fn room_s(&self, phases: &[(&str, f64)], begin: usize, crossing: usize) -> f64 {
        let cycle = (begin..begin + phases.len()).map(|phase| phases[phase % phases.len()]);
        let free = cycle.take_while(|(state, _)| !self.is_crossed(state, crossing));
        free.map(|(_, seconds)| seconds).sum()
    }

    /// Whether somebody has green who is in the way of a crosswalk.
    fn is_crossed(&self, shown: &str, crossing: usize) -> bool {
        let greens = shown.chars().enumerate().filter(|(_, letter)| is_green(*letter));
        let mut ways =
            greens.flat_map(|(index, letter)| self.ways(index).map(move |way| (way, letter)));
        ways.any(|(way, letter)| self.is_in_the_way(way.approach, way.turn, letter, crossing))
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{LEFT, OTHER, THROUGH, cross, field};
    use super::*;
    use crate::settings::SignalSettings;

    /// Green for the north, yellow and red but for its right turn.
    const NORTH: [&str; 3] = ["GGGrrrrrrrrr", "Gyyrrrrrrrrr", "Grrrrrrrrrrr"];

    /// A cycle with seconds for the north alone, for north and south, and for the cross street.
    fn program(seconds: [f64; 3]) -> Vec<(&'static str, f64)> {
        vec![
            (NORTH[0], seconds[0]),
            (NORTH[1], 4.0),
            (NORTH[2], 1.0),
            (THROUGH, seconds[1]),
            ("yyyrrryyyrrr", 4.0),
            (OTHER, seconds[2]),
            ("rrryyyrrryyy", 4.0),
        ]
    }

    #[test]
    fn a_walk_goes_on_over_the_yellow_between_greens_that_both_serve_it() {
        use Walk::{Begins, GoesOn, No};
        let timing = cross(&field());
        // The west in both greens, the east beside the second alone, whose 15 + 4 s are enough.
        let program = program([8.0, 15.0, 19.0]);
        assert_eq!(timing.walks(&program, 3), [Begins, GoesOn, GoesOn, GoesOn, No, No, No]);
        assert_eq!(timing.walks(&program, 1), [No, No, No, Begins, No, No, No]);
        assert_eq!(timing.walks(&program, 0), [No, No, No, No, No, Begins, No]);
    }

    #[test]
    fn no_walk_begins_whose_clearance_would_meet_a_green() {
        use Walk::{Begins, No};
        let timing = cross(&field());
        let short = [(THROUGH, 30.0), (OTHER, 20.0), (THROUGH, 10.0), (LEFT, 9.0)];
        // The left turns of the last green go over both crosswalks of the first one.
        assert_eq!(timing.walks(&short, 3), [Begins, No, No, No]);
        // Too short in every row: the longest one.
        let shorter = [(THROUGH, 12.0), (OTHER, 20.0), (THROUGH, 10.0), (LEFT, 9.0)];
        assert_eq!(timing.walks(&shorter, 3), [Begins, No, No, No]);
        assert_eq!(timing.walks(&[(THROUGH, 9.0), (THROUGH, 9.0)], 3), [Begins, Begins]);
    }

    #[test]
    fn a_phase_has_the_longest_clearance_that_begins_in_it() {
        let mut timing = cross(&field());
        timing.approaches[3].width_m = 30.0;
        let mut program = program([20.0, 15.0, 19.0]);
        // 36 s in the west, over the first four phases and the yellow after them.
        let [west, others]: [Option<[u32; 2]>; 2] = [Some([7, 29]), Some([7, 12])];
        let expected = vec![west, None, None, others, None, others, None];
        assert_eq!(timing.longest_walks(&program), expected);
        program[0].1 = 10.0;
        assert_eq!(timing.longest_walks(&program)[0], None, "10 + 5 + 15 + 4 s are too short");
        let without = cross(&SignalSettings { pedestrians: false, ..field() });
        assert!(without.longest_walks(&program).iter().all(Option::is_none));
    }
}
