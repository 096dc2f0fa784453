//! Colours that stay apart for colour-blind readers and in print. Those of methods are in their own
//! descriptions: hue alone does not keep ten apart, so they differ in lightness too, and learners, whose curves
//! cross, in their dashes.

/// Colour of what scores are divided by.
pub(super) const BASELINE: &str = "#8c8c8c";

/// Colours of methods that the domain does not have.
const OTHERS: [&str; 6] = ["#0072b2", "#d55e00", "#009e73", "#e69f00", "#56b4e9", "#cc79a7"];

/// Colours from best to worst, each darker than the one before, so that the order stays in print and
/// for colour-blind readers.
///
/// Source: C. Brewer, colorbrewer2.org, sequential `YlOrRd` and `Reds` of nine classes, chosen for steps of
/// lightness that all readers see.
pub const ORDERED: [&str; 6] = ["#ffffcc", "#fed976", "#fd8d3c", "#fc4e2a", "#cb181d", "#67000d"];

/// Colours from what is known to what is assumed, each lighter than the one before.
///
/// Source: C. Brewer, colorbrewer2.org, sequential `Blues` of nine classes.
pub const KNOWN: [&str; 6] = ["#08306b", "#2070b4", "#4f9bcb", "#94c4df", "#cde0f1", "#f7fbff"];

/// Returns the colour of a text on one of [`KNOWN`].
pub fn ink_on_known(known: usize) -> &'static str {
    if known < 2 { "#ffffff" } else { "#1a1a1a" }
}

/// Colour of what is not known.
pub const UNKNOWN: &str = "#9e9e9e";

/// Returns the colour of a text on one of [`ORDERED`].
pub fn ink_on(ordered: usize) -> &'static str {
    if ordered < 4 { "#1a1a1a" } else { "#ffffff" }
}

/// Returns the colour of a method that the domain does not have, by its position among those; one that no other
/// method has, as far as there are enough.
pub fn method(position: usize, taken: &[&str]) -> &'static str {
    let free: Vec<&str> = OTHERS.into_iter().filter(|color| !taken.contains(color)).collect();
    let colors = if free.is_empty() { &OTHERS[..] } else { &free };
    colors[position % colors.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn methods_that_a_domain_does_not_have_take_colours_in_turn() {
        assert_eq!((method(0, &[]), method(7, &[])), (OTHERS[0], OTHERS[1]));
        assert_eq!((method(0, &[OTHERS[0]]), method(9, &OTHERS)), (OTHERS[1], OTHERS[3]));
    }
}
