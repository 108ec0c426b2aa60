//! What the coordinates of a grid mean.

/// A horizontal coordinate reference system: what it is called, and what its coordinates measure.
///
/// Coordinates are always in the order x, y (east, north; longitude, latitude in degrees), whatever order an authority
/// assigns: that is how rasters, GeoJSON and every GIS store them.
#[derive(Debug, Clone)]
pub struct Crs {
    epsg: Option<u32>,
    name: String,
    kind: CrsKind,
    definition: CrsDefinition,
    /// Length of one coordinate unit on the ground where the data lie \[m\]; `None` if it is that of the kind.
    true_meters_per_unit: Option<f64>,
}

impl PartialEq for Crs {
    /// Whether two definitions are equal. Where in the system data lie is no part of it.
    fn eq(&self, other: &Crs) -> bool {
        let parts = |crs: &Crs| (crs.epsg, crs.kind);
        parts(self) == parts(other) && self.name == other.name && self.definition == other.definition
    }
}

/// What the coordinates of a [`Crs`] measure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CrsKind {
    /// Longitude and latitude \[deg\].
    Geographic,
    /// Easting and northing in a plane.
    Projected {
        /// Length of one coordinate unit \[m\].
        meters_per_unit: f64,
    },
    /// Neither: geocentric, or of unknown units.
    Other,
}

/// Where the mathematics of a [`Crs`] comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum CrsDefinition {
    /// The registry entry of its EPSG code.
    Registry,
    /// A WKT text without a code that the registry knows.
    Wkt(String),
    /// A PROJ or PROJJSON text.
    Proj(String),
    /// Only a name: coordinates cannot be transformed.
    Described,
}

impl Crs {
    /// A system from its EPSG code, if it has one, its name, what its coordinates measure, and what defines it.
    pub fn new(epsg: Option<u32>, name: impl Into<String>, kind: CrsKind, definition: CrsDefinition) -> Crs {
        Crs { epsg, name: name.into(), kind, definition, true_meters_per_unit: None }
    }

    /// Sets the length of one coordinate unit on the ground \[m\], for data in a projection that stretches lengths there.
    #[must_use]
    pub fn with_true_meters_per_unit(self, meters: f64) -> Crs {
        Crs { true_meters_per_unit: Some(meters), ..self }
    }

    /// Length of one coordinate unit \[m\], on the ground where that was set; 1 in systems without a plane.
    pub fn meters_per_unit(&self) -> f64 {
        match (self.true_meters_per_unit, self.kind) {
            (Some(meters), _) => meters,
            (None, CrsKind::Projected { meters_per_unit }) => meters_per_unit,
            (None, CrsKind::Geographic | CrsKind::Other) => 1.0,
        }
    }

    /// The EPSG code of the horizontal system.
    pub fn epsg(&self) -> Option<u32> {
        self.epsg
    }

    /// `EPSG:25832`, or the name if there is no code.
    pub fn label(&self) -> String {
        self.epsg.map_or_else(|| self.name.clone(), |code| format!("EPSG:{code}"))
    }

    /// The name, for example `ETRS89 / UTM zone 32N`.
    pub fn name(&self) -> String {
        self.name.clone()
    }

    /// What the coordinates measure.
    pub fn kind(&self) -> CrsKind {
        self.kind
    }

    /// What defines it.
    pub fn definition(&self) -> &CrsDefinition {
        &self.definition
    }

    /// Whether two definitions mean one system: the same EPSG code, or the same definition where neither has one.
    pub fn same_as(&self, other: &Crs) -> bool {
        if self.epsg.is_some() || other.epsg.is_some() { self.epsg == other.epsg } else { self == other }
    }
}
