//! Existing plans from UTDF: phases, their times and the movements that they serve.
//!
//! - **Movements** are those that [`streets`](super::streets) makes of the lane groups: by where they lead.
//! - **Control types** are 0 pretimed, 1 actuated, 2 semi-actuated and 3 coordinated. Semi-actuated plans run as actuated
//!   with the recalls of the file. Without `[Timeplans]` a plan is actuated.
//! - **A phase** is one with a longest green. Phases without a movement at the signal keep their place and time, because
//!   they may be another node's of the same controller. They keep a walk if column `PED` names them: then they are for
//!   pedestrians alone.

use std::collections::BTreeMap;

use osm_signals::Turn;

use super::Utdf;
use super::streets::number;
use super::tables::{Cell, Cells, Fault, START};
use crate::existing::{Control, ExistingPlan, NamedPlan, PlanPhase, Plans, Recall};
use crate::vocabulary::Heading;
use evaluation::family::error::FamilyError;

/// Records of lane groups with a phase, and whether the movement yields in it.
const OF_LANES: [(&str, bool); 8] = [
    ("phase1", false),
    ("phase2", false),
    ("phase3", false),
    ("phase4", false),
    ("permphase1", true),
    ("permphase2", true),
    ("permphase3", true),
    ("permphase4", true),
];

/// Records of `[Phases]` and `[Timeplans]`, and the phases of lane groups, that are read, in lower case.
pub(super) const READ: [&str; 25] = [
    "brp", "mingreen", "maxgreen", "vehext", "yellow", "allred", "recall", "walk", "dontwalk",
    "dualentry", "inhibitmax", "control type", "cycle length", "offset", "referenced to",
    "reference phase", "node 0", "phase1", "phase2", "phase3", "phase4", "permphase1",
    "permphase2", "permphase3", "permphase4",
];

/// Yellow and all-red where neither the phase nor the network says them, seconds.
const DEFAULT_CHANGE_S: [f64; 2] = [4.0, 1.0];

/// Shortest green and passage time where a phase has none, seconds.
const DEFAULT_GREEN_S: f64 = 5.0;
const DEFAULT_PASSAGE_S: f64 = 3.0;

/// Column of the phases that are for pedestrians alone.
pub(super) const PEOPLE: &str = "PED";

/// Names of the movements of a signal by the columns of its lane groups; none of those that lead nowhere.
pub(super) type Names = BTreeMap<String, (Heading, Turn)>;

/// Returns the name of a movement.
fn name((heading, turn): (Heading, Turn)) -> String {
    format!("{heading}{}", turn.letter())
}

/// A phase and whether it has only one of walk and clearance, or why it cannot be.
type ReadPhase = Result<(PlanPhase, bool), String>;

impl Utdf {
    /// Returns the plans of a file without streets: its columns are the movements. Also returns which phases have half a walk.
    ///
    /// # Errors
    ///
    /// [`FamilyError::Csv`] with file and line: a cell that is no number, a plan that cannot be simulated.
    pub(super) fn plans_alone(&self) -> Result<(Plans, Vec<String>), FamilyError> {
        let fail = |fault| self.wrong(fault);
        self.check_network().map_err(fail)?;
        let mut half_walk = Vec::new();
        let mut plans = Plans { file: self.file().to_owned(), ..Plans::default() };
        for ((_, id), cells) in self.tables.phases.iter().filter(|((record, _), _)| record == "brp")
        {
            let spot = cells.values().next().map_or(START, |cell| cell.spot);
            let of_lanes = OF_LANES.iter().filter_map(|(record, _)| {
                self.tables.lanes.get(&((*record).to_owned(), id.clone()))
            });
            let columns = of_lanes.flat_map(|cells| cells.keys());
            let names: Names = columns
                .filter_map(|column| {
                    Some((column.clone(), Heading::of_movement(column, self.side)?))
                })
                .collect();
            match self.plan(id, &names, &mut half_walk).map_err(fail)? {
                None => {}
                Some(Ok(plan)) => plans.all.push(NamedPlan {
                    intersection: id.clone(),
                    period: String::new(),
                    plan,
                    line: spot.line,
                }),
                Some(Err(reason)) => {
                    return Err(fail(Fault::new(spot, format!("node {id}: {reason}"))));
                }
            }
        }
        Ok((plans, half_walk))
    }

    /// Returns the plan of a signal, or why it has none; `None` where the file has no phases of it.
    ///
    /// # Arguments
    ///
    /// * `half_walk` — gets the phases that have only one of walk and clearance.
    ///
    /// # Errors
    ///
    /// [`Fault`] with the line of a cell that is no number.
    pub(super) fn plan(
        &self,
        id: &str,
        names: &Names,
        half_walk: &mut Vec<String>,
    ) -> Result<Option<Result<ExistingPlan, String>>, Fault> {
        let none = Cells::new();
        let record =
            |name: &str| self.tables.phases.get(&(name.to_owned(), id.to_owned())).unwrap_or(&none);
        if record("brp").is_empty() {
            return Ok(None);
        }
        let data = |name: &str| -> Result<Option<f64>, Fault> {
            let cells = self.tables.timeplans.get(&(name.to_owned(), id.to_owned()));
            cells.and_then(|cells| cells.get("DATA")).map(|cell| number(cell, name)).transpose()
        };
        let control = match data("control type")? {
            Some(0.0) => Control::Pretimed,
            None | Some(1.0 | 2.0) => Control::Actuated,
            Some(3.0) => Control::Coordinated,
            Some(other) => {
                return Ok(Some(Err(format!(
                    "control type {other} is not known; expected 0 to 3"
                ))));
            }
        };
        let reference = data("reference phase")?.filter(|n| *n > 0.0).map_or(0, |n| n as u32);
        let reference = [reference / 100, reference % 100];
        let mut plan = ExistingPlan {
            cycle_s: data("cycle length")?.filter(|s| *s > 0.0 && control != Control::Actuated),
            offset_s: Some(data("offset")?.unwrap_or_default()),
            reference: reference.into_iter().filter(|number| *number > 0).collect(),
            referenced_to: data("referenced to")?.filter(|n| *n >= 0.0).map_or(0, |n| n as u32),
            ..ExistingPlan::new(control, Vec::new())
        };
        for (column, brp) in record("brp") {
            let Some(phase) = self.phase(column, brp, &record)? else { continue };
            match phase {
                Ok((phase, has_half_walk)) => {
                    if has_half_walk {
                        half_walk.push(format!("node {id}, phase {}", phase.number));
                    }
                    plan.phases.push(phase);
                }
                Err(reason) => return Ok(Some(Err(reason))),
            }
        }
        plan.phases.sort_by_key(|phase| phase.number);
        // A reference phase without times is none of this signal's.
        plan.reference.retain(|number| plan.phases.iter().any(|phase| phase.number == *number));
        if let Err(reason) = self.give_movements(id, names, &mut plan)? {
            return Ok(Some(Err(reason)));
        }
        // Where the file has no such record, it is as in tables.
        if record("dualentry").is_empty() {
            for phase in &mut plan.phases {
                phase.dual_entry = phase.movements.iter().any(|name| name.ends_with('T'));
            }
        }
        Ok(Some(plan.check().map(|_| plan)))
    }

    /// Returns the phase of a column; `None` for one that is not used.
    fn phase<'t>(
        &self,
        column: &str,
        brp: &Cell,
        record: &dyn Fn(&str) -> &'t Cells,
    ) -> Result<Option<ReadPhase>, Fault> {
        let value =
            |name: &str| record(name).get(column).map(|cell| number(cell, name)).transpose();
        let Some(max_green_s) = value("maxgreen")? else { return Ok(None) };
        let digits: Option<Vec<u32>> = brp.text.chars().map(|c| c.to_digit(10)).collect();
        let number = column.strip_prefix('D').and_then(|text| text.parse().ok());
        let (Some(number), Some([barrier, ring, position])) = (number, digits.as_deref()) else {
            let text = &brp.text;
            let message = format!(
                "BRP of {column} = {text:?}: expected barrier, ring and position, such as 111"
            );
            return Err(Fault::new(brp.spot, message));
        };
        let of_network =
            |name: &str, otherwise: f64| self.tables.of_network(name).unwrap_or(otherwise);
        let yellow_s = value("yellow")?;
        let all_red_s = value("allred")?;
        let walk_s = value("walk")?.filter(|s| *s > 0.0);
        let clearance_s = value("dontwalk")?.filter(|s| *s > 0.0);
        let has_half_walk = walk_s.is_some() != clearance_s.is_some();
        let walk_s = walk_s.zip(clearance_s);
        let recall = match value("recall")? {
            None => Recall::None,
            Some(code) => match Recall::ALL.get(code as usize).filter(|_| code >= 0.0) {
                Some(recall) => *recall,
                None => {
                    return Ok(Some(Err(format!(
                        "recall {code} of phase {number} is not known; expected 0 to 3"
                    ))));
                }
            },
        };
        // Pedestrian recall without pedestrians is a vehicle recall.
        let recall = if recall == Recall::Ped && walk_s.is_none() { Recall::Min } else { recall };
        let phase = PlanPhase {
            number,
            ring: *ring,
            barrier: *barrier,
            position: *position,
            movements: Vec::new(),
            yielding: Vec::new(),
            min_green_s: value("mingreen")?.unwrap_or(DEFAULT_GREEN_S.min(max_green_s)),
            max_green_s,
            passage_s: value("vehext")?.unwrap_or(DEFAULT_PASSAGE_S),
            yellow_s: yellow_s.unwrap_or_else(|| of_network("yellowtime", DEFAULT_CHANGE_S[0])),
            all_red_s: all_red_s.unwrap_or_else(|| of_network("allredtime", DEFAULT_CHANGE_S[1])),
            walk_s: walk_s.map(|(walk_s, clearance_s)| [walk_s, clearance_s]),
            recall,
            dual_entry: value("dualentry")?.is_some_and(|flag| flag != 0.0),
            inhibit_max: value("inhibitmax")?.is_some_and(|flag| flag != 0.0),
        };
        Ok(Some(Ok((phase, has_half_walk))))
    }

    /// Gives phases their movements, or says why they cannot have them.
    fn give_movements(
        &self,
        id: &str,
        names: &Names,
        plan: &mut ExistingPlan,
    ) -> Result<Result<(), String>, Fault> {
        let mut of_people = Vec::new();
        for (record, yields) in OF_LANES {
            let Some(cells) = self.tables.lanes.get(&(record.to_owned(), id.to_owned())) else {
                continue;
            };
            for (column, cell) in cells {
                if column == PEOPLE {
                    of_people.push(number(cell, record)?);
                }
                let Some(way) = names.get(column) else { continue };
                let number = number(cell, record)?;
                if number <= 0.0 {
                    continue;
                }
                let Some(phase) = plan.phases.iter_mut().find(|p| f64::from(p.number) == number)
                else {
                    return Ok(Err(format!(
                        "{record} of {column} is {number}, which has no times in [Phases]"
                    )));
                };
                let name = name(*way);
                let known = phase.movements.contains(&name) || phase.yielding.contains(&name);
                if !known && yields {
                    phase.yielding.push(name);
                } else if !known {
                    phase.movements.push(name);
                }
            }
        }
        // What another node's phase does for its pedestrians is nothing to those of this one.
        for phase in &mut plan.phases {
            let is_own = of_people.contains(&f64::from(phase.number));
            if phase.all_movements().next().is_none() && !is_own {
                phase.walk_s = None;
                let recall = phase.recall;
                phase.recall = if recall == Recall::Ped { Recall::Min } else { recall };
            }
        }
        // As engineers list them: left, through, right.
        for phase in &mut plan.phases {
            let order = |name: &String| Heading::of_movement(name, self.side);
            phase.movements.sort_by_key(order);
            phase.yielding.sort_by_key(order);
        }
        Ok(Ok(()))
    }
}
