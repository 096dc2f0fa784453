//! Streets of several signals: `corridors.csv`, a table on the page, and the time-space diagram of a plan.
//!
//! A row is a direction of a street under a method: how long vehicles take that drive along all its signals. Intervals are
//! Student's over the evaluation seeds.
//!
//! The diagram is that of `coordinated`, with the cycle that its rings follow. A band is the longest run of seconds in which a
//! vehicle at the speed limit meets no red.

use minijinja::{Value, context};

use super::shown::{OfTask, Seen, TaskPlan};
use evaluation::report::svg::{Anchor, Axes, Canvas, TextStyle, nice_step};
use evaluation::report::table::{Cell, Columns};
use evaluation::report::{Figure, WIDTH};
use evaluation::stats::mean_interval;
use signals::control::coordinated;
use signals::program::ProgramPhase;
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
    let of = |street| Some((street, greens(plan, street)?));
    let panels: Vec<(&StreetResult, Greens)> =
        task.results.streets.iter().filter_map(of).take(FEW).collect();
    let mut canvas = Canvas::new(WIDTH, (PANEL_PX + 50.0) * panels.len() as f64 + 10.0);
    let bands = panels.iter().enumerate().map(|(i, (street, greens))| {
        let top = 24.0 + (PANEL_PX + 50.0) * i as f64;
        format!("{}: {}", street.direction, panel(&mut canvas, top, street, greens))
    });
    let bands: Vec<String> = bands.collect();
    let title = format!("Time-space diagram of {method}");
    (!bands.is_empty()).then(|| canvas.figure("time-space", &title, &bands.join("; ")))
}

/// Per signal of a street whether its movement is green, by second of the cycle.
type Greens = Vec<Vec<bool>>;

/// Returns the greens of a street; `None` where one of its signals has no fixed cycle, another one, or the network's own, whose
/// offset records do not have.
fn greens(plan: &TaskPlan, street: &StreetResult) -> Option<Greens> {
    let of = |stop: &StreetStop| {
        let mut programs = plan.programs.iter().chain(&plan.rings);
        let program = programs.find(|p| p.signal == stop.signal && !p.own)?;
        let offset_s = program.stages.as_ref().map_or(program.offset_s, |s| s.offset_s.into());
        let green = |phase: &ProgramPhase| {
            let letter = |link: &usize| phase.state.as_bytes().get(*link);
            let is_green = |link| matches!(letter(link), Some(b'G' | b'g'));
            vec![stop.links.iter().any(is_green); phase.duration_s.round() as usize]
        };
        let mut greens: Vec<bool> = program.phases.iter().flat_map(green).collect();
        let count = greens.len().max(1);
        greens.rotate_right(offset_s.round() as usize % count);
        Some(greens)
    };
    let all: Greens = street.stops.iter().map(of).collect::<Option<_>>()?;
    let has_cycle = |greens: &Vec<bool>| !greens.is_empty() && greens.len() == all[0].len();
    all.iter().all(has_cycle).then_some(all)
}

/// Returns start and length of the band in seconds of the first stop line; `None` where every vehicle meets a red.
fn band(street: &StreetResult, greens: &Greens) -> Option<(usize, usize)> {
    let cycle_s = greens[0].len();
    let stops = || street.stops.iter().map(|stop| stop.after_s.round() as usize).zip(greens);
    let passes = |t| stops().all(|(after_s, green)| green[(t + after_s) % cycle_s]);
    let twice: Vec<bool> = (0..2 * cycle_s).map(passes).collect();
    let (mut start, mut best) = (0, (0, 0));
    for run in twice.chunk_by(|a, b| a == b) {
        if run[0] && run.len() > best.1 {
            best = (start, run.len());
        }
        start += run.len();
    }
    (best.1 > 0).then_some((best.0, best.1.min(cycle_s)))
}

/// Draws a direction and returns its band in words.
fn panel(canvas: &mut Canvas, top: f64, street: &StreetResult, greens: &Greens) -> String {
    let cycle_s = greens[0].len();
    let last_s = street.stops.last().map_or(0.0, |stop| stop.after_s);
    let span_s = CYCLES * cycle_s as f64 + last_s;
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
    let band = band(street, greens);
    let said = match band {
        Some((_, width_s)) => format!("band of {width_s} s in a cycle of {cycle_s} s"),
        None => "no band".to_owned(),
    };
    let (method, stops) = (coordinated::METHOD.name, &street.stops);
    let name = format!("{method}, {}, {} signals: {said}", street.direction, stops.len());
    canvas.text(left, top - 8.0, &name, TextStyle::new(Anchor::Start).bold());
    let bands = band.iter().flat_map(|(start, width_s)| {
        (start % cycle_s..).step_by(cycle_s).map(move |from| [from as f64, (from + width_s) as f64])
    });
    for [from_s, to_s] in bands.take_while(|[_, to_s]| to_s + last_s <= span_s) {
        let corner = |t: f64, stop: &StreetStop| (frame.x(t + stop.after_s), frame.y(stop.at_m));
        let from = stops.iter().map(|stop| corner(from_s, stop));
        let to = stops.iter().rev().map(|stop| corner(to_s, stop));
        canvas.band(&from.chain(to).collect::<Vec<_>>(), GREEN);
    }
    for (stop, greens) in stops.iter().zip(greens) {
        let y = frame.y(stop.at_m);
        let mut from = 0;
        let seconds: Vec<bool> =
            greens.iter().copied().cycle().take(span_s.round() as usize).collect();
        for run in seconds.chunk_by(|a, b| a == b) {
            let (color, half) = if run[0] { (GREEN, BAR_PX / 4.0) } else { (RED, BAR_PX / 2.0) };
            let ends = [from, from + run.len()].map(|t| frame.x(t as f64));
            canvas.rect((ends[0], y - half), (ends[1], y + half), color, None);
            from += run.len();
        }
        let style = TextStyle::new(Anchor::Start).small();
        canvas.text(right + 8.0, y + 4.0, &stop.signal, style);
    }
    said
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_band_is_what_the_greens_of_a_street_have_in_common_for_who_drives_along() {
        let green = |from: usize| (0..60).map(|t| (60 + t - from) % 60 < 30).collect::<Vec<bool>>();
        let band = |stops: &[(f64, usize)]| {
            let stop =
                |after_s| StreetStop { signal: "s".into(), links: vec![], at_m: 0.0, after_s };
            let street = StreetResult {
                direction: "EB".into(),
                stops: stops.iter().map(|(after_s, _)| stop(*after_s)).collect(),
                episodes: vec![],
            };
            super::band(&street, &stops.iter().map(|(_, from)| green(*from)).collect())
        };
        // Green from 5 to 35 s, and at the second signal from 30 to 60 s, which is 10 to 40 s at the first.
        assert_eq!(band(&[(0.0, 5), (20.0, 30)]), Some((10, 25)));
        assert_eq!(band(&[(0.0, 5), (20.0, 55)]), None);
        // It may go over the end of the cycle.
        assert_eq!(band(&[(0.0, 50)]), Some((50, 30)));
    }
}
