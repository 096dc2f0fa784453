//! Where the numbers of a page come from: what the run was, and the files that define its point MDPs.

use minijinja::{Value, context};
use serde_json::{Value as Json, json};

use super::whole::{Report, Runs};
use crate::store::own::OwnMethod;

/// What to cite, as entries of BibTeX. A test compares the first with `CITATION.cff`.
pub const CITATIONS: &str = concat!(
    "@software{tsc-family,\n  title = {tsc-family},\n  author = {{The tsc-family developers}},\n  year = {2026},\n  version = {",
    env!("CARGO_PKG_VERSION"),
    "}\n}\n@inproceedings{jayawardana2022impact,\n  title = {The Impact of Task Underspecification in Evaluating Deep \
     Reinforcement Learning},\n  author = {Jayawardana, Vindula and Tang, Catherine and Li, Sirui and Suo, Dajiang and Wu, \
     Cathy},\n  booktitle = {Advances in Neural Information Processing Systems 35},\n  year = {2022}\n}\n"
);

/// Returns what the run was, by name.
pub(super) fn provenance(data: &Report) -> Vec<Value> {
    let (i, p) = (&data.manifest.identity, &data.manifest.provenance);
    let seeds: Vec<_> = i.evaluation_seeds.iter().map(u64::to_string).collect();
    let own = i.controllers.iter().map(|own| (format!("controller {}", own.name), told(own)));
    [
        ("command", p.command.clone()),
        ("tsc-family", format!("{} (git {}, {})", i.tsc_family, p.git, p.rustc)),
        ("builds", data.results.several_builds().unwrap_or_default()),
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
    .chain(runs(data))
    .chain(own)
    .filter(|(_, value)| !value.is_empty())
    .map(|(name, value)| context! { name, value })
    .collect()
}

fn runs(data: &Report) -> impl Iterator<Item = (String, String)> {
    let sources = data.runs.iter().flat_map(|runs| &runs.sources);
    sources.map(|(name, path, manifest)| {
        (format!("run {name}"), format!("{path}, manifest sha256 {}", manifest.sha256()))
    })
}

/// Returns the settings of the run, or of each run that is compared.
pub(super) fn settings(data: &Report) -> String {
    let of_run = || data.manifest.identity.settings.clone();
    let of_each = |runs: &Runs| {
        runs.sources
            .iter()
            .map(|(name, _, m)| (name.clone(), m.identity.settings.clone()))
            .collect()
    };
    let mut settings = data.runs.as_ref().map_or_else(of_run, of_each);
    shorten(&mut settings);
    serde_json::to_string_pretty(&settings).expect("JSON read from a manifest can be written")
}

/// Writes numbers that were given in single precision as they were given: 0.99, not 0.9900000095367432.
fn shorten(value: &mut Json) {
    match value {
        Json::Object(fields) => fields.values_mut().for_each(shorten),
        Json::Array(values) => values.iter_mut().for_each(shorten),
        Json::Number(number) if number.is_f64() => {
            let full = number.as_f64().unwrap_or_default();
            let single = full as f32;
            let short: Option<f64> = single.to_string().parse().ok();
            if let Some(short) = short.filter(|_| f64::from(single) == full) {
                *value = json!(short);
            }
        }
        _ => {}
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_single_precision_are_written_as_they_were_given() {
        let mut settings = json!({"gamma": 0.99f32, "list": [0.1f32, 0.1f64, 2.5], "episodes": 100, "small": 1e-9});
        shorten(&mut settings);
        let text = settings.to_string();
        assert_eq!(text, r#"{"episodes":100,"gamma":0.99,"list":[0.1,0.1,2.5],"small":1e-9}"#);
    }
}
