//! What is kept of a record in memory, where there may be a million: its summary, and of its rows the numbers that
//! something is computed of, in one piece. Whoever needs whole rows reads the record again ([`super::Origin`]).

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::metrics::{Metrics, Names, shared};
use super::opaque::Opaque;
use super::record::{Outcome, Record, Row, RowKind, Summary};

thread_local! {
    /// The seeds of the evaluation episodes that were met last: all methods have the same on a point MDP.
    static SEEDS: RefCell<Arc<[u64]>> = RefCell::default();
}

/// Of which metrics the values are kept of every episode.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Keep {
    /// Of all.
    All,
    /// Of those that have one of these names.
    Only(BTreeSet<String>),
}

impl Keep {
    /// Returns what keeps no values of single episodes.
    pub fn nothing() -> Self {
        Self::Only(BTreeSet::new())
    }

    /// Returns those of some names that are kept.
    fn of(&self, names: &Names) -> Names {
        match self {
            Self::All => names.clone(),
            Self::Only(wanted) => {
                shared(names.iter().filter(|name| wanted.contains(*name)).cloned().collect())
            }
        }
    }
}

/// What is kept of a record.
#[derive(Debug, Clone, PartialEq)]
pub struct Kept {
    /// How the task ended.
    pub outcome: Outcome,
    /// Means over the evaluation episodes, and figures of the whole training.
    pub metrics: Metrics,
    /// Wall-clock time of the task, seconds.
    pub wall_s: f64,
    /// The evaluation episodes, in order.
    pub evaluations: Rows,
    training: Option<Box<Rows>>,
    words: Option<Box<Words>>,
}

/// What few records have, or few different ones.
#[derive(Debug, Clone, PartialEq)]
struct Words {
    reason: Option<String>,
    details: BTreeMap<String, String>,
    programs: Opaque,
}

impl Kept {
    /// Returns what is kept of a record.
    pub fn of(record: Record, keep: &Keep) -> Self {
        let Record { summary, rows } = record;
        let Summary { outcome, metrics, wall, reason, details, programs, .. } = summary;
        let of = |kind: RowKind| rows.iter().filter(move |row| row.kind == kind);
        let mut evaluations = Rows::of(|| of(RowKind::Evaluation), keep);
        evaluations.seeds = known(of(RowKind::Evaluation).map(|row| row.seed));
        let training = Rows::of(|| of(RowKind::Training), keep);
        let words = reason.is_some() || !details.is_empty() || !programs.is_empty();
        Self {
            outcome,
            metrics,
            wall_s: wall.wall_s,
            evaluations,
            training: (training.count > 0).then(|| Box::new(training)),
            words: words.then(|| Box::new(Words { reason, details, programs })),
        }
    }

    /// Returns the episodes of training, in order; `None` without any.
    pub fn training(&self) -> Option<&Rows> {
        self.training.as_deref()
    }

    /// Returns why the task failed.
    pub fn reason(&self) -> Option<&str> {
        self.words.as_ref()?.reason.as_deref()
    }

    /// Returns what the method says of itself, if anything.
    pub fn details(&self) -> Option<&BTreeMap<String, String>> {
        self.words.as_ref().map(|words| &words.details)
    }

    /// Returns what the signals ran, where that is a program.
    pub fn programs(&self) -> Option<&Opaque> {
        self.words.as_ref().map(|words| &words.programs)
    }
}

/// The numbers of some episodes, one after the other.
#[derive(Debug, Clone, PartialEq)]
pub struct Rows {
    count: u32,
    seeds: Arc<[u64]>,
    /// All metrics that some of the episodes have.
    all: Names,
    /// Those whose values are kept.
    names: Names,
    /// A value per episode and name; not a number where an episode has none.
    values: Box<[f64]>,
}

impl Rows {
    fn of<'a, I: Iterator<Item = &'a Row>>(rows: impl Fn() -> I, keep: &Keep) -> Self {
        let mut all = Names::clone(Metrics::new().names());
        for row in rows() {
            let names = row.metrics.names();
            if !Arc::ptr_eq(&all, names) && *all != **names {
                let both: BTreeSet<&String> = all.iter().chain(names.iter()).collect();
                all = shared(both.into_iter().cloned().collect());
            }
        }
        let names = keep.of(&all);
        let mut values = Vec::with_capacity(rows().count() * names.len());
        for Row { metrics, .. } in rows() {
            values.extend(names.iter().map(|name| metrics.get(name).copied().unwrap_or(f64::NAN)));
        }
        let count = rows().count() as u32;
        Self { count, seeds: Arc::default(), all, names, values: values.into() }
    }

    /// Number of episodes.
    pub fn len(&self) -> usize {
        self.count as usize
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Returns the seeds of evaluation episodes, as vehicles and simulator got them; those of training are not kept.
    pub fn seeds(&self) -> &[u64] {
        &self.seeds
    }

    /// Returns the names of all metrics that some of the episodes have, kept or not.
    pub fn all_names(&self) -> &[String] {
        &self.all
    }

    /// Returns the values of a metric that is kept, one per episode; `None` where an episode has none.
    pub fn values<'a>(&'a self, name: &str) -> impl Iterator<Item = Option<f64>> + use<'a> {
        let at = self.names.binary_search_by(|other| other.as_str().cmp(name)).ok();
        (0..self.len()).map(move |row| {
            let value = self.values[row * self.names.len() + at?];
            (!value.is_nan()).then_some(value)
        })
    }

    /// Returns the metrics that are kept of an episode.
    pub fn metrics(&self, row: usize) -> Metrics {
        let values = &self.values[row * self.names.len()..][..self.names.len()];
        match values.iter().any(|value| value.is_nan()) {
            false => Metrics::of(self.names.clone(), values.into()),
            true => {
                let pairs = self.names.iter().cloned().zip(values.iter().copied());
                pairs.filter(|(_, value)| !value.is_nan()).collect()
            }
        }
    }
}

/// Returns seeds, kept once for as long as they stay the same.
fn known(seeds: impl Iterator<Item = u64> + Clone) -> Arc<[u64]> {
    SEEDS.with_borrow_mut(|last| {
        if !last.iter().copied().eq(seeds.clone()) {
            *last = seeds.collect();
        }
        last.clone()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::manifest::Task;
    use crate::store::record::TaskResult;

    fn row(kind: RowKind, seed: u64, metrics: &[(&str, f64)]) -> Row {
        let metrics = metrics.iter().map(|(n, v)| ((*n).to_owned(), *v)).collect();
        Row { kind, episode: 0, seed, metrics }
    }

    fn record() -> Record {
        let task = Task { task: 7, method: "m".into(), point: "p".into(), replicate: 0, seed: 3 };
        let rows = vec![
            row(RowKind::Training, 1, &[("delay_s", 9.0), ("loss", 0.5)]),
            row(RowKind::Training, 2, &[("delay_s", 8.0)]),
            row(RowKind::Evaluation, 5, &[("delay_s", 4.0), ("queue_veh", 1.0)]),
            row(RowKind::Evaluation, 6, &[("delay_s", 6.0), ("queue_veh", 3.0)]),
        ];
        Record::finished(&task, "abc", TaskResult { rows, ..TaskResult::default() })
    }

    #[test]
    fn everything_that_is_kept_is_as_the_record_has_it() {
        let (record, kept) = (record(), Kept::of(record(), &Keep::All));
        assert_eq!(
            (&kept.metrics, kept.evaluations.seeds()),
            (&record.summary.metrics, &[5, 6][..])
        );
        let kinds = [
            (RowKind::Training, kept.training().unwrap()),
            (RowKind::Evaluation, &kept.evaluations),
        ];
        for (kind, rows) in kinds {
            let own: Vec<&Row> = record.rows.iter().filter(|row| row.kind == kind).collect();
            for (i, row) in own.iter().enumerate() {
                assert_eq!(rows.metrics(i), row.metrics);
            }
            for name in rows.all_names() {
                let values: Vec<_> = own.iter().map(|row| row.metrics.get(name).copied()).collect();
                assert_eq!(rows.values(name).collect::<Vec<_>>(), values, "{name}");
            }
        }
    }

    #[test]
    fn of_what_is_not_kept_the_names_stay() {
        let kept = Kept::of(record(), &Keep::Only(BTreeSet::from(["delay_s".to_owned()])));
        let rows = &kept.evaluations;
        assert_eq!(rows.all_names(), ["delay_s", "queue_veh"]);
        assert_eq!(rows.values("delay_s").collect::<Vec<_>>(), [Some(4.0), Some(6.0)]);
        assert_eq!(rows.values("queue_veh").collect::<Vec<_>>(), [None, None]);
        assert_eq!((rows.len(), rows.metrics(1).len()), (2, 1));
        assert_eq!((kept.reason(), kept.details(), kept.programs()), (None, None, None));
    }

    #[test]
    fn a_record_of_a_failed_task_has_a_reason_and_no_rows() {
        let task = Task { task: 7, method: "m".into(), point: "p".into(), replicate: 0, seed: 3 };
        let failed = Record::failed(&task, "abc", "diverged".to_owned(), Default::default());
        let kept = Kept::of(failed, &Keep::All);
        assert_eq!((kept.outcome, kept.reason()), (Outcome::Failed, Some("diverged")));
        assert!(kept.evaluations.is_empty() && kept.training().is_none());
    }
}
