//! Named metrics. A run has few sets of names, so every set is kept once: a row of a record is then little more than its
//! numbers.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt;
use std::iter::Zip;
use std::slice::Iter;
use std::sync::Arc;

use serde::{Deserialize, Serialize, Serializer};

use crate::stats::score::mean;

/// Sets of names that a thread remembers; a run has about three.
const REMEMBERED: usize = 16;

/// Names in order.
type Names = Arc<Vec<String>>;

thread_local! {
    /// The sets of names that were met, the last one first.
    static KNOWN: RefCell<Vec<Names>> = const { RefCell::new(Vec::new()) };
}

/// Named metrics in the order of their names; the unit is the suffix of the name.
#[derive(Clone, PartialEq, Deserialize)]
#[serde(from = "BTreeMap<String, f64>")]
pub struct Metrics {
    names: Names,
    values: Box<[f64]>,
}

impl Metrics {
    /// Returns no metrics.
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns a metric.
    pub fn get(&self, name: &str) -> Option<&f64> {
        let at = self.names.binary_search_by(|other| other.as_str().cmp(name)).ok()?;
        self.values.get(at)
    }

    /// Whether there is a metric of this name.
    pub fn contains_key(&self, name: &str) -> bool {
        self.get(name).is_some()
    }

    /// Returns the names, in order.
    pub fn keys(&self) -> Iter<'_, String> {
        self.names.iter()
    }

    /// Returns names and values, in the order of the names.
    pub fn iter(&self) -> Zip<Iter<'_, String>, Iter<'_, f64>> {
        self.names.iter().zip(self.values.iter())
    }

    /// Returns the number of metrics.
    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    /// Adds a metric, in place of one of the same name.
    pub fn insert(&mut self, name: String, value: f64) {
        self.extend([(name, value)]);
    }

    /// Returns the mean of every metric that all of some sets have.
    pub fn means<'a>(all: impl IntoIterator<Item = &'a Self>) -> Self {
        let all: Vec<&Self> = all.into_iter().collect();
        let of = |name: &String| {
            let values: Option<Vec<f64>> = all.iter().map(|own| own.get(name).copied()).collect();
            Some((name.clone(), mean(&values?)?))
        };
        all.first().into_iter().flat_map(|first| first.keys()).filter_map(of).collect()
    }
}

/// Returns a set of names that was met before, or else remembers this one.
fn shared(names: Vec<String>) -> Names {
    KNOWN.with_borrow_mut(|known| {
        let at = known.iter().position(|other| **other == names);
        let found = at.map_or_else(|| Arc::new(names), |at| known.remove(at));
        known.truncate(REMEMBERED - 1);
        known.insert(0, found.clone());
        found
    })
}

impl Default for Metrics {
    fn default() -> Self {
        BTreeMap::new().into()
    }
}

impl fmt::Debug for Metrics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_map().entries(self).finish()
    }
}

impl From<BTreeMap<String, f64>> for Metrics {
    fn from(metrics: BTreeMap<String, f64>) -> Self {
        let (names, values): (Vec<String>, Vec<f64>) = metrics.into_iter().unzip();
        Self { names: shared(names), values: values.into() }
    }
}

impl<const N: usize> From<[(String, f64); N]> for Metrics {
    fn from(metrics: [(String, f64); N]) -> Self {
        metrics.into_iter().collect()
    }
}

impl FromIterator<(String, f64)> for Metrics {
    fn from_iter<T: IntoIterator<Item = (String, f64)>>(metrics: T) -> Self {
        metrics.into_iter().collect::<BTreeMap<_, _>>().into()
    }
}

impl Extend<(String, f64)> for Metrics {
    fn extend<T: IntoIterator<Item = (String, f64)>>(&mut self, metrics: T) {
        let own = self.iter().map(|(name, value)| (name.clone(), *value));
        *self = own.chain(metrics).collect();
    }
}

impl IntoIterator for Metrics {
    type Item = (String, f64);
    type IntoIter = std::vec::IntoIter<(String, f64)>;

    fn into_iter(self) -> Self::IntoIter {
        let all: Vec<_> = self.iter().map(|(name, value)| (name.clone(), *value)).collect();
        all.into_iter()
    }
}

impl<'a> IntoIterator for &'a Metrics {
    type Item = (&'a String, &'a f64);
    type IntoIter = Zip<Iter<'a, String>, Iter<'a, f64>>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl std::ops::Index<&str> for Metrics {
    type Output = f64;

    fn index(&self, name: &str) -> &f64 {
        self.get(name).expect("whoever indexes knows that there is a metric of this name")
    }
}

impl Serialize for Metrics {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_set_of_names_is_kept_once() {
        let read = |text: &str| serde_json::from_str::<Metrics>(text).unwrap();
        let [first, again, other] =
            [r#"{"a":1.0,"b":2.0}"#, r#"{"b":3.0,"a":4.0}"#, r#"{"a":1.0,"c":2.0}"#].map(read);
        assert!(Arc::ptr_eq(&first.names, &again.names));
        assert!(!Arc::ptr_eq(&first.names, &other.names));
    }

    #[test]
    fn what_is_no_number_is_refused() {
        let e = serde_json::from_str::<Metrics>(r#"{"a":"1"}"#).unwrap_err().to_string();
        assert!(e.contains("expected f64"), "{e}");
        assert!(serde_json::from_str::<Metrics>("[1.0]").is_err());
    }

    #[test]
    fn means_are_of_what_all_have() {
        let of = |pairs: &[(&str, f64)]| -> Metrics {
            pairs.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect()
        };
        let all = [of(&[("a", 1.0), ("b", 2.0)]), of(&[("a", 2.0)])];
        assert_eq!(Metrics::means(&all), of(&[("a", 1.5)]));
        assert_eq!(Metrics::means(&all[..1]), all[0]);
        assert_eq!(Metrics::means([]), Metrics::new());
    }

    proptest! {
        #[test]
        fn they_are_read_changed_and_written_as_a_map_is(
            entries in prop::collection::vec(("[a-e]{1,2}", -9.0f64..9.0), 0..9), extra in "[a-e]",
        ) {
            let fields = entries.iter().map(|(name, value)| format!("\"{name}\":{value:?}"));
            let text = format!("{{{}}}", fields.collect::<Vec<_>>().join(","));
            let mut map: BTreeMap<String, f64> = serde_json::from_str(&text).unwrap();
            let mut metrics: Metrics = serde_json::from_str(&text).unwrap();
            for _ in 0..2 {
                prop_assert!(metrics.iter().eq(&map) && metrics.len() == map.len());
                prop_assert_eq!(serde_json::to_string(&metrics).unwrap(), serde_json::to_string(&map).unwrap());
                prop_assert_eq!(metrics.get(&extra), map.get(&extra));
                prop_assert_eq!(&metrics, &Metrics::from(map.clone()));
                map.insert(extra.clone(), 5.0);
                metrics.insert(extra.clone(), 5.0);
            }
        }
    }
}
