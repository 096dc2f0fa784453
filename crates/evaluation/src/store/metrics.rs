//! Named metrics, kept small: the names of a run are few and their sets fewer, so every set is kept once.
//!
//! A record of two episodes has 30 metrics; with a map of their own names, a million of them would take 4 GB.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

use serde::de::{DeserializeSeed, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Sets of names that a thread remembers; a run has about three.
const REMEMBERED: usize = 16;

/// Names in order.
pub(super) type Names = Arc<Vec<String>>;

thread_local! {
    /// The sets of names that were met, the last one first.
    static KNOWN: RefCell<Vec<Names>> = const { RefCell::new(Vec::new()) };
}

/// Named metrics in the order of their names; the unit is the suffix of the name.
#[derive(Clone, PartialEq)]
pub struct Metrics {
    names: Names,
    values: Arc<[f64]>,
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
    pub fn keys(&self) -> impl Iterator<Item = &String> {
        self.names.iter()
    }

    /// Returns the values, in the order of their names.
    pub fn values(&self) -> impl Iterator<Item = &f64> {
        self.values.iter()
    }

    /// Returns names and values, in the order of the names.
    pub fn iter(&self) -> std::iter::Zip<std::slice::Iter<'_, String>, std::slice::Iter<'_, f64>> {
        self.names.iter().zip(self.values.iter())
    }

    /// Returns the names, shared with all that have the same.
    pub(super) fn names(&self) -> &Names {
        &self.names
    }

    /// Returns metrics of these names, in their order.
    pub(super) fn of(names: Names, values: Arc<[f64]>) -> Self {
        Self { names, values }
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
}

/// Returns a set of names that was met before, or else remembers this one.
pub(super) fn shared(names: Vec<String>) -> Names {
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
        Self { names: shared(Vec::new()), values: Arc::default() }
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
    type IntoIter = std::iter::Zip<std::slice::Iter<'a, String>, std::slice::Iter<'a, f64>>;

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

impl<'de> Deserialize<'de> for Metrics {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(MetricsVisitor)
    }
}

/// Reads metrics; where they have the names of those before, no name is copied.
struct MetricsVisitor;

impl<'de> Visitor<'de> for MetricsVisitor {
    type Value = Metrics;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a map of names and numbers")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Metrics, A::Error> {
        let mut values: Vec<f64> = Vec::new();
        let mut other: Option<String> = None;
        let like = KNOWN.with_borrow(|known| -> Result<Option<Names>, A::Error> {
            let mut like = 0;
            loop {
                match map.next_key_seed(Next { known, like, at: values.len() })? {
                    Some(Key::Known(found)) => like = found,
                    Some(Key::Other(name)) => break other = Some(name),
                    None => break,
                }
                values.push(map.next_value()?);
            }
            Ok(known.get(like).cloned())
        })?;
        let like = like.unwrap_or_default();
        if other.is_none() && like.len() == values.len() {
            return Ok(Metrics { names: like, values: values.into() });
        }
        // What comes last counts, as in any map that is read.
        let mut all: BTreeMap<String, f64> = like.iter().cloned().zip(values).collect();
        if let Some(name) = other {
            all.insert(name, map.next_value()?);
            while let Some((name, value)) = map.next_entry()? {
                all.insert(name, value);
            }
        }
        Ok(all.into())
    }
}

/// The name of the next metric.
struct Next<'a> {
    known: &'a [Names],
    /// Position of a set of which the names so far are the first.
    like: usize,
    /// How many these are.
    at: usize,
}

/// A name that was read.
enum Key {
    /// The next of the set at this position, which has the names so far, too.
    Known(usize),
    /// Any other.
    Other(String),
}

impl<'de> DeserializeSeed<'de> for Next<'_> {
    type Value = Key;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Key, D::Error> {
        deserializer.deserialize_str(self)
    }
}

impl Visitor<'_> for Next<'_> {
    type Value = Key;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the name of a metric")
    }

    fn visit_str<E>(self, name: &str) -> Result<Key, E> {
        let Self { known, like, at } = self;
        let is_next = |set: usize| known[set].get(at).is_some_and(|next| next == name);
        let continues = |set: usize| known[set].get(..at) == known[like].get(..at) && is_next(set);
        let found = match like < known.len() && is_next(like) {
            true => Some(like),
            false => (0..known.len()).find(|set| continues(*set)),
        };
        Ok(found.map_or_else(|| Key::Other(name.to_owned()), Key::Known))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn sets_that_begin_alike_are_told_apart_and_kept_once() {
        let texts =
            [r#"{"a":1.0,"b":2.0}"#, r#"{"a":1.0,"b":2.0,"c":3.0}"#, r#"{"a":1.0,"c":2.0}"#, "{}"];
        let read = |text: &str| serde_json::from_str::<Metrics>(text).unwrap();
        for text in texts.iter().chain(texts.iter().rev()) {
            assert_eq!(serde_json::to_string(&read(text)).unwrap(), *text);
        }
        assert!(Arc::ptr_eq(&read(texts[1]).names, &read(texts[1]).names));
        assert!(!Arc::ptr_eq(&read(texts[0]).names, &read(texts[2]).names));
    }

    #[test]
    fn what_is_no_number_is_refused() {
        let e = serde_json::from_str::<Metrics>(r#"{"a":"1"}"#).unwrap_err().to_string();
        assert!(e.contains("expected f64"), "{e}");
        assert!(serde_json::from_str::<Metrics>("[1.0]").is_err());
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
