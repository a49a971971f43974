"""Motion blur of objects: the mean of images at instants of the shutter's time, at each of which the camera moves on."""
from . import camera


class Instant:
    """One of `count`: share of the samples and number; poses of the camera at its ends, or None."""

    def __init__(self, number, count, poses):
        self.number, self.count, self.poses = number, count, poses


def _places(depsgraph):
    return {(i.object.name_full, tuple(i.persistent_id)): (i.matrix_world.copy(), _shape_of(i.object))
            for i in depsgraph.object_instances if i.object.type not in ("CAMERA", "EMPTY")}


def _shape_of(target):
    """A few vertices of a mesh, which deformation moves."""
    if target.type != "MESH" or target.data is None or not target.data.vertices:
        return ()
    vertices = target.data.vertices
    return tuple(tuple(vertices[i * (len(vertices) - 1) // 7].co) for i in range(8))


def _moves(first, last):
    if first.keys() != last.keys():
        return True
    return any(abs(a - b) > 1e-6 for key in first for a, b in zip(_numbers(first[key]), _numbers(last[key])))


def _numbers(place):
    matrix, shape = place
    return [v for row in matrix for v in row] + [v for point in shape for v in point]


def instants_of(scene, depsgraph, set_frame, matrix_of, steps):
    """Yields the Instants of a frame, with the scene set to the middle of each: one where no object moves. In the end the frame is
    set back."""
    frame, times = scene.frame_current, camera.shutter_of(scene)
    if times is not None and steps > 1:
        places = []
        for moment in times:
            set_frame(int((frame + moment) // 1), (frame + moment) % 1)
            places.append(_places(depsgraph))
        set_frame(frame, 0.0)
        if _moves(*places):
            length = (times[1] - times[0]) / steps
            for i in range(steps):
                begin = times[0] + i * length
                moments = (begin, begin + length, begin + length / 2)
                poses = camera.poses_between(scene, frame, moments, set_frame, matrix_of)[:2] if scene.camera else None
                yield Instant(i, steps, poses)
            set_frame(frame, 0.0)
            return
    yield Instant(0, 1, camera.poses_of(scene, set_frame, matrix_of))
