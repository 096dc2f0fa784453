//! What of the plans that signals have today is not as standards want it, without simulation: `audit.csv`, and a table on the
//! page.
//!
//! - **Yellow and all-red**: ITE's kinematic formula at the speed limit, for left turns too; yellow is 3 to 6 s. What a yellow
//!   is longer counts as all-red.
//! - **Walk and clearance**: at least 7 s; 3.5 ft/s over the crosswalk, also during yellow and all-red. Crosswalks belong to
//!   phases as in the simulation.
//! - **Splits** of plans with a cycle hold the shortest green, and walk and clearance, each with yellow and all-red. Where there
//!   is none, a call prolongs the green.
//! - **Volume to capacity**: the simulated volumes, by the greens of the plan if each phase lasts its split.
//!
//! Source: ITE (2020); MUTCD (2009), section 4E.06; Signal Timing Manual (2nd ed.), chapters 4 to 6; HCM (6th ed.), chapter 19.

use std::collections::BTreeSet;

use basics::units::{FOOT_M, KMH_TO_MPH};
use minijinja::{Value, context};
use osm_signals::Turn;
use osm_signals::angle::turn_degrees;

use super::capacity::Basis;
use super::movements::basis;
use super::plans::told::{Told, given_plan};
use super::shown::Seen;
use evaluation::report::format;
use evaluation::report::table::{Cell, Columns, Table};
use signals::control::existing;
use signals::existing::{Control, ExistingPlan, PlanPhase};
use signals::movement_results::{MovementResult, supplied};
use signals::places::{DrawnArm, DrawnIntersection};
use signals::settings::SignalSettings;
use signals::timing::{Timing, WALK_S, WALKING_MPS};
use signals::vocabulary::Heading;

/// Name of the table in the report's folder.
pub(crate) const TABLE: &str = "audit.csv";

/// Most rows of the table on the page.
const ROWS: usize = 50;

/// How far a time may be below what is required, seconds: cabinets have tenths.
const SLACK_S: f64 = 0.05;

/// Shortest and longest yellow, seconds (MUTCD, section 4D.26).
const YELLOW_S: [f64; 2] = [3.0, 6.0];

/// Volume to capacity above which counts or plan are not plausible.
pub(crate) const IMPLAUSIBLE: f64 = 1.2;

/// Angle from which approaches are opposite, degrees.
const OPPOSITE_DEG: f64 = 150.0;

/// Something that is not as it should be.
#[derive(Debug, Clone, PartialEq)]
struct Finding {
    what: String,
    value: f64,
    required: f64,
    unit: &'static str,
    source: &'static str,
}

/// A plan at its intersection.
struct Placed<'a> {
    plan: &'a ExistingPlan,
    drawn: &'a DrawnIntersection,
    timing: Timing,
    /// Per phase the state in which its links are green.
    states: Vec<String>,
}

impl<'a> Placed<'a> {
    fn new(plan: &'a ExistingPlan, drawn: &'a DrawnIntersection, limits: &SignalSettings) -> Self {
        Self { plan, drawn, timing: drawn.timing(limits), states: drawn.states(plan) }
    }

    /// Returns what is wrong with times and right of way.
    fn findings(&self) -> Vec<Finding> {
        let (mut found, count) = (Vec::new(), self.drawn.incoming().count());
        let crosswalks = self.plan.crosswalks(&self.timing, &self.states, count);
        let changes = self.states.iter().zip(self.plan.after(&self.states));
        let phases = self.plan.phases.iter().zip(changes).zip(crosswalks);
        for ((phase, (state, after)), crosswalk) in phases {
            let mut add = |what: String, value: f64, required: f64, source| {
                let what = format!("phase {}: {what}", phase.number);
                if value + SLACK_S < required {
                    found.push(Finding { what, value, required, unit: "s", source });
                }
            };
            let PlanPhase { yellow_s, all_red_s, min_green_s, .. } = *phase;
            // A phase without a yellow ends nothing, and what goes on in the next one needs none.
            let (mut least_yellow_s, mut least_red_s, mut mph) = (0.0_f64, 0.0_f64, 0.0_f64);
            for approach in self.timing.ending(state, &after).filter(|_| yellow_s > 0.0) {
                let [own_s, red_s] = self.timing.kinematic_s(approach);
                let own_s = own_s.clamp(YELLOW_S[0], YELLOW_S[1]);
                least_yellow_s = least_yellow_s.max(own_s);
                least_red_s = least_red_s.max(red_s - (yellow_s - own_s).max(0.0));
                mph = self.drawn.incoming().nth(approach).map_or(mph, |arm| mph.max(arm.speed_mph));
            }
            let at = format!("at {mph:.0} mph ({:.0} km/h)", mph / KMH_TO_MPH);
            add(format!("yellow {at}"), yellow_s, least_yellow_s, "ITE");
            add(format!("all-red {at}"), all_red_s, least_red_s, "ITE");
            let change_s = yellow_s + all_red_s;
            let [walk_s, clearance_s] = phase.walk_s.unwrap_or_default();
            if phase.walk_s.is_some() {
                add("walk".to_owned(), walk_s, WALK_S.into(), "MUTCD: 7 s, in some cases 4 s");
            }
            if let Some(length_m) = crosswalk.map(|c| self.timing.crosswalk_m(c)) {
                let over = format!("{:.0} ft ({length_m:.1} m)", length_m / FOOT_M);
                let what = format!("clearance, yellow and all-red over {over}");
                add(what, clearance_s + change_s, length_m / WALKING_MPS, "MUTCD: 3.5 ft/s");
            }
            let (with, least_s) = match walk_s + clearance_s > min_green_s {
                true => ("walk, clearance", walk_s + clearance_s),
                false => ("shortest green", min_green_s),
            };
            if self.plan.control != Control::Actuated {
                let source = "Signal Timing Manual, chapter 6";
                let what = format!("split with {with}, yellow and all-red");
                add(what, phase.split_s(), least_s + change_s, source);
            }
            found.extend(phase.yielding.iter().filter_map(|name| self.unprotected(phase, name)));
        }
        found
    }

    /// Returns a turn of several lanes that yields to opposing traffic.
    fn unprotected(&self, phase: &PlanPhase, name: &str) -> Option<Finding> {
        let side = self.drawn.side();
        let ((across, letter), _) = side.swapped(((Turn::Left, 'l'), (Turn::Right, 'r')));
        Heading::of_movement(name, side).filter(|(_, turn)| *turn == across)?;
        let ways = self.plan.ways.get(name)?;
        let from = |edge: &str| self.drawn.incoming().find(|arm| arm.edge == edge);
        let arm = ways.iter().find_map(|(edge, _)| from(edge))?;
        let off_deg = |other: &DrawnArm| turn_degrees(arm.bearing_deg, other.bearing_deg).abs();
        self.drawn.incoming().find(|other| off_deg(other) >= OPPOSITE_DEG)?;
        let value = arm.lanes.iter().filter(|lane| lane.contains(letter)).count() as f64;
        let what = format!("phase {}: lanes of {name} that yield", phase.number);
        let source = "Signal Timing Manual, chapter 4";
        (value > 1.0).then_some(Finding { what, value, required: 1.0, unit: "lanes", source })
    }

    /// Whether yellow and all-red, or walk and clearance, of a phase are shorter than those that other methods have to keep.
    fn is_shorter(&self) -> bool {
        let walk_s = |phase: &PlanPhase| phase.walk_s.unwrap_or_default().iter().sum::<f64>();
        let legal = self.plan.legal(&self.timing, &self.states).phases;
        self.plan.phases.iter().zip(&legal).any(|(own, legal)| {
            let mut times = own.change_s().into_iter().zip(legal.change_s());
            times.any(|(own, legal)| own + SLACK_S < legal) || walk_s(own) + 1.0 <= walk_s(legal)
        })
    }
}

/// Returns the ratio of volume to capacity of every lane group, with its movements.
fn of_groups(results: &[MovementResult], basis: Basis) -> Vec<(String, f64)> {
    let mut found: Vec<(String, f64)> = Vec::new();
    for (m, capacity) in results.iter().zip(basis.capacities(results)) {
        let Some((supply, capacity)) = m.supply.as_ref().zip(capacity) else { continue };
        if found.iter().all(|(group, _)| *group != supply.group) {
            found.push((supply.group.clone(), capacity.ratio));
        }
    }
    found
}

/// Returns the ratios of volume to capacity under a method: by the greens of the plan that it was given, else by those that
/// were shown; nothing where records do not say them.
pub(crate) fn ratios(seen: Seen<'_>, point: usize, method: usize) -> Vec<(String, f64)> {
    let identity = &seen.data.manifest.identity;
    let task = seen.shown.movements.iter().find(|t| (t.point, t.method) == (point, method));
    let Some((task, basis)) = task.zip(basis(seen.data)) else { return Vec::new() };
    match given_plan(&identity.points[point], &identity.methods[method]) {
        Some(plan) => of_groups(&supplied(&plan, &task.results), basis),
        None => of_groups(&task.results, basis),
    }
}

/// Returns the lane groups above capacity.
fn overloaded(ratios: Vec<(String, f64)>) -> impl Iterator<Item = Finding> {
    ratios.into_iter().filter(|(_, ratio)| *ratio > 1.0).map(|(group, value)| {
        let check = if value > IMPLAUSIBLE { ": check plan and counts first" } else { "" };
        let source = "Highway Capacity Manual, chapter 19";
        let what = format!("{group}: simulated volume to capacity by splits{check}");
        Finding { what, value, required: 1.0, unit: "", source }
    })
}

fn limits(seen: Seen<'_>) -> Option<SignalSettings> {
    let limits = seen.data.manifest.identity.settings.get("signal").cloned();
    serde_json::from_value(limits.unwrap_or_default()).ok()
}

/// Says what is wrong with times and right of way of a plan that reports tell; nothing where the arms are not known.
pub(crate) fn checks(seen: Seen<'_>, told: &Told) -> Vec<String> {
    let point = &seen.data.manifest.identity.points[told.point].point;
    let drawn = seen.shown.drawing(point).filter(|_| told.is_alone);
    let Some((limits, drawn)) = limits(seen).zip(drawn) else { return Vec::new() };
    let plan = ExistingPlan { ways: told.ways.clone(), ..told.given_back() };
    let said = |Finding { what, value, required, unit, source }: Finding| {
        let [value, required] = [value, required].map(|v| (100.0 * v).round() / 100.0);
        format!("{what}: {value} instead of {required} {unit} ({source})")
    };
    Placed::new(&plan, drawn, &limits).findings().into_iter().map(said).collect()
}

/// Returns [`checks`] in one line, each with all phases that it is of.
pub(crate) fn in_words(checks: &[String]) -> String {
    let mut all: Vec<(&str, String)> = Vec::new();
    for (phase, what) in checks.iter().filter_map(|check| check.split_once(": ")) {
        match all.iter_mut().find(|(other, _)| *other == what) {
            Some((_, phases)) => phases.push_str(&phase.replacen("phase", ",", 1)),
            None => all.push((what, phase.to_owned())),
        }
    }
    let said = all.iter().map(|(what, phases)| format!("{phases}: {what}"));
    said.collect::<Vec<_>>().join("; ")
}

/// Does something with the plan that a signal has today at every point MDP where it is known.
fn each<T>(seen: Seen<'_>, of: impl Fn(usize, &Placed<'_>) -> T) -> Vec<T> {
    let identity = &seen.data.manifest.identity;
    let Some(limits) = limits(seen) else { return Vec::new() };
    let at = |point: usize| {
        let plan = given_plan(&identity.points[point], existing::METHOD.name)?;
        let drawn = seen.shown.drawing(&identity.points[point].point)?;
        Some(of(point, &Placed::new(&plan, drawn, &limits)))
    };
    (0..seen.data.points.len()).filter_map(at).collect()
}

/// Returns what is wrong with the plans of today, with the point MDP.
fn all(seen: Seen<'_>) -> Vec<(usize, Finding)> {
    let methods = &seen.data.manifest.identity.methods;
    let method = methods.iter().position(|m| m == existing::METHOD.name);
    let of = |point: usize, placed: &Placed<'_>| {
        let ratios = method.map(|method| ratios(seen, point, method)).unwrap_or_default();
        let found = placed.findings().into_iter().chain(overloaded(ratios));
        found.map(|found| (point, found)).collect::<Vec<_>>()
    };
    each(seen, of).into_iter().flatten().collect()
}

/// Returns the table of findings on plans of today.
fn rows(seen: Seen<'_>, found: Vec<(usize, Finding)>) -> Table {
    let Seen { data, shown } = seen;
    let row = |point: usize| &data.points[point].row;
    let cell = |value: f64, unit: &str| {
        Cell::number(value, |v| format!("{} {unit}", format::score(v)).trim_end().to_owned())
    };
    Columns::new()
        .text("point", "", move |(point, _): &(usize, Finding)| row(*point).point.clone())
        .text("signal", "Signal", move |(point, _)| shown.title(row(*point)))
        .text("finding", "Finding", |(_, f)| f.what.clone())
        .column("value", "Value", move |(_, f)| cell(f.value, f.unit))
        .column("required", "Required", move |(_, f)| cell(f.required, f.unit))
        .text("unit", "", |(_, f)| f.unit.to_owned())
        .text("source", "Source", |(_, f)| f.source.to_owned())
        .table(found)
}

/// Returns the table.
pub(crate) fn table(seen: Seen<'_>) -> String {
    rows(seen, all(seen)).csv()
}

/// Returns the section; undefined where no plan of today is known.
pub(crate) fn values(seen: Seen<'_>) -> Option<Value> {
    let (mut found, plans) = (all(seen), shorter(seen).1);
    let wrong = found.iter().map(|(point, _)| point).collect::<BTreeSet<_>>().len();
    let count = found.len();
    found.truncate(ROWS);
    let table = rows(seen, found).html("What is shorter, or more, than required.");
    (plans > 0).then(|| context! { plans, wrong, count, rows => ROWS, table })
}

/// Returns at how many signals, of how many, what is done today has shorter clearances than other methods have to keep.
pub(crate) fn shorter(seen: Seen<'_>) -> (usize, usize) {
    let short = each(seen, |_, placed| placed.is_shorter());
    (short.iter().filter(|is| **is).count(), short.len())
}

#[cfg(test)]
mod tests {
    use osm_signals::DrivingSide;

    use super::super::capacity::tests::movement;
    use super::*;
    use signals::settings::ChangeInterval;

    /// A street of 40 mph with double left turns across one of 30 mph, signalled as the standards want it.
    const PLAN: &str = "\
        intersection,control,cycle_s,phase,ring,barrier,position,movements,yielding,min_green_s,max_green_s,yellow_s,all_red_s,walk_s,clearance_s
        7,pretimed,90,1,1,1,1,WBL,,5,9.7,4,1.3,,
        7,pretimed,90,2,1,1,2,EBT EBR,,10,34.7,4,1.3,7,14
        7,pretimed,90,4,1,2,1,NBT NBR,NBL,10,29.7,3.2,2.1,7,18
        7,pretimed,90,5,2,1,1,EBL,,5,9.7,4,1.3,,
        7,pretimed,90,6,2,1,2,WBT WBR,,10,34.7,4,1.3,7,14
        7,pretimed,90,8,2,2,1,SBT SBR,SBL,10,29.7,3.2,2.1,7,18
";

    type Lengthened = (Vec<String>, Option<f64>, Vec<f64>);

    /// Audits the plan with changes of some of its rows, and with some vehicles per hour. What is found in the plan with legal
    /// clearances comes second, with its cycle, and the splits of both rings before the barriers.
    fn audited(
        changes: &[(&str, &str)],
        [through_vph, left_vph]: [f64; 2],
    ) -> (Vec<String>, Lengthened) {
        let mut table = PLAN.replace("        ", "");
        for (from, to) in changes {
            assert!(table.contains(from), "{from}");
            table = table.replace(from, to);
        }
        let mut plan = signals::existing::read(&table, "plan.csv").unwrap().all.remove(0).plan;
        let arms = ["SB", "WB", "NB", "EB"];
        let arm = |k: usize| DrawnArm {
            edge: format!("in{k}"),
            bearing_deg: 90.0 * k as f64,
            lanes: [["rs", "s", "l"].as_slice(), &["rs", "s", "l", "l"]][k % 2]
                .iter()
                .map(|turns| (*turns).to_owned())
                .collect(),
            lanes_out: 2,
            speed_mph: [30.0, 40.0][k % 2],
            ..DrawnArm::default()
        };
        let arms_of = (0..4).map(arm).collect();
        let drawn = DrawnIntersection { arms: arms_of, ..DrawnIntersection::default() };
        for (k, name) in arms.iter().enumerate() {
            for (turn, to) in [("R", 3), ("T", 2), ("L", 1)] {
                let way = (format!("in{k}"), format!("out{}", (k + to) % 4));
                plan.ways.insert(format!("{name}{turn}"), vec![way]);
            }
        }
        let limits = SignalSettings {
            change_interval: ChangeInterval::Kinematic,
            pedestrians: true,
            lane_width_m: Some(3.66),
            ..Default::default()
        };
        let of = |(name, vehicles_veh, lanes): (&str, f64, u32)| MovementResult {
            from: plan.ways[name][0].0.clone(),
            to: plan.ways[name][0].1.clone(),
            ..movement(name, name, [lanes; 2], vehicles_veh, [0.0; 2])
        };
        let results = [("NBT", through_vph, 2), ("WBL", left_vph, 2)].map(of);
        let basis = Basis { saturation_vph: 1800.0, hours: 1.0, side: DrivingSide::Right };
        let ratios = of_groups(&supplied(&plan, &results), basis);
        let placed = Placed::new(&plan, &drawn, &limits);
        let said = |f: Finding| format!("{} {:.2} {:.2}", f.what, f.value, f.required);
        let found = placed.findings().into_iter().chain(overloaded(ratios)).map(said);
        let legal = plan.legal(&placed.timing, &placed.states);
        let split = |ring: &Vec<usize>| ring.iter().map(|p| legal.phases[*p].split_s()).sum();
        let splits = legal.sides().iter().flatten().map(split).map(|s: f64| s.round()).collect();
        let placed = Placed::new(&legal, &drawn, &limits);
        assert!(!placed.is_shorter());
        let in_legal = placed.findings().into_iter().map(said).collect();
        (found.collect(), (in_legal, legal.cycle_s, splits))
    }

    #[test]
    fn ten_planted_faults_are_found_and_none_besides() {
        assert_eq!(audited(&[], [1000.0, 300.0]).0, [""; 0]);
        let faults = [
            ("1,WBL,,5,9.7", "1,WBL,,12,9.7"),
            ("EBT EBR,,10,34.7,4,1.3", "EBT EBR,EBL,10,35.6,3,1.4"),
            ("9.7,3.2,2.1,7,18\n7,pretimed,90,5", "9.7,3.2,2.1,7,9\n7,pretimed,90,5"),
            ("EBL,,5,9.7,4,1.3", "EBL,,5,10.6,3,1.4"),
            ("WBR,,10,34.7,4,1.3,7,14", "WBR,,10,35.7,4,0.3,4,14"),
            ("8,2,2,1,SBT SBR,SBL,10,29.7", "8,2,2,1,SBT SBR,SBL,10,20.7"),
        ];
        // Yellow 1 + 17.88 / 6.1, all-red (18.3 + 6.1) / 17.88 less what yellow is longer; 6 lanes of 12 ft at 3.5 ft/s; 1,800
        // veh/h by two lanes and 29.7 or 9.7 of 90 s, left turns less 5%.
        let expected = [
            "phase 1: split with shortest green, yellow and all-red 15.00 17.30",
            "phase 2: yellow at 40 mph (64 km/h) 3.00 3.93",
            "phase 2: lanes of EBL that yield 2.00 1.00",
            "phase 4: clearance, yellow and all-red over 72 ft (22.0 m) 14.30 20.58",
            "phase 5: yellow at 40 mph (64 km/h) 3.00 3.93",
            "phase 6: all-red at 40 mph (64 km/h) 0.30 1.30",
            "phase 6: walk 4.00 7.00",
            "phase 8: split with walk, clearance, yellow and all-red 26.00 30.30",
            "NBT: simulated volume to capacity by splits: check plan and counts first 1.26 1.00",
            "WBL: simulated volume to capacity by splits 1.11 1.00",
        ];
        let (found, (in_legal, ..)) = audited(&faults, [1500.0, 410.0]);
        assert_eq!(found, expected);
        assert_eq!(in_legal, [expected[0], expected[2]], "what is no clearance stays");
    }

    #[test]
    fn legal_clearances_keep_the_cycle_where_walks_fit_into_it_and_make_it_longer_otherwise() {
        let vph = [0.0; 2];
        let short = [("29.7,3.2,2.1,7,18", "30.9,3.2,0.9,7,9")];
        assert_eq!(audited(&short, vph).1, (vec![], Some(90.0), vec![55.0, 55.0, 35.0, 35.0]));
        // 7 s and 22 m at 1.067 m/s are 28 s, with 0.7 s that stays beyond whole seconds and 5.3 s of change 34 s; so are 7 s and 18.3 m 31 s
        // beside a left turn of 5.7 and 5.3 s.
        let tight = [("29.7,3.2,2.1,7,18", "20.9,3.2,0.9,7,9"), ("pretimed,90", "pretimed,80")];
        assert_eq!(audited(&tight, vph).1, (vec![], Some(80.0), vec![46.0, 46.0, 34.0, 34.0]));
        let tighter = [tight[0], ("10,34.7,4", "10,16.7,4"), ("pretimed,90", "pretimed,62")];
        assert_eq!(audited(&tighter, vph).1, (vec![], Some(76.0), vec![42.0, 42.0, 34.0, 34.0]));
    }
}
