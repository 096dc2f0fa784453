//! Who wants to cross at one signal, when, and how long they wait.
//!
//! Pedestrians of each crosswalk are a Poisson process from a random stream of its own, so that every method meets
//! the same ones. Whoever comes while others begin to walk (WALK, 7 s) goes with them; everybody else pushes the
//! button and waits for the next WALK. Those who still wait at the end count with their wait until then.
//!
//! **On recall** nobody pushes a button. The delay of a crosswalk is then that of somebody who comes at any time: over the times
//! r in which nobody may begin to cross, the sum of r squared over twice the time of the episode, which for a fixed cycle is
//! the manual's formula (HCM, 6th edition, chapter 19). People begin to cross in WALK and 4 s after it (effective walk time).
//! A crosswalk without any WALK has no delay: nobody is served there.
//!
//! When WALK begins is up to what drives the signal:
//! - **the cabinet**, which a controller's decisions drive, and **two rings**: when a green that serves a waiting
//!   crosswalk begins, or at once if it is green and may still last as long as it takes;
//! - **a program**: when greens in a row that serve the crosswalk begin, if they leave it enough time; see
//!   [`Timing::walks`].

use std::ops::AddAssign;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha12Rng;

use crate::sim::Program;
use crate::timing::{Timing, WALK_S, Walk};
use basics::seed;
use basics::units::SECONDS_PER_HOUR;

/// Wait after which the cabinet itself serves whoever waits, whatever the controller asks for, seconds: the
/// cycle that the Signal Timing Manual (2nd ed., chapter 6) does not want exceeded where people walk. Our choice.
pub const LONGEST_WAIT_S: f64 = 120.0;

/// Time after WALK in which people still begin to cross, seconds (HCM, chapter 19).
const AFTER_WALK_S: f64 = 4.0;

/// Those of one crosswalk.
#[derive(Debug, Clone, PartialEq, Default)]
struct Crossing {
    /// When they come, latest first, seconds.
    to_come: Vec<f64>,
    /// When those came who wait, in their order.
    waiting: Vec<f64>,
    /// Time since WALK began under a program; none while nobody may walk.
    walk_s: Option<u32>,
    /// Whether somebody may have to wait at it.
    counts: bool,
    totals: PedestrianTotals,
    /// Until when people could last begin to cross, seconds.
    open_until_s: f64,
    /// Sum of the squares of the times in which nobody could.
    closed_s2: f64,
}

/// Those of one signal.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Pedestrians {
    crossings: Vec<Crossing>,
    /// When the episode began, seconds.
    begin_s: f64,
    /// Whether nobody pushes buttons.
    recalls: bool,
    /// Of the program, per crosswalk what each phase is to it; empty before its first second.
    walks: Vec<Vec<Walk>>,
    /// The phase of the program in the last second.
    phase: Option<usize>,
}

/// How many there were at a crosswalk, and how long they waited; on recall one who comes at any time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PedestrianTotals {
    /// Pedestrians.
    pub count: u32,
    /// Sum of their waits, seconds.
    pub wait_s: f64,
    /// Crosswalks at which people would have crossed, but that never had WALK.
    pub unserved: u32,
}

impl AddAssign for PedestrianTotals {
    fn add_assign(&mut self, other: Self) {
        self.count += other.count;
        self.wait_s += other.wait_s;
        self.unserved += other.unserved;
    }
}

impl PedestrianTotals {
    /// Returns the mean delay, seconds; `None` without anybody.
    pub fn delay_s(self) -> Option<f64> {
        (self.count > 0).then(|| self.wait_s / f64::from(self.count))
    }
}

impl Pedestrians {
    /// Draws the pedestrians of an episode.
    ///
    /// # Arguments
    ///
    /// * `crossings` — of every crosswalk the edge that it leads over, and people per hour; none where no green ever lets
    ///   anybody cross, or each of the signal's own program does.
    /// * `recalls` — whether nobody pushes buttons.
    pub fn new(
        crossings: &[Option<(&str, f64)>],
        signal: &str,
        seed: u64,
        (begin_s, end_s): (f64, f64),
        recalls: bool,
    ) -> Self {
        let crossing = |crossing: &Option<(&str, f64)>| {
            let Some((edge, per_hour)) = crossing else { return Crossing::default() };
            let mut rng = ChaCha12Rng::seed_from_u64(seed::pedestrians(seed, signal, edge));
            let (mut time_s, mut to_come) = (begin_s, Vec::new());
            loop {
                // 1 - u lies in (0, 1], whose logarithm is finite.
                time_s -= (1.0 - rng.random::<f64>()).ln() * SECONDS_PER_HOUR / per_hour;
                if time_s.is_nan() || time_s >= end_s {
                    break;
                }
                to_come.push(time_s);
            }
            to_come.reverse();
            Crossing { to_come, counts: true, open_until_s: begin_s, ..Crossing::default() }
        };
        let crossings = crossings.iter().map(crossing).collect();
        Self { crossings, begin_s, recalls, ..Self::default() }
    }

    /// Returns those who come to each crosswalk at these times.
    #[cfg(test)]
    pub(super) fn of(come_s: &[&[f64]]) -> Self {
        let crossing = |times: &&[f64]| Crossing {
            to_come: times.iter().rev().copied().collect(),
            counts: true,
            ..Crossing::default()
        };
        Self { crossings: come_s.iter().map(crossing).collect(), ..Self::default() }
    }

    /// Lets those come who come until now.
    pub fn arrive(&mut self, now_s: f64) {
        for crossing in &mut self.crossings {
            while let Some(at_s) = crossing.to_come.pop_if(|at_s| *at_s <= now_s) {
                crossing.waiting.push(at_s);
            }
        }
    }

    /// Whether somebody waits at a crosswalk.
    pub fn waits(&self, crossing: usize) -> bool {
        !self.crossings[crossing].waiting.is_empty()
    }

    /// Returns the crosswalk at which somebody has waited for too long, of several for the longest.
    pub fn overdue(&self, now_s: f64) -> Option<usize> {
        let first = |c: usize| self.crossings[c].waiting.first().copied();
        let all = (0..self.crossings.len()).filter_map(|c| Some((c, first(c)?)));
        let oldest = all.min_by(|a, b| a.1.total_cmp(&b.1))?;
        (now_s - oldest.1 > LONGEST_WAIT_S).then_some(oldest.0)
    }

    /// Lets those go who wait at a crosswalk, which has WALK for a second.
    pub fn go(&mut self, crossing: usize, now_s: f64) {
        let own = &mut self.crossings[crossing];
        own.closed_s2 += (now_s - own.open_until_s).max(0.0).powi(2);
        own.open_until_s = now_s + 1.0 + AFTER_WALK_S;
        for came_s in own.waiting.drain(..) {
            own.totals += PedestrianTotals { count: 1, wait_s: now_s - came_s, unserved: 0 };
        }
    }

    /// Takes in the phase that a program shows for the next second.
    pub fn second_of_program(
        &mut self,
        phase: usize,
        program: &Program,
        timing: &Timing,
        now_s: f64,
    ) {
        if self.walks.is_empty() {
            self.walks = walks(program, timing, self.crossings.len());
        }
        let is_new = self.phase.replace(phase) != Some(phase);
        for crossing in 0..self.crossings.len() {
            let walk = self.walks[crossing].get(phase).copied().unwrap_or(Walk::No);
            let walk_s = &mut self.crossings[crossing].walk_s;
            *walk_s = match walk {
                Walk::No => None,
                Walk::Begins if is_new => Some(0),
                Walk::Begins | Walk::GoesOn => walk_s.map(|s| s + 1),
            };
            if walk_s.is_some_and(|s| s < WALK_S) {
                self.go(crossing, now_s);
            }
        }
    }

    /// Returns the totals at the end of the episode, per crosswalk.
    pub fn finish(&mut self, now_s: f64) -> Vec<PedestrianTotals> {
        self.arrive(now_s);
        let count = self.crossings.len();
        let of = |crossing: usize| {
            let (own, recalls) = (&self.crossings[crossing], self.recalls);
            // The cabinet serves whoever waits.
            let waits = |came_s: &f64| now_s - came_s > 2.0 * LONGEST_WAIT_S;
            let wants = recalls && own.counts || own.waiting.first().is_some_and(waits);
            if wants && own.open_until_s <= self.begin_s {
                return PedestrianTotals { unserved: 1, ..PedestrianTotals::default() };
            }
            self.go(crossing, now_s);
            let own = &self.crossings[crossing];
            let wait_s = own.closed_s2 / (2.0 * (now_s - self.begin_s));
            let on_recall = PedestrianTotals { count: 1, wait_s, unserved: 0 };
            if recalls && own.counts { on_recall } else { own.totals }
        };
        (0..count).map(of).collect()
    }
}

/// Returns per crosswalk what each phase of a program is to it. Phases that the program never comes to do not count.
fn walks(program: &Program, timing: &Timing, crossings: usize) -> Vec<Vec<Walk>> {
    let all = program.phases.iter().enumerate();
    let (places, shown): (Vec<usize>, Vec<(&str, f64)>) = all
        .filter(|(_, phase)| phase.is_reached)
        .map(|(place, phase)| (place, (phase.state.as_str(), phase.min_s)))
        .unzip();
    let of = |crossing: usize| {
        let mut walks = vec![Walk::No; program.phases.len()];
        for (place, walk) in places.iter().zip(timing.walks(&shown, crossing)) {
            walks[*place] = walk;
        }
        walks
    };
    (0..crossings).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::signal::testing::signal;
    use crate::settings::SignalSettings;
    use crate::sim::{ProgramKind, ProgramPhase};

    fn hours(hours: f64, seed: u64, per_hour: f64) -> Pedestrians {
        let crossings = [Some(("a", per_hour)), None, Some(("b", per_hour))];
        Pedestrians::new(&crossings, "c", seed, (0.0, 3600.0 * hours), false)
    }

    #[test]
    fn pedestrians_come_at_their_rate_and_the_same_for_a_seed() {
        let of = |p: &Pedestrians| p.crossings.iter().map(|c| c.to_come.len()).collect::<Vec<_>>();
        let counts = of(&hours(1000.0, 7, 10.0));
        assert!((counts[0] as f64 - 10_000.0).abs() < 400.0 && counts[1] == 0, "{counts:?}");
        assert_ne!(hours(1.0, 7, 10.0).crossings[0], hours(1.0, 7, 10.0).crossings[2]);
        assert_eq!(hours(1.0, 7, 10.0), hours(1.0, 7, 10.0));
        assert_ne!(hours(1.0, 7, 10.0), hours(1.0, 8, 10.0));
        assert_eq!(of(&hours(1.0, 7, 0.0)), [0; 3]);
    }

    #[test]
    fn a_program_lets_those_go_who_come_before_walk_is_over() {
        let settings = SignalSettings { pedestrians: true, ..SignalSettings::default() };
        let timing = signal(&settings).timing;
        let mut pedestrians = Pedestrians::of(&[&[3.0, 15.0, 25.0], &[]]);
        let phases = vec![ProgramPhase::fixed("Gr", 10.0), ProgramPhase::fixed("rG", 20.0)];
        let program = Program::new("p", ProgramKind::Static, phases);
        // The first approach waits from 10 s on: 7 s of walk.
        for second in 0..30 {
            let now_s = f64::from(second);
            pedestrians.arrive(now_s);
            let phase = usize::from(second >= 10);
            pedestrians.second_of_program(phase, &program, &timing, now_s);
        }
        // From 3 to 10 s, not at all, and from 25 s to the end.
        let mut on_recall = Pedestrians { recalls: true, ..pedestrians.clone() };
        let waits = PedestrianTotals { count: 3, wait_s: 12.0, unserved: 0 };
        assert_eq!(pedestrians.finish(30.0)[0], waits);
        // Nobody may begin to cross for 10 s, and for the last 9: 7 s of WALK and 4 s after it.
        let delay_s = on_recall.finish(30.0)[0].delay_s();
        assert_eq!(delay_s, Some((10.0_f64.powi(2) + 9.0_f64.powi(2)) / 60.0));
        // Without any walk nobody is served, however long the episode.
        for recalls in [true, false] {
            let closed = Pedestrians { recalls, ..Pedestrians::of(&[&[3.0]]) }.finish(300.0)[0];
            assert_eq!((closed.unserved, closed.delay_s()), (1, None));
        }
    }
}
