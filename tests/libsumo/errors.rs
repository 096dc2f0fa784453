use std::path::PathBuf;

use crate::fixture::{EDGES, NODES, Scenario};
use tsc_family::traffic::sim::libsumo::SumoSim;
use tsc_family::traffic::sim::{Sim, SimError, Snapshot, StartOptions};

const GOOD: &str = r#"<vehicle id="v" depart="0"><route edges="WA AB BE"/></vehicle>"#;
const UNKNOWN_EDGE: &str = r#"<vehicle id="v" depart="0"><route edges="WA missing"/></vehicle>"#;
/// SUMO checks whether a route is connected only when the vehicle is about to depart.
const GAP: &str = r#"<vehicle id="v" depart="10"><route edges="WA BE"/></vehicle>"#;

#[test]
fn a_failure_is_an_error_and_the_process_can_simulate_again() {
    let _alone = crate::alone();
    let scenario = Scenario::new();
    let plain = NODES.replace(r#" type="traffic_light""#, "");
    scenario.build("plain", &plain, EDGES, None);
    let cycles = EDGES.replace("<edge ", r#"<edge allow="bicycle" "#);
    scenario.build("cycles", NODES, &cycles, None);
    let good = scenario.options("net", "good", GOOD);
    let mut sim = SumoSim::new().unwrap();

    assert!(matches!(sim.step(1), Err(SimError::NotRunning)));
    assert!(matches!(sim.select(0, "0"), Err(SimError::NotRunning)));
    assert!(matches!(sim.set_phases(&[]), Err(SimError::NotRunning)));
    assert!(matches!(sim.observe(&mut Snapshot::default()), Err(SimError::NotRunning)));
    sim.close().unwrap();

    let missing = StartOptions { config: PathBuf::from("/missing.sumocfg"), ..good.clone() };
    assert!(matches!(sim.start(&missing), Err(SimError::NoConfig(path)) if path == missing.config));
    let mut wrong_option = good.clone();
    wrong_option.args.push("--no-such-option".to_owned());
    let mut prints_only = good.clone();
    prints_only.args.push("--version".to_owned());
    let unknown_edge = scenario.options("net", "unknown", UNKNOWN_EDGE);
    let no_network = scenario.options("absent", "absent", GOOD);
    for options in [&wrong_option, &unknown_edge, &no_network, &prints_only] {
        let result = sim.start(options);
        assert!(matches!(result, Err(SimError::Fatal { .. })), "{options:?}: {result:?}");
        assert!(matches!(sim.step(1), Err(SimError::NotRunning)));
        sim.start(&good).unwrap();
        sim.step(1).unwrap();
    }

    let no_signals = scenario.options("plain", "plain", GOOD);
    assert!(matches!(sim.start(&no_signals), Err(SimError::Config { .. })));
    let no_cars = scenario.options("cycles", "cycles", "");
    let result = sim.start(&no_cars);
    assert!(matches!(result, Err(SimError::Config { .. })), "{result:?}");

    sim.start(&scenario.options("net", "gap", GAP)).unwrap();
    let failure = (0..20).find_map(|_| sim.step(1).err());
    assert!(matches!(failure, Some(SimError::Fatal { .. })), "{failure:?}");

    // An own episode is closed by the next start; that of another one is not.
    sim.start(&good).unwrap();
    sim.step(5).unwrap();
    sim.start(&good).unwrap();
    let mut second = SumoSim::new().unwrap();
    assert!(matches!(second.start(&good), Err(SimError::AlreadyRunning)));
    second.close().unwrap();
    sim.step(1).unwrap();
    drop(sim);
    second.start(&good).unwrap();
    second.step(1).unwrap();
}
