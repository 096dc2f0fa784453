//! `tsc-family doctor`: what was linked, what is there, what is wrong, and the way out.

use std::thread::available_parallelism;

use control_tasks::mujoco::{self, MujocoError};
use serde::Serialize;

use super::output::line;
use crate::cli::exit;
use crate::cli::scenario::ScenarioArg;
use crate::settings::overrides::Override;
use crate::store::manifest::{GIT, RUSTC};
use crate::traffic::calibration::{Quantity, SEEDS};
use crate::traffic::network::netconvert::Netconvert;
use crate::traffic::settings::{Preset, Scenario};

/// What stands for a MuJoCo that is missing.
const MUJOCO_ABSENT: &str = "not found; only half-cheetah and swimmer need it";

/// Scenario whose settings `--calibrate` takes where none is named.
const SCENARIO: &str = "salt-lake-city";

/// Width of a column of numbers in the table of `--calibrate`.
const NUMBER: usize = 10;

/// Numbers from here on are printed without decimals.
const LARGE: f64 = 100.0;

/// `tsc-family doctor`.
#[derive(Debug, clap::Args)]
pub struct DoctorArgs {
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
    /// Measure saturation flow, lost times, use of yellow and permissive left turns with the SUMO that is installed,
    /// beside the Highway Capacity Manual; takes about a minute
    #[arg(long)]
    calibrate: bool,
    /// Limits of timing, and demand, for --calibrate: `resco` or `field` [default: the scenario's, else `resco`]
    #[arg(long, value_name = "PRESET", requires = "calibrate", hide_possible_values = true)]
    preset: Option<Preset>,
    /// Setting for --calibrate, such as `demand.impatience=0.5` (repeatable)
    #[arg(long, value_name = "KEY=VALUE", requires = "calibrate")]
    set: Vec<Override>,
    /// Scenario whose settings --calibrate takes [default: salt-lake-city]
    #[arg(value_name = "SCENARIO", requires = "calibrate")]
    scenario: Option<String>,
}

/// What `--calibrate` measured.
#[derive(Debug, Serialize)]
struct Calibration {
    preset: &'static str,
    seeds: u32,
    quantities: Vec<Quantity>,
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
    #[serde(skip_serializing_if = "Option::is_none")]
    calibration: Option<Calibration>,
}

pub(super) fn run(args: &DoctorArgs) -> anyhow::Result<u8> {
    let mut findings = look();
    if args.calibrate && findings.problems.is_empty() {
        findings.calibration = Some(calibration(args)?);
    }
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
        if let Some(calibration) = &findings.calibration {
            line("")?;
            table(calibration)?;
        }
    }
    Ok(if findings.problems.is_empty() { exit::DONE } else { exit::NO_SUMO })
}

/// Measures with the settings that the arguments name.
fn calibration(args: &DoctorArgs) -> anyhow::Result<Calibration> {
    let name = args.scenario.as_deref().unwrap_or(SCENARIO);
    let arg = ScenarioArg::new(name, args.set.clone(), args.preset);
    let scenario = arg.signals(&arg.settings())?.scenario;
    let quantities = measure(&scenario)?;
    Ok(Calibration { preset: scenario.preset.name(), seeds: SEEDS, quantities })
}

#[cfg(feature = "libsumo")]
fn measure(scenario: &Scenario) -> anyhow::Result<Vec<Quantity>> {
    use anyhow::Context as _;

    use super::output::note;
    use crate::traffic::calibration::{SIMULATIONS, calibrate};
    use crate::traffic::sim::libsumo::SumoSim;

    let folder = tempfile::tempdir().context("cannot create a folder for the simulations")?;
    let mut sim = SumoSim::new()?;
    note(format!("calibrating: {SIMULATIONS} simulations"));
    Ok(calibrate(&mut sim, scenario, folder.path())?)
}

#[cfg(not(feature = "libsumo"))]
fn measure(_: &Scenario) -> anyhow::Result<Vec<Quantity>> {
    anyhow::bail!("built without the feature `libsumo`; build with default features")
}

/// Prints what was measured.
fn table(calibration: &Calibration) -> anyhow::Result<()> {
    let Calibration { preset, seeds, quantities } = calibration;
    line(format!("preset {preset}, {seeds} seeds; HCM: Highway Capacity Manual, 7th edition"))?;
    let width = |text: fn(&Quantity) -> &str| quantities.iter().map(|q| text(q).len()).max();
    let (name, unit) = (width(|q| &q.quantity).unwrap_or(0), width(|q| q.unit).unwrap_or(0));
    let row = |cells: [&str; 6]| {
        let [quantity, its_unit, measured, range, hcm, difference] = cells;
        let text = format!(
            "{quantity:name$}  {its_unit:unit$}  {measured:>NUMBER$}  {range:>15}  {hcm:>NUMBER$}  {difference:>NUMBER$}"
        );
        line(text.trim_end())
    };
    row(["quantity", "unit", "measured", "seeds", "HCM", "difference"])?;
    for q in quantities {
        let number = |value: f64| match q.hcm < LARGE {
            true => format!("{value:.2}"),
            false => format!("{value:.0}"),
        };
        let range = format!("{} to {}", number(q.lowest), number(q.highest));
        let difference = format!("{:+.0}%", q.difference_percent);
        row([&q.quantity, q.unit, &number(q.measured), &range, &number(q.hcm), &difference])?;
    }
    Ok(())
}

fn look() -> Findings {
    let mut problems = Vec::new();
    let (libsumo, sumo_version) = simulator(&mut problems);
    let netconvert = Netconvert::find().map_err(|e| problems.push(e.to_string())).ok();
    let netconvert_version = netconvert.as_ref().map(|n| n.version().to_owned());
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
        netconvert: netconvert.map(|n| n.path().display().to_string()),
        netconvert_version,
        mujoco: mujoco(&mut problems),
        workers: available_parallelism().map_or(1, std::num::NonZero::get),
        problems,
        calibration: None,
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
