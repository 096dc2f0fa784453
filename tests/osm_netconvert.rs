//! Real extracts, read by this project and by netconvert: both have to see the same streets.
//!
//! netconvert gets the drivable ways of an extract with their raw tags, signals and turn
//! restrictions, and joins and guesses as users of SUMO let it. Compared are the intersections that
//! both call one signalised intersection: those that share an OSM node with exactly one of the
//! other's. Every difference is printed in a line (`-- --nocapture`).
//!
//! - **Untagged lanes.** netconvert has a default per class, this project the mode of the class in
//!   the extract. The test is about reading the map and not about guesses, so netconvert gets the
//!   mode as tag `lanes` of the ways without; the figures without that are printed, too.
//! - **Slip lanes** (`Arm::slip_lanes`) count as lanes of the arm here, while netconvert's edge
//!   ends where they fork off. They are left out of the comparison.
//! - **Centre lanes** (`Arm::centre_lanes`): an odd lane between the directions serves both here; for
//!   netconvert it is part of the direction in which the way is drawn. Incoming lanes are equal if
//!   netconvert's number lies between ours with and without the centre lanes.
//!
//! The figures without the last two conventions (`as they are`) are printed, too.
#![expect(clippy::unwrap_used, reason = "a test may panic")]
#![expect(clippy::print_stdout, reason = "the differences are the result")]

#[path = "osm_netconvert/raw.rs"]
mod raw;
#[path = "osm_netconvert/sumo.rs"]
mod sumo;

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fs;
use std::path::{Path, PathBuf};

use raw::Raw;
use sumo::SumoSignal;
use tsc_family::osm::arms::Arm;
use tsc_family::osm::config::OsmConfig;
use tsc_family::osm::extract::Extract;
use tsc_family::osm::graph::Graph;
use tsc_family::osm::intersections::{Found, Intersection, intersections};
use tsc_family::osm::read::read;
use tsc_family::osm::streets::{Source, Streets};
use tsc_family::osm::tags::Direction;

/// Where extracts are, if they are there.
const EXTRACTS: &str = "../shared/data/osm";

/// Extracts that are large enough for an assertion.
const ASSERTED: [&str; 2] = ["r5_washington_dc.osm.pbf", "valhalla_harrisburg.osm.pbf"];

/// Least share of intersections with equal arms, and of those with equal incoming lanes.
const LEAST_AGREEMENT: f64 = 0.9;

/// Fewest arms, and fewest with incoming lanes, of what is a signalised intersection here.
const FEWEST: (usize, usize) = (3, 2);

/// How many of some intersections are equal.
#[derive(Debug, Default, Clone, Copy)]
struct Agreement {
    both: u32,
    arms: u32,
    /// Without slip lanes and up to centre lanes.
    lanes: u32,
    all: u32,
    /// Slip and centre lanes counted.
    lanes_as_they_are: u32,
    tagged: u32,
    tagged_lanes: u32,
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

    /// Our incoming lanes: with everything, without slip lanes, without centre lanes either.
    fn lanes(&self) -> (u32, u32, u32) {
        let sum = |f: fn(&Arm) -> u32| self.ours.arms.iter().map(f).sum();
        let (all, slip, centre): (u32, u32, u32) =
            (sum(|a| a.lanes_in), sum(|a| a.slip_lanes), sum(|a| a.centre_lanes));
        (all, all - slip, all - slip - centre)
    }

    fn sumo_lanes(&self) -> u32 {
        self.sumo.arms.iter().map(|a| a.lanes_in).sum()
    }

    fn lanes_equal(&self) -> bool {
        let (_, most, least) = self.lanes();
        (least..=most).contains(&self.sumo_lanes())
    }

    fn tagged(&self) -> bool {
        let inwards = self.ours.arms.iter().filter(|a| a.lanes_in > 0);
        inwards.into_iter().all(|a| a.lanes_source == Source::Tagged)
    }

    /// Per arm: bearing, lanes in (slip lanes and centre lanes among them), lanes out.
    fn line(&self) -> String {
        let (all, most, least) = self.lanes();
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
        let differs = match (self.arms_equal(), self.lanes_equal()) {
            (false, false) => "arms and lanes",
            (false, true) => "arms",
            _ => "lanes",
        };
        format!(
            "{differs}: {} {} ({}): arms {}/{}, incoming lanes {all} ({least} to {most})/{}; {}; {} [{}]",
            self.ours.id,
            place(self.ours.centre.latitude(), self.ours.centre.longitude()),
            streets.join(", "),
            self.ours.arms.len(),
            self.sumo.arms.len(),
            self.sumo_lanes(),
            ours.collect::<Vec<_>>().join(" "),
            sumo.collect::<Vec<_>>().join(" "),
            self.sumo.id,
        )
    }
}

fn place(latitude: f64, longitude: f64) -> String {
    format!("{latitude:.6},{longitude:.6}")
}

fn agreement(pairs: &[Pair<'_>]) -> Agreement {
    let count =
        |holds: &dyn Fn(&Pair<'_>) -> bool| pairs.iter().filter(|p| holds(p)).count() as u32;
    Agreement {
        both: pairs.len() as u32,
        arms: count(&|p| p.arms_equal()),
        lanes: count(&|p| p.lanes_equal()),
        all: count(&|p| p.arms_equal() && p.lanes_equal()),
        lanes_as_they_are: count(&|p| p.lanes().0 == p.sumo_lanes()),
        tagged: count(&|p| p.tagged()),
        tagged_lanes: count(&|p| p.tagged() && p.lanes_equal()),
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

/// Returns the number of lanes by which this project counts ways without a usable tag, by way.
fn assumed_lanes(extract: &Extract, config: &OsmConfig) -> HashMap<i64, u32> {
    let streets = Streets::new(extract, &config.streets);
    let mut assumed = HashMap::new();
    for way in &extract.ways {
        let directions = match way.street.direction {
            Direction::Both => vec![true, false],
            Direction::Forward => vec![true],
            Direction::Backward => vec![false],
        };
        let lanes = directions.iter().map(|forward| streets.lanes(&way.street, *forward));
        let lanes: Vec<_> = lanes.collect();
        if lanes.iter().all(|l| l.source != Source::Tagged) {
            let centre = u32::from(lanes.iter().any(|l| l.centre));
            let own: u32 = lanes.iter().map(|l| l.lanes - u32::from(l.centre)).sum();
            assumed.insert(way.id, own + centre);
        }
    }
    assumed
}

fn sumo_signals(raw: &Raw, lanes: &HashMap<i64, u32>) -> Vec<SumoSignal> {
    let folder = tempfile::tempdir().unwrap();
    let osm = folder.path().join("streets.osm");
    fs::write(&osm, raw.xml(lanes)).unwrap();
    let mut signals = sumo::signals(&osm);
    signals.retain(|s| {
        let ways_in = s.arms.iter().filter(|a| a.lanes_in > 0).count();
        s.arms.len() >= FEWEST.0 && ways_in >= FEWEST.1
    });
    signals
}

fn report(title: &str, a: Agreement) {
    let share =
        |n: u32, of: u32| format!("{n}/{of} ({:.1}%)", 100.0 * f64::from(n) / f64::from(of.max(1)));
    println!(
        "  {title}: both have {}; equal arms {}; equal incoming lanes {}, where all are tagged {}, as they \
         are {}; both equal {}",
        a.both,
        share(a.arms, a.both),
        share(a.lanes, a.both),
        share(a.tagged_lanes, a.tagged),
        share(a.lanes_as_they_are, a.both),
        share(a.all, a.both),
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
    let config = OsmConfig::default();
    let found = intersections(&Graph::new(&extract), &config, &[]);
    let raw = Raw::read(path);
    let by_default = sumo_signals(&raw, &HashMap::new());
    let sumo = sumo_signals(&raw, &assumed_lanes(&extract, &config));
    println!(
        "{}: ours {}, netconvert's {}",
        path.file_name().unwrap().display(),
        found.intersections.len(),
        sumo.len()
    );
    report(
        "netconvert's lanes where untagged",
        agreement(&pairs(&found.intersections, &by_default)),
    );
    let pairs = pairs(&found.intersections, &sumo);
    let agreement = agreement(&pairs);
    report("lanes of the class where untagged", agreement);
    for pair in pairs.iter().filter(|p| !(p.arms_equal() && p.lanes_equal())) {
        println!("  {}", pair.line());
    }
    report_others(&raw, &found, &sumo, &pairs);
    agreement
}

fn extracts() -> Vec<PathBuf> {
    let Ok(folder) = fs::read_dir(EXTRACTS) else { return Vec::new() };
    let mut paths: Vec<PathBuf> = folder.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths
}

#[test]
fn netconvert_sees_the_same_arms_and_lanes() {
    let extracts = extracts();
    if extracts.is_empty() || !sumo::is_there() {
        println!("skipped: this test needs {EXTRACTS} and netconvert");
        return;
    }
    let agreements: Vec<_> = extracts.iter().map(|path| (path, compare(path))).collect();
    for (path, agreement) in agreements {
        let name = path.file_name().unwrap().to_string_lossy();
        if ASSERTED.contains(&&*name) {
            let least = LEAST_AGREEMENT * f64::from(agreement.both);
            assert!(f64::from(agreement.arms) >= least, "{name}: arms of {agreement:?}");
            assert!(f64::from(agreement.lanes) >= least, "{name}: lanes of {agreement:?}");
        }
    }
}
