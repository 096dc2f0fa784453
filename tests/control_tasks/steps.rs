use csv::StringRecord;
use tsc_family::cartpole::{self, Context, Variant, fell};
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

/// The names of a table's columns, and its rows.
fn table(name: &str) -> (StringRecord, Vec<StringRecord>) {
    let mut table = csv::Reader::from_path(format!("tests/control_tasks/{name}.csv")).unwrap();
    (table.headers().unwrap().clone(), table.records().map(Result::unwrap).collect())
}

fn numbers<'a>(cells: impl IntoIterator<Item = &'a str>) -> Vec<f64> {
    cells.into_iter().map(|cell| cell.parse().unwrap()).collect()
}

fn within(tolerance: f64, ours: f64, gymnasium: f64, row: usize) {
    let error = (ours - gymnasium).abs();
    assert!(error <= tolerance * gymnasium.abs().max(1.0), "row {row}: {ours} {gymnasium}");
}

/// Checks steps from gymnasium's states, and whole episodes from gymnasium's starts, which may drift apart by so much.
/// `step` makes of context, state and action the next state, the reward where the table has it, and whether it is the end.
fn check<const N: usize>(
    name: &str,
    drift: f64,
    step: impl Fn(&[&str], [f64; N], f64) -> ([f64; N], Option<f64>, bool),
) {
    let (names, rows) = table(name);
    let column = |name: &str| names.iter().position(|other| other == name);
    let start = column("start").unwrap();
    let states = names.iter().filter_map(|name| Some((name, column(&format!("{name}_after"))?)));
    let states: Vec<_> = states.map(|(name, after)| (column(name).unwrap(), after)).collect();
    let (mut state, mut episodes, mut ends) = ([0.0; N], 0, 0);
    for (i, row) in rows.iter().enumerate() {
        let number = |name: &str| numbers(column(name).map(|at| &row[at]));
        let before = numbers(states.iter().map(|(at, _)| &row[*at])).try_into().unwrap();
        let context: Vec<&str> = row.iter().take(start).collect();
        if number("start") == [1.0] {
            state = before;
            episodes += 1;
        }
        for (from, tolerance) in [(before, TOLERANCE), (state, drift)] {
            let (after, reward, terminated) = step(&context, from, number("action")[0]);
            for (ours, (_, at)) in after.iter().zip(&states) {
                within(tolerance, *ours, numbers([&row[*at]])[0], i);
            }
            assert_eq!(reward.is_some(), column("reward").is_some());
            reward
                .iter()
                .zip(number("reward"))
                .for_each(|(ours, n)| within(tolerance, *ours, n, i));
            assert_eq!(f64::from(u8::from(terminated)), number("terminated")[0], "row {i}");
            ends += usize::from(terminated);
            state = after;
        }
    }
    assert!(rows.len() > 1000 && episodes > 5, "{episodes} episodes");
    assert!(ends > 5 || name == "pendulum", "{ends} ends");
}

#[test]
fn every_step_of_a_pole_is_gymnasium_s() {
    check("cartpole", TOLERANCE, |context, state, action| {
        let numbers = numbers(context[1..].iter().copied());
        let [length_m, masscart_kg, masspole_kg, force_n, gravity_mps2] = numbers[..] else {
            panic!("a context of {} numbers", numbers.len())
        };
        let variant = match context[0] {
            "carl-compat" => Variant::CarlCompat,
            "physical" => Variant::Physical,
            other => panic!("no variant {other}"),
        };
        let pole = Context { length_m, masscart_kg, masspole_kg, force_n, gravity_mps2 };
        let after = cartpole::Dynamics::new(pole, variant).step(state, action == 1.0);
        (after, Some(1.0), fell(&after))
    });
}

#[test]
fn every_step_of_a_pendulum_is_gymnasium_s() {
    check("pendulum", TOLERANCE, |context, state, action| {
        let [mass_kg, length_m, gravity_mps2] =
            numbers(context.iter().copied()).try_into().unwrap();
        let pendulum = Pendulum { mass_kg, length_m, gravity_mps2, max_torque_nm: 2.0 };
        let (reward, after) = pendulum.step(state, action);
        (after, Some(reward), false)
    });
}

#[test]
fn every_step_of_a_mountain_car_is_gymnasium_s() {
    check("mountain-car", TOLERANCE, |context, state, action| {
        let [max_speed, goal, power] = numbers(context.iter().copied()).try_into().unwrap();
        let car = MountainCar { max_speed, goal, power, start: [-0.6, -0.4] };
        let (reward, after, terminated) = car.step(state, action as f32);
        (after, Some(reward), terminated)
    });
}

#[test]
fn every_step_of_an_acrobot_is_gymnasium_s() {
    check("acrobot", DRIFT, |context, state, action| {
        let [first, second, mass, second_mass] =
            numbers(context.iter().copied()).try_into().unwrap();
        let acrobot = Acrobot {
            lengths_m: [first, second],
            masses_kg: [mass, second_mass],
            torque_nm: 1.0,
            start: 0.1,
        };
        let (after, terminated) = acrobot.step(state, action - 1.0);
        (after, None, terminated)
    });
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
    let rows: Vec<Vec<f64>> = table(name).1.iter().map(numbers).collect();
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
            within(TOLERANCE, reward, row[4 + shown], i);
        }
        for (ours, theirs) in state.iter().zip(&row[4..4 + shown]) {
            within(TOLERANCE, *ours, *theirs, i);
        }
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
