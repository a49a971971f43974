"""Cameras: field of view and shift from the projection, depth of field, motion while the shutter is open."""
import math

from mathutils import Vector

from .report import owner


def size_of(scene):
    """Width and height of the whole frame, pixels."""
    render = scene.render
    scale = render.resolution_percentage / 100
    return max(int(render.resolution_x * scale), 1), max(int(render.resolution_y * scale), 1)


def crop_of(scene):
    """x, y from the top left, width and height of the render region, pixels; None: the whole frame."""
    render = scene.render
    if not render.use_border:
        return None
    width, height = size_of(scene)
    left, right = int(render.border_min_x * width), int(render.border_max_x * width)
    bottom, top = int(render.border_min_y * height), int(render.border_max_y * height)
    if right <= left or top <= bottom:
        return None
    return left, height - top, right - left, top - bottom


def _pose(matrix):
    """Position, target and up. The target is 1 m ahead."""
    matrix = matrix.normalized()
    position = matrix.translation
    turn = matrix.to_3x3()
    return {"position": list(position), "target": list(position + turn @ Vector((0, 0, -1))),
            "up": list(turn @ Vector((0, 1, 0)))}


def camera_of(camera_object, depsgraph, size, report):
    """The "camera" of a scene file for an evaluated object of a camera."""
    camera, name = camera_object.data, owner("camera", camera_object)
    scene = depsgraph.scene
    render = scene.render
    projection = camera_object.calc_matrix_camera(
        depsgraph, x=size[0], y=size[1], scale_x=render.pixel_aspect_x, scale_y=render.pixel_aspect_y)
    if abs(render.pixel_aspect_x - render.pixel_aspect_y) > 1e-6:
        report.lose(name, "pixels that are not square")
    out = _pose(camera_object.matrix_world)
    out["resolution"] = list(size)
    if camera.type == "PERSP":
        # P11 = 1 / tan(fov_y / 2); (P02 / P00, P12 / P11) is the centre of the view at depth 1, 2 / P11 its height.
        out["fov_y"] = math.degrees(2 * math.atan(1 / projection[1][1]))
        shift = [projection[0][2] / projection[0][0] * projection[1][1] / 2, projection[1][2] / 2]
        if max(abs(v) for v in shift) > 1e-7:
            out["shift"] = shift
        _add_lens(out, camera, camera_object, depsgraph, report, name)
    elif camera.type == "ORTHO":
        _distant(out, camera_object, projection, report, name)
    else:
        report.lose(name, f"the projection of a {camera.type.lower()} camera: a perspective of 90 degrees")
        out["fov_y"] = 90.0
    return out


def _distant(out, camera_object, projection, report, name):
    """Parallel rays by a pinhole far behind: a hundred heights of the view away it deviates by half a degree at most."""
    height = 2 / abs(projection[1][1])
    away = 100 * height
    back = camera_object.matrix_world.to_3x3().normalized() @ Vector((0, 0, away))
    out["position"] = list(Vector(out["position"]) + back)
    out["fov_y"] = math.degrees(2 * math.atan(0.5 * height / away))
    shift = [-projection[0][3] / projection[0][0] / height, -projection[1][3] / projection[1][1] / height]
    if max(abs(v) for v in shift) > 1e-7:
        out["shift"] = shift
    report.approximate(name, f"parallel rays: the camera is {away:.4g} m farther back, behind what lies there")


def _add_lens(out, camera, camera_object, depsgraph, report, name):
    dof = camera.dof
    if not dof.use_dof or dof.aperture_fstop <= 0:
        return
    distance = dof.focus_distance
    if dof.focus_object is not None:
        there = dof.focus_object.evaluated_get(depsgraph).matrix_world.translation
        axis = camera_object.matrix_world.to_3x3().normalized() @ Vector((0, 0, -1))
        distance = abs((there - camera_object.matrix_world.translation).dot(axis))
    if distance <= 0:
        return
    out["aperture_radius"] = camera.lens * 1e-3 / (2 * dof.aperture_fstop)
    out["focus_distance"] = distance
    if dof.aperture_blades > 2 or abs(dof.aperture_ratio - 1) > 1e-3:
        report.approximate(name, "the blades or the ratio of its aperture: a circle")


def shutter_of(scene):
    """Times at which the shutter opens and closes, frames from the present one; None without motion blur."""
    if not scene.render.use_motion_blur:
        return None
    length = scene.render.motion_blur_shutter
    position = getattr(scene.render, "motion_blur_position", None)
    if position is None:
        position = getattr(getattr(scene, "cycles", None), "motion_blur_position", "CENTER")
    start = {"START": 0.0, "CENTER": -length / 2, "END": -length}[position]
    return start, start + length


def poses_of(scene, set_frame, matrix_of):
    """World matrices of the camera as the shutter opens and closes; None where it does not move.
    set_frame(frame, subframe): moves the scene there, and in the end back; matrix_of(camera): its world matrix there."""
    times = shutter_of(scene)
    if times is None or scene.camera is None:
        return None
    frame = scene.frame_current
    found = poses_between(scene, frame, times, set_frame, matrix_of)
    set_frame(frame, 0.0)
    return found


def poses_between(scene, frame, times, set_frame, matrix_of):
    """World matrices of the camera at times in frames from `frame`, at the last of which the scene stays."""
    found = []
    for moment in times:
        exact = frame + moment
        set_frame(int(exact // 1), exact % 1)
        found.append(matrix_of(scene.camera).copy())
    return found


def add_motion(out, opened, closed):
    """Makes a camera move from one world matrix to another while the shutter is open."""
    first, last = _pose(opened), _pose(closed)
    if max((Vector(first[k]) - Vector(last[k])).length for k in first) < 1e-7:
        return
    out.update(first)
    out["motion"] = last
