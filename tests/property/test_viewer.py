"""Laws of drawings: whatever the map, they are to scale, on their paper, well-formed, and as uncertain as they say."""

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from echoplan.arrays import BoolArray, FloatArray
from echoplan.geometry import directions, lines_through, signed_distances, transform_points
from echoplan.model import Corner, CornerKind, FeatureMap, Wall
from echoplan.viewer.markup import element, path, size
from echoplan.viewer.outline import wall_bodies
from echoplan.viewer.plan import Plan, station_labels
from echoplan.viewer.sections import flattened
from echoplan.viewer.sheet import Sheet
from echoplan.viewer.svg import plan_element, plan_svg
from echoplan.viewer.uncertainty import Ellipse, across_sigmas, error_ellipse, greatest_sigma, wall_band
from echoplan.viewer.wording import decimal
from helpers import maps
from helpers.drawings import group_of, marked, placed, stroke, strokes, the, titles, view_box

few = settings(max_examples=25)
lengths = st.floats(-50.0, 50.0).map(lambda value: round(value, 3))
points = st.tuples(lengths, lengths).map(np.array)
angles = st.floats(-np.pi, np.pi)
sigmas = st.floats(1e-4, 1.0)
spoilt_plans = st.integers(0, 10**6).map(
    lambda seed: Plan(feature_map=maps.spoilt(maps.ROOM, np.random.default_rng(seed)), truth=maps.ROOM)
)
sides = st.floats(-2.5, 3.0).map(lambda power: 10.0**power)


@st.composite
def covariances(draw: st.DrawFn) -> FloatArray:
    """Of a point: any two deviations across each other, turned by any angle."""
    axes = np.stack([directions(turn := draw(angles)), directions(turn + np.pi / 2)], axis=1)
    matrix: FloatArray = axes @ np.diag([draw(sigmas) ** 2, draw(sigmas) ** 2]) @ axes.T
    return (matrix + matrix.T) / 2


@st.composite
def sheets(draw: st.DrawFn) -> Sheet:
    """Of anything from a shelf to a town, as wide as high to within a thousand."""
    low = draw(points)
    return Sheet(bounds_xy=np.stack([low, low + np.array([draw(sides), draw(sides)])]))


@st.composite
def walls(draw: st.DrawFn) -> Wall:
    """At least a hand long."""
    start, turn, length = draw(points), draw(angles), draw(st.floats(0.1, 20.0))
    return maps.wall(start, start + length * directions(turn), covariance=draw(covariances()))


@st.composite
def maps_of_corners(draw: st.DrawFn) -> FeatureMap:
    """Corners anywhere, and stations."""
    corners = [maps.corner(each) for each in draw(st.lists(points, max_size=5))]
    poses = draw(st.lists(points, max_size=5))
    return maps.drawn(*corners, poses=[[*each, 0.0] for each in poses])


def holds(ellipse: Ellipse, points_xy: FloatArray) -> BoolArray:
    """Which points lie within an ellipse."""
    away = points_xy - ellipse.center_xy
    axes = np.stack([directions(ellipse.angle), directions(ellipse.angle + np.pi / 2)], axis=1)
    inside: BoolArray = np.hypot(*(away @ axes / ellipse.semi_axes).T) <= 1.0
    return inside


def may_stand(character: str) -> bool:
    """Whether a document may hold a character (XML 1.0, production 2)."""
    code = ord(character)
    return code in (0x9, 0xA, 0xD) or any(
        low <= code <= high for low, high in ((0x20, 0xD7FF), (0xE000, 0xFFFD), (0x10000, 0x10FFFF))
    )


def within(points_xy: FloatArray, box: FloatArray) -> bool:
    """Whether points lie on their paper, to the rounding of the drawing."""
    left, upper, width, height = box
    low, high = np.array([left, upper]) - 1e-3, np.array([left + width, upper + height]) + 1e-3
    return bool(((points_xy >= low) & (points_xy <= high)).all())


def all_strokes(elements: Iterable[ET.Element]) -> FloatArray:
    return np.concatenate([np.zeros((0, 2)), *(each for made in elements for each in strokes(made))])


@few
@given(covariances(), points, st.sampled_from([0.5, 0.9, 0.95, 0.99]))
def test_an_ellipse_contains_its_probability_of_points(
    covariance: FloatArray, middle: FloatArray, probability: float
) -> None:
    drawn = np.random.default_rng(1).multivariate_normal(middle, covariance, size=4000, method="cholesky")
    share = holds(error_ellipse(middle, covariance, probability=probability), drawn).mean()
    # Four deviations of a binomial share.
    assert abs(share - probability) < 4 * np.sqrt(probability * (1 - probability) / 4000)


@given(covariances(), points, angles)
def test_an_ellipse_turns_with_its_point(covariance: FloatArray, middle: FloatArray, turn: float) -> None:
    pose = np.array([1.0, -2.0, turn])
    rotation = np.stack([directions(turn), directions(turn + np.pi / 2)], axis=1)
    before = error_ellipse(middle, covariance)
    moved = rotation @ covariance @ rotation.T
    after = error_ellipse(transform_points(pose, middle), (moved + moved.T) / 2)
    np.testing.assert_allclose(after.center_xy, transform_points(pose, before.center_xy))
    np.testing.assert_allclose(after.semi_axes, before.semi_axes, rtol=1e-6)
    if before.semi_axes[0] > 1.01 * before.semi_axes[1]:
        assert abs(np.sin(after.angle - before.angle - turn)) < 1e-5


@given(covariances(), points, st.floats(0.01, 100.0))
def test_an_ellipse_grows_with_its_deviations(covariance: FloatArray, middle: FloatArray, times: float) -> None:
    small, great = (error_ellipse(middle, factor * covariance) for factor in (1.0, times**2))
    np.testing.assert_allclose(great.semi_axes, times * small.semi_axes, rtol=1e-6)


@given(covariances(), angles)
def test_no_direction_is_less_sure_than_the_greatest_deviation(covariance: FloatArray, direction: float) -> None:
    way = directions(direction)
    assert np.sqrt(way @ covariance @ way) <= greatest_sigma(covariance) * (1 + 1e-9)


@few
@given(walls())
def test_a_band_contains_its_probability_of_lines_everywhere(one: Wall) -> None:
    # Small enough for angles to be as good as their sines.
    covariance = one.covariance * 1e-10
    drawn = np.random.default_rng(2).multivariate_normal([one.normal_angle, one.offset], covariance, size=4000)
    certain = Wall(
        normal_angle=one.normal_angle, offset=one.offset, endpoints_xy=one.endpoints_xy, covariance=covariance
    )
    way = (one.endpoints_xy[1] - one.endpoints_xy[0]) / one.length
    for along, half in wall_band(certain):
        share = (np.abs(signed_distances(drawn, one.endpoints_xy[0] + along * way)) <= half).mean()
        assert abs(share - 0.95) < 4 * np.sqrt(0.95 * 0.05 / 4000)


@given(walls())
def test_a_wall_is_nowhere_between_two_places_less_sure_than_at_the_worse_of_them(one: Wall) -> None:
    start, end = one.endpoints_xy
    ends = across_sigmas(one, one.endpoints_xy)
    between = across_sigmas(one, start + np.linspace(0, 1, 7)[:, None] * (end - start))
    assert (between <= ends.max() * (1 + 1e-9) + 1e-12).all()


@given(walls(), st.lists(points, min_size=1, max_size=6), st.floats(0.01, 0.5))
def test_bodies_lie_behind_the_detected_face(one: Wall, hubs: list[FloatArray], thickness: float) -> None:
    stations = np.array(hubs)
    line = lines_through(*one.endpoints_xy)
    distances = signed_distances(line, stations)
    assume((np.abs(distances) > 1e-6).all() and len({*np.sign(distances)}) == 1)
    (body,) = wall_bodies([one], stations, thickness=thickness)
    depths = signed_distances(line, body)
    np.testing.assert_allclose(depths[:2], 0.0, atol=1e-9)
    np.testing.assert_allclose(depths[2:], -np.sign(distances[0]) * thickness, atol=1e-9)


@few
@given(spoilt_plans)
def test_every_body_has_its_face_and_the_specified_thickness(plan: Plan) -> None:
    found = plan.feature_map
    for one, body in zip(found.walls, wall_bodies(found.walls, found.poses[:, :2], thickness=0.05), strict=True):
        np.testing.assert_array_equal(body[:2], one.endpoints_xy)
        np.testing.assert_allclose(np.abs(signed_distances(lines_through(*body[:2]), body[2:])), 0.05)


@given(sheets())
def test_a_scale_is_one_that_people_know(sheet: Sheet) -> None:
    digits = f"{sheet.scale:.6e}".split("e")[0]
    assert float(digits) in (1.0, 2.0, 2.5, 5.0)


@given(sheets())
def test_no_sheet_is_greater_than_its_page_and_no_greater_scale_would_fit(sheet: Sheet) -> None:
    page = np.array([190.0, 277.0])
    assert (sheet.size <= page * (1 + 1e-9)).all()
    # The next scale is at most 2.5 times greater.
    bare = sheet.size - [20.0, 32.0]
    assert (2.5 * bare >= (page - [20.0, 32.0]) * (1 - 1e-6)).any()


@given(sheets(), arrays(np.float64, (4, 2), elements=st.floats(-100, 100)))
def test_what_is_measured_on_paper_times_the_scale_is_what_is_in_the_room(sheet: Sheet, points_xy: FloatArray) -> None:
    drawn = sheet.paper(points_xy)
    back = sheet.bounds_xy[[0, 1], [0, 1]] + (drawn - 10.0) * [1, -1] * sheet.scale / 1000
    np.testing.assert_allclose(back, points_xy, atol=1e-9 * max(sheet.scale, 1))


@given(sheets())
def test_lines_of_the_grid_are_within_the_map_a_step_apart_and_none_is_missing(sheet: Sheet) -> None:
    for lines, low, high in zip(sheet.lines, *sheet.bounds_xy, strict=True):
        margin = 1e-8 * sheet.grid
        np.testing.assert_allclose(np.diff(lines), sheet.grid, rtol=1e-6)
        assert len(lines) >= (high - low) / sheet.grid - 1
        assert ((lines >= low - margin) & (lines <= high + margin)).all()


@few
@given(spoilt_plans)
def test_all_that_is_drawn_of_features_lies_on_the_paper(plan: Plan) -> None:
    drawing = plan_element(plan)
    box = view_box(drawing)
    for name in ("face", "body", "true", "way"):
        assert within(all_strokes(each for each in marked(drawing, name) if "d" in each.attrib), box)
    for each in marked(drawing, "fixed"):
        assert within(placed(next(group for group in drawing.iter() if each in list(group)))[0], box)


@few
@given(spoilt_plans)
def test_faces_on_paper_are_faces_in_the_room_times_the_scale(plan: Plan) -> None:
    drawing = plan_element(plan)
    origin = np.array([float(each) for each in drawing.attrib["data-origin"].split()])
    metre = 1000 / float(drawing.attrib["data-scale"])
    for one, made in zip(plan.feature_map.walls, marked(drawing, "face"), strict=True):
        np.testing.assert_allclose((stroke(made) - origin) * [1, -1] / metre, one.endpoints_xy, atol=2e-4 / metre)


@few
@given(points, covariances())
def test_an_ellipse_on_paper_is_the_ellipse_in_the_room(middle: FloatArray, covariance: FloatArray) -> None:
    one = Corner(position_xy=middle, kind=CornerKind.CONCAVE, covariance=covariance)
    drawing = plan_element(Plan(feature_map=maps.drawn(one)))
    made, (place, turn) = the(drawing, "ellipse").attrib, placed(group_of(drawing, "ellipse"))
    # A square metre is drawn at 1 : 10, its middle 60 mm from the edges.
    np.testing.assert_allclose(place, [60.0, 60.0], atol=1e-3)
    semi = np.array([float(made["rx"]), float(made["ry"])]) / 100
    axes = np.stack([directions(-np.radians(turn)), directions(np.pi / 2 - np.radians(turn))], axis=1)
    np.testing.assert_allclose(axes @ np.diag(semi**2) @ axes.T / 5.991465, covariance, atol=1e-5)


@few
@given(spoilt_plans | maps_of_corners().map(lambda found: Plan(feature_map=found)))
def test_every_name_in_a_drawing_is_its_own_and_every_feature_has_one(plan: Plan) -> None:
    found, drawing = plan.feature_map, plan_element(plan)
    names = [each.attrib["id"] for each in drawing.iter() if "id" in each.attrib]
    assert len(names) == len(set(names))
    counts = {"wall": len(found.walls), "corner": len(found.corners), "cylinder": len(found.cylinders)}
    counts["station"] = len(found.poses)
    assert sorted(names) == sorted(f"{kind}-{number}" for kind, count in counts.items() for number in range(count))


@few
@given(spoilt_plans)
def test_a_drawing_describes_each_feature_once(plan: Plan) -> None:
    drawing = plan_element(plan)
    assert len(list(titles(drawing))) == 1 + len(marked(drawing, "feature"))


@given(st.text(st.characters(exclude_categories=())))
def test_a_drawing_is_well_formed_whatever_its_method_is_called(method: str) -> None:
    made = ET.fromstring(plan_svg(Plan(feature_map=FeatureMap(method=method))).encode())
    allowed = "".join(each if may_stand(each) else "\ufffd" for each in method)
    # Parsers make one kind of line end of all.
    assert next(titles(made)) == "Map made by " + re.sub("\r\n?", "\n", allowed)


@given(st.text(), st.text())
def test_text_never_becomes_markup(text: str, value: str) -> None:
    made = ET.fromstring(ET.tostring(element("p", element("b"), text=text, data_value=value), encoding="utf-8"))
    assert [each.tag for each in made.iter()] == ["p", "b"]
    assert set(made.attrib) == {"data-value"}


@given(st.floats(-1e6, 1e6))
def test_a_number_in_a_drawing_is_the_number_to_a_ten_thousandth(value: float) -> None:
    text = size(value)
    assert abs(float(text) - value) <= 0.5001e-4
    assert re.fullmatch(r"-?(0|[1-9]\d*)(\.\d*[1-9])?", text)
    assert text != "-0"


@given(st.lists(arrays(np.float64, (3, 2), elements=st.floats(-1e3, 1e3)), max_size=4))
def test_a_path_contains_its_strokes(drawn: list[FloatArray]) -> None:
    back = strokes(element("path", d=path(drawn)))
    assert len(back) == len(drawn)
    for one, other in zip(back, drawn, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-4)


@few
@given(spoilt_plans)
def test_bounds_contain_everything_drawn_and_are_at_least_a_metre_wide(plan: Plan) -> None:
    low, high = plan.bounds_xy
    found = plan.feature_map
    ends = [one.endpoints_xy for one in found.walls]
    inside = np.concatenate([found.poses[:, :2], *ends, maps.ROOM.walls_xy.reshape(-1, 2)])
    assert ((inside >= low) & (inside <= high)).all()
    for each in found.cylinders:
        assert (each.center_xy - each.radius >= low - 1e-12).all()
        assert (each.center_xy + each.radius <= high + 1e-12).all()
    assert (high - low >= 1.0 - 1e-12).all()


@few
@given(spoilt_plans)
def test_no_enlarged_ellipse_is_longer_than_a_tenth_of_its_map(plan: Plan) -> None:
    longest = max((2 * float(each.semi_axes[0]) for each in plan.ellipses), default=0.0)
    room = 0.1 * float(np.ptp(plan.bounds_xy, axis=0).max())
    assert plan.magnification in (1, 2, 5, 10)
    assert plan.magnification == 1 or plan.magnification * longest <= room


@given(st.integers(0, 3000), st.integers(0, 2**32 - 1))
def test_stations_have_a_name_each_or_few_enough_to_be_read(count: int, seed: int) -> None:
    labels = station_labels(np.arange(count), np.random.default_rng(seed).normal(size=(count, 2)))
    named = [each for each in labels if each]
    assert len(labels) == count
    assert len(set(named)) == len(named) <= 26
    assert not labels or labels[0]


@given(st.floats(-1e9, 1e9), st.integers(0, 6))
def test_a_number_in_words_is_the_number_to_half_its_last_digit(value: float, digits: int) -> None:
    text = decimal(value, digits)
    assert abs(float(text) - value) <= 0.5001 * 10.0**-digits + 1e-9 * abs(value)
    assert not re.fullmatch(r"-0(\.0*)?", text)


@given(
    st.recursive(
        st.dictionaries(st.sampled_from("abc"), st.integers(0, 9)),
        lambda inner: st.dictionaries(st.sampled_from("abc"), inner | st.integers(0, 9)),
        max_leaves=8,
    )
)
def test_flattened_settings_lead_back_to_each_value(nested: dict[str, object]) -> None:
    flat = flattened(nested)
    assert len({name for name, _ in flat}) == len(flat)
    for name, text in flat:
        value: object = nested
        for part in name.split("."):
            assert isinstance(value, dict)
            value = value[part]
        assert str(value) == text
