//! Events of a high-resolution data logger against what SUMO itself says: its lights second by second, and induction loops.
#![cfg(feature = "libsumo")]
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::Path;
use std::process::Command;
use std::{env, fs};

use osm_signals::DrivingSide;
use tsc_family::settings::overrides::Override;
use tsc_family::traffic::controllers::create;
use tsc_family::traffic::env::high_resolution::{Function, Recording, code};
use tsc_family::traffic::env::run_episode;
use tsc_family::traffic::environment::{environment, generated_world};
use tsc_family::traffic::events;
use tsc_family::traffic::family::load::load_with;
use tsc_family::traffic::network::build::{BuildOptions, build_all};
use tsc_family::traffic::network::intersection::IntersectionSpec;
use tsc_family::traffic::settings::{Scenario, SixFeatures};
use tsc_family::traffic::sim::libsumo::SumoSim;

/// Six lanes, 30 mph, 300 m, 420 veh/h per approach, a left lane, no right lane.
const FEATURES: [f64; 6] = [6.0, 30.0, 300.0, 420.0, 1.0, 0.0];

/// Approaches clockwise from the north, as vehicles drive.
const APPROACHES: [&str; 4] = ["SB", "WB", "NB", "EB"];

/// Incoming lanes of an approach: one to go straight on or right, one to go straight on, one for left turns.
const LANES: usize = 3;

/// Where the loops lie, metres before the stop line.
const LOOP_M: f64 = 100.0;

fn scenario() -> Scenario {
    let settings = [
        "preset=field",
        "signal.pedestrian_calls_per_h=40",
        "demand.horizon_s=1800",
        "simulation.time_to_teleport_s=-1",
    ];
    let settings: Vec<Override> = settings.iter().map(|s| s.parse().unwrap()).collect();
    load_with("smoke", &settings).unwrap().scenario
}

/// Returns the value of an attribute in a line of XML.
fn attribute<'a>(line: &'a str, name: &str) -> Option<&'a str> {
    let (_, rest) = line.split_once(&format!(" {name}=\""))?;
    Some(rest.split_once('"')?.0)
}

/// Reads the states that SUMO saved, by second.
fn states(path: &Path) -> Vec<String> {
    let text = fs::read_to_string(path).unwrap();
    let lines = text.lines().filter(|line| line.contains("<tlsState "));
    let states: BTreeMap<usize, String> = lines
        .map(|line| {
            let second: f64 = attribute(line, "time").unwrap().parse().unwrap();
            (second as usize, attribute(line, "state").unwrap().to_owned())
        })
        .collect();
    assert_eq!(states.keys().copied().collect::<Vec<_>>(), (0..states.len()).collect::<Vec<_>>());
    states.into_values().collect()
}

/// What SUMO's loops say is the time of the step before, seconds: vehicles move in a step while the lights show what is saved
/// with the time of that step.
const STEP_S: f64 = 1.0;

/// Reads when each vehicle came to the loops of an approach, seconds.
fn arrivals(path: &Path, approach: usize) -> Vec<f64> {
    let text = fs::read_to_string(path).unwrap();
    let mut first: BTreeMap<String, f64> = BTreeMap::new();
    for line in text.lines().filter(|line| line.contains("state=\"enter\"")) {
        if attribute(line, "id").unwrap().starts_with(&format!("in{approach}_")) {
            let at_s: f64 = attribute(line, "time").unwrap().parse().unwrap();
            first.entry(attribute(line, "vehID").unwrap().to_owned()).or_insert(at_s + STEP_S);
        }
    }
    let mut times: Vec<f64> = first.into_values().collect();
    times.sort_by(f64::total_cmp);
    times
}

/// Returns the seconds in which an event of a phase or channel comes.
fn seconds(recording: &Recording, code: u16, parameter: u32) -> Vec<usize> {
    let is = |e: &&tsc_family::traffic::env::high_resolution::Event| {
        (e.code, e.parameter) == (code, parameter)
    };
    recording.events.iter().filter(is).map(|e| (e.at_ds / 10) as usize).collect()
}

/// Returns the phase that goes straight on from an approach.
fn through_phase(recording: &Recording, approach: usize) -> u32 {
    let name = format!("{}T", APPROACHES[approach]);
    recording.phases.iter().find(|p| p.movements.contains(&name)).unwrap().number
}

/// Returns when a link turns to one of some letters from others.
fn turns_to(states: &[String], link: usize, letters: &[u8]) -> Vec<usize> {
    let is = |second: usize| letters.contains(&states[second].as_bytes()[link]);
    (0..states.len()).filter(|s| is(*s) && (*s == 0 || !is(*s - 1))).collect()
}

/// One test, because there is one simulation per process.
#[test]
fn events_are_what_was_simulated() {
    let scenario = scenario();
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let networks = folder.join("networks");
    let Scenario { network, demand, signal, .. } = &scenario;
    let features = SixFeatures::from_array(FEATURES);
    let spread = demand.approach_spread;
    let spec = IntersectionSpec::from_six_features("p", &features, spread, DrivingSide::Right);
    let options = BuildOptions { force: true, leave_out: false };
    let built = build_all(&[spec], network, demand, signal, &networks, options, &|_| ()).unwrap();
    let files = &built.files["p"];
    let (saved, loops) = (folder.join("states.xml"), folder.join("loops.xml"));
    let mut more = format!(
        "<additional><timedEvent type=\"SaveTLSStates\" source=\"c\" dest=\"{}\"/>",
        saved.display()
    );
    for lane in (0..4).flat_map(|a| (0..LANES).map(move |l| format!("in{a}_{l}"))) {
        more.push_str(&format!(
            "<instantInductionLoop id=\"{lane}\" lane=\"{lane}\" pos=\"-{LOOP_M}\" file=\"{}\"/>",
            loops.display()
        ));
    }
    fs::write(folder.join("p.add.xml"), more + "</additional>").unwrap();

    let mut sim = Some(SumoSim::new().unwrap());
    let mut on_green = 0;
    for method in ["nema", "baseline", "actuated", "max-pressure"] {
        let mut world = generated_world(files).unwrap();
        let config = fs::read_to_string(&files.sumocfg).unwrap();
        let config = config
            .replace("\"p.", &format!("\"{}/p/p.", networks.display()))
            .replace("</input>", "<additional-files value=\"p.add.xml\"/></input>");
        world.config = folder.join("watched.sumocfg");
        fs::write(&world.config, config).unwrap();
        let mut env = environment(sim.take().unwrap(), world, &scenario, folder);
        env.write_events(LOOP_M);
        let mut controller = create(method, &scenario, false, 1).unwrap();
        run_episode(&mut env, controller.as_mut(), 7).unwrap();
        let recording = env.take_recording();
        let states = states(&saved);
        assert!(states.len() >= 1799, "{method}: only {} states were saved", states.len());

        let per_arm = states[0].len() / 4;
        let mut expected = String::from("phase,arrivals,on_green\n");
        for approach in 0..4 {
            let (link, phase) = (approach * per_arm + 1, through_phase(&recording, approach));
            let in_time = |mut all: Vec<usize>| {
                all.retain(|second| *second < states.len());
                all
            };
            let of = |code: u16| in_time(seconds(&recording, code, phase));
            let greens = turns_to(&states, link, b"Gg");
            assert!(greens.len() > 5, "{method}, {phase}: {greens:?}");
            assert_eq!(of(code::BEGIN_GREEN), greens, "{method}, {phase}");
            let yellows = turns_to(&states, link, b"y");
            assert_eq!(of(code::BEGIN_YELLOW), yellows, "{method}, {phase}");
            let mut reds = turns_to(&states, link, b"rs");
            reds.retain(|second| *second > 0);
            assert_eq!(of(code::BEGIN_RED), reds, "{method}, {phase}");
            // Two seconds of all-red: (19.2 + 6.1) m at 13.4 m/s, with 3.2 s of yellow together 6 s.
            let ends: Vec<usize> = reds.iter().map(|red| red + 2).collect();
            assert_eq!(of(code::END_RED), in_time(ends), "{method}, {phase}");

            let own = arrivals(&loops, approach);
            let channels = recording.detectors.iter().filter(|d| {
                d.function == Function::Advance && d.lane.starts_with(&format!("in{approach}_"))
            });
            let channels: Vec<u32> = channels.map(|d| d.channel).collect();
            assert_eq!(channels.len(), LANES);
            let is_on =
                |channel: u32, c: u16| c == code::DETECTOR_ON && channels.contains(&channel);
            let seen: Vec<f64> = (recording.events.iter())
                .filter(|e| is_on(e.parameter, e.code))
                .map(|e| e.at_ds as f64 / 10.0)
                .collect();
            assert!(own.len() > 60, "{method}: {}", own.len());
            assert_eq!(seen.len(), own.len(), "{method}, {approach}");
            for (seen, own) in seen.iter().zip(&own) {
                assert!((seen - own).abs() < 0.35, "{method}, {approach}: {seen}, {own}");
            }

            // Through lanes alone: the left lane has another phase.
            let text = fs::read_to_string(&loops).unwrap();
            let lanes = [format!("in{approach}_0"), format!("in{approach}_1")];
            let is_through = |line: &&str| {
                line.contains("state=\"enter\"")
                    && lanes.iter().any(|lane| attribute(line, "id") == Some(lane))
            };
            let through: Vec<usize> = (text.lines().filter(is_through))
                .map(|line| attribute(line, "time").unwrap().parse::<f64>().unwrap() + STEP_S)
                .map(|at_s| at_s as usize)
                .collect();
            let is_green = |s: &&usize| {
                matches!(states.get(**s).map(|s| s.as_bytes()[link]), Some(b'G' | b'g'))
            };
            let greens = through.iter().filter(is_green).count();
            on_green += greens;
            expected.push_str(&format!("{phase},{},{greens}\n", through.len()));
        }
        let walks = recording.events.iter().filter(|e| e.code == code::BEGIN_WALK).count();
        assert!(walks > 3, "{method}: {walks}");
        let reasons = |c: u16| recording.events.iter().filter(|e| e.code == c).count();
        let known = reasons(code::GAP_OUT) + reasons(code::MAX_OUT);
        assert_eq!(known > 20, method == "nema", "{method}: {known}");
        assert_eq!(reasons(code::CYCLE), usize::from(method == "baseline"), "{method}");

        let out = folder.join(method);
        fs::create_dir(&out).unwrap();
        let start = events::start("2026-03-02 07:00").unwrap();
        fs::write(out.join("events.csv"), events::events(&recording, start)).unwrap();
        fs::write(out.join("detectors.csv"), events::detectors(&recording)).unwrap();
        fs::write(out.join("expected.csv"), expected).unwrap();
        fed_to_atspm(&out);
        sim = Some(env.into_sim());
    }
    assert!(on_green > 500, "{on_green}");
}

/// Compares arrivals on green that `atspm` computes with those counted from loops and lights, where it is installed.
fn fed_to_atspm(folder: &Path) {
    let python = env::var("TSC_FAMILY_ATSPM_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/scripts/atspm_check.py");
    let output = Command::new(python)
        .arg(script)
        .arg(folder)
        .arg("--expected")
        .arg(folder.join("expected.csv"))
        .output();
    let say = |text: &str| {
        let mut said = std::io::stderr();
        writeln!(said, "{text}").unwrap();
    };
    let Ok(output) = output else { return say("skipped: there is no Python") };
    let said = String::from_utf8_lossy(&output.stderr);
    match output.status.code() {
        Some(77) => say(&said),
        code => assert_eq!(code, Some(0), "{said}\n{}", String::from_utf8_lossy(&output.stdout)),
    }
}
