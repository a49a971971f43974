#!/usr/bin/env python3
"""The Python package: gradients and fluxes, fog over images, comparisons, bakes, denoising, and files.
usage: PYTHONPATH=BUILD/python test_python_tools.py TYNDALL [unittest arguments] (works in the current folder)"""
import pathlib
import unittest

import tyndall
from python_cases import FOG, cloud, needs_numpy, np, run, xarray


@needs_numpy
class Gradients(unittest.TestCase):
    """Derivatives of a loss, and fluxes."""

    def scene(self, density):
        medium = {"density": density, "bounds": [[-1, -1, -1], [1, 1, 1]], "sigma_s": 5, "sigma_a": 0.2}
        return tyndall.Scene({"media": [medium], "lights": FOG["lights"]})

    def loss(self, density, weights, method, options):
        light = self.scene(density).solve(method, **options)
        return float((weights * light.fluence(size=6).values).sum())

    def test_voxels_agree_with_differences(self):
        self.check_voxels("fld", tolerance=1e-6)

    def test_voxels_of_dom(self):
        self.check_voxels("dom", differentiable=True, tolerance=1e-6, resolution=10, directions=48)

    def check_voxels(self, method, **options):
        density = cloud() + np.float32(0.1)
        random = np.random.default_rng(4)
        weights = random.uniform(0, 1, (6, 6, 6))[..., None] * np.ones(3)
        step = (0.01 * random.uniform(0, 1, density.shape)).astype(np.float32)
        scene = self.scene(density)
        light = scene.solve(method, **options)
        gradient = light.gradient(weights, size=6)
        self.assertTrue(gradient.stats["converged"])
        self.assertEqual(gradient.density().shape, density.shape)
        self.assertEqual(gradient.extinction.shape, density.shape)
        losses = [self.loss(density + sign * step, weights, method, options) for sign in (1, -1)]
        difference = (losses[0] - losses[1]) / 2
        self.assertAlmostEqual(float((gradient.density() * step).sum()) / difference, 1, delta=1e-3)
        total = float((weights * light.fluence(size=6).values).sum())
        self.assertAlmostEqual(gradient.lights.sum() / total, 1, delta=1e-5)  # the loss is linear in the light
        self.assertEqual(set(gradient.medium()), {"sigma_s", "sigma_a", "g"})
        same = light.gradient(weights[..., 0], size=6)
        np.testing.assert_array_equal(same.density(), gradient.density())

    def test_errors(self):
        light = tyndall.Scene(FOG).solve("fld")
        with self.assertRaisesRegex(tyndall.ArgumentError, "shape"):
            light.gradient(np.zeros((2, 2, 2)), size=3)
        with self.assertRaisesRegex(tyndall.ArgumentError, "voxels"):
            light.gradient(np.zeros((3, 3, 3)), size=3).density()
        with self.assertRaisesRegex(tyndall.ArgumentError, "dom.differentiable"):
            tyndall.Scene(FOG).solve("dom").gradient(np.zeros((3, 3, 3)), size=3)
        with self.assertRaisesRegex(tyndall.ArgumentError, "not of pop"):
            tyndall.Scene(FOG).solve("pop").gradient(np.zeros((3, 3, 3)), size=3)

    def test_flux(self):
        flux = tyndall.Scene("builtin:step_cloud").flux([0, 250], columns=(4, 1), views=[[0, 0]], spp=256)
        self.assertEqual(flux.up.shape, (2, 1, 4, 3))
        self.assertEqual(flux.absorbed.shape, (1, 4, 3))
        self.assertEqual(flux.radiance.shape, (1, 1, 4, 3))
        # What comes in leaves, upwards, downwards or into the cloud.
        leaves = flux.up[1].mean() + flux.down[0].mean() + flux.absorbed.mean()
        self.assertAlmostEqual(leaves / flux.down[1].mean(), 1, delta=0.05)
        self.assertTrue((flux.errors["up"][1] > 0).all())


class Tools(unittest.TestCase):
    """Fog over images, comparisons, bakes, denoising, files."""

    @needs_numpy
    def test_screen(self):
        picture = np.zeros((32, 48, 4), np.float32)
        picture[..., :3] = 1
        depth = np.full((32, 48), 10, np.float32)
        flipped = np.flip(depth, 1)
        image = tyndall.screen(picture, flipped, {"sigma_s": 0, "sigma_a": 0.05}, fov_y=50)
        np.testing.assert_allclose(image.rgb, np.exp(-0.5), rtol=1e-4)
        fog = tyndall.screen(tyndall.Image(picture[..., :3]), depth, "fog:50")
        self.assertGreater(1, fog.rgb.max())
        holes = depth.copy()
        holes[10:14, 20:30] = 0
        filled = tyndall.screen(picture, holes, {"sigma_s": 0, "sigma_a": 0.05}, fill=True)
        np.testing.assert_allclose(filled.rgb, np.exp(-0.5), rtol=1e-4)
        self.assertEqual((filled.stats["filled"], holes[12, 25]), (40, 0))
        for variant in ("gather", "naive", "published", "reference"):
            self.assertGreater(tyndall.screen(picture, depth, variant=variant).rgb.max(), 0)
        with self.assertRaisesRegex(tyndall.Error, "fogg"):
            tyndall.screen(picture, depth, "fogg:50")
        with self.assertRaisesRegex(tyndall.Error, "variant: unknown"):
            tyndall.screen(picture, depth, variant="sharp")

    def test_compare(self):
        table = tyndall.compare(tyndall.Scene(FOG), ["dom", "screen", "nothing"], spp=16, block=4)
        self.assertEqual([row["method"] for row in table], ["dom", "screen", "nothing"])
        self.assertLess(abs(table[0]["mean_ratio"] - 1), 0.1)
        self.assertIn("no method nothing", table[2]["error"])
        self.assertIn("relative RMSE", repr(table))
        self.assertIn("data:image/png", table._repr_html_())

    @needs_numpy
    def test_bake(self):
        scene = tyndall.Scene({"lights": [{"type": "environment", "radiance": 1}]})
        corners = [[-1, 0, -1], [-1, 0, 1], [1, 0, 1], [1, 0, -1]]
        scene.add_geometry(tyndall.Mesh(corners, [[0, 1, 2], [0, 2, 3]], uv=[[0, 0], [0, 1], [1, 1], [1, 0]]))
        texels = scene.bake("lightmap", width=8, height=8, spp=64)
        np.testing.assert_allclose(texels.rgb[2:6, 2:6].mean(), np.pi, rtol=0.05)  # irradiance of a sky of radiance 1
        vertices = scene.bake("vertices", spp=64)
        self.assertEqual(vertices.size, (4, 1))
        probes = scene.bake("probes", positions=[[0, 1, 0], [0, 2, 0]], spp=64)
        self.assertEqual(probes.size, (2, 1))
        box = tyndall.Box((-1, 1, -1), (1, 2, 1), (2, 1, 2))
        self.assertEqual(scene.bake("probes", grid=box, spp=4).size, (2, 2))
        with self.assertRaisesRegex(tyndall.Error, "spp"):
            scene.bake("vertices", spp=0)
        with self.assertRaisesRegex(tyndall.ArgumentError, "terms: 7"):
            scene.bake("probes", grid=box, terms=7)

    @needs_numpy
    def test_denoise(self):
        scene = tyndall.Scene(FOG)
        noisy = scene.render(spp=8, channels=tyndall.DENOISE_CHANNELS)
        clean = noisy.denoise()
        truth = scene.render(spp=512, seed=1)
        self.assertLess(clean.diff(truth)["relative_rmse"][3], noisy.diff(truth)["relative_rmse"][3])
        self.assertIn("error", clean.layers)
        self.assertGreater(clean.stats["raw_error"], clean.stats["error"])
        crop = scene.render(spp=8, channels=tyndall.DENOISE_CHANNELS, crop=(8, 4, 12, 8))
        self.assertEqual(crop.denoise().frame, crop.frame)

    @needs_numpy
    def test_volume_files(self):
        volume = tyndall.Volume(cloud(), spacing=0.5, origin=(1, 2, 3))
        for name in ("cloud.vdb", "cloud.nvdb", "cloud.nrrd", "cloud.vti", "cloud.vol"):
            volume.save(name)
            read = tyndall.Volume.read(name)
            self.assertIn("grids", tyndall.info(name))
            self.assertAlmostEqual(read.info["max"], volume.info["max"], 5, name)
            self.assertAlmostEqual(read.info["placement"][0], 0.5, 6, name)
        cloud().tofile("cloud.raw")
        raw = tyndall.Volume.read("cloud.raw", raw={"size": (12, 12, 12), "type": "float"})
        np.testing.assert_array_equal(raw.values, cloud())

    def test_named_grids(self):
        """Of a file with two, the one that is named is read, or none."""
        arrays = "".join(f'<DataArray type="Float32" Name="{name}" format="ascii">{value} {value}</DataArray>'
                         for name, value in (("density", 1), ("heat", 7)))
        pathlib.Path("two.vti").write_text(
            '<VTKFile type="ImageData"><ImageData WholeExtent="0 1 0 0 0 0"><Piece Extent="0 1 0 0 0 0"><PointData>'
            f"{arrays}</PointData></Piece></ImageData></VTKFile>", encoding="utf-8")
        self.assertEqual([grid["name"] for grid in tyndall.info("two.vti")["grids"]], ["density", "heat"])
        self.assertEqual(tyndall.Volume.read("two.vti").info["max"], 1)
        self.assertEqual(tyndall.Volume.read("two.vti", "heat").info["max"], 7)
        with self.assertRaisesRegex(tyndall.InputError, "ice"):
            tyndall.Volume.read("two.vti", "ice")

    def test_long_lists(self):
        names = [f"m{i}" for i in range(70)]
        pathlib.Path("many.mtl").write_text("".join(f"newmtl {name}\nKd 0.5 0.5 0.5\n" for name in names))
        faces = "".join(f"usemtl {name}\nf 1 2 3\n" for name in names)
        pathlib.Path("many.obj").write_text(f"mtllib many.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n{faces}")
        self.assertEqual(len(tyndall.info("many.obj")["entries"]), 70)

    @needs_numpy
    def test_the_pages_examples_run(self):
        """The first example of docs/python.md, with fewer pixels, and its fields."""
        page = (pathlib.Path(__file__).resolve().parent.parent / "docs" / "python.md").read_text(encoding="utf-8")
        blocks = [block.split("```")[0] for block in page.split("```python")[1:]]
        names = {}
        exec(blocks[0].replace("(320, 240)", "(32, 24)"), names)
        picture = tyndall.read("cloud.png").rgb
        self.assertEqual(picture.shape, (24, 32, 3))
        self.assertGreater(picture[11, 16, 0], 1.5 * picture[0, 0, 0])  # white before a blue sky
        self.assertLessEqual(len(blocks[0].strip().splitlines()), 10)
        if xarray is not None:
            exec(blocks[1].replace("size=32", "size=4"), names)
            self.assertEqual(names["field"].values.shape, (4, 4, 4, 3))

    def test_facts(self):
        self.assertIn("path", tyndall.methods())
        self.assertEqual(tyndall.presets()["Fog"] if "Fog" in tyndall.presets() else "visibility", "visibility")
        self.assertEqual(len(tyndall.medium("fog:50")["sigma_s"]), 3)
        self.assertGreater(tyndall.blackbody(3000)[0], tyndall.blackbody(3000)[2])
        self.assertEqual(tyndall.__version__, tyndall.read.__globals__["_core"].version)
        self.assertGreaterEqual(tyndall.Context(threads=3).threads, 3)
        with self.assertRaises(tyndall.ArgumentError):
            tyndall.Context(threads=0)



if __name__ == "__main__":
    run()
