//! The programs of one task.

use evaluation::stats::Direction;
use signals::program::SignalProgram;

/// How much is known of what a method does on a point MDP.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// The record has the programs.
    Recorded,
    /// The record has greens and cycle in words; yellow and all-red follow from the settings.
    Described,
    /// The record has greens and cycle in words, nothing else.
    Greens,
    /// Not even that: the record is from before programs were kept.
    NotKept,
    /// The method decides while it runs.
    Decides,
}

/// The programs of one task.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskPlan {
    /// Position of the method in the manifest.
    pub method: usize,
    /// Position of the point MDP among the chosen ones.
    pub point: usize,
    /// Which of several independent trainings.
    pub replicate: u32,
    /// Mean objective of the evaluation episodes.
    pub objective: Option<f64>,
    /// How much is known.
    pub source: Source,
    /// What there is of programs; most methods have none, and there may be a million tasks.
    pub programs: Option<Box<Programs>>,
    /// Phases of the signals that a method drives by phases, in words, by signal.
    pub phases: Vec<(String, String)>,
    /// Signals of a task in which some ran in two rings: with their phases, or with the fixed cycle of the others.
    pub rings: Vec<SignalProgram>,
}

/// What is known of the programs of a task.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Programs {
    /// One program per signal; without phases where they are not known.
    pub all: Vec<SignalProgram>,
    /// Cycle per signal where the record says it and its phases do not, seconds.
    pub cycles_s: Vec<Option<f64>>,
}

impl TaskPlan {
    /// Returns one program per signal, as far as there are any.
    pub fn programs(&self) -> &[SignalProgram] {
        self.programs.as_ref().map_or(&[], |programs| &programs.all)
    }

    /// Whether its objective is better than that of another training; a training without one is the worst.
    pub(crate) fn is_better_than(&self, other: &Self, direction: Direction) -> bool {
        match (self.objective, other.objective) {
            (Some(own), Some(other)) => direction.is_worse(other, own),
            (own, other) => own.is_some() && other.is_none(),
        }
    }

    /// Whether SUMO can be given the programs.
    pub fn is_whole(&self) -> bool {
        matches!(self.source, Source::Recorded | Source::Described)
    }
}
