//! From UTDF to intersections with approaches and volumes.
//!
//! - **Arms** are called after the direction of travel and the street, such as `NB Main St`. They are the
//!   links of a signal, in the direction of the node at their other end. The names of directions are those of the file and
//!   need not agree with the compass. A node that is a bend belongs to the street: its length
//!   goes on to the next node.
//! - **Lanes** are those of the lane groups. Lanes of a left or right group are turn lanes where a through group exists.
//!   Lanes that lead away are those of the link in the other direction, or as many as the movements into it have exits.
//! - **Volumes** are those of the file times its growth, with the peak hour factor and the heavy vehicles of its
//!   movements. A movement is the turn that leads to its destination. Deviation: of several destinations to one side
//!   each gets the same share.
//! - **Control** is read elsewhere; a free right turn is a lane at the signal.

use std::collections::{BTreeMap, BTreeSet};

use osm_signals::Turn;
use osm_signals::turn::exits;
use sheet::Fault;

use super::Utdf;
use super::tables::{Cell, Cells, Node, Records};
use crate::family::approaches::{Approach, Arrivals, Counted, Intersection, check_arms, gathered};
use crate::family::doubts::Doubt;
use crate::turning::header::Heading;
use basics::units::{FOOT_M, KMH_TO_MPH};
use evaluation::family::columns::at;
use evaluation::family::error::FamilyError;

/// Least length of an approach, metres.
const MIN_LENGTH_M: f64 = 25.0;

/// Speed where a link has none, miles per hour.
const DEFAULT_MPH: f64 = 30.0;

/// Length where a link has none, feet.
const DEFAULT_FT: f64 = 1000.0;

/// Most bends that a street goes through.
const MOST_BENDS: usize = 20;

/// Records that are read, in lower case.
const READ: [&str; 16] = [
    "up id",
    "lanes",
    "name",
    "distance",
    "speed",
    "up node",
    "dest node",
    "shared",
    "volume",
    "growth",
    "phf",
    "heavyvehicles",
    "exit lanes",
    "node 0",
    "node 1",
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
}

/// What is said of single intersections.
#[derive(Default)]
struct Said {
    no_speed: Vec<String>,
    no_length: Vec<String>,
    short: Vec<String>,
    no_place: Vec<String>,
    no_way_back: Vec<String>,
    no_exit: Vec<String>,
    shared_left: Vec<String>,
    left_out: Vec<String>,
    several_exits: Vec<String>,
    one_controller: Vec<String>,
}

/// A movement of a lane group.
struct Movement {
    column: String,
    heading: Heading,
    turn: Turn,
    lanes: u32,
    shared: u32,
    to: Option<String>,
    volume_vph: f64,
    peak_hour_factor: Option<f64>,
    heavy: Option<f64>,
}

impl Utdf {
    /// Returns the signals of the network as intersections with approaches and volumes.
    ///
    /// # Errors
    ///
    /// [`FamilyError::Csv`] with file and line: a cell that is no number, a network without signals.
    pub fn intersections(&self) -> Result<Converted, FamilyError> {
        let mut said = Said::default();
        let mut rows = Vec::new();
        let mut with_volumes = 0;
        let signals: Vec<&Node> =
            self.tables.nodes.iter().filter(|node| self.is_signal(node)).collect();
        for node in &signals {
            let made = self.signal(node, &mut said).map_err(|fault| at(&self.file, fault))?;
            let Some(arms) = made else { continue };
            let total: f64 = arms.iter().filter_map(|a| a.counted).map(|c| c.total_vph()).sum();
            with_volumes += usize::from(total > 0.0);
            let intersection = gathered(arms).remove(0);
            if let Err(why) = check_arms(&intersection) {
                said.left_out.push(why);
                continue;
            }
            rows.push(intersection);
        }
        if rows.is_empty() {
            let mut message = format!(
                "none of the {} nodes is a signal that can be simulated",
                self.tables.nodes.len()
            );
            for why in said.left_out.iter().take(3) {
                message = format!("{message}; {why}");
            }
            return Err(at(&self.file, Fault { line: 1, message }));
        }
        let found = vec![format!(
            "UTDF: {} of {} signals, {with_volumes} with volumes; {} nodes",
            rows.len(),
            signals.len(),
            self.tables.nodes.len()
        )];
        let mut doubts = said.doubts();
        doubts.extend(self.unused());
        Ok(Converted { intersections: rows, found, doubts })
    }

    /// Whether a node is a signal: its type says so, or it has timing.
    fn is_signal(&self, node: &Node) -> bool {
        match node.kind {
            Some(kind) => kind == 0,
            None => self.tables.phases.keys().any(|(_, id)| *id == node.id),
        }
    }

    /// Returns the rows of a signal; `None` if it is left out.
    fn signal(&self, node: &Node, said: &mut Said) -> Result<Option<Vec<Approach>>, Fault> {
        let id = &node.id;
        let none = Cells::new();
        let link =
            |record: &str| self.tables.links.get(&(record.to_owned(), id.clone())).unwrap_or(&none);
        let up: Vec<(Heading, &Cell)> =
            Heading::ALL.iter().filter_map(|h| Some((*h, link("up id").get(h.name())?))).collect();
        let movements = self.movements(id)?;
        if up.len() < 2 || movements.is_empty() {
            let what = if movements.is_empty() { "no lanes" } else { "fewer than two links" };
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
        let mut arms = Vec::new();
        for (heading, other) in &up {
            let bearing_deg = self.bearing_deg(node, &other.text).unwrap_or_else(|| {
                said.no_place.push(format!("node {id}, {heading}"));
                heading.degrees() + 180.0
            });
            let own: Vec<&Movement> = movements.iter().filter(|m| m.heading == *heading).collect();
            let lanes =
                |turn: Turn| own.iter().filter(|m| m.turn == turn).map(|m| m.lanes).sum::<u32>();
            let [left, through, right] = [Turn::Left, Turn::Through, Turn::Right].map(lanes);
            if through > 0
                && left > 0
                && own.iter().any(|m| m.turn == Turn::Through && m.shared & 1 == 1)
            {
                said.shared_left.push(format!("node {id}, {heading}"));
            }
            // Without a through group the lanes that left and right share are neither.
            let is_shared = own.iter().any(|m| m.turn == Turn::Left && m.shared & 2 == 2);
            let (left, right) = match through {
                0 if is_shared => (left.saturating_sub(1), right),
                _ => (left, right),
            };
            let lanes_in = own.iter().map(|m| m.lanes).sum();
            let street = link("name").get(heading.name()).map_or("", |cell| cell.text.as_str());
            let words = std::iter::once(heading.name()).chain(street.split_whitespace());
            let (length_m, speed_mph) = self.length_and_speed(id, *heading, said)?;
            arms.push(Approach {
                intersection: id.clone(),
                arm: words.collect::<Vec<_>>().join(" "),
                latitude: f64::NAN,
                longitude: f64::NAN,
                bearing_deg: (bearing_deg.rem_euclid(360.0) * 10.0).round() / 10.0 % 360.0,
                lanes_in,
                lanes_out: self.lanes_out((id, *heading), &other.text, &movements, said)?,
                left_turn_lanes: left,
                right_turn_lanes: right,
                speed_mph,
                length_m,
                aadt_veh_per_day_per_lane: 0.0,
                movements: String::new(),
                period: String::new(),
                counted: None,
                line: other.line,
                imputed: false,
            });
        }
        let ids: Vec<&str> = up.iter().map(|(_, cell)| cell.text.as_str()).collect();
        let bearings: Vec<f64> = arms.iter().map(|a| a.bearing_deg).collect();
        let leads_away: Vec<bool> = arms.iter().map(|a| a.lanes_out > 0).collect();
        for (i, (heading, _)) in up.iter().enumerate() {
            let own: Vec<&Movement> = movements.iter().filter(|m| m.heading == *heading).collect();
            let others = (0..arms.len()).filter(|j| *j != i && leads_away[*j]);
            let ways = exits(bearings[i], others.map(|j| (j, bearings[j])));
            self.give(&mut arms[i], &own, &ways, &ids, said);
        }
        Ok(Some(arms))
    }

    /// Gives an arm the movements of its lane groups and their volumes.
    fn give(
        &self,
        arm: &mut Approach,
        own: &[&Movement],
        ways: &[(usize, Turn)],
        ids: &[&str],
        said: &mut Said,
    ) {
        if arm.lanes_in == 0 {
            return;
        }
        let at = format!("node {}", arm.intersection);
        // Where a movement leads by its destination, else by its name.
        let way = |m: &Movement| {
            let to = m.to.as_deref().and_then(|to| ids.iter().position(|id| *id == to));
            match to {
                Some(to) => ways.iter().find(|(exit, _)| *exit == to).map(|(_, turn)| *turn),
                None => ways.iter().find(|(_, turn)| *turn == m.turn).map(|(_, turn)| *turn),
            }
        };
        let takes = |m: &Movement| {
            let beside = own.iter().find(|other| other.lanes > 0 && other.turn == Turn::Through);
            let beside = beside
                .or_else(|| own.iter().find(|other| other.lanes > 0 && other.turn == Turn::Left));
            let shares = beside.is_some_and(|b| match m.turn {
                Turn::Left => b.shared & 1 == 1,
                Turn::Through => false,
                Turn::Right => b.shared & 2 == 2,
            });
            m.lanes > 0 || m.volume_vph > 0.0 || shares
        };
        let mut volumes: BTreeMap<Turn, f64> = BTreeMap::new();
        let mut letters = BTreeSet::new();
        let (mut peaks, mut heavy, mut total) = (0.0, 0.0, 0.0);
        for m in own.iter().filter(|m| takes(m)) {
            let Some(turn) = way(m) else {
                if m.volume_vph > 0.0 {
                    said.no_exit.push(format!("{at} {}: {:.0} veh/h", m.column, m.volume_vph));
                }
                continue;
            };
            letters.insert(match turn {
                Turn::Left => 'l',
                Turn::Through => 's',
                Turn::Right => 'r',
            });
            *volumes.entry(turn).or_default() += m.volume_vph;
            total += m.volume_vph;
            peaks += m.volume_vph / m.peak_hour_factor.unwrap_or(1.0);
            heavy += m.volume_vph * m.heavy.unwrap_or_default();
        }
        for (turn, volume) in &volumes {
            let to: BTreeSet<&str> = own
                .iter()
                .filter(|m| m.volume_vph > 0.0 && way(m) == Some(*turn))
                .filter_map(|m| m.to.as_deref())
                .collect();
            if to.len() > 1 {
                said.several_exits.push(format!("{at} {}: {volume:.0} veh/h", arm.arm));
            }
        }
        arm.movements =
            ['l', 's', 'r'].into_iter().filter(|letter| letters.contains(letter)).collect();
        let vph = |turn| volumes.get(&turn).copied().unwrap_or_default();
        let has_factor = own.iter().any(|m| m.peak_hour_factor.is_some()) && total > 0.0;
        let has_heavy = own.iter().any(|m| m.heavy.is_some()) && total > 0.0;
        arm.counted = Some(Counted {
            left_vph: vph(Turn::Left),
            through_vph: vph(Turn::Through),
            right_vph: vph(Turn::Right),
            arrivals: has_factor
                .then(|| Arrivals::PeakHourFactor((total / peaks * 1e4).round() / 1e4)),
            heavy_vehicles: has_heavy.then(|| (heavy / total * 1e4).round() / 1e4),
        });
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
        let [lanes, shared, to, volumes, growth, factors, heavy] =
            ["lanes", "shared", "dest node", "volume", "growth", "phf", "heavyvehicles"]
                .map(|name| of(&self.tables.lanes, name));
        let default =
            |name: &str| self.tables.network.get(name).and_then(|v| v.parse::<f64>().ok());
        let columns: BTreeSet<&String> =
            lanes.keys().chain(volumes.keys()).chain(to.keys()).collect();
        let mut movements = Vec::new();
        for column in columns {
            let Some((heading, turn)) = movement(column) else { continue };
            let optional = |cells: &Cells, name: &str| {
                cells.get(column).map(|cell| number(cell, name)).transpose()
            };
            let count = |cells: &Cells, name: &str| {
                cells.get(column).map_or(Ok(0), |cell| whole(cell, name))
            };
            let growth = optional(&growth, "growth")?.map(|percent| percent / 100.0);
            let growth = growth.or_else(|| default("growth")).unwrap_or(1.0);
            let volume = optional(&volumes, "volume")?.unwrap_or_default();
            let factor = optional(&factors, "phf")?.or_else(|| default("phf"));
            let percent = optional(&heavy, "heavyvehicles")?.map(|percent| percent / 100.0);
            movements.push(Movement {
                column: column.clone(),
                heading,
                turn,
                lanes: count(&lanes, "lanes")?,
                shared: count(&shared, "shared")?,
                to: to.get(column).map(|cell| cell.text.clone()),
                volume_vph: volume * growth,
                peak_hour_factor: factor.filter(|factor| (0.25..=1.0).contains(factor)),
                heavy: percent
                    .or_else(|| default("hv"))
                    .filter(|share| (0.0..=1.0).contains(share)),
            });
        }
        Ok(movements)
    }

    /// Returns what of the file is not used.
    fn unused(&self) -> Option<Doubt> {
        let tables = &self.tables;
        let records = tables.links.keys().chain(tables.lanes.keys()).map(|(name, _)| name.clone());
        let mut names: BTreeSet<String> =
            records.filter(|name| !READ.contains(&name.as_str())).collect();
        names.extend(tables.unknown.iter().cloned());
        if !tables.phases.is_empty() {
            names.insert("[Phases]".to_owned());
        }
        if !tables.timeplans.is_empty() {
            names.insert("[Timeplans]".to_owned());
        }
        let names: Vec<String> = names.into_iter().collect();
        (!names.is_empty())
            .then(|| Doubt::whole(format!("records that are not used: {}", names.join(", "))))
    }
}

/// Returns the direction and the turn of a movement's column; `None` for one that is no movement.
fn movement(column: &str) -> Option<(Heading, Turn)> {
    let heading = Heading::ALL.into_iter().find(|h| column.starts_with(h.name()))?;
    let turn = match &column[heading.name().len()..] {
        "L" | "L2" | "U" => Turn::Left,
        "T" => Turn::Through,
        "R" | "R2" => Turn::Right,
        _ => return None,
    };
    Some((heading, turn))
}

fn number(cell: &Cell, record: &str) -> Result<f64, Fault> {
    let number = cell.text.parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| {
        Fault::new(cell.line, format!("{record} = {:?}: expected a number", cell.text))
    })
}

fn whole(cell: &Cell, record: &str) -> Result<u32, Fault> {
    let number = number(cell, record)?;
    match number.fract() == 0.0 && (0.0..=99.0).contains(&number) {
        true => Ok(number as u32),
        false => Err(Fault::new(
            cell.line,
            format!("{record} = {number}: expected a whole number from 0 to 99"),
        )),
    }
}

impl Said {
    fn doubts(self) -> Vec<Doubt> {
        let doubts = [
            ("signals that cannot be simulated are left out", self.left_out),
            ("links without a speed get 30 mph", self.no_speed),
            ("links without a distance get 1000 ft", self.no_length),
            ("approaches shorter than 25 m are made so long", self.short),
            ("nodes without coordinates: directions of travel give the bearings", self.no_place),
            (
                "neither links nor destinations say how many lanes lead away: as many as go straight on from the opposite \
                 side, at least one",
                self.no_way_back,
            ),
            ("movements have no exit, and their vehicles are not simulated", self.no_exit),
            (
                "a through lane that also turns left beside lanes for left turns is simulated as through only",
                self.shared_left,
            ),
            (
                "a turn with several destinations divides its vehicles equally among them",
                self.several_exits,
            ),
            ("nodes of one controller are simulated apart", self.one_controller),
        ];
        doubts.into_iter().filter_map(|(about, rows)| Doubt::of(about, rows)).collect()
    }
}
