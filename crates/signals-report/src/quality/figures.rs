//! The figures of the page on quality, except the map: shares of what is known, and histograms.

use evaluation::report::WIDTH;
use evaluation::report::svg::{Anchor, Axes, Canvas, MUTED, TextStyle, nice_step};
use evaluation::report::{format, palette};
use evaluation::stats::Histogram;
use signals::city::quality::{Distribution, Quality};

use super::text::percent;

/// Height of the row of a feature, pixels.
const ROW_PX: f64 = 34.0;

/// Smallest share of a bar that has room for its label.
const LABELLED_SHARE: f64 = 0.05;

/// What values rest on, with the position of its colour in [`palette::KNOWN`].
pub(super) const SOURCES: [(&str, usize); 4] = [
    ("known from the data", 0),
    ("counted on its street", 2),
    ("from its class of street", 4),
    ("default", 5),
];

/// Width and height of a small histogram, pixels: it fits on a phone without scrolling.
const SMALL_PX: (f64, f64) = (300.0, 214.0);

/// Most bars of a histogram before its last one for everything beyond.
const MAX_BARS: usize = 14;

/// Fewest bars, so that a single one does not fill the panel.
const MIN_BARS: usize = 3;

/// Share of the values that decides how wide bars are, and share that is shown before the last one.
const USUAL: (f64, f64) = (0.95, 0.99);

/// Smallest height of a bar that counts anything, pixels.
const MIN_BAR_PX: f64 = 3.0;

/// Height of a panel relative to its highest bar, so that a count fits above.
const HEADROOM: f64 = 1.2;

/// Width of the bars of distances, metres.
const DISTANCE_BIN_M: f64 = 5.0;

/// Draws per feature the shares of what is known, imputed and assumed.
pub(super) fn provenance(q: &Quality) -> String {
    let (left, right, top) = (96.0, WIDTH - 24.0, 40.0);
    let bottom = top + ROW_PX * q.provenance.len() as f64;
    let mut canvas = Canvas::new(WIDTH, bottom + 56.0);
    let frame = canvas.axes(&Axes {
        area: (left, top, right, bottom),
        x: (0.0, 100.0),
        y: (0.0, q.provenance.len().max(1) as f64),
        x_step: 20.0,
        y_step: None,
        x_last: 100.0,
        x_label: Some("share of approaches (%)".to_owned()),
        y_label: None,
    });
    for (i, (name, color)) in SOURCES.into_iter().enumerate() {
        let x = left + 205.0 * i as f64;
        canvas.rect((x, 10.0), (x + 16.0, 26.0), palette::KNOWN[color], Some("#1a1a1a"));
        canvas.text(x + 22.0, 22.5, name, TextStyle::new(Anchor::Start));
    }
    let mut description = Vec::new();
    for (i, p) in q.provenance.iter().enumerate() {
        let y = top + ROW_PX * i as f64;
        let middle = y + ROW_PX / 2.0 + 4.5;
        let name = p.feature.replace('_', " ");
        canvas.text(left - 10.0, middle, &name, TextStyle::new(Anchor::End));
        let mut from = 0.0;
        let shares = [p.tagged, p.spread, p.imputed, p.default];
        for ((_, color), share) in SOURCES.into_iter().zip(shares).filter(|s| s.1 > 0.0) {
            let (a, b) = (frame.x(100.0 * from), frame.x(100.0 * (from + share)));
            let fill = palette::KNOWN[color];
            canvas.rect((a, y + 4.0), (b, y + ROW_PX - 4.0), fill, Some("#1a1a1a"));
            if share >= LABELLED_SHARE {
                let style = TextStyle::new(Anchor::Middle).color(palette::ink_on_known(color));
                canvas.text((a + b) / 2.0, middle, &percent(share), style);
            }
            from += share;
        }
        let [known, spread, imputed, default] = shares.map(percent);
        description.push(format!(
            "{name}: {known} known, {spread} counted elsewhere on the street, {imputed} from class, \
             {default} default"
        ));
    }
    canvas.finish("provenance-figure", "What the values rest on", &description.join("; "))
}

/// Draws a small histogram of every feature, its bars the bins that make point MDPs.
pub(super) fn features(q: &Quality) -> Vec<String> {
    let panel = |(i, d): (usize, &Distribution)| {
        let name = format::words(&d.name, &d.unit);
        let title = format!("{name}: mean {}, sd {}", format::score(d.mean), format::score(d.sd));
        let label = if d.unit.starts_with(&name) {
            d.unit.clone()
        } else if d.unit.is_empty() {
            name
        } else {
            format!("{name} ({})", d.unit)
        };
        let bars = Bars { values: &d.values, bin: d.bin, centred: true };
        histogram(&format!("feature-{i}"), &title, &label, "intersections", &bars)
    };
    q.features.iter().enumerate().map(panel).collect()
}

/// Returns the distances of matched rows of the signal list, metres.
pub(super) fn matched_m(q: &Quality) -> Vec<f64> {
    let matched = q.listed.iter().filter(|row| row.intersection.is_some());
    matched.filter_map(|row| row.distance_m).collect()
}

/// Draws the distances of matched rows of the signal list; `None` without any.
pub(super) fn distances(q: &Quality) -> Option<String> {
    let values = matched_m(q);
    let bars = Bars { values: &values, bin: DISTANCE_BIN_M, centred: false };
    let (title, label) = ("Distance of matched signals", "distance to the intersection (m)");
    (!values.is_empty())
        .then(|| histogram("distances-figure", title, label, "listed signals", &bars))
}

/// Values to count: in bins around multiples of a width, or between them.
struct Bars<'a> {
    values: &'a [f64],
    bin: f64,
    centred: bool,
}

impl Bars<'_> {
    /// Returns the position of a value in units of a width, as the family rounds it.
    fn position(&self, value: f64, width: f64) -> f64 {
        match self.centred {
            true => (value / width).round_ties_even(),
            false => (value / width + 1e-9).floor(),
        }
    }

    /// Returns counts per bar and the width of a bar, a multiple of the bin if there would be too
    /// many otherwise.
    fn count(&self) -> (Histogram, f64) {
        let mut sorted = self.values.to_vec();
        sorted.sort_by(f64::total_cmp);
        if sorted.is_empty() {
            return (Histogram::new(&[], (MIN_BARS as f64, 1.0)), self.bin);
        }
        // Not interpolated, which would reach towards an extreme value.
        let at = |share: f64| sorted[(share * (sorted.len() - 1) as f64) as usize];
        let mut width = self.bin;
        while self.position(at(USUAL.0), width) >= MAX_BARS as f64 {
            width *= 2.0;
        }
        let (all, last) = (self.position(at(1.0), width), MAX_BARS as f64 - 1.0);
        let shown = if all <= last { all } else { self.position(at(USUAL.1), width).min(last) };
        let bars = (shown as usize + 1).max(MIN_BARS) as f64;
        let positions: Vec<f64> = sorted.iter().map(|v| self.position(*v, width)).collect();
        (Histogram::new(&positions, (bars, 1.0)), width)
    }
}

fn histogram(id: &str, title: &str, x_label: &str, what: &str, bars: &Bars<'_>) -> String {
    let (h, width) = bars.count();
    let (count, start) = (h.counts.len() as f64, if bars.centred { -0.5 } else { 0.0 });
    let beyond = h.over > 0;
    let peak = h.peak().max(1) as f64;
    // The bar of everything beyond has room for its label, after a gap of one.
    let last = (count / 5.0).max(2.0);
    let end = start + count + if beyond { 1.0 + last } else { 0.0 };
    let area = (46.0, 46.0, SMALL_PX.0 - 12.0, SMALL_PX.1 - 52.0);
    let mut canvas = Canvas::new(SMALL_PX.0, SMALL_PX.1);
    let at_bars = width * ((end - start) / 6.0).ceil();
    let step = if at_bars.fract() == 0.0 { at_bars } else { nice_step(width * (end - start), 5.0) };
    let frame = canvas.axes(&Axes {
        area,
        x: (start * width, end * width),
        y: (0.0, peak * HEADROOM),
        x_step: step,
        y_step: Some(nice_step(peak, 4.0).max(1.0)),
        x_last: (start + count - if beyond { count / MAX_BARS as f64 } else { 0.0 }) * width,
        x_label: Some(x_label.to_owned()),
        y_label: None,
    });
    let (bottom, color) = (frame.y(0.0), palette::KNOWN[0]);
    for (b, n) in h.counts.iter().enumerate().filter(|(_, n)| **n > 0) {
        let from = start + b as f64;
        let (x, x2) = (frame.x(from * width), frame.x((from + 1.0) * width));
        let y = frame.y(*n as f64).min(bottom - MIN_BAR_PX);
        canvas.rect((x, bottom), (x2, y), color, Some("#ffffff"));
    }
    if beyond {
        let (x, x2) = (frame.x((end - last) * width), frame.x(end * width));
        let y = frame.y(h.over as f64).min(bottom - MIN_BAR_PX);
        canvas.rect((x, bottom), (x2, y), color, Some("#1a1a1a"));
        let style = TextStyle::new(Anchor::Middle).small();
        canvas.text((x + x2) / 2.0, y - 4.0, &h.over.to_string(), style);
        let label = format!("\u{2265} {}", format::feature((start + count) * width));
        canvas.text(x2, area.3 + 17.0, &label, TextStyle::new(Anchor::End));
    }
    canvas.text(8.0, 17.0, title, TextStyle::new(Anchor::Start).bold());
    canvas.text(
        8.0,
        36.0,
        &format!("number of {what}"),
        TextStyle::new(Anchor::Start).color(MUTED),
    );
    let counts: Vec<String> = h.counts.iter().map(usize::to_string).collect();
    let description = format!(
        "number of {what} per {} from 0 on: {}; beyond: {}",
        format::feature(width),
        counts.join(", "),
        h.over
    );
    canvas.finish(id, title, &description)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counted(values: &[f64], bin: f64, centred: bool) -> (Vec<usize>, usize, f64) {
        let (h, width) = Bars { values, bin, centred }.count();
        (h.counts, h.over, width)
    }

    #[test]
    fn a_tie_goes_to_the_bar_of_its_point_mdp() {
        assert_eq!(counted(&[0.5, 1.5, 2.5], 1.0, true), (vec![1, 0, 2], 0, 1.0));
    }

    #[test]
    fn distances_lie_between_ticks() {
        assert_eq!(counted(&[0.0, 4.9, 5.0], 5.0, false), (vec![2, 1, 0], 0, 5.0));
    }

    #[test]
    fn an_extreme_value_does_not_squeeze_the_others() {
        let mut values = vec![100.0; 40];
        values.push(5000.0);
        assert_eq!(counted(&values, 100.0, true), (vec![0, 40, 0], 1, 100.0));
    }

    #[test]
    fn many_bins_become_wider_bars() {
        let values: Vec<f64> = (0..1000).map(f64::from).collect();
        let (counts, over, width) = counted(&values, 1.0, true);
        assert_eq!((counts.len(), counts.iter().sum::<usize>(), over), (9, 1000, 0));
        assert_eq!(width, 128.0);
    }
}
