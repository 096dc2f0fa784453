//! How the rings go on, second by second.
//!
//! A green may end once it has lasted its least and nobody has passed its detectors for the passage time, or it has
//! lasted its longest, and another phase is called that cannot run beside it:
//! - **Within a side** the ring goes on to its next phase that is called; the other ring does not notice.
//! - **Across a barrier** both rings go together, when neither has a called phase left and both may end. A through
//!   phase at its longest takes the other ring with it, unless that one's phase is coordinated and may not end yet. The
//!   next side is the first in order of which a phase is called. A ring without a call there serves its through phase
//!   beside the other ring's (dual entry). In an existing plan in which no phase of the ring does so, it rests until one of
//!   them is called.
//!
//!   Deviation: in NEMA TS 2 a through phase at its longest rests in green until the other ring may end as well. In an
//!   existing plan it does so.
//! - **Back to the same side**, for a left turn that came too late: both rings end first.
//!
//! What is never shown, whatever the plan says:
//! - a link beside one that it conflicts with, or before that one's yellow and red are over;
//! - the yellow of a left turn that yields, beside the green of whom it yields to (the yellow trap): that green ends
//!   with it;
//! - a green shorter than its least. A phase begins within a side only if the other ring can wait for it.
//!
//! A link that is green in a phase and in the one after it stays green in between, as in every other program here.
//!
//! An existing plan has its own yellow and red per phase, and a ring takes those of its phase whatever stays green. Where
//! it is coordinated, a clock counts the cycle: coordinated phases are green until they may end, others end at the end of
//! their splits at the latest, and a phase that could not last its least before that is not called until the next cycle. One
//! whose split has no more room than that, or that has waited for a whole cycle, overruns its split. At a barrier a ring with
//! the longer change begins it first, as soon as the other one's green is about to be over, so that each ring ends at the end
//! of its own split. Where a left turn would see yellow beside the green of whom it yields to, both begin together, when both
//! may end.

use osm_signals::Turn;

use super::links::Links;
use super::phasing::Phasing;
use super::plan::{Coordination, Plan, Side};
use crate::timing::{Timing, WALK_S};

/// What the detectors of every phase say in a second.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Seen {
    /// Whether a vehicle calls it.
    pub(super) calls: Vec<bool>,
    /// Whether a vehicle prolongs it.
    pub(super) extends: Vec<bool>,
    /// How long those take who wait at its crosswalks, seconds; empty without push buttons.
    pub(super) walk_s: Vec<Option<u32>>,
}

impl Seen {
    /// Returns how long those take who wait at the crosswalks of a phase, seconds; none if nobody does.
    fn walk_s(&self, phase: usize) -> Option<u32> {
        self.walk_s.get(phase).copied().flatten()
    }
}

/// What a ring does.
#[derive(Debug, Clone, PartialEq)]
enum Stage {
    /// Nothing: the side has no phase for it.
    Idle,
    Green {
        phase: usize,
        for_s: u32,
        /// Time since a vehicle was last seen.
        gap_s: u32,
        /// Since when and until when pedestrians cross, in its own time, seconds.
        walk: Option<(u32, u32)>,
    },
    Change {
        next: Option<usize>,
        left_s: u32,
        /// Links that stay green meanwhile.
        held: Vec<usize>,
    },
}

/// The green of a ring that goes on for a moment while the other ring crosses the barrier already.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Late {
    ring: usize,
    /// How long it still lasts, seconds.
    left_s: u32,
    /// The phase after it.
    next: Option<usize>,
    /// The phase that the other ring begins.
    beside: Option<usize>,
}

/// Why a green ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// Nobody had passed its detectors for the passage time.
    GapOut,
    /// It had lasted its longest.
    MaxOut,
    /// Its split within the cycle was over.
    ForceOff,
}

/// The rings of a signal.
#[derive(Debug, Clone)]
pub(super) struct Rings {
    links: Links,
    plan: Plan,
    timing: Timing,
    side: usize,
    stages: [Stage; 2],
    /// The ring that has still to follow the other one across the barrier.
    late: Option<Late>,
    /// Time since the first coordinated phase could end, seconds; stands still without a cycle.
    clock_s: u32,
    /// Per phase, for how long it has been called without being green, seconds.
    waits_s: Vec<u32>,
    green: Vec<bool>,
    /// Yellow that is left per link, seconds.
    yellow_s: Vec<u32>,
    /// Yellow and red that is left per link, seconds.
    clearing_s: Vec<u32>,
    shown: String,
    /// Phases whose green ended with the last second, and why; the reason is missing where the other ring took it along.
    ended: Vec<(usize, Option<Ending>)>,
}

impl Rings {
    /// Returns the rings of a signal as they begin: the through phases of the main street are green, of a coordinated plan
    /// the coordinated phases.
    pub(super) fn new(links: Links, plan: Plan, timing: Timing) -> Self {
        let count = links.count();
        let holds = |phase: &usize| plan.coordination.as_ref().is_some_and(|c| c.holds[*phase]);
        let has_any = |side: &Side| side.iter().flatten().any(holds);
        let side = plan.sides.iter().position(has_any).unwrap_or_default();
        let first = |ring: &Vec<usize>| {
            let enters = |p: &&usize| plan.phases[**p].enters;
            let found = ring.iter().find(|p| holds(p)).or_else(|| ring.iter().find(enters));
            found.or(ring.last()).copied()
        };
        let stage = |ring: &Vec<usize>| match first(ring) {
            Some(phase) => Stage::Green { phase, for_s: 0, gap_s: 0, walk: None },
            None => Stage::Idle,
        };
        let [first, second] = &plan.sides[side];
        let stages = [stage(first), stage(second)];
        let mut rings = Self {
            links,
            clock_s: plan.coordination.as_ref().map_or(0, |c| c.begins_s),
            waits_s: vec![0; plan.phases.len()],
            plan,
            timing,
            side,
            stages,
            late: None,
            green: vec![false; count],
            yellow_s: vec![0; count],
            clearing_s: vec![0; count],
            shown: String::new(),
            ended: Vec::new(),
        };
        rings.light();
        rings.shown = rings.state();
        rings
    }

    /// Returns the plan.
    pub(super) fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Returns what is shown now.
    pub(super) fn shown(&self) -> &str {
        &self.shown
    }

    /// Whether all of some links are green.
    pub(super) fn all_green(&self, links: &[usize]) -> bool {
        links.iter().all(|link| self.green[*link])
    }

    /// Returns its phases as events number them.
    pub(super) fn phasing(&self) -> Phasing {
        Phasing::of(&self.links, &self.plan, &[])
    }

    /// Returns the phases that are green.
    pub(super) fn green_phases(&self) -> impl Iterator<Item = usize> + '_ {
        self.stages.iter().filter_map(|stage| match stage {
            Stage::Green { phase, .. } => Some(*phase),
            _ => None,
        })
    }

    /// Returns the phases whose green ended with the last second, and why.
    pub(super) fn ended(&self) -> &[(usize, Option<Ending>)] {
        &self.ended
    }

    /// Lets a second go by, at the end of which the detectors see something, and returns what is shown from then
    /// on, if it is something else.
    pub(super) fn second(&mut self, seen: &Seen) -> Option<&str> {
        self.ended.clear();
        let mut moves = self.clearing_s.iter().any(|s| *s > 0);
        self.elapse(seen);
        moves |= self.follow();
        moves |= self.begin();
        self.walk(seen);
        // A change that takes no time may lead to a next one.
        while self.advance(seen) || self.cross(seen) {
            moves = true;
            if !self.begin() {
                break;
            }
            self.walk(seen);
        }
        if !moves {
            return None;
        }
        self.light();
        let state = self.state();
        if state == self.shown {
            return None;
        }
        self.shown = state;
        Some(&self.shown)
    }

    fn elapse(&mut self, seen: &Seen) {
        for stage in &mut self.stages {
            match stage {
                Stage::Idle => {}
                Stage::Green { phase, for_s, gap_s, .. } => {
                    *for_s += 1;
                    *gap_s = if seen.extends[*phase] { 0 } else { *gap_s + 1 };
                }
                Stage::Change { left_s, .. } => *left_s = left_s.saturating_sub(1),
            }
        }
        if let Some(late) = &mut self.late {
            late.left_s = late.left_s.saturating_sub(1);
        }
        if let Some(coordination) = &self.plan.coordination {
            self.clock_s = (self.clock_s + 1) % coordination.cycle_s;
            for (phase, waits_s) in self.waits_s.iter_mut().enumerate() {
                let is_called = seen.calls[phase] || self.plan.phases[phase].recall;
                let is_green =
                    |stage: &Stage| matches!(stage, Stage::Green { phase: p, .. } if *p == phase);
                *waits_s =
                    if is_called && !self.stages.iter().any(is_green) { *waits_s + 1 } else { 0 };
            }
        }
        let clocks = self.yellow_s.iter_mut().chain(&mut self.clearing_s);
        clocks.for_each(|s| *s = s.saturating_sub(1));
    }

    /// Begins the phases whose change is over, and says whether one did.
    fn begin(&mut self) -> bool {
        let mut any = false;
        for ring in 0..2 {
            let Stage::Change { next, left_s: 0, .. } = self.stages[ring] else { continue };
            let clear = |link: &usize| {
                let meets = |other: usize| !self.links.together(*link, other);
                let waits =
                    |other: usize| self.clearing_s[other] > 0 && (other == *link || meets(other));
                !(0..self.links.count()).any(waits)
            };
            match next {
                None => self.stages[ring] = Stage::Idle,
                Some(phase) if self.plan.phases[phase].links.iter().all(clear) => {
                    self.stages[ring] = Stage::Green { phase, for_s: 0, gap_s: 0, walk: None };
                }
                Some(_) => continue,
            }
            any = true;
        }
        any
    }

    /// Lets those begin to walk who wait at the crosswalks of what is green, if it may still last as long as they
    /// take.
    fn walk(&mut self, seen: &Seen) {
        for ring in 0..2 {
            let Stage::Green { phase, for_s, walk, .. } = self.stages[ring] else { continue };
            let is_over = walk.is_none_or(|(_, end_s)| for_s >= end_s);
            let room = |takes_s: u32| {
                let other = match self.stages[1 - ring] {
                    Stage::Green { phase: other, for_s, .. } => {
                        takes_s <= self.left_s(other, for_s)
                    }
                    _ => true,
                };
                for_s == 0 || (takes_s <= self.left_s(phase, for_s) && other)
            };
            if let Some(takes_s) = seen.walk_s(phase).filter(|s| is_over && room(*s))
                && let Stage::Green { walk, .. } = &mut self.stages[ring]
            {
                *walk = Some((for_s, for_s + takes_s));
            }
        }
    }

    /// Returns the phases whose crosswalks show WALK.
    pub(super) fn walking(&self) -> impl Iterator<Item = usize> + '_ {
        self.stages.iter().filter_map(|stage| match stage {
            Stage::Green { phase, for_s, walk: Some((began_s, _)), .. } => {
                (for_s - began_s < WALK_S).then_some(*phase)
            }
            _ => None,
        })
    }

    /// Returns the shortest time that the phase of a green lasts, pedestrians included, seconds.
    fn least_s(&self, phase: usize, walk: Option<(u32, u32)>) -> u32 {
        self.plan.phases[phase].min_s.max(walk.map_or(0, |(_, end_s)| end_s))
    }

    /// Returns how long a green may still last while another phase is called, seconds.
    fn left_s(&self, phase: usize, for_s: u32) -> u32 {
        let max_s = self.plan.phases[phase].max_s.saturating_sub(for_s);
        let Some(coordination) = &self.plan.coordination else { return max_s };
        if coordination.holds[phase] {
            let end_s = coordination.ends_s[phase];
            // One that became green after that moment waits for the next cycle.
            let may_end = self.clock_s >= end_s && for_s > self.clock_s - end_s;
            let next_s = (coordination.cycle_s + end_s - self.clock_s) % coordination.cycle_s;
            return match (may_end, next_s) {
                (true, _) => 0,
                (false, 0) => coordination.cycle_s,
                (false, next_s) => next_s,
            };
        }
        let left_s = self.end_s(coordination, phase, for_s).saturating_sub(self.clock_s);
        if coordination.inhibits_max[phase] { left_s } else { left_s.min(max_s) }
    }

    /// Returns when the cycle ends the green of a phase that is not coordinated, seconds of the clock.
    fn end_s(&self, coordination: &Coordination, phase: usize, for_s: u32) -> u32 {
        let end_s = coordination.ends_s[phase];
        let Some(now_s) = end_s.checked_sub(coordination.cycle_s) else { return end_s };
        // One that was green before that moment of this cycle ends there, one that began after it in the next cycle.
        let is_of_last = self.clock_s < now_s || for_s > self.clock_s - now_s;
        if is_of_last { now_s } else { end_s }
    }

    /// Whether a phase is green whoever comes, until the cycle lets it end.
    fn holds(&self, phase: usize) -> bool {
        self.plan.coordination.as_ref().is_some_and(|c| c.holds[phase])
    }

    /// Whether a phase that is called may last its least before the cycle ends it. One whose split has no more room than its
    /// least begins whenever it is called within its split, and overruns it. So does one that has waited for a whole cycle:
    /// nobody waits for ever.
    fn fits(&self, phase: usize) -> bool {
        let Some(coordination) = &self.plan.coordination else { return true };
        let Some(split_s) = coordination.splits_s[phase] else { return false };
        if coordination.holds[phase] || self.waits_s[phase] >= coordination.cycle_s {
            return true;
        }
        let change_s = |phase: usize| {
            let (yellow_s, red_s) = self.plan.phases[phase].change_s;
            yellow_s + red_s
        };
        let before_s = self.green_phases().map(change_s).max().unwrap_or_default();
        let min_s = self.plan.phases[phase].min_s;
        let least_s = if min_s + change_s(phase) < split_s { min_s } else { 0 };
        self.clock_s + before_s + least_s <= self.end_s(coordination, phase, 0)
    }

    /// Returns why the green of a ring ends now; none where nothing in it says so.
    fn ending(&self, phase: usize, for_s: u32, gap_s: u32) -> Option<Ending> {
        if gap_s >= self.plan.phases[phase].passage_s && !self.holds(phase) {
            return Some(Ending::GapOut);
        }
        if self.left_s(phase, for_s) > 0 {
            return None;
        }
        let is_over =
            |c: &Coordination| c.holds[phase] || self.clock_s >= self.end_s(c, phase, for_s);
        match self.plan.coordination.as_ref().is_some_and(is_over) {
            true => Some(Ending::ForceOff),
            false => Some(Ending::MaxOut),
        }
    }

    /// Whether the phase of a ring may end; a ring without one may.
    fn may_end(&self, ring: usize) -> bool {
        match self.stages[ring] {
            Stage::Idle => true,
            Stage::Change { .. } => false,
            Stage::Green { phase, for_s, gap_s, walk } => {
                let ends = self.ending(phase, for_s, gap_s).is_some();
                for_s >= self.least_s(phase, walk) && ends
            }
        }
    }

    /// Whether a phase of an existing plan waits at its force-off for the other ring: the last one was during its green, and
    /// is nearer than the next one.
    fn rests(&self, phase: usize, for_s: u32) -> bool {
        let Some(coordination) = self.plan.coordination.as_ref().filter(|_| self.plan.is_existing)
        else {
            return false;
        };
        let cycle_s = coordination.cycle_s;
        let since_s = (self.clock_s + cycle_s - coordination.ends_s[phase] % cycle_s) % cycle_s;
        !coordination.holds[phase] && for_s > since_s && 2 * since_s < cycle_s
    }

    /// Whether the phase of a ring may end to cross the barrier.
    fn may_cross(&self, ring: usize) -> bool {
        let waits = match self.stages[ring] {
            Stage::Green { phase, for_s, walk, .. } => {
                for_s >= self.least_s(phase, walk) && self.rests(phase, for_s)
            }
            _ => false,
        };
        waits || self.may_end(ring)
    }

    /// Returns the ring of a coordinated existing plan that crosses the barrier while the other one's green still lasts, and
    /// for how long, seconds: no longer than its change takes more time than the other one's.
    fn first_to_cross(&self) -> Option<(usize, u32)> {
        if !self.plan.is_existing || self.plan.coordination.is_none() {
            return None;
        }
        (0..2).find_map(|ring| {
            let Stage::Green { phase, .. } = self.stages[ring] else { return None };
            let Stage::Green { phase: other, for_s, walk, .. } = self.stages[1 - ring] else {
                return None;
            };
            let whole_s = |phase: usize| {
                let (yellow_s, red_s) = self.plan.phases[phase].change_s;
                yellow_s + red_s
            };
            let left_s = self.left_s(other, for_s);
            let is_due = left_s > 0 && left_s + whole_s(other) <= whole_s(phase);
            let is_fair = for_s + left_s >= self.least_s(other, walk);
            let others = &self.plan.phases[other].links;
            let is_trapped = |link: &usize| {
                self.links.turn(*link) == Some(Turn::Left)
                    && !others.contains(link)
                    && others.iter().any(|to| self.links.yields(*link, *to))
            };
            let is_trap = || self.plan.phases[phase].links.iter().any(is_trapped);
            let crosses = is_due && is_fair && self.may_cross(ring) && !is_trap();
            crosses.then_some((ring, left_s))
        })
    }

    /// Ends the green that was still to last when the other ring crossed the barrier, if its time is over, and says whether
    /// it does.
    fn follow(&mut self) -> bool {
        let Some(late) = self.late.filter(|late| late.left_s == 0) else { return false };
        self.late = None;
        let goes_on: Vec<usize> = [late.next, late.beside].into_iter().flatten().collect();
        self.change(&[(late.ring, late.next)], &goes_on);
        true
    }

    /// Whether a phase is called and not served.
    fn waits(&self, phase: usize, seen: &Seen) -> bool {
        let is_served = |stage: &Stage| match stage {
            Stage::Green { phase: p, .. } => *p == phase,
            _ => false,
        };
        (seen.calls[phase] || self.plan.phases[phase].recall)
            && !self.stages.iter().any(is_served)
            && self.fits(phase)
    }

    /// Returns the phase of a ring to which it can go on within the side.
    fn successor(&self, ring: usize, seen: &Seen) -> Option<usize> {
        let order = &self.plan.sides[self.side][ring];
        let called = |phases: &[usize]| phases.iter().copied().find(|next| self.waits(*next, seen));
        match self.stages[ring] {
            // In a cabinet the last phase of the other ring stays green for as long as this ring goes on, its longest green or not.
            Stage::Idle if self.plan.is_existing => called(order),
            Stage::Green { phase, .. } => {
                let place = order.iter().position(|p| *p == phase)?;
                let next = called(&order[place + 1..])?;
                let has_room = self.plan.is_existing || self.has_room(ring, phase, next, seen);
                has_room.then_some(next)
            }
            _ => None,
        }
    }

    /// Whether a phase of a ring can begin after another one, and last its least, before the other ring's last phase
    /// has been green for its longest.
    fn has_room(&self, ring: usize, phase: usize, next: usize, seen: &Seen) -> bool {
        let Stage::Green { phase: other, for_s, .. } = self.stages[1 - ring] else { return true };
        if self.plan.sides[self.side][1 - ring].last() != Some(&other) {
            return true;
        }
        let (yellow_s, red_s) = self.plan.phases[phase].change_s;
        let walk_s = seen.walk_s(next).unwrap_or(0);
        let needed_s = yellow_s + red_s + self.plan.phases[next].min_s.max(walk_s);
        needed_s <= self.left_s(other, for_s)
    }

    /// Lets rings go on within their side, and says whether one did.
    fn advance(&mut self, seen: &Seen) -> bool {
        if self.late.is_some() {
            return false;
        }
        let mut any = false;
        for ring in 0..2 {
            if let Some(next) = self.successor(ring, seen)
                && self.may_end(ring)
            {
                self.change(&[(ring, Some(next))], &[next]);
                any = true;
            }
        }
        any
    }

    /// Returns the side that is called next; this one, if it is called from its beginning.
    fn called_side(&self, seen: &Seen) -> Option<usize> {
        let count = self.plan.sides.len();
        let called = |side: &usize| {
            self.plan.sides[*side].iter().flatten().any(|phase| self.waits(*phase, seen))
        };
        let next = |k: usize| (self.side + k) % count;
        (1..=count).map(next).find(called).or_else(|| {
            // The limit holds even if nobody waits.
            let at_limit = |stage: &Stage| match stage {
                Stage::Green { phase, for_s, .. } => {
                    self.plan.phases[*phase].limit_s.is_some_and(|limit| *for_s >= limit)
                }
                _ => false,
            };
            let over = count > 1 && self.stages.iter().any(at_limit);
            over.then(|| next(1))
        })
    }

    /// Lets both rings cross the barrier if they may, and says whether they do.
    fn cross(&mut self, seen: &Seen) -> bool {
        if self.late.is_some() {
            return false;
        }
        let Some(side) = self.called_side(seen) else { return false };
        if (0..2).any(|ring| self.successor(ring, seen).is_some()) {
            return false;
        }
        let order = &self.plan.sides[self.side];
        let (mut all_may, mut forced, mut least, mut held) = (true, false, true, false);
        for (ring, order) in order.iter().enumerate() {
            all_may &= self.may_cross(ring);
            match self.stages[ring] {
                Stage::Idle => {}
                Stage::Change { .. } => least = false,
                Stage::Green { phase, for_s, walk, .. } => {
                    least &= for_s >= self.least_s(phase, walk);
                    let any_place = self.plan.coordination.is_some();
                    let is_last = any_place || order.last() == Some(&phase);
                    let is_over = self.left_s(phase, for_s) == 0;
                    // In a cabinet it rests until the other ring may end.
                    forced |= is_over && is_last && !self.plan.is_existing;
                    held |= self.holds(phase) && !is_over;
                }
            }
        }
        let together = all_may || (forced && least && !held);
        let again = side == self.side;
        let alone = if together || again { None } else { self.first_to_cross() };
        if !together && alone.is_none() {
            return false;
        }
        let first = |ring: usize| {
            let order = &self.plan.sides[side][ring];
            let called =
                |p: &&usize| (seen.calls[**p] || self.plan.phases[**p].recall) && self.fits(**p);
            let enters = |p: &&usize| self.plan.phases[**p].enters;
            let found = order.iter().find(called).or_else(|| order.iter().find(enters));
            // In a cabinet a ring without a call and without dual entry stays red.
            found.or(order.last().filter(|_| !self.plan.is_existing)).copied()
        };
        let nexts = [first(0), first(1)];
        let goes_on: Vec<usize> = nexts.into_iter().flatten().filter(|_| !again).collect();
        self.side = side;
        match alone {
            None => self.change(&[(0, nexts[0]), (1, nexts[1])], &goes_on),
            Some((ring, left_s)) => {
                let other = 1 - ring;
                let (next, beside) = (nexts[other], nexts[ring]);
                self.late = Some(Late { ring: other, left_s, next, beside });
                self.change(&[(ring, nexts[ring])], &goes_on);
            }
        }
        true
    }

    /// Whether a link yields in a phase to what is green in it, or may be beside it in the other ring.
    pub(super) fn yields(&self, link: usize, phase: usize, other_ring: &[usize]) -> bool {
        let phases = other_ring.iter().chain([&phase]);
        let mut others = phases.flat_map(|p| &self.plan.phases[*p].links);
        self.links.always_yields(link) || others.any(|other| self.links.yields(link, *other))
    }

    /// Returns what is green when a phase is alone.
    pub(super) fn alone(&self, phase: usize) -> String {
        let mut green = vec![false; self.links.count()];
        self.plan.phases[phase].links.iter().for_each(|link| green[*link] = true);
        let letters = self.links.letters(&green, &vec![false; green.len()]);
        letters.into_iter().map(char::from).collect()
    }
}

/// What the rings make of the links: who stays green, who turns yellow, who may turn green.
impl Rings {
    /// Lets rings change: what ends turns yellow.
    ///
    /// # Arguments
    ///
    /// * `goes_on` — the phases whose links stay green if they are.
    fn change(&mut self, changes: &[(usize, Option<usize>)], goes_on: &[usize]) {
        let mut coming = vec![false; self.links.count()];
        for next in goes_on {
            self.plan.phases[*next].links.iter().for_each(|link| coming[*link] = true);
        }
        for (ring, _) in changes {
            if let Stage::Green { phase, for_s, gap_s, .. } = self.stages[*ring] {
                let rests = || self.rests(phase, for_s).then_some(Ending::ForceOff);
                self.ended.push((phase, self.ending(phase, for_s, gap_s).or_else(rests)));
            }
        }
        let mut stages = self.stages.clone();
        let old: Vec<Option<usize>> = (changes.iter())
            .map(|(ring, _)| match self.stages[*ring] {
                Stage::Green { phase, .. } => Some(phase),
                _ => None,
            })
            .collect();
        for (ring, next) in changes {
            let mut held = Vec::new();
            if let Stage::Green { phase, .. } = self.stages[*ring] {
                let own = &self.plan.phases[phase].links;
                let stays = |link: &&usize| coming[**link] && self.green[**link];
                held.extend(own.iter().filter(stays));
            }
            stages[*ring] = Stage::Change { next: *next, left_s: 0, held };
        }
        self.stages = stages;
        let before = self.green.clone();
        let mut barred = vec![false; before.len()];
        loop {
            let mut after = self.staying();
            after.iter_mut().zip(&barred).for_each(|(after, barred)| *after &= !barred);
            let traps = |link: usize, other: usize| {
                let ends =
                    before[link] && !after[link] && self.links.turn(link) == Some(Turn::Left);
                ends && after[other] && self.links.yields(link, other)
            };
            let count = after.len();
            let trap: Vec<bool> =
                (0..count).map(|other| (0..count).any(|link| traps(link, other))).collect();
            if !trap.contains(&true) {
                self.end(&before, &after, changes, &old);
                return;
            }
            for stage in &mut self.stages {
                if let Stage::Change { held, .. } = stage {
                    held.retain(|link| !trap[*link]);
                }
            }
            // What stays by a phase that goes on has nobody who yields to it and ends; see `plan`.
            barred.iter_mut().zip(trap).for_each(|(barred, trap)| *barred |= trap);
        }
    }

    /// Lets links end that do not stay, and times the rings that change.
    ///
    /// # Arguments
    ///
    /// * `old` — the phases that were green in those rings.
    fn end(
        &mut self,
        before: &[bool],
        after: &[bool],
        changes: &[(usize, Option<usize>)],
        old: &[Option<usize>],
    ) {
        let change_s = |phase: usize| self.plan.phases[phase].change_s;
        let longest = |phases: &mut dyn Iterator<Item = usize>| {
            phases.map(change_s).fold((0, 0), |a, b| (a.0.max(b.0), (a.0 + a.1).max(b.0 + b.1)))
        };
        let letters = |green: &[bool]| -> String {
            green.iter().map(|green| if *green { 'G' } else { 'r' }).collect()
        };
        let change = self.timing.change(&letters(before), &letters(after));
        let of_all = change.map_or((0, 0), |c| (c.yellow_s, c.total_s()));
        for link in (0..before.len()).filter(|l| before[*l] && !after[*l]) {
            let (yellow_s, total_s) = match self.plan.is_existing {
                false => of_all,
                true => {
                    let ending = || old.iter().flatten().copied();
                    let own = |phase: &usize| self.plan.phases[*phase].links.contains(&link);
                    let of_link = longest(&mut ending().filter(own));
                    // What ends although its phase goes on ends with those that do.
                    if of_link == (0, 0) { longest(&mut ending()) } else { of_link }
                }
            };
            self.yellow_s[link] = yellow_s;
            self.clearing_s[link] = total_s;
        }
        let (_, coming) = self.claimed();
        for ((ring, _), old) in changes.iter().zip(old) {
            // A left turn that stays green but loses its right of way takes its change as well.
            let phase = old.map(|old| &self.plan.phases[old]);
            let loses = |link: &usize| {
                after[*link] && (0..coming.len()).any(|o| coming[o] && self.links.yields(*link, o))
            };
            let own_s = phase
                .filter(|phase| phase.links.iter().any(loses))
                .map_or(0, |phase| phase.change_s.0 + phase.change_s.1);
            let is_existing = self.plan.is_existing;
            let whole_s = phase.map_or(0, |phase| phase.change_s.0 + phase.change_s.1);
            if let Stage::Change { left_s, .. } = &mut self.stages[*ring] {
                *left_s = if is_existing { whole_s } else { of_all.1.max(own_s) };
            }
        }
        self.green = after.to_vec();
    }

    /// Returns the links that are green by a phase, and those that are about to be.
    fn claimed(&self) -> (Vec<bool>, Vec<bool>) {
        let (mut now, mut coming) =
            (vec![false; self.links.count()], vec![false; self.links.count()]);
        for stage in &self.stages {
            match stage {
                Stage::Idle => {}
                Stage::Green { phase, .. } => {
                    self.plan.phases[*phase].links.iter().for_each(|link| now[*link] = true);
                }
                Stage::Change { next, held, .. } => {
                    held.iter().for_each(|link| now[*link] = true);
                    let next = next.iter().flat_map(|p| &self.plan.phases[*p].links);
                    next.for_each(|link| coming[*link] = true);
                }
            }
        }
        (now, coming)
    }

    /// Returns the links that are green now and stay so with what the rings do.
    fn staying(&self) -> Vec<bool> {
        let (now, coming) = self.claimed();
        let mut stay: Vec<bool> = now.iter().zip(&self.green).map(|(a, b)| *a && *b).collect();
        for &link in &self.plan.overlaps {
            let free = self.is_free(link, &now)
                && self.is_free(link, &coming)
                && self.links.fits(link, &stay);
            stay[link] |= self.green[link] && free;
        }
        stay
    }

    /// Whether a link may be green beside others, and none of them would yield to it.
    fn is_free(&self, link: usize, others: &[bool]) -> bool {
        let yields = |other: usize| others[other] && self.links.yields(other, link);
        self.links.fits(link, others) && !(0..others.len()).any(yields)
    }

    /// Turns green what is to be.
    fn light(&mut self) {
        let (now, coming) = self.claimed();
        let mut green = self.staying();
        for link in 0..green.len() {
            green[link] |= now[link];
        }
        let clearing: Vec<bool> = self.clearing_s.iter().map(|s| *s > 0).collect();
        for &link in &self.plan.overlaps {
            green[link] |= self.clearing_s[link] == 0
                && self.is_free(link, &now)
                && self.is_free(link, &coming)
                && self.links.fits(link, &green)
                && self.is_free(link, &clearing);
        }
        self.green = green;
    }

    fn state(&self) -> String {
        let (_, coming) = self.claimed();
        let letters = self.links.letters(&self.green, &coming);
        let letter = |(link, letter): (usize, u8)| match letter {
            b'r' if self.yellow_s[link] > 0 => 'y',
            letter => char::from(letter),
        };
        letters.into_iter().enumerate().map(letter).collect()
    }
}
