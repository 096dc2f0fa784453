//! Where the numbers of a page come from: what the run was, and the files that define its point MDPs.

use minijinja::{Value, context};

use super::whole::Report;
use crate::store::own::OwnMethod;

/// Returns what the run was, by name.
pub(super) fn provenance(data: &Report) -> Vec<Value> {
    let (i, p) = (&data.manifest.identity, &data.manifest.provenance);
    let seeds: Vec<_> = i.evaluation_seeds.iter().map(u64::to_string).collect();
    let own = i.controllers.iter().map(|own| (format!("controller {}", own.name), told(own)));
    [
        ("command", p.command.clone()),
        ("tsc-family", format!("{} (git {}, {})", i.tsc_family, p.git, p.rustc)),
        ("builds", data.results.builds().several().unwrap_or_default()),
        ("simulator", i.simulator.clone()),
        ("host", p.host.clone()),
        ("started", p.started.clone()),
        ("networks", p.networks.clone()),
        ("base seed", i.base_seed.to_string()),
        ("evaluation seeds", seeds.join(", ")),
        ("sampling", format!("{}, seed {}", data.sampling(), i.sample.seed)),
        ("manifest sha256", data.results.sha256.clone()),
        ("schema version", i.schema_version.to_string()),
    ]
    .into_iter()
    .map(|(name, value)| (name.to_owned(), value))
    .chain(own)
    .filter(|(_, value)| !value.is_empty())
    .map(|(name, value)| context! { name, value })
    .collect()
}

/// Returns what a method of somebody's own is and consists of.
fn told(own: &OwnMethod) -> String {
    let files = own.sha256.iter().map(|(file, sha256)| format!("{file} {sha256}"));
    let versions = own.versions.iter().map(|(what, version)| format!("{what} {version}"));
    let about = [format!("{} ({})", own.source, own.kind.in_words()), own.summary.clone()];
    let parts = about.into_iter().chain(files).chain(versions).filter(|part| !part.is_empty());
    parts.collect::<Vec<_>>().join("; ")
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
