//! Steps of pendulum and mountain car against gymnasium's.

use tsc_family::control_tasks::mountain_car::MountainCar;
use tsc_family::control_tasks::pendulum::Pendulum;

/// Largest difference: absolute, relative where numbers are larger than 1.
const TOLERANCE: f64 = 1e-12;

/// A row of a table.
struct Row {
    context: [f64; 3],
    start: bool,
    before: [f64; 2],
    action: f64,
    after: [f64; 2],
    reward: f64,
    terminated: bool,
}

fn rows(name: &str) -> Vec<Row> {
    let mut table = csv::Reader::from_path(format!("tests/control_tasks/{name}.csv")).unwrap();
    let row = |record: csv::StringRecord| {
        let n: Vec<f64> = record.iter().map(|n| n.parse().unwrap()).collect();
        Row {
            context: n[..3].try_into().unwrap(),
            start: n[3] == 1.0,
            before: [n[4], n[5]],
            action: n[6],
            after: [n[7], n[8]],
            reward: n[9],
            terminated: n[10] == 1.0,
        }
    };
    table.records().map(|record| row(record.unwrap())).collect()
}

fn close(ours: f64, gymnasium: f64, row: usize) {
    let error = (ours - gymnasium).abs();
    assert!(error <= TOLERANCE * gymnasium.abs().max(1.0), "row {row}: {ours} {gymnasium}");
}

/// Checks steps from gymnasium's states, and whole episodes from gymnasium's starts.
fn check(name: &str, step: impl Fn(&Row, [f64; 2]) -> (f64, [f64; 2], bool)) -> (usize, usize) {
    let rows = rows(name);
    let (mut state, mut episodes, mut ends) = ([0.0; 2], 0, 0);
    for (i, row) in rows.iter().enumerate() {
        if row.start {
            state = row.before;
            episodes += 1;
        }
        for from in [row.before, state] {
            let (reward, after, terminated) = step(row, from);
            close(reward, row.reward, i);
            close(after[0], row.after[0], i);
            close(after[1], row.after[1], i);
            assert_eq!(terminated, row.terminated, "row {i}");
            state = after;
        }
        ends += usize::from(row.terminated);
    }
    assert!(rows.len() > 1100);
    (episodes, ends)
}

#[test]
fn every_step_of_a_pendulum_is_gymnasium_s() {
    let (episodes, _) = check("pendulum", |row, state| {
        let [mass_kg, length_m, gravity_mps2] = row.context;
        let pendulum = Pendulum { mass_kg, length_m, gravity_mps2, max_torque_nm: 2.0 };
        let (reward, after) = pendulum.step(state, row.action);
        (reward, after, false)
    });
    assert_eq!(episodes, 9);
}

#[test]
fn every_step_of_a_mountain_car_is_gymnasium_s() {
    let (episodes, ends) = check("mountain-car", |row, state| {
        let [max_speed, goal, power] = row.context;
        MountainCar { max_speed, goal, power, start: [-0.6, -0.4] }.step(state, row.action as f32)
    });
    assert!(episodes > 5 && ends > 3, "{episodes} {ends}");
}
