use tsc_family::control_tasks::acrobot::Acrobot;
use tsc_family::control_tasks::episodes::Dynamics;
use tsc_family::control_tasks::half_cheetah::HalfCheetah;
use tsc_family::control_tasks::mountain_car::MountainCar;
use tsc_family::control_tasks::mujoco;
use tsc_family::control_tasks::pendulum::Pendulum;
use tsc_family::control_tasks::swimmer::Swimmer;

/// Largest difference: absolute, relative where numbers are larger than 1.
const TOLERANCE: f64 = 1e-12;

/// The same for whole episodes of an acrobot, in which a difference in the last digit of a sine grows.
const DRIFT: f64 = 1e-9;

struct Row {
    context: [f64; 3],
    start: bool,
    before: [f64; 2],
    action: f64,
    after: [f64; 2],
    reward: f64,
    terminated: bool,
}

fn numbers(name: &str) -> Vec<Vec<f64>> {
    let mut table = csv::Reader::from_path(format!("tests/control_tasks/{name}.csv")).unwrap();
    let row = |record: csv::StringRecord| record.iter().map(|n| n.parse().unwrap()).collect();
    table.records().map(|record| row(record.unwrap())).collect()
}

fn rows(name: &str) -> Vec<Row> {
    let row = |n: Vec<f64>| Row {
        context: n[..3].try_into().unwrap(),
        start: n[3] == 1.0,
        before: [n[4], n[5]],
        action: n[6],
        after: [n[7], n[8]],
        reward: n[9],
        terminated: n[10] == 1.0,
    };
    numbers(name).into_iter().map(row).collect()
}

pub(crate) fn close(ours: f64, gymnasium: f64, row: usize) {
    within(TOLERANCE, ours, gymnasium, row);
}

fn within(tolerance: f64, ours: f64, gymnasium: f64, row: usize) {
    let error = (ours - gymnasium).abs();
    assert!(error <= tolerance * gymnasium.abs().max(1.0), "row {row}: {ours} {gymnasium}");
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

#[test]
fn every_step_of_an_acrobot_is_gymnasium_s() {
    let (mut state, mut ends) = ([0.0; 4], 0);
    for (i, row) in numbers("acrobot").into_iter().enumerate() {
        let [first, second, mass, second_mass, start, action, rest @ ..] = row.as_slice() else {
            panic!("row {i} is short")
        };
        let acrobot = Acrobot {
            lengths_m: [*first, *second],
            masses_kg: [*mass, *second_mass],
            torque_nm: 1.0,
            start: 0.1,
        };
        let before: [f64; 4] = rest[..4].try_into().unwrap();
        if *start == 1.0 {
            state = before;
        }
        for (from, tolerance) in [(before, TOLERANCE), (state, DRIFT)] {
            let (after, terminated) = acrobot.step(from, action - 1.0);
            for (ours, theirs) in after.iter().zip(&rest[4..8]) {
                within(tolerance, *ours, *theirs, i);
            }
            assert_eq!(terminated, rest[8] == 1.0, "row {i}");
            state = after;
        }
        ends += usize::from(rest[8] == 1.0);
    }
    assert!(ends > 5, "{ends}");
}

/// Checks every tenth state of episodes in MuJoCo, which go on from our own states; `N` numbers make a state.
#[expect(clippy::print_stderr, reason = "says that it skips")]
fn check_model<D: Dynamics<State = [f64; N]>, const N: usize>(
    name: &str,
    make: impl Fn(&[f64]) -> D,
    begin: impl Fn(&D, [f64; N]) -> [f64; N],
) {
    // Versions differ in the last digits, which contacts make grow.
    match mujoco::version() {
        Ok(("4.0.0", _)) => {}
        Ok((version, _)) => {
            return eprintln!("skipped: the table is MuJoCo 4.0.0's, not {version}'s");
        }
        Err(e) => return eprintln!("skipped: {e}"),
    }
    let rows = numbers(name);
    let (mut made, mut state, mut reward) = (None, [0.0; N], 0.0);
    let (mut number, mut context) = (0_u64, u64::MAX);
    for (i, row) in rows.iter().enumerate() {
        let shown = N / 3 * 2;
        if row[3] == 0.0 {
            let dynamics = made.insert(make(&row[..3]));
            state[..shown].copy_from_slice(&row[4..4 + shown]);
            state = begin(dynamics, state);
            context = context.wrapping_add(1);
            number = context;
        } else {
            let dynamics = made.as_ref().unwrap();
            let mut action = vec![0.0; dynamics.actions().width()];
            for _ in 0..10 {
                action.fill_with(|| {
                    number = (1_103_515_245 * number + 12345) % (1 << 31);
                    (number >> 8) as f32 / (1 << 22) as f32 - 1.0
                });
                (reward, _) = dynamics.act(&mut state, &action);
            }
            close(reward, row[4 + shown], i);
        }
        state.iter().zip(&row[4..4 + shown]).for_each(|(ours, theirs)| close(*ours, *theirs, i));
    }
    assert!(rows.len() > 100 && context > 0);
}

#[test]
fn states_of_a_half_cheetah_are_gymnasium_s() {
    let make = |context: &[f64]| {
        HalfCheetah::new(context[0], 9.457333 * context[1], 0.6 * context[2].sqrt(), 0.1)
    };
    check_model("half-cheetah", make, HalfCheetah::begin);
}

#[test]
fn states_of_a_swimmer_are_gymnasium_s() {
    let make = |context: &[f64]| Swimmer::new(context.try_into().unwrap(), 10.0, 1e-4);
    check_model("swimmer", make, Swimmer::begin);
}
