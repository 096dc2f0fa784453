//! What each period of the day contributes: `periods.csv`, and a table on the page. Only where the scenario has the hours per
//! year of its periods.
//!
//! The vehicle-hours of a year are those of the simulated time, once for each hour of the year that the period has. They are
//! of the evaluated intersections alone: a sample is not extrapolated.

use minijinja::{Value, context};

use super::demand::{HOUR_S, horizon_s};
use super::level_of_service::letter;
use super::shown::Seen;
use evaluation::report::format;
use evaluation::report::table::{Cell, Columns, Table};

/// Name of the table in the report's folder.
pub(crate) const TABLE: &str = "periods.csv";

/// Returns a row per period and method that has a result on each of its intersections; none where the scenario does not say the
/// hours of its periods.
fn rows(Seen { data, shown }: Seen<'_>) -> Table {
    let identity = &data.manifest.identity;
    let horizon_h = horizon_s(identity).map(|s| s / HOUR_S);
    let periods =
        identity.settings.pointer("/family/periods").and_then(serde_json::Value::as_object);
    let mut rows: Vec<(&String, f64, &String, usize, [f64; 2])> = Vec::new();
    for (name, hours) in periods.into_iter().flatten() {
        let own = shown.places.drawings.iter().filter(|drawn| drawn.period == *name);
        let points: Vec<usize> = own.filter_map(|drawn| data.position(&drawn.point)).collect();
        for (index, method) in identity.methods.iter().enumerate() {
            let of = |point: &usize| {
                let result = data.points[*point].results[index].as_ref()?;
                let vehicles = *result.metrics.get("vehicles_veh")?;
                Some([vehicles, vehicles * result.objective])
            };
            let all = points.iter().map(of).collect::<Option<Vec<_>>>().unwrap_or_default();
            let sums = [0, 1].map(|i| all.iter().map(|own| own[i]).sum::<f64>());
            if let Some(hours) = hours.as_f64().filter(|_| sums[0] > 0.0) {
                rows.push((name, hours, method, points.len(), sums));
            }
        }
    }
    let delay = |s: f64| format!("{s:.1} {}", letter(s));
    Columns::new()
        .text("period", "Period", |r: &(&String, f64, &String, usize, [f64; 2])| r.0.clone())
        .column("hours_per_year", "Hours per year", |r| Cell::exact(r.1))
        .text("method", "Method", |r| r.2.clone())
        .column("intersections", "Intersections", |r| Cell::count(r.3))
        .file("vehicles_vph", move |r| Cell::exact(r.4[0] / horizon_h.unwrap_or(1.0)))
        .column("delay_s", "Delay, s per vehicle, and level", move |r| {
            Cell::number(r.4[1] / r.4[0], delay)
        })
        .column("vehicle_hours_per_year", "Delay, vehicle-hours per year", move |r| {
            let hours = |horizon_h: f64| r.4[1] / HOUR_S * (1.0 / horizon_h * r.1);
            Cell::number(horizon_h.map(hours), format::thousands)
        })
        .table(rows)
}

/// Returns the table.
pub(crate) fn table(seen: Seen<'_>) -> String {
    rows(seen).csv()
}

/// Returns the section on periods; undefined where their hours are not known.
pub(crate) fn values(seen: Seen<'_>) -> Option<Value> {
    let caption = "Delay in each period, and in a year, at the evaluated intersections.";
    let rows = rows(seen);
    (!rows.is_empty()).then(|| context! { table => rows.html(caption) })
}
