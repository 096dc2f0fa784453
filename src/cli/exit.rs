//! Documented exit codes.

use std::error::Error;
use std::io::ErrorKind;

use control_tasks::mujoco::MujocoError;
use osm_signals::OsmError;

use crate::analysis::AnalysisError;
use crate::family::error::FamilyError;
use crate::files::FileError;
use crate::report::ReportError;
use crate::run::error::RunError;
use crate::run::fault::TrialError;
pub use crate::run::stop::STOPPED;
use crate::sample::SampleError;
use crate::store::error::StoreError;
use crate::store::input_files::Changed;
use crate::study::StudyError;
use crate::traffic::city::CityError;
use crate::traffic::error::TrafficError;
use crate::traffic::network::error::NetworkError;
use crate::traffic::sim::error::SimError;

/// Everything went well.
pub const DONE: u8 = 0;
/// Something unexpected failed.
pub const UNEXPECTED: u8 = 1;
/// Wrong usage or unusable input.
pub const USAGE: u8 = 2;
/// The run is complete, but some tasks failed.
pub const SOME_FAILED: u8 = 3;
/// SUMO or MuJoCo is missing or unsupported.
pub const NO_SUMO: u8 = 4;
/// The results directory holds another run, or is in use by one; or a controller of the user's is another than planned.
pub const MISMATCH: u8 = 5;
/// The run is over, but some tasks have no record, for reasons of the machine; run the same command again.
pub const INCOMPLETE: u8 = 6;
/// Interrupted; run the same command again to continue.
pub const INTERRUPTED: u8 = 130;

/// A request that makes no sense, with the reason and the way out.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(super) struct Refused(pub(super) String);

/// Refuses a request that makes no sense.
pub(super) fn refuse<T>(reason: impl Into<String>) -> anyhow::Result<T> {
    Err(Refused(reason.into()).into())
}

/// Refuses the first option that was given and has no effect, with the reason.
pub(super) fn without_effect(options: &[(&str, bool, &str)]) -> anyhow::Result<()> {
    match options.iter().find(|(_, is_given, _)| *is_given) {
        None => Ok(()),
        Some((flag, _, reason)) => refuse(format!("{flag} has no effect: {reason}; leave it out")),
    }
}

/// Returns the exit code of an error, by the first known error in its chain.
pub fn code(error: &(dyn Error + 'static)) -> u8 {
    let mut next = Some(error);
    while let Some(error) = next {
        if let Some(code) = known(error) {
            return code;
        }
        next = error.source();
    }
    UNEXPECTED
}

/// Returns the codes of an error's types, by the first pattern that fits.
macro_rules! codes {
    ($error:ident: $($type:ty { $($pattern:pat => $code:expr,)* })*) => {
        $(if let Some(error) = $error.downcast_ref::<$type>() {
            return Some(match error { $($pattern => $code,)* });
        })*
    };
}

fn known(error: &(dyn Error + 'static)) -> Option<u8> {
    codes! { error:
        FileError { e => file(e), }
        Refused { _ => USAGE, }
        SampleError { _ => USAGE, }
        AnalysisError { _ => USAGE, }
        StudyError { _ => USAGE, }
        MujocoError { _ => NO_SUMO, }
        StoreError {
            StoreError::Mismatch { .. }
            | StoreError::Version { .. }
            | StoreError::Locked { .. }
            | StoreError::Adding(_)
            | StoreError::Submitted(_) => MISMATCH,
            StoreError::Io(e) => file(e),
            _ => USAGE,
        }
        ReportError { ReportError::Io(e) => file(e), _ => UNEXPECTED, }
        RunError {
            RunError::Family(e) => code(e),
            RunError::Store(e) => code(e),
            RunError::Trial(e) => code(e),
            RunError::Prepare(e) => code(e.as_ref()),
            RunError::Io(e) => file(e),
            RunError::Controller { given: true, .. } => MISMATCH,
            RunError::Stopped { no_simulator: true, .. } => NO_SUMO,
            RunError::Stopped { .. } | RunError::Unprepared(_) | RunError::Batch(_) => UNEXPECTED,
            _ => USAGE,
        }
        TrialError {
            TrialError::Simulator(_) => NO_SUMO,
            TrialError::Input(_) | TrialError::Model(_) | TrialError::Diverged(_) => USAGE,
            TrialError::Machine(e) => code(e.as_ref()),
            TrialError::Stopped => STOPPED,
            TrialError::Failed(_) | TrialError::Own(_) | TrialError::Disturbed(_) => UNEXPECTED,
        }
        TrafficError {
            TrafficError::Family(e) => code(e),
            TrafficError::Network(e) => code(e),
            TrafficError::Sim(e) => code(e),
            TrafficError::Run(e) => code(e),
            TrafficError::Io(e) => file(e),
            TrafficError::Changed(e) => code(e),
            _ => USAGE,
        }
        Changed { Changed::Disturbed(_) => UNEXPECTED, Changed::Io(e) => file(e), _ => USAGE, }
        FamilyError { FamilyError::Io(e) => file(e), _ => USAGE, }
        NetworkError {
            NetworkError::NoNetconvert { .. } => NO_SUMO,
            NetworkError::Io(e) => file(e),
            NetworkError::Intersection { .. } | NetworkError::Altered { .. } => USAGE,
            _ => UNEXPECTED,
        }
        CityError {
            CityError::Family(e) => code(e),
            CityError::Network(e) => code(e),
            CityError::Io(e) => file(e),
            CityError::Input(OsmError::Unreadable { reason, .. }) => match reason.kind() {
                ErrorKind::FileTooLarge => USAGE,
                _ => system(reason),
            },
            _ => USAGE,
        }
        SimError {
            SimError::Unavailable(_) | SimError::Absent(_) => NO_SUMO,
            SimError::Io(e) => file(e),
            SimError::Signal { .. }
            | SimError::NoVehicles(_)
            | SimError::Config { .. }
            | SimError::Obstacles(_)
            | SimError::NoConfig(_) => USAGE,
            _ => UNEXPECTED,
        }
    }
    None
}

fn file(error: &FileError) -> u8 {
    match error.reason.kind() {
        // Of one that is written, the machine allows no more.
        ErrorKind::FileTooLarge if error.action == "read" => USAGE,
        _ => system(&error.reason),
    }
}

/// A file that is not there or may not be used is the user's to mend; a full disk is not usage.
fn system(reason: &std::io::Error) -> u8 {
    match reason.kind() {
        ErrorKind::NotFound
        | ErrorKind::PermissionDenied
        | ErrorKind::AlreadyExists
        | ErrorKind::NotADirectory
        | ErrorKind::IsADirectory
        | ErrorKind::InvalidInput
        | ErrorKind::ReadOnlyFilesystem => USAGE,
        _ => UNEXPECTED,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_code_of_a_wrapped_error_is_its_cause_s() {
        let reason = std::io::Error::from(ErrorKind::NotFound);
        let e = ReportError::Io(FileError::at("read", "a".as_ref())(reason));
        assert_eq!(code(&e), USAGE);
    }

    #[test]
    fn a_simulation_that_fails_in_training_is_no_wrong_usage() {
        let e = TrialError::Failed(SimError::NotRunning.into());
        assert_eq!(code(&RunError::Trial(e)), UNEXPECTED);
    }

    #[test]
    fn a_device_in_place_of_a_file_is_wrong_usage() {
        let reason = std::io::Error::new(ErrorKind::InvalidInput, "it is a pipe or device");
        assert_eq!(code(&FileError::at("read", "a".as_ref())(reason)), USAGE);
    }

    #[test]
    fn a_missing_simulator_has_its_own_code() {
        let e = SimError::Unavailable("libsumocpp.so".into());
        assert_eq!(code(&TrafficError::Sim(SimError::Unavailable(String::new()))), NO_SUMO);
        let e = RunError::Trial(TrialError::Simulator(e.into()));
        assert_eq!(code(&e), NO_SUMO);
    }
}
