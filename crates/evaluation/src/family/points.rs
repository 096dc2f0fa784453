//! A table of point MDPs written by hand: any features, and either importance or counts.
//!
//! Columns: `point` (optional; numbered when absent), `importance` (sums to 1) or counts (normalised), and one
//! column per feature. A column name that ends in a known unit tells the feature's unit.

use std::collections::HashMap;

use sheet::{Fault, Row, Sheet};

use super::columns::{Columns, at};
use super::error::FamilyError;
use super::names::{safe_id, title};
use super::{Feature, MdpFamily, PointMdp};

/// Returns the number in a column of a row, by name.
pub type Numbers<'a> = &'a dyn Fn(&str) -> Result<f64, String>;

/// What is particular to the points of a domain.
pub struct Kind<'a> {
    /// Columns that there must be.
    pub needed: &'a [&'a str],
    /// Column of counts: how many real instances a point MDP stands for.
    pub counts: &'a str,
    /// Columns of numbers that are large, in which `1.500` may be 1500 as well.
    pub large: &'a [&'a str],
    /// Ends of the names of features, and their units.
    pub units: &'a [(&'a str, &'a str)],
    /// Checks the numbers of a row, which it asks for by name.
    pub check: &'a dyn Fn(Numbers<'_>) -> Result<(), String>,
}

/// Columns that are no features, besides counts.
const OTHERS: [&str; 2] = ["point", "importance"];

/// Largest importance or feature: what is computed of a million of them is finite.
const LARGEST: f64 = 1e12;

/// Reads a table of point MDPs.
///
/// # Errors
///
/// [`FamilyError`] naming file and line: a missing or doubled column, a value that is no number, is negative or
/// that the kind refuses, a name that comes twice, importance that does not sum to 1.
pub fn read(name: &str, text: &str, file: &str, kind: &Kind<'_>) -> Result<MdpFamily, FamilyError> {
    let fail = |fault| at(file, fault);
    let mut sheet = Sheet::of(text).map_err(fail)?;
    let empty = sheet.headers.iter().all(str::is_empty);
    if empty {
        return Err(FamilyError::Empty { file: file.to_owned() });
    }
    let header_line = sheet.header_line;
    let no_features = [&OTHERS[..], &[kind.counts]].concat();
    let columns = Columns::find(&sheet.headers, kind.needed, &no_features)
        .and_then(|columns| weighted(&columns, kind).map(|()| columns))
        .map_err(|message| fail(Fault { line: header_line, message }))?;
    let is_feature =
        |name: &&str| !no_features.iter().any(|other| other.eq_ignore_ascii_case(name));
    let features: Vec<&str> = columns.names().filter(is_feature).collect();
    let mut points: Vec<PointMdp> = Vec::new();
    let mut positions: HashMap<String, usize> = HashMap::new();
    while let Some(row) = sheet.next_row().map_err(fail)? {
        let line = row.line;
        let fail = |message| fail(Fault { line, message });
        let point = point(&row, &columns, &features, points.len(), kind).map_err(fail)?;
        if let Some(earlier) = positions.insert(point.id.clone(), points.len()) {
            let (first, second) = (&points[earlier].title, &point.title);
            return Err(fail(match first == second {
                true => format!("point {first} stands twice in the table"),
                false => format!("points {first:?} and {second:?} get the same id; rename one"),
            }));
        }
        points.push(point);
    }
    if columns.get("importance").is_none() {
        let total: f64 = points.iter().map(|p| p.importance).sum();
        if !points.is_empty() && total <= 0.0 {
            let message = format!("all `{}` are 0; give counts", kind.counts);
            return Err(fail(Fault { line: header_line, message }));
        }
        for p in &mut points {
            p.importance /= total;
        }
    }
    let features = features.into_iter().map(|name| feature(name, kind)).collect();
    MdpFamily::new(name, features, points, file).map_err(|error| match error {
        FamilyError::NotADistribution { file, sum, .. } => {
            let column = format!(" in a column `{}`", kind.counts);
            FamilyError::NotADistribution { file, sum, column }
        }
        other => other,
    })
}

/// Checks that there is a column that weights the rows.
fn weighted(columns: &Columns, kind: &Kind<'_>) -> Result<(), String> {
    match columns.get("importance").or(columns.get(kind.counts)) {
        Some(_) => Ok(()),
        None => Err(format!("a column `importance` or `{}` is needed", kind.counts)),
    }
}

fn point(
    row: &Row,
    columns: &Columns,
    features: &[&str],
    earlier: usize,
    kind: &Kind<'_>,
) -> Result<PointMdp, String> {
    let read = |name: &str| match kind.large.contains(&name) {
        true => columns.count(row, name),
        false => columns.number(row, name),
    };
    let number = |name: &str| match read(name)? {
        number if (0.0..=LARGEST).contains(&number) => Ok(number),
        number if number < 0.0 => {
            Err(format!("{name} = {number}: expected a number that is not negative"))
        }
        number => Err(format!("{name} = {number:e}: expected a number from 0 to {LARGEST}")),
    };
    let title = match columns.get("point") {
        Some(i) => title("point", row.text(i))?,
        None => format!("p{:04}", earlier + 1),
    };
    let instances = match columns.get(kind.counts) {
        Some(_) => {
            let whole = columns.whole(row, kind.counts)?;
            columns.count(row, kind.counts).map(|_| whole)?
        }
        None => 1,
    };
    let importance = match columns.get("importance") {
        Some(_) => number("importance")?,
        None => f64::from(instances),
    };
    (kind.check)(&read)?;
    let features = features.iter().map(|name| number(name)).collect::<Result<Vec<_>, _>>()?;
    Ok(PointMdp { id: safe_id(&title), title, features, importance, instances })
}

fn feature(name: &str, kind: &Kind<'_>) -> Feature {
    let unit = kind.units.iter().find(|(suffix, _)| name.ends_with(suffix)).map_or("", |(_, u)| u);
    Feature { name: name.to_owned(), unit: unit.to_owned() }
}
