//! The leaderboard as a page in Markdown, and as lines of JSON.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use super::format;
use crate::analysis::leaderboard::{Row, Table, Trained};
use crate::sample::Sampling;
use crate::stats::Direction;

/// What stands above the tables.
const ABOVE: &str = "\
# Leaderboard

This page ranks all published methods on each family. `tsc-family compare --leaderboard` made it from the records; do not edit it.

- **Place**: the first and the last place that the 95% intervals allow; a method that lacks results has none. `tsc-family compare` decides
  more pairs, because it compares two methods on the same vehicles.
- **One table** has runs with the same records of the baseline. Compare methods within one table only.
- **Point MDPs**: those of the sample. A run with *looks*, which could have stopped early, has wider intervals.
- **Training**: trainings per point MDP, and episodes or steps of each. *Chosen*: validation chose the policies that count; *last*: they are
  those after the last episode.
- **Run**: the day on which it began, and the version of the program.
";

/// Returns the page.
///
/// # Arguments
///
/// * `link` — returns the path of a results directory as seen from the page.
pub fn markdown(tables: &[Table], link: &dyn Fn(&str) -> String) -> String {
    let mut page = ABOVE.to_owned();
    for table in tables {
        page.push_str(&format!("\n## {}\n\n{}\n\n", title(table), about(table)));
        page.push_str(
            "| place | method | score (95% interval) | point MDPs | training | run |\n\
             | --- | --- | ---: | --- | --- | --- |\n",
        );
        for row in &table.rows {
            page.push_str(&line(row, link));
        }
    }
    page
}

/// Returns what a table is called.
fn title(table: &Table) -> String {
    let mut title = table.scenario.clone();
    if let Some(preset) = &table.preset {
        title.push_str(&format!(", preset {preset}"));
    }
    title.push_str(&format!(", {}", format::count(table.family_size, "point MDP")));
    if let Some(version) = &table.version {
        let baseline = table.rows.iter().find(|row| row.method == table.baseline);
        title.push_str(&match baseline {
            Some(row) => format!(", {}, baseline of version {version}", row.simulator),
            None => format!(", version {version}"),
        });
    }
    if !table.settings.is_empty() {
        title.push_str(&format!(": {}", quoted(&table.settings)));
    }
    title
}

fn quoted(settings: &[String]) -> String {
    let settings: Vec<String> = settings.iter().map(|setting| format!("`{setting}`")).collect();
    settings.join(", ")
}

fn about(table: &Table) -> String {
    let better = match table.direction {
        Direction::Lower => "less is better",
        Direction::Higher => "more is better",
    };
    let seeds: BTreeSet<_> = table.rows.iter().map(|row| row.seeds.to_string()).collect();
    let simulators: BTreeSet<_> = table.rows.iter().map(|row| row.simulator.clone()).collect();
    let listed = |names: BTreeSet<String>| Vec::from_iter(names).join(" or ");
    let baseline = match table.baseline.as_str() {
        "" => String::new(),
        baseline => format!(" divided by that of `{baseline}`"),
    };
    format!(
        "The score is `{}`{baseline}; {better}. Evaluation seeds: {}. Simulator: {}.",
        table.objective,
        listed(seeds),
        listed(simulators)
    )
}

fn line(row: &Row, link: &dyn Fn(&str) -> String) -> String {
    let place = match row.places {
        None => "-".to_owned(),
        Some((first, last)) if first == last => first.to_string(),
        Some((first, last)) => format!("{first} to {last}"),
    };
    let points = match (row.points, row.sampling) {
        ((all, of), _) if all == of => "all".to_owned(),
        ((some, of), Sampling::All) => format!("{some} of {of}"),
        ((some, of), sampling) => format!("{some} of {of}, {}", sampling.name()),
    };
    let looks = match (row.has_looks, row.has_grown) {
        (true, _) => ", looks",
        (false, true) => ", grown after results were seen",
        (false, false) => "",
    };
    let left_out = match row.left_out {
        0 => String::new(),
        count => format!(", without {}", format::count(count, "replicate")),
    };
    let trained = match row.trained {
        None => "-".to_owned(),
        Some(Trained { trainings, episodes, steps, .. }) => {
            let length = match steps {
                Some(steps) => format!("{} steps", format::thousands(steps as f64)),
                None => format!("{episodes} episodes"),
            };
            format!("{trainings} of {length}, {}", policies(row).unwrap_or_default())
        }
    };
    let method = match row.settings.is_empty() {
        true => row.method.clone(),
        false => format!("{} with {}", row.method, quoted(&row.settings)),
    };
    let score = format::score_within(row.score, row.interval);
    let interval = row.interval.filter(|(low, high)| low < high);
    let interval = interval.map(|ends| format!(" ({})", format::interval(ends)));
    format!(
        "| {place} | {method} | {score}{} | {points}{looks}{left_out} | {trained} | [{}, {}]({}) |\n",
        interval.unwrap_or_default(),
        row.date,
        row.version,
        link(&row.path),
    )
}

/// Returns which policies of its trainings count; `None` for a method that does not learn.
fn policies(row: &Row) -> Option<&'static str> {
    row.trained.map(|trained| if trained.is_chosen { "chosen" } else { "last" })
}

/// Returns the lines of `--json`: one per row.
pub fn json(tables: &[Table]) -> Vec<Value> {
    let line = |table: &Table, row: &Row| {
        json!({
            "event": "row",
            "scenario": table.scenario,
            "preset": table.preset,
            "family_size": table.family_size,
            "settings": table.settings,
            "method": row.method,
            "run_settings": row.settings,
            "path": row.path,
            "first_place": row.places.map(|(first, _)| first),
            "last_place": row.places.map(|(_, last)| last),
            "score": row.score,
            "interval": row.interval,
            "points": row.points.0,
            "replicates_left_out": row.left_out,
            "sampling": row.sampling,
            "looks": row.has_looks,
            "grown": row.has_grown,
            "evaluation_seeds": row.seeds,
            "trainings": row.trained.map(|trained| trained.trainings),
            "episodes": row.trained.filter(|t| t.steps.is_none()).map(|trained| trained.episodes),
            "steps": row.trained.and_then(|trained| trained.steps),
            "policies": policies(row),
            "simulator": row.simulator,
            "tsc_family": row.version,
            "date": row.date,
        })
    };
    tables.iter().flat_map(|table| table.rows.iter().map(move |row| line(table, row))).collect()
}
