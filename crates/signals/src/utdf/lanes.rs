//! The movements of an approach: where they lead, their lanes and their bays, and their vehicles.
//!
//! - **A movement** is the turn that leads to its destination, whatever its lane group is called; without a destination that
//!   of its name. Lanes of a left or right group are turn lanes where a through group exists.
//! - **Lanes that lead away** are those of the link. Where it counts the bays at its far stop line (`Storage`), these are none
//!   of them. They are at least as many as the widest movement into them has, and as those that have one phase together.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::RangeInclusive;

use osm_signals::Turn;
use osm_signals::intersections::MAX_LANES;
use sheet::Fault;

use super::plans::MOST_OF_MOVEMENT;
use super::streets::tenth;
use super::{Cell, Utdf};
use crate::family::approaches::{
    Approach, Arrivals, Counted, MOST_EXITS, MOST_PEDESTRIANS_PER_H, MOST_VPH,
};
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

    /// Returns the exits of a movement, as positions in [`Self::exits`]: that of its destination, else all of its turn. A
    /// U-turn has the first exit of its turn.
    fn exits_of(&self, m: &Movement<'_>) -> Vec<usize> {
        let Some(turn) = self.turn(m) else { return Vec::new() };
        let of_turn = || (0..self.exits.len()).filter(|exit| self.exits[*exit].1 == turn);
        let Some(to) = m.to else { return of_turn().collect() };
        let there = of_turn().find(|exit| self.ids[self.exits[*exit].0] == to);
        there.or_else(|| of_turn().next()).into_iter().collect()
    }
}

/// Gives an arm its turn lanes. Lanes belong to where they lead, whatever their group is called.
pub(super) fn give_turn_lanes(arm: &mut Approach, own: &[&Movement<'_>], ways: &Ways<'_>) {
    let [left, through, right] = [Turn::Left, Turn::Through, Turn::Right].map(|turn| {
        own.iter().filter(|m| ways.turn(m).unwrap_or(m.turn) == turn).map(|m| m.lanes).sum::<u32>()
    });
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
        let (bay, own_lanes) = match ways.turn(m).unwrap_or(m.turn) {
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

/// Gives an arm the movements of its lane groups and their volumes.
pub(super) fn give(arm: &mut Approach, own: &[&Movement<'_>], ways: &Ways<'_>, said: &mut Said) {
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
    }
    let exits = |turn: &Turn| ways.exits.iter().filter(|(_, other)| other == turn).count();
    let several = volumes.iter().any(|(turn, vph)| *vph > 0.0 && exits(turn) > 1);
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
pub(super) fn letter(turn: Turn) -> char {
    ['l', 's', 'r'][turn as usize]
}

/// Returns a number of lanes, or a code that is as small; 0 where the cell is empty.
fn whole(cell: Option<&Cell>, record: &str) -> Result<u32, Fault> {
    let Some(cell) = cell else { return Ok(0) };
    let number = cell.number(record)?;
    let is_whole = number.fract() == 0.0 && (0.0..=f64::from(MAX_LANES)).contains(&number);
    let wrong = || format!("{record} = {number}: expected a whole number from 0 to {MAX_LANES}");
    is_whole.then_some(number as u32).ok_or_else(|| Fault::new(cell.line, wrong()))
}
