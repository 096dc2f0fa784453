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
use sheet::Fault;

use super::{Cell, Node, START, Utdf};

use crate::existing::{NamedPlan, Plans};
use crate::family::approaches::{
    self, Approach, Arrivals, Counted, Intersection, MOST_EXITS, MOST_PEDESTRIANS_PER_H, MOST_VPH,
    check_arms, gathered,
};
use crate::family::doubts::{Doubt, Said};
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

/// Least growth and share of heavy vehicles, percent: what is less is a factor or a share.
const LEAST_GROWTH_PERCENT: f64 = 10.0;
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

/// Names of the movements of a signal by the columns of its lane groups; none of those that lead nowhere.
pub(super) type Names = BTreeMap<String, (Heading, Turn)>;

/// Most bends that a street goes through.
const MOST_BENDS: usize = 20;

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

/// Why a signal or its plan is no part of what is made.
pub(super) enum Stop {
    /// It cannot be simulated, and the others can.
    LeftOut(String),
    /// The file is wrong.
    Wrong(Fault),
}

impl From<Fault> for Stop {
    fn from(fault: Fault) -> Self {
        Self::Wrong(fault)
    }
}

impl From<String> for Stop {
    fn from(why: String) -> Self {
        Self::LeftOut(why)
    }
}

/// A movement of a lane group.
struct Movement<'a> {
    column: &'a str,
    heading: Heading,
    turn: Turn,
    lanes: u32,
    shared: u32,
    to: Option<&'a str>,
    /// Volume times growth; 0 where the file has no volume.
    volume_vph: f64,
    /// Whether the file has a volume.
    is_counted: bool,
    peak_hour_factor: Option<f64>,
    heavy: Option<f64>,
    /// People per hour who cross where it leaves.
    pedestrians_per_h: Option<f64>,
    /// Length of its bay, metres, and how many of its lanes are in it.
    storage: Option<(f64, Option<u32>)>,
}

impl Utdf {
    /// Returns the signals of the network as intersections with approaches and volumes.
    pub fn intersections(&self) -> Result<Converted, FamilyError> {
        self.converted().map_err(|fault| self.wrong(fault))
    }

    fn converted(&self) -> Result<Converted, Fault> {
        let (mut said, mut why_not) = (Said::default(), Vec::new());
        let signals: Vec<&Node> = self.nodes.iter().filter(|n| self.is_signal(n)).collect();
        let mut plans = Plans { file: self.file.clone(), is_utdf: true, ..Plans::default() };
        let mut intersections = Vec::new();
        for node in &signals {
            let (intersection, names) = match self.signal(node, &mut said) {
                Ok(made) => made,
                Err(Stop::Wrong(fault)) => return Err(fault),
                Err(Stop::LeftOut(why)) => {
                    why_not.push(why);
                    continue;
                }
            };
            intersections.push(intersection);
            let (intersection, period, line) = (node.id.clone(), String::new(), node.line);
            match self.plan(&node.id, &names, &mut said) {
                Ok(None) => {}
                Ok(Some(plan)) => plans.all.push(NamedPlan { intersection, period, plan, line }),
                Err(Stop::Wrong(fault)) => return Err(fault),
                Err(Stop::LeftOut(why)) => said.say(NO_PLAN, format!("node {}: {why}", node.id)),
            }
        }
        let nodes = self.nodes.len();
        if intersections.is_empty() {
            let none = format!("none of the {nodes} nodes is a signal that can be simulated");
            let few = std::iter::once(none).chain(why_not.into_iter().take(3));
            return Err(Fault::new(START, few.collect::<Vec<_>>().join("; ")));
        }
        let of_plans = match plans.all.len() {
            0 => String::new(),
            count => format!(", {count} with a plan"),
        };
        let with_volumes = intersections.iter().filter(|i| volumes(i).any(|vph| vph > 0.0)).count();
        let found = vec![format!(
            "UTDF: {} of {} signals, {with_volumes} with volumes{of_plans}; {nodes} nodes",
            intersections.len(),
            signals.len(),
        )];
        let left_out = Doubt::of("signals that cannot be simulated are left out", why_not);
        let no_units = (!self.network.contains_key("metric")).then(|| {
            let about = "no Metric in [Network]: lengths are read as feet and speeds as mph; Metric,1 says metres and km/h";
            Doubt { about: about.to_owned(), rows: vec![self.file.clone()] }
        });
        let doubts = left_out.into_iter().chain(said.doubts()).chain(no_units).collect();
        Ok(Converted { intersections, found, doubts, plans })
    }

    /// Whether a node is a signal: its type says so, or it has timing.
    fn is_signal(&self, node: &Node) -> bool {
        let is_timed = || self.phases.0.values().any(|of| of.contains_key(&node.id));
        node.kind.map_or_else(is_timed, |kind| kind == 0)
    }

    fn node(&self, id: &str) -> Option<&Node> {
        self.nodes.iter().find(|node| node.id == id)
    }

    /// Returns a signal, and the movements that its columns are.
    fn signal(&self, node: &Node, said: &mut Said) -> Result<(Intersection, Names), Stop> {
        let id = node.id.as_str();
        let up: Vec<(Heading, &Cell)> = (Heading::ALL.into_iter())
            .filter_map(|h| Some((h, self.links.cell("up id", id, h.name())?)))
            .collect();
        let movements = self.movements(id, said)?;
        if up.len() < MIN_LINKS || movements.is_empty() {
            return Err(format!("node {id} has fewer than three links, or no lanes").into());
        }
        let first = self.timeplans.cell("node 1", id, "DATA").filter(|c| c.text != "0");
        if let Some(Cell { text, .. }) = first {
            let about = "nodes of one controller are simulated apart";
            said.say(about, format!("node {id} with {text}"));
        }
        let (mut bearings, mut lanes_out) = (Vec::new(), Vec::new());
        for (heading, other) in &up {
            let bearing_deg = self.bearing_deg(node, *heading, &other.text, said);
            bearings.push((bearing_deg.rem_euclid(360.0) * 10.0).round() / 10.0 % 360.0);
            lanes_out.push(self.lanes_out(id, &other.text, &movements)?);
        }
        if let Some((a, b)) = too_near(&bearings) {
            let (a, b) = (up[a].0, up[b].0);
            return Err(
                format!("node {id}: {a} and {b} come from nearly the same direction").into()
            );
        }
        let (mut arms, mut names) = (Vec::new(), Names::new());
        for (i, (heading, other)) in up.iter().enumerate() {
            let own: Vec<&Movement<'_>> =
                movements.iter().filter(|m| m.heading == *heading).collect();
            let others = (0..up.len()).filter(|j| *j != i && lanes_out[*j] > 0);
            let ways = Ways {
                own: &other.text,
                ids: up.iter().map(|(_, cell)| cell.text.as_str()).collect(),
                exits: exits_on(self.side, bearings[i], others.map(|j| (j, bearings[j]))),
            };
            let street = self.links.cell("name", id, heading.name());
            let words = street.map_or("", |cell| cell.text.as_str()).split_whitespace();
            let (length_m, speed_mph) = self.length_and_speed(id, *heading, said)?;
            let at = format!("node {id}, {heading}");
            let [left_turn_lanes, right_turn_lanes] = turn_lanes(&at, &own, &ways, said);
            let mut arm = Approach {
                intersection: id.to_owned(),
                arm: std::iter::once(heading.name()).chain(words).collect::<Vec<_>>().join(" "),
                latitude: f64::NAN,
                longitude: f64::NAN,
                bearing_deg: bearings[i],
                lanes_in: own.iter().map(|m| m.lanes).sum(),
                lanes_out: lanes_out[i],
                left_storage_m: None,
                right_storage_m: None,
                left_turn_lanes,
                right_turn_lanes,
                speed_mph,
                length_m,
                aadt_veh_per_day_per_lane: 0.0,
                movements: String::new(),
                period: String::new(),
                counted: None,
                line: other.line,
                imputed: false,
            };
            give(&mut arm, &own, &ways, said);
            // Both turns into a street meet the same people.
            let into = |m: &&Movement<'_>| m.turn != Turn::Through && m.leads_to(&up, i);
            let walk = movements.iter().filter(into).filter_map(|m| m.pedestrians_per_h);
            if let Some(counted) = &mut arm.counted {
                counted.pedestrians_per_h = walk.reduce(f64::max);
            }
            give_bays(&mut arm, &own, &ways, said);
            let exists = |turn: &Turn| arm.movements.contains(letter(*turn));
            let named = |m: &&Movement<'_>| {
                Some((m.column.to_owned(), (*heading, ways.turn(m).filter(exists)?)))
            };
            names.extend(own.iter().filter_map(named));
            arms.push(arm);
        }
        let lanes = arms.iter().map(|a| a.lanes_in.max(a.lanes_out)).max().unwrap_or_default();
        let intersection = gathered(arms).remove(0);
        let most_vph = volumes(&intersection).fold(0.0, f64::max);
        if lanes > MAX_LANES || most_vph > MOST_VPH {
            return Err(format!(
                "node {id} has {lanes} lanes in one direction and up to {most_vph:.0} veh/h; at most {MAX_LANES} and \
                 {MOST_VPH} are simulated"
            ).into());
        }
        if intersection.arms.iter().all(|arm| arm.lanes_in == 0) {
            return Err(format!("node {id} has no incoming lane").into());
        }
        for arm in &intersection.arms {
            approaches::check(arm).map_err(|why| format!("node {id}, {}: {why}", arm.arm))?;
        }
        check_arms(&intersection)?;
        Ok((intersection, names))
    }

    /// Returns the direction from a node to another, degrees clockwise from north.
    fn bearing_deg(&self, node: &Node, heading: Heading, other: &str, said: &mut Said) -> f64 {
        let way = node.at.zip(self.node(other).and_then(|other| other.at));
        let way = way.map(|((x, y), (to_x, to_y))| (to_x - x, to_y - y));
        if let Some((east, north)) = way.filter(|way| *way != (0.0, 0.0)) {
            return east.atan2(north).to_degrees();
        }
        let about = "links to nodes that have no coordinates, or that the network does not have: directions of travel give the \
                     bearings; correct Up ID, X and Y";
        said.say(about, format!("node {}, {heading}: node {other}", node.id));
        heading.degrees() + 180.0
    }

    /// Returns the length of an approach in metres, through bends, and its speed in miles per hour.
    fn length_and_speed(
        &self,
        id: &str,
        heading: Heading,
        said: &mut Said,
    ) -> Result<(f64, f64), Fault> {
        let of = |record: &str, id: &str, heading: Heading| {
            self.links.number(record, id, heading.name())
        };
        let at = format!("node {id}, {heading}");
        let [unit_m, unit_mph] = self.units();
        let speed = of("speed", id, heading)?.filter(|speed| *speed > 0.0);
        let speed_mph = speed.map(|speed| speed * unit_mph).unwrap_or_else(|| {
            said.say("links without a speed get 30 mph", at.clone());
            DEFAULT_MPH
        });
        let mut length = of("distance", id, heading)?.filter(|length| *length > 0.0);
        let (mut node, mut along) = (id, heading);
        for _ in 0..MOST_BENDS {
            let next = self.up(node, along);
            let Some(next) = next.filter(|next| self.node(next).is_some_and(|n| n.kind == Some(2)))
            else {
                break;
            };
            // Of the two links of a bend the one that does not come back.
            let goes_on = |h: &Heading| self.up(next, *h).is_some_and(|up| up != node);
            let Some(on) = Heading::ALL.into_iter().find(goes_on) else { break };
            length = length.zip(of("distance", next, on)?).map(|(a, b)| a + b).or(length);
            (node, along) = (next, on);
        }
        let length_m = length.map(|length| length * unit_m).unwrap_or_else(|| {
            said.say("links without a distance get 1000 ft", at.clone());
            DEFAULT_FT * FOOT_M
        });
        if length_m < MIN_LENGTH_M {
            let about = "approaches shorter than 25 m are made so long";
            said.say(about, format!("{at}: {length_m:.0} m"));
        }
        if speed_mph > MOST_MPH || length_m > MOST_LENGTH_M {
            let own = self.links.cell("speed", id, heading.name());
            let message = format!(
                "{at}: {speed_mph:.0} mph over {length_m:.0} m: expected at most {MOST_MPH} mph and {MOST_LENGTH_M} m"
            );
            return Err(Fault::new(own.map_or(START, |cell| cell.line), message));
        }
        Ok((tenth(length_m.max(MIN_LENGTH_M)), tenth(speed_mph)))
    }

    /// Returns the node from which a link comes.
    fn up(&self, id: &str, heading: Heading) -> Option<&str> {
        self.links.cell("up id", id, heading.name()).map(|cell| cell.text.as_str())
    }

    /// Returns how many metres and miles per hour the units of the file are.
    fn units(&self) -> [f64; 2] {
        let is_metric = self.network.get("metric") == Some(&1.0);
        if is_metric { [1.0, KMH_TO_MPH] } else { [FOOT_M, 1.0] }
    }

    /// Returns the lanes from a signal to another node.
    fn lanes_out(&self, id: &str, other: &str, movements: &[Movement<'_>]) -> Result<u32, Fault> {
        let lanes = self.links.row("lanes", other);
        let back = Heading::ALL.into_iter().find(|h| self.up(other, *h) == Some(id));
        if let Some(back) = back.filter(|_| !lanes.is_empty()) {
            return whole(lanes.get(back.name()), "lanes");
        }
        let (mut exits, mut widest) = (0, 0);
        for m in movements.iter().filter(|m| m.to == Some(other)) {
            let own = self.lanes.cell("exit lanes", id, m.column);
            exits = whole(own, "exit lanes")?.max(exits);
            widest = m.lanes.max(widest).max(1);
        }
        Ok(if exits > 0 { exits } else { widest })
    }

    /// Returns the movements of an intersection, and says what is doubtful of their volumes.
    fn movements(&self, id: &str, said: &mut Said) -> Result<Vec<Movement<'_>>, Fault> {
        let [unit_m, _] = self.units();
        let default = |name: &str| self.network.get(name).copied();
        let named = ["lanes", "volume", "dest node"].map(|name| self.lanes.row(name, id));
        let columns: BTreeSet<&String> = named.iter().flat_map(|cells| cells.keys()).collect();
        let mut movements = Vec::new();
        for column in columns {
            let Some((heading, turn)) = Heading::of_movement(column, self.side) else { continue };
            let cell = |name: &str| self.lanes.cell(name, id, column);
            let range = |name: &str, low: f64, high: f64| {
                let Some(cell) = cell(name) else { return Ok(None) };
                let value = cell.number(name)?;
                if value == 0.0 || (low..=high).contains(&value) {
                    return Ok(Some(value));
                }
                let message = format!(
                    "{name} of {column} = {value}: expected 0, or a number from {low} to {high}"
                );
                Err(Fault::new(cell.line, message))
            };
            let percent = |name: &str, low: f64, high: f64, of_network: &str| {
                let share = range(name, low, high)?.map(|percent| percent / 100.0);
                Ok::<_, Fault>(share.or_else(|| default(of_network)))
            };
            let growth = percent("growth", LEAST_GROWTH_PERCENT, 1000.0, "growth")?;
            let volume = range("volume", 0.0, MOST_VPH)?;
            let factor = range("phf", MIN_PEAK_HOUR_FACTOR, 1.0)?.or_else(|| default("phf"));
            let in_bay = cell("stlanes").map(|c| whole(Some(c), "stlanes")).transpose()?;
            let bay_m = range("storage", 0.0, MOST_LENGTH_M)?.map(|length| length * unit_m);
            let bay_m = bay_m.filter(|m| *m > 0.0 && in_bay != Some(0));
            movements.push(Movement {
                storage: bay_m.map(|m| (tenth(m), in_bay)),
                column,
                heading,
                turn,
                lanes: whole(cell("lanes"), "lanes")?,
                shared: whole(cell("shared"), "shared")?,
                to: cell("dest node").map(|cell| cell.text.as_str()),
                volume_vph: volume.unwrap_or_default() * growth.unwrap_or(1.0),
                is_counted: volume.is_some(),
                peak_hour_factor: factor.filter(|factor| *factor > 0.0),
                heavy: percent("heavyvehicles", LEAST_HEAVY_PERCENT, 100.0, "hv")?,
                pedestrians_per_h: range("peds", 0.0, MOST_PEDESTRIANS_PER_H)?,
            });
        }
        if movements.iter().any(|m| m.is_counted) {
            let total: f64 = movements.iter().map(|m| m.volume_vph).sum();
            if total < FEW_VEHICLES {
                let about = "signals have hardly any vehicle; volumes may be shares or in thousands, or growth a factor";
                said.say(about, format!("node {id}: {total:.1} veh/h"));
            }
            for m in movements.iter().filter(|m| m.lanes > 0 && !m.is_counted) {
                let about = "movements that have lanes were not counted, and have no vehicles; write 0 where nobody drives";
                said.say(about, format!("node {id} {}", m.column));
            }
        }
        Ok(movements)
    }
}

/// Where the movements of an approach lead.
struct Ways<'a> {
    /// Node that it comes from.
    own: &'a str,
    /// Nodes of all arms.
    ids: Vec<&'a str>,
    /// Exits by their arms.
    exits: Vec<(usize, Turn)>,
}

impl Ways<'_> {
    /// Returns the turn of a movement: that of its destination where it has one, else that of its name; `None` where
    /// no exit has it. U-turns count as left turns.
    fn turn(&self, m: &Movement<'_>) -> Option<Turn> {
        let leads = |(exit, turn): &&(usize, Turn)| match m.to {
            Some(to) if to != self.own => self.ids[*exit] == to,
            Some(_) => *turn == Turn::Left,
            None => *turn == m.turn,
        };
        self.exits.iter().find(leads).map(|(_, turn)| *turn)
    }

    /// Returns the turn of a movement, that of its name where it leads nowhere.
    fn lane_turn(&self, m: &Movement<'_>) -> Turn {
        self.turn(m).unwrap_or(m.turn)
    }

    /// Returns the exits of a movement, as positions in [`Self::exits`]: that of its destination, else all of its turn. A
    /// U-turn has the first exit of its turn.
    fn exits_of(&self, m: &Movement<'_>) -> Vec<usize> {
        let Some(turn) = self.turn(m) else { return Vec::new() };
        let of_turn = || (0..self.exits.len()).filter(|exit| self.exits[*exit].1 == turn);
        let Some(to) = m.to else { return of_turn().collect() };
        let there = of_turn().find(|exit| self.ids[self.exits[*exit].0] == to);
        there.or_else(|| of_turn().next()).into_iter().collect()
    }

    /// Whether several exits have a turn.
    fn has_several(&self, turn: Turn) -> bool {
        self.exits.iter().filter(|(_, t)| *t == turn).count() > 1
    }
}

impl Movement<'_> {
    /// Whether it leaves by the street with an index, by its destination or else by the compass.
    fn leads_to(&self, up: &[(Heading, &Cell)], street: usize) -> bool {
        let (heading, cell) = &up[street];
        let eighths = match self.turn {
            Turn::Left => 2,
            Turn::Through => 4,
            Turn::Right => 6,
        };
        self.to.map_or_else(|| self.heading.clockwise(eighths) == *heading, |to| to == cell.text)
    }
}

/// Returns the vehicles per hour of the arms of an intersection that were counted.
fn volumes(intersection: &Intersection) -> impl Iterator<Item = f64> {
    intersection.arms.iter().filter_map(|arm| arm.counted).map(|counted| counted.total_vph())
}

/// Returns two directions that are nearly the same.
fn too_near(bearings: &[f64]) -> Option<(usize, usize)> {
    let mut pairs = (0..bearings.len()).flat_map(|i| (0..i).map(move |j| (j, i)));
    let is_near =
        |(a, b): &(usize, usize)| turn_degrees(bearings[*a], bearings[*b]).abs() < MIN_ANGLE_DEG;
    pairs.find(is_near)
}

/// Returns how many lanes of an approach are for left and for right turns alone. Lanes belong to where they lead, whatever
/// their group is called.
fn turn_lanes(at: &str, own: &[&Movement<'_>], ways: &Ways<'_>, said: &mut Said) -> [u32; 2] {
    let [left, through, right] = [Turn::Left, Turn::Through, Turn::Right]
        .map(|turn| own.iter().filter(|m| ways.lane_turn(m) == turn).map(|m| m.lanes).sum::<u32>());
    let shares = |turn: Turn, bit: u32| own.iter().any(|m| m.turn == turn && m.shared & bit == bit);
    // Without a through group the lanes that left and right share are neither.
    let is_shared = through == 0 && shares(Turn::Left, 2);
    if through > 0 && left > 0 && shares(Turn::Through, 1) || is_shared && left > 1 {
        let about = "a lane that turns left and goes elsewhere, beside lanes for left turns, is simulated without its left turn";
        said.say(about, at.to_owned());
    }
    [left.saturating_sub(u32::from(is_shared)), right]
}

/// Gives an arm the bays of its lane groups.
fn give_bays(arm: &mut Approach, own: &[&Movement<'_>], ways: &Ways<'_>, said: &mut Said) {
    for m in own.iter().filter(|m| m.lanes > 0) {
        let Some((storage_m, lanes)) = m.storage else { continue };
        let (bay, own_lanes) = match ways.lane_turn(m) {
            Turn::Left => (&mut arm.left_storage_m, arm.left_turn_lanes),
            Turn::Right => (&mut arm.right_storage_m, arm.right_turn_lanes),
            Turn::Through => continue,
        };
        let at = format!("node {}, {}", arm.intersection, m.column);
        if own_lanes == 0 || !(LEAST_STORAGE_M..=MOST_STORAGE_M).contains(&storage_m) {
            let about = "storage lengths of movements without turn lanes of their own, or out of range, are not used";
            said.say(about, format!("{at}: {storage_m:.0} m"));
            continue;
        }
        if lanes.is_some_and(|lanes| lanes < m.lanes) {
            let about = "bays have fewer lanes than turn there; all lanes of the turn are as long as the bay";
            said.say(about, at);
        }
        *bay = Some(bay.unwrap_or_default().max(storage_m));
    }
}

/// Gives an arm the movements of its lane groups and their volumes.
fn give(arm: &mut Approach, own: &[&Movement<'_>], ways: &Ways<'_>, said: &mut Said) {
    let at = format!("node {}", arm.intersection);
    let lost = |m: &Movement<'_>| format!("{at} {}: {:.0} veh/h", m.column, m.volume_vph);
    const NO_EXIT: &str =
        "movements have no exit or no lanes, and their vehicles are not simulated";
    if arm.lanes_in == 0 {
        own.iter().filter(|m| m.volume_vph > 0.0).for_each(|m| said.say(NO_EXIT, lost(m)));
        return;
    }
    let of_lanes = |turn| own.iter().find(|m| m.lanes > 0 && m.turn == turn);
    let beside = of_lanes(Turn::Through).or_else(|| of_lanes(Turn::Left));
    let shares = |m: &Movement<'_>| {
        let shared = beside.map_or(0, |beside| beside.shared);
        m.turn == Turn::Left && shared & 1 == 1 || m.turn == Turn::Right && shared & 2 == 2
    };
    let mut volumes: BTreeMap<Turn, f64> = BTreeMap::new();
    let mut divided: BTreeMap<Turn, f64> = BTreeMap::new();
    let mut exits_vph = [0.0; MOST_EXITS];
    let (mut peaks, mut heavy, mut total) = (0.0, 0.0, 0.0);
    for m in own.iter().filter(|m| m.lanes > 0 || m.volume_vph > 0.0 || shares(m)) {
        let Some(turn) = ways.turn(m) else {
            if m.volume_vph > 0.0 {
                said.say(NO_EXIT, lost(m));
            }
            continue;
        };
        if turn != m.turn {
            let about = "movements lead elsewhere than their names say, by the coordinates of nodes; lanes and volumes follow the \
                 coordinates";
            said.say(about, format!("{at} {} is {}", m.column, turn.name()));
        }
        if m.lanes == 0 && m.volume_vph > 0.0 && !shares(m) {
            let about =
                "volumes of movements without a lane and without a shared one use the other lanes";
            said.say(about, lost(m));
        }
        *volumes.entry(turn).or_default() += m.volume_vph;
        total += m.volume_vph;
        peaks += m.volume_vph / m.peak_hour_factor.unwrap_or(1.0);
        heavy += m.volume_vph * m.heavy.unwrap_or_default();
        let exits = ways.exits_of(m);
        for exit in &exits {
            // More exits than a network may have are refused with the intersection.
            if let Some(vph) = exits_vph.get_mut(*exit) {
                *vph += m.volume_vph / exits.len() as f64;
            }
        }
        if exits.len() > 1 && m.volume_vph > 0.0 {
            *divided.entry(turn).or_default() += m.volume_vph;
        }
    }
    for (turn, volume) in &divided {
        let about = "turns with several exits divide their vehicles equally among them";
        said.say(about, format!("{at} {} {}: {volume:.0} veh/h", arm.arm, turn.name()));
    }
    let several = volumes.iter().any(|(turn, vph)| *vph > 0.0 && ways.has_several(*turn));
    arm.movements = [Turn::Left, Turn::Through, Turn::Right]
        .into_iter()
        .filter(|turn| volumes.contains_key(turn))
        .map(letter)
        .collect();
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

fn tenth(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}

/// Returns a number of lanes, or a code that is as small; 0 where the cell is empty.
fn whole(cell: Option<&Cell>, record: &str) -> Result<u32, Fault> {
    let Some(cell) = cell else { return Ok(0) };
    let number = cell.number(record)?;
    match number.fract() == 0.0 && (0.0..=f64::from(MAX_LANES)).contains(&number) {
        true => Ok(number as u32),
        false => Err(Fault::new(
            cell.line,
            format!("{record} = {number}: expected a whole number from 0 to {MAX_LANES}"),
        )),
    }
}
