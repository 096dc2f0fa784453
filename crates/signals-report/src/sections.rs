//! What reports on traffic signals have beside what they have on any task.

use std::path::Path;

use minijinja::{Value, context};

use super::answers;
use super::audit;
use super::corridors;
use super::happened::happened;
use super::intersections::{geojson, spots, table};
use super::level_of_service::{LEVELS, letter, range};
use super::levels::levels;
use super::map;
use super::measures::TrafficMeasures;
use super::movements;
use super::periods;
use super::plans;
use super::remarks::{overloaded_of, says};
use super::savings;
use super::shown::{Seen, Shown};
use basics::files::write_atomically;
use evaluation::analysis::{Analysis, LOSS, Measures, PointResult, RETURN, TaskScore};
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
use signals::trial::{PEDESTRIAN_DELAY, UNSERVED};

const INTERSECTIONS: &str = "intersections.csv";
const GEOJSON: &str = "results.geojson";

/// A section: its template, id and title, and its values where there are any.
macro_rules! section {
    ($template:literal, $id:literal, $title:literal, $values:expr) => {
        ($id, $title, include_str!(concat!("templates/", $template, ".html")), $values)
    };
}

type TableText = fn(Seen<'_>) -> String;

/// What reports on traffic signals have beside what they have on any task.
#[derive(Debug, Clone, PartialEq)]
pub struct TrafficSections {
    shown: Shown,
    measures: TrafficMeasures,
}

impl TrafficSections {
    /// Reads what a results directory has beside its records.
    /// Fails with [`StoreError`] when its file of places is damaged.
    pub fn read(layout: &Layout, results: &Results) -> Result<Self, StoreError> {
        let shown = Shown::read(layout, results)?;
        let measures = TrafficMeasures { several_signals: !shown.streets.is_empty() };
        Ok(Self { shown, measures })
    }

    fn seen<'a>(&'a self, data: &'a Analysis) -> Seen<'a> {
        Seen { data, shown: &self.shown }
    }

    /// Returns the tables beside that of plans, and what each contains.
    fn further(&self, data: &Analysis) -> Vec<(&'static str, TableText)> {
        let Shown { movements, streets, .. } = &self.shown;
        let placed = self.shown.is_placed();
        let all: [(bool, &str, TableText); 8] = [
            (true, plans::cabinet::TABLE, plans::cabinet::table),
            (savings::values(self.seen(data)).is_some(), savings::TABLE, savings::table),
            (audit::shorter(self.seen(data)).1 > 0, audit::TABLE, audit::table),
            (periods::values(self.seen(data)).is_some(), periods::TABLE, periods::table),
            (!movements.is_empty(), movements::TABLE, movements::table),
            (!streets.is_empty(), corridors::TABLE, corridors::table),
            (placed, INTERSECTIONS, |seen| table(seen).csv()),
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
        &self.measures
    }

    fn words(&self, objective: &str) -> Words {
        Words {
            instance: "intersection".to_owned(),
            met: "vehicles".to_owned(),
            nothing: ", as on a road without vehicles; give it demand".to_owned(),
            nouns: "delays".to_owned(),
            amount: "delay per vehicle".to_owned(),
            unit_in_full: "s per vehicle".to_owned(),
            sizes: ["short", "long", "longest"].map(str::to_owned),
            ..Words::of_metric(objective)
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
        happened(data, &self.shown.standing)
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

    fn metrics(&self, table: Table, data: &Analysis) -> Vec<Metric> {
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
        let on_foot =
            [(PEDESTRIAN_DELAY, "On foot", "s per person"), (UNSERVED, "No walk", "crosswalks")];
        let known = |name: &str| data.tasks.iter().any(|task| task.metrics.contains_key(name));
        let on_foot = on_foot.into_iter().filter(|of| table == Table::Scores && known(of.0));
        columns.into_iter().chain(on_foot).map(metric).collect()
    }

    fn score_columns(&self) -> &'static [&'static str] {
        &["level_of_service"]
    }

    fn score_cells(&self, _: &Analysis, _: &TaskScore, objective: Option<f64>) -> Vec<String> {
        let known = objective.filter(|_| !self.measures.several_signals);
        vec![known.map(letter).map(String::from).unwrap_or_default()]
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

    fn point_columns(&self, _: &Analysis) -> Vec<&'static str> {
        if self.measures.several_signals { Vec::new() } else { vec!["Level"] }
    }

    fn point_cells(&self, _: &Analysis, result: &PointResult) -> Vec<String> {
        let level = (!self.measures.several_signals).then(|| letter(result.objective).to_string());
        level.into_iter().collect()
    }

    fn figures(&self, data: &Analysis) -> Vec<Figure> {
        let levels = (!self.measures.several_signals).then(|| levels(data)).flatten();
        let figures = [levels, map::places(self.seen(data)), corridors::diagram(self.seen(data))];
        figures.into_iter().flatten().collect()
    }

    fn parts(&self, data: &Analysis, figures: &[Figure]) -> Result<Vec<Part>, ReportError> {
        let figure = |name: &str| figures.iter().find(|f| f.name == name).map(|f| f.svg.as_str());
        let head = |l: usize| context! { letter => LEVELS[l].to_string(), range => range(l) };
        let level_heads: Vec<Value> = (0..LEVELS.len()).map(head).collect();
        let seen = self.seen(data);
        let service = figure("level-of-service").map(|levels| context! { levels });
        let map = figure("map").zip(data.best()).map(|(map, best)| {
            context! {
                map,
                best => best.method.as_str(),
                chosen => data.points.len(),
                family_size => data.manifest.identity.sample.family_size,
                sampling => data.sampling(),
                has_pages => !super::pages::links(seen).is_empty(),
            }
        });
        let streets = corridors::values(seen, figure("time-space"));
        let programs = self.shown.plans.iter().any(|plan| !plan.programs.is_empty());
        let programs = programs.then(|| context! {});
        let note = (!self.measures.several_signals).then(|| context! { level_heads });
        let all = [
            section!("savings", "signals", "Signals", savings::values(seen)),
            section!("service", "service", "Level of service", service),
            section!("map", "places", "Map", map),
            section!("audit", "audit", "Audit of existing plans", audit::values(seen)),
            section!("periods", "periods", "Periods of the day", periods::values(seen)),
            section!("movements", "movements", "Movements", movements::values(seen)),
            section!("corridors", "corridors", "Streets of several signals", streets),
            section!("plans", "plans", "Signal plans", programs),
            section!("cabinet", "cabinet", "For the cabinet", plans::cabinet::values(seen)),
            section!("level_note", "level-note", "", note),
        ];
        let known = all.into_iter().filter_map(|(id, title, template, values)| {
            let slot = match id {
                "signals" => Slot::First,
                "level-note" => Slot::Notes,
                _ => Slot::Body,
            };
            let html = render("part.html", template, values?).map_err(ReportError::Template);
            Some(html.map(|html| Part { slot, id, title, html }))
        });
        known.collect()
    }

    fn tables(&self, data: &Analysis) -> Vec<&'static str> {
        let further = self.further(data).into_iter().map(|(name, _)| name);
        std::iter::once(plans::TABLE).chain(further).collect()
    }

    fn write(&self, folder: &Path, data: &Analysis) -> Result<Written, ReportError> {
        let seen = self.seen(data);
        let mut written = Written { files: vec![plans::write(folder, seen)?], notes: Vec::new() };
        written.notes.extend(plans::cabinet::write(&folder.join(plans::FOLDER), seen)?);
        super::pages::write(folder, seen)?;
        for (name, text) in self.further(data) {
            let path = folder.join(name);
            write_atomically(&path, text(seen).as_bytes())?;
            written.files.push(path);
        }
        Ok(written)
    }
}
