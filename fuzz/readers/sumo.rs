//! Readers of what SUMO reads and writes, .

use std::io::Cursor;
use std::path::Path;

use tsc_family::traffic::network::demand::DemandSpec;
use tsc_family::traffic::sim::net_file::NetFile;
use tsc_family::traffic::sim::scan::{Scanned, scan};
use tsc_family::traffic::sim::sumocfg::SumoConfig;
use tsc_family::traffic::sim::tripinfo;

/// Most vehicles that are drawn here.
const FEW_VEHICLES: f64 = 1000.0;

/// A SUMO configuration.
pub(crate) fn sumocfg(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let Ok(config) = SumoConfig::parse(text, Path::new("city/a.sumocfg")) else { return };
    let is_blocked = !config.obstacles.is_empty();
    assert!(
        is_blocked || config.networks().count() > 0,
        "a configuration without a network is an error"
    );
    assert!(config.begin_s.is_finite() && config.end_s.is_none_or(f64::is_finite));
    for (option, value) in &config.options {
        // What SUMO is never to be given.
        for word in ["output", "remote", "save", "state", "script", "log"] {
            assert!(!option.starts_with(word) && !option.ends_with("-output"), "{option}={value}");
        }
        assert!(!value.contains("${"), "{option}={value}");
    }
}

/// A file that a scenario names: which others it names, what a copy has otherwise, or what is in its way.
pub(crate) fn sources(bytes: &[u8]) {
    let found = scanned(bytes);
    let size = bytes.len() as u64;
    for at in found.edits.iter().map(|edit| &edit.at).chain(&found.day_plan) {
        assert!(at.start <= at.end && at.end <= size, "{at:?} of {size}");
    }
    for edit in &found.edits {
        // A value stands between quotes, so that nothing else is written over.
        let [before, after] = [edit.at.start - 1, edit.at.end].map(|at| bytes[at as usize]);
        let is_value = before == after && matches!(after, b'"' | b'\'');
        assert!(is_value || edit.with.trim().is_empty(), "{edit:?}");
    }
}

fn named(bytes: &[u8]) -> Option<Vec<String>> {
    let found = scanned(bytes);
    found.obstacles.is_empty().then(|| found.named.into_iter().map(|named| named.0).collect())
}

fn scanned(bytes: &[u8]) -> Scanned {
    let owned = bytes.to_vec();
    let found = scan(Path::new("fuzz.xml"), Box::new(Cursor::new(owned)));
    let names = || found.named.iter().map(|named| &named.0);
    assert!(names().all(|name| !name.is_empty() && name.is_ascii()), "{found:?}");
    found
}

/// A network that netconvert wrote.
pub(crate) fn net(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if let Ok(net) = NetFile::parse(text) {
        for (a, b) in net.links.iter().zip(net.links.iter().skip(1)) {
            assert_eq!(net.meet(a, b), net.meet(b, a));
        }
    }
}

/// What SUMO says of the vehicles of an episode.
pub(crate) fn tripinfo(bytes: &[u8]) {
    if let Ok(totals) = tripinfo::parse(bytes, Path::new("tripinfo.xml"), &mut |_| ()) {
        assert_eq!(totals.vehicles, totals.arrived + totals.running + totals.undeparted);
    }
}

/// The demand of a network: it reads back, and what is written for SUMO names no file.
pub(crate) fn demand(bytes: &[u8]) {
    let path = Path::new("fuzz.demand.json");
    let Ok(demand) = DemandSpec::parse(bytes, path) else { return };
    assert_eq!(
        DemandSpec::parse(demand.to_json().as_bytes(), path).expect("it was written"),
        demand
    );
    let inflow_vph: f64 = demand.streams.iter().map(|stream| stream.inflow_vph).sum();
    if inflow_vph * demand.horizon_s / 3600.0 <= FEW_VEHICLES {
        let vehicles = demand.vehicles(1);
        assert!(vehicles.iter().all(|v| f64::from(v.depart_s) <= demand.horizon_s), "{demand:?}");
        let names = named(demand.routes_xml(&vehicles).as_bytes());
        assert_eq!(names, Some(Vec::new()), "what SUMO reads names a file: {demand:?}");
    }
}
