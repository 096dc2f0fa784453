//! Junctions that have a signal although no node says so: on every street that leaves them, pedestrians cross at a signal.
//!
//! In some cities the signals of a junction are mapped by its crossings alone (`highway=crossing`,
//! `crossing=traffic_signals`). A stop or give-way sign at the junction or before it says that its vehicles have none.

use std::collections::{BTreeSet, HashSet};

use super::graph::{Graph, Step};

/// Farthest that a crossing may be from its junction, metres along the street: half of a wide street, a
/// corner, and the crossing.
const CROSSING_REACH_M: f64 = 35.0;

/// Fewest streets that leave a signalised junction.
const STREETS: usize = 3;

/// Returns the junctions of which every street has a crossing with a signal, sorted; the crossings with the
/// two carriageways of a divided street are looked at together.
pub(super) fn crossed_all_around(graph: &Graph<'_>, join_m: f64) -> Vec<u32> {
    let none = HashSet::new();
    let nodes = |ids: &[i64]| -> HashSet<u32> {
        ids.iter().filter_map(|id| graph.extract.nodes.index(*id)).map(|n| n as u32).collect()
    };
    let (crossings, signs) = (nodes(&graph.extract.crossings), nodes(&graph.extract.signs));
    let near: BTreeSet<u32> = crossings
        .iter()
        .flat_map(|node| graph.steps(*node))
        .filter_map(|step| {
            let chain = graph.chain_within(*step, CROSSING_REACH_M);
            let reached = graph.length_m(&chain.steps) <= CROSSING_REACH_M;
            (reached && graph.is_junction(chain.end, &none)).then_some(chain.end)
        })
        .collect();
    let mut seen: BTreeSet<u32> = BTreeSet::new();
    let mut found = BTreeSet::new();
    for start in near {
        if seen.contains(&start) {
            continue;
        }
        let cluster = cluster(graph, start, join_m, &crossings);
        seen.extend(&cluster);
        let inside = |node: u32| cluster.contains(&node);
        let streets: Vec<Step> = cluster
            .iter()
            .flat_map(|node| graph.steps(*node))
            .copied()
            .filter(|s| !inside(graph.chain(*s, &none, &inside).end))
            .collect();
        let signed = cluster.iter().any(|node| signs.contains(node))
            || streets.iter().any(|s| meets(graph, *s, &signs));
        let crossed = streets.iter().all(|s| meets(graph, *s, &crossings));
        if streets.len() >= STREETS && crossed && !signed {
            found.extend(cluster);
        }
    }
    found.into_iter().collect()
}

/// Returns a junction and those that short streets without a crossing join to it.
fn cluster(graph: &Graph<'_>, start: u32, join_m: f64, crossings: &HashSet<u32>) -> BTreeSet<u32> {
    let none = HashSet::new();
    let mut cluster = BTreeSet::from([start]);
    let mut queue = vec![start];
    while let Some(node) = queue.pop() {
        for step in graph.steps(node) {
            let chain = graph.chain(*step, &none, &|_| false);
            let joined = graph.is_junction(chain.end, &none)
                && graph.length_m(&chain.steps) <= join_m
                && !meets(graph, *step, crossings);
            if joined && cluster.insert(chain.end) {
                queue.push(chain.end);
            }
        }
    }
    cluster
}

fn meets(graph: &Graph<'_>, first: Step, nodes: &HashSet<u32>) -> bool {
    let chain = graph.chain_within(first, CROSSING_REACH_M);
    let mut metres = 0.0;
    chain.steps.iter().any(|step| {
        metres += graph.step_m(*step);
        metres <= CROSSING_REACH_M && nodes.contains(&graph.target(*step))
    })
}
