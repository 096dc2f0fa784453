//! What evaluation knows of a method: its name, and what it does before it is evaluated.

/// What a method does before it is evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Training {
    /// Nothing: its record follows from the evaluation seeds alone, so one task is enough.
    None,
    /// It searches for settings in simulation; another task seed may find others.
    Tuned,
    /// It learns; another task seed learns something else.
    Learned,
}

/// A method as `tsc-family run --methods` knows it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Method {
    /// Stable name.
    pub name: &'static str,
    /// One sentence for people.
    pub summary: &'static str,
    /// What it does before it is evaluated; all but [`Training::None`] is replicated.
    pub training: Training,
    /// Whether it runs when `--methods` is not given.
    pub default: bool,
}
