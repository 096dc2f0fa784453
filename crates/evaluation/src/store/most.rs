//! How much a run may be: a mistyped number, or a stranger's, is refused before anything is allocated for it.

/// Most tasks of a plan: what a machine plans, counts and reports in memory.
pub const MOST_TASKS: u64 = 5_000_000;

/// Most evaluation episodes of a task.
pub const MOST_EVALUATION_SEEDS: u32 = 100_000;

/// Most evaluation episodes of a run, over all tasks: each is a row of a record.
pub const MOST_EVALUATIONS: u64 = 1_000_000_000;

/// Most trainings of a method on a point MDP.
pub const MOST_REPLICATES: u32 = 100_000;

/// Most point MDPs of a family that a sample was drawn from.
const MOST_POINTS: usize = 100_000_000;

/// Checks how many tasks and evaluation episodes a run has.
///
/// # Arguments
///
/// * `per_point` — tasks of every point MDP.
/// * `seeds` — evaluation episodes of every task.
pub fn check(points: usize, per_point: u64, seeds: usize) -> Result<(), String> {
    let (points, seeds) = (points as u64, seeds as u64);
    let tasks = points.saturating_mul(per_point);
    if tasks > MOST_TASKS {
        return Err(format!(
            "{points} point MDPs with {per_point} tasks each are {tasks} tasks, and at most {MOST_TASKS} are taken; \
             give fewer point MDPs, methods or replicates: at most {} tasks per point MDP",
            MOST_TASKS / points.max(1)
        ));
    }
    let episodes = tasks.saturating_mul(seeds);
    if seeds > u64::from(MOST_EVALUATION_SEEDS) || episodes > MOST_EVALUATIONS {
        let most = (MOST_EVALUATIONS / tasks.max(1)).min(MOST_EVALUATION_SEEDS.into());
        return Err(format!(
            "{seeds} evaluation episodes of each of {tasks} tasks are {episodes}; give at most {most} evaluation seeds"
        ));
    }
    Ok(())
}

/// Checks how many trainings of a method a point MDP has.
pub fn check_replicates(replicates: u32) -> Result<(), String> {
    if (1..=MOST_REPLICATES).contains(&replicates) {
        return Ok(());
    }
    Err(format!("replicates = {replicates}: expected 1 to {MOST_REPLICATES}"))
}

/// Checks how often point MDPs were drawn from a family.
///
/// # Errors
///
/// How often that is, and how often they can be.
pub fn check_draws(counts: impl Iterator<Item = u32>, family_size: usize) -> Result<(), String> {
    let drawn: u64 = counts.map(u64::from).sum();
    if family_size <= MOST_POINTS && drawn <= family_size as u64 {
        return Ok(());
    }
    Err(format!(
        "{drawn} draws from a family of {family_size}; expected no more than it has, and at most {MOST_POINTS}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plan_of_a_million_tasks_is_taken_and_one_that_no_machine_holds_is_not() {
        check(250_000, 4, 5).unwrap();
        check(1, 1, 100_000).unwrap();
        assert_eq!(
            check(12_500, 4_000, 5).unwrap_err(),
            "12500 point MDPs with 4000 tasks each are 50000000 tasks, and at most 5000000 are taken; give fewer \
             point MDPs, methods or replicates: at most 400 tasks per point MDP"
        );
        assert!(check(usize::MAX, u64::MAX, 5).unwrap_err().contains("at most 0 tasks"));
        assert_eq!(
            check(250_000, 4, 5_000).unwrap_err(),
            "5000 evaluation episodes of each of 1000000 tasks are 5000000000; give at most 1000 evaluation seeds"
        );
        assert!(check(1, 1, 100_001).unwrap_err().ends_with("at most 100000 evaluation seeds"));
    }
}
