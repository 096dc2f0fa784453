//! An existing plan on the links of a signal: as rings that see vehicles, or as a fixed cycle.
//!
//! - **Right of way.** A movement shows `G` in the phases that give it the right of way, and `g` where it yields. A right
//!   turn that the plan gives the right of way beside another movement with it, and that meets it, yields.
//! - **Detectors** are as those of `nema`: presence at the stop line. A lane belongs to the phases that give one of its
//!   links the right of way; where none does, to those in which they yield. A lane for right turns and others belongs to no
//!   phase that serves its right turns alone.
//! - **Pedestrians** take walk and clearance of the plan: in every cycle where every method serves them so, else on recall,
//!   or when somebody has pushed the button. Where nobody crosses, only recall does. A fixed cycle is what it is.
//!   A phase without a walk serves nobody on foot. A phase without vehicles that has a walk is for pedestrians alone: it
//!   serves the crosswalks that no other phase with a walk does.

use osm_signals::Turn;

use super::links::Links;
use super::plan::{Coordination, Detector, Phase, Plan};
use crate::control::dual_ring::Config;
use crate::existing::{Control, ExistingPlan, PlanPhase, Recall, Timed, schedule};
use crate::junction::Set;
use crate::sim::topology::edge;
use crate::sim::{ProgramPhase, Scene, SignalInfo};
use crate::timing::{Change, Timing, WALK_S, beside, nearest_s};

/// The plan on the links of a signal.
struct Wired<'a> {
    plan: &'a ExistingPlan,
    signal: &'a SignalInfo,
    /// When each phase is green if each lasts its split, and the cycle, seconds.
    timed: Vec<Timed>,
    cycle_s: u32,
    /// The links, of which the plan is the witness.
    links: Links,
    /// Per phase its links with the right of way.
    protected: Vec<Set>,
    /// Per phase its links that yield.
    yielding: Vec<Set>,
}

impl<'a> Wired<'a> {
    fn new(plan: &'a ExistingPlan, scene: &Scene, signal: &'a SignalInfo) -> Result<Self, String> {
        let links = Links::new(scene, signal, Vec::new());
        let of = |names: &[String]| {
            let ways = || names.iter().filter_map(|name| plan.ways.get(name)).flatten();
            let is = |link: &usize| {
                signal.links[*link].iter().any(|l| {
                    let from = edge(&scene.lanes[l.from_lane].id);
                    ways().any(|way| (way.0.as_str(), way.1.as_str()) == (from, edge(&l.to_lane)))
                })
            };
            links.set((0..signal.links.len()).filter(is))
        };
        let protected: Vec<Set> = plan.phases.iter().map(|p| of(&p.movements)).collect();
        let yields = |(p, own): (&PlanPhase, &Set)| links.set(of(&p.yielding).difference(own));
        let yielding = plan.phases.iter().zip(&protected).map(yields).collect();
        let (timed, cycle_s) = schedule(plan);
        let mut wired = Self { plan, signal, timed, cycle_s, links, protected, yielding };
        let is_left_out = |link: &usize| {
            let mut phases = wired.protected.iter().chain(&wired.yielding);
            wired.links.cars[*link].is_some() && !phases.any(|links| links.contains(*link))
        };
        if let Some(link) = (0..wired.links.cars.len()).find(is_left_out) {
            let lane = signal.links[link].first().map_or("", |l| &scene.lanes[l.from_lane].id);
            return Err(format!(
                "its existing plan has no phase for link {link}, from lane {lane}"
            ));
        }
        let alone = (0..plan.phases.len()).map(|phase| vec![phase]);
        let greens = plan.pairs().into_iter().chain(alone);
        let states = greens.map(|phases| wired.state(&phases)).collect();
        wired.links = Links::new(scene, signal, states);
        Ok(wired)
    }

    /// Returns what is shown while some phases are green.
    fn state(&self, phases: &[usize]) -> String {
        let has = |of: &[Set], link: usize| phases.iter().any(|p| of[*p].contains(link));
        let approach = |link: usize| self.links.cars[link].as_ref().map(|car| car.approach);
        let is_right = |link: usize| self.links.turn(link) == Some(Turn::Right);
        let letter = |link: usize| {
            let met = |other: usize| {
                has(&self.protected, other)
                    && !is_right(other)
                    && approach(other) != approach(link)
                    && self.signal.may_meet(link, other)
            };
            let is_met = || (0..self.links.cars.len()).any(met);
            match (has(&self.protected, link), has(&self.yielding, link)) {
                (false, false) => 'r',
                _ if is_right(link) && is_met() => 'g',
                _ if is_right(link) => 'G',
                (true, _) => 'G',
                (false, true) => 'g',
            }
        };
        (0..self.links.cars.len()).map(letter).collect()
    }

    fn rings(&self, timing: &Timing) -> Plan {
        let phases = (0..self.plan.phases.len()).map(|phase| self.phase(phase, timing)).collect();
        Plan {
            phases,
            sides: self.plan.sides(),
            is_existing: true,
            coordination: self.coordination(),
            ..Plan::default()
        }
    }

    fn phase(&self, index: usize, timing: &Timing) -> Phase {
        let phase = &self.plan.phases[index];
        let change_s = phase.change_s();
        let change = match self.plan.control {
            Control::Actuated => Change::of(nearest_s(change_s.iter().sum()), change_s),
            Control::Pretimed | Control::Coordinated => self.timed[index].change,
        };
        let crossings = self.crossings(index, timing);
        let everybody = timing.crossings() > 0 && timing.recalls_pedestrians();
        let in_every_cycle = everybody || phase.recall == Recall::Ped;
        let walk_s = phase.walk_s.filter(|_| in_every_cycle).map_or(0, whole_s);
        let min_s = nearest_s(phase.min_green_s).max(1).max(walk_s);
        let links = self.all(index);
        // Where everybody crosses in every cycle, nobody pushes a button for a phase of pedestrians alone.
        let is_for_people = links.is_clear() && !crossings.is_empty();
        let is_recalled = phase.recall != Recall::None || is_for_people && in_every_cycle;
        Phase {
            number: phase.number,
            serves: "phase",
            detectors: self.detectors(index),
            links,
            crossings,
            min_s,
            max_s: nearest_s(phase.max_green_s).max(min_s),
            change,
            passage_s: nearest_s(phase.passage_s),
            recall: is_recalled || self.is_coordinated(index),
            is_full: phase.recall == Recall::Max,
            enters: phase.dual_entry,
            ..Phase::default()
        }
    }

    fn is_coordinated(&self, index: usize) -> bool {
        self.plan.control == Control::Coordinated && self.plan.coordinated().contains(&index)
    }

    /// Returns all links of a phase.
    fn all(&self, index: usize) -> Set {
        &self.protected[index] | &self.yielding[index]
    }

    /// Returns the crosswalks of a phase with the time that they take, seconds: each belongs to the phase with most links
    /// of those that have a walk and serve it.
    fn crossings(&self, index: usize, timing: &Timing) -> Vec<(usize, u32)> {
        let Some(walk_s) = self.plan.phases[index].walk_s.map(whole_s) else { return Vec::new() };
        let state = |phase: usize| self.links.plain(&self.all(phase));
        let owner = |crossing: usize| {
            let serves = |p: &usize| {
                let is_for_people = self.all(*p).is_clear() && !timing.closed[crossing];
                let is_beside = || timing.serves_crossing(&state(*p), crossing);
                self.plan.phases[*p].walk_s.is_some() && (is_for_people || is_beside())
            };
            let size = |p: &usize| self.all(*p).count_ones(..);
            (0..self.plan.phases.len()).filter(serves).rev().max_by_key(size)
        };
        (0..timing.crossings())
            .filter(|crossing| owner(*crossing) == Some(index))
            .map(|crossing| (crossing, walk_s.max(WALK_S)))
            .collect()
    }

    fn detectors(&self, index: usize) -> Vec<Detector> {
        let links = &self.links;
        let own = self.all(index);
        let detector = |lane: usize| {
            let of_lane = links.on_lane(lane);
            let has = |of: &Set| of_lane.iter().any(|l| of.contains(*l));
            // A lane for several movements would hold a phase that serves its right turns alone.
            let goes_on = |of: &Set| {
                of_lane.iter().any(|l| of.contains(*l) && links.turn(*l) != Some(Turn::Right))
            };
            let is_of_others = !has(&self.protected[index]) && self.protected.iter().any(has)
                || !goes_on(&own) && self.protected.iter().any(goes_on);
            (!is_of_others).then(|| Detector::new(links, lane, &Config::default()))
        };
        links.lanes(own.ones()).into_iter().filter_map(detector).collect()
    }

    fn coordination(&self) -> Option<Coordination> {
        if self.plan.control != Control::Coordinated {
            return None;
        }
        let (timed, cycle_s) = (&self.timed, self.cycle_s);
        let greens_s = timed.iter().map(|t| Some([t.begin_s, t.begin_s + t.green_s]));
        let holds = (0..timed.len()).map(|phase| self.is_coordinated(phase)).collect();
        let (first, cycle) = Coordination::new(cycle_s, &greens_s.collect::<Vec<_>>(), holds)?;
        Some(Coordination {
            begins_s: cycle_s - timed[first].green_s,
            inhibits_max: self.plan.phases.iter().map(|p| p.inhibit_max).collect(),
            splits_s: timed.iter().map(|t| Some(t.split_s())).collect(),
            ..cycle
        })
    }

    /// Returns the plan as a cycle of states.
    fn cycle(&self) -> Vec<ProgramPhase> {
        let mut shown: Vec<ProgramPhase> = Vec::new();
        for second in 0..self.cycle_s {
            let state = self.at(second);
            match shown.last_mut().filter(|last| last.state == state) {
                Some(last) => *last = ProgramPhase::fixed(state, last.duration_s + 1.0),
                None => shown.push(ProgramPhase::fixed(state, 1.0)),
            }
        }
        shown
    }

    /// Returns what a fixed cycle shows in a second.
    fn at(&self, second: u32) -> String {
        let (timed, cycle_s) = (&self.timed, self.cycle_s);
        let since = |p: usize| (second + cycle_s - timed[p].begin_s % cycle_s) % cycle_s;
        let all = || 0..timed.len();
        let lasts_s = |p: usize| timed[p].split_s();
        let green: Vec<usize> = all().filter(|p| since(*p) < timed[*p].green_s).collect();
        let next = |p: usize| {
            let begins_s = (timed[p].begin_s + lasts_s(p)) % cycle_s;
            let follows = move |n: &usize| {
                let same = self.plan.phases[*n].ring == self.plan.phases[p].ring;
                same && timed[*n].begin_s % cycle_s == begins_s && timed[*n].green_s > 0
            };
            all().filter(follows)
        };
        let changing = || all().filter(|p| (timed[*p].green_s..lasts_s(*p)).contains(&since(*p)));
        let mut letters = self.state(&green).into_bytes();
        for (link, letter) in letters.iter_mut().enumerate() {
            let ending: Vec<usize> = changing().filter(|p| self.all(*p).contains(link)).collect();
            if *letter != b'r' || ending.is_empty() {
                continue;
            }
            // What is green in a phase and in the one after it in its ring stays green.
            let stays = |p: &usize| next(*p).any(|n| self.all(n).contains(link));
            let yellow = |p: &usize| since(*p) < timed[*p].green_s + timed[*p].change.yellow_s;
            *letter = if ending.iter().any(stays) {
                let protects = |p: &usize| {
                    let own = |p: usize| self.protected[p].contains(link);
                    own(*p) && next(*p).any(own)
                };
                if ending.iter().any(protects) { b'G' } else { b'g' }
            } else if ending.iter().any(yellow) {
                b'y'
            } else {
                b'r'
            };
        }
        String::from_utf8(letters).expect("letters are ASCII")
    }
}

/// Returns walk and clearance together, whole seconds.
pub(super) fn whole_s([walk_s, clearance_s]: [f64; 2]) -> u32 {
    beside(walk_s + clearance_s)[1]
}

/// Returns links and phases of a plan that sees vehicles on a signal.
pub(super) fn rings(
    plan: &ExistingPlan,
    scene: &Scene,
    signal: &SignalInfo,
    timing: &Timing,
) -> Result<(Links, Plan), String> {
    let wired = Wired::new(plan, scene, signal)?;
    let rings = wired.rings(timing);
    Ok((wired.links, rings))
}

/// Returns the fixed cycle of a plan on a signal.
pub fn fixed_cycle(
    plan: &ExistingPlan,
    scene: &Scene,
    signal: &SignalInfo,
) -> Result<Vec<ProgramPhase>, String> {
    Ok(Wired::new(plan, scene, signal)?.cycle())
}

#[cfg(test)]
mod tests {
    use super::super::testing::{self, On, RED, SIDE, SIDE_ENDS, expected, settings, timing};
    use super::super::{DualRing, Seen};
    use super::*;
    use crate::env::derive::derive;
    use crate::env::testing::crossing;
    use crate::existing::testing::{phase, plan};
    use crate::settings::SignalSettings;

    /// Four arms from the north clockwise, with links right, through, left.
    fn scene() -> Scene {
        let lanes: Vec<(String, f64, &str)> = (0..4)
            .flat_map(|k| {
                let heading_deg = (180.0 + 90.0 * f64::from(k)) % 360.0;
                [(format!("in{k}_0"), heading_deg, "rs"), (format!("in{k}_1"), heading_deg, "l")]
            })
            .collect();
        let lanes: Vec<(&str, f64, &str)> =
            lanes.iter().map(|(id, h, d)| (id.as_str(), *h, *d)).collect();
        let mut scene = crossing(&lanes, &["GGgrrrGGgrrr"]);
        let signal = &mut scene.signals[0];
        for (index, links) in signal.links.iter_mut().enumerate() {
            links[0].to_lane = format!("out{}_0", (index / 3 + [3, 2, 1][index % 3]) % 4);
        }
        // Left turns meet the opposing through and right-turning traffic, nothing else that is green together.
        let mut meets = vec![vec![false; 12]; 12];
        for left in [2, 5, 8, 11] {
            for other in [(left + 5) % 12, (left + 4) % 12] {
                (meets[left][other], meets[other][left]) = (true, true);
            }
        }
        signal.meets = meets;
        scene
    }

    fn placed(control: Control) -> ExistingPlan {
        let mut plan = plan(control);
        for (arm, heading) in ["SB", "WB", "NB", "EB"].iter().enumerate() {
            for (turn, to) in [('R', 3), ('T', 2), ('L', 1)] {
                let way = (format!("in{arm}"), format!("out{}", (arm + to) % 4));
                plan.ways.insert(format!("{heading}{turn}"), vec![way]);
            }
        }
        plan
    }

    const LEFTS: &str = "rrGrrrrrGrrr";
    const MAIN: &str = "GGrrrrGGrrrr";
    const MAIN_ENDS: &str = "yyrrrryyrrrr";

    #[test]
    fn a_pretimed_plan_is_a_cycle_with_its_own_yellow_and_red() {
        let (scene, plan) = (scene(), placed(Control::Pretimed));
        let cycle = fixed_cycle(&plan, &scene, &scene.signals[0]).unwrap();
        let shown: Vec<(&str, f64)> =
            cycle.iter().map(|p| (p.state.as_str(), p.duration_s)).collect();
        let expected = [
            (LEFTS, 8.0),
            ("rryrrrrryrrr", 4.0),
            (RED, 1.0),
            (MAIN, 20.0),
            (MAIN_ENDS, 3.0),
            (RED, 1.0),
            (SIDE, 20.0),
            (SIDE_ENDS, 4.0),
            (RED, 1.0),
        ];
        assert_eq!(shown, expected);
    }

    #[test]
    fn what_is_green_in_a_phase_and_the_next_of_its_ring_stays_green() {
        let scene = scene();
        let mut plan = placed(Control::Pretimed);
        // Left turns yield beside the through movement of their own approach: 5 with 2, and 1 with 6.
        plan.phases[1].yielding.push("NBL".into());
        plan.phases[4].yielding.push("SBL".into());
        // Northbound traffic as a whole in the phases of ring 1.
        plan.phases[0].movements = vec!["NBT".into()];
        plan.phases[3].movements = vec!["NBL".into()];
        let cycle = fixed_cycle(&plan, &scene, &scene.signals[0]).unwrap();
        let states: Vec<&str> = cycle.iter().map(|p| p.state.as_str()).collect();
        assert_eq!(states[..4], ["rrrrrrrGGrrr", "rrrrrrrGyrrr", "rrrrrrrGrrrr", "GGgrrrGGgrrr"]);
    }

    #[test]
    fn walks_lengthen_greens_where_pedestrians_cross_and_on_recall() {
        let (scene, mut plan) = (scene(), placed(Control::Actuated));
        for phase in &mut plan.phases {
            (phase.walk_s, phase.recall) = (Some([20.0, 15.0]), Recall::None);
        }
        plan.phases[1].recall = Recall::Ped;
        let wired = Wired::new(&plan, &scene, &scene.signals[0]).unwrap();
        let least_s = |pedestrians| {
            let settings = SignalSettings { pedestrians, ..settings() };
            let rings = wired.rings(&timing(&wired.links, &settings));
            [0, 1].map(|phase: usize| rings.phases[phase].min_s)
        };
        assert_eq!(least_s(true), [35, 35]);
        let [without, recalled] = least_s(false);
        assert!(without < 35 && recalled == 35, "{without} {recalled}");
    }

    #[test]
    fn greens_to_choose_have_room_for_walks_and_smallest_splits_or_are_as_long_as_today() {
        let (scene, mut plan) = (scene(), placed(Control::Coordinated));
        (plan.phases[1].walk_s, plan.phases[2].walk_s) = (Some([7.0, 9.0]), Some([7.0, 30.0]));
        plan.phases[0].min_split_s = Some(11.5);
        let signal = &scene.signals[0];
        let derived = derive(&scene, signal, &settings()).unwrap();
        let greens = |plan: &ExistingPlan| {
            DualRing::ring_greens(&scene, signal, &derived, Some(plan), &Config::default()).unwrap()
        };
        let found = greens(&plan);
        assert_eq!(found.green_s, [8.0, 20.0, 20.0, 8.0, 20.0, 20.0]);
        assert_eq!(found.least_s, [7.0, 16.0, 20.0, 5.0, 5.0, 5.0]);
        assert_eq!((found.cycle_s, &found.change_s[..2]), (Some([61.5; 2]), &[4.5, 4.5][..]));
        // Ring 2 waits at the barrier.
        (plan.control, plan.phases[4].max_green_s) = (Control::Pretimed, 15.0);
        let cycle_s = [derived.spec.limits.min_cycle_s.min(61.5), 150.0];
        assert_eq!((greens(&plan).green_s[4], greens(&plan).cycle_s), (20.0, Some(cycle_s)));
        plan.offset_s = Some(3.0);
        assert_eq!(greens(&plan).cycle_s, Some([61.5; 2]));
        plan.control = Control::Actuated;
        assert_eq!(greens(&plan).cycle_s, None);
    }

    #[test]
    fn a_phase_without_a_walk_serves_nobody_and_one_without_vehicles_all_that_is_left() {
        let (scene, mut plan) = (scene(), placed(Control::Actuated));
        let served = |plan: &ExistingPlan| {
            let wired = Wired::new(plan, &scene, &scene.signals[0]).unwrap();
            let settings = SignalSettings { pedestrians: true, ..settings() };
            let rings = wired.rings(&timing(&wired.links, &settings));
            let of = |phase: &Phase| (phase.number, phase.crossings.len(), phase.recall);
            rings.phases.iter().map(of).filter(|of| of.1 > 0).collect::<Vec<_>>()
        };
        assert!(served(&plan).is_empty());
        let mut people = phase(9, [3, 1, 1], "");
        people.walk_s = Some([7.0, 13.0]);
        plan.phases.push(people);
        assert_eq!(served(&plan), [(9, 4, true)]);
    }

    fn rings(plan: &ExistingPlan) -> DualRing {
        let scene = scene();
        let wired = Wired::new(plan, &scene, &scene.signals[0]).unwrap();
        let timing = timing(&wired.links, &settings());
        let rings = wired.rings(&timing);
        DualRing::of(wired.links, rings, timing)
    }

    fn play(plan: &ExistingPlan, vehicles: &[On], seconds: usize) -> Vec<(String, usize)> {
        testing::play(&mut rings(plan), vehicles, seconds)
    }

    #[test]
    fn an_actuated_plan_goes_by_its_own_times() {
        let plan = placed(Control::Actuated);
        // 5 s at least; 3 s without a vehicle; 3.5 and 1 s are 4 and 1 s; phase 8 enters beside 4.
        let shown = play(&plan, &[(4, 0..12)], 60);
        assert_eq!(shown, expected(&[(MAIN, 5), (MAIN_ENDS, 4), (RED, 1), (SIDE, 50)]));
        let shown = play(&plan, &[(2, 0..99), (4, 0..99)], 60);
        assert_eq!(shown[0], (MAIN.to_owned(), 20), "its longest green");
    }

    #[test]
    fn a_phase_that_ends_nothing_is_followed_at_once() {
        let mut plan = placed(Control::Actuated);
        plan.phases = vec![
            phase(1, [1, 1, 1], "SBT SBR"),
            phase(2, [1, 1, 2], "SBT SBR NBT NBR sbl nbl"),
            phase(4, [2, 1, 1], "EBT EBR ebl WBT WBR wbl"),
        ];
        (plan.phases[0].yellow_s, plan.phases[0].all_red_s) = (0.0, 0.0);
        plan.phases.iter_mut().for_each(|p| p.recall = Recall::Min);
        plan.reference.clear();
        assert_eq!(plan.check(), Ok(vec![]));
        let shown = play(&plan, &[], 35);
        let all = "GGgrrrGGgrrr";
        let ends = [("yyyrrryyyrrr", 4), (RED, 1)];
        let side = [(SIDE, 5), (SIDE_ENDS, 4), (RED, 1)];
        let starts = [("GGrrrrrrrrrr", 5), (all, 5)];
        let first = [(all, 5)];
        assert_eq!(shown, expected(&[&first[..], &ends, &side, &starts, &ends].concat()));
    }

    #[test]
    fn a_movement_of_phases_that_end_together_is_red_for_as_long_as_the_longer_one_says() {
        let mut plan = placed(Control::Actuated);
        plan.phases[4].movements.push("NBR".into());
        let shown = play(&plan, &[(4, 0..99)], 20);
        assert_eq!(shown, expected(&[(MAIN, 5), (MAIN_ENDS, 4), (RED, 1), (SIDE, 10)]));
    }

    #[test]
    fn maximum_recall_lasts_the_longest_green_and_comes_in_every_cycle() {
        let mut plan = placed(Control::Actuated);
        for phase in [1, 2] {
            plan.phases[phase].recall = Recall::Max;
        }
        let shown = play(&plan, &[(2, 0..99), (4, 0..99)], 50);
        let cycle = [(MAIN, 20), (MAIN_ENDS, 4), (RED, 1), (SIDE, 20), (SIDE_ENDS, 4), (RED, 1)];
        assert_eq!(shown, expected(&cycle));
    }

    #[test]
    fn coordinated_phases_hold_the_green_until_the_end_of_their_split() {
        let plan = placed(Control::Coordinated);
        assert_eq!(play(&plan, &[], 200), expected(&[(MAIN, 200)]), "nobody calls");
        // They began 20 s before they may end. The lefts are skipped, and what they leave is theirs: 62 - 20 - 4 - 5 s.
        let shown = play(&plan, &[(4, 0..999), (8, 0..999)], 81 + 62);
        let side = [(MAIN_ENDS, 3), (RED, 1), (SIDE, 20), (SIDE_ENDS, 4), (RED, 1)];
        let all = [&[(MAIN, 20)][..], &side, &[(MAIN, 33)], &side, &[(MAIN, 32)]].concat();
        assert_eq!(shown, expected(&all));
    }

    /// Returns the greens of some phases that have ended, with vehicles on the detectors of others all the time: number, first
    /// second and length.
    fn greens(
        plan: &ExistingPlan,
        numbers: &[u32],
        vehicles: &[u32],
        seconds: u32,
    ) -> Vec<(u32, u32, u32)> {
        let on = |number: u32, _| vehicles.contains(&number);
        let mut ended = testing::greens(&mut rings(plan), &on, seconds);
        ended.retain(|(number, ..)| numbers.contains(number));
        ended
    }

    #[test]
    fn a_through_phase_opposite_the_only_coordinated_one_is_served_in_every_cycle() {
        let mut plan = placed(Control::Coordinated);
        let all = |left, through, side| {
            [(through, 0, 20), (side, 24, 20), (left, 49, 8), (through, 62, 20), (side, 86, 20)]
        };
        plan.reference = vec![2];
        assert_eq!(greens(&plan, &[5, 6, 8], &[4, 5, 6, 8], 107), all(5, 6, 8));
        plan.reference = vec![6];
        assert_eq!(greens(&plan, &[1, 2, 4], &[1, 2, 4, 8], 107), all(1, 2, 4));
    }

    #[test]
    fn a_phase_at_its_longest_rests_until_the_other_ring_may_cross_the_barrier() {
        let mut plan = placed(Control::Actuated);
        plan.phases[4].max_green_s = 50.0;
        let ended = greens(&plan, &[2, 6, 8], &[2, 4, 6, 8], 80);
        assert_eq!(ended, [(2, 0, 50), (6, 0, 50), (8, 55, 20)]);
    }

    #[test]
    fn each_ring_ends_at_its_own_force_off_where_changes_before_a_barrier_differ() {
        // Left turn 1 lags with 5 s of change beside phase 6 with 7 s.
        let mut plan = lead_lag();
        (plan.phases[4].yellow_s, plan.phases[4].max_green_s) = (5.5, 18.0);
        let ended = greens(&plan, &[1, 2, 6, 8], &[1, 2, 4, 6, 8], 60);
        assert_eq!(ended, [(2, 0, 20), (6, 0, 31), (1, 25, 8), (8, 37, 20)]);
    }

    #[test]
    fn a_ring_waits_where_its_left_turn_would_see_yellow_beside_those_it_yields_to() {
        let mut plan = placed(Control::Coordinated);
        // Northbound vehicles turn left in phase 2, and yield to phase 6, whose change is 2 s shorter.
        plan.phases[1].yielding.push("NBL".into());
        (plan.phases[4].yellow_s, plan.phases[4].all_red_s) = (3.0, 0.0);
        plan.phases[4].max_green_s = 21.5;
        assert_eq!(greens(&plan, &[2, 6], &[4, 8], 30), [(2, 0, 21), (6, 0, 21)]);
    }

    /// Left turn 1 lags, so that phase 2 ends 12 s before phase 6.
    fn lead_lag() -> ExistingPlan {
        let mut plan = placed(Control::Coordinated);
        (plan.phases[0].position, plan.phases[1].position) = (2, 1);
        plan
    }

    #[test]
    fn nobody_waits_for_ever_whatever_the_order_of_the_phases() {
        let lead_lead = placed(Control::Coordinated);
        let mut lag_lag = lead_lag();
        (lag_lag.phases[3].position, lag_lag.phases[4].position) = (2, 1);
        let mut one_ring = placed(Control::Coordinated);
        for (phase, barrier) in one_ring.phases.iter_mut().zip(1..) {
            (phase.ring, phase.barrier, phase.position) = (1, barrier, 1);
        }
        // The phases of ring 2 after those of ring 1.
        let mut split = lead_lag();
        for phase in &mut split.phases {
            phase.barrier = 2 * phase.barrier + phase.ring;
            phase.ring = 1;
        }
        // The side street lasts longer than its split at least, or exactly as long beside unequal yellows.
        let mut long = placed(Control::Coordinated);
        let mut unequal = long.clone();
        for phase in long.phases.iter_mut().filter(|p| p.barrier == 2) {
            phase.min_green_s = phase.max_green_s + 10.0;
        }
        for phase in &mut unequal.phases {
            match phase.number {
                6 => phase.yellow_s += 1.0,
                _ if phase.barrier == 2 => phase.min_green_s = phase.max_green_s,
                _ => {}
            }
        }
        for plan in [lead_lead, lead_lag(), lag_lag, one_ring, split, long, unequal] {
            let mut rings = rings(&plan);
            let cycle_s = rings.plan.coordination.as_ref().unwrap().cycle_s;
            let mut waited_s = vec![0; plan.phases.len()];
            for second in 0..20 * cycle_s {
                // Everybody comes once a cycle, each a little later than in the cycle before.
                for (phase, waited_s) in (0..).zip(&mut waited_s) {
                    let comes = (second + 7 * phase) % (cycle_s + 1 + phase) == 0;
                    let green = rings.green_phases().any(|green| green == phase as usize);
                    *waited_s =
                        if green { 0 } else { *waited_s + u32::from(comes || *waited_s > 0) };
                    assert!(*waited_s <= 2 * cycle_s, "{second} s: phase {phase} of {plan:#?}");
                }
                let of = |s: &u32| Seen { calls: *s > 0, extends: *s > 0, walk_s: None };
                rings.step(&waited_s.iter().map(of).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn a_call_that_comes_too_late_for_its_split_waits_for_the_next_cycle() {
        let plan = placed(Control::Coordinated);
        // The split of phase 4 ends 24 s after the coordinated phases may end: 4 s of change and 5 s of green fit in
        // until 15 s.
        assert_eq!(play(&plan, &[(4, 29..99)], 81)[0], (MAIN.to_owned(), 30));
        assert_eq!(play(&plan, &[(4, 40..200)], 100)[0], (MAIN.to_owned(), 82));
        // What began late ends at the end of its split: 24 s after 20 s.
        let shown = play(&plan, &[(4, 29..200)], 81);
        assert_eq!(shown[3], (SIDE.to_owned(), 44 - 34));
    }
}
