//! The sections of UTDF as tables of text.

use std::collections::{BTreeMap, BTreeSet};

use sheet::uneven::Line;

use crate::settings::MIN_PEAK_HOUR_FACTOR;

/// A line of one of the files of a network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Spot {
    /// Number of the file, from 0.
    pub(super) file: usize,
    pub(super) line: u64,
}

/// Where messages about the whole network point.
pub(super) const START: Spot = Spot { file: 0, line: 1 };

/// What is wrong at a line of one of the files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Fault {
    pub(super) spot: Spot,
    pub(super) message: String,
}

impl Fault {
    /// Returns a fault.
    pub(super) fn new(spot: Spot, message: impl Into<String>) -> Self {
        Self { spot, message: message.into() }
    }
}

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

/// A cell with its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Cell {
    pub(super) text: String,
    pub(super) spot: Spot,
}

impl Cell {
    /// Returns whether it has another number than a text, or another text that is no number.
    fn differs(&self, text: &str) -> bool {
        let number = |text: &str| text.parse::<f64>().ok();
        self.text != text && (number(text).is_none() || number(text) != number(&self.text))
    }
}

/// Records of a section by name, in lower case, and intersection.
pub(super) type Records = BTreeMap<(String, String), Cells>;

/// A node of the network.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Node {
    pub(super) id: String,
    pub(super) spot: Spot,
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
    Links,
    Lanes,
    Timeplans,
    Phases,
    /// Nodes and streets of version 6.
    Layout,
    /// Plans of version 6.
    Timing,
    Unknown,
}

/// Sections by their names.
const SECTIONS: [(&str, Section); 6] = [
    ("network", Section::Network),
    ("nodes", Section::Nodes),
    ("links", Section::Links),
    ("lanes", Section::Lanes),
    ("timeplans", Section::Timeplans),
    ("phases", Section::Phases),
];

/// Columns of `LAYOUT.CSV` with the leg that a node lies on, and the direction of travel from there.
const LEGS: [(&str, &str); 8] = [
    ("NID", "SB"),
    ("SID", "NB"),
    ("EID", "WB"),
    ("WID", "EB"),
    ("NEID", "SW"),
    ("NWID", "SE"),
    ("SEID", "NW"),
    ("SWID", "NE"),
];

impl Tables {
    /// Adds the lines of a file with a number.
    ///
    /// # Errors
    ///
    /// [`Fault`] for what is no UTDF, and for a record that stands twice.
    pub(super) fn add(&mut self, lines: &[Line], file: usize) -> Result<(), Fault> {
        let mut section: Option<Section> = None;
        let mut header: Option<(Section, Vec<String>)> = None;
        let mut found = false;
        for line in lines {
            let spot = Spot { file, line: line.number };
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
            if let Some(named) = columns_of(line, section) {
                header = Some((named, column_names(named, line, spot)?));
                found = true;
                continue;
            }
            // Titles stand between the name of a section and its columns.
            let Some((section, columns)) = &header else { continue };
            self.row(*section, columns, line, spot)?;
        }
        if found {
            return Ok(());
        }
        let message = "no UTDF: no line RECORDNAME,INTID,... or INTID,TYPE,X,Y; export the network as UTDF (CSV)";
        Err(Fault::new(Spot { file, line: lines.first().map_or(1, |line| line.number) }, message))
    }

    fn row(
        &mut self,
        section: Section,
        columns: &[String],
        line: &Line,
        spot: Spot,
    ) -> Result<(), Fault> {
        let text = |name: &str| {
            let at = columns.iter().position(|c| c.eq_ignore_ascii_case(name));
            at.map(|at| plain(line.text(at))).unwrap_or_default()
        };
        match section {
            Section::Network => {
                let (name, value) = (text("RECORDNAME").to_lowercase(), text("DATA"));
                let is_read = SETTINGS.iter().any(|(setting, ..)| *setting == name);
                let other = self.network.get(&name).filter(|other| !other.text.is_empty());
                match other {
                    Some(other) if is_read && !value.is_empty() && other.differs(value) => {
                        let message = format!(
                            "[Network] {name} = {value:?}, but {:?} in {}; remove one",
                            other.text,
                            already(other.spot, spot)
                        );
                        return Err(Fault::new(spot, message));
                    }
                    Some(_) => {}
                    None => {
                        self.network.insert(name, Cell { text: value.to_owned(), spot });
                    }
                }
            }
            Section::Nodes | Section::Layout => {
                let id = text("INTID").to_owned();
                if let Some(other) = self.nodes.iter().find(|node| node.id == id) {
                    let message = format!(
                        "node {id} stands in {} already; remove one",
                        already(other.spot, spot)
                    );
                    return Err(Fault::new(spot, message));
                }
                let number = |name: &str| -> Result<Option<f64>, Fault> {
                    match text(name) {
                        "" => Ok(None),
                        value => match value.parse::<f64>() {
                            Ok(number) if number.is_finite() => Ok(Some(number)),
                            _ => Err(Fault::new(
                                spot,
                                format!("{name} = {value:?}: expected a number"),
                            )),
                        },
                    }
                };
                let kind = number("TYPE")?.map(|kind| kind as u32);
                let at = number("X")?.zip(number("Y")?);
                if section == Section::Layout {
                    self.legs(&id, spot, &text);
                }
                self.nodes.push(Node { id, spot, kind, at });
            }
            Section::Timing => {
                self.unknown.insert("plans of TIMING.CSV".to_owned());
            }
            Section::Unknown => {}
            Section::Links | Section::Lanes | Section::Timeplans | Section::Phases => {
                let records = match section {
                    Section::Links => &mut self.links,
                    Section::Lanes => &mut self.lanes,
                    Section::Timeplans => &mut self.timeplans,
                    _ => &mut self.phases,
                };
                let key = (text("RECORDNAME").to_lowercase(), text("INTID").to_owned());
                let mut cells = Cells::new();
                for (column, value) in columns.iter().zip(line.fields()) {
                    let (column, value) = (column.to_uppercase(), plain(value));
                    if !value.is_empty()
                        && column != "RECORDNAME"
                        && column != "INTID"
                        && !column.is_empty()
                    {
                        cells.insert(column, Cell { text: value.to_owned(), spot });
                    }
                }
                let (name, id) = (key.0.clone(), key.1.clone());
                // A second [Timeplans] may replace the offset, and repeat the rest.
                let may_replace = |other: &Cells| {
                    section == Section::Timeplans
                        && (name == "offset"
                            || match (other.get("DATA"), cells.get("DATA")) {
                                (Some(other), Some(cell)) => !other.differs(&cell.text),
                                (other, cell) => other.is_none() && cell.is_none(),
                            })
                };
                if records.get(&key).is_some_and(|other| !may_replace(other)) {
                    let message = format!("record {name} of node {id} stands twice; remove one");
                    return Err(Fault::new(spot, message));
                }
                records.insert(key, cells);
            }
        }
        Ok(())
    }

    /// Adds the legs of a node of version 6.
    fn legs<'t>(&mut self, id: &str, spot: Spot, text: &dyn Fn(&str) -> &'t str) {
        for (record, column) in [("up id", 0), ("name", 1)] {
            let mut cells = Cells::new();
            for (leg, heading) in LEGS {
                // NID is the node of the northern leg and NNAME its street.
                let name = if column == 0 { leg.to_owned() } else { leg.replace("ID", "NAME") };
                let value = text(&name);
                if !value.is_empty() && value != "0" {
                    cells.insert(heading.to_owned(), Cell { text: value.to_owned(), spot });
                }
            }
            self.links.insert((record.to_owned(), id.to_owned()), cells);
        }
    }

    /// Returns the sections without which no intersection can be made.
    pub(super) fn missing(&self) -> Vec<&'static str> {
        let all = [
            ("nodes ([Nodes] or LAYOUT.CSV)", self.nodes.is_empty()),
            ("links ([Links] or LAYOUT.CSV)", self.links.is_empty()),
            ("lanes ([Lanes] or LANES.CSV)", self.lanes.is_empty()),
        ];
        all.into_iter().filter(|(_, missing)| *missing).map(|(name, _)| name).collect()
    }

    /// Returns whether there are plans without the streets that they are for, as reports write them for Synchro to merge.
    pub(super) fn is_plans_only(&self) -> bool {
        let has_plans = [&self.phases, &self.lanes].iter().all(|records| !records.is_empty());
        self.nodes.is_empty() && self.links.is_empty() && has_plans
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

/// Returns whether a line names the columns of records.
pub(super) fn has_records(lines: &[Line]) -> bool {
    lines.iter().any(|line| line.text(0).eq_ignore_ascii_case("RECORDNAME"))
}

/// Returns the names of the columns of a section. The values of `[Network]` and `[Timeplans]` are in `DATA`, which some
/// programs call `Value`.
fn column_names(section: Section, line: &Line, spot: Spot) -> Result<Vec<String>, Fault> {
    let mut columns: Vec<String> = line.fields().map(str::to_owned).collect();
    if !matches!(section, Section::Network | Section::Timeplans) {
        return Ok(columns);
    }
    let find = |name: &str| columns.iter().position(|column| column.eq_ignore_ascii_case(name));
    let Some(at) = find("DATA").or_else(|| find("VALUE")) else {
        let message = "no column DATA with the values of the records; call it so";
        return Err(Fault::new(spot, message));
    };
    "DATA".clone_into(&mut columns[at]);
    Ok(columns)
}

/// Returns the name of a place where a value stands that comes again.
fn already(first: Spot, second: Spot) -> String {
    match first.file == second.file {
        true => format!("line {}", first.line),
        false => format!("line {} of another file", first.line),
    }
}

/// Returns a value without the star of what somebody entered.
fn plain(text: &str) -> &str {
    text.strip_prefix('*').unwrap_or(text).trim()
}

/// Returns the section whose columns a line names, if it names any.
fn columns_of(line: &Line, section: Option<Section>) -> Option<Section> {
    let first = line.text(0).to_uppercase();
    let has = |name: &str| line.fields().any(|field| field.eq_ignore_ascii_case(name));
    match (first.as_str(), section) {
        ("RECORDNAME" | "INTID", Some(section)) => Some(section),
        ("RECORDNAME", None) if has("D1") => Some(Section::Phases),
        ("RECORDNAME", None) if has("NBT") || has("EBT") || has("NBL") => Some(Section::Lanes),
        ("RECORDNAME", None) if has("NB") || has("EB") => Some(Section::Links),
        ("INTID", None) if has("NID") || has("EID") => Some(Section::Layout),
        ("INTID", None) if has("TYPE") && has("X") => Some(Section::Nodes),
        ("PLANID", None) => Some(Section::Timing),
        _ => None,
    }
}
