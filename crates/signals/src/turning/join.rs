//! Gives counted vehicles to the arms of a table of approaches.
//!
//! - A direction of travel belongs to the arm that vehicles come from: by name where all arms are called by their
//!   directions, else by compass.
//! - Left, through and right are the turns that the bearings of the arms make. A turn that was counted exists, also where
//!   `movements` lacks it. Turns without an exit of their name go to the exits that nobody was counted for, from left to
//!   right, where these are as many. Where a street bends, the three turns of an approach lead to its three exits in their
//!   order if the names of directions say the same; see [`Directions`].
//! - Pedestrians of `NB` cross the arm that northbound vehicles come from. Those of no direction are divided equally among the
//!   arms that lead to the signal. More than a table may have are cut.
//! - U-turns count as the turns across opposing traffic: to the left, or in left-hand traffic to the right. Deviation:
//!   networks have no U-turns.
//! - Weekends count only where nothing was counted on a working day within the period.
//! - Vehicles that have no arm or no exit are not simulated.
//!
//! All of this is said, with the intersection.

use std::collections::{BTreeMap, BTreeSet};

use jiff::civil::Weekday;
use osm_signals::turn::exits_on;
use osm_signals::{DrivingSide, Turn};
use sheet::Fault;

use super::hour::{Hour, Interval, Unfit, busiest};
use super::layout::DAY_MIN;
use super::matching::matched_arms;
use super::{CountedIntersection, FEW, Period, Towards, TurningCounts};
use crate::family::approaches::{
    Approach, Arrivals, Counted, Intersection, MOST_EXITS, MOST_PEDESTRIANS_PER_H,
};
use crate::family::doubts::{Doubt, Said};
use crate::vocabulary::Heading;
use evaluation::family::columns::at;
use evaluation::family::error::FamilyError;

/// Turns from left to right.
const TURNS: [Turn; 3] = [Turn::Left, Turn::Through, Turn::Right];

/// Vehicles of an hour at a whole intersection below which a count is doubtful.
pub(crate) const FEW_VEHICLES: f64 = 20.0;

/// A table of approaches with counts.
#[derive(Debug, Clone, PartialEq)]
pub struct Joined {
    /// The rows; those of one intersection and period stand together.
    pub approaches: Vec<Approach>,
    /// Ids of the intersections that were counted.
    pub counted: BTreeSet<String>,
    /// What was found, one line each.
    pub found: Vec<String>,
    /// What is doubtful.
    pub doubts: Vec<Doubt>,
}

impl Joined {
    /// Returns the approaches of intersections as they are.
    pub fn of(intersections: &[Intersection]) -> Self {
        Self {
            approaches: intersections.iter().flat_map(|i| i.arms.clone()).collect(),
            counted: BTreeSet::new(),
            found: Vec::new(),
            doubts: Vec::new(),
        }
    }
}

/// What is said of turns without an exit.
const NO_EXIT: &str = "counted turns have no exit, and their vehicles are not simulated";

/// How counts are given to arms.
#[derive(Default)]
struct Joining {
    said: Said,
    /// Whether a counted direction has an arm.
    is_given: bool,
    /// Intersections of which none has.
    nowhere: Vec<String>,
}

impl TurningCounts {
    /// Returns the approaches of intersections with what was counted on them in the busiest hour of each period, or of all
    /// that was counted. Intersections without counts keep their rows, once per period.
    ///
    /// # Errors
    ///
    /// [`FamilyError::Csv`] with file and line: none of the intersections was counted, several have one name, times that
    /// do not fit together.
    ///
    /// # Arguments
    ///
    /// * `intersections` — each once, without periods.
    /// * `side` — on which people drive.
    pub fn into_approaches(
        &self,
        intersections: &[Intersection],
        periods: &[Period],
        side: DrivingSide,
    ) -> Result<Joined, FamilyError> {
        let (rows_of, unknown) = self.by_intersection(intersections)?;
        let mut doubts = self.doubts.clone();
        let mut joining = Joining::default();
        let mut hours: Vec<(Option<&Period>, Vec<Hour>)> = Vec::new();
        let mut approaches = Vec::new();
        let asked: Vec<Option<&Period>> =
            if periods.is_empty() { vec![None] } else { periods.iter().map(Some).collect() };
        for period in asked {
            let (mut of_period, mut no_hour) = (Vec::new(), Vec::new());
            for (intersection, counted) in intersections.iter().zip(&rows_of) {
                let mut arms = intersection.arms.clone();
                if let Some(counted) = counted {
                    match joining.hour(counted, &intersection.id, period) {
                        Ok(hour) => {
                            joining.give(&hour, intersection, &mut arms, side);
                            of_period.push(hour);
                        }
                        // What one intersection lacks in a period is said; what all lack is wrong.
                        Err(Unfit::NoHour(line, message)) => {
                            let place = Fault { line, message };
                            no_hour.push((intersection.id.clone(), at(&counted.file, place)));
                        }
                        Err(Unfit::Wrong(line, message)) => {
                            return Err(at(&counted.file, Fault { line, message }));
                        }
                    }
                }
                if let Some(period) = period {
                    arms.iter_mut().for_each(|arm| arm.period.clone_from(&period.name));
                }
                approaches.extend(arms);
            }
            if (of_period.is_empty() || period.is_none()) && !no_hour.is_empty() {
                return Err(no_hour.swap_remove(0).1);
            }
            for (id, error) in &no_hour {
                let about = "counted, but without a complete hour in the period";
                joining.said.say(about, format!("intersection {id}: {error}"));
            }
            hours.push((period, of_period));
        }
        if let Some(why) = joining.nowhere.first().filter(|_| !joining.is_given) {
            return Err(self.intersections[0].at_first(why.clone()));
        }
        let mut found = vec![format!(
            "turning counts: {} of {} intersections",
            rows_of.iter().flatten().count(),
            intersections.len()
        )];
        found.extend(hours.iter().filter_map(|(period, hours)| summary(*period, hours)));
        doubts.extend(Doubt::of(
            "counts of intersections that the table does not have are not used",
            unknown,
        ));
        let uncounted: Vec<String> = (intersections.iter().zip(&rows_of))
            .filter(|(_, counted)| counted.is_none())
            .map(|(i, _)| format!("intersection {}", i.id))
            .collect();
        doubts.extend(Doubt::of(
            "intersections without turning counts keep the traffic that the table has, in every period",
            uncounted,
        ));
        doubts.extend(joining.said.doubts());
        let counted = (intersections.iter().zip(&rows_of))
            .filter(|(_, counted)| counted.is_some())
            .map(|(i, _)| i.id.clone())
            .collect();
        Ok(Joined { approaches, counted, found, doubts })
    }

    /// Returns what was counted at each intersection, and the names of those that the table does not have.
    fn by_intersection(
        &self,
        intersections: &[Intersection],
    ) -> Result<(Vec<Option<CountedIntersection>>, Vec<String>), FamilyError> {
        let mut rows: Vec<Option<CountedIntersection>> = vec![None; intersections.len()];
        let mut unknown = Vec::new();
        for counted in &self.intersections {
            let mut found = None;
            for name in &counted.names {
                let same = meant(name, intersections.iter().map(|i| i.id.as_str()));
                let same = same.map_err(|message| counted.at_first(message))?;
                found =
                    found.or(same.and_then(|same| intersections.iter().position(|i| i.id == same)));
            }
            let is_only = !counted.is_named && intersections.len() == 1;
            match found.or(is_only.then_some(0)) {
                None => unknown.push(counted.names.join(" or ")),
                // Mornings and evenings come in files of their own.
                Some(i) => match &mut rows[i] {
                    Some(other) => {
                        other.file = format!("{} and {}", other.file, counted.file);
                        other.intervals.extend(counted.intervals.iter().cloned());
                    }
                    none => *none = Some(counted.clone()),
                },
            }
        }
        if rows.iter().all(Option::is_none) {
            let few = |ids: Vec<&str>| {
                let more = if ids.len() > FEW { ", ..." } else { "" };
                format!("{}{more}", ids[..ids.len().min(FEW)].join(", "))
            };
            return Err(self.intersections[0].at_first(format!(
                "none of the counted intersections ({}) is one of the table ({}); call them alike in a column INTID, the \
                 title or the name of the file, for example with the ids of --signals",
                few(unknown.iter().map(String::as_str).collect()),
                few(intersections.iter().map(|i| i.id.as_str()).collect())
            )));
        }
        Ok((rows, unknown))
    }
}

impl CountedIntersection {
    /// Returns an error at its first row.
    fn at_first(&self, message: String) -> FamilyError {
        at(&self.file, Fault { line: self.intervals[0].line, message })
    }
}

/// Returns which of some intersections a name means: the one that is called exactly so, else the only one whose name
/// compares as the same; `None` if there is none.
pub(crate) fn meant<'a>(
    name: &str,
    ids: impl Iterator<Item = &'a str>,
) -> Result<Option<&'a str>, String> {
    let plain = comparable(name);
    let mut alike: BTreeSet<&str> = ids.filter(|id| comparable(id) == plain).collect();
    if let Some(exact) = alike.get(name) {
        return Ok(Some(*exact));
    }
    if alike.len() > 1 {
        let alike: Vec<&str> = alike.into_iter().collect();
        return Err(format!(
            "{name} may be intersection {}; call it exactly like one of them",
            alike.join(" or ")
        ));
    }
    Ok(alike.pop_first())
}

/// Returns a name as it is compared: without case, leading zeros, and what separates words.
pub(crate) fn comparable(id: &str) -> String {
    let id = id.to_lowercase();
    let words = id.split(|letter: char| !letter.is_alphanumeric()).filter(|word| !word.is_empty());
    let plain: Vec<&str> = words
        .map(|word| match word.trim_start_matches('0') {
            "" => "0",
            rest if word.chars().all(|c| c.is_ascii_digit()) => rest,
            _ => word,
        })
        .collect();
    if plain.is_empty() { id } else { plain.join(" ") }
}

/// Returns when the busiest hours of a period are.
fn summary(period: Option<&Period>, hours: &[Hour]) -> Option<String> {
    let timed = || hours.iter().filter(|hour| hour.begin_min.is_some());
    let first = timed().min_by_key(|hour| hour.begin_min)?;
    let last = timed().max_by_key(|hour| hour.begin_min)?;
    let named = period.map_or_else(String::new, |p| format!("{}: ", p.name));
    let vehicles: f64 = hours.iter().map(Hour::total).sum();
    let when = if first.begin_min == last.begin_min {
        format!("busiest hour {first}")
    } else {
        let [first, last] = [first, last].map(|hour| hour.to_string().replace(" to ", "-"));
        format!("busiest hours from {first} to {last}")
    };
    Some(format!("  {named}{when}, {vehicles:.0} vehicles"))
}

/// Gives an arm what was known of it before and not counted now: pedestrians, heavy vehicles and the peak hour factor.
fn keep(counted: &mut Counted, before: Counted) {
    counted.pedestrians_per_h = before.pedestrians_per_h;
    if counted.total_vph() > 0.0 {
        counted.heavy_vehicles = counted.heavy_vehicles.or(before.heavy_vehicles);
        let is_factor = |arrivals: &Arrivals| matches!(arrivals, Arrivals::PeakHourFactor(_));
        counted.arrivals = counted.arrivals.or(before.arrivals.filter(is_factor));
    }
}

/// Returns the quarters of an approach, of which vehicles without an exit are no part.
fn quarters(hour: &Hour, heading: Heading, total: f64) -> Option<Arrivals> {
    let counted = hour.quarters.get(&heading)?;
    let sum: f64 = counted.iter().sum();
    (total > 0.0).then(|| Arrivals::QuarterHours(counted.map(|vehicles| vehicles * total / sum)))
}

impl Joining {
    /// Returns the busiest hour of an intersection.
    fn hour(
        &mut self,
        counted: &CountedIntersection,
        id: &str,
        period: Option<&Period>,
    ) -> Result<Hour, Unfit> {
        let (from, to) = period.map_or((0, DAY_MIN), |p| (p.from_min, p.to_min));
        let is_weekend = |row: &&Interval| {
            row.day.is_some_and(|day| matches!(day.weekday(), Weekday::Saturday | Weekday::Sunday))
        };
        let is_within = |row: &Interval| row.minute.is_none_or(|m| (from..to).contains(&m));
        let (weekends, working): (Vec<&Interval>, Vec<_>) =
            counted.intervals.iter().partition(is_weekend);
        let has_working_days = working.iter().any(|row| is_within(row));
        let rows = if has_working_days { working } else { counted.intervals.iter().collect() };
        let hour = busiest(&rows, period)?;
        let of_period = period.map_or_else(String::new, |p| format!(", {}", p.name));
        let at = format!("intersection {id}{of_period}");
        let days: BTreeSet<_> = counted.intervals.iter().map(|row| row.day).collect();
        if days.len() > 1 {
            let left_out = weekends.iter().map(|row| row.day).collect::<BTreeSet<_>>().len();
            let left_out = match left_out {
                weekends if has_working_days && weekends > 0 => {
                    format!(", without weekends ({weekends})")
                }
                _ => String::new(),
            };
            let days =
                if hour.days == 1 { "1 day".to_owned() } else { format!("{} days", hour.days) };
            self.said
                .say("the hour is the mean of several days", format!("{at}: {days}{left_out}"));
        }
        if !has_working_days && !weekends.is_empty() {
            let about = "the hour is one of a weekend, because no working day was counted then";
            self.said.say(about, at.clone());
        }
        if hour.empty > 0 {
            self.said.say(
                "empty fields beside numbers count as nobody",
                format!("{at}: {} fields", hour.empty),
            );
        }
        for times in &hour.missing {
            let about = "rows are missing between others, so hours with them may have been busier; add them";
            self.said.say(about, format!("{at}: {times}"));
        }
        if hour.total() < FEW_VEHICLES {
            self.said.say(
                "the busiest hour has hardly any vehicle; counts may be shares or in thousands",
                format!("{at}: {:.1} vehicles", hour.total()),
            );
        }
        if hour.is_assumed {
            self.said.say("rows without a length, read as the vehicles of an hour", at);
        }
        Ok(hour)
    }

    /// Gives an hour to the arms of an intersection.
    fn give(
        &mut self,
        hour: &Hour,
        intersection: &Intersection,
        arms: &mut [Approach],
        side: DrivingSide,
    ) {
        let at = |heading: Heading| format!("intersection {}, {heading}", intersection.id);
        let headings: Vec<Heading> = hour.headings().into_iter().collect();
        let matched = matched_arms(&headings, arms, &[]);
        if matched.is_ambiguous {
            self.said.say("directions of the compass may belong to other arms, because the streets lie between them; compare the volumes", format!("intersection {}", intersection.id));
        }
        let has_arm = matched.arms.iter().any(Option::is_some);
        self.is_given |= has_arm;
        if !has_arm && !headings.is_empty() {
            let counted: Vec<&str> = headings.iter().map(|heading| heading.name()).collect();
            let known: Vec<&str> = arms.iter().map(|arm| arm.arm.as_str()).collect();
            self.nowhere.push(format!(
                "intersection {}: its counted directions {} belong to none of its arms {}; call directions and arms alike, or \
                 correct bearing_deg of the arms",
                intersection.id,
                counted.join(" "),
                known.join(", ")
            ));
        }
        // An approach without vehicles was counted as well, as long as others were.
        let before: Vec<Option<Counted>> = arms.iter().map(|arm| arm.counted).collect();
        for arm in arms.iter_mut().filter(|arm| arm.lanes_in > 0) {
            arm.counted = Some(Counted::default());
        }
        let across = Turn::across(side);
        for (heading, arm) in headings.iter().zip(&matched.arms) {
            let vehicles = |towards| hour.of(*heading, towards);
            let back = vehicles(Towards::UTurn);
            let mut volumes = [Towards::Left, Towards::Through, Towards::Right].map(vehicles);
            let Some(arm) = *arm else {
                self.said.say("counted directions have no arm, and their vehicles are not simulated; correct the direction or bearing_deg", format!(
                    "{}: {:.0} veh/h",
                    at(*heading),
                    volumes.iter().sum::<f64>() + back
                ));
                continue;
            };
            let others = (0..arms.len()).filter(|i| *i != arm && arms[*i].lanes_out > 0);
            let exits =
                exits_on(side, arms[arm].bearing_deg, others.map(|i| (i, arms[i].bearing_deg)));
            let directions = Directions { headings: &headings, arms: &matched.arms };
            let is_named = directions.name_exits(*heading, &exits);
            let mut ways: Vec<Turn> = exits.iter().map(|(_, turn)| *turn).collect();
            if is_named {
                ways = TURNS.to_vec();
            } else if let Some(other) =
                directions.ahead(*heading, &exits).filter(|_| volumes[1] > 0.0)
            {
                let from = format!("where {other} comes from");
                self.said.say("vehicles that go straight on leave by a street of another direction; compare bearing_deg and the counts", format!("{}: {:.0} veh/h to {from}", at(*heading), volumes[1]));
            }
            self.fit(&mut volumes, &ways, &at(*heading));
            if back > 0.0 && ways.contains(&across) {
                volumes[across as usize] += back;
                self.said.say(
                    format!("U-turns count as {} turns", across.name()),
                    format!("{}: {back:.0} veh/h", at(*heading)),
                );
            } else if back > 0.0 {
                self.said.say(NO_EXIT, format!("{} U-turn: {back:.0} veh/h", at(*heading)));
            }
            self.look_at_exits(hour, *heading, &volumes, &ways, &at(*heading));
            let mut exits_vph = None;
            if is_named {
                let (by_bearings, by_exit) = by_turn(volumes, &exits);
                let words = |[left, through, right]: [f64; 3]| {
                    format!("{left:.0} left, {through:.0} through, {right:.0} right")
                };
                let (told, drawn) = (words(volumes), words(by_bearings));
                self.said.say("streets bend, so bearings call turns otherwise; the vehicles go to the exits that the names of directions say", format!("{}: {told} are {drawn}", at(*heading)));
                (volumes, exits_vph) = (by_bearings, Some(by_exit));
            }
            self.add_letters(&mut arms[arm], &volumes, &at(*heading));
            arms[arm].counted = Some(Counted {
                left_vph: volumes[0],
                through_vph: volumes[1],
                right_vph: volumes[2],
                arrivals: quarters(hour, *heading, volumes.iter().sum()),
                heavy_vehicles: hour.heavy.get(heading).copied(),
                pedestrians_per_h: None,
                exits_vph,
            });
        }
        // What a network in UTDF says stays where nobody counted it.
        for (arm, before) in arms.iter_mut().zip(before) {
            if let Some((counted, before)) = arm.counted.as_mut().zip(before) {
                keep(counted, before);
            }
        }
        let of_vehicles = headings.into_iter().zip(matched.arms).collect();
        self.give_pedestrians(hour, intersection, arms, of_vehicles);
    }

    /// Gives the people of an hour to the arms that they cross.
    fn give_pedestrians(
        &mut self,
        hour: &Hour,
        intersection: &Intersection,
        arms: &mut [Approach],
        mut arm_of: BTreeMap<Heading, Option<usize>>,
    ) {
        if hour.pedestrians.is_empty() {
            return;
        }
        let headings = hour.pedestrians.keys().copied().flatten();
        let headings: Vec<Heading> =
            headings.filter(|heading| !arm_of.contains_key(heading)).collect();
        let taken: Vec<usize> = arm_of.values().copied().flatten().collect();
        let matched = matched_arms(&headings, arms, &taken);
        arm_of.extend(headings.into_iter().zip(matched.arms));
        let anywhere = hour.pedestrians.get(&None).copied();
        if let Some(anywhere) = anywhere.filter(|anywhere| *anywhere > 0.0) {
            let about =
                "pedestrians per hour without a direction are divided equally among the crosswalks";
            self.said.say(about, format!("intersection {}: {anywhere:.0}", intersection.id));
        }
        let incoming = arms.iter().filter(|arm| arm.lanes_in > 0).count();
        // Nobody knows who crosses an arm that was not counted beside others.
        let share = anywhere.map(|anywhere| anywhere / incoming.max(1) as f64);
        let mut per_h = vec![share; arms.len()];
        let counted = hour.pedestrians.iter().filter_map(|(heading, n)| Some(((*heading)?, *n)));
        for (heading, count) in counted {
            match arm_of[&heading] {
                Some(arm) => *per_h[arm].get_or_insert(0.0) += count,
                None if count > 0.0 => self.said.say("pedestrians cross an arm that does not lead to the signal, and are not simulated", format!("intersection {}, {heading}: {count:.0}", intersection.id)),
                None => {}
            }
        }
        let too_many = format!(
            "more than {MOST_PEDESTRIANS_PER_H} pedestrians per hour cross an arm, and so many are simulated; give counts of \
             an hour, not of a day"
        );
        for (arm, per_h) in arms.iter_mut().zip(per_h) {
            let Some(counted) = arm.counted.as_mut().filter(|_| arm.lanes_in > 0) else { continue };
            let Some(per_h) = per_h else {
                self.said.say("pedestrians were counted on other arms only, and these have nobody who pushes a button", format!("intersection {}, arm {}", intersection.id, arm.arm));
                continue;
            };
            counted.pedestrians_per_h = Some(per_h.min(MOST_PEDESTRIANS_PER_H));
            if per_h > MOST_PEDESTRIANS_PER_H {
                self.said.say(
                    too_many.as_str().to_owned(),
                    format!("intersection {}, arm {}: {per_h:.0}", intersection.id, arm.arm),
                );
            }
        }
    }

    /// Gives the vehicles of turns that do not exist to exits that nobody was counted for, from left to right.
    fn fit(&mut self, volumes: &mut [f64; 3], ways: &[Turn], at: &str) {
        let missing: Vec<usize> =
            (0..3).filter(|i| volumes[*i] > 0.0 && !ways.contains(&TURNS[*i])).collect();
        if missing.is_empty() {
            return;
        }
        let free: Vec<usize> =
            (0..3).filter(|i| volumes[*i] == 0.0 && ways.contains(&TURNS[*i])).collect();
        if missing.len() == free.len() {
            let mut renamed = *volumes;
            for (from, to) in missing.iter().zip(&free) {
                renamed[*to] = volumes[*from];
                renamed[*from] = 0.0;
            }
            let words = |[left, through, right]: &[f64; 3]| {
                format!("{left:.0} left, {through:.0} through, {right:.0} right")
            };
            self.said.say("counted turns are given to exits from left to right, because bearings call them otherwise", format!("{at}: {} become {}", words(volumes), words(&renamed)));
            *volumes = renamed;
            return;
        }
        for i in missing {
            let word = TURNS[i].name();
            self.said.say(NO_EXIT, format!("{at} {word}: {:.0} veh/h", volumes[i]));
            volumes[i] = 0.0;
        }
    }

    /// Says which turns were not counted, and which have several exits.
    fn look_at_exits(
        &mut self,
        hour: &Hour,
        heading: Heading,
        volumes: &[f64; 3],
        ways: &[Turn],
        at: &str,
    ) {
        for (i, towards) in
            [Towards::Left, Towards::Through, Towards::Right].into_iter().enumerate()
        {
            let exits = ways.iter().filter(|way| **way == TURNS[i]).count();
            let word = TURNS[i].name();
            let is_counted = hour.vehicles.contains_key(&(heading, towards)) || volumes[i] > 0.0;
            if exits > 0 && !is_counted {
                self.said.say(
                    "turns that exist were not counted, and have no vehicles",
                    format!("{at} {word}"),
                );
            }
            if exits > 1 && volumes[i] > 0.0 {
                self.said.say(
                    "turns with several exits divide their vehicles equally among them",
                    format!("{at} {word}: {:.0} veh/h to {exits} exits", volumes[i]),
                );
            }
        }
    }

    /// Adds counted turns to those that an arm has.
    fn add_letters(&mut self, arm: &mut Approach, volumes: &[f64; 3], at: &str) {
        if arm.movements.is_empty() {
            return;
        }
        for (volume, letter) in volumes.iter().zip(['l', 's', 'r']) {
            if *volume > 0.0 && !arm.movements.contains(letter) {
                arm.movements.push(letter);
                let word = match letter {
                    'l' => "left",
                    's' => "through",
                    _ => "right",
                };
                self.said.say(
                    "counted turns that the arm did not have are added to its movements",
                    format!("{at} {word}: {volume:.0} veh/h"),
                );
            }
        }
    }
}

/// Eighths of a circle from a direction to that of the vehicles which come from the arms on its left, ahead and on its right.
const FACING: [usize; 3] = [2, 4, 6];

/// Eighths of a circle from which a street has another direction.
const OTHER: usize = 2;

/// Directions of travel and the arms that they come from. Bearings make at most one exit the way straight on, and none that is
/// 45 degrees off; names know more: northbound vehicles that go straight on leave by the arm that southbound ones come from.
struct Directions<'a> {
    /// The directions.
    headings: &'a [Heading],
    /// Per direction its arm, if there is one.
    arms: &'a [Option<usize>],
}

impl Directions<'_> {
    /// Whether the three exits of an approach are left, ahead and right by the names of directions, and not by bearings.
    fn name_exits(&self, heading: Heading, exits: &[(usize, Turn)]) -> bool {
        let by_name = FACING.map(|eighths| self.arm_of(heading.clockwise(eighths)));
        exits.len() == TURNS.len()
            && exits.iter().zip(TURNS).any(|((_, turn), named)| *turn != named)
            && exits.iter().zip(by_name).all(|((arm, _), named)| Some(*arm) == named)
    }

    /// Returns the direction of the vehicles that come from where those of another one go straight on, if it is not that of
    /// the opposite street.
    fn ahead(&self, heading: Heading, exits: &[(usize, Turn)]) -> Option<Heading> {
        let (ahead, _) = exits.iter().find(|(_, turn)| *turn == Turn::Through)?;
        let mut known = self.headings.iter().zip(self.arms);
        let (found, _) = known.find(|(_, arm)| **arm == Some(*ahead))?;
        let [_, straight, _] = FACING;
        let off = (*found as usize).abs_diff(heading.clockwise(straight) as usize);
        (off.min(Heading::ALL.len() - off) >= OTHER).then_some(*found)
    }

    fn arm_of(&self, heading: Heading) -> Option<usize> {
        let place = self.headings.iter().position(|other| *other == heading)?;
        self.arms.get(place).copied().flatten()
    }
}

/// Returns vehicles to exits as the turns that bearings make of these, and as exits of a table.
fn by_turn(volumes: [f64; 3], exits: &[(usize, Turn)]) -> ([f64; 3], [f64; MOST_EXITS]) {
    let (mut turns, mut exits_vph) = ([0.0; 3], [0.0; MOST_EXITS]);
    for (((_, turn), vph), exit) in exits.iter().zip(volumes).zip(&mut exits_vph) {
        turns[*turn as usize] += vph;
        *exit = vph;
    }
    (turns, exits_vph)
}

#[cfg(test)]
mod tests {
    use super::*;
    use Heading::{East, North, South, SouthWest, West};
    use Turn::{Left, Right, Through};

    #[test]
    fn a_bent_street_goes_on_by_the_names_of_directions() {
        // Arms in the north-east, south-east, south and west.
        let headings = [North, South, East, West];
        let directions =
            Directions { headings: &headings, arms: &[Some(2), Some(0), Some(3), Some(1)] };
        let northbound = [(3, Left), (0, Right), (1, Right)];
        assert!(directions.name_exits(North, &northbound));
        assert_eq!(
            by_turn([100.0, 400.0, 50.0], &northbound),
            ([100.0, 0.0, 450.0], [100.0, 400.0, 50.0, 0.0, 0.0])
        );
        let southbound = [(1, Left), (2, Left), (3, Through)];
        assert!(directions.name_exits(South, &southbound));
        assert_eq!(directions.ahead(South, &southbound), Some(East));
        // Bearings that agree, and exits in another order.
        assert!(!directions.name_exits(North, &[(3, Left), (0, Through), (1, Right)]));
        assert!(!directions.name_exits(North, &[(0, Left), (3, Right), (1, Right)]));
        let skew = Directions { headings: &[North, SouthWest], arms: &[Some(1), Some(0)] };
        assert_eq!(skew.ahead(North, &[(0, Through)]), None);
    }
}
