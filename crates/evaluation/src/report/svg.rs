//! A canvas with axes that becomes an SVG; the only file that names the plotting crate.
//!
//! The crate draws axes, ticks and grid; the marks are drawn as primitives at positions that the
//! axes give, because its ready-made plots have no common margins, no clipped values and no labels
//! inside bars.

use std::path::{Path, PathBuf};

use basics::files::{FileError, write_atomically};
use kuva::backend::svg::SvgBackend;
use kuva::render::axis::{add_axes_and_grid, add_labels_and_title};
use kuva::render::color::Color;
use kuva::render::layout::{ComputedLayout, Layout, TickFormat};
pub use kuva::render::render::TextAnchor as Anchor;
use kuva::render::render::{PathData, Primitive, Scene};
use kuva::render::theme::Theme;

/// Width of all figures, pixels.
pub const WIDTH: f64 = 900.0;

/// Fonts, all of them local; the first that exists is used.
const FONT: &str = "Helvetica Neue, Helvetica, Arial, Liberation Sans, DejaVu Sans, sans-serif";

/// Height of labels, ticks and text, pixels of the drawing.
pub const TEXT_PX: u32 = 13;

/// Mean width of a character relative to its height in the fonts above, on the generous side.
const CHARACTER_WIDTH: f64 = 0.56;

/// Opacity of a band around a line.
const BAND_OPACITY: f64 = 0.22;

/// Colour of text.
pub const INK: &str = "#1a1a1a";

/// Colour of reference lines and of what is secondary.
pub const MUTED: &str = "#5a5a5a";

/// A figure: its file name without extension, and the drawing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Figure {
    /// File name without extension, also its id in the page.
    pub name: &'static str,
    /// The SVG.
    pub svg: String,
}

impl Figure {
    /// Writes the figure, and returns its file.
    ///
    /// # Errors
    ///
    /// [`FileError`] when the folder cannot be written or the disk is full.
    pub fn write(&self, folder: &Path) -> Result<PathBuf, FileError> {
        let path = folder.join(format!("{}.svg", self.name));
        write_atomically(&path, self.svg.as_bytes())?;
        Ok(path)
    }
}

/// How a text looks.
#[derive(Debug, Clone, Copy)]
pub struct TextStyle {
    /// Where it stands.
    pub anchor: Anchor,
    /// Whether it is bold.
    pub bold: bool,
    /// Its colour.
    pub color: &'static str,
    /// Its height, pixels.
    pub size_px: u32,
}

impl TextStyle {
    /// Returns the usual style.
    pub fn new(anchor: Anchor) -> Self {
        Self { anchor, bold: false, color: INK, size_px: TEXT_PX }
    }

    /// Returns the style in bold.
    pub fn bold(self) -> Self {
        Self { bold: true, ..self }
    }

    /// Returns the style in a smaller size, for notes.
    pub fn small(self) -> Self {
        Self { size_px: TEXT_PX - 2, ..self }
    }

    /// Returns the style in so many pixels.
    pub fn sized(self, size_px: u32) -> Self {
        Self { size_px, ..self }
    }

    /// Returns the style in another colour.
    pub fn color(self, color: &'static str) -> Self {
        Self { color, ..self }
    }
}

/// Axes to draw: their place on the canvas, ranges and labels.
#[derive(Debug, Clone, PartialEq)]
pub struct Axes {
    /// Left, top, right and bottom end of the plot area, pixels.
    pub area: (f64, f64, f64, f64),
    /// Range of x.
    pub x: (f64, f64),
    /// Range of y.
    pub y: (f64, f64),
    /// Distance of the ticks on x.
    pub x_step: f64,
    /// Distance of the ticks on y; `None` draws no ticks on y.
    pub y_step: Option<f64>,
    /// Last tick on x with a label; beyond it the axis means something else.
    pub x_last: f64,
    /// Label of x with its unit; `None` draws no tick labels either.
    pub x_label: Option<String>,
    /// Label of y with its unit.
    pub y_label: Option<String>,
}

/// Maps data to the canvas.
pub struct Frame {
    computed: ComputedLayout,
}

impl Frame {
    /// Returns the pixel of an x value.
    pub fn x(&self, value: f64) -> f64 {
        self.computed.map_x(value)
    }

    /// Returns the pixel of a y value.
    pub fn y(&self, value: f64) -> f64 {
        self.computed.map_y(value)
    }
}

/// A drawing of a fixed size in pixels.
#[derive(Debug)]
pub struct Canvas {
    scene: Scene,
    width: f64,
    height: f64,
}

impl Canvas {
    /// Returns an empty, white canvas.
    pub fn new(width: f64, height: f64) -> Self {
        let mut scene = Scene::new(width, height);
        scene.font_family = Some(FONT.to_owned());
        scene.background_color = Some("white".to_owned());
        scene.text_color = Some(INK.to_owned());
        Self { scene, width, height }
    }

    /// Draws axes with ticks and grid lines.
    pub fn axes(&mut self, axes: &Axes) -> Frame {
        let (left, top, right, bottom) = axes.area;
        let theme = Theme {
            axis_color: MUTED.into(),
            tick_color: MUTED.into(),
            grid_color: "#e3e3e3".into(),
            text_color: INK.into(),
            ..Theme::light()
        };
        let mut layout = Layout::new(axes.x, axes.y)
            .with_width(self.width)
            .with_height(self.height)
            .with_theme(theme)
            .with_force_margins(left, self.width - right)
            .with_force_margins_y(top, self.height - bottom)
            .with_x_axis_min(axes.x.0)
            .with_x_axis_max(axes.x.1)
            .with_y_axis_min(axes.y.0)
            .with_y_axis_max(axes.y.1)
            .with_x_tick_step(axes.x_step)
            .with_label_size(TEXT_PX)
            .with_tick_size(TEXT_PX)
            .with_x_tick_format(tick_format(axes));
        if let Some(step) = axes.y_step {
            layout = layout.with_y_tick_step(step);
        } else {
            layout.suppress_y_ticks = true;
            layout = layout.with_y_categories(Vec::new());
        }
        if let Some(label) = &axes.y_label {
            layout = layout.with_y_label(plain(label));
        }
        let computed = ComputedLayout::from_layout(&layout);
        add_axes_and_grid(&mut self.scene, &computed, &layout);
        add_labels_and_title(&mut self.scene, &computed, &layout);
        if let Some(label) = &axes.x_label {
            let style = TextStyle::new(Anchor::Middle);
            self.text((left + right) / 2.0, bottom + 42.0, label, style);
        }
        Frame { computed }
    }

    /// Draws a rectangle, given two corners, with an optional outline.
    pub fn rect(
        &mut self,
        (x, y): (f64, f64),
        (x2, y2): (f64, f64),
        fill: &str,
        line: Option<&str>,
    ) {
        self.scene.add(Primitive::Rect {
            x: x.min(x2),
            y: y.min(y2),
            width: (x2 - x).abs(),
            height: (y2 - y).abs(),
            fill: Color::from(fill),
            stroke: line.map(Color::from),
            stroke_width: line.map(|_| 0.7),
            opacity: None,
        });
    }

    /// Draws a line; `dash` is a pattern such as `5 4`.
    pub fn line(
        &mut self,
        a: (f64, f64),
        b: (f64, f64),
        color: &str,
        width: f64,
        dash: Option<&str>,
    ) {
        self.scene.add(Primitive::Line {
            x1: a.0,
            y1: a.1,
            x2: b.0,
            y2: b.1,
            stroke: Color::from(color),
            stroke_width: width,
            stroke_dasharray: dash.map(str::to_owned),
        });
    }

    /// Draws lines from point to point; `dash` is a pattern such as `5 4`.
    pub fn polyline(
        &mut self,
        points: Vec<(f64, f64)>,
        color: &str,
        width: f64,
        dash: Option<&str>,
    ) {
        self.scene.add(Primitive::PolyLine {
            points,
            stroke: Color::from(color),
            stroke_width: width,
            stroke_dasharray: dash.map(str::to_owned),
        });
    }

    /// Draws a circle with a thin outline; the tip shows when the pointer rests on it.
    pub fn circle(&mut self, (cx, cy): (f64, f64), r: f64, fill: &str, tip: Option<&str>) {
        let circle = Primitive::Circle {
            cx,
            cy,
            r,
            fill: Color::from(fill),
            fill_opacity: None,
            stroke: Some(Color::from(INK)),
            stroke_width: Some(0.6),
        };
        self.tipped(circle, tip);
    }

    fn tipped(&mut self, drawn: Primitive, tip: Option<&str>) {
        match tip {
            Some(tip) => self.group(tip, None, |canvas| canvas.scene.add(drawn)),
            None => self.scene.add(drawn),
        }
    }

    /// Draws a group with a tip that shows when the pointer rests on it, and with further attributes.
    pub fn group(&mut self, tip: &str, attrs: Option<String>, draw: impl FnOnce(&mut Self)) {
        let (title, extra_attrs) = (Some(tip.to_owned()), attrs);
        self.scene.add(Primitive::GroupStart { transform: None, title, extra_attrs });
        draw(self);
        self.scene.add(Primitive::GroupEnd);
    }

    /// Draws lines given as SVG path data; the tip shows when the pointer rests on one.
    pub fn path(&mut self, d: String, color: &str, width: f64, tip: Option<&str>) {
        let path = Primitive::Path(Box::new(PathData {
            d,
            fill: None,
            stroke: Color::from(color),
            stroke_width: width,
            opacity: None,
            stroke_dasharray: None,
        }));
        self.tipped(path, tip);
    }

    /// Draws a filled shape with a thin outline.
    pub fn shape(&mut self, corners: &[(f64, f64)], fill: &str) {
        self.filled(corners, fill, INK, 0.6, None);
    }

    /// Draws a translucent shape without outline.
    pub fn band(&mut self, corners: &[(f64, f64)], fill: &str) {
        self.filled(corners, fill, fill, 0.0, Some(BAND_OPACITY));
    }

    fn filled(
        &mut self,
        corners: &[(f64, f64)],
        fill: &str,
        line: &str,
        width: f64,
        opacity: Option<f64>,
    ) {
        let mut d = String::new();
        for (i, (x, y)) in corners.iter().enumerate() {
            d.push_str(&format!("{}{x:.1} {y:.1} ", if i == 0 { 'M' } else { 'L' }));
        }
        d.push('Z');
        self.scene.add(Primitive::Path(Box::new(PathData {
            d,
            fill: Some(Color::from(fill)),
            stroke: Color::from(line),
            stroke_width: width,
            opacity,
            stroke_dasharray: None,
        })));
    }

    /// Writes a text; `y` is its baseline.
    pub fn text(&mut self, x: f64, y: f64, text: &str, style: TextStyle) {
        self.scene.add(Primitive::Text {
            x,
            y,
            content: plain(text),
            size: style.size_px,
            anchor: style.anchor,
            rotate: None,
            bold: style.bold,
            color: Some(Color::from(style.color)),
        });
    }

    /// Returns the drawing as a figure, with a title and a description for those who cannot see it.
    ///
    /// # Arguments
    ///
    /// * `name` — of its files, and its id, which must be unique in the page.
    pub fn figure(self, name: &'static str, title: &str, description: &str) -> Figure {
        Figure { name, svg: self.finish(name, title, description) }
    }

    /// Returns the SVG, with a title and a description for those who cannot see it.
    ///
    /// `id` must be unique in the page.
    pub fn finish(self, id: &str, title: &str, description: &str) -> String {
        let svg = SvgBackend::new().with_pretty(true).render_scene(&self.scene);
        let (open, body) = svg.split_once('>').expect("an SVG starts with its element");
        format!(
            "{open} viewBox=\"0 0 {} {}\" role=\"img\" aria-labelledby=\"{id}-title {id}-desc\">\n  \
             <title id=\"{id}-title\">{}</title>\n  <desc id=\"{id}-desc\">{}</desc>{body}",
            self.width,
            self.height,
            escape(title),
            escape(description),
        )
    }
}

/// Returns the width of a text at its usual height, pixels, on the generous side.
pub fn text_width(text: &str) -> f64 {
    text.chars().count() as f64 * f64::from(TEXT_PX) * CHARACTER_WIDTH
}

/// Returns a distance of ticks (1, 2 or 5 times a power of 10) that makes about `count` of them.
pub fn nice_step(span: f64, count: f64) -> f64 {
    let raw = (span / count).max(f64::MIN_POSITIVE);
    let power = 10f64.powf(raw.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().find(|s| s * power >= raw * 0.999).unwrap_or(10.0) * power
}

fn tick_format(axes: &Axes) -> TickFormat {
    let (last, labelled) = (axes.x_last + 1e-9, axes.x_label.is_some());
    let decimals = (-(axes.x_step.log10() + 1e-9).floor()).max(0.0) as usize;
    TickFormat::Custom(std::sync::Arc::new(move |v| match labelled && v <= last {
        true => format!("{v:.decimals$}"),
        false => String::new(),
    }))
}

/// A dollar sign would start a formula.
fn plain(text: &str) -> String {
    text.replace('$', "\\$")
}

fn escape(text: &str) -> String {
    quick_xml::escape::escape(text).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_svg_has_a_title_and_escapes_text() {
        let mut canvas = Canvas::new(100.0, 50.0);
        canvas.text(1.0, 2.0, "a < b & $c", TextStyle::new(Anchor::Start));
        let svg = canvas.finish("x", "T & t", "d");
        assert!(svg.contains("a &lt; b &amp; $c"), "{svg}");
        assert!(svg.contains("<title id=\"x-title\">T &amp; t</title>"));
        assert!(svg.contains("viewBox=\"0 0 100 50\""));
    }

    #[test]
    fn ticks_are_round_numbers() {
        assert_eq!([1.1, 2.3, 40.0].map(|span| nice_step(span, 5.0)), [0.5, 0.5, 10.0]);
        assert!((nice_step(0.9, 5.0) - 0.2).abs() < 1e-12);
    }
}
