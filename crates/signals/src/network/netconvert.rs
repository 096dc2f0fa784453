//! Runs netconvert: from an intersection to the text of its `.net.xml`.
//!
//! Two passes: the first gives netconvert's own program and the order of the signal's links, the
//! second a network with both programs. Only a network that knows the permissive greens of both
//! has room to wait for them within the junction.
//!
//! The default program has netconvert's greens in netconvert's order. Cycle and left green come from the
//! settings, whose defaults are netconvert's; yellow, all-red and shortest greens are those that hold for
//! every method, see [`default_program`](super::default_program). With 3 s of yellow the program is what any user of
//! netconvert gets for streets of up to 30 mph, but for a second more of left-turn green; netconvert
//! itself would give faster streets a longer yellow, and wide and slow ones an all-red.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use osm_signals::Turn;

use super::default_program::{timing, within_limits};
use super::demand::DemandSpec;
use super::intersection::IntersectionSpec;
use super::lanes::{Connection, LaneLayout, layout};
use super::left_turns::treatments;
use super::phases::{Lights, PHASES_PROGRAM, on_red, phases, program, stages};
use super::plain::{self, DEFAULT_PROGRAM};
use super::tool::{find, finish};
use crate::junction::{Conflicts, Movement};
use crate::network::error::NetworkError;
use crate::program::ProgramPhase;
use crate::settings::{NetworkSettings, Scenario};
use crate::sim::net_file::NetFile;
use crate::vocabulary::Light;
use basics::files::FileError;

/// Options of every run: no downloads of schemas, no U-turns.
const OPTIONS: [&str; 6] = ["-X", "never", "--no-turnarounds", "true", "--precision", "2"];

/// Id that netconvert gives to the program it makes.
const FIRST_PROGRAM: &str = "0";

/// Turning radii of the junction's corners to try, metres. The first is netconvert's default; where
/// opposing left turns overlap in so narrow a junction, a wider one gives them room.
const CORNERS_M: [f64; 5] = [4.0, 6.0, 8.0, 12.0, 16.0];

/// Longest time that a netconvert may take; a network of one intersection takes a tenth of a second.
const LIMIT: Duration = Duration::from_secs(300);

/// A netconvert that runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Netconvert {
    /// Where it was found.
    pub path: PathBuf,
    /// Its version, such as `1.15.0`.
    pub version: String,
}

impl Netconvert {
    /// Finds netconvert in `SUMO_HOME/bin`, then on `PATH`.
    /// Fails with [`NetworkError::NoNetconvert`] naming the places looked at.
    pub fn find() -> Result<Self, NetworkError> {
        let found = find().map_err(|tried| NetworkError::NoNetconvert { tried });
        found.map(|(path, version)| Self { path, version })
    }

    /// Builds the network of an intersection, with intermediate files in `folder`. Returns the `.net.xml`, its lanes, and
    /// the green phases of the program [`PHASES_PROGRAM`].
    ///
    /// The text depends only on the intersection, the settings and the version of netconvert.
    /// Fails with [`NetworkError::Intersection`] for an impossible intersection,
    /// [`NetworkError::Netconvert`] if netconvert fails, [`NetworkError::Unsound`] if its output
    /// lacks something, [`NetworkError::Io`] for files.
    pub fn build(
        &self,
        spec: &IntersectionSpec,
        scenario: &Scenario,
        folder: &Path,
    ) -> Result<(String, LaneLayout, Vec<Lights>), NetworkError> {
        let Scenario { network: settings, signal, demand, .. } = scenario;
        let unsound = |reason: String| NetworkError::Unsound { point: spec.point.clone(), reason };
        let layout = layout(spec)?;
        let exit_length_m = settings.exit_length_m;
        write(folder, "p.edg.xml", &plain::edges(spec, &layout, exit_length_m))?;
        write(folder, "p.con.xml", &plain::connections(spec, &layout))?;

        let attempt = |corner_m| -> Result<_, NetworkError> {
            let nodes = plain::nodes(spec, &layout, exit_length_m, corner_m, plain::PLAIN);
            write(folder, "p.nod.xml", &nodes)?;
            let text = self.run(spec, settings, folder, &[], "first.net.xml")?;
            let net = NetFile::parse(&text).map_err(unsound)?;
            let links = links(&layout, &net).map_err(unsound)?;
            let mut conflicts = Conflicts::of(&layout.movements);
            let overlap = refine(&mut conflicts, &layout, &net);
            Ok((net, links, conflicts, overlap, corner_m))
        };
        let mut first = attempt(CORNERS_M[0])?;
        for corner_m in &CORNERS_M[1..] {
            if !first.3 {
                break;
            }
            first = attempt(*corner_m)?;
        }
        let (net, links, conflicts, _, corner_m) = first;
        let vehicles = DemandSpec::from_intersection(spec, demand)?;
        let lefts = treatments(spec, &layout, &vehicles, settings, signal);
        let phases = phases(spec, &layout, &conflicts, lefts.as_deref());
        let own = net
            .program(FIRST_PROGRAM)
            .ok_or_else(|| unsound("netconvert made no program".to_owned()))?;
        let movement_of_link = movement_of_link(&layout, &links);
        let mut ours = program(&phases, &movement_of_link, settings);
        let timing = timing(spec, &layout, &movement_of_link, signal);
        let mut own = own.to_vec();
        if signal.no_merging_greens {
            let states: Vec<_> = own.iter().map(|p| (p.state.as_str(), p.duration_s)).collect();
            own = timing.greens(&states).into_iter().map(|i| own[i].clone()).collect();
            without_merging(&mut own, &layout, &movement_of_link, &spec.merging);
        }
        let mut own = match &lefts {
            None => within_limits(&own, &timing, settings),
            Some(lefts) => {
                let states: Vec<_> = own.iter().map(|p| (p.state.as_str(), p.duration_s)).collect();
                let greens_of_own: Vec<Lights> = (timing.greens(&states).into_iter())
                    .map(|i| lights(states[i].0, &movement_of_link))
                    .collect();
                let stages = stages(&greens_of_own, &layout, &conflicts, lefts);
                within_limits(&greens(&stages, &movement_of_link, settings), &timing, settings)
            }
        };
        if signal.turn_on_red {
            // Greens are as without it; the second network knows whom to yield to on red.
            let of = |link: usize| net.links.iter().find(|l| l.link == link);
            let meet = |a, b| a != b && of(a).zip(of(b)).is_some_and(|(a, b)| net.meet(a, b));
            let mut may = turns_on_red(spec, &layout, &links);
            // Of two that meet, as at five arms, only one may.
            for link in 0..may.len() {
                may[link] &= !(0..link).any(|other| may[other] && meet(link, other));
            }
            [ours, own] = [ours, own].map(|program| on_red(program, &may, &meet));
            let kind = plain::TURN_ON_RED;
            let nodes = plain::nodes(spec, &layout, exit_length_m, corner_m, kind);
            write(folder, "p.nod.xml", &nodes)?;
        }
        let programs = [(DEFAULT_PROGRAM, own.as_slice()), (PHASES_PROGRAM, ours.as_slice())];
        write(folder, "p.tll.xml", &plain::signals(&layout, &links, programs))?;

        let second = self.run(spec, settings, folder, &["-i", "p.tll.xml"], "second.net.xml")?;
        let text = without_comment(&second);
        let net = NetFile::parse(&text).map_err(unsound)?;
        for (id, expected) in programs {
            if net.program(id) != Some(expected) {
                return Err(unsound(format!("netconvert changed the program {id:?}")));
            }
        }
        Ok((text, layout, phases))
    }

    fn run(
        &self,
        spec: &IntersectionSpec,
        settings: &NetworkSettings,
        folder: &Path,
        extra: &[&str],
        output: &str,
    ) -> Result<String, NetworkError> {
        let point = spec.point.clone();
        let mut command = Command::new(&self.path);
        command
            .current_dir(folder)
            .args(OPTIONS)
            .args(["--lefthand", if spec.side.is_right() { "false" } else { "true" }])
            .args(["-n", "p.nod.xml", "-e", "p.edg.xml", "-x", "p.con.xml", "-o", output])
            .args(["--tls.cycle.time", &whole(settings.default_cycle_s)])
            .args(["--tls.left-green.time", &whole(settings.default_left_green_s)])
            .args(extra);
        finish(command, LIMIT, &point)?;
        let path = folder.join(output);
        let text = fs::read_to_string(&path).map_err(FileError::at("read", &path))?;
        if !text.trim_end().ends_with("</net>") {
            // It says nothing when it cannot write, and ends well.
            let reason = "netconvert could not write all of the network; is the disk full?".into();
            return Err(NetworkError::Disturbed { point, reason });
        }
        Ok(text)
    }
}

/// Completes the conflicts that geometry implies by those that netconvert sees within the junction,
/// and by who yields there; returns whether left turns overlap that should not.
fn refine(conflicts: &mut Conflicts, layout: &LaneLayout, net: &NetFile) -> bool {
    let links = |m: &Movement| {
        let (from, to) = (m.from_edge(), m.to_edge());
        net.links.iter().filter(move |l| l.from == from && l.to == to)
    };
    let mut overlap = false;
    for (i, a) in layout.movements.iter().enumerate() {
        for (j, b) in layout.movements.iter().enumerate().filter(|(_, b)| b.from != a.from) {
            let pairs = || links(a).flat_map(|l| links(b).map(move |k| (l, k)));
            let mut meeting = pairs().filter(|(l, k)| net.meet(l, k)).peekable();
            if meeting.peek().is_none() {
                continue;
            }
            overlap |= !a.conflicts_with(b) && a.turn == Turn::Left && b.turn == Turn::Left;
            let yields = meeting.all(|(l, k)| net.yields(l, k));
            conflicts.set(i, j, yields);
        }
    }
    overlap
}

/// Takes the right of way from movements that have it beside another one into the same leg: from that of the two which has it in
/// more greens. One that has no other gets a green with its approach alone.
fn without_merging(
    greens: &mut Vec<ProgramPhase>,
    layout: &LaneLayout,
    movement_of_link: &[usize],
    may: &[(String, String)],
) {
    let all = &layout.movements;
    let has = |green: &ProgramPhase, m: usize| {
        lights(&green.state, movement_of_link)[m] == Light::Protected
    };
    let is_exempt = |m: &Movement| may.contains(&(m.from_edge(), m.to_edge()));
    let merge = |a: &Movement, b: &Movement| {
        let ahead = a.turn != Turn::Right && b.turn != Turn::Right;
        ahead && a.from != b.from && a.to == b.to && !(is_exempt(a) && is_exempt(b))
    };
    for (a, b) in (0..all.len()).flat_map(|a| (0..a).map(move |b| (a, b))) {
        for place in (0..greens.len()).filter(|_| merge(&all[a], &all[b])) {
            if !has(&greens[place], a) || !has(&greens[place], b) {
                continue;
            }
            let count = |m: usize| greens.iter().filter(|green| has(green, m)).count();
            let waits = if count(a) > count(b) { a } else { b };
            if count(waits) == 1 {
                let own = movement_of_link.iter().map(|m| all[*m].from == all[waits].from);
                let state = own.map(|is_own| if is_own { 'G' } else { 'r' }).collect::<String>();
                greens.push(ProgramPhase::fixed(state, greens[place].duration_s));
            }
            let letters = greens[place].state.chars().zip(movement_of_link);
            let state = letters.map(|(c, m)| if *m == waits { 'r' } else { c }).collect();
            greens[place].state = state;
        }
    }
}

/// Returns of every link of the signal whether it turns right from the rightmost lane, and no sign forbids that on red.
fn turns_on_red(spec: &IntersectionSpec, layout: &LaneLayout, links: &[usize]) -> Vec<bool> {
    let mut may = vec![false; links.len()];
    for (c, link) in layout.connections.iter().zip(links) {
        let may_arm = !spec.arms[c.movement.from].no_turn_on_red;
        may[*link] = may_arm && c.movement.turn == Turn::Right && c.from_lane == 0;
    }
    may
}

/// Returns what a state shows movements.
fn lights(state: &str, movement_of_link: &[usize]) -> Lights {
    let movements = movement_of_link.iter().max().map_or(0, |last| last + 1);
    let mut lights = vec![Light::Red; movements];
    for (letter, movement) in state.chars().zip(movement_of_link) {
        lights[*movement] = lights[*movement].max(Light::of_letter(letter));
    }
    lights
}

/// Returns greens as a program without changes; how long they last compares the through movements of the streets.
fn greens(
    stages: &[(Lights, bool)],
    movement_of_link: &[usize],
    settings: &NetworkSettings,
) -> Vec<ProgramPhase> {
    let green = |(lights, is_left): &(Lights, bool)| {
        let state: String = movement_of_link.iter().map(|m| lights[*m].letter()).collect();
        let seconds = [settings.phase_green_s, settings.default_left_green_s];
        ProgramPhase::fixed(state, seconds[usize::from(*is_left)])
    };
    stages.iter().map(green).collect()
}

/// Returns the movement of every link.
fn movement_of_link(layout: &LaneLayout, links: &[usize]) -> Vec<usize> {
    let mut movement_of_link = vec![0; links.len()];
    for (c, link) in layout.connections.iter().zip(links) {
        let movement = layout.movements.iter().position(|m| *m == c.movement);
        movement_of_link[*link] = movement.expect("connections belong to movements");
    }
    movement_of_link
}

/// Returns the link of every connection.
/// The error is the connection that the network lacks.
pub fn links(layout: &LaneLayout, net: &NetFile) -> Result<Vec<usize>, String> {
    let link = |c: &Connection| {
        let (from, to) = (c.movement.from_edge(), c.movement.to_edge());
        net.links
            .iter()
            .find(|l| {
                l.from == from && l.to == to && (l.from_lane, l.to_lane) == (c.from_lane, c.to_lane)
            })
            .map(|l| l.link)
            .filter(|&link| link < layout.connections.len())
            .ok_or_else(|| format!("netconvert gave no link from {from} to {to}"))
    };
    layout.connections.iter().map(link).collect()
}

/// Writes a file in a folder of files for SUMO.
/// Fails with [`FileError`] when it cannot be written.
pub fn write(folder: &Path, name: &str, text: &str) -> Result<(), FileError> {
    let path = folder.join(name);
    fs::write(&path, text).map_err(FileError::at("write", &path))
}

/// Returns a network without the comment that says when, where and how it was made.
fn without_comment(net: &str) -> String {
    let root = net.find("<net ").unwrap_or_default();
    format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\n{}", &net[root..])
}

/// netconvert takes whole seconds.
fn whole(seconds: f64) -> String {
    format!("{seconds:.0}")
}

#[cfg(test)]
mod tests {
    use osm_signals::DrivingSide;

    use super::super::lanes::link_order;
    use super::super::movements::shapes::{cross, spec, tee};
    use super::*;
    use crate::settings::defaults;

    #[test]
    fn links_are_in_the_order_that_programs_from_elsewhere_are_read_in() {
        let netconvert = Netconvert::find().unwrap();
        let mut shapes = vec![cross(), tee(), spec(&[20.0, 95.0, 170.0, 200.0, 330.0])];
        shapes[0].arms[1].left_turn_lanes = 1;
        for mut shape in shapes {
            for side in [DrivingSide::Right, DrivingSide::Left] {
                shape.side = side;
                let folder = tempfile::tempdir().unwrap();
                let (text, layout, _) =
                    netconvert.build(&shape, &defaults(), folder.path()).unwrap();
                let links = links(&layout, &NetFile::parse(&text).unwrap()).unwrap();
                assert_eq!(link_order(&shape, &layout), links, "{side:?}: {:?}", shape.arms);
            }
        }
    }

    #[test]
    fn two_movements_go_into_one_leg_together_only_where_they_may() {
        // From the north straight on and from the stem to the left, each into lanes of its own.
        let mut tee = tee();
        (tee.arms[0].lanes_in, tee.arms[0].left_turn_lanes, tee.arms[2].lanes_out) = (3, 1, 3);
        let together = |spec: &IntersectionSpec, no_merging_greens: bool| {
            let mut scenario = defaults();
            scenario.signal.no_merging_greens = no_merging_greens;
            let folder = tempfile::tempdir().unwrap();
            let netconvert = Netconvert::find().unwrap();
            let (text, layout, _) = netconvert.build(spec, &scenario, folder.path()).unwrap();
            let net = NetFile::parse(&text).unwrap();
            let movement_of_link = movement_of_link(&layout, &links(&layout, &net).unwrap());
            let [one, other] = [(0, 2), (1, 2)]
                .map(|way| layout.movements.iter().position(|m| (m.from, m.to) == way).unwrap());
            net.program(DEFAULT_PROGRAM).unwrap().iter().any(|phase| {
                let lights = lights(&phase.state, &movement_of_link);
                [one, other].iter().all(|m| lights[*m] == Light::Protected)
            })
        };
        assert!(together(&tee, false) && !together(&tee, true));
        tee.merging = [("in0", "out2"), ("in1", "out2")].map(|(a, b)| (a.into(), b.into())).into();
        assert!(together(&tee, true));
    }

    #[test]
    fn the_comment_with_date_and_paths_is_dropped() {
        assert_eq!(
            without_comment("<?xml?>\n<!-- when -->\n<net a=\"1\">\n</net>\n"),
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\n<net a=\"1\">\n</net>\n"
        );
    }

    #[test]
    fn what_netconvert_rejects_is_quoted() {
        let folder = tempfile::tempdir().unwrap();
        let mut spec = cross();
        spec.arms[0].speed_mps = -1.0;
        let netconvert = Netconvert::find().unwrap();
        let e = netconvert.build(&spec, &defaults(), folder.path()).unwrap_err();
        assert!(e.to_string().starts_with("p: netconvert failed: Error: "), "{e}");
    }
}
