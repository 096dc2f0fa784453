//! Turning movement counts: vehicles by approach and turn at an intersection, as count companies and detectors deliver
//! them.
//!
//! One row per intersection and interval. Columns are named by the direction of travel and the turn: `NBL` is a
//! northbound left turn, from the south to the west. Titles above the names of the columns and totals below the rows are
//! passed over. [`TurningCounts::into_approaches`] gives the counted vehicles to the arms of a table of approaches.

mod below;
pub mod clock;
mod days;
mod exits;
pub mod header;
pub mod hour;
mod join;
mod matching;
mod sums;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use osm_signals::sources::Source;
use sheet::uneven::{self, Line};
use sheet::{Fault, file};

use crate::family::doubts::Doubt;
use basics::files::FileError;
use below::below_directions;
use evaluation::family::columns::at;
use evaluation::family::error::FamilyError;
use header::{Heading, Holds, holds, may_be_movement};
use hour::Interval;
pub use hour::Period;
pub use join::Joined;
pub(crate) use join::{FEW_VEHICLES, meant};
pub(crate) use matching::matched_arms;

/// Least columns of movements that make a line the one with the names of the columns.
const ENOUGH: usize = 3;

/// Most names of columns, or of lines, that a message lists.
const FEW: usize = 8;

/// What stands in a field for a movement that does not exist or has no detector.
const NOTHING: [&str; 4] = ["*", "-", "--", "n/a"];

/// Turning movement counts of intersections, from one or more files.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TurningCounts {
    /// By the intersection as the files call it, in their order; empty in a file without that column.
    intersections: Vec<(String, CountedIntersection)>,
    /// What was read otherwise than it stands there.
    doubts: Vec<Doubt>,
}

/// The rows of an intersection.
#[derive(Debug, Clone, PartialEq)]
struct CountedIntersection {
    /// The file.
    file: String,
    /// Column with its name; empty without one.
    id_column: String,
    /// Minutes of a row, where the title of its table says them.
    said_min: Option<u32>,
    /// Its rows.
    intervals: Vec<Interval>,
}

impl TurningCounts {
    /// Reads files of counts: CSV, workbooks, or zipped. Of a workbook every sheet that names movements is read.
    ///
    /// # Errors
    ///
    /// [`FamilyError::Csv`] with file and line: no line that names movements, a field that is no number, an
    /// intersection in two files.
    pub fn read<P: AsRef<Path>>(paths: &[P]) -> Result<Self, FamilyError> {
        let mut all = Self::default();
        for path in paths {
            let path = path.as_ref();
            let file = path.display().to_string();
            let wrong = |message: String| at(&file, Fault { line: 1, message });
            let bytes = file::read(path, file::TABLE_BYTES).map_err(FileError::at("read", path))?;
            let sources = Source::sheets(&bytes, path).map_err(|e| wrong(e.to_string()))?;
            all.add_sheets(&sources, &file)?;
        }
        Ok(all)
    }

    /// Adds the sheets of a workbook that name movements, or the one table of another file.
    ///
    /// # Errors
    ///
    /// As [`TurningCounts::read`].
    fn add_sheets(&mut self, sheets: &[Source<'_>], file: &str) -> Result<(), FamilyError> {
        let is_named = |sheet: &&Source<'_>| {
            let lines = uneven::lines(&sheet.bytes).unwrap_or_default();
            (0..lines.len()).any(|i| Columns::of(&lines, i).is_some())
        };
        let (mut named, mut others): (Vec<&Source>, Vec<&Source>) =
            sheets.iter().partition(is_named);
        if named.is_empty() {
            // The first says what is missing.
            named.push(others.remove(0));
        }
        for sheet in named {
            let name = match sheets.len() {
                1 => file.to_owned(),
                _ => format!("{file}, sheet {}", sheet.sheet),
            };
            self.add_table(&sheet.bytes, &name, sheet.rows.1)?;
        }
        self.doubts.extend(Doubt::of(
            format!("{file}: sheets that name no movements are passed over"),
            others.into_iter().map(|sheet| sheet.sheet.clone()).collect(),
        ));
        Ok(())
    }

    /// Adds a file; its name is for messages.
    ///
    /// # Errors
    ///
    /// As [`TurningCounts::read`].
    pub fn add(&mut self, bytes: &[u8], file: &str) -> Result<(), FamilyError> {
        self.add_table(bytes, file, 0)
    }

    /// Adds a table.
    ///
    /// # Errors
    ///
    /// As [`TurningCounts::read`].
    ///
    /// # Arguments
    ///
    /// * `above` — what the number of a row in the file is more than its line in the text.
    fn add_table(&mut self, bytes: &[u8], file: &str, above: i64) -> Result<(), FamilyError> {
        if uneven::is_utdf(bytes) {
            let message = "a network in UTDF, not a table of counts; give it with --utdf, which takes its volumes too";
            return Err(at(file, Fault { line: 1, message: message.to_owned() }));
        }
        let mut lines = uneven::lines(bytes).map_err(|fault| at(file, fault))?;
        for line in &mut lines {
            line.number = line.number.saturating_add_signed(above).max(1);
        }
        let mut columns: Option<Columns> = None;
        let mut said_min = None;
        let (mut sums, mut shares) = (Vec::new(), Vec::new());
        let (mut skipped, mut unused) = (Vec::new(), BTreeSet::new());
        let mut found: Vec<(String, CountedIntersection)> = Vec::new();
        for (i, line) in lines.iter().enumerate() {
            if let Some(named) = Columns::of(&lines, i) {
                let named =
                    named.map_err(|message| at(file, Fault { line: line.number, message }))?;
                unused.extend(named.unused.iter().cloned());
                columns = Some(named);
                continue;
            }
            let Some(columns) = &columns else {
                if let Some(zone) = universal_title(line) {
                    return Err(at(
                        file,
                        Fault { line: line.number, message: universal_time(zone) },
                    ));
                }
                said_min = line.fields().find_map(minutes_of_title).or(said_min);
                continue;
            };
            let wrong = |message: String| at(file, Fault { line: line.number, message });
            match columns.interval(line).map_err(wrong)? {
                None => skipped.push(format!("line {}: {}", line.number, first_words(line))),
                Some((id, interval)) => {
                    sums.extend(columns.wrong_sum(line, &interval));
                    shares.extend(columns.share_for_percent(line));
                    let known = found.iter_mut().find(|(name, _)| *name == id);
                    match known {
                        Some((_, counted)) => counted.intervals.push(interval),
                        None => found.push((
                            id,
                            CountedIntersection {
                                file: file.to_owned(),
                                id_column: columns.id_name.clone(),
                                said_min,
                                intervals: vec![interval],
                            },
                        )),
                    }
                }
            }
        }
        if columns.is_none() {
            let message = "no line names movements; expected columns such as INTID, Time, NBL, NBT, NBR, SBL, where NB is \
                           northbound traffic and L, T, R are left, through, right";
            return Err(at(file, Fault { line: 1, message: message.to_owned() }));
        }
        if found.is_empty() {
            let message = "no row with counts below the names of the columns";
            let line = lines.first().map_or(1, |line| line.number);
            return Err(at(file, Fault { line, message: message.to_owned() }));
        }
        if let Some(row) = universal_row(&found) {
            return Err(at(file, Fault { line: row.line, message: universal_time(&row.zone) }));
        }
        for (id, counted) in found {
            // Mornings and evenings come in files of their own.
            match self.intersections.iter_mut().find(|(name, _)| *name == id) {
                None => self.intersections.push((id, counted)),
                Some((_, other)) => {
                    other.file = format!("{} and {file}", other.file);
                    other.said_min = other.said_min.or(counted.said_min);
                    other.intervals.extend(counted.intervals);
                }
            }
        }
        self.doubts.extend(Doubt::of(
            format!("{file}: percentages of heavy vehicles below 1; if they are shares, multiply them by 100"),
            shares,
        ));
        self.doubts.extend(Doubt::of(
            format!("{file}: lines without a time or an intersection are passed over"),
            skipped,
        ));
        self.doubts.extend(Doubt::of(
            format!("{file}: the turns of an approach do not sum up to its column of totals; the turns count"),
            sums,
        ));
        if !unused.is_empty() {
            let names: Vec<&str> = unused.iter().map(String::as_str).take(FEW).collect();
            let more = unused.len().saturating_sub(FEW);
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            self.doubts.push(Doubt::whole(format!(
                "{file}: columns that are not used: {}{more}",
                names.join(", ")
            )));
        }
        Ok(())
    }

    /// Returns how many intersections were counted.
    pub fn len(&self) -> usize {
        self.intersections.len()
    }

    /// Returns whether nothing was counted.
    pub fn is_empty(&self) -> bool {
        self.intersections.is_empty()
    }
}

/// Returns whether one of some lines names movements.
pub(crate) fn names_movements(lines: &[Line]) -> bool {
    (0..lines.len()).any(|i| matches!(Columns::of(lines, i), Some(Ok(_))))
}

/// Returns what is wrong with times of a zone that is universal time.
fn universal_time(zone: &str) -> String {
    format!(
        "time in the zone {zone:?} is universal time; write local time, such as 07:15 or 07:15-06:00, or remove the zone if \
         it is local time already"
    )
}

/// Returns the first row in universal time, unless others have another zone: then `+00:00` is the winter of a country.
fn universal_row(found: &[(String, CountedIntersection)]) -> Option<&Interval> {
    let rows = || found.iter().flat_map(|(_, counted)| &counted.intervals);
    let is_local = |row: &Interval| !row.zone.is_empty() && !clock::is_universal(&row.zone);
    if rows().any(is_local) { None } else { rows().find(|row| clock::is_universal(&row.zone)) }
}

/// Returns the zone of a title such as `Time zone: UTC`, where it is universal time.
fn universal_title(line: &Line) -> Option<&str> {
    let is_zone = |field: &str| field.to_lowercase().replace(' ', "").contains("timezone");
    if !line.fields().any(is_zone) {
        return None;
    }
    let mut values =
        line.fields().map(|field| field.split_once(": ").map_or(field, |(_, value)| value));
    // A number in another field of the line is no offset.
    values.find(|value| value.parse::<f64>().is_err() && clock::is_universal(value))
}

/// Returns the minutes of a row that a title says, such as `15 Minute Counts`.
fn minutes_of_title(text: &str) -> Option<u32> {
    let text = text.to_lowercase();
    text.match_indices("min").find_map(|(at, min)| {
        // Other words begin so as well, such as Minneapolis.
        let after = text[at + min.len()..].split(|c: char| !c.is_alphabetic()).next()?;
        if !matches!(after, "" | "s") && !after.starts_with("ute") {
            return None;
        }
        let digits = text[..at].trim_end_matches([' ', '-']).rsplit(' ').next()?;
        digits.parse().ok().filter(|minutes| (1..=60).contains(minutes) && 60 % minutes == 0)
    })
}

/// Returns the first words of a line.
fn first_words(line: &Line) -> String {
    line.fields().filter(|f| !f.is_empty()).take(2).collect::<Vec<_>>().join(" ")
}

/// What the columns of a table hold.
struct Columns {
    holds: Vec<(usize, Holds)>,
    /// Name of the column with the intersection; empty without one.
    id_name: String,
    unused: Vec<String>,
}

impl Columns {
    /// Returns the columns that a line names, alone or below a line with the directions; `None` if it names none.
    ///
    /// # Errors
    ///
    /// A column of several turns, or one of which nobody can tell what it counts.
    fn of(lines: &[Line], at: usize) -> Option<Result<Self, String>> {
        let line = &lines[at];
        let names: Vec<String> = match movements(line.fields()) >= ENOUGH {
            true => line.fields().map(str::to_owned).collect(),
            false => match below_directions(lines, at)? {
                Ok(names) => names,
                Err(message) => return Some(Err(message)),
            },
        };
        let (mut all, mut unused) = (Vec::new(), Vec::new());
        for (i, name) in names.iter().enumerate() {
            match holds(name) {
                Some(Holds::Shared(_)) => {
                    return Some(Err(format!(
                        "column {name} counts several turns together; give each turn a column of its own"
                    )));
                }
                Some(holds) => all.push((i, holds)),
                None if name.is_empty() => {}
                None if may_be_movement(name) => {
                    return Some(Err(format!(
                        "column {name} may count vehicles, and is not understood; call it such as NBL or NB HV %, or remove \
                         it"
                    )));
                }
                None => unused.push(name.clone()),
            }
        }
        let words: Vec<usize> =
            all.iter().map(|(i, _)| *i).filter(|i| is_word(*i, &all, &names)).collect();
        all.retain(|(i, _)| !words.contains(i));
        unused.extend(words.into_iter().map(|i| names[i].clone()));
        let settled = keep_local(&mut all, &mut unused, &names)
            .and_then(|()| sums::settle(&mut all, &mut unused, &names));
        if let Err(message) = settled {
            return Some(Err(message));
        }
        let holds = best_id(all, &names);
        let id = holds.iter().find(|(_, holds)| *holds == Holds::Intersection);
        let id_name = id.map(|(i, _)| names[*i].clone()).unwrap_or_default();
        Some(Ok(Self { holds, id_name, unused }))
    }

    fn find(&self, wanted: Holds) -> Option<usize> {
        self.holds.iter().find(|(_, holds)| *holds == wanted).map(|(i, _)| *i)
    }

    /// Returns the intersection of a row and what was counted; `None` for a line that is none, such as a total.
    fn interval(&self, line: &Line) -> Result<Option<(String, Interval)>, String> {
        let text = |wanted: Holds| self.find(wanted).map(|i| plain(line.text(i)));
        let (mut day, mut minute) = (text(Holds::Date).unwrap_or_default().to_owned(), None);
        let of_day = clock::begin(&day);
        let timed = text(Holds::Time).unwrap_or(&day);
        let own_zone = clock::zone(timed);
        let length_min = clock::length_min(timed);
        let zone = own_zone.unwrap_or_else(|| text(Holds::Zone).unwrap_or_default().to_uppercase());
        if let Some(time) = text(Holds::Time) {
            let Some((own, begin)) = clock::begin(time) else {
                // Words are titles and totals. So is what begins with a digit, such as 5th Avenue, and stands alone.
                let place = self.find(Holds::Time);
                let is_number = |i: usize| matches!(line.count(i), Ok(Some(_)));
                let is_alone =
                    !(0..line.fields().count()).any(|i| Some(i) != place && is_number(i));
                return match time.starts_with(|c: char| c.is_ascii_digit()) && !is_alone {
                    true => Err(format!("time {time:?} is not understood; write it like 07:15")),
                    false => Ok(None),
                };
            };
            // The cell of the date may have a time as well.
            match of_day {
                Some((date, _)) if !date.is_empty() => day = date,
                _ if day.is_empty() => day = own,
                _ => {}
            }
            minute = Some(begin);
        } else if let Some((own, begin)) = of_day {
            // Date and time in one column.
            (day, minute) = (own, Some(begin));
        }
        if minute.is_none() && self.find(Holds::End).is_some() {
            let message =
                "the table has ends of intervals only; add a column Time with their beginnings";
            return Err(message.to_owned());
        }
        let id = text(Holds::Intersection).unwrap_or_default().to_owned();
        let is_total = ["total", "totals", "grand total"].contains(&&*id.to_lowercase());
        if self.find(Holds::Intersection).is_some() && (id.is_empty() || is_total) {
            return Ok(None);
        }
        let mut interval = Interval {
            line: line.number,
            day,
            minute,
            length_min,
            zone,
            vehicles: BTreeMap::new(),
            heavy: BTreeMap::new(),
            pedestrians: BTreeMap::new(),
        };
        let (mut percents, mut numbers) = (Vec::new(), Vec::new());
        for (i, holds) in &self.holds {
            let number = |most: f64| -> Result<Option<f64>, String> {
                if NOTHING.contains(&line.text(*i).to_lowercase().as_str()) {
                    return Ok(None);
                }
                let name = line.text(*i);
                let number =
                    line.count(*i).map_err(|e| format!("{name:?} in column {}: {e}", i + 1))?;
                match number {
                    Some(n) if !(0.0..=most).contains(&n) => {
                        Err(format!("{n} in column {}: expected a number from 0 to {most}", i + 1))
                    }
                    number => Ok(number),
                }
            };
            match holds {
                Holds::Vehicles(heading, towards) => {
                    if let Some(count) = number(1e6)? {
                        *interval.vehicles.entry((*heading, *towards)).or_insert(0.0) += count;
                    }
                }
                Holds::HeavyVehicles(heading, towards) => {
                    if let Some(count) = number(1e6)? {
                        *interval.vehicles.entry((*heading, *towards)).or_insert(0.0) += count;
                        *interval.heavy.entry(*heading).or_insert(0.0) += count;
                    }
                }
                Holds::HeavyPercent(heading) => {
                    percents.extend(number(100.0)?.map(|percent| (*heading, percent)));
                }
                Holds::HeavyCount(heading) => {
                    numbers.extend(number(1e6)?.map(|count| (*heading, count)));
                }
                Holds::Pedestrians(heading) => {
                    if let Some(count) = number(1e6)? {
                        *interval.pedestrians.entry(*heading).or_insert(0.0) += count;
                    }
                }
                Holds::Intersection
                | Holds::Date
                | Holds::Time
                | Holds::UniversalTime
                | Holds::Zone
                | Holds::End
                | Holds::Total(_)
                | Holds::HeavyUnclear(_)
                | Holds::Shared(_) => {}
            }
        }
        for (heading, percent) in percents {
            let vehicles = interval.approach(heading);
            interval.heavy.insert(heading, vehicles * percent / 100.0);
        }
        for (heading, count) in numbers {
            let vehicles = interval.approach(heading);
            if count > vehicles {
                return Err(format!(
                    "{count} heavy vehicles {heading}, but {vehicles} vehicles there; if they are percent, put % into the \
                     name of the column"
                ));
            }
            interval.heavy.insert(heading, count);
        }
        Ok(Some((id, interval)))
    }
}

/// Returns whether a column that seems to have a movement has another word for its name, because no other column is of that
/// street.
fn is_word(column: usize, all: &[(usize, Holds)], names: &[String]) -> bool {
    let heading =
        |i: usize| all.iter().find(|(j, _)| *j == i).and_then(|(_, holds)| holds.heading());
    let Some(own) = heading(column).filter(|_| header::may_be_word(&names[column])) else {
        return false;
    };
    let opposite = Heading::ALL[(own as usize + 4) % 8];
    let is_of_street = |holds: &Holds| holds.heading().is_some_and(|h| h == own || h == opposite);
    !all.iter().any(|(i, holds)| *i != column && is_of_street(holds))
}

/// Takes columns of times to those that are not used where another column has the local time.
///
/// # Errors
///
/// A column in universal time without another one.
fn keep_local(
    all: &mut Vec<(usize, Holds)>,
    unused: &mut Vec<String>,
    names: &[String],
) -> Result<(), String> {
    let is_local = |column: &(usize, Holds)| header::says_local(&names[column.0]);
    let local: Vec<Holds> = all.iter().filter(|c| is_local(c)).map(|(_, holds)| *holds).collect();
    let universal = all.iter().find(|(_, holds)| *holds == Holds::UniversalTime);
    let has_time = all.iter().any(|(_, holds)| *holds == Holds::Time);
    if let Some((i, _)) = universal.filter(|_| !has_time) {
        return Err(format!(
            "column {} has universal time; write local time in a column Time, or call it Time if it is local time already",
            names[*i]
        ));
    }
    let is_other = |column: &(usize, Holds)| match column.1 {
        Holds::UniversalTime => true,
        Holds::Time | Holds::Date => local.contains(&column.1) && !is_local(column),
        _ => false,
    };
    unused.extend(all.iter().filter(|c| is_other(c)).map(|(i, _)| names[*i].clone()));
    all.retain(|column| !is_other(column));
    Ok(())
}

/// Returns the columns with one of those that name the intersection.
fn best_id(all: Vec<(usize, Holds)>, names: &[String]) -> Vec<(usize, Holds)> {
    let ids = all.iter().filter(|(_, holds)| *holds == Holds::Intersection).map(|(i, _)| *i);
    let best = ids.min_by_key(|i| header::rank_of_id(&names[*i]));
    all.into_iter().filter(|(i, holds)| *holds != Holds::Intersection || Some(*i) == best).collect()
}

impl Columns {
    /// Returns a percentage of heavy vehicles that may be a share.
    fn share_for_percent(&self, line: &Line) -> Option<String> {
        self.holds.iter().find_map(|(i, holds)| {
            let Holds::HeavyPercent(heading) = holds else { return None };
            let percent = line.count(*i).ok().flatten()?;
            (percent > 0.0 && percent < 1.0)
                .then(|| format!("line {}: {heading} {percent}", line.number))
        })
    }

    /// Returns what is said where the turns of a row do not sum up to its totals.
    fn wrong_sum(&self, line: &Line, interval: &Interval) -> Option<String> {
        self.holds.iter().find_map(|(i, holds)| {
            let Holds::Total(heading) = holds else { return None };
            let total = line.count(*i).ok().flatten()?;
            let sum = interval.approach(*heading);
            let differs = (total - sum).abs() > 0.5;
            differs
                .then(|| format!("line {}: {heading} {sum:.0} instead of {total:.0}", line.number))
        })
    }
}

impl Interval {
    /// Returns the vehicles of an approach.
    fn approach(&self, heading: header::Heading) -> f64 {
        self.vehicles.iter().filter(|((h, _), _)| *h == heading).map(|(_, count)| count).sum()
    }
}

/// Returns a text without the marks by which spreadsheets keep leading zeros: `="0715"`.
fn plain(text: &str) -> &str {
    text.strip_prefix('=').unwrap_or(text).trim_matches('"').trim()
}

fn movements<'a>(names: impl Iterator<Item = &'a str>) -> usize {
    let is_movement = |name: &&str| {
        matches!(
            holds(name),
            Some(Holds::Vehicles(..) | Holds::HeavyVehicles(..) | Holds::Shared(_))
        )
    };
    names.filter(is_movement).count()
}

#[cfg(test)]
mod tests;
