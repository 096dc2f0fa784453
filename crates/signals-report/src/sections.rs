//! What reports on traffic signals have beside what they have on any task.

use std::path::Path;

use minijinja::{Value, context};

use super::answers;
use super::corridors;
use super::happened::happened;
use super::intersections::{geojson, spots, table};
use super::level_of_service::{DELAY, LEVELS, letter, range};
use super::levels::{level_shares, levels};
use super::map;
use super::measures::TrafficMeasures;
use super::movements;
use super::periods;
use super::plan_values::plan_values;
use super::plans;
use super::remarks::{overloaded_of, says};
use super::shown::{Seen, Shown};
use basics::files::write_atomically;
use evaluation::analysis::{Analysis, LOSS, Measures, PointResult, RETURN, TaskScore};
use evaluation::report::figures::label;
use evaluation::report::page::render;
use evaluation::report::{
    About, Figure, Look, Metric, Part, ReportError, Sections, Slot, Spot, Table, Words, Written,
    format,
};
use evaluation::stats::Limit;
use evaluation::store::Layout;
use evaluation::store::error::StoreError;
use evaluation::store::manifest::PointRow;
use evaluation::store::results::Results;
use signals::control::registry::METHODS;
use signals::settings::failure;

/// Tables of intersections.
const INTERSECTIONS: &str = "intersections.csv";
const GEOJSON: &str = "results.geojson";

/// What makes the text of a table.
type TableText = fn(Seen<'_>) -> String;

/// What reports on traffic signals have beside what they have on any task.
#[derive(Debug, Clone, PartialEq)]
pub struct TrafficSections {
    shown: Shown,
}

impl TrafficSections {
    /// Reads what a results directory has beside its records.
    ///
    /// # Errors
    ///
    /// [`StoreError`] when its file of places is damaged.
    pub fn read(layout: &Layout, results: &Results) -> Result<Self, StoreError> {
        Ok(Self { shown: Shown::read(layout, results)? })
    }

    fn seen<'a>(&'a self, data: &'a Analysis) -> Seen<'a> {
        Seen { data, shown: &self.shown }
    }

    /// Returns the tables beside that of plans, and what each contains.
    fn further(&self, data: &Analysis) -> Vec<(&'static str, TableText)> {
        let Shown { movements, streets, .. } = &self.shown;
        let placed = self.shown.is_placed();
        let all: [(bool, &str, TableText); 6] = [
            (true, plans::cabinet::TABLE, plans::cabinet::table),
            (periods::are_known(self.seen(data)), periods::TABLE, periods::table),
            (!movements.is_empty(), movements::TABLE, movements::table),
            (!streets.is_empty(), corridors::TABLE, corridors::table),
            (placed, INTERSECTIONS, table),
            (placed, GEOJSON, geojson),
        ];
        let known = all.into_iter().filter(|(is_known, ..)| *is_known);
        known.map(|(_, name, text)| (name, text)).collect()
    }
}

impl Sections for TrafficSections {
    fn today(&self, data: &Analysis) -> Option<&'static str> {
        answers::today(data)
    }

    fn measures(&self) -> &dyn Measures {
        &TrafficMeasures
    }

    fn words(&self, objective: &str) -> Words {
        let words = Words {
            instance: "intersection".to_owned(),
            met: "vehicles".to_owned(),
            nothing: ", as on a road without vehicles; give it demand".to_owned(),
            ..Words::of_metric(objective)
        };
        match objective {
            DELAY => Words {
                nouns: "delays".to_owned(),
                amount: "delay per vehicle".to_owned(),
                unit_in_full: "s per vehicle".to_owned(),
                sizes: ["short", "long", "longest"].map(str::to_owned),
                ..words
            },
            _ => words,
        }
    }

    fn title(&self, point: &PointRow) -> String {
        self.shown.title(point)
    }

    fn failure(&self) -> Option<Limit> {
        Some(failure())
    }

    fn look(&self, method: &str) -> Option<Look> {
        let method = METHODS.iter().find(|m| m.name == method)?;
        Some(Look { color: method.color, dash: method.dash })
    }

    fn happened(&self, data: &Analysis) -> Vec<String> {
        happened(data)
    }

    fn says(&self, about: About, data: &Analysis) -> Option<String> {
        says(about, data)
    }

    fn audience(&self) -> &'static str {
        "Traffic engineers"
    }

    fn legend(&self, data: &Analysis) -> Vec<String> {
        let of = overloaded_of(data).map_or_else(String::new, |o| format!("\n({})", o.in_words()));
        let regimes = format!(
            "to E and at F: mean score where the baseline is at level of service A to E and at F{of}"
        );
        let shares =
            "unfinished: share of the vehicles; gridlock: share of the evaluation episodes";
        let regimes = (!data.regimes.is_empty()).then_some(regimes);
        regimes.into_iter().chain([shares.to_owned()]).collect()
    }

    fn training_columns(&self) -> [[&'static str; 2]; 2] {
        [["resco_best", "resco_last_ten"], ["RESCO best", "RESCO last"]]
    }

    fn metrics(&self, table: Table, _: &Analysis) -> Vec<Metric> {
        let metric = |(name, heading, unit): (&str, &str, &str)| Metric {
            name: name.to_owned(),
            heading: heading.to_owned(),
            unit: unit.to_owned(),
        };
        let waiting = ("waiting_s", "Waiting", "s per vehicle");
        let queue = ("queue_veh", "Queue", "vehicles");
        let unfinished = ("unfinished_veh", "Unfinished", "vehicles");
        let columns = match table {
            Table::Ranking => vec![waiting, queue, unfinished],
            Table::Summary => vec![waiting, queue],
            Table::Scores => vec![
                waiting,
                queue,
                ("throughput_veh", "Throughput", "vehicles"),
                unfinished,
                ("teleports", "Teleports", ""),
            ],
            Table::Episodes => vec![
                waiting,
                unfinished,
                ("undeparted_veh", "Never entered", "vehicles"),
                ("vehicles_veh", "Vehicles", ""),
                (RETURN, "Return", ""),
                (LOSS, "Loss", ""),
            ],
        };
        columns.into_iter().map(metric).collect()
    }

    fn score_columns(&self) -> &'static [&'static str] {
        &["level_of_service"]
    }

    fn score_cells(&self, data: &Analysis, _: &TaskScore, objective: Option<f64>) -> Vec<String> {
        let level = objective.filter(|_| is_delay(data)).map(letter);
        vec![level.map_or_else(String::new, |level| level.to_string())]
    }

    fn summary_columns(&self, data: &Analysis) -> Vec<(&'static str, String)> {
        let at_f = overloaded_of(data);
        let number = |value: Option<f64>| value.map_or_else(String::new, |v| v.to_string());
        vec![
            ("points_at_f", at_f.map_or_else(String::new, |o| o.points.to_string())),
            ("importance_at_f", number(at_f.map(|o| o.importance))),
            ("delay_share_at_f", number(at_f.map(|o| o.delay))),
        ]
    }

    fn spots(&self, data: &Analysis) -> Option<Vec<Spot>> {
        self.shown.is_placed().then(|| spots(self.seen(data)))
    }

    fn stands_for(&self, point: &PointRow) -> String {
        let all = self.shown.stood_for(&point.point);
        match all > point.instances as usize {
            true => format!("for {all} intersections, {} its own", point.instances),
            false => format::count(point.instances as usize, "intersection"),
        }
    }

    fn point_columns(&self, data: &Analysis) -> Vec<&'static str> {
        if is_delay(data) { vec!["Level"] } else { Vec::new() }
    }

    fn point_cells(&self, data: &Analysis, result: &PointResult) -> Vec<String> {
        let level = is_delay(data).then(|| letter(result.objective).to_string());
        level.into_iter().collect()
    }

    fn figures(&self, data: &Analysis) -> Vec<Figure> {
        let figures =
            [levels(data), map::places(self.seen(data)), corridors::diagram(self.seen(data))];
        figures.into_iter().flatten().collect()
    }

    fn parts(&self, data: &Analysis, figures: &[Figure]) -> Result<Vec<Part>, ReportError> {
        let figure = |name: &str| figures.iter().find(|f| f.name == name).map(|f| f.svg.as_str());
        let part = |slot, id, title, template: &str, values: Value| {
            let html = render("part.html", template, values).map_err(ReportError::Template)?;
            Ok::<_, ReportError>(Part { slot, id, title, html })
        };
        let level_heads: Vec<Value> = (LEVELS.iter().enumerate())
            .map(|(l, letter)| context! { letter => letter.to_string(), range => range(l) })
            .collect();
        let mut parts = Vec::new();
        if let Some(levels) = figure("level-of-service") {
            let template = include_str!("templates/service.html");
            let values = context! { levels, level_heads => level_heads.clone(), methods => level_rows(data) };
            parts.push(part(Slot::Body, "service", "Level of service", template, values)?);
        }
        if let (Some(map), Some(best)) = (figure("map"), data.best()) {
            let values = context! {
                map,
                is_delay => is_delay(data),
                best => best.method.as_str(),
                chosen => data.points.len(),
                family_size => data.manifest.identity.sample.family_size,
                sampling => data.sampling(),
                has_pages => !super::pages::links(self.seen(data)).is_empty(),
            };
            let template = include_str!("templates/map.html");
            parts.push(part(Slot::Body, "places", "Map", template, values)?);
        }
        if let Some(values) = periods::values(self.seen(data)) {
            let template = include_str!("templates/periods.html");
            parts.push(part(Slot::Body, "periods", "Periods of the day", template, values)?);
        }
        if let Some(values) = movements::values(self.seen(data)) {
            let template = include_str!("templates/movements.html");
            parts.push(part(Slot::Body, "movements", "Movements", template, values)?);
        }
        if let Some(values) = corridors::values(self.seen(data), figure("time-space")) {
            let (template, title) =
                (include_str!("templates/corridors.html"), "Streets of several signals");
            parts.push(part(Slot::Body, "corridors", title, template, values)?);
        }
        if let Some(plans) = plan_values(self.seen(data)) {
            let values = context! { plans, chosen => data.points.len() };
            let template = include_str!("templates/plans.html");
            parts.push(part(Slot::Body, "plans", "Signal plans", template, values)?);
        }
        if let Some(values) = plans::cabinet::values(self.seen(data)) {
            let template = include_str!("templates/cabinet.html");
            parts.push(part(Slot::Body, "cabinet", "For the cabinet", template, values)?);
        }
        if is_delay(data) {
            let template = include_str!("templates/level_note.html");
            parts.push(part(Slot::Notes, "level-note", "", template, context! { level_heads })?);
        }
        Ok(parts)
    }

    fn tables(&self, data: &Analysis) -> Vec<&'static str> {
        let further = self.further(data).into_iter().map(|(name, _)| name);
        std::iter::once(plans::TABLE).chain(further).collect()
    }

    fn write(&self, folder: &Path, data: &Analysis) -> Result<Written, ReportError> {
        let seen = self.seen(data);
        let plans = plans::write(folder, seen)?;
        let mut written = Written { files: vec![plans.table], notes: Vec::new() };
        written.notes.extend(plans::sheets::write(&folder.join(plans::FOLDER), seen)?.notes);
        super::pages::write(folder, seen)?;
        for (name, text) in self.further(data) {
            let path = folder.join(name);
            write_atomically(&path, text(seen).as_bytes())?;
            written.files.push(path);
        }
        Ok(written)
    }
}

fn is_delay(data: &Analysis) -> bool {
    data.manifest.identity.objective == DELAY
}

/// Returns the methods with the share of the family at each level.
fn level_rows(data: &Analysis) -> Vec<Value> {
    let row = |m| {
        let levels = level_shares(data, m).map(format::percent).to_vec();
        context! { label => label(data, m), levels }
    };
    data.methods.iter().filter(|m| m.points > 0).map(row).collect()
}
