//! Networks as netconvert really builds them: shapes, both programs, repeatability, alteration.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use osm_signals::DrivingSide;
use osm_signals::Turns;
use tsc_family::settings::overrides::Override;
use tsc_family::traffic::family::load;
use tsc_family::traffic::network::build::Built;
use tsc_family::traffic::network::build::{BuildOptions, BuildSummary, build_all};
use tsc_family::traffic::network::demand::DemandSpec;
use tsc_family::traffic::network::error::NetworkError;
use tsc_family::traffic::network::intersection::{Arm, IntersectionSpec, intersections};
use tsc_family::traffic::network::plain::DEFAULT_PROGRAM;
use tsc_family::traffic::network::validate::validate;
use tsc_family::traffic::program::ProgramPhase;
use tsc_family::traffic::settings::{Scenario, defaults};
use tsc_family::traffic::sim::net_file::NetFile;

use crate::nightly::is_nightly;

const EXIT_LENGTH_M: f64 = 60.0;

fn spec(point: &str, bearings_deg: &[f64]) -> IntersectionSpec {
    let arm = |bearing_deg: &f64| Arm {
        bearing_deg: *bearing_deg,
        lanes_in: 2,
        lanes_out: 2,
        speed_mps: 13.41,
        length_m: 234.5,
        inflow_vph: 400.0,
        ..Arm::default()
    };
    let arms = bearings_deg.iter().map(arm).collect();
    IntersectionSpec { point: point.into(), arms, ..IntersectionSpec::default() }
}

fn cross() -> IntersectionSpec {
    spec("cross", &[0.0, 90.0, 180.0, 270.0])
}

fn tee() -> IntersectionSpec {
    spec("tee", &[0.0, 90.0, 180.0])
}

fn with_double_lefts() -> IntersectionSpec {
    let mut s = IntersectionSpec { point: "double-lefts".into(), ..cross() };
    for arm in &mut s.arms {
        (arm.lanes_in, arm.left_turn_lanes, arm.right_turn_lanes) = (4, 2, 1);
    }
    s
}

/// Bays of two lengths, one arm with one of them only, and one whose lanes all turn.
fn with_bays() -> IntersectionSpec {
    let mut s = IntersectionSpec { point: "bays".into(), ..with_double_lefts() };
    for arm in &mut s.arms {
        (arm.left_storage_m, arm.right_storage_m) = (Some(80.0), Some(30.0));
    }
    s.arms[1].right_storage_m = None;
    s.arms.remove(3);
    let stem = &mut s.arms[1];
    (stem.lanes_in, stem.left_turn_lanes, stem.right_turn_lanes) = (2, 1, 1);
    s
}

fn one_way() -> IntersectionSpec {
    let mut s = IntersectionSpec { point: "one-way".into(), ..cross() };
    s.arms[0].lanes_in = 0;
    s.arms[1].lanes_out = 0;
    s.arms[2].turns = Some(Turns { left: false, ..Turns::ALL });
    s
}

fn shapes() -> Vec<IntersectionSpec> {
    vec![
        cross(),
        with_double_lefts(),
        with_bays(),
        one_way(),
        tee(),
        spec("wye", &[0.0, 120.0, 240.0]),
        spec("five", &[0.0, 72.0, 144.0, 216.0, 288.0]),
        spec("crooked-five", &[10.0, 47.0, 95.0, 182.0, 260.0]),
        spec("six", &[0.0, 60.0, 120.0, 180.0, 240.0, 300.0]),
        spec("straight", &[0.0, 180.0]),
    ]
}

fn build(
    specs: &[IntersectionSpec],
    out: &Path,
    force: bool,
) -> Result<BuildSummary, NetworkError> {
    let mut scenario = defaults();
    scenario.demand.horizon_s = 300.0;
    build_all(specs, &scenario, out, BuildOptions { force, leave_out: false }, &|_| ())
}

fn files(folder: &Path) -> BTreeSet<(String, Vec<u8>)> {
    let mut all = BTreeSet::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            all.extend(files(&path));
        } else {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            all.insert((name, fs::read(&path).unwrap()));
        }
    }
    all
}

fn cross_net() -> String {
    let out = tempfile::tempdir().unwrap();
    build(&[cross()], out.path(), false).unwrap();
    fs::read_to_string(out.path().join("cross/cross.net.xml")).unwrap()
}

fn fault(net: &str) -> String {
    let result = validate(&cross(), &NetFile::parse(net).unwrap(), EXIT_LENGTH_M);
    result.map_or_else(|e| e.to_string(), |()| "sound".to_owned())
}

#[test]
fn every_shape_builds_and_is_sound() {
    let out = tempfile::tempdir().unwrap();
    let done = Mutex::new(BTreeSet::new());
    let progress = |point: &str| assert!(done.lock().unwrap().insert(point.to_owned()));
    let options = BuildOptions::default();
    let summary = build_all(&shapes(), &defaults(), out.path(), options, &progress).unwrap();
    assert_eq!((summary.built, done.lock().unwrap().len()), (10, 10));
    let mut all = Built::all(out.path()).unwrap();
    all.sort_by(|a, b| a.point.cmp(&b.point));
    let phases: Vec<_> = all.iter().map(|r| (r.point.as_str(), r.arms, r.phases)).collect();
    let expected = [
        ("bays", 3, 3),
        ("crooked-five", 5, 3),
        ("cross", 4, 2),
        ("double-lefts", 4, 8),
        ("five", 5, 5),
        ("one-way", 4, 3),
        ("six", 6, 3),
        ("straight", 2, 1),
        ("tee", 3, 2),
        ("wye", 3, 3),
    ];
    assert_eq!(phases, expected);
}

/// Every network of the embedded city, as point MDPs and as itself, under both presets: it can be built,
/// both presets have the same greens where nothing is said of left turns and merging, and an all-red is never longer than it has to be. Of the peak hour, whose
/// intersections are the same with other inflows, every eighth; of the intersections as themselves every third. At
/// every change a twentieth of these.
#[test]
fn the_whole_city_builds_under_both_presets_with_the_same_greens() {
    let daily = if is_nightly() { 1 } else { 20 };
    for (city, detail, step) in [
        ("salt-lake-city", "six-features", 1),
        ("salt-lake-city-peak", "six-features", 8),
        ("salt-lake-city", "per-approach", 3),
    ] {
        let greens = ["resco", "field"].map(|preset| {
            let settings = [
                format!("preset={preset}"),
                format!("family.detail={detail}"),
                "signal.left_turns=network".to_owned(),
                "signal.no_merging_greens=false".to_owned(),
            ];
            let settings: Vec<Override> = settings.iter().map(|s| s.parse().unwrap()).collect();
            let loaded = load::load_with(city, &settings).unwrap();
            let specs = intersections(&loaded).unwrap();
            let specs: Vec<_> = specs.into_iter().step_by(step * daily).collect();
            let out = tempfile::tempdir().unwrap();
            let options = BuildOptions::default();
            build_all(&specs, &loaded.scenario, out.path(), options, &|_| ()).unwrap();
            let program = |spec: &IntersectionSpec| {
                let path = out.path().join(format!("{0}/{0}.net.xml", spec.point));
                let net = NetFile::parse(&fs::read_to_string(path).unwrap()).unwrap();
                program_greens(spec, net.program(DEFAULT_PROGRAM).unwrap(), preset)
            };
            specs.iter().map(program).collect::<Vec<_>>()
        });
        assert_eq!(greens[0], greens[1], "{city}, {detail}");
    }
}

/// The greens of a default program, by what follows yellow, after checks that need no other code.
fn program_greens(spec: &IntersectionSpec, program: &[ProgramPhase], preset: &str) -> Vec<String> {
    let point = &spec.point;
    let mut greens = Vec::new();
    // A right turn on red has red, with leave to go.
    let red = |p: &ProgramPhase| ProgramPhase { state: p.state.replace('s', "r"), ..p.clone() };
    let program: Vec<ProgramPhase> = program.iter().map(red).collect();
    for (i, phase) in program.iter().enumerate() {
        let before = &program[(i + program.len() - 1) % program.len()];
        let after_yellow = before.state.contains('y');
        let all_red = after_yellow && before.state.replace('y', "r") == phase.state;
        if phase.state.contains('y') {
            assert!(phase.duration_s >= 3.0, "{point}: {phase:?}");
        } else if all_red && phase.duration_s < 5.0 {
            assert_eq!(preset, "field", "{point}: {phase:?}");
        } else {
            let least = if preset == "field" { 5.0 } else { 7.0 };
            assert!(phase.duration_s >= least, "{point}: {phase:?}");
            assert!(phase.state.contains(['G', 'g']), "{point}: {phase:?}");
            greens.push(phase.state.clone());
        }
    }
    greens
}

#[test]
fn two_builds_are_equal_byte_by_byte_and_leave_nothing_else_behind() {
    let (one, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    build(&shapes(), one.path(), false).unwrap();
    build(&shapes(), other.path(), false).unwrap();
    assert_eq!(files(one.path()), files(other.path()));
    assert_eq!(fs::read_dir(one.path()).unwrap().count(), 10 + 1);
}

#[test]
fn what_is_up_to_date_is_not_built_again_and_what_changed_is() {
    let out = tempfile::tempdir().unwrap();
    let mut specs = vec![cross(), tee()];
    build(&specs, out.path(), false).unwrap();
    let summary = build(&specs, out.path(), false).unwrap();
    assert_eq!((summary.built, summary.up_to_date, summary.netconvert), (0, 2, None));
    specs[0].arms[0].inflow_vph = 500.0;
    let summary = build(&specs, out.path(), false).unwrap();
    assert_eq!((summary.built, summary.up_to_date), (1, 1));
}

fn networks(folder: &Path) -> BTreeSet<(PathBuf, Vec<u8>)> {
    let entries = |folder: &Path| fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
    let files = entries(&folder.join("by-hash")).flat_map(|network| entries(&network));
    files.map(|path| (path.clone(), fs::read(&path).unwrap())).collect()
}

#[test]
fn a_build_with_other_settings_leaves_networks_as_they_are() {
    let out = tempfile::tempdir().unwrap();
    let build = |scenario: &Scenario, force| {
        let options = BuildOptions { force, leave_out: false };
        build_all(&[cross()], scenario, out.path(), options, &|_| ()).unwrap()
    };
    let (first, mut second) = (defaults(), defaults());
    second.network.default_cycle_s = 30.0;
    let shown = || fs::read_to_string(out.path().join("cross/cross.net.xml")).unwrap();
    build(&first, false);
    let (before, first_shown) = (networks(out.path()), shown());
    assert_eq!(build(&second, false).built, 1);
    let both = networks(out.path());
    assert!(both.is_superset(&before) && both.len() == 10);
    assert_ne!(shown(), first_shown);
    // Back again: nothing is built, and people see the network that was asked for.
    assert_eq!(build(&first, false).up_to_date, 1);
    assert_eq!(shown(), first_shown);
    build(&first, true);
    assert_eq!(networks(out.path()), both);
}

#[test]
fn an_impossible_intersection_leaves_no_files() {
    let out = tempfile::tempdir().unwrap();
    let mut bad = cross();
    bad.arms.iter_mut().for_each(|arm| arm.lanes_out = 0);
    let e = build(&[bad], out.path(), false).unwrap_err();
    assert!(matches!(e, NetworkError::Intersection { .. }), "{e}");
    assert!(files(out.path()).is_empty());
}

#[test]
fn the_routes_of_a_point_are_those_of_seed_0() {
    let out = tempfile::tempdir().unwrap();
    let built = build(&[cross()], out.path(), false).unwrap();
    let files = &built.files["cross"];
    let again = out.path().join("again.rou.xml");
    let vehicles = DemandSpec::read(&files.demand).unwrap().write_routes(0, &again).unwrap();
    assert_eq!(fs::read(&again).unwrap(), fs::read(&files.routes).unwrap());
    assert!((80..200).contains(&vehicles), "{vehicles}");
}

#[test]
fn a_sound_network_passes_and_its_lengths_are_exact() {
    let net = cross_net();
    assert_eq!(fault(&net), "sound");
    let lanes = NetFile::parse(&net).unwrap().lanes;
    let lengths = |kind: &str| -> Vec<_> {
        lanes.iter().filter(|l| l.edge.starts_with(kind)).map(|l| l.length_m).collect()
    };
    assert_eq!((lengths("in"), lengths("out")), (vec![234.5; 8], vec![EXIT_LENGTH_M; 8]));
}

#[test]
fn planted_faults_are_found() {
    let net = cross_net();
    let start = net.find("<connection from=\"in0\" to=\"out3\"").unwrap();
    let connection = &net[start..=start + net[start..].find("/>").unwrap() + 1];
    let other = "<tlLogic id=\"c\" type=\"static\" programID=\"zzz\"></tlLogic><tlLogic";
    for (from, to, expected) in [
        // The fourth link turns left across the opposing through lanes.
        ("state=\"GGGg", "state=\"GGGG", "meet but are both protected"),
        ("GGGgrrrrGGGgrrrr", "rrrrrrrrrrrrrrrr", "program \"phases\", phase 0: serves nothing"),
        ("length=\"234.50\" shape", "length=\"230.00\" shape", "of 234.5 m with 13.41 m/s"),
        (connection, "", "connection in0_0 to out3_0 is missing or was not asked for"),
        ("<tlLogic", other, "program \"program\" is not the one that SUMO starts with"),
    ] {
        let fault = fault(&net.replacen(from, to, 1));
        assert!(fault.ends_with(expected), "{from}: {fault}");
    }
    let fault = fault(&net.replace("state=\"G", "state=\"r"));
    assert!(fault.ends_with("in0_0 to out3_0 is never green"), "{fault}");
}

#[test]
fn bays_are_pieces_of_the_street_and_change_nothing_at_the_signal() {
    let folder = tempfile::tempdir().unwrap();
    let bays = with_bays();
    let mut whole = IntersectionSpec { point: "whole".into(), ..bays.clone() };
    for arm in &mut whole.arms {
        (arm.left_storage_m, arm.right_storage_m) = (None, None);
    }
    let left = IntersectionSpec { point: "left".into(), side: DrivingSide::Left, ..bays.clone() };
    let built = build(&[bays, whole, left], folder.path(), false).unwrap();
    let net = |point: &str| {
        NetFile::parse(&fs::read_to_string(&built.files[point].net).unwrap()).unwrap()
    };
    let (bays, whole) = (net("bays"), net("whole"));
    let lanes = |net: &NetFile, edge: &str| {
        let of: Vec<f64> =
            net.lanes.iter().filter(|l| l.edge == edge).map(|l| l.length_m).collect();
        (of.len(), of.first().copied().unwrap_or_default())
    };
    // 234.5 m: 30 m with all four lanes, 50 m without the right one, the rest without the two left ones.
    assert_eq!(
        [lanes(&bays, "in0"), lanes(&bays, "up0"), lanes(&bays, "far0")],
        [(4, 30.0), (3, 50.0), (1, 154.5)]
    );
    assert_eq!(
        [lanes(&bays, "in1"), lanes(&bays, "up1"), lanes(&bays, "far1")],
        [(2, 80.0), (1, 154.5), (0, 0.0)]
    );
    assert_eq!(lanes(&whole, "in0"), (4, 234.5));
    assert_eq!((&bays.links, &bays.programs), (&whole.links, &whole.programs));
    assert_eq!(lanes(&net("left"), "far0"), (1, 154.5));
    let demand = DemandSpec::read(&built.files["bays"].demand).unwrap();
    assert_eq!(
        (demand.streams[0].from.as_str(), &demand.streams[0].upstream[..]),
        ("in0", &["far0".to_owned(), "up0".to_owned()][..])
    );
    let (_, routes) = demand.routes(1);
    assert!(routes.contains("edges=\"far0 up0 in0 out2\""), "{routes}");
    // Without bays nothing is written that was not before.
    let text = fs::read_to_string(&built.files["whole"].demand).unwrap();
    assert!(!text.contains("upstream") && !text.contains("storage"), "{text}");
}
