//! The phases of a signal as events number them, whatever drives it.
//!
//! - **Watched links** say by their lights whether a phase is green: its through links that no other phase has, else all
//!   that no other phase has. Where other phases have all of them, as a left turn that also yields in its through phase,
//!   it is green while they have the right of way. Stages are watched as a whole.
//! - **Phases that are never green**, as that of a left turn's arrow under a program without arrows, are left out.
//! - **A lane** belongs to the phase that watches most of its links; one of overlaps only, to the through phase of its
//!   approach.

use osm_signals::Turn;

use super::links::Links;
use super::plan::Plan;

/// A phase with its number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NumberedPhase {
    /// Its number, as on the cabinet sheet.
    pub number: u32,
    /// Its links.
    pub links: Vec<usize>,
    /// Links whose lights say whether it is green.
    pub watched: Vec<usize>,
    /// Whether it is green only while they have the right of way.
    pub needs_arrow: bool,
    /// All-red after it, seconds.
    pub all_red_s: u32,
    /// Its crosswalks, each with walk and clearance together, seconds.
    pub crossings: Vec<(usize, u32)>,
}

impl NumberedPhase {
    /// Whether it is green in a state of its signal.
    pub fn is_green(&self, state: &[u8]) -> bool {
        let is = |link: &usize| match state.get(*link) {
            Some(b'G') => true,
            Some(b'g') => !self.needs_arrow,
            _ => false,
        };
        !self.watched.is_empty() && self.watched.iter().all(is)
    }

    /// Whether some of its watched links is yellow in a state of its signal.
    pub fn is_yellow(&self, state: &[u8]) -> bool {
        self.watched.iter().any(|link| matches!(state.get(*link), Some(b'y' | b'Y')))
    }
}

/// The phases of a signal, and whose its lanes are.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Phasing {
    /// Its phases.
    pub phases: Vec<NumberedPhase>,
    /// Lanes that lead to it, as indices in the scene, ascending, each with the place of its phase.
    pub lanes: Vec<(usize, usize)>,
}

impl Phasing {
    /// Returns the phases of a plan.
    ///
    /// # Arguments
    ///
    /// * `shown` — all states that the signal may show; empty where that is up to the plan.
    pub(super) fn of(links: &Links, plan: &Plan, shown: &[String]) -> Self {
        let all: Vec<usize> = (0..plan.phases.len()).collect();
        let phases = numbered(links, plan, &all);
        let is_shown = |p: &NumberedPhase| shown.iter().any(|state| p.is_green(state.as_bytes()));
        let kept: Vec<usize> = all.into_iter().filter(|index| is_shown(&phases[*index])).collect();
        let phases = if kept.is_empty() { phases } else { numbered(links, plan, &kept) };
        let mut lanes: Vec<usize> =
            links.cars.iter().flatten().flat_map(|car| car.lanes.iter().copied()).collect();
        lanes.sort_unstable();
        lanes.dedup();
        let of_lane = |lane: usize| Some((lane, phase_of_lane(links, &phases, lane)?));
        let lanes = lanes.into_iter().filter_map(of_lane).collect();
        Self { phases, lanes }
    }
}

/// Returns some phases of a plan.
fn numbered(links: &Links, plan: &Plan, kept: &[usize]) -> Vec<NumberedPhase> {
    let phase = |index: &usize| {
        let phase = &plan.phases[*index];
        let has = |link: usize| move |other: &usize| plan.phases[*other].links.contains(&link);
        let is_shared = |link: &usize| kept.iter().filter(|other| *other != index).any(has(*link));
        let is_car = |link: &&usize| links.turn(**link).is_some();
        let cars: Vec<usize> = phase.links.iter().filter(is_car).copied().collect();
        let own: Vec<usize> = cars.iter().filter(|l| !is_shared(l)).copied().collect();
        let is_through = |link: &&usize| links.turn(**link) == Some(Turn::Through);
        let through: Vec<usize> = own.iter().filter(is_through).copied().collect();
        let (watched, needs_arrow) = match (plan.stages, through.is_empty(), own.is_empty()) {
            (true, ..) => (cars, false),
            (false, false, _) => (through, false),
            (false, true, false) => (own, false),
            (false, true, true) => (cars, true),
        };
        NumberedPhase {
            number: phase.number,
            links: phase.links.clone(),
            watched,
            needs_arrow,
            all_red_s: phase.change_s.1,
            crossings: phase.crossings.clone(),
        }
    };
    kept.iter().map(phase).collect()
}

/// Returns the place of the phase that a lane belongs to; none where no phase serves its approach.
fn phase_of_lane(links: &Links, phases: &[NumberedPhase], lane: usize) -> Option<usize> {
    let on_lane: Vec<usize> = (0..links.count())
        .filter(|link| links.cars[*link].as_ref().is_some_and(|c| c.lanes.contains(&lane)))
        .collect();
    let approach = on_lane.first().and_then(|link| links.cars[*link].as_ref())?.approach;
    let beside: Vec<usize> = links.of_approach(approach).collect();
    let share =
        |of: &[usize], among: &[usize]| of.iter().filter(|link| among.contains(link)).count();
    let rank = |index: &usize| {
        let p = &phases[*index];
        let shares =
            [share(&p.watched, &on_lane), share(&p.links, &on_lane), share(&p.watched, &beside)];
        (shares, std::cmp::Reverse(p.number))
    };
    let best = (0..phases.len()).max_by_key(rank)?;
    (rank(&best).0 != [0; 3]).then_some(best)
}
