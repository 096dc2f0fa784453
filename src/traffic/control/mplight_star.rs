//! MPLight*: MPLight that sees four numbers per movement instead of one.
//!
//! Pressure, waiting time, speeds and approaching vehicles ([`super::state::full_demand`]); everything
//! else, the reward too, is [MPLight](super::mplight)'s.
//!
//! RESCO cuts the numbers of movement m out of the state from m on instead of from 4 m on, so that its
//! twelve movements see a window that slides over the first fifteen of 48 numbers, those of four
//! movements. There are two methods therefore:
//! - `mplight-star` gives every movement its own four numbers, as intended;
//! - `mplight-star-resco` does as RESCO does, for comparison with what was published.
//!
//! Source: RESCO, agents/mplight.py (`MPLightFULL`) and states.py (`mplight_full`).

use super::mplight::{self, MpLight, mplight_settings};
use super::state::{Demand, FULL_WIDTH};

/// Name of the variant in which every movement sees its own numbers.
pub const NAME: &str = "mplight-star";

/// Name of the variant that does as RESCO does.
pub const RESCO_NAME: &str = "mplight-star-resco";

/// Distance between the windows of two movements in RESCO's code.
const RESCO_STRIDE: usize = 1;

mplight_settings! { {
    /// Hyper-parameters of `mplight-star` and `mplight-star-resco`; the defaults are RESCO's.
    pub struct Config extends mplight::Config
} and {
    /// Whether the speeds of all lanes of a movement count; in RESCO only those of its last lane.
    speed_of_all_lanes: bool = false;
} }

/// Returns an untrained `mplight-star`; `seed` is for everything random in it.
pub fn mplight_star(config: &Config, episodes: u32, seed: u64) -> MpLight {
    let demand = Demand::Full { all_lanes: config.speed_of_all_lanes, stride: FULL_WIDTH };
    MpLight::variant(NAME, config.into(), demand, episodes, seed)
}

/// Returns an untrained `mplight-star-resco`; `seed` is for everything random in it.
pub fn mplight_star_resco(config: &Config, episodes: u32, seed: u64) -> MpLight {
    let demand = Demand::Full { all_lanes: config.speed_of_all_lanes, stride: RESCO_STRIDE };
    MpLight::variant(RESCO_NAME, config.into(), demand, episodes, seed)
}

#[cfg(test)]
mod tests {
    use super::super::testing::{check_learner, signal_with};
    use super::super::{Controller, LaneObservation, Observation, Service};
    use super::*;

    #[test]
    fn both_variants_learn_and_go_on_from_a_checkpoint() {
        check_learner(&|episodes| Box::new(mplight_star(&Config::default(), episodes, 7)));
        check_learner(&|episodes| Box::new(mplight_star_resco(&Config::default(), episodes, 7)));
    }

    #[test]
    fn resco_s_variant_is_blind_for_the_later_movements() {
        // Movements 1, 4, 7 and 10 in RESCO's numbers; windows of four from m on end before the
        // numbers of movement 7, which begin at 28.
        let rows: [[Service; 4]; 4] = std::array::from_fn(|a| {
            std::array::from_fn(|m| if a == m { Service::Protected } else { Service::None })
        });
        let signal = signal_with(&rows);
        let choice = |mut controller: MpLight, queue: [f64; 4]| {
            controller.begin(std::slice::from_ref(&signal)).unwrap();
            let lane = |queue| LaneObservation { queue, ..LaneObservation::default() };
            let seen = Observation { lanes: queue.map(lane).to_vec(), ..Observation::default() };
            controller.values(&seen)
        };
        let [few, many] = [[1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 9.0, 0.0]];
        let config = Config::default();
        let resco = || mplight_star_resco(&config, 1, 7);
        assert_eq!(choice(resco(), few), choice(resco(), many));
        let intended = || mplight_star(&config, 1, 7);
        assert_ne!(choice(intended(), few), choice(intended(), many));
    }
}
