import numpy as np
import pytest

from echoplan.classical.grids import Cones, Raster, trace_for
from echoplan.classical.grids.conflicts import Claims, claims_of, explanations, pressure, settle_conflicts
from helpers import cells

RASTER = Raster(-3.0, -3.0, 0.1, 60, 60)
THICKNESS = 0.2


def joined(*parts: Cones) -> Cones:
    return Cones(*map(np.concatenate, zip(*parts, strict=True)))


def claimed(cones: Cones, *, settled: bool = True) -> Claims:
    """Claims of pings in the order of their readings."""
    trace = trace_for(cones, np.minimum(cones.readings, cones.reaches) + THICKNESS / 2, RASTER.resolution)
    claims = claims_of(cones, RASTER, trace, thickness=THICKNESS)
    if settled:
        settle_conflicts(claims, RASTER, cones, trace, THICKNESS)
    return claims


def number_of(x: float, y: float) -> int:
    """Number of the cell of a point."""
    return int(np.floor((y - RASTER.y) / 0.1)) * RASTER.columns + int(np.floor((x - RASTER.x) / 0.1))


def test_sound_is_louder_the_nearer_and_the_closer_to_the_axis() -> None:
    assert pressure(1.0, 0.0) == 1.0
    assert pressure(2.0, 0.0) == 0.5
    assert pressure(1.0, 1.0) == pytest.approx(np.exp(-2.0))
    assert np.isfinite(pressure(0.0, 0.0))


def test_every_cell_of_an_arc_is_claimed_once_and_silence_claims_none() -> None:
    cones = joined(cells.cone(0.021, 0.033), cells.cone(0.021, 0.033, reading=np.inf))
    claims = claimed(cones, settled=False)
    (seen, _) = cells.seen(cones, RASTER)
    on_arc = seen.inside & (np.abs(seen.distances - 1.0) <= THICKNESS / 2)
    assert np.array_equal(claims.standing.reshape(60, 60), on_arc.astype(np.int64))
    assert claims.left.tolist() == [on_arc.sum(), 0]
    assert not claims.kept.any()


def test_the_claims_of_a_cell_stand_the_loudest_first() -> None:
    cones = joined(*(cells.cone(0.05, 0.05, bearing=turn, reading=1.0) for turn in (0.4, 0.0, 0.2)))
    claims = claimed(cones, settled=False)
    cell = number_of(1.05, 0.05)
    first, end = claims.starts[cell], claims.starts[cell + 1]
    assert claims.owners[first:end].tolist() == [1, 2, 0]
    assert claims.pressures[first:end].tolist() == sorted(claims.pressures[first:end], reverse=True)


@pytest.mark.parametrize("seed", range(4))
def test_what_stands_is_counted_alike_by_cell_and_by_ping(seed: int) -> None:
    cones = cells.random_cones(np.random.default_rng(seed))
    order = np.argsort(cones.readings, kind="stable")
    claims = claimed(Cones(*(field[order] for field in cones)))
    assert claims.left.sum() == claims.standing.sum()
    assert (claims.left[claims.kept & np.isfinite(np.sort(cones.readings))] > 0).all()
    assert (claims.passes <= claims.kept.sum()).all()


def test_a_ping_that_is_discarded_frees_no_cell() -> None:
    wall = cells.cone(0.35, 0.05, half_aperture=0.3)
    oblique = cells.cone(0.95, 0.55, bearing=-0.9, reading=2.9, half_aperture=1.2)
    claims = claimed(joined(wall, oblique))
    assert claims.kept.tolist() == [True, False]
    assert claims.passes.max() == 1
    assert claims.passes[number_of(0.95, 0.05)] == 1
    assert claims.passes[number_of(1.85, -0.55)] == 0


def test_readings_are_explained_only_by_what_stands() -> None:
    near = cells.cone(0.05, 0.05)
    through = cells.cone(0.05, 0.05, bearing=0.3, reading=2.0, half_aperture=0.3)
    claims = claimed(joined(near, through))
    echoes = explanations(claims, share=1e-9)
    assert (echoes > 0).sum() == (claims.standing > 0).sum()
    assert echoes.sum() == claims.left.sum()
    assert echoes[number_of(0.95, 0.35)] == 0 < echoes[number_of(0.95, -0.35)]
