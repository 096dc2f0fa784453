//! Who crosses beside a green, what greens must be long enough for, and when pedestrians begin to walk under a program.
//!
//! - **Greens in a row** that serve a crosswalk are one walk, whatever yellow and red lies between them. It begins with the
//!   first of them.
//! - **Room**: walk and clearance must be over before somebody who is in the way gets green. Yellow and red before that
//!   belong to the clearance (MUTCD, section 4E.06). A row without room shows no walk.
//! - A crosswalk for which **no row** of a cycle has room is served in the longest one. Else its pedestrians would wait for
//!   ever. Our choice.

use osm_signals::Turn;
use osm_signals::angle::turn_degrees;

use super::{CROSSING_DEG, Timing, Way, beside, is_green};
use crate::needs::{Need, least_greens_s};
use crate::vocabulary::DEFAULT_LANE_WIDTH_M;

/// Time in which pedestrians begin to walk, seconds (HCM, MUTCD).
pub const WALK_S: u32 = 7;

/// Speed of pedestrians, metres per second (HCM, MUTCD: 3.5 ft/s).
pub const WALKING_MPS: f64 = 1.067;

/// Approaches up to which a left turn without an opposite approach has no arrow: those of a T and of a Y, where it is
/// what its green is for, and yields to those who walk.
const LEGS_OF_A_T: usize = 3;

/// Angle from which approaches are opposite, degrees: beyond [`CROSSING_DEG`].
const OPPOSITE_DEG: f64 = 150.0;

impl Timing {
    /// Returns how many crosswalks there are: one across each approach; none where pedestrians do not count.
    pub fn crossings(&self) -> usize {
        if self.settings.pedestrians { self.approaches.len() } else { 0 }
    }

    /// Closes the crosswalks that no green of a program serves.
    pub fn close_crosswalks_without(&mut self, greens: &[String]) {
        let serves = |approach| greens.iter().any(|green| self.serves_crossing(green, approach));
        self.closed = (0..self.approaches.len()).map(|approach| !serves(approach)).collect();
    }

    /// Whether every green beside a crosswalk lasts until pedestrians have crossed.
    pub fn recalls_pedestrians(&self) -> bool {
        self.settings.pedestrian_calls_per_h.is_none()
    }

    /// Returns the walk and clearance of the crosswalk of an approach, seconds.
    pub fn crossing_s(&self, approach: usize) -> u32 {
        beside(f64::from(WALK_S) + self.crosswalk_m(approach) / WALKING_MPS)[1]
    }

    /// Returns the length of the crosswalk of an approach, metres: what those clear, too, who cross the street.
    pub fn crosswalk_m(&self, approach: usize) -> f64 {
        let approach = &self.approaches[approach];
        let wider_m =
            self.settings.lane_width_m.map_or(0.0, |lane_m| lane_m - DEFAULT_LANE_WIDTH_M);
        approach.width_m + wider_m * f64::from(approach.plain_lanes)
    }

    /// Returns which phase of a plan lets people cross an approach: of those that do, that whose through movement has the
    /// crosswalk at its right, else that with most links; a phase for people alone comes last.
    ///
    /// # Arguments
    ///
    /// * `states` — per phase with a walk the state in which all its links are green, and no other.
    pub fn walker(&self, states: &[Option<String>], approach: usize) -> Option<usize> {
        let heading_deg = |approach: usize| self.approaches[approach].heading_deg;
        let is_left_of = |(way, _): (&Way, char)| {
            let turn_deg = turn_degrees(heading_deg(way.approach), heading_deg(approach));
            way.turn == Turn::Through && CROSSING_DEG.contains(&-turn_deg)
        };
        let rank = |(phase, state): (usize, &Option<String>)| {
            let state = state.as_deref()?;
            let size = self.moving(state, is_green).count();
            let serves = size == 0 || self.serves_crossing(state, approach);
            serves.then(|| (self.moving(state, is_green).any(is_left_of), size, phase))
        };
        states.iter().enumerate().filter_map(rank).max().map(|(.., phase)| phase)
    }

    /// Whether pedestrians can cross an approach beside what is shown: its crosswalk is open, somebody who does not turn
    /// right has green, and nobody who has green or yellow is in their way.
    pub fn serves_crossing(&self, shown: &str, approach: usize) -> bool {
        // Right turns alone stay green while a street changes.
        let mut green = self.moving(shown, is_green);
        let moves = |letter| is_green(letter) || matches!(letter, 'y' | 'Y' | 'u');
        !self.closed[approach]
            && green.any(|(way, _)| way.turn != Turn::Right)
            && !self.is_met(self.moving(shown, moves), approach)
            && !self.is_left_only(shown)
    }

    /// Whether vehicles on some ways are in the way of those who cross an approach.
    fn is_met<'a>(&self, mut ways: impl Iterator<Item = (&'a Way, char)>, crossed: usize) -> bool {
        ways.any(|(way, letter)| self.is_in_the_way(way, letter, crossed))
    }

    /// Whether vehicles of an approach that turn like this are in the way of those who cross another one.
    fn is_in_the_way(
        &self,
        &Way { approach: from, turn }: &Way,
        letter: char,
        crossed: usize,
    ) -> bool {
        if from == crossed {
            return turn != Turn::Right;
        }
        let angle = |a: usize, b: usize| {
            turn_degrees(self.approaches[a].heading_deg, self.approaches[b].heading_deg)
        };
        match turn {
            Turn::Right => false,
            Turn::Through => angle(from, crossed).abs() >= OPPOSITE_DEG,
            Turn::Left => {
                let opposed =
                    (0..self.approaches.len()).any(|o| angle(from, o).abs() >= OPPOSITE_DEG);
                let has_arrow =
                    opposed || self.counts_unopposed_arrows && self.approaches.len() > LEGS_OF_A_T;
                // Yellow tells nothing of the green before it.
                letter != 'g' && has_arrow && CROSSING_DEG.contains(&angle(from, crossed))
            }
        }
    }

    /// Returns the shortest time that a green may last, seconds, if what follows serves nothing of it;
    /// crosswalks count that are served in every cycle.
    pub fn min_green_s(&self, green: &str) -> u32 {
        self.alone_s(green, self.recalls_pedestrians())
    }

    /// Returns the longest time that a green may last, seconds; a shortest green that is longer counts
    /// more, also one that a push button asks for.
    pub fn max_green_s(&self, green: &str) -> Option<u32> {
        self.settings.max_green_s.map(|max| max.max(self.alone_s(green, true)))
    }

    /// Returns the shortest time of a green with or without pedestrians, seconds, if what follows serves nothing of it.
    pub fn alone_s(&self, green: &str, pedestrians: bool) -> u32 {
        let s = &self.settings;
        if !s.pedestrians {
            return if self.is_left_only(green) { s.min_left_green_s } else { s.min_green_s };
        }
        let needs = self.needs(&[green]);
        let counts = |need: &&Need| need.served[0] && (pedestrians || need.crossing.is_none());
        needs.iter().filter(counts).map(|need| need.least_s).max().unwrap_or(s.min_green_s)
    }

    /// Returns what greens must be long enough for. Without pedestrians that is a time for each; with them it is
    /// a time for each movement and each crosswalk, over greens in a row that serve it, and a floor for each
    /// green.
    pub fn needs(&self, greens: &[&str]) -> Vec<Need> {
        let s = &self.settings;
        let alone = |(i, least_s)| Need::of_green(i, greens.len(), least_s);
        if !s.pedestrians {
            let own = greens.iter().map(|green| self.alone_s(green, false));
            return own.enumerate().map(alone).collect();
        }
        let serves = |green: &str, approach: usize, turn: Turn| {
            self.served(green, approach).any(|t| t == turn)
        };
        let approaches = 0..self.approaches.len();
        let floor = |green: &&str| {
            let turns_right_only =
                approaches.clone().all(|a| self.served(green, a).all(|turn| turn == Turn::Right));
            if turns_right_only { s.min_green_s } else { s.min_green_s.min(s.min_left_green_s) }
        };
        let mut needs: Vec<Need> = greens.iter().map(floor).enumerate().map(alone).collect();
        let mut add = |least_s: u32, crossing: Option<usize>, serves: &dyn Fn(&str) -> bool| {
            let served = greens.iter().map(|green| serves(green)).collect();
            needs.push(Need { served, least_s, crossing });
        };
        for approach in approaches.clone() {
            let through = Way { approach, turn: Turn::Through };
            let has_through = self.links.iter().flatten().any(|way| *way == through);
            // A stem's left turns are what its green is for.
            let left_s = if has_through { s.min_left_green_s } else { s.min_green_s };
            add(s.min_green_s, None, &|green| serves(green, approach, Turn::Through));
            add(left_s, None, &|green| serves(green, approach, Turn::Left));
        }
        for approach in approaches {
            let least_s = self.crossing_s(approach);
            add(least_s, Some(approach), &|green| self.serves_crossing(green, approach));
        }
        needs.retain(|need| need.served.contains(&true));
        needs
    }

    /// Returns the shortest greens of a cycle, seconds, which lets pedestrians cross every time.
    pub fn least_greens_s(&self, greens: &[&str]) -> Vec<u32> {
        let change_s =
            |a: usize, b: usize| self.change(greens[a], greens[b]).map_or(0, |c| c.total_s());
        let cycle: Vec<usize> = (0..greens.len()).collect();
        least_greens_s(&self.needs(greens), &cycle, &change_s)
    }
}

/// Whether more approaches than those of a T meet, and one of them has no opposite approach.
///
/// # Arguments
///
/// * `headings_deg` — directions of travel of the approaches, degrees clockwise from north.
pub fn has_unopposed(headings_deg: &[f64]) -> bool {
    let is_opposed =
        |from: &f64| headings_deg.iter().any(|o| turn_degrees(*from, *o).abs() >= OPPOSITE_DEG);
    headings_deg.len() > LEGS_OF_A_T && !headings_deg.iter().all(is_opposed)
}

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

impl Timing {
    /// Returns what each phase of a program is to a crosswalk.
    ///
    /// # Arguments
    ///
    /// * `phases` — state and shortest duration in seconds, as they are shown one after the other.
    pub fn walks(&self, phases: &[(&str, f64)], crossing: usize) -> Vec<Walk> {
        let mut walks = vec![Walk::No; phases.len()];
        let rows = self.rows(phases, crossing);
        let longest_s = rows.iter().map(|row| row.1).fold(0.0, f64::max);
        let least_s = f64::from(self.crossing_s(crossing)).min(longest_s);
        for (row, _) in rows.iter().filter(|(_, room_s)| *room_s >= least_s) {
            row.iter().for_each(|phase| walks[*phase] = Walk::GoesOn);
            walks[row[0]] = Walk::Begins;
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
            for (row, _) in rows.iter().filter(|(_, room_s)| *room_s >= f64::from(takes_s)) {
                longest[row[0]] = longest[row[0]].max(Some(takes_s));
            }
        }
        longest.into_iter().map(|takes_s| Some([WALK_S, takes_s? - WALK_S])).collect()
    }

    /// Returns the phases in a row with one walk, to the last green, and the time from the first of them until somebody who is in
    /// the way gets green, seconds. Where every green serves the crosswalk, each is a row.
    fn rows(&self, phases: &[(&str, f64)], crossing: usize) -> Vec<(Vec<usize>, f64)> {
        let greens = self.greens(phases);
        let serves: Vec<bool> =
            greens.iter().map(|green| self.serves_crossing(phases[*green].0, crossing)).collect();
        let count = greens.len();
        let served = |place: usize| serves[place % count];
        let all = serves.iter().all(|served| *served);
        let begins = |place: &usize| served(*place) && (all || !served(place + count - 1));
        let row = |first: usize| {
            let length = if all { 1 } else { (first..).take_while(|p| served(*p)).count() };
            let (begin, last) = (greens[first], greens[(first + length - 1) % count]);
            let steps = (last + phases.len() - begin) % phases.len();
            let shown = (0..phases.len()).map(|step| (begin + step) % phases.len());
            let is_free =
                |phase: &usize| !self.is_met(self.moving(phases[*phase].0, is_green), crossing);
            let room_s = shown.clone().take_while(is_free).map(|phase| phases[phase].1).sum();
            (shown.take(steps + 1).collect(), room_s)
        };
        (0..count).filter(begins).map(row).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{LEFT, OTHER, THROUGH, cross, field};
    use super::super::{Approach, Timing, Way};
    use super::*;
    use crate::settings::SignalSettings;

    /// From the north through and left, the stem in the east right and left, from the south right and through.
    fn tee(settings: &SignalSettings) -> Timing {
        let approach =
            |heading_deg| Approach { heading_deg, width_m: 12.8, plain_lanes: 4, speed_mps: 13.41 };
        let way = |approach, turn| vec![Way { approach, turn }];
        let links = vec![
            way(0, Turn::Through),
            way(0, Turn::Left),
            way(1, Turn::Right),
            way(1, Turn::Left),
            way(2, Turn::Right),
            way(2, Turn::Through),
        ];
        Timing::new(settings, [180.0, 270.0, 0.0].map(approach).to_vec(), links)
    }

    const TEE: [&str; 3] = ["GgrrGG", "GGGrrr", "rrGGrr"];

    #[test]
    fn the_left_stage_of_a_t_lasts_as_a_left_turn_does() {
        let timing = tee(&field());
        // Walk and clearance of 12.8 m are 19 s. The left turn's arrow leads over the stem's crosswalk.
        assert_eq!(timing.least_greens_s(&TEE), [19, 5, 19]);
        assert_eq!(timing.needs(&TEE).iter().filter(|need| need.crossing.is_some()).count(), 3);
        // Without an arrow both stages serve that crosswalk: 10 + 4 + 1 + 5 s are enough.
        let permissive = ["GgrrGG", "GgGrrr", "rrGGrr"];
        assert_eq!(timing.least_greens_s(&permissive), [9, 5, 19]);
    }

    #[test]
    fn a_through_movement_that_stays_green_need_not_begin_anew() {
        let timing = cross(&SignalSettings { pedestrians: false, ..field() });
        assert_eq!(timing.least_greens_s(&[THROUGH, LEFT, OTHER]), [7, 5, 7]);
        let timing = cross(&field());
        let north = "GGGrrrrrrrrr";
        // The crosswalk in the west is served in both, that in the east beside the first one alone.
        assert_eq!(timing.least_greens_s(&[THROUGH, north, OTHER]), [19, 5, 19]);
        assert!(!timing.serves_crossing(north, 1) && timing.serves_crossing(north, 3));
    }

    #[test]
    fn nobody_crosses_before_an_arrow_or_into_traffic() {
        let timing = cross(&field());
        let served =
            |shown: &str| (0..4).filter(|a| timing.serves_crossing(shown, *a)).collect::<Vec<_>>();
        assert_eq!(served(THROUGH), [1, 3]);
        assert_eq!(served(OTHER), [0, 2]);
        assert_eq!(served(LEFT), [0; 0]);
        assert_eq!(served("rrrrrrrrrrrr"), [0; 0]);
        assert_eq!(served("GrrrrrGrrrrr"), [0; 0], "right turns that stay green");
        assert_eq!(served("rrrrrrGGgrrr"), [1, 3]);
        assert_eq!(served("rrryyyGGgrrr"), [0; 0], "before the east has red");
    }

    #[test]
    fn nobody_crosses_before_the_arrow_of_a_fifth_leg() {
        let five = |settings: &SignalSettings| {
            let mut timing = cross(settings);
            let north_east = Approach { heading_deg: 225.0, ..timing.approaches[0] };
            timing.approaches.push(north_east);
            timing.links.push(vec![Way { approach: 4, turn: Turn::Left }]);
            Timing::new(settings, timing.approaches, timing.links)
        };
        let served = |timing: &Timing| {
            let shown = "rrrrrrrrrrrrG";
            (0..4).filter(|a| timing.serves_crossing(shown, *a)).collect::<Vec<_>>()
        };
        let pressed = SignalSettings { pedestrian_calls_per_h: Some(20.0), ..field() };
        // Its left turns go into the streets in the east and the south.
        assert_eq!(served(&five(&pressed)), [0, 3]);
        assert_eq!(served(&five(&field())), [0, 1, 2, 3], "published results have recall");
    }

    #[test]
    fn a_crosswalk_that_the_program_never_serves_is_closed() {
        // The left turn from the north is green throughout, so nobody can ever cross in front of it.
        let mut timing = tee(&field());
        let program = ["GgrrGG", "rgGGrr"].map(str::to_owned);
        let nema = "rrrrGG";
        assert!(timing.serves_crossing("rrGGrr", 0) && timing.serves_crossing(nema, 1));
        timing.close_crosswalks_without(&program);
        assert_eq!([0, 1, 2].map(|a| !timing.closed[a]), [false, true, true]);
        assert!(!timing.serves_crossing("rrGGrr", 0) && timing.serves_crossing(nema, 1));
        let count = timing.needs(&["GgrrGG", "rrGGrr"]);
        assert_eq!(count.iter().filter(|need| need.crossing.is_some()).count(), 2);
    }

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
