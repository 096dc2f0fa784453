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
    /// Something that is not in the results.
    #[error("there is no {what} `{name}` in the results{meant}; there are: {there}")]
    Unknown {
        /// What it is: `method`, `point MDP`.
        what: &'static str,
        /// The name that was given.
        name: String,
        /// The names there are.
        there: String,
        /// What may have been meant, as the end of a message.
        meant: String,
    },
    /// A point MDP on which some method has no score.
    #[error(
        "not every method has a score on point MDP `{point}`; finish the run, or choose methods with --methods"
    )]
    Lacking {
        /// The point MDP.
        point: String,
    },
    /// Methods that have no point MDP in common.
    #[error(
        "no point MDP has a score of every one of {methods} ({lacking}); finish the run, or choose methods with \
         --methods"
    )]
    NothingInCommon {
        /// The methods.
        methods: String,
        /// What they lack.
        lacking: String,
    },
    /// Families that cannot be ranked together, with the reason and the way out.
    #[error("{0}")]
    NotTogether(String),
}
