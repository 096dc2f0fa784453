//! What each period of the day contributes: `periods.csv`, and a table on the page. Only where the scenario has the hours per
//! year of its periods.
//!
//! The vehicle-hours of a year are those of the simulated time, once for each hour of the year that the period has. They are
//! of the evaluated intersections alone: a sample is not extrapolated.

use minijinja::{Value, context};

use super::demand::{HOUR_S, horizon_s};
use super::level_of_service::letter;
use super::shown::Seen;
use evaluation::analysis::Analysis;
use evaluation::report::csv;

/// Name of the table in the report's folder.
pub(crate) const TABLE: &str = "periods.csv";

const HEADER: [&str; 7] = [
    "period", "hours_per_year", "method", "intersections", "vehicles_vph", "delay_s",
    "vehicle_hours_per_year",
];

/// A period of the day.
#[derive(Debug, Clone, PartialEq)]
struct Period {
    name: String,
    hours: f64,
    /// Positions of its point MDPs.
    points: Vec<usize>,
}

/// What a method achieved in a period: sums over its intersections.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Achieved {
    vehicles: f64,
    delay_s: f64,
}

/// Returns the periods of a run with their point MDPs; nothing where the scenario does not say their hours.
fn periods(Seen { data, shown }: Seen<'_>) -> Vec<Period> {
    let identity = &data.manifest.identity;
    let hours = identity.settings.pointer("/family/periods").and_then(serde_json::Value::as_object);
    let of = |(name, hours): (&String, &serde_json::Value)| {
        let own = shown.places.drawings.iter().filter(|drawn| drawn.period == *name);
        let points = own.filter_map(|drawn| data.position(&drawn.point)).collect();
        Some(Period { name: name.clone(), hours: hours.as_f64()?, points })
    };
    let all: Vec<Period> = hours.into_iter().flatten().filter_map(of).collect();
    all.into_iter().filter(|period| !period.points.is_empty()).collect()
}

/// Returns what a method achieved in a period; `None` without a result on each of its intersections.
fn achieved(data: &Analysis, period: &Period, method: usize) -> Option<Achieved> {
    let mut sum = Achieved { vehicles: 0.0, delay_s: 0.0 };
    for point in &period.points {
        let result = data.points[*point].results[method].as_ref()?;
        let vehicles = result.metrics.get("vehicles_veh")?;
        sum.vehicles += vehicles;
        sum.delay_s += vehicles * result.objective;
    }
    (sum.vehicles > 0.0).then_some(sum)
}

/// Returns the vehicle-hours of a year.
fn per_year(data: &Analysis, period: &Period, achieved: &Achieved) -> Option<f64> {
    let times = HOUR_S / horizon_s(&data.manifest.identity)? * period.hours;
    Some(achieved.delay_s / HOUR_S * times)
}

/// Whether there is anything to say of periods.
pub(crate) fn are_known(seen: Seen<'_>) -> bool {
    !periods(seen).is_empty()
}

/// Returns the table.
pub(crate) fn table(seen: Seen<'_>) -> String {
    let data = seen.data;
    let identity = &data.manifest.identity;
    let mut rows = Vec::new();
    let horizon_h = horizon_s(identity).unwrap_or(HOUR_S) / HOUR_S;
    for period in periods(seen) {
        for (index, method) in identity.methods.iter().enumerate() {
            let Some(sum) = achieved(data, &period, index) else { continue };
            let year = per_year(data, &period, &sum).map_or_else(String::new, |h| h.to_string());
            rows.push(vec![
                period.name.clone(),
                period.hours.to_string(),
                method.clone(),
                period.points.len().to_string(),
                (sum.vehicles / horizon_h).to_string(),
                (sum.delay_s / sum.vehicles).to_string(),
                year,
            ]);
        }
    }
    csv::table(&HEADER, rows.into_iter())
}

/// Returns the section on periods; undefined where their hours are not known.
pub(crate) fn values(seen: Seen<'_>) -> Option<Value> {
    let data = seen.data;
    if !are_known(seen) {
        return None;
    }
    let all = periods(seen);
    let is_whole = all.iter().map(|period| period.points.len()).sum::<usize>() == data.points.len();
    let heads: Vec<Value> = (all.iter())
        .map(|p| context! { name => p.name.as_str(), hours => p.hours.to_string(), points => p.points.len() })
        .collect();
    let row = |method: &evaluation::analysis::MethodSummary| {
        let sums: Vec<Option<Achieved>> =
            all.iter().map(|p| achieved(data, p, method.index)).collect();
        let year = |(p, sum): (&Period, &Option<Achieved>)| per_year(data, p, sum.as_ref()?);
        let total: Option<f64> = all.iter().zip(&sums).map(year).sum();
        let total = total.filter(|_| is_whole);
        let cells = all.iter().zip(&sums).map(|(p, sum)| {
            let delay_s = sum.map(|sum| sum.delay_s / sum.vehicles);
            context! {
                delay => delay_s.map(|s| format!("{s:.1}")),
                level => delay_s.map(|s| letter(s).to_string()),
                hours => year((p, sum)).map(|h| format!("{h:.0}")),
            }
        });
        let label = method.method.clone();
        context! { label, cells => cells.collect::<Vec<_>>(), total => total.map(|h| format!("{h:.0}")) }
    };
    let rows: Vec<Value> = data.methods.iter().filter(|m| m.points > 0).map(row).collect();
    Some(context! { heads, rows })
}
