//! Families that tests of sampling draw from.

use super::{Feature, MdpFamily, PointMdp};

/// Returns a family like a city's: 164 point MDPs on a grid of six features, a few of which hold most of the importance.
pub(crate) fn city() -> MdpFamily {
    grid("city", 164, 0.97)
}

/// Returns `size` point MDPs, each as important as the one before times `decay`.
fn grid(name: &str, size: usize, decay: f64) -> MdpFamily {
    let features =
        ["lanes", "speed_mph", "length_m", "inflow_vph", "left_turn_lanes", "right_turn_lanes"];
    let features = features.map(|name| Feature { name: name.to_owned(), unit: String::new() });
    let total: f64 = (0..size).map(|i| decay.powi(i as i32)).sum();
    let point = |i: usize| {
        // The digits of i with these bases, scattered so that neighbours in importance differ.
        let mut rest = i * 89 % 1024;
        let levels = [
            (4, 2.0, 1.0),
            (4, 20.0, 5.0),
            (4, 100.0, 100.0),
            (4, 250.0, 250.0),
            (2, 0.0, 1.0),
            (2, 0.0, 1.0),
        ];
        let features = levels.map(|(base, first, step)| {
            let digit = rest % base;
            rest /= base;
            first + step * digit as f64
        });
        let id = format!("p{i:03}");
        let importance = decay.powi(i as i32) / total;
        PointMdp { title: id.clone(), id, features: features.to_vec(), importance, instances: 1 }
    };
    MdpFamily::new(name, features.to_vec(), (0..size).map(point).collect(), name)
        .expect("the importance sums to 1")
}
