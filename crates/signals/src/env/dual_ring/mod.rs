//! Dual-ring control of one signal: phases from its links, and how the rings go on, second by second.
//!
//! `links` says what may be green together, `plan` makes phases of it, or `existing` those of a plan that somebody brings,
//! `coordination` puts phases into a cycle, `told` says what runs. All are pure.
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

mod coordination;
mod existing;
mod links;
mod plan;
mod retimed;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
mod told;

use osm_signals::Turn;

use crate::control::dual_ring::Config;
use crate::existing::ExistingPlan;
use crate::junction::Set;
use crate::program::{ProgramPhase, RingStages};
use crate::sim::{Scene, SignalInfo};

use self::coordination::coordinate;
pub use self::existing::fixed_cycle;
use self::links::Links;
use self::plan::{Coordination, Phase, Plan, Side};
use super::derive::{DerivedSignal, PHASES_PROGRAM, greens};
use super::pedestrians::Pedestrians;
use crate::timing::{Timing, WALK_S};

/// What the detectors of a phase say in a second.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Seen {
    /// Whether a vehicle calls it.
    calls: bool,
    /// Whether a vehicle prolongs it.
    extends: bool,
    /// How long those take who wait at its crosswalks, seconds; absent without anybody or push buttons.
    walk_s: Option<u32>,
}

/// The green of a ring.
#[derive(Debug, Clone, Copy)]
struct Green {
    phase: usize,
    for_s: u32,
    /// Time since a vehicle was last seen.
    gap_s: u32,
    /// Since when and until when pedestrians cross, in its own time, seconds.
    walk: Option<(u32, u32)>,
}

/// What a ring does.
#[derive(Debug, Clone)]
enum Stage {
    /// Nothing: the side has no phase for it.
    Idle,
    Green(Green),
    Change {
        next: Option<usize>,
        left_s: u32,
        /// Links that stay green meanwhile.
        held: Set,
    },
}

impl Stage {
    fn begin(phase: Option<usize>) -> Self {
        phase.map_or(Self::Idle, |phase| {
            Self::Green(Green { phase, for_s: 0, gap_s: 0, walk: None })
        })
    }
}

/// The green of a ring that goes on for a moment while the other ring crosses the barrier already.
#[derive(Debug, Clone, Copy)]
struct Late {
    ring: usize,
    /// How long it still lasts, seconds.
    left_s: u32,
    /// The phase after it.
    next: Option<usize>,
    /// The phase that the other ring begins.
    beside: Option<usize>,
}

/// Dual-ring control of one signal.
#[derive(Debug, Clone)]
pub struct DualRing {
    links: Links,
    plan: Plan,
    timing: Timing,
    /// The stages that the rings follow within a cycle, and their cycle, with what is shown between them.
    told: Option<(RingStages, Vec<ProgramPhase>)>,
    side: usize,
    stages: [Stage; 2],
    /// The ring that has still to follow the other one across the barrier.
    late: Option<Late>,
    /// Time since the first coordinated phase could end, seconds; stands still without a cycle.
    clock_s: u32,
    /// Per phase, for how long it has been called without being green, seconds.
    waits_s: Vec<u32>,
    green: Set,
    /// Yellow that is left per link, seconds.
    yellow_s: Vec<u32>,
    /// Yellow and red that is left per link, seconds.
    clearing_s: Vec<u32>,
    /// What is shown now.
    pub shown: String,
}

impl DualRing {
    /// Returns the control of a signal that is about to begin, with other longest greens of its phases where some are given.
    pub fn new(
        scene: &Scene,
        signal: &SignalInfo,
        derived: &DerivedSignal,
        config: &Config,
        greens_s: &[f64],
    ) -> Self {
        let (links, plan) = planned(scene, signal, derived, config);
        Self::of(links, plan.with_longest(greens_s), derived.timing.clone())
    }

    /// Returns the control of a signal that is about to begin within a cycle, at a time in seconds; `None` where two rings cannot
    /// follow its stages.
    pub fn coordinated(
        scene: &Scene,
        signal: &SignalInfo,
        derived: &DerivedSignal,
        (config, stages): (&Config, &RingStages),
        now_s: f64,
    ) -> Option<Self> {
        let (links, plan) = planned(scene, signal, derived, config);
        let plan = coordinate(stages, plan, &links, &derived.timing, now_s.round() as u32)?;
        let cycle = cycle_of(stages, &derived.timing).into_iter();
        let cycle = cycle.map(|(state, s)| ProgramPhase::fixed(state, s)).collect();
        let told = Some((stages.clone(), cycle));
        Some(Self { told, ..Self::of(links, plan, derived.timing.clone()) })
    }

    /// Returns the control of a signal that runs an existing plan and sees vehicles.
    pub fn existing(
        scene: &Scene,
        signal: &SignalInfo,
        derived: &DerivedSignal,
        plan: &ExistingPlan,
    ) -> Result<Self, String> {
        let (links, plan) = existing::rings(plan, scene, signal, &derived.timing)?;
        Ok(Self::of(links, plan, derived.timing.clone()))
    }

    /// Returns the rings of a signal as they begin: the through phases of the main street are green, of a coordinated plan
    /// the coordinated phases.
    fn of(links: Links, plan: Plan, timing: Timing) -> Self {
        let count = links.cars.len();
        let holds = |phase: usize| plan.holds(phase);
        let has_held = |side: &Side| side.iter().flatten().any(|p| holds(*p));
        let side = plan.sides.iter().position(has_held).unwrap_or_default();
        let stages = plan.sides[side].each_ref();
        let stages =
            stages.map(|ring| Stage::begin(first(&plan, ring, &holds).or(ring.last().copied())));
        let mut rings = Self {
            clock_s: plan.coordination.as_ref().map_or(0, |c| c.begins_s),
            waits_s: vec![0; plan.phases.len()],
            green: links.set([]),
            links,
            plan,
            timing,
            told: None,
            side,
            stages,
            late: None,
            yellow_s: vec![0; count],
            clearing_s: vec![0; count],
            shown: String::new(),
        };
        rings.light();
        rings.shown = rings.state();
        rings
    }

    /// Lets a second go by and returns what is shown from then on, if it is something else.
    ///
    /// # Arguments
    ///
    /// * `nearest_m` — shape `[lanes of the scene]`; distance of the first vehicle of each lane to the stop line,
    ///   metres, infinite without one.
    /// * `pedestrians` — the time, seconds, and who wants to cross, where they push buttons.
    pub fn second(
        &mut self,
        nearest_m: &[f64],
        mut pedestrians: Option<(f64, &mut Pedestrians)>,
    ) -> Option<&str> {
        if let Some((now_s, pedestrians)) = &mut pedestrians {
            pedestrians.arrive(*now_s);
        }
        let waits = |crossing: usize| pedestrians.as_ref().is_some_and(|(_, p)| p.waits(crossing));
        let seen = |phase: &Phase| {
            let mut on =
                phase.detectors.iter().filter(|d| nearest_m[d.lane] <= d.reach_m).peekable();
            let extends = phase.is_full || on.peek().is_some();
            let is_called = on.any(|d| {
                let is_green = |link: &usize| self.green.contains(*link);
                d.calls && (d.served_by.is_empty() || !d.served_by.iter().all(is_green))
            });
            let waiting = phase.crossings.iter().filter(|(crossing, _)| waits(*crossing));
            let walk_s = waiting.map(|(_, takes_s)| *takes_s).max();
            Seen { calls: is_called || walk_s.is_some(), extends, walk_s }
        };
        let seen: Vec<Seen> = self.plan.phases.iter().map(seen).collect();
        let before = self.shown.clone();
        self.step(&seen);
        if let Some((now_s, pedestrians)) = pedestrians {
            let walking = self.walking().map(|phase| &self.plan.phases[phase]);
            for (crossing, _) in walking.flat_map(|phase| &phase.crossings) {
                pedestrians.go(*crossing, now_s);
            }
        }
        (self.shown != before).then_some(&self.shown)
    }

    fn links_of(&self, phase: usize) -> &Set {
        &self.plan.phases[phase].links
    }

    fn greens(&self) -> impl Iterator<Item = &Green> + '_ {
        [0, 1].into_iter().filter_map(|ring| self.green_of(ring))
    }

    fn green_of(&self, ring: usize) -> Option<&Green> {
        if let Stage::Green(green) = &self.stages[ring] { Some(green) } else { None }
    }

    fn green_phases(&self) -> impl Iterator<Item = usize> + '_ {
        self.greens().map(|green| green.phase)
    }

    /// Returns the phases whose crosswalks show WALK.
    fn walking(&self) -> impl Iterator<Item = usize> + '_ {
        // On recall a walk begins with every green.
        let recalls = self.timing.recalls_pedestrians();
        let walks = move |g: &&Green| {
            let began_s = g.walk.map(|(began_s, _)| began_s).or(recalls.then_some(0));
            began_s.is_some_and(|began_s| g.for_s - began_s < WALK_S)
        };
        self.greens().filter(walks).map(|green| green.phase)
    }

    /// Whether a link yields in a phase to what is green in it, or may be beside it in the other ring.
    fn yields(&self, link: usize, phase: usize, other_ring: &[usize]) -> bool {
        let mut phases = other_ring.iter().chain([&phase]);
        self.links.minor.contains(link)
            || phases.any(|p| self.links.yields_to(link, self.links_of(*p)))
    }

    /// Lets a second go by, at the end of which the detectors of the phases see something.
    fn step(&mut self, seen: &[Seen]) {
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
        if moves {
            self.light();
            self.shown = self.state();
        }
    }

    fn elapse(&mut self, seen: &[Seen]) {
        for stage in &mut self.stages {
            match stage {
                Stage::Idle => {}
                Stage::Green(green) => {
                    green.for_s += 1;
                    green.gap_s = if seen[green.phase].extends { 0 } else { green.gap_s + 1 };
                }
                Stage::Change { left_s, .. } => *left_s = left_s.saturating_sub(1),
            }
        }
        if let Some(cycle) = &self.plan.coordination {
            self.clock_s = (self.clock_s + 1) % cycle.cycle_s;
            let waits_s = self.waits_s.iter().enumerate();
            let next_s = |(p, s)| if self.waits(p, seen) { s + 1 } else { 0 };
            self.waits_s = waits_s.map(next_s).collect();
        }
        let late = self.late.iter_mut().map(|late| &mut late.left_s);
        let clocks = self.yellow_s.iter_mut().chain(&mut self.clearing_s).chain(late);
        clocks.for_each(|s| *s = s.saturating_sub(1));
    }

    /// Begins the phases whose change is over, and says whether one did.
    fn begin(&mut self) -> bool {
        let clearing = self.clearing();
        let mut any = false;
        for stage in &mut self.stages {
            let Stage::Change { next, left_s: 0, .. } = *stage else { continue };
            let clear = |l: usize| !clearing.contains(l) && self.links.fits(l, &clearing);
            if next.is_none_or(|phase| self.plan.phases[phase].links.ones().all(clear)) {
                *stage = Stage::begin(next);
                any = true;
            }
        }
        any
    }

    /// Lets those begin to walk who wait at the crosswalks of what is green, if it may still last as long as they
    /// take.
    fn walk(&mut self, seen: &[Seen]) {
        for ring in 0..2 {
            let Some(green) = self.green_of(ring) else { continue };
            let is_over = green.walk.is_none_or(|(_, end_s)| green.for_s >= end_s);
            let has_room =
                |s: &u32| green.for_s == 0 || self.greens().all(|g| *s <= self.left_s(g));
            let takes_s = seen[green.phase].walk_s.filter(|s| is_over && has_room(s));
            if let (Some(takes_s), Stage::Green(green)) = (takes_s, &mut self.stages[ring]) {
                green.walk = Some((green.for_s, green.for_s + takes_s));
            }
        }
    }

    /// Whether a green has lasted its shortest time, pedestrians included.
    fn has_least(&self, green: &Green) -> bool {
        green.for_s >= self.least_s(green)
    }

    fn least_s(&self, green: &Green) -> u32 {
        self.plan.phases[green.phase].min_s.max(green.walk.map_or(0, |(_, end_s)| end_s))
    }

    /// Returns how long a green may still last while another phase is called, seconds.
    fn left_s(&self, &Green { phase, for_s, .. }: &Green) -> u32 {
        let max_s = self.plan.phases[phase].max_s.saturating_sub(for_s);
        let Some(cycle) = &self.plan.coordination else { return max_s };
        if !cycle.holds[phase] {
            let left_s = self.end_s(cycle, phase, for_s).saturating_sub(self.clock_s);
            return if cycle.inhibits_max[phase] { left_s } else { left_s.min(max_s) };
        }
        let end_s = cycle.ends_s[phase];
        match (cycle.cycle_s + end_s - self.clock_s) % cycle.cycle_s {
            // One that became green after that moment waits for the next cycle.
            _ if self.clock_s >= end_s && for_s > self.clock_s - end_s => 0,
            0 => cycle.cycle_s,
            next_s => next_s,
        }
    }

    /// Returns when the cycle ends the green of a phase that is not coordinated, seconds of the clock.
    fn end_s(&self, cycle: &Coordination, phase: usize, for_s: u32) -> u32 {
        match cycle.ends_s[phase].checked_sub(cycle.cycle_s) {
            // One that was green before that moment of this cycle ends there, one that began after it in the next cycle.
            Some(now_s) if self.clock_s < now_s || for_s > self.clock_s - now_s => now_s,
            _ => cycle.ends_s[phase],
        }
    }

    /// Whether a phase that is called may last its least before the cycle ends it. One whose split has no more room than its
    /// least begins whenever it is called within its split, and overruns it. So does one that has waited for a whole cycle:
    /// nobody waits for ever.
    fn fits(&self, phase: usize) -> bool {
        let Some(cycle) = &self.plan.coordination else { return true };
        let Some(split_s) = cycle.splits_s[phase] else { return false };
        let own = &self.plan.phases[phase];
        let before_s = self.green_phases().map(|p| self.plan.phases[p].change.total_s()).max();
        let least_s = if own.min_s + own.change.total_s() < split_s { own.min_s } else { 0 };
        cycle.holds[phase]
            || self.waits_s[phase] >= cycle.cycle_s
            || self.clock_s + before_s.unwrap_or(0) + least_s <= self.end_s(cycle, phase, 0)
    }

    /// Whether the phase of a green says that it ends now.
    fn is_over(&self, green: &Green) -> bool {
        let has_gap = green.gap_s >= self.plan.phases[green.phase].passage_s;
        has_gap && !self.plan.holds(green.phase) || self.left_s(green) == 0
    }

    /// Whether the phase of a ring may end; a ring without one may.
    fn may_end(&self, ring: usize) -> bool {
        match &self.stages[ring] {
            Stage::Idle => true,
            Stage::Change { .. } => false,
            Stage::Green(green) => self.has_least(green) && self.is_over(green),
        }
    }

    /// Returns the cycle of an existing plan.
    fn cabinet_cycle(&self) -> Option<&Coordination> {
        self.plan.coordination.as_ref().filter(|_| self.plan.is_existing)
    }

    /// Whether a phase of an existing plan waits at its force-off for the other ring: the last one was during its green, and
    /// is nearer than the next one.
    fn rests(&self, green: &Green) -> bool {
        self.cabinet_cycle().is_some_and(|cycle| {
            let cycle_s = cycle.cycle_s;
            let end_s = cycle.ends_s[green.phase] % cycle_s;
            let since_s = (self.clock_s + cycle_s - end_s) % cycle_s;
            !cycle.holds[green.phase] && green.for_s > since_s && 2 * since_s < cycle_s
        })
    }

    /// Whether the phase of a ring may end to cross the barrier.
    fn may_cross(&self, ring: usize) -> bool {
        let waits = |green| self.has_least(green) && self.rests(green);
        self.may_end(ring) || self.green_of(ring).is_some_and(waits)
    }

    /// Returns the ring of a coordinated existing plan that crosses the barrier while the other one's green still lasts, and
    /// for how long, seconds: no longer than its change takes more time than the other one's.
    fn first_to_cross(&self) -> Option<(usize, u32)> {
        self.cabinet_cycle()?;
        (0..2).find_map(|ring| {
            let (own, other) = (self.green_of(ring)?, self.green_of(1 - ring)?);
            let change_s = |green: &Green| self.plan.phases[green.phase].change.total_s();
            let left_s = self.left_s(other);
            let is_due = left_s > 0 && left_s + change_s(other) <= change_s(own);
            let is_fair = other.for_s + left_s >= self.least_s(other);
            let others = self.links_of(other.phase);
            let is_left = |link: &usize| self.links.turn(*link) == Some(Turn::Left);
            let mut lefts = self.links_of(own.phase).difference(others).filter(is_left);
            let mut is_trap = || lefts.any(|link| self.links.yields_to(link, others));
            (is_due && is_fair && self.may_cross(ring) && !is_trap()).then_some((ring, left_s))
        })
    }

    /// Ends the green that was still to last when the other ring crossed the barrier, if its time is over, and says whether
    /// it does.
    fn follow(&mut self) -> bool {
        let Some(late) = self.late.take_if(|late| late.left_s == 0) else { return false };
        let goes_on: Vec<usize> = [late.next, late.beside].into_iter().flatten().collect();
        self.change(&[(late.ring, late.next)], &goes_on);
        true
    }

    fn is_called(&self, phase: usize, seen: &[Seen]) -> bool {
        seen[phase].calls || self.plan.phases[phase].recall
    }

    /// Whether a phase is called and not served.
    fn waits(&self, phase: usize, seen: &[Seen]) -> bool {
        self.is_called(phase, seen) && self.green_phases().all(|green| green != phase)
    }

    /// Returns the phase of a ring to which it can go on within the side.
    fn successor(&self, ring: usize, seen: &[Seen]) -> Option<usize> {
        let order = &self.plan.sides[self.side][ring];
        let waits = |next: &usize| self.waits(*next, seen) && self.fits(*next);
        let called = |phases: &[usize]| phases.iter().copied().find(waits);
        match &self.stages[ring] {
            // In a cabinet the last phase of the other ring stays green for as long as this ring goes on, its longest green or not.
            Stage::Idle if self.plan.is_existing => called(order),
            Stage::Green(green) => {
                let place = order.iter().position(|p| *p == green.phase)?;
                let has_room = |next: &usize| {
                    self.plan.is_existing || self.has_room(ring, green.phase, *next, seen)
                };
                called(&order[place + 1..]).filter(has_room)
            }
            _ => None,
        }
    }

    /// Whether a phase of a ring can begin after another one, and last its least, before the other ring's last phase
    /// has been green for its longest.
    fn has_room(&self, ring: usize, phase: usize, next: usize, seen: &[Seen]) -> bool {
        let last = self.plan.sides[self.side][1 - ring].last();
        let Some(other) = self.green_of(1 - ring).filter(|g| last == Some(&g.phase)) else {
            return true;
        };
        let least_s = self.plan.phases[next].min_s.max(seen[next].walk_s.unwrap_or(0));
        self.plan.phases[phase].change.total_s() + least_s <= self.left_s(other)
    }

    /// Lets rings go on within their side, and says whether one did.
    fn advance(&mut self, seen: &[Seen]) -> bool {
        let mut any = false;
        for ring in 0..2 {
            let next =
                self.successor(ring, seen).filter(|_| self.late.is_none() && self.may_end(ring));
            if let Some(next) = next {
                self.change(&[(ring, Some(next))], &[next]);
                any = true;
            }
        }
        any
    }

    /// Returns the side that is called next; this one, if it is called from its beginning.
    fn called_side(&self, seen: &[Seen]) -> Option<usize> {
        let count = self.plan.sides.len();
        let waits = |phase: &usize| self.waits(*phase, seen) && self.fits(*phase);
        let called = |side: &usize| self.plan.sides[*side].iter().flatten().any(waits);
        let next = |k: usize| (self.side + k) % count;
        (1..=count).map(next).find(called).or_else(|| {
            // The limit holds even if nobody waits.
            let at_limit =
                |g: &Green| self.plan.phases[g.phase].limit_s.is_some_and(|s| g.for_s >= s);
            (count > 1 && self.greens().any(at_limit)).then(|| next(1))
        })
    }

    /// Lets both rings cross the barrier if they may, and says whether they do.
    fn cross(&mut self, seen: &[Seen]) -> bool {
        let goes_on = (0..2).any(|ring| self.successor(ring, seen).is_some());
        let Some(side) = self.called_side(seen).filter(|_| self.late.is_none() && !goes_on) else {
            return false;
        };
        let together = self.may_cross_together();
        let alone = if together || side == self.side { None } else { self.first_to_cross() };
        if !together && alone.is_none() {
            return false;
        }
        let nexts = self.plan.sides[side].each_ref().map(|order| {
            let first = first(&self.plan, order, &|p| self.is_called(p, seen) && self.fits(p));
            // In a cabinet a ring without a call and without dual entry stays red.
            first.or(order.last().copied().filter(|_| !self.plan.is_existing))
        });
        let goes_on: Vec<usize> =
            nexts.into_iter().flatten().filter(|_| side != self.side).collect();
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

    /// Whether both rings may cross the barrier at once: both may end, or one at its longest takes the other along.
    fn may_cross_together(&self) -> bool {
        let order = &self.plan.sides[self.side];
        let is_over = |green: &Green| self.left_s(green) == 0;
        let forces = |ring: usize| {
            let any_place = self.plan.coordination.is_some();
            let is_last = |g: &Green| any_place || order[ring].last() == Some(&g.phase);
            self.green_of(ring).is_some_and(|green| is_over(green) && is_last(green))
        };
        let may_be_taken = |stage: &Stage| match stage {
            Stage::Idle => true,
            Stage::Change { .. } => false,
            Stage::Green(g) => self.has_least(g) && (is_over(g) || !self.plan.holds(g.phase)),
        };
        // In a cabinet it rests until the other ring may end.
        let is_forced = || !self.plan.is_existing && (0..2).any(forces);
        (0..2).all(|ring| self.may_cross(ring))
            || (is_forced() && self.stages.iter().all(may_be_taken))
    }
}

/// What the rings make of the links: who stays green, who turns yellow, who may turn green.
impl DualRing {
    /// Lets rings change: what ends turns yellow.
    ///
    /// # Arguments
    ///
    /// * `goes_on` — the phases whose links stay green if they are.
    fn change(&mut self, changes: &[(usize, Option<usize>)], goes_on: &[usize]) {
        let mut coming = self.links.set([]);
        goes_on.iter().for_each(|next| coming.union_with(self.links_of(*next)));
        let mut old = Vec::new();
        for &(ring, next) in changes {
            let mut held = self.links.set([]);
            if let Some(green) = self.green_of(ring).copied() {
                held = &(self.links_of(green.phase) & &coming) & &self.green;
                old.push((ring, green.phase));
            }
            self.stages[ring] = Stage::Change { next, left_s: 0, held };
        }
        let before = self.green.clone();
        let mut barred = self.links.set([]);
        loop {
            let mut after = self.staying();
            after.difference_with(&barred);
            let ends =
                before.difference(&after).filter(|l| self.links.turn(*l) == Some(Turn::Left));
            let mut trap = self.links.set([]);
            ends.for_each(|link| trap.union_with(&self.links.yields[link]));
            trap.intersect_with(&after);
            if trap.is_clear() {
                return self.end(&before, after, changes, &old);
            }
            for stage in &mut self.stages {
                if let Stage::Change { held, .. } = stage {
                    held.difference_with(&trap);
                }
            }
            // What stays by a phase that goes on has nobody who yields to it and ends; see `plan`.
            barred.union_with(&trap);
        }
    }

    /// Lets links end that do not stay, and times the rings that change.
    ///
    /// # Arguments
    ///
    /// * `old` — the rings that were green, with their phases.
    fn end(
        &mut self,
        before: &Set,
        after: Set,
        changes: &[(usize, Option<usize>)],
        old: &[(usize, usize)],
    ) {
        let longest = |is: &dyn Fn(usize) -> bool| {
            let ending = old.iter().filter(|(_, phase)| is(*phase));
            let changes = ending.map(|(_, phase)| self.plan.phases[*phase].change);
            changes.fold((0, 0), |(y, all), c| (c.yellow_s.max(y), c.total_s().max(all)))
        };
        let change = self.timing.change(&self.links.plain(before), &self.links.plain(&after));
        let of_all = change.map_or((0, 0), |c| (c.yellow_s, c.total_s()));
        for link in before.difference(&after) {
            (self.yellow_s[link], self.clearing_s[link]) = match self.plan.is_existing {
                false => of_all,
                true => match longest(&|phase| self.links_of(phase).contains(link)) {
                    // What ends although its phase goes on ends with those that do.
                    (0, 0) => longest(&|_| true),
                    of_link => of_link,
                },
            };
        }
        let (_, coming) = self.claimed();
        for &(ring, _) in changes {
            let phase = old.iter().find(|(of, _)| *of == ring).map(|(_, phase)| *phase);
            let is_existing = self.plan.is_existing;
            // A left turn that stays green but loses its right of way takes its change as well.
            let loses = |l: usize| after.contains(l) && self.links.yields_to(l, &coming);
            let takes = phase.filter(|p| is_existing || self.links_of(*p).ones().any(loses));
            let own_s = takes.map_or(0, |phase| self.plan.phases[phase].change.total_s());
            if let Stage::Change { left_s, .. } = &mut self.stages[ring] {
                *left_s = if is_existing { own_s } else { own_s.max(of_all.1) };
            }
        }
        self.green = after;
    }

    /// Returns the links whose yellow or red is not over.
    fn clearing(&self) -> Set {
        self.links.set((0..self.clearing_s.len()).filter(|link| self.clearing_s[*link] > 0))
    }

    /// Returns the links that are green by a phase, and those that are about to be.
    fn claimed(&self) -> (Set, Set) {
        let (mut now, mut coming) = (self.links.set([]), self.links.set([]));
        for stage in &self.stages {
            match stage {
                Stage::Idle => {}
                Stage::Green(green) => now.union_with(self.links_of(green.phase)),
                Stage::Change { next, held, .. } => {
                    now.union_with(held);
                    next.iter().for_each(|phase| coming.union_with(self.links_of(*phase)));
                }
            }
        }
        (now, coming)
    }

    /// Returns the links that are green now and stay so with what the rings do.
    fn staying(&self) -> Set {
        let (now, coming) = self.claimed();
        let is_green = |link: &&usize| self.green.contains(**link);
        self.with_overlaps(&now & &self.green, &[&now, &coming], &is_green)
    }

    /// Returns links with the overlaps that may be green beside them and others, none of which would yield to them.
    fn with_overlaps(&self, mut green: Set, others: &[&Set], may: &dyn Fn(&&usize) -> bool) -> Set {
        for &link in self.plan.overlaps.iter().filter(may) {
            let is_free = |others: &&Set| {
                self.links.fits(link, others)
                    && !others.ones().any(|o| self.links.yields[o].contains(link))
            };
            if others.iter().all(is_free) && self.links.fits(link, &green) {
                green.insert(link);
            }
        }
        green
    }

    /// Turns green what is to be.
    fn light(&mut self) {
        let ((now, coming), clearing) = (self.claimed(), self.clearing());
        let is_clear = |link: &&usize| !clearing.contains(**link);
        let others = [&now, &coming, &clearing];
        self.green = self.with_overlaps(&self.staying() | &now, &others, &is_clear);
    }

    fn state(&self) -> String {
        let letters = self.links.letters(&self.green, &self.claimed().1);
        let letter = |(c, yellow_s): (char, &u32)| if c == 'r' && *yellow_s > 0 { 'y' } else { c };
        letters.chars().zip(&self.yellow_s).map(letter).collect()
    }
}

/// Returns the first phase of a ring that is one, else the first that is green beside the other ring.
fn first(plan: &Plan, ring: &[usize], is: &dyn Fn(usize) -> bool) -> Option<usize> {
    let mut phases = ring.iter().copied();
    phases.find(|p| is(*p)).or_else(|| ring.iter().copied().find(|p| plan.phases[*p].enters))
}

/// Returns the states of a cycle of stages, the changes between them included, with their durations, seconds.
pub fn cycle_of(stages: &RingStages, timing: &Timing) -> Vec<(String, f64)> {
    let next = stages.greens.iter().cycle().skip(1);
    let with_change = |(green, next): (&ProgramPhase, &ProgramPhase)| {
        let change = timing.between(&green.state, &next.state).into_iter();
        let change = change.map(|(state, s)| (state, f64::from(s)));
        std::iter::once((green.state.clone(), green.duration_s)).chain(change)
    };
    stages.greens.iter().zip(next).flat_map(with_change).collect()
}

/// Returns the phases of a signal as they follow from its programs, whatever drives it.
fn planned(
    scene: &Scene,
    signal: &SignalInfo,
    derived: &DerivedSignal,
    config: &Config,
) -> (Links, Plan) {
    let timing = &derived.timing;
    let programs = || signal.programs.iter();
    let witnesses = programs()
        .filter(|program| [signal.active_program.as_str(), PHASES_PROGRAM].contains(&&*program.id));
    let states = witnesses.flat_map(|program| greens(program, timing)).collect();
    let mut links = Links::new(scene, signal, states);
    // Only programs that were made with the setting say by their arrows who has one.
    let is_generated = programs().any(|program| program.id == PHASES_PROGRAM);
    links.arrows_only = !timing.settings.left_turns.is_network() && is_generated;
    links.has_inner = derived.spec.movements.iter().any(|movement| !movement.inner.is_empty());
    let plan = Plan::new(&links, &derived.own_greens, timing, config);
    (links, plan)
}
