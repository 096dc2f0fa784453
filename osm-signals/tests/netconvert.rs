//! Extracts, read by this project and by netconvert: both have to see the same streets. Hand-made ones are there
//! always, those of real cities where they are.
//!
//! netconvert gets the extract as it is, whatever this project takes for a street, and leaves out by its own
//! options what cars may not use and service roads. It joins and guesses as users of SUMO let it. Compared
//! are the intersections that both call one signalised intersection: those that share an OSM node with exactly
//! one of the other's. Every difference is printed in a line (`-- --nocapture`).
//!
//! - **Arms**: intersections with the same number of arms.
//! - **Tagged lanes**: approaches whose number of lanes is tagged, at intersections with the same number of
//!   arms. Where no tag says it, both sides guess, and a comparison would say nothing about reading the map.
//! - **Slip lanes** (`Arm::slip_lanes`) count as lanes of the arm here, while netconvert's edge
//!   ends where they fork off. They are left out of the comparison.
//! - **Centre lanes** (`Arm::centre_lanes`): an odd lane between the directions serves both here; for
//!   netconvert it is part of the direction in which the way is drawn. Lanes are equal if netconvert's
//!   number lies between ours with and without the centre lanes.
//!
//! Extracts of one's own are compared with `TSC_FAMILY_EXTRACTS=FOLDER`.
#![expect(clippy::unwrap_used, reason = "a test may panic")]
#![expect(clippy::print_stdout, reason = "the differences are the result")]

#[path = "netconvert/raw.rs"]
mod raw;
#[path = "netconvert/sumo.rs"]
mod sumo;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use osm_signals::arms::Arm;
use osm_signals::graph::Graph;
use osm_signals::intersections::{Found, Intersection, intersections};
use osm_signals::read::read;
use osm_signals::settings::Settings;
use osm_signals::streets::Source;
use raw::Raw;
use sumo::{Conventions, SumoSignal};

/// Where extracts are, if they are there.
const EXTRACTS: &str = "../../shared/data/osm";

/// Extracts that are large enough for an assertion.
const ASSERTED: [&str; 2] = ["r5_washington_dc.osm.pbf", "valhalla_harrisburg.osm.pbf"];

/// Hand-made extracts that netconvert refuses: values that no tag may have.
const REFUSED: &str = "bad_values";

/// Fewest intersections that both see in the hand-made extracts.
const FEWEST_CASES: u32 = 50;

/// Least share of intersections with equal arms, and of tagged approaches with equal lanes.
const LEAST_AGREEMENT: f64 = 0.93;

/// Fewest arms, and fewest with incoming lanes, of what is a signalised intersection here.
const FEWEST: (usize, usize) = (3, 2);

/// How many of some intersections and approaches are equal.
#[derive(Debug, Default, Clone, Copy)]
struct Agreement {
    /// Intersections that both have.
    both: u32,
    /// Those with the same number of arms.
    arms: u32,
    /// Approaches of these with tagged lanes.
    tagged: u32,
    /// Those with the same number of lanes.
    lanes: u32,
    /// Intersections of ours, and of netconvert's.
    all: (u32, u32),
}

/// One of ours and the one of netconvert's that it shares nodes with.
struct Pair<'a> {
    ours: &'a Intersection,
    sumo: &'a SumoSignal,
}

impl Pair<'_> {
    fn arms_equal(&self) -> bool {
        self.ours.arms.len() == self.sumo.arms.len()
    }

    /// Approaches with tagged lanes, and those of them for which netconvert has the same number.
    fn tagged(&self) -> (u32, u32) {
        if !self.arms_equal() {
            return (0, 0);
        }
        let count = self.ours.arms.len();
        let apart = |shift: usize| -> f64 {
            let arm = |i: usize| &self.sumo.arms[(i + shift) % count];
            let of = |(i, a): (usize, &Arm)| angle_deg(a.bearing_deg, arm(i).bearing_deg);
            self.ours.arms.iter().enumerate().map(of).sum()
        };
        let shift = (0..count).min_by(|a, b| apart(*a).total_cmp(&apart(*b))).unwrap();
        let arms = self.ours.arms.iter().enumerate();
        let mut found = (0, 0);
        for (i, arm) in arms.filter(|(_, a)| a.lanes_in > 0 && a.lanes_source == Source::Tagged) {
            let most = arm.lanes_in - arm.slip_lanes;
            let theirs = self.sumo.arms[(i + shift) % count].lanes_in;
            found.0 += 1;
            found.1 += u32::from((most - arm.centre_lanes..=most).contains(&theirs));
        }
        found
    }

    fn equal(&self) -> bool {
        let (tagged, equal) = self.tagged();
        self.arms_equal() && tagged == equal
    }

    /// Per arm: bearing, lanes in (slip lanes and centre lanes among them), lanes out.
    fn line(&self) -> String {
        let ours = self.ours.arms.iter().map(|a| {
            let extra = match (a.slip_lanes, a.centre_lanes) {
                (0, 0) => String::new(),
                (slip, centre) => format!(" ({slip} slip {centre} centre)"),
            };
            format!("{:.0} deg {}{extra} in {} out,", a.bearing_deg, a.lanes_in, a.lanes_out)
        });
        let sumo = self.sumo.arms.iter().map(|a| {
            let edges = a.edges.join(" ");
            format!("{:.0} deg {} in {} out ({edges}),", a.bearing_deg, a.lanes_in, a.lanes_out)
        });
        let streets: Vec<&str> = self.ours.streets().into_iter().collect();
        format!(
            "{}: {} {} ({}): arms {}/{}; {}; {} [{}]",
            if self.arms_equal() { "lanes" } else { "arms" },
            self.ours.id,
            place(self.ours.centre.latitude(), self.ours.centre.longitude()),
            streets.join(", "),
            self.ours.arms.len(),
            self.sumo.arms.len(),
            ours.collect::<Vec<_>>().join(" "),
            sumo.collect::<Vec<_>>().join(" "),
            self.sumo.id,
        )
    }
}

fn angle_deg(a: f64, b: f64) -> f64 {
    ((a - b + 540.0).rem_euclid(360.0) - 180.0).abs()
}

fn place(latitude: f64, longitude: f64) -> String {
    format!("{latitude:.6},{longitude:.6}")
}

fn agreement(pairs: &[Pair<'_>], all: (usize, usize)) -> Agreement {
    let sum = |f: &dyn Fn(&Pair<'_>) -> u32| pairs.iter().map(f).sum();
    Agreement {
        both: pairs.len() as u32,
        arms: sum(&|p| u32::from(p.arms_equal())),
        tagged: sum(&|p| p.tagged().0),
        lanes: sum(&|p| p.tagged().1),
        all: (all.0 as u32, all.1 as u32),
    }
}

/// Returns the pairs of one of ours and one of netconvert's that share nodes with each other only.
fn pairs<'a>(ours: &'a [Intersection], sumo: &'a [SumoSignal]) -> Vec<Pair<'a>> {
    let mut at: BTreeMap<i64, BTreeSet<usize>> = BTreeMap::new();
    for (i, node) in ours.iter().enumerate().flat_map(|(i, o)| o.nodes.iter().map(move |n| (i, n)))
    {
        at.entry(*node).or_default().insert(i);
    }
    let met = |s: &SumoSignal| -> BTreeSet<usize> {
        s.nodes.iter().filter_map(|n| at.get(n)).flatten().copied().collect()
    };
    let met: Vec<BTreeSet<usize>> = sumo.iter().map(met).collect();
    let mut pairs = Vec::new();
    for (signal, own) in sumo.iter().zip(&met).filter(|(_, own)| own.len() == 1) {
        let index = own.first().copied().unwrap();
        if met.iter().filter(|m| m.contains(&index)).count() == 1 {
            pairs.push(Pair { ours: &ours[index], sumo: signal });
        }
    }
    pairs
}

fn network(raw: &Raw) -> String {
    let folder = tempfile::tempdir().unwrap();
    let osm = folder.path().join("streets.osm");
    fs::write(&osm, raw.xml()).unwrap();
    sumo::network(&osm)
}

fn sumo_signals(network: &str, conventions: &Conventions) -> Vec<SumoSignal> {
    let mut signals = sumo::signals(network, conventions);
    signals.retain(|s| {
        let ways_in = s.arms.iter().filter(|a| a.lanes_in > 0).count();
        s.arms.len() >= FEWEST.0 && ways_in >= FEWEST.1
    });
    signals
}

fn report(name: &str, a: Agreement) {
    let share = |n: u32, of: u32| {
        format!("{n} of {of} ({:.1}%)", 100.0 * f64::from(n) / f64::from(of.max(1)))
    };
    println!(
        "{name}: ours {}, netconvert's {}, both {}; equal arms {}; tagged approaches with equal lanes {}",
        a.all.0,
        a.all.1,
        a.both,
        share(a.arms, a.both),
        share(a.lanes, a.tagged),
    );
}

/// Prints the intersections that only one side has, or that one side splits.
fn report_others(raw: &Raw, found: &Found, sumo: &[SumoSignal], pairs: &[Pair<'_>]) {
    let meet = |o: &Intersection, s: &SumoSignal| o.nodes.iter().any(|n| s.nodes.contains(n));
    for ours in found.intersections.iter().filter(|o| pairs.iter().all(|p| p.ours.id != o.id)) {
        let theirs = sumo.iter().filter(|s| meet(ours, s)).map(|s| s.id.as_str());
        println!(
            "  ours alone: {} {} with {} arms, nodes {:?}; netconvert has {:?}",
            ours.id,
            place(ours.centre.latitude(), ours.centre.longitude()),
            ours.arms.len(),
            ours.nodes,
            theirs.collect::<Vec<_>>()
        );
    }
    for theirs in sumo.iter().filter(|s| pairs.iter().all(|p| p.sumo.id != s.id)) {
        let ours = found.intersections.iter().filter(|o| meet(o, theirs)).map(|o| o.id.as_str());
        let skipped =
            found.skipped.iter().filter(|s| s.signals.iter().any(|n| theirs.nodes.contains(n)));
        println!(
            "  netconvert's alone: {} {} with {} arms; ours {:?}, skipped {:?}",
            theirs.id,
            theirs
                .nodes
                .first()
                .map_or_else(String::new, |n| place(raw.nodes[n].0, raw.nodes[n].1)),
            theirs.arms.len(),
            ours.collect::<Vec<_>>(),
            skipped.map(|s| s.reason.reason()).collect::<Vec<_>>()
        );
    }
}

fn compare(path: &Path) -> Agreement {
    let extract = read(path, &|_, _| {}).unwrap();
    let found = intersections(&Graph::new(&extract), &Settings::default(), &[], &[]);
    let raw = Raw::read(path);
    let network = network(&raw);
    let name = path.file_name().unwrap().to_string_lossy();
    let as_it_is = sumo_signals(&network, &Conventions::default());
    let counts = (found.intersections.len(), as_it_is.len());
    report(
        &format!("{name}, as it is"),
        agreement(&pairs(&found.intersections, &as_it_is), counts),
    );
    let sumo = sumo_signals(&network, &Conventions { closed: raw.closed(), side_by_side: true });
    let pairs = pairs(&found.intersections, &sumo);
    let agreement = agreement(&pairs, (found.intersections.len(), sumo.len()));
    report(&format!("{name}, with our conventions"), agreement);
    for pair in pairs.iter().filter(|p| !p.equal()) {
        println!("  {}", pair.line());
    }
    report_others(&raw, &found, &sumo, &pairs);
    agreement
}

fn extracts(folder: &str) -> Vec<PathBuf> {
    let Ok(folder) = fs::read_dir(folder) else { return Vec::new() };
    let mut paths: Vec<PathBuf> = folder.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths
}

/// Fails if too few intersections have equal arms, or too few tagged approaches equal lanes.
fn assert_agreement(name: &str, agreement: Agreement) {
    let least = |all: u32| LEAST_AGREEMENT * f64::from(all);
    assert!(f64::from(agreement.arms) >= least(agreement.both), "{name}: {agreement:?}");
    assert!(f64::from(agreement.lanes) >= least(agreement.tagged), "{name}: {agreement:?}");
}

#[test]
fn netconvert_sees_the_same_arms_and_lanes_in_hand_made_extracts() {
    if !sumo::is_there() {
        writeln!(std::io::stderr(), "skipped: this test needs netconvert").unwrap();
        return;
    }
    let mut all = Agreement::default();
    for case in extracts("tests/networks") {
        if !case.is_dir() || case.file_name().is_some_and(|name| name == REFUSED) {
            continue;
        }
        let one = compare(&case.join("input.osm"));
        (all.both, all.arms) = (all.both + one.both, all.arms + one.arms);
        (all.tagged, all.lanes) = (all.tagged + one.tagged, all.lanes + one.lanes);
    }
    assert!(all.both >= FEWEST_CASES, "{all:?}");
    assert_agreement("hand-made extracts", all);
}

#[test]
fn netconvert_sees_the_same_arms_and_lanes_in_cities() {
    let own = std::env::var("TSC_FAMILY_EXTRACTS");
    let folder = own.as_deref().unwrap_or(EXTRACTS);
    let extracts = extracts(folder);
    if extracts.is_empty() || !sumo::is_there() {
        writeln!(std::io::stderr(), "skipped: this test needs {folder} and netconvert").unwrap();
        return;
    }
    let name = |path: &PathBuf| path.file_name().unwrap().to_string_lossy().into_owned();
    let asserted = |path: &PathBuf| ASSERTED.contains(&&*name(path));
    assert!(own.is_ok() || extracts.iter().any(asserted), "none of {ASSERTED:?} is there");
    // Differences of the others are only printed, for whoever gives a folder.
    std::thread::scope(|scope| {
        for path in extracts.iter().filter(|path| own.is_ok() || asserted(path)) {
            scope.spawn(move || {
                let agreement = compare(path);
                if asserted(path) {
                    assert_agreement(&name(path), agreement);
                }
            });
        }
    });
}
