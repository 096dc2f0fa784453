//! CartPole's steps against gymnasium's.

use super::steps::close;
use tsc_family::cartpole::{Context, Dynamics, State, Variant, fell};

struct Row {
    dynamics: Dynamics,
    start: bool,
    before: State,
    right: bool,
    after: State,
    terminated: bool,
}

fn rows() -> Vec<Row> {
    let mut table = csv::Reader::from_path("tests/control_tasks/cartpole.csv").unwrap();
    let row = |record: csv::StringRecord| {
        let n: Vec<f64> = record.iter().skip(1).map(|n| n.parse().unwrap()).collect();
        let [length_m, masscart_kg, masspole_kg, force_n, gravity_mps2] =
            n[..5].try_into().unwrap();
        let context = Context { length_m, masscart_kg, masspole_kg, force_n, gravity_mps2 };
        let variant = match &record[0] {
            "carl-compat" => Variant::CarlCompat,
            "physical" => Variant::Physical,
            other => panic!("no variant {other}"),
        };
        assert_eq!(n[15], 1.0, "a reward of 1 for every step");
        Row {
            dynamics: Dynamics::new(context, variant),
            start: n[5] == 1.0,
            before: n[6..10].try_into().unwrap(),
            right: n[10] == 1.0,
            after: n[11..15].try_into().unwrap(),
            terminated: n[16] == 1.0,
        }
    };
    table.records().map(|record| row(record.unwrap())).collect()
}

#[test]
fn every_step_and_whole_episodes_are_gymnasium_s() {
    let (mut state, mut episodes, mut falls, mut own) = ([0.0; 4], 0, 0, 0);
    let ours = Dynamics::new(Context::default(), Variant::CarlCompat);
    let rows = rows();
    for (i, row) in rows.iter().enumerate() {
        if row.start {
            state = row.before;
            episodes += 1;
        }
        for from in [row.before, state] {
            state = row.dynamics.step(from, row.right);
            state.iter().zip(&row.after).for_each(|(a, b)| close(*a, *b, i));
            assert_eq!(fell(&state), row.terminated, "row {i}");
        }
        falls += usize::from(row.terminated);
        own += usize::from(row.dynamics == ours);
    }
    assert_eq!((rows.len(), own), (1500, 1000));
    assert!(episodes > 50 && falls >= episodes - 11, "{episodes} {falls}");
}
