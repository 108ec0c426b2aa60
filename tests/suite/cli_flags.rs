//! Every flag of `map`, `link`, `track`, `city`, `info`, `zones` and `limits` changes something, and each is tested somewhere.

use crate::cli::{plan, scenes};

/// Flags of `map` that change its document: a scene and a UAV without it, the flag, and where the documents differ.
const PLAN_FLAGS: [(&str, &str, &str); 22] = [
    ("city.geojson --uav 2,2,50", "--ground 5", "/sites/0/height_amsl_m"),
    ("city.geojson --uav 2,2,50", "--height-field tall", "/digest"),
    ("city.geojson --uav 2,2,50", "--top-field z_top", "/digest"),
    ("city.geojson --uav 2,2,50", "--missing levels", "/digest"),
    ("city.geojson --uav 2,2,50", "--height-unit ft", "/digest"),
    ("city.geojson --uav 2,2,50 --missing levels", "--levels-field tall", "/digest"),
    ("city.geojson --uav 2,2,50", "--extent 0,0,50,50", "/scene/cols"),
    ("city.geojson --uav 2,2,50", "--cell 0.5", "/scene/cell_m/0"),
    ("city.geojson --uav 2,2,50", "--crs EPSG:25832", "/scene/crs"),
    ("city.geojson --uav 2,2,50", "--terrain slope.asc", "/digest"),
    ("city.geojson --uav 2,2,50 --terrain slope.asc", "--base highest", "/digest"),
    ("city.geojson --uav 2,2,50", "--data-area all", "/digest"),
    ("city.geojson --uav 2,2,50", "--uav 40,40,50", "/sites/1/id"),
    ("city.geojson --uav 2,2,50", "--uavs sites.csv", "/sites/1/id"),
    ("city.geojson --uav 2,2,50", "--rx-height 9", "/digest"),
    ("city.geojson --uav 2,2,50", "--receivers all", "/digest"),
    ("city.geojson --uav 2,2,50", "--radius 25", "/digest"),
    ("dsm.asc --ground 0 --uav 2,2,50", "--building-threshold 3", "/sites/0/receivers"),
    ("dsm.asc --ground 0 --uav 15,2,5", "--nodata-as block", "/digest"),
    ("itu:urban --uav 2,2,50", "--size 200", "/scene/cols"),
    ("itu:urban --size 200 --uav 2,2,50", "--seed 2", "/digest"),
    ("itu:urban --size 200 --uav 2,2,50", "--method ray", "/method"),
];

/// Flags that change what is written or said; the tests named here show how.
const OTHER_FLAGS: [(&str, &str); 35] = [
    ("--csv-text", "names_that_mean_something_to_a_program_reach_none"),
    ("--width", "every_picture_has_the_width_and_resolution_that_were_asked_for"),
    ("--dpi", "every_picture_has_the_width_and_resolution_that_were_asked_for"),
    ("--skip-bad", "bad_rows_are_told_together_and_left_out_on_request"),
    ("--tile", "tiles_of_footprints_hold_what_a_hand_counts"),
    ("--repairs", "every_thing_mended_or_left_out_is_listed_once"),
    ("--project", "rows_6_to_9_of_reference_systems"),
    ("--layer", "one_table_of_several_is_read_when_it_is_named"),
    ("--uav-error", "what_limits_a_map_is_what_maps_of_the_changed_scene_say"),
    ("--height-error", "higher_roofs_are_those_of_a_file_with_higher_buildings"),
    ("--cities", "what_limits_a_map_is_what_maps_of_the_changed_scene_say"),
    ("--tolerance", "the_program_says_what_was_taken_and_writes_coarser_cells"),
    ("--max-memory", "a_run_that_needs_more_memory_than_allowed_is_refused_before_it_starts"),
    ("--hash", "a_large_input_is_hashed_on_request"),
    ("--layers", "layers_become_bands_named_after_their_site"),
    ("--height-curve", "table_document_and_plot_of_a_curve_agree_with_maps"),
    ("--curve-heights", "the_heights_of_a_curve_are_chosen_or_asked_for"),
    ("--tif-layout", "a_plain_geotiff_of_a_map_differs_in_its_layout_alone"),
    ("--strips", "maps_strip_by_strip_are_those_in_memory"),
    ("--scratch", "what_needs_all_cells_at_once_is_refused_with_a_way_out"),
    ("--resume", "what_is_there_is_left_alone"),
    ("--gdal-values", "values_of_gdal_are_255_where_the_class_is_line_of_sight_and_0_elsewhere"),
    ("--polygons", "a_cell_is_inside_one_polygon_of_its_class_and_of_no_other"),
    ("--simplify", "simpler_outlines_stay_near_and_keep_parts_and_holes"),
    ("--bare", "a_bare_picture_has_a_pixel_per_cell_and_knows_its_place"),
    ("--title", "title_and_attribution_are_drawn"),
    ("--attribution", "title_and_attribution_are_drawn"),
    ("--output", "every_format_holds_the_same_numbers"),
    ("--json", "standard_output_holds_one_document_and_nothing_else"),
    ("--overwrite", "an_existing_file_is_replaced_only_with_leave"),
    ("--threads", "threads_do_not_change_results"),
    ("--quiet", "quiet_says_nothing_but_errors"),
    ("--rx", "a_link_over_a_wall_is_what_a_hand_computes"),
    ("--track", "stretches_end_where_a_hand_computes_them"),
    ("--every", "stretches_end_where_a_hand_computes_them"),
];

#[test]
fn every_flag_changes_the_plan() {
    let folder = scenes();
    for (base, flag, pointer) in PLAN_FLAGS {
        let without = plan(&folder, base);
        let with = plan(&folder, &format!("{base} {flag}"));
        assert_ne!(without.pointer(pointer), with.pointer(pointer), "{flag}: {with}");
    }
    for command in ["map", "link", "track", "city", "info", "zones", "limits"] {
        for flag in folder.flags(command) {
            let flag = flag.as_str();
            let is_known = ["--help", "--version", "--uav"].contains(&flag)
                || PLAN_FLAGS.iter().any(|(_, words, _)| words.split(' ').next() == Some(flag))
                || OTHER_FLAGS.iter().any(|(name, _)| *name == flag);
            assert!(is_known, "{command} {flag}: add it to the flags above, with a test");
        }
    }
}
