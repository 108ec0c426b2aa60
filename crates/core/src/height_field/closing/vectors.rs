//! Vectors of the plane, in doubles.

/// A position or a difference of two \[lattice steps\].
pub(super) type Place = [f64; 2];

pub(super) fn minus(a: Place, b: Place) -> Place {
    [a[0] - b[0], a[1] - b[1]]
}

pub(super) fn plus(a: Place, t: f64, u: Place) -> Place {
    [a[0] + t * u[0], a[1] + t * u[1]]
}

pub(super) fn dot(a: Place, b: Place) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

pub(super) fn cross(a: Place, b: Place) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

pub(super) fn length(a: Place) -> f64 {
    dot(a, a).sqrt()
}

/// What grows with the direction of a vector, from east counter-clockwise: 0 to 4.
pub(super) fn turn([x, y]: Place) -> f64 {
    let share = y / (x.abs() + y.abs());
    match (x < 0.0, y < 0.0) {
        (false, false) => share,
        (true, _) => 2.0 - share,
        (false, true) => 4.0 + share,
    }
}

/// The direction in the middle between two, counter-clockwise from the first; opposite if they are one.
pub(super) fn between(first: Place, last: Place) -> Place {
    let (a, b) = (length(first), length(last));
    let sum = [first[0] / a + last[0] / b, first[1] / a + last[1] / b];
    let side = cross(first, last);
    if side > 0.0 {
        sum
    } else if side < 0.0 {
        [-sum[0], -sum[1]]
    } else if dot(first, last) > 0.0 {
        [-first[0], -first[1]]
    } else {
        [-first[1], first[0]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_turn_counter_clockwise() {
        let circle =
            [[1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [-1.0, 1.0], [-1.0, 0.0], [-1.0, -1.0], [0.0, -1.0], [1.0, -1.0]];
        assert!(circle.map(turn).is_sorted_by(|a, b| a < b));
        assert!(length(minus(between([1.0, 0.0], [0.0, 2.0]), [1.0, 1.0])) < 1e-15);
        assert!(cross(between([0.0, 1.0], [1.0, 0.0]), [-1.0, -1.0]).abs() < 1e-15);
        assert!(length(minus(between([1.0, 0.0], [-3.0, 0.0]), [0.0, 1.0])) < 1e-15);
    }
}
