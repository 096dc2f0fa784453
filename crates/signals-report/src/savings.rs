//! What each signal would save against what it does today, by the best method that a cabinet can be told: `signals.csv`, and the
//! first table of the page.
//!
//! Periods of an intersection are point MDPs of their own and stand in one row, which has one method for all of them. Intervals
//! are Student's, over evaluation seeds, with the same vehicles for both methods; they contain no error of the model.
//!
//! Half of the seeds choose the method, and the others measure what it saves, in all ways to divide them, as
//! [`of_best`] does. With one or two seeds those that choose measure, too, which is said.

use minijinja::{Value, context};

use super::answers::today;
use super::audit::{IMPLAUSIBLE, checks, ratios, shorter};
use super::demand::{HOUR_S, horizon_s, span};
use super::level_of_service::{DELAY, letter};
use super::plans::told::{Told, best};
use super::shown::Seen;
use evaluation::analysis::{Analysis, of_best};
use evaluation::report::format;
use evaluation::report::table::{Cell, Columns};
use evaluation::stats::score::mean;
use evaluation::stats::{Direction, mean_interval};
use signals::control::retime;
use signals::family::load::id_of_intersection;
use signals::places::DrawnIntersection;

/// Name of the table in the report's folder.
pub(super) const TABLE: &str = "signals.csv";

/// Name of the folder with a page per intersection, and how many have one at most.
pub(super) const FOLDER: &str = "intersections";
pub(super) const MOST_PAGES: usize = 500;

/// Most rows of the table on the page.
const ROWS: usize = 40;

/// An intersection with the positions of its point MDPs, one per period.
pub(super) struct Page<'a> {
    pub(super) name: String,
    pub(super) periods: Vec<(usize, &'a DrawnIntersection)>,
}

/// Returns the intersections with arms of their own.
pub(super) fn intersections(seen: Seen<'_>) -> Vec<Page<'_>> {
    let Seen { data, shown } = seen;
    let mut pages: Vec<(&str, Page<'_>)> = Vec::new();
    if data.manifest.identity.objective != DELAY {
        return Vec::new();
    }
    for drawn in &shown.places.drawings {
        let Some(point) = data.position(&drawn.point) else { continue };
        let own = pages.iter_mut().find(|(id, _)| *id == drawn.intersection);
        match own.filter(|_| !drawn.period.is_empty()) {
            Some((_, page)) => page.periods.push((point, drawn)),
            None => {
                let stem = match drawn.period.as_str() {
                    "" => drawn.point.clone(),
                    _ => id_of_intersection(&drawn.intersection),
                };
                let page = Page { name: format!("{stem}.html"), periods: vec![(point, drawn)] };
                pages.push((&drawn.intersection, page));
            }
        }
    }
    pages.into_iter().map(|(_, page)| page).collect()
}

impl Page<'_> {
    /// Returns what the intersection is called, without its period.
    pub(super) fn title(&self, Seen { data, shown }: Seen<'_>) -> String {
        let (point, drawn) = self.periods[0];
        let title = shown.title(&data.points[point].row);
        title.strip_suffix(&format!(", {}", drawn.period)).unwrap_or(&title).to_owned()
    }
}

/// Returns the hours of the year that a period has, where the scenario says it.
pub(super) fn hours(data: &Analysis, drawn: &DrawnIntersection) -> Option<f64> {
    let periods = data.manifest.identity.settings.pointer("/family/periods")?;
    periods.get(&drawn.period)?.as_f64()
}

/// Returns the mean of values and half the width of its interval; no width for a single one.
pub(super) fn interval(values: &[f64]) -> Option<(f64, Option<f64>)> {
    let (middle, low, high) = mean_interval(values)?;
    Some((middle, (values.len() > 1).then_some((high - low) / 2.0)))
}

/// Returns the delay of a method by evaluation seed, over its trainings.
pub(super) fn by_seed(data: &Analysis, point: usize, method: usize) -> Option<Vec<f64>> {
    let all = &data.points[point].results[method].as_ref()?.objectives.as_ref()?.method;
    let seeds = all.first()?.len();
    (0..seeds)
        .map(|s| mean(&all.iter().filter_map(|r| r.get(s).copied()).collect::<Vec<_>>()))
        .collect()
}

/// What a signal would save; methods are positions in the manifest.
pub(super) struct Saving<'a> {
    pub(super) page: &'a Page<'a>,
    /// What is done today, or else the reference of the scores.
    pub(super) against: usize,
    /// The best that a cabinet can be told.
    pub(super) method: usize,
    /// Vehicle-hours per evaluation seed, or group of seeds.
    pub(super) saved_h: Vec<f64>,
    /// Mean delays per vehicle before and after, seconds.
    delays_s: [f64; 2],
    /// Volume to capacity before, where it is highest, with the movements there.
    highest: Option<(String, f64)>,
    /// What the audit finds in its plans.
    findings: usize,
}

impl Saving<'_> {
    fn is_marked(&self) -> bool {
        self.highest.as_ref().is_some_and(|(_, ratio)| *ratio > IMPLAUSIBLE)
    }
}

/// Says vehicle-hours with half the width of their interval.
pub(super) fn hours_in_words(saved_h: &[f64]) -> String {
    let Some((middle, half)) = interval(saved_h) else { return "-".to_owned() };
    let sign = if middle <= -0.05 { "\u{2212}" } else { "" };
    let half = half.map_or_else(String::new, |half| format!(" \u{b1} {}", format::thousands(half)));
    format!("{sign}{}{half}", format::thousands(middle.abs()))
}

/// Whether the hours of the year of all periods are known.
fn is_yearly(data: &Analysis, pages: &[Page<'_>]) -> bool {
    let mut drawn = pages.iter().flat_map(|page| &page.periods);
    horizon_s(&data.manifest.identity).is_some() && drawn.all(|(_, d)| hours(data, d).is_some())
}

/// Returns the vehicle-hours of a method per evaluation seed, and the vehicles; `None` without a result of every seed.
fn cost(data: &Analysis, page: &Page<'_>, method: usize, yearly: bool) -> Option<(Vec<f64>, f64)> {
    let identity = &data.manifest.identity;
    let (mut sums_h, mut vehicles) = (vec![0.0; identity.evaluation_seeds.len()], 0.0);
    for (point, drawn) in &page.periods {
        let times = if yearly { hours(data, drawn)? * HOUR_S / horizon_s(identity)? } else { 1.0 };
        let metrics = &data.points[*point].results[method].as_ref()?.metrics;
        let own = metrics.get("vehicles_veh")? * times;
        let delays_s = by_seed(data, *point, method).filter(|all| all.len() == sums_h.len())?;
        sums_h.iter_mut().zip(delays_s).for_each(|(sum, delay_s)| *sum += own * delay_s / HOUR_S);
        vehicles += own;
    }
    (vehicles > 0.0).then_some((sums_h, vehicles))
}

/// Returns what an intersection would save; `None` without results of two methods that can be compared.
fn saving<'a>(
    seen: Seen<'_>,
    page: &'a Page<'a>,
    plans: &[Told],
    yearly: bool,
) -> Option<Saving<'a>> {
    let data = seen.data;
    let methods = &data.manifest.identity.methods;
    let today = today(data).and_then(|name| methods.iter().position(|m| m == name));
    let of = |method: usize| Some((method, cost(data, page, method, yearly)?));
    let before = [today, data.reference.index].into_iter().flatten().find_map(of)?;
    let has_plan = |method: &usize| {
        let has = |point: usize| plans.iter().any(|t| (t.point, t.method) == (point, *method));
        page.periods.iter().all(|(point, _)| has(*point))
    };
    let told = (0..methods.len()).filter(|m| *m != before.0 && has_plan(m)).filter_map(of);
    let sum = |cost: &(usize, (Vec<f64>, f64))| cost.1.0.iter().sum::<f64>();
    let all: Vec<_> = std::iter::once(before.clone()).chain(told).collect();
    let after = all.iter().min_by(|a, b| sum(a).total_cmp(&sum(b)))?;
    let saved_h = |cost: &(usize, (Vec<f64>, f64))| -> Vec<f64> {
        before.1.0.iter().zip(&cost.1.0).map(|(a, b)| a - b).collect()
    };
    let measured = of_best(&all.iter().map(saved_h).collect::<Vec<_>>(), Direction::Higher);
    let mean_s = |cost: &(usize, (Vec<f64>, f64))| Some(mean(&cost.1.0)? * HOUR_S / cost.1.1);
    let delays_s = [mean_s(&before)?, mean_s(after)?];
    let saved_h = measured.unwrap_or_else(|| saved_h(after));
    let ratios = page.periods.iter().flat_map(|(point, _)| ratios(seen, *point, before.0));
    let highest = ratios.max_by(|a, b| a.1.total_cmp(&b.1));
    let own = |t: &&Told| t.method == after.0 && page.periods.iter().any(|(p, _)| t.point == *p);
    let findings = plans.iter().filter(own).map(|told| checks(seen, told).len()).sum();
    Some(Saving { page, against: before.0, method: after.0, saved_h, delays_s, highest, findings })
}

/// Returns what all intersections would save, the most first.
pub(super) fn savings<'a>(seen: Seen<'_>, pages: &'a [Page<'a>]) -> Vec<Saving<'a>> {
    let (plans, yearly) = (best(seen), is_yearly(seen.data, pages));
    let mut all: Vec<Saving<'_>> =
        pages.iter().filter_map(|page| saving(seen, page, &plans, yearly)).collect();
    let sum = |saving: &Saving<'_>| saving.saved_h.iter().sum::<f64>();
    all.sort_by(|a, b| sum(b).total_cmp(&sum(a)));
    all
}

/// Returns how many intersections are compared with a method, and what they would save together by evaluation seed.
fn sums(all: &[Saving<'_>], against: usize, with_marked: bool) -> (usize, Vec<f64>) {
    let is_in = |s: &&Saving<'_>| s.against == against && (with_marked || !s.is_marked());
    let own: Vec<&Saving<'_>> = all.iter().filter(is_in).collect();
    let seeds = own.first().map_or(0, |s| s.saved_h.len());
    (own.len(), (0..seeds).map(|k| own.iter().map(|s| s.saved_h[k]).sum()).collect())
}

/// Returns what vehicle-hours are counted over.
pub(super) fn per(data: &Analysis, pages: &[Page<'_>]) -> String {
    let simulated = || horizon_s(&data.manifest.identity).map_or("time".to_owned(), span);
    if is_yearly(data, pages) { "year".to_owned() } else { format!("simulated {}", simulated()) }
}

/// Returns the table.
pub(super) fn table(seen: Seen<'_>) -> String {
    let data = seen.data;
    let (methods, pages) = (&data.manifest.identity.methods, intersections(seen));
    let per = per(data, &pages);
    let end =
        |s: &Saving<'_>, sign: f64| interval(&s.saved_h).and_then(|i| Some(i.0 + sign * i.1?));
    let delay = |i: usize| move |s: &Saving<'_>| Cell::exact(s.delays_s[i]);
    let level = |i: usize| move |s: &Saving<'_>| letter(s.delays_s[i]).to_string();
    Columns::new()
        .text("intersection", "", |s: &Saving<'_>| s.page.periods[0].1.intersection.clone())
        .text("title", "", |s| s.page.title(seen))
        .text("against", "", |s| methods[s.against].clone())
        .text("method", "", |s| methods[s.method].clone())
        .file("saved_vehicle_hours", |s| Cell::exact(interval(&s.saved_h).map(|i| i.0)))
        .file("saved_low", |s| Cell::exact(end(s, -1.0)))
        .file("saved_high", |s| Cell::exact(end(s, 1.0)))
        .text("per", "", |_| per.clone())
        .file("against_delay_s", delay(0))
        .file("delay_s", delay(1))
        .text("against_level_of_service", "", level(0))
        .text("level_of_service", "", level(1))
        .file("v_c", |s| Cell::exact(s.highest.as_ref().map(|h| h.1).filter(|v| v.is_finite())))
        .text("lane_group", "", |s| s.highest.as_ref().map(|h| h.0.clone()).unwrap_or_default())
        .file("check_first", |s| Cell::flag(Some(s.is_marked())))
        .file("plan_findings", |s| Cell::count(s.findings))
        .table(savings(seen, &pages))
        .csv()
}

/// Returns the section; undefined without intersections that have results.
pub(super) fn values(seen: Seen<'_>) -> Option<Value> {
    let data = seen.data;
    let pages = intersections(seen);
    let (methods, all) = (&data.manifest.identity.methods, savings(seen, &pages));
    let today = today(data).and_then(|name| methods.iter().position(|m| m == name));
    // Sums are against one method.
    let main =
        today.filter(|t| all.iter().any(|s| s.against == *t)).or(Some(all.first()?.against))?;
    let called = |method: usize| match Some(method) != today && data.reference.is_baseline {
        true => format!("the untuned plan ({})", methods[method]),
        false => methods[method].clone(),
    };
    let row = |s: &Saving<'_>| {
        let [before, after] = s.delays_s;
        context! {
            title => s.page.title(seen),
            page => (pages.len() <= MOST_PAGES).then(|| format!("{FOLDER}/{}", s.page.name)),
            hours => hours_in_words(&s.saved_h),
            delay => format!("{before:.1} \u{2192} {after:.1}"),
            level => format!("{} \u{2192} {}", letter(before), letter(after)),
            method => methods[s.method].clone(),
            stays => s.method == s.against,
            against => (s.against != main).then(|| called(s.against)),
            group => s.highest.as_ref().map(|h| h.0.clone()),
            ratio => s.highest.as_ref().map(|h| format!("{:.2}", h.1)),
            marked => s.is_marked(),
            findings => (s.findings > 0).then(|| format::count(s.findings, "finding")),
        }
    };
    let sum = |with_marked: bool| {
        let (count, sums) = sums(&all, main, with_marked);
        context! { count, hours => hours_in_words(&sums) }
    };
    let deciding = (0..methods.len()).filter(|m| {
        let wins = data.winners.iter().flatten().any(|w| w.best == *m);
        wins && all.iter().all(|s| s.method != *m)
    });
    Some(context! {
        rows => all.iter().take(ROWS).map(row).collect::<Vec<_>>(),
        count => all.len(),
        without => pages.len() - all.len(),
        whole => sum(true),
        unmarked => sum(false),
        marked => all.iter().filter(|s| s.is_marked()).count(),
        against => called(main),
        is_today => Some(main) == today,
        per => per(data, &pages),
        halves => data.manifest.identity.evaluation_seeds.len() >= 3,
        retimes => methods.iter().any(|m| m == retime::METHOD.name),
        legal => data.manifest.identity.settings.pointer("/retime/legal_clearances").is_some(),
        deciding => deciding.map(|m| methods[m].clone()).collect::<Vec<_>>().join(", "),
        shorter => shorter(seen).0,
        plans => shorter(seen).1,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_is_student_s_and_a_single_seed_has_none() {
        assert_eq!(interval(&[3.0]), Some((3.0, None)));
        // A standard deviation of 1, an error of 1 / sqrt(3), Student's quantile for 2 degrees of freedom.
        let (middle, half) = interval(&[1.0, 2.0, 3.0]).unwrap();
        let expected = 4.302_652_73 / 3.0_f64.sqrt();
        assert!((middle - 2.0).abs() < 1e-12 && (half.unwrap() - expected).abs() < 1e-7);
        assert_eq!(interval(&[]), None);
        assert_eq!(hours_in_words(&[-1.0, -2.0, -3.0]), "\u{2212}2.0 \u{b1} 2.5");
    }

    #[test]
    fn what_is_above_1_2_of_capacity_is_marked_and_left_out_of_the_second_sum() {
        let page = Page { name: String::new(), periods: Vec::new() };
        let saving = |against: usize, saved_h: [f64; 2], ratio: Option<f64>| Saving {
            page: &page,
            against,
            method: 2,
            saved_h: saved_h.to_vec(),
            delays_s: [30.0, 20.0],
            highest: ratio.map(|ratio| ("NBT".to_owned(), ratio)),
            findings: 0,
        };
        let all = [
            saving(0, [1.0, 2.0], Some(1.2)),
            saving(0, [30.0, 50.0], Some(1.21)),
            saving(0, [-4.0, -5.0], None),
            saving(0, [7.0, 9.0], Some(f64::INFINITY)),
            // Compared with another method, it is in neither sum.
            saving(1, [100.0, 100.0], Some(0.5)),
        ];
        let marked: Vec<bool> = all.iter().map(Saving::is_marked).collect();
        assert_eq!(marked, [false, true, false, true, false]);
        assert_eq!(sums(&all, 0, true), (4, vec![34.0, 56.0]));
        assert_eq!(sums(&all, 0, false), (2, vec![-3.0, -3.0]));
        assert_eq!(sums(&all, 2, true), (0, vec![]));
    }
}
