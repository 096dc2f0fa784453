//! Signals written by hand, for the tests of the rings.

use osm_signals::Turn;

use super::links::{Car, Links};
use super::plan::{Phase, Plan};
use super::{DualRing, Seen};
use crate::control::dual_ring::Config;
use crate::settings::SignalSettings;
use crate::timing::{Approach, Timing, Way};

/// Approaches from the north clockwise as (heading, turns per lane), a link per turn.
pub(super) fn links(approaches: &[(f64, &[&str])], states: &[&str]) -> Links {
    let mut cars = Vec::new();
    let mut lane = 0;
    for (approach, (_, lanes)) in approaches.iter().enumerate() {
        for turns in *lanes {
            for turn in turns.chars() {
                let turn = match turn {
                    'r' => Turn::Right,
                    's' => Turn::Through,
                    _ => Turn::Left,
                };
                cars.push(Some(Car { approach, turn, lanes: vec![lane] }));
            }
            lane += 1;
        }
    }
    let headings = approaches.iter().map(|(heading, _)| *heading).collect();
    Links::of(cars, headings, false, states.iter().map(|s| (*s).to_owned()).collect(), &|_, _| true)
}

pub(super) const LANES: &[&str] = &["rs", "l"];
pub(super) const ARMS: [(f64, &[&str]); 4] =
    [(180.0, LANES), (270.0, LANES), (0.0, LANES), (90.0, LANES)];

/// Links right, through, left from the north clockwise; right turns run beside the lefts of the cross street.
pub(super) const GREENS: [&str; 4] =
    ["GGgrrrGGgrrr", "rrGGrrrrGGrr", "rrrGGgrrrGGg", "GrrrrGGrrrrG"];

/// Four arms with left lanes.
pub(super) fn cross() -> Links {
    links(&ARMS, &GREENS)
}

/// From the north left into the stem, the stem, from the south.
pub(super) fn tee() -> Links {
    let arms: [(f64, &[&str]); 3] = [(180.0, &["s", "l"]), (270.0, &["rl"]), (0.0, &["rs"])];
    links(&arms, &["GgrrGG", "GGGrrr", "rrGGGr"])
}

/// The same with a fifth arm that has a green of its own.
pub(super) fn five() -> Links {
    let mut arms = ARMS.to_vec();
    arms.push((45.0, &["rsl"]));
    let greens =
        [GREENS.map(|g| format!("{g}rrr")).as_slice(), &["rrrrrrrrrrrrGGG".into()]].concat();
    links(&arms, &greens.iter().map(String::as_str).collect::<Vec<_>>())
}

/// 10 s of least green, 5 s for lefts, 3 s of yellow, 1 s of red.
pub(super) fn settings() -> SignalSettings {
    SignalSettings {
        min_green_s: 10,
        min_left_green_s: 5,
        all_red_s: 1,
        ..SignalSettings::default()
    }
}

pub(super) fn timing(links: &Links, settings: &SignalSettings) -> Timing {
    let approach = |heading_deg: &f64| Approach {
        heading_deg: *heading_deg,
        width_m: 10.0,
        plain_lanes: 3,
        speed_mps: 14.0,
    };
    let ways = |car: &Option<Car>| {
        car.iter().map(|c| Way { approach: c.approach, turn: c.turn }).collect()
    };
    let approaches = links.headings.iter().map(approach).collect();
    Timing::new(settings, approaches, links.cars.iter().map(ways).collect())
}

pub(super) fn config() -> Config {
    Config { max_green_s: 40, left_max_green_s: 20, ..Config::default() }
}

pub(super) fn rings(links: &Links, config: &Config, settings: &SignalSettings) -> DualRing {
    let timing = timing(links, settings);
    let plan = Plan::new(links, &links.states, &timing, config);
    DualRing::of(links.clone(), plan, timing)
}

/// Vehicles on the detectors of a phase, from a second to another one.
pub(super) type On = (u32, std::ops::Range<usize>);

/// Plays so many seconds and returns the states with the seconds for which they are shown.
pub(super) fn play(rings: &mut DualRing, vehicles: &[On], seconds: usize) -> Vec<(String, usize)> {
    let mut shown: Vec<(String, usize)> = Vec::new();
    for second in 0..seconds {
        match shown.last_mut() {
            Some((state, count)) if *state == rings.shown => *count += 1,
            _ => shown.push((rings.shown.clone(), 1)),
        }
        let on = |number: u32| vehicles.iter().any(|(p, at)| *p == number && at.contains(&second));
        rings.step(&seen(rings, &on));
    }
    shown
}

/// Returns what detectors see of vehicles on those of some phases, by number.
pub(super) fn seen(rings: &DualRing, on: &dyn Fn(u32) -> bool) -> Vec<Seen> {
    let of = |on| Seen { calls: on, extends: on, walk_s: None };
    rings.plan.phases.iter().map(|phase| of(on(phase.number))).collect()
}

/// Returns the greens that have ended, with vehicles on phases by number and second: number, first second and length.
pub(super) fn greens(
    rings: &mut DualRing,
    on: &dyn Fn(u32, u32) -> bool,
    seconds: u32,
) -> Vec<(u32, u32, u32)> {
    let mut since = vec![None; rings.plan.phases.len()];
    let mut ended = Vec::new();
    for second in 0..seconds {
        let green: Vec<usize> = rings.green_phases().collect();
        for (phase, since) in since.iter_mut().enumerate() {
            if green.contains(&phase) {
                since.get_or_insert(second);
            } else if let Some(begin) = since.take() {
                ended.push((rings.plan.phases[phase].number, begin, second - begin));
            }
        }
        rings.step(&seen(rings, &|number| on(number, second + 1)));
    }
    ended
}

pub(super) fn expected(states: &[(&str, usize)]) -> Vec<(String, usize)> {
    states.iter().map(|(state, seconds)| ((*state).to_owned(), *seconds)).collect()
}

pub(super) const RED: &str = "rrrrrrrrrrrr";
pub(super) const SIDE: &str = "rrrGGgrrrGGg";
pub(super) const SIDE_ENDS: &str = "rrryyyrrryyy";

/// The numbers of the phases: rings within sides.
pub(super) fn numbers(plan: &Plan) -> String {
    let ring = |ring: &Vec<usize>| {
        ring.iter().map(|p| plan.phases[*p].number.to_string()).collect::<Vec<_>>().join(" ")
    };
    let side = |side: &[Vec<usize>; 2]| format!("{}|{}", ring(&side[0]), ring(&side[1]));
    plan.sides.iter().map(side).collect::<Vec<_>>().join(", ")
}

pub(super) fn phase(plan: &Plan, number: u32) -> &Phase {
    plan.phases.iter().find(|phase| phase.number == number).unwrap()
}
