//! Small geometry of shadows, on the lattice and in doubles.

/// Increase of a bearing in one turn around the UAV.
pub(super) const FULL_TURN: f64 = 4.0;

/// Converts a number to a double: exact below 2^53, rounded once above.
#[inline(always)]
pub(super) fn as_f64<T: TryInto<i64>>(v: T) -> f64 {
    #[expect(
        clippy::cast_precision_loss,
        reason = "positions and counts are below 2^53, products of two within a margin"
    )]
    let v = v.try_into().unwrap_or(i64::MAX) as f64;
    v
}

/// Returns the step from `b` to `a`.
#[inline(always)]
pub(super) fn sub(a: [i64; 2], b: [i64; 2]) -> [i64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

/// Returns twice the area that two steps span, positive counterclockwise.
#[inline(always)]
pub(super) fn cross(a: [i64; 2], b: [i64; 2]) -> i64 {
    a[0] * b[1] - a[1] * b[0]
}

/// Returns the bearing of a position: it rises counterclockwise from 0 in the south by 1 per
/// quadrant. It is NaN for `(0, 0)`.
pub(super) fn bearing(x: i64, y: i64) -> f64 {
    let (x, y) = (as_f64(x), as_f64(y));
    let slope = y / (x.abs() + y.abs());
    if x >= 0.0 { 1.0 + slope } else { 3.0 - slope }
}

/// Returns the square of the distance of a box (west, south, east, north) from a point \[lattice
/// steps\].
pub(super) fn distance_squared(bounds: [i32; 4], (x, y): (i64, i64)) -> u64 {
    let beyond = |low: i32, high: i32, at: i64| (i64::from(low) - at).max(at - i64::from(high)).max(0).unsigned_abs();
    let [west, south, east, north] = bounds;
    let (dx, dy) = (beyond(west, east, x), beyond(south, north, y));
    dx * dx + dy * dy
}
