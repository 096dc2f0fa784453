//! Turning movement counts: vehicles by approach and turn at an intersection, as count companies and detectors deliver
//! them.
//!
//! A layout says what the columns of a table hold, as data (`layouts.toml`): `NBL` is a northbound left turn, from the south to
//! the west. A file that fits no layout is refused. [`TurningCounts::into_approaches`] gives the counted vehicles to the arms of a table of
//! approaches.

pub mod hour;
mod join;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use jiff::civil::Date;
use jiff::fmt::strtime;
use osm_signals::sources::Source;
use serde::Deserialize;
use sheet::uneven::{self, Line};
use sheet::{Fault, file};
use toml::Table;

use crate::family::doubts::{Doubt, Said};
use crate::vocabulary::Heading;
use basics::files::{self, FileError, limits};
use evaluation::family::columns::at;
use evaluation::family::error::FamilyError;
use evaluation::settings::overrides::overlay;
use hour::Interval;
pub use hour::Period;
pub use join::Joined;
pub use join::meant;
pub(crate) use join::{FEW_VEHICLES, few, matched_arms, without_zero_pedestrians};

const LAYOUTS: &str = include_str!("layouts.toml");

/// Least columns of movements of a table of counts.
const ENOUGH: usize = 3;

/// Most names, or rows, that a message lists.
const FEW: usize = 8;

/// What stands in a field for a movement that does not exist or has no detector.
const NOTHING: [&str; 3] = ["*", "-", "--"];

/// Most vehicles or people of a row.
const MOST_COUNTED: f64 = 1e6;

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

/// The day and the minute of a row, where it has them.
type Moment = (Option<Date>, Option<u32>);

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Kind {
    Intersection,
    Date,
    Time,
    Direction,
    Turn,
    Class,
    Count,
    Vehicles,
    Light,
    Heavy,
    HeavyCount,
    HeavyPercent,
    People,
    PeopleParts,
    PeopleTotal,
    Unused,
}

/// A column: its kind, and the movement or approach where it has one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Holds {
    kind: Kind,
    heading: Option<Heading>,
    towards: Option<Towards>,
    /// Tells apart columns that are added: classes, ways across an approach, a second exit.
    part: usize,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Layout {
    direction_rows: Vec<usize>,
    intersection_cell: Vec<String>,
    dates: Vec<String>,
    times: Vec<String>,
    light_classes: Vec<String>,
    heavy_classes: Vec<String>,
    unused_sheets: Vec<String>,
    directions: Vec<String>,
    bound: Vec<Vec<String>>,
    leg: Vec<Vec<String>>,
    turn: Vec<Vec<String>>,
    columns: BTreeMap<Kind, Vec<String>>,
    /// What each name means.
    #[serde(skip)]
    names: BTreeMap<String, Holds>,
}

/// Returns a name as it is compared.
fn plain(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric() || *c == '%').collect::<String>().to_uppercase()
}

impl Layout {
    /// Returns the layouts that are known, or the one of a file.
    fn read(file: Option<&Path>) -> Result<Vec<Self>, FamilyError> {
        let known: Table = LAYOUTS.parse().expect("a test reads it");
        let path = file.unwrap_or(Path::new("layouts.toml"));
        let wrong = |e: toml::de::Error| {
            let message = format!("not a layout of counts: {}", e.message());
            at(&path.display().to_string(), Fault { line: 1, message })
        };
        let own: Vec<Table> = match file {
            None => known["layout"].clone().try_into().expect("a test reads it"),
            Some(path) => {
                vec![files::read_text(path, limits::DOCUMENT)?.parse().map_err(wrong)?]
            }
        };
        let layout = |own: Table| {
            let mut table = known["common"].as_table().expect("a test reads it").clone();
            overlay(&mut table, own);
            let mut layout: Self = table.try_into().map_err(wrong)?;
            layout.names = layout.meanings();
            Ok(layout)
        };
        own.into_iter().map(layout).collect()
    }

    /// Returns the names that a pattern stands for.
    fn expanded(&self, pattern: &str) -> Vec<(String, Option<Heading>, Option<Towards>)> {
        // Traffic from a leg travels the other way.
        let (place, words, turned) = match pattern.contains("{leg}") {
            true => ("{leg}", &self.leg, 4),
            false => ("{bound}", &self.bound, 0),
        };
        let sides = Heading::ALL.into_iter().zip(words).flat_map(|(heading, names)| {
            names.iter().map(move |name| (name.as_str(), Some(heading.clockwise(turned))))
        });
        let turns = Towards::ALL.into_iter().zip(&self.turn).flat_map(|(towards, names)| {
            names.iter().map(move |name| (name.as_str(), Some(towards)))
        });
        let sides: Vec<_> =
            if pattern.contains(place) { sides.collect() } else { vec![("", None)] };
        let turns: Vec<_> =
            if pattern.contains("{turn}") { turns.collect() } else { vec![("", None)] };
        let name =
            |side: &str, turn: &str| plain(&pattern.replace(place, side).replace("{turn}", turn));
        let all = sides.iter().flat_map(|(side, heading)| {
            turns.iter().map(|(turn, towards)| (name(side, turn), *heading, *towards))
        });
        all.collect()
    }

    fn meanings(&self) -> BTreeMap<String, Holds> {
        let mut names = BTreeMap::new();
        for (&kind, patterns) in &self.columns {
            let is_added = matches!(kind, Kind::Light | Kind::Heavy | Kind::PeopleParts);
            for (i, pattern) in patterns.iter().enumerate() {
                for (name, heading, towards) in self.expanded(pattern) {
                    let second = usize::from(towards.is_some() && name.ends_with('2'));
                    let part = if is_added || kind <= Kind::Time { 2 * i } else { 0 } + second;
                    names.entry(name).or_insert(Holds { kind, heading, towards, part });
                }
            }
        }
        names
    }

    /// Returns the columns that a line names, alone or with the directions above it; `None` where it names none.
    fn columns(&self, lines: &[Line], row: usize) -> Option<Result<Vec<(usize, Holds)>, String>> {
        if lines[row].fields().find(|f| !f.is_empty())?.starts_with(|c: char| c.is_ascii_digit()) {
            return None;
        }
        self.direction_rows.iter().find_map(|up| self.below(lines, row, row.checked_sub(*up)?))
    }

    fn below(
        &self,
        lines: &[Line],
        row: usize,
        above: usize,
    ) -> Option<Result<Vec<(usize, Holds)>, String>> {
        let mut all: Vec<(usize, Holds, String)> = Vec::new();
        let (mut direction, mut unknown) = ("", None);
        for column in 0..lines[row].fields().count().max(lines[above].fields().count()) {
            let (below, over) = (lines[row].text(column), lines[above].text(column));
            if above != row && !over.is_empty() {
                direction = over;
            }
            let name = format!("{direction} {below}").trim().to_owned();
            let known =
                self.names.get(&plain(&name)).filter(|_| !(below.is_empty() && over.is_empty()));
            match known.or_else(|| self.names.get(&plain(below))) {
                Some(known) => all.push((column, *known, name)),
                None if !below.is_empty() && self.may_count(&name) => unknown = Some(name),
                None => {}
            }
        }
        let has = |kind: Kind| all.iter().any(|(_, held, _)| held.kind == kind);
        let is_vehicles = |kind| matches!(kind, Kind::Vehicles | Kind::Light | Kind::Heavy);
        let movements = || all.iter().filter(|(_, held, _)| is_vehicles(held.kind));
        let is_list = has(Kind::Direction) && has(Kind::Turn) && has(Kind::Count);
        if movements().count() < ENOUGH && !is_list {
            return None;
        }
        // A word such as Net is no movement beside those of other streets.
        let is_alone = |(_, held, _): &&(usize, Holds, String)| {
            held.heading.filter(|heading| !heading.name().ends_with('B')).is_some_and(|heading| {
                let street = [Some(heading), Some(heading.clockwise(4))];
                movements().filter(|(_, other, _)| street.contains(&other.heading)).count() < 2
            })
        };
        let alone = movements().find(is_alone).map(|(_, _, name)| name.clone());
        if let Some(name) = unknown.or(alone) {
            return Some(Err(format!(
                "column {name} may count vehicles, or be a time of another zone, and is in no layout; call it such as NBL, \
                 NB HV % or Time, or remove it"
            )));
        }
        all.retain(|(_, held, _)| held.kind != Kind::Unused);
        for (i, (_, held, name)) in all.iter().enumerate() {
            if let Some((_, _, other)) = all[..i].iter().find(|(_, other, _)| other == held) {
                return Some(Err(format!(
                    "columns {other} and {name} count the same; remove one, or add their numbers"
                )));
            }
        }
        let is_used = |own: &Holds| !all.iter().any(|(_, other, _)| is_instead(*other, *own));
        let used = all.iter().filter(|(_, own, _)| is_used(own));
        Some(Ok(used.map(|(column, held, _)| (*column, *held)).collect()))
    }

    /// Whether a name that no layout has may be one of vehicles, or of times that are not local.
    fn may_count(&self, name: &str) -> bool {
        let plain = plain(name);
        let sides = || self.bound.iter().chain(&self.leg).flatten();
        let has_side = name
            .split(|c: char| !c.is_alphanumeric())
            .any(|word| sides().any(|side| side.eq_ignore_ascii_case(word)));
        has_side
            || ["UTC", "GMT", "ZONE"].iter().any(|zone| plain.contains(zone))
            || ["NB", "EB", "SB", "WB"].iter().any(|bound| plain.starts_with(bound))
    }

    /// Returns how vehicles travel in a row that names their direction, and where they go.
    fn movement(&self, direction: &str, turn: &str) -> Option<(Heading, Towards)> {
        let mut sides = self.directions.iter().flat_map(|pattern| self.expanded(pattern));
        let (_, heading, _) = sides.find(|(name, _, _)| *name == plain(direction))?;
        let mut turns = self.expanded("{turn}").into_iter();
        let (_, _, towards) = turns.find(|(name, _, _)| *name == plain(turn))?;
        Some((heading?, towards?))
    }

    /// Returns whether a class is one of heavy vehicles; `None` for another word.
    fn is_heavy(&self, class: &str) -> Option<bool> {
        let is_in = |list: &[String]| list.iter().any(|name| plain(name) == plain(class));
        is_in(&self.heavy_classes).then_some(true).or(is_in(&self.light_classes).then_some(false))
    }

    /// Returns whether a sheet repeats rows of others.
    fn leaves_out(&self, sheet: &str) -> bool {
        self.unused_sheets.iter().any(|word| sheet.to_lowercase().contains(&word.to_lowercase()))
    }

    /// Returns the intersection that a line names beside a text.
    fn title<'a>(&self, line: &'a Line) -> Option<&'a str> {
        let is_title = |text: &str| self.intersection_cell.iter().any(|t| plain(t) == plain(text));
        let mut fields = line.fields().filter(|field| !field.is_empty());
        let first = fields.next()?;
        match first.split_once(':').map(|(title, name)| (title, name.trim())) {
            Some((title, name)) if !name.is_empty() => is_title(title).then_some(name),
            _ => fields.next().filter(|_| is_title(first)),
        }
    }

    /// Returns the day and the minute of a text that has one or both of them.
    fn moment(&self, text: &str) -> Option<Moment> {
        let text = text.to_uppercase().replace("A.M.", "AM").replace("P.M.", "PM");
        let text = if text.len() == 3 { format!("0{text}") } else { text };
        let both = self.dates.iter().flat_map(|date| {
            self.times.iter().flat_map(move |time| [" ", "T"].map(|t| format!("{date}{t}{time}")))
        });
        let mut formats = self.times.iter().chain(&self.dates).cloned().chain(both);
        let found = formats.find_map(|format| strtime::parse(format, &text).ok())?;
        let time = found.to_time().ok().filter(|_| found.hour().is_some());
        let minute = time.map(|time| 60 * i32::from(time.hour()) + i32::from(time.minute()));
        let minute = minute.map(i32::unsigned_abs);
        let day = found.to_date().ok();
        (day.is_some() || minute.is_some()).then_some((day, minute))
    }
}

/// Whether a column makes another one needless: parts of people a sum, counts of heavy vehicles percentages, a movement its
/// approach, and of several names of the intersection the first of the layout's list.
fn is_instead(other: Holds, own: Holds) -> bool {
    use Kind::{
        Date, Heavy, HeavyCount, HeavyPercent, Intersection, PeopleParts, PeopleTotal, Time,
    };
    let is_same = own.heading.is_none() || own.heading == other.heading;
    let is_finer = other.kind == own.kind
        && is_same
        && (other.heading, other.towards) != (own.heading, own.towards)
        && (other.towards.is_some() || own.towards.is_none());
    match own.kind {
        Intersection | Date | Time => other.kind == own.kind && other.part < own.part,
        PeopleTotal => is_finer || is_same && matches!(other.kind, Kind::People | PeopleParts),
        Kind::People => other.kind == PeopleParts && is_same,
        HeavyCount => other.kind == Heavy || is_finer,
        HeavyPercent => {
            let is_number = other.kind == HeavyCount && (is_same || other.heading.is_none());
            other.kind == Heavy || is_finer || is_number
        }
        _ => false,
    }
}

/// Returns what is said of a table that has no known layout.
fn unknown(lines: &[Line]) -> String {
    let row = |line: &Line| format!("  {}\n", line.fields().collect::<Vec<_>>().join(","));
    let rows: String = lines.iter().take(FEW).map(row).collect();
    format!(
        "no layout of turning counts fits; expected columns such as INTID, Time, NBL, NBT, NBR, SBL, where NB is northbound \
         traffic and L, T, R are left, through, right. Its first rows are\n{rows}Say what its columns are in a file such \
         as\n  direction_rows = [0]  # 1: directions in the row above the turns\n  [columns]\n  intersection = \
         [\"INTID\"]\n  date = [\"Date\"]\n  time = [\"Time\"]\n  vehicles = [\"{{bound}} {{turn}}\"]  # {{bound}}: NB, \
         {{leg}}: N, {{turn}}: L or Left\nand give it with --counts-layout"
    )
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

/// An intersection and one of its rows, by their places.
type Place = (usize, usize);

/// What one file has.
#[derive(Default)]
struct Reading {
    found: Vec<CountedIntersection>,
    /// Where the rows of a time are in it: by names, day and minute.
    places: BTreeMap<(Vec<String>, Moment), Place>,
    /// The line in which something was counted, by class.
    seen: BTreeMap<(Place, Holds, String), u64>,
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
            let title = lines.iter().find_map(|line| layouts[0].title(line));
            titles.extend(title.map(str::to_owned));
            match fit(layouts, &lines) {
                Ok(layout) if !layout.leaves_out(&sheet.sheet) => {
                    let class = layout.is_heavy(&sheet.sheet).map(|h| (sheet.sheet.clone(), h));
                    fitting.push(Fitting { layout, lines, name, class });
                    continue;
                }
                Ok(_) => {}
                Err(fault) => drop(first_fault.get_or_insert(at(&name, fault))),
            }
            others.push(sheet.sheet.clone());
        }
        if fitting.iter().any(|sheet| sheet.class.is_none()) {
            let classes = fitting.extract_if(.., |sheet| sheet.class.is_some());
            others.extend(classes.filter_map(|sheet| Some(sheet.class?.0)));
        }
        let empty = |message: &str| {
            let line =
                fitting.first().and_then(|sheet| sheet.lines.first()).map_or(1, |l| l.number);
            at(file, Fault { line, message: message.to_owned() })
        };
        if fitting.is_empty() {
            return Err(first_fault.unwrap_or_else(|| empty("an empty file")));
        }
        titles.dedup();
        titles.extend(Path::new(file).file_stem().map(|stem| stem.to_string_lossy().into_owned()));
        let mut reading = Reading::default();
        for sheet in &fitting {
            reading.table(sheet, &titles)?;
        }
        if reading.found.is_empty() {
            return Err(empty("no row with counts below the names of the columns"));
        }
        for (i, heading) in reading.classed {
            for row in &mut reading.found[i].intervals {
                if row.vehicles.keys().any(|(own, _)| *own == heading) {
                    row.heavy.entry(heading).or_insert(0.0);
                }
            }
        }
        self.intersections.extend(reading.found);
        let unused = reading.unused.into_iter().collect();
        let doubts = reading.said.doubts();
        let doubts = doubts.chain(Doubt::of("sheets that are not used", others));
        for doubt in doubts.chain(Doubt::of("columns that are not used", unused)) {
            self.doubts.push(Doubt { about: format!("{file}: {}", doubt.about), ..doubt });
        }
        Ok(())
    }
}

/// Returns the first layout that fits.
fn fit<'a>(layouts: &'a [Layout], lines: &[Line]) -> Result<&'a Layout, Fault> {
    let mut fault = None;
    for layout in layouts {
        match (0..lines.len()).find_map(|i| Some((i, layout.columns(lines, i)?))) {
            Some((_, Ok(_))) => return Ok(layout),
            Some((i, Err(message))) => {
                fault.get_or_insert(Fault { line: lines[i].number, message });
            }
            None => {}
        }
    }
    let line = lines.first().map_or(1, |line| line.number);
    Err(fault.unwrap_or_else(|| Fault { line, message: unknown(lines) }))
}

impl Reading {
    /// Reads a table.
    fn table(&mut self, sheet: &Fitting<'_>, titles: &[String]) -> Result<(), FamilyError> {
        let mut columns: Vec<(usize, Holds)> = Vec::new();
        let mut below: BTreeMap<Heading, f64> = BTreeMap::new();
        let mut read = BTreeSet::new();
        for (i, line) in sheet.lines.iter().enumerate() {
            let wrong = |message: String| at(&sheet.name, Fault { line: line.number, message });
            if let Some(named) = sheet.layout.columns(&sheet.lines, i) {
                columns = named.map_err(wrong)?;
                let is_used = |i: usize| columns.iter().any(|(column, _)| *column == i);
                let unused = line.fields().enumerate();
                let unused = unused.filter(|(i, name)| !name.is_empty() && !is_used(*i));
                self.unused.extend(unused.map(|(_, name)| name.to_owned()));
                continue;
            }
            if columns.is_empty() {
                continue;
            }
            let row = Row { line, columns: &columns, sheet };
            if let Some(place) = self.row(&row, titles).map_err(wrong)? {
                read.insert(place);
                continue;
            }
            let first = line.fields().find(|field| !field.is_empty());
            match first.and_then(|first| sheet.layout.is_heavy(first)) {
                Some(false) => {}
                Some(true) => {
                    for (column, held) in columns.iter().filter(|c| c.1.kind == Kind::Vehicles) {
                        let number = row.number(*column, MOST_COUNTED).map_err(wrong)?;
                        if let (Some(heading), Some(number)) = (held.heading, number) {
                            *below.entry(heading).or_default() += number;
                        }
                    }
                }
                None => {
                    let words: Vec<&str> =
                        line.fields().filter(|field| !field.is_empty()).take(2).collect();
                    let about = "lines without a time or an intersection are passed over";
                    self.said.say(about, format!("line {}: {}", line.number, words.join(" ")));
                }
            }
        }
        // Rows get the shares of heavy vehicles that stand below them.
        for (heading, heavy) in below {
            let intervals = read.iter().map(|(i, k)| &self.found[*i].intervals[*k]);
            let all: f64 = intervals.map(|row| row.approach(heading)).sum();
            for (i, k) in read.iter().filter(|_| all >= heavy && all > 0.0) {
                let row = &mut self.found[*i].intervals[*k];
                let vehicles = row.approach(heading);
                row.heavy.entry(heading).or_insert(vehicles * heavy / all);
            }
        }
        Ok(())
    }

    /// Reads a row, and returns where it is; `None` for a line that is none, such as a total.
    fn row(&mut self, row: &Row<'_>, titles: &[String]) -> Result<Option<Place>, String> {
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
        for (column, held) in row.columns.iter().filter(|(_, held)| held.kind > Kind::Class) {
            let most = if held.kind == Kind::HeavyPercent { 100.0 } else { MOST_COUNTED };
            let Some(number) = row.number(*column, most)? else { continue };
            let (held, class) = match held.kind {
                Kind::Count => row.listed(*held)?,
                _ => (*held, row.sheet.class.clone().unwrap_or_default()),
            };
            if let Some(before) = self.seen.insert((place, held, class.0), row.line.number) {
                let name = held.heading.map_or("the intersection", Heading::name);
                let what =
                    named.map_or("the intersection, such as INTID, or times", |_| "the times");
                return Err(format!(
                    "the same time as line {before} for {name}; remove one of the two, or add a column with {what}"
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
        Ok(Some(place))
    }

    /// Returns where the rows of a time are.
    fn place(&mut self, row: &Row<'_>, names: Vec<String>, (day, minute): Moment) -> Place {
        let known = self.found.iter().position(|counted| counted.names == names);
        *self.places.entry((names.clone(), (day, minute))).or_insert_with(|| {
            let i = known.unwrap_or_else(|| {
                self.found.push(CountedIntersection {
                    names,
                    is_named: row.text(Kind::Intersection).is_some(),
                    file: row.sheet.name.clone(),
                    intervals: Vec::new(),
                });
                self.found.len() - 1
            });
            let intervals = &mut self.found[i].intervals;
            let line = row.line.number;
            intervals.push(Interval { line, day, minute, ..Interval::default() });
            (i, intervals.len() - 1)
        })
    }
}

/// A line below the names of columns.
struct Row<'a> {
    line: &'a Line,
    columns: &'a [(usize, Holds)],
    sheet: &'a Fitting<'a>,
}

impl<'a> Row<'a> {
    fn text(&self, kind: Kind) -> Option<&'a str> {
        let (column, _) = self.columns.iter().find(|(_, held)| held.kind == kind)?;
        let text = self.line.text(*column);
        Some(text.strip_prefix('=').unwrap_or(text).trim_matches('"').trim())
    }

    fn number(&self, column: usize, most: f64) -> Result<Option<f64>, String> {
        let text = self.line.text(column);
        if NOTHING.contains(&text) {
            return Ok(None);
        }
        let wrong = |e: String| format!("{text:?} in column {}: {e}", column + 1);
        match self.line.count(column).map_err(wrong)? {
            Some(number) if !(0.0..=most).contains(&number) => {
                Err(wrong(format!("expected a number from 0 to {most}")))
            }
            number => Ok(number),
        }
    }

    /// Returns when it counts; `None` for a line with words where a time is expected.
    fn moment(&self) -> Result<Option<Moment>, String> {
        let (mut day, mut minute) = (None, None);
        for (kind, like) in [(Kind::Time, "07:15, in local time"), (Kind::Date, "2026-11-05")] {
            let Some(text) = self.text(kind) else { continue };
            let Some(found) = self.sheet.layout.moment(text) else {
                let is_count = |(i, held): &(usize, Holds)| {
                    held.kind > Kind::Class && matches!(self.line.count(*i), Ok(Some(_)))
                };
                let is_timed = minute.is_some();
                let is_time = text.starts_with(|c: char| c.is_ascii_digit());
                return match is_time || is_timed && !text.is_empty() {
                    true if self.columns.iter().any(is_count) => {
                        Err(format!("time {text:?} is not understood; write it like {like}"))
                    }
                    _ => Ok((is_timed && text.is_empty()).then_some((day, minute))),
                };
            };
            // The cell of the date may have a time as well.
            (day, minute) = (found.0.or(day), minute.or(found.1));
        }
        Ok(Some((day, minute)))
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
}

impl Interval {
    /// Returns the vehicles of an approach.
    fn approach(&self, heading: Heading) -> f64 {
        self.vehicles.iter().filter(|((h, _), _)| *h == heading).map(|(_, count)| count).sum()
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
