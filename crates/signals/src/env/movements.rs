//! Which links of a signal make up its movements.
//!
//! A movement is one approach and one turn. Choices:
//! - **An approach** is an edge that ends at the signal.
//! - **Links that are not served together** are different movements, even if approach and turn are the
//!   same: otherwise a phase would count lanes that it does not serve. The part with most links keeps
//!   RESCO's number; the others are numbered as if they came from approaches of their own.
//! - **U-turns** belong to the left turns and do not decide whether these are served.

use std::collections::BTreeMap;

use osm_signals::Turn;
use osm_signals::angle::{normalise_degrees, turn_degrees};

use crate::sim::topology::edge;
use crate::sim::{Direction, Link, Scene, SignalInfo};

/// Headings of the four slots of RESCO's movement order: S, W, N, E.
const SLOT_HEADINGS_DEG: [f64; 4] = [180.0, 270.0, 0.0, 90.0];

/// Half of the sector around north whose arms come first, degrees.
const NORTH_SECTOR_DEG: f64 = 45.0;

/// A link with its index at the signal and its number among those of that index.
type Numbered<'a> = ((usize, usize), &'a Link);

/// Turns in RESCO's order within an approach.
const TURNS: [Turn; 3] = [Turn::Right, Turn::Through, Turn::Left];

/// A movement in the simulator's terms.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RawMovement {
    /// As in [`crate::control::Movement`].
    pub(super) index: usize,
    pub(super) turn: Turn,
    /// Slot of the approach.
    pub(super) approach: usize,
    /// Indices in [`Scene::lanes`].
    pub(super) lanes: Vec<usize>,
    /// Indices in [`Scene::lanes`] of other signals' lanes.
    pub(super) downstream: Vec<usize>,
    /// Link indices of the signal.
    pub(super) links: Vec<usize>,
    /// Its links themselves, of which an index may steer those of several movements: index and number.
    pub(super) ways: Vec<(usize, usize)>,
    /// Those of them that decide whether a phase serves it.
    pub(super) deciding: Vec<usize>,
}

/// Returns the movements of a signal by ascending index; `states` are the greens to choose from.
pub(super) fn raw_movements(
    scene: &Scene,
    signal: &SignalInfo,
    states: &[String],
) -> Vec<RawMovement> {
    let slots = approach_slots(scene, signal);
    let arms = slots.len().max(SLOT_HEADINGS_DEG.len());
    let mut groups: BTreeMap<(usize, usize), Vec<Numbered<'_>>> = BTreeMap::new();
    for (index, links) in signal.links.iter().enumerate() {
        for (number, link) in links.iter().enumerate() {
            let slot = slots[edge(&scene.lanes[link.from_lane].id)];
            let turn = turn_of(link.direction);
            let place = TURNS.iter().position(|t| *t == turn).expect("all turns are there");
            groups.entry((slot, place)).or_default().push(((index, number), link));
        }
    }
    let mut movements = Vec::new();
    let mut parts = 0;
    for ((approach, place), links) in groups {
        for (number, part) in served_together(&links, states).into_iter().enumerate() {
            let slot = if number == 0 { approach } else { arms + parts };
            parts += usize::from(number > 0);
            movements.push(movement(TURNS.len() * slot + place, TURNS[place], approach, &part));
        }
    }
    movements.sort_by_key(|m| m.index);
    movements
}

fn movement(index: usize, turn: Turn, approach: usize, links: &[Numbered<'_>]) -> RawMovement {
    let sorted = |values: &mut dyn Iterator<Item = usize>| {
        let mut values: Vec<usize> = values.collect();
        values.sort_unstable();
        values.dedup();
        values
    };
    let all = sorted(&mut links.iter().map(|((index, _), _)| *index));
    let ahead = links.iter().filter(|(_, link)| link.direction != Direction::Turn);
    let deciding = sorted(&mut ahead.map(|((index, _), _)| *index));
    RawMovement {
        index,
        turn,
        approach,
        lanes: sorted(&mut links.iter().map(|(_, link)| link.from_lane)),
        downstream: sorted(&mut links.iter().flat_map(|(_, link)| link.downstream.clone())),
        deciding: if deciding.is_empty() { all.clone() } else { deciding },
        links: all,
        ways: links.iter().map(|(place, _)| *place).collect(),
    }
}

/// Returns the links of a movement in parts that are green in the same states, the largest first.
fn served_together<'a>(links: &[Numbered<'a>], states: &[String]) -> Vec<Vec<Numbered<'a>>> {
    let green = |index: usize| -> Vec<bool> {
        states.iter().map(|s| matches!(s.as_bytes().get(index), Some(b'G' | b'g'))).collect()
    };
    let (back, ahead): (Vec<_>, Vec<_>) =
        links.iter().copied().partition(|(_, link)| link.direction == Direction::Turn);
    if ahead.is_empty() {
        return vec![back];
    }
    let mut parts: Vec<(Vec<bool>, Vec<Numbered<'_>>)> = Vec::new();
    for (place, link) in ahead {
        let pattern = green(place.0);
        match parts.iter_mut().find(|(known, _)| *known == pattern) {
            Some((_, part)) => part.push((place, link)),
            None => parts.push((pattern, vec![(place, link)])),
        }
    }
    // The sort is stable: of equally large parts the one with the lowest link is first.
    parts.sort_by_key(|(_, part)| std::cmp::Reverse(part.len()));
    let mut parts: Vec<Vec<Numbered<'_>>> = parts.into_iter().map(|(_, part)| part).collect();
    for (place, link) in back {
        let beside = |part: &Vec<Numbered<'_>>| {
            part.iter().any(|(_, other)| other.from_lane == link.from_lane)
        };
        let part = parts.iter().position(beside).unwrap_or(0);
        parts[part].push((place, link));
    }
    parts
}

/// Returns the slot of every approach, by the id of its edge.
fn approach_slots<'a>(scene: &'a Scene, signal: &SignalInfo) -> BTreeMap<&'a str, usize> {
    let mut headings: BTreeMap<&str, f64> = BTreeMap::new();
    for link in signal.links.iter().flatten() {
        let lane = &scene.lanes[link.from_lane];
        headings.entry(edge(&lane.id)).or_insert(lane.heading_deg);
    }
    // Clockwise by the bearing of the arm, which lies opposite to the heading. An arm just west
    // of north comes first, as if it were north.
    let bearing = |heading: f64| normalise_degrees(heading + 180.0 + NORTH_SECTOR_DEG);
    let mut order: Vec<(&str, f64)> = headings.into_iter().collect();
    order.sort_by(|a, b| bearing(a.1).total_cmp(&bearing(b.1)).then_with(|| a.0.cmp(b.0)));
    let slots = match order.len() {
        0..=4 => cardinal_slots(&order.iter().map(|(_, h)| *h).collect::<Vec<_>>()),
        n => (0..n).collect(),
    };
    order.into_iter().map(|(edge, _)| edge).zip(slots).collect()
}

/// Returns the assignment of up to four headings to distinct slots with the smallest sum of
/// squared angles.
fn cardinal_slots(headings: &[f64]) -> Vec<usize> {
    fn search(headings: &[f64], used: u8) -> (f64, Vec<usize>) {
        let Some((first, rest)) = headings.split_first() else { return (0.0, Vec::new()) };
        (0..4)
            .filter(|slot| used >> slot & 1 == 0)
            .map(|slot| {
                let (cost, mut slots) = search(rest, used | 1 << slot);
                slots.insert(0, slot);
                (cost + turn_degrees(SLOT_HEADINGS_DEG[slot], *first).powi(2), slots)
            })
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .expect("there are at most as many headings as slots")
    }
    search(headings, 0).1
}

pub(super) fn turn_of(direction: Direction) -> Turn {
    match direction {
        Direction::Right | Direction::PartRight => Turn::Right,
        Direction::Straight => Turn::Through,
        Direction::Left | Direction::PartLeft | Direction::Turn => Turn::Left,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::testing::crossing;

    /// Index, lanes and links of every movement.
    fn found(lanes: &[(&str, f64, &str)], greens: &[&str]) -> Vec<(usize, Vec<usize>, Vec<usize>)> {
        let scene = crossing(lanes, greens);
        let states: Vec<String> = greens.iter().map(|g| (*g).to_owned()).collect();
        raw_movements(&scene, &scene.signals[0], &states)
            .into_iter()
            .map(|m| (m.index, m.lanes, m.links))
            .collect()
    }

    #[test]
    fn a_turn_whose_lanes_are_not_served_together_is_two_movements() {
        let lanes = [("n_0", 0.0, "r"), ("n_1", 0.0, "r"), ("n_2", 0.0, "s"), ("e_0", 90.0, "s")];
        let expected = [
            (7, vec![2], vec![2]),
            (10, vec![3], vec![3]),
            (6, vec![0], vec![0]),
            (12, vec![1], vec![1]),
        ];
        let mut movements = found(&lanes, &["GrGr", "GGrG"]);
        movements.sort_by_key(|m| (m.0 % 3 == 0, m.0));
        assert_eq!(movements, expected);
    }

    #[test]
    fn a_u_turn_with_a_green_of_its_own_stays_with_the_lefts() {
        let lanes = [("n_0", 0.0, "s"), ("n_1", 0.0, "lt"), ("e_0", 90.0, "s")];
        let movements = found(&lanes, &["GrGr", "rGGr", "rrgG"]);
        assert_eq!(movements[1], (8, vec![1], vec![1, 2]));
        let scene = crossing(&lanes, &["GrGr"]);
        let raw = raw_movements(&scene, &scene.signals[0], &["GrGr".to_owned()]);
        assert_eq!(raw[1].deciding, [1]);
    }
}
