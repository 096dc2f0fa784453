//! A sketch of an intersection to scale: streets, lanes, turn lanes with their length, and turn arrows.
//!
//! Lanes are 12 ft wide, as their true width is not known; lengths, numbers and directions are those that were simulated.

use std::fmt::Write;

use quick_xml::escape::escape;

use signals::places::{DrawnArm, DrawnIntersection};

/// Size of the drawing, pixels.
const SIZE_PX: f64 = 520.0;

/// Width of a lane, metres (12 ft).
const LANE_M: f64 = 3.66;

/// What lies between the crossing street and a stop line, metres.
const SET_BACK_M: f64 = 4.0;

/// Street that is drawn before the stop line, metres.
const SHOWN_M: f64 = 62.0;

/// Room for names around the drawing, metres.
const ROOM_M: f64 = 14.0;

/// Height of letters, pixels: 7 pt where the drawing is 3.4 in wide, as on paper.
const LETTERS_PX: f64 = 15.0;

/// Half the width of a letter, pixels.
const HALF_LETTER_PX: f64 = 4.2;

/// Where turn arrows are, metres before the stop line.
const ARROW_M: f64 = 9.0;

/// Length of the scale bar, metres.
const BAR_M: f64 = 20.0;

/// Colours of street, markings and text.
const STREET: &str = "#d5d5d5";
const MARKING: &str = "#ffffff";
const INK: &str = "#111111";

/// The directions of an arm on the drawing.
#[derive(Clone, Copy)]
struct Axes {
    /// Away from the centre.
    out: (f64, f64),
    /// To the side on which vehicles arrive.
    right: (f64, f64),
    /// 1 if that is the right of who arrives, else -1.
    side: f64,
}

impl Axes {
    fn of(arm: &DrawnArm, is_left_hand: bool) -> Self {
        let (sin, cos) = arm.bearing_deg.to_radians().sin_cos();
        let out = (sin, -cos);
        // Who drives to the centre has the kerb on this side.
        let side = if is_left_hand { -1.0 } else { 1.0 };
        Self { out, right: (side * out.1, -side * out.0), side }
    }

    /// Returns the place so far out and so far to the side of arrivals, metres from the centre.
    fn at(self, out_m: f64, side_m: f64) -> (f64, f64) {
        (self.out.0 * out_m + self.right.0 * side_m, self.out.1 * out_m + self.right.1 * side_m)
    }
}

/// Returns the drawing of an intersection.
///
/// # Arguments
///
/// * `said` — per arm what stands at its end below its name, such as the phases of its movements.
pub(super) fn sketch(drawn: &DrawnIntersection, title: &str, said: &[String]) -> String {
    let widest =
        drawn.arms.iter().map(|arm| arm.lanes.len().max(arm.lanes_out as usize)).max().unwrap_or(1);
    let stop_m = widest as f64 * LANE_M + SET_BACK_M;
    let end_m = stop_m + SHOWN_M;
    let scale = SIZE_PX / 2.0 / (end_m + ROOM_M);
    let mut drawing = Drawing { text: String::new(), scale };
    for arm in &drawn.arms {
        let axes = Axes::of(arm, drawn.is_left_hand);
        let (arrivals_m, exits_m) =
            (arm.lanes.len() as f64 * LANE_M, f64::from(arm.lanes_out) * LANE_M);
        for lane in 0..arm.lanes.len() {
            let from_kerb = lane as f64 * LANE_M;
            let long_m = arm.bay_m(lane).map_or(SHOWN_M, |m| m.min(SHOWN_M));
            let (outer, inner) = (arrivals_m - from_kerb, arrivals_m - from_kerb - LANE_M);
            let corners =
                [(0.0, outer), (stop_m + long_m, outer), (stop_m + long_m, inner), (0.0, inner)];
            drawing.fill(&corners.map(|(out, side)| axes.at(out, side)), STREET);
        }
        let corners = [(0.0, 0.0), (end_m, 0.0), (end_m, -exits_m), (0.0, -exits_m)];
        drawing.fill(&corners.map(|(out, side)| axes.at(out, side)), STREET);
    }
    let ring = (0..36).map(|i| {
        let (sin, cos) = (f64::from(i) * 10.0).to_radians().sin_cos();
        ((stop_m - SET_BACK_M) * sin, (stop_m - SET_BACK_M) * cos)
    });
    drawing.fill(&ring.collect::<Vec<_>>(), STREET);
    for (arm, said) in drawn.arms.iter().zip(said) {
        drawing.markings(arm, Axes::of(arm, drawn.is_left_hand), (stop_m, end_m), said);
    }
    drawing.scale_bar();
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {SIZE_PX} {SIZE_PX}\" role=\"img\" \
         font-family=\"system-ui, sans-serif\"><title>{}</title>{}</svg>",
        escape(title),
        drawing.text
    )
}

/// A drawing in metres around its middle.
struct Drawing {
    text: String,
    /// Pixels per metre.
    scale: f64,
}

impl Drawing {
    fn px(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let tenth = |px: f64| (px * 10.0).round() / 10.0;
        (tenth(SIZE_PX / 2.0 + x * self.scale), tenth(SIZE_PX / 2.0 + y * self.scale))
    }

    fn add(&mut self, element: std::fmt::Arguments<'_>) {
        self.text.write_fmt(element).expect("a string takes all");
    }

    fn points(&self, points: &[(f64, f64)]) -> String {
        let texts = points.iter().map(|p| {
            let (x, y) = self.px(*p);
            format!("{x},{y}")
        });
        texts.collect::<Vec<_>>().join(" ")
    }

    fn fill(&mut self, points: &[(f64, f64)], color: &str) {
        let points = self.points(points);
        self.add(format_args!(
            "<polygon points=\"{points}\" fill=\"{color}\" stroke=\"{color}\" stroke-width=\"0.5\"/>"
        ));
    }

    fn line(&mut self, points: &[(f64, f64)], color: &str, width_px: f64, dash: &str) {
        let points = self.points(points);
        let dash =
            if dash.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{dash}\"") };
        self.add(format_args!(
            "<polyline points=\"{points}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{width_px}\"{dash}/>"
        ));
    }

    /// Writes words around a place, but within the drawing.
    fn words(&mut self, (x, y): (f64, f64), style: &str, text: &str) {
        let reach = text.chars().count() as f64 * HALF_LETTER_PX;
        let most = (SIZE_PX / 2.0 - reach).max(0.0) / self.scale;
        let ((x, y), text) = (self.px((x.clamp(-most, most), y)), escape(text));
        self.add(format_args!(
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{LETTERS_PX}\" fill=\"{INK}\" text-anchor=\"middle\"{style}>{text}</text>"
        ));
    }

    /// Draws lines, stop lines and arrows of an arm, and what it is called.
    fn markings(&mut self, arm: &DrawnArm, axes: Axes, (stop_m, end_m): (f64, f64), said: &str) {
        let lanes = arm.lanes.len();
        let arrivals_m = lanes as f64 * LANE_M;
        for lane in 0..lanes {
            let outer = arrivals_m - lane as f64 * LANE_M;
            if lane > 0 {
                let beside = [lane - 1, lane].map(|l| arm.bay_m(l).unwrap_or(SHOWN_M));
                let long_m = beside[0].min(beside[1]).min(SHOWN_M);
                let line = [axes.at(stop_m, outer), axes.at(stop_m + long_m, outer)];
                let is_bay = beside[0] != beside[1];
                self.line(&line, MARKING, 1.2, if is_bay { "" } else { "5 4" });
            }
            let middle = outer - LANE_M / 2.0;
            self.arrow(axes, (stop_m + ARROW_M, middle), &arm.lanes[lane]);
            // Of lanes of one turn the first says their length; those that are longer than what is drawn, within it.
            let is_first = lane == 0 || arm.lanes[lane - 1] != arm.lanes[lane];
            if let Some(long_m) = arm.bay_m(lane).filter(|_| is_first) {
                let inside_m = if arm.lanes[lane] == "l" { SHOWN_M - 6.0 } else { SHOWN_M - 14.0 };
                let at_m = if long_m < SHOWN_M - 3.0 { long_m + 3.0 } else { inside_m };
                self.words(axes.at(stop_m + at_m, middle), "", &format!("{long_m:.0} m"));
            }
        }
        for lane in 1..arm.lanes_out {
            let side = -f64::from(lane) * LANE_M;
            self.line(&[axes.at(stop_m, side), axes.at(end_m, side)], MARKING, 1.2, "5 4");
        }
        if lanes > 0 && arm.lanes_out > 0 {
            self.line(&[axes.at(stop_m, 0.0), axes.at(end_m, 0.0)], "#c09000", 1.6, "");
        }
        if lanes > 0 {
            let line = [axes.at(stop_m, 0.1), axes.at(stop_m, arrivals_m - 0.1)];
            self.line(&line, INK, 2.5, "");
        }
        let exits_m = f64::from(arm.lanes_out) * LANE_M;
        let line_m = (LETTERS_PX + 1.0) / self.scale;
        let is_steep = axes.out.1.abs() > 0.5;
        let (x, y) = match is_steep {
            // Two lines have room beyond the end of the street.
            true if axes.out.1 > 0.0 => axes.at(end_m + line_m, 0.0),
            true => axes.at(end_m + 1.3 * line_m, 0.0),
            // Beside the street, on the side on which vehicles leave, where two lines have room.
            false => {
                let (x, y) = axes.at(0.72 * end_m, -exits_m);
                (x, if axes.right.1 > 0.0 { y - 1.3 * line_m } else { y + line_m })
            }
        };
        self.words((x, y), " font-weight=\"600\"", &arm.name);
        if !said.is_empty() {
            self.words((x, y + line_m), "", said);
        }
    }

    /// Draws the arrow of a lane: a shaft in the direction of travel, and a head for each turn.
    fn arrow(&mut self, axes: Axes, (out_m, side_m): (f64, f64), turns: &str) {
        let at = |ahead: f64, right: f64| axes.at(out_m - ahead, side_m + axes.side * right);
        let mut shaft_m: f64 = 0.0;
        for turn in turns.chars() {
            let (tip, base) = match turn {
                's' => ((5.0, 0.0), (3.2, 0.0)),
                'l' => ((2.6, -1.5), (2.6, -0.4)),
                _ => ((2.6, 1.5), (2.6, 0.4)),
            };
            shaft_m = shaft_m.max(if turn == 's' { 3.4 } else { 2.6 });
            let half = 0.55;
            let wings = match turn {
                's' => [(base.0, -half), (base.0, half)],
                _ => [(base.0 - half, base.1), (base.0 + half, base.1)],
            };
            let head = [tip, wings[0], wings[1]].map(|(ahead, right)| at(ahead, right));
            self.fill(&head, INK);
            if turn != 's' {
                self.line(&[at(2.6, 0.0), at(2.6, base.1)], INK, 1.3, "");
            }
        }
        if shaft_m > 0.0 {
            self.line(&[at(0.0, 0.0), at(shaft_m, 0.0)], INK, 1.3, "");
        }
    }

    fn scale_bar(&mut self) {
        let half = SIZE_PX / 2.0 / self.scale;
        let (left, low) = (-half + 3.0, half - 3.0);
        self.line(&[(left, low), (left + BAR_M, low)], INK, 2.0, "");
        let middle = (left + BAR_M / 2.0, low - 2.4);
        self.words(middle, "", &format!("{BAR_M:.0} m, north is up"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arm(bearing_deg: f64, lanes: &[&str], left_storage_m: Option<f64>) -> DrawnArm {
        DrawnArm {
            name: format!("arm <{bearing_deg}>"),
            edge: "in0".into(),
            bearing_deg,
            lanes: lanes.iter().map(|lane| (*lane).to_owned()).collect(),
            lanes_out: 2,
            speed_mph: 30.0,
            left_storage_m,
            right_storage_m: None,
        }
    }

    fn drawn(is_left_hand: bool) -> DrawnIntersection {
        DrawnIntersection {
            point: "i0001".into(),
            intersection: "1".into(),
            period: String::new(),
            is_left_hand,
            arms: vec![arm(0.0, &["sr", "s", "l"], Some(30.0)), arm(90.0, &["sr"], None)],
        }
    }

    #[test]
    fn arrivals_are_on_the_side_on_which_traffic_keeps() {
        let north = arm(0.0, &["s"], None);
        // From the north, southbound vehicles that keep to the right are in the west.
        assert!(Axes::of(&north, false).at(10.0, 3.0).0 < 0.0);
        assert!(Axes::of(&north, true).at(10.0, 3.0).0 > 0.0);
    }

    #[test]
    fn a_bay_is_as_long_as_its_storage_and_names_are_escaped() {
        let svg = sketch(&drawn(false), "a & b", &["L 5".into(), String::new()]);
        assert!(svg.contains("<title>a &amp; b</title>") && svg.contains("arm &lt;0&gt;"), "{svg}");
        assert!(svg.contains(">30 m<") && svg.contains(">L 5<"), "{svg}");
        let long = DrawnIntersection {
            arms: vec![arm(0.0, &["s", "l", "l"], Some(76.0))],
            ..drawn(false)
        };
        assert_eq!(sketch(&long, "", &[String::new()]).matches(">76 m<").count(), 1);
        assert_eq!(svg.matches("stroke-width=\"2.5\"").count(), 2, "two stop lines");
    }

    #[test]
    fn only_turn_lanes_are_bays() {
        let arm = arm(0.0, &["sr", "s", "l"], Some(30.0));
        assert_eq!([0, 1, 2].map(|lane| arm.bay_m(lane)), [None, None, Some(30.0)]);
    }
}
