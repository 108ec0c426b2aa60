//! Round trips of random requests: words, request, words; request, JSON, request.

use clap::{Arg, ArgAction, Args, Command, FromArgMatches};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::json::{command_line, filled_members, from_keywords, from_members, set_members};
use crate::{
    ChartRequest, CityRequest, CompareRequest, InfoRequest, LimitsRequest, LinkRequest, LiveRequest, MapRequest,
    PlaceRequest, PlosRequest, SampleRequest, StressRequest, TrackRequest, ZonesRequest,
};

/// Numbers from a seed (SplitMix64).
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        usize::try_from((z ^ (z >> 31)) % n as u64).unwrap_or(0)
    }

    fn one<'a>(&mut self, of: &[&'a str]) -> &'a str {
        of[self.below(of.len())]
    }
}

/// Returns a value that a flag takes.
fn value_of(flag: &Arg, numbers: &mut Numbers) -> String {
    let possible = flag.get_possible_values();
    if !possible.is_empty() {
        let known: Vec<&str> = possible.iter().map(clap::builder::PossibleValue::get_name).collect();
        let one = numbers.one(&known).to_string();
        let is_list = flag.get_value_delimiter().is_some() && numbers.below(2) == 0;
        return if is_list { format!("{one},{}", numbers.one(&known)) } else { one };
    }
    let value_name = flag.get_value_names().and_then(|names| names.first()).map_or("", |name| name.as_str());
    let of: &[&str] = match flag.get_id().as_str() {
        "scenes" if flag.is_positional() => &["itu:urban", "maps/a b.tif"],
        "method" if value_name == "LIST" => &["product", "product,itu", "all"],
        _ if value_name == "LIST" && flag.get_id() != "missing" => &["5:90:5", "30, 60.5", "45", "0.1:0.7:0.1"],
        "until" => &["±0.005", "0.01"],
        "families" => &["cell-slits", "cell-slits,prism-walls"],
        "scene" => &["itu:urban", "itu:0.3,500,15", "maps/a b.tif", "Straße.geojson"],
        "uav" => &["500,500,100", "-1.5,2e3,30roof", "691549.7,5334762.2,400ft amsl"],
        "rx" => &["1,2", "-1,2.5,1.5roof"],
        "extent" => &["0,0,10.5,20", "-5,-5,-1,-1e-3"],
        "sector" | "elevation" => &["10,20.5", "-90,-30"],
        "curve_heights" => &["10:60:5", "-1:1:0.25"],
        "height" if value_name == "M" => &["100", "400ft"],
        "height" => &["60,100", "20:200:10", "30roof", "100ft:200ft:50ft", "10:35amsl:10"],
        "zones" => &["street:20", "street:20,rooftop:3"],
        "missing" => &["levels,median", "9", "levels,9.5", "median,drop", "fail"],
        "ground" => &["12.5", "-3", "buildings"],
        "data_area" => &["auto", "all", "area of data.geojson"],
        "band" => &["1", "2", "building_height"],
        "shard" => &["1/1", "3/16"],
        "tile" => &["0,0", "3,12"],
        "tile_size" => &["16", "2048"],
        "threads" | "count" | "top" | "cities" | "seed" => &["2", "7", "31"],
        "max_memory" => &["800M", "1.5GiB", "123456"],
        "width" | "dpi" => &["100", "2400"],
        "goal" => &["p_los", "p_los (street) >= 0.8", "margin(area)"],
        "method" => &["auto", "ray", "step:0.5"],
        "earth_k" => &["4/3", "inf", "1.2"],
        "rx_height" => &["1.5", "5ft", "0"],
        _ if flag
            .get_value_names()
            .is_some_and(|names| names.iter().any(|name| ["M", "DEG", "K", "C", "P"].contains(&name.as_str()))) =>
        {
            &["0", "1", "12.5", "-0.001", "1e21", "0.30000000000000004"]
        }
        _ => &["a.tif", "007", "1e3", "true", "-x", "with space, comma", "Größe"],
    };
    numbers.one(of).to_string()
}

/// Returns words that set some flags of a command.
fn random_words(command: &Command, numbers: &mut Numbers) -> Vec<String> {
    let mut words = Vec::new();
    for flag in command.get_arguments().filter(|flag| !["help", "version"].contains(&flag.get_id().as_str())) {
        if flag.is_positional() {
            words.push(value_of(flag, numbers));
            continue;
        }
        if !flag.is_required_set() && numbers.below(6) > 0 {
            continue;
        }
        let name = format!("--{}", flag.get_long().expect("a long flag"));
        match flag.get_action() {
            ArgAction::SetTrue => words.push(name),
            ArgAction::Append => {
                (0..=numbers.below(2)).for_each(|_| words.push(format!("{name}={}", value_of(flag, numbers))));
            }
            _ => words.push(format!("{name}={}", value_of(flag, numbers))),
        }
    }
    words
}

fn check<T>(n: usize)
where
    T: Args + FromArgMatches + Serialize + DeserializeOwned + Default + PartialEq + std::fmt::Debug,
{
    let command = T::augment_args(Command::new("x").no_binary_name(true));
    let parsed = |words: &[String]| {
        let matches = command.clone().try_get_matches_from(words)?;
        T::from_arg_matches(&matches)
    };
    let mut numbers = Numbers(7);
    let mut n_read = 0;
    while n_read < n {
        let typed = random_words(&command, &mut numbers);
        // Some flags exclude each other.
        let Ok(request) = parsed(&typed) else { continue };
        n_read += 1;
        let members = set_members(&request);
        assert_eq!(from_members::<T>(members.clone()).as_ref(), Ok(&request), "{typed:?}");
        assert_eq!(from_keywords::<T>(members.clone()).as_ref(), Ok(&request), "{typed:?}");
        let again = command_line("x", members).split_off(1);
        assert_eq!(parsed(&again).expect("words of a request"), request, "{typed:?} {again:?}");
    }
}

#[test]
fn requests_are_equal_after_words_and_after_json() {
    let n = if std::env::var_os("SKYSHED_LONG").is_some() { 10_000 } else { 300 };
    check::<MapRequest>(n);
    check::<PlaceRequest>(n);
    check::<LinkRequest>(n);
    check::<TrackRequest>(n);
    check::<CityRequest>(n);
    check::<InfoRequest>(n);
    check::<ZonesRequest>(n);
    check::<LimitsRequest>(n);
    check::<CompareRequest>(n);
    check::<SampleRequest>(n);
    check::<LiveRequest>(n);
    check::<ChartRequest>(n);
    check::<PlosRequest>(n);
    check::<StressRequest>(n);
}

#[test]
fn a_default_that_was_set_has_the_identity_of_one_that_was_not() {
    use crate::{Receivers, SetRange, SetReceiver};
    let identity = |request: &MapRequest| crate::json::canonical(&filled_members(request));
    let unset = MapRequest::default();
    let set = MapRequest::default().rx_height(1.5).receivers(Receivers::Ground);
    assert_eq!(identity(&unset), identity(&set));
    assert_ne!(identity(&unset), identity(&unset.clone().rx_height(1.6)));
    assert_ne!(identity(&unset), identity(&unset.clone().receivers(Receivers::Roof)));
}
