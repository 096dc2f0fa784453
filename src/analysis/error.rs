//! Why results cannot be analysed as asked.

/// Why results cannot be analysed as asked.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AnalysisError {
    /// Scores cannot be divided by a method that the run does not have.
    #[error("no scores against `{method}`, which is not in the run; its methods are {methods}")]
    NotInRun {
        /// The method.
        method: String,
        /// The methods of the run.
        methods: String,
    },
    /// Scores cannot be divided by a method that lacks results.
    #[error(
        "no scores against `{method}`: it has no {objective} above 0 on {missing} of {points} ({some}); \
         finish the run, or leave --against out"
    )]
    Incomplete {
        /// The method.
        method: String,
        /// What scores compare.
        objective: String,
        /// Number of point MDPs without a result.
        missing: usize,
        /// Number of chosen point MDPs, in words.
        points: String,
        /// Some of those without a result.
        some: String,
    },
}
