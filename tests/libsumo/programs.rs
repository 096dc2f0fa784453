use std::fs;

use crate::fixture::Scenario;
use tsc_family::traffic::sim::libsumo::SumoSim;
use tsc_family::traffic::sim::{Program, ProgramKind, ProgramPhase, Sim, SimError, Snapshot};

/// Vehicles from N that follow each other closely enough to prolong an actuated green.
const ROUTES: &str = r#"<flow id="f" begin="0" end="500" period="2" departPos="100">
    <route edges="NA AS SX"/></flow>"#;

fn phase(sim: &mut SumoSim, signal: usize) -> u32 {
    let mut snapshot = Snapshot::default();
    sim.observe(&mut snapshot).expect("it runs");
    snapshot.phases[signal]
}

/// Returns how many steps of 1 s signal 0 spends in its present phase, at most 100, and simulates
/// one step more: SUMO switches at the beginning of a step.
fn remaining_s(sim: &mut SumoSim) -> usize {
    let start = phase(sim, 0);
    (0..100)
        .take_while(|_| {
            sim.step(1).expect("it runs");
            phase(sim, 0) == start
        })
        .count()
}

#[test]
fn installed_programs_and_set_phases_take_effect() {
    let _alone = crate::alone();
    let scenario = Scenario::new();
    let mut sim = SumoSim::new().unwrap();
    assert_eq!(SumoSim::version_unloaded().unwrap(), sim.version().unwrap());
    let add = scenario.file("gaps", "add");
    let actuated = |id: &str, parameter: &str| {
        format!(
            "<tlLogic id='S' type='actuated' programID='{id}' offset='0'>{parameter}\
             <phase duration='20' minDur='5' maxDur='40' state='GGrr'/><phase duration='3' state='yyrr'/></tlLogic>"
        )
    };
    let (with, without) = (actuated("g", "<param key='max-gap' value='2.5'/>"), actuated("h", ""));
    fs::write(&add, format!("<additional>{with}{without}</additional>")).unwrap();
    let mut options = scenario.options("net", "programs", ROUTES);
    options.args = vec!["--additional-files".to_owned(), add.display().to_string()];
    let scene = sim.start(&options).unwrap();
    let s = &scene.signals[2];
    let gaps: Vec<_> = s.programs.iter().map(|p| (p.id.as_str(), p.max_gap_s)).collect();
    assert_eq!(gaps, [("0", None), ("g", Some(2.5)), ("h", None)]);
    let a = &scene.signals[0];
    assert_eq!((a.active_program.as_str(), a.programs[0].kind), ("0", ProgramKind::Static));
    assert!(a.programs[0].phases.iter().all(|p| p.state.len() == a.links.len()));
    let (green, red) = ("G".repeat(a.links.len()), "r".repeat(a.links.len()));

    let phases = vec![ProgramPhase::fixed(&green, 7.0), ProgramPhase::fixed(&red, 20.0)];
    let mut program = Program::new("own", ProgramKind::Static, phases);
    sim.step(3).unwrap();
    sim.install(0, &program).unwrap();
    assert_eq!(phase(&mut sim, 0), 0);
    assert_eq!(remaining_s(&mut sim), 7);
    assert_eq!(phase(&mut sim, 0), 1);

    // Setting a phase restarts its timer, also when it is the current one; `None` does not.
    sim.set_phases(&[Some(0), None, None]).unwrap();
    sim.step(5).unwrap();
    sim.set_phases(&[Some(0), None, None]).unwrap();
    assert_eq!(remaining_s(&mut sim), 7);
    sim.set_phases(&[Some(0), None, None]).unwrap();
    sim.step(5).unwrap();
    sim.set_phases(&[None, None, None]).unwrap();
    assert_eq!(remaining_s(&mut sim), 2);

    program.phases[0].duration_s = 11.0;
    sim.step(4).unwrap();
    sim.install(0, &program).unwrap();
    assert_eq!(phase(&mut sim, 0), 0);
    assert_eq!(remaining_s(&mut sim), 11);

    // The queue of the red phase prolongs the actuated green beyond its minimum.
    let limits =
        |state: &str| ProgramPhase { min_s: 5.0, max_s: 60.0, ..ProgramPhase::fixed(state, 5.0) };
    let phases = vec![limits(&green), ProgramPhase::fixed(&red, 5.0)];
    let actuated = Program::new("actuated", ProgramKind::Actuated, phases);
    sim.step(20).unwrap();
    sim.install(0, &actuated).unwrap();
    let green_s = remaining_s(&mut sim);
    assert!((10..=60).contains(&green_s), "green for {green_s} s");

    sim.select(0, "own").unwrap();
    sim.set_phases(&[Some(1), None, None]).unwrap();
    assert_eq!(remaining_s(&mut sim), 20);
    sim.select(0, "0").unwrap();

    // What SUMO refuses is an error, and the simulation goes on.
    let other_kind = Program { id: "own".to_owned(), ..actuated.clone() };
    let short = Program { phases: vec![ProgramPhase::fixed("G", 5.0)], ..program.clone() };
    let unknown = Program { kind: ProgramKind::Other, ..program };
    for program in [other_kind, short, unknown] {
        assert!(matches!(sim.install(0, &program), Err(SimError::Traci { .. })), "{program:?}");
    }
    assert!(matches!(sim.select(0, "missing"), Err(SimError::Traci { .. })));
    assert!(matches!(sim.select(3, "0"), Err(SimError::Traci { .. })));
    assert!(matches!(sim.set_phases(&[Some(99), None, None]), Err(SimError::Traci { .. })));
    assert!(matches!(sim.set_phases(&[Some(0)]), Err(SimError::Traci { .. })));
    sim.step(10).unwrap();
}
