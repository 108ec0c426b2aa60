//! What UAVs see: the answer of a map.

use skyshed_request::Layer;

use super::report::{MapReport, SiteFacts};
use crate::coverage::{HeightLayers, MapOptions, Mapper, MarginSample, Overlay, SiteCoverage, Tally};
use crate::error::{Result, Warning};
use crate::export::Format;
use crate::raster::GeoRef;
use crate::scene::Scene;
use skyshed_request::SaveOptions;

/// What each of some UAVs sees of a scene, and all of them together.
///
/// The masks of single UAVs are there if they were to be kept ([`crate::CoverageRequest::keep_masks`]).
#[derive(Debug, Clone)]
pub struct Coverages {
    pub(crate) scene: Scene,
    pub(crate) sites: Vec<SiteCoverage>,
    /// All masks together: for more than one UAV and for none, and where a layer tells of that.
    pub(crate) overlay: Option<Overlay>,
    /// The layers that were asked for; pictures show the first.
    pub(crate) layers: Vec<Layer>,
    pub(crate) report: MapReport,
    /// Why the method was chosen.
    pub(crate) why: &'static str,
    /// How the maps were made.
    pub(crate) options: MapOptions,
}

impl Coverages {
    /// Each UAV with its position, counts and zones, in the order in which they were given.
    pub fn sites(&self) -> &[SiteFacts] {
        &self.report.sites
    }

    /// The counts of what at least one UAV sees.
    pub fn union(&self) -> &Tally {
        &self.report.union
    }

    /// How many UAVs see each cell: shape `[n_rows, n_cols]`, columns running fastest, row 0 north; 0 where there is no
    /// receiver.
    pub fn count(&self) -> Vec<u32> {
        match (&self.overlay, self.sites.first()) {
            (Some(overlay), _) => overlay.count().to_vec(),
            (None, Some(only)) => {
                only.mask.iter().map(|class| u32::from(*class == crate::coverage::class::LOS)).collect()
            }
            (None, None) => vec![0; self.grid().n_cells()],
        }
    }

    /// Returns the number of the nearest UAV that sees each cell, from 1 in the list of all, 0 where none does; `None` if
    /// [`Layer::BestServer`] was not asked for. Shape as [`Coverages::count`].
    pub fn best_server(&self) -> Option<&[u32]> {
        self.overlay.as_ref().and_then(Overlay::best_server)
    }

    /// The mask of one UAV, if masks were kept: classes of [`crate::class`], shape as [`Coverages::count`].
    pub fn mask(&self, site: usize) -> Option<&[u8]> {
        self.sites.get(site).map(|site| site.mask.as_slice()).filter(|mask| !mask.is_empty())
    }

    /// A layer of heights of one UAV \[m\], NaN where there is no receiver; shape as [`Coverages::count`]. `None` if it was
    /// not asked for, and for layers that hold no heights.
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

    /// How many UAVs there are in the list of all, of which these are some.
    pub(crate) fn n_uavs(&self) -> usize {
        self.overlay.as_ref().map_or(self.sites.len(), |overlay| overlay.n_uavs().max(self.sites.len()))
    }

    /// What at least one UAV sees: classes of [`crate::class`], shape as [`Coverages::count`]; `None` without a UAV.
    pub fn union_mask(&self) -> Option<&[u8]> {
        self.overlay.as_ref().map(Overlay::union).or_else(|| self.mask(0))
    }

    /// The cells: shape, extent, reference system.
    pub fn grid(&self) -> &GeoRef {
        self.scene.grid()
    }

    /// What was odd.
    pub fn warnings(&self) -> &[Warning] {
        &self.report.facts.warnings
    }

    /// SHA-256 of the masks: equal for equal answers, whatever the machine, the engine and the number of threads.
    pub fn digest(&self) -> &str {
        &self.report.digest
    }

    /// The document `skyshed/map/1`.
    pub fn document(&self) -> serde_json::Value {
        self.report.document(Some(self.scene.timing.summed()))
    }

    /// Margins of the receivers of the first UAV, of so many at most.
    ///
    /// # Errors
    /// E118.
    pub(crate) fn margin_sample(&self, most: usize) -> Result<MarginSample> {
        let options = MapOptions { layers: HeightLayers::default(), ..self.options.clone() };
        let (mapper, site) = (Mapper::new(&self.scene.field, &options)?, &self.sites[0]);
        Ok(mapper.seen_from(&site.uav)?.margin_sample(site, most))
    }

    /// Whether a file of a format tells of each UAV cell by cell.
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

/// What one UAV sees of a scene.
///
/// ```
/// use skyshed::prelude::*;
///
/// let city = Scene::options().size(150.0).open("itu:suburban")?;
/// let uav = Uav::new(75.0, 75.0, Height::agl(60.0));
/// let seen = city.coverage(uav).layers([Layer::Los, Layer::Margin]).run()?;
/// // A margin is zero or more exactly where there is line of sight; zero means that the ray touches.
/// let margin = seen.layer(Layer::Margin).expect("it was asked for");
/// assert!(seen.mask().iter().zip(margin).all(|(class, m)| (*class == 1) == (*m >= 0.0)));
/// # Ok::<(), skyshed::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Coverage(pub(crate) Coverages);

impl Coverage {
    /// The share of receivers in line of sight; `None` without any receiver in range.
    pub fn p_los(&self) -> Option<f64> {
        self.tally().p_los()
    }

    /// How many receivers there are in range.
    pub fn receivers(&self) -> u64 {
        self.tally().receivers
    }

    /// Cells by class, receivers by elevation angle.
    pub fn tally(&self) -> &Tally {
        &self.0.report.union
    }

    /// The UAV: where it is and hovers over, counts by zone.
    pub fn site(&self) -> &SiteFacts {
        &self.0.report.sites[0]
    }

    /// The answer for each cell: classes of [`crate::class`] (0 NLoS, 1 LoS, 2 no receiver, 3 out of range, 255 no data),
    /// shape `[n_rows, n_cols]`, columns running fastest, row 0 north.
    pub fn mask(&self) -> &[u8] {
        &self.0.sites[0].mask
    }

    /// A layer of heights \[m\], NaN where there is no receiver; shape as [`Coverage::mask`]. `None` if it was not
    /// asked for, and
    /// for layers that hold no heights.
    pub fn layer(&self, layer: Layer) -> Option<&[f32]> {
        self.0.layer(0, layer)
    }

    /// The cells: shape, extent, reference system.
    pub fn grid(&self) -> &GeoRef {
        self.0.grid()
    }

    /// What was odd.
    pub fn warnings(&self) -> &[Warning] {
        self.0.warnings()
    }

    /// SHA-256 of the mask: equal for equal answers, whatever the machine, the engine and the number of threads.
    pub fn digest(&self) -> &str {
        self.0.digest()
    }

    /// The document `skyshed/map/1`.
    pub fn document(&self) -> serde_json::Value {
        self.0.document()
    }
}
