//! What goes to the terminal: data to standard output, everything else to standard error.

use std::io::{IsTerminal, Write};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use basics::plain::plain;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::{Map, Value};

/// Time between two plain progress lines.
const PLAIN_INTERVAL: Duration = Duration::from_secs(10);

/// Writes one line to standard output.
pub(super) fn line(text: impl std::fmt::Display) -> std::io::Result<()> {
    write(format!("{}\n", plain(&text.to_string())).as_bytes())
}

/// Writes a line of JSON per row, which says what it is.
pub(super) fn events(event: &str, rows: Vec<Map<String, Value>>) -> std::io::Result<()> {
    rows.into_iter().try_for_each(|mut row| {
        row.insert("event".to_owned(), event.into());
        line(Value::Object(row))
    })
}

/// Writes bytes to standard output. A reader that has gone, as `head` does, has enough: the work and its exit code are the
/// same as with one that stays.
pub(super) fn write(text: &[u8]) -> std::io::Result<()> {
    match std::io::stdout().write_all(text) {
        Err(e) if e.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        Err(e) => {
            Err(std::io::Error::new(e.kind(), format!("cannot write to standard output: {e}")))
        }
        Ok(()) => Ok(()),
    }
}

/// Writes one line to standard error, above a progress bar.
pub(super) fn note(text: impl std::fmt::Display) {
    // Nothing can be done about a closed standard error.
    let _ = writeln!(std::io::stderr(), "{}", plain(&text.to_string()));
}

/// Progress on standard error: a bar on a terminal, a plain line now and then elsewhere.
pub(super) struct Progress {
    bar: ProgressBar,
    what: Option<&'static str>,
    total: u64,
    plain: bool,
    last_line: Mutex<Instant>,
    start: Instant,
}

impl Progress {
    /// Returns a progress of `total` units of `what`; without a name they are shown as a percentage.
    pub(super) fn new(total: u64, what: Option<&'static str>, quiet: bool) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let bar = if quiet || !terminal {
            ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::hidden())
        } else {
            ProgressBar::new(total)
        };
        let count = what.map_or("{percent}%", |_| "{pos}/{len} {prefix}");
        let template = format!("{{bar:30}} {count}, {{elapsed}} gone, {{eta}} left  {{wide_msg}}");
        let style = ProgressStyle::with_template(&template).expect("the template is valid");
        bar.set_style(style.progress_chars("=> "));
        bar.set_prefix(what.unwrap_or_default());
        if terminal && !quiet {
            bar.enable_steady_tick(Duration::from_millis(500));
        }
        let plain = !quiet && !terminal;
        let now = Instant::now();
        Self { bar, what, total, plain, last_line: Mutex::new(now), start: now }
    }

    pub(super) fn set(&self, done: u64, message: &str) {
        self.bar.set_position(done);
        self.say(message);
    }

    /// Counts some units that are done, from any thread.
    pub(super) fn add(&self, count: usize, message: &str) {
        self.bar.inc(count as u64);
        self.say(message);
    }

    fn say(&self, message: &str) {
        self.bar.set_message(plain(message).replace('\n', " "));
        let Ok(mut last_line) = self.last_line.lock() else { return };
        if self.plain && last_line.elapsed() >= PLAIN_INTERVAL {
            *last_line = Instant::now();
            note(self.plain_line(self.bar.position(), message));
        }
    }

    fn plain_line(&self, done: u64, message: &str) -> String {
        let elapsed = self.start.elapsed();
        let left = match done {
            0 => "unknown time".to_owned(),
            _ => duration(elapsed.mul_f64(self.total.saturating_sub(done) as f64 / done as f64)),
        };
        let separator = if message.is_empty() { "" } else { ", " };
        let total = self.total;
        let count = match self.what {
            Some(what) => format!("{done}/{total} {what}"),
            None => format!("{}%", 100 * done / total.max(1)),
        };
        format!("{count}, {left} left{separator}{message}")
    }

    /// Prints a line above the bar.
    pub(super) fn note(&self, text: &str) {
        if self.plain {
            note(text);
        } else {
            self.bar.println(plain(text));
        }
    }

    /// Removes the bar.
    pub(super) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// Returns a duration for people: `42 s`, `3 min 5 s`, `2 h 10 min`.
pub(super) fn duration(duration: Duration) -> String {
    let seconds = duration.as_secs_f64().round() as u64;
    match seconds {
        0..60 => format!("{seconds} s"),
        60..3600 => format!("{} min {} s", seconds / 60, seconds % 60),
        _ => format!("{} h {} min", seconds / 3600, seconds / 60 % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plain_line_counts_units_that_have_a_name_and_percents_of_others() {
        let line = |what| Progress::new(8, what, true).plain_line(2, "x");
        assert!(line(Some("networks")).starts_with("2/8 networks, 0 s left, x"));
        assert!(line(None).starts_with("25%, 0 s left, x"));
        assert_eq!(Progress::new(0, None, true).plain_line(0, ""), "0%, unknown time left");
    }

    #[test]
    fn durations_have_two_units_at_most() {
        let text: Vec<_> =
            [0, 59, 185, 7800].map(|s| duration(Duration::from_secs(s))).into_iter().collect();
        assert_eq!(text, ["0 s", "59 s", "3 min 5 s", "2 h 10 min"]);
    }
}
