#!/usr/bin/env python3
"""The Python package: memory is shared and outlives its names, work is interrupted with a valid partial image, errors
have their place, and images are those of the command line.
usage: PYTHONPATH=BUILD/python test_python.py TYNDALL [unittest arguments] (works in the current folder)"""
import array
import contextlib
import ctypes
import gc
import io
import json
import logging
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time
import unittest
import weakref

import tyndall
from tyndall import _core
from python_cases import FOG, TOOL, cloud, needs_numpy, needs_xarray, np, run, xarray


def address(made):
    return made.__array_interface__["data"][0]


class Buffers(unittest.TestCase):
    """Memory of images, grids and fields."""

    def test_channels_are_views(self):
        image = tyndall.Scene(FOG).render()
        core = image._core.channel("G")
        self.assertEqual(core.shape, (16, 24))
        seen = memoryview(core)
        self.assertEqual((seen.shape, seen.format, seen.readonly), ((16, 24), "f", False))
        self.assertEqual(ctypes.addressof(ctypes.c_char.from_buffer(seen.cast("B"))), core.address)
        with self.assertRaises(KeyError):
            image["nothing"]

    @needs_numpy
    def test_arrays_share_memory(self):
        image = tyndall.Scene(FOG).render(channels=["variance", "depth"])
        colors, green = image.rgb, image["G"]
        self.assertEqual(address(green), image._core.channel("G").address)
        self.assertTrue(np.shares_memory(colors, green))
        self.assertEqual(address(np.asarray(image)), image._core.channel("R").address)
        colors[3, 5, 1] = 77
        self.assertEqual(green[3, 5], 77)
        self.assertEqual(memoryview(image._core.channel("G"))[3, 5], 77)
        self.assertEqual(image["variance"].shape, (16, 24, 3))
        self.assertEqual(image["depth"].shape, (16, 24))
        self.assertEqual(np.asarray(image, dtype=np.float64).dtype, np.float64)

    @needs_numpy
    def test_views_outlive_images(self):
        image = tyndall.Scene(FOG).render()
        kept, expected = image.rgb, image.rgb.copy()
        del image
        gc.collect()
        scratch = [np.full((16, 24, 3), 9, np.float32) for _ in range(64)]  # would reuse freed memory
        np.testing.assert_array_equal(kept, expected)
        del scratch

    @needs_numpy
    def test_dlpack_shares_memory(self):
        image = tyndall.Scene(FOG).render()
        for source in (image, image._core.channel("B")):
            made = np.from_dlpack(source)
            first = "R" if source is image else "B"
            self.assertEqual(address(made), image._core.channel(first).address)
        before = sys.getrefcount(image._core)
        capsule = image.__dlpack__()  # which nobody takes
        self.assertEqual(sys.getrefcount(image._core), before + 1)
        del capsule
        self.assertEqual(sys.getrefcount(image._core), before)
        self.assertEqual(image.__dlpack_device__(), (1, 0))
        np.testing.assert_array_equal(np.from_dlpack(image), image.rgb)
        image.__dlpack__(stream=None, max_version=(1, 0), dl_device=(1, 0), copy=False)
        for wish in ({"copy": True}, {"dl_device": (2, 0)}):
            with self.assertRaises(BufferError):
                image.__dlpack__(**wish)

    @needs_numpy
    def test_contiguity(self):
        any_contiguous, view = 0x98, (ctypes.c_byte * 256)()  # PyBUF_ANY_CONTIGUOUS
        colors = tyndall.Scene(FOG).render()._core.colors("R", "G", "B")
        with self.assertRaises(BufferError):
            ctypes.pythonapi.PyObject_GetBuffer(ctypes.py_object(colors), view, any_contiguous)

    @needs_numpy
    def test_volumes_borrow_arrays(self):
        density = cloud()
        volume = tyndall.Volume(density, spacing=0.5, origin=(1, 2, 3))
        self.assertEqual(volume._grids[0].values.address, address(density))
        self.assertEqual(volume.info["size"], (12, 12, 12))
        self.assertEqual(volume.info["placement"], (0.5, 0, 0, 1, 0, 0.5, 0, 2, 0, 0, 0.5, 3))
        with self.assertRaises((ValueError, BufferError)):
            volume.values[0, 0, 0] = 1
        readonly = density.copy()
        readonly.flags.writeable = False
        self.assertEqual(tyndall.Volume(readonly)._grids[0].values.address, address(readonly))

    @needs_numpy
    def test_volumes_convert_what_they_cannot_borrow(self):
        density = cloud()
        for other in (density.astype(np.float64), density[:, ::2, ::-1], np.asfortranarray(density),
                      (density * 100).astype(np.int16), density.astype(np.float16)):
            volume = tyndall.Volume(other)
            self.assertNotEqual(volume._grids[0].values.address, address(other))
            np.testing.assert_allclose(volume.values, other.astype(np.float32), rtol=1e-6)
        with self.assertLogs("tyndall", logging.WARNING) as log:
            holes = cloud()
            holes[4, 4, 4] = np.nan
            volume = tyndall.Volume(holes)
        self.assertEqual(volume.values[4, 4, 4], 0)
        self.assertTrue(np.isnan(holes[4, 4, 4]), "the caller's array was changed")
        self.assertIn("1 values that are not finite", log.output[0])

    @needs_numpy
    def test_borrowed_arrays_outlive_their_names(self):
        class Owned(np.ndarray):  # can be referred to weakly
            pass

        density = cloud().view(Owned)
        alive = weakref.ref(density)
        scene = tyndall.Scene(FOG)
        reference = tyndall.Scene(FOG)
        reference["media[0].density"] = cloud()
        scene["media[0].density"] = density
        del density
        gc.collect()
        self.assertIsNotNone(alive(), "the scene borrows an array that is gone")
        scratch = [np.ones((12, 12, 12), np.float32) for _ in range(64)]
        np.testing.assert_array_equal(scene.render().rgb, reference.render().rgb)
        del scratch
        scene["media[0].density"] = 1
        reference.render()
        gc.collect()
        self.assertIsNone(alive(), "the scene keeps an array that it does not name")

    @needs_numpy
    def test_references_are_balanced(self):
        density = cloud()
        before = sys.getrefcount(density)
        for _ in range(5):
            volume = tyndall.Volume(density)
            scene = tyndall.Scene(FOG)
            scene["media[0].density"] = volume
            image = scene.render(spp=1, size=(4, 4))
            field = scene.solve("fld", resolution=6).fluence(size=4)
            views = [image.rgb, image["R"], np.asarray(field), volume.values, np.from_dlpack(image)]
            with contextlib.suppress(tyndall.Error):
                scene["media[0].g"] = 7
            del volume, scene, image, field, views
        gc.collect()
        self.assertEqual(sys.getrefcount(density), before)

    @needs_numpy
    def test_tensors_without_buffers(self):
        class Tensor:  # as torch.Tensor: DLPack alone
            def __init__(self, values):
                self.values, self.shape = values, values.shape

            def __dlpack__(self, **keywords):
                return self.values.__dlpack__(**keywords)

            def __dlpack_device__(self):
                return self.values.__dlpack_device__()

        density = cloud()
        before = sys.getrefcount(density)
        volume = tyndall.Volume(Tensor(density))
        self.assertEqual(volume._grids[0].values.address, address(density))
        self.assertEqual(sys.getrefcount(density), before + 1)
        del volume
        self.assertEqual(sys.getrefcount(density), before)

    def test_without_numpy(self):
        values = memoryview(array.array("f", range(24))).cast("B").cast("f", (2, 3, 4))
        volume = tyndall.Volume(values, spacing=1)
        self.assertEqual(volume.info["size"], (4, 3, 2))
        self.assertEqual(memoryview(volume._grids[0].values)[1, 2, 3], 23)

    def test_wrong_arrays(self):
        for wrong, message in ((memoryview(b"abc").cast("c"), "axes"), ([1, 2], "axes"), (array.array("f", [1]), "axes")):
            with self.assertRaisesRegex(tyndall.Error, message):
                tyndall.Volume(wrong)
        with self.assertRaises(tyndall.Error):
            _core.grid_create(tyndall.default_context(), memoryview(b"\0" * 8).cast("c", (2, 2, 2)), None, 0.0)

    @needs_numpy
    def test_arrays_beyond_memory(self):
        """Their number of bytes as floats is 8 modulo 2^64."""
        points = np.broadcast_to(np.uint8(0), (1537228672809129302, 3))
        with self.assertRaisesRegex(tyndall.ArgumentError, "too large"):
            tyndall.Scene(FOG)._core.set_mesh("large", points, np.zeros((1, 3), np.uint32), None, None, None)


class Scenes(unittest.TestCase):
    """Documents and changes."""

    def test_changes(self):
        scene = tyndall.Scene(FOG)
        self.assertEqual(scene["media[0].g"], 0.3)
        before = scene.hash
        scene["media[0].g"] = 0.5
        self.assertEqual(scene["media[0].g"], 0.5)
        self.assertNotEqual(scene.hash, before)
        scene.update({"media[0].g": 0.3})
        self.assertEqual(scene.hash, before)
        self.assertEqual(scene.add_light("point", position=[0, 2, 0], intensity=5), "lights[1]")
        del scene["lights[1]"]
        self.assertEqual(scene.hash, before)
        self.assertNotIn("lights[1]", scene)
        with self.assertRaises(KeyError):
            scene["media[3].g"]

    def test_a_wrong_change_changes_nothing(self):
        scene = tyndall.Scene(FOG)
        before = scene.document
        with self.assertRaises(tyndall.InputError) as caught:
            scene.update({"media[0].sigma_s": 3, "media[0].g": 1.2})
        self.assertEqual(scene.document, before)
        self.assertEqual((caught.exception.key, caught.exception.file), ("media[0].g", None))

    def test_errors_have_their_place(self):
        pathlib.Path("wrong.json").write_text(json.dumps({"tyndall": 1, "media": [{**FOG["media"][0], "g": 1.2}]}, indent=1))
        with self.assertRaises(tyndall.InputError) as caught:
            tyndall.Scene("wrong.json")
        error = caught.exception
        lines = pathlib.Path("wrong.json").read_text().splitlines()
        self.assertEqual((error.file, error.key), ("wrong.json", "media[0].g"))
        self.assertIn('"g"', lines[error.line - 1])
        self.assertIsInstance(error, ValueError)
        with self.assertRaises(tyndall.FileError) as caught:
            tyndall.Scene("missing.json")
        self.assertIsInstance(caught.exception, OSError)
        self.assertEqual(caught.exception.file, "missing.json")
        with self.assertRaisesRegex(tyndall.InputError, "did you mean|unknown|not a key") as caught:
            tyndall.Scene(FOG).render("dom", directionz=48)
        self.assertIn("render.dom", caught.exception.key)
        with self.assertRaisesRegex(tyndall.ArgumentError, "no method"):
            tyndall.Scene(FOG).render("radiosity")
        with self.assertRaisesRegex(tyndall.InputError, "nothing of this name"):
            tyndall.Scene({"media": [{**FOG["media"][0], "density": {"file": "memory:nothing"}}]})

    def test_options_hold_for_one_call(self):
        scene = tyndall.Scene(FOG)
        before = scene.hash
        scene.render("dom", resolution=8, directions=24, camera={"position": [0, 1, 4]})
        self.assertEqual(scene.hash, before)
        self.assertNotIn("render.dom", scene)
        with self.assertRaises(tyndall.Error):
            scene.render("dom", resolution=-5)
        self.assertEqual(scene.hash, before)
        self.assertIn("directions", tyndall.method_options("dom"))

    @needs_numpy
    def test_meshes_and_maps(self):
        scene = tyndall.Scene({"camera": FOG["camera"], "render": {"method": "path", "spp": 16}})
        quad = tyndall.Mesh([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2], [0, 2, 3]])
        scene.add_geometry(quad, material={"albedo": 0.5})
        sky = np.full((4, 8, 3), 2, np.float32)
        scene.add_light("environment", file=tyndall.Image(sky))
        self.assertEqual(scene.info["triangles"], 2)
        image = scene.render()
        np.testing.assert_allclose(image.rgb[0, 0], 2, rtol=1e-5)
        np.testing.assert_allclose(image.rgb[8, 12].mean(), 1, rtol=0.2)  # albedo times radiance
        scene.save("memory.json")
        np.testing.assert_array_equal(tyndall.Scene("memory.json").render().rgb, image.rgb)
        with self.assertRaisesRegex(tyndall.InputError, "not a volume"):
            scene.add_medium(density={"file": scene["geometry[0].file"]}, sigma_s=1)

    @needs_numpy
    def test_copies(self):
        scene = tyndall.Scene(FOG)
        scene["media[0].density"] = cloud()
        scene.add_geometry(tyndall.Mesh([[-1, -2, -1], [1, -2, -1], [0, -2, 1]], [[0, 2, 1]]))
        copy = scene.copy()
        self.assertEqual(copy.hash, scene.hash)
        np.testing.assert_array_equal(copy.render().rgb, scene.render().rgb)
        copy["media[0].g"] = 0.9
        self.assertEqual(scene["media[0].g"], 0.3)
        os.makedirs("folder", exist_ok=True)
        tyndall.Volume(cloud()).save("folder/cloud.nrrd")
        pathlib.Path("folder/cloud.json").write_text(json.dumps(
            {"tyndall": 1, "media": [{**FOG["media"][0], "density": {"file": "cloud.nrrd"}}]}))
        loaded = tyndall.Scene("folder/cloud.json")
        loaded.save("folder/again.json")
        self.assertEqual(tyndall.Scene("folder/again.json").hash, loaded.hash)
        self.assertEqual(loaded.copy().hash, loaded.hash)

    @needs_numpy
    def test_placed_volumes(self):
        """An array with spacing and origin is the same as the box of cells that it fills."""
        density = cloud(8)
        placed, filling = tyndall.Scene(FOG), tyndall.Scene(FOG)
        filling["media[0].density"] = density
        del placed["media[0]"]
        placed.add_medium(density=tyndall.Volume(density, spacing=0.25, origin=(-0.875,) * 3), sigma_s=2, sigma_a=0.1, g=0.3,
                          bounds=[[-1, -1, -1], [1, 1, 1]])
        difference = placed.render(spp=64).diff(filling.render(spp=64))
        self.assertLess(abs(difference["mean_ratio"][3] - 1), 0.05)

    @needs_numpy
    def test_scenes_in_use_do_not_change(self):
        scene = tyndall.Scene(FOG)
        refused = []

        def change(progress):
            try:
                scene["media[0].g"] = 0.1
            except tyndall.Error as error:
                refused.append(str(error))

        scene.render(seconds=0.3, progress=change)
        self.assertTrue(refused and "in use" in refused[0], refused)
        scene["media[0].g"] = 0.1

    @needs_numpy
    def test_scenes_are_not_read_while_they_change(self):
        scene = tyndall.Scene(FOG)
        answers, done = set(), threading.Event()

        def read():
            while not done.is_set():
                try:
                    answers.add(scene.info["lights"] == 1 and "media" in scene.document and scene.hash != "" and
                                scene.camera["fov_y"] > 0 and scene.settings["spp"] > 0)
                except tyndall.ArgumentError as error:
                    answers.add(str(error))

        reader = threading.Thread(target=read)
        reader.start()
        for _ in range(40):
            scene["media[0].density"] = np.ones((48, 48, 48), np.float32)
        done.set()
        reader.join()
        refusal = "the scene is being changed in another thread"
        self.assertIn(refusal, answers)
        self.assertLessEqual(answers, {True, refusal})

    @needs_numpy
    def test_volumes_of_other_contexts(self):
        """A scene keeps the context of its grids."""
        scene = tyndall.Scene(FOG)
        context = tyndall.Context(1)
        before = sys.getrefcount(context)
        scene["media[0].density"] = tyndall.Volume(cloud(), context=context)
        scene._given.clear()
        self.assertGreater(sys.getrefcount(context), before)
        del scene
        gc.collect()
        self.assertEqual(sys.getrefcount(context), before)


class Rendering(unittest.TestCase):
    """Images, fields and their progress."""

    @needs_numpy
    def test_images_are_those_of_the_command_line(self):
        if TOOL is None:
            self.skipTest("no command line tool was given")
        pathlib.Path("fog.json").write_text(json.dumps({"tyndall": 1, **FOG}))
        scene = tyndall.Scene("fog.json")
        for method in ("path", "dom"):
            subprocess.run([TOOL, "render", "fog.json", "-o", "fog.exr", "--method", method, "-D", "media[0].g=0.5", "-q"],
                           check=True)
            expected = tyndall.read("fog.exr")
            scene["media[0].g"] = 0.5
            image = scene.render(method)
            np.testing.assert_array_equal(image.rgb, expected.rgb)
            for key in ("tyndall.scene", "tyndall.method", "tyndall.seed", "tyndall.spp", "tyndall.camera.fov_y"):
                self.assertEqual(image.metadata[key], expected.metadata[key], key)

    def test_all_methods(self):
        scene = tyndall.Scene(FOG)
        for method in (*tyndall.methods(), "auto"):
            image = scene.render(method, size=(8, 6), spp=1)
            self.assertEqual((image.size, image.complete), ((8, 6), True), method)
            self.assertGreater(image.stats["seconds"], 0)

    def test_saving(self):
        image = tyndall.Scene(FOG).render(channels=["depth"])
        image.set_metadata("my.note", "foggy")
        image.save("saved.exr")
        self.assertEqual(tyndall.read("saved.exr").metadata["my.note"], "foggy")
        image.save("saved.png", exposure=1)
        pathlib.Path("own.png").write_bytes(image.to_png(exposure=1))
        self.assertEqual(tyndall.diff(tyndall.read("own.png"), tyndall.read("saved.png"))["differing"], 0)
        self.assertEqual(image._repr_png_()[:8], b"\x89PNG\r\n\x1a\n")
        for name, options in (("saved.gif", {}), ("saved.exr", {"channel": "depth.Z"})):
            with self.assertRaises(tyndall.ArgumentError):
                image.save(name, **options)

    @needs_numpy
    def test_colors_of_files_are_in_order(self):
        """Channels of EXR files are in alphabetical order."""
        image = tyndall.Scene(FOG).render(channels=["single", "normal"])
        image.save("order.exr")
        read = tyndall.read("order.exr")
        for layer in ("single", "normal", ""):
            np.testing.assert_array_equal(read[layer], image[layer])
        with self.assertRaisesRegex(tyndall.ArgumentError, "no colours"):
            tyndall.Image({"depth": image["R"], "mask": image["G"]}).rgb

    @needs_numpy
    def test_fields(self):
        scene = tyndall.Scene(FOG)
        lower, upper = (-1, -1, -1), (1, 1, 1)
        truth = scene.solve("path", spp=256).fluence(lower, upper, 2)
        self.assertEqual(truth.values.shape, (2, 2, 2, 3))
        np.testing.assert_allclose(truth.y, [-0.5, 0.5])
        self.assertGreater(truth.values[:, 1].mean(), truth.values[:, 0].mean())  # the light comes from above
        for method in ("dom", "fld", "pop"):
            light = scene.solve(method)
            fields = light.fields(lower, upper, 2)
            np.testing.assert_allclose(fields.fluence.values.mean(), truth.values.mean(), rtol=0.1, err_msg=method)
            self.assertTrue((fields.uncollided.values < fields.fluence.values).all())
            self.assertEqual(light.render((6, 4)).size, (6, 4))
        self.assertEqual(scene.solve("fld", resolution=8).fields(size=2).flux.values.shape, (2, 2, 2, 3, 3))
        along = scene.solve("dom").radiance([[0, 0, 1]], [[0, 0, 1]])
        self.assertEqual(along.shape, (1, 3))
        self.assertGreater(along.min(), 0)
        through = scene.transmittance((0, 0, -2), (0, 0, 2))
        np.testing.assert_allclose(through, np.exp(-4.2), rtol=1e-5)

    @needs_xarray
    def test_xarray(self):
        values = cloud(8)
        at = np.linspace(-0.875, 0.875, 8)
        density = xarray.DataArray(values.transpose(2, 1, 0), {"x": at, "y": at + 1, "z": at + 2}, ["x", "y", "z"])
        volume = tyndall.Volume(density)
        np.testing.assert_allclose(volume.info["placement"], (0.25, 0, 0, -0.875, 0, 0.25, 0, 0.125, 0, 0, 0.25, 1.125))
        np.testing.assert_array_equal(volume.values, values)
        scene = tyndall.Scene(FOG)
        field = scene.solve("fld", resolution=8).fields(size=4).to_xarray()
        self.assertEqual(field["fluence"].dims, ("z", "y", "x", "channel"))
        self.assertEqual(field["x"].attrs["units"], "m")
        made = scene.render(channels="depth").to_xarray()
        self.assertEqual(made["radiance"].shape, (16, 24, 3))

    def test_progress(self):
        seen = []
        tyndall.Scene(FOG).render(seconds=0.3, progress=seen.append)
        self.assertGreaterEqual(len(seen), 1)
        self.assertEqual(seen[0].stage, "path")
        self.assertTrue(all(0 <= p.fraction <= 1 for p in seen))
        self.assertEqual([p.seconds for p in seen], sorted(p.seconds for p in seen))
        with self.assertRaisesRegex(ZeroDivisionError, "mine"):
            def fail(progress):
                raise ZeroDivisionError("mine")
            tyndall.Scene(FOG).render(seconds=30, progress=fail)

    def test_bars(self):
        from tyndall import _progress

        bar, out = _progress.TerminalBar(), io.StringIO()
        with contextlib.redirect_stderr(out):
            bar(_progress.Progress("path", 0.1, 0.1, 0.9, 1, 4))
            self.assertEqual(out.getvalue(), "", "a bar for work that is soon over")
            bar(_progress.Progress("path", 0.5, 1, 61, 2, 4))
            bar.close()
        self.assertIn("path:  50% [############............] 2/4 spp 0:01, 1:01 to go", out.getvalue())
        shown = []

        class Handle:
            def update(self, item):
                shown.append(item._repr_html_())

        notebook = _progress.NotebookBar(lambda item, display_id: shown.append(item._repr_html_()) or Handle())
        notebook(_progress.Progress("path", 0.5, 1, 61, 2, 4))
        notebook.close()
        self.assertIn('value="0.5000"', shown[0])
        self.assertEqual(shown[1], "")

    def test_stopping(self):
        image = tyndall.Scene(FOG).render(seconds=30, progress=lambda p: p.seconds < 0.2)
        self.assertFalse(image.complete)
        self.assertEqual(image.metadata["tyndall.complete"], 0)
        with self.assertRaises(tyndall.Cancelled):
            tyndall.Scene(FOG).render("dom", resolution=64, directions=1024, progress=lambda p: False)

    def test_exceptions_of_functions(self):
        """They come through, with the partial image."""
        def fail(_):
            raise RuntimeError("enough")

        for function in ("progress", "partial"):
            with self.assertRaisesRegex(RuntimeError, "enough") as caught:
                tyndall.Scene(FOG).render(seconds=30, **{function: fail})
            self.assertFalse(caught.exception.image.complete)

    def interrupt_soon(self, delay=0.3):
        timer = threading.Timer(delay, os.kill, (os.getpid(), signal.SIGINT))
        timer.start()
        self.addCleanup(timer.cancel)
        return time.monotonic()

    def test_interrupts(self):
        scene = tyndall.Scene(FOG)
        begun = self.interrupt_soon()
        with self.assertRaises(KeyboardInterrupt) as caught:
            scene.render(seconds=30)
        self.assertLess(time.monotonic() - begun, 10)
        image = caught.exception.image
        self.assertFalse(image.complete)
        self.assertGreater(image.metadata["tyndall.spp"], 0)
        if np is not None:
            whole = scene.render(spp=256)
            self.assertLess(abs(image.diff(whole)["mean_ratio"][3] - 1), 0.2)
        self.interrupt_soon()
        self.assertFalse(scene.render(seconds=30, on_interrupt="return").complete)
        self.assertTrue(scene.render(spp=1).complete)

    def test_images_so_far(self):
        seen = []

        def look(image):
            seen.append(image)
            return len(seen) < 2

        image = tyndall.Scene(FOG).render(seconds=30, partial=look)
        self.assertEqual([i.size for i in seen], [(24, 16)] * 2)
        self.assertFalse(image.complete or seen[0].complete)
        with self.assertRaisesRegex(ZeroDivisionError, "mine"):
            def fail(image):
                raise ZeroDivisionError("mine")
            tyndall.Scene(FOG).render(seconds=30, partial=fail)

    @needs_numpy
    def test_renders_go_on_from_states(self):
        one = tyndall.Context(threads=1)  # on which the work takes longer than a twentieth of a second
        for name in ("fog.state", "dom.state", "going.exr.state"):  # of runs before
            pathlib.Path(name).unlink(missing_ok=True)
        whole = tyndall.Scene(FOG).render(spp=2000)
        partial = tyndall.Scene(FOG, context=one).render(spp=2000, seconds=0.05, state="fog.state")
        self.assertLess(partial.stats["spp"], 2000)
        image = tyndall.Scene(FOG).render(spp=2000, state="fog.state")
        self.assertEqual(image.stats["spp"], 2000)
        self.assertIn("samples.N", image.channels)
        np.testing.assert_array_equal(image.rgb, whole.rgb)
        with self.assertRaisesRegex(tyndall.InputError, "fog.state: .*; remove it to start again"):
            tyndall.Scene(FOG, overrides={"media[0].g": 0}).render(spp=2000, state="fog.state")
        with self.assertRaisesRegex(tyndall.ArgumentError, "no states"):
            tyndall.Scene(FOG).render("dom", state="dom.state")
        if TOOL is not None:
            pathlib.Path("going.json").write_text(json.dumps({"tyndall": 1, **FOG}))
            scene = tyndall.Scene("going.json", context=one)
            scene.render(spp=2000, seconds=0.05, state="going.exr.state")
            subprocess.run([TOOL, "render", "going.json", "-o", "going.exr", "--spp", "2000", "--resume", "-q"], check=True)
            np.testing.assert_array_equal(tyndall.read("going.exr").rgb, whole.rgb)

    def test_other_threads_run_meanwhile(self):
        """Python's lock is released: a thread counts while another renders."""
        counted, stop = [0], threading.Event()

        def count():
            while not stop.is_set():
                counted[0] += 1

        thread = threading.Thread(target=count)
        scene = tyndall.Scene(FOG, context=tyndall.Context(threads=1))
        thread.start()
        before = counted[0]
        scene.render(seconds=0.3)
        done = counted[0] - before
        stop.set()
        thread.join()
        self.assertGreater(done, 1000)

    @needs_numpy
    def test_threads_render_one_scene(self):
        scene = tyndall.Scene(FOG)
        images = [None] * 4

        def render(i):
            images[i] = scene.render(seed=3)

        threads = [threading.Thread(target=render, args=(i,)) for i in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for image in images[1:]:
            np.testing.assert_array_equal(image.rgb, images[0].rgb)


if __name__ == "__main__":
    run()
