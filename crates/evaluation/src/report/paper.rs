//! A drawing for papers: as PDF, and as PGF for documents in LaTeX.
//!
//! Both are written here: a converter from SVG with its font machinery would bring about fifty crates, for drawings that
//! have lines, shapes and short texts.
//!
//! - **PDF** (1.4) has its text in Helvetica, one of the fonts that every viewer has, so no font is embedded.
//! - **PGF** has its text in the fonts of the document.
//!
//! Source: Adobe, PDF Reference, fourth edition (version 1.5), 2003; the widths of letters are those of Adobe's font
//! metrics of Helvetica and Helvetica-Bold.

use std::fmt::Write;

use kuva::render::color::Color;
use kuva::render::render::{PathData, Primitive, Scene, TextAnchor};

use super::latex::escaped;

/// Points per pixel of a drawing.
const POINTS: f64 = 0.75;

/// Distance of the control points of a quarter circle from its ends, in radii.
const QUARTER: f64 = 0.552_285;

/// Distance of two lines of text, in heights of a letter.
const LEADING: f64 = 1.2;

/// Widths of the letters from space to tilde, in thousandths of their height: Helvetica, and Helvetica-Bold.
const WIDTHS: [[u16; 95]; 2] = [
    [
        278, 278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333, 278, 278, 556, 556,
        556, 556, 556, 556, 556, 556, 556, 556, 278, 278, 584, 584, 584, 556, 1015, 667, 667, 722,
        722, 667, 611, 778, 722, 278, 500, 667, 556, 833, 722, 778, 667, 778, 722, 667, 611, 722,
        667, 944, 667, 667, 611, 278, 278, 278, 469, 556, 333, 556, 556, 500, 556, 556, 278, 556,
        556, 222, 222, 500, 222, 833, 556, 556, 556, 556, 333, 500, 278, 556, 500, 722, 500, 500,
        500, 334, 260, 334, 584,
    ],
    [
        278, 333, 474, 556, 556, 889, 722, 238, 333, 333, 389, 584, 278, 333, 278, 278, 556, 556,
        556, 556, 556, 556, 556, 556, 556, 556, 333, 333, 584, 584, 584, 611, 975, 722, 722, 722,
        722, 667, 611, 778, 722, 278, 556, 722, 611, 833, 722, 778, 667, 778, 722, 667, 611, 722,
        667, 944, 667, 667, 611, 333, 278, 333, 584, 556, 333, 556, 611, 556, 611, 556, 333, 611,
        611, 278, 278, 556, 278, 889, 611, 611, 611, 611, 389, 556, 333, 611, 556, 778, 556, 556,
        500, 389, 280, 389, 584,
    ],
];

/// Width of other letters.
const OTHER_WIDTH: u16 = 556;

/// A position, pixels from the upper left corner.
type At = (f64, f64);

/// A part of an outline.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Step {
    Move(At),
    Line(At),
    Curve(At, At, At),
    Close,
}

/// A line's colour, width in pixels and dashes.
struct Stroke<'a> {
    color: [u8; 3],
    width: f64,
    dashes: Option<&'a str>,
}

/// A text and how it stands.
struct Text<'a> {
    at: At,
    text: &'a str,
    size: f64,
    anchor: TextAnchor,
    /// Degrees, clockwise.
    turned: f64,
    bold: bool,
    color: [u8; 3],
}

/// What draws outlines and texts.
trait Pen {
    fn outline(&mut self, steps: &[Step], fill: Option<([u8; 3], f64)>, stroke: Option<Stroke<'_>>);
    fn text(&mut self, text: &Text<'_>);
}

/// Returns a drawing as PDF.
pub(super) fn pdf(scene: &Scene, title: &str) -> Vec<u8> {
    let mut pen = Pdf::default();
    draw(scene, &mut pen);
    pen.document(scene, title)
}

/// Returns a drawing as PGF.
pub(super) fn pgf(scene: &Scene, title: &str) -> String {
    let (width, height) = (scene.width * POINTS, scene.height * POINTS);
    let mut pen = Pgf { height: scene.height, text: String::new() };
    draw(scene, &mut pen);
    format!(
        "% {}, a figure of tsc-family. In the preamble: \\usepackage{{pgf}}. In the text, where FILE is this file:\n\
         % \\resizebox{{\\linewidth}}{{!}}{{\\input{{FILE}}}}\n\
         \\begingroup%\n\\begin{{pgfpicture}}%\n\
         \\pgfpathrectangle{{\\pgfpointorigin}}{{\\pgfqpoint{{{width:.2}bp}}{{{height:.2}bp}}}}%\n\
         \\pgfusepath{{use as bounding box}}%\n{}\\end{{pgfpicture}}%\n\\endgroup%\n",
        title.replace(['\n', '\r'], " "),
        pen.text
    )
}

/// Draws everything with a pen.
fn draw(scene: &Scene, pen: &mut dyn Pen) {
    let ink = scene
        .text_color
        .as_deref()
        .map_or([0; 3], |color| rgb(&Color::from(color)).unwrap_or([0; 3]));
    for drawn in &scene.elements {
        match drawn {
            Primitive::Rect { x, y, width, height, fill, stroke, stroke_width, opacity } => {
                let (right, bottom) = (x + width, y + height);
                let steps = polygon(&[(*x, *y), (right, *y), (right, bottom), (*x, bottom)]);
                let stroke = stroke
                    .as_ref()
                    .and_then(|color| stroked(color, stroke_width.unwrap_or(1.0), None));
                pen.outline(&steps, filled(Some(fill), *opacity), stroke);
            }
            Primitive::Line { x1, y1, x2, y2, stroke, stroke_width, stroke_dasharray } => {
                let steps = [Step::Move((*x1, *y1)), Step::Line((*x2, *y2))];
                pen.outline(
                    &steps,
                    None,
                    stroked(stroke, *stroke_width, stroke_dasharray.as_deref()),
                );
            }
            Primitive::PolyLine { points, stroke, stroke_width, stroke_dasharray } => {
                let dashes = stroke_dasharray.as_deref();
                pen.outline(&lines(points), None, stroked(stroke, *stroke_width, dashes));
            }
            Primitive::Circle { cx, cy, r, fill, fill_opacity, stroke, stroke_width } => {
                let stroke = stroke
                    .as_ref()
                    .and_then(|color| stroked(color, stroke_width.unwrap_or(1.0), None));
                pen.outline(&circle((*cx, *cy), *r), filled(Some(fill), *fill_opacity), stroke);
            }
            Primitive::Path(path) => {
                let PathData { d, fill, stroke, stroke_width, opacity, stroke_dasharray } = &**path;
                let line = stroked(stroke, *stroke_width, stroke_dasharray.as_deref());
                pen.outline(&steps_of(d), filled(fill.as_ref(), *opacity), line);
            }
            Primitive::Text { x, y, content, size, anchor, rotate, bold, color } => {
                pen.text(&Text {
                    at: (*x, *y),
                    // A canvas has marked dollar signs as no formula.
                    text: &content.replace("\\$", "$"),
                    size: f64::from(*size),
                    anchor: *anchor,
                    turned: rotate.unwrap_or(0.0),
                    bold: *bold,
                    color: color.as_ref().and_then(rgb).unwrap_or(ink),
                })
            }
            // Groups have tips for pointers, and a canvas draws nothing else.
            _ => {}
        }
    }
}

fn rgb(color: &Color) -> Option<[u8; 3]> {
    match color {
        Color::Rgb(r, g, b) => Some([*r, *g, *b]),
        _ => None,
    }
}

fn filled(color: Option<&Color>, opacity: Option<f64>) -> Option<([u8; 3], f64)> {
    Some((rgb(color?)?, opacity.unwrap_or(1.0)))
}

fn stroked<'a>(color: &Color, width: f64, dashes: Option<&'a str>) -> Option<Stroke<'a>> {
    let color = rgb(color).filter(|_| width > 0.0)?;
    Some(Stroke { color, width, dashes })
}

fn lines(points: &[At]) -> Vec<Step> {
    let step = |(i, at): (usize, &At)| if i == 0 { Step::Move(*at) } else { Step::Line(*at) };
    points.iter().enumerate().map(step).collect()
}

fn polygon(points: &[At]) -> Vec<Step> {
    let mut steps = lines(points);
    steps.push(Step::Close);
    steps
}

fn circle((x, y): At, r: f64) -> Vec<Step> {
    let mut steps = vec![Step::Move((x - r, y))];
    steps.extend(half((x - r, y), 2.0 * r));
    steps.extend(half((x + r, y), -2.0 * r));
    steps.push(Step::Close);
    steps
}

/// Returns half a circle to a point beside the one where it begins: first upwards when it goes to the right, and
/// downwards when it goes to the left.
fn half((x, y): At, across: f64) -> [Step; 2] {
    let (r, k) = (across / 2.0, QUARTER * across / 2.0);
    let top = (x + r, y - r);
    [
        Step::Curve((x, y - k), (x + r - k, y - r), top),
        Step::Curve((x + r + k, y - r), (x + across, y - k), (x + across, y)),
    ]
}

/// Returns the outline that SVG path data describe, of which figures have lines and half circles.
fn steps_of(d: &str) -> Vec<Step> {
    let (mut steps, mut at) = (Vec::new(), (0.0, 0.0));
    let mut rest = d.trim_start();
    while let Some(command) = rest.chars().next() {
        let end = rest[1..]
            .find(|c: char| c.is_ascii_alphabetic() && c != 'e')
            .map_or(rest.len(), |i| i + 1);
        let numbers: Vec<f64> = (rest[1..end].split([' ', ',']))
            .filter(|number| !number.is_empty())
            .filter_map(|number| number.parse().ok())
            .collect();
        rest = rest[end..].trim_start();
        match (command, &numbers[..]) {
            ('Z', _) => steps.push(Step::Close),
            ('a', [.., across, _]) => {
                steps.extend(half(at, *across));
                at.0 += across;
            }
            ('M' | 'L', pairs) => {
                for (i, pair) in pairs.chunks_exact(2).enumerate() {
                    at = (pair[0], pair[1]);
                    steps.push(if command == 'M' && i == 0 {
                        Step::Move(at)
                    } else {
                        Step::Line(at)
                    });
                }
            }
            _ => debug_assert!(false, "figures have no {command} in their paths"),
        }
    }
    steps
}

/// Writes a page of PDF, in the pixels of the drawing.
#[derive(Default)]
struct Pdf {
    content: String,
    /// Opacities, each with the number of its state less one.
    opacities: Vec<f64>,
}

impl Pdf {
    fn color(&mut self, [r, g, b]: [u8; 3], operator: &str) {
        let part = |value: u8| f64::from(value) / 255.0;
        let _ = writeln!(self.content, "{:.3} {:.3} {:.3} {operator}", part(r), part(g), part(b));
    }

    /// Returns the file.
    fn document(self, scene: &Scene, title: &str) -> Vec<u8> {
        let (width, height) = (scene.width * POINTS, scene.height * POINTS);
        let states = self.opacities.iter().enumerate();
        let states: String =
            states.map(|(i, opacity)| format!("/G{i} << /ca {opacity:.3} >> ")).collect();
        let content = format!("{POINTS} 0 0 -{POINTS} 0 {height:.2} cm\n{}", self.content);
        let font = |name: &str| {
            format!(
                "<< /Type /Font /Subtype /Type1 /BaseFont /{name} /Encoding /WinAnsiEncoding >>"
            )
        };
        let objects = [
            "<< /Type /Catalog /Pages 2 0 R >>".to_owned(),
            "<< /Type /Pages /Kids [3 0 R] /Count 1 >>".to_owned(),
            format!(
                "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {width:.2} {height:.2}] /Contents 4 0 R /Resources \
                 << /Font << /F0 5 0 R /F1 6 0 R >> /ExtGState << {states}>> >> >>"
            ),
            format!("<< /Length {} >>\nstream\n{content}\nendstream", content.len()),
            font("Helvetica"),
            font("Helvetica-Bold"),
            format!("<< /Title ({}) /Producer (tsc-family) >>", literal(title)),
        ];
        let mut file = b"%PDF-1.4\n%\xe2\xe3\xcf\xd3\n".to_vec();
        let mut places = String::new();
        for (i, object) in objects.iter().enumerate() {
            let _ = writeln!(places, "{:010} 00000 n ", file.len());
            file.extend(format!("{} 0 obj\n{object}\nendobj\n", i + 1).into_bytes());
        }
        let (count, begin) = (objects.len() + 1, file.len());
        file.extend(
            format!(
                "xref\n0 {count}\n0000000000 65535 f \n{places}trailer\n<< /Size {count} /Root 1 0 R /Info 7 0 R >>\n\
                 startxref\n{begin}\n%%EOF\n"
            )
            .into_bytes(),
        );
        file
    }
}

impl Pen for Pdf {
    fn outline(
        &mut self,
        steps: &[Step],
        fill: Option<([u8; 3], f64)>,
        stroke: Option<Stroke<'_>>,
    ) {
        self.content.push_str("q\n");
        if let Some((color, opacity)) = fill {
            self.color(color, "rg");
            if opacity < 1.0 {
                let known = self.opacities.iter().position(|other| *other == opacity);
                let state = known.unwrap_or_else(|| {
                    self.opacities.push(opacity);
                    self.opacities.len() - 1
                });
                let _ = writeln!(self.content, "/G{state} gs");
            }
        }
        if let Some(Stroke { color, width, dashes }) = &stroke {
            self.color(*color, "RG");
            let _ = writeln!(self.content, "{width} w [{}] 0 d", dashes.unwrap_or_default());
        }
        for step in steps {
            let _ = match step {
                Step::Move((x, y)) => writeln!(self.content, "{x:.2} {y:.2} m"),
                Step::Line((x, y)) => writeln!(self.content, "{x:.2} {y:.2} l"),
                Step::Curve(a, b, c) => writeln!(
                    self.content,
                    "{:.2} {:.2} {:.2} {:.2} {:.2} {:.2} c",
                    a.0, a.1, b.0, b.1, c.0, c.1
                ),
                Step::Close => writeln!(self.content, "h"),
            };
        }
        self.content.push_str(match (fill.is_some(), stroke.is_some()) {
            (true, true) => "B\nQ\n",
            (true, false) => "f\nQ\n",
            (false, true) => "S\nQ\n",
            (false, false) => "n\nQ\n",
        });
    }

    fn text(&mut self, text: &Text<'_>) {
        self.color(text.color, "rg");
        let share = match text.anchor {
            TextAnchor::Start => 0.0,
            TextAnchor::Middle => 0.5,
            TextAnchor::End => 1.0,
        };
        let (sin, cos) = text.turned.to_radians().sin_cos();
        let before = share * width(text.text, text.bold) * text.size;
        let (x, y) = (text.at.0 - before * cos, text.at.1 - before * sin);
        // Letters stand upright on a page that is upside down.
        let _ = writeln!(
            self.content,
            "BT /F{} {} Tf {cos:.4} {sin:.4} {sin:.4} {:.4} {x:.2} {y:.2} Tm ({}) Tj ET",
            u8::from(text.bold),
            text.size,
            -cos,
            literal(text.text)
        );
    }
}

/// Returns the width of a text in heights of a letter.
fn width(text: &str, bold: bool) -> f64 {
    let of = |byte: u8| WIDTHS[usize::from(bold)].get(usize::from(byte).wrapping_sub(32)).copied();
    bytes(text).into_iter().map(|byte| f64::from(of(byte).unwrap_or(OTHER_WIDTH))).sum::<f64>()
        / 1000.0
}

/// Returns a text in the encoding of the fonts, `WinAnsiEncoding`.
fn bytes(text: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    for c in text.chars() {
        match c {
            ' '..='~' | '\u{a0}'..='\u{ff}' => bytes.push(c as u8),
            '\u{2026}' => bytes.push(0x85),
            '\u{2018}' => bytes.push(0x91),
            '\u{2019}' => bytes.push(0x92),
            '\u{201c}' => bytes.push(0x93),
            '\u{201d}' => bytes.push(0x94),
            '\u{2013}' => bytes.push(0x96),
            '\u{2014}' => bytes.push(0x97),
            '\u{2212}' => bytes.push(b'-'),
            '\u{2265}' => bytes.extend(b">="),
            '\u{2264}' => bytes.extend(b"<="),
            _ => bytes.push(b'?'),
        }
    }
    bytes
}

/// Returns a text as it stands within brackets.
fn literal(text: &str) -> String {
    let mut literal = String::new();
    for byte in bytes(text) {
        match byte {
            b'(' | b')' | b'\\' => literal.extend(['\\', char::from(byte)]),
            b' '..=b'~' => literal.push(char::from(byte)),
            _ => {
                let _ = write!(literal, "\\{byte:03o}");
            }
        }
    }
    literal
}

/// Writes commands of PGF.
struct Pgf {
    /// Of the drawing, pixels.
    height: f64,
    text: String,
}

impl Pgf {
    fn point(&self, (x, y): At) -> String {
        format!("\\pgfqpoint{{{:.2}bp}}{{{:.2}bp}}", x * POINTS, (self.height - y) * POINTS)
    }

    fn define(&mut self, name: &str, [r, g, b]: [u8; 3]) {
        let _ = writeln!(self.text, "\\definecolor{{{name}}}{{RGB}}{{{r},{g},{b}}}%");
    }
}

impl Pen for Pgf {
    fn outline(
        &mut self,
        steps: &[Step],
        fill: Option<([u8; 3], f64)>,
        stroke: Option<Stroke<'_>>,
    ) {
        let mut uses = Vec::new();
        self.text.push_str("\\begin{pgfscope}%\n");
        if let Some((color, opacity)) = fill {
            uses.push("fill");
            self.define("tscfill", color);
            self.text.push_str("\\pgfsetfillcolor{tscfill}%\n");
            if opacity < 1.0 {
                let _ = writeln!(self.text, "\\pgfsetfillopacity{{{opacity:.3}}}%");
            }
        }
        if let Some(Stroke { color, width, dashes }) = &stroke {
            uses.push("stroke");
            self.define("tscstroke", *color);
            let _ = writeln!(
                self.text,
                "\\pgfsetstrokecolor{{tscstroke}}\\pgfsetlinewidth{{{:.2}bp}}%",
                width * POINTS
            );
            if let Some(dashes) = dashes {
                let lengths =
                    dashes.split([' ', ',']).filter_map(|length| length.parse::<f64>().ok());
                let lengths: String =
                    lengths.map(|length| format!("{{{:.2}bp}}", length * POINTS)).collect();
                let _ = writeln!(self.text, "\\pgfsetdash{{{lengths}}}{{0bp}}%");
            }
        }
        for step in steps {
            let command = match step {
                Step::Move(at) => format!("\\pgfpathmoveto{{{}}}", self.point(*at)),
                Step::Line(at) => format!("\\pgfpathlineto{{{}}}", self.point(*at)),
                Step::Curve(a, b, c) => {
                    let [a, b, c] = [a, b, c].map(|at| self.point(*at));
                    format!("\\pgfpathcurveto{{{a}}}{{{b}}}{{{c}}}")
                }
                Step::Close => "\\pgfpathclose".to_owned(),
            };
            let _ = writeln!(self.text, "{command}%");
        }
        let _ = writeln!(self.text, "\\pgfusepath{{{}}}%\n\\end{{pgfscope}}%", uses.join(","));
    }

    fn text(&mut self, text: &Text<'_>) {
        self.define("tsctext", text.color);
        let side = match text.anchor {
            TextAnchor::Start => "left,",
            TextAnchor::Middle => "",
            TextAnchor::End => "right,",
        };
        let size = text.size * POINTS;
        let _ = writeln!(
            self.text,
            "\\pgftext[{side}base,at={{{}}},rotate={:.2}]{{\\fontsize{{{size:.2}bp}}{{{:.2}bp}}\\selectfont{}\
             \\color{{tsctext}}{}}}%",
            self.point(text.at),
            -text.turned,
            size * LEADING,
            if text.bold { "\\bfseries" } else { "" },
            escaped(text.text)
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::svg::{Anchor, Canvas, TextStyle};

    fn drawn() -> Canvas {
        let mut canvas = Canvas::new(200.0, 100.0);
        canvas.line((0.0, 0.0), (200.0, 100.0), "#ff0000", 2.0, Some("5 4"));
        canvas.band(&[(0.0, 0.0), (10.0, 0.0), (10.0, 10.0)], "#0000ff");
        canvas.circle((50.0, 50.0), 10.0, "#00ff00", Some("a tip"));
        canvas.text(100.0, 50.0, "50% & (more) \u{2265} $1", TextStyle::new(Anchor::End));
        canvas
    }

    #[test]
    fn a_pdf_names_where_its_objects_are() {
        let file = drawn().figure("drawn", "T (t)", "d").pdf;
        assert!(file.starts_with(b"%PDF-1.4\n") && file.ends_with(b"%%EOF\n"));
        // A letter for each byte, so that places in the text are those in the file.
        let text: String =
            file.iter().map(|b| if b.is_ascii() { char::from(*b) } else { '?' }).collect();
        let begin: usize =
            text.split("startxref\n").nth(1).unwrap().lines().next().unwrap().parse().unwrap();
        assert!(text[begin..].starts_with("xref\n0 8\n"));
        for (i, line) in text[begin..].lines().skip(3).take(7).enumerate() {
            let place: usize = line[..10].parse().unwrap();
            assert!(text[place..].starts_with(&format!("{} 0 obj\n", i + 1)), "{line}");
        }
        let length: usize =
            text.split("/Length ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
        let stream = text.split("stream\n").nth(1).unwrap();
        assert_eq!(&stream[length..length + 4], "\nend");
    }

    #[test]
    fn a_pdf_has_the_lines_shapes_and_texts_of_the_drawing() {
        let file = drawn().figure("drawn", "T (t)", "d").pdf;
        let text: String = file.iter().map(|byte| char::from(*byte)).collect();
        assert!(text.contains("/MediaBox [0 0 150.00 75.00]"));
        assert!(
            text.contains("1.000 0.000 0.000 RG\n2 w [5 4] 0 d\n0.00 0.00 m\n200.00 100.00 l\nS\n"),
            "{text}"
        );
        assert!(
            text.contains("/G0 gs\n0.00 0.00 m\n10.00 0.00 l\n10.00 10.00 l\nh\nf\n"),
            "{text}"
        );
        assert!(text.contains("/Title (T \\(t\\))") && text.contains("/ca 0.220"));
        // 50% & (more) >= $1 is 9.004 letters wide, so it begins 117.05 to the left of its end.
        let width = width("50% & (more) \u{2265} $1", false);
        assert!((width - 9.004).abs() < 1e-9, "{width}");
        assert!(text.contains("-17.05 50.00 Tm (50% & \\(more\\) >= $1) Tj"), "{text}");
    }

    #[test]
    fn a_pgf_has_the_lines_shapes_and_texts_of_the_drawing() {
        let text = drawn().figure("drawn", "T", "d").pgf;
        assert!(text.contains(
            "\\pgfsetdash{{3.75bp}{3.00bp}}{0bp}%\n\\pgfpathmoveto{\\pgfqpoint{0.00bp}{75.00bp}}%"
        ));
        assert!(text.contains("\\pgfsetfillopacity{0.220}"));
        assert!(
            text.contains("\\pgftext[right,base,at={\\pgfqpoint{75.00bp}{37.50bp}},rotate=-0.00]"),
            "{text}"
        );
        assert!(text.contains("50\\% \\& (more) $\\geq$ \\$1}%"), "{text}");
        assert_eq!(
            text.matches("\\begin{pgfscope}").count(),
            text.matches("\\end{pgfscope}").count()
        );
    }

    #[test]
    fn a_ring_of_arcs_is_a_circle() {
        let ring = steps_of("M40.0 50.0a10.00 10.00 0 1 0 20.00 0a10.00 10.00 0 1 0 -20.00 0");
        let round = circle((50.0, 50.0), 10.0);
        assert_eq!(ring, round[..round.len() - 1]);
        assert_eq!(steps_of("M1 2 L3.5 4 Z"), polygon(&[(1.0, 2.0), (3.5, 4.0)]));
    }
}
