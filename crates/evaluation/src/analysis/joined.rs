//! Several runs over one family as one: their methods side by side, on the same point MDPs and evaluation seeds.
//!
//! - **Point MDPs** are those of the run that has fewest; all other runs must have them too. Its sample gives the weights.
//! - **Seeds** are those that all runs have.
//! - **A method that several runs have** is one method where its records agree and neither lacks one that the other has
//!   of a task of both. Else it is there once per run, as `METHOD@RUN`. So what the runs differ in shows in the same
//!   ranking: a baseline under two versions of a simulator is two methods. All records of a method are of one run.
//! - **Scores** are relative to the baseline of the first run that is named.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::fs;
use std::path::Path;
use std::sync::Arc;

use serde_json::Value;

use super::reference::AnalysisError;
use super::training::learned;
use crate::store::manifest::{Identity, Manifest, PointRow, Provenance, Task};
use crate::store::own::OwnMethod;
use crate::store::own::{differing, flat};
use crate::store::record::{Metrics, Record};
use crate::store::results::Results;

/// Point MDPs that a refusal names.
const NAMED: usize = 3;

/// Largest relative difference of two importances that are the same.
const SAME: f64 = 1e-9;

/// Sections of settings that say how a family is made. Its point MDPs are compared themselves.
const OF_FAMILY: [&str; 4] = ["family", "name", "title", "version"];

/// Settings that name a family or say where its tables are.
const NAMES: [&str; 5] = ["name", "title", "version", "family.approaches", "family.points"];

/// Section of settings that only methods that learn read.
const OF_LEARNERS: &str = "training";

/// A run that is compared.
#[derive(Debug, Clone)]
pub struct Source {
    /// What it is called: the last part of its path, as far as no other run is called so.
    pub name: String,
    /// Its path, as it was given.
    pub path: String,
    /// What its records say.
    pub results: Results,
}

/// What a comparison must know of the domain.
#[derive(Debug, Clone, Default)]
pub struct Known {
    /// Names of its methods: settings in the section of one are read by that method alone.
    pub methods: Vec<&'static str>,
    /// Sections of settings that decide what all methods meet in an episode.
    pub episodes: &'static [&'static str],
}

/// Several runs as one.
#[derive(Debug, Clone)]
pub struct Joined {
    /// Records of all methods.
    pub results: Results,
    /// The runs, in the order given.
    pub sources: Vec<Source>,
    /// The run whose sample counts.
    pub sample: usize,
    /// What differs between the runs, a sentence each.
    pub differences: Vec<String>,
    /// How many episodes are equal of methods that several runs have, a sentence each.
    pub repeated: Vec<String>,
}

/// A method of the comparison.
struct Column {
    /// Its name in the runs.
    method: String,
    /// The runs that have it with these records.
    sources: Vec<usize>,
    /// That of them with the most trainings, whose records are taken.
    run: usize,
    replicates: u32,
    /// What it is called here.
    name: String,
}

impl Source {
    /// Names runs by the last parts of their paths: as many as it takes to tell them apart; else by numbers.
    pub fn named(mut runs: Vec<Self>) -> Vec<Self> {
        let most = runs.iter().map(|run| Path::new(&run.path).components().count()).max();
        let names = |length: usize| -> Vec<String> {
            runs.iter().map(|run| last_parts(&run.path, length)).collect()
        };
        let distinct = |names: &Vec<String>| BTreeSet::from_iter(names).len() == names.len();
        let named = (1..=most.unwrap_or(1)).map(names).find(distinct);
        let numbered = || (1..=runs.len()).map(|n| n.to_string()).collect();
        let names = named.unwrap_or_else(numbered);
        runs.iter_mut().zip(names).for_each(|(run, name)| run.name = name);
        runs
    }

    fn identity(&self) -> &Identity {
        &self.results.manifest.identity
    }
}

fn last_parts(path: &str, length: usize) -> String {
    let parts: Vec<_> = Path::new(path).iter().map(|part| part.to_string_lossy()).collect();
    let last = parts[parts.len().saturating_sub(length)..].join("-");
    let safe = |c: char| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '_' };
    last.chars().map(safe).collect()
}

/// Puts runs side by side.
///
/// # Errors
///
/// [`AnalysisError`] with the reason and the way out where they cannot be compared.
pub fn join(sources: Vec<Source>, known: &Known) -> Result<Joined, AnalysisError> {
    let Some(first) = sources.first() else {
        return refused("there is no run to compare".to_owned());
    };
    for (at, other) in sources.iter().enumerate().skip(1) {
        // A run that was made again has the same manifest; the same folder is a slip.
        let folder = |source: &Source| fs::canonicalize(&source.path).ok();
        let twice = |s: &&Source| folder(s).is_some() && folder(s) == folder(other);
        if let Some(same) = sources[..at].iter().find(twice) {
            let (one, other) = (&same.path, &other.path);
            return refused(format!("{one} and {other} are one folder; give each run once"));
        }
        check_together(first, other, known)?;
    }
    let sample =
        (0..sources.len()).min_by_key(|s| sources[*s].identity().points.len()).unwrap_or(0);
    for other in sources.iter().enumerate().filter(|(s, _)| *s != sample).map(|(_, other)| other) {
        check_points(&sources[sample], other)?;
    }
    let seeds = common_seeds(&sources)?;
    let points = &sources[sample].identity().points;
    let evaluated: Vec<Evaluated<'_>> =
        sources.iter().map(|source| evaluations(source, points, &seeds)).collect();
    let columns = columns(&sources, &evaluated);
    let repeated = repeated(&sources, &evaluated);
    let results = side_by_side(&sources, sample, &columns, &seeds);
    let mut differences = differences(&sources, known);
    differences.extend(unequal(&sources, sample, &seeds));
    Ok(Joined { results, sample, differences, repeated, sources })
}

fn refused<T>(text: String) -> Result<T, AnalysisError> {
    Err(AnalysisError(text))
}

/// Refuses two runs whose methods did not have the same task.
fn check_together(a: &Source, b: &Source, known: &Known) -> Result<(), AnalysisError> {
    let (one, other) = (a.identity(), b.identity());
    let preset = |i: &Identity| i.settings["preset"].as_str().unwrap_or("not set").to_owned();
    let of = |what: &str, value: &dyn Fn(&Identity) -> String, way_out: &str| {
        let (x, y) = (value(one), value(other));
        match x == y {
            true => Ok(()),
            false => refused(format!("{what} {x} in {} and {y} in {}; {way_out}", a.path, b.path)),
        }
    };
    let families = "compare runs of one family here, and rank over several families with `across`";
    of("the task is", &|i| i.domain.clone(), families)?;
    of("scores compare", &|i| format!("{} ({})", i.objective, i.direction.name()), families)?;
    of(
        "the preset is",
        &preset,
        "methods of one preset can be compared; `across` ranks over both",
    )?;
    of("the baseline is", &|i| i.baseline.clone(), families)?;
    of("the family's size is", &|i| i.sample.family_size.to_string(), families)?;
    let decides = |key: &str| known.episodes.contains(&section(key));
    let way_out = "with another value, episodes of the same seed are not the same; run one of them again with the value of \
                   the other";
    differing_settings([a, b])
        .iter()
        .filter(|key| decides(key))
        .try_for_each(|key| of(&format!("the setting {key} is"), &|i| value_of(i, key), way_out))
}

/// Says why a run cannot be compared with another one on all point MDPs of that; `None` where it can be.
///
/// # Arguments
///
/// * `first` — whose point MDPs count.
pub fn obstacle(first: &Source, other: &Source, known: &Known) -> Option<AnalysisError> {
    let together = check_together(first, other, known).and_then(|()| check_points(first, other));
    together.and_then(|()| common_seeds([first, other]).map(drop)).err()
}

/// Refuses a run that lacks point MDPs, or has others of the same names.
fn check_points(sample: &Source, other: &Source) -> Result<(), AnalysisError> {
    let (of_sample, of_other) = (sample.identity(), other.identity());
    let there: HashMap<&str, &PointRow> =
        of_other.points.iter().map(|p| (p.point.as_str(), p)).collect();
    let lacking = |p: &&PointRow| !there.contains_key(p.point.as_str());
    let missing: Vec<&str> =
        of_sample.points.iter().filter(lacking).map(|p| p.point.as_str()).collect();
    if !missing.is_empty() {
        let more = if missing.len() > NAMED { ", ..." } else { "" };
        return refused(format!(
            "{} lacks {} of the {} point MDPs of {} ({}{more}); methods are compared on the same point MDPs: add those to \
             it with `run --budget`, or run its methods with the scenario, --budget, --sampling and --seed of {}",
            other.path,
            missing.len(),
            of_sample.points.len(),
            sample.path,
            missing[..missing.len().min(NAMED)].join(", "),
            sample.path
        ));
    }
    let is_near = |a: f64, b: f64| (a - b).abs() <= SAME * a.abs().max(b.abs());
    let is_other = |p: &&PointRow| {
        let other = there[p.point.as_str()];
        p.content != other.content
            || p.features != other.features
            || !is_near(p.importance, other.importance)
    };
    if let Some(point) = of_sample.points.iter().find(is_other) {
        return refused(format!(
            "the point MDP {} is another one in {} than in {}: its importance, features, vehicles or random numbers are \
             others; compare runs of one table of point MDPs",
            point.name(),
            other.path,
            sample.path
        ));
    }
    Ok(())
}

fn common_seeds<'a>(
    sources: impl IntoIterator<Item = &'a Source>,
) -> Result<Vec<u64>, AnalysisError> {
    let mut sources = sources.into_iter();
    let Some(first) = sources.next() else { return Ok(Vec::new()) };
    let mut common = first.identity().evaluation_seeds.clone();
    for other in sources {
        let (one, two) = (first.identity(), other.identity());
        common.retain(|seed| two.evaluation_seeds.contains(seed));
        if common.is_empty() {
            return refused(format!(
                "{} and {} have no evaluation seed in common (--seed is {} and {}); run one of them again with the \
                 --seed of the other",
                first.path, other.path, one.base_seed, two.base_seed
            ));
        }
    }
    Ok(common)
}

fn columns(sources: &[Source], evaluated: &[Evaluated<'_>]) -> Vec<Column> {
    let planned: Vec<HashSet<Key<'_>>> =
        sources.iter().map(|source| source.results.plan().iter().map(key).collect()).collect();
    let lacks_the_same = |a: usize, b: usize, method: &str| {
        let mut both = planned[a].intersection(&planned[b]).filter(|key| key.0 == method);
        both.all(|key| evaluated[a].contains_key(key) == evaluated[b].contains_key(key))
    };
    let mut columns: Vec<Column> = Vec::new();
    for (s, source) in sources.iter().enumerate() {
        for method in &source.identity().methods {
            let is_one = |other: &usize| {
                agree(&evaluated[*other], &evaluated[s], method)
                    && lacks_the_same(*other, s, method)
            };
            let replicates = source.identity().replicates_of(method);
            match columns.iter_mut().find(|c| c.method == *method && c.sources.iter().all(is_one)) {
                Some(column) => {
                    column.sources.push(s);
                    if replicates > column.replicates {
                        (column.run, column.replicates) = (s, replicates);
                    }
                }
                None => columns.push(Column {
                    method: method.clone(),
                    sources: vec![s],
                    run: s,
                    replicates,
                    name: method.clone(),
                }),
            }
        }
    }
    for c in 0..columns.len() {
        if columns.iter().filter(|other| other.method == columns[c].method).count() > 1 {
            columns[c].name =
                format!("{}@{}", columns[c].method, sources[columns[c].sources[0]].name);
        }
    }
    columns
}

/// Says of methods that several runs have how many episodes are equal, and which is the first that is not.
fn repeated(sources: &[Source], evaluated: &[Evaluated<'_>]) -> Vec<String> {
    let mut said = Vec::new();
    for (a, one) in sources.iter().enumerate() {
        for (b, other) in sources.iter().enumerate().skip(a + 1) {
            for method in &one.identity().methods {
                said.extend(equal((one, &evaluated[a]), (other, &evaluated[b]), method));
            }
        }
    }
    said
}

/// Says how many episodes of a method are equal in two runs; `None` where they share no task of it.
fn equal(
    (one, a): (&Source, &Evaluated<'_>),
    (other, b): (&Source, &Evaluated<'_>),
    method: &str,
) -> Option<String> {
    let mut shared: Vec<_> = shared(a, b, method).collect();
    shared.sort_by_key(|(key, ..)| *key);
    let (mut all, mut same, mut first) = (0, 0, None);
    for (key, rows, others) in shared {
        for ((seed, here), (_, there)) in rows.iter().zip(others).filter(|(x, y)| x.0 == y.0) {
            all += 1;
            match here == there {
                true => same += 1,
                false => first = first.or(Some((key.1, *seed, *here, *there))),
            }
        }
    }
    let mut text = format!(
        "{method} in {} and {}: {same} of {all} shared episodes are equal to the last digit",
        one.name, other.name
    );
    if let Some((point, seed, here, there)) = first {
        let objective = &one.identity().objective;
        let value = |metrics: &Metrics| {
            metrics.get(objective).map_or_else(|| "none".to_owned(), f64::to_string)
        };
        text.push_str(&format!(
            "; the first other one, on {point} with seed {seed}, has {objective} {} and {}",
            value(here),
            value(there)
        ));
    }
    for (source, evaluated) in [(one, a), (other, b)] {
        let of_method = |t: &&Task| *t.method == *method;
        let tasks = source.results.plan().iter().filter(of_method).count();
        let done = evaluated.keys().filter(|key| key.0 == method).count();
        if done < tasks {
            text.push_str(&format!("; {} has {done} of {tasks} tasks of it", source.name));
        }
    }
    (all > 0).then_some(text)
}

/// Method, point MDP and replicate of a task.
type Key<'a> = (&'a str, &'a str, u32);

fn key(task: &Task) -> Key<'_> {
    (&task.method, &task.point, task.replicate)
}

/// What a task measured on every seed.
type Rows<'a> = Vec<(u64, &'a Metrics)>;

/// What tasks measured on every seed.
type Evaluated<'a> = HashMap<Key<'a>, Rows<'a>>;

/// Returns what two runs measured in the tasks of a method that both have.
fn shared<'a, 'b>(
    a: &'b Evaluated<'a>,
    b: &'b Evaluated<'a>,
    method: &'b str,
) -> impl Iterator<Item = (Key<'a>, &'b Rows<'a>, &'b Rows<'a>)> {
    let of_method = a.iter().filter(move |(key, _)| key.0 == method);
    of_method.filter_map(|(key, rows)| Some((*key, rows, b.get(key)?)))
}

/// Returns what was measured on point MDPs with the seeds that follow from these.
fn evaluations<'a>(source: &'a Source, points: &[PointRow], seeds: &[u64]) -> Evaluated<'a> {
    let seeds: HashMap<&str, BTreeSet<u64>> = (points.iter())
        .map(|p| (p.point.as_str(), p.evaluation_seeds(seeds).into_iter().collect()))
        .collect();
    let of = |(task, record): (&'a Task, &'a Record)| {
        let seeds = seeds.get(&*task.point)?;
        let rows = record.evaluations().filter(|row| seeds.contains(&row.seed));
        let mut rows: Vec<_> = rows.map(|row| (row.seed, &row.metrics)).collect();
        rows.sort_by_key(|row| row.0);
        Some((key(task), rows))
    };
    source.results.done().filter_map(of).collect()
}

/// Whether two runs have the same records of a method wherever both have some, and both have some somewhere.
fn agree(a: &Evaluated<'_>, b: &Evaluated<'_>, method: &str) -> bool {
    let mut some = false;
    let all = shared(a, b, method).all(|(_, x, y)| {
        some |= !x.is_empty();
        x == y
    });
    all && some
}

fn side_by_side(sources: &[Source], sample: usize, columns: &[Column], seeds: &[u64]) -> Results {
    let base = &sources[sample].results;
    let tasks: Vec<HashMap<Key<'_>, (&Task, Option<&Record>)>> = (sources.iter())
        .map(|s| s.results.rows().map(|(task, record)| (key(task), (task, record))).collect())
        .collect();
    let identity = identity(sources, sample, columns, seeds);
    let mut rows: Vec<(Task, Option<Arc<Record>>)> = Vec::new();
    for point in &identity.points {
        let of_point: BTreeSet<u64> = point.evaluation_seeds(seeds).into_iter().collect();
        for column in columns {
            for replicate in 0..column.replicates {
                let key = (&*column.method, &*point.point, replicate);
                let Some((task, found)) = tasks[column.run].get(&key) else { continue };
                let task =
                    Task { task: rows.len(), method: column.name.clone(), ..(*task).clone() };
                let record = found.map(|record| Arc::new(record.on_seeds(&task, &of_point)));
                rows.push((task, record));
            }
        }
    }
    let of = |value: &dyn Fn(&Provenance) -> &str| {
        each(sources, &|source| value(&source.results.manifest.provenance).to_owned())
    };
    let warnings = sources.iter().flat_map(|source| {
        let warnings = &source.results.manifest.provenance.warnings;
        warnings.iter().map(|warning| format!("{}: {warning}", source.name))
    });
    let provenance = Provenance {
        command: of(&|p| &p.command),
        git: of(&|p| &p.git),
        rustc: of(&|p| &p.rustc),
        host: of(&|p| &p.host),
        started: of(&|p| &p.started),
        networks: base.manifest.provenance.networks.clone(),
        warnings: warnings.collect(),
        memory_per_worker_mb: None,
        assisting: None,
    };
    base.with(Manifest { identity, provenance }, rows)
}

fn identity(sources: &[Source], sample: usize, columns: &[Column], seeds: &[u64]) -> Identity {
    let of_sample = sources[sample].identity();
    let baseline =
        columns.iter().find(|c| c.method == of_sample.baseline && c.sources.contains(&0));
    let controller = |c: &Column| {
        let own = sources[c.sources[0]].identity().controller(&c.method)?;
        Some(OwnMethod { name: c.name.clone(), ..own.clone() })
    };
    let several = columns.iter().filter(|c| c.replicates > 1);
    Identity {
        methods: columns.iter().map(|c| c.name.clone()).collect(),
        baseline: baseline.map(|c| c.name.clone()).unwrap_or_default(),
        controllers: columns.iter().filter_map(controller).collect(),
        replicates: columns.iter().map(|c| c.replicates).max().unwrap_or(1),
        replicated: several.map(|c| c.name.clone()).collect(),
        evaluation_seeds: seeds.to_vec(),
        simulator: each(sources, &|source| source.identity().simulator.clone()),
        tsc_family: each(sources, &|source| source.identity().tsc_family.clone()),
        ..of_sample.clone()
    }
}

fn each(sources: &[Source], value: &dyn Fn(&Source) -> String) -> String {
    let mut by_value: Vec<(String, Vec<&str>)> = Vec::new();
    for source in sources {
        let value = value(source);
        match by_value.iter_mut().find(|(known, _)| *known == value) {
            Some((_, names)) => names.push(&source.name),
            None => by_value.push((value, vec![&source.name])),
        }
    }
    match &by_value[..] {
        [(value, _)] => value.clone(),
        several => {
            let of = |(value, names): &(String, Vec<&str>)| {
                let value = if value.is_empty() { "not known" } else { value };
                format!("{value} in {}", names.join(" and "))
            };
            several.iter().map(of).collect::<Vec<_>>().join("; ")
        }
    }
}

/// Says what differs between the runs.
fn differences(sources: &[Source], known: &Known) -> Vec<String> {
    let mut found = Vec::new();
    let mut add = |what: &str, value: &dyn Fn(&Source) -> String| {
        let several = sources.iter().map(value).collect::<BTreeSet<_>>().len() > 1;
        found.extend(several.then(|| format!("{what}: {}", each(sources, value))));
    };
    add("Simulator, whose effect differences between methods of different runs contain", &|s| {
        s.identity().simulator.clone()
    });
    add("Build of tsc-family", &|s| {
        format!("{} (git {})", s.identity().tsc_family, s.results.manifest.provenance.git)
    });
    for key in differing_settings(sources).iter().filter(|key| is_read(sources, known, key)) {
        add(&format!("Setting {key}"), &|s| value_of(s.identity(), key));
    }
    let files = |s: &Source, point: &str| {
        let row = s.identity().points.iter().find(|p| p.point == point);
        row.map(|row| (row.sha256.clone(), row.given.clone()))
    };
    let fewest = sources.iter().min_by_key(|s| s.identity().points.len());
    let points = fewest.map_or(&[][..], |s| &s.identity().points);
    let others = |point: &&PointRow| {
        sources.iter().any(|s| files(s, &point.point) != files(&sources[0], &point.point))
    };
    let others = points.iter().filter(others).count();
    if others > 0 {
        found.push(format!(
            "Files of the point MDPs: on {others} of {} networks, demand or what the command line gave are not the same",
            points.len()
        ));
    }
    found
}

/// Whether more than one of the runs has a method that reads a setting.
fn is_read(sources: &[Source], known: &Known, key: &str) -> bool {
    let method = method_of(key);
    let readers = |reads: &dyn Fn(&Source) -> bool| sources.iter().filter(|s| reads(s)).count() > 1;
    if section(key) == OF_LEARNERS {
        return readers(&|s| !learned(&s.results).is_empty());
    }
    if known.methods.contains(&method.as_str()) {
        return readers(&|s| s.identity().methods.contains(&method));
    }
    have_section(sources, key)
}

/// Whether all of these runs have the section of a setting: one that a run lacks is of a method that its build did not have.
fn have_section<'a>(sources: impl IntoIterator<Item = &'a Source>, key: &str) -> bool {
    sources.into_iter().all(|s| s.identity().settings.get(section(key)).is_some())
}

fn method_of(key: &str) -> String {
    section(key).replace('_', "-")
}

fn section(key: &str) -> &str {
    key.split('.').next().unwrap_or_default()
}

/// Returns the settings in which runs differ, but those of families.
fn differing_settings<'a>(sources: impl IntoIterator<Item = &'a Source>) -> BTreeSet<String> {
    let of = |source: &Source| flat(&source.identity().settings);
    let all: Vec<_> = sources.into_iter().map(of).collect();
    let keys = all[1..].iter().flat_map(|other| differing(&all[0], other));
    keys.filter(|key| !OF_FAMILY.contains(&section(key))).cloned().collect()
}

fn value_of(identity: &Identity, key: &str) -> String {
    match flat(&identity.settings).get(key) {
        None | Some(Value::Null) => "not set".to_owned(),
        Some(value) => value.to_string(),
    }
}

/// Returns the settings that all methods read by which a run differs from another, as `key = value`; one at its default may be
/// left out.
pub fn settings(from: &Source, run: &Source, known: &Known) -> Vec<String> {
    let of = |source: &Source| flat(&source.identity().settings);
    let (there, here) = (of(from), of(run));
    let is_of_all = |key: &str| {
        section(key) != OF_LEARNERS
            && have_section([from, run], key)
            && !known.methods.contains(&method_of(key).as_str())
            && !NAMES.contains(&key)
    };
    // At most five significant digits.
    let short = |number: f64| format!("{number:.4e}").parse::<f64>().unwrap_or(number).to_string();
    let said = |value: &Value| match value.as_f64().filter(|_| value.is_f64()) {
        Some(number) => short(number),
        None => value.to_string(),
    };
    let named = |key: &String| {
        format!("{key} = {}", here.get(key).map_or_else(|| "not set".to_owned(), said))
    };
    differing(&there, &here).into_iter().filter(|key| is_of_all(key)).map(named).collect()
}

/// Says of which runs only a part of the point MDPs and seeds is compared.
fn unequal(sources: &[Source], sample: usize, seeds: &[u64]) -> Vec<String> {
    let points = sources[sample].identity().points.len();
    let mut found = Vec::new();
    for source in sources {
        let identity = source.identity();
        let (all, of) = (identity.points.len(), &source.name);
        if all > points {
            found.push(format!(
                "Point MDPs: {points} of the {all} of {of} are compared, those of {}",
                sources[sample].name
            ));
        }
        let all = identity.evaluation_seeds.len();
        if all > seeds.len() {
            found.push(format!(
                "Evaluation seeds: {} of the {all} of {of} are compared",
                seeds.len()
            ));
        }
    }
    if sources[sample].identity().sample.growth.is_some() {
        found.push(format!(
            "Sample: {} grew in looks until enough was known, so all intervals are wider and hold over all its looks",
            sources[sample].name
        ));
    }
    found
}
