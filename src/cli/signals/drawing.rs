//! A signal as a drawing: a panel with its lanes and movements, then one per phase.

use std::fmt::Write;

use super::look::Look;
use crate::traffic::sim::topology::{StreetLane, edge};

/// Side of a panel, pixels.
const PANEL: f64 = 320.0;
/// Height of the text above a panel, pixels.
const HEAD: f64 = 44.0;
/// Panels beside each other.
const COLUMNS: usize = 4;
/// What is shown of the streets before the farthest stop line, metres.
const MARGIN_M: f64 = 40.0;
/// Distance of a lane's label from its stop line and from that of the lane beside it, metres.
const LABEL_M: f64 = 4.0;
/// Distance of an approach's label from its stop line, metres.
const EDGE_LABEL_M: f64 = 22.0;

const STYLE: &str = "\
text{font:12px sans-serif;fill:#1b1f24}.small{font-size:10px}\
.lane{fill:none;stroke:#8c959f}.up{fill:none;stroke:#b9c6d8}.out{fill:none;stroke:#dfe3e8}\
.way{fill:none;stroke:#1f4e9c;stroke-width:1.5}.red{fill:none;stroke:#b0b0b0;stroke-width:1}\
.go{fill:none;stroke:#12722f;stroke-width:3}\
.yield{fill:none;stroke:#12722f;stroke-width:2;stroke-dasharray:5 4}\
.frame{fill:#fff;stroke:#d0d7de}";

/// A part of the plane that a panel shows.
struct View {
    middle: [f64; 2],
    radius_m: f64,
}

impl View {
    fn new(ends: &[[f64; 2]]) -> Self {
        let mean = |axis: usize| ends.iter().map(|e| e[axis]).sum::<f64>() / ends.len() as f64;
        let middle = [mean(0), mean(1)];
        let distance = |e: &[f64; 2]| (e[0] - middle[0]).hypot(e[1] - middle[1]);
        Self { middle, radius_m: ends.iter().map(distance).fold(0.0, f64::max) + MARGIN_M }
    }

    fn scale(&self) -> f64 {
        PANEL / (2.0 * self.radius_m)
    }

    /// Returns where a point is in a panel; north is up.
    fn place(&self, point: [f64; 2]) -> [f64; 2] {
        let half = PANEL / 2.0;
        let east = (point[0] - self.middle[0]) * self.scale();
        let north = (point[1] - self.middle[1]) * self.scale();
        [half + east, half - north]
    }

    fn line(&self, class: &str, width: Option<f64>, shape: &[[f64; 2]]) -> String {
        let points: Vec<String> = shape
            .iter()
            .map(|point| {
                let [x, y] = self.place(*point);
                format!("{x:.1},{y:.1}")
            })
            .collect();
        let width = width.map(|m| format!(" stroke-width=\"{:.1}\"", m * self.scale()));
        let width = width.unwrap_or_default();
        format!("<polyline class=\"{class}\"{width} points=\"{}\"/>\n", points.join(" "))
    }
}

/// Returns the drawing of a signal.
pub(super) fn svg(look: &Look, number: usize) -> String {
    let signal = &look.signals[number];
    let spec = &signal.spec;
    let lanes = look.topology.lanes();
    let street = |id: &str| look.topology.position(id).map(|lane| &lanes[lane]);
    let ends: Vec<[f64; 2]> =
        spec.lanes.iter().filter_map(|lane| street(&lane.id)?.shape.last().copied()).collect();
    let view = View::new(&ends);
    let base = streets(look, number, &view);
    let ways = ways(look, number);

    let mut panels = vec![(String::from("lanes and movements"), spec.id.clone(), {
        let mut panel = base.clone();
        ways.iter().flatten().for_each(|way| panel.push_str(&view.line("way", None, way)));
        panel.push_str(&labels(look, number, &view));
        panel
    })];
    for (i, phase) in spec.phases.iter().enumerate() {
        let counts: Vec<String> =
            phase.pair.iter().map(|m| spec.movements[*m].index.to_string()).collect();
        let mut panel = base.clone();
        let letters = phase.state.as_bytes();
        // Red first, so that green lies above it.
        for wanted in ["red", "yield", "go"] {
            for link in signal.movement_links.iter().flatten() {
                let class = match letters.get(*link) {
                    Some(b'G') => "go",
                    Some(b'g') => "yield",
                    _ => "red",
                };
                if class == wanted {
                    ways[*link].iter().for_each(|way| {
                        panel.push_str(&view.line(class, None, way));
                    });
                }
            }
        }
        let head = format!("phase {i}: counts {}", counts.join(", "));
        panels.push((head, phase.state.clone(), panel));
    }
    page(&spec.id, &panels)
}

/// Draws the lanes: those of the signal, the pieces upstream, and those that leave.
fn streets(look: &Look, number: usize, view: &View) -> String {
    let signal = &look.signals[number];
    let lanes = look.topology.lanes();
    let mut drawing = String::new();
    let mut draw = |class: &str, id: &str| {
        if let Some(lane) = look.topology.position(id).map(|lane| &lanes[lane]) {
            drawing.push_str(&view.line(class, Some(0.9 * lane.width_m), &lane.shape));
        }
    };
    for link in look.scene.signals[number].links.iter().flatten() {
        draw("out", &link.to_lane);
    }
    for lane in &signal.lanes {
        look.scene.lanes[*lane].pieces.iter().for_each(|piece| draw("up", &piece.id));
    }
    for lane in &signal.spec.lanes {
        draw("lane", &lane.id);
    }
    drawing
}

/// Returns the shapes of the ways of every link through the junction.
fn ways(look: &Look, number: usize) -> Vec<Vec<Vec<[f64; 2]>>> {
    let lanes = look.topology.lanes();
    let way = |from: &StreetLane, to: usize| -> Vec<[f64; 2]> {
        let way = from.ways.iter().find(|way| way.to == to);
        let inner = way.iter().flat_map(|way| &way.inner).flat_map(|l| &lanes[*l].shape);
        let ends = from.shape.last().into_iter();
        ends.chain(inner).chain(lanes[to].shape.first()).copied().collect()
    };
    let shapes = |links: &Vec<crate::traffic::sim::Link>| {
        let place = |id: &str| look.topology.position(id);
        links
            .iter()
            .filter_map(|link| {
                let from = place(&look.scene.lanes[link.from_lane].id)?;
                Some(way(&lanes[from], place(&link.to_lane)?))
            })
            .collect()
    };
    look.scene.signals[number].links.iter().map(shapes).collect()
}

/// Writes at every lane the movements that start from it, and at every approach its edge.
fn labels(look: &Look, number: usize, view: &View) -> String {
    let spec = &look.signals[number].spec;
    let lanes = look.topology.lanes();
    let mut text = String::new();
    let mut named: Vec<&str> = Vec::new();
    for (l, lane) in spec.lanes.iter().enumerate() {
        let Some(street) = look.topology.position(&lane.id).map(|i| &lanes[i]) else { continue };
        let (Some(end), Some(heading)) = (street.shape.last(), street.end_heading_deg()) else {
            continue;
        };
        let (east, north) = heading.to_radians().sin_cos();
        let at = |back_m: f64| view.place([end[0] - back_m * east, end[1] - back_m * north]);
        let movements: Vec<String> = (spec.movements.iter())
            .filter(|m| m.lanes.contains(&l))
            .map(|m| m.index.to_string())
            .collect();
        let mut write = |[x, y]: [f64; 2], words: &str| {
            writeln!(
                text,
                "<text class=\"small\" text-anchor=\"middle\" x=\"{x:.1}\" y=\"{y:.1}\">{}</text>",
                escaped(words)
            )
            .expect("writing to a string cannot fail");
        };
        // Numbers of neighbours would run into each other at the same height.
        write(at(LABEL_M * (1 + l % 2) as f64), &movements.join(" "));
        if !named.contains(&edge(&lane.id)) {
            named.push(edge(&lane.id));
            write(at(EDGE_LABEL_M), edge(&lane.id));
        }
    }
    text
}

/// Puts panels side by side: heading, second line, drawing.
fn page(id: &str, panels: &[(String, String, String)]) -> String {
    let rows = panels.len().div_ceil(COLUMNS);
    let width = PANEL * COLUMNS.min(panels.len()) as f64;
    let height = (PANEL + HEAD) * rows as f64;
    let mut page = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" role=\"img\">\n<title>Signal {}: lanes, movements and \
         phases; solid green has right of way, dashed green yields</title>\n<style>{STYLE}</style>\n",
        escaped(id)
    );
    for (i, (head, second, drawing)) in panels.iter().enumerate() {
        let (x, y) = ((i % COLUMNS) as f64 * PANEL, (i / COLUMNS) as f64 * (PANEL + HEAD));
        write!(
            page,
            "<g transform=\"translate({x} {y})\">\n<text x=\"8\" y=\"18\">{}</text>\n\
             <text class=\"small\" x=\"8\" y=\"34\">{}</text>\n\
             <svg y=\"{HEAD}\" width=\"{PANEL}\" height=\"{PANEL}\">\n\
             <rect class=\"frame\" width=\"{PANEL}\" height=\"{PANEL}\"/>\n{drawing}</svg>\n</g>\n",
            escaped(head),
            escaped(second)
        )
        .expect("writing to a string cannot fail");
    }
    page.push_str("</svg>\n");
    page
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn north_is_up_and_east_to_the_right() {
        let view = View::new(&[[100.0, 200.0]]);
        assert_eq!(view.place([100.0, 200.0]), [160.0, 160.0]);
        assert_eq!(view.place([140.0, 240.0]), [320.0, 0.0]);
    }

    #[test]
    fn names_are_escaped_and_panels_wrap() {
        let panel = || ("a<b".to_owned(), "G".to_owned(), String::new());
        let page = page("x&y", &[panel(), panel(), panel(), panel(), panel()]);
        assert!(page.contains("Signal x&amp;y") && page.contains("a&lt;b"));
        assert!(page.contains("width=\"1280\" height=\"728\""));
        assert!(page.contains("translate(0 364)"));
    }
}
