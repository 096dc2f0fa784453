//! From UTDF to intersections with approaches and volumes.
//!
//! - **Arms** are called after the direction of travel and the street, such as `NB Main St`. They are the
//!   links of a signal, in the direction of the node at their other end. The names of directions are those of the file and
//!   need not agree with the compass. A node that is a bend belongs to the street: its length
//!   goes on to the next node.
//! - **Lanes** are those of the lane groups. Lanes of a left or right group are turn lanes where a through group exists.
//!   Lanes that lead away are those of the link in the other direction, or as many as the movements into it have exits.
//! - **Volumes** are those of the file times its growth, with the peak hour factor and the heavy vehicles of its
//!   movements. A movement is the turn that leads to its destination. Several destinations of one turn have their own
//!   volumes. Deviation: where movements have no destination, exits of one turn get the same share.
//! - **Control** has no part in an intersection; see [`plans`](super::plans). A free right turn is a lane at the signal.

use std::collections::{BTreeMap, BTreeSet};

use osm_signals::Turn;
use osm_signals::angle::turn_degrees;
use osm_signals::intersections::MAX_LANES;
use osm_signals::turn::exits_on;

use super::Utdf;
use super::plans::Names;
use super::tables::{Cell, Cells, Fault, Node, Records, SETTINGS, START};
use crate::existing::{NamedPlan, Plans};
use crate::family::approaches::{
    self, Approach, Arrivals, Counted, Intersection, MOST_EXITS, MOST_PEDESTRIANS_PER_H, MOST_VPH,
    check_arms, gathered,
};
use crate::family::doubts::Doubt;
use crate::settings::MIN_PEAK_HOUR_FACTOR;
use crate::turning::FEW_VEHICLES;
use crate::vocabulary::Heading;
use basics::units::{FOOT_M, KMH_TO_MPH};
use evaluation::family::error::FamilyError;

/// Least length of an approach, metres.
const MIN_LENGTH_M: f64 = 25.0;

/// Most miles per hour, and metres, of an approach.
const MOST_MPH: f64 = 100.0;
const MOST_LENGTH_M: f64 = 100_000.0;

/// Speed where a link has none, miles per hour.
const DEFAULT_MPH: f64 = 30.0;

/// Length where a link has none, feet.
const DEFAULT_FT: f64 = 1000.0;

/// Lengths of bays that are simulated, metres.
const LEAST_STORAGE_M: f64 = 5.0;
const MOST_STORAGE_M: f64 = 1000.0;

/// Growth below which it is probably a factor, percent.
const LEAST_GROWTH_PERCENT: f64 = 10.0;

/// Percentage of heavy vehicles below which it is probably a share.
const LEAST_HEAVY_PERCENT: f64 = 1.0;

/// Fewest links of a signal: with two there is nothing to decide.
const MIN_LINKS: usize = 3;

/// Least angle between two arms, degrees: nearer ones have no junction between them.
const MIN_ANGLE_DEG: f64 = 5.0;

/// What is said of plans that a file has and nobody can show.
pub(super) const NO_PLAN: &str = "plans that cannot be simulated are left out";

/// What is said of phases with half a walk.
pub(super) const HALF_WALK: &str =
    "phases that have only one of Walk and DontWalk get no walk; give both, or none";

/// Most bends that a street goes through.
const MOST_BENDS: usize = 20;

/// Records that are read, in lower case.
const READ: [&str; 19] = [
    "storage", "stlanes", "up id", "lanes", "name", "distance", "speed", "up node", "dest node",
    "shared", "volume", "growth", "phf", "heavyvehicles", "peds", "exit lanes", "node 0", "node 1",
    "node 2",
];

/// What a network in UTDF became.
#[derive(Debug, Clone, PartialEq)]
pub struct Converted {
    /// Its signals.
    pub intersections: Vec<Intersection>,
    /// What was found, one line each.
    pub found: Vec<String>,
    /// What is doubtful, and what is not used.
    pub doubts: Vec<Doubt>,
    /// The plans that they have today.
    pub plans: Plans,
}

/// What is said of single intersections.
#[derive(Default)]
struct Said {
    no_speed: Vec<String>,
    no_length: Vec<String>,
    short: Vec<String>,
    no_place: Vec<String>,
    no_node: Vec<String>,
    no_way_back: Vec<String>,
    no_exit: Vec<String>,
    no_lane: Vec<String>,
    renamed: Vec<String>,
    no_bay: Vec<String>,
    part_of_bay: Vec<String>,
    shared_right: Vec<String>,
    shared_left: Vec<String>,
    left_out: Vec<String>,
    several_exits: Vec<String>,
    one_controller: Vec<String>,
    growth: Vec<String>,
    heavy: Vec<String>,
    few: Vec<String>,
    no_volume: Vec<String>,
    no_plan: Vec<String>,
    half_walk: Vec<String>,
}

/// A movement of a lane group.
struct Movement {
    column: String,
    heading: Heading,
    turn: Turn,
    lanes: u32,
    shared: u32,
    to: Option<String>,
    /// Volume times growth; 0 where the file has no volume.
    volume_vph: f64,
    /// Whether the file has a volume.
    is_counted: bool,
    /// Growth as the file has it, percent.
    growth_percent: Option<f64>,
    peak_hour_factor: Option<f64>,
    heavy: Option<f64>,
    /// Heavy vehicles as the file has them, percent.
    heavy_percent: Option<f64>,
    /// People per hour who cross where it leaves.
    pedestrians_per_h: Option<f64>,
    /// Length of its bay, metres, and how many of its lanes are in it.
    storage: Option<(f64, Option<u32>)>,
}

impl Utdf {
    /// Returns the signals of the network as intersections with approaches and volumes.
    ///
    /// # Errors
    ///
    /// [`FamilyError::Csv`] with file and line: a cell that is no number, a network without signals.
    pub fn intersections(&self) -> Result<Converted, FamilyError> {
        self.check_network().map_err(|fault| self.wrong(fault))?;
        let mut said = Said::default();
        let mut rows = Vec::new();
        let mut with_volumes = 0;
        let signals: Vec<&Node> =
            self.tables.nodes.iter().filter(|node| self.is_signal(node)).collect();
        // Plans have the lines of their nodes.
        let file = signals.first().and_then(|node| self.files.get(node.spot.file));
        let file = file.cloned().unwrap_or_default();
        let mut plans = Plans { file, is_utdf: true, ..Plans::default() };
        for node in &signals {
            let made = self.signal(node, &mut said).map_err(|fault| self.wrong(fault))?;
            let Some((arms, names)) = made else { continue };
            let total: f64 = arms.iter().filter_map(|a| a.counted).map(|c| c.total_vph()).sum();
            let total_lanes =
                arms.iter().map(|a| a.lanes_in.max(a.lanes_out)).max().unwrap_or_default();
            let most_vph =
                arms.iter().filter_map(|a| a.counted).map(|c| c.total_vph()).fold(0.0, f64::max);
            if total_lanes > MAX_LANES || most_vph > MOST_VPH {
                said.left_out.push(format!(
                    "node {} has {total_lanes} lanes in one direction and up to {most_vph:.0} veh/h; at most {MAX_LANES} and \
                     {MOST_VPH} are simulated",
                    node.id
                ));
                continue;
            }
            let intersection = gathered(arms).remove(0);
            if let Err(why) = check_rows(&intersection) {
                said.left_out.push(why);
                continue;
            }
            with_volumes += usize::from(total > 0.0);
            rows.push(intersection);
            let plan = self.plan(&node.id, &names, &mut said.half_walk);
            match plan.map_err(|fault| self.wrong(fault))? {
                None => {}
                Some(Err(reason)) => said.no_plan.push(format!("node {}: {reason}", node.id)),
                Some(Ok(plan)) => plans.all.push(NamedPlan {
                    intersection: node.id.clone(),
                    period: String::new(),
                    plan,
                    line: node.spot.line,
                }),
            }
        }
        if rows.is_empty() {
            let mut message = format!(
                "none of the {} nodes is a signal that can be simulated",
                self.tables.nodes.len()
            );
            for why in said.left_out.iter().take(3) {
                message = format!("{message}; {why}");
            }
            return Err(self.wrong(Fault::new(START, message)));
        }
        let of_plans = match plans.all.len() {
            0 => String::new(),
            count => format!(", {count} with a plan"),
        };
        let found = vec![format!(
            "UTDF: {} of {} signals, {with_volumes} with volumes{of_plans}; {} nodes",
            rows.len(),
            signals.len(),
            self.tables.nodes.len()
        )];
        let mut doubts = said.doubts();
        if !self.tables.says_units() {
            let about = "no Metric in [Network]: lengths are read as feet and speeds as mph; Metric,1 says metres and km/h";
            doubts.extend(Doubt::of(about, vec![self.file().to_owned()]));
        }
        doubts.extend(self.unused());
        Ok(Converted { intersections: rows, found, doubts, plans })
    }

    /// Checks the defaults of the network.
    ///
    /// # Errors
    ///
    /// [`Fault`] at the line of one that is out of its range.
    pub(super) fn check_network(&self) -> Result<(), Fault> {
        for (name, low, high) in SETTINGS {
            let Some(Cell { text, spot }) = self.tables.network.get(name) else { continue };
            if text.is_empty() {
                continue;
            }
            if !text.parse::<f64>().is_ok_and(|value| (low..=high).contains(&value)) {
                let message =
                    format!("[Network] {name} = {text:?}: expected a number from {low} to {high}");
                return Err(Fault::new(*spot, message));
            }
        }
        Ok(())
    }

    /// Whether a node is a signal: its type says so, or it has timing.
    fn is_signal(&self, node: &Node) -> bool {
        match node.kind {
            Some(kind) => kind == 0,
            None => self.tables.phases.keys().any(|(_, id)| *id == node.id),
        }
    }

    /// Returns the rows of a signal, and the movements that its columns are; `None` if it is left out.
    fn signal(
        &self,
        node: &Node,
        said: &mut Said,
    ) -> Result<Option<(Vec<Approach>, Names)>, Fault> {
        let id = &node.id;
        let none = Cells::new();
        let link =
            |record: &str| self.tables.links.get(&(record.to_owned(), id.clone())).unwrap_or(&none);
        let up: Vec<(Heading, &Cell)> =
            Heading::ALL.iter().filter_map(|h| Some((*h, link("up id").get(h.name())?))).collect();
        let movements = self.movements(id)?;
        if up.len() < MIN_LINKS || movements.is_empty() {
            let what = if movements.is_empty() { "no lanes" } else { "fewer than three links" };
            said.left_out.push(format!("node {id} has {what}"));
            return Ok(None);
        }
        if let Some(cell) = self
            .tables
            .timeplans
            .get(&("node 1".to_owned(), id.clone()))
            .and_then(|c| c.get("DATA"))
            && cell.text != "0"
        {
            said.one_controller.push(format!("node {id} with {}", cell.text));
        }
        said.volumes(id, &movements);
        let ids: Vec<&str> = up.iter().map(|(_, cell)| cell.text.as_str()).collect();
        let mut bearings = Vec::new();
        let mut lanes_out = Vec::new();
        for (heading, other) in &up {
            let bearing_deg = self.bearing_deg(node, &other.text).unwrap_or_else(|| {
                match self.tables.nodes.iter().any(|node| node.id == other.text) {
                    true => said.no_place.push(format!("node {id}, {heading}")),
                    false => {
                        said.no_node.push(format!("node {id}, {heading}: node {}", other.text))
                    }
                }
                heading.degrees() + 180.0
            });
            bearings.push((bearing_deg.rem_euclid(360.0) * 10.0).round() / 10.0 % 360.0);
            lanes_out.push(self.lanes_out((id, *heading), &other.text, &movements, said)?);
        }
        if let Some((a, b)) = too_near(&bearings) {
            let (a, b) = (up[a].0, up[b].0);
            said.left_out
                .push(format!("node {id}: {a} and {b} come from nearly the same direction"));
            return Ok(None);
        }
        let mut arms = Vec::new();
        let mut names = Names::new();
        for (i, (heading, other)) in up.iter().enumerate() {
            let own: Vec<&Movement> = movements.iter().filter(|m| m.heading == *heading).collect();
            let others = (0..ids.len()).filter(|j| *j != i && lanes_out[*j] > 0);
            let ways = Ways {
                own: ids[i],
                ids: &ids,
                exits: exits_on(self.side, bearings[i], others.map(|j| (j, bearings[j]))),
            };
            // Lanes belong to where they lead, whatever their group is called.
            let lanes = |turn: Turn| {
                let of = own.iter().filter(|m| ways.turn(m).unwrap_or(m.turn) == turn);
                of.map(|m| m.lanes).sum::<u32>()
            };
            let [left, through, right] = [Turn::Left, Turn::Through, Turn::Right].map(lanes);
            if through > 0
                && left > 0
                && own.iter().any(|m| m.turn == Turn::Through && m.shared & 1 == 1)
            {
                said.shared_left.push(format!("node {id}, {heading}"));
            }
            // Without a through group the lanes that left and right share are neither.
            let is_shared = own.iter().any(|m| m.turn == Turn::Left && m.shared & 2 == 2);
            if through == 0 && is_shared && left > 1 {
                said.shared_right.push(format!("node {id}, {heading}"));
            }
            let (left, right) = match through {
                0 if is_shared => (left.saturating_sub(1), right),
                _ => (left, right),
            };
            let street = link("name").get(heading.name()).map_or("", |cell| cell.text.as_str());
            let words = std::iter::once(heading.name()).chain(street.split_whitespace());
            let (length_m, speed_mph) = self.length_and_speed(id, *heading, said)?;
            let mut arm = Approach {
                intersection: id.clone(),
                arm: words.collect::<Vec<_>>().join(" "),
                latitude: f64::NAN,
                longitude: f64::NAN,
                bearing_deg: bearings[i],
                lanes_in: own.iter().map(|m| m.lanes).sum(),
                lanes_out: lanes_out[i],
                left_storage_m: None,
                right_storage_m: None,
                left_turn_lanes: left,
                right_turn_lanes: right,
                speed_mph,
                length_m,
                aadt_veh_per_day_per_lane: 0.0,
                movements: String::new(),
                period: String::new(),
                counted: None,
                line: other.spot.line,
                imputed: false,
            };
            give(&mut arm, &own, &ways, said);
            // Both turns into a street meet the same people.
            let into = |m: &&Movement| m.turn != Turn::Through && m.leads_to(&up, i);
            let walk = movements.iter().filter(into).filter_map(|m| m.pedestrians_per_h);
            if let Some(counted) = &mut arm.counted {
                counted.pedestrians_per_h = walk.reduce(f64::max);
            }
            for m in own.iter().filter(|m| m.lanes > 0) {
                let Some((storage_m, lanes)) = m.storage else { continue };
                let (bay, own_lanes) = match ways.turn(m).unwrap_or(m.turn) {
                    Turn::Left => (&mut arm.left_storage_m, arm.left_turn_lanes),
                    Turn::Right => (&mut arm.right_storage_m, arm.right_turn_lanes),
                    Turn::Through => continue,
                };
                let at = format!("node {id}, {}", m.column);
                if own_lanes == 0 || !(LEAST_STORAGE_M..=MOST_STORAGE_M).contains(&storage_m) {
                    said.no_bay.push(format!("{at}: {storage_m:.0} m"));
                    continue;
                }
                if lanes.is_some_and(|lanes| lanes < m.lanes) {
                    said.part_of_bay.push(at);
                }
                *bay = Some(bay.unwrap_or_default().max(storage_m));
            }
            for m in own {
                let exists = |turn: &Turn| arm.movements.contains(letter(*turn));
                if let Some(turn) = ways.turn(m).filter(exists) {
                    names.insert(m.column.clone(), (*heading, turn));
                }
            }
            arms.push(arm);
        }
        Ok(Some((arms, names)))
    }

    /// Returns the direction from a node to another, degrees clockwise from north.
    fn bearing_deg(&self, node: &Node, other: &str) -> Option<f64> {
        let (x, y) = node.at?;
        let (to_x, to_y) = self.tables.nodes.iter().find(|n| n.id == other)?.at?;
        let (east, north) = (to_x - x, to_y - y);
        (east != 0.0 || north != 0.0).then(|| east.atan2(north).to_degrees())
    }

    /// Returns the length of an approach in metres, through bends, and its speed in miles per hour.
    fn length_and_speed(
        &self,
        id: &str,
        heading: Heading,
        said: &mut Said,
    ) -> Result<(f64, f64), Fault> {
        let of = |record: &str, id: &str, heading: Heading| -> Result<Option<f64>, Fault> {
            let key = (record.to_owned(), id.to_owned());
            let cell = self.tables.links.get(&key).and_then(|cells| cells.get(heading.name()));
            // In version 6 they are beside the lanes.
            let group = || {
                let cells = self.tables.lanes.get(&key)?;
                ["T", "L", "R"].iter().find_map(|turn| cells.get(&format!("{heading}{turn}")))
            };
            cell.or_else(group).map(|cell| number(cell, record)).transpose()
        };
        let at = format!("node {id}, {heading}");
        let is_metric = self.tables.is_metric();
        let speed_mph = match of("speed", id, heading)?.filter(|speed| *speed > 0.0) {
            Some(speed) if is_metric => speed * KMH_TO_MPH,
            Some(speed) => speed,
            None => {
                said.no_speed.push(at.clone());
                DEFAULT_MPH
            }
        };
        let mut length = of("distance", id, heading)?.filter(|length| *length > 0.0);
        let (mut node, mut along) = (id.to_owned(), heading);
        for _ in 0..MOST_BENDS {
            let Some(next) = self.up(&node, along) else { break };
            if self.tables.nodes.iter().find(|n| n.id == next).and_then(|n| n.kind) != Some(2) {
                break;
            }
            // Of the two links of a bend the one that does not come back.
            let Some(on) =
                Heading::ALL.into_iter().find(|h| self.up(&next, *h).is_some_and(|up| up != node))
            else {
                break;
            };
            length = length.zip(of("distance", &next, on)?).map(|(a, b)| a + b).or(length);
            (node, along) = (next, on);
        }
        let length_m = match length {
            Some(length) if is_metric => length,
            Some(length) => length * FOOT_M,
            None => {
                said.no_length.push(at.clone());
                DEFAULT_FT * FOOT_M
            }
        };
        if length_m < MIN_LENGTH_M {
            said.short.push(format!("{at}: {length_m:.0} m"));
        }
        if speed_mph > MOST_MPH || length_m > MOST_LENGTH_M {
            let key = ("speed".to_owned(), id.to_owned());
            let spot = self
                .tables
                .links
                .get(&key)
                .and_then(|c| c.get(heading.name()))
                .map_or(START, |c| c.spot);
            let message = format!(
                "node {id}, {heading}: {speed_mph:.0} mph over {length_m:.0} m: expected at most {MOST_MPH} mph and \
                 {MOST_LENGTH_M} m"
            );
            return Err(Fault::new(spot, message));
        }
        let tenth = |value: f64| (value * 10.0).round() / 10.0;
        Ok((tenth(length_m.max(MIN_LENGTH_M)), tenth(speed_mph)))
    }

    /// Returns the node from which a link comes.
    fn up(&self, id: &str, heading: Heading) -> Option<String> {
        let cells = self.tables.links.get(&("up id".to_owned(), id.to_owned()))?;
        cells.get(heading.name()).map(|cell| cell.text.clone())
    }

    /// Returns the lanes from a signal to the node that the approach with a heading comes from.
    fn lanes_out(
        &self,
        (id, heading): (&str, Heading),
        other: &str,
        movements: &[Movement],
        said: &mut Said,
    ) -> Result<u32, Fault> {
        let lanes = self.tables.links.get(&("lanes".to_owned(), other.to_owned()));
        let back = Heading::ALL.into_iter().find(|h| self.up(other, *h).as_deref() == Some(id));
        if let (Some(cells), Some(back)) = (lanes, back) {
            return cells.get(back.name()).map_or(Ok(0), |cell| whole(cell, "lanes"));
        }
        let into: Vec<&Movement> =
            movements.iter().filter(|m| m.to.as_deref() == Some(other)).collect();
        let exits = self.tables.lanes.get(&("exit lanes".to_owned(), id.to_owned()));
        let mut most = 0;
        for m in &into {
            if let Some(cell) = exits.and_then(|cells| cells.get(&m.column)) {
                most = most.max(whole(cell, "exit lanes")?);
            }
        }
        if movements.iter().all(|m| m.to.is_none()) {
            // Nothing says where movements lead: the way straight on of the other direction ends here.
            said.no_way_back.push(format!("node {id}, {heading}"));
            let against =
                Heading::ALL[(heading as usize + Heading::ALL.len() / 2) % Heading::ALL.len()];
            let ahead = |m: &&Movement| m.heading == against && m.turn == Turn::Through;
            return Ok(movements.iter().filter(ahead).map(|m| m.lanes).sum::<u32>().max(1));
        }
        let widest = into.iter().map(|m| m.lanes).max().unwrap_or_default();
        Ok(if most > 0 { most } else { widest.max(u32::from(!into.is_empty())) })
    }

    /// Returns the movements of an intersection.
    fn movements(&self, id: &str) -> Result<Vec<Movement>, Fault> {
        let of = |records: &Records, name: &str| -> Cells {
            records.get(&(name.to_owned(), id.to_owned())).cloned().unwrap_or_default()
        };
        let [lanes, shared, to, volumes, growth, factors, heavy, peds, storage, in_bay] = [
            "lanes", "shared", "dest node", "volume", "growth", "phf", "heavyvehicles", "peds",
            "storage", "stlanes",
        ]
        .map(|name| of(&self.tables.lanes, name));
        let unit_m = if self.tables.is_metric() { 1.0 } else { FOOT_M };
        let default = |name: &str| self.tables.of_network(name);
        let columns: BTreeSet<&String> =
            lanes.keys().chain(volumes.keys()).chain(to.keys()).collect();
        let mut movements = Vec::new();
        for column in columns {
            let Some((heading, turn)) = Heading::of_movement(column, self.side) else { continue };
            let optional = |cells: &Cells, name: &str| {
                cells.get(column).map(|cell| number(cell, name)).transpose()
            };
            let count = |cells: &Cells, name: &str| {
                cells.get(column).map_or(Ok(0), |cell| whole(cell, name))
            };
            let range = |cells: &Cells, name: &str, low: f64, high: f64| {
                let value = optional(cells, name)?;
                match value.filter(|value| !(low..=high).contains(value)) {
                    None => Ok(value),
                    Some(value) => {
                        let spot = cells.get(column).map_or(START, |cell| cell.spot);
                        let message = format!(
                            "{name} of {column} = {value}: expected a number from {low} to {high}"
                        );
                        Err(Fault::new(spot, message))
                    }
                }
            };
            let growth_percent = range(&growth, "growth", 0.0, 1000.0)?;
            let growth = growth_percent.map(|percent| percent / 100.0);
            let growth = growth.or_else(|| default("growth")).unwrap_or(1.0);
            let volume = range(&volumes, "volume", 0.0, MOST_VPH)?;
            let factor =
                range(&factors, "phf", MIN_PEAK_HOUR_FACTOR, 1.0)?.or_else(|| default("phf"));
            let heavy_percent = range(&heavy, "heavyvehicles", 0.0, 100.0)?;
            let pedestrians_per_h = range(&peds, "peds", 0.0, MOST_PEDESTRIANS_PER_H)?;
            let bay_m =
                range(&storage, "storage", 0.0, MOST_LENGTH_M)?.map(|length| length * unit_m);
            let in_bay = in_bay.get(column).map(|cell| whole(cell, "stlanes")).transpose()?;
            movements.push(Movement {
                storage: bay_m
                    .filter(|m| *m > 0.0 && in_bay != Some(0))
                    .map(|m| ((m * 10.0).round() / 10.0, in_bay)),
                column: column.clone(),
                heading,
                turn,
                lanes: count(&lanes, "lanes")?,
                shared: count(&shared, "shared")?,
                to: to.get(column).map(|cell| cell.text.clone()),
                volume_vph: volume.unwrap_or_default() * growth,
                is_counted: volume.is_some(),
                growth_percent,
                peak_hour_factor: factor
                    .filter(|factor| (MIN_PEAK_HOUR_FACTOR..=1.0).contains(factor)),
                heavy: heavy_percent
                    .map(|percent| percent / 100.0)
                    .or_else(|| default("hv"))
                    .filter(|share| (0.0..=1.0).contains(share)),
                heavy_percent,
                pedestrians_per_h,
            });
        }
        Ok(movements)
    }

    /// Returns what of the file is not used.
    fn unused(&self) -> Option<Doubt> {
        let tables = &self.tables;
        let is_read = |name: &String| {
            READ.contains(&name.as_str()) || super::plans::READ.contains(&name.as_str())
        };
        let streets = tables.links.keys().chain(tables.lanes.keys());
        let timing = tables.phases.keys().chain(tables.timeplans.keys());
        let mut names: BTreeSet<String> = streets
            .chain(timing)
            .map(|(name, _)| name.clone())
            .filter(|name| !is_read(name))
            .collect();
        names.extend(tables.unknown.iter().cloned());
        let names: Vec<String> = names.into_iter().collect();
        (!names.is_empty())
            .then(|| Doubt::whole(format!("records that are not used: {}", names.join(", "))))
    }
}

/// Where the movements of an approach lead.
struct Ways<'a> {
    /// Node that it comes from.
    own: &'a str,
    /// Nodes of all arms.
    ids: &'a [&'a str],
    /// Exits by their arms.
    exits: Vec<(usize, Turn)>,
}

impl Ways<'_> {
    /// Returns the turn of a movement: that of its destination where it has one, else that of its name; `None` where
    /// no exit has it. U-turns count as left turns.
    fn turn(&self, m: &Movement) -> Option<Turn> {
        let named = |turn: Turn| self.exits.iter().find(|(_, t)| *t == turn).map(|(_, turn)| *turn);
        match &m.to {
            Some(to) if to != self.own => {
                let arm = self.ids.iter().position(|id| id == to)?;
                self.exits.iter().find(|(exit, _)| *exit == arm).map(|(_, turn)| *turn)
            }
            Some(_) => named(Turn::Left),
            None => named(m.turn),
        }
    }

    /// Returns the exits of a movement, as positions in [`Self::exits`]: that of its destination, else all of its turn. A
    /// U-turn has the first exit of its turn.
    fn exits_of(&self, m: &Movement) -> Vec<usize> {
        let Some(turn) = self.turn(m) else { return Vec::new() };
        let of_turn: Vec<usize> =
            (0..self.exits.len()).filter(|exit| self.exits[*exit].1 == turn).collect();
        let Some(to) = &m.to else { return of_turn };
        let leads_there = |exit: &usize| self.ids[self.exits[*exit].0] == to;
        let there = of_turn.iter().copied().find(leads_there);
        there.or_else(|| of_turn.first().copied()).into_iter().collect()
    }

    /// Returns the vehicles per hour of movements by exit, and the turns whose vehicles several exits divide equally.
    fn by_exit(&self, own: &[&Movement]) -> ([f64; MOST_EXITS], BTreeMap<Turn, f64>) {
        let mut exits_vph = [0.0; MOST_EXITS];
        let mut divided: BTreeMap<Turn, f64> = BTreeMap::new();
        for m in own.iter().filter(|m| m.volume_vph > 0.0) {
            let exits = self.exits_of(m);
            for exit in &exits {
                // More exits than a network may have are refused with the intersection.
                if let Some(vph) = exits_vph.get_mut(*exit) {
                    *vph += m.volume_vph / exits.len() as f64;
                }
            }
            if let Some(turn) = self.turn(m).filter(|_| exits.len() > 1) {
                *divided.entry(turn).or_default() += m.volume_vph;
            }
        }
        (exits_vph, divided)
    }

    /// Whether several exits have a turn.
    fn has_several(&self, turn: Turn) -> bool {
        self.exits.iter().filter(|(_, t)| *t == turn).count() > 1
    }
}

impl Movement {
    /// Whether it leaves by the street with an index, by its destination or else by the compass.
    fn leads_to(&self, up: &[(Heading, &Cell)], street: usize) -> bool {
        let (heading, cell) = &up[street];
        let eighths = match self.turn {
            Turn::Left => 2,
            Turn::Through => 4,
            Turn::Right => 6,
        };
        match &self.to {
            Some(to) => *to == cell.text,
            None => {
                Heading::ALL[(self.heading as usize + eighths) % Heading::ALL.len()] == *heading
            }
        }
    }
}

/// Checks that the table of approaches may have the arms of an intersection.
fn check_rows(intersection: &Intersection) -> Result<(), String> {
    let Intersection { id, arms, .. } = intersection;
    if arms.iter().all(|arm| arm.lanes_in == 0) {
        return Err(format!("node {id} has no incoming lane"));
    }
    for arm in arms {
        approaches::check(arm).map_err(|why| format!("node {id}, {}: {why}", arm.arm))?;
    }
    check_arms(intersection)
}

/// Returns two directions that are nearly the same.
fn too_near(bearings: &[f64]) -> Option<(usize, usize)> {
    (0..bearings.len()).find_map(|i| {
        let near = |j: &usize| turn_degrees(bearings[*j], bearings[i]).abs() < MIN_ANGLE_DEG;
        (0..i).find(near).map(|j| (j, i))
    })
}

/// Gives an arm the movements of its lane groups and their volumes.
fn give(arm: &mut Approach, own: &[&Movement], ways: &Ways<'_>, said: &mut Said) {
    let at = format!("node {}", arm.intersection);
    let lost = |m: &Movement| format!("{at} {}: {:.0} veh/h", m.column, m.volume_vph);
    if arm.lanes_in == 0 {
        said.no_exit.extend(own.iter().filter(|m| m.volume_vph > 0.0).map(|m| lost(m)));
        return;
    }
    let shares = |m: &Movement| {
        let beside = own.iter().find(|other| other.lanes > 0 && other.turn == Turn::Through);
        let beside =
            beside.or_else(|| own.iter().find(|other| other.lanes > 0 && other.turn == Turn::Left));
        beside.is_some_and(|b| match m.turn {
            Turn::Left => b.shared & 1 == 1,
            Turn::Through => false,
            Turn::Right => b.shared & 2 == 2,
        })
    };
    let mut volumes: BTreeMap<Turn, f64> = BTreeMap::new();
    let mut letters = BTreeSet::new();
    let (mut peaks, mut heavy, mut total) = (0.0, 0.0, 0.0);
    for m in own.iter().filter(|m| m.lanes > 0 || m.volume_vph > 0.0 || shares(m)) {
        let Some(turn) = ways.turn(m) else {
            if m.volume_vph > 0.0 {
                said.no_exit.push(lost(m));
            }
            continue;
        };
        if turn != m.turn {
            said.renamed.push(format!("{at} {} is {}", m.column, turn.name()));
        }
        if m.lanes == 0 && m.volume_vph > 0.0 && !shares(m) {
            said.no_lane.push(lost(m));
        }
        letters.insert(letter(turn));
        *volumes.entry(turn).or_default() += m.volume_vph;
        total += m.volume_vph;
        peaks += m.volume_vph / m.peak_hour_factor.unwrap_or(1.0);
        heavy += m.volume_vph * m.heavy.unwrap_or_default();
    }
    let (exits_vph, divided) = ways.by_exit(own);
    for (turn, volume) in &divided {
        said.several_exits.push(format!("{at} {} {}: {volume:.0} veh/h", arm.arm, turn.name()));
    }
    let several = volumes.iter().any(|(turn, vph)| *vph > 0.0 && ways.has_several(*turn));
    arm.movements = ['l', 's', 'r'].into_iter().filter(|letter| letters.contains(letter)).collect();
    let vph = |turn| volumes.get(&turn).copied().unwrap_or_default();
    let has_factor = own.iter().any(|m| m.peak_hour_factor.is_some()) && total > 0.0;
    let has_heavy = own.iter().any(|m| m.heavy.is_some()) && total > 0.0;
    arm.counted = Some(Counted {
        left_vph: vph(Turn::Left),
        through_vph: vph(Turn::Through),
        right_vph: vph(Turn::Right),
        arrivals: has_factor.then(|| Arrivals::PeakHourFactor((total / peaks * 1e4).round() / 1e4)),
        heavy_vehicles: has_heavy.then(|| (heavy / total * 1e4).round() / 1e4),
        pedestrians_per_h: None,
        exits_vph: several.then_some(exits_vph),
    });
}

/// Returns the letter of a turn in the table of approaches.
fn letter(turn: Turn) -> char {
    match turn {
        Turn::Left => 'l',
        Turn::Through => 's',
        Turn::Right => 'r',
    }
}

pub(super) fn number(cell: &Cell, record: &str) -> Result<f64, Fault> {
    let number = cell.text.parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| {
        Fault::new(cell.spot, format!("{record} = {:?}: expected a number", cell.text))
    })
}

fn whole(cell: &Cell, record: &str) -> Result<u32, Fault> {
    let number = number(cell, record)?;
    match number.fract() == 0.0 && (0.0..=f64::from(MAX_LANES)).contains(&number) {
        true => Ok(number as u32),
        false => Err(Fault::new(
            cell.spot,
            format!("{record} = {number}: expected a whole number from 0 to {MAX_LANES}"),
        )),
    }
}

impl Said {
    /// Says what is doubtful about the volumes of a signal.
    fn volumes(&mut self, id: &str, movements: &[Movement]) {
        let is_factor = |growth: &f64| *growth > 0.0 && *growth < LEAST_GROWTH_PERCENT;
        let is_share = |percent: &f64| *percent > 0.0 && *percent < LEAST_HEAVY_PERCENT;
        for m in movements {
            if let Some(percent) = m.heavy_percent.filter(is_share) {
                self.heavy.push(format!("node {id} {}: {percent}", m.column));
            }
            if let Some(growth) = m.growth_percent.filter(is_factor) {
                self.growth.push(format!("node {id} {}: {growth}", m.column));
            }
        }
        if !movements.iter().any(|m| m.is_counted) {
            return;
        }
        let not_counted = movements.iter().filter(|m| m.lanes > 0 && !m.is_counted);
        self.no_volume.extend(not_counted.map(|m| format!("node {id} {}", m.column)));
        let total: f64 = movements.iter().map(|m| m.volume_vph).sum();
        if total < FEW_VEHICLES {
            self.few.push(format!("node {id}: {total:.1} veh/h"));
        }
    }

    fn doubts(self) -> Vec<Doubt> {
        let doubts = [
            ("signals that cannot be simulated are left out", self.left_out),
            ("links without a speed get 30 mph", self.no_speed),
            ("links without a distance get 1000 ft", self.no_length),
            ("approaches shorter than 25 m are made so long", self.short),
            ("nodes without coordinates: directions of travel give the bearings", self.no_place),
            (
                "links come from nodes that the network does not have: directions of travel give the bearings; correct Up ID",
                self.no_node,
            ),
            (
                "neither links nor destinations say how many lanes lead away: as many as go straight on from the opposite \
                 side, at least one",
                self.no_way_back,
            ),
            (
                "movements have no exit or no lanes, and their vehicles are not simulated",
                self.no_exit,
            ),
            (
                "a through lane that also turns left beside lanes for left turns is simulated as through only",
                self.shared_left,
            ),
            (
                "turns with several exits divide their vehicles equally among them",
                self.several_exits,
            ),
            (
                "movements lead elsewhere than their names say, by the coordinates of nodes; lanes and volumes follow the \
                 coordinates",
                self.renamed,
            ),
            (
                "volumes of movements without a lane and without a shared one use the other lanes",
                self.no_lane,
            ),
            ("a lane that left and right turns share serves right turns only", self.shared_right),
            (
                "storage lengths of movements without turn lanes of their own, or out of range, are not used",
                self.no_bay,
            ),
            (
                "bays have fewer lanes than turn there; all lanes of the turn are as long as the bay",
                self.part_of_bay,
            ),
            ("nodes of one controller are simulated apart", self.one_controller),
            (
                "growth is percent here (100 = none); if it is a factor, multiply it by 100",
                self.growth,
            ),
            (
                "HeavyVehicles is percent and below 1 here; if these are shares, multiply them by 100",
                self.heavy,
            ),
            (
                "signals have hardly any vehicle; volumes may be shares or in thousands, or growth a factor",
                self.few,
            ),
            (
                "movements that have lanes were not counted, and have no vehicles; write 0 where nobody drives",
                self.no_volume,
            ),
            (NO_PLAN, self.no_plan),
            (HALF_WALK, self.half_walk),
        ];
        doubts.into_iter().filter_map(|(about, rows)| Doubt::of(about, rows)).collect()
    }
}
