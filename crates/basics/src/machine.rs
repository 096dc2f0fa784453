//! How a program that failed shows that the machine is at fault, or somebody else, and not what it was given.

use std::io::Write;
use std::path::Path;

use crate::files::FileError;

/// What programs say when the machine is at fault, in the words of the C library.
const SAID: [&str; 6] = [
    "No space left on device", "Disk quota exceeded", "Input/output error",
    "Read-only file system", "Too many open files", "File too large",
];

/// Signals that a process sends itself by an error of its own: illegal instruction, trap, abort, arithmetic, segments.
const OWN_SIGNALS: [i32; 5] = [4, 5, 6, 8, 11];

const PROBE: usize = 1 << 16;

/// Returns whether a program that failed says that the machine is at fault.
pub fn is_at_fault(said: &str) -> bool {
    SAID.iter().any(|text| said.contains(text))
}

/// Returns whether a process that was ended by a signal was ended from outside.
pub fn is_from_outside(signal: i32) -> bool {
    !OWN_SIGNALS.contains(&signal)
}

/// Returns whether whoever started this process had it ignore a signal, as `nohup` does with HUP.
pub fn ignores(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    ignored.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

/// Checks that a folder can be written, because programs that could not write do not always say so.
pub fn probe(folder: &Path) -> Result<(), FileError> {
    let mut file = tempfile::tempfile_in(folder).map_err(FileError::at("write", folder))?;
    file.write_all(&[1; PROBE])
        .and_then(|()| file.sync_all())
        .map_err(FileError::at("write", folder))
}

/// Share of the machine's memory that all workers together may use.
const WORKERS_SHARE: f64 = 0.9;

/// Memory below which no worker is limited unless the machine has less, MB: a simulation of one intersection takes some
/// 100, and a class of a user's with its libraries several times as much.
const LEAST_LIMIT_MB: f64 = 1000.0;

/// Returns the memory that each of so many workers may use, MB: an equal share of nine tenths of the machine's, but at
/// least 1000; `None` where the system does not tell.
pub fn memory_per_worker_mb(workers: usize) -> Option<u64> {
    let machine_kb = kilobytes(&std::fs::read_to_string("/proc/meminfo").ok()?, "MemTotal:")?;
    Some(share_mb(machine_kb / 1000, workers))
}

fn share_mb(memory_mb: u64, workers: usize) -> u64 {
    let all_mb = memory_mb as f64 * WORKERS_SHARE;
    (all_mb / workers.max(1) as f64).max(LEAST_LIMIT_MB).min(all_mb) as u64
}

/// Returns the memory that a process and those that it started use now, in and out of swap, MB; `None` where the system does
/// not tell, or the process has ended. Pages that several processes share are counted in equal parts.
pub fn memory_used_mb(process: i32) -> Option<u64> {
    let of_one = |process: &i32| {
        let text = std::fs::read_to_string(format!("/proc/{process}/smaps_rollup")).ok()?;
        Some(kilobytes(&text, "Pss:")? + kilobytes(&text, "SwapPss:").unwrap_or(0))
    };
    Some(family(process).iter().filter_map(of_one).reduce(|a, b| a + b)? / 1000)
}

fn family(process: i32) -> Vec<i32> {
    let mut family = vec![process];
    let mut next = 0;
    while let Some(parent) = family.get(next) {
        let threads = std::fs::read_dir(format!("/proc/{parent}/task"));
        for thread in threads.into_iter().flatten().flatten() {
            let children = std::fs::read_to_string(thread.path().join("children"));
            let children = children.unwrap_or_default();
            family.extend(children.split_whitespace().filter_map(|id| id.parse::<i32>().ok()));
        }
        next += 1;
    }
    family
}

fn kilobytes(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim().strip_suffix("kB")?.trim().parse().ok()
}

/// Returns the largest memory that this process and those that it started have used so far, MB; `None` where it is not told.
/// Each of them counts with its own largest memory, and one that has ended does not count.
pub fn peak_memory_mb() -> Option<u64> {
    let of_one = |process: &i32| {
        let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
        kilobytes(&status, "VmHWM:")
    };
    let family = family(std::process::id().try_into().ok()?);
    Some(family.iter().filter_map(of_one).reduce(|a, b| a + b)?.div_ceil(1000))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn workers_share_nine_tenths_and_none_has_less_than_a_simulation_needs() {
        assert_eq!([1, 2, 8].map(|workers| share_mb(16_000, workers)), [14_400, 7_200, 1_800]);
        assert_eq!(share_mb(16_000, 64), 1000);
        assert_eq!(share_mb(500, 4), 450, "a machine that has less");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn the_memory_of_a_process_with_its_children_is_told() {
        let held = std::hint::black_box(vec![1_u8; 50_000_000]);
        let own = i32::try_from(std::process::id()).unwrap();
        for mb in [memory_used_mb(own), peak_memory_mb()] {
            assert!((50..100_000).contains(&mb.unwrap()), "{mb:?} with {}", held.len());
        }
        let mut child = std::process::Command::new("sleep").arg("60").spawn().unwrap();
        let id = i32::try_from(child.id()).unwrap();
        assert!(family(own).contains(&id));
        child.kill().unwrap();
        child.wait().unwrap();
        assert_eq!(memory_used_mb(id), None);
    }

    #[test]
    fn a_folder_that_can_be_written_passes_and_others_do_not() {
        let folder = tempfile::tempdir().unwrap();
        probe(folder.path()).unwrap();
        assert!(probe(&folder.path().join("missing")).is_err());
    }

    #[test]
    fn the_words_of_the_c_library_are_known() {
        for code in [28, 122, 5, 30, 24, 27] {
            let said = std::io::Error::from_raw_os_error(code).to_string();
            assert!(is_at_fault(&format!("Error: {said}.")), "{said}");
        }
        assert!(!is_at_fault("Error: No such file or directory"));
    }
}
