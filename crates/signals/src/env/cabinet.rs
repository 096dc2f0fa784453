//! What stands between a controller's decisions and the lights, and keeps to the limits.
//!
//! A decision for another phase starts the change at once: yellow, all-red, then the new green. Like a
//! cabinet in the street,
//! - it **ignores decisions** while a change goes on and until the least green is over; the controller
//!   is asked again at the next decision;
//! - it **ends a green at its longest**, in favour of the phase that has not been green for the longest
//!   time, if the controller has not. The limit is one of phases: a link that several phases serve in
//!   turn may stay green for longer.
//!
//! Where no light turns red, the new phase begins after the time of a yellow all the same, as in RESCO.
//! At the start of an episode the first phase has been green for long enough.

use std::collections::VecDeque;

use crate::control::GreenPhase;
use crate::sim::error::SimError;

use super::derive::DerivedSignal;
use super::signal::DecisionProgram;

/// The cabinet of a signal that a controller decides.
#[derive(Debug, Clone)]
pub struct Cabinet {
    id: String,
    table: DecisionProgram,
    min_green_s: Vec<u32>,
    max_green_s: Vec<Option<u32>>,
    yellow_time_s: u32,
    phase: GreenPhase,
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
        Self {
            id: signal.spec.id.clone(),
            table: DecisionProgram::new(signal),
            min_green_s: phases.iter().map(|p| signal.timing.min_green_s(&p.state)).collect(),
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

    /// Returns the phase that is green, or will be when the change is over.
    pub fn phase(&self) -> GreenPhase {
        self.phase
    }

    /// Takes in a decision for the next `interval_s` seconds.
    ///
    /// # Errors
    ///
    /// [`SimError::Signal`] when the phase does not exist.
    pub fn decide(&mut self, wanted: GreenPhase, interval_s: u32) -> Result<(), SimError> {
        if wanted.0 >= self.last.len() {
            let reason = format!("it has no phase {}", wanted.0);
            return Err(SimError::Signal { signal: self.id.clone(), reason });
        }
        if !self.coming.is_empty() {
            return Ok(());
        }
        let now = self.phase.0;
        if wanted != self.phase && (self.first || self.green_s >= self.min_green_s[now]) {
            self.change(wanted, 0);
        } else if let Some(max_s) = self.max_green_s[now]
            && self.green_s + interval_s > max_s
            && let Some(next) = self.longest_unserved()
        {
            self.change(next, max_s.saturating_sub(self.green_s));
        }
        Ok(())
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
        for (at_s, _) in &mut self.coming {
            *at_s -= seconds;
        }
    }

    /// Returns the program with all greens and changes.
    pub fn program(&self) -> &crate::sim::Program {
        &self.table.program
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::signal::testing::signal;
    use crate::settings::SignalSettings;

    /// Plays decisions, one every `interval_s`, and returns what is shown, second by second.
    fn shown(settings: &SignalSettings, decisions: &[usize], interval_s: u32) -> String {
        let signal = signal(settings);
        let mut cabinet = Cabinet::new(&signal, settings.yellow_time_s);
        let mut state = cabinet.program().phases[0].state.clone();
        let mut shown = String::new();
        for decision in decisions {
            cabinet.decide(GreenPhase(*decision), interval_s).unwrap();
            for _ in 0..interval_s {
                while let Some(phase) = cabinet.due() {
                    state.clone_from(&cabinet.program().phases[phase as usize].state);
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
    fn a_decision_before_the_least_green_is_over_is_ignored() {
        let settings = SignalSettings { min_green_s: 9, all_red_s: 1, ..SignalSettings::default() };
        // After the change at 0 green begins at 4: 1 s, then 6 s old at the next decisions, then 11 s.
        assert_eq!(shown(&settings, &[1, 0, 0, 0], 5), "yyyrrrrrrrrrrrrrrrrG");
    }

    #[test]
    fn the_longest_green_ends_in_favour_of_who_waits() {
        let settings = SignalSettings { max_green_s: Some(17), ..SignalSettings::default() };
        let all = shown(&settings, &[0; 6], 10);
        assert_eq!(&all[..20], "GGGGGGGGGGGGGGGGGyyy");
        // The other phase stays for its least green; then the controller has its way again.
        assert_eq!(&all[20..53], "rrrrrrrrrrrrrGGGGGGGGGGGGGGGGGyyy");
    }

    #[test]
    fn a_phase_that_does_not_exist_is_refused() {
        let mut cabinet = Cabinet::new(&signal(&SignalSettings::default()), 3);
        let e = cabinet.decide(GreenPhase(2), 10).unwrap_err().to_string();
        assert!(e.contains("it has no phase 2"), "{e}");
    }
}
