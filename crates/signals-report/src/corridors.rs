//! Streets of several signals: `corridors.csv`, a table on the page, and the time-space diagram of a plan.
//!
//! A row is a direction of a street under a method: how long vehicles take that drive along all its signals. Intervals are
//! Student's over the evaluation seeds.
//!
//! The diagram is that of `coordinated` where it ran, with the cycle that its rings follow, else of the method with the least delay
//! of those whose signals along a street all run programs of fixed times. A band is the longest run of seconds in which a vehicle at the speed limit meets
//! no red; there is none where cycles differ.

use minijinja::{Value, context};

use super::plans::TaskPlan;
use super::shown::{Seen, finished};
use evaluation::report::csv::{self, number};
use evaluation::report::svg::{Anchor, Axes, Canvas, TextStyle, nice_step};
use evaluation::report::{Figure, WIDTH};
use evaluation::stats::mean_interval;
use evaluation::store::manifest::Task;
use evaluation::store::record::Summary;
use evaluation::store::results::Results;
use signals::control::coordinated;
use signals::program::{ProgramKind, SignalProgram};
use signals::street_results::{ByStreet, StreetEpisode, StreetResult, StreetStop};

/// Name of the table in the report's folder.
pub(crate) const TABLE: &str = "corridors.csv";

/// Name of the figure.
const FIGURE: &str = "time-space";

/// Most directions that the figure shows, and rows of the page.
const FEW: usize = 8;
const MOST_ROWS: usize = 60;

/// Cycles that the diagram shows.
const CYCLES: f64 = 2.0;

/// Height of the diagram of a direction, pixels.
const PANEL_PX: f64 = 250.0;

/// Height of the bar of a signal, pixels.
const BAR_PX: f64 = 7.0;

const RED: &str = "#c0392b";
const GREEN: &str = "#1e8449";
const BAND: &str = "#1e8449";

/// Returns a quantity of an episode.
type Quantity = fn(&StreetEpisode) -> f64;

/// The quantities of the table with their columns.
const QUANTITIES: [(&str, Quantity); 3] =
    [("travel_s", |e| e.travel_s), ("delay_s", |e| e.delay_s), ("stops_per_veh", |e| e.stops)];

/// Results by street of a task.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TaskStreets {
    method: usize,
    /// Position of the point MDP in the manifest.
    point: usize,
    replicate: u32,
    streets: Vec<StreetResult>,
}

/// Returns the results by street of every finished task that has them, in the order of the plan.
pub(crate) fn streets(results: &Results) -> Vec<TaskStreets> {
    let of_task = |(method, point, task, summary): (usize, usize, &Task, &Summary)| {
        // What records have of single intersections is something else.
        let ByStreet { streets } = summary.parts.read().unwrap_or_default();
        let replicate = task.replicate;
        (!streets.is_empty()).then_some(TaskStreets { method, point, replicate, streets })
    };
    finished(results).filter_map(of_task).collect()
}

/// Returns mean and interval of a quantity over the episodes in which somebody drove along.
fn over(street: &StreetResult, of: fn(&StreetEpisode) -> f64) -> Option<(f64, f64, f64)> {
    let driven = street.episodes.iter().filter(|e| e.vehicles > 0);
    mean_interval(&driven.map(of).collect::<Vec<_>>())
}

fn vehicles(street: &StreetResult) -> f64 {
    let all: u32 = street.episodes.iter().map(|e| e.vehicles).sum();
    f64::from(all) / street.episodes.len().max(1) as f64
}

fn length_m(street: &StreetResult) -> f64 {
    street.stops.last().map_or(0.0, |stop| stop.at_m)
}

fn signals(street: &StreetResult) -> String {
    street.stops.iter().map(|stop| stop.signal.as_str()).collect::<Vec<_>>().join(" ")
}

pub(crate) fn table(seen: Seen<'_>) -> String {
    let Seen { data, shown } = seen;
    let titles = shown.titles(data);
    let titled = csv::Titled(titles.as_deref());
    let identity = &data.manifest.identity;
    let mut header: Vec<String> =
        ["point", "method", "replicate", "direction", "signals", "length_m", "episodes"]
            .map(str::to_owned)
            .to_vec();
    header.push("vehicles_per_episode".to_owned());
    for (name, _) in QUANTITIES {
        header.extend([name.to_owned(), format!("{name}_low"), format!("{name}_high")]);
    }
    let rows = shown.streets.iter().flat_map(|task| {
        task.streets.iter().map(move |street| {
            let mut cells = vec![
                identity.points[task.point].point.clone(),
                identity.methods[task.method].clone(),
                task.replicate.to_string(),
                street.direction.clone(),
                signals(street),
                length_m(street).to_string(),
                street.episodes.len().to_string(),
                vehicles(street).to_string(),
            ];
            for (_, of) in QUANTITIES {
                let (mean, low, high) = over(street, of)
                    .map_or((None, None, None), |(m, l, h)| (Some(m), Some(l), Some(h)));
                cells.extend([number(mean), number(low), number(high)]);
            }
            titled.row(task.point, cells)
        })
    });
    csv::table(&titled.header(header), rows)
}

/// Returns the section on streets; undefined where no record has any.
///
/// # Arguments
///
/// * `diagram` — the time-space diagram, if there is one.
pub(crate) fn values(seen: Seen<'_>, diagram: Option<&str>) -> Option<Value> {
    let Seen { data, shown } = seen;
    shown.streets.first()?;
    let identity = &data.manifest.identity;
    let each = |task: &TaskStreets| 0..task.streets.len();
    let all = shown.streets.iter().flat_map(|task| each(task).map(move |number| (task, number)));
    let mut all: Vec<(&TaskStreets, usize)> = all.collect();
    // The methods of a street stand together.
    all.sort_by_key(|(task, number)| (task.point, *number));
    let row = |(task, number): &(&TaskStreets, usize)| {
        let street = &task.streets[*number];
        let cell = |((_, of), digits): (&(&str, Quantity), usize)| {
            let cell = |(m, low, high): (f64, f64, f64)| {
                format!("{m:.digits$} ({low:.digits$} to {high:.digits$})")
            };
            over(street, *of).map_or_else(|| "-".to_owned(), cell)
        };
        let training = match task.replicate {
            0 => String::new(),
            replicate => format!(", replicate {replicate}"),
        };
        context! {
            title => data.points.get(task.point).map(|p| shown.title(&p.row)),
            direction => street.direction.as_str(),
            signals => signals(street),
            count => street.stops.len(),
            length => format!("{:.0}", length_m(street)),
            method => identity.methods[task.method].clone() + training.as_str(),
            vehicles => format!("{:.0}", vehicles(street)),
            cells => QUANTITIES.iter().zip([1, 1, 2]).map(cell).collect::<Vec<_>>(),
        }
    };
    let rows: Vec<Value> = all.iter().take(MOST_ROWS).map(row).collect();
    Some(context! { rows, diagram, many => all.len() > MOST_ROWS, few => MOST_ROWS })
}

/// Draws the time-space diagram of the plan that is worth looking at.
pub(crate) fn diagram(seen: Seen<'_>) -> Option<Figure> {
    let Seen { data, shown } = seen;
    let task = shown.streets.first()?;
    let identity = &data.manifest.identity;
    let is_coordinated =
        |plan: &TaskPlan| identity.methods[plan.method] == coordinated::METHOD.name;
    let is_drawn = |plan: &&TaskPlan| {
        plan.point == task.point && task.streets.iter().any(|s| lights(plan, s).is_some())
    };
    let delay_s = |plan: &TaskPlan| plan.objective.unwrap_or(f64::INFINITY);
    let plan = shown.plans.iter().filter(is_drawn).min_by(|a, b| {
        is_coordinated(b).cmp(&is_coordinated(a)).then(delay_s(a).total_cmp(&delay_s(b)))
    })?;
    let panels: Vec<(&StreetResult, Vec<Light<'_>>)> = (task.streets.iter())
        .filter_map(|street| Some((street, lights(plan, street)?)))
        .take(FEW)
        .collect();
    let mut canvas = Canvas::new(WIDTH, (PANEL_PX + 50.0) * panels.len() as f64 + 10.0);
    let (mut bands, method) = (Vec::new(), &identity.methods[plan.method]);
    for (i, (street, lights)) in panels.iter().enumerate() {
        let top = 24.0 + (PANEL_PX + 50.0) * i as f64;
        let band = panel(&mut canvas, top, (method, street), lights);
        bands.push(format!("{}: {band}", street.direction));
    }
    let title = format!("Time-space diagram of {method}");
    Some(canvas.figure(FIGURE, &title, &bands.join("; ")))
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
        for phase in &self.program.phases {
            if left_s < phase.duration_s {
                let letter = |link: &usize| phase.state.as_bytes().get(*link).copied();
                return self.stop.links.iter().any(|l| matches!(letter(l), Some(b'G' | b'g')));
            }
            left_s -= phase.duration_s;
        }
        false
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
    if free.iter().all(|free| *free) {
        return Some((0.0, cycle_s, cycle_s));
    }
    let (mut best, mut run) = ((0, 0), 0);
    for t in 0..2 * seconds {
        run = if free[t % seconds] { run + 1 } else { 0 };
        if run > best.1 {
            best = (t + 1 - run, run);
        }
    }
    (best.1 > 0).then_some((best.0 as f64, best.1 as f64, cycle_s))
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
    let name = |band: &str| {
        format!("{method}, {}, {} signals: {band}", street.direction, street.stops.len())
    };
    let said = match band {
        Some((_, width_s, cycle_s)) => format!("band of {width_s} s in a cycle of {cycle_s} s"),
        None => "no band".to_owned(),
    };
    canvas.text(left, top - 8.0, &name(&said), TextStyle::new(Anchor::Start).bold());
    if let Some((start_s, width_s, cycle_s)) = band {
        let mut from_s = start_s % cycle_s;
        while from_s + width_s + last_s <= span_s {
            let ends = |t: f64| {
                let corner = move |light: &Light<'_>| (t + light.stop.after_s, light.stop.at_m);
                lights.iter().map(corner)
            };
            let corners = ends(from_s).chain(ends(from_s + width_s).rev());
            let drawn: Vec<_> = corners.map(|(t, m)| (frame.x(t), frame.y(m))).collect();
            canvas.band(&drawn, BAND);
            from_s += cycle_s;
        }
    }
    for light in lights {
        let y = frame.y(light.stop.at_m);
        let mut from = 0;
        let seconds = span_s.round() as usize;
        for t in 1..=seconds {
            let is_green = light.is_green(from as f64);
            if t == seconds || light.is_green(t as f64) != is_green {
                let half = if is_green { BAR_PX / 4.0 } else { BAR_PX / 2.0 };
                let color = if is_green { GREEN } else { RED };
                let ends = [from, t].map(|t| frame.x(t as f64));
                canvas.rect((ends[0], y - half), (ends[1], y + half), color, None);
                from = t;
            }
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
