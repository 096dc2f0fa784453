//! How a program that failed shows that the machine is at fault, or somebody else, and not what it was given.

use std::io::{self, Write};
use std::path::Path;

use crate::files::FileError;

/// What programs say when the machine is at fault, in the words of the C library.
const SAID: [&str; 6] = [
    "No space left on device", "Disk quota exceeded", "Input/output error",
    "Read-only file system", "Too many open files", "File too large",
];

/// Signals that a process sends itself by an error of its own: illegal instruction, trap, abort, arithmetic, segments.
const OWN_SIGNALS: [i32; 5] = [4, 5, 6, 8, 11];

/// What to say where a limit on processes and threads refuses one.
pub const LIMIT: &str = "a limit on processes and threads is reached; raise it (ulimit -u, the pids of the container or \
                         of the batch system), or end other programs";

/// What to say where a limit on open files refuses one.
const FILES: &str =
    "a limit on open files is reached; raise it (ulimit -n), then run the same command again";

/// The system's numbers of errors where no file more can be opened: of a process, of the machine.
const NO_FILES: [i32; 2] = [24, 23];

/// Bytes that show whether there is room to write.
const PROBE: usize = 1 << 16;

/// Returns whether a program that failed says that the machine is at fault.
pub fn is_at_fault(said: &str) -> bool {
    SAID.iter().any(|text| said.contains(text))
}

/// Returns why no process or thread can be started, and what to do.
pub fn with_way_out(reason: io::Error) -> io::Error {
    let way_out = if lacks_files(&reason) { FILES } else { LIMIT };
    io::Error::new(reason.kind(), format!("{reason}: {way_out}"))
}

/// Returns whether no file more can be opened.
pub fn lacks_files(reason: &io::Error) -> bool {
    reason.raw_os_error().is_some_and(|code| NO_FILES.contains(&code))
}

/// Returns whether a process that was ended by a signal was ended from outside.
pub fn is_from_outside(signal: i32) -> bool {
    !OWN_SIGNALS.contains(&signal)
}

/// Returns whether whoever started this process had it ignore a signal, as `nohup` does with HUP.
pub fn ignores(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

/// Checks that a folder can be written, because programs that could not write do not always say so.
///
/// # Errors
///
/// [`FileError`] when it cannot.
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

/// Where control groups are, of the second version and of the first, and the names of their limits of memory.
const GROUPS: [(&str, &str); 2] =
    [("/sys/fs/cgroup", "memory.max"), ("/sys/fs/cgroup/memory", "memory.limit_in_bytes")];

/// Returns the memory that each of so many workers may use, MB: an equal share of nine tenths of the machine's, but at
/// least 1000; `None` where the system does not tell.
pub fn memory_per_worker_mb(workers: usize) -> Option<u64> {
    Some(share_mb(memory_mb()?, workers))
}

fn share_mb(memory_mb: u64, workers: usize) -> u64 {
    let all_mb = memory_mb as f64 * WORKERS_SHARE;
    (all_mb / workers.max(1) as f64).max(LEAST_LIMIT_MB).min(all_mb) as u64
}

/// Returns the memory that processes here may use together, MB: the machine's, or less where a container or a batch
/// system sets a limit.
fn memory_mb() -> Option<u64> {
    let machine_kb = kilobytes(&std::fs::read_to_string("/proc/meminfo").ok()?, "MemTotal:")?;
    let groups = std::fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    let limits_kb = groups.lines().flat_map(limits_kb);
    Some(limits_kb.fold(machine_kb, u64::min) / 1000)
}

/// Returns the limits of a control group and of those that it is in, kB.
///
/// # Arguments
///
/// * `line` — of `/proc/self/cgroup`: a number, controllers, a path.
fn limits_kb(line: &str) -> Vec<u64> {
    let mut parts = line.splitn(3, ':').skip(1);
    let (Some(controllers), Some(path)) = (parts.next(), parts.next()) else { return Vec::new() };
    let version = match controllers {
        "" => 0,
        names if names.split(',').any(|name| name == "memory") => 1,
        _ => return Vec::new(),
    };
    let (root, name) = GROUPS[version];
    let limit = |group: &Path| {
        let inside = group.strip_prefix("/").unwrap_or(group);
        let text = std::fs::read_to_string(Path::new(root).join(inside).join(name)).ok()?;
        Some(text.trim().parse::<u64>().ok()? / 1000)
    };
    Path::new(path).ancestors().filter_map(limit).collect()
}

/// Returns the memory that a process and those that it started use now, in and out of swap, MB; `None` where the system does
/// not tell, or the process has ended.
///
/// What is resident is counted, not what is reserved: threads and shared libraries reserve several times what they use. Where
/// it exceeds a limit, pages that several processes share are counted in equal parts.
pub fn memory_used_mb(process: i32, limit_mb: u64) -> Option<u64> {
    let family = family(process);
    let used_mb = |resident: bool| -> Option<u64> {
        let used_kb = family.iter().filter_map(|process| used_kb(*process, resident));
        used_kb.reduce(|a, b| a + b).map(|kb| kb / 1000)
    };
    let resident_mb = used_mb(true)?;
    let exact = Some(resident_mb).filter(|mb| *mb > limit_mb && family.len() > 1);
    exact.and_then(|_| used_mb(false)).or(Some(resident_mb))
}

/// Returns the memory of one process, kB: what is resident, or its part of it; with swap.
fn used_kb(process: i32, resident: bool) -> Option<u64> {
    let (file, names) = match resident {
        true => ("status", ["VmRSS:", "VmSwap:"]),
        false => ("smaps_rollup", ["Pss:", "SwapPss:"]),
    };
    let text = std::fs::read_to_string(format!("/proc/{process}/{file}")).ok()?;
    let [used, swapped] = names.map(|name| kilobytes(&text, name));
    Some(used? + swapped.unwrap_or(0))
}

/// Returns a process and those that it started, as far as the system tells.
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

/// Returns the number of kilobytes in the line of a name, in a file of the system.
fn kilobytes(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim().strip_suffix("kB")?.trim().parse().ok()
}

/// Returns the largest memory that this process and those that it started have used so far, MB; `None` where the system does
/// not tell.
///
/// Each of them counts with its own largest memory, and one that has ended does not count.
pub fn peak_memory_mb() -> Option<u64> {
    Some(peak_kb(std::process::id().try_into().ok()?)?.div_ceil(1000))
}

/// Returns the largest memory of a process and of those that it started, kB.
fn peak_kb(process: i32) -> Option<u64> {
    let of_one = |process: &i32| {
        let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
        kilobytes(&status, "VmHWM:")
    };
    family(process).iter().filter_map(of_one).reduce(|a, b| a + b)
}

#[cfg(test)]
mod tests {
    #[test]
    #[cfg(target_os = "linux")]
    fn the_largest_memory_is_told() {
        let held = std::hint::black_box(vec![1_u8; 50_000_000]);
        let peak = peak_memory_mb().unwrap();
        assert!((50..100_000).contains(&peak), "{peak} with {}", held.len());
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn what_a_process_has_started_counts_in_its_largest_memory() {
        let shell = |line: &str| {
            let mut shell = std::process::Command::new("sh");
            shell.args(["-c", line]).stdin(std::process::Stdio::piped()).spawn().unwrap()
        };
        let (mut alone, mut with) = (shell("read line"), shell("sleep 60 & read line; kill $!"));
        let [id, id_with] = [&alone, &with].map(|shell| i32::try_from(shell.id()).unwrap());
        // The process that the shell starts needs a moment.
        let counted = (0..6_000).any(|_| {
            std::thread::sleep(std::time::Duration::from_millis(5));
            peak_kb(id_with).unwrap() > peak_kb(id).unwrap() + 300
        });
        assert!(counted, "{:?} with {:?}", peak_kb(id_with), peak_kb(id));
        // The end of their input ends them.
        for shell in [&mut alone, &mut with] {
            shell.wait().unwrap();
        }
    }

    use super::*;

    #[test]
    fn workers_share_nine_tenths_and_none_has_less_than_a_simulation_needs() {
        assert_eq!([1, 2, 8].map(|workers| share_mb(16_000, workers)), [14_400, 7_200, 1_800]);
        assert_eq!(share_mb(16_000, 64), 1000);
        assert_eq!(share_mb(500, 4), 450, "a machine that has less");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn the_memory_of_the_machine_and_of_a_process_with_its_children_is_told() {
        let machine_mb = memory_mb().unwrap();
        let held = std::hint::black_box(vec![1_u8; 50_000_000]);
        let own = i32::try_from(std::process::id()).unwrap();
        let used_mb = memory_used_mb(own, u64::MAX).unwrap();
        assert!((50..machine_mb).contains(&used_mb), "{used_mb} with {}", held.len());
        assert!(memory_used_mb(own, 1).unwrap() <= memory_used_mb(own, u64::MAX).unwrap() + 100);
        let sleeps = || std::process::Command::new("sleep").arg("60").spawn().unwrap();
        let mut child = sleeps();
        let id = i32::try_from(child.id()).unwrap();
        assert!(family(own).contains(&id));
        child.kill().unwrap();
        child.wait().unwrap();
        assert_eq!(memory_used_mb(id, u64::MAX), None);
    }

    #[test]
    fn groups_of_other_controllers_and_damaged_lines_have_no_limit() {
        for line in ["4:cpu,cpuacct:/a", "", "0", "7:memory:/there/is/none"] {
            assert!(limits_kb(line).iter().all(|kb| *kb > 1000), "{line}");
        }
        assert_eq!(limits_kb("4:cpu,cpuacct:/a"), [0_u64; 0]);
    }

    #[test]
    fn a_folder_that_can_be_written_passes_and_others_do_not() {
        let folder = tempfile::tempdir().unwrap();
        probe(folder.path()).unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        let e = probe(&folder.path().join("missing")).unwrap_err().to_string();
        assert!(e.starts_with("cannot write ") && e.contains("missing: "), "{e}");
    }

    #[test]
    fn a_limit_on_files_is_told_from_one_on_processes() {
        let said = |code| with_way_out(io::Error::from_raw_os_error(code)).to_string();
        assert!(said(24).ends_with("raise it (ulimit -n), then run the same command again"));
        assert!(said(11).contains("raise it (ulimit -u"), "{}", said(11));
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
