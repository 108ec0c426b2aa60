//! Counts over a mask: receivers, those in line of sight, and the same by elevation angle.

use super::class;

/// Width of an elevation band \[deg\].
pub const BAND_DEGREES: i32 = 10;

/// Bands from −90° to 90°.
const N_BANDS: usize = 18;

/// Receivers whose elevation angle to the UAV lies in `from_deg ≤ θ < to_deg` (90° in the last band).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ElevationBand {
    /// Lower end \[deg\].
    pub from_deg: i32,
    /// Upper end \[deg\].
    pub to_deg: i32,
    /// Receivers in the band.
    pub receivers: u64,
    /// Of these, in line of sight.
    pub los: u64,
}

/// Counts of one map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// Receivers in range: classes 0 and 1.
    pub receivers: u64,
    /// Receivers in line of sight: class 1.
    pub los: u64,
    /// Cells of class 2.
    pub not_receivers: u64,
    /// Cells of class 3.
    pub out_of_range: u64,
    /// Cells of class 255.
    pub nodata: u64,
    bands: [(u64, u64); N_BANDS],
}

impl Tally {
    /// Counts one cell; `rise` and `distance` \[same unit\] place the UAV as seen from a receiver.
    #[inline]
    pub(super) fn add(&mut self, class: u8, rise: f64, distance: f64) {
        match class {
            class::NLOS | class::LOS => {
                let los = u64::from(class == class::LOS);
                self.receivers += 1;
                self.los += los;
                let band = &mut self.bands[band_of(rise, distance)];
                band.0 += 1;
                band.1 += los;
            }
            class::NOT_A_RECEIVER => self.not_receivers += 1,
            class::OUT_OF_RANGE => self.out_of_range += 1,
            _ => self.nodata += 1,
        }
    }

    /// Counts a mask, without elevation bands.
    pub fn of_mask(mask: &[u8]) -> Self {
        let mut counts = [0_u64; 256];
        mask.iter().for_each(|c| counts[*c as usize] += 1);
        let of = |c: u8| counts[c as usize];
        Tally {
            receivers: of(class::NLOS) + of(class::LOS),
            los: of(class::LOS),
            not_receivers: of(class::NOT_A_RECEIVER),
            out_of_range: of(class::OUT_OF_RANGE),
            nodata: of(class::NODATA),
            ..Tally::default()
        }
    }

    /// The sum of two tallies of disjoint cells.
    #[must_use]
    pub fn plus(mut self, other: &Tally) -> Self {
        self.receivers += other.receivers;
        self.los += other.los;
        self.not_receivers += other.not_receivers;
        self.out_of_range += other.out_of_range;
        self.nodata += other.nodata;
        for (a, b) in self.bands.iter_mut().zip(&other.bands) {
            a.0 += b.0;
            a.1 += b.1;
        }
        self
    }

    /// P_LoS: the share of receivers in line of sight, `None` without a receiver.
    #[expect(clippy::cast_precision_loss, reason = "counts of cells are far below 2^53")]
    pub fn p_los(&self) -> Option<f64> {
        (self.receivers > 0).then(|| self.los as f64 / self.receivers as f64)
    }

    /// Why there is no P_LoS.
    pub fn reason(&self) -> &'static str {
        if self.out_of_range > 0 && self.not_receivers == 0 && self.nodata == 0 {
            "no receiver in range"
        } else if self.not_receivers > 0 {
            "every cell in range is a building or outside the chosen receivers"
        } else {
            "no cell with known heights in range"
        }
    }

    /// The bands that hold receivers, and all from 0° to 90°, lowest first.
    pub fn elevation_bands(&self) -> Vec<ElevationBand> {
        (0..N_BANDS)
            .filter_map(|k| {
                let from_deg = i32::try_from(k).ok()? * BAND_DEGREES - 90;
                let (receivers, los) = self.bands[k];
                (receivers > 0 || from_deg >= 0).then_some(ElevationBand {
                    from_deg,
                    to_deg: from_deg + BAND_DEGREES,
                    receivers,
                    los,
                })
            })
            .collect()
    }
}

/// The band of the angle whose tangent is `rise/distance`, decided by products with the tangents of the band edges.
#[inline]
fn band_of(rise: f64, distance: f64) -> usize {
    /// tan 10°, 20° … 80°.
    const TANGENTS: [f64; 8] = [
        0.176_326_980_708_464_97,
        0.363_970_234_266_202_36,
        0.577_350_269_189_625_8,
        0.839_099_631_177_28,
        1.191_753_592_594_21,
        1.732_050_807_568_877_2,
        2.747_477_419_454_622,
        5.671_281_819_617_709,
    ];
    let steps = TANGENTS.iter().filter(|t| rise.abs() >= **t * distance).count();
    if rise >= 0.0 {
        9 + steps
    } else {
        // Below the horizon the band's lower end is included: −10° belongs to −10…0.
        let inside = TANGENTS.iter().filter(|t| rise.abs() > **t * distance).count();
        8 - inside
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_are_half_open_and_hold_ninety_degrees() {
        assert_eq!(band_of(0.0, 1.0), 9);
        assert_eq!(band_of(1.0, 1.0), 13);
        assert_eq!(band_of(1.0, 0.0), 17);
        assert_eq!(band_of(-0.1, 1.0), 8);
        assert_eq!(band_of(-1.0, 0.0), 0);
        let tangents: Vec<f64> = (1..9).map(|k| (f64::from(k) * 10.0).to_radians().tan()).collect();
        for (k, t) in tangents.iter().enumerate() {
            assert_eq!(band_of(t * 1.000_001, 1.0), 10 + k);
            assert_eq!(band_of(t * 0.999_999, 1.0), 9 + k);
        }
    }

    #[test]
    fn no_receiver_gives_no_probability() {
        let tally = Tally::of_mask(&[2, 2, 255]);
        assert_eq!(tally.p_los(), None);
        assert_eq!(Tally::of_mask(&[0, 1, 1, 3]).p_los(), Some(2.0 / 3.0));
    }
}
