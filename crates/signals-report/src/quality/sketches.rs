//! How flagged intersections were read: the streets of the map and the arms made of them, as drawings.

use minijinja::{Value, context};

use super::intersections::{flags, streets};
use super::link::map_link;
use evaluation::report::svg::{Anchor, Canvas, INK, TextStyle};
use signals::city::drawing::Drawing;
use signals::city::quality::Quality;
use signals::city::sketch::{RADIUS_M, Sketch, SketchArm};

/// Width and height of a drawing, pixels.
const SIZE_PX: f64 = 260.0;

/// Where the thick line of an arm begins and ends and where its label stands, metres from the centre.
const ARM_M: (f64, f64, f64) = (12.0, 56.0, 72.0);

/// How much farther out a label stands beside another one, metres, and the angle up to which it has to,
/// degrees.
const BESIDE_M: f64 = 13.0;
const CLOSE_DEG: f64 = 35.0;

/// Colour of the streets of the map.
const STREET: &str = "#9a9a9a";

/// Colours of arms that lead to the signal, and of those that only lead away.
const ARM: (&str, &str) = ("#0072b2", "#56b4e9");

/// Colours of junction nodes and of signals.
const NODES: (&str, &str) = (INK, "#d55e00");

/// Width of the line of an arm without lanes towards the signal, and what each lane adds, pixels.
const LANE_PX: (f64, f64) = (2.5, 2.0);

/// Returns a drawing per sketch with what is worth a look.
pub(super) fn sketches(q: &Quality, drawing: &Drawing) -> Vec<Value> {
    let draw = |(i, sketch): (usize, &Sketch)| {
        let spot = q.spots.iter().find(|s| s.id == sketch.id)?;
        Some(context! {
            figure => figure(i, sketch),
            id => spot.id.as_str(),
            streets => streets(spot),
            link => map_link(spot.latitude, spot.longitude),
            flags => flags(spot),
        })
    };
    drawing.sketches.iter().enumerate().filter_map(draw).collect()
}

fn figure(index: usize, sketch: &Sketch) -> String {
    let mut canvas = Canvas::new(SIZE_PX, SIZE_PX);
    let middle = SIZE_PX / 2.0;
    let at = |(east, north): (f64, f64)| {
        (middle + east * middle / RADIUS_M, middle - north * middle / RADIUS_M)
    };
    for street in &sketch.streets {
        let places: Vec<(f64, f64)> = street.iter().map(|p| at(*p)).collect();
        canvas.polyline(places, STREET, 1.4, None);
    }
    let (start, end, label) = ARM_M;
    for (i, arm) in sketch.arms.iter().enumerate() {
        let (sin, cos) = arm.bearing_deg.to_radians().sin_cos();
        let along = |metres: f64| at((metres * sin, metres * cos));
        let (color, width) = match arm.lanes_in {
            0 => (ARM.1, LANE_PX.0),
            lanes => (ARM.0, LANE_PX.0 + LANE_PX.1 * f64::from(lanes)),
        };
        canvas.line(along(start), along(end), color, width, None);
        // The labels of arms side by side would overlap.
        let (x, y) = along(if close(sketch, i) { label + BESIDE_M } else { label });
        canvas.text(x, y + 4.5, &words(arm), TextStyle::new(Anchor::Middle).bold());
    }
    for (places, color, radius) in [(&sketch.nodes, NODES.0, 2.6), (&sketch.signals, NODES.1, 3.6)]
    {
        for place in places {
            canvas.circle(at(*place), radius, color, None);
        }
    }
    let arms: Vec<String> = sketch.arms.iter().map(words).collect();
    let title = format!("{} as it was read", sketch.id);
    canvas.finish(&format!("sketch-{index}"), &title, &arms.join(", "))
}

/// Returns whether an arm is one of two side by side whose label has to give way.
fn close(sketch: &Sketch, i: usize) -> bool {
    let before = i.checked_sub(1).map(|i| sketch.arms[i].bearing_deg);
    let before = before.or_else(|| sketch.arms.last().map(|a| a.bearing_deg - 360.0));
    i % 2 == 1 && before.is_some_and(|before| sketch.arms[i].bearing_deg - before < CLOSE_DEG)
}

/// Returns the name of an arm with its lanes, such as `A 3/2`.
fn words(arm: &SketchArm) -> String {
    format!("{} {}/{}", arm.arm, arm.lanes_in, arm.lanes_out)
}
