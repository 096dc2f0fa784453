//! What SUMO really shows keeps to the limits, whatever the method, the preset and the action set.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use crate::shown::{Limits, Way, foes, hurried, states, violations, violations_by_link};
use osm_signals::DrivingSide;
use tsc_family::settings::overrides::Override;
use tsc_family::traffic::control::dual_ring::Config;
use tsc_family::traffic::control::phase_sets::covering;
use tsc_family::traffic::control::registry::METHODS;
use tsc_family::traffic::control::{
    ControlError, Controller, Drive, EpisodeOutcome, GreenPhase, Observation, SignalSpec, Trainer,
};
use tsc_family::traffic::control::{coordinated, existing};
use tsc_family::traffic::control::{nema, retime};
use tsc_family::traffic::controllers::create;
use tsc_family::traffic::env::{SignalEnv, run_episode};
use tsc_family::traffic::environment::{environment, generated_world};
use tsc_family::traffic::family::load::load_with;
use tsc_family::traffic::network::build::{BuildOptions, build_all};
use tsc_family::traffic::network::intersection::IntersectionSpec;
use tsc_family::traffic::program::{ProgramPhase, RingStages};
use tsc_family::traffic::settings::{Scenario, SixFeatures};
use tsc_family::traffic::sim::libsumo::SumoSim;

/// Length of an episode, in which every phase of the longest cycle is shown.
const HORIZON_S: usize = 360;

const RESCO: Limits = Limits {
    yellow: 3,
    all_red: 0,
    min_through: 7,
    min_left: 7,
    min_state: 7,
    walk: 0,
    max_green: usize::MAX,
};

/// Those that planted violations are held against.
const PLANTED: Limits = Limits { all_red: 1, min_left: 5, max_green: 20, ..RESCO };

/// Point MDPs with their limits under `field`, computed by hand:
/// yellow 1 + v / 6.1, all-red (w + 6.1) / v, together rounded up; walk 7 + w / 1.067 with lanes of 12 ft.
const POINTS: [(&str, [f64; 6], Limits); 3] = [
    // 8.94 m/s, 6.4 m: 2.47 + 1.40 s; 7.3 m: 13.9 s.
    ("slow", [2.0, 20.0, 200.0, 200.0, 0.0, 0.0], field(3, 1, 14)),
    // 13.41 m/s, 12.8 m: 3.20 + 1.41 s; 14.6 m: 20.7 s.
    ("narrow", [4.0, 30.0, 300.0, 400.0, 0.0, 0.0], field(4, 1, 21)),
    // 20.12 m/s, 19.2 m: 4.30 + 1.26 s; 22.0 m: 27.6 s.
    ("wide", [6.0, 45.0, 400.0, 700.0, 1.0, 1.0], field(5, 1, 28)),
];

const fn field(yellow: usize, all_red: usize, walk: usize) -> Limits {
    Limits { yellow, all_red, min_through: walk, min_left: 5, min_state: 5, walk, max_green: 60 }
}

struct Watch {
    env: SignalEnv<SumoSim>,
    states: PathBuf,
    limits: Limits,
    by_link: bool,
    turn_on_red: bool,
    /// Which links meet, as the network says.
    foes: Vec<Vec<bool>>,
    seconds: usize,
    wrong: Vec<String>,
}

impl Watch {
    fn new(scenario: &Scenario, features: [f64; 6], limits: Limits, folder: &Path) -> Self {
        let networks = folder.join("networks");
        let features = SixFeatures::from_array(features);
        let spec = IntersectionSpec::from_six_features(
            "p",
            &features,
            scenario.demand.approach_spread,
            DrivingSide::Right,
        );
        let options = BuildOptions { force: true, leave_out: false };
        let built = build_all(&[spec], scenario, &networks, options, &|_| ()).unwrap();
        let mut world = generated_world(&built.files["p"]).unwrap();
        let states = folder.join("states.xml");
        let event = format!(
            "<additional><timedEvent type=\"SaveTLSStates\" source=\"c\" dest=\"{}\"/></additional>",
            states.display()
        );
        fs::write(folder.join("p.add.xml"), event).unwrap();
        let config = fs::read_to_string(&world.config).unwrap();
        let config = config
            .replace("\"p.", &format!("\"{}/p.", built.files["p"].folder.display()))
            .replace("</input>", "<additional-files value=\"p.add.xml\"/></input>");
        world.config = folder.join("watched.sumocfg");
        fs::write(&world.config, config).unwrap();
        let env = environment(SumoSim::new().unwrap(), world, scenario, folder);
        let foes = foes(&built.files["p"].net);
        let turn_on_red = scenario.signal.turn_on_red;
        Self {
            env,
            states,
            limits,
            by_link: false,
            turn_on_red,
            foes,
            seconds: 0,
            wrong: Vec::new(),
        }
    }

    fn check(&mut self) {
        let states = states(&self.states);
        assert!(states.len() >= HORIZON_S - 1, "only {} states were saved", states.len());
        self.seconds += states.len();
        // Four equal arms count from the right turn; wherever it has no green and no yellow, it may go on red, but
        // beside a green that yields to it.
        let per_arm = states[0].len() / 4;
        for (second, state) in states.iter().enumerate() {
            for (link, letter) in state.chars().enumerate() {
                let yields = |(other, l): (usize, char)| l == 'g' && self.foes[link][other];
                let on_red = self.turn_on_red
                    && link % per_arm == 0
                    && !state.chars().enumerate().any(yields);
                if letter == (if on_red { 'r' } else { 's' }) {
                    self.wrong.push(format!("{second} s: link {link} shows {letter}"));
                }
            }
        }
        self.wrong.extend(match self.by_link {
            true => {
                assert_eq!(self.foes.len(), states[0].len());
                let may_meet = |a: usize, b: usize| self.foes[a][b];
                violations_by_link(&states, &ways(states[0].len()), &may_meet, &self.limits)
            }
            false => violations(&states, &through_links(states[0].len()), &self.limits),
        });
        if !self.by_link {
            self.wrong.extend(hurried(&states, &ways(states[0].len()), &self.limits));
        }
    }
}

/// The ways of the links of four equal arms, in the same order, clockwise from the north.
fn ways(links: usize) -> Vec<Way> {
    let (per_arm, through) = (links / 4, through_links(links));
    let to = |i: usize| match i % per_arm {
        _ if through.contains(&i) => 2,
        0 => 3,
        _ => 1,
    };
    (0..links).map(|i| Way { from: i / per_arm, to: (i / per_arm + to(i)) % 4 }).collect()
}

/// Through links of four equal arms: SUMO counts per arm from the right turn to the left turn, and both
/// turns have one link.
fn through_links(links: usize) -> Vec<usize> {
    let per_arm = links / 4;
    (0..links).filter(|i| i % per_arm != 0 && i % per_arm != per_arm - 1).collect()
}

impl Trainer for Watch {
    fn episode(
        &mut self,
        controller: &mut dyn Controller,
        seed: u32,
    ) -> Result<EpisodeOutcome, ControlError> {
        let metrics = run_episode(&mut self.env, controller, u64::from(seed)).unwrap();
        self.check();
        Ok(metrics.outcome().unwrap())
    }

    fn decisions_per_episode(&self) -> u32 {
        self.env.decisions_per_episode()
    }
}

/// Asks for another of so many phases at every decision, as untrained learners do, or always for the first one.
struct Asks {
    another: bool,
    phases: usize,
}

fn restless() -> Asks {
    Asks { another: true, phases: 1 }
}
fn stubborn() -> Asks {
    Asks { another: false, phases: 1 }
}

impl Controller for Asks {
    fn name(&self) -> &'static str {
        if self.another { "restless" } else { "stubborn" }
    }
    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        self.phases = signals[0].phases.len();
        Ok(vec![Drive::Decisions; signals.len()])
    }
    fn act(&mut self, seen: &[Observation], phases: &mut [GreenPhase]) -> Result<(), ControlError> {
        phases[0] = GreenPhase(if self.another { (seen[0].phase + 1) % self.phases } else { 0 });
        Ok(())
    }
}

/// Runs two rings within a cycle of the first set of phases that serves everybody, 10 s longer than their least greens.
struct Within;

impl Controller for Within {
    fn name(&self) -> &'static str {
        coordinated::METHOD.name
    }
    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        let set = &covering(&signals[0])[0];
        let least_s = signals[0].limits.least_s(set);
        let state = |phase: &usize| &signals[0].phases[*phase].state;
        let greens = set.iter().map(state).zip(least_s);
        let greens = greens.map(|(state, s)| ProgramPhase::fixed(state, s + 10.0)).collect();
        let rings = Config { max_green_s: 600, left_max_green_s: 600, ..Config::default() };
        let stages = RingStages { greens, offset_s: 17, coordinated: 0 };
        Ok(vec![Drive::CoordinatedRings(rings, stages)])
    }
}

fn scenario(preset: &str, actions: &str) -> Scenario {
    let (preset, more) =
        preset.split_once(' ').unwrap_or((preset, "simulation.time_to_teleport_s=-1"));
    let settings = [
        format!("preset={preset}"),
        more.to_owned(),
        format!("signal.actions={actions}"),
        format!("demand.horizon_s={HORIZON_S}"),
        "fixed_time.simulations=8".to_owned(),
        "retime.simulations=20".to_owned(),
        "training.episodes=1".to_owned(),
    ];
    let settings: Vec<Override> = settings.iter().map(|s| s.parse().unwrap()).collect();
    load_with("smoke", &settings).unwrap().scenario
}

/// Says to a copy of this program which preset it tries.
const PRESET: &str = "TSC_FAMILY_SHOWN_PRESET";

/// What the third copy tries.
const LEFTS: &str = "left turns and push buttons";

/// One test, because there is one simulation per process; a process per preset, because two are as fast as one.
#[test]
fn every_method_keeps_to_the_limits() {
    if let Ok(preset) = env::var(PRESET) {
        let seconds = if preset == LEFTS { checked_lefts() } else { checked_seconds(&preset) };
        println!("{preset}: {seconds} s checked, 0 violations");
        return;
    }
    let children = ["resco", "field", LEFTS].map(|preset| {
        Command::new(env::current_exe().unwrap())
            .args(["--exact", "shown_states::every_method_keeps_to_the_limits", "--nocapture"])
            .env(PRESET, preset)
            .spawn()
            .unwrap()
    });
    let alone = crate::alone();
    lights_of_other_limits_are_found_out();
    drop(alone);
    for mut child in children {
        assert!(child.wait().unwrap().success());
    }
}

fn checked_seconds(preset: &str) -> usize {
    let (mut seconds, mut within_rings) = (0, false);
    for actions in ["own-greens", "all-pairs"] {
        let scenario = scenario(preset, actions);
        // Streets of every speed have the same limits under `resco`.
        let points = if preset == "field" { &POINTS[..] } else { &POINTS[1..] };
        for &(name, features, field) in points {
            let folder = tempfile::tempdir().unwrap();
            let limits = if preset == "field" { field } else { RESCO };
            let mut watch = Watch::new(&scenario, features, limits, folder.path());
            let mut controllers: Vec<Box<dyn Controller>> =
                vec![Box::new(restless()), Box::new(stubborn()), Box::new(Within)];
            // An existing plan has its own times, and these networks have none; nor have they signals to coordinate.
            let others = [existing::METHOD.name, coordinated::METHOD.name];
            for method in METHODS.iter().filter(|m| !others.contains(&m.name)) {
                controllers.push(create(method.name, &scenario, false, 1).unwrap());
            }
            for mut controller in controllers {
                let within = controller.name() == coordinated::METHOD.name;
                watch.by_link =
                    within || [nema::METHOD.name, retime::METHOD.name].contains(&controller.name());
                // Coordinated phases last until the cycle lets them end.
                watch.limits.max_green = if within { usize::MAX } else { limits.max_green };
                controller.train(&mut watch).unwrap();
                watch.episode(controller.as_mut(), 99).unwrap();
                let wrong = std::mem::take(&mut watch.wrong);
                let method = controller.name();
                within_rings |= within && watch.env.dual_rings().next().is_some();
                assert!(wrong.is_empty(), "{method}, {preset}, {actions}, {name}: {wrong:#?}");
            }
            seconds += watch.seconds;
        }
    }
    assert!(within_rings, "no signal ran two rings within a cycle");
    seconds
}

/// Checks what methods of every kind show where left turns are signalled as they are set, and where people push
/// buttons, and returns how long that was, seconds.
fn checked_lefts() -> usize {
    let (_, features, field) = POINTS[2];
    let pressed = Limits { min_through: 7, walk: 0, ..field };
    let mut seconds = 0;
    for (setting, limits) in [
        ("signal.left_turns=permissive", field),
        ("signal.left_turns=protected", field),
        ("signal.left_turns=protected-permissive", field),
        ("signal.left_turns=by-rule", field),
        ("signal.pedestrian_calls_per_h=60", pressed),
    ] {
        for actions in ["own-greens", "all-pairs"] {
            let scenario = scenario(&format!("field {setting}"), actions);
            let folder = tempfile::tempdir().unwrap();
            let mut watch = Watch::new(&scenario, features, limits, folder.path());
            for name in ["restless", "baseline", "actuated", "max-pressure", "nema"] {
                let mut controller: Box<dyn Controller> = match name {
                    "restless" => Box::new(restless()),
                    name => create(name, &scenario, false, 1).unwrap(),
                };
                watch.by_link = name == nema::METHOD.name;
                watch.episode(controller.as_mut(), 99).unwrap();
                let states = states(&watch.states);
                let per_arm = states[0].len() / 4;
                let lefts = |letter: char| {
                    let mut left =
                        states.iter().flat_map(|s| s.chars().skip(per_arm - 1).step_by(per_arm));
                    left.any(|c| c == letter)
                };
                match setting {
                    "signal.left_turns=permissive" => assert!(!lefts('G'), "{name}, {actions}"),
                    "signal.left_turns=protected" => assert!(!lefts('g'), "{name}, {actions}"),
                    _ => {}
                }
                let wrong = std::mem::take(&mut watch.wrong);
                assert!(wrong.is_empty(), "{name}, {setting}, {actions}: {wrong:#?}");
            }
            seconds += watch.seconds;
        }
    }
    seconds
}

/// Lights that keep to `resco` do not keep to `field`, and the check says so.
fn lights_of_other_limits_are_found_out() {
    let scenario = scenario("resco", "own-greens");
    for (_, features, field) in POINTS {
        let folder = tempfile::tempdir().unwrap();
        let mut watch = Watch::new(&scenario, features, field, folder.path());
        watch.episode(&mut restless(), 1).unwrap();
        let wrong = watch.wrong.join("\n");
        assert!(wrong.contains("after the last yellow"), "{wrong}");
        assert!(wrong.contains(" can be crossed for 7 s, not "), "{wrong}");
        watch.wrong.clear();
        watch.by_link = true;
        watch.episode(create("nema", &scenario, false, 1).unwrap().as_mut(), 1).unwrap();
        let wrong = std::mem::take(&mut watch.wrong).join("\n");
        assert!(wrong.contains(" begins 0 s after "), "{wrong}");
        assert!(wrong.contains(", not "), "{wrong}");
        watch.by_link = false;
        watch.episode(&mut stubborn(), 1).unwrap();
        assert!(watch.wrong.is_empty(), "it never changes");
    }
}

/// Returns what a check says of states that each last for some seconds.
fn said(check: impl Fn(&[String]) -> Vec<String>, script: &[(&str, usize)]) -> Vec<String> {
    let second = |(state, count): &(&str, usize)| vec![(*state).to_owned(); *count];
    check(&script.iter().flat_map(second).collect::<Vec<_>>())
}

#[test]
fn planted_violations_of_two_rings_are_found() {
    let check = |states: &[String]| violations_by_link(states, &ways(12), &|_, _| true, &PLANTED);
    let red = ("rrrrrrrrrrrr", 2);
    let main = |seconds| ("GGgrrrGGgrrr", seconds);
    let ends = ("yyyrrryyyrrr", 3);
    let left = ("GGGrrrrrrrrr", 5);
    let fair = [red, left, ("GGgrrrrrrrrr", 4), main(9), ends, red, ("rrrGGgrrrGGg", 9)];
    assert_eq!(said(check, &fair), [""; 0]);
    let found = |script: &[(&str, usize)], what: &str| {
        let wrong = said(check, script);
        assert!(wrong.iter().any(|w| w.contains(what)), "{what}: {wrong:?}");
    };
    found(&[red, ("GGGrrrGGgrrr", 9)], "links 2 and 7 have right of way");
    found(&[red, ("GggrrrGGgGrr", 9)], "link 1 is green beside 9");
    found(&[red, main(9), ("GGyrrrGGyrrr", 3), red], "yellow of 2 beside the green of 7");
    found(&[red, main(9), ("yyyrrryyyrrr", 2), red], "has 2 s of yellow");
    found(&[red, main(9), ends, ("rrrGGgrrrGGg", 9)], "begins 0 s after");
    found(&[red, main(9), ("yyyGrryyyrrr", 3), red], "begins in the yellow of");
    found(&[red, main(9), ("yyyrrryyyrrr", 3), main(9)], "from yellow to green");
    found(&[red, main(6), ends, red], "link 1 was green for 6 s, not 7");
    found(&[red, ("rrGrrrrrGrrr", 4), ("rryrrrrryrrr", 3), red], "link 2 was green for 4 s, not 5");
    found(&[red, main(21), ends, red], "link 1 was green for 21 s");
}

#[test]
fn planted_violations_are_found() {
    let check = |states: &[String]| violations(states, &[0], &PLANTED);
    let first = ("Gr", 9);
    let fair = [first, ("yr", 3), ("rr", 1), ("rG", 5), ("ry", 3), ("rr", 2)];
    assert_eq!(said(check, &fair), [""; 0]);
    let found = |script: &[(&str, usize)], what: &str| {
        let wrong = said(check, script);
        assert!(wrong.iter().any(|w| w.contains(what)), "{wrong:?}");
    };
    found(&[first, ("yr", 2), ("rr", 1), ("rG", 9)], "2 s of yellow");
    found(&[first, ("rr", 1), ("rG", 9)], "0 s of yellow");
    found(&[first, ("yr", 3), ("rG", 9)], "green 0 s after");
    found(&[first, ("yr", 3), ("rr", 1), ("rG", 4), ("ry", 3), ("rr", 1)], "lasts 4 s, not 5");
    found(&[("Gr", 21), ("yr", 3), ("rr", 1), ("rG", 9)], "lasts 21 s");
    found(&[first, ("yr", 3), ("Gr", 9)], "from yellow to green");
}

#[test]
fn planted_haste_is_found() {
    let check = |states: &[String]| hurried(states, &ways(12), &field(3, 1, 19));
    let red = ("rrrrrrrrrrrr", 2);
    assert_eq!(said(check, &[red, ("GGgrrrGGgrrr", 19), red]), [""; 0]);
    assert_eq!(said(check, &[red, ("GGgrrrGGgrrr", 18), red]).len(), 2);
    // The second green has an arrow over arm 1; arm 3 can be crossed in both.
    let arrow = ("GGGrrrrrrrrr", 9);
    let wrong = said(check, &[red, ("GGgrrrGGgrrr", 12), ("GGgrrryyyrrr", 3), arrow, red]);
    assert_eq!(wrong, ["2 s: arm 1 can be crossed for 15 s, not 19"]);
}
