//! Where the numbers of a page come from: what the run was, and the files that define its point MDPs.

use minijinja::{Value, context};

use super::whole::Report;

/// Returns what the run was, by name.
pub(super) fn provenance(data: &Report) -> Vec<Value> {
    let (i, p) = (&data.manifest.identity, &data.manifest.provenance);
    let seeds: Vec<_> = i.evaluation_seeds.iter().map(u64::to_string).collect();
    [
        ("command", p.command.clone()),
        ("tsc-family", format!("{} (git {}, {})", i.tsc_family, p.git, p.rustc)),
        ("simulator", i.simulator.clone()),
        ("host", p.host.clone()),
        ("started", p.started.clone()),
        ("networks", p.networks.clone()),
        ("base seed", i.base_seed.to_string()),
        ("evaluation seeds", seeds.join(", ")),
        ("sampling", format!("{}, seed {}", data.sampling(), i.sample.seed)),
        ("manifest sha256", data.origin.sha256.clone()),
        ("schema version", i.schema_version.to_string()),
    ]
    .into_iter()
    .filter(|(_, value)| !value.is_empty())
    .map(|(name, value)| context! { name, value })
    .collect()
}

/// Returns the files that define the point MDPs, with their sha256.
pub(super) fn hashes(data: &Report) -> Vec<Value> {
    let points = data.manifest.identity.points.iter();
    let files = points.flat_map(|p| p.sha256.iter().map(move |(file, sha)| (p, file, sha)));
    files
        .map(|(p, file, sha256)| {
            context! { point => p.point.as_str(), file => file.as_str(), sha256 => sha256.as_str() }
        })
        .collect()
}
