//! `tsc-family doctor`: what was linked, what is there, what is wrong, and the way out.

use std::thread::available_parallelism;

use control_tasks::mujoco::{self, MujocoError};
use serde_json::json;

use super::output::line;
use crate::cli::exit;
use crate::store::manifest::{GIT, RUSTC};
use crate::traffic::network::netconvert::Netconvert;

/// What stands for a MuJoCo that is missing.
const MUJOCO_ABSENT: &str = "not found; only half-cheetah and swimmer need it";

pub(super) fn run(json: bool) -> anyhow::Result<u8> {
    let mut problems = Vec::new();
    let (libsumo, sumo) = simulator(&mut problems);
    let netconvert = Netconvert::find().map_err(|e| problems.push(e.to_string())).ok();
    let version = netconvert.as_ref().map(|n| n.version.clone());
    if let (Some(sumo), Some(netconvert)) = (&sumo, &version)
        && number(sumo) != number(netconvert)
    {
        problems.push(format!(
            "libsumo is {sumo} but netconvert is {netconvert}; set SUMO_HOME so that both come \
             from one installation, and rebuild"
        ));
    }
    let built = format!("{} ({})", env!("CARGO_PKG_VERSION"), GIT);
    let netconvert = netconvert.map(|n| n.path.display().to_string());
    let (mujoco, workers) = (mujoco(&mut problems), available_parallelism().map_or(1, |n| n.get()));
    let code = if problems.is_empty() { exit::DONE } else { exit::NO_SUMO };
    if json {
        line(json!({
            "tsc_family": built,
            "built_with": RUSTC,
            "libsumo": libsumo,
            "sumo_version": sumo,
            "netconvert": netconvert,
            "netconvert_version": version,
            "mujoco": mujoco,
            "workers": workers,
            "problems": problems,
        }))?;
        return Ok(code);
    }
    let found = |found: Option<String>| found.unwrap_or_else(|| "not found".to_owned());
    let rows = [
        ("tsc-family", built),
        ("built with", RUSTC.to_owned()),
        ("libsumo", libsumo),
        ("SUMO", found(sumo)),
        ("netconvert", found(netconvert)),
        ("", version.unwrap_or_default()),
        ("MuJoCo", mujoco.unwrap_or_else(|| MUJOCO_ABSENT.to_owned())),
        ("workers", format!("{workers}, one per processor")),
    ];
    for (name, value) in rows.iter().filter(|(_, value)| !value.is_empty()) {
        line(format!("{name:12}{value}"))?;
    }
    problems.iter().try_for_each(|problem| line(format!("problem     {problem}")))?;
    if problems.is_empty() {
        line("all is well")?;
    }
    Ok(code)
}

/// Returns version and path of MuJoCo. That it is missing is no problem, as few tasks need it; that it cannot be used is one.
fn mujoco(problems: &mut Vec<String>) -> Option<String> {
    match mujoco::version() {
        Ok((version, path)) => Some(format!("{version} ({})", path.display())),
        Err(MujocoError::Missing(_)) => None,
        Err(e) => {
            problems.push(e.to_string());
            None
        }
    }
}

/// Returns the digits and dots of a version text such as `SUMO 1.15.0`.
fn number(text: &str) -> String {
    let start = text.find(|c: char| c.is_ascii_digit()).unwrap_or(text.len());
    text[start..].chars().take_while(|c| c.is_ascii_digit() || *c == '.').collect()
}

fn simulator(problems: &mut Vec<String>) -> (String, Option<String>) {
    use crate::traffic::sim::libsumo::{INCLUDE_DIR, KIND, LIBRARY, SumoSim, library};

    let linked = match library() {
        Ok(found) if found.as_os_str() == LIBRARY => {
            format!("{LIBRARY} ({KIND}, headers {INCLUDE_DIR})")
        }
        Ok(found) => format!("{} ({KIND})", found.display()),
        Err(_) => "not found".to_owned(),
    };
    let version = SumoSim::new().and_then(|sim| sim.version());
    (linked, version.map_err(|e| problems.push(e.to_string())).ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_compared_by_their_numbers() {
        assert_eq!(number("SUMO 1.15.0"), number("Eclipse SUMO netconvert Version 1.15.0"));
    }
}
