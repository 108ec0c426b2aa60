//! Line of sight among prisms on a curved earth: the stretches of the flat one, and a parabola in each.

use num_bigint::BigInt;
use num_rational::Ratio;

use super::{P3, Prism, difference, plan, prism_stretches};

/// An earth that falls away by `drop` times the square of the distance [lattice units], and the flat ground on it.
#[derive(Clone, Debug)]
pub(crate) struct Earth {
    pub(crate) drop: Ratio<BigInt>,
    /// Height of the ground, which is solid [1/1024 m]. Both ends of a link are at or above it.
    pub(crate) ground: Option<i64>,
}

/// Decides whether the link is LoS among the prisms on a curved earth: heights are above a datum that is curved as well.
///
/// From the plane that touches the earth below the UAV a point at distance d is lower by drop d², and the ray is straight. At t it is above
/// a roof by
///
/// ```text
/// z_u + t (z_r - drop L² - z_u)  -  (top - drop t² L²)  =  z_u - top + t rise - drop L² t (1 - t)
/// ```
///
/// which is a parabola in t. A stretch blocks iff that is negative somewhere on it: at one of its ends, or at the vertex.
pub(crate) fn prisms_los_on_earth(prisms: &[Prism], earth: &Earth, uav: P3, receiver: P3) -> bool {
    let whole = |v: i64| Ratio::from(BigInt::from(v));
    let squared: BigInt =
        difference(plan(uav), plan(receiver)).map(|d| BigInt::from(d) * BigInt::from(d)).into_iter().sum();
    let (rise, sag) = (whole(receiver[2]) - whole(uav[2]), &earth.drop * Ratio::from(squared));
    uav == receiver
        || prism_stretches(prisms, plan(uav), plan(receiver)).iter().all(|stretch| {
            let Some(height) = stretch.height.max(earth.ground) else { return true };
            let above = |t: &Ratio<BigInt>| {
                let one = whole(1);
                whole(uav[2]) - whole(height) + t * &rise - &sag * t * (one - t)
            };
            let [from, to] = [&stretch.from, &stretch.to].map(|t| Ratio::new(t.num.to_big(), t.den.to_big()));
            let is_clear = |t: &Ratio<BigInt>| above(t) >= whole(0);
            let vertex = if sag == whole(0) { from.clone() } else { (&sag - &rise) / (&sag * whole(2)) };
            is_clear(&from) && is_clear(&to) && (vertex <= from || vertex >= to || is_clear(&vertex))
        })
}
