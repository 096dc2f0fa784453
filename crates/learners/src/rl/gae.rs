//! Generalised advantage estimation (Schulman et al., 2016).

/// What the estimate needs of a transition.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Reward received.
    pub reward: f32,
    /// Value of the state before.
    pub value: f32,
    /// Value of the state after; 0 when it is terminal.
    pub next_value: f32,
    /// Whether the next step belongs to another episode.
    pub last: bool,
}

/// Writes the advantage of every step.
///
/// `A_t = sum_k (gamma lambda)^k (r_{t+k} + gamma V_{t+k+1} - V_{t+k})`, the sum ending with the
/// episode or with the steps.
///
/// # Arguments
///
/// * `steps`, `advantages` — of the same length, in the order of time.
pub fn advantages(steps: &[Step], gamma: f32, lambda: f32, advantages: &mut [f32]) {
    let mut next = 0.0;
    for (step, advantage) in steps.iter().zip(advantages).rev() {
        if step.last {
            next = 0.0;
        }
        let error = step.reward + gamma * step.next_value - step.value;
        next = error + gamma * lambda * next;
        *advantage = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(reward: f32, value: f32, next_value: f32, last: bool) -> Step {
        Step { reward, value, next_value, last }
    }

    #[test]
    fn advantages_are_those_computed_by_hand() {
        // gamma 0.5, lambda 0.5; errors: 1 + 1 - 1 = 1; 2 + 0 - 2 = 0 (terminal); then a new episode:
        // -1 + 2 - 4 = -3; 0 + 3 - 4 = -1 (cut, the value after counts).
        let steps = [
            step(1.0, 1.0, 2.0, false),
            step(2.0, 2.0, 0.0, true),
            step(-1.0, 4.0, 4.0, false),
            step(0.0, 4.0, 6.0, true),
        ];
        let mut found = [0.0; 4];
        advantages(&steps, 0.5, 0.5, &mut found);
        assert_eq!(found, [1.0, 0.0, -3.25, -1.0]);
    }

    #[test]
    fn with_lambda_one_the_advantage_is_return_less_value() {
        let steps =
            [step(1.0, 7.0, 3.0, false), step(1.0, 3.0, 5.0, false), step(1.0, 5.0, 0.0, true)];
        let mut found = [0.0; 3];
        advantages(&steps, 0.9, 1.0, &mut found);
        assert!((found[0] - (1.0 + 0.9 + 0.81 - 7.0)).abs() < 1e-5);
    }
}
