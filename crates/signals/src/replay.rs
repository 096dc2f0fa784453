//! An episode of a record once more, to see what its lights did.
//!
//! A method that was trained comes from its model; one that was tuned runs the cycle or the greens that its record has; every other one
//! does as it did. Metrics say whether it is the same episode.

use super::control::fixed_time::SETTING;
use super::control::registry::METHODS;
use super::control::{ControlError, Controller, Drive, Same, SignalSpec, coordinated, existing};
use super::controllers::create;
use super::domain::scenario_of;
use super::environment::{environment, planned_world};
use super::model::SignalModel;
use super::network_files::GENERATED;
use super::program::{ProgramKind, SignalProgram};
use super::settings::Scenario;
use super::sim::Sim;
use super::trial::SignalTrial;
use evaluation::run::RunError;
use evaluation::run::domain::{Site, Trial};
use evaluation::run::fault::TrialError;
use evaluation::run::method::{Training, find};
use evaluation::run::model::SavedModel;
use evaluation::settings::overrides::with_numbers;
use evaluation::store::Layout;
use evaluation::store::record::{Metrics, Summary};

/// Returns what runs the cycle or the greens of every signal that a record has.
fn recorded(programs: Vec<SignalProgram>, scenario: &Scenario) -> Box<dyn Controller> {
    let (within, free) = (coordinated::rings(&scenario.coordinated), scenario.nema.clone());
    let drive = move |signal: &SignalSpec| {
        let program = programs.iter().find(|p| p.signal == signal.id);
        let shown_again = |program: &SignalProgram| match (program.own, program.kind) {
            (true, _) => Some(Drive::OwnProgram),
            (false, ProgramKind::Static) => {
                let phases = program.phases.iter().map(|p| (p.state.clone(), p.duration_s));
                Some(Drive::Recorded(phases.collect(), program.offset_s))
            }
            (false, ProgramKind::DualRing) => Some(match program.stages.clone() {
                Some(stages) => Drive::CoordinatedRings(within.clone(), stages),
                None => Drive::Retimed(free.clone(), program.greens_s.clone()),
            }),
            _ => None,
        };
        program.and_then(shown_again).ok_or_else(|| ControlError::Signal {
            method: "recorded",
            signal: signal.id.clone(),
            reason: "its record has no cycle of it".to_owned(),
        })
    };
    Box::new(Same { name: "recorded", drive })
}

/// Plays an episode of a record again, and returns its metrics and what each signal showed, as a program that shows it once.
///
/// # Arguments
///
/// * `summary` — of the record.
/// * `seed` — of the episode.
pub fn replay<S: Sim>(
    sim: S,
    layout: &Layout,
    site: &Site<'_>,
    summary: &Summary,
    seed: u64,
) -> Result<(Metrics, Vec<SignalProgram>), RunError> {
    let input = |e: String| TrialError::Input(e.into());
    let scenario = scenario_of(site.settings).map_err(input)?;
    let chosen = summary.details.iter();
    let chosen = chosen.filter_map(|(s, v)| Some((s.strip_prefix(SETTING)?, v.parse().ok()?)));
    let scenario = with_numbers(&scenario, chosen);
    let method = summary.method.as_str();
    let own_program = method == super::control::program::METHOD.name;
    let world = planned_world(site.point, site.prepared, own_program, method);
    let (world, held) = world.map_err(TrialError::from)?;
    let imported = site.point.environment != GENERATED;
    let model = layout.model(summary.task);
    let controller = match find(METHODS, method) {
        Err(_) if !imported && site.point.given.contains_key(method) => {
            create(existing::METHOD.name, &scenario, imported, summary.seed)?
        }
        Err(_) => {
            let message = "is a method of your own, which is not started here; name a method of this program or a plan";
            return Err(input(format!("{method} {message}")).into());
        }
        Ok(known) => match known.training {
            Training::Learned => {
                let model = SignalModel::new(SavedModel::read(&model)?, METHODS)?;
                model.controller(known.name, &scenario, |scenario, seed| {
                    create(method, scenario, imported, seed)
                })?
            }
            Training::Tuned { .. } if !known.is_tuned() => {
                let programs = summary.programs.read::<Vec<SignalProgram>>();
                let wrong = |e| input(format!("the programs of its record cannot be read: {e}"));
                recorded(programs.map_err(wrong)?, &scenario)
            }
            _ => create(method, &scenario, imported, summary.seed)?,
        },
    };
    let mut env = environment(sim, world, &scenario, site.scratch);
    env.told = Some(Vec::new());
    let mut trial = SignalTrial::new(vec![env], controller, held);
    let metrics = trial.episode(seed)?;
    trial.verify()?;
    Ok((metrics, trial.envs[0].shown_programs()))
}
