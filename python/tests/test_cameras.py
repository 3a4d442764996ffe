"""Cameras, and where what they see lies: millimetres throughout."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from conftest import block, white

import lumivox


def test_a_cameras_matrix_is_a_rotation_and_a_place_in_mm() -> None:
    camera = lumivox.Camera.look_at((10, 20, 500), (10, 20, 0))
    np.testing.assert_allclose(camera.world_from_camera, [[1, 0, 0, 10], [0, 1, 0, 20], [0, 0, 1, 500]], atol=1e-9)
    scene = lumivox.Scene((lumivox.VolumeInstance(block(), white(1.0)),))
    matrix = np.eye(4)
    matrix[2, 3] = 400.0
    seen = lumivox.render(scene, camera=lumivox.Camera(matrix), size=(33, 33), samples=8)
    # The block is 64 mm deep, and dense: its front is 368 mm away.
    assert seen.depth[16, 16] == pytest.approx(368.0, abs=3.0)
    for wrong in (np.diag([2.0, 2.0, 2.0, 1.0]), np.diag([-1.0, 1.0, 1.0, 1.0]), np.diag([1e-3, 1e-3, 1e-3, 1.0])):
        with pytest.raises(ValueError, match="must be a rotation and a place in mm"):
            lumivox.Camera(wrong)


def test_a_volumes_place_is_in_mm() -> None:
    upright = [[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0]]
    usual = lumivox.Scene((lumivox.VolumeInstance(block(), white()),))
    np.testing.assert_allclose(usual.scene_from_patient() @ [*usual.volumes[0].volume.center, 1], np.zeros(3), atol=1e-9)
    given = lumivox.Scene((lumivox.VolumeInstance(block(), white(), world_from_patient=usual.scene_from_patient()),))
    options = {"camera": lumivox.Camera.look_at((30, 40, 300), (0, 0, 0)), "size": (16, 16), "samples": 2, "pass_samples": 2}
    a, b = lumivox.render(usual, **options), lumivox.render(given, **options)
    assert a.alpha.any()
    np.testing.assert_allclose(a.alpha, b.alpha, atol=1e-6)
    with pytest.warns(UserWarning, match="millimetres, not metres"):
        lumivox.VolumeInstance(block(), white(), world_from_patient=np.multiply(upright, 1e-3))


def test_points_are_projected_and_brought_back() -> None:
    camera = lumivox.Camera.look_at((100, -50, 400), (5, 6, 7), fov=40)
    np.testing.assert_allclose(camera.project((5, 6, 7), (64, 48))[:2], (32, 24), atol=1e-9)
    points = np.random.default_rng(1).normal(0, 50, (4, 5, 3))
    places = camera.project(points, (64, 48))
    assert places.shape == (4, 5, 3)
    np.testing.assert_allclose(camera.unproject(places, (64, 48)), points, atol=1e-9)
    assert camera.project((100, -50, 500), (64, 48))[2] < 0, "behind it"
    # Its top is that of the image.
    above = camera.project(np.add((5, 6, 7), (0, 10, 0)), (64, 48))
    assert above[1] < 24
    with pytest.raises(ValueError, match="three numbers"):
        camera.project((1, 2), (64, 48))


def test_positions_are_the_patients() -> None:
    volume = lumivox.Volume.from_array(np.full((16, 16, 16), 100, np.uint8), (4.0, 4.0, 4.0), (-100.0, 30.0, 7.0))
    scene = lumivox.Scene((lumivox.VolumeInstance(volume, white(100.0)),))
    image = lumivox.render(scene, azimuth=0, size=(32, 32), samples=16)
    places, met = image.positions, image.alpha > 0.999
    assert places.shape == (32, 32, 3) and met.any() and np.isinf(places[image.alpha == 0]).all()
    # The face is seen, and the patient's front is where y is lowest.
    np.testing.assert_allclose(places[met][:, 1], volume.bounds[0][1], atol=0.5)
    low, high = volume.bounds
    assert (places[met] > np.subtract(low, 1)).all() and (places[met] < np.add(high, 1)).all()
    # Left in the image is the patient's right, and the head is above.
    rows, columns = np.nonzero(met)
    assert np.corrcoef(columns, places[met][:, 0])[0, 1] > 0.99 and np.corrcoef(rows, places[met][:, 2])[0, 1] < -0.99


def test_regions_and_first_samples_are_options(head: lumivox.Volume) -> None:
    options = {"preset": "ct-bone", "size": (24, 20), "pass_samples": 2}
    whole = lumivox.render(head, samples=4, **options).film.sums()
    part = lumivox.render(head, samples=4, region=(3, 4, 10, 8), **options)
    np.testing.assert_array_equal(part.film.sums(), whole[:, 4:12, 3:13])
    more = lumivox.render(head, samples=4, first_sample=2, **options).film.sums()
    np.testing.assert_allclose(lumivox.render(head, samples=2, **options).film.sums() + more, whole, rtol=1e-6)
    with pytest.raises(ValueError, match="first_sample must be 0 to 3"):
        lumivox.render(head, samples=4, first_sample=4, **options)
    with pytest.raises(ValueError, match="region must be 1 to 21"):
        lumivox.render(head, samples=4, region=(3, 4, 22, 8), **options)


def test_scans_far_apart_are_warned_of(head: lumivox.Volume) -> None:
    far = lumivox.Volume.from_array(head.array, head.spacing, np.add(head.origin, (10_000, 0, 0)), modality="CT")
    with pytest.warns(UserWarning, match="scan 2 lies 9.* mm from the first"):
        lumivox.Scene.of([head, far], preset="ct-bone")


def test_lights_reach_the_layers_that_they_share(head: lumivox.Volume) -> None:
    def lit(layers: int) -> float:
        scene = lumivox.Scene(
            (lumivox.VolumeInstance(head, lumivox.look.preset_medium("ct-skin", head)[1], layers=2),),
            lumivox.Environment("uniform", strength=0.0),
            (lumivox.Sun(0, 30, layers=layers),),
        )
        return float(lumivox.render(scene, size=(16, 16), samples=4).radiance.max())

    assert lit(1) == 0.0 < lit(3)


def slice_of(*shape: int) -> lumivox.Volume:
    """A plane of voxels."""
    return lumivox.Volume.from_array(np.arange(np.prod(shape), dtype=np.uint16).reshape(shape), modality="MR")


@pytest.mark.parametrize(
    ("shape", "towards_eye"),
    [((1, 20, 24), (0, -1, 0)), ((20, 1, 24), (0, 0, 1)), ((20, 24, 2), (1, 0, 0)), ((20, 20, 20), (0, 0, 1))],
)
def test_a_single_slice_is_seen_from_its_front(shape: tuple[int, ...], towards_eye: tuple[float, ...]) -> None:
    # As radiologists look: from the feet, from the face, from the left. What has an inside is seen from the face.
    scene = lumivox.Scene.of(slice_of(*shape))

    def side(**options: float) -> npt.NDArray[np.float64]:
        return np.array(lumivox.Camera.framing(scene, **options).world_from_camera)[:, 2]  # type: ignore[arg-type]

    np.testing.assert_allclose(side(), towards_eye, atol=1e-6)
    # An angle that is given is taken, the other one is 0.
    np.testing.assert_allclose(side(azimuth=0), (0, 0, 1), atol=1e-6)
    np.testing.assert_allclose(side(elevation=30), (0, 0.5, np.sqrt(0.75)), atol=1e-6)
