#!/usr/bin/env python3
"""What the command line can do, from Python: the table of docs/python.md, scenes of arrays as files, textures in memory,
bakes of files that go on, the page of a comparison, the viewer, and tensors of torch both ways.
usage: PYTHONPATH=BUILD/python test_python_commands.py TYNDALL [unittest arguments] (works in the current folder)"""
import json
import logging
import math
import os
import pathlib
import re
import shutil
import sys
import unittest
import urllib.request

import tyndall

from python_cases import FOG, TOOL, cloud, np

try:
    import torch
except ImportError:
    torch = None

PAGE = pathlib.Path(__file__).resolve().parent.parent / "docs" / "python.md"
QUAD = ([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2], [0, 2, 3]])
UV = [[0, 1], [1, 1], [1, 0], [0, 0]]


def textured(value, key="base_color", **more):
    """A quad with a texture under a white sky, seen from the front."""
    scene = tyndall.Scene({"camera": {"position": [0, 0, 2.4], "resolution": [24, 24]}, "render": {"method": "path", "spp": 16}})
    scene.add_light("environment", radiance=1)
    scene.add_geometry(tyndall.Mesh(*QUAD, uv=UV), material={key: value, **more})
    return scene


class Table(unittest.TestCase):
    """The table of commands in docs/python.md."""

    def test_every_command_has_a_row(self):
        known = re.findall(r"^  (\w+) +\S", tyndall.run("help").split("commands:")[1].split("options of all")[0], re.M)
        rows = dict(re.findall(r"^\| `(\w+)` \| (.+?) \|", PAGE.read_text(encoding="utf-8"), re.M))
        self.assertGreater(len(known), 15)
        self.assertEqual([name for name in known if name not in rows], [])
        for name in known:
            cell = rows[name]
            named = re.findall(r"`(\w+)(?:\.(\w+))?\(", cell)
            self.assertTrue(named or "no" in cell, f"{name}: neither a counterpart nor a reason")
            for first, second in named:
                owner = {"scene": tyndall.Scene, "image": tyndall.Image, "volume": tyndall.Volume, "fields": tyndall.Fields,
                         "light": tyndall.Light, "comparison": tyndall.Comparison, "tyndall": tyndall}.get(first, tyndall)
                self.assertTrue(hasattr(owner, second or first), f"{name}: there is no {first}.{second}()")

    def test_the_program_is_found(self):
        self.assertTrue(os.access(tyndall.tool(), os.X_OK))
        kept = os.environ.get("TYNDALL")
        os.environ["TYNDALL"] = "/nowhere/tyndall"
        try:
            with self.assertRaisesRegex(tyndall.Unsupported, "TYNDALL is /nowhere/tyndall, which is no program"):
                tyndall.tool()
        finally:
            if kept is None:
                del os.environ["TYNDALL"]
            else:
                os.environ["TYNDALL"] = kept

    def test_errors_of_commands(self):
        with self.assertRaisesRegex(tyndall.ArgumentError, "--spp: '0' is not a whole number"):
            tyndall.run("render", "builtin:cloud_sun", output="never.exr", spp=0)
        with self.assertRaises(tyndall.InputError) as caught:
            tyndall.run("info", "missing.json")
        self.assertIn("missing.json", str(caught.exception))
        pathlib.Path("bad.json").write_text('{"tyndall": 1,\n "media": [{"g": 7}]}')
        with self.assertRaises(tyndall.InputError) as caught:
            tyndall.run("info", "bad.json")
        self.assertEqual((caught.exception.file, caught.exception.line, caught.exception.key), ("bad.json", 2, "media[0].g"))
        for name in ("bench", "figure"):
            if not os.access(f"{os.path.dirname(tyndall.tool())}/tyndall-{name}", os.X_OK):
                with self.assertRaisesRegex(tyndall.Error, f"tyndall-{name} is not installed"):
                    tyndall.run(name, "all")


class Files(unittest.TestCase):
    """Scenes and images as files."""

    def test_scenes_of_arrays_are_saved(self):
        scene = tyndall.Scene({**FOG, "camera": {"position": [0.5, -3, 1.5], "resolution": [24, 16]}})
        scene["media[0].density"] = cloud()
        scene.add_medium(density=tyndall.Volume(cloud(), spacing=0.2, origin=(0, 1, 0)), sigma_t=1,
                         albedo=tyndall.Volume(np.stack([cloud()] * 3, -1), spacing=0.2, origin=(0, 1, 0)))
        scene.add_geometry(tyndall.Mesh(*QUAD, colors=[[1, 0.5, 0.2, 1]] * 4, uv=UV))
        scene.add_geometry(tyndall.Mesh(*QUAD, uv=UV), transform={"translate": [0, 0, -2]},
                           material={"base_color": np.random.default_rng(1).uniform(0, 1, (5, 7, 3))})
        scene.add_light("environment", file=tyndall.Image(np.random.default_rng(2).uniform(0, 1, (4, 8, 3))))
        for up in ("y", "z"):
            scene["up_axis"] = up
            scene.save(f"saved_{up}.json")
            again = tyndall.Scene(f"saved_{up}.json")
            np.testing.assert_allclose(again.render(spp=4).rgb, scene.render(spp=4).rgb, rtol=2e-4, atol=1e-5)

    def test_paths_are_turned(self):
        """A scene that is saved elsewhere names its files from there."""
        os.makedirs("near", exist_ok=True)
        os.makedirs("far", exist_ok=True)
        tyndall.Volume(cloud(), spacing=0.1).save("near/cloud.vdb")
        medium = {"density": {"file": "cloud.vdb"}, "sigma_t": 1, "albedo": 1}
        pathlib.Path("near/scene.json").write_text(json.dumps({"tyndall": 1, **FOG, "media": [medium]}))
        scene = tyndall.Scene("near/scene.json")
        scene.save("far/scene.json")
        self.assertEqual(tyndall.Scene("far/scene.json").render().diff(scene.render())["differing"], 0)
        scene.save("near/again.json")
        self.assertEqual(tyndall.Scene("near/again.json")["media[0].density.file"], "cloud.vdb")

    def test_merge(self):
        scene = tyndall.Scene(FOG)
        parts = [scene.render(seed=seed, channels="variance") for seed in (1, 2)]
        merged = tyndall.merge(parts)
        np.testing.assert_allclose(merged.rgb, (parts[0].rgb + parts[1].rgb) / 2, rtol=1e-5)
        self.assertEqual(merged.metadata["tyndall.spp"], 8)
        with self.assertRaisesRegex(tyndall.ArgumentError, "two or more are merged, not 1"):
            tyndall.merge(parts[:1])
        with self.assertRaisesRegex(tyndall.InputError, "shares seed 1"):
            tyndall.merge([parts[0], parts[0]])

    def test_frames(self):
        for number in (1, 2):
            tyndall.Volume(number * cloud(), spacing=0.1, origin=(-0.5,) * 3).save(f"plume_{number:02d}.vdb")
        scene = tyndall.Scene({**FOG, "media": [{"density": {"file": "plume_##.vdb"}, "sigma_t": 2, "albedo": 0.9}], "frame": 1})
        images = dict(scene.frames([1, 2], "path", spp=4))
        self.assertNotEqual(images[1].rgb.mean(), images[2].rgb.mean())
        np.testing.assert_array_equal(images[2].rgb, scene.render("path", spp=4, frame=2).rgb)
        self.assertEqual(scene["frame"], 1)
        tyndall.run("render", scene, output="plume_##.exr", method="path", spp=4, frames="1-2")
        np.testing.assert_array_equal(tyndall.read("plume_02.exr").rgb, images[2].rgb)

    def test_info_of_scenes(self):
        self.assertEqual(tyndall.info("builtin:cloud_sun")["media"], 1)
        with self.assertRaisesRegex(tyndall.ArgumentError, "volumes, meshes, images and scenes"):
            tyndall.info(__file__)

    def test_figures(self):
        if os.access(f"{os.path.dirname(tyndall.tool())}/tyndall-figure", os.X_OK):
            made = tyndall.figure("fld-limiters", "figures", quick=True)
            self.assertEqual(list(made), ["fld-limiters"])
            self.assertTrue(made["fld-limiters"])

    def test_fields_are_written(self):
        fields = tyndall.Scene(FOG).solve("fld", resolution=8).fields(size=4)
        fields.save("fluence.vti")
        for c in range(3):
            read = tyndall.Volume.read("fluence.vti", "fluence", component=c)
            np.testing.assert_allclose(read.values, fields.fluence.values[..., c], rtol=1e-6)
        self.assertAlmostEqual(read.info["placement"][3], fields.fluence.x[0], 6)

    def test_conversions(self):
        tyndall.Volume(cloud(), spacing=0.5).save("cloud.vdb")
        tyndall.convert("cloud.vdb", "cloud.nii.gz")
        np.testing.assert_allclose(tyndall.Volume.read("cloud.nii.gz").info["max"], cloud().max(), rtol=1e-6)
        tyndall.Scene(FOG).render().save("fog.exr")
        tyndall.convert("fog.exr", "fog.ktx2", mipmaps=True)
        self.assertGreater(os.path.getsize("fog.ktx2"), 100)

    def test_compare(self):
        comparison = tyndall.compare(tyndall.Scene(FOG), ["dom", "path"], spp=32, reference_spp=64)
        self.assertGreater(comparison.noise, 0)
        for row in comparison:
            expected = math.sqrt(max(row["relative_rmse"] ** 2 - comparison.noise ** 2, 0))
            self.assertAlmostEqual(row["without_noise"], expected, 12)
        comparison.save("report")
        told = json.loads(pathlib.Path("report/errors.json").read_text())
        for row, image in zip(comparison, told["images"]):
            self.assertAlmostEqual(image["relative_rmse_without_noise"]["all"], row["without_noise"], 5)
        self.assertIn("<html", pathlib.Path("report/report.html").read_text(encoding="utf-8"))

    def test_screen_and_denoise_options(self):
        picture = np.random.default_rng(3).uniform(0, 1, (16, 24, 3)).astype(np.float32)
        depth = np.full((16, 24), 20, np.float32)
        plain = tyndall.screen(picture, depth, variant="gather")
        for options in ({"mask": "none"}, {"level_scale": 3.0}, {"luminance_weights": False}):
            self.assertGreater(plain.diff(tyndall.screen(picture, depth, variant="gather", **options))["differing"], 0, options)
        with self.assertRaisesRegex(tyndall.ArgumentError, "mask: unknown"):
            tyndall.screen(picture, depth, variant="gather", mask="hard")
        noisy = tyndall.Scene(FOG).render(spp=8, channels=tyndall.DENOISE_CHANNELS)
        self.assertGreater(noisy.denoise().diff(noisy.denoise(parts=False))["differing"], 0)


class Textures(unittest.TestCase):
    """Materials with arrays as textures."""

    def test_colors(self):
        picture = np.random.default_rng(4).integers(0, 256, (6, 8, 3), dtype=np.uint8)
        scene = textured(picture)
        scene.save("texture.json")
        np.testing.assert_array_equal(tyndall.Scene("texture.json").render().rgb, scene.render().rgb)  # as the PNG file's
        white = textured(np.ones((4, 4, 3), np.float32)).render()
        gray = textured({"file": np.full((4, 4), 0.5, np.float32)}).render()
        np.testing.assert_allclose(gray.rgb[12, 12] / white.rgb[12, 12], 0.5, rtol=0.02)  # 8 bits of sRGB

    def test_upright(self):
        top = np.zeros((2, 2, 3), np.float32)
        top[0] = 1
        image = textured(top).render()
        self.assertGreater(image.rgb[3].mean(), 5 * image.rgb[20].mean())

    def test_alpha_and_changes(self):
        hole = np.ones((4, 4, 4), np.float32)
        hole[..., 3] = 0
        scene = textured(hole)
        before = scene.render().rgb[12, 12].copy()
        scene["geometry[0].material.base_color"] = np.zeros((4, 4, 3), np.float32)
        self.assertLess(scene.render().rgb[12, 12].max(), 0.01 * before.max())

    def test_normals_and_numbers(self):
        flat = np.zeros((4, 4, 3), np.uint8) + np.array([128, 128, 255], np.uint8)
        lit = {"type": "directional", "direction": [0, -1, -1], "irradiance": 1}
        scenes = []
        for normals in (flat, flat + np.array([0, 60, 0], np.uint8)):
            scene = textured(0.8, normal_map={"file": normals})
            scene["lights[0]"] = lit
            scenes.append(scene.render().rgb[12, 12].mean())
        self.assertGreater(scenes[1], 1.1 * scenes[0])  # turned towards the light
        rough = textured(0.8, metallic=1.0, roughness=np.full((4, 4), 0.5, np.float32)).render()
        number = textured(0.8, metallic=1.0, roughness=0.5).render()
        np.testing.assert_allclose(rough.rgb[12, 12], number.rgb[12, 12], rtol=0.02)

    def test_emission(self):
        glow = np.zeros((8, 8, 3), np.uint8)
        glow[:4] = 255
        scene = textured({"file": glow, "factor": [4, 2, 1]}, "emission", base_color=0)
        scene["lights"] = []
        image = scene.render()
        np.testing.assert_allclose(image.rgb[3, 12], [4, 2, 1], rtol=0.02)
        self.assertLess(image.rgb[20, 12].max(), 0.01)
        with self.assertRaisesRegex(tyndall.InputError, "shapes have no textures of emission"):
            scene.add_geometry(sphere={"center": [0, 0, 0], "radius": 1}, material={"emission": glow})

    def test_wrong_textures(self):
        with self.assertRaisesRegex(tyndall.ArgumentError, "base_color: a texture of shape"):
            textured(np.zeros((4, 4, 2), np.float32))
        with self.assertRaisesRegex(tyndall.InputError, "is a mesh, not an image"):
            textured(tyndall.Mesh(*QUAD))


class Bakes(unittest.TestCase):
    """Folders of bakes."""

    def scene(self):
        scene = tyndall.Scene({"lights": [{"type": "environment", "radiance": 1}]})
        scene.add_geometry(tyndall.Mesh(*QUAD, uv=UV))
        scene.add_geometry(tyndall.Mesh(np.array(QUAD[0]) + [0, 0, -1], QUAD[1]))
        return scene

    def test_files_and_states(self):
        shutil.rmtree("baked", ignore_errors=True)
        told = self.scene().bake_files("baked", spp=16, size=(8, 8), grid=(2, 2, 1))
        files = {str(path.relative_to("baked")) for path in pathlib.Path("baked").rglob("*")}
        self.assertTrue({"bake.json", "scene.json"} <= files and any(name.endswith(".glb") for name in files), files)
        self.assertIn("spherical_harmonics", json.dumps(told))
        lightmap = next(pathlib.Path("baked").glob("*.exr"))
        before = lightmap.read_bytes()
        lightmap_time = lightmap.stat().st_mtime_ns
        self.scene().bake_files("baked", spp=16, size=(8, 8), grid=(2, 2, 1), resume=True)
        self.assertEqual((lightmap.read_bytes(), lightmap.stat().st_mtime_ns), (before, lightmap_time))
        self.assertIn("lightmaps", json.dumps(tyndall.export("baked", "exported", "godot")).lower())
        with self.assertRaises(tyndall.InputError):
            self.scene().bake_files("baked", spp=32, size=(8, 8), grid=(2, 2, 1), resume=True)

    def test_interrupts_keep_what_is_finished(self):
        shutil.rmtree("interrupted", ignore_errors=True)
        seen = []

        def stop(progress):
            seen.append(progress)
            return False

        with self.assertRaises(tyndall.Error):
            self.scene().bake_files("interrupted", spp=60000, size=(64, 64), progress=stop)
        self.assertTrue(seen and isinstance(seen[0], tyndall.Progress) and 0 <= seen[0].fraction <= 1)

    def test_unwrap(self):
        self.scene().save("level.json")
        level = next(pathlib.Path("level.files").glob("*.glb"))
        self.assertTrue(tyndall.unwrap(level, "unwrapped.glb", all_=True))
        self.assertGreater(tyndall.info("unwrapped.glb")["triangles"], 0)


class Viewer(unittest.TestCase):
    """The viewer's server."""

    def test_view(self):
        with tyndall.Scene(FOG).view(open=False, size=(32, 24), compare=None) as viewer:
            self.assertIn("<html", urllib.request.urlopen(viewer.url, timeout=20).read().decode().lower())
            self.assertIn("href", viewer._repr_html_())
        self.assertTrue(viewer.closed)
        with self.assertRaises(tyndall.InputError):
            tyndall.view("missing.json", open=False)


@unittest.skipIf(torch is None, "python3-torch is not installed")
class Torch(unittest.TestCase):
    """Tensors both ways."""

    def test_tensors_are_borrowed(self):
        density = torch.from_numpy(cloud())
        volume = tyndall.Volume(density, spacing=0.5)
        self.assertEqual(volume._grids[0].values.address, density.data_ptr())
        grad = torch.from_numpy(cloud()).requires_grad_()
        self.assertEqual(tyndall.Volume(grad)._grids[0].values.address, grad.data_ptr())
        scene, other = tyndall.Scene(FOG), tyndall.Scene(FOG)
        scene["media[0].density"], other["media[0].density"] = density, cloud()
        np.testing.assert_array_equal(scene.render().rgb, other.render().rgb)
        scene["media[0].g"] = torch.tensor(0.5)
        scene["media[0].sigma_s"] = torch.tensor([1.0, 2.0, 3.0])
        self.assertEqual(scene["media[0].sigma_s"], [1, 2, 3])
        for other in (density.to(torch.float64), density.permute(2, 1, 0), density.half(), (100 * density).to(torch.int32)):
            np.testing.assert_allclose(tyndall.Volume(other).values, other.float().numpy(), rtol=1e-6)

    def test_images_are_tensors(self):
        image = tyndall.Scene(FOG).render()
        made = torch.from_dlpack(image)
        self.assertEqual((tuple(made.shape), made.data_ptr()), (image.shape, image._core.channel("R").address))
        made[3, 5, 1] = 77
        self.assertEqual(image["G"][3, 5], 77)
        field = tyndall.Scene(FOG).solve("fld", resolution=8).fluence(size=4)
        self.assertEqual(tuple(torch.from_numpy(field.values).shape), (4, 4, 4, 3))

    def test_pictures_and_meshes(self):
        picture, depth = torch.rand(16, 24, 3), torch.full((16, 24), 10.0)
        image = tyndall.screen(picture, depth, {"sigma_s": 0, "sigma_a": 0.05})
        np.testing.assert_allclose(image.rgb, picture.numpy() * math.exp(-0.5), rtol=1e-4)
        mesh = tyndall.Mesh(torch.tensor(QUAD[0], dtype=torch.float32), torch.tensor(QUAD[1]))
        scene = tyndall.Scene(FOG)
        scene.add_geometry(mesh, material={"base_color": 0.5})
        self.assertEqual(scene.info["triangles"], 2)
        self.assertEqual(textured(torch.rand(4, 4, 3)).info["textures"], 1)


if __name__ == "__main__":
    if np is None:
        print("skipped: python3-numpy is not installed")
        sys.exit(0)
    if TOOL is not None:
        os.environ["TYNDALL"] = TOOL
    logging.basicConfig(level=logging.ERROR)
    if torch is None:
        print("skipped in part: python3-torch is not installed")
    unittest.main(verbosity=1)
