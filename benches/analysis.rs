//! Reports and estimates over large families: time and memory.
//!
//! `cargo bench --bench analysis`, without SUMO; prints Markdown. Results directories are made up: settings and metrics of
//! a published one, scores that depend on features and method, with noise per seed.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark may panic and print")]

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use tsc_family::sample::{Draw, Sampling};
use tsc_family::seed;
use tsc_family::store::Layout;
use tsc_family::store::manifest::{Manifest, PointRow, Task};
use tsc_family::store::record::{Record, Row, RowKind, TaskResult};
use tsc_family::store::wall::Wall;

/// Families that are measured: methods, point MDPs, evaluation seeds.
const FAMILIES: [[usize; 3]; 3] = [[12, 1000, 2], [12, 1000, 5], [12, 8_334, 2]];

/// Published results whose manifest is the model of all.
const MODEL: &str = "results/salt-lake-city/resco";

/// Names and plausible means of the metrics beside the objective.
const METRICS: [(&str, f64); 9] = [
    ("collisions", 0.0),
    ("max_queue_veh", 20.0),
    ("queue_veh", 7.0),
    ("teleports", 0.0),
    ("throughput_veh", 2000.0),
    ("undeparted_veh", 0.0),
    ("unfinished_veh", 25.0),
    ("vehicles_veh", 2025.0),
    ("waiting_s", 13.0),
];

/// How often the memory of a command is looked at.
const POLL: Duration = Duration::from_millis(5);

fn main() {
    // `cargo test --benches` builds and starts this too; only `cargo bench` passes `--bench`.
    if !std::env::args().any(|a| a == "--bench") {
        return;
    }
    println!("### Reports\n");
    println!("| methods x point MDPs x seeds | tasks | s | processor, s | peak, MB |");
    println!("|---|---|---|---|---|");
    for size @ [methods, points, seeds] in FAMILIES {
        let folder = tempfile::tempdir().unwrap();
        let dir = folder.path().join("r");
        make(&dir, size);
        let Measure { wall_s, processor_s, peak_mb } =
            measure(&["report".to_owned(), dir.display().to_string()]);
        println!(
            "| {methods} x {points} x {seeds} | {} | {wall_s:.1} | {processor_s:.1} | {peak_mb:.0} |",
            points * methods
        );
    }
    println!();
}

/// What a command took.
struct Measure {
    wall_s: f64,
    processor_s: f64,
    peak_mb: f64,
}

/// Runs a command of the program and returns what it took.
fn measure(arguments: &[String]) -> Measure {
    let start = Instant::now();
    let mut child = Command::new(env!("CARGO_BIN_EXE_tsc-family"))
        .args(arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let (mut peak_mb, mut processor_s) = (0.0, 0.0);
    while child.try_wait().unwrap().is_none() {
        let of = |file: &str| fs::read_to_string(format!("/proc/{}/{file}", child.id()));
        let status = of("status").unwrap_or_default();
        let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let peak = peak.and_then(|p| p.trim().trim_end_matches("kB").trim().parse::<f64>().ok());
        peak_mb = f64::max(peak_mb, peak.unwrap_or(0.0) * 1024.0 / 1e6);
        // Fields 14 and 15, of which the 12th and 13th follow the name in brackets; hundredths of a second.
        let stat = of("stat").unwrap_or_default();
        let fields = stat.rsplit_once(')').map_or("", |(_, rest)| rest).split_whitespace();
        let ticks: f64 = fields.skip(11).take(2).filter_map(|f| f.parse::<f64>().ok()).sum();
        processor_s = f64::max(processor_s, ticks / 100.0);
        std::thread::sleep(POLL);
    }
    assert!(child.wait().unwrap().success(), "{arguments:?} failed");
    Measure { wall_s: start.elapsed().as_secs_f64(), processor_s, peak_mb }
}

/// Makes up the results of so many methods on so many point MDPs with so many seeds, all of the family.
fn make(dir: &Path, [methods, points, seeds]: [usize; 3]) {
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join(MODEL);
    let mut manifest = Manifest::read(&Layout::new(model)).unwrap();
    let identity = &mut manifest.identity;
    identity.scenario = format!("made-up-{points}");
    identity.methods = vec![identity.baseline.clone()];
    identity.methods.extend((1..methods).map(|m| format!("method-{m:02}")));
    identity.evaluation_seeds = (0..seeds as u64).collect();
    let rows = &identity.points;
    let made = (0..points).map(|i| {
        let mut rng = ChaCha8Rng::seed_from_u64(i as u64);
        let like = &rows[i % rows.len()];
        let features = like.features.iter().map(|f| f * (0.8 + 0.4 * rng.random::<f64>()));
        let features: Vec<f64> = features.collect();
        PointRow {
            point: format!("p{i:06}"),
            importance: 0.2 + rng.random::<f64>(),
            instances: 1,
            features,
            places: Vec::new(),
            content: String::new(),
            environment: like.environment.clone(),
            ..PointRow { sha256: Default::default(), ..like.clone() }
        }
    });
    let mut made: Vec<PointRow> = made.collect();
    let total: f64 = made.iter().map(|p| p.importance).sum();
    made.iter_mut().for_each(|p| p.importance /= total);
    let draw = |p: &PointRow| Draw {
        point: p.point.clone(),
        weight: p.importance,
        count: 1,
        inclusion: None,
    };
    identity.sample.sampling = Sampling::All;
    identity.sample.draws = made.iter().map(draw).collect();
    (identity.sample.budget, identity.sample.family_size) = (points, points);
    identity.points = made;
    let tasks = identity.tasks();
    let layout = Layout::new(dir);
    fs::create_dir_all(dir).unwrap();
    fs::write(layout.manifest(), serde_json::to_vec(&manifest).unwrap()).unwrap();
    let sha256 = manifest.sha256();
    for task in tasks.iter().step_by(1000) {
        fs::create_dir_all(layout.record(task.task).parent().unwrap()).unwrap();
    }
    tasks.par_iter().for_each(|task| {
        let point =
            &manifest.identity.points[task.task / (tasks.len() / manifest.identity.points.len())];
        let method = manifest.identity.methods.iter().position(|m| *m == task.method).unwrap();
        let record = record(task, point, (method, seeds), &sha256);
        let mut text = serde_json::to_string(&record.summary).unwrap() + "\n";
        for row in &record.rows {
            text += &(serde_json::to_string(row).unwrap() + "\n");
        }
        fs::write(layout.record(task.task), text).unwrap();
    });
}

/// Makes up the record of a task.
fn record(task: &Task, point: &PointRow, (method, seeds): (usize, usize), sha256: &str) -> Record {
    let mut rng = ChaCha8Rng::seed_from_u64(task.seed);
    let [lanes, .., inflow, _, _] = point.features[..] else { panic!("six features") };
    let level = 15.0 + inflow / lanes / 8.0;
    let good = 1.0 - 0.04 * method as f64 + 0.1 * rng.random::<f64>();
    let row = |episode: usize| {
        let noise = 0.9 + 0.2 * rng.random::<f64>();
        let metric = |(name, mean): &(&str, f64)| ((*name).to_owned(), mean * noise);
        let mut metrics: tsc_family::store::record::Metrics = METRICS.iter().map(metric).collect();
        metrics.insert("delay_s".to_owned(), level * good * noise);
        let seed = seed::at_point(episode as u64, &point.point);
        Row { kind: RowKind::Evaluation, episode: episode as u32, seed, metrics }
    };
    let rows = (0..seeds).map(row).collect();
    let wall = Wall { wall_s: 1.0, simulator_s: 0.9, attempts: 1, ..Wall::default() };
    Record::finished(task, sha256, TaskResult { rows, wall, ..TaskResult::default() })
}
