//! UTDF, the Universal Traffic Data Format of Synchro: streets, volumes and timing of intersections as tables of text.
//!
//! Read is the combined file of versions 7 and 8, whose sections begin with a name in brackets. Columns are found by their
//! names. An empty cell means "not applicable", and a star before a value that somebody entered it in place of the computed
//! one.
//!
//! [`Utdf::intersections`] makes approaches and plans of it, and [`to_utdf`] writes plans.

mod lanes;
mod plans;
mod streets;
mod write;

use std::collections::BTreeMap;
use std::path::Path;

use osm_signals::DrivingSide;
use sheet::uneven::{self, Line, is_utdf};
use sheet::{Fault, file};

use crate::existing::{self, Plans};
use crate::family::doubts::Doubt;
use crate::family::load::Uncounted;
use crate::settings::{MIN_PEAK_HOUR_FACTOR, Scenario};
use basics::files::FileError;
use evaluation::family::columns::at;
use evaluation::family::error::FamilyError;
use evaluation::family::names::safe_id;
use evaluation::settings::overrides::Override;
pub use streets::Converted;
use streets::{HALF_WALK, NO_PLAN};
pub use write::to_utdf;

/// Line to which messages about the whole network point.
const START: u64 = 1;

/// Settings of the network that are read, in lower case, with the least and the largest value.
const SETTINGS: [(&str, f64, f64); 7] = [
    ("utdfversion", 7.0, 8.0),
    ("phf", MIN_PEAK_HOUR_FACTOR, 1.0),
    ("hv", 0.0, 1.0),
    ("growth", 0.0, 10.0),
    ("metric", 0.0, 1.0),
    ("yellowtime", 1.0, 10.0),
    ("allredtime", 0.0, 20.0),
];

/// A network in UTDF.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Utdf {
    /// Settings that hold for the whole network, by name.
    network: BTreeMap<&'static str, f64>,
    nodes: Vec<Node>,
    links: Records,
    lanes: Records,
    timeplans: Records,
    phases: Records,
    /// The file.
    file: String,
    /// Side that traffic keeps to, which the format does not say.
    side: DrivingSide,
    /// Whether `Peds` 0 everywhere are counts of nobody.
    zero_pedestrians: bool,
}

impl Utdf {
    /// Reads the file of a network.
    pub fn read(path: &Path) -> Result<Self, FamilyError> {
        let mut network = Self::default();
        let bytes = file::read(path, file::TABLE_BYTES).map_err(FileError::at("read", path))?;
        network.add(&bytes, &path.display().to_string())?;
        Ok(network)
    }

    /// Takes the text of a file; its name is for messages.
    pub fn add(&mut self, bytes: &[u8], file: &str) -> Result<(), FamilyError> {
        let lines = uneven::lines(bytes).map_err(|fault| at(file, fault))?;
        file.clone_into(&mut self.file);
        self.take(&lines).map_err(|fault| self.wrong(fault))
    }

    fn wrong(&self, fault: Fault) -> FamilyError {
        at(&self.file, fault)
    }

    /// Returns a scenario of the network's signals, which turning counts may be given to.
    ///
    /// # Arguments
    ///
    /// * `overrides` — settings of the scenario; the format does not say to which side traffic keeps.
    pub fn scenario(
        mut self,
        overrides: &[Override],
    ) -> Result<(Uncounted, Converted), FamilyError> {
        let stem = Path::new(&self.file).file_stem().unwrap_or_default();
        let name = safe_id(&stem.to_string_lossy());
        let text = format!(
            "name = \"{name}\"\ntitle = \"Signals of {name}, from UTDF\"\n\n[family]\napproaches = \"approaches.csv\"\n"
        );
        let mut scenario: Scenario = toml::from_str(&text).expect("the text is a scenario");
        for setting in overrides {
            scenario = setting.apply(&scenario)?;
        }
        self.side = scenario.network.driving_side;
        self.zero_pedestrians = scenario.family.zero_pedestrians;
        let converted = self.intersections()?;
        let intersections = converted.intersections.clone();
        let plans = Some(converted.plans.clone()).filter(|plans| !plans.all.is_empty());
        let file = self.file.clone();
        Ok((Uncounted { file, scenario, text, intersections, plans }, converted))
    }
}

/// Reads the plans that signals have today: a table of phases, or UTDF, of which all but the
/// plans is passed over.
///
/// # Arguments
///
/// * `side` — which traffic of the scenario keeps to.
pub fn read_plans(path: &Path, side: DrivingSide) -> Result<(Plans, Vec<Doubt>), FamilyError> {
    let file = path.display().to_string();
    let bytes = file::read(path, file::TABLE_BYTES).map_err(FileError::at("read", path))?;
    if is_utdf(&bytes) {
        let mut network = Utdf { side, ..Utdf::default() };
        network.add(&bytes, &file)?;
        let Converted { plans, doubts, .. } = network.intersections()?;
        let doubts: Vec<Doubt> = (doubts.into_iter())
            .filter(|doubt| [NO_PLAN, HALF_WALK].contains(&doubt.about.as_str()))
            .collect();
        if plans.all.is_empty() {
            let none = "no plan that can be shown; export the network with its phases, or give a table of phases".to_owned();
            let why = doubts.iter().map(Doubt::brief);
            let message = std::iter::once(none).chain(why).collect::<Vec<_>>().join("; ");
            return Err(at(&file, Fault { line: START, message }));
        }
        return Ok((plans, doubts));
    }
    let text = sheet::decode(&bytes).map_err(|fault| at(&file, fault))?;
    Ok((existing::read(&text, &file)?, Vec::new()))
}

/// Cells of a record by the names of their columns; only those that hold something.
type Cells = BTreeMap<String, Cell>;

/// A cell with its line.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Cell {
    text: String,
    line: u64,
}

impl Cell {
    /// Returns the number that it holds; messages call it like its record.
    fn number(&self, record: &str) -> Result<f64, Fault> {
        let number = self.text.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| {
            Fault::new(self.line, format!("{record} = {:?}: expected a number", self.text))
        })
    }
}

/// Records of a section by name, in lower case, and intersection.
#[derive(Debug, Clone, PartialEq, Default)]
struct Records(BTreeMap<String, BTreeMap<String, Cells>>);

impl Records {
    fn row(&self, record: &str, id: &str) -> &Cells {
        static NONE: Cells = Cells::new();
        self.0.get(record).and_then(|of| of.get(id)).unwrap_or(&NONE)
    }

    fn cell(&self, record: &str, id: &str, column: &str) -> Option<&Cell> {
        self.row(record, id).get(column)
    }

    fn number(&self, record: &str, id: &str, column: &str) -> Result<Option<f64>, Fault> {
        self.cell(record, id, column).map(|cell| cell.number(record)).transpose()
    }
}

/// A node of the network.
#[derive(Debug, Clone, PartialEq)]
struct Node {
    id: String,
    line: u64,
    /// 0 signal, 1 external, 2 bend, 3 unsignalised, 4 roundabout; `None` where it is not said.
    kind: Option<u32>,
    /// East and north of some origin, feet or metres.
    at: Option<(f64, f64)>,
}

impl Utdf {
    fn take(&mut self, lines: &[Line]) -> Result<(), Fault> {
        let mut section = None;
        let mut columns: Option<Vec<String>> = None;
        for line in lines {
            let first = line.text(0);
            if let Some(name) = first.strip_prefix('[').and_then(|name| name.strip_suffix(']')) {
                (section, columns) = (Some(name.to_lowercase()), None);
                continue;
            }
            let Some(section) = &section else { continue };
            if ["RECORDNAME", "INTID"].iter().any(|name| first.eq_ignore_ascii_case(name)) {
                let names = column_names(section, line)?;
                if columns.is_some_and(|above| above != names) {
                    let message = format!(
                        "other columns than above in [{section}]; put the name of their section before them"
                    );
                    return Err(Fault::new(line.number, message));
                }
                columns = Some(names);
            } else if let Some(columns) = &columns {
                // Titles stand between the name of a section and its columns.
                self.row(section, columns, line)?;
            }
        }
        Ok(())
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
            let at = columns.iter().position(|column| column == name);
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
            if *self.network.entry(known).or_insert(number) != number {
                return Err(wrong(format!("[Network] {known} stands twice; remove one")));
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
        let cells = columns.iter().cloned().zip(line.fields());
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
    let called =
        |name: &str| if name.eq_ignore_ascii_case("VALUE") { "DATA" } else { name }.to_uppercase();
    let columns: Vec<String> = line.fields().map(called).collect();
    let needed: &[&str] = match section {
        "network" => &["DATA"],
        "timeplans" => &["INTID", "DATA"],
        "nodes" | "links" | "lanes" | "phases" => &["INTID"],
        _ => &[],
    };
    match needed.iter().find(|name| !columns.iter().any(|column| column == *name)) {
        None => Ok(columns),
        Some(name) => {
            Err(Fault::new(line.number, format!("[{section}] has no column {name}; call it so")))
        }
    }
}

/// Returns a value without the star of what somebody entered.
fn plain(text: &str) -> &str {
    text.strip_prefix('*').unwrap_or(text).trim()
}

#[cfg(test)]
mod tests;
