//! `check --submission`: whether records that somebody submits are what the method measured, as far as that can be told.
//!
//! Hashes prove nothing here, since whoever makes records makes their hashes. Seeds and vehicles follow from the manifest and
//! the networks, and a random part of the tasks is done again: who forges one record in twenty is found out by 2% of a thousand
//! tasks with a probability of 64%, and by another seed of another reader again.

use std::collections::{BTreeMap, BTreeSet};
use std::hash::{BuildHasher, Hasher, RandomState};
use std::path::Path;
use std::sync::atomic::Ordering;
use std::thread::available_parallelism;

use serde_json::json;

use super::CheckArgs;
use crate::analysis::joined::{Known, Source, join};
use crate::cli::exit;
use crate::cli::interrupt::interrupted;
use crate::cli::output::{line, note};
use crate::domains;
use crate::report::format;
use crate::run::domain::{Domain, domain_of};
use crate::run::executor::Event;
use crate::run::plan::{Change, establish, evaluation_seeds};
use crate::run::session::reopen;
use crate::run::worker::check_own;
use crate::seed;
use crate::store::Layout;
use crate::store::manifest::{Identity, PointRow, Task};
use crate::store::own::OwnKind;
use crate::store::record::{Outcome, Record, RowKind, mean_metrics};
use crate::store::results::Results;
use crate::traffic::domain::Traffic;
use crate::traffic::simulator;

/// Share of the tasks that are done again, per cent.
const RESIMULATED_PERCENT: f64 = 2.0;

/// Largest relative difference of two means of the same numbers.
const ROUNDING: f64 = 1e-9;

/// Largest seed that every JSON reader keeps exactly.
const SEED_BITS: u32 = 53;

/// Most findings of a kind that are said one by one.
const MOST_SAID: usize = 10;

/// What became of a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Verdict {
    Verified,
    Wrong,
    NotVerified,
}

impl Verdict {
    fn words(self) -> &'static str {
        match self {
            Self::Verified => "verified",
            Self::Wrong => "wrong",
            Self::NotVerified => "not verified",
        }
    }
}

/// What is said of a submission: the verdict, of what, and in words.
struct Findings(Vec<(Verdict, &'static str, String)>);

impl Findings {
    /// Adds what is wrong of something, or that nothing is.
    fn add(&mut self, what: &'static str, wrong: Vec<String>, verified: String) {
        if wrong.is_empty() {
            self.0.push((Verdict::Verified, what, verified));
            return;
        }
        let more = wrong.len().saturating_sub(MOST_SAID);
        self.0.extend(wrong.into_iter().take(MOST_SAID).map(|w| (Verdict::Wrong, what, w)));
        if more > 0 {
            self.0.push((Verdict::Wrong, what, format!("and {more} more")));
        }
    }

    fn not(&mut self, what: &'static str, why: String) {
        self.0.push((Verdict::NotVerified, what, why));
    }
}

/// Verifies a submission whose files are whole, says what was verified and what was not, and returns the exit code: of
/// something wrong, else of an interruption.
///
/// # Arguments
///
/// * `prepared` — folder of the networks.
pub(super) fn verify(layout: &Layout, prepared: &Path, args: &CheckArgs) -> anyhow::Result<u8> {
    let results = Results::load_all(layout)?;
    let identity = &results.manifest.identity;
    let domains = domains::domains();
    let domain = domain_of(&domains, layout, identity)?;
    let mut findings = Findings(Vec::new());
    let records = results.done().count();
    findings.add(
        "hashes",
        Vec::new(),
        format!("{records} records are whole and of this manifest, and the plan follows from it"),
    );
    // Of a run that stopped at a look, what that look has.
    let so_far = results.clone().so_far();
    let sample = &so_far.manifest.identity.sample;
    let looks = sample.growth.as_ref().map_or(0, |growth| growth.looks.len());
    let of_look = sample.look().map(|look| format!(" of look {} of {looks}", look + 1));
    let tasks = format!("{} tasks{}", so_far.plan().len(), of_look.unwrap_or_default());
    let lacking = |what: &str, n: usize| (n > 0).then(|| format!("{n} of {tasks} {what}"));
    let lacking = [
        lacking("have no record", so_far.missing().count()),
        lacking("failed", so_far.failed().count()),
    ];
    findings.add(
        "completeness",
        lacking.into_iter().flatten().collect(),
        format!("all {tasks} have a record, and none failed"),
    );
    seeds(&results, &mut findings);
    means(&results, &mut findings);
    vehicles(domain, &results, prepared, &mut findings)?;
    match &args.published {
        Some(published) => family(domain, results.clone(), layout, published, &mut findings)?,
        None => findings.not(
            "family",
            "whether the point MDPs, their importance and the baseline are those of a published run; give it with --published DIR"
                .to_owned(),
        ),
    }
    let is_whole = resimulate(layout, prepared, (&results, &so_far), args, &mut findings)?;
    let mut wrong = false;
    for (verdict, what, text) in &findings.0 {
        wrong |= *verdict == Verdict::Wrong;
        let verdict = verdict.words();
        match args.json {
            true => line(
                json!({"event": "submission", "what": what, "verdict": verdict, "text": text}),
            )?,
            false => line(format_args!("{verdict}: {what}: {text}"))?,
        }
    }
    Ok(match (wrong, is_whole) {
        (true, _) => exit::USAGE,
        (false, false) => exit::INTERRUPTED,
        (false, true) => exit::DONE,
    })
}

/// Returns the tasks that ended well, with their point MDPs.
fn finished(results: &Results) -> impl Iterator<Item = (&Task, &Record, &PointRow)> {
    let points: BTreeMap<&str, &PointRow> =
        results.manifest.identity.points.iter().map(|row| (row.point.as_str(), row)).collect();
    results
        .done()
        .filter(|(_, record)| record.summary.outcome == Outcome::Ok)
        .filter_map(move |(task, record)| Some((task, record, *points.get(task.point.as_str())?)))
}

/// Returns how messages name a task.
fn named(task: &Task) -> String {
    let training = match task.replicate {
        0 => String::new(),
        replicate => format!(", training {}", replicate + 1),
    };
    format!("task {} ({} on {}{training})", task.task, task.method, task.point)
}

/// Checks that episodes have the seeds that follow from the manifest, and that nothing was trained on evaluation seeds.
fn seeds(results: &Results, findings: &mut Findings) {
    let identity = &results.manifest.identity;
    let (mut wrong, mut episodes) = (Vec::new(), 0);
    for (task, record, point) in finished(results) {
        let expected = point.evaluation_seeds(&identity.evaluation_seeds);
        let found: Vec<u64> = record.evaluations().map(|row| row.seed).collect();
        episodes += found.len();
        if found != expected {
            let at = found.iter().zip(&expected).position(|(a, b)| a != b);
            wrong.push(match at {
                Some(k) => format!(
                    "{}: evaluation episode {k} has the seed {}, and the manifest's is {}",
                    named(task),
                    found[k],
                    expected[k]
                ),
                None => format!(
                    "{}: it has {} evaluation episodes, and the manifest has {} seeds",
                    named(task),
                    found.len(),
                    expected.len()
                ),
            });
        }
        let learns = |kind: RowKind| matches!(kind, RowKind::Training | RowKind::Validation);
        let seen = record.rows.iter().find(|row| learns(row.kind) && seed::is_evaluation(row.seed));
        wrong.extend(seen.map(|row| {
            format!("{}: it was trained on the evaluation seed {}", named(task), row.seed)
        }));
    }
    findings.add(
        "seeds",
        wrong,
        format!("{episodes} evaluation episodes have the manifest's seeds, and no training has one of them"),
    );
    let derived = evaluation_seeds(identity.base_seed, identity.evaluation_seeds.len() as u32);
    if identity.evaluation_seeds != derived {
        findings.not(
            "choice of seeds",
            format!(
                "the evaluation seeds do not follow from --seed {}: they were given with --seeds, so they may have been chosen",
                identity.base_seed
            ),
        );
    }
}

/// Checks that summaries are the means of their episodes.
fn means(results: &Results, findings: &mut Findings) {
    let (mut wrong, mut records) = (Vec::new(), 0);
    for (task, record, _) in finished(results) {
        records += 1;
        let is_other = |(name, mean): &(String, f64)| {
            let said = record.summary.metrics.get(name);
            said.is_none_or(|said| (said - mean).abs() > ROUNDING * mean.abs().max(1.0))
        };
        if let Some((name, mean)) = mean_metrics(&record.rows).into_iter().find(is_other) {
            let said = record.summary.metrics.get(&name).copied().unwrap_or(f64::NAN);
            wrong.push(format!(
                "{}: its {name} is {said}, and the mean of its episodes {mean}",
                named(task)
            ));
        }
    }
    findings.add("means", wrong, format!("{records} summaries are the means of their episodes"));
}

/// Checks that episodes have as many vehicles as their seeds give on the networks.
fn vehicles(
    domain: &dyn Domain,
    results: &Results,
    prepared: &Path,
    findings: &mut Findings,
) -> anyhow::Result<()> {
    let (mut wrong, mut episodes) = (Vec::new(), 0);
    let mut known: BTreeMap<(&str, u64), Option<(&'static str, f64)>> = BTreeMap::new();
    let spoilt =
        results.manifest.identity.points.iter().flat_map(|row| domain.spoilt(row, prepared));
    if let Some(first) = spoilt.into_iter().next() {
        findings.not(
            "vehicles",
            format!(
                "the networks are not those of the manifest ({} is missing or another one); build them with build-networks and \
                 say with --networks where they are",
                first.path.display()
            ),
        );
        return Ok(());
    }
    for (task, record, point) in finished(results) {
        for row in record.evaluations() {
            let key = (point.point.as_str(), row.seed);
            let expected = match known.get(&key) {
                Some(expected) => *expected,
                None => {
                    *known.entry(key).or_insert(domain.episode_extent(point, prepared, row.seed)?)
                }
            };
            let Some((metric, expected)) = expected else { continue };
            let Some(found) = row.metrics.get(metric) else { continue };
            episodes += 1;
            if *found != expected {
                wrong.push(format!(
                    "{}: {metric} is {found} in the episode with seed {}, and that seed has {expected}",
                    named(task),
                    row.seed
                ));
            }
        }
    }
    match episodes {
        0 => findings.not("vehicles", format!("{} says nothing of episodes that follows from their seeds", domain.name())),
        _ => findings.add(
            "vehicles",
            wrong,
            format!("{episodes} episodes have as many vehicles as their seeds give on the networks of the manifest"),
        ),
    }
    Ok(())
}

/// Checks that a run is of the family of a published one, with the same baseline.
fn family(
    domain: &dyn Domain,
    results: Results,
    layout: &Layout,
    published: &Path,
    findings: &mut Findings,
) -> anyhow::Result<()> {
    let baseline = results.manifest.identity.baseline.clone();
    let of_published = Results::load(&Layout::new(published))?;
    let methods: Vec<&str> = domain.methods().iter().map(|m| m.name).collect();
    let known = Known { methods: &methods, episodes: domain.episode_sections() };
    let submitted = layout.root().display().to_string();
    let sources =
        Source::named(vec![(published.display().to_string(), of_published), (submitted, results)]);
    let shown = published.display();
    match join(sources, known) {
        Err(e) => findings.add("family", vec![e.to_string()], String::new()),
        Ok(joined) => {
            let differs = joined.apart.iter().find(|(method, _)| *method == baseline);
            let wrong = differs.map(|(method, _)| {
                format!(
                    "the records of {method} are not those of {shown}: {}",
                    joined.differences.join("; ")
                )
            });
            findings.add(
                "family",
                wrong.into_iter().collect(),
                format!("point MDPs, importance, seeds and the records of the baseline are those of {shown}"),
            );
        }
    }
    Ok(())
}

/// Does a random part of the tasks again and compares the records; returns `false` when it was interrupted.
///
/// # Arguments
///
/// * `so_far` — the results that count, of which the part is.
fn resimulate(
    layout: &Layout,
    prepared: &Path,
    (results, so_far): (&Results, &Results),
    args: &CheckArgs,
    findings: &mut Findings,
) -> anyhow::Result<bool> {
    const WHAT: &str = "re-simulation";
    let (manifest, identity) = (&results.manifest, &results.manifest.identity);
    if let Some(why) = another_measure(identity) {
        findings.not(WHAT, why);
        return Ok(true);
    }
    let domains = domains::domains();
    let domain = domain_of(&domains, layout, identity)?;
    if identity.points.iter().any(|row| !domain.spoilt(row, prepared).is_empty()) {
        findings.not(WHAT, "the networks are not there (see vehicles)".to_owned());
        return Ok(true);
    }
    let random = || RandomState::new().build_hasher().finish() >> (u64::BITS - SEED_BITS);
    let sample_seed = args.sample_seed.unwrap_or_else(random);
    let mut drawn: Vec<&Task> = finished(so_far).map(|(task, ..)| task).collect();
    let percent = args.resimulate.unwrap_or(RESIMULATED_PERCENT);
    let count = ((drawn.len() as f64 * percent / 100.0).ceil() as usize).min(drawn.len());
    drawn.sort_by_key(|task| seed::derive(sample_seed, &["submission", &task.task.to_string()]));
    drawn.truncate(count);
    let (mut todo, mut absent) = (Vec::new(), BTreeSet::new());
    for task in drawn {
        let own = identity.controller(&task.method);
        if own.is_some_and(|own| own.kind == OwnKind::External) {
            absent.insert(format!("{}: its scores were measured elsewhere", task.method));
            continue;
        }
        match check_own(domain, layout, identity, &task.method) {
            Ok(()) => todo.push(task.clone()),
            Err(e) => drop(absent.insert(format!("{}: {e}", task.method))),
        }
    }
    let scratch = crate::cli::temporary_folder()?;
    let again = Layout::new(scratch.path().join("again"));
    again.make()?;
    let design = results.design.as_ref();
    establish(&again, (**manifest).clone(), results.plan(), design, Change::default())?;
    let session = reopen(&domains, &again, manifest.clone(), prepared.to_path_buf())?;
    let jobs =
        args.jobs.map_or_else(|| available_parallelism().map_or(1, |j| j.get()), |j| j.get());
    if !todo.is_empty() && !args.json {
        note(format!(
            "{} of {} tasks are done again (--sample-seed {sample_seed})",
            todo.len(),
            so_far.plan().len()
        ));
    }
    let mut undone = Vec::new();
    let executor = session.local(args.controllers.launcher()?, jobs);
    let interrupted = interrupted()?;
    session.work(&todo, &executor, &interrupted, &mut |event| match event {
        Event::Finished(record) if !args.json => {
            note(format!("task {} is done again", record.summary.task));
        }
        Event::Undone { task, reason } => undone.push(format!("task {task}: {reason}")),
        _ => {}
    })?;
    let (mut wrong, mut same) = (Vec::new(), 0);
    let theirs: BTreeMap<usize, &Record> =
        results.done().map(|(t, record)| (t.task, record)).collect();
    for task in &todo {
        let Some(ours) = Record::read(&again, task, &results.sha256)? else { continue };
        match theirs.get(&task.task).and_then(|theirs| difference(theirs, &ours)) {
            None => same += 1,
            Some(difference) => wrong.push(format!("{}: {difference}", named(task))),
        }
    }
    let left = todo.len() - same - wrong.len();
    let is_whole = left == 0 || !interrupted.load(Ordering::Relaxed);
    if !is_whole {
        note(format!(
            "interrupted with {} to do again; --sample-seed {sample_seed} draws the same tasks",
            format::count(left, "task")
        ));
    }
    let of = so_far.plan().len();
    if same + wrong.len() > 0 {
        findings.add(
            WHAT,
            wrong,
            format!("{same} of {of} tasks, drawn at random (--sample-seed {sample_seed}), gave the same records again"),
        );
    }
    undone.into_iter().chain(absent).for_each(|why| findings.not(WHAT, why));
    findings.not(WHAT, format!("the other {} of {of} tasks", of - same));
    Ok(is_whole)
}

/// Says why records cannot be measured again here.
fn another_measure(identity: &Identity) -> Option<String> {
    let (own, there) = (env!("CARGO_PKG_VERSION"), &identity.tsc_family);
    if there != own {
        return Some(format!(
            "tsc-family {there} made the records, and this is {own}; check them with that version"
        ));
    }
    if identity.domain != Traffic::NAME {
        return None;
    }
    match simulator::version() {
        Err(e) => Some(e.to_string()),
        Ok(here) if here != identity.simulator => Some(format!(
            "the records are from {}, and this is {here}, under which delays are others; check them with that version",
            identity.simulator
        )),
        Ok(_) => None,
    }
}

/// Returns what differs between a record and the same one done again; `None` where nothing does but wall-clock values.
fn difference(theirs: &Record, ours: &Record) -> Option<String> {
    if theirs.summary.checksum == ours.summary.checksum {
        return None;
    }
    for (there, here) in theirs.rows.iter().zip(&ours.rows) {
        let (kind, seed) = (there.kind.name(), there.seed);
        if (there.kind, there.seed) != (here.kind, here.seed) {
            return Some(format!("a row of {kind} with the seed {seed} is another one here"));
        }
        let metric =
            there.metrics.iter().find(|(name, value)| here.metrics.get(name) != Some(value));
        if let Some((name, value)) = metric {
            let now = here.metrics.get(name).map_or_else(|| "absent".to_owned(), f64::to_string);
            return Some(format!(
                "the {kind} episode with seed {seed} has {name} = {value} in the record, and {now} when it is done again"
            ));
        }
    }
    if theirs.rows.len() != ours.rows.len() {
        let (there, here) = (theirs.rows.len(), ours.rows.len());
        return Some(format!(
            "it has {there} rows in the record, and {here} when it is done again"
        ));
    }
    let outcome = ours.summary.reason.as_deref();
    Some(match outcome {
        Some(reason) => format!("it failed when it was done again: {reason}"),
        None => "its summary says other things than when it is done again".to_owned(),
    })
}
