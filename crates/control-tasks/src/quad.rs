//! A quadcopter that flies through a course of walls: the five point MDPs of the paper's first study.
//!
//! The dynamics are those of Inala et al. (ICLR 2020; github.com/jinala/RLBench, `quad/quad_train.py`): it moves ahead at
//! about 2 m/s, and an action accelerates it up or down. A course has 60 tunnels of a metre each between a lower and an upper
//! wall, which go up and down together; body and tilt are ignored where it meets a wall.
//! Two choices, see `docs/control-tasks.md`: the paper calls its two numbers lengths of obstacles, u and l; no variable of the
//! code is one, so they are the heights of both walls before the first tunnel, whose values in the code are 1 and 5. And
//! `environment.tilt_check = false` leaves out that a tilt, which no action changes, ends nearly a third of the episodes.

use crate::episodes::Dynamics;
use crate::methods::{ppo, td3, trpo};
use crate::task::{
    Actions, ContextFeature, Direction, Generator, Objective, POSITIVE, PointMdp, Side, Task,
    feature, point, scenario, settings,
};

const STEP_S: f64 = 0.1;

/// Largest acceleration, m/s².
const ACCELERATION: f64 = 5.0;

/// Tunnels of a course, each a metre long, and where the first begins.
const TUNNELS: usize = 60;
const BEGIN_M: f64 = 3.0;

/// By how much a tunnel is higher or lower than the one before it, m.
const RISE_M: f64 = 0.8;

/// Heights of the lower and of the upper wall at which the course turns.
const TURNS_M: [f64; 2] = [0.5, 10.0];

/// Height of the ceiling, m, and the weight of being beyond it or below the floor.
const CEILING_M: f64 = 12.0;
const BEYOND: f64 = 3.0;

/// Largest tilt, rad.
const TILT: f64 = 0.8;

/// Error above which an episode ends, and distance to the end at which the course is done.
const ERROR: f64 = 0.02;
const DONE_M: f64 = 0.01;

/// What an episode starts within.
const START: f64 = 0.04;

/// A quadcopter and its course.
#[derive(Debug, Clone, PartialEq)]
pub struct Quad {
    /// Heights of the lower and of the upper wall of every tunnel.
    tunnels: Vec<[f64; 2]>,
    tilt_check: bool,
}

/// Place ahead and height (m), their velocities (m/s), tilt (rad) and its velocity (rad/s).
pub type State = [f64; 6];

impl Quad {
    /// Returns the course that begins between walls of two heights.
    pub fn new(lower_m: f64, upper_m: f64, tilt_check: bool) -> Self {
        let (mut heights, mut rise) = ([lower_m, upper_m], RISE_M);
        let tunnel = |_| {
            heights = heights.map(|height| height + rise);
            if heights[0] <= TURNS_M[0] || heights[1] >= TURNS_M[1] {
                rise = -rise;
            }
            heights
        };
        Self { tunnels: (0..TUNNELS).map(tunnel).collect(), tilt_check }
    }

    fn error(&self, [x, y, _, _, tilt, _]: &State) -> f64 {
        let mut error = BEYOND * (-y).max(0.0) + BEYOND * (y - CEILING_M).max(0.0);
        for (i, [lower, upper]) in self.tunnels.iter().enumerate() {
            let (from, to) = (BEGIN_M + i as f64, BEGIN_M + 1.0 + i as f64);
            if (from..=to).contains(x) {
                let along = (from - x).max(x - to);
                error += (-along.max(y - lower)).max(0.0) + (-along.max(upper - y)).max(0.0);
            }
        }
        if self.tilt_check {
            error += (tilt - TILT).max(0.0) + (-TILT - tilt).max(0.0);
        }
        error
    }
}

impl Dynamics for Quad {
    const LABEL: &'static str = "quad";
    const HORIZON: u32 = 500;
    const WIDTH: usize = 4;
    type State = State;

    fn actions(&self) -> Actions {
        Actions::Continuous { count: 1, limit: ACCELERATION as f32 }
    }

    fn start(&self, generator: &mut Generator) -> State {
        let mut near = || START * (2.0 * generator.unit() - 1.0);
        let [x, vx, vy, tilt, turning] =
            [BEGIN_M, 2.0, 1.0, 0.0, 0.0].map(|middle| middle + near());
        let [lower, upper] = self.tunnels[0];
        [x, f64::midpoint(lower, upper) + near(), vx, vy, tilt, turning]
    }

    fn act(&self, state: &mut State, action: &[f32]) -> (f64, bool) {
        let [x, y, vx, vy, tilt, turning] = *state;
        let acceleration = f64::from(action[0]).clamp(-ACCELERATION, ACCELERATION);
        *state = [
            x + vx * STEP_S,
            y + vy * STEP_S,
            vx,
            vy + acceleration * STEP_S,
            tilt + turning * STEP_S,
            turning,
        ];
        let left = (BEGIN_M + TUNNELS as f64 - state[0]).max(0.0);
        (1.0, self.error(state) > ERROR || left < DONE_M)
    }

    fn score(&self, state: &State, _: f64, _: u32) -> f64 {
        ((state[0] - BEGIN_M) / TUNNELS as f64).clamp(0.0, 1.0)
    }
}

settings! {
    /// Where methods act.
    pub struct Environment, source "Inala et al., 2020, RLBench" {
        /// Whether a tilt of more than 0.8 rad ends an episode, as in the original. No action changes the tilt.
        tilt_check: bool = true;
    }
}

scenario! {
    /// Quadcopters.
    task: Quads,
    environment: Environment,
    methods: { ppo, trpo, td3 }
}

impl Task for Quads {
    const NAME: &'static str = "quad";
    const WHAT: &'static str = "a quadcopter's course";
    const SIMULATOR: &'static str = "Quad with the equations of Inala et al., 2020";
    const FEATURES: &'static [ContextFeature] = &[
        feature("lower_wall_m", "m", 1.0, "u", [0.0, f64::MAX]),
        feature("upper_wall_m", "m", 5.0, "l", POSITIVE),
    ];
    const OBJECTIVE: Objective = Objective {
        most: Some(1.0),
        ..Objective::new("course_share", "share of the course", "", Direction::Higher)
    };
    // Less than half of the course.
    const FAILURE: (Side, f64) = (Side::Below, 0.5);
    const STEP_S: f64 = 5e-7;
    const EMBEDDED: &'static str = include_str!("../../../scenarios/quad.toml");
    // Nobody tuned it.
    const TUNED: &'static str = "";
    type Scenario = Scenario;
    type Dynamics = Quad;

    fn points() -> Vec<PointMdp> {
        let five = [
            ([0.0, 6.0], ", simplified"),
            ([0.5, 3.0], ""),
            ([0.625, 4.0], ", generic"),
            ([1.0, 2.0], ""),
            ([1.0, 5.0], ""),
        ];
        five.map(|(context, mark)| {
            let title = format!("walls at {} and {} m{mark}", context[0], context[1]);
            point(Self::FEATURES, &context, title, 0.2)
        })
        .into()
    }

    fn check(_: &Scenario, context: &[f64]) -> Result<(), (usize, String)> {
        let clear = RISE_M + context[0] < context[1];
        match (clear, context[1] < TURNS_M[1]) {
            (true, true) => Ok(()),
            (false, _) => Err((1, format!("expected more than {RISE_M} m above lower_wall_m"))),
            (_, false) => Err((1, format!("expected less than {} m", TURNS_M[1]))),
        }
    }

    fn dynamics(scenario: &Scenario, context: &[f64]) -> Quad {
        Quad::new(context[0], context[1], scenario.environment.tilt_check)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::episodes::Episodes;
    use crate::task::testing::{check_episodes, check_family, check_features};
    use learners::rl::environment::play;

    #[test]
    fn it_is_a_task() {
        check_family::<Quads>(5);
        check_episodes::<Quads>();
        check_features::<Quads>(&Scenario::default());
    }

    #[test]
    fn a_course_goes_up_and_down_between_its_turns() {
        let course = Quad::new(1.0, 5.0, true).tunnels;
        let lower: Vec<f64> =
            course.iter().map(|[lower, _]| (lower * 10.0).round() / 10.0).collect();
        // Up to an upper wall of 10 m or more, then down to a lower wall of 0.5 m or less.
        assert_eq!(lower[..9], [1.8, 2.6, 3.4, 4.2, 5.0, 5.8, 6.6, 5.8, 5.0]);
        assert_eq!(lower[12..16], [1.8, 1.0, 0.2, 1.0]);
        assert!(course.iter().all(|[lower, upper]| (upper - lower - 4.0).abs() < 1e-9));
    }

    /// Mean share of the course of a pilot who flies along the middle of tunnels.
    fn flown(tilt_check: bool, episodes: u64) -> f64 {
        let quad = Quad::new(1.0, 5.0, tilt_check);
        let middle = |x: f64| {
            let i = ((x - BEGIN_M).max(0.0) as usize).min(TUNNELS - 1);
            f64::midpoint(quad.tunnels[i][0], quad.tunnels[i][1])
        };
        let mut pilot = |o: &[f32], a: &mut [f32]| {
            let [x, y, vy] = [o[0], o[1], o[3]].map(f64::from);
            let rise = middle(x + 1.0) - middle(x);
            a[0] = (8.0 * (middle(x + 0.5) - y) + 4.0 * (2.0 * rise - vy)) as f32;
        };
        let mut environment = Episodes::of(quad.clone());
        let total: f64 = (0..episodes).map(|k| play(&mut environment, k, &mut pilot).score).sum();
        total / episodes as f64
    }

    #[test]
    fn a_course_can_be_flown_and_the_tilt_ends_some_flights_late() {
        let (free, checked) = (flown(false, 50), flown(true, 50));
        assert!(free > 0.999 && (0.9..0.98).contains(&checked), "{free} {checked}");
    }

    #[test]
    fn walls_that_leave_no_way_are_refused() {
        let refused =
            |lower, upper| Quads::check(&Scenario::default(), &[lower, upper]).unwrap_err();
        assert_eq!(
            refused(1.0, 1.7),
            (1, "expected more than 0.8 m above lower_wall_m".to_owned())
        );
        assert_eq!(refused(1.0, 11.0), (1, "expected less than 10 m".to_owned()));
    }
}
