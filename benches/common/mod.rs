//! What the benchmarks share: an intersection, the plain `sumo` binary, medians.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use osm_signals::DrivingSide;
use tsc_family::traffic::env::{SignalEnv, World};
use tsc_family::traffic::network::build::{BuildOptions, build_all};
use tsc_family::traffic::network::demand::DemandSpec;
use tsc_family::traffic::network::intersection::IntersectionSpec;
use tsc_family::traffic::settings::{
    DemandSettings, NetworkSettings, SignalSettings, SimulationSettings, SixFeatures,
};
use tsc_family::traffic::sim::libsumo::SumoSim;

/// Returns the median.
pub(crate) fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    (values[(n - 1) / 2] + values[n / 2]) / 2.0
}

/// Builds a four-arm intersection of two lanes per direction and a left-turn lane.
pub(crate) fn network(folder: &Path, inflow_vph: f64) -> PathBuf {
    let point = format!("q{inflow_vph:.0}");
    let features = SixFeatures::from_array([5.0, 35.0, 300.0, inflow_vph, 1.0, 0.0]);
    let spec = IntersectionSpec::from_six_features(&point, &features, 0.0, DrivingSide::Right);
    let out = folder.join("networks");
    build_all(
        &[spec],
        &NetworkSettings::default(),
        &DemandSettings::default(),
        &SignalSettings::default(),
        &out,
        BuildOptions::default(),
        &|_| {},
    )
    .unwrap();
    out.join(&point).join(format!("{point}.sumocfg"))
}

/// Returns the environment of a network that [`network`] built.
pub(crate) fn env(config: &Path, folder: &Path) -> SignalEnv<SumoSim> {
    let demand = DemandSpec::read(&config.with_extension("demand.json")).unwrap();
    let mut world = World::from_sumocfg(config).unwrap();
    world.routes = Some(Box::new(move |seed, path| demand.write_routes(seed, path).map(drop)));
    SignalEnv::new(
        SumoSim::new().unwrap(),
        world,
        SignalSettings::default(),
        SimulationSettings::default(),
        folder.to_path_buf(),
    )
}

/// Returns the wall-clock time of the plain binary with the same outputs, in `folder/plain.xml`.
pub(crate) fn sumo(
    config: &Path,
    args: &[&str],
    seed: u64,
    (begin, end): (u32, u32),
    folder: &Path,
) -> Duration {
    let binary = std::env::var_os("SUMO_HOME")
        .map(|home| PathBuf::from(home).join("bin/sumo"))
        .filter(|path| path.exists())
        .unwrap_or_else(|| "sumo".into());
    let start = Instant::now();
    let status = Command::new(binary)
        .arg("-c")
        .arg(config)
        .args(args)
        .args(["--seed", &seed.to_string()])
        .args(["--begin", &begin.to_string(), "--end", &end.to_string()])
        .args(["--step-length", "1", "--time-to-teleport", "-1", "--xml-validation", "never"])
        .args(["--no-step-log", "true", "--no-warnings", "true", "--duration-log.disable", "true"])
        .arg("--tripinfo-output")
        .arg(folder.join("plain.xml"))
        .args(["--tripinfo-output.write-unfinished", "--tripinfo-output.write-undeparted"])
        .stdout(Stdio::null())
        .status()
        .unwrap();
    assert!(status.success());
    start.elapsed()
}
