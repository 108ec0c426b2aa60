//! Probability of line of sight over whole cities: users, placements and plots.

use skyshed_core::words;

words! {
    /// Users that count.
    pub enum Users {
        /// All ground that is not building, uniformly
        Outdoor = "outdoor",
        /// Streets between crossroads
        Street = "street",
        /// Crossroads
        Crossroad = "crossroad",
    }
}

words! {
    /// Places where the UAV hovers, uniformly.
    pub enum Placement {
        /// Anywhere over the city
        Anywhere = "anywhere",
        /// Over a street
        Street = "street",
        /// Over a crossroad
        Crossroad = "crossroad",
        /// Over a building
        Rooftop = "rooftop",
        /// Over the middle of a street
        StreetCenter = "street-center",
        /// Over the middle of a crossroad
        CrossroadCenter = "crossroad-center",
        /// Over the middle of a building
        RooftopCenter = "rooftop-center",
    }
}

words! {
    /// Kind of plot.
    pub enum PlotKind {
        /// A heat map for two-way sweeps of one city and method, else curves
        Auto = "auto",
        /// Curves
        Curves = "curves",
        /// Heat maps of two-way sweeps
        Heat = "heat",
    }
    default Auto
}
