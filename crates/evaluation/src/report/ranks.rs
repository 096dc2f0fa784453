//! The probability of every place for every method, as a table of shaded cells.

use super::figure::{Figure, WIDTH};
use super::figures::{label, sentence, widest_name};
use super::palette::{KNOWN, ink_on_known};
use super::svg::{Anchor, Canvas, MUTED, TextStyle};
use super::whole::Report;

/// Least probability of each shade, from the darkest on; less has the lightest.
const SHADES: [f64; 5] = [0.95, 0.75, 0.5, 0.25, 0.05];

/// Height of a row of cells, pixels.
const ROW_PX: f64 = 30.0;

/// Widest cell and narrowest with a number, pixels.
const CELL_PX: (f64, f64) = (84.0, 25.0);

/// Space above the cells, and beside them, pixels.
const TOP_PX: f64 = 48.0;
const SIDE_PX: f64 = 14.0;

/// Draws the table; `None` where nothing was resampled.
pub(super) fn ranks(data: &Report) -> Option<Figure> {
    let ranks = data.comparison.ranks.as_ref()?;
    let places = ranks.len() as f64;
    let left = widest_name(data) + 20.0;
    let cell = ((WIDTH - left - SIDE_PX) / places).min(CELL_PX.0);
    let bottom = TOP_PX + ROW_PX * places;
    let mut canvas = Canvas::new(WIDTH, bottom + 14.0);
    let muted = TextStyle::new(Anchor::Start).color(MUTED);
    canvas.text(left, 18.0, "place by score (1 is the best); probability in per cent", muted);
    for place in 0..ranks.len() {
        let x = left + cell * (place as f64 + 0.5);
        canvas.text(x, TOP_PX - 8.0, &(place + 1).to_string(), TextStyle::new(Anchor::Middle));
    }
    for (i, (m, probabilities)) in data.methods.iter().zip(ranks).enumerate() {
        let top = TOP_PX + ROW_PX * i as f64;
        canvas.text(left - 10.0, top + 20.0, &label(data, m), TextStyle::new(Anchor::End));
        for (place, p) in probabilities.iter().enumerate() {
            let shade = SHADES.iter().position(|least| p >= least).unwrap_or(SHADES.len());
            let x = left + cell * place as f64;
            let corners = ((x + 1.0, top + 1.0), (x + cell - 1.0, top + ROW_PX - 1.0));
            canvas.rect(corners.0, corners.1, KNOWN[shade], Some("#c8c8c8"));
            if cell >= CELL_PX.1 && *p > 0.0 {
                let style = TextStyle::new(Anchor::Middle).color(ink_on_known(shade));
                let style = if cell < 34.0 { style.small() } else { style };
                canvas.text(x + cell / 2.0, top + 20.0, &percent(*p), style);
            }
        }
    }
    let description = sentence(data.methods.iter().zip(ranks).map(|(m, probabilities)| {
        let likely = probabilities.iter().enumerate().filter(|(_, p)| **p >= 0.005);
        let likely = likely.map(|(place, p)| format!("place {} {}%", place + 1, percent(*p)));
        format!("{}: {}", label(data, m), likely.collect::<Vec<_>>().join(", "))
    }));
    Some(canvas.figure("ranks", "Probability of every place", &description))
}

fn percent(p: f64) -> String {
    match 100.0 * p {
        p if p <= 0.0 => "0".to_owned(),
        p if p < 0.5 => "<1".to_owned(),
        p if p >= 100.0 - 1e-9 => "100".to_owned(),
        p if p > 99.5 => ">99".to_owned(),
        p => format!("{p:.0}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neither_nothing_nor_all_is_claimed_of_less() {
        let texts = [0.0, 0.0005, 0.254, 0.996, 0.9999, 1.0].map(percent);
        assert_eq!(texts, ["0", "<1", "25", ">99", ">99", "100"]);
    }
}
