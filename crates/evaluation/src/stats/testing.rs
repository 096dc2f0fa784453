//! What tests of resampling share.

use proptest::prelude::*;

use super::PointObjectives;

/// Point MDPs with what was measured there.
pub(super) fn any_points() -> impl Strategy<Value = Vec<PointObjectives>> {
    let values = || prop::collection::vec(0.1f64..100.0, 3);
    let one = (0.01f64..1.0, 1u32..4, prop::collection::vec(values(), 1..3), values());
    let one = one.prop_map(|(weight, draws, method, baseline)| PointObjectives {
        weight,
        draws,
        method,
        baseline,
    });
    prop::collection::vec(one, 1..6)
}
