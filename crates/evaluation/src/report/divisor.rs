//! What scores are divided by, in words.

use crate::analysis::Reference;

impl Reference {
    /// Returns it in a sentence: `the baseline NAME`, or `NAME`.
    pub(super) fn in_full(&self) -> String {
        if self.is_baseline { baseline_in_full(&self.name) } else { self.name.clone() }
    }

    /// Returns it in a sentence, short: `the baseline`, or `NAME`.
    pub(super) fn in_short(&self) -> &str {
        if self.is_baseline { "the baseline" } else { &self.name }
    }

    /// Returns it in a label: `baseline`, or `NAME`.
    pub(super) fn as_label(&self) -> &str {
        if self.is_baseline { "baseline" } else { &self.name }
    }

    /// Returns its name in a table, marked as what the others are divided by.
    pub(super) fn marked(&self) -> String {
        match self.is_baseline {
            true if self.name == "baseline" => self.name.clone(),
            true => format!("{} (baseline)", self.name),
            false => format!("{} (divisor)", self.name),
        }
    }
}

/// Returns a baseline in a sentence: `the baseline NAME`, without a name that says just that.
pub(super) fn baseline_in_full(name: &str) -> String {
    if name == "baseline" { "the baseline".to_owned() } else { format!("the baseline {name}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reference(name: &str, is_baseline: bool) -> Reference {
        Reference { name: name.into(), index: Some(0), is_baseline }
    }

    #[test]
    fn the_baseline_is_called_so_and_another_method_is_not() {
        let baseline = reference("untuned", true);
        assert_eq!(baseline.in_full(), "the baseline untuned");
        assert_eq!(baseline.in_short(), "the baseline");
        assert_eq!(reference("baseline", true).in_full(), "the baseline");
        assert_eq!(reference("fixed-time", false).in_full(), "fixed-time");
        assert_eq!(reference("fixed-time", false).as_label(), "fixed-time");
    }
}
