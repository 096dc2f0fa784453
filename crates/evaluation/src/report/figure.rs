//! A drawing as a file and on the page.

/// Width of all figures, pixels.
pub const WIDTH: f64 = 900.0;

/// A figure: its file name without extension, and the SVG.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Figure {
    /// File name without extension, also its id in the page.
    pub name: &'static str,
    /// The SVG.
    pub svg: String,
}
