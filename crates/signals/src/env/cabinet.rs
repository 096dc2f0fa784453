//! What stands between a controller's decisions and the lights, and keeps to the limits.
//!
//! A decision for another phase starts the change at once: yellow, all-red, then the new green. Like a
//! cabinet in the street,
//! - it **ignores decisions** while a change goes on and until the least green is over; the controller
//!   is asked again at the next decision;
//! - it **ends a green at its longest**, in favour of the phase that has not been green for the longest
//!   time, if the controller has not. The limit is one of phases: a link that several phases serve in
//!   turn may stay green for longer;
//! - it **counts a shortest green** over all greens in a row that serve a movement or a crosswalk
//!   ([`needs`](crate::needs)), where pedestrians count;
//! - it **serves push buttons**: WALK begins with a green that serves a crosswalk at which somebody waits, or at
//!   once if that is green and may still last as long as it takes; then the change waits until they have
//!   crossed. Who has waited for [`LONGEST_WAIT_S`](super::pedestrians::LONGEST_WAIT_S) is served next, whatever
//!   the controller asks for.
//!
//! Where no light turns red, the new phase begins after the time of a yellow all the same, as in RESCO.
//! At the start of an episode the first phase has been green for long enough.

use std::collections::VecDeque;

use crate::control::GreenPhase;
use crate::needs::Need;
use crate::sim::error::SimError;
use crate::timing::WALK_S;

use super::derive::DerivedSignal;
use super::pedestrians::Pedestrians;
use super::signal::DecisionProgram;

/// The cabinet of a signal that a controller decides.
#[derive(Debug, Clone)]
pub struct Cabinet {
    id: String,
    /// What SUMO runs.
    pub(super) table: DecisionProgram,
    needs: Vec<Need>,
    /// Per need how long it has been served; a crosswalk's since its WALK began.
    served_s: Vec<u32>,
    /// Per need whether it counts: all do but crosswalks that nobody uses.
    counts: Vec<bool>,
    /// Per need whether it is served before and after the change that goes on.
    held: Vec<bool>,
    recalls: bool,
    /// When it is, seconds.
    now_s: f64,
    max_green_s: Vec<Option<u32>>,
    yellow_time_s: u32,
    /// The phase that is green, or will be when the change is over.
    pub(super) phase: GreenPhase,
    green_s: u32,
    first: bool,
    /// Per phase, when it was last green, counted in changes; 0 for never.
    last: Vec<u32>,
    changes: u32,
    /// What will be shown, and in how many seconds.
    coming: VecDeque<(u32, u32)>,
}

impl Cabinet {
    /// Returns the cabinet of a signal that shows its first phase.
    pub fn new(signal: &DerivedSignal, yellow_time_s: u32) -> Self {
        let phases = &signal.spec.phases;
        let states: Vec<&str> = phases.iter().map(|p| p.state.as_str()).collect();
        let needs = signal.timing.needs(&states);
        let recalls = signal.timing.recalls_pedestrians();
        Self {
            id: signal.spec.id.clone(),
            table: DecisionProgram::new(signal),
            served_s: vec![0; needs.len()],
            counts: needs.iter().map(|need| recalls || need.crossing.is_none()).collect(),
            held: vec![false; needs.len()],
            needs,
            recalls,
            now_s: 0.0,
            max_green_s: phases.iter().map(|p| signal.timing.max_green_s(&p.state)).collect(),
            yellow_time_s,
            phase: GreenPhase(0),
            green_s: 0,
            first: true,
            last: vec![0; phases.len()],
            changes: 0,
            coming: VecDeque::new(),
        }
    }

    /// Takes in a decision for the next `interval_s` seconds.
    ///
    /// # Arguments
    ///
    /// * `pedestrians` — who wants to cross, where they push buttons.
    pub fn decide(
        &mut self,
        wanted: GreenPhase,
        interval_s: u32,
        pedestrians: Option<&Pedestrians>,
    ) -> Result<(), SimError> {
        if wanted.0 >= self.last.len() {
            let reason = format!("it has no phase {}", wanted.0);
            return Err(SimError::Signal { signal: self.id.clone(), reason });
        }
        if !self.coming.is_empty() {
            return Ok(());
        }
        let now = self.phase.0;
        let overdue = pedestrians.and_then(|p| self.overdue(p));
        let wanted = overdue.unwrap_or(wanted);
        if wanted != self.phase && (self.first || self.may_change(wanted)) {
            self.change(wanted, 0);
        } else if let Some(max_s) = self.max_green_s[now]
            && self.green_s + interval_s > max_s
            && let Some(next) = self.longest_unserved()
        {
            self.change(next, max_s.saturating_sub(self.green_s));
        }
        Ok(())
    }

    /// Whether all that another phase does not serve has been served for long enough.
    fn may_change(&self, to: GreenPhase) -> bool {
        self.needs.iter().enumerate().all(|(i, need)| {
            let ends = need.served[self.phase.0] && !need.served[to.0];
            !ends || !self.counts[i] || self.served_s[i] >= need.least_s
        })
    }

    /// Returns the phase that serves who has waited for too long, of several the one that has not been green for the
    /// longest time; this one, if it does.
    fn overdue(&self, pedestrians: &Pedestrians) -> Option<GreenPhase> {
        let crossing = pedestrians.overdue(self.now_s)?;
        let need = self.needs.iter().find(|need| need.crossing == Some(crossing))?;
        if need.served[self.phase.0] && self.has_room(need) {
            return Some(self.phase);
        }
        let serving = (0..self.last.len()).filter(|i| need.served[*i] && *i != self.phase.0);
        serving.min_by_key(|i| (self.last[*i], *i)).map(GreenPhase)
    }

    /// Whether the green may still last as long as a crosswalk takes.
    fn has_room(&self, need: &Need) -> bool {
        self.max_green_s[self.phase.0].is_none_or(|max| self.green_s + need.least_s <= max)
    }

    /// Lets pedestrians come and go until now; where they push buttons, to be called every second.
    pub fn second(&mut self, now_s: f64, pedestrians: &mut Pedestrians) {
        self.now_s = now_s;
        pedestrians.arrive(now_s);
        for i in 0..self.needs.len() {
            let Some(crossing) = self.needs[i].crossing else { continue };
            let is_green = self.coming.is_empty();
            if !self.needs[i].served[self.phase.0] || !(is_green || self.held[i]) {
                continue;
            }
            if self.counts[i] && self.served_s[i] >= self.needs[i].least_s {
                self.counts[i] = false;
            }
            if !self.counts[i]
                && is_green
                && pedestrians.waits(crossing)
                && self.has_room(&self.needs[i])
            {
                (self.counts[i], self.served_s[i]) = (true, 0);
            }
            if self.counts[i] && self.served_s[i] < WALK_S {
                pedestrians.go(crossing, now_s);
            }
        }
    }

    fn longest_unserved(&self) -> Option<GreenPhase> {
        let others = (0..self.last.len()).filter(|i| *i != self.phase.0);
        others.min_by_key(|i| (self.last[*i], *i)).map(GreenPhase)
    }

    /// Plans a change that begins in so many seconds.
    fn change(&mut self, to: GreenPhase, in_s: u32) {
        let mut at_s = in_s;
        let between = self.table.change(self.phase, to);
        for (phase, seconds) in between {
            self.coming.push_back((at_s, *phase));
            at_s += seconds;
        }
        if between.is_empty() {
            let left_s = self.max_green_s[self.phase.0].map(|max| max.saturating_sub(self.green_s));
            at_s = (at_s + self.yellow_time_s).min(left_s.unwrap_or(u32::MAX));
        }
        self.coming.push_back((at_s, to.0 as u32));
        for (i, need) in self.needs.iter().enumerate() {
            self.held[i] = need.served[self.phase.0] && need.served[to.0];
            if !self.held[i] {
                self.served_s[i] = 0;
                self.counts[i] = self.recalls || need.crossing.is_none();
            }
        }
        self.changes += 1;
        self.last[self.phase.0] = self.changes;
        self.phase = to;
    }

    /// Returns the phase of the program that is to be shown from now on, if it is another one.
    pub fn due(&mut self) -> Option<u32> {
        let (0, phase) = *self.coming.front()? else { return None };
        self.coming.pop_front();
        self.green_s = 0;
        Some(phase)
    }

    /// Returns how long the lights stay as they are, seconds; `None` for until the next decision.
    pub fn next_s(&self) -> Option<u32> {
        self.coming.front().map(|(at_s, _)| *at_s)
    }

    /// Lets time go by, at most [`Self::next_s`].
    pub fn elapse(&mut self, seconds: u32) {
        self.first = false;
        self.green_s += seconds;
        for (i, need) in self.needs.iter().enumerate() {
            if need.served[self.phase.0] && (self.coming.is_empty() || self.held[i]) {
                self.served_s[i] += seconds;
            }
        }
        for (at_s, _) in &mut self.coming {
            *at_s -= seconds;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::pedestrians::PedestrianTotals;
    use crate::env::signal::testing::signal;
    use crate::settings::SignalSettings;

    /// Plays decisions, one every `interval_s`, and returns what is shown, second by second.
    fn shown(settings: &SignalSettings, decisions: &[usize], interval_s: u32) -> String {
        let signal = signal(settings);
        let mut cabinet = Cabinet::new(&signal, settings.yellow_time_s);
        let mut state = cabinet.table.program.phases[0].state.clone();
        let mut shown = String::new();
        for decision in decisions {
            cabinet.decide(GreenPhase(*decision), interval_s, None).unwrap();
            for _ in 0..interval_s {
                while let Some(phase) = cabinet.due() {
                    state.clone_from(&cabinet.table.program.phases[phase as usize].state);
                }
                shown.push(state.chars().next().unwrap());
                cabinet.elapse(1);
            }
        }
        shown
    }

    #[test]
    fn resco_changes_at_every_decision() {
        let settings = SignalSettings::default();
        assert_eq!(shown(&settings, &[0, 1, 0, 0], 10), "GGGGGGGGGGyyyrrrrrrrrrrGGGGGGGGGGGGGGGGG");
        assert_eq!(shown(&settings, &[1, 1], 10), "yyyrrrrrrrrrrrrrrrrr", "at the start");
    }

    #[test]
    fn the_longest_green_ends_in_favour_of_who_waits() {
        let settings = SignalSettings { max_green_s: Some(17), ..SignalSettings::default() };
        let all = shown(&settings, &[0; 6], 10);
        assert_eq!(&all[..20], "GGGGGGGGGGGGGGGGGyyy");
        // The other phase stays for its least green; then the controller has its way again.
        assert_eq!(&all[20..53], "rrrrrrrrrrrrrGGGGGGGGGGGGGGGGGyyy");
    }

    /// Plays decisions every 10 s with pedestrians who come to the crosswalk of the first approach, and returns
    /// what is shown and their waits.
    fn crossed(decisions: &[usize], come_s: &[f64]) -> (String, PedestrianTotals) {
        let settings = SignalSettings {
            pedestrians: true,
            pedestrian_calls_per_h: Some(1.0),
            max_green_s: Some(60),
            ..SignalSettings::default()
        };
        let signal = signal(&settings);
        let mut pedestrians = Pedestrians::of(&[come_s, &[]]);
        let mut cabinet = Cabinet::new(&signal, 3);
        let (mut state, mut shown) = (cabinet.table.program.phases[0].state.clone(), String::new());
        for (k, decision) in decisions.iter().enumerate() {
            cabinet.decide(GreenPhase(*decision), 10, Some(&pedestrians)).unwrap();
            for second in 0..10 {
                while let Some(phase) = cabinet.due() {
                    state.clone_from(&cabinet.table.program.phases[phase as usize].state);
                }
                cabinet.second((10 * k + second) as f64, &mut pedestrians);
                shown.push(state.chars().last().unwrap());
                cabinet.elapse(1);
            }
        }
        (shown, pedestrians.finish(10.0 * decisions.len() as f64)[0])
    }

    #[test]
    fn a_push_button_makes_the_next_green_beside_the_crosswalk_last() {
        // Red for 3 s of yellow; without anybody 7 s of green, with somebody 19 s.
        let (shown, _) = crossed(&[1, 1, 0, 0], &[]);
        assert_eq!(shown, format!("{}{}yyy{}", "r".repeat(3), "G".repeat(17), "r".repeat(17)));
        let (shown, totals) = crossed(&[1, 1, 0, 0], &[1.0]);
        assert_eq!(shown, format!("{}{}yyy{}", "r".repeat(3), "G".repeat(27), "r".repeat(7)));
        assert_eq!(totals, PedestrianTotals { count: 1, wait_s: 2.0, unserved: 0 });
    }

    #[test]
    fn who_comes_while_it_is_green_walks_at_once_if_there_is_room() {
        let (shown, totals) = crossed(&[1, 1, 1, 0, 0, 0], &[25.0]);
        assert_eq!(shown.matches('G').count(), 47, "from 25 to 44 s: {shown}");
        assert_eq!(totals.wait_s, 0.0);
        // After 50 of 60 s there is none. The other green follows, and this one again at 83 s.
        let (_, totals) = crossed(&[1; 9], &[53.0]);
        assert_eq!(totals, PedestrianTotals { count: 1, wait_s: 30.0, unserved: 0 });
    }

    #[test]
    fn who_has_waited_for_two_minutes_is_served_whatever_is_asked_for() {
        let settings = SignalSettings {
            pedestrians: true,
            pedestrian_calls_per_h: Some(1.0),
            ..SignalSettings::default()
        };
        let mut pedestrians = Pedestrians::of(&[&[5.0], &[]]);
        let mut cabinet = Cabinet::new(&signal(&settings), 3);
        for decision in 0..20 {
            cabinet.decide(GreenPhase(0), 10, Some(&pedestrians)).unwrap();
            for second in 0..10 {
                while cabinet.due().is_some() {}
                cabinet.second(f64::from(10 * decision + second), &mut pedestrians);
                cabinet.elapse(1);
            }
        }
        assert_eq!(
            pedestrians.finish(200.0)[0],
            PedestrianTotals { count: 1, wait_s: 128.0, unserved: 0 }
        );
        assert_eq!(cabinet.phase, GreenPhase(0), "it has its way again");
    }
}
