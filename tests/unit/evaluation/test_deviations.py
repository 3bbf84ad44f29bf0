from echoplan.evaluation import deviations, match_map
from helpers import maps


def test_every_true_wall_has_a_line_found_or_not() -> None:
    found = maps.drawn(maps.wall((5, 0.2), (5, 1.2)), maps.wall((1, 0.02), (3, 0.02)), maps.wall((2, 0.01), (4, 0.01)))
    lines = deviations(match_map(found, maps.ROOM).walls)
    assert [line.index for line in lines] == [1, 2, 3, 4, 5, 6]
    assert [line.detected_by for line in lines] == [9, 4, 3, 2, 5, 1]
    assert [line.match and line.match.estimate for line in lines] == [2, 0, None, None, None, None]
    assert lines[0].match is not None
    assert round(lines[0].match.distance, 9) == 0.01


def test_a_vertex_with_several_corners_has_its_nearest() -> None:
    found = maps.drawn(maps.corner((5.0, 0.05)), maps.corner((5.0, 0.02)), maps.corner((5.0, 0.08)))
    lines = deviations(match_map(found, maps.ROOM).corners)
    assert [line.match and line.match.estimate for line in lines] == [None, None, None, None, 1, None]
