//! Existing plans from UTDF: phases, their times and the movements that they serve.
//!
//! - **Movements** are those that [`streets`](super::streets) makes of the lane groups: by where they lead.
//! - **Control types** are 0 pretimed, 1 actuated, 2 semi-actuated and 3 coordinated. Semi-actuated plans run as actuated
//!   with the recalls of the file. Without `[Timeplans]` a plan is actuated.
//! - **A phase** is one with a longest green. Phases without a movement at the signal keep their place and time, because
//!   they may be another node's of the same controller. They keep a walk if column `PED` names them: then they are for
//!   pedestrians alone.

use sheet::Fault;

use super::streets::{HALF_WALK, Names, Stop};
use super::{Cell, Utdf};
use crate::existing::table::{EXTENSION_S, SHORT_GREEN_S};
use crate::existing::{Control, ExistingPlan, LIMITS, Limits, PlanPhase, Recall};
use crate::family::doubts::Said;
use crate::vocabulary::Heading;

/// Records of lane groups with a phase, which end in a number, and whether the movement yields in it.
const OF_LANES: [(&str, bool); 2] = [("phase", false), ("permphase", true)];

/// Yellow and all-red where neither the phase nor the network says them, seconds.
const DEFAULT_CHANGE_S: [f64; 2] = [4.0, 1.0];

/// Most phases of a movement with and without the right of way.
pub(super) const MOST_OF_MOVEMENT: usize = 4;

/// Most detectors of a movement.
pub(super) const MOST_DETECTORS: usize = 5;

/// Column of the phases that are for pedestrians alone.
pub(super) const PEOPLE: &str = "PED";

impl Utdf {
    /// Returns the plan of a signal; `None` where the file has no phases of it.
    pub(super) fn plan(
        &self,
        id: &str,
        names: &Names,
        said: &mut Said,
    ) -> Result<Option<ExistingPlan>, Stop> {
        let record = |name: &str| self.phases.row(name, id);
        if record("brp").is_empty() {
            return Ok(None);
        }
        let data = |name: &str| self.timeplans.number(name, id, "DATA");
        let control = match data("control type")? {
            Some(0.0) => Control::Pretimed,
            None | Some(1.0 | 2.0) => Control::Actuated,
            Some(3.0) => Control::Coordinated,
            Some(other) => {
                return Err(format!("control type {other} is not known; expected 0 to 3").into());
            }
        };
        let phases = record("brp").iter().map(|(column, brp)| self.phase(id, column, brp, said));
        let mut phases: Vec<PlanPhase> =
            phases.filter_map(Result::transpose).collect::<Result<_, _>>()?;
        phases.sort_by_key(|phase| phase.number);
        let positive = |name: &str| Ok::<_, Fault>(data(name)?.filter(|value| *value > 0.0));
        let reference = positive("reference phase")?.map_or(0, |number| number as u32);
        // A reference phase without times is none of this signal's.
        let is_own = |number: &u32| phases.iter().any(|phase| phase.number == *number);
        let mut plan = ExistingPlan {
            cycle_s: positive("cycle length")?.filter(|_| control != Control::Actuated),
            offset_s: data("offset")?,
            reference: [reference / 100, reference % 100].into_iter().filter(is_own).collect(),
            referenced_to: positive("referenced to")?.map_or(0, |number| number as u32),
            ..ExistingPlan::new(control, phases)
        };
        self.give_movements(id, names, &mut plan)?;
        // Where the file has no such record, it is as in tables.
        if record("dualentry").is_empty() {
            for phase in &mut plan.phases {
                phase.dual_entry = phase.movements.iter().any(|name| name.ends_with('T'));
            }
        }
        plan.check()?;
        Ok(Some(plan))
    }

    /// Says how far each detector of a lane group is from the stop line, and in brackets how long it is; `None` without any.
    fn detectors(&self, id: &str, column: &str) -> Option<String> {
        let unit = if self.network.get("metric") == Some(&1.0) { "m" } else { "ft" };
        let text = |name: String| Some(&self.lanes.cell(&name, id, column)?.text);
        let one = |n| {
            let length = text(format!("detectsize{n}"));
            let length = length.map_or_else(String::new, |length| format!(" ({length})"));
            Some(format!("{}{length}", text(format!("detectpos{n}"))?))
        };
        let all: Vec<String> = (1..=MOST_DETECTORS).filter_map(one).collect();
        (!all.is_empty()).then(|| format!("{} {unit}", all.join(", ")))
    }

    /// Returns the phase of a column; `None` for one that is not used.
    fn phase(
        &self,
        id: &str,
        column: &str,
        brp: &Cell,
        said: &mut Said,
    ) -> Result<Option<PlanPhase>, Stop> {
        let value = |name: &str| {
            let Some(cell) = self.phases.cell(name, id, column) else { return Ok(None) };
            let number = cell.number(name)?;
            let outside = |limits: &&Limits| limits.1 == name && !limits.2.contains(&number);
            LIMITS.iter().find(outside).map_or(Ok(Some(number)), |(.., limits, _)| {
                let (low, high) = (limits.start(), limits.end());
                let why = format!("{name} of {column} = {}: expected {low} to {high}", cell.text);
                Err(Stop::LeftOut(Some(cell.line), why))
            })
        };
        let Some(max_green_s) = value("maxgreen")? else { return Ok(None) };
        let digits: Option<Vec<u32>> = brp.text.chars().map(|c| c.to_digit(10)).collect();
        let number = column.strip_prefix('D').and_then(|text| text.parse().ok());
        let (Some(number), Some(&[barrier, ring, position])) = (number, digits.as_deref()) else {
            let text = &brp.text;
            let message = format!(
                "BRP of {column} = {text:?}: expected barrier, ring and position, such as 111"
            );
            return Err(Fault::new(brp.line, message).into());
        };
        let [walk_s, clearance_s] =
            [value("walk")?, value("dontwalk")?].map(|value| value.filter(|s| *s > 0.0));
        if walk_s.is_some() != clearance_s.is_some() {
            said.say(HALF_WALK, format!("node {id}, phase {number}"));
        }
        let walk_s = walk_s.zip(clearance_s).map(<[f64; 2]>::from);
        let code = value("recall")?.unwrap_or_default();
        let recall = match Recall::ALL[code as usize] {
            // Pedestrian recall without pedestrians is a vehicle recall.
            Recall::Ped if walk_s.is_none() => Recall::Min,
            recall => recall,
        };
        let or_network = |name: &str, of_network: &str, otherwise: f64| {
            let otherwise = || self.network.get(of_network).copied().unwrap_or(otherwise);
            Ok::<_, Stop>(value(name)?.unwrap_or_else(otherwise))
        };
        let flag = |name: &str| Ok::<_, Stop>(value(name)?.is_some_and(|flag| flag != 0.0));
        Ok(Some(PlanPhase {
            number,
            ring,
            barrier,
            position,
            min_green_s: value("mingreen")?.unwrap_or(SHORT_GREEN_S.min(max_green_s)),
            max_green_s,
            min_split_s: value("minsplit")?.filter(|s| *s > 0.0),
            passage_s: value("vehext")?.unwrap_or(EXTENSION_S),
            yellow_s: or_network("yellow", "yellowtime", DEFAULT_CHANGE_S[0])?,
            all_red_s: or_network("allred", "allredtime", DEFAULT_CHANGE_S[1])?,
            walk_s,
            recall,
            dual_entry: flag("dualentry")?,
            inhibit_max: flag("inhibitmax")?,
            ..PlanPhase::default()
        }))
    }

    /// Gives phases their movements, or says why they cannot have them.
    fn give_movements(&self, id: &str, names: &Names, plan: &mut ExistingPlan) -> Result<(), Stop> {
        let (mut of_people, mut listed) = (Vec::new(), Vec::new());
        let kinds = OF_LANES.iter().flat_map(|kind| (1..=MOST_OF_MOVEMENT).map(move |n| (kind, n)));
        for ((kind, yields), n) in kinds {
            let record = &format!("{kind}{n}");
            for (column, cell) in self.lanes.row(record, id) {
                if column == PEOPLE {
                    of_people.push(cell.number(record)?);
                }
                let Some((heading, turn)) = names.get(column) else { continue };
                let number = cell.number(record)?;
                if number <= 0.0 {
                    continue;
                }
                let phase = plan.phases.iter_mut().find(|p| f64::from(p.number) == number);
                let Some(phase) = phase else {
                    return Err(format!(
                        "{record} of {column} is {number}, which has no times in [Phases]"
                    )
                    .into());
                };
                let name = format!("{heading}{}", turn.letter());
                if !phase.all_movements().any(|known| *known == name) {
                    // A lane group's detectors stand at the first phase that serves it.
                    let own = self.detectors(id, column).filter(|_| !listed.contains(column));
                    if let Some(own) = own {
                        let all = std::mem::take(&mut phase.detectors);
                        let both = [all.as_str(), &format!("{name} {own}")];
                        phase.detectors = both[usize::from(all.is_empty())..].join("; ");
                        listed.push(column.clone());
                    }
                    let names = if *yields { &mut phase.yielding } else { &mut phase.movements };
                    names.push(name);
                }
            }
        }
        for phase in &mut plan.phases {
            // What another node's phase does for its pedestrians is nothing to those of this one.
            let is_own = of_people.contains(&f64::from(phase.number));
            if phase.all_movements().next().is_none() && !is_own {
                phase.walk_s = None;
                let recall = phase.recall;
                phase.recall = if recall == Recall::Ped { Recall::Min } else { recall };
            }
            // As engineers list them: left, through, right.
            let order = |name: &String| Heading::of_movement(name, self.side);
            phase.movements.sort_by_key(order);
            phase.yielding.sort_by_key(order);
        }
        Ok(())
    }
}
