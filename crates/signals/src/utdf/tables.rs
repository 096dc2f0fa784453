//! The sections of UTDF as tables of text.

use std::collections::BTreeMap;

use sheet::Fault;
use sheet::uneven::Line;

use crate::settings::MIN_PEAK_HOUR_FACTOR;

/// Line to which messages about the whole network point.
pub(super) const START: u64 = 1;

/// Settings of the network that are read, in lower case, with the least and the largest value.
const SETTINGS: [(&str, f64, f64); 6] = [
    ("phf", MIN_PEAK_HOUR_FACTOR, 1.0),
    ("hv", 0.0, 1.0),
    ("growth", 0.0, 10.0),
    ("metric", 0.0, 1.0),
    ("yellowtime", 1.0, 10.0),
    ("allredtime", 0.0, 20.0),
];

/// Cells of a record by the names of their columns; only those that hold something.
pub(super) type Cells = BTreeMap<String, Cell>;

/// A cell with its line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Cell {
    pub(super) text: String,
    pub(super) line: u64,
}

impl Cell {
    /// Returns the number that it holds; messages call it like its record.
    pub(super) fn number(&self, record: &str) -> Result<f64, Fault> {
        let number = self.text.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| {
            Fault::new(self.line, format!("{record} = {:?}: expected a number", self.text))
        })
    }
}

/// Records of a section by name, in lower case, and intersection.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Records(pub(super) BTreeMap<String, BTreeMap<String, Cells>>);

impl Records {
    pub(super) fn row(&self, record: &str, id: &str) -> &Cells {
        static NONE: Cells = Cells::new();
        self.0.get(record).and_then(|of| of.get(id)).unwrap_or(&NONE)
    }

    pub(super) fn cell(&self, record: &str, id: &str, column: &str) -> Option<&Cell> {
        self.row(record, id).get(column)
    }

    pub(super) fn number(
        &self,
        record: &str,
        id: &str,
        column: &str,
    ) -> Result<Option<f64>, Fault> {
        self.cell(record, id, column).map(|cell| cell.number(record)).transpose()
    }
}

/// A node of the network.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Node {
    pub(super) id: String,
    pub(super) line: u64,
    /// 0 signal, 1 external, 2 bend, 3 unsignalised, 4 roundabout; `None` where it is not said.
    pub(super) kind: Option<u32>,
    /// East and north of some origin, feet or metres.
    pub(super) at: Option<(f64, f64)>,
}

/// All sections.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Tables {
    /// Settings that hold for the whole network, by name.
    pub(super) network: BTreeMap<&'static str, f64>,
    pub(super) nodes: Vec<Node>,
    pub(super) links: Records,
    pub(super) lanes: Records,
    pub(super) timeplans: Records,
    pub(super) phases: Records,
}

impl Tables {
    pub(super) fn add(&mut self, lines: &[Line]) -> Result<(), Fault> {
        let mut section = None;
        let mut columns: Option<Vec<String>> = None;
        let mut found = false;
        for line in lines {
            let first = line.text(0);
            if let Some(name) = first.strip_prefix('[').and_then(|name| name.strip_suffix(']')) {
                (section, columns) = (Some(name.to_lowercase()), None);
                continue;
            }
            let Some(section) = &section else { continue };
            if ["RECORDNAME", "INTID"].iter().any(|name| first.eq_ignore_ascii_case(name)) {
                columns = Some(column_names(section, line)?);
                found = true;
            } else if let Some(columns) = &columns {
                // Titles stand between the name of a section and its columns.
                self.row(section, columns, line)?;
            }
        }
        if found {
            return Ok(());
        }
        let message = "no UTDF: no section such as [Lanes] with a line RECORDNAME,INTID,...; export the network as UTDF (CSV)";
        Err(Fault::new(lines.first().map_or(START, |line| line.number), message))
    }

    fn records(&mut self, section: &str) -> Option<&mut Records> {
        Some(match section {
            "links" => &mut self.links,
            "lanes" => &mut self.lanes,
            "timeplans" => &mut self.timeplans,
            "phases" => &mut self.phases,
            _ => return None,
        })
    }

    fn row(&mut self, section: &str, columns: &[String], line: &Line) -> Result<(), Fault> {
        let text = |name: &str| {
            let at = columns.iter().position(|c| c.eq_ignore_ascii_case(name));
            at.map(|at| plain(line.text(at))).unwrap_or_default()
        };
        let cell = |text: &str| Cell { text: text.to_owned(), line: line.number };
        let wrong = |message: String| Fault::new(line.number, message);
        if section == "network" {
            let (name, value) = (text("RECORDNAME"), text("DATA"));
            let known = SETTINGS.iter().find(|(known, ..)| name.eq_ignore_ascii_case(known));
            let Some((known, low, high)) = known.filter(|_| !value.is_empty()) else {
                return Ok(());
            };
            let number = value.parse().ok().filter(|number: &f64| (*low..=*high).contains(number));
            let number = number.ok_or_else(|| {
                wrong(format!(
                    "[Network] {known} = {value:?}: expected a number from {low} to {high}"
                ))
            })?;
            let other = *self.network.entry(known).or_insert(number);
            if other != number {
                let message =
                    format!("[Network] {known} = {value:?}, but {other} above; remove one");
                return Err(wrong(message));
            }
            return Ok(());
        }
        let id = text("INTID").to_owned();
        if section == "nodes" {
            if self.nodes.iter().any(|node| node.id == id) {
                return Err(wrong(format!("node {id} stands twice; remove one")));
            }
            let of = |name: &str| {
                Some(text(name)).filter(|text| !text.is_empty()).map(|t| cell(t).number(name))
            };
            let kind = of("TYPE").transpose()?.map(|kind| kind as u32);
            let at = of("X").transpose()?.zip(of("Y").transpose()?);
            self.nodes.push(Node { id, line: line.number, kind, at });
            return Ok(());
        }
        let Some(records) = self.records(section) else { return Ok(()) };
        let name = text("RECORDNAME").to_lowercase();
        let cells = columns.iter().map(|column| column.to_uppercase()).zip(line.fields());
        let is_cell = |(column, cell): &(String, Cell)| {
            !["RECORDNAME", "INTID", ""].contains(&column.as_str()) && !cell.text.is_empty()
        };
        let cells = cells.map(|(column, text)| (column, cell(plain(text)))).filter(is_cell);
        let twice = format!("record {name} of node {id} stands twice; remove one");
        match records.0.entry(name).or_default().insert(id, cells.collect()) {
            Some(_) => Err(wrong(twice)),
            None => Ok(()),
        }
    }
}

/// Returns the names of the columns of a section. The values of `[Network]` and `[Timeplans]` are in `DATA`, which some
/// programs call `Value`.
fn column_names(section: &str, line: &Line) -> Result<Vec<String>, Fault> {
    let mut columns: Vec<String> = line.fields().map(str::to_owned).collect();
    if !["network", "timeplans"].contains(&section) {
        return Ok(columns);
    }
    let find = |name: &str| columns.iter().position(|column| column.eq_ignore_ascii_case(name));
    let Some(at) = find("DATA").or_else(|| find("VALUE")) else {
        let message = "no column DATA with the values of the records; call it so";
        return Err(Fault::new(line.number, message));
    };
    "DATA".clone_into(&mut columns[at]);
    Ok(columns)
}

/// Returns a value without the star of what somebody entered.
fn plain(text: &str) -> &str {
    text.strip_prefix('*').unwrap_or(text).trim()
}
