//! The movements of an approach: where they lead, their lanes and their bays.
//!
//! - **A movement** is the turn that leads to its destination, whatever its lane group is called; without a destination that
//!   of its name. Lanes of a left or right group are turn lanes where a through group exists.
//! - **Lanes that lead away** are those of the link. Where it counts the bays at its far stop line (`Storage`), these are none
//!   of them. They are at least as many as the widest movement into them has, and as those that have one phase together.

use std::collections::BTreeSet;
use std::ops::RangeInclusive;

use osm_signals::Turn;
use osm_signals::intersections::MAX_LANES;
use sheet::Fault;

use super::plans::MOST_OF_MOVEMENT;
use super::streets::tenth;
use super::{Cell, Utdf};
use crate::family::approaches::{Approach, MOST_PEDESTRIANS_PER_H, MOST_VPH};
use crate::family::doubts::Said;
use crate::settings::MIN_PEAK_HOUR_FACTOR;
use crate::turning::FEW_VEHICLES;
use crate::vocabulary::Heading;

/// Lengths of bays that are simulated, metres, and of those that are read.
const STORAGE_M: RangeInclusive<f64> = 5.0..=1000.0;
const MOST_STORAGE: f64 = 100_000.0;

/// Least growth and share of heavy vehicles, percent: what is less is a factor or a share.
const LEAST_GROWTH_PERCENT: f64 = 10.0;
const LEAST_HEAVY_PERCENT: f64 = 1.0;

/// A movement of a lane group.
pub(super) struct Movement<'a> {
    pub(super) column: &'a str,
    pub(super) heading: Heading,
    pub(super) turn: Turn,
    pub(super) lanes: u32,
    pub(super) shared: u32,
    pub(super) to: Option<&'a str>,
    /// Volume times growth; 0 where the file has no volume.
    pub(super) volume_vph: f64,
    /// Whether the file has a volume.
    pub(super) is_counted: bool,
    pub(super) peak_hour_factor: Option<f64>,
    pub(super) heavy: Option<f64>,
    /// People per hour who cross where it leaves.
    pub(super) pedestrians_per_h: Option<f64>,
    /// Length of its bay, metres, and how many of its lanes are in it.
    pub(super) storage: Option<(f64, Option<u32>)>,
    /// Whether the file forbids it on red.
    pub(super) waits_on_red: bool,
}

impl Utdf {
    /// Returns the lanes from a signal to another node.
    pub(super) fn lanes_out(
        &self,
        id: &str,
        other: &str,
        movements: &[Movement<'_>],
    ) -> Result<u32, Fault> {
        let into = || movements.iter().filter(|m| m.to == Some(other));
        let phases = |m: &Movement<'_>| -> BTreeSet<&str> {
            let of = |n| Some(self.lanes.cell(&format!("phase{n}"), id, m.column)?.text.as_str());
            (1..=MOST_OF_MOVEMENT).filter_map(of).filter(|number| *number != "0").collect()
        };
        let near = Turn::across(self.side).mirrored();
        let go = |m: &Movement<'_>, o: &Movement<'_>| {
            let ahead = m.turn != near && o.turn != near;
            m.column == o.column || ahead && !phases(m).is_disjoint(&phases(o))
        };
        let together =
            |m: &Movement<'_>| into().filter(|o| go(m, o)).map(|o| o.lanes.max(1)).sum::<u32>();
        let widest = into().map(together).max().unwrap_or_default();
        let lanes = self.links.row("lanes", other);
        let back = Heading::ALL.into_iter().find(|h| self.up(other, *h) == Some(id));
        if let Some(back) = back.filter(|_| !lanes.is_empty()) {
            let lanes = whole(lanes.get(back.name()), "lanes")?;
            let (mut at_stop_line, mut in_bays) = (0, 0);
            for (column, cell) in self.lanes.row("lanes", other) {
                if Heading::begins(column) == Some(back) {
                    let own = whole(Some(cell), "lanes")?;
                    let of = |record: &str| self.lanes.cell(record, other, column);
                    let is_bay =
                        self.lanes.number("storage", other, column)?.is_some_and(|l| l > 0.0);
                    let bay = of("stlanes").map_or(Ok(own), |cell| whole(Some(cell), "stlanes"))?;
                    at_stop_line += own;
                    in_bays += if is_bay { bay.min(own) } else { 0 };
                }
            }
            let not_of_link = at_stop_line.saturating_sub(lanes);
            let through = lanes.saturating_sub(in_bays.saturating_sub(not_of_link));
            return Ok(if lanes == 0 { 0 } else { through.max(widest).max(1) });
        }
        Ok(widest)
    }

    /// Returns the movements of an intersection, and says what is doubtful of their volumes.
    pub(super) fn movements(&self, id: &str, said: &mut Said) -> Result<Vec<Movement<'_>>, Fault> {
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
            let bay_m = range("storage", 0.0, MOST_STORAGE)?.map(|length| length * unit_m);
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
                waits_on_red: self.lanes.number("allow rtor", id, column)? == Some(0.0),
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
pub(super) struct Ways<'a> {
    /// Node that it comes from.
    pub(super) own: &'a str,
    /// Nodes of all arms.
    pub(super) ids: Vec<&'a str>,
    /// Exits by their arms.
    pub(super) exits: Vec<(usize, Turn)>,
}

impl Ways<'_> {
    /// Returns the turn of a movement: that of its destination where it has one, else that of its name; `None` where
    /// no exit has it. U-turns count as left turns.
    pub(super) fn turn(&self, m: &Movement<'_>) -> Option<Turn> {
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
    pub(super) fn exits_of(&self, m: &Movement<'_>) -> Vec<usize> {
        let Some(turn) = self.turn(m) else { return Vec::new() };
        let of_turn = || (0..self.exits.len()).filter(|exit| self.exits[*exit].1 == turn);
        let Some(to) = m.to else { return of_turn().collect() };
        let there = of_turn().find(|exit| self.ids[self.exits[*exit].0] == to);
        there.or_else(|| of_turn().next()).into_iter().collect()
    }

    /// Whether several exits have a turn.
    pub(super) fn has_several(&self, turn: Turn) -> bool {
        self.exits.iter().filter(|(_, t)| *t == turn).count() > 1
    }
}

impl Movement<'_> {
    /// Whether it leaves by the street with an index, by its destination or else by the compass.
    pub(super) fn leads_to(&self, up: &[(Heading, &Cell)], street: usize) -> bool {
        let (heading, cell) = &up[street];
        let eighths = match self.turn {
            Turn::Left => 2,
            Turn::Through => 4,
            Turn::Right => 6,
        };
        self.to.map_or_else(|| self.heading.clockwise(eighths) == *heading, |to| to == cell.text)
    }
}

/// Gives an arm its turn lanes. Lanes belong to where they lead, whatever their group is called.
pub(super) fn give_turn_lanes(arm: &mut Approach, own: &[&Movement<'_>], ways: &Ways<'_>) {
    let [left, through, right] = [Turn::Left, Turn::Through, Turn::Right]
        .map(|turn| own.iter().filter(|m| ways.lane_turn(m) == turn).map(|m| m.lanes).sum::<u32>());
    let shares = |turn: Turn, bit: u32| own.iter().any(|m| m.turn == turn && m.shared & bit == bit);
    // Without a through group the lanes that left and right share are neither.
    let is_shared = through == 0 && shares(Turn::Left, 2);
    arm.left_turn_lanes = left.saturating_sub(u32::from(is_shared));
    arm.right_turn_lanes = right;
    let also = |bit: u32| through > 0 && shares(Turn::Through, bit);
    arm.shared_left = (also(1) || is_shared) && arm.left_turn_lanes > 0;
    arm.shared_right = also(2) && right > 0;
}

/// Gives an arm the bays of its lane groups.
pub(super) fn give_bays(
    arm: &mut Approach,
    own: &[&Movement<'_>],
    ways: &Ways<'_>,
    said: &mut Said,
) {
    for m in own.iter().filter(|m| m.lanes > 0) {
        let Some((storage_m, lanes)) = m.storage else { continue };
        let (bay, own_lanes) = match ways.lane_turn(m) {
            Turn::Left => (&mut arm.left_storage_m, arm.left_turn_lanes),
            Turn::Right => (&mut arm.right_storage_m, arm.right_turn_lanes),
            Turn::Through => continue,
        };
        let at = format!("node {}, {}", arm.intersection, m.column);
        if own_lanes == 0 || !STORAGE_M.contains(&storage_m) {
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
