//! Layers of a map, and the forms of its files.

use skyshed_core::words;

words! {
    /// Layer of a map.
    #[non_exhaustive]
    pub enum Layer {
        /// Classes: 0 NLoS, 1 LoS, 2 not a receiver, 3 out of range, 255 nodata
        Los = "los",
        /// Receiver height less the least visible height [m]
        Margin = "margin",
        /// Least receiver height in line of sight [m above the datum]
        LeastReceiverHeight = "least-receiver-height" old "ceiling",
        /// Least UAV height over its place that sees the receiver [m above the datum]. It is never below the surface under the
        /// UAV. Infinite where no height is enough; minus infinite where nothing limits it, no surface under the UAV either
        /// (in .tif, .asc and .bil 32768 and -32768)
        LeastHeight = "least-height",
        /// Number of moves by one lattice step that turn the answer, 0 to 8. The UAV moves east, west, north, south, up and
        /// down, all roofs up and down (1/1024 m; of a raster horizontally 1/1024 cell). Costs eight more maps
        Stability = "stability",
        /// 0 never, 1 surely, 2 possibly in line of sight, whatever heights of buildings are within --sigma standard deviations of
        /// --height-error and --height-bias. Costs two more maps
        Sure = "sure",
        /// Probability of line of sight, 0 to 1, with errors of heights of footprints (--height-error, --height-bias)
        PLos = "p-los" old "p_los",
        /// Number of UAVs that see the cell; nodata where nobody receives (NaN in .exr, 4294967295 in .npz)
        Count = "count",
        /// UAVs that see the cell, one bit each
        Which = "which",
        /// Classes as in `los`, of all UAVs together: 1 where any sees the cell
        Union = "union",
        /// Classes as in `los`, of all UAVs together: 1 where every one sees the cell, 3 where it is out of range of any
        All = "all",
        /// The nearest UAV that sees the cell, by its number in the order of the UAVs from 1, in three dimensions, the first at
        /// equal distances; 0 where none does, nodata where nobody receives
        BestServer = "best-server",
        /// Share of the time of the table in which some UAV that is up sees the cell, 0 to 1 (columns `from` and `to` of --uavs)
        Uptime = "uptime",
        /// Longest time in which no UAV that is up sees the cell \[min\]; all of the time of the table where none ever does
        Gap = "gap",
    }
}

impl Layer {
    /// Returns `true` for a layer of all UAVs together.
    pub fn is_of_all(self) -> bool {
        matches!(self, Layer::Count | Layer::Which | Layer::Union | Layer::All | Layer::BestServer) || self.is_of_time()
    }

    /// Returns `true` for a layer of the times in which UAVs are up.
    pub fn is_of_time(self) -> bool {
        matches!(self, Layer::Uptime | Layer::Gap)
    }

    /// Returns `true` for a layer that refers to UAVs by their places in the list of all.
    pub fn tells_numbers(self) -> bool {
        matches!(self, Layer::Which | Layer::BestServer)
    }

    /// Returns `true` for a layer with a float for each receiver: meters, the number of moves that turn
    /// it, how sure it is, or a probability.
    pub fn is_measure(self) -> bool {
        use Layer::{LeastHeight, LeastReceiverHeight, Margin, PLos, Stability, Sure};
        matches!(self, Margin | LeastReceiverHeight | LeastHeight | Stability | Sure | PLos)
    }
}

words! {
    /// Arrangement of the cells of a GeoTIFF.
    pub enum TiffLayout {
        /// Tiles, deflated, with overviews
        Cog = "cog",
        /// Strips of rows, uncompressed, without overviews: for simple readers, and for timing
        Plain = "plain",
    }
    default Cog
}

words! {
    /// Cells that become polygons.
    pub enum PolygonClasses {
        /// Cells in line of sight
        Los = "los",
        /// Cells that are hidden
        Nlos = "nlos",
        /// Both
        All = "all",
    }
}

impl PolygonClasses {
    /// Returns the classes of a mask.
    pub fn classes(self) -> &'static [u8] {
        use skyshed_core::coverage::class::{LOS, NLOS};
        match self {
            PolygonClasses::Los => &[LOS],
            PolygonClasses::Nlos => &[NLOS],
            PolygonClasses::All => &[LOS, NLOS],
        }
    }
}
