//! Turning movement counts: vehicles by approach and turn at an intersection, as count companies and detectors deliver
//! them.
//!
//! A `layout` says what the columns of a table hold: `NBL` is a northbound left turn, from the south to the west. A file
//! that fits no layout is refused. [`TurningCounts::into_approaches`] gives the counted vehicles to the arms of a table of
//! approaches.

pub mod hour;
mod join;
mod layout;
mod matching;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use jiff::civil::Date;
use osm_signals::sources::Source;
use sheet::uneven::{self, Line};
use sheet::{Fault, file};

use crate::family::doubts::{Doubt, Said};
use crate::vocabulary::Heading;
use basics::files::FileError;
use evaluation::family::columns::at;
use evaluation::family::error::FamilyError;
use hour::Interval;
pub use hour::Period;
pub use join::Joined;
pub(crate) use join::{FEW_VEHICLES, meant};
use layout::{Columns, Holds, Kind, Layout, Moment};
pub(crate) use matching::matched_arms;

/// Least columns of movements of a table of counts.
const ENOUGH: usize = 3;

/// Most names, or rows, that a message lists.
const FEW: usize = 8;

/// What stands in a field for a movement that does not exist or has no detector.
const NOTHING: [&str; 4] = ["*", "-", "--", "n/a"];

/// Ends of the names of files that may hold counts.
const ENDS: [&str; 7] = ["csv", "tsv", "txt", "xlsx", "xls", "ods", "zip"];

/// Where vehicles go.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Towards {
    /// To the left.
    Left,
    /// Straight on.
    Through,
    /// To the right.
    Right,
    /// Back.
    UTurn,
}

impl Towards {
    const ALL: [Self; 4] = [Self::Left, Self::Through, Self::Right, Self::UTurn];
}

/// Turning movement counts of intersections, from one or more files.
#[derive(Debug, Clone, Default)]
pub struct TurningCounts {
    intersections: Vec<CountedIntersection>,
    /// What was read otherwise than it stands there.
    doubts: Vec<Doubt>,
}

/// The rows of an intersection.
#[derive(Debug, Clone)]
struct CountedIntersection {
    /// What it may be called: in its column, or in the cell with its name and by its file.
    names: Vec<String>,
    /// Whether a column names it.
    is_named: bool,
    /// The file.
    file: String,
    intervals: Vec<Interval>,
}

/// Returns the files of counts, of a folder those that it holds.
///
/// # Errors
///
/// A folder that cannot be read.
pub fn files(paths: &[PathBuf]) -> Result<Vec<PathBuf>, FamilyError> {
    let mut all = Vec::new();
    for path in paths {
        if !path.is_dir() {
            all.push(path.clone());
            continue;
        }
        let mut inside = Vec::new();
        for entry in std::fs::read_dir(path).map_err(FileError::at("read", path))? {
            let file = entry.map_err(FileError::at("read", path))?.path();
            let end = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
            // Spreadsheets keep ~$name.xlsx of what is open.
            let is_hidden =
                file.file_name().is_some_and(|n| n.to_string_lossy().starts_with(['.', '~']));
            if ENDS.contains(&end.as_str()) && !is_hidden {
                inside.push(file);
            }
        }
        inside.sort();
        all.extend(inside);
    }
    Ok(all)
}

/// Returns whether one of some lines names movements.
pub(crate) fn names_movements(lines: &[Line]) -> bool {
    let layouts = Layout::read(None).unwrap_or_default();
    layouts.iter().any(|l| (0..lines.len()).any(|i| matches!(l.columns(lines, i), Some(Ok(_)))))
}

/// A sheet that fits a layout.
struct Fitting<'a> {
    layout: &'a Layout,
    lines: Vec<Line>,
    /// File, and sheet where there are several.
    name: String,
    /// Name of the sheet if it has one class of vehicles, and whether these are heavy.
    class: Option<(String, bool)>,
}

/// Names, day and time of rows.
type RowKey = (Vec<String>, Option<Date>, Option<u32>);

/// What one file has.
#[derive(Default)]
struct Reading {
    found: Vec<CountedIntersection>,
    /// Where the rows of a time are in it.
    places: BTreeMap<RowKey, (usize, usize)>,
    /// The line in which something was counted.
    seen: BTreeMap<((usize, usize), Holds, String), u64>,
    /// Approaches whose heavy vehicles are classes of their own: where none is listed, there was none.
    classed: BTreeSet<(usize, Heading)>,
    unused: BTreeSet<String>,
    said: Said,
}

impl TurningCounts {
    /// Reads files of counts: CSV, workbooks, or zipped. Of a workbook every sheet that fits a layout is read, except sheets
    /// of one class of vehicles beside one of all.
    ///
    /// # Errors
    ///
    /// [`FamilyError::Csv`] with file and line: no layout fits, a field that is no number.
    ///
    /// # Arguments
    ///
    /// * `layout` — a file with a layout, instead of those that are known.
    pub fn read(paths: &[PathBuf], layout: Option<&Path>) -> Result<Self, FamilyError> {
        let layouts = Layout::read(layout)?;
        let mut all = Self::default();
        for path in paths {
            let name = path.display().to_string();
            let wrong = |message: String| at(&name, Fault { line: 1, message });
            let bytes = file::read(path, file::TABLE_BYTES).map_err(FileError::at("read", path))?;
            let sheets = Source::sheets(&bytes, path).map_err(|e| wrong(e.to_string()))?;
            all.add_sheets(&sheets, &name, &layouts)?;
        }
        Ok(all)
    }

    /// Adds the text of a file; its name is for messages.
    ///
    /// # Errors
    ///
    /// As [`TurningCounts::read`].
    pub fn add(&mut self, bytes: &[u8], file: &str) -> Result<(), FamilyError> {
        let source = Source { bytes: bytes.into(), rows: ("line", 0), sheet: String::new() };
        self.add_sheets(&[source], file, &Layout::read(None)?)
    }

    fn add_sheets(
        &mut self,
        sheets: &[Source<'_>],
        file: &str,
        layouts: &[Layout],
    ) -> Result<(), FamilyError> {
        let (mut fitting, mut others, mut titles) = (Vec::new(), Vec::new(), Vec::new());
        let mut first_fault = None;
        for sheet in sheets {
            if uneven::is_utdf(&sheet.bytes) {
                let message = "a network in UTDF, not a table of counts; give it with --utdf, which takes its volumes too";
                return Err(at(file, Fault { line: 1, message: message.to_owned() }));
            }
            let name = match sheets.len() {
                1 => file.to_owned(),
                _ => format!("{file}, sheet {}", sheet.sheet),
            };
            let mut lines = uneven::lines(&sheet.bytes).map_err(|fault| at(&name, fault))?;
            for line in &mut lines {
                line.number = line.number.saturating_add_signed(sheet.rows.1).max(1);
            }
            match fit(layouts, &lines) {
                Ok(layout) if !layout.leaves_out(&sheet.sheet) => {
                    titles.extend(
                        lines.iter().find_map(|line| layout.title(line)).map(str::to_owned),
                    );
                    let class = layout.is_heavy(&sheet.sheet).map(|h| (sheet.sheet.clone(), h));
                    fitting.push(Fitting { layout, lines, name, class });
                }
                Ok(_) => others.push(sheet.sheet.clone()),
                Err(fault) => {
                    titles.extend(
                        lines.iter().find_map(|line| layouts[0].title(line)).map(str::to_owned),
                    );
                    first_fault.get_or_insert(at(&name, fault));
                    others.push(sheet.sheet.clone());
                }
            }
        }
        if fitting.iter().any(|sheet| sheet.class.is_none()) {
            let (all, classes): (Vec<_>, Vec<_>) =
                fitting.into_iter().partition(|sheet| sheet.class.is_none());
            others.extend(classes.into_iter().filter_map(|sheet| Some(sheet.class?.0)));
            fitting = all;
        }
        if fitting.is_empty() {
            let fault = Fault { line: 1, message: "an empty file".to_owned() };
            return Err(first_fault.unwrap_or_else(|| at(file, fault)));
        }
        titles.dedup();
        titles.extend(Path::new(file).file_stem().map(|stem| stem.to_string_lossy().into_owned()));
        let mut reading = Reading::default();
        for sheet in &fitting {
            reading.table(sheet, &titles)?;
        }
        for (i, heading) in reading.classed {
            for row in &mut reading.found[i].intervals {
                if row.vehicles.keys().any(|(own, _)| *own == heading) {
                    row.heavy.entry(heading).or_insert(0.0);
                }
            }
        }
        if reading.found.is_empty() {
            let line = fitting[0].lines.first().map_or(1, |line| line.number);
            let message = "no row with counts below the names of the columns".to_owned();
            return Err(at(&fitting[0].name, Fault { line, message }));
        }
        self.intersections.extend(reading.found);
        self.doubts.extend(
            reading
                .said
                .doubts()
                .map(|doubt| Doubt { about: format!("{file}: {}", doubt.about), ..doubt }),
        );
        self.doubts.extend(Doubt::of(format!("{file}: sheets that are not used"), others));
        let unused = reading.unused.into_iter().collect();
        self.doubts.extend(Doubt::of(format!("{file}: columns that are not used"), unused));
        Ok(())
    }
}

/// Returns the first layout that fits.
fn fit<'a>(layouts: &'a [Layout], lines: &[Line]) -> Result<&'a Layout, Fault> {
    let mut fault = None;
    for layout in layouts {
        for (i, line) in lines.iter().enumerate() {
            match layout.columns(lines, i) {
                Some(Ok(_)) => return Ok(layout),
                Some(Err(message)) => {
                    fault.get_or_insert(Fault { line: line.number, message });
                    break;
                }
                None => {}
            }
        }
    }
    let line = lines.first().map_or(1, |line| line.number);
    Err(fault.unwrap_or_else(|| Fault { line, message: layout::unknown(lines) }))
}

impl Reading {
    /// Reads a table.
    fn table(&mut self, sheet: &Fitting<'_>, titles: &[String]) -> Result<(), FamilyError> {
        let mut columns: Option<Columns> = None;
        let mut below: BTreeMap<Heading, f64> = BTreeMap::new();
        let mut read = BTreeSet::new();
        for (i, line) in sheet.lines.iter().enumerate() {
            let wrong = |message: String| at(&sheet.name, Fault { line: line.number, message });
            if let Some(named) = sheet.layout.columns(&sheet.lines, i) {
                let named = named.map_err(wrong)?;
                self.unused.extend(named.unused.iter().cloned());
                columns = Some(named);
                continue;
            }
            let Some(columns) = &columns else { continue };
            let row = Row { line, columns, sheet };
            match self.row(&row, titles).map_err(wrong)? {
                Some(place) => {
                    read.insert(place);
                }
                None if row
                    .first()
                    .is_some_and(|class| sheet.layout.is_heavy(class) == Some(true)) =>
                {
                    for (heading, number) in row.approaches().map_err(wrong)? {
                        *below.entry(heading).or_default() += number;
                    }
                }
                None if row.first().is_some_and(|first| sheet.layout.is_heavy(first).is_some()) => {
                }
                None => {
                    let words: Vec<&str> =
                        line.fields().filter(|field| !field.is_empty()).take(2).collect();
                    let about = "lines without a time or an intersection are passed over";
                    self.said.say(about, format!("line {}: {}", line.number, words.join(" ")));
                }
            }
        }
        self.heavy_below(&below, &read);
        Ok(())
    }

    /// Gives rows the shares of heavy vehicles that stand below them.
    fn heavy_below(&mut self, below: &BTreeMap<Heading, f64>, read: &BTreeSet<(usize, usize)>) {
        for (heading, heavy) in below {
            let all: f64 =
                read.iter().map(|(i, k)| self.found[*i].intervals[*k].approach(*heading)).sum();
            for (i, k) in read.iter().filter(|_| all >= *heavy && all > 0.0) {
                let row = &mut self.found[*i].intervals[*k];
                let vehicles = row.approach(*heading);
                row.heavy.entry(*heading).or_insert(vehicles * heavy / all);
            }
        }
    }

    /// Reads a row, and returns where it is; `None` for a line that is none, such as a total.
    fn row(&mut self, row: &Row<'_>, titles: &[String]) -> Result<Option<(usize, usize)>, String> {
        let Some(moment) = row.moment()? else { return Ok(None) };
        let named = row.text(Kind::Intersection);
        let is_total =
            |name: &str| matches!(&*name.to_lowercase(), "" | "total" | "totals" | "grand total");
        if named.is_some_and(is_total) {
            return Ok(None);
        }
        let names = named.map_or_else(|| titles.to_vec(), |name| vec![name.to_owned()]);
        let place = self.place(row, names, moment);
        let interval = &mut self.found[place.0].intervals[place.1];
        let mut heavy = Vec::new();
        for (column, held) in row.columns.holds.iter().filter(|(_, held)| held.kind > Kind::Class) {
            let most = if held.kind == Kind::HeavyPercent { 100.0 } else { 1e6 };
            let Some(number) = row.number(*column, most)? else { continue };
            let (held, class) = match held.kind {
                Kind::Count => row.listed(*held)?,
                _ => (*held, row.sheet.class.clone().unwrap_or_default()),
            };
            if let Some(before) = self.seen.insert((place, held, class.0), row.line.number) {
                let name = held.heading.map_or("the intersection", Heading::name);
                return Err(format!(
                    "the same time as line {before} for {name}; remove one of the two, or add a column with the times"
                ));
            }
            match (held.kind, held.heading, held.towards) {
                (Kind::Vehicles | Kind::Light | Kind::Heavy, Some(heading), Some(towards)) => {
                    *interval.vehicles.entry((heading, towards)).or_insert(0.0) += number;
                    if held.kind == Kind::Heavy || class.1 {
                        *interval.heavy.entry(heading).or_insert(0.0) += number;
                        self.classed.insert((place.0, heading));
                    }
                }
                (Kind::People | Kind::PeopleParts | Kind::PeopleTotal, heading, _) => {
                    *interval.pedestrians.entry(heading).or_insert(0.0) += number;
                }
                (Kind::HeavyCount | Kind::HeavyPercent, ..) => heavy.push((held, number)),
                _ => {}
            }
        }
        for (held, number) in heavy {
            interval.add_heavy(held, number)?;
        }
        for (heading, total, sum) in row.wrong_sums(interval)? {
            let about =
                "the turns of an approach do not sum up to its column of totals; the turns count";
            let name = heading.map_or("all", Heading::name);
            let line = row.line.number;
            self.said.say(about, format!("line {line}: {name} {sum:.0} instead of {total:.0}"));
        }
        Ok(Some(place))
    }

    /// Returns where the rows of a time are.
    fn place(&mut self, row: &Row<'_>, names: Vec<String>, moment: Moment) -> (usize, usize) {
        let Moment { day, minute, length_min } = moment;
        let key = (names, day, minute);
        if let Some(place) = self.places.get(&key) {
            return *place;
        }
        let known = self.found.iter().position(|counted| counted.names == key.0);
        let i = known.unwrap_or_else(|| {
            self.found.push(CountedIntersection {
                names: key.0.clone(),
                is_named: row.text(Kind::Intersection).is_some(),
                file: row.sheet.name.clone(),
                intervals: Vec::new(),
            });
            self.found.len() - 1
        });
        let line = row.line.number;
        let intervals = &mut self.found[i].intervals;
        intervals.push(Interval { line, day, minute, length_min, ..Interval::default() });
        let place = (i, intervals.len() - 1);
        self.places.insert(key, place);
        place
    }
}

/// A line below the names of columns.
struct Row<'a> {
    line: &'a Line,
    columns: &'a Columns,
    sheet: &'a Fitting<'a>,
}

impl<'a> Row<'a> {
    fn text(&self, kind: Kind) -> Option<&'a str> {
        let (column, _) = self.columns.holds.iter().find(|(_, held)| held.kind == kind)?;
        let text = self.line.text(*column);
        Some(text.strip_prefix('=').unwrap_or(text).trim_matches('"').trim())
    }

    fn first(&self) -> Option<&'a str> {
        self.line.fields().find(|field| !field.is_empty())
    }

    fn number(&self, column: usize, most: f64) -> Result<Option<f64>, String> {
        let text = self.line.text(column);
        if NOTHING.contains(&text.to_lowercase().as_str()) {
            return Ok(None);
        }
        let number = self
            .line
            .count(column)
            .map_err(|e| format!("{text:?} in column {}: {e}", column + 1))?;
        match number.filter(|number| !(0.0..=most).contains(number)) {
            None => Ok(number),
            Some(n) => {
                Err(format!("{n} in column {}: expected a number from 0 to {most}", column + 1))
            }
        }
    }

    /// Returns when it counts; `None` for a line with words where a time is expected.
    fn moment(&self) -> Result<Option<Moment>, String> {
        let mut moment = Moment::default();
        for (kind, like) in [(Kind::Time, "07:15, in local time"), (Kind::Date, "2026-11-05")] {
            let Some(text) = self.text(kind) else { continue };
            let Some(found) = self.sheet.layout.moment(text) else {
                let is_count = |(i, held): &(usize, Holds)| {
                    held.kind > Kind::Class && matches!(self.line.count(*i), Ok(Some(_)))
                };
                let has_counts = self.columns.holds.iter().any(is_count);
                let is_timed = moment.minute.is_some();
                return match text.starts_with(|c: char| c.is_ascii_digit())
                    || is_timed && !text.is_empty()
                {
                    true if has_counts => {
                        Err(format!("time {text:?} is not understood; write it like {like}"))
                    }
                    _ if is_timed && text.is_empty() => Ok(Some(moment)),
                    _ => Ok(None),
                };
            };
            // The cell of the date may have a time as well.
            moment = Moment {
                day: found.day.or(moment.day),
                minute: moment.minute.or(found.minute),
                length_min: moment.length_min.or(found.length_min),
            };
        }
        Ok(Some(moment))
    }

    /// Returns what a row with one movement counts, its class, and whether that is heavy.
    fn listed(&self, held: Holds) -> Result<(Holds, (String, bool)), String> {
        let text = |kind| self.text(kind).unwrap_or_default();
        let (direction, turn, class) = (text(Kind::Direction), text(Kind::Turn), text(Kind::Class));
        let (heading, towards) = self.sheet.layout.movement(direction, turn).ok_or_else(|| {
            format!("{direction:?} {turn:?} is no movement; write a direction such as N, and left, thru or right")
        })?;
        let is_heavy = match class {
            "" => false,
            class => self.sheet.layout.is_heavy(class).ok_or_else(|| {
                format!("the class {class:?} is in no list of the layout; add it to light_classes or heavy_classes")
            })?,
        };
        let held =
            Holds { kind: Kind::Vehicles, heading: Some(heading), towards: Some(towards), ..held };
        Ok((held, (class.to_owned(), is_heavy)))
    }

    /// Returns the vehicles of the approaches.
    fn approaches(&self) -> Result<Vec<(Heading, f64)>, String> {
        let of = |(column, held): &(usize, Holds)| {
            let heading = held.heading.filter(|_| held.kind == Kind::Vehicles)?;
            Some(self.number(*column, 1e6).transpose()?.map(|number| (heading, number)))
        };
        self.columns.holds.iter().filter_map(of).collect()
    }

    /// Returns totals that the parts do not sum up to, with the sums.
    fn wrong_sums(&self, interval: &Interval) -> Result<Vec<(Option<Heading>, f64, f64)>, String> {
        let mut wrong = Vec::new();
        for (column, held) in self.columns.holds.iter().filter(|(_, held)| held.kind == Kind::Total)
        {
            let Some(total) = self.number(*column, 1e6)? else { continue };
            let sum = held.heading.map_or(interval.total(), |heading| interval.approach(heading));
            if (total - sum).abs() > 0.5 {
                wrong.push((held.heading, total, sum));
            }
        }
        Ok(wrong)
    }
}

impl Interval {
    /// Returns the vehicles of an approach.
    fn approach(&self, heading: Heading) -> f64 {
        self.vehicles.iter().filter(|((h, _), _)| *h == heading).map(|(_, count)| count).sum()
    }

    fn total(&self) -> f64 {
        self.vehicles.values().sum()
    }

    /// Takes a number or percentage of heavy vehicles of a movement, an approach or the intersection.
    fn add_heavy(&mut self, held: Holds, number: f64) -> Result<(), String> {
        let is_of = |of: (Heading, Towards)| {
            held.heading.is_none_or(|heading| heading == of.0)
                && held.towards.is_none_or(|towards| towards == of.1)
        };
        let mut by_heading: BTreeMap<Heading, f64> = BTreeMap::new();
        for (movement, count) in self.vehicles.iter().filter(|(movement, _)| is_of(**movement)) {
            *by_heading.entry(movement.0).or_insert(0.0) += count;
        }
        let all: f64 = by_heading.values().sum();
        let heavy = if held.kind == Kind::HeavyPercent { all * number / 100.0 } else { number };
        if heavy > all {
            let name = held.heading.map_or("at the intersection", Heading::name);
            return Err(format!(
                "{heavy} heavy vehicles {name}, but {all} vehicles there; if they are percent, put % into the name of the \
                 column"
            ));
        }
        for (heading, count) in by_heading {
            let share = if all > 0.0 { count / all } else { 0.0 };
            *self.heavy.entry(heading).or_insert(0.0) += heavy * share;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
