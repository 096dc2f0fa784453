//! How the rings go on, second by second.
//!
//! A green may end once it has lasted its least and nobody has passed its detectors for the passage time, or it has
//! lasted its longest, and another phase is called that cannot run beside it:
//! - **Within a side** the ring goes on to its next phase that is called; the other ring does not notice.
//! - **Across a barrier** both rings go together, when neither has a called phase left and both may end. A through
//!   phase at its longest takes the other ring with it. The next side is the first in order of which a phase is
//!   called. A ring without a call there serves its through phase beside the other ring's (dual entry).
//! - **Back to the same side**, for a left turn that came too late: both rings end first.
//!
//! What is never shown, whatever the plan says:
//! - a link beside one that it conflicts with, or before that one's yellow and red are over;
//! - the yellow of a left turn that yields, beside the green of whom it yields to (the yellow trap): that green ends
//!   with it;
//! - a green shorter than its least. A phase begins within a side only if the other ring can wait for it.
//!
//! A link that is green in a phase and in the one after it stays green in between, as in every other program here.

mod lights;

use super::links::Links;
use super::plan::Plan;
use crate::traffic::timing::Timing;

/// What the detectors of every phase say in a second.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Seen {
    /// Whether a vehicle calls it.
    pub(super) calls: Vec<bool>,
    /// Whether a vehicle prolongs it.
    pub(super) extends: Vec<bool>,
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
    },
    Change {
        next: Option<usize>,
        left_s: u32,
        /// Links that stay green meanwhile.
        held: Vec<usize>,
    },
}

/// The rings of a signal.
#[derive(Debug, Clone)]
pub(super) struct Rings {
    links: Links,
    plan: Plan,
    timing: Timing,
    passage_s: u32,
    side: usize,
    stages: [Stage; 2],
    green: Vec<bool>,
    /// Yellow that is left per link, seconds.
    yellow_s: Vec<u32>,
    /// Yellow and red that is left per link, seconds.
    clearing_s: Vec<u32>,
    shown: String,
}

impl Rings {
    /// Returns the rings of a signal as they begin: the through phases of the main street are green.
    pub(super) fn new(links: Links, plan: Plan, timing: Timing, passage_s: u32) -> Self {
        let count = links.count();
        let stage = |ring: &Vec<usize>| match ring.last() {
            Some(&phase) => Stage::Green { phase, for_s: 0, gap_s: 0 },
            None => Stage::Idle,
        };
        let [first, second] = &plan.sides[0];
        let stages = [stage(first), stage(second)];
        let mut rings = Self {
            links,
            plan,
            timing,
            passage_s,
            side: 0,
            stages,
            green: vec![false; count],
            yellow_s: vec![0; count],
            clearing_s: vec![0; count],
            shown: String::new(),
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

    /// Lets a second go by, at the end of which the detectors see something, and returns what is shown from then
    /// on, if it is something else.
    pub(super) fn second(&mut self, seen: &Seen) -> Option<&str> {
        let mut moves = self.clearing_s.iter().any(|s| *s > 0);
        self.elapse(seen);
        moves |= self.begin();
        // A change that takes no time may lead to a next one.
        while self.advance(seen) || self.cross(seen) {
            moves = true;
            if !self.begin() {
                break;
            }
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
                Stage::Green { phase, for_s, gap_s } => {
                    *for_s += 1;
                    *gap_s = if seen.extends[*phase] { 0 } else { *gap_s + 1 };
                }
                Stage::Change { left_s, .. } => *left_s = left_s.saturating_sub(1),
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
                    self.stages[ring] = Stage::Green { phase, for_s: 0, gap_s: 0 };
                }
                Some(_) => continue,
            }
            any = true;
        }
        any
    }

    /// Whether the phase of a ring may end; a ring without one may.
    fn may_end(&self, ring: usize) -> bool {
        match self.stages[ring] {
            Stage::Idle => true,
            Stage::Change { .. } => false,
            Stage::Green { phase, for_s, gap_s } => {
                let p = &self.plan.phases[phase];
                for_s >= p.min_s && (gap_s >= self.passage_s || for_s >= p.max_s)
            }
        }
    }

    /// Whether a phase is called and not served.
    fn waits(&self, phase: usize, seen: &Seen) -> bool {
        let is_served = |stage: &Stage| match stage {
            Stage::Green { phase: p, .. } => *p == phase,
            _ => false,
        };
        (seen.calls[phase] || self.plan.phases[phase].recall) && !self.stages.iter().any(is_served)
    }

    /// Returns the phase of a ring to which it can go on within the side.
    fn successor(&self, ring: usize, seen: &Seen) -> Option<usize> {
        let Stage::Green { phase, .. } = self.stages[ring] else { return None };
        let order = &self.plan.sides[self.side][ring];
        let place = order.iter().position(|p| *p == phase)?;
        let next = *order[place + 1..].iter().find(|next| self.waits(**next, seen))?;
        self.has_room(ring, phase, next).then_some(next)
    }

    /// Whether a phase of a ring can begin after another one, and last its least, before the other ring's last phase
    /// has been green for its longest.
    fn has_room(&self, ring: usize, phase: usize, next: usize) -> bool {
        let Stage::Green { phase: other, for_s, .. } = self.stages[1 - ring] else { return true };
        if self.plan.sides[self.side][1 - ring].last() != Some(&other) {
            return true;
        }
        let (yellow_s, red_s) = self.plan.phases[phase].change_s;
        let needed_s = yellow_s + red_s + self.plan.phases[next].min_s;
        for_s + needed_s <= self.plan.phases[other].max_s
    }

    /// Lets rings go on within their side, and says whether one did.
    fn advance(&mut self, seen: &Seen) -> bool {
        let mut any = false;
        for ring in 0..2 {
            if let Some(next) = self.successor(ring, seen)
                && self.may_end(ring)
            {
                self.change(&[(ring, Some(next))], true);
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
        let Some(side) = self.called_side(seen) else { return false };
        if (0..2).any(|ring| self.successor(ring, seen).is_some()) {
            return false;
        }
        let order = &self.plan.sides[self.side];
        let (mut all_may, mut forced, mut least) = (true, false, true);
        for ring in 0..2 {
            all_may &= self.may_end(ring);
            match self.stages[ring] {
                Stage::Idle => {}
                Stage::Change { .. } => least = false,
                Stage::Green { phase, for_s, .. } => {
                    let p = &self.plan.phases[phase];
                    least &= for_s >= p.min_s;
                    forced |= for_s >= p.max_s && order[ring].last() == Some(&phase);
                }
            }
        }
        if !(all_may || (forced && least)) {
            return false;
        }
        let first = |ring: usize| {
            let order = &self.plan.sides[side][ring];
            let called = |p: &&usize| seen.calls[**p] || self.plan.phases[**p].recall;
            order.iter().find(called).or(order.last()).copied()
        };
        let changes = [(0, first(0)), (1, first(1))];
        let again = side == self.side;
        self.side = side;
        self.change(&changes, !again);
        true
    }

    /// Returns what is green when a phase is alone.
    pub(super) fn alone(&self, phase: usize) -> String {
        let mut green = vec![false; self.links.count()];
        self.plan.phases[phase].links.iter().for_each(|link| green[*link] = true);
        let letters = self.links.letters(&green, &vec![false; green.len()]);
        letters.into_iter().map(char::from).collect()
    }
}
