#!/usr/bin/env python3
"""`tyndall view` as its clients see it: what is shown is what `tyndall render` writes, changes of several clients, what is saved,
what is refused; and the page in a headless browser where there is one.
usage: test_view.py TYNDALL"""
import atexit, itertools, json, math, os, re, shutil, signal, struct, subprocess, sys, tempfile, threading, time
import test_view_page as pages
from websocket import BINARY, TEXT, Refused, WebSocket, request

TYNDALL = sys.argv[1]
WIDTH, HEIGHT = 96, 64
SIZE = f"{WIDTH}x{HEIGHT}"
METHOD, PATH = 0, 1
WAIT = 120  # seconds, for a slow and busy machine

SCENE = """{
\t"tyndall": 1,
\t"camera": { "position": [0, 0, 4], "target": [0, 0, 0], "fov_y": 40, "resolution": [96, 64] },
\t"media": [
\t\t{ "name": "ball", "bounds": { "sphere": { "center": [0, 0, 0], "radius": 1 } },  "sigma_t": 2.50, "albedo": 0.9, "g": 0.4 }
\t],
\t"lights": [ { "type": "directional", "direction": [1, -1, -0.5], "irradiance": 3 } ],
\t"render": { "method": "fld", "spp": 8 }
}
"""


class Viewer:
    def __init__(self, scene, *options, launcher=()):
        self.process = subprocess.Popen([*launcher, TYNDALL, "view", scene, "--no-open", *options], stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE, text=True)
        atexit.register(self.process.kill)  # where a check fails
        self.address = self.process.stdout.readline().strip()
        found = re.fullmatch(r"http://127\.0\.0\.1:(\d+)/\?token=([0-9a-f]{32})", self.address)
        assert found, (self.address, self.process.stderr.read() if self.process.poll() is not None else "")
        self.port, self.token = int(found[1]), found[2]

    def connect(self):
        return Client(self)

    def image(self, channel):
        return request(self.port, f"/image.exr?token={self.token}&channel={channel}")

    def stop(self, number=signal.SIGINT):
        self.process.send_signal(number)
        rest, errors = self.process.communicate(timeout=WAIT)
        assert rest == "", rest
        return self.process.returncode, errors


class Client:
    def __init__(self, viewer):
        self.socket = WebSocket(viewer.port, f"/live?token={viewer.token}", origin=f"http://127.0.0.1:{viewer.port}")
        self.frames, self.status, self.scene, self.ids = {}, None, None, 0
        self.welcome = self.next("welcome")

    def send(self, type, **members):
        self.ids += 1
        self.socket.send(json.dumps({"type": type, **members} | ({} if type in ("camera", "view") else {"id": self.ids})))
        return self.ids

    def read(self):
        """The next message: a parsed text, or None for a frame, which is kept and acknowledged."""
        opcode, data = self.socket.receive()
        if opcode == TEXT:
            message = json.loads(data)
            if message["type"] == "status":
                self.status = message
            if message["type"] == "scene":
                self.scene = message
            return message
        assert opcode == BINARY, (opcode, data)
        magic, channel, codec, _, sequence, revision, width, height, full, _, spp, _, _, final = \
            struct.unpack_from("<4sBBHIIHHHHfffI", data)
        assert magic == b"TYF1" and codec == 0 and len(data) == 64 + 6 * width * height
        self.socket.send(json.dumps({"type": "ack", "channel": channel, "sequence": sequence}))
        self.frames[channel] = {"revision": revision, "width": width, "height": height, "final": final == 1,
                                "coarse": width < full, "pixels": data[64:]}
        return None

    def wait(self, condition, what):
        deadline = time.monotonic() + WAIT
        while not condition():
            assert time.monotonic() < deadline, (what, self.status)
            self.read()

    def next(self, *types, id=None):
        deadline = time.monotonic() + WAIT
        while time.monotonic() < deadline:
            message = self.read()
            if message is not None and message["type"] in types and (id is None or message.get("id") == id):
                return message
        raise AssertionError(types)

    def wait_final(self, revision=0):
        def final():
            frame = self.frames.get(METHOD)
            return frame is not None and frame["final"] and frame["revision"] >= revision
        self.wait(final, "a final image")
        return self.frames[METHOD]

    def set(self, path, value, moving=False):
        self.send("set", changes=[{"path": path, "value": value}], moving=moving)
        return self.next("scene")["revision"]

    def refused(self, type, **members):
        return self.next("error", id=self.send(type, **members))["text"]


def write_exr(path, frame):
    """An uncompressed EXR of the halves of a frame."""
    width, height, pixels = frame["width"], frame["height"], frame["pixels"]
    values = struct.unpack(f"<{3 * width * height}H", pixels)
    text = lambda name, type, value: name + b"\0" + type + b"\0" + struct.pack("<I", len(value)) + value
    channels = b"".join(name + b"\0" + struct.pack("<IIII", 1, 0, 1, 1) for name in (b"B", b"G", b"R")) + b"\0"
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = b"\x76\x2f\x31\x01" + struct.pack("<I", 2) + text(b"channels", b"chlist", channels) \
        + text(b"compression", b"compression", b"\0") + text(b"dataWindow", b"box2i", box) \
        + text(b"displayWindow", b"box2i", box) + text(b"lineOrder", b"lineOrder", b"\0") \
        + text(b"pixelAspectRatio", b"float", struct.pack("<f", 1)) \
        + text(b"screenWindowCenter", b"v2f", bytes(8)) + text(b"screenWindowWidth", b"float", struct.pack("<f", 1)) + b"\0"
    line = 8 + 6 * width
    start = len(header) + 8 * height
    rows = [struct.pack("<iI", y, 6 * width) + b"".join(
        struct.pack(f"<{width}H", *values[3 * width * y + c:3 * width * (y + 1):3]) for c in (2, 1, 0)) for y in range(height)]
    with open(path, "wb") as file:
        file.write(header + struct.pack(f"<{height}Q", *(start + line * y for y in range(height))) + b"".join(rows))


def difference(a, b):
    out = subprocess.run([TYNDALL, "diff", a, b, "--json"], capture_output=True, text=True)
    assert out.stdout, out.stderr
    return json.loads(out.stdout)


def render(*arguments):
    out = subprocess.run([TYNDALL, "render", *arguments, "-q"], capture_output=True, text=True)
    assert out.returncode == 0, out.stderr


def check_images(viewer, client):
    """The final image is that of `tyndall render`, the frame its halves, and the edited scene and command give it, too."""
    client.wait_final()
    revision = client.set("media[0].g", 0.75)
    frame = client.wait_final(revision)
    status, headers, body = viewer.image("method")
    assert status == 200 and body[:4] == b"\x76\x2f\x31\x01", (status, headers)
    open("live.exr", "wb").write(body)
    write_exr("frame.exr", frame)  # halves differ by at most 2^-12 of a value, and values by several times from the mean
    found = difference("frame.exr", "live.exr")
    assert found["all"]["relative_rmse"] < 6e-4 and abs(found["all"]["mean_ratio"] - 1) < 1e-4, found

    done = client.next("done", id=client.send("document"))
    open("saved.json", "w").write(done["json"])
    assert done["json"] == SCENE.replace("0.4", "0.75"), done["json"]
    assert done["command"].startswith("tyndall render ") and "media[0].g=0.75" in done["command"], done["command"]
    render("saved.json", "-o", "saved.exr")
    assert subprocess.run(done["command"].replace("tyndall", f"'{TYNDALL}'", 1), shell=True, capture_output=True).returncode == 0
    for other in ("saved.exr", "out.exr"):
        assert difference("live.exr", other)["differing"] == 0, other
    client.set("media[0].g", 0.4)


def check_coarse(client):
    """While something moves images are coarse, and at rest they become final."""
    client.wait_final()
    for step in range(4):
        revision = client.set("media[0].sigma_t", 2.6 + 0.1 * step, moving=True)
        client.wait(lambda: client.frames[METHOD]["revision"] >= revision, "a coarse image")
        assert not client.frames[METHOD]["final"]
    client.send("camera", position=[0.5, 0, 4], moving=True)
    assert client.next("scene")["changed"] == ["camera.position"]
    assert client.wait_final(revision + 1)["width"] == WIDTH
    client.set("media[0].sigma_t", 2.5)
    client.set("camera.position", [0, 0, 4])


def check_surfaces():
    """Surfaces, which are traced beside the light of media, are those of `tyndall render`; a camera that moves faster than
    images come is followed all the same."""
    document = json.loads(SCENE)
    document["geometry"] = [{"quad": {"origin": [-5, -1, 5], "u": [10, 0, 0], "v": [0, 0, -10]}, "material": {"albedo": 0.5}}]
    document["render"]["spp"] = 64
    json.dump(document, open("floor.json", "w"))
    viewer = Viewer("floor.json", "--no-compare", "--threads", "2")
    client = viewer.connect()
    client.wait_final()
    open("live_floor.exr", "wb").write(viewer.image("method")[2])
    render("floor.json", "-o", "floor.exr")
    found = difference("live_floor.exr", "floor.exr")["all"]
    assert abs(found["mean_ratio"] - 1) < 0.02 and found["relative_rmse"] < 0.2, found
    client.send("view", width=8 * WIDTH, height=8 * HEIGHT)
    revision = client.set("media[0].g", 0.3)
    moved = threading.Event()

    def move():
        for step in itertools.count():
            client.send("camera", position=[0.01 * (step % 50), 0, 4], moving=True)
            if moved.wait(0.004):
                return
    mover = threading.Thread(target=move)
    mover.start()
    for _ in range(3):
        client.wait(lambda: METHOD in client.frames and client.frames[METHOD]["revision"] > revision, "an image of a moving camera")
        revision = client.frames[METHOD]["revision"]
    moved.set()
    mover.join()
    client.wait_final(revision + 1)
    assert viewer.stop()[0] == 0


def check_milk():
    """Media in dielectrics, which the fast methods solve beside their own light, are those of `tyndall render`; a method that
    does not see them says so."""
    document = json.loads(SCENE)
    document["media"][0].update({"sigma_t": 8, "g": 0.5})
    document["geometry"] = [{"sphere": {"center": [0, 0, 0], "radius": 1},
                             "material": {"base_color": 1, "transmission": 1, "ior": 1.33, "roughness": 0, "volume": {}}}]
    document["render"]["spp"] = 16
    json.dump(document, open("milk.json", "w"))
    viewer = Viewer("milk.json", "--no-compare", "--threads", "2")
    client = viewer.connect()
    for method in ("fld", "dom"):
        client.send("view", method=method)
        client.wait(lambda: client.status and client.status["method"] == method and client.status["final"], f"{method}'s image")
        client.wait_final()
        assert client.status["message"] == "", client.status
        open("live_milk.exr", "wb").write(viewer.image("method")[2])
        render("milk.json", "--method", method, "-o", "milk.exr")
        found = difference("live_milk.exr", "milk.exr")["all"]
        assert abs(found["mean_ratio"] - 1) < 0.03, (method, found)
    revision = client.set("media[0].albedo", 0.5, moving=True)
    client.wait(lambda: client.frames[METHOD]["revision"] >= revision, "a coarse image of milk")
    client.send("view", method="lpv")
    client.wait(lambda: client.status["method"] == "lpv" and client.status["message"] != "", "what lpv does not show")
    assert "solid dielectrics are opaque" in client.status["message"], client.status
    assert viewer.stop()[0] == 0


def check_methods(client):
    for method in ("pop", "dom", "octaves", "lpv", "path"):
        client.send("view", method=method)
        client.wait(lambda: client.status is not None and client.status["method"] == method, method)
        client.wait(lambda: client.status["final"] or client.status["message"], method)
        assert client.status["method"] == method and client.status["message"] == "", client.status
    client.send("view", method="nonsense")
    assert "nonsense" in client.next("error")["text"]
    lights = client.welcome["document"]["lights"]
    client.send("view", method="pop")
    client.set("lights", [{"type": "environment", "radiance": 1}])
    revision = client.set("camera.position", [1, 0, 4])  # which only light that keeps its lobes can be viewed from
    client.wait_final(revision)
    client.wait(lambda: client.status["revision"] >= revision, "the status of the moved camera")
    assert client.status["message"] == "", client.status
    client.set("camera.position", [0, 0, 4])
    client.send("view", method="lpv")
    client.wait(lambda: client.status["method"] == "lpv" and client.status["final"], "a sky by lpv")
    assert client.status["message"] == "", client.status
    media = client.welcome["document"]["media"]
    client.set("media", [])
    client.wait(lambda: client.status["method"] == "lpv" and "neither media" in client.status["message"], "the refusal of a method")
    client.set("media", media)
    client.set("lights", lights)
    client.send("view", method="fld")
    client.wait(lambda: client.status["method"] == "fld" and client.status["message"] == "", "fld again")


def check_difference(client):
    """The numbers beside path: plausible for this scene, and the noise falls while path converges."""
    client.set("media[0].albedo", 0.8)
    client.wait_final(client.scene["revision"])
    found = lambda: client.status["difference"]
    revision = client.scene["revision"]
    client.wait(lambda: client.status["revision"] == revision and found() is not None, "a difference")
    first = found()["noise"]
    client.wait(lambda: found()["noise"] < 0.6 * first, "less noise")
    last = found()
    assert 0.85 < last["mean_ratio"] < 1.15 and last["noise"] < last["rmse"] < 0.5, last
    assert client.status["path"]["spp"] >= 4, client.status
    client.set("media[0].albedo", 0.9)


def check_unchanged(client):
    """A change to what is there already is answered with its id, and makes no revision."""
    revision = client.set("media[0].g", 0.5)
    for value in (0.5, 0.50):
        done = client.next("done", "error", "scene", id=client.send("set", changes=[{"path": "media[0].g", "value": value}]))
        assert done["type"] == "done" and done["revision"] == revision, done
    client.set("media[0].g", 0.4)


def check_refusals(viewer, client):
    before = client.welcome["document"]
    assert client.refused("set", changes=[{"path": "media[0].g", "value": 1.5}]).startswith("media[0].g: "), "range"
    assert "colour" in client.refused("set", changes=[{"path": "media[0].colour", "value": 1}])
    assert client.refused("set", changes=[{"path": "media[0].g", "value": 0.1}, {"path": "media[0].albedo", "value": 2}])
    assert client.refused("set", changes=[]) and client.refused("set") and client.refused("bogus", a=1)
    assert client.refused("record", name="../x.exr") and client.refused("record", name="x.txt")
    for text in ("", "{", "[]", "null", '{"type": 1}', "x" * 1000, '{"type":"set","type":"set"}', "[" * 5000):
        client.socket.send(text)
        assert client.next("error")["text"]
    for text in ('{"type":"camera","position":[1,2]}', '{"type":"camera","fov_y":"wide"}', '{"type":"view","width":3}'):
        client.socket.send(text)
        assert client.next("error")["text"]
    assert viewer.connect().welcome["document"] == before
    for target in ("/", "/?token=0", "/image.exr?channel=method", "/live"):
        assert request(viewer.port, target)[0] in (403, 426), target
    try:
        WebSocket(viewer.port, f"/live?token={viewer.token[::-1]}")
        raise AssertionError("a wrong token")
    except Refused:
        pass


def check_clients(viewer, client):
    """A change of one client reaches the other; one that comes later sees it; one that leaves holds nothing up."""
    second = viewer.connect()
    second.wait_final()
    revision = client.set("media[0].g", 0.2)
    second.wait(lambda: second.scene is not None and second.scene["revision"] == revision, "the other's change")
    assert second.scene["document"]["media"][0]["g"] == 0.2 and second.scene["changed"] == ["media[0].g"]
    second.wait_final(revision)
    second.socket.close()
    third = viewer.connect()
    assert third.welcome["document"]["media"][0]["g"] == 0.2 and third.welcome["original"]["media"][0]["g"] == 0.4
    third.wait_final(revision)
    client.set("media[0].g", 0.4)


def check_record(client):
    client.wait_final(client.scene["revision"])
    for name in ("a.exr", "a.png"):
        done = client.next("done", "error", id=client.send("record", name=name))
        assert done["type"] == "done" and os.path.getsize(f"frames/{name}") > 100, done


# ---- photographs through screen ----

PHOTO = ("photo.exr", "--medium", "fog:40", "--environment", "0.5", "--balance", "--sky", "20")


def check_photo():
    """What is shown is what `tyndall screen` writes; beside it the photograph; options change like keys of a scene."""
    render("builtin:demo", "-o", "photo.exr", "--size", SIZE, "--spp", "4", "--aov", "depth")
    viewer = Viewer(*PHOTO, "--record", "frames")
    client = viewer.connect()
    welcome = client.welcome
    assert welcome["kind"] == welcome["reference"] == "photograph" and "camera" not in welcome["view"], welcome["view"]
    assert welcome["document"] == {"medium": {"preset": "fog", "visibility": 40}, "environment": 0.5, "balance": True,
                                   "sky": 20}, welcome["document"]
    assert (welcome["view"]["width"], welcome["view"]["height"], welcome["view"]["curve"]) == (WIDTH, HEIGHT, "filmic")
    client.wait_final()
    client.wait(lambda: PATH in client.frames, "the photograph")
    open("before.exr", "wb").write(viewer.image("path")[2])
    assert difference("before.exr", "photo.exr")["differing"] == 0

    def same_as_command(*words):
        client.wait_final(client.scene["revision"] if client.scene else 1)
        done = client.next("done", id=client.send("document"))
        assert done["command"].startswith("tyndall screen photo.exr --medium "), done
        assert all(word in done["command"] for word in words), done["command"]
        out = subprocess.run(done["command"].replace("tyndall", f"'{TYNDALL}'", 1), shell=True, capture_output=True)
        assert out.returncode == 0, out.stderr
        open("live.exr", "wb").write(viewer.image("method")[2])
        assert difference("live.exr", "out.exr")["differing"] == 0, done["command"]
        return json.loads(done["json"])

    assert same_as_command("fog:40", "--environment 0.5", "--balance") == {"preset": "fog", "visibility": 40}
    client.set("medium", {"sigma_s": [0.02, 0.03, 0.05], "sigma_a": 0.001, "g": 0.8})
    client.set("medium.sigma_s[1]", 0.04)
    for key, value in (("spread", "gaussian"), ("filter", "6"), ("levels", 3), ("sky", 500), ("environment", [0.1, 0.2, 0.4]),
                       ("balance", None), ("distance-scale", 2), ("fov-y", 70)):
        client.set(key, value)
    kept = same_as_command("--spread gaussian", "--filter 6", "--levels 3", "--sky 500", "--environment 0.1,0.2,0.4",
                           "--distance-scale 2", "--fov-y 70")
    assert kept == {"sigma_s": [0.02, 0.04, 0.05], "sigma_a": 0.001, "g": 0.8}, kept
    client.set("variant", "gather")  # spread belongs to scatter, and waits until that comes back
    client.set("mask", "step")
    same_as_command("--variant gather", "--mask step")
    client.set("sky", "fill")
    client.set("variant", "reference")
    client.set("window", 9)
    same_as_command("--window 9", "--sky fill")
    client.set("variant", None)
    same_as_command("--spread gaussian")

    revision = client.scene["revision"]
    for path, value, text in (("medium.visibility", 3, "medium"), ("medium.density", 1, "medium.density: "), ("variant", "x", "variant: "),
                              ("medium", None, "medium"), ("environment", "none.exr", "none.exr"), ("environment", -1, "environment"),
                              ("distance-channel", "Q", "Q"), ("focal", 50, "fov-y"), ("levels", 99, "levels: "), ("spp", 4, "spp")):
        refused = client.refused("set", changes=[{"path": path, "value": value}])
        assert text in refused and "--help" not in refused, refused
    client.send("view", width=50, height=50)
    assert "own size" in client.next("error")["text"]
    client.send("camera", position=[0, 0, 0])
    assert client.next("error")["text"]
    assert viewer.connect().welcome["revision"] == revision
    done = client.next("done", id=client.send("record", name="photo.png"))
    assert os.path.getsize(done["file"]) > 100
    for step in range(20):
        moved = client.set("medium.sigma_a", 0.001 * step, moving=True)
    client.wait_final(moved)
    assert viewer.stop() == (0, "view: Ctrl-C ends it\n")


def check_slow_photo():
    """Images while something moves are smaller where the whole takes long, and look like it."""
    render("builtin:demo", "-o", "slow.exr", "--size", "240x160", "--spp", "4", "--aov", "depth")
    viewer = Viewer("slow.exr", "--medium", "fog:40", "--environment", "0.5", "--sky", "20", "--variant", "reference", "--threads", "1")
    client = viewer.connect()
    mean = lambda frame: sum(struct.unpack(f"<{len(frame['pixels']) // 2}e", frame["pixels"])) * 2 / len(frame["pixels"])
    client.wait_final()
    for step in range(8):
        before = client.frames[METHOD]["revision"]
        client.send("set", changes=[{"path": "medium.visibility", "value": 41 + step}], moving=True)
        client.wait(lambda: client.frames[METHOD]["revision"] > before, "the image of a change")
        coarse = client.frames[METHOD]
        assert coarse["coarse"] and not coarse["final"], coarse["width"]
    final = client.wait_final(coarse["revision"])
    # 60 x 40 pixels were 9 % brighter, the 34 x 22 of a machine that is slow by sanitizers 38 %
    bound = 0.15 if coarse["width"] >= 60 else 0.5
    assert final["width"] == 240 and abs(mean(coarse) / mean(final) - 1) < bound, (coarse["width"], mean(coarse), mean(final))
    viewer.stop()


# ---- the page ----

def write_frames(last):
    """A sequence of volumes, and a scene of it."""
    for frame in range(last + 1):
        values = [1 + frame + (x + y + z) % 3 for z in range(6) for y in range(6) for x in range(6)]
        head = "NRRD0004\ntype: float\ndimension: 3\nsizes: 6 6 6\nencoding: raw\nendian: little\n\n"
        open(f"puff_{frame:02}.nrrd", "wb").write(head.encode() + struct.pack("<216f", *values))
    scene = json.loads(SCENE)
    scene["media"][0] |= {"density": {"file": "puff_##.nrrd"}, "bounds": [[-1, -1, -1], [1, 1, 1]], "sigma_t": 0.5}
    open("frames.json", "w").write(json.dumps(scene))


def check_sequence(pages):
    last = 4
    write_frames(last)
    viewer = Viewer("frames.json", "--record", "frames", "--no-compare")
    found = pages.sequence(viewer.address, os.path.abspath("frames"), last)
    for frame in range(last + 1 if found != 77 else 0):
        render("frames.json", "-o", "frame.exr", "-D", f"frame={frame}", "--size", SIZE)
        assert difference(f"frames/take_{frame:04}.exr", "frame.exr")["differing"] == 0, frame
    viewer.stop()


def check_kept(pages):
    """The page's probe has the values of the EXR, and what it saves is the scene with the changed value alone."""
    viewer, found = Viewer("scene.json", "--no-compare", "--threads", "2"), {}
    client = viewer.connect()
    client.wait_final(client.set("media[0].g", 0.65))
    pages.kept(viewer.address, found)
    width, height = found["size"]
    write_exr("probed.exr", {"width": width, "height": height, "pixels": struct.pack(f"<{3 * width * height}e", *found["pixels"])})
    open("kept.exr", "wb").write(viewer.image("method")[2])
    difference_of = difference("probed.exr", "kept.exr")["all"]  # as in check_images
    assert difference_of["relative_rmse"] < 6e-4 and abs(difference_of["mean_ratio"] - 1) < 1e-4, difference_of
    assert found["json"] == SCENE.replace("0.4", "0.65"), found["json"]
    open("kept.json", "w").write(found["json"])
    again = Viewer("kept.json", "--no-compare", "--threads", "2")
    other = again.connect()
    other.wait_final()
    open("again.exr", "wb").write(again.image("method")[2])
    assert difference("again.exr", "kept.exr")["differing"] == 0
    again.stop()
    viewer.stop()


def check_pages():
    check_kept(pages)
    check_sequence(pages)
    for arguments, row in ((("scene.json", "--no-compare"), "media[0].sigma_t"), (PHOTO, "medium.visibility")):
        other = Viewer(*arguments, "--remote")
        pages.remote(other.address, row)
        other.stop()
    other = Viewer(*PHOTO)
    pages.photo(other.address)
    other.stop()


def ranks_seconds(launcher):
    """Processor seconds of the ranks other than 0."""
    sums = {}
    for rank in open(f"/proc/{launcher}/task/{launcher}/children").read().split():
        words = open(f"/proc/{rank}/environ", "rb").read().split(b"\0")
        number = next(int(word.split(b"=")[1]) for word in words if word.startswith(b"OMPI_COMM_WORLD_RANK="))
        times = open(f"/proc/{rank}/stat").read().rpartition(")")[2].split()[11:13]
        sums[number] = sum(map(int, times)) / os.sysconf("SC_CLK_TCK")
    return [sums[number] for number in sorted(sums)]


def check_ranks():
    """Under mpirun the other ranks go on with an edited scene, whose image is that of one process."""
    if shutil.which("mpirun") is None or not os.path.exists(os.path.join(os.path.dirname(TYNDALL), "tyndall-mpi.so")):
        return
    viewer = Viewer("scene.json", "--method", "path", "--threads", "1", "--no-compare", "--size", "480x320",
                    launcher=["mpirun", "--allow-run-as-root", "--oversubscribe", "-q", "-n", "4"])
    client = viewer.connect()

    def converge(revision):
        client.wait(lambda: client.status is not None and client.status["revision"] >= revision
                    and client.status["path"]["spp"] >= 16, "16 samples")

    converge(client.set("media[0].g", 0.6))
    revision = client.set("media[0].g", 0.75)
    before = ranks_seconds(viewer.process.pid)
    converge(revision)
    used = [now - then for now, then in zip(ranks_seconds(viewer.process.pid), before)]
    assert len(used) == 4 and sum(used[1:]) > 0.1 * used[0] > 0, used  # measured 0.2 under load to 0.64
    render("scene.json", "--method", "path", "--size", "480x320", "--spp", "16", "-D", "media[0].g=0.75", "-o", "alone.exr")
    open("ranks.exr", "wb").write(viewer.image("method")[2])
    found = difference("ranks.exr", "alone.exr")["all"]
    assert abs(found["mean_ratio"] - 1) < 0.01, found  # 2.0 with g = 0.4
    viewer.stop()


def check_start():
    """What cannot start says so in one line."""
    def fails(*arguments):
        out = subprocess.run([TYNDALL, "view", *arguments], capture_output=True, text=True, timeout=WAIT)
        assert out.stdout == "" and out.stderr.startswith("tyndall: ") and out.stderr.count("\n") == 1, out
        return out.returncode
    assert fails("missing.json") == 2 and fails("scene.json", "--method", "nonsense") == 2
    assert fails("scene.json", "--medium", "fog:50") == 2 and fails("scene.json", "--sky", "fill") == 2
    assert fails("scene.json", "depth.exr") == 2 and fails("missing.exr", "--medium", "fog:50") == 2
    assert fails("missing.exr") == 2 and fails("missing.exr", "--medium", "fog:50", "--method", "path") == 2
    assert fails("missing.exr", "--medium", "fog:50", "-D", "variant=gather") == 2
    assert fails("scene.json", "-D", "media[0].g=2") == 2 and fails("scene.json", "--port", "70000") == 2


def main():
    here = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        open("scene.json", "w").write(SCENE)
        check_start()
        # Without path in the background, which takes all that processors have left, but where it is looked at.
        viewer = Viewer("scene.json", "--record", "frames", "--threads", "2", "--no-compare")
        client = viewer.connect()
        check_images(viewer, client)
        check_methods(client)
        check_record(client)
        check_unchanged(client)
        check_clients(viewer, client)
        check_refusals(viewer, client)
        taken = subprocess.run([TYNDALL, "view", "scene.json", "--port", str(viewer.port)], capture_output=True, text=True)
        assert taken.returncode == 1 and str(viewer.port) in taken.stderr, taken
        status, errors = viewer.stop()
        assert status == 0 and errors == "view: Ctrl-C ends it\n", (status, errors)
        viewer = Viewer("scene.json", "--threads", "2")
        client = viewer.connect()
        check_coarse(client)
        check_difference(client)
        page = pages.main(viewer.address)
        assert viewer.stop() == (0, "view: Ctrl-C ends it\n")
        check_photo()
        check_slow_photo()
        if page != 77:
            check_pages()
        check_surfaces()
        check_milk()
        check_ranks()
        os.chdir(here)
    print("test_view: passed" + (", but for the page: there is no browser" if page == 77 else ""))
    return 0


if __name__ == "__main__":
    sys.exit(main())
