//! Gives counted vehicles to the arms of a table of approaches.
//!
//! - A direction of travel belongs to the arm that vehicles come from: by name where all arms are called by their
//!   directions, else by compass.
//! - Left, through and right are the turns that the bearings of the arms make. A turn that was counted exists, also where
//!   `movements` lacks it. Turns without an exit of their name go to the exits that nobody was counted for, from left to
//!   right, where these are as many. Where a street bends, the three turns of an approach lead to its three exits in their
//!   order if the names of directions say the same.
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
use osm_signals::angle::turn_degrees;
use osm_signals::turn::exits_on;
use osm_signals::{DrivingSide, Turn};
use sheet::Fault;

use super::hour::{DAY_MIN, Hour, Interval, busiest};
use super::{CountedIntersection, Period, Towards, TurningCounts};
use crate::family::approaches::{
    Approach, Arrivals, Counted, Intersection, MOST_EXITS, MOST_PEDESTRIANS_PER_H,
};
use crate::family::doubts::{Doubt, Said};
use crate::vocabulary::{Heading, MOST_OFF_DEG};
use evaluation::family::columns::at;
use evaluation::family::error::FamilyError;

/// Most names that a message lists.
const MOST_NAMES: usize = 6;

/// Turns from left to right.
const TURNS: [Turn; 3] = [Turn::Left, Turn::Through, Turn::Right];

/// Vehicles of an hour at a whole intersection below which a count is doubtful.
pub(crate) const FEW_VEHICLES: f64 = 20.0;

/// A table of approaches with counts.
#[derive(Debug, Clone, PartialEq, Default)]
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

/// Cost of a direction without an arm, as if it were so many degrees off.
const WITHOUT_DEG: f64 = 120.0;

/// Difference of two assignments of directions to arms, degrees in the quadratic mean, below which either may be meant.
const CLOSE_DEG: f64 = 12.0;

/// Eighths of a circle from a direction to that of the vehicles which come from the arms on its left, ahead and on its right.
const FACING: [usize; 3] = [2, 4, 6];

/// What is said of turns without an exit.
const NO_EXIT: &str = "counted turns have no exit, and their vehicles are not simulated";

/// How counts are given to arms.
#[derive(Default)]
struct Joining {
    side: DrivingSide,
    /// File of the counts at hand.
    file: String,
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
        let (counted, uncounted): (Vec<_>, Vec<_>) =
            intersections.iter().zip(&rows_of).partition(|(_, rows)| rows.is_some());
        let mut found = vec![format!(
            "turning counts: {} of {} intersections",
            counted.len(),
            intersections.len()
        )];
        let mut joining = Joining { side, ..Joining::default() };
        let mut approaches = Vec::new();
        let asked: Vec<Option<&Period>> =
            if periods.is_empty() { vec![None] } else { periods.iter().map(Some).collect() };
        for period in asked {
            let (mut hours, mut no_hour) = (Vec::new(), Vec::new());
            for (intersection, rows) in intersections.iter().zip(&rows_of) {
                let mut arms = intersection.arms.clone();
                if let Some(rows) = rows {
                    match joining.hour(rows, &intersection.id, period)? {
                        Some(hour) => {
                            joining.file.clone_from(&rows.file);
                            joining.give(&hour, intersection, &mut arms);
                            hours.push(hour);
                        }
                        None => no_hour.push((intersection, rows)),
                    }
                }
                for arm in arms.iter_mut().filter(|_| period.is_some()) {
                    arm.period = period.map_or_else(String::new, |period| period.name.clone());
                }
                approaches.extend(arms);
            }
            let within = period.map_or_else(String::new, |period| format!(" within {period}"));
            // What one intersection lacks in a period is said; what all lack is wrong.
            for (intersection, rows) in no_hour {
                if hours.is_empty() || period.is_none() {
                    let message =
                        format!("no hour{within} is complete; add the rows that are missing");
                    return Err(rows.at_first(message));
                }
                let about = "counted, but without a complete hour in the period";
                joining.said.say(about, format!("intersection {}{within}", intersection.id));
            }
            found.extend(summary(period, &hours));
        }
        if let Some(why) = joining.nowhere.first().filter(|_| !joining.is_given) {
            return Err(self.intersections[0].at_first(why.clone()));
        }
        let mut doubts = self.doubts.clone();
        doubts.extend(Doubt::of(
            "counts of intersections that the table does not have are not used",
            unknown,
        ));
        doubts.extend(Doubt::of(
            "intersections without turning counts keep the traffic that the table has, in every period",
            uncounted.iter().map(|(i, _)| format!("intersection {}", i.id)).collect(),
        ));
        doubts.extend(joining.said.doubts());
        let counted = counted.iter().map(|(i, _)| i.id.clone()).collect();
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
        if rows.iter().any(Option::is_some) {
            return Ok((rows, unknown));
        }
        Err(self.intersections[0].at_first(format!(
            "none of the counted intersections ({}) is one of the table ({}); call them alike in a column INTID, the title \
             or the name of the file, for example with the ids of --signals",
            few(unknown.into_iter()),
            few(intersections.iter().map(|i| i.id.clone()))
        )))
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
pub fn meant<'a>(
    name: &str,
    ids: impl Iterator<Item = &'a str>,
) -> Result<Option<&'a str>, String> {
    let plain = comparable(name);
    let mut alike: BTreeSet<&str> = ids.filter(|id| comparable(id) == plain).collect();
    if let Some(exact) = alike.get(name) {
        return Ok(Some(*exact));
    }
    if alike.len() > 1 {
        let alike = alike.into_iter().collect::<Vec<_>>().join(" or ");
        return Err(format!(
            "{name} may be intersection {alike}; call it exactly like one of them"
        ));
    }
    Ok(alike.pop_first())
}

/// Returns a name as it is compared: without case, leading zeros, and what separates words.
fn comparable(id: &str) -> String {
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

/// Returns the arms of an intersection that vehicles with these directions come from, as positions in `arms`, and whether
/// another assignment is nearly as good, as at an intersection whose streets lie at 45 degrees. Where the names of all arms
/// that lead to the signal begin with different directions, as those of UTDF do, these count, else the compass: each arm
/// once, with the least sum of squared deviations.
pub(crate) fn matched_arms(
    headings: &[Heading],
    arms: &[Approach],
    taken: &[usize],
) -> (Vec<Option<usize>>, bool) {
    let incoming: Vec<usize> = (0..arms.len()).filter(|i| arms[*i].lanes_in > 0).collect();
    if let Some(told) = Heading::told(incoming.iter().map(|i| arms[*i].arm.as_str())) {
        let place = |heading: &Heading| told.iter().position(|other| other == heading);
        let arms = headings.iter().map(|heading| place(heading).map(|i| incoming[i])).collect();
        return (arms, false);
    }
    let free = incoming.into_iter().filter(|i| !taken.contains(i));
    let free: Vec<(usize, f64)> = free.map(|i| (i, arms[i].bearing_deg)).collect();
    let mut all = Vec::new();
    assign(headings, &free, &mut Vec::new(), 0.0, &mut all);
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let n = headings.len().max(1) as f64;
    let second = all.get(1).map_or(f64::INFINITY, |(cost, _)| *cost);
    let (best, arms) = all.swap_remove(0);
    (arms, (second / n).sqrt() - (best / n).sqrt() < CLOSE_DEG)
}

/// Collects the assignments of the directions that are left to arms of these bearings, each with its cost.
fn assign(
    headings: &[Heading],
    free: &[(usize, f64)],
    chosen: &mut Vec<Option<usize>>,
    cost: f64,
    all: &mut Vec<(f64, Vec<Option<usize>>)>,
) {
    let Some(heading) = headings.get(chosen.len()) else {
        all.push((cost, chosen.clone()));
        return;
    };
    let off_deg = |bearing_deg: f64| turn_degrees(heading.degrees(), bearing_deg + 180.0).abs();
    let ways = free.iter().map(|(arm, bearing_deg)| (Some(*arm), off_deg(*bearing_deg)));
    for (arm, off_deg) in ways.chain([(None, WITHOUT_DEG)]) {
        if arm.is_none() || off_deg <= MOST_OFF_DEG && !chosen.contains(&arm) {
            chosen.push(arm);
            assign(headings, free, chosen, cost + off_deg * off_deg, all);
            chosen.pop();
        }
    }
}

/// Takes counts of nobody on foot for no counts, where a file has no other, and says so; elsewhere says which intersections have
/// no other.
pub(crate) fn without_zero_pedestrians<'a>(
    arms: impl Iterator<Item = &'a mut Approach>,
) -> Option<Doubt> {
    let mut of_id = BTreeMap::<&str, Vec<&mut Option<f64>>>::new();
    for Approach { intersection, counted, .. } in arms {
        let people = counted.as_mut().map(|counted| &mut counted.pedestrians_per_h);
        of_id.entry(intersection).or_default().extend(people.filter(|people| people.is_some()));
    }
    of_id.retain(|_, people| !people.is_empty());
    let count = of_id.len();
    of_id.retain(|_, people| people.iter().all(|people| **people == Some(0.0)));
    let ids = of_id.keys().map(|id| format!("intersection {id}")).collect();
    if of_id.len() < count {
        return Doubt::of(
            "pedestrian counts are all 0 at some intersections only, where nobody walks then; empty \
                          pedestrians_per_h of approaches.csv where nobody counted",
            ids,
        );
    }
    of_id.into_values().flatten().for_each(|people| *people = None);
    Doubt::of(
        "pedestrian counts are all 0, so nobody counted, and pedestrians have recall; --set \
               family.zero_pedestrians=true takes them for counts of nobody",
        ids,
    )
}

fn words([left, through, right]: [f64; 3]) -> String {
    format!("{left:.0} left, {through:.0} through, {right:.0} right")
}

impl Joining {
    /// Returns the busiest hour of an intersection, if one is complete.
    fn hour(
        &mut self,
        counted: &CountedIntersection,
        id: &str,
        period: Option<&Period>,
    ) -> Result<Option<Hour>, FamilyError> {
        let (from, to) = period.map_or((0, DAY_MIN), |p| (p.from_min, p.to_min));
        let is_weekend = |row: &&Interval| {
            row.day.is_some_and(|day| matches!(day.weekday(), Weekday::Saturday | Weekday::Sunday))
        };
        let is_within = |row: &&Interval| row.minute.is_none_or(|m| (from..to).contains(&m));
        let (weekends, working): (Vec<&Interval>, Vec<_>) =
            counted.intervals.iter().partition(is_weekend);
        let has_working_days = working.iter().any(is_within);
        let rows = if has_working_days { working } else { counted.intervals.iter().collect() };
        let hour = busiest(&rows, period)
            .map_err(|(line, message)| at(&counted.file, Fault { line, message }))?;
        let Some(hour) = hour else { return Ok(None) };
        let of_period = period.map_or_else(String::new, |p| format!(", {}", p.name));
        let at = format!("intersection {id}{of_period}");
        let days = |rows: &[&Interval]| rows.iter().map(|row| row.day).collect::<BTreeSet<_>>();
        let all_days = days(&counted.intervals.iter().collect::<Vec<_>>()).len();
        let left_out = if has_working_days { days(&weekends).len() } else { 0 };
        let empty = few(hour.empty.iter().map(u64::to_string));
        let of_days = match left_out {
            0 => format!("{at}: {} days", hour.days),
            n => format!("{at}: {} days, without weekends ({n})", hour.days),
        };
        for (is, about, row) in [
            (all_days > 1, "the hour is the mean of several days", of_days),
            (
                !has_working_days && !weekends.is_empty(),
                "the hour is one of a weekend, because no working day was counted then",
                at.clone(),
            ),
            (
                !hour.empty.is_empty(),
                "empty fields beside numbers count as nobody",
                format!("{at}: {}, line {empty}", counted.file),
            ),
            (
                hour.total() < FEW_VEHICLES,
                "the busiest hour has hardly any vehicle; counts may be shares or in thousands",
                format!("{at}: {:.1} vehicles", hour.total()),
            ),
            (hour.is_assumed, "rows without a length, read as the vehicles of an hour", at.clone()),
        ] {
            if is {
                self.said.say(about, row);
            }
        }
        Ok(Some(hour))
    }

    /// Gives an hour to the arms of an intersection.
    fn give(&mut self, hour: &Hour, intersection: &Intersection, arms: &mut [Approach]) {
        let id = &intersection.id;
        let is_counted = |(_, n): &(_, &f64)| **n > 0.0;
        let headings: BTreeSet<Heading> =
            hour.vehicles.iter().filter(is_counted).map(|((heading, _), _)| *heading).collect();
        let headings: Vec<Heading> = headings.into_iter().collect();
        let (matched, is_ambiguous) = matched_arms(&headings, arms, &[]);
        if is_ambiguous {
            self.said.say("directions of the compass may belong to other arms, because the streets lie between them; compare the volumes", format!("intersection {id}"));
        }
        let has_arm = matched.iter().any(Option::is_some);
        self.is_given |= has_arm;
        if !has_arm && !headings.is_empty() {
            let counted: Vec<&str> = headings.iter().map(|heading| heading.name()).collect();
            let known: Vec<&str> = arms.iter().map(|arm| arm.arm.as_str()).collect();
            self.nowhere.push(format!(
                "intersection {id}: its counted directions {} belong to none of its arms {}; call directions and arms alike, \
                 or correct bearing_deg of the arms",
                counted.join(" "),
                known.join(", ")
            ));
        }
        // An approach without vehicles was counted as well, as long as others were.
        let before: Vec<Option<Counted>> = arms.iter().map(|arm| arm.counted).collect();
        for arm in arms.iter_mut().filter(|arm| arm.lanes_in > 0) {
            arm.counted = Some(Counted::default());
        }
        let arm_of: BTreeMap<Heading, Option<usize>> = headings.into_iter().zip(matched).collect();
        for (&heading, &arm) in &arm_of {
            let at = format!("intersection {id}, {heading}");
            let vehicles =
                |towards| hour.vehicles.get(&(heading, towards)).copied().unwrap_or_default();
            let back = vehicles(Towards::UTurn);
            let mut volumes = [Towards::Left, Towards::Through, Towards::Right].map(vehicles);
            let Some(arm) = arm else {
                let all = volumes.iter().sum::<f64>() + back;
                self.said.say("counted directions have no arm, and their vehicles are not simulated; correct the direction or bearing_deg", format!("{at}: {all:.0} veh/h"));
                continue;
            };
            let others = (0..arms.len()).filter(|i| *i != arm && arms[*i].lanes_out > 0);
            let others = others.map(|i| (i, arms[i].bearing_deg));
            let exits = exits_on(self.side, arms[arm].bearing_deg, others);
            let is_named = name_exits(&arm_of, heading, &exits);
            let ways: Vec<Turn> =
                if is_named { TURNS.to_vec() } else { exits.iter().map(|e| e.1).collect() };
            self.fit(&mut volumes, &ways, &at);
            let across = Turn::across(self.side);
            if back > 0.0 && ways.contains(&across) {
                volumes[across as usize] += back;
                let about = format!("U-turns count as {} turns", across.name());
                self.said.say(about, format!("{at}: {back:.0} veh/h"));
            } else if back > 0.0 {
                self.said.say(NO_EXIT, format!("{at} U-turn: {back:.0} veh/h"));
            }
            for (turn, towards) in TURNS.into_iter().zip(Towards::ALL) {
                let is_counted = hour.vehicles.contains_key(&(heading, towards));
                if ways.contains(&turn) && !is_counted && volumes[turn as usize] == 0.0 {
                    let about = "turns that exist were not counted, and have no vehicles";
                    self.said.say(about, format!("{}, {at} {}", self.file, turn.name()));
                }
            }
            let mut exits_vph = None;
            if is_named {
                let (by_bearings, by_exit) = by_turn(volumes, &exits);
                self.said.say(
                    "streets bend, so bearings call turns otherwise; the vehicles go to the exits that the names of directions say",
                    format!("{at}: {} are {}", words(volumes), words(by_bearings)),
                );
                (volumes, exits_vph) = (by_bearings, Some(by_exit));
            }
            let letters = &mut arms[arm].movements;
            let has_letters = !letters.is_empty();
            for ((volume, letter), turn) in volumes.iter().zip(['l', 's', 'r']).zip(TURNS) {
                if has_letters && *volume > 0.0 && !letters.contains(letter) {
                    letters.push(letter);
                    let about =
                        "counted turns that the arm did not have are added to its movements";
                    self.said.say(about, format!("{at} {}: {volume:.0} veh/h", turn.name()));
                }
            }
            let [left_vph, through_vph, right_vph] = volumes;
            let total: f64 = volumes.iter().sum();
            // Vehicles without an exit are no part of the quarters.
            let quarters = hour.quarters.get(&heading).filter(|_| total > 0.0).map(|quarters| {
                let sum: f64 = quarters.iter().sum();
                Arrivals::QuarterHours(quarters.map(|vehicles| vehicles * total / sum))
            });
            arms[arm].counted = Some(Counted {
                left_vph,
                through_vph,
                right_vph,
                arrivals: quarters,
                heavy_vehicles: hour.heavy.get(&heading).copied(),
                pedestrians_per_h: None,
                exits_vph,
            });
        }
        // What a network in UTDF says stays where nobody counted it.
        for (arm, before) in arms.iter_mut().zip(before) {
            let (Some(counted), Some(before)) = (arm.counted.as_mut(), before) else { continue };
            counted.pedestrians_per_h = before.pedestrians_per_h;
            if counted.total_vph() > 0.0 {
                counted.heavy_vehicles = counted.heavy_vehicles.or(before.heavy_vehicles);
                let is_factor =
                    |arrivals: &Arrivals| matches!(arrivals, Arrivals::PeakHourFactor(_));
                counted.arrivals = counted.arrivals.or(before.arrivals.filter(is_factor));
            }
        }
        if !hour.pedestrians.is_empty() {
            self.give_pedestrians(hour, id, arms, arm_of);
        }
    }

    /// Gives the people of an hour to the arms that they cross.
    fn give_pedestrians(
        &mut self,
        hour: &Hour,
        id: &str,
        arms: &mut [Approach],
        mut arm_of: BTreeMap<Heading, Option<usize>>,
    ) {
        let headings = hour.pedestrians.keys().copied().flatten();
        let headings: Vec<Heading> =
            headings.filter(|heading| !arm_of.contains_key(heading)).collect();
        let taken: Vec<usize> = arm_of.values().copied().flatten().collect();
        let (matched, _) = matched_arms(&headings, arms, &taken);
        arm_of.extend(headings.into_iter().zip(matched));
        let anywhere = hour.pedestrians.get(&None).copied();
        if let Some(anywhere) = anywhere.filter(|anywhere| *anywhere > 0.0) {
            self.said.say(
                "pedestrians per hour without a direction are divided equally among the crosswalks",
                format!("intersection {id}: {anywhere:.0}"),
            );
        }
        let incoming = arms.iter().filter(|arm| arm.lanes_in > 0).count();
        // Nobody knows who crosses an arm that was not counted beside others.
        let share = anywhere.map(|anywhere| anywhere / incoming.max(1) as f64);
        let mut per_h = vec![share; arms.len()];
        let counted = hour.pedestrians.iter().filter_map(|(heading, n)| Some(((*heading)?, *n)));
        for (heading, count) in counted {
            match arm_of[&heading] {
                Some(arm) => *per_h[arm].get_or_insert(0.0) += count,
                None if count > 0.0 => self.said.say("pedestrians cross an arm that does not lead to the signal, and are not simulated", format!("intersection {id}, {heading}: {count:.0}")),
                None => {}
            }
        }
        for (arm, per_h) in arms.iter_mut().zip(per_h) {
            let Some(counted) = arm.counted.as_mut().filter(|_| arm.lanes_in > 0) else { continue };
            let at = format!("intersection {id}, arm {}", arm.arm);
            let Some(per_h) = per_h else {
                self.said.say("pedestrians were counted on other arms only, and these have nobody who pushes a button", at);
                continue;
            };
            counted.pedestrians_per_h = Some(per_h.min(MOST_PEDESTRIANS_PER_H));
            if per_h > MOST_PEDESTRIANS_PER_H {
                self.said.say(
                    format!("more than {MOST_PEDESTRIANS_PER_H} pedestrians per hour cross an arm, and so many are simulated"),
                    format!("{at}: {per_h:.0}"),
                );
            }
        }
    }

    /// Gives the vehicles of turns that do not exist to exits that nobody was counted for, from left to right.
    fn fit(&mut self, volumes: &mut [f64; 3], ways: &[Turn], at: &str) {
        let told = *volumes;
        let turns = |is_missing: bool| -> Vec<usize> {
            let is = |i: &usize| {
                (told[*i] > 0.0) == is_missing && ways.contains(&TURNS[*i]) != is_missing
            };
            (0..3).filter(is).collect()
        };
        let (missing, free) = (turns(true), turns(false));
        if !missing.is_empty() && missing.len() == free.len() {
            missing.iter().zip(free).for_each(|(from, to)| volumes.swap(*from, to));
            self.said.say(
                "counted turns are given to exits from left to right, because bearings call them otherwise",
                format!("{at}: {} become {}", words(told), words(*volumes)),
            );
            return;
        }
        for i in missing {
            let word = TURNS[i].name();
            self.said.say(NO_EXIT, format!("{at} {word}: {:.0} veh/h", volumes[i]));
            volumes[i] = 0.0;
        }
    }
}

/// Whether the three exits of an approach are left, ahead and right by the names of directions, and not by bearings. Bearings
/// make at most one exit the way straight on, and none that is 45 degrees off; names know more: northbound vehicles that go
/// straight on leave by the arm that southbound ones come from.
fn name_exits(
    arm_of: &BTreeMap<Heading, Option<usize>>,
    heading: Heading,
    exits: &[(usize, Turn)],
) -> bool {
    let by_name = FACING.map(|eighths| arm_of.get(&heading.clockwise(eighths)).copied().flatten());
    exits.len() == TURNS.len()
        && exits.iter().zip(TURNS).any(|((_, turn), named)| *turn != named)
        && exits.iter().zip(by_name).all(|((arm, _), named)| Some(*arm) == named)
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

/// Returns names as messages list them.
pub(crate) fn few(names: impl Iterator<Item = String>) -> String {
    let mut names: Vec<String> = names.collect();
    names.dedup();
    let more = if names.len() > MOST_NAMES { ", ..." } else { "" };
    format!("{}{more}", names[..names.len().min(MOST_NAMES)].join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Heading::{East, North, NorthEast, South, SouthWest, West};
    use Turn::{Left, Right, Through};

    /// The arms of directions, of arms with these bearings.
    fn matching(headings: &[Heading], bearings_deg: &[f64]) -> (Vec<Option<usize>>, bool) {
        let arm = |deg: &f64| Approach { bearing_deg: *deg, lanes_in: 1, ..Approach::default() };
        matched_arms(headings, &bearings_deg.iter().map(arm).collect::<Vec<_>>(), &[])
    }

    #[test]
    fn directions_belong_to_the_arms_that_their_vehicles_come_from() {
        let cross = matching(&[North, South, East, West], &[10.0, 95.0, 185.0, 280.0]);
        assert_eq!(cross, (vec![Some(2), Some(0), Some(3), Some(1)], false));
        // A skew street, a missing arm, diagonals.
        let skew = matching(&[North, South, East], &[60.0, 240.0]);
        assert_eq!(skew.0, [None, Some(0), Some(1)]);
        assert_eq!(matching(&[North, South], &[60.0, 240.0]).0, [Some(1), Some(0)]);
        assert_eq!(matching(&[NorthEast, SouthWest], &[45.0, 225.0]).0, [Some(1), Some(0)]);
        // Streets at 45 degrees may be meant either way.
        assert!(matching(&[North, South, East, West], &[45.0, 135.0, 225.0, 315.0]).1);
    }

    #[test]
    fn a_bent_street_goes_on_by_the_names_of_directions() {
        // Arms in the north-east, south-east, south and west.
        let arm_of = [(North, Some(2)), (South, Some(0)), (East, Some(3)), (West, Some(1))].into();
        let northbound = [(3, Left), (0, Right), (1, Right)];
        assert!(name_exits(&arm_of, North, &northbound));
        assert_eq!(
            by_turn([100.0, 400.0, 50.0], &northbound),
            ([100.0, 0.0, 450.0], [100.0, 400.0, 50.0, 0.0, 0.0])
        );
        assert!(name_exits(&arm_of, South, &[(1, Left), (2, Left), (3, Through)]));
        // Bearings that agree, and exits in another order.
        assert!(!name_exits(&arm_of, North, &[(3, Left), (0, Through), (1, Right)]));
        assert!(!name_exits(&arm_of, North, &[(0, Left), (3, Right), (1, Right)]));
    }
}
