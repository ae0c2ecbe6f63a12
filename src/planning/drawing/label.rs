//! Labels that keep out of each other's way.

use super::sheet::WIDTH_MM;
use super::svg::{Spot, spot};

/// The room that labels have taken: middle, half width and half height in mm of the sheet.
#[derive(Debug, Default)]
pub struct Labels {
    taken: Vec<(Spot, f64, f64)>,
}

impl Labels {
    /// Takes the room of a mark, whether or not it is free.
    pub fn take(&mut self, middle: Spot, half: f64) {
        self.taken.push((middle, half, half));
    }

    /// Takes the room of a text at the first of the places, each the middle of a text, that is free and on the
    /// sheet.
    pub fn place(&mut self, places: &[Spot], width: f64, height: f64) -> Option<Spot> {
        let (half_width, half_height) = (width / 2.0, height / 2.0);
        let free = |middle: &&Spot| {
            let on_sheet = middle.x - half_width >= 0.0 && middle.x + half_width <= WIDTH_MM;
            on_sheet
                && self.taken.iter().all(|(other, w, h)| {
                    (other.x - middle.x).abs() >= w + half_width
                        || (other.y - middle.y).abs() >= h + half_height
                })
        };
        let place = *places.iter().find(free)?;
        self.taken.push((place, half_width, half_height));
        Some(place)
    }
}

/// The baseline of a text whose middle stands at a place.
#[must_use]
pub fn baseline(middle: Spot, size_mm: f64) -> Spot {
    /// Half of a capital's height over the size of its font.
    const HALF_CAPITAL: f64 = 0.36;
    spot(middle.x, middle.y + HALF_CAPITAL * size_mm)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_label_takes_the_first_free_place_or_none() {
        let mut labels = Labels::default();
        labels.take(spot(50.0, 50.0), 1.0);
        let places = [spot(50.5, 50.0), spot(50.0, 53.0)];
        assert_eq!(labels.place(&places, 4.0, 2.0), Some(places[1]));
        assert_eq!(labels.place(&places, 4.0, 2.0), None);
        assert_eq!(labels.place(&[spot(1.0, 10.0)], 4.0, 2.0), None, "not on the sheet");
    }
}
