//! Sections that are declared for tests.

use super::*;

settings! {
    /// A section.
    struct Small, source "a paper" {
        /// Things that are kept,
        /// the oldest first.
        kept: usize = 10_000, in 1.0..=1e6, unit "things";
        /// Things per step.
        step: u32 = 3, in 1.0..=64.0, at most kept, unit "things", source "another paper";
        /// Size of a step.
        size: f32 = 1e-3, in 1e-8..=1.0;
        /// Whether it goes backwards.
        backwards: bool = false;
    }
}

settings! {
    /// The same and more.
    struct Large extends Small, source "a paper" {
        /// Things that are kept.
        kept: usize = 7, in 1.0..=1e6, unit "things";
        /// Things per step.
        step: u32 = 3, in 1.0..=64.0, at most kept, unit "things";
        /// Size of a step.
        size: f32 = 1e-3, in 1e-8..=1.0;
        /// Whether it goes backwards.
        backwards: bool = true;
    } and {
        /// More.
        more: f64 = 0.5, in 0.0..=1.0;
    }
}

#[test]
fn a_line_makes_an_entry_of_the_table() {
    let [kept, step, size, backwards] = Small::SETTINGS else { panic!("four settings") };
    assert_eq!(kept.summary(), "Things that are kept, the oldest first.");
    let headline = "Things per step (default 3 things; 1 to 64, at most kept)";
    assert_eq!(step.headline(), headline);
    assert_eq!(Small::default().about(), "A section.");
    let texts = |s: &Setting| (s.name, (s.default)(), s.unit, s.source);
    assert_eq!(texts(kept), ("kept", "10000".to_owned(), "things", "a paper"));
    assert_eq!(texts(step), ("step", "3".to_owned(), "things", "another paper"));
    assert_eq!(texts(size), ("size", "0.001".to_owned(), "", "a paper"));
    assert_eq!(texts(backwards), ("backwards", "false".to_owned(), "", "a paper"));
    let limits = Limits { low: 1.0, high: 64.0, at_most: Some("kept") };
    assert_eq!((step.limits, backwards.limits), (Some(limits), None));
}

#[test]
fn a_limit_that_is_another_setting_moves_with_it() {
    let step = |kept| Small { kept, ..Small::default() }.ranges()[1];
    let range = |high| Ranged { name: "step", value: 3.0, low: 1.0, high };
    assert_eq!((step(9), step(100)), (range(9.0), range(64.0)));
    let names: Vec<_> = Small::default().ranges().iter().map(|r| r.name).collect();
    assert_eq!(names, ["kept", "step", "size"], "a switch has no range");
}

#[test]
fn a_section_that_extends_another_has_its_settings() {
    let large = Large { size: 0.5, ..Large::default() };
    let expected = Small { kept: 7, step: 3, size: 0.5, backwards: true };
    assert_eq!(Small::from(&large), expected);
    assert_eq!(Large::SETTINGS.len(), 5);
}
