//! The palette: one meaning per color, readable with any color vision.
//!
//! The two class colors are from Okabe and Ito's set and are fixed: blue is line of sight, orange
//! is none. Ramps of unsigned quantities change monotonically in lightness (a test measures it), so
//! that they survive a gray printer. The diverging ramp runs from orange over near-white to blue,
//! so that a positive margin has the color of line of sight.
//!
//! Averages of colors are taken in linear light. The transfer curve is tabulated with additions,
//! products and quotients only, without `powf`. Library functions differ in the last bit between
//! platforms, and pictures must not.

use std::sync::OnceLock;

/// A color with 8 bits each of red, green and blue in the sRGB space.
pub(crate) type Rgb = [u8; 3];

/// Line of sight.
pub(crate) const LOS: Rgb = [0x00, 0x72, 0xB2];
/// No line of sight.
pub(crate) const NLOS: Rgb = [0xE6, 0x9F, 0x00];
/// Buildings of unknown height.
pub(crate) const BUILDING: Rgb = [0xC3, 0xC6, 0xC9];
/// Cells beyond the radius.
pub(crate) const OUT_OF_RANGE: Rgb = [0xE9, 0xED, 0xF0];
/// Stripes over cells without data.
pub(crate) const HATCH: Rgb = [0xC2, 0xC8, 0xCE];
/// Open ground on a city plan.
pub(crate) const OPEN_GROUND: Rgb = [0xF3, 0xF1, 0xEB];
/// Colors of a cell as two UAVs see it: neither, only the first (lost), only the second (gained),
/// both. Changes are strong, agreement is pale, and all four differ in lightness.
pub(crate) const PAIR: [Rgb; 4] = [[0xF6, 0xEE, 0xDF], [0xD5, 0x5E, 0x00], [0x00, 0x2F, 0x4C], [0x9C, 0xC9, 0xE6]];
/// Colors of a cell by which of up to four UAVs see it: none, only the first to fourth, several.
/// All differ in lightness.
pub const ONLY_COLORS: [Rgb; 6] =
    [NLOS, LOS, [0xF0, 0xE4, 0x42], [0x88, 0x22, 0x55], [0x88, 0xCC, 0xEE], [0x1B, 0x1F, 0x24]];
/// Colors of a cell for one UAV of many: seen by none, only by other UAVs, by this and others, only
/// by this. All differ in lightness.
pub const ALONE_COLORS: [Rgb; 4] = [NLOS, [0xFB, 0xFA, 0xF6], [0xB4, 0xDB, 0xF2], LOS];
/// Colors of a cell by the least height that sees it: classes from the lowest up, then none. All
/// differ in lightness.
pub const LEAST_HEIGHT_COLORS: [Rgb; 6] = [HEIGHT[0], HEIGHT[1], HEIGHT[3], HEIGHT[4], HEIGHT[5], NLOS];
/// Colors of a cell by certainty of line of sight: never, surely, perhaps. All differ in lightness.
pub const SURE_COLORS: [Rgb; 3] = [NLOS, LOS, [0xFB, 0xFA, 0xF6]];
/// Paper.
pub(crate) const WHITE: Rgb = [0xFF, 0xFF, 0xFF];

/// Text and frames.
pub(crate) const INK: &str = "#1B1F24";
/// Secondary text.
pub(crate) const MUTED: &str = "#545D68";
/// Hairlines.
pub(crate) const HAIRLINE: &str = "#AEB6BF";

/// Grays of the lowest and of the tallest building on a map.
const BUILDING_TONES: [Rgb; 2] = [[0xDE, 0xE0, 0xE2], [0x7D, 0x81, 0x86]];

/// Viridis (Smith, van der Walt, 2015; CC0) at seventeen equal steps.
const VIRIDIS: [Rgb; 17] = colors([
    0x440154, 0x48186A, 0x472D7B, 0x424086, 0x3B528B, 0x33638D, 0x2C728E, 0x26828E, 0x21918C, 0x1FA088, 0x28AE80,
    0x3FBC73, 0x5EC962, 0x84D44B, 0xADDC30, 0xD8E219, 0xFDE725,
]);
/// Colors by how many of eight moves change the answer. None is cream, then Inferno (Smith, van der
/// Walt, 2015; CC0) from light to dark.
pub(crate) const TURNS: [Rgb; 9] =
    colors([0xF6F1E0, 0xF9C932, 0xF98E09, 0xE55C30, 0xBB3754, 0x89226A, 0x57106E, 0x2D0B59, 0x08051D]);
const DIVERGING: [Rgb; 5] = [[0x7F, 0x4A, 0x00], NLOS, [0xF6, 0xF4, 0xEF], LOS, [0x00, 0x2F, 0x4C]];
const SEEN: [Rgb; 4] = [[0xB4, 0xDB, 0xF2], [0x5A, 0xA9, 0xDB], LOS, [0x00, 0x3A, 0x5E]];
const HEIGHT: [Rgb; 6] = colors([0xD3EECD, 0x94D9BE, 0x4FB9BE, 0x3B8DB8, 0x455CA0, 0x321D4F]);

/// Converts colors written as one number each, 0xRRGGBB.
const fn colors<const N: usize>(numbers: [u32; N]) -> [Rgb; N] {
    let mut colors = [[0; 3]; N];
    let mut k = 0;
    while k < N {
        let [_, rgb @ ..] = numbers[k].to_be_bytes();
        colors[k] = rgb;
        k += 1;
    }
    colors
}

/// A continuous color scale over 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ramp {
    /// Dark violet to yellow, for unsigned quantities.
    Sequential,
    /// Orange, near-white, blue, for signed quantities with 0 in the middle.
    Diverging,
    /// Pale to deep blue, for the number of UAVs that see a cell.
    Seen,
    /// Pale green to deep violet, for building heights.
    Height,
    /// Light to dark gray, for buildings under a mask.
    BuildingTone,
}

impl Ramp {
    /// Returns the color at `t`, clamped to 0 to 1.
    pub(crate) fn at(self, t: f64) -> Rgb {
        let anchors: &[Rgb] = match self {
            Self::Sequential => &VIRIDIS,
            Self::Diverging => &DIVERGING,
            Self::Seen => &SEEN,
            Self::Height => &HEIGHT,
            Self::BuildingTone => &BUILDING_TONES,
        };
        let last = anchors.len() - 1;
        let position = t.clamp(0.0, 1.0) * last as f64;
        let i = index(position, last - 1);
        mix(anchors[i], anchors[i + 1], position - i as f64)
    }

    /// Returns `n` colors at equal steps.
    pub(crate) fn steps(self, n: u8) -> Vec<Rgb> {
        (0..n).map(|k| self.at(f64::from(k) / f64::from(n - 1))).collect()
    }
}

/// Returns the colors of cells by how many of `n_sites` UAVs see them, from none to all. None is
/// orange, one of one is blue, and other numbers run from pale to deep blue.
pub(crate) fn count_colors(n_sites: u32) -> Vec<Rgb> {
    let color = |seen| match (seen, n_sites) {
        (0, _) => NLOS,
        (_, 1) => LOS,
        _ => Ramp::Seen.at(f64::from(seen - 1) / f64::from(n_sites - 1)),
    };
    (0..=n_sites).map(color).collect()
}

/// Mixes `a` and `b` in the sRGB space; `t` = 0 gives `a`.
pub(crate) fn mix(a: Rgb, b: Rgb, t: f64) -> Rgb {
    std::array::from_fn(|k| byte(f64::from(a[k]) + (f64::from(b[k]) - f64::from(a[k])) * t))
}

/// Multiplies a color by `factor`; above 1 the excess moves it towards white.
pub(crate) fn shade(color: Rgb, factor: f64) -> Rgb {
    if factor <= 1.0 { mix([0, 0, 0], color, factor.max(0.0)) } else { mix(color, WHITE, (factor - 1.0).min(1.0)) }
}

/// Writes a color in SVG's form, `#RRGGBB`.
pub(crate) fn hex(color: Rgb) -> String {
    format!("#{:02X}{:02X}{:02X}", color[0], color[1], color[2])
}

/// Returns the SVG attribute that fills with a color.
pub(crate) fn fill(color: Rgb) -> String {
    format!("fill=\"{}\"", hex(color))
}

/// Returns the text color, white or ink, that contrasts more with a color.
pub(crate) fn ink_on(color: Rgb) -> &'static str {
    // Contrast with white and with black is equal at this lightness (WCAG 2.2).
    if lightness(color) > 0.179 { INK } else { "#FFFFFF" }
}

/// Returns the relative luminance, 0 for black to 1 for white.
fn lightness(color: Rgb) -> f64 {
    let [r, g, b] = Light::tables().linear(color).map(|c| f64::from(c) / f64::from(FULL_LIGHT));
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Rounds a channel value to a byte.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the range of a byte first")]
pub(crate) fn byte(value: f64) -> u8 {
    (value + 0.5).clamp(0.0, 255.0) as u8
}

/// Truncates a non-negative position to an index of at most `last`.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the range of indices first")]
pub(crate) fn index(position: f64, last: usize) -> usize {
    position.clamp(0.0, last as f64) as usize
}

/// White in linear light, in the 12-bit units of [`Light`].
pub(crate) const FULL_LIGHT: u32 = 4095;

/// Tables between sRGB bytes and linear light in 12 bits; each byte survives the round trip.
#[derive(Debug)]
pub(crate) struct Light {
    to_linear: [u16; 256],
    to_srgb: Vec<u8>,
}

impl Light {
    /// Returns the tables, made on first use.
    pub(crate) fn tables() -> &'static Self {
        static TABLES: OnceLock<Light> = OnceLock::new();
        TABLES.get_or_init(|| {
            let to_linear: [u16; 256] = std::array::from_fn(|code| {
                let linear = srgb_to_linear(code as f64 / 255.0) * f64::from(FULL_LIGHT);
                u16::try_from(index(linear + 0.5, 4095)).expect("4095 fits 16 bits")
            });
            let mut code = 0_usize;
            let to_srgb = (0..=4095_u16)
                .map(|linear| {
                    while code < 255 && to_linear[code + 1].abs_diff(linear) <= to_linear[code].abs_diff(linear) {
                        code += 1;
                    }
                    u8::try_from(code).expect("codes end at 255")
                })
                .collect();
            Self { to_linear, to_srgb }
        })
    }

    /// Returns the linear light of a color.
    pub(crate) fn linear(&self, color: Rgb) -> [u32; 3] {
        color.map(|c| u32::from(self.to_linear[usize::from(c)]))
    }

    /// Returns the byte nearest to a linear light of at most [`FULL_LIGHT`].
    pub(crate) fn srgb(&self, linear: u32) -> u8 {
        self.to_srgb[linear.min(FULL_LIGHT) as usize]
    }
}

/// Evaluates the sRGB transfer curve (IEC 61966-2-1). x^2.4 is x² · (x²)^(1/5), the root by
/// Newton's method.
fn srgb_to_linear(code: f64) -> f64 {
    if code <= 0.04045 {
        return code / 12.92;
    }
    let x = (code + 0.055) / 1.055;
    let square = x * x;
    let mut root = 1.0_f64;
    for _ in 0..40 {
        let fourth = root * root * root * root;
        root -= (root * fourth - square) / (5.0 * fourth);
    }
    square * root
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_survives_linear_light() {
        let light = Light::tables();
        for code in 0..=255_u8 {
            assert_eq!(light.srgb(light.linear([code; 3])[0]), code);
        }
    }

    #[test]
    fn the_curve_passes_published_values() {
        assert!((srgb_to_linear(0.5) - 0.214_041_140_5).abs() < 1e-9);
        assert!((srgb_to_linear(1.0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn ramps_for_unsigned_quantities_are_monotonic_in_lightness() {
        for (ramp, sign) in
            [(Ramp::Sequential, 1.0), (Ramp::Seen, -1.0), (Ramp::Height, -1.0), (Ramp::BuildingTone, -1.0)]
        {
            for k in 0..64 {
                let [a, b] = [k, k + 1].map(|k| lightness(ramp.at(f64::from(k) / 64.0)));
                assert!((b - a) * sign > 0.0, "{ramp:?} at step {k}: {a} to {b}");
            }
        }
    }

    #[test]
    fn the_classes_of_a_picture_differ_in_lightness() {
        // WCAG's contrast of neighbors; buildings are gray, so hue tells them apart.
        let classes = [&ONLY_COLORS[..], &ALONE_COLORS, &LEAST_HEIGHT_COLORS];
        for (colors, least) in classes.map(|colors| (colors, 1.2)).into_iter().chain([(&PAIR[..], 1.4), (&TURNS, 1.0)])
        {
            let mut of_all: Vec<f64> = colors.iter().map(|color| lightness(*color)).collect();
            of_all.sort_by(f64::total_cmp);
            for pair in of_all.windows(2) {
                assert!((pair[1] + 0.05) / (pair[0] + 0.05) > least, "{of_all:?}");
            }
        }
        assert!(TURNS.map(lightness).is_sorted_by(|a, b| a > b), "the more moves turn an answer the darker it is");
    }

    #[test]
    fn class_colors_are_the_fixed_ones() {
        assert_eq!((hex(LOS).as_str(), hex(NLOS).as_str()), ("#0072B2", "#E69F00"));
        assert_eq!(Ramp::Diverging.at(0.75), LOS);
        // The colors of files are those of pictures.
        use skyshed_core::coverage::class;
        for (value, color) in [
            (class::NLOS, NLOS),
            (class::LOS, LOS),
            (class::NOT_A_RECEIVER, BUILDING),
            (class::OUT_OF_RANGE, OUT_OF_RANGE),
        ] {
            assert_eq!(class::color(value)[..3], color);
        }
    }
}
