//! Coordinate reference systems of grids.

/// A horizontal coordinate reference system: its name, and the meaning of its coordinates.
///
/// Coordinates are always in the order x, y (east, north; longitude, latitude in degrees), as
/// rasters, GeoJSON and every GIS store them. The axis order of the authority is ignored.
#[derive(Debug, Clone)]
pub struct Crs {
    epsg: Option<u32>,
    name: String,
    kind: CrsKind,
    definition: CrsDefinition,
    /// Length of one coordinate unit on the ground at the data \[m\]; `None` if the kind gives it.
    true_meters_per_unit: Option<f64>,
}

impl PartialEq for Crs {
    /// Compares the definitions. The true length of a unit at the data is ignored.
    fn eq(&self, other: &Crs) -> bool {
        let parts = |crs: &Crs| (crs.epsg, crs.kind);
        parts(self) == parts(other) && self.name == other.name && self.definition == other.definition
    }
}

/// The meaning of the coordinates of a [`Crs`].
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

/// The source of the mathematics of a [`Crs`].
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
    /// Makes a system from its EPSG code, if it has one, its name, the meaning of its coordinates,
    /// and its definition.
    pub fn new(epsg: Option<u32>, name: impl Into<String>, kind: CrsKind, definition: CrsDefinition) -> Crs {
        Crs { epsg, name: name.into(), kind, definition, true_meters_per_unit: None }
    }

    /// Sets the length of one coordinate unit on the ground \[m\], for data in a projection that
    /// stretches lengths there.
    #[must_use]
    pub fn with_true_meters_per_unit(self, meters: f64) -> Crs {
        Crs { true_meters_per_unit: Some(meters), ..self }
    }

    /// Returns the length of one coordinate unit \[m\]. It is the length on the ground if that was
    /// set, and 1 in systems without a plane.
    pub fn meters_per_unit(&self) -> f64 {
        match (self.true_meters_per_unit, self.kind) {
            (Some(meters), _) => meters,
            (None, CrsKind::Projected { meters_per_unit }) => meters_per_unit,
            (None, CrsKind::Geographic | CrsKind::Other) => 1.0,
        }
    }

    /// Returns the EPSG code of the horizontal system.
    pub fn epsg(&self) -> Option<u32> {
        self.epsg
    }

    /// Returns `EPSG:25832`, or the name if there is no code.
    pub fn label(&self) -> String {
        self.epsg.map_or_else(|| self.name.clone(), |code| format!("EPSG:{code}"))
    }

    /// Returns the name, for example `ETRS89 / UTM zone 32N`.
    pub fn name(&self) -> String {
        self.name.clone()
    }

    /// Returns the meaning of the coordinates.
    pub fn kind(&self) -> CrsKind {
        self.kind
    }

    /// Returns the definition.
    pub fn definition(&self) -> &CrsDefinition {
        &self.definition
    }

    /// Returns `true` if two definitions mean one system. They have the same EPSG code, or the same
    /// definition and no code.
    pub fn same_as(&self, other: &Crs) -> bool {
        if self.epsg.is_some() || other.epsg.is_some() { self.epsg == other.epsg } else { self == other }
    }
}
