//! How a program that failed shows that the machine is at fault, or somebody else, and not what it was given.

use std::io::{self, Write};
use std::path::Path;

use crate::files::FileError;

/// What programs say when the machine is at fault, in the words of the C library.
const SAID: [&str; 6] = [
    "No space left on device",
    "Disk quota exceeded",
    "Input/output error",
    "Read-only file system",
    "Too many open files",
    "File too large",
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

/// Returns the largest memory that this process has used so far, MB; `None` where the system does not tell.
pub fn peak_memory_mb() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes.div_ceil(1000))
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

    use super::*;

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
