//! What a cabinet with a high-resolution data logger would write of an episode.
//!
//! - **Phases** of two rings are those that the rings run, with the reason why a green ended. Of everything else the lights
//!   say what is green, with the phases of the plan that was given, else those of `nema`. A phase that ends without yellow,
//!   as an arrow that becomes a green that yields, has a yellow of 0 s.
//! - **Red clearance** lasts as long as the phase's all-red. Under the network's own program, whose all-red nobody says,
//!   it ends when the next green of the signal begins.
//! - **Presence**: a zone of 20 ft that ends a car's length before the stop line. A car of that length is on it exactly while
//!   its front is between `PRESENCE_M` and the stop line, which is what is observed.
//! - **Advance**: a pulse when the front of a vehicle passes a place upstream. A vehicle counts for the lane from which it will
//!   cross the stop line; in the street one loop covers a lane before it widens.
//! - **Between two seconds** vehicles are taken to move evenly, and one that has left to have gone at its last speed or faster.
//!
//! Source: J. R. Sturdevant et al., "Indiana Traffic Signal Hi Resolution Data Logger Enumerations", Purdue University, 2012.

use std::collections::BTreeMap;

use osm_signals::DrivingSide;

use crate::program::{self, ProgramKind, SignalProgram};
use crate::sim::{ProgramPhase, Scene, Snapshot};

use super::by_movement::link_names;
use super::derive::DerivedSignal;
use super::dual_ring::{Ending, NumberedPhase, Phasing};
use super::pedestrians::Pedestrians;
use crate::timing::WALK_S;
use crate::vocabulary::{Light, listed_before};

/// Codes of events, with what their parameter is.
pub mod code {
    /// Phase begins green; the phase.
    pub const BEGIN_GREEN: u16 = 1;
    /// Phase gaps out; the phase.
    pub const GAP_OUT: u16 = 4;
    /// Phase maxes out; the phase.
    pub const MAX_OUT: u16 = 5;
    /// Phase is forced off; the phase.
    pub const FORCE_OFF: u16 = 6;
    /// Green of a phase ends; the phase.
    pub const END_GREEN: u16 = 7;
    /// Phase begins yellow; the phase.
    pub const BEGIN_YELLOW: u16 = 8;
    /// Phase ends yellow; the phase.
    pub const END_YELLOW: u16 = 9;
    /// Phase begins red clearance; the phase.
    pub const BEGIN_RED: u16 = 10;
    /// Phase ends red clearance; the phase.
    pub const END_RED: u16 = 11;
    /// Pedestrians begin to walk; the phase.
    pub const BEGIN_WALK: u16 = 21;
    /// Pedestrian clearance begins; the phase.
    pub const BEGIN_CLEARANCE: u16 = 22;
    /// Steady don't walk begins; the phase.
    pub const DONT_WALK: u16 = 23;
    /// A pedestrian call is registered; the phase.
    pub const PEDESTRIAN_CALL: u16 = 45;
    /// Detector off; its channel.
    pub const DETECTOR_OFF: u16 = 81;
    /// Detector on; its channel.
    pub const DETECTOR_ON: u16 = 82;
    /// Push button off; the phase.
    pub const BUTTON_OFF: u16 = 89;
    /// Push button on; the phase.
    pub const BUTTON_ON: u16 = 90;
    /// Coordination pattern; its number.
    pub const PATTERN: u16 = 131;
    /// Cycle length; seconds.
    pub const CYCLE: u16 = 132;
    /// Offset; seconds.
    pub const OFFSET: u16 = 133;
    /// Split of phase 1; seconds. Those of phases 2 to 16 follow.
    pub const FIRST_SPLIT: u16 = 134;
}

/// Highest phase whose split has a code.
const MOST_SPLITS: u32 = 16;

/// Longest cycle of which splits are written, seconds: a day. Programs of networks last as long as they say.
const MOST_CYCLE_S: f64 = 86_400.0;

/// Length of a presence detector, metres: 20 ft.
///
/// Source: "Signal Timing Manual" (2nd ed., NCHRP Report 812), chapter 4; split failures are defined for such zones (C. M. Day et al.,
/// "Performance Measures for Traffic Signal Systems", Purdue University, 2014).
pub const PRESENCE_LENGTH_M: f64 = 6.1;

/// Where a presence detector ends, metres before the stop line: the length of SUMO's cars.
pub const PRESENCE_END_M: f64 = 5.0;

/// Distance to the stop line from which on a vehicle's front says that it is on the presence detector, metres.
const PRESENCE_M: f64 = PRESENCE_END_M + PRESENCE_LENGTH_M;

/// Largest share of what is seen of a lane at which an advance detector lies: vehicles must have been seen before it.
const MOST_OF_SEEN: f64 = 0.75;

/// How long a pulse of an advance detector and of a push button lasts, tenths of a second.
const PULSE_DS: i64 = 1;

/// Tenths of a second in one second.
const DS_PER_S: f64 = 10.0;

/// An event.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Event {
    /// When, tenths of a second of simulated time.
    pub at_ds: i64,
    /// Place of the signal in the scene.
    pub signal: usize,
    /// What: one of [`code`].
    pub code: u16,
    /// Its parameter: a phase, a channel, a number or seconds.
    pub parameter: u32,
}

/// What a detector is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Function {
    /// A zone near the stop line, on while a vehicle is there.
    Presence,
    /// A place upstream; a pulse per vehicle.
    Advance,
}

impl Function {
    /// Returns its name in tables of detectors.
    pub fn name(self) -> &'static str {
        match self {
            Self::Presence => "Presence",
            Self::Advance => "Advance",
        }
    }
}

/// A detector.
#[derive(Debug, Clone, PartialEq)]
pub struct DetectorSpec {
    /// Place of the signal in the scene.
    pub signal: usize,
    /// Its channel: odd for presence, even for advance detectors, in the order of the signal's lanes.
    pub channel: u32,
    /// What it is for.
    pub function: Function,
    /// Number of its phase.
    pub phase: u32,
    /// SUMO's id of its lane.
    pub lane: String,
    /// Movements of its lane.
    pub movements: Vec<String>,
    /// From the stop line to its end nearest to that, metres.
    pub distance_m: f64,
    /// Its length, metres.
    pub length_m: f64,
}

/// A phase of a signal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PhaseSpec {
    /// Place of the signal in the scene.
    pub signal: usize,
    /// Its number.
    pub number: u32,
    /// Its movements.
    pub movements: Vec<String>,
}

/// What was written of an episode.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Recording {
    /// SUMO's ids of the signals.
    pub signals: Vec<String>,
    /// Its events, in the order of time.
    pub events: Vec<Event>,
    /// The detectors, by signal and channel.
    pub detectors: Vec<DetectorSpec>,
    /// The phases, by signal and number.
    pub phases: Vec<PhaseSpec>,
    /// What each signal was told to show, as a program that shows it once: from the beginning of the episode to its end.
    pub programs: Vec<SignalProgram>,
}

/// Places of phases whose green ended, each with the reason where there is one.
type Ended<'a> = &'a [(usize, Option<Ending>)];

/// What a signal showed in a second.
pub(super) struct Shown<'a> {
    /// When the second began.
    pub(super) at_s: f64,
    /// The lights.
    pub(super) state: &'a str,
    /// Places of the phases that are green, where rings run them, and those that ended with the second before.
    pub(super) rings: Option<(Vec<usize>, Ended<'a>)>,
}

/// What a phase shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    Red,
    Green,
    Yellow,
    /// Since when, tenths of a second.
    Clearing(i64),
}

/// A vehicle on its way to a signal.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Track {
    /// Place of its lane among those of the signal.
    lane: usize,
    distance_m: f64,
    speed_mps: f64,
    /// Since when it has been on the presence detector.
    since_s: Option<f64>,
    has_passed: bool,
}

/// A cycle that a signal keeps to, seconds.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct CommonCycle {
    pub(super) cycle_s: u32,
    /// Absent where it has no effect, or nobody knows it.
    pub(super) offset_s: Option<u32>,
    /// By number of the phase.
    pub(super) splits_s: Vec<(u32, u32)>,
}

/// What is written of one signal.
#[derive(Debug, Clone, Default)]
pub(super) struct Logger {
    signal: usize,
    phasing: Phasing,
    /// Whether the all-red of its phases is known.
    knows_red: bool,
    stages: Vec<Option<Stage>>,
    /// By phase, since when its crosswalks have shown WALK or clearance, whether it is WALK, and how long both last, seconds.
    walks: Vec<Option<(i64, bool, u32)>>,
    last: Vec<u8>,
    setbacks_m: Vec<f64>,
    tracks: BTreeMap<u32, Track>,
    /// By lane, from when to when somebody was on the presence detector, seconds.
    present_s: Vec<Vec<(f64, f64)>>,
    /// By lane, when somebody passed the advance detector, seconds.
    passed_s: Vec<Vec<f64>>,
    events: Vec<Event>,
    /// States as SUMO was told them, with the time from which each was shown, seconds.
    told: Vec<(f64, String)>,
    /// When the last second ended.
    until_s: f64,
}

fn tenths(time_s: f64) -> i64 {
    (time_s * DS_PER_S).round() as i64
}

impl Logger {
    /// Returns the logger of a signal.
    ///
    /// # Arguments
    ///
    /// * `advance_m` — where advance detectors lie, as far as enough is seen of a lane.
    /// * `detection_m` — how far lanes are traced upstream.
    pub(super) fn new(
        signal: usize,
        phasing: Phasing,
        knows_red: bool,
        (scene, derived): (&Scene, &DerivedSignal),
        (advance_m, detection_m): (f64, f64),
    ) -> Self {
        let setback = |(lane, _): &(usize, usize)| {
            let length_m = scene.lanes[*lane].length_m;
            let place = derived.lanes.iter().position(|l| l == lane);
            let seen_m = place.map_or(length_m, |place| derived.seen_m[place]);
            advance_m.min(MOST_OF_SEEN * seen_m.min(detection_m.max(length_m)))
        };
        let setbacks_m: Vec<f64> = phasing.lanes.iter().map(setback).collect();
        let (phases, lanes) = (phasing.phases.len(), phasing.lanes.len());
        Self {
            signal,
            phasing,
            knows_red,
            stages: vec![None; phases],
            walks: vec![None; phases],
            setbacks_m,
            present_s: vec![Vec::new(); lanes],
            passed_s: vec![Vec::new(); lanes],
            ..Self::default()
        }
    }

    fn write(&mut self, at_ds: i64, code: u16, parameter: u32) {
        self.events.push(Event { at_ds, signal: self.signal, code, parameter });
    }

    /// Takes the cycle that the signal keeps to from the beginning on.
    pub(super) fn coordinate(&mut self, at_s: f64, cycle: &CommonCycle) {
        let at_ds = tenths(at_s);
        self.write(at_ds, code::PATTERN, 1);
        self.write(at_ds, code::CYCLE, cycle.cycle_s);
        if let Some(offset_s) = cycle.offset_s {
            self.write(at_ds, code::OFFSET, offset_s);
        }
        for (phase, split_s) in &cycle.splits_s {
            if (1..=MOST_SPLITS).contains(phase) {
                self.write(at_ds, code::FIRST_SPLIT + *phase as u16 - 1, *split_s);
            }
        }
    }

    /// Takes what SUMO was told to show for some seconds.
    pub(super) fn tell(&mut self, (from_s, until_s): (f64, f64), state: &str) {
        self.until_s = until_s;
        if self.told.last().is_none_or(|(_, last)| last != state) {
            self.told.push((from_s, state.to_owned()));
        }
    }

    /// Returns a program that shows once what was told; `None` where nothing was.
    fn program(&self, signal: &str) -> Option<SignalProgram> {
        let ends = self.told.iter().skip(1).map(|(from_s, _)| *from_s).chain([self.until_s]);
        let phase = |((from_s, state), until_s): (&(f64, String), f64)| {
            program::ProgramPhase::fixed(state, until_s - from_s)
        };
        let phases = self.told.iter().zip(ends).map(phase).collect();
        let offset_s = self.told.first()?.0;
        Some(SignalProgram { offset_s, ..SignalProgram::new(signal, ProgramKind::Static, phases) })
    }

    /// Takes what is shown for a second.
    pub(super) fn show(&mut self, shown: &Shown<'_>) {
        let at_ds = tenths(shown.at_s);
        let state = shown.state.as_bytes();
        // An arrow after a green that yielded is another green.
        let light = |c: Option<&u8>| c.map_or(Light::Red, |c| Light::of_letter((*c).into()));
        let begins = !self.last.is_empty()
            && (0..state.len()).any(|l| light(state.get(l)) > light(self.last.get(l)));
        let green: Vec<bool> = (0..self.stages.len())
            .map(|index| match &shown.rings {
                Some((green, _)) => green.contains(&index),
                None => self.phasing.phases[index].is_green(state),
            })
            .collect();
        for (index, is_green) in green.iter().enumerate() {
            self.end(index, *is_green, begins, shown);
        }
        for (index, is_green) in green.iter().enumerate() {
            if *is_green && self.stages[index] != Some(Stage::Green) {
                self.stages[index] = Some(Stage::Green);
                self.write(at_ds, code::BEGIN_GREEN, self.phasing.phases[index].number);
            }
        }
        self.last = state.to_vec();
    }

    /// Lets a phase go on from green to red, as far as it does.
    fn end(&mut self, index: usize, is_green: bool, begins: bool, shown: &Shown<'_>) {
        let at_ds = tenths(shown.at_s);
        let phase = &self.phasing.phases[index];
        let (number, all_red_ds) = (phase.number, i64::from(phase.all_red_s) * DS_PER_S as i64);
        let is_yellow = phase.is_yellow(shown.state.as_bytes());
        if self.stages[index] == Some(Stage::Green) && !is_green {
            let ended = shown.rings.as_ref().map_or(&[][..], |(_, ended)| ended);
            let reason = ended.iter().find(|(phase, _)| *phase == index).and_then(|e| e.1);
            let code = reason.map(|reason| match reason {
                Ending::GapOut => code::GAP_OUT,
                Ending::MaxOut => code::MAX_OUT,
                Ending::ForceOff => code::FORCE_OFF,
            });
            code.into_iter().for_each(|code| self.write(at_ds, code, number));
            self.write(at_ds, code::END_GREEN, number);
            self.write(at_ds, code::BEGIN_YELLOW, number);
            self.stages[index] = Some(Stage::Yellow);
        }
        if self.stages[index] == Some(Stage::Yellow) && (is_green || !is_yellow) {
            self.write(at_ds, code::END_YELLOW, number);
            self.write(at_ds, code::BEGIN_RED, number);
            self.stages[index] = Some(Stage::Clearing(at_ds));
        }
        if let Some(Stage::Clearing(since_ds)) = self.stages[index] {
            let is_over = if self.knows_red { at_ds >= since_ds + all_red_ds } else { begins };
            if is_over || is_green {
                self.write(at_ds, code::END_RED, number);
                self.stages[index] = Some(Stage::Red);
            }
        }
    }

    /// Takes what those who cross did and what they were shown for a second.
    pub(super) fn walk(&mut self, at_s: f64, pedestrians: &mut Pedestrians) {
        let at_ds = tenths(at_s);
        for index in 0..self.stages.len() {
            let crossings = self.phasing.phases[index].crossings.clone();
            if crossings.is_empty() {
                continue;
            }
            let number = self.phasing.phases[index].number;
            // Crosswalks of a phase may have their walks with different greens.
            let walking = crossings.iter().filter(|c| pedestrians.walks(c.0, at_s));
            let takes_s = walking.map(|c| c.1).max();
            let was = self.walks[index];
            let pushes: Vec<f64> =
                crossings.iter().flat_map(|c| pedestrians.take_calls(c.0)).collect();
            // Who comes while others walk goes with them.
            if !(takes_s.is_some() && was.is_some_and(|(_, is_walk, _)| is_walk)) {
                for push_s in pushes {
                    let push_ds = tenths(push_s);
                    self.write(push_ds, code::BUTTON_ON, number);
                    self.write(push_ds, code::PEDESTRIAN_CALL, number);
                    self.write(push_ds + PULSE_DS, code::BUTTON_OFF, number);
                }
            }
            match (was, takes_s) {
                (None, Some(takes_s)) => {
                    self.write(at_ds, code::BEGIN_WALK, number);
                    self.walks[index] = Some((at_ds, true, takes_s));
                }
                (Some((since_ds, true, lasts_s)), Some(takes_s)) => {
                    self.walks[index] = Some((since_ds, true, lasts_s.max(takes_s)));
                }
                (Some((since_ds, true, lasts_s)), None) => {
                    self.write(at_ds, code::BEGIN_CLEARANCE, number);
                    self.walks[index] = Some((since_ds, false, lasts_s));
                }
                (Some((_, false, _)), Some(takes_s)) => {
                    self.write(at_ds, code::DONT_WALK, number);
                    self.write(at_ds, code::BEGIN_WALK, number);
                    self.walks[index] = Some((at_ds, true, takes_s));
                }
                (None | Some((_, false, _)), None) => {}
            }
            if let Some((since_ds, false, lasts_s)) = self.walks[index]
                && at_ds >= since_ds + i64::from(lasts_s.max(WALK_S)) * DS_PER_S as i64
            {
                self.write(at_ds, code::DONT_WALK, number);
                self.walks[index] = None;
            }
        }
    }

    /// Takes where vehicles are.
    ///
    /// # Arguments
    ///
    /// * `before_s`, `now_s` — when vehicles were seen last, and now.
    pub(super) fn see(&mut self, snapshot: &Snapshot, (before_s, now_s): (f64, f64)) {
        let mut before = std::mem::take(&mut self.tracks);
        for vehicle in &snapshot.vehicles {
            let place = self.phasing.lanes.iter().position(|l| l.0 == vehicle.lane as usize);
            let Some(lane) = place.filter(|_| vehicle.distance_m.is_finite()) else { continue };
            let was = before.remove(&vehicle.vehicle);
            let at = |level_m: f64, was: &Track| {
                let share = (was.distance_m - level_m) / (was.distance_m - vehicle.distance_m);
                before_s + share.clamp(0.0, 1.0) * (now_s - before_s)
            };
            let came_by = |level_m: f64| match &was {
                Some(was) if was.distance_m > level_m => at(level_m, was),
                _ => now_s,
            };
            let mut track = Track {
                lane,
                distance_m: vehicle.distance_m,
                speed_mps: vehicle.speed_mps,
                since_s: None,
                has_passed: was.is_some_and(|was| was.has_passed),
            };
            let setback_m = self.setbacks_m[lane];
            if !track.has_passed && vehicle.distance_m <= setback_m {
                track.has_passed = true;
                if was.is_some() {
                    self.passed_s[lane].push(came_by(setback_m));
                }
            }
            let stayed = was.and_then(|was| Some((was.lane, was.since_s?)));
            if vehicle.distance_m <= PRESENCE_M {
                track.since_s = match stayed {
                    Some((old, since_s)) if old == lane => Some(since_s),
                    _ => Some(came_by(PRESENCE_M)),
                };
            }
            if let Some((old, since_s)) = stayed.filter(|(old, _)| *old != lane) {
                self.present_s[old].push((since_s, now_s));
            }
            self.tracks.insert(vehicle.vehicle, track);
        }
        for was in before.into_values() {
            let speed_mps = was.speed_mps.max(was.distance_m / (now_s - before_s));
            let left_s = if speed_mps > 0.0 { was.distance_m / speed_mps } else { 0.0 };
            let gone_s = (before_s + left_s).min(now_s);
            if let Some(since_s) = was.since_s {
                self.present_s[was.lane].push((since_s, gone_s));
            } else if was.distance_m - was.speed_mps * (now_s - before_s) <= PRESENCE_M {
                // It was over the detector and away within the second.
                let share = (was.distance_m - PRESENCE_M).max(0.0) / was.distance_m.max(PRESENCE_M);
                self.present_s[was.lane].push((before_s + share * (gone_s - before_s), gone_s));
            }
        }
    }

    /// Returns the presence and the advance detector of each lane.
    fn detectors(&self, scene: &Scene, names: &[Vec<String>]) -> Vec<[DetectorSpec; 2]> {
        let spec = |(place, (lane, phase)): (u32, &(usize, usize))| {
            let links = &scene.signals[self.signal].links;
            let on_lane = |link: &usize| links[*link].iter().any(|l| l.from_lane == *lane);
            let presence = DetectorSpec {
                signal: self.signal,
                channel: 2 * place + 1,
                function: Function::Presence,
                phase: self.phasing.phases[*phase].number,
                lane: scene.lanes[*lane].id.clone(),
                movements: named(names, (0..links.len()).filter(on_lane)),
                distance_m: PRESENCE_END_M,
                length_m: PRESENCE_LENGTH_M,
            };
            let advance = DetectorSpec {
                channel: 2 * place + 2,
                function: Function::Advance,
                distance_m: self.setbacks_m[place as usize],
                length_m: 0.0,
                ..presence.clone()
            };
            [presence, advance]
        };
        (0u32..).zip(&self.phasing.lanes).map(spec).collect()
    }

    /// Ends the episode.
    ///
    /// # Arguments
    ///
    /// * `names` — per link index the names of its movements.
    fn finish(&mut self, scene: &Scene, names: &[Vec<String>], recording: &mut Recording) {
        let detectors = self.detectors(scene, names);
        for track in std::mem::take(&mut self.tracks).into_values() {
            if let Some(since_s) = track.since_s {
                self.present_s[track.lane].push((since_s, f64::INFINITY));
            }
        }
        for (lane, [presence, advance]) in detectors.into_iter().enumerate() {
            for (on_ds, off_ds) in merged(std::mem::take(&mut self.present_s[lane])) {
                self.write(on_ds, code::DETECTOR_ON, presence.channel);
                off_ds.into_iter().for_each(|at_ds| {
                    self.write(at_ds, code::DETECTOR_OFF, presence.channel);
                });
            }
            let mut passed_s = std::mem::take(&mut self.passed_s[lane]);
            passed_s.sort_by(f64::total_cmp);
            let mut free_ds = i64::MIN;
            for at_s in passed_s {
                let on_ds = tenths(at_s).max(free_ds);
                self.write(on_ds, code::DETECTOR_ON, advance.channel);
                self.write(on_ds + PULSE_DS, code::DETECTOR_OFF, advance.channel);
                free_ds = on_ds + 2 * PULSE_DS;
            }
            recording.detectors.extend([presence, advance]);
        }
        recording.events.append(&mut self.events);
        recording.programs.extend(self.program(&scene.signals[self.signal].id));
        let phase = |phase: &NumberedPhase| PhaseSpec {
            signal: self.signal,
            number: phase.number,
            movements: named(names, phase.links.iter().copied()),
        };
        let mut phases: Vec<PhaseSpec> = self.phasing.phases.iter().map(phase).collect();
        phases.sort_by_key(|phase| phase.number);
        recording.phases.append(&mut phases);
    }
}

/// Returns when a detector is on, tenths of a second, from the times at which somebody was on it; it is on without an end
/// while somebody still is.
fn merged(mut present_s: Vec<(f64, f64)>) -> Vec<(i64, Option<i64>)> {
    present_s.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut merged: Vec<(i64, Option<i64>)> = Vec::new();
    for (on_s, off_s) in present_s {
        let on_ds = tenths(on_s);
        let off_ds = off_s.is_finite().then(|| tenths(off_s).max(on_ds + PULSE_DS));
        match merged.last_mut() {
            Some((_, None)) => {}
            Some((_, Some(end_ds))) if on_ds <= *end_ds => match off_ds {
                Some(off_ds) => *end_ds = off_ds.max(*end_ds),
                None => merged.last_mut().expect("it was there").1 = None,
            },
            _ => merged.push((on_ds, off_ds)),
        }
    }
    merged
}

/// Returns the movements of links, each once, in the usual order.
fn named(names: &[Vec<String>], links: impl Iterator<Item = usize>) -> Vec<String> {
    let mut found: Vec<String> = links.flat_map(|link| names[link].iter().cloned()).collect();
    found.sort_by_key(|name| listed_before(name));
    found.dedup();
    found
}

/// Ends an episode, and returns what was written of it.
pub(super) fn finish(loggers: Vec<Logger>, scene: &Scene, side: DrivingSide) -> Recording {
    let signals = scene.signals.iter().map(|signal| signal.id.clone()).collect();
    let mut recording = Recording { signals, ..Recording::default() };
    for mut logger in loggers {
        let names = link_names(scene, &scene.signals[logger.signal], side);
        logger.finish(scene, &names, &mut recording);
    }
    recording.events.sort_by_key(|event| event.at_ds);
    recording
}

/// Returns the splits of a fixed cycle by number of the phase, seconds: from green to the end of red clearance, all of a
/// phase that is green several times; `None` for one that is no cycle of whole seconds.
pub(super) fn cycle_of(
    phases: &[ProgramPhase],
    phasing: &Phasing,
    knows_red: bool,
) -> Option<CommonCycle> {
    let is_whole = |s: f64| s >= 1.0 && s.fract() == 0.0;
    let whole_s: f64 = phases.iter().map(|p| p.duration_s).sum();
    if phases.len() < 2 || whole_s > MOST_CYCLE_S || phases.iter().any(|p| !is_whole(p.duration_s))
    {
        return None;
    }
    let cycle: Vec<&str> = (phases.iter())
        .flat_map(|p| std::iter::repeat_n(p.state.as_str(), p.duration_s as usize))
        .collect();
    let stages = vec![None; phasing.phases.len()];
    let mut logger = Logger { phasing: phasing.clone(), knows_red, stages, ..Logger::default() };
    for second in 0..3 * cycle.len() {
        let state = cycle[second % cycle.len()];
        logger.show(&Shown { at_s: second as f64, state, rings: None });
    }
    // What began in the second cycle.
    let per_cycle_ds = 10 * cycle.len() as i64;
    let split = |number: u32| {
        let own = |code: u16| {
            let is = move |e: &&Event| e.code == code && e.parameter == number;
            logger.events.iter().filter(is).map(|e| e.at_ds)
        };
        let begins =
            own(code::BEGIN_GREEN).filter(|at| (per_cycle_ds..2 * per_cycle_ds).contains(at));
        let lasts = |begin: i64| own(code::END_RED).find(|end| *end > begin).map(|end| end - begin);
        let split_ds: i64 = begins.map(|begin| lasts(begin).unwrap_or(per_cycle_ds)).sum();
        (split_ds > 0).then_some((number, (split_ds / 10) as u32))
    };
    let splits_s = phasing.phases.iter().filter_map(|p| split(p.number)).collect();
    Some(CommonCycle { cycle_s: cycle.len() as u32, offset_s: None, splits_s })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sim::VehicleState;

    /// Phases 2 and 4 on links 0 and 1, and phase 5, which shares link 2 with phase 2.
    fn logger(knows_red: bool) -> Logger {
        let phase = |number, links: &[usize], watched: &[usize], needs_arrow| NumberedPhase {
            number,
            links: links.to_vec(),
            watched: watched.to_vec(),
            needs_arrow,
            all_red_s: 2,
            crossings: vec![],
        };
        let phases = vec![
            phase(2, &[0, 2], &[0], false),
            phase(4, &[1], &[1], false),
            phase(5, &[2], &[2], true),
        ];
        Logger {
            phasing: Phasing { phases, lanes: vec![(7, 0)] },
            knows_red,
            stages: vec![None; 3],
            walks: vec![None; 3],
            setbacks_m: vec![100.0],
            present_s: vec![vec![]],
            passed_s: vec![vec![]],
            ..Logger::default()
        }
    }

    /// Returns code, phase and second of what is written while states are shown.
    fn shown(knows_red: bool, states: &[(&str, usize)]) -> Vec<(u16, u32, i64)> {
        let mut logger = logger(knows_red);
        let seconds = states.iter().flat_map(|(state, s)| std::iter::repeat_n(*state, *s));
        for (second, state) in seconds.enumerate() {
            logger.show(&Shown { at_s: second as f64, state, rings: None });
        }
        logger.events.iter().map(|e| (e.code, e.parameter, e.at_ds / 10)).collect()
    }

    #[test]
    fn lights_say_when_phases_begin_and_end() {
        let states = [("Grg", 9), ("yry", 3), ("rrr", 1), ("rGr", 5)];
        let ends = [(7, 2, 9), (8, 2, 9), (9, 2, 12), (10, 2, 12)];
        // Nobody says how long the network's all-red is: until the next green.
        let expected = [&[(1, 2, 0)][..], &ends, &[(11, 2, 13), (1, 4, 13)]].concat();
        assert_eq!(shown(false, &states), expected);
        let expected = [&[(1, 2, 0)][..], &ends, &[(1, 4, 13), (11, 2, 14)]].concat();
        assert_eq!(shown(true, &states), expected);
    }

    #[test]
    fn an_arrow_after_a_green_that_yields_ends_the_red_clearance_of_others() {
        let found = shown(false, &[("Grg", 5), ("yrg", 3), ("rrg", 1), ("rrG", 5)]);
        assert_eq!(found[4..], [(10, 2, 8), (11, 2, 9), (1, 5, 9)]);
    }

    #[test]
    fn an_arrow_that_becomes_a_green_that_yields_has_no_yellow() {
        let found = shown(true, &[("GrG", 5), ("Grg", 5)]);
        let begins = [(1, 2, 0), (1, 5, 0)];
        let ends = [(7, 5, 5), (8, 5, 5), (9, 5, 5), (10, 5, 5), (11, 5, 7)];
        assert_eq!(found, [&begins[..], &ends].concat());
    }

    #[test]
    fn a_fixed_cycle_has_splits_from_green_to_the_end_of_red_clearance() {
        let cycle = [("GrG", 6.0), ("Grg", 14.0), ("yry", 3.0), ("rrr", 2.0), ("rGr", 10.0)];
        let end = [("ryr", 3.0), ("rrr", 2.0)];
        let phases: Vec<ProgramPhase> =
            cycle.iter().chain(&end).map(|(state, s)| ProgramPhase::fixed(*state, *s)).collect();
        let found = cycle_of(&phases, &logger(true).phasing, true).unwrap();
        let splits_s = vec![(2, 25), (4, 15), (5, 8)];
        assert_eq!(found, CommonCycle { cycle_s: 40, offset_s: None, splits_s });
        let half = [ProgramPhase::fixed("Grr", 9.5), ProgramPhase::fixed("rGr", 9.5)];
        assert_eq!(cycle_of(&half, &logger(true).phasing, true), None);
        let endless = [ProgramPhase::fixed("Grr", 1e12), ProgramPhase::fixed("rGr", 10.0)];
        assert_eq!(cycle_of(&endless, &logger(true).phasing, true), None);
    }

    /// Returns code and tenth of a second of what the detectors of a lane write of a vehicle seen at these distances and speeds.
    fn driven(seconds: &[Option<(f64, f64)>]) -> Vec<(u16, u32, i64)> {
        let mut logger = logger(true);
        for (second, seen) in seconds.iter().enumerate() {
            let vehicle = |(distance_m, speed_mps): (f64, f64)| VehicleState {
                lane: 7,
                link: Some(0),
                vehicle: 1,
                speed_mps,
                distance_m,
                ..VehicleState::default()
            };
            let vehicles = seen.map(vehicle).into_iter().collect();
            let span_s = (second as f64, second as f64 + 1.0);
            logger.see(&Snapshot { vehicles, phases: vec![] }, span_s);
        }
        let mut scene = Scene::default();
        scene.lanes.resize(8, crate::sim::Lane::default());
        let names = vec![vec![]; 3];
        scene.signals.push(crate::sim::SignalInfo {
            id: "c".into(),
            links: vec![vec![]; 3],
            programs: vec![],
            active_program: String::new(),
            meets: vec![],
        });
        let mut recording = Recording::default();
        logger.finish(&scene, &names, &mut recording);
        recording.events.iter().map(|e| (e.code, e.parameter, e.at_ds)).collect()
    }

    #[test]
    fn a_vehicle_is_seen_upstream_and_at_the_stop_line() {
        // 100 m in the middle of the second second; 11.1 m at 3.445 s; over the stop line after 2 of 20 m.
        let seconds = [Some((110.0, 20.0)), Some((90.0, 20.0)), Some((20.0, 20.0))];
        let found = driven(&[&seconds[..], &[Some((2.0, 20.0)), None]].concat());
        assert_eq!(found, [(82, 1, 35), (81, 1, 41), (82, 2, 15), (81, 2, 16)]);
        // Away within the second: from 11.1 of 15 m to the stop line, at 20 m/s.
        let found = driven(&[Some((15.0, 20.0)), None]);
        assert_eq!(found, [(82, 1, 12), (81, 1, 18)]);
    }

    #[test]
    fn a_vehicle_that_begins_behind_a_detector_does_not_pass_it_and_one_that_stands_stays_on() {
        assert_eq!(driven(&[Some((50.0, 0.0)), Some((8.0, 9.0)), Some((1.0, 0.0))]), [(82, 1, 19)]);
        assert_eq!(driven(&[Some((150.0, 10.0)), Some((140.0, 10.0))]), []);
    }

    #[test]
    fn times_that_overlap_are_one() {
        let found = merged(vec![(3.0, 4.0), (1.0, 2.0), (1.5, 2.5), (3.95, 4.5)]);
        assert_eq!(found, [(10, Some(25)), (30, Some(45))]);
        assert_eq!(merged(vec![(1.0, f64::INFINITY), (2.0, 3.0)]), [(10, None)]);
        assert_eq!(merged(vec![(0.0, 2.0), (1.0, f64::INFINITY)]), [(0, None)]);
    }
}
