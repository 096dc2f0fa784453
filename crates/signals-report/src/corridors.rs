//! Streets of several signals: `corridors.csv`, a table on the page, and the time-space diagram of a plan.
//!
//! A row is a direction of a street under a method: how long vehicles take that drive along all its signals. Intervals are
//! Student's over the evaluation seeds.
//!
//! The diagram is that of `coordinated`, with the cycle that its rings follow. A band is the longest run of seconds in which a
//! vehicle at the speed limit meets no red; there is none where cycles differ.

use minijinja::{Value, context};

use super::shown::TaskPlan;
use super::shown::{OfTask, Seen};
use evaluation::report::svg::{Anchor, Axes, Canvas, TextStyle, nice_step};
use evaluation::report::table::{Cell, Columns};
use evaluation::report::{Figure, WIDTH};
use evaluation::stats::mean_interval;
use signals::control::coordinated;
use signals::program::{ProgramKind, SignalProgram};
use signals::street_results::{ByStreet, StreetEpisode, StreetResult, StreetStop};

/// Name of the table in the report's folder.
pub(crate) const TABLE: &str = "corridors.csv";

/// Most directions that the figure shows, and rows of the page.
const FEW: usize = 8;
const MOST_ROWS: usize = 60;

/// Vehicles below which a mean is marked.
const FEW_VEHICLES: u32 = 30;

/// Cycles that the diagram shows.
const CYCLES: f64 = 2.0;

/// Height of the diagram of a direction, pixels.
const PANEL_PX: f64 = 250.0;

/// Height of the bar of a signal, pixels.
const BAR_PX: f64 = 7.0;

const RED: &str = "#c0392b";
const GREEN: &str = "#1e8449";

/// A quantity of an episode: column, heading, digits on the page, and its value.
type Quantity = (&'static str, &'static str, usize, fn(&StreetEpisode) -> f64);

const QUANTITIES: [Quantity; 3] = [
    ("travel_s", "Travel time (s)", 1, |e| e.travel_s),
    ("delay_s", "Delay (s per vehicle)", 1, |e| e.delay_s),
    ("stops_per_veh", "Stops per vehicle", 2, |e| e.stops),
];

fn length_m(street: &StreetResult) -> f64 {
    street.stops.last().map_or(0.0, |stop| stop.at_m)
}

/// A street under a task.
type Row<'a> = (&'a OfTask<ByStreet>, &'a StreetResult);

/// Returns the columns of the file and of the page.
fn columns(Seen { data, shown }: Seen<'_>) -> Columns<'_, Row<'_>> {
    let identity = &data.manifest.identity;
    let point = |task: &OfTask<ByStreet>| &identity.points[task.point].point;
    let signals = |street: &StreetResult| {
        street.stops.iter().map(|stop| stop.signal.as_str()).collect::<Vec<_>>().join(" ")
    };
    let title = |task: &OfTask<ByStreet>| data.points.get(task.point).map(|p| shown.title(&p.row));
    let all_vehicles =
        |street: &StreetResult| street.episodes.iter().map(|e| e.vehicles).sum::<u32>();
    let vehicles = move |street: &StreetResult| {
        f64::from(all_vehicles(street)) / street.episodes.len().max(1) as f64
    };
    let mut columns = Columns::new()
        .text("point", "", move |r: &Row<'_>| point(r.0).clone())
        .text("", "Network", move |r| title(r.0).unwrap_or_default())
        .text("method", "Method", |r| identity.methods[r.0.method].clone())
        .column("replicate", "Replicate", |r| Cell::count(r.0.replicate as usize))
        .text("direction", "Direction", |r| r.1.direction.clone())
        .text("signals", "Signals", move |r| signals(r.1))
        .column("length_m", "Length (m)", |r| Cell::number(length_m(r.1), |m| format!("{m:.0}")))
        .file("episodes", |r| Cell::count(r.1.episodes.len()))
        .column("vehicles_per_episode", "Vehicles per episode", move |r| {
            Cell::number(vehicles(r.1), |n| format!("{n:.0}"))
        });
    for (name, heading, digits, of) in QUANTITIES {
        // Over the episodes in which somebody drove along.
        let over = move |(_, street): &Row<'_>| {
            let driven = street.episodes.iter().filter(|e| e.vehicles > 0);
            mean_interval(&driven.map(of).collect::<Vec<_>>())
        };
        let cell = move |row: &Row<'_>| {
            let all = over(row);
            let interval = all.map(|(_, low, high)| format!("{low:.digits$} to {high:.digits$}"));
            let mark = if all_vehicles(row.1) < FEW_VEHICLES { " *" } else { "" };
            Cell::number(all.map(|all| all.0), |mean| format!("{mean:.digits$}{mark}"))
                .above(interval)
        };
        columns = columns
            .column(name, heading, cell)
            .file(format!("{name}_low"), move |row| Cell::exact(over(row).map(|all| all.1)))
            .file(format!("{name}_high"), move |row| Cell::exact(over(row).map(|all| all.2)));
    }
    match shown.titles(data) {
        Some(titles) => columns.text("title", "", move |row| titles[row.0.point].clone()),
        None => columns,
    }
}

fn rows(seen: Seen<'_>) -> Vec<Row<'_>> {
    let tasks = seen.shown.streets.iter();
    tasks.flat_map(|task| task.results.streets.iter().map(move |street| (task, street))).collect()
}

pub(crate) fn table(seen: Seen<'_>) -> String {
    columns(seen).table(rows(seen)).csv()
}

/// Returns the section on streets; undefined where no record has any.
pub(crate) fn values(seen: Seen<'_>, diagram: Option<&str>) -> Option<Value> {
    seen.shown.streets.first()?;
    let mut rows = rows(seen);
    // The methods of a street stand together.
    let number = |(task, street): &Row<'_>| task.results.streets.iter().position(|s| s == *street);
    rows.sort_by_key(|row| (row.0.point, number(row)));
    rows.truncate(MOST_ROWS);
    let caption = "Means over the evaluation seeds with 95% intervals";
    Some(
        context! { table => columns(seen).table(rows).html(caption), diagram, most => MOST_ROWS, few => FEW_VEHICLES },
    )
}

/// Draws the time-space diagram of `coordinated`.
pub(crate) fn diagram(Seen { data, shown }: Seen<'_>) -> Option<Figure> {
    let task = shown.streets.first()?;
    let method = coordinated::METHOD.name;
    let is_own = |plan: &&TaskPlan| {
        plan.point == task.point && data.manifest.identity.methods[plan.method] == method
    };
    let plan = shown.plans.iter().find(is_own)?;
    let of = |street| Some((street, lights(plan, street)?));
    let panels: Vec<(&StreetResult, Vec<Light<'_>>)> =
        task.results.streets.iter().filter_map(of).take(FEW).collect();
    if panels.is_empty() {
        return None;
    }
    let mut canvas = Canvas::new(WIDTH, (PANEL_PX + 50.0) * panels.len() as f64 + 10.0);
    let bands = panels.iter().enumerate().map(|(i, (street, lights))| {
        let top = 24.0 + (PANEL_PX + 50.0) * i as f64;
        let band = panel(&mut canvas, top, (method, street), lights);
        format!("{}: {band}", street.direction)
    });
    let bands: Vec<String> = bands.collect();
    let title = format!("Time-space diagram of {method}");
    Some(canvas.figure("time-space", &title, &bands.join("; ")))
}

/// A signal of a street with the program that it runs.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Light<'a> {
    stop: &'a StreetStop,
    program: &'a SignalProgram,
}

impl Light<'_> {
    fn cycle_s(&self) -> f64 {
        self.program.phases.iter().map(|p| p.duration_s).sum()
    }

    /// Whether the movement along the street is green at a time.
    fn is_green(&self, time_s: f64) -> bool {
        let stages = self.program.stages.as_ref();
        let offset_s = stages.map_or(self.program.offset_s, |stages| stages.offset_s.into());
        let mut left_s = (time_s - offset_s).rem_euclid(self.cycle_s());
        let shown = self.program.phases.iter().find(|phase| {
            left_s -= phase.duration_s;
            left_s < 0.0
        });
        let letter = |link: &usize| shown?.state.as_bytes().get(*link).copied();
        self.stop.links.iter().any(|link| matches!(letter(link), Some(b'G' | b'g')))
    }
}

/// Returns the signals of a street with their programs; `None` where one of them has no fixed cycle, or the
/// network's own, whose offset records do not have.
fn lights<'a>(plan: &'a TaskPlan, street: &'a StreetResult) -> Option<Vec<Light<'a>>> {
    let of = |stop: &'a StreetStop| {
        let mut programs = plan.programs.iter().chain(&plan.rings);
        let program = programs.find(|p| p.signal == stop.signal)?;
        let is_timed = matches!(program.kind, ProgramKind::Static | ProgramKind::DualRing);
        let light = Light { stop, program };
        (is_timed && !program.own && light.cycle_s() > 0.0).then_some(light)
    };
    street.stops.iter().map(of).collect()
}

/// Returns start and length of the band in seconds of the first stop line, and the cycle; `None` where cycles differ or
/// every vehicle meets a red.
fn band(lights: &[Light<'_>]) -> Option<(f64, f64, f64)> {
    let cycle_s = lights[0].cycle_s();
    if lights.iter().any(|light| (light.cycle_s() - cycle_s).abs() > 1e-6) {
        return None;
    }
    let seconds = cycle_s.round() as usize;
    let passes =
        |t: usize| lights.iter().all(|light| light.is_green(t as f64 + light.stop.after_s.round()));
    let free: Vec<bool> = (0..seconds).map(passes).collect();
    let twice = [&free[..], &free].concat();
    let (mut start, mut best) = (0, (0, 0));
    for run in twice.chunk_by(|a, b| a == b) {
        if run[0] && run.len() > best.1 {
            best = (start, run.len());
        }
        start += run.len();
    }
    (best.1 > 0).then_some((best.0 as f64, best.1.min(seconds) as f64, cycle_s))
}

/// Draws a direction and returns its band in words.
fn panel(
    canvas: &mut Canvas,
    top: f64,
    (method, street): (&str, &StreetResult),
    lights: &[Light<'_>],
) -> String {
    let longest_s = lights.iter().map(Light::cycle_s).fold(0.0, f64::max);
    let last_s = lights.last().map_or(0.0, |light| light.stop.after_s);
    let span_s = CYCLES * longest_s + last_s;
    let length_m = length_m(street).max(1.0);
    let (left, right, bottom) = (74.0, WIDTH - 120.0, top + PANEL_PX - 40.0);
    let margin_m = 0.06 * length_m;
    let frame = canvas.axes(&Axes {
        area: (left, top, right, bottom),
        x: (0.0, span_s),
        y: (-margin_m, length_m + margin_m),
        x_step: nice_step(span_s, 8.0),
        y_step: Some(nice_step(length_m, 4.0)),
        x_last: span_s,
        x_label: Some("time (s)".to_owned()),
        y_label: Some("distance (m)".to_owned()),
    });
    let band = band(lights);
    let said = match band {
        Some((_, width_s, cycle_s)) => format!("band of {width_s} s in a cycle of {cycle_s} s"),
        None => "no band".to_owned(),
    };
    let name = format!("{method}, {}, {} signals: {said}", street.direction, street.stops.len());
    canvas.text(left, top - 8.0, &name, TextStyle::new(Anchor::Start).bold());
    if let Some((start_s, width_s, cycle_s)) = band {
        let mut from_s = start_s % cycle_s;
        while from_s + width_s + last_s <= span_s {
            let corner =
                |t: f64, l: &Light<'_>| (frame.x(t + l.stop.after_s), frame.y(l.stop.at_m));
            let from = lights.iter().map(|light| corner(from_s, light));
            let to = lights.iter().rev().map(|light| corner(from_s + width_s, light));
            let corners: Vec<_> = from.chain(to).collect();
            canvas.band(&corners, GREEN);
            from_s += cycle_s;
        }
    }
    for light in lights {
        let y = frame.y(light.stop.at_m);
        let mut from = 0;
        let seconds = 0..span_s.round() as usize;
        let greens: Vec<bool> = seconds.map(|t| light.is_green(t as f64)).collect();
        for run in greens.chunk_by(|a, b| a == b) {
            let (color, half) = if run[0] { (GREEN, BAR_PX / 4.0) } else { (RED, BAR_PX / 2.0) };
            let ends = [from, from + run.len()].map(|t| frame.x(t as f64));
            canvas.rect((ends[0], y - half), (ends[1], y + half), color, None);
            from += run.len();
        }
        let style = TextStyle::new(Anchor::Start).small();
        canvas.text(right + 8.0, y + 4.0, &light.stop.signal, style);
    }
    said
}

#[cfg(test)]
mod tests {
    use super::*;
    use signals::program::ProgramPhase;

    fn program(offset_s: f64, cycle_s: f64) -> SignalProgram {
        let phases = [("rG", 30.0), ("ry", 3.0), ("Gr", cycle_s - 33.0)];
        let phases = phases.map(|(state, s)| ProgramPhase::fixed(state, s)).to_vec();
        SignalProgram { offset_s, ..SignalProgram::new("s", ProgramKind::Static, phases) }
    }

    fn stop(after_s: f64) -> StreetStop {
        StreetStop { signal: "s".into(), links: vec![1], at_m: 10.0 * after_s, after_s }
    }

    #[test]
    fn the_band_is_what_the_greens_of_a_street_have_in_common_for_who_drives_along() {
        let (programs, stops) =
            ([program(5.0, 60.0), program(30.0, 60.0)], [stop(0.0), stop(20.0)]);
        let light = |i: usize| Light { stop: &stops[i], program: &programs[i] };
        // Green from 5 to 35 s, and at the second signal from 30 to 60 s, which is 10 to 40 s at the first.
        assert_eq!(band(&[light(0), light(1)]), Some((10.0, 25.0, 60.0)));
        assert_eq!(band(&[light(0)]), Some((5.0, 30.0, 60.0)));
        let other = program(0.0, 70.0);
        assert_eq!(band(&[light(0), Light { stop: &stops[1], program: &other }]), None);
    }

    #[test]
    fn a_band_may_go_over_the_end_of_the_cycle() {
        let (program, stop) = (program(50.0, 60.0), stop(0.0));
        assert_eq!(band(&[Light { stop: &stop, program: &program }]), Some((50.0, 30.0, 60.0)));
    }
}
