//! The sections of UTDF as tables of text.

use std::collections::{BTreeMap, BTreeSet};

use sheet::Fault;
use sheet::uneven::Line;

use crate::settings::MIN_PEAK_HOUR_FACTOR;

/// Line to which messages about the whole network point.
pub(super) const START: u64 = 1;

/// Settings of the network that are read, in lower case, with the least and the largest value.
pub(super) const SETTINGS: [(&str, f64, f64); 6] = [
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
    /// Returns whether it has another number than a text, or another text that is no number.
    fn differs(&self, text: &str) -> bool {
        let number = |text: &str| text.parse::<f64>().ok();
        self.text != text && (number(text).is_none() || number(text) != number(&self.text))
    }

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
pub(super) struct Records(BTreeMap<String, BTreeMap<String, Cells>>);

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

    /// Returns the names of all records.
    pub(super) fn names(&self) -> impl Iterator<Item = &String> {
        self.0.keys()
    }

    pub(super) fn has(&self, id: &str) -> bool {
        self.0.values().any(|of| of.contains_key(id))
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
    /// By name, in lower case.
    pub(super) network: BTreeMap<String, Cell>,
    pub(super) nodes: Vec<Node>,
    pub(super) links: Records,
    pub(super) lanes: Records,
    pub(super) timeplans: Records,
    pub(super) phases: Records,
    /// Sections, and records of sections, that nobody knows.
    pub(super) unknown: BTreeSet<String>,
}

/// What the lines below a header are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Section {
    Network,
    Nodes,
    /// Links, lanes, time plans, phases: a place in [`Tables::records`].
    Records(usize),
    Unknown,
}

/// Sections by their names.
const SECTIONS: [(&str, Section); 6] = [
    ("network", Section::Network),
    ("nodes", Section::Nodes),
    ("links", LINKS),
    ("lanes", LANES),
    ("timeplans", TIMEPLANS),
    ("phases", PHASES),
];

const LINKS: Section = Section::Records(0);
const LANES: Section = Section::Records(1);
const TIMEPLANS: Section = Section::Records(2);
const PHASES: Section = Section::Records(3);

impl Tables {
    pub(super) fn add(&mut self, lines: &[Line]) -> Result<(), Fault> {
        let mut section: Option<Section> = None;
        let mut header: Option<(Section, Vec<String>)> = None;
        let mut found = false;
        for line in lines {
            let first = line.text(0);
            if let Some(name) = first.strip_prefix('[').and_then(|name| name.strip_suffix(']')) {
                let known = SECTIONS.iter().find(|(known, _)| name.eq_ignore_ascii_case(known));
                if known.is_none() {
                    self.unknown.insert(format!("[{name}]"));
                }
                section = Some(known.map_or(Section::Unknown, |(_, section)| *section));
                header = None;
                continue;
            }
            let is_header =
                ["RECORDNAME", "INTID"].iter().any(|name| first.eq_ignore_ascii_case(name));
            if let Some(named) = section.filter(|_| is_header) {
                header = Some((named, column_names(named, line)?));
                found = true;
                continue;
            }
            // Titles stand between the name of a section and its columns.
            let Some((section, columns)) = &header else { continue };
            self.row(*section, columns, line)?;
        }
        if found {
            return Ok(());
        }
        let message = "no UTDF: no section such as [Lanes] with a line RECORDNAME,INTID,...; export the network as UTDF (CSV)";
        Err(Fault::new(lines.first().map_or(START, |line| line.number), message))
    }

    fn records(&mut self) -> [&mut Records; 4] {
        [&mut self.links, &mut self.lanes, &mut self.timeplans, &mut self.phases]
    }

    fn row(&mut self, section: Section, columns: &[String], line: &Line) -> Result<(), Fault> {
        let number = line.number;
        let text = |name: &str| {
            let at = columns.iter().position(|c| c.eq_ignore_ascii_case(name));
            at.map(|at| plain(line.text(at))).unwrap_or_default()
        };
        let wrong = |message: String| Err(Fault::new(number, message));
        match section {
            Section::Network => {
                let (name, value) = (text("RECORDNAME").to_lowercase(), text("DATA"));
                let is_read = SETTINGS.iter().any(|(setting, ..)| *setting == name);
                let cell = Cell { text: value.to_owned(), line: number };
                let other = self.network.entry(name.clone()).or_insert(cell);
                let differs = !other.text.is_empty() && !value.is_empty() && other.differs(value);
                if is_read && differs {
                    return wrong(format!(
                        "[Network] {name} = {value:?}, but {:?} in line {}; remove one",
                        other.text, other.line
                    ));
                }
                if other.text.is_empty() {
                    *other = Cell { text: value.to_owned(), line: number };
                }
            }
            Section::Nodes => {
                let id = text("INTID").to_owned();
                if let Some(other) = self.nodes.iter().find(|node| node.id == id) {
                    let other = other.line;
                    return wrong(format!("node {id} stands in line {other} already; remove one"));
                }
                let of = |name: &str| {
                    let cell = Cell { text: text(name).to_owned(), line: number };
                    (!cell.text.is_empty()).then(|| cell.number(name)).transpose()
                };
                let kind = of("TYPE")?.map(|kind| kind as u32);
                let at = of("X")?.zip(of("Y")?);
                self.nodes.push(Node { id, line: number, kind, at });
            }
            Section::Unknown => {}
            Section::Records(place) => {
                let (name, id) = (text("RECORDNAME").to_lowercase(), text("INTID").to_owned());
                let named = columns.iter().map(|column| column.to_uppercase()).zip(line.fields());
                let cells: Cells = named
                    .filter(|(column, _)| !["RECORDNAME", "INTID", ""].contains(&column.as_str()))
                    .map(|(column, value)| {
                        (column, Cell { text: plain(value).to_owned(), line: number })
                    })
                    .filter(|(_, cell)| !cell.text.is_empty())
                    .collect();
                let of = self.records()[place].0.entry(name.clone()).or_default();
                // A second [Timeplans] may replace the offset, and repeat the rest.
                let may_replace = |other: &Cells| {
                    section == TIMEPLANS
                        && (name == "offset"
                            || match (other.get("DATA"), cells.get("DATA")) {
                                (Some(other), Some(cell)) => !other.differs(&cell.text),
                                (other, cell) => other.is_none() && cell.is_none(),
                            })
                };
                if of.get(&id).is_some_and(|other| !may_replace(other)) {
                    return wrong(format!("record {name} of node {id} stands twice; remove one"));
                }
                of.insert(id, cells);
            }
        }
        Ok(())
    }

    /// Returns the sections without which no intersection can be made.
    pub(super) fn missing(&self) -> Vec<&'static str> {
        let all = [
            ("nodes ([Nodes])", self.nodes.is_empty()),
            ("links ([Links])", self.links.0.is_empty()),
            ("lanes ([Lanes])", self.lanes.0.is_empty()),
        ];
        all.into_iter().filter(|(_, missing)| *missing).map(|(name, _)| name).collect()
    }

    /// Returns whether the network says in which units its lengths and speeds are.
    pub(super) fn says_units(&self) -> bool {
        self.network.get("metric").is_some_and(|cell| !cell.text.is_empty())
    }

    /// Returns whether lengths and speeds are metric.
    pub(super) fn is_metric(&self) -> bool {
        self.of_network("metric") == Some(1.0)
    }

    /// Returns a number that holds for the whole network; `None` where none is said.
    pub(super) fn of_network(&self, name: &str) -> Option<f64> {
        self.network.get(name)?.text.parse().ok()
    }
}

/// Returns the names of the columns of a section. The values of `[Network]` and `[Timeplans]` are in `DATA`, which some
/// programs call `Value`.
fn column_names(section: Section, line: &Line) -> Result<Vec<String>, Fault> {
    let mut columns: Vec<String> = line.fields().map(str::to_owned).collect();
    if !matches!(section, Section::Network | TIMEPLANS) {
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
