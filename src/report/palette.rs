//! Colours that stay apart for colour-blind readers and in print.

/// Colour of the baseline.
const BASELINE: &str = "#8c8c8c";

/// Okabe and Ito's palette without black, most legible first.
///
/// Source: M. Okabe and K. Ito, "Color universal design", 2008.
const METHODS: [&str; 8] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#f0e442", "#1a1a1a"];

/// Colours from best to worst, readable in the same order by colour-blind readers.
///
/// Source: C. Brewer, colorbrewer2.org, diverging `RdYlBu` with six classes, reversed.
pub(super) const ORDERED: [&str; 6] =
    ["#4575b4", "#91bfdb", "#e0f3f8", "#fee090", "#fc8d59", "#d73027"];

/// Colour of what is not known.
pub(super) const UNKNOWN: &str = "#9e9e9e";

/// Returns the colour of a text on one of [`ORDERED`].
pub(super) fn ink_on(ordered: usize) -> &'static str {
    if ordered == 0 || ordered + 1 == ORDERED.len() { "#ffffff" } else { "#1a1a1a" }
}

/// Returns the colour of a method by its position among the methods that are not the baseline.
pub(super) fn method(position: Option<usize>) -> &'static str {
    position.map_or(BASELINE, |i| METHODS[i % METHODS.len()])
}
