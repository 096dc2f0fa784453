//! What traffic adds to the first page: vehicle-hours.

use super::demand::{self, HOUR_S};
use super::plans::cabinet::unserved_people;
use super::plans::told::given_plan;
use evaluation::analysis::{Analysis, PointSummary};
use evaluation::report::format;
use evaluation::stats::score::weighted_mean;
use evaluation::store::manifest::PointRow;
use signals::control::{existing, program};
use signals::existing::Control;
use signals::network_files::GENERATED;
use signals::trial::{PEDESTRIAN_DELAY, UNSERVED};

/// Returns the method that does what signals do today: the plans that were given, or the programs of SUMO scenarios of
/// somebody's own.
pub(super) fn today(data: &Analysis) -> Option<&'static str> {
    let identity = &data.manifest.identity;
    let has = |name: &str| identity.methods.iter().any(|m| m == name);
    let imported = || identity.points.iter().all(|point| point.environment != GENERATED);
    if has(existing::METHOD.name) {
        return Some(existing::METHOD.name);
    }
    (has(program::METHOD.name) && imported()).then_some(program::METHOD.name)
}

/// Says how many vehicle-hours the best method saves over the family in the time that was simulated; `None` where
/// intersections or vehicles were not counted.
pub(super) fn gain(data: &Analysis) -> Option<String> {
    let identity = &data.manifest.identity;
    let [best, reference] = compared(data)?;
    let intersections = data.family_instances()?;
    let horizon_s = demand::horizon_s(identity)?;
    let saved = |p: &PointSummary| {
        let (own, other) = (p.results[best].as_ref()?, p.results[reference].as_ref()?);
        let vehicles = own.metrics.get("vehicles_veh")?;
        Some((p.weight, (other.objective - own.objective) * vehicles / HOUR_S))
    };
    let known: Option<Vec<(f64, f64)>> = data.points.iter().map(saved).collect();
    let hours = intersections * weighted_mean(known?)?;
    let direction = if hours < 0.0 { "more" } else { "less" };
    let about = if data.is_whole() { "" } else { "about " };
    Some(format!(
        "Over all {intersections} intersections that is {about}{} vehicle-hours {direction} in the simulated {}.",
        format::thousands(hours.abs()),
        demand::span(horizon_s)
    ))
}

/// Returns the positions of the best method and of what it is compared with.
fn compared(data: &Analysis) -> Option<[usize; 2]> {
    let of_today = today(data).and_then(|name| data.methods.iter().find(|m| m.method == name));
    let of_today = of_today.filter(|m| m.rank.is_some()).map(|m| m.index);
    Some([data.best()?.index, of_today.or(data.reference.index)?])
}

/// Returns the delay of people on foot, seconds; `None` where it is not known, or a fixed cycle has phases for them alone, in
/// which nobody walks.
pub(super) fn delay_on_foot(data: &Analysis, point: usize, method: usize) -> Option<f64> {
    let plan = given_plan(&data.points[point].row, &data.manifest.identity.methods[method]);
    let is_served = plan.is_none_or(|plan| unserved_people(&plan).is_empty());
    let result = data.points[point].results[method].as_ref().filter(|_| is_served)?;
    result.metrics.get(PEDESTRIAN_DELAY).copied()
}

/// Says what the best method does to people on foot; `None` where they do not count on every point MDP.
pub(super) fn on_foot(data: &Analysis) -> Option<String> {
    let [best, reference] = compared(data)?;
    let identity = &data.manifest.identity;
    let delay_s = |method: usize| {
        let of = |(i, p): (usize, &PointSummary)| Some((p.weight, delay_on_foot(data, i, method)?));
        weighted_mean(data.points.iter().enumerate().map(of).collect::<Option<Vec<_>>>()?)
    };
    let [own, other] = [best, reference].map(|m| &identity.methods[m]);
    let waits = delay_s(best).zip(delay_s(reference)).map(|(own_s, other_s)| {
        let change = match own_s - other_s {
            _ if best == reference => String::new(),
            more if more >= 0.0 => format!(", {more:.1} s more than under {other}"),
            less => format!(", {:.1} s less than under {other}", -less),
        };
        format!("People on foot wait {own_s:.1} s under {own}{change}.")
    });
    let unserved = |method: usize| {
        let of = |p: &PointSummary| p.results[method].as_ref()?.metrics.get(UNSERVED).copied();
        let count = data.points.iter().filter_map(of).sum::<f64>().round() as usize;
        let (none, name) = (format::count(count, "crosswalk"), &identity.methods[method]);
        (count > 0)
            .then(|| format!("Under {name} nobody is served at {none}, which no mean contains."))
    };
    let methods = [best, reference].into_iter().skip((best == reference).into());
    let said: Vec<String> = waits.into_iter().chain(methods.filter_map(unserved)).collect();
    (!said.is_empty()).then(|| said.join(" "))
}

/// Whether a method runs a coordinated plan on a point MDP that is simulated without its street.
pub(super) fn is_coordinated(point: &PointRow, method: &str) -> bool {
    given_plan(point, method).is_some_and(|plan| plan.control == Control::Coordinated)
}

/// Says where what is done today is a coordinated plan, which loses its progression in a simulation of one intersection;
/// `None` where it is none.
pub(super) fn uncoordinated(data: &Analysis) -> Option<String> {
    let points = &data.manifest.identity.points;
    let name = today(data)?;
    let coordinated = points.iter().filter(|point| is_coordinated(point, name)).count();
    (coordinated > 0).then(|| {
        format!(
            "On {coordinated} of {} {name} is a coordinated plan. Each intersection was simulated alone: such a plan \
             keeps its cycle but gets no progression, so what is gained over it may be too much.",
            format::count(points.len(), "point MDP")
        )
    })
}
