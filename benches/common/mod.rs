//! What the benchmarks share: an intersection, medians.

use std::path::{Path, PathBuf};

use osm_signals::DrivingSide;
use tsc_family::traffic::env::{SignalEnv, World};
use tsc_family::traffic::network::build::{BuildOptions, build_all};
use tsc_family::traffic::network::demand::DemandSpec;
use tsc_family::traffic::network::intersection::IntersectionSpec;
use tsc_family::traffic::settings::{SignalSettings, SimulationSettings, SixFeatures, defaults};
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
    build_all(&[spec], &defaults(), &out, BuildOptions::default(), &|_| {}).unwrap();
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
