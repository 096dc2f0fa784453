//! An intersection as netconvert's plain XML.
//!
//! Node `c` is the signal. Arm `k`, clockwise from north, has the incoming edge `in{k}` from node
//! `n{k}` and the outgoing edge `out{k}` to node `x{k}`, where it has lanes in that direction.
//!
//! A street with bays consists of pieces, see [`bays`](super::bays): `in{k}` is the one at the signal, `up{k}` and `far{k}` lie
//! upstream.
//!
//! In left-hand traffic, which netconvert's `--lefthand` builds, the drawing is the mirror image: arms
//! count anticlockwise, and lanes from the left, as SUMO counts them there.
//!
//! The lengths of edges are given as attributes, so that SUMO's length from the arm's end to the
//! stop line is exactly the feature; the nodes lie as much further out as the junction is
//! estimated to be wide, so that the drawing nearly agrees.

use std::fmt::Write;

pub use super::bays::SIGNAL;
use super::bays::{Piece, pieces, ways};
use super::intersection::{Arm, IntersectionSpec};
use super::lanes::LaneLayout;
use crate::junction::outgoing_edge;
use crate::program::ProgramPhase;
use crate::vocabulary::DEFAULT_LANE_WIDTH_M;

/// Program id of netconvert's own program, which SUMO runs unless told otherwise.
///
/// It must sort after [`PHASES_PROGRAM`](super::phases::PHASES_PROGRAM): SUMO runs the program that
/// comes last in the file, but until its first change vehicles see the lights of the one whose id
/// sorts last (seen in SUMO 1.15 and 1.28). With netconvert's own id, `0`, they would run red
/// lights for half a minute.
pub const DEFAULT_PROGRAM: &str = "program";

/// Width of a lane, metres (SUMO's default).
pub const LANE_WIDTH_M: f64 = DEFAULT_LANE_WIDTH_M;

/// SUMO's type of a node with a signal.
pub const PLAIN: &str = "traffic_light";

/// SUMO's type of a node with a signal whose right turns know how to yield to crossing traffic.
pub const TURN_ON_RED: &str = "traffic_light_right_on_red";

/// Returns the nodes file.
/// * `corner_m` — turning radius at the corners of the junction, metres.
/// * `kind` — type of the node with the signal.
pub fn nodes(
    spec: &IntersectionSpec,
    layout: &LaneLayout,
    exit_length_m: f64,
    corner_m: f64,
    kind: &str,
) -> String {
    let width = |(i, arm): (usize, &Arm)| arm.lanes_in + layout.exit_lanes[i];
    let widest = spec.arms.iter().enumerate().map(width).max().unwrap_or_default();
    let radius_m = corner_m + LANE_WIDTH_M * f64::from(widest) / 2.0;
    let mut nodes = String::new();
    line(
        &mut nodes,
        format_args!(
            "<node id=\"{SIGNAL}\" x=\"0\" y=\"0\" type=\"{kind}\" radius=\"{corner_m}\"/>"
        ),
    );
    for (i, arm) in spec.arms.iter().enumerate() {
        let ends = [
            (format!("n{i}"), arm.lanes_in, arm.length_m),
            (format!("x{i}"), layout.exit_lanes[i], exit_length_m),
        ];
        let opening = |piece: &Piece| (piece.from.clone(), piece.lanes, piece.begins_m);
        let street = pieces(spec, i);
        let openings = street.iter().rev().skip(1).map(opening);
        let ends: Vec<_> = ends.into_iter().chain(openings).collect();
        for (id, _, length_m) in ends.iter().filter(|(_, lanes, _)| *lanes > 0) {
            let (sin, cos) = arm.bearing_deg.to_radians().sin_cos();
            let (east, y) = ((length_m + radius_m) * sin, (length_m + radius_m) * cos);
            // The drawing shows the ground, so that of left-hand traffic is mirrored back.
            let x = if spec.side.is_right() { east } else { 0.0 - east };
            line(&mut nodes, format_args!("<node id=\"{id}\" x=\"{x:.2}\" y=\"{y:.2}\"/>"));
        }
    }
    document("nodes", &nodes)
}

/// Returns the edges file.
pub fn edges(spec: &IntersectionSpec, layout: &LaneLayout, exit_length_m: f64) -> String {
    let mut edges = String::new();
    for (i, arm) in spec.arms.iter().enumerate() {
        let end = format!("x{i}");
        let street = pieces(spec, i);
        let incoming = street
            .iter()
            .map(|p| (p.edge.clone(), p.from.as_str(), p.to.as_str(), p.lanes, p.length_m));
        let outgoing =
            (outgoing_edge(i), SIGNAL, end.as_str(), layout.exit_lanes[i], exit_length_m);
        let directions = incoming.chain([outgoing]);
        for (id, from, to, lanes, length_m) in directions.filter(|d| d.3 > 0) {
            let speed_mps = arm.speed_mps;
            line(
                &mut edges,
                format_args!(
                    "<edge id=\"{id}\" from=\"{from}\" to=\"{to}\" numLanes=\"{lanes}\" \
                     speed=\"{speed_mps:.2}\" length=\"{length_m:.2}\"/>"
                ),
            );
        }
    }
    document("edges", &edges)
}

/// Returns the connections file.
pub fn connections(spec: &IntersectionSpec, layout: &LaneLayout) -> String {
    let mut connections = String::new();
    for c in &layout.connections {
        let (from, to) = (c.movement.from_edge(), c.movement.to_edge());
        connection(&mut connections, [&from, &to], [c.from_lane, c.to_lane], "");
    }
    for street in (0..spec.arms.len()).map(|arm| pieces(spec, arm)) {
        for pair in street.windows(2) {
            for (from_lane, to_lane) in ways(&pair[1], &pair[0]) {
                let edges = [pair[1].edge.as_str(), pair[0].edge.as_str()];
                connection(&mut connections, edges, [from_lane, to_lane], "");
            }
        }
    }
    document("connections", &connections)
}

/// Returns the signal file: programs, each with its id, and the link of every connection.
/// * `links` — per connection of the layout its link index.
pub fn signals(
    layout: &LaneLayout,
    links: &[usize],
    programs: [(&str, &[ProgramPhase]); 2],
) -> String {
    let mut text = String::new();
    for (id, phases) in programs {
        line(
            &mut text,
            format_args!(
                "<tlLogic id=\"{SIGNAL}\" type=\"static\" programID=\"{id}\" offset=\"0\">"
            ),
        );
        for phase in phases {
            let (duration_s, state) = (phase.duration_s, &phase.state);
            let phase = format_args!("    <phase duration=\"{duration_s}\" state=\"{state}\"/>");
            line(&mut text, phase);
        }
        line(&mut text, format_args!("</tlLogic>"));
    }
    for (c, link) in layout.connections.iter().zip(links) {
        let (from, to) = (c.movement.from_edge(), c.movement.to_edge());
        let of_signal = format!(" tl=\"{SIGNAL}\" linkIndex=\"{link}\"");
        connection(&mut text, [&from, &to], [c.from_lane, c.to_lane], &of_signal);
    }
    document("tlLogics", &text)
}

fn connection(text: &mut String, [from, to]: [&str; 2], lanes: [u32; 2], more: &str) {
    let [from_lane, to_lane] = lanes;
    line(
        text,
        format_args!(
            "<connection from=\"{from}\" to=\"{to}\" fromLane=\"{from_lane}\" toLane=\"{to_lane}\"{more}/>"
        ),
    );
}

fn line(text: &mut String, line: std::fmt::Arguments<'_>) {
    writeln!(text, "    {line}").expect("writing to a string cannot fail");
}

fn document(root: &str, body: &str) -> String {
    format!("<{root}>\n{body}</{root}>\n")
}

#[cfg(test)]
mod tests {
    use super::super::lanes::layout;
    use super::super::movements::shapes::cross;
    use super::*;

    #[test]
    fn an_arm_to_the_east_lies_at_its_length_plus_the_junction() {
        let s = cross();
        let nodes = nodes(&s, &layout(&s).unwrap(), 60.0, 4.0, PLAIN);
        assert!(nodes.contains(r#"<node id="n1" x="210.40" y="0.00"/>"#), "{nodes}");
        assert!(nodes.contains(r#"<node id="x1" x="70.40" y="0.00"/>"#), "{nodes}");
        // A one-way arm has one edge.
        let mut s = cross();
        s.arms[1].lanes_in = 0;
        let edges = edges(&s, &layout(&s).unwrap(), 60.0);
        assert!(edges.contains(r#"<edge id="out1" from="c" to="x1" numLanes="2" "#), "{edges}");
        assert!(!edges.contains("in1"), "{edges}");
    }
}
