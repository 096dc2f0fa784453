//! What the passes keep, part by part of a file and all together.

use std::path::Path;

use super::nothing;
use super::turns::{Member, restrictions};
use crate::OsmError;
use crate::extract::{Extract, Nodes, Place, Restriction, SignalNode, Via, Way};
use crate::oddities::Oddities;
use crate::tags::{SignalTags, Street, Tags, is_crossing_signal, tag};

/// What the first pass keeps: ways and turn restrictions.
#[derive(Debug, Default)]
pub(super) struct Streets {
    ways: Vec<Way>,
    refs: Vec<i64>,
    /// By relation, so that of two with one id the later one can win.
    turns: Vec<(i64, Vec<Restriction>)>,
    oddities: Oddities,
}

impl Streets {
    pub(super) fn way(&mut self, id: i64, tags: &Tags<'_>, nodes: &[i64]) {
        let Some(street) = Street::parse(id, tags, &mut self.oddities) else { return };
        if nodes.len() < 2 {
            self.oddities.add("way with fewer than two nodes", || format!("way {id}"));
            return;
        }
        let start = self.refs.len();
        self.refs.extend_from_slice(nodes);
        self.ways.push(Way { id, refs: start..self.refs.len(), street });
    }

    pub(super) fn relation(&mut self, id: i64, tags: &Tags<'_>, members: &[Member<'_>]) {
        let turns = restrictions(id, tags, members, &mut self.oddities);
        if !turns.is_empty() {
            self.turns.push((id, turns));
        }
    }

    pub(super) fn append(&mut self, later: Self) {
        let shift = self.refs.len();
        self.refs.extend(later.refs);
        self.ways.extend(later.ways.into_iter().map(|mut way| {
            way.refs = way.refs.start + shift..way.refs.end + shift;
            way
        }));
        self.turns.extend(later.turns);
        self.oddities.merge(later.oddities);
    }

    /// Returns the extract, in which no node has a place yet.
    pub(super) fn finish(self) -> Extract {
        let Self { mut ways, mut refs, mut turns, mut oddities } = self;
        if !ways.is_sorted_by(|a, b| a.id < b.id) {
            last_of_each(&mut ways, |way| way.id, "two ways with one id", "way", &mut oddities);
            refs = in_order(&mut ways, &refs);
        }
        last_of_each(&mut turns, |t| t.0, "two relations with one id", "relation", &mut oddities);
        let kept = |id: &i64| ways.binary_search_by_key(id, |way| way.id).is_ok();
        let mut restrictions = Vec::new();
        for (relation, turns) in turns {
            let ends_at = |id: i64, node: i64| {
                ways.binary_search_by_key(&id, |way| way.id).is_ok_and(|k| {
                    let nodes = &refs[ways[k].refs.clone()];
                    nodes.first() == Some(&node) || nodes.last() == Some(&node)
                })
            };
            for turn in turns {
                let (all_kept, at_ends) = match &turn.via {
                    // Where a way goes on, nothing says which of its two directions is meant.
                    Via::Node(node) => (true, ends_at(turn.from, *node) && ends_at(turn.to, *node)),
                    Via::Ways(ways) => (ways.iter().all(kept), true),
                };
                let reason = match all_kept && kept(&turn.from) && kept(&turn.to) {
                    true if at_ends => {
                        restrictions.push(turn);
                        continue;
                    }
                    true => "turn restriction on a way that does not end at the turn",
                    false => "turn restriction on a way that is not drivable or not in the extract",
                };
                oddities.add(reason, || format!("relation {relation}"));
            }
        }
        let nodes = Nodes::wanted(refs.clone());
        Extract { ways, refs, nodes, restrictions, oddities, ..Extract::default() }
    }
}

fn last_of_each<T>(
    items: &mut Vec<T>,
    id: impl Fn(&T) -> i64,
    reason: &'static str,
    element: &str,
    oddities: &mut Oddities,
) {
    items.sort_by_key(&id);
    items.reverse();
    items.dedup_by(|earlier, later| {
        let same = id(earlier) == id(later);
        if same {
            oddities.add(reason, || format!("{element} {}", id(later)));
        }
        same
    });
    items.reverse();
}

fn in_order(ways: &mut [Way], refs: &[i64]) -> Vec<i64> {
    let mut ordered = Vec::with_capacity(ways.iter().map(|way| way.refs.len()).sum());
    for way in ways {
        let start = ordered.len();
        ordered.extend_from_slice(&refs[way.refs.clone()]);
        way.refs = start..ordered.len();
    }
    ordered
}

/// What the second pass keeps: where nodes are, and signals.
#[derive(Debug, Default)]
pub(super) struct Places {
    found: Vec<(i64, Place)>,
    signals: Vec<SignalNode>,
    crossings: Vec<i64>,
    signs: Vec<i64>,
    oddities: Oddities,
}

impl Places {
    /// Keeps a node if it is wanted or a signal; `place` is called for these only.
    pub(super) fn node(
        &mut self,
        wanted: &Nodes,
        id: i64,
        tags: &Tags<'_>,
        place: impl FnOnce() -> Option<Place>,
    ) {
        let signal = SignalTags::parse(tags);
        let wanted = wanted.index(id).is_some();
        if signal.is_none() && !wanted {
            return;
        }
        let Some(place) = place() else {
            self.oddities.add("node without a place on Earth", || format!("node {id}"));
            return;
        };
        if wanted {
            self.found.push((id, place));
            if is_crossing_signal(tags) {
                self.crossings.push(id);
            }
            if matches!(tag(tags, "highway"), Some("stop" | "give_way")) {
                self.signs.push(id);
            }
        }
        if let Some(tags) = signal {
            self.signals.push(SignalNode { id, place, tags });
        }
    }

    pub(super) fn put(self, extract: &mut Extract) {
        for (id, place) in self.found {
            let index = extract.nodes.index(id);
            if index.is_some_and(|index| extract.nodes.places[index].is_some()) {
                extract.oddities.add("two nodes with one id", || format!("node {id}"));
            }
            extract.nodes.set(id, place);
        }
        extract.signals.extend(self.signals);
        extract.crossings.extend(self.crossings);
        extract.signs.extend(self.signs);
        extract.oddities.merge(self.oddities);
    }
}

/// Puts the signals in order and counts the nodes that were not found; without any place it is an error.
pub(super) fn complete(path: &Path, mut extract: Extract) -> Result<Extract, OsmError> {
    let Extract { nodes, signals, crossings, signs, oddities, .. } = &mut extract;
    for ids in [crossings, signs] {
        ids.sort_unstable();
        ids.dedup();
        ids.shrink_to_fit();
    }
    last_of_each(signals, |s| s.id, "two signals with one id", "node", oddities);
    signals.shrink_to_fit();
    for index in (0..nodes.ids.len()).filter(|index| nodes.places[*index].is_none()) {
        oddities.add("node is missing in the file", || format!("node {}", nodes.ids[index]));
    }
    if nodes.places.iter().any(Option::is_some) {
        return Ok(extract);
    }
    let reason = "holds streets and no node of them, so that nothing has a place, as Overpass writes with `out geom` or \
                  without `>`; end the query with `(._; >;); out body;`";
    Err(nothing(path, reason))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROAD: [(&str, &str); 1] = [("highway", "primary")];

    #[test]
    fn ways_are_sorted_and_the_last_of_two_with_one_id_wins() {
        let (mut early, mut late) = (Streets::default(), Streets::default());
        early.way(7, &ROAD, &[1, 2]);
        early.way(5, &ROAD, &[2, 3]);
        late.way(7, &ROAD, &[8, 9, 10]);
        late.way(6, &[("building", "yes")], &[1, 2]);
        early.append(late);
        let extract = early.finish();
        assert_eq!(extract.ways.iter().map(|w| w.id).collect::<Vec<_>>(), [5, 7]);
        assert_eq!(extract.refs, [2, 3, 8, 9, 10]);
        assert_eq!(extract.nodes_of(&extract.ways[1]), [8, 9, 10]);
        assert_eq!(extract.oddities.count("two ways with one id"), 1);
    }

    #[test]
    fn a_way_of_one_node_is_counted() {
        let mut streets = Streets::default();
        streets.way(7, &ROAD, &[1]);
        let extract = streets.finish();
        assert_eq!(extract.ways, []);
        assert_eq!(extract.oddities.count("way with fewer than two nodes"), 1);
    }

    #[test]
    fn a_restriction_on_a_way_that_is_not_kept_is_counted() {
        use super::super::turns::Kind;
        let tags = [("type", "restriction"), ("restriction", "no_left_turn")];
        let mut streets = Streets::default();
        streets.way(1, &ROAD, &[1, 2]);
        streets.way(2, &ROAD, &[2, 3]);
        streets.way(3, &[("highway", "footway")], &[2, 4]);
        for (relation, to) in [(11, 2), (10, 3), (12, 99)] {
            let members = [(Kind::Way, 1, "from"), (Kind::Node, 2, "via"), (Kind::Way, to, "to")];
            streets.relation(relation, &tags, &members);
        }
        let extract = streets.finish();
        let kept = Restriction { from: 1, via: Via::Node(2), to: 2, only: false, when: None };
        assert_eq!(extract.restrictions, [kept]);
        let reason = "turn restriction on a way that is not drivable or not in the extract";
        assert_eq!(extract.oddities.count(reason), 2);
    }

    #[test]
    fn a_restriction_on_a_way_that_goes_on_through_its_node_is_counted() {
        use super::super::turns::Kind;
        let tags = [("type", "restriction"), ("restriction", "no_left_turn")];
        let mut streets = Streets::default();
        streets.way(1, &ROAD, &[1, 2, 3]);
        streets.way(2, &ROAD, &[2, 4]);
        for (relation, from, to) in [(10, 1, 2), (11, 2, 1)] {
            let members =
                [(Kind::Way, from, "from"), (Kind::Node, 2, "via"), (Kind::Way, to, "to")];
            streets.relation(relation, &tags, &members);
        }
        let extract = streets.finish();
        assert_eq!(extract.restrictions, []);
        let reason = "turn restriction on a way that does not end at the turn";
        assert_eq!(extract.oddities.count(reason), 2);
    }

    #[test]
    fn nodes_without_a_place_are_missing_and_later_ones_win() {
        let mut streets = Streets::default();
        streets.way(1, &ROAD, &[1, 2]);
        let mut extract = streets.finish();
        let mut places = Places::default();
        places.node(&extract.nodes, 1, &[], || Place::from_degrees(40.0, 500.0));
        places.node(&extract.nodes, 2, &[], || Place::from_degrees(40.0, 50.0));
        places.node(&extract.nodes, 2, &[], || Place::from_degrees(41.0, 50.0));
        places.node(&extract.nodes, 3, &[], || panic!("not wanted"));
        let signal = [("highway", "traffic_signals")];
        places.node(&extract.nodes, 4, &signal, || Place::from_degrees(42.0, 50.0));
        places.put(&mut extract);
        let extract = complete(Path::new("a"), extract).unwrap();
        assert_eq!(extract.nodes.places[0], None);
        assert_eq!(extract.nodes.places[1], Place::from_degrees(41.0, 50.0));
        assert_eq!(extract.signals.iter().map(|s| s.id).collect::<Vec<_>>(), [4]);
        for reason in [
            "node without a place on Earth",
            "two nodes with one id",
            "node is missing in the file",
        ] {
            assert_eq!(extract.oddities.count(reason), 1, "{reason}");
        }
    }
}
