//! The sections of UTDF as tables of text.

use std::collections::{BTreeMap, BTreeSet};

use sheet::Fault;
use sheet::uneven::Line;

/// Cells of a record by the names of their columns; only those that hold something.
pub(super) type Cells = BTreeMap<String, Cell>;

/// A cell with its line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Cell {
    pub(super) text: String,
    pub(super) line: u64,
}

/// Records of a section by name, in lower case, and intersection.
pub(super) type Records = BTreeMap<(String, String), Cells>;

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
    /// Adds the lines of a file.
    ///
    /// # Errors
    ///
    /// [`Fault`] for what is no UTDF, and for a record that stands twice.
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
            if let Some(named) = columns_of(line, section) {
                header = Some((named, line.fields().map(str::to_owned).collect()));
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
        let message = "no UTDF: no line RECORDNAME,INTID,... or INTID,TYPE,X,Y; export the network as UTDF (CSV)";
        Err(Fault::new(lines.first().map_or(1, |line| line.number), message))
    }

    fn row(&mut self, section: Section, columns: &[String], line: &Line) -> Result<(), Fault> {
        let text = |name: &str| {
            let at = columns.iter().position(|c| c.eq_ignore_ascii_case(name));
            at.map(|at| plain(line.text(at))).unwrap_or_default()
        };
        match section {
            Section::Network => {
                let cell = Cell { text: text("DATA").to_owned(), line: line.number };
                self.network.insert(text("RECORDNAME").to_lowercase(), cell);
            }
            Section::Nodes | Section::Layout => {
                let id = text("INTID").to_owned();
                if let Some(other) = self.nodes.iter().find(|node| node.id == id) {
                    let message =
                        format!("node {id} stands in line {} already; remove one", other.line);
                    return Err(Fault::new(line.number, message));
                }
                let number = |name: &str| -> Result<Option<f64>, Fault> {
                    match text(name) {
                        "" => Ok(None),
                        value => match value.parse::<f64>() {
                            Ok(number) if number.is_finite() => Ok(Some(number)),
                            _ => Err(Fault::new(
                                line.number,
                                format!("{name} = {value:?}: expected a number"),
                            )),
                        },
                    }
                };
                let kind = number("TYPE")?.map(|kind| kind as u32);
                let at = number("X")?.zip(number("Y")?);
                if section == Section::Layout {
                    self.legs(&id, line, &text);
                }
                self.nodes.push(Node { id, line: line.number, kind, at });
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
                        cells.insert(column, Cell { text: value.to_owned(), line: line.number });
                    }
                }
                let (name, id) = (key.0.clone(), key.1.clone());
                // A second [Timeplans] may replace the offset.
                if section != Section::Timeplans && records.contains_key(&key) {
                    let message = format!("record {name} of node {id} stands twice; remove one");
                    return Err(Fault::new(line.number, message));
                }
                records.insert(key, cells);
            }
        }
        Ok(())
    }

    /// Adds the legs of a node of version 6.
    fn legs<'t>(&mut self, id: &str, line: &Line, text: &dyn Fn(&str) -> &'t str) {
        for (record, column) in [("up id", 0), ("name", 1)] {
            let mut cells = Cells::new();
            for (leg, heading) in LEGS {
                // NID is the node of the northern leg and NNAME its street.
                let name = if column == 0 { leg.to_owned() } else { leg.replace("ID", "NAME") };
                let value = text(&name);
                if !value.is_empty() && value != "0" {
                    cells.insert(
                        heading.to_owned(),
                        Cell { text: value.to_owned(), line: line.number },
                    );
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
