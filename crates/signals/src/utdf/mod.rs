//! UTDF, the Universal Traffic Data Format of Synchro: streets, volumes and timing of intersections as tables of text.
//!
//! Read is the combined file of versions 7 and 8, whose sections begin with a name in brackets. Columns are found by their
//! names. An empty cell means "not applicable", and a star before a value that somebody entered it in place of the computed
//! one.
//!
//! [`Utdf::intersections`] makes approaches and plans of it, and [`to_utdf`] writes plans.

mod plans;
mod streets;
mod tables;
mod write;

use std::path::Path;

use osm_signals::DrivingSide;
use sheet::uneven::{self, is_utdf};
use sheet::{Fault, file};

use crate::existing::{self, Plans};
use crate::family::doubts::Doubt;
use crate::family::load::Uncounted;
use crate::settings::Scenario;
use basics::files::FileError;
use evaluation::family::columns::at;
use evaluation::family::error::FamilyError;
use evaluation::family::names::safe_id;
use evaluation::settings::overrides::Override;
pub use streets::Converted;
use streets::{HALF_WALK, NO_PLAN};
use tables::{START, Tables};
pub use write::to_utdf;

/// A network in UTDF.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Utdf {
    tables: Tables,
    /// The file.
    file: String,
    /// Side that traffic keeps to, which the format does not say.
    side: DrivingSide,
}

impl Utdf {
    /// Reads the file of a network.
    pub fn read(path: &Path) -> Result<Self, FamilyError> {
        let mut network = Self::default();
        let bytes = file::read(path, file::TABLE_BYTES).map_err(FileError::at("read", path))?;
        network.add(&bytes, &path.display().to_string())?;
        network.complete()?;
        Ok(network)
    }

    /// Takes the text of a file; its name is for messages.
    pub fn add(&mut self, bytes: &[u8], file: &str) -> Result<(), FamilyError> {
        let lines = uneven::lines(bytes).map_err(|fault| at(file, fault))?;
        if !is_utdf(bytes) && crate::turning::names_movements(&lines) {
            let message = "a table of turning counts, no network; give it with --turning-counts beside --utdf";
            return Err(at(file, Fault { line: 1, message: message.to_owned() }));
        }
        file.clone_into(&mut self.file);
        self.tables.add(&lines).map_err(|fault| self.wrong(fault))
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
        let converted = self.intersections()?;
        let intersections = converted.intersections.clone();
        let plans = Some(converted.plans.clone()).filter(|plans| !plans.all.is_empty());
        let file = self.file.clone();
        Ok((Uncounted { file, scenario, text, intersections, plans }, converted))
    }

    /// Checks that what makes intersections is there.
    fn complete(&self) -> Result<(), FamilyError> {
        let Tables { nodes, links, lanes, .. } = &self.tables;
        if nodes.is_empty() || links.0.is_empty() || lanes.0.is_empty() {
            let message =
                "no [Nodes], [Links] or [Lanes]; export the network again with all sections";
            return Err(self.wrong(Fault::new(START, message)));
        }
        Ok(())
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
    let wrong = |message: String| at(&file, Fault { line: 1, message });
    let bytes = file::read(path, file::TABLE_BYTES).map_err(FileError::at("read", path))?;
    if is_utdf(&bytes) {
        let mut network = Utdf { side, ..Utdf::default() };
        network.add(&bytes, &file)?;
        network.complete()?;
        let Converted { plans, doubts, .. } = network.intersections()?;
        let doubts: Vec<Doubt> = (doubts.into_iter())
            .filter(|doubt| [NO_PLAN, HALF_WALK].contains(&doubt.about.as_str()))
            .collect();
        if plans.all.is_empty() {
            let why = doubts
                .iter()
                .find(|doubt| doubt.about == NO_PLAN)
                .map_or_else(|| "it has no section [Phases]".to_owned(), Doubt::brief);
            return Err(wrong(format!(
                "no plan that can be shown: {why}; export the network with its phases, or give a table of phases"
            )));
        }
        return Ok((plans, doubts));
    }
    let is_counts =
        uneven::lines(&bytes).is_ok_and(|lines| crate::turning::names_movements(&lines));
    if is_counts {
        return Err(wrong(
            "a table of turning counts, no plans; give it with --turning-counts".to_owned(),
        ));
    }
    let text = sheet::decode(&bytes).map_err(|fault| at(&file, fault))?;
    Ok((existing::read(&text, &file)?, Vec::new()))
}

#[cfg(test)]
mod tests;
