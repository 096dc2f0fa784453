//! From UTDF to intersections.
//!
//! - **Arms** are called after the direction of travel and the street, such as `NB Main St`. They are the
//!   links of a signal, in the direction of the node at their other end. The names of directions are those of the file and
//!   need not agree with the compass. A node that is a bend belongs to the street: its length
//!   goes on to the next node.
//! - **Volumes** are those of the file times its growth, with the peak hour factor and the heavy vehicles of its
//!   movements. Several destinations of one turn have their own
//!   volumes. Deviation: where movements have no destination, exits of one turn get the same share.
//! - **Pedestrians**: a file whose `Peds` are all 0 is one in which nobody counted them.
//! - **Control** has no part in an intersection; see [`plans`](super::plans). A free right turn is a lane at the signal.

use std::collections::BTreeMap;

use osm_signals::Turn;
use osm_signals::angle::turn_degrees;
use osm_signals::turn::exits_on;
use sheet::Fault;

use super::lanes::{Movement, Ways, give, give_bays, give_turn_lanes, letter};
use super::{Cell, Node, START, Utdf};

use crate::existing::{NamedPlan, Plans};
use crate::family::approaches::{self, Approach, Intersection, MOST_VPH, check_arms, gathered};
use crate::family::doubts::{Doubt, Said};
use crate::turning::without_zero_pedestrians;
use crate::vocabulary::Heading;
use basics::units::{FOOT_M, KMH_TO_MPH};
use evaluation::family::error::FamilyError;

/// Least length of an approach, metres.
const MIN_LENGTH_M: f64 = 25.0;

/// Speed where a link has none, miles per hour.
const DEFAULT_MPH: f64 = 30.0;

/// Length where a link has none, feet.
const DEFAULT_FT: f64 = 1000.0;

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
    /// It cannot be simulated, and the others can: the line, if one is the reason, and why.
    LeftOut(Option<u64>, String),
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
        Self::LeftOut(None, why)
    }
}

impl Utdf {
    /// Returns the signals of the network as intersections with approaches and volumes.
    pub fn intersections(&self) -> Result<Converted, FamilyError> {
        self.converted().map_err(|fault| self.wrong(fault))
    }

    fn converted(&self) -> Result<Converted, Fault> {
        let is_empty = [self.nodes.is_empty(), self.links.0.is_empty(), self.lanes.0.is_empty()];
        let sections = ["[Nodes]", "[Links]", "[Lanes]"].into_iter().zip(is_empty);
        if let Some((section, _)) = sections.into_iter().find(|(_, is_empty)| *is_empty) {
            let message = "export the network as UTDF (CSV) with all sections; give counts with --turning-counts, and plans alone as a table such as plans/METHOD.csv";
            return Err(Fault::new(START, format!("no rows below {section} of UTDF; {message}")));
        }
        let (mut said, mut why_not) = (Said::default(), Vec::new());
        let signals: Vec<&Node> = self.nodes.iter().filter(|n| self.is_signal(n)).collect();
        let mut plans = Plans { file: self.file.clone(), is_utdf: true, ..Plans::default() };
        let mut intersections = Vec::new();
        for node in &signals {
            let (intersection, names) = match self.signal(node, &mut said) {
                Ok(made) => made,
                Err(Stop::Wrong(fault)) => return Err(fault),
                Err(Stop::LeftOut(_, why)) => {
                    why_not.push(why);
                    continue;
                }
            };
            intersections.push(intersection);
            let (intersection, period) = (node.id.clone(), String::new());
            let phases = self.phases.row("brp", &node.id).values().next();
            let line = phases.map_or(node.line, |cell| cell.line);
            match self.plan(&node.id, &names, &mut said) {
                Ok(None) => {}
                Ok(Some(plan)) => plans.all.push(NamedPlan { intersection, period, plan, line }),
                Err(Stop::Wrong(fault)) => return Err(fault),
                Err(Stop::LeftOut(at, why)) => {
                    let at =
                        format!("{}, line {}, node {}", self.file, at.unwrap_or(line), node.id);
                    said.say(NO_PLAN, format!("{at}: {why}"));
                }
            }
        }
        let nodes = self.nodes.len();
        if intersections.is_empty() {
            let none = format!("none of the {nodes} nodes is a signal that can be simulated");
            let few = std::iter::once(none).chain(why_not.into_iter().take(3));
            return Err(Fault::new(START, few.collect::<Vec<_>>().join("; ")));
        }
        let with_volumes = intersections.iter().filter(|i| volumes(i).any(|vph| vph > 0.0)).count();
        let found = vec![format!(
            "UTDF: {} of {} signals, {with_volumes} with volumes, {} with a plan; {nodes} nodes",
            intersections.len(),
            signals.len(),
            plans.all.len(),
        )];
        let left_out = Doubt::of("signals that cannot be simulated are left out", why_not);
        let no_units = "no Metric in [Network]: lengths are read as feet and speeds as mph; Metric,1 says metres and km/h";
        let absent = [
            (!self.network.contains_key("metric"), no_units),
            (self.phases.0.is_empty(), "no [Phases]: the signals have no existing plan"),
        ];
        let absent =
            absent.map(|(is, about)| Doubt::of(about, vec![self.file.clone()]).filter(|_| is));
        let arms = intersections.iter_mut().flat_map(|i: &mut Intersection| &mut i.arms);
        let nobody = (!self.zero_pedestrians).then(|| without_zero_pedestrians(arms)).flatten();
        let absent = absent.into_iter().flatten();
        let doubts =
            left_out.into_iter().chain(said.doubts()).chain(absent).chain(nobody).collect();
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
            let mut arm = Approach {
                intersection: id.to_owned(),
                arm: std::iter::once(heading.name()).chain(words).collect::<Vec<_>>().join(" "),
                latitude: f64::NAN,
                longitude: f64::NAN,
                bearing_deg: bearings[i],
                lanes_in: own.iter().map(|m| m.lanes).sum(),
                lanes_out: lanes_out[i],
                speed_mph,
                length_m,
                line: other.line,
                ..Approach::default()
            };
            give_turn_lanes(&mut arm, &own, &ways);
            let near = Turn::across(self.side).mirrored();
            arm.no_turn_on_red = own.iter().any(|m| m.waits_on_red && ways.turn(m) == Some(near));
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
        let intersection = gathered(arms).remove(0);
        let most_vph = volumes(&intersection).fold(0.0, f64::max);
        if most_vph > MOST_VPH {
            return Err(
                format!("node {id}: {most_vph:.0} veh/h on one arm, above {MOST_VPH}").into()
            );
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
        Ok((tenth(length_m.max(MIN_LENGTH_M)), tenth(speed_mph)))
    }

    /// Returns the node from which a link comes.
    pub(super) fn up(&self, id: &str, heading: Heading) -> Option<&str> {
        self.links.cell("up id", id, heading.name()).map(|cell| cell.text.as_str())
    }

    /// Returns how many metres and miles per hour the units of the file are.
    pub(super) fn units(&self) -> [f64; 2] {
        let is_metric = self.network.get("metric") == Some(&1.0);
        if is_metric { [1.0, KMH_TO_MPH] } else { [FOOT_M, 1.0] }
    }
}

impl Movement<'_> {
    /// Whether it leaves by the street with an index, by its destination or else by the compass.
    fn leads_to(&self, up: &[(Heading, &Cell)], street: usize) -> bool {
        let (heading, cell) = &up[street];
        let eighths = [2, 4, 6][self.turn as usize];
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

pub(super) fn tenth(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}
