//! Rings on links written by hand: what is shown, second by second.

use osm_signals::Turn;

use super::Seen;
use super::links::Links;
use super::plan::Plan;
use super::testing::{
    ARMS, GREENS, On, RED, SIDE, SIDE_ENDS, config, cross, expected, five, links, numbers, phase,
    play, rings, settings, tee, timing,
};
use crate::control::dual_ring::{Config, Recall};
use crate::settings::SignalSettings;

fn shown(vehicles: &[On], seconds: usize) -> Vec<(String, usize)> {
    play(&mut rings(&cross(), &config(), &settings()), vehicles, seconds)
}

const MAIN: &str = "GGgrrrGGgrrr";
const MAIN_ENDS: &str = "yyyrrryyyrrr";

fn plan(links: &Links) -> Plan {
    Plan::new(links, &links.states, &timing(links, &settings()), &config())
}

#[test]
fn four_arms_with_left_lanes_have_eight_phases_around_a_barrier() {
    let plan = plan(&cross());
    assert_eq!(numbers(&plan), "1 2|5 6, 3 4|7 8");
    let links = |number| phase(&plan, number).links.ones().collect::<Vec<_>>();
    // 2 comes from the north; its own left is 5, and 1 that of the south.
    assert_eq!((links(2), links(5), links(1)), (vec![0, 1, 2], vec![2], vec![8]));
    assert_eq!((links(4), links(7), links(3)), (vec![3, 4, 5], vec![5], vec![11]));
}

#[test]
fn phases_follow_from_arms_and_greens() {
    let shared = ARMS.map(|(heading, _)| (heading, &["rsl"][..]));
    let one_way: [(f64, &[&str]); 2] = [(180.0, &["rs", "l"]), (90.0, &["s", "l"])];
    let split = ["GGGrrrrrrrrr", "rrrrrrGGGrrr", "rrrGGgrrrGGg"];
    let lead_lag = ["GGGrrrrrrrrr", "GGgrrrGGgrrr", "rrrrrrGGGrrr", "rrrGGgrrrGGg"];
    // The through traffic from the north has green in two greens, one link at a time.
    let parts: [(f64, &[&str]); 2] = [(180.0, &["r", "s", "s"]), (90.0, &["s"])];
    let several_nodes = Links { has_inner: true, ..cross() };
    for (links, expected) in [
        (links(&shared, &[GREENS[0], GREENS[2]]), "2|6, 4|8"),
        (tee(), "2|5 6, 4|"),
        (links(&one_way, &["GGGrr", "rrrGG"]), "2|, 4|"),
        (five(), "1 2|5 6, 3 4|7 8, 10|"),
        (links(&ARMS, &split), "2|6, 4|, 10|"),
        (links(&ARMS, &lead_lag), "2|6, 4|8"),
        (links(&parts, &["GGrr", "GrGr", "rrrG"]), "1|, 2|, 3|"),
        (several_nodes, "1|, 2|, 3|, 4|"),
    ] {
        assert_eq!(numbers(&plan(&links)), expected);
    }
}

#[test]
fn a_phase_that_nobody_calls_is_skipped_and_the_main_street_is_recalled() {
    let all = shown(&[(4, 0..11)], 60);
    let end = 60 - 10 - 4 - 10 - 4;
    let greens = [(MAIN, 10), (MAIN_ENDS, 3), (RED, 1), (SIDE, 10), (SIDE_ENDS, 3), (RED, 1)];
    assert_eq!(all, [expected(&greens), expected(&[(MAIN, end)])].concat());
}

#[test]
fn a_green_ends_by_a_gap_or_at_its_longest_while_another_phase_is_called() {
    // Seen in the seconds that end at 1 to 15; at 17 nobody has passed for two.
    assert_eq!(shown(&[(8, 0..30), (2, 0..15)], 30)[0], (MAIN.to_owned(), 17));
    assert_eq!(shown(&[(8, 0..99), (2, 0..99)], 60)[0], (MAIN.to_owned(), 40));
    assert_eq!(shown(&[(2, 0..99)], 90), expected(&[(MAIN, 90)]), "nobody else");
}

#[test]
fn lefts_lead_and_each_ring_goes_on_by_itself() {
    let mut rings = rings(&cross(), &config(), &settings());
    play(&mut rings, &[(4, 0..11)], 20);
    // In the last seconds of the side street both lefts of the main street are called.
    let all = play(&mut rings, &[(1, 0..20), (5, 0..11), (2, 0..99), (6, 0..99)], 40);
    let lefts = [
        (SIDE, 4),
        (SIDE_ENDS, 3),
        (RED, 1),
        // 1 and 5, with the right turns of the side street.
        ("rrGGrrrrGGrr", 5),
        // 5 ends, 1 goes on; what has not been seen beside 6 ends too.
        ("rryyrrrrGyrr", 3),
        ("rrrrrrrrGrrr", 1),
        ("rrrrrrGGGrrr", 5),
    ];
    assert_eq!(all[..7], expected(&lefts)[..], "{all:#?}");
}

#[test]
fn a_left_that_comes_too_late_is_served_after_both_through_phases_have_ended() {
    // With 2 alone ending, the left turns of the south would see yellow beside the green of the north: the trap.
    let all = shown(&[(5, 20..99), (2, 0..99), (6, 0..99)], 60);
    let both_end = [(MAIN, 40), (MAIN_ENDS, 3), (RED, 1), ("GGGrrrrrrrrr", 16)];
    assert_eq!(all, expected(&both_end));
}

#[test]
fn a_left_of_which_nobody_opposes_has_right_of_way_and_yields_again_in_time() {
    let mut rings = rings(&cross(), &config(), &settings());
    play(&mut rings, &[(5, 20..45), (2, 0..99), (6, 0..99)], 45);
    // Its yellow and red: it has no right of way any more, and 6 waits.
    let all = play(&mut rings, &[(2, 0..99), (6, 0..99)], 20);
    let expected = expected(&[("GGGrrrrrrrrr", 4), ("GGgrrrrrrrrr", 4), (MAIN, 12)]);
    assert_eq!(all, expected);
}

#[test]
fn a_phase_begins_within_a_side_only_if_the_other_ring_can_wait_for_it() {
    // 2 and 5 rest; 6 is called when 2 has 12 s left, of which the change and its least green would take 14.
    let config = Config { recall: Recall::None, ..config() };
    let mut rings = rings(&cross(), &config, &settings());
    play(&mut rings, &[(5, 0..99), (2, 0..99), (6, 0..10)], 44);
    assert_eq!(rings.shown, "GGGrrrrrrrrr");
    let all = play(&mut rings, &[(2, 0..99), (6, 28..99), (4, 28..99)], 60);
    assert_eq!(all[0], ("GGGrrrrrrrrr".to_owned(), 40), "{all:#?}");
}

/// What a state must never show, and what no link may do; in words.
fn violations(states: &[String], links: &Links, least: impl Fn(usize) -> usize) -> Vec<String> {
    let at = |second: usize, link: usize| states[second].as_bytes()[link];
    let green = |second, link| matches!(at(second, link), b'G' | b'g');
    let mut wrong = Vec::new();
    for second in 1..states.len() {
        for a in 0..links.cars.len() {
            for b in (0..links.cars.len()).filter(|b| *b != a) {
                let meet = !links.together[a].contains(b);
                if green(second, a) && green(second, b) && meet {
                    wrong.push(format!("{second} s: links {a} and {b} are green"));
                }
                if green(second, a) && at(second, b) == b'y' && meet {
                    wrong.push(format!("{second} s: link {a} is green beside the yellow of {b}"));
                }
                let begins = green(second, a) && !green(second - 1, a);
                if begins && meet && (second.saturating_sub(4)..second).any(|s| green(s, b)) {
                    wrong.push(format!("{second} s: link {a} begins before {b} is clear"));
                }
                let trapped = at(second, a) == b'y'
                    && links.turn(a) == Some(Turn::Left)
                    && links.yields[a].contains(b)
                    && green(second, b);
                if trapped {
                    wrong.push(format!("{second} s: the yellow of {a} is a trap beside {b}"));
                }
            }
        }
    }
    for link in 0..links.cars.len() {
        let mut begin = None;
        for second in 1..states.len() {
            match (green(second - 1, link), green(second, link), begin) {
                (false, true, _) => begin = Some(second),
                (true, false, Some(since)) if second - since < least(link) => {
                    wrong.push(format!("{since} s: link {link} has {} s", second - since));
                }
                _ => {}
            }
            let yellow = (second..states.len()).take_while(|s| at(*s, link) == b'y').count();
            let whole = second + yellow < states.len();
            if green(second - 1, link) && !green(second, link) && whole && yellow != 3 {
                wrong.push(format!("{second} s: link {link} has {yellow} s of yellow"));
            }
        }
    }
    wrong
}

/// Plays vehicles that come and go at random.
fn random(links: &Links, config: &Config, seconds: usize) -> Vec<String> {
    let mut rings = rings(links, config, &settings());
    let phases = rings.plan.phases.len();
    let mut on = vec![false; phases];
    let mut state = 1_u64;
    let mut states = Vec::new();
    for second in 0..seconds {
        states.push(rings.shown.clone());
        for vehicle in &mut on {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let draw = (state >> 40) % 100;
            // Quiet and busy times.
            let (comes, goes) = if second / 500 % 2 == 0 { (3, 30) } else { (30, 10) };
            *vehicle = if *vehicle { draw >= goes } else { draw < comes };
        }
        let of = |on: &bool| Seen { calls: *on, extends: *on, walk_s: None };
        rings.step(&on.iter().map(of).collect::<Vec<_>>());
    }
    states
}

#[test]
fn whatever_comes_nothing_forbidden_is_shown_and_everybody_is_served() {
    let cases = [
        cross(),
        five(),
        tee(),
        links(&ARMS, &["GGGrrrrrrrrr", "rrrrrrGGGrrr", "rrrGGgrrrGGg"]),
        // Lefts that are never permissive.
        links(&ARMS, &["GGrrrrGGrrrr", "rrGrrrrrGrrr", "rrrGGrrrrGGr", "rrrrrGrrrrrG"]),
        // Stages.
        links(&[(180.0, &["r", "s", "s"]), (90.0, &["s"])], &["GGrr", "GrGr", "rrrG"]),
    ];
    for (case, links) in cases.iter().enumerate() {
        for recall in [Recall::None, Recall::Main, Recall::All] {
            let states = random(links, &Config { recall, ..config() }, 10_000);
            let stages = case == 5;
            let least = |link: usize| match links.turn(link) {
                Some(Turn::Through) if !stages => 10,
                _ => 5,
            };
            let wrong = violations(&states, links, least);
            assert!(wrong.is_empty(), "{case} {recall:?}: {:#?}", &wrong[..wrong.len().min(9)]);
            for link in 0..links.cars.len() {
                let served = states.iter().filter(|s| matches!(s.as_bytes()[link], b'G' | b'g'));
                assert!(served.count() > 50, "{case}: link {link}");
            }
        }
    }
}

#[test]
fn planted_violations_are_found() {
    let states = |script: &[(&str, usize)]| -> Vec<String> {
        script.iter().flat_map(|(s, count)| vec![(*s).to_owned(); *count]).collect()
    };
    let found = |script: &[(&str, usize)], what: &str| {
        let wrong = violations(&states(script), &cross(), |_| 5);
        assert!(wrong.iter().any(|w| w.contains(what)), "{what}: {wrong:?}");
    };
    found(&[(RED, 5), ("GGgGrrrrrrrr", 9)], "links 1 and 3 are green");
    found(&[(RED, 5), (MAIN, 9), (MAIN_ENDS, 2), (RED, 9)], "2 s of yellow");
    found(&[(RED, 5), (MAIN, 9), (MAIN_ENDS, 3), (SIDE, 9)], "begins before");
    found(&[(RED, 5), (MAIN, 4), (MAIN_ENDS, 3), (RED, 9)], "link 1 has 4 s");
    found(&[(MAIN, 9), ("GGgrrrGGyrrr", 3), ("GGgrrrGGrrrr", 5)], "trap");
    found(&[(MAIN, 9), ("yyyrrrGGgrrr", 3), (RED, 5)], "trap");
    let fair = [(MAIN, 9), (MAIN_ENDS, 3), (RED, 1), (SIDE, 9)];
    assert!(violations(&states(&fair), &cross(), |_| 5).is_empty());
}

#[test]
fn a_call_at_a_crosswalk_holds_the_through_phase_beside_it() {
    let pressed =
        SignalSettings { pedestrians: true, pedestrian_calls_per_h: Some(10.0), ..settings() };
    let recalled = SignalSettings { pedestrian_calls_per_h: None, ..pressed.clone() };
    let phases = |settings: &SignalSettings| rings(&cross(), &config(), settings).plan.clone();
    // 7 + 10 / 1.067 s. To the right of whoever comes from the north lies the west.
    let pressed_plan = phases(&pressed);
    let north = phase(&pressed_plan, 2);
    assert_eq!((north.crossings.as_slice(), north.min_s), ([(3, 17)].as_slice(), 10));
    assert_eq!(phase(&phases(&recalled), 2).min_s, 17);
    assert_eq!(phase(&phases(&recalled), 1).min_s, 5);

    let mut rings = rings(&cross(), &config(), &pressed);
    let place = rings.plan.phases.iter().position(|p| p.number == 4).unwrap();
    let mut green_s = 0;
    for second in 0..60 {
        let mut seen = vec![Seen::default(); rings.plan.phases.len()];
        // Somebody waits until WALK begins.
        if second < 20 && rings.shown != SIDE {
            (seen[place].calls, seen[place].walk_s) = (true, Some(17));
        }
        rings.step(&seen);
        green_s += usize::from(rings.shown == SIDE);
    }
    assert_eq!(green_s, 17, "nobody else holds it, and the main street is recalled");
}

#[test]
fn a_phase_has_no_walk_for_a_crosswalk_that_is_closed() {
    let settings = SignalSettings { pedestrians: true, ..settings() };
    let mut timing = timing(&cross(), &settings);
    // A program that serves the main street alone: the crosswalks of the north and the south are closed.
    timing.close_crosswalks_without(&[MAIN.to_owned()]);
    let plan = Plan::new(&cross(), &cross().states, &timing, &config());
    let walks = |number| phase(&plan, number).crossings.len();
    assert_eq!([2, 6, 4, 8].map(walks), [1, 1, 0, 0]);
}

#[test]
fn where_arrows_are_said_a_left_turn_without_one_has_no_phase() {
    let arms: [(f64, &[&str]); 3] = [(180.0, &["s", "l"]), (270.0, &["rl"]), (0.0, &["rs"])];
    let mut yielding = links(&arms, &["GgrrGG", "rrGGrr"]);
    assert_eq!(numbers(&plan(&yielding)), "2|5 6, 4|");
    yielding.arrows_only = true;
    assert_eq!(numbers(&plan(&yielding)), "2|6, 4|");
    // Protected only: red beside the opposing approach.
    let mut protected = links(&arms, &["GrrrGG", "GGrrrr", "rrGGrr"]);
    protected.arrows_only = true;
    let plan = plan(&protected);
    assert_eq!(numbers(&plan), "2|5 6, 4|");
    assert_eq!(phase(&plan, 2).links.count_ones(..), 1);
}
