//! The end of a worker's log, which a failure quotes.

use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use basics::files;

/// Lines of a worker's log that a failure quotes.
const QUOTED_LINES: usize = 6;

/// Bytes at the end of a log in which they are looked for; a simulator may have filled it.
const LOOKED_AT: u64 = 1 << 16;

/// Returns the last lines of a worker's log.
pub(super) fn quoted(log: &Path) -> String {
    last_lines(&end(log), QUOTED_LINES)
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
    lines[lines.len().saturating_sub(count)..].join(" | ")
}

#[cfg(test)]
mod tests {
    use super::*;

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
