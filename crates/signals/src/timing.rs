//! What the limits of `[signal]` mean for one signal: change intervals and shortest greens.
//!
//! Pure functions over SUMO's states, one letter per link, and a description of the approaches. The
//! generator uses them for the program of a network, the environment for what controllers do, and so
//! every method and the baseline obey the same limits.
//!
//! Choices where handbooks differ:
//! - **Speed** is the speed limit of the approach. (ITE takes the 85th percentile, which nobody has
//!   for a speed limit from a map; it is some 7 mph more.)
//! - **Width** of a crossing street is that of its lanes in both directions, the widest of all streets
//!   that cross the approach at 30 to 150 degrees.
//! - **Tenths and whole seconds**: yellow and all-red are tenths, rounded up, for the cabinet. SUMO's steps are whole
//!   seconds, so both together are rounded up in the simulation. The cabinet's greens have what that is too much: with the
//!   splits that were simulated none is shorter than its limits. (Existing plans keep their greens, and are rounded to the nearest.)
//! - **Crosswalks** lie across every approach. A green serves that of an approach if the approach waits (right
//!   turns do not count), nothing goes straight on into its street, and no left turn with an arrow of its
//!   own, one that is protected from an opposing approach, goes there. Where pedestrians push buttons at more than three
//!   approaches, one without an opposing approach has an arrow too. Deviation: under recall it has none, as in the
//!   published results. A phase for left turns alone serves
//!   none. There are no pedestrians in the simulation: greens last long enough for them, and turning vehicles
//!   do not wait for any. The crosswalk of an arm that only leads away is not counted.
//! - **Closed crosswalks**: one that no green of the signal's own program serves counts as closed (MUTCD, sign R9-3),
//!   under every method. So all methods serve the same crosswalks.
//! - **Consecutive greens** that serve a crosswalk or a movement carry its time together; see
//!   [`needs`](super::needs). This holds with `pedestrians`; without them every green lasts its own shortest time.
//! - **Lanes of a street** are as wide as the network says. Those of which it says nothing have SUMO's 3.2 m, in place of
//!   which crosswalks and all-red take `lane_width_m`.
//!
//! Source: ITE, "Guidelines for Determining Traffic Signal Change and Clearance Intervals" (2020);
//! MUTCD (2009), sections 4D.26 and 4E.06; HCM (6th ed.), chapter 19; "Signal Timing Manual" (2nd ed.,
//! NCHRP Report 812), chapter 6.

mod crosswalks;

use osm_signals::Turn;
use osm_signals::angle::turn_degrees;

pub use crosswalks::{WALK_S, WALKING_MPS, Walk, has_unopposed};

use crate::needs::Need;
use crate::settings::{ChangeInterval, SignalSettings};

/// Perception and reaction of a driver, seconds (ITE).
const REACTION_S: f64 = 1.0;

/// Deceleration of a driver who stops at yellow, metres per second squared (ITE: 10 ft/s2).
const DECELERATION_MPS2: f64 = 3.05;

/// Length of a vehicle that clears the junction, metres (ITE: 20 ft).
const VEHICLE_M: f64 = 6.1;

/// Lowest speed at which a vehicle clears the junction, metres per second: that of somebody who walks. Networks have
/// approaches with a speed limit of 0. Our choice.
const SLOWEST_MPS: f64 = 1.4;

/// Longest yellow, seconds (MUTCD).
const MAX_YELLOW_S: f64 = 6.0;

/// Longest time that a state after yellow is taken for all-red although some link stays green in it, seconds; a lagging green
/// lasts longer.
const MAX_LINGERING_S: f64 = 4.0;

/// Angles between which a street crosses an approach, degrees.
const CROSSING_DEG: std::ops::RangeInclusive<f64> = 30.0..=150.0;

/// An approach of a signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Approach {
    /// Direction of travel at the stop line, degrees clockwise from north.
    pub heading_deg: f64,
    /// Width of the street, both directions, metres.
    pub width_m: f64,
    /// Lanes in it whose width nobody said, so that they have SUMO's.
    pub plain_lanes: u32,
    /// Speed limit, metres per second.
    pub speed_mps: f64,
}

/// A way through the signal: which approach it comes from, and where it turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Way {
    /// Index of the approach.
    pub approach: usize,
    /// The turn.
    pub turn: Turn,
}

/// Yellow and all-red between two greens, whole seconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Change {
    /// Yellow of the links that end.
    pub yellow_s: u32,
    /// Red of all links that end or begin, after it.
    pub all_red_s: u32,
}

impl Change {
    /// Returns both together, seconds.
    pub fn total_s(self) -> u32 {
        self.yellow_s + self.all_red_s
    }

    /// Returns a change of whole seconds, yellow and all-red each one of the two beside its own; yellow is rounded up first.
    pub fn of(total_s: u32, [yellow_s, all_red_s]: [f64; 2]) -> Self {
        let yellow_s = total_s.saturating_sub(beside(all_red_s)[0]).min(beside(yellow_s)[1]);
        Self { yellow_s, all_red_s: total_s - yellow_s }
    }

    /// Returns the fewest whole seconds that are not less than yellow and all-red together.
    pub fn holding([yellow_s, all_red_s]: [f64; 2]) -> Self {
        Self::of(beside(yellow_s + all_red_s)[1], [yellow_s, all_red_s])
    }

    /// Returns yellow and all-red for the cabinet, of which these are the whole seconds; `None` where they are the same.
    pub(crate) fn unless_exact(self, exact_s: [f64; 2]) -> Option<[f64; 2]> {
        Some(exact_s).filter(|s| *s != [self.yellow_s, self.all_red_s].map(f64::from))
    }
}

/// What makes a time that is a whole number but for rounding stay one, seconds.
const ROUNDING_S: f64 = 1e-6;

/// Returns the nearest whole second; a half is rounded up.
pub fn nearest_s(seconds: f64) -> u32 {
    (seconds + ROUNDING_S).round().max(0.0) as u32
}

/// Returns the whole seconds below and above a time; the same twice for a whole number.
pub fn beside(seconds: f64) -> [u32; 2] {
    [(seconds + ROUNDING_S).floor(), (seconds - ROUNDING_S).ceil()].map(|s| s.max(0.0) as u32)
}

/// Returns a time without digits beyond the tenth, seconds.
pub fn tenths(seconds: f64) -> f64 {
    (seconds * 10.0).round() / 10.0
}

/// The limits of one signal.
#[derive(Debug, Clone, PartialEq)]
pub struct Timing {
    pub(crate) settings: SignalSettings,
    approaches: Vec<Approach>,
    /// Ways by link index.
    links: Vec<Vec<Way>>,
    /// Whether the crosswalk of each approach is closed.
    pub(crate) closed: Vec<bool>,
    /// Whether a left turn without an opposite approach has an arrow.
    counts_unopposed_arrows: bool,
}

impl Timing {
    /// Returns the limits of a signal.
    ///
    /// # Arguments
    ///
    /// * `links` — per link index the ways that it steers; none for pedestrians and trains.
    pub fn new(settings: &SignalSettings, approaches: Vec<Approach>, links: Vec<Vec<Way>>) -> Self {
        let closed = vec![false; approaches.len()];
        let counts_unopposed_arrows = settings.pedestrian_calls_per_h.is_some();
        let settings = settings.clone();
        Self { settings, approaches, links, closed, counts_unopposed_arrows }
    }

    /// Returns yellow and all-red between two greens, as they are simulated; `None` when no green ends.
    pub fn change(&self, from: &str, to: &str) -> Option<Change> {
        self.exact_change_s(from, to).map(Change::holding)
    }

    /// Returns yellow and all-red between two greens, tenths of seconds; `None` when no green ends.
    pub(crate) fn exact_change_s(&self, from: &str, to: &str) -> Option<[f64; 2]> {
        from.chars().zip(to.chars()).find(|(a, b)| ends(*a, *b))?;
        let s = &self.settings;
        let least_s = [s.yellow_time_s, s.all_red_s].map(f64::from);
        if s.change_interval == ChangeInterval::Fixed {
            return Some(least_s);
        }
        Some(self.ending(from, to).fold(least_s, |worst_s, approach| {
            let own_s = self.kinematic(approach);
            [0, 1].map(|i: usize| worst_s[i].max(own_s[i]))
        }))
    }

    /// Returns the approaches of which a link has green in one state and has to stop before the other, some several times.
    pub fn ending<'a>(&'a self, from: &'a str, to: &'a str) -> impl Iterator<Item = usize> + 'a {
        let ending = from.chars().zip(to.chars()).enumerate().filter(|(_, (a, b))| ends(*a, *b));
        ending.flat_map(|(index, _)| self.ways(index)).map(|way| way.approach)
    }

    /// Returns what is shown between two greens, and for how long, seconds: yellow, then all-red; nothing
    /// when no light turns red.
    pub fn between(&self, from: &str, to: &str) -> Vec<(String, u32)> {
        let Some(change) = self.change(from, to) else { return Vec::new() };
        let yellow = yellow(from, to);
        let all_red = yellow.replace('y', "r");
        [(yellow, change.yellow_s), (all_red, change.all_red_s)]
            .into_iter()
            .filter(|(_, seconds)| *seconds > 0)
            .collect()
    }

    /// Returns yellow and all-red of an approach by ITE's formula, seconds, before they are rounded up and brought within
    /// their limits.
    pub fn kinematic_s(&self, approach: usize) -> [f64; 2] {
        let speed_mps = self.approaches[approach].speed_mps.max(SLOWEST_MPS);
        let red_s = (self.crossing_m(approach) + VEHICLE_M) / speed_mps;
        [kinematic_yellow_s(speed_mps), red_s]
    }

    /// Returns the change interval of an approach by ITE's formula, tenths of seconds.
    fn kinematic(&self, approach: usize) -> [f64; 2] {
        let [yellow_s, red_s] = self.kinematic_s(approach);
        let up = |seconds: f64| (seconds * 10.0 - ROUNDING_S).ceil() / 10.0;
        let least_s = [self.settings.yellow_time_s, self.settings.all_red_s].map(f64::from);
        let yellow = up(yellow_s).min(MAX_YELLOW_S).max(least_s[0]);
        [yellow, tenths(up(yellow_s + red_s) - yellow).max(least_s[1])]
    }

    /// Returns the width of the widest street that crosses an approach, metres; 0 where none does.
    fn crossing_m(&self, approach: usize) -> f64 {
        let heading = self.approaches[approach].heading_deg;
        let others = self.approaches.iter().enumerate();
        others
            .filter(|(_, o)| CROSSING_DEG.contains(&turn_degrees(heading, o.heading_deg).abs()))
            .map(|(other, _)| self.crosswalk_m(other))
            .fold(0.0, f64::max)
    }

    /// Whether a green serves left turns alone, while the vehicles beside them that go on wait; right
    /// turns do not count.
    pub fn is_left_only(&self, green: &str) -> bool {
        let serves = |approach, turn| self.served(green, approach).any(|served| served == turn);
        let approaches = 0..self.approaches.len();
        let is_other = |approach: usize| {
            let through = Way { approach, turn: Turn::Through };
            let has_through = self.links.iter().flatten().any(|way| *way == through);
            serves(approach, Turn::Through) || serves(approach, Turn::Left) && !has_through
        };
        !approaches.clone().any(is_other) && approaches.into_iter().any(|a| serves(a, Turn::Left))
    }

    fn served<'a>(&'a self, green: &'a str, approach: usize) -> impl Iterator<Item = Turn> + 'a {
        let own = self.moving(green, is_green).filter(move |(way, _)| way.approach == approach);
        own.map(|(way, _)| way.turn)
    }

    /// Returns the ways whose letters say that vehicles move, with these.
    fn moving<'a>(
        &'a self,
        shown: &'a str,
        moves: fn(char) -> bool,
    ) -> impl Iterator<Item = (&'a Way, char)> {
        let letters = shown.chars().enumerate().filter(move |(_, letter)| moves(*letter));
        letters.flat_map(|(index, letter)| self.ways(index).map(move |way| (way, letter)))
    }

    fn ways(&self, index: usize) -> impl Iterator<Item = &Way> {
        self.links.get(index).into_iter().flatten()
    }

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
            // Where vehicles may turn on red, it is red.
            let red = |state: &str| state.replace(['y', 'Y', 'u', 's'], "r");
            if !is_yellow(at(before).0) || red(at(before).0) != at(i).0.replace('s', "r") {
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
            let (count, first) = (greens.len(), greens[start]);
            let row = (start..start + count).take_while(|k| need.served[k % count]);
            let last = greens[row.last().unwrap_or(start) % count];
            let steps = (last + phases.len() - first) % phases.len();
            let lasts_s = (0..=steps).map(|step| phases[(first + step) % phases.len()].1);
            lasts_s.sum::<f64>() >= f64::from(need.least_s)
        };
        let serves = |need: &Need| {
            let begins =
                |k: &usize| need.served[*k] && !need.served[(k + greens.len() - 1) % greens.len()];
            (0..greens.len()).filter(begins).all(|start| carries(need, start))
        };
        let changes = |k: usize| {
            let (from, to) = (greens[k], greens[(k + 1) % greens.len()]);
            let steps = (to + phases.len() - from - 1) % phases.len();
            let between = (1..=steps).map(|step| phases[(from + step) % phases.len()]);
            let is_yellow = |(state, _): &(&str, f64)| state.contains(['y', 'Y']);
            let (yellow, rest): (Vec<_>, Vec<_>) = between.partition(is_yellow);
            let [yellow_s, rest_s] = [yellow, rest].map(|of| of.iter().map(|p| p.1).sum::<f64>());
            self.change(phases[from].0, phases[to].0).is_none_or(|least| {
                yellow_s >= f64::from(least.yellow_s) && rest_s >= f64::from(least.all_red_s)
            })
        };
        greens.iter().all(|i| lasts(*i))
            && needs.iter().all(serves)
            && (0..greens.len()).all(changes)
    }
}

/// Returns the yellow of ITE's formula at a speed, seconds, before it is rounded up and brought within its limits.
fn kinematic_yellow_s(speed_mps: f64) -> f64 {
    REACTION_S + speed_mps / (2.0 * DECELERATION_MPS2)
}

fn is_green(letter: char) -> bool {
    matches!(letter, 'G' | 'g')
}

/// Whether a link that shows `a` has to stop before it shows `b`.
fn ends(a: char, b: char) -> bool {
    is_green(a) && matches!(b, 'r' | 's')
}

/// Returns the yellow state between two greens: links that are green and will be red turn yellow, all
/// others stay as they are.
///
/// Source: RESCO, traffic_signal.py, yellow phases.
fn yellow(from: &str, to: &str) -> String {
    from.chars().zip(to.chars()).map(|(a, b)| if ends(a, b) { 'y' } else { a }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four arms of 30 mph and 12.8 m, links by arm from the north clockwise: right, through, left.
    pub(super) fn cross(settings: &SignalSettings) -> Timing {
        let approach = |k: usize| Approach {
            heading_deg: (180.0 + 90.0 * k as f64) % 360.0,
            width_m: 12.8,
            plain_lanes: 4,
            speed_mps: 13.41,
        };
        let links = (0..12)
            .map(|i| {
                let turn = [Turn::Right, Turn::Through, Turn::Left][i % 3];
                vec![Way { approach: i / 3, turn }]
            })
            .collect();
        Timing::new(settings, (0..4).map(approach).collect(), links)
    }

    pub(super) fn field() -> SignalSettings {
        SignalSettings {
            change_interval: ChangeInterval::Kinematic,
            all_red_s: 1,
            min_left_green_s: 5,
            max_green_s: Some(60),
            pedestrians: true,
            ..SignalSettings::default()
        }
    }

    pub(super) const THROUGH: &str = "GGgrrrGGgrrr";
    pub(super) const LEFT: &str = "rrGrrrrrGrrr";
    pub(super) const OTHER: &str = "rrrGGgrrrGGg";

    #[test]
    fn resco_has_three_seconds_of_yellow_no_all_red_and_seven_of_green() {
        let timing = cross(&SignalSettings::default());
        let change = timing.change(THROUGH, OTHER).unwrap();
        assert_eq!((change.yellow_s, change.all_red_s), (3, 0));
        assert_eq!([THROUGH, LEFT, OTHER].map(|s| timing.min_green_s(s)), [7, 7, 7]);
        assert_eq!(timing.max_green_s(THROUGH), None);
    }

    #[test]
    fn yellow_and_all_red_follow_from_speed_and_width() {
        // Yellow 1 + 13.41 / 6.1 = 3.20, all-red (12.8 + 6.1) / 13.41 = 1.41, together 4.61 s.
        let of = |timing: &Timing| {
            let change = timing.change(THROUGH, OTHER).unwrap();
            (timing.exact_change_s(THROUGH, OTHER).unwrap(), change.yellow_s, change.all_red_s)
        };
        assert_eq!(of(&cross(&field())), ([3.2, 1.5], 4, 1));
        let mut fast = cross(&field());
        fast.approaches[2].speed_mps = 22.35;
        fast.approaches[1].width_m = 30.0;
        // The slow approach: 3.20 + 2.69 s; the fast one: 4.66 + 1.62 s.
        assert_eq!(of(&fast), ([4.7, 2.7], 5, 3));
        let wide = cross(&SignalSettings { lane_width_m: Some(3.66), ..field() });
        assert_eq!(of(&wide), ([3.2, 1.6], 4, 1), "all-red over four lanes of 12 ft: 20.7 / 13.41");
    }

    #[test]
    fn yellow_shows_only_where_green_ends_and_all_red_follows() {
        let settings = SignalSettings { all_red_s: 2, ..SignalSettings::default() };
        let timing = cross(&settings);
        assert_eq!(
            timing.between("GGgrr", "GrGrG"),
            [("Gygrr".to_owned(), 3), ("Grgrr".to_owned(), 2)]
        );
        assert_eq!(timing.between("GGgrr", "GGGrr"), []);
    }

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
