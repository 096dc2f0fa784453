//! `tsc-family doctor`: what was linked, what is there, what is wrong, and the way out.

use std::thread::available_parallelism;

use control_tasks::mujoco::{self, MujocoError};
use serde::Serialize;

use super::output::line;
use crate::cli::exit;
use crate::store::manifest::{GIT, RUSTC};
use crate::traffic::network::netconvert::Netconvert;

/// What stands for a MuJoCo that is missing.
const MUJOCO_ABSENT: &str = "not found; only half-cheetah and swimmer need it";

/// `tsc-family doctor`.
#[derive(Debug, clap::Args)]
pub struct DoctorArgs {
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// What doctor found.
#[derive(Debug, Serialize)]
struct Findings {
    tsc_family: String,
    built_with: String,
    libsumo: String,
    sumo_version: Option<String>,
    netconvert: Option<String>,
    netconvert_version: Option<String>,
    mujoco: Option<String>,
    workers: usize,
    problems: Vec<String>,
}

pub(super) fn run(args: &DoctorArgs) -> anyhow::Result<u8> {
    let findings = look();
    if args.json {
        line(serde_json::to_string(&findings)?)?;
    } else {
        let absent = || "not found".to_owned();
        let rows = [
            ("tsc-family", findings.tsc_family.clone()),
            ("built with", findings.built_with.clone()),
            ("libsumo", findings.libsumo.clone()),
            ("SUMO", findings.sumo_version.clone().unwrap_or_else(absent)),
            ("netconvert", findings.netconvert.clone().unwrap_or_else(absent)),
            ("", findings.netconvert_version.clone().unwrap_or_default()),
            ("MuJoCo", findings.mujoco.clone().unwrap_or_else(|| MUJOCO_ABSENT.to_owned())),
            ("workers", format!("{}, one per processor", findings.workers)),
        ];
        for (name, value) in rows.iter().filter(|(_, value)| !value.is_empty()) {
            line(format!("{name:12}{value}"))?;
        }
        for problem in &findings.problems {
            line(format!("problem     {problem}"))?;
        }
        if findings.problems.is_empty() {
            line("all is well")?;
        }
    }
    Ok(if findings.problems.is_empty() { exit::DONE } else { exit::NO_SUMO })
}

fn look() -> Findings {
    let mut problems = Vec::new();
    let (libsumo, sumo_version) = simulator(&mut problems);
    let netconvert = Netconvert::find().map_err(|e| problems.push(e.to_string())).ok();
    let netconvert_version = netconvert.as_ref().map(|n| n.version.clone());
    if let (Some(sumo), Some(netconvert)) = (&sumo_version, &netconvert_version)
        && number(sumo) != number(netconvert)
    {
        problems.push(format!(
            "libsumo is {sumo} but netconvert is {netconvert}; set SUMO_HOME so that both come \
             from one installation, and rebuild"
        ));
    }
    Findings {
        tsc_family: format!("{} ({})", env!("CARGO_PKG_VERSION"), GIT),
        built_with: RUSTC.to_owned(),
        libsumo,
        sumo_version,
        netconvert: netconvert.map(|n| n.path.display().to_string()),
        netconvert_version,
        mujoco: mujoco(&mut problems),
        workers: available_parallelism().map_or(1, std::num::NonZero::get),
        problems,
    }
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

#[cfg(feature = "libsumo")]
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

#[cfg(not(feature = "libsumo"))]
fn simulator(problems: &mut Vec<String>) -> (String, Option<String>) {
    problems.push(
        "built without the feature `libsumo`, so nothing can be simulated; build with default \
         features"
            .to_owned(),
    );
    ("none".to_owned(), None)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_compared_by_their_numbers() {
        assert_eq!(number("SUMO 1.15.0"), number("Eclipse SUMO netconvert Version 1.15.0"));
    }
}
