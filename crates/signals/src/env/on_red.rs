//! Turning on red: which links may, and what they show instead of red.
//!
//! The network is the witness: a link may be used on red if its programs somewhere show it SUMO's `s`, which means to
//! stop and then to yield, and never plain red but beside a green link that yields and meets it. (Two links that yield to
//! each other could wait for each other for ever, and SUMO refuses such programs.) Everything that derives, decides or
//! observes sees red there, so phases, movements and pressures are those of the same signal without turns on red. Only
//! what SUMO is told has the `s`, in whatever state the link is red: in greens of others, in their yellow and in all-red.

use crate::sim::{Program, SignalInfo};
use crate::vocabulary::{is_met_by_yielding, on_red};

/// The links of a signal that may be used on red.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct OnRed {
    /// By link index.
    may: Vec<bool>,
    /// Shape `[links, links]`; whether the first may be used on red and the second meets it.
    meets: Vec<Vec<bool>>,
    /// The signal's programs as the network has them, where their letters were turned into red.
    programs: Vec<Program>,
}

impl OnRed {
    /// Finds the links and turns their letter into red in all programs of the signal.
    pub(crate) fn take(signal: &mut SignalInfo) -> Self {
        let count = signal.links.len();
        let states = || signal.programs.iter().flat_map(|p| &p.phases).map(|p| p.state.as_str());
        let meet = |link: usize, other: usize| other != link && signal.may_meet(link, other);
        let may = |link: usize| {
            let is = |letter: u8| move |s: &&str| s.as_bytes().get(link) == Some(&letter);
            states().any(|s| is(b's')(&s))
                && states().filter(is(b'r')).all(|s| is_met_by_yielding(s, link, &meet))
        };
        let may: Vec<bool> = (0..count).map(may).collect();
        let programs = signal.programs.clone();
        let of = |link: usize| (0..count).map(|other| may[link] && meet(link, other)).collect();
        let meets = (0..count).map(of).collect();
        for phase in signal.programs.iter_mut().flat_map(|p| &mut p.phases) {
            let letters = phase.state.chars().enumerate();
            let red = |(link, letter)| match (may.get(link), letter) {
                (Some(true), 's') => 'r',
                _ => letter,
            };
            phase.state = letters.map(red).collect();
        }
        Self { may, meets, programs }
    }

    /// Returns a program of the network with the letters that it has there: its own states may have an `s` beside a green
    /// that yields, which [`Self::shown`] never has.
    pub(super) fn own<'p>(&'p self, signal: &'p SignalInfo, id: &str) -> Option<&'p Program> {
        let mut programs = self.programs.iter().chain(&signal.programs);
        programs.find(|program| program.id == id)
    }

    /// Returns what SUMO is told to show for a state.
    pub(super) fn shown(&self, state: &str) -> String {
        on_red(state, &self.may, &|link, other| self.meets[link].get(other) == Some(&true))
    }

    /// Returns what SUMO is told to run for a program.
    pub(super) fn program(&self, mut program: Program) -> Program {
        for phase in &mut program.phases {
            phase.state = self.shown(&phase.state);
        }
        program
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::testing::crossing;

    #[test]
    fn links_that_are_never_plain_red_may_and_what_derives_sees_them_red() {
        let lanes = [("n_0", 0.0, "r"), ("n_1", 0.0, "s"), ("e_0", 90.0, "r"), ("e_1", 90.0, "s")];
        let mut scene = crossing(&lanes, &["GGsr", "yysr", "srsr", "srGG", "sryy"]);
        let signal = &mut scene.signals[0];
        let own = signal.programs[0].clone();
        let on_red = OnRed::take(signal);
        let states: Vec<_> = signal.programs[0].phases.iter().map(|p| p.state.clone()).collect();
        assert_eq!(states[..4], ["GGrr", "yyrr", "rrrr", "rrGG"]);
        assert_eq!(on_red.program(signal.programs[0].clone()), own);
        assert_eq!(on_red.shown("yyrr"), "yysr");
    }

    #[test]
    fn beside_a_green_link_that_yields_and_meets_it_a_link_stays_red() {
        let lanes = [("n_0", 0.0, "r"), ("s_0", 180.0, "l"), ("s_1", 180.0, "s")];
        let mut scene = crossing(&lanes, &["Ggr", "rgr", "srG", "sGr"]);
        let signal = &mut scene.signals[0];
        signal.meets = vec![vec![false, true, false], vec![true, false, false], vec![false; 3]];
        let own = signal.programs[0].clone();
        let on_red = OnRed::take(signal);
        assert_eq!(signal.programs[0].phases[2].state, "rrG");
        assert_eq!(on_red.program(signal.programs[0].clone()), own);
    }
}
