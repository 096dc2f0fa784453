//! Turning on red: which links may, and what they show instead of red.
//!
//! The network is the witness: a link may be used on red if its programs somewhere show it SUMO's `s`, which means to
//! stop and then to yield, and never plain red but beside a green link that yields and meets it. (Two links that yield to
//! each other could wait for each other for ever, and SUMO refuses such programs.) Everything that derives, decides or
//! observes sees red there, so phases, movements and pressures are those of the same signal without turns on red. Only
//! what SUMO is told has the `s`, in whatever state the link is red: in greens of others, in their yellow and in all-red.

use crate::sim::{Program, SignalInfo};

/// The links of a signal that may be used on red.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct OnRed {
    /// By link index.
    may: Vec<bool>,
    /// Per link index those that meet it; empty where it may not be used.
    meets: Vec<Vec<usize>>,
}

impl OnRed {
    /// Finds the links and turns their letter into red in all programs of the signal.
    pub(super) fn take(signal: &mut SignalInfo) -> Self {
        let count = signal.links.len();
        let states = || signal.programs.iter().flat_map(|p| &p.phases).map(|p| p.state.as_bytes());
        let meets = |link: usize| -> Vec<usize> {
            (0..count).filter(|other| *other != link && signal.may_meet(link, *other)).collect()
        };
        let may = |link: usize| {
            let meets = meets(link);
            let is = |letter: u8| move |s: &&[u8]| s.get(link) == Some(&letter);
            states().any(|s| is(b's')(&s))
                && states().filter(is(b'r')).all(|s| yields_beside(s, &meets))
        };
        let may: Vec<bool> = (0..count).map(may).collect();
        let of = |link: usize| if may[link] { meets(link) } else { Vec::new() };
        let meets = (0..count).map(of).collect();
        for phase in signal.programs.iter_mut().flat_map(|p| &mut p.phases) {
            let letters = phase.state.chars().enumerate();
            let red = |(link, letter)| match (may.get(link), letter) {
                (Some(true), 's') => 'r',
                _ => letter,
            };
            phase.state = letters.map(red).collect();
        }
        Self { may, meets }
    }

    /// Returns what SUMO is told to show for a state.
    pub(super) fn shown(&self, state: &str) -> String {
        let letter = |(link, letter): (usize, char)| match self.may.get(link) {
            Some(true) if letter == 'r' && !yields_beside(state.as_bytes(), &self.meets[link]) => {
                's'
            }
            _ => letter,
        };
        state.chars().enumerate().map(letter).collect()
    }

    /// Returns what SUMO is told to run for a program.
    pub(super) fn program(&self, mut program: Program) -> Program {
        for phase in &mut program.phases {
            phase.state = self.shown(&phase.state);
        }
        program
    }
}

/// Whether one of some links is green and yields.
fn yields_beside(state: &[u8], links: &[usize]) -> bool {
    links.iter().any(|link| state.get(*link) == Some(&b'g'))
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

    #[test]
    fn a_link_that_is_plain_red_somewhere_keeps_its_letters() {
        let lanes = [("n_0", 0.0, "r"), ("e_0", 90.0, "s")];
        let mut scene = crossing(&lanes, &["Gr", "rr", "sG"]);
        let on_red = OnRed::take(&mut scene.signals[0]);
        assert_eq!(scene.signals[0].programs[0].phases[2].state, "sG");
        assert_eq!(on_red.shown("rG"), "rG");
    }
}
