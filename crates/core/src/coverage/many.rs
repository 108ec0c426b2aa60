//! Maps of many UAVs over one scene: several at once, each shared by the threads that are free.

use rayon::prelude::*;

use super::{Control, Mapper, Overlay, SiteCoverage, Uav};
use crate::error::Result;

/// How long the masks and layers of maps are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KeepMasks {
    /// With the maps.
    Always,
    /// Until all has been told of a map, so that memory does not grow with the number of UAVs: at most [`maps_at_once`]
    /// are held.
    UntilTold,
    /// The mask of the only UAV is handed over part by part and never held, and layers of heights are not made; of several
    /// UAVs as `UntilTold`.
    Never,
}

/// The maps of some UAVs, in their order.
#[derive(Debug, Clone)]
pub struct ManyMaps {
    /// The maps; without masks and layers where they were not to be kept.
    pub sites: Vec<SiteCoverage>,
    /// All masks laid over each other, for more than one UAV.
    pub overlay: Option<Overlay>,
}

impl Mapper<'_> {
    /// Maps what each of some UAVs sees. Calls `each_part` with one part of the masks after another, in the order of the UAVs
    /// and from the north, and `each` with every map once its mask is complete.
    ///
    /// The outcome does not depend on the number of threads.
    pub fn map_many(
        &self,
        uavs: &[Uav],
        keep: KeepMasks,
        control: &Control,
        mut each_part: impl FnMut(&[u8]) + Send,
        mut each: impl FnMut(&SiteCoverage),
    ) -> Result<ManyMaps> {
        let mut sites: Vec<SiteCoverage> = Vec::with_capacity(uavs.len());
        let mut overlay = (uavs.len() > 1).then(|| Overlay::new(self.field.grid().n_cells()));
        for chunk in uavs.chunks(maps_at_once()) {
            let maps: Vec<SiteCoverage> = match chunk {
                [one] => {
                    let is_held = uavs.len() > 1 || keep != KeepMasks::Never;
                    vec![self.map_in_parts(one, control, Some(&mut each_part), is_held)?]
                }
                _ => chunk.par_iter().map(|uav| self.map(uav, control)).collect::<Result<_>>()?,
            };
            for mut site in maps {
                if chunk.len() > 1 {
                    each_part(&site.mask);
                }
                each(&site);
                if let Some(overlay) = &mut overlay {
                    overlay.add(&site.mask);
                }
                if keep != KeepMasks::Always {
                    site = SiteCoverage::of_tally(&site.uav, site.tally);
                }
                sites.push(site);
            }
        }
        Ok(ManyMaps { sites, overlay })
    }
}

/// How many maps are made at once: enough to keep every thread busy where maps are small.
pub fn maps_at_once() -> usize {
    2 * rayon::current_num_threads()
}
