"""Each method has a test of the property that makes it what it is, not only of running: this is where."""

from pathlib import Path

import pytest

from echoplan.methods import METHODS

TESTS = Path(__file__).parents[2]
DEFINING = {
    "joint": ("unit/joint/test_mapper.py", "test_errors_of_walls_agree_with_their_covariances"),
    "mdp-fuzzy": ("unit/extraction/test_compensation.py", "test_flat_excess_is_what_geometry_says"),
    "rcd": ("unit/extraction/test_rcd.py", "test_the_middle_of_a_region_is_taken_for_the_normal"),
    "point-plot": ("unit/classical/test_point_plot.py", "test_a_wall_is_drawn_as_an_arc_about_the_station"),
    "atm": ("unit/classical/test_atm.py", "test_crossings_sharpen_the_direction_of_a_post"),
    "tbf": (
        "unit/classical/loci/test_triangulation.py",
        "test_a_point_is_counted_once_for_each_sweep_that_detected_it",
    ),
    "arc-carving": (
        "unit/classical/loci/test_carving.py",
        "test_a_newer_echo_from_farther_away_cuts_its_beam_out_of_an_older_arc",
    ),
    "directional-maximum": (
        "unit/classical/loci/test_density.py",
        "test_arcs_are_thinned_to_the_densest_cell_on_each_line",
    ),
    "hough": ("unit/classical/loci/test_votes.py", "test_echoes_of_a_wall_vote_for_one_line"),
    "arc-hough-tbf": (
        "unit/classical/features/test_fusion.py",
        "test_a_tangent_and_a_line_that_agree_become_one_surer_wall",
    ),
    "iepf-kalman": (
        "unit/classical/test_iepf_kalman.py",
        "test_a_chain_is_split_at_the_farthest_point_into_walls_that_meet",
    ),
    "gmm": ("unit/classical/features/test_mixture.py", "test_one_component_learns_mean_and_covariance_of_its_points"),
    "salient-ekf": ("unit/classical/test_salient_ekf.py", "test_drifting_odometry_is_corrected"),
    "grid-elfes": (
        "unit/classical/grids/test_elfes.py",
        "test_a_cell_known_to_be_empty_cancels_and_the_rest_of_the_arc_takes_its_share",
    ),
    "grid-bayes": (
        "unit/classical/grids/test_bayes.py",
        "test_the_grid_is_that_of_the_inverse_sensor_model_written_out",
    ),
    "grid-muriel": ("unit/classical/grids/test_muriel.py", "test_repeats_from_one_place_count_once"),
    "grid-cemal": ("unit/classical/grids/test_cemal.py", "test_a_specular_long_reading_does_not_erase_a_wall"),
    "grid-range-layer": (
        "unit/classical/grids/test_range_layer.py",
        "test_a_square_room_comes_out_round_and_its_corners_are_cut_off_by_two_fifths_of_its_half_width",
    ),
    "topological": (
        "unit/classical/test_topological.py",
        "test_two_rooms_joined_by_a_door_are_two_places_and_one_passage",
    ),
}


@pytest.mark.parametrize("method", METHODS)
def test_the_property_that_defines_a_method_is_tested(method: str) -> None:
    file, name = DEFINING[method]
    assert f"\ndef {name}(" in (TESTS / file).read_text(encoding="utf-8")
