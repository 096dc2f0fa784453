//! Layouts of count sheets: what the columns of a table hold, as data. `layouts.toml` says what each field means.

use std::collections::BTreeMap;
use std::path::Path;

use basics::files::{self, limits};
use evaluation::family::columns::at;
use evaluation::family::error::FamilyError;
use jiff::civil::Date;
use jiff::fmt::strtime;
use serde::Deserialize;
use sheet::Fault;
use sheet::uneven::Line;
use toml::{Table, Value};

use super::{ENOUGH, FEW, Towards};
use crate::vocabulary::Heading;

const LAYOUTS: &str = include_str!("layouts.toml");

/// Minutes of the longest interval that a row counts.
const LONGEST_MIN: u32 = 60;

/// Minutes of a day.
pub(super) const DAY_MIN: u32 = 1440;

/// Days after 1899-12-30 from which on a spreadsheet's number is a date of our time.
const FIRST_SERIAL: f64 = 20_000.0;

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Kind {
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
    Total,
    Unused,
}

/// A column: its kind, and the movement or approach where it has one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Holds {
    pub(super) kind: Kind,
    pub(super) heading: Option<Heading>,
    pub(super) towards: Option<Towards>,
    /// Tells apart columns that are added: classes, ways across an approach, a second exit.
    pub(super) part: usize,
}

impl Holds {
    pub(super) fn is_vehicles(&self) -> bool {
        matches!(self.kind, Kind::Vehicles | Kind::Light | Kind::Heavy)
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Layout {
    #[expect(dead_code, reason = "for who reads the file")]
    name: String,
    direction_rows: Vec<usize>,
    intersection_cell: Vec<String>,
    dates: Vec<String>,
    times: Vec<String>,
    light_classes: Vec<String>,
    heavy_classes: Vec<String>,
    unused_sheets: Vec<String>,
    directions: Vec<String>,
    words: Words,
    columns: BTreeMap<Kind, Vec<String>>,
    /// What each name means.
    #[serde(skip)]
    names: BTreeMap<String, Holds>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Words {
    bound: Vec<Vec<String>>,
    leg: Vec<Vec<String>>,
    turn: Vec<Vec<String>>,
}

/// The columns of a table.
pub(super) struct Columns {
    pub(super) holds: Vec<(usize, Holds)>,
    pub(super) unused: Vec<String>,
}

/// Returns a name as it is compared.
fn plain(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric() || *c == '%').collect::<String>().to_uppercase()
}

impl Layout {
    /// Returns the layouts that are known, or the one of a file.
    pub(super) fn read(file: Option<&Path>) -> Result<Vec<Self>, FamilyError> {
        let known: Table = LAYOUTS.parse().expect("a test reads it");
        let own: Vec<Table> = match file {
            None => known["layout"].clone().try_into().expect("a test reads it"),
            Some(path) => {
                let text = files::read_text(path, limits::DOCUMENT)?;
                vec![text.parse().map_err(|e| Self::wrong(path, &e))?]
            }
        };
        let made = own.into_iter().map(|mut table| {
            complete(&mut table, &known["common"]);
            let mut layout: Self = table.try_into()?;
            layout.names = layout.meanings();
            Ok(layout)
        });
        let path = file.unwrap_or(Path::new("layouts.toml"));
        made.collect::<Result<_, _>>().map_err(|e| Self::wrong(path, &e))
    }

    fn wrong(path: &Path, error: &toml::de::Error) -> FamilyError {
        let message = format!("not a layout of counts: {}", error.message());
        at(&path.display().to_string(), Fault { line: 1, message })
    }

    /// Returns the names that a pattern stands for.
    fn expanded(&self, pattern: &str) -> Vec<(String, Option<Heading>, Option<Towards>)> {
        // Traffic from a leg travels the other way.
        let (place, words, turned) = match pattern.contains("{leg}") {
            true => ("{leg}", &self.words.leg, 4),
            false => ("{bound}", &self.words.bound, 0),
        };
        let sides = Heading::ALL.into_iter().zip(words).flat_map(|(heading, names)| {
            names.iter().map(move |name| (name.as_str(), Some(heading.clockwise(turned))))
        });
        let turns = Towards::ALL.into_iter().zip(&self.words.turn).flat_map(|(towards, names)| {
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
    pub(super) fn columns(&self, lines: &[Line], row: usize) -> Option<Result<Columns, String>> {
        if lines[row].fields().find(|f| !f.is_empty())?.starts_with(|c: char| c.is_ascii_digit()) {
            return None;
        }
        self.direction_rows.iter().find_map(|up| self.below(lines, row, row.checked_sub(*up)?))
    }

    fn below(&self, lines: &[Line], row: usize, above: usize) -> Option<Result<Columns, String>> {
        let (mut all, mut unused) = (Vec::new(), Vec::new());
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
                None if below.is_empty() => {}
                None if self.may_count(&name) => unknown = Some(name),
                None => unused.push(below.to_owned()),
            }
        }
        let has = |kind: Kind| all.iter().any(|(_, held, _)| held.kind == kind);
        let movements = || all.iter().filter(|(_, held, _)| held.is_vehicles());
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
        for (i, (_, held, name)) in all.iter().enumerate().filter(|(_, c)| c.1.kind != Kind::Unused)
        {
            if let Some((_, _, other)) = all[..i].iter().find(|(_, other, _)| other == held) {
                return Some(Err(format!(
                    "columns {other} and {name} count the same; remove one, or add their numbers"
                )));
            }
        }
        let is_left_out = |own: &Holds| {
            own.kind == Kind::Unused || all.iter().any(|(_, other, _)| is_instead(*other, *own))
        };
        let (left_out, used): (Vec<_>, Vec<_>) =
            all.iter().partition(|(_, own, _)| is_left_out(own));
        unused.extend(left_out.into_iter().map(|(_, _, name)| name.clone()));
        let holds = used.into_iter().map(|(column, held, _)| (*column, *held)).collect();
        Some(Ok(Columns { holds, unused }))
    }

    /// Whether a name that no layout has may be one of vehicles, or of times that are not local.
    fn may_count(&self, name: &str) -> bool {
        let plain = plain(name);
        let sides = || self.words.bound.iter().chain(&self.words.leg).flatten();
        let has_side = name
            .split(|c: char| !c.is_alphanumeric())
            .any(|word| sides().any(|side| side.eq_ignore_ascii_case(word)));
        has_side
            || ["UTC", "GMT", "ZONE"].iter().any(|zone| plain.contains(zone))
            || ["NB", "EB", "SB", "WB"].iter().any(|bound| plain.starts_with(bound))
    }

    /// Returns how vehicles travel in a row that names their direction, and where they go.
    pub(super) fn movement(&self, direction: &str, turn: &str) -> Option<(Heading, Towards)> {
        let mut sides = self.directions.iter().flat_map(|pattern| self.expanded(pattern));
        let (_, heading, _) = sides.find(|(name, _, _)| *name == plain(direction))?;
        let mut turns = self.expanded("{turn}").into_iter();
        let (_, _, towards) = turns.find(|(name, _, _)| *name == plain(turn))?;
        Some((heading?, towards?))
    }

    /// Returns whether a class is one of heavy vehicles; `None` for another word.
    pub(super) fn is_heavy(&self, class: &str) -> Option<bool> {
        let is_in = |list: &[String]| list.iter().any(|name| plain(name) == plain(class));
        is_in(&self.heavy_classes).then_some(true).or(is_in(&self.light_classes).then_some(false))
    }

    /// Returns whether a sheet repeats rows of others.
    pub(super) fn leaves_out(&self, sheet: &str) -> bool {
        self.unused_sheets.iter().any(|word| sheet.to_lowercase().contains(&word.to_lowercase()))
    }

    /// Returns the intersection that a line names beside a text.
    pub(super) fn title<'a>(&self, line: &'a Line) -> Option<&'a str> {
        let is_title = |text: &str| self.intersection_cell.iter().any(|t| plain(t) == plain(text));
        let mut fields = line.fields().filter(|field| !field.is_empty());
        let first = fields.next()?;
        match first.split_once(':').map(|(title, name)| (title, name.trim())) {
            Some((title, name)) if !name.is_empty() => is_title(title).then_some(name),
            _ => fields.next().filter(|_| is_title(first)),
        }
    }

    /// Returns the day and the minute of a text that has one or both of them, and the minutes of an interval whose end it
    /// has as well.
    pub(super) fn moment(&self, text: &str) -> Option<Moment> {
        self.instant(text).or_else(|| {
            [" - ", " to ", " \u{2013} ", "\u{2013}", "-"].into_iter().find_map(|between| {
                let (first, last) = text.split_once(between)?;
                let (first, last) = (self.instant(first)?, self.instant(last)?);
                let length = (last.minute? + DAY_MIN - first.minute?) % DAY_MIN;
                let is_length = (1..=LONGEST_MIN).contains(&length);
                is_length.then_some(Moment { length_min: Some(length), ..first })
            })
        })
    }

    fn instant(&self, text: &str) -> Option<Moment> {
        let text = text.trim_start_matches('=').trim_matches('"').trim().to_uppercase();
        let serial = text.parse::<f64>().ok().filter(|_| text.contains('.'));
        if let Some(serial) = serial {
            let is_day = (FIRST_SERIAL..5.0 * FIRST_SERIAL).contains(&serial);
            // Seconds that rounding has lost.
            let minute = (serial.fract() * f64::from(DAY_MIN) + 0.02).floor() as u32;
            let span = jiff::Span::new().try_days(serial.trunc() as i64).ok()?;
            let date = Date::constant(1899, 12, 30).checked_add(span).ok();
            return (is_day || (0.0..1.0).contains(&serial)).then_some(Moment {
                day: date.filter(|_| is_day),
                minute: Some(minute),
                length_min: None,
            });
        }
        let text = text.replace("A.M.", "AM").replace("P.M.", "PM");
        let text = if text.len() == 3 { format!("0{text}") } else { text };
        let both = self.dates.iter().flat_map(|date| {
            self.times.iter().flat_map(move |time| [" ", "T"].map(|t| format!("{date}{t}{time}")))
        });
        let mut formats = self.times.iter().chain(&self.dates).cloned().chain(both);
        let found = formats.find_map(|format| strtime::parse(format, &text).ok())?;
        let minute = found.to_time().ok().filter(|_| found.hour().is_some());
        let day = found.to_date().ok();
        let minute = minute.and_then(|time| {
            u32::try_from(60 * i32::from(time.hour()) + i32::from(time.minute())).ok()
        });
        (day.is_some() || minute.is_some()).then_some(Moment { day, minute, length_min: None })
    }
}

/// When a row counts.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Moment {
    pub(super) day: Option<Date>,
    pub(super) minute: Option<u32>,
    /// Minutes of the interval, where its end is given.
    pub(super) length_min: Option<u32>,
}

/// Gives a table what another one has besides, also in the tables within.
fn complete(table: &mut Table, common: &Value) {
    for (key, value) in common.as_table().into_iter().flatten() {
        match table.get_mut(key) {
            Some(Value::Table(own)) => complete(own, value),
            Some(_) => {}
            None => drop(table.insert(key.clone(), value.clone())),
        }
    }
}

/// Whether a column makes another one needless, such as parts of people a sum, and counts of heavy vehicles percentages.
fn is_instead(other: Holds, own: Holds) -> bool {
    let is_same = own.heading.is_none() || own.heading == other.heading;
    let is_finer = other.kind == own.kind
        && is_same
        && (other.heading, other.towards) != (own.heading, own.towards)
        && (other.towards.is_some() || own.towards.is_none());
    match own.kind {
        // Of several names of the intersection the first of the layout's list counts.
        Kind::Intersection | Kind::Date | Kind::Time => {
            other.kind == own.kind && other.part < own.part
        }
        Kind::PeopleTotal => {
            is_finer || is_same && matches!(other.kind, Kind::People | Kind::PeopleParts)
        }
        Kind::People => other.kind == Kind::PeopleParts && other.heading == own.heading,
        Kind::HeavyCount => other.kind == Kind::Heavy || is_finer,
        Kind::HeavyPercent => match other.kind {
            Kind::HeavyCount => is_same || other.heading.is_none(),
            kind => kind == Kind::Heavy || is_finer,
        },
        _ => false,
    }
}

/// Returns what is said of a table that has no known layout.
pub(super) fn unknown(lines: &[Line]) -> String {
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
