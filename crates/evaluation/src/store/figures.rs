//! Names of what a record's summary says of a training, beside the means over its evaluation, and of metrics of its rows.

/// Name of the metric of a record that says after which row of training the evaluated policy was taken.
pub const POLICY_ROW: &str = "policy_row";

/// Name of the metric of a record that counts how often the training was started again.
pub const RESTARTS: &str = "restarts";

/// Name of the metric of a record that counts the rows of training and the episodes of validation that were given up by
/// starting again.
pub const DISCARDED_EPISODES: &str = "discarded_episodes";

/// Name of the metric of a record that is 1 where the training ended with a dead network, else 0.
pub const DEAD: &str = "dead";

/// Name of the metric of a record that counts the episodes of validation.
pub const VALIDATION_EPISODES: &str = "validation_episodes";

/// Metric of an episode on several point MDPs that counts those where the objective is worse than the baseline's.
pub const ABOVE_BASELINE: &str = "points_above_1";

/// What the name of the objective begins with where it is the last policy's.
pub const LAST_PREFIX: &str = "last_";

/// Metric of a training episode that only learners have; not all learners of somebody's own.
pub const RETURN: &str = "return";

/// Metric of a row of training that is not an episode: steps of training so far.
pub const STEPS: &str = "steps";

/// Training episodes whose mean is reported beside the best one.
pub const LAST_EPISODES: usize = 10;
