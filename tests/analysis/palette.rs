//! Colours that all readers can tell apart.

use tsc_family::domains::domains;
use tsc_family::report::palette::{KNOWN, ORDERED, ink_on, ink_on_known};
use tsc_family::run::method::Method;

/// Least distance of two colours in Oklab; Okabe and Ito's blue and green have 0.086 for readers
/// without S cones.
const APART: f64 = 0.08;

/// What readers see: everything, without L, without M, without S cones.
///
/// Source: G. Machado, M. Oliveira and L. Fernandes, "A physiologically-based model for
/// simulation of color vision deficiency", 2009, severity 1.
const EYES: [[[f64; 3]; 3]; 4] = [
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    [[0.1523, 1.0526, -0.2049], [0.1145, 0.7863, 0.0992], [-0.0039, -0.0481, 1.0520]],
    [[0.3673, 0.8606, -0.2280], [0.2801, 0.6725, 0.0474], [-0.0118, 0.0429, 0.9689]],
    [[1.2555, -0.0767, -0.1788], [-0.0784, 0.9308, 0.1476], [0.0047, 0.6914, 0.3039]],
];

/// B. Ottosson, "A perceptual color space for image processing", 2020.
const TO_CONES: [[f64; 3]; 3] =
    [[0.4122, 0.5363, 0.0514], [0.2119, 0.6807, 0.1074], [0.0883, 0.2817, 0.6300]];
const TO_OKLAB: [[f64; 3]; 3] =
    [[0.2105, 0.7936, -0.0041], [1.9780, -2.4286, 0.4506], [0.0259, 0.7828, -0.8087]];

fn product(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row.iter().zip(v).map(|(a, b)| a * b).sum())
}

fn seen(color: &str, eye: &[[f64; 3]; 3]) -> [f64; 3] {
    let light = [1, 3, 5].map(|i| {
        let c = f64::from(u8::from_str_radix(&color[i..i + 2], 16).unwrap()) / 255.0;
        if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
    });
    let light = product(eye, light).map(|c| c.clamp(0.0, 1.0));
    product(&TO_OKLAB, product(&TO_CONES, light).map(f64::cbrt))
}

fn alike(methods: &[Method]) -> Vec<String> {
    let mut found = Vec::new();
    for (i, a) in methods.iter().enumerate() {
        for b in &methods[..i] {
            let distance = |eye| {
                let (p, q) = (seen(a.color, eye), seen(b.color, eye));
                p.iter().zip(q).map(|(p, q)| (p - q).powi(2)).sum::<f64>().sqrt()
            };
            let least = EYES.iter().map(distance).fold(f64::INFINITY, f64::min);
            if least <= APART {
                found.push(format!("{} and {}: {least}", a.name, b.name));
            }
        }
    }
    found
}

#[test]
fn colour_blind_readers_see_a_colour_per_method() {
    for domain in domains() {
        let baseline = domain.baseline();
        // A tuned method has the colour of its untuned one, and figures name both.
        let is_own = |m: &&Method| Some(m.name) != baseline && !m.is_tuned();
        let methods: Vec<Method> = domain.methods().iter().filter(is_own).copied().collect();
        assert_eq!(alike(&methods), Vec::<String>::new(), "{}", domain.name());
        let twin = Method { name: "twin", ..methods[0] };
        assert_eq!(alike(&[methods[0], twin]).len(), 1, "the check would find two of a colour");
    }
}

#[test]
fn letters_can_be_read_on_every_level() {
    let light = |color: &str| {
        let c = |i: usize| f64::from(u8::from_str_radix(&color[i..i + 2], 16).unwrap()) / 255.0;
        let linear =
            |v: f64| if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) };
        0.2126 * linear(c(1)) + 0.7152 * linear(c(3)) + 0.0722 * linear(c(5))
    };
    let levels = ORDERED.iter().enumerate().map(|(level, color)| (color, ink_on(level)));
    let known = KNOWN.iter().enumerate().map(|(known, color)| (color, ink_on_known(known)));
    for (color, ink) in levels.chain(known) {
        let (a, b) = (light(color), light(ink));
        let contrast = (a.max(b) + 0.05) / (a.min(b) + 0.05);
        assert!(contrast > 4.5, "{color}: {contrast}");
    }
}
