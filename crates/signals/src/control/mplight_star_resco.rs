//! MPLight* with the mistake of RESCO's code, for comparison with what was published.
//!
//! RESCO cuts the numbers of movement m out of the state from m on instead of from 4 m on, so that its
//! twelve movements see a window that slides over the first fifteen of 48 numbers, those of four
//! movements. Everything else is [`mplight_star`](super::mplight_star)'s.
//!
//! Source: RESCO, agents/mplight.py (`MPLightFULL`) and states.py (`mplight_full`).

use super::learner::Learning;
use super::mplight_star::variant;
use super::{Controller, Setup};
use evaluation::run::method::{Method, Training};

pub use super::mplight_star::Config;

/// The method.
pub const METHOD: Method = Method {
    summary: "the same with RESCO's mistake in what a movement sees",
    decision_s: 6e-4,
    dash: "10 3 2 3",
    settings: Config::SETTINGS,
    ..Method::built_in("mplight-star-resco", Training::Learned, "#bb33ff")
};

/// Distance between the windows of two movements in RESCO's code.
const RESCO_STRIDE: usize = 1;

/// Returns RESCO's MPLight*, untrained.
pub fn create(config: &Config, setup: &Setup) -> Box<dyn Controller> {
    let learner = variant(METHOD.name, RESCO_STRIDE, config, setup.seed);
    Box::new(Learning::new(learner, setup))
}

#[cfg(test)]
mod tests {
    use super::super::learner::Learner;
    use super::super::state::FULL_WIDTH;
    use super::super::testing::{check_learner, signal_with};
    use super::super::{LaneObservation, Light, Observation};
    use super::*;

    const SETUP: Setup = Setup { seed: 7, episodes: 1, imported: false, decision_s: 10 };

    #[test]
    fn it_learns_and_goes_on_from_a_checkpoint() {
        check_learner(&|episodes| create(&Config::default(), &Setup { episodes, ..SETUP }));
    }

    #[test]
    fn it_is_blind_for_the_later_movements_and_mplight_star_is_not() {
        // Movements 1, 4, 7 and 10 in RESCO's numbers; windows of four from m on end before the
        // numbers of movement 7, which begin at 28.
        let rows: [[Light; 4]; 4] = std::array::from_fn(|a| {
            std::array::from_fn(|m| if a == m { Light::Protected } else { Light::Red })
        });
        let signal = signal_with(&rows);
        let values = |stride, queue: [f64; 4]| {
            let mut learner = variant(METHOD.name, stride, &Config::default(), 7);
            let signals = std::slice::from_ref(&signal);
            learner.meet(signals).unwrap();
            let lane = |queue| LaneObservation { queue, ..LaneObservation::default() };
            let seen = Observation { lanes: queue.map(lane).to_vec(), ..Observation::default() };
            learner.values(signals, &seen)
        };
        let [few, many] = [[1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 9.0, 0.0]];
        assert_eq!(values(RESCO_STRIDE, few), values(RESCO_STRIDE, many));
        assert_ne!(values(FULL_WIDTH, few), values(FULL_WIDTH, many));
    }
}
