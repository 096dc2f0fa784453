//! From the times at which vehicles cross a stop line to headways and lost times: pure functions.

use crate::sim::SimError;

/// Vehicles of a queue whose headways do not count.
const STARTING: usize = 4;

/// Vehicles that a green must let through for its headways to count.
const LEAST_VEHICLES: usize = STARTING + 4;

/// Cycles at the beginning in which the queue may be too short.
const FILLING: u32 = 3;

/// When a phase is green, and until when it keeps others waiting, seconds of the cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Served {
    pub(super) green: (f64, f64),
    /// End of its all-red.
    pub(super) until_s: f64,
}

/// How queues discharge, means over lanes and cycles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Discharge {
    /// From the fifth vehicle on.
    pub(super) headway_s: f64,
    /// Start-up lost time.
    pub(super) start_up_s: f64,
    /// Vehicles per lane and phase that cross from the onset of yellow on.
    pub(super) in_yellow: f64,
    /// Lost time per phase.
    pub(super) lost_s: f64,
    /// Vehicles per lane and phase.
    pub(super) vehicles: f64,
}

/// Returns how queues discharge.
///
/// # Arguments
///
/// * `crossings_s` — per lane the times at which vehicles cross, ascending.
///
/// # Errors
///
/// [`SimError::Signal`] when no green had a queue.
pub(super) fn discharge(
    crossings_s: &[Vec<f64>],
    cycle_s: f64,
    served: Served,
) -> Result<Discharge, SimError> {
    let (begin_s, end_s) = served.green;
    let (mut headways_s, mut fourth_s, mut in_yellow, mut all) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for lane in crossings_s {
        let last = lane.last().map_or(0, |t| (t / cycle_s) as u32);
        // The last cycle may be cut off.
        for cycle in FILLING..last {
            let start_s = f64::from(cycle) * cycle_s;
            let within = |from_s: f64, to_s: f64| {
                let times = lane.iter().map(move |t| t - start_s);
                times.filter(move |t| (from_s..to_s).contains(t)).collect::<Vec<f64>>()
            };
            let green = within(begin_s, end_s);
            if green.len() < LEAST_VEHICLES {
                continue;
            }
            let (fourth, vehicles) = (green[STARTING - 1], green.len());
            headways_s.push((green[vehicles - 1] - fourth) / (vehicles - STARTING) as f64);
            fourth_s.push(fourth - begin_s);
            let late = within(end_s, served.until_s).len();
            in_yellow.push(late as f64);
            all.push((vehicles + late) as f64);
        }
    }
    if headways_s.is_empty() {
        return Err(SimError::Signal {
            signal: "c".to_owned(),
            reason: "no green of the calibration had a queue of eight vehicles".to_owned(),
        });
    }
    let headway_s = mean(&headways_s);
    Ok(Discharge {
        headway_s,
        start_up_s: mean(&fourth_s) - STARTING as f64 * headway_s,
        in_yellow: mean(&in_yellow),
        lost_s: served.until_s - begin_s - mean(&all) * headway_s,
        vehicles: mean(&all),
    })
}

/// Returns the mean of some values.
pub(super) fn mean(of: &[f64]) -> f64 {
    of.iter().sum::<f64>() / of.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    const SERVED: Served = Served { green: (10.0, 40.0), until_s: 45.0 };

    /// Ten cycles of 100 s, in each of which vehicles cross at these seconds.
    fn crossings(of_cycle: &[f64]) -> Vec<Vec<f64>> {
        vec![(0..10).flat_map(|c| of_cycle.iter().map(move |t| 100.0 * f64::from(c) + t)).collect()]
    }

    #[test]
    fn headways_count_from_the_fifth_vehicle_and_the_first_four_lose_time() {
        // The fourth after 10 s, then one every 2 s until 36 s, one in yellow.
        let mut times = vec![13.0, 15.5, 18.0, 20.0];
        times.extend((1..=8).map(|k| 20.0 + 2.0 * f64::from(k)));
        times.push(41.0);
        let found = discharge(&crossings(&times), 100.0, SERVED).unwrap();
        assert_eq!((found.headway_s, found.start_up_s, found.in_yellow), (2.0, 2.0, 1.0));
        // 35 s for 13 vehicles of 2 s.
        assert_eq!(found.lost_s, 9.0);
    }

    #[test]
    fn greens_without_a_queue_are_no_measurement() {
        let e = discharge(&crossings(&[12.0, 14.0]), 100.0, SERVED).unwrap_err().to_string();
        assert!(e.contains("no green of the calibration had a queue"), "{e}");
    }
}
