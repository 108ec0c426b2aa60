//! Answer of a map: the coverage of one UAV, or of many.

use skyshed_request::Layer;

use super::report::{MapReport, SiteFacts};
use crate::coverage::{HeightLayers, MapOptions, Mapper, MarginSample, Overlay, SiteCoverage, Tally};
use crate::error::{Result, Warning};
use crate::export::Format;
use crate::raster::GeoRef;
use crate::scene::Scene;
use skyshed_request::SaveOptions;

/// Coverage of a scene by each of some UAVs, and by all of them together.
///
/// Masks of single UAVs exist if they were to be kept ([`crate::CoverageRequest::keep_masks`]).
#[derive(Debug, Clone)]
pub struct Coverages {
    pub(crate) scene: Scene,
    pub(crate) sites: Vec<SiteCoverage>,
    /// All masks together, unless there is one UAV whose layers do not need it.
    pub(crate) overlay: Option<Overlay>,
    /// Requested layers; pictures show the first.
    pub(crate) layers: Vec<Layer>,
    pub(crate) report: MapReport,
    /// Reason for the choice of the method, in words.
    pub(crate) why: &'static str,
    /// Options that the maps were made with.
    pub(crate) options: MapOptions,
}

impl Coverages {
    /// Returns each UAV with its position, counts and zones, in the order of the request.
    pub fn sites(&self) -> &[SiteFacts] {
        &self.report.sites
    }

    /// Returns the counts of the union: a receiver is in sight if at least one UAV sees it.
    pub fn union(&self) -> &Tally {
        &self.report.union
    }

    /// Returns the number of UAVs that see each cell; 0 where there is no receiver, too. The shape is
    /// `[n_rows, n_cols]`, columns running fastest, row 0 north. Shares of receivers are shares of
    /// [`Coverages::union`]; [`Coverages::seen_by`] counts them.
    pub fn count(&self) -> Vec<u32> {
        match (&self.overlay, self.sites.first()) {
            (Some(overlay), _) => overlay.count().to_vec(),
            (None, Some(only)) => {
                only.mask.iter().map(|class| u32::from(*class == crate::coverage::class::LOS)).collect()
            }
            (None, None) => vec![0; self.grid().n_cells()],
        }
    }

    /// Returns the numbers of receivers in range that no UAV, one UAV, two UAVs … see, as many as there
    /// are UAVs and one more.
    pub fn seen_by(&self) -> Vec<u64> {
        let mut receivers = vec![0_u64; self.n_uavs() + 1];
        self.count().into_iter().for_each(|n| receivers[n as usize] += 1);
        let seen: u64 = receivers[1..].iter().sum();
        receivers[0] = self.report.union.receivers - seen;
        receivers
    }

    /// Returns the number of the nearest UAV that sees each cell, from 1 in the list of all, 0 where
    /// none does. Shape as [`Coverages::count`]; `None` without the layer [`Layer::BestServer`].
    pub fn best_server(&self) -> Option<&[u32]> {
        self.overlay.as_ref().and_then(Overlay::best_server)
    }

    /// Returns the share of the span of time in which some UAV sees each cell, 0 to 1, NaN where there is no
    /// receiver. Shape as [`Coverages::count`]; `None` without the layer [`Layer::Uptime`].
    pub fn uptime(&self) -> Option<&[f32]> {
        self.overlay.as_ref().and_then(Overlay::uptime)
    }

    /// Returns the longest time in which no UAV sees each cell \[min\], NaN where there is no receiver; the
    /// whole span where none ever does. Shape as [`Coverages::count`]; `None` without the layer [`Layer::Gap`].
    pub fn gap(&self) -> Option<&[f32]> {
        self.overlay.as_ref().and_then(Overlay::gap)
    }

    /// Returns the mask of one UAV, if masks were kept: classes of [`crate::class`], shape as
    /// [`Coverages::count`].
    pub fn mask(&self, site: usize) -> Option<&[u8]> {
        self.sites.get(site).map(|site| site.mask.as_slice()).filter(|mask| !mask.is_empty())
    }

    /// Returns the values of a layer of one UAV, NaN where there is no receiver; shape as
    /// [`Coverages::count`]. Heights and margins are in \[m\]. `None` if the layer was not
    /// requested, and for layers without values, such as `los`.
    pub fn layer(&self, site: usize, layer: Layer) -> Option<&[f32]> {
        let site = self.sites.get(site)?;
        match layer {
            Layer::Margin => site.margin.as_deref(),
            Layer::LeastReceiverHeight => site.least_receiver_height.as_deref(),
            Layer::LeastHeight => site.least_height.as_deref(),
            Layer::Stability => site.stability.as_ref().map(|found| found.turns.as_slice()),
            Layer::Sure => site.sure.as_deref(),
            Layer::PLos => site.p_los.as_deref(),
            _ => None,
        }
    }

    /// Returns the number of UAVs in the whole list, of which these may be a part.
    pub(crate) fn n_uavs(&self) -> usize {
        self.overlay.as_ref().map_or(self.sites.len(), |overlay| overlay.n_uavs().max(self.sites.len()))
    }

    /// Returns the mask of the union: classes of [`crate::class`], shape as [`Coverages::count`].
    /// `None` for a single UAV whose mask was not kept.
    pub fn union_mask(&self) -> Option<&[u8]> {
        self.overlay.as_ref().map(Overlay::union).or_else(|| self.mask(0))
    }

    /// Returns the mask of what every UAV sees: classes of [`crate::class`], shape as
    /// [`Coverages::count`]. `None` without the layer [`Layer::All`].
    pub fn all_mask(&self) -> Option<&[u8]> {
        self.overlay.as_ref().and_then(Overlay::all)
    }

    /// Returns the grid of the cells: shape, extent, reference system. Of a raster and a range it is the
    /// window in range, otherwise that of the scene.
    pub fn grid(&self) -> &GeoRef {
        self.scene.grid()
    }

    /// Returns the warnings.
    pub fn warnings(&self) -> &[Warning] {
        &self.report.facts.warnings
    }

    /// Returns the SHA-256 of the masks. It is equal for equal answers, whatever the machine, the
    /// engine and the number of threads.
    pub fn digest(&self) -> &str {
        &self.report.digest
    }

    /// Returns the document `skyshed/map/1`.
    pub fn document(&self) -> serde_json::Value {
        self.report.document(Some(self.scene.timing.summed()))
    }

    /// Returns margins of receivers of the first UAV, `most` of them at most.
    ///
    /// # Errors
    /// E118.
    pub(crate) fn margin_sample(&self, most: usize) -> Result<MarginSample> {
        let options = MapOptions { layers: HeightLayers::default(), ..self.options.clone() };
        let (mapper, site) = (Mapper::new(&self.scene.field, &options)?, &self.sites[0]);
        Ok(mapper.seen_from(&site.uav)?.margin_sample(site, most))
    }

    /// Returns `true` if a file of a format needs the mask of each UAV.
    pub(crate) fn needs_masks(format: Format, layers: &[Layer], options: &SaveOptions) -> bool {
        match format {
            Format::GeoTiff | Format::Exr | Format::AsciiGrid | Format::Bil | Format::Npz => {
                layers.iter().any(|layer| !layer.is_of_all())
            }
            Format::Kmz | Format::FlatGeobuf => true,
            Format::GeoJson => options.forms.polygons.is_some(),
            _ => false,
        }
    }
}

/// Coverage of a scene by one UAV.
///
/// ```
/// use skyshed::prelude::*;
///
/// let city = Scene::options().size(150.0).open("itu:suburban")?;
/// let uav = Uav::new(75.0, 75.0, Height::agl(60.0));
/// let seen = city.coverage(uav).layers([Layer::Los, Layer::Margin]).run()?;
/// // A margin is zero or more exactly where there is line of sight. At zero the ray touches.
/// let margin = seen.layer(Layer::Margin).expect("it was asked for");
/// assert!(seen.mask().iter().zip(margin).all(|(class, m)| (*class == 1) == (*m >= 0.0)));
/// # Ok::<(), skyshed::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Coverage(pub(crate) Coverages);

impl Coverage {
    /// Returns the share of receivers in line of sight; `None` without any receiver in range.
    pub fn p_los(&self) -> Option<f64> {
        self.tally().p_los()
    }

    /// Returns the number of receivers in range.
    pub fn receivers(&self) -> u64 {
        self.tally().receivers
    }

    /// Returns the counts: cells by class, receivers by elevation angle.
    pub fn tally(&self) -> &Tally {
        &self.0.report.union
    }

    /// Returns the UAV: its position, the place below it, and counts by zone.
    pub fn site(&self) -> &SiteFacts {
        &self.0.report.sites[0]
    }

    /// Returns the class of each cell, of [`crate::class`]: 0 NLoS, 1 LoS, 2 no receiver, 3 out of
    /// range, 255 no data. The shape is `[n_rows, n_cols]` of [`Coverage::grid`], columns running
    /// fastest, row 0 north. Of a raster and a range this grid is the window in range.
    pub fn mask(&self) -> &[u8] {
        &self.0.sites[0].mask
    }

    /// Returns the values of a layer, NaN where there is no receiver; shape as [`Coverage::mask`].
    /// Heights and margins are in \[m\]. `None` if the layer was not requested, and for layers
    /// without values, such as `los`.
    pub fn layer(&self, layer: Layer) -> Option<&[f32]> {
        self.0.layer(0, layer)
    }

    /// Returns the grid of the cells: shape, extent, reference system. Of a raster and a range it is the
    /// window in range, otherwise that of the scene.
    pub fn grid(&self) -> &GeoRef {
        self.0.grid()
    }

    /// Returns the warnings.
    pub fn warnings(&self) -> &[Warning] {
        self.0.warnings()
    }

    /// Returns the SHA-256 of the mask. It is equal for equal answers, whatever the machine, the
    /// engine and the number of threads.
    pub fn digest(&self) -> &str {
        self.0.digest()
    }

    /// Returns the document `skyshed/map/1`.
    pub fn document(&self) -> serde_json::Value {
        self.0.document()
    }
}
