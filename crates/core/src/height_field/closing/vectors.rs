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

/// Returns a number from 0 to 4 that grows with the direction of a vector, from east
/// counter-clockwise.
pub(super) fn turn([x, y]: Place) -> f64 {
    let share = y / (x.abs() + y.abs());
    match (x < 0.0, y < 0.0) {
        (false, false) => share,
        (true, _) => 2.0 - share,
        (false, true) => 4.0 + share,
    }
}

/// Returns the vector of length 1 that has a [turn] of 0 to 4.
pub(super) fn direction(turn: f64) -> Place {
    let in_quarter = |t: f64| [1.0 - t, t];
    let [x, y] = match turn {
        ..1.0 => in_quarter(turn),
        ..2.0 => in_quarter(turn - 1.0),
        ..3.0 => in_quarter(turn - 2.0),
        _ => in_quarter(turn - 3.0),
    };
    let far = length([x, y]);
    let (x, y) = (x / far, y / far);
    match turn {
        ..1.0 => [x, y],
        ..2.0 => [-y, x],
        ..3.0 => [-x, -y],
        _ => [y, -x],
    }
}

/// An edge: an end, its direction, a normal of length 1, its length.
#[derive(Clone, Copy)]
pub(super) struct Edge {
    pub(super) from: Place,
    pub(super) along: Place,
    pub(super) normal: Place,
    pub(super) length: f64,
}

impl Edge {
    pub(super) fn between(from: Place, to: Place) -> Edge {
        let d = minus(to, from);
        let length = length(d);
        let along = [d[0] / length, d[1] / length];
        Edge { from, along, normal: [-along[1], along[0]], length }
    }

    pub(super) fn ends(&self) -> [Place; 2] {
        [self.from, self.place(self.length, 0.0)]
    }

    /// Returns a place along the edge and to its left.
    pub(super) fn seen(&self, place: Place) -> (f64, f64) {
        let d = minus(place, self.from);
        (dot(d, self.along), dot(d, self.normal))
    }

    /// Returns the place so far along the edge and so far to its left.
    pub(super) fn place(&self, t: f64, h: f64) -> Place {
        plus(plus(self.from, t, self.along), h, self.normal)
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
        for k in 0..=400 {
            let t = f64::from(k) / 100.0;
            assert!((turn(direction(t)) - t % 4.0).abs() < 1e-15 && (length(direction(t)) - 1.0).abs() < 1e-15, "{t}");
        }
    }
}
