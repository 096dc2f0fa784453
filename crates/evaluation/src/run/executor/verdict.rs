//! Whose fault it is that a worker left no record: what it said itself, or else how it ended.

use std::io::{Read, Seek, SeekFrom};
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::ExitStatus;

use crate::run::progress::{Failure, Fault};
use basics::{files, machine};

/// What is on standard error when there was no memory: of Rust's allocator, of C++'s.
const NO_MEMORY: [&str; 2] = ["memory allocation of ", "std::bad_alloc"];

/// Lines of a worker's log that a failure quotes.
const QUOTED_LINES: usize = 6;

/// What stands in the last words of simulators that end for a known reason in their input, and what to do.
const KNOWN: [(&str, &str); 1] = [(
    "MSE2Collector",
    "a detector over several lanes fails, whatever the method: give signals of type delay_based or NEMA another type or \
     a shorter detector range (option tls.delay_based.detector-range), and leave out or shorten laneAreaDetectors",
)];

/// How errors of a simulator begin in a log.
const ERROR: &str = "Error: ";

/// What stands between two of them.
const BETWEEN: &str = " | ";

/// Bytes at the end of a log in which they are looked for; a simulator may have filled it.
const LOOKED_AT: u64 = 1 << 16;

/// Returns why a worker left no record.
pub(super) fn verdict(status: ExitStatus, said: Option<Failure>, log: &Path) -> Failure {
    let quoted = quoted(log);
    match said {
        Some(said) if !matches!(said.fault, Fault::Input | Fault::Task) => {
            return said;
        }
        // It ended itself, because it hung.
        Some(said) if status.signal().is_some() => return said,
        _ => {}
    }
    let no_memory = NO_MEMORY.iter().any(|text| quoted.contains(text));
    let how = match (status.code(), status.signal()) {
        (Some(code), _) => format!("the worker ended with exit code {code}"),
        (None, Some(signal)) => {
            format!("the worker was killed by signal {signal}{}", meaning(signal))
        }
        (None, None) => "the worker ended".to_owned(),
    };
    let killed = status.signal().is_some_and(machine::is_from_outside);
    let known = KNOWN.iter().find(|(text, _)| said.is_none() && quoted.contains(text));
    let fault = match said {
        None if known.is_some() && !killed => Fault::Input,
        _ if no_memory => Fault::Disturbed,
        _ if machine::is_at_fault(&quoted) => Fault::Machine,
        Some(ref failure) => failure.fault,
        None if killed => Fault::Disturbed,
        None => Fault::Task,
    };
    let own = said.as_ref().map(|said| last_lines(&format!("error: {}", said.reason), usize::MAX));
    let before = own.as_ref().and_then(|own| quoted.strip_suffix(own.as_str()));
    let reason = match (said, before) {
        // There is nothing else to tell, such as what SUMO says of the input.
        (Some(said), Some("")) if fault == Fault::Input => said.reason,
        // What ended it comes first; the lines before may be harmless, or say why.
        (Some(said), Some(before)) if !before.is_empty() => {
            let before = before.trim_end_matches(BETWEEN);
            format!("{how}: error: {}; before that: {before}", said.reason)
        }
        _ if quoted.is_empty() => how,
        _ => format!("{how}: {quoted}"),
    };
    let reason = match known {
        Some((_, way_out)) if fault == Fault::Input => format!("{way_out}; {reason}"),
        _ => reason,
    };
    Failure { fault, reason }
}

/// Returns what people should think of when they read the number of a signal.
fn meaning(signal: i32) -> &'static str {
    match signal {
        9 => " (somebody, or the system for want of memory: fewer --jobs need less)",
        24 => " (a limit of processor time)",
        25 => " (a limit of the size of files)",
        _ => "",
    }
}

/// Returns the last lines of a worker's log.
fn quoted(log: &Path) -> String {
    last_lines(&end(log), QUOTED_LINES)
}

/// Returns the last error that a simulator wrote into a worker's log, without the word itself.
pub(super) fn last_error(log: &Path) -> Option<String> {
    let text = end(log);
    let error = text.lines().rev().find_map(|line| line.trim().strip_prefix(ERROR))?;
    Some(error.trim().to_owned())
}

/// Returns the end of a log; nothing of one that cannot be read.
fn end(log: &Path) -> String {
    let Ok(mut file) = files::open(log) else { return String::new() };
    let size = file.metadata().map_or(0, |about| about.len());
    let mut bytes = Vec::new();
    let read = file
        .seek(SeekFrom::Start(size.saturating_sub(LOOKED_AT)))
        .and_then(|_| file.take(LOOKED_AT).read_to_end(&mut bytes));
    read.map_or(String::new(), |_| String::from_utf8_lossy(&bytes).into_owned())
}

fn last_lines(text: &str, count: usize) -> String {
    let lines: Vec<&str> = text.lines().map(str::trim).filter(|l| !l.is_empty()).collect();
    lines[lines.len().saturating_sub(count)..].join(BETWEEN)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(status: i32, said: Option<Fault>, log: &str) -> (Fault, String) {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), log).unwrap();
        let said = said.map(|fault| Failure { fault, reason: "its words".into() });
        let Failure { fault, reason } = verdict(ExitStatus::from_raw(status), said, file.path());
        (fault, reason)
    }

    #[test]
    fn a_worker_that_was_killed_was_disturbed_and_one_that_crashed_was_not() {
        for signal in [1, 2, 9, 15, 24, 25] {
            assert_eq!(of(signal, None, "").0, Fault::Disturbed, "{signal}");
        }
        for signal in [4, 5, 6, 8, 11] {
            assert_eq!(of(signal, None, "").0, Fault::Task, "{signal}");
        }
        assert_eq!(of(101 << 8, None, "a panic").0, Fault::Task);
        assert!(of(9, None, "").1.contains("signal 9 (somebody, or the system for want of memory"));
    }

    #[test]
    fn want_of_memory_is_no_fault_of_the_task_s() {
        assert_eq!(of(6, None, "memory allocation of 64 bytes failed").0, Fault::Disturbed);
        let said = Some(Fault::Task);
        assert_eq!(
            of(1 << 8, said, "error: sumo failed in `step`: std::bad_alloc").0,
            Fault::Disturbed
        );
    }

    #[test]
    fn a_simulator_that_crashes_on_its_input_is_not_tried_again_and_the_way_out_comes_first() {
        let log = "sumo: MSE2Collector.cpp:844: Assertion `a == b' failed.";
        let (fault, reason) = of(6, None, log);
        assert_eq!(fault, Fault::Input);
        assert!(reason.starts_with("a detector over several lanes fails"), "{reason}");
        assert!(reason.ends_with(log), "{reason}");
        assert_eq!(of(9, None, log).0, Fault::Disturbed, "somebody ended it");
    }

    #[test]
    fn a_worker_that_quotes_a_full_disk_is_stopped_by_the_machine() {
        let log = "Error: Could not build output file 't.xml' (No space left on device).";
        assert_eq!(of(1 << 8, Some(Fault::Task), log).0, Fault::Machine);
    }

    #[test]
    fn what_a_worker_says_counts_and_the_log_is_quoted() {
        let (fault, reason) =
            of(2 << 8, Some(Fault::Input), "\n Error: no such edge \n\nQuitting\n");
        assert_eq!(fault, Fault::Input);
        assert_eq!(reason, "the worker ended with exit code 2: Error: no such edge | Quitting");
        let alone = of(2 << 8, Some(Fault::Input), "error: its words\n");
        assert_eq!(alone, (Fault::Input, "its words".to_owned()), "the log has nothing else");
        let (_, reason) =
            of(1 << 8, Some(Fault::Task), "Warning: slow\nError: a\nerror: its words\n");
        let expected = "the worker ended with exit code 1: error: its words; before that: Warning: slow | Error: a";
        assert_eq!(reason, expected, "what ended it comes first");
        let (_, reason) = of(1 << 8, Some(Fault::Task), "error: its words\n");
        assert_eq!(reason, "the worker ended with exit code 1: error: its words");
        assert_eq!(of(1 << 8, Some(Fault::Machine), "x"), (Fault::Machine, "its words".to_owned()));
        assert_eq!(of(1 << 8, Some(Fault::Own), "x"), (Fault::Own, "its words".to_owned()));
        assert_eq!(of(9, Some(Fault::Task), "x"), (Fault::Task, "its words".to_owned()));
    }

    #[test]
    fn the_end_of_a_log_is_quoted_however_long_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let log = folder.path().join("0.log");
        let noise = "step\n".repeat(100_000);
        std::fs::write(&log, format!("{noise}Error: no edge\n\n quitting \n")).unwrap();
        assert_eq!(quoted(&log), "step | step | step | step | Error: no edge | quitting");
        assert_eq!(quoted(folder.path()), "");
    }
}
