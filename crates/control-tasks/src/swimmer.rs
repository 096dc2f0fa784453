//! Three links in a viscous liquid, which are to swim to a goal: the five point MDPs of the paper's first study.
//!
//! The model is gymnasium's `Swimmer` (1.4.0, `envs/mujoco/swimmer_v5.py` and its model), and MuJoCo computes it. As in Inala et
//! al. (ICLR 2020; github.com/jinala/RLBench, `swimmer/swimmer_train.py`), an episode ends when the joint at the head is beyond
//! 10 m, or after 5,000 steps. The five point MDPs are those of Jayawardana et al. (NeurIPS 2022): the radii of the links.

use std::cell::OnceCell;

use crate::episodes::Dynamics;
use crate::methods::{ppo, td3, trpo};
use crate::mujoco::{self, Simulation};
use crate::task::scenario::scenario;
use crate::task::{ContextFeature, Task, point};
use evaluation::family::PointMdp;
use evaluation::run::domain::Objective;
use evaluation::run::fault::Cause;
use evaluation::settings::setting::settings;
use evaluation::stats::{Direction, Side};
use learners::rl::environment::Actions;
use learners::rl::random::Generator;

/// Steps of the model per action, and what they take, s.
const STEPS: u32 = 4;
const STEP_S: f64 = 0.04;

/// Amount of the noise on positions and velocities where an episode starts.
const START: f64 = 0.1;

/// Largest radius of a link, m; its length is 1 m.
const MOST_M: f64 = 0.5;

/// A swimmer.
#[derive(Debug, Clone)]
pub struct Swimmer {
    /// Radii of the links, from the head on, m.
    pub radii_m: [f64; 3],
    /// How far the goal is, m.
    pub goal_m: f64,
    /// What a unit of squared torque costs.
    pub control_cost: f64,
    /// Made when it is needed: most of what asks about a swimmer does not need MuJoCo.
    simulation: OnceCell<Simulation<15>>,
}

/// Positions along x and y, direction and angles of both joints; their velocities; and where the solver starts.
pub type State = [f64; 15];

impl Swimmer {
    /// Returns a swimmer; radii and goal in m, and what a unit of squared torque costs.
    pub fn new(radii_m: [f64; 3], goal_m: f64, control_cost: f64) -> Self {
        Self { radii_m, goal_m, control_cost, simulation: OnceCell::new() }
    }

    /// Returns the model in MJCF. Nothing touches anything.
    pub fn mjcf(&self) -> String {
        let [head, middle, tail] = self.radii_m;
        format!(
            r#"<mujoco>
<compiler angle="degree" inertiafromgeom="true"/>
<option timestep="0.01" integrator="RK4" density="4000" viscosity="0.1"/>
<default>
<geom type="capsule" density="1000" contype="0" conaffinity="0" condim="1"/>
<joint armature="0.1"/>
</default>
<worldbody>
<body>
<joint type="slide" axis="1 0 0"/>
<joint type="slide" axis="0 1 0"/>
<joint type="hinge" axis="0 0 1"/>
<geom size="{head}" fromto="1.5 0 0 0.5 0 0"/>
<body pos="0.5 0 0">
<joint name="first" axis="0 0 1" limited="true" range="-100 100"/>
<geom size="{middle}" fromto="0 0 0 -1 0 0"/>
<body pos="-1 0 0">
<joint name="second" axis="0 0 1" limited="true" range="-100 100"/>
<geom size="{tail}" fromto="0 0 0 -1 0 0"/>
</body>
</body>
</body>
</worldbody>
<actuator>
<motor joint="first" gear="150" ctrllimited="true" ctrlrange="-1 1"/>
<motor joint="second" gear="150" ctrllimited="true" ctrlrange="-1 1"/>
</actuator>
</mujoco>"#
        )
    }

    fn simulation(&self) -> &Simulation<15> {
        self.simulation.get_or_init(|| {
            Simulation::new(&self.mjcf(), 2, None)
                .expect("the library is there, which a trial checks first, and the model is ours")
        })
    }

    /// Returns the state of positions and velocities; the rest of what is given does not count.
    pub fn begin(&self, state: State) -> State {
        self.simulation().begin(state)
    }
}

impl Dynamics for Swimmer {
    const LABEL: &'static str = "swimmer";
    const HORIZON: u32 = 5000;
    const WIDTH: usize = 8;
    type State = State;

    fn actions(&self) -> Actions {
        Actions::Continuous { count: 2, limit: 1.0 }
    }

    fn start(&self, generator: &mut Generator) -> State {
        let mut state = State::default();
        state[..10].fill_with(|| START * (2.0 * generator.unit() - 1.0));
        self.begin(state)
    }

    fn observe(&self, state: &State, observation: &mut [f32]) {
        observation.iter_mut().zip(&state[2..10]).for_each(|(o, s)| *o = *s as f32);
    }

    fn act(&self, state: &mut State, action: &[f32]) -> (f64, bool) {
        let before = state[0];
        let control = [f64::from(action[0]), f64::from(action[1])];
        self.simulation().step(state, &control, STEPS);
        let cost = control[0] * control[0] + control[1] * control[1];
        let reward = (state[0] - before) / STEP_S - self.control_cost * cost;
        (reward, state[0] > self.goal_m)
    }

    fn score(&self, _: &State, _: f64, steps: u32) -> f64 {
        f64::from(steps)
    }
}

settings! {
    /// Where methods act.
    pub struct Environment, source "Inala et al., 2020" {
        /// How far the goal is.
        goal_m: f64 = 10.0, in 0.1..=1e6, unit "m";
        /// What a unit of squared torque costs, where the largest torque is 1.
        control_cost: f64 = 1e-4, in 0.0..=1e3, source "gymnasium 1.4.0, Swimmer-v5";
    }
}

scenario! {
    task: Swimmers,
    environment: Environment,
    methods: { ppo, trpo, td3 }
}

/// Swimmers.
#[derive(Debug, Clone, Copy, Default)]
pub struct Swimmers;

impl Task for Swimmers {
    const NAME: &'static str = "swimmer";
    const WHAT: &'static str = "a swimmer";
    const SIMULATOR: &'static str = "MuJoCo";
    const FEATURES: &'static [ContextFeature] = &[
        ContextFeature { name: "head_radius_m", unit: "m", default: 0.1, short: "a" },
        ContextFeature { name: "middle_radius_m", unit: "m", default: 0.1, short: "b" },
        ContextFeature { name: "tail_radius_m", unit: "m", default: 0.1, short: "c" },
    ];
    const OBJECTIVE: Objective = Objective {
        metric: "steps_to_goal",
        title: "steps to the goal",
        unit: "steps",
        direction: Direction::Lower,
    };
    // Not at the goal within the steps of an episode, in nearly all of them.
    const FAILURE: (Side, f64) = (Side::Above, 4999.0);
    const STEP_S: f64 = 1.5e-5;
    const EMBEDDED: &'static str = include_str!("../../../scenarios/swimmer.toml");
    const TUNED: &'static str = include_str!("../../../scenarios/presets/swimmer-tuned.toml");
    type Scenario = Scenario;
    type Dynamics = Swimmer;

    fn simulator() -> Result<String, Cause> {
        Ok(format!("{} {}", Self::SIMULATOR, mujoco::version()?.0))
    }

    fn points() -> Vec<PointMdp> {
        let five = [
            ([0.1, 0.1, 0.1], ""),
            ([0.15, 0.15, 0.15], ""),
            ([0.1, 0.15, 0.1], ""),
            ([0.05, 0.05, 0.05], ", simplified"),
            ([0.1, 0.1125, 0.1], ", generic"),
        ];
        let made = five.map(|(context, mark)| {
            let [head, middle, tail] = context;
            let title = format!("links of {head}, {middle} and {tail} m{mark}");
            point(Self::FEATURES, &context, title, 0.2)
        });
        made.into()
    }

    fn check(_: &Scenario, context: &[f64]) -> Result<(), (usize, String)> {
        match context.iter().position(|radius| *radius > MOST_M) {
            Some(place) => Err((place, format!("give {MOST_M} m or less, as a link is 1 m long"))),
            None => Ok(()),
        }
    }

    fn dynamics(scenario: &Scenario, context: &[f64]) -> Swimmer {
        let radii_m = context.try_into().expect("a context has all features");
        let Environment { goal_m, control_cost } = scenario.environment;
        Swimmer::new(radii_m, goal_m, control_cost)
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
        check_family::<Swimmers>(5);
        if let Err(e) = mujoco::version() {
            eprintln!("skipped: {e}");
            return;
        }
        check_episodes::<Swimmers>();
        check_features::<Swimmers>(&Scenario::default());
    }

    #[test]
    fn a_wave_along_the_links_reaches_the_goal_soonest_where_they_are_thin() {
        if let Err(e) = mujoco::version() {
            eprintln!("skipped: {e}");
            return;
        }
        let swum = |radius: f64| {
            let mut environment = Episodes::of(Swimmer::new([radius; 3], 10.0, 1e-4));
            let mut time = 0.0;
            let mut wave = |_: &[f32], action: &mut [f32]| {
                time += 1.0;
                for (action, behind) in action.iter_mut().zip([0.0, 2.0]) {
                    *action = (std::f32::consts::TAU * time / 30.0 - behind).sin();
                }
            };
            play(&mut environment, 1, &mut wave)
        };
        let (thin, thick) = (swum(0.05), swum(0.15));
        assert!(
            thin.steps < thick.steps && thin.score == f64::from(thin.steps),
            "{thin:?} {thick:?}"
        );
    }

    #[test]
    fn a_link_thicker_than_long_is_refused() {
        let e = Swimmers::check(&Scenario::default(), &[0.1, 0.6, 0.1]).unwrap_err();
        assert_eq!(e, (1, "give 0.5 m or less, as a link is 1 m long".to_owned()));
    }
}
