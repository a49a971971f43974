"""tyndall render --tev and tyndall view --tev against a server that speaks tev's protocol: packets, pixels, and servers that are missing, slow or
gone. tev reads integers as little-endian, and texts to their NUL.
usage: test_cli_tev.py TYNDALL"""
import json, socket, struct, subprocess, sys, threading, time
import test_view

CREATE_IMAGE, UPDATE_IMAGE = 4, 6
NAMES = ["R", "G", "B"]
SCENE = "builtin:cube_g0"


class Reader:
    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, form):
        values = struct.unpack_from("<" + form, self.data, self.at)
        self.at += struct.calcsize("<" + form)
        return values

    def text(self):
        end = self.data.index(0, self.at)
        text, self.at = self.data[self.at:end].decode(), end + 1
        return text


class FakeTev:
    """Accepts one connection. packets_max: it closes the connection after so many packets; reads: false, never reads."""

    def __init__(self, packets_max=None, reads=True):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        self.packets_max, self.reads = packets_max, reads
        self.images, self.updates, self.packets, self.created = {}, [], 0, 0
        self.failure = None
        self.thread = threading.Thread(target=self.serve, daemon=True)
        self.thread.start()

    def serve(self):
        try:
            connection, _ = self.listener.accept()
            with connection:
                if not self.reads:
                    self.listener.accept()  # until the test is done
                    return
                file = connection.makefile("rb")
                while self.packets_max is None or self.packets < self.packets_max:
                    head = file.read(4)
                    if not head:
                        return
                    size = struct.unpack("<I", head)[0]
                    self.take(Reader(file.read(size - 4)), size - 4)
                    self.packets += 1
        except Exception as failure:
            self.failure = failure
        finally:
            self.listener.close()

    def take(self, packet, size):
        assert len(packet.data) == size, "a packet was cut off"
        kind, focus = packet.take("BB")
        name = packet.text()
        if kind == CREATE_IMAGE:
            width, height, channels = packet.take("iii")
            assert focus == 1 and [packet.text() for _ in range(channels)] == NAMES
            self.created += 1
            self.images[name] = width, height, [[0.0] * (width * height) for _ in NAMES]
        else:
            assert kind == UPDATE_IMAGE and focus == 0, kind
            assert [packet.text() for _ in range(packet.take("i")[0])] == NAMES
            self.update(packet, name)
        assert packet.at == size, "bytes are left in a packet"

    def update(self, packet, name):
        x, y, width, height = packet.take("iiii")
        offsets, strides = packet.take("qqq"), packet.take("qqq")
        full_width, full_height, planes = self.images[name]
        assert x == 0 and width == full_width and 0 <= y < y + height <= full_height
        count = width * height
        values = packet.take(f"{max(o + (count - 1) * s + 1 for o, s in zip(offsets, strides))}f")
        for plane, offset, stride in zip(planes, offsets, strides):
            plane[y * width:(y + height) * width] = values[offset:offset + (count - 1) * stride + 1:stride]
        self.updates.append((time.monotonic(), y, height, sum(map(sum, planes))))

    def join(self):
        if not self.reads:
            socket.create_connection(("127.0.0.1", self.port))
        self.thread.join(60)
        assert not self.thread.is_alive()
        if self.failure:
            raise self.failure


def run(*arguments, status=0, lines=0):
    done = subprocess.run([sys.argv[1], "render", *arguments], capture_output=True, text=True, stdin=subprocess.DEVNULL,
                          timeout=300)
    assert done.returncode == status, (done.returncode, done.stderr)
    assert done.stderr.count("\n") == lines, done.stderr
    return done


def write_exr(name, width, height, planes):
    """An uncompressed image of 32-bit floats."""
    def attribute(key, kind, value):
        return key.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<I", len(value)) + value

    channels = b"".join(c.encode() + b"\0" + struct.pack("<IIII", 2, 0, 1, 1) for c in "BGR") + b"\0"
    box = struct.pack("<iiii", 0, 0, width - 1, height - 1)
    head = struct.pack("<II", 20000630, 2) + attribute("channels", "chlist", channels) + \
        attribute("compression", "compression", b"\0") + attribute("dataWindow", "box2i", box) + \
        attribute("displayWindow", "box2i", box) + attribute("lineOrder", "lineOrder", b"\0") + \
        attribute("pixelAspectRatio", "float", struct.pack("<f", 1)) + \
        attribute("screenWindowCenter", "v2f", struct.pack("<ff", 0, 0)) + \
        attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0"
    row_size = 12 * width
    first = len(head) + 8 * height
    with open(name, "wb") as file:
        file.write(head + b"".join(struct.pack("<Q", first + y * (8 + row_size)) for y in range(height)))
        for y in range(height):
            row = [value for plane in reversed(planes) for value in plane[y * width:(y + 1) * width]]
            file.write(struct.pack("<ii", y, row_size) + struct.pack(f"<{3 * width}f", *row))


def check_same(tev, name):
    """What tev has is the file, value for value."""
    (width, height, planes), = tev.images.values()
    write_exr("tev.exr", width, height, planes)
    done = subprocess.run([sys.argv[1], "diff", "tev.exr", name, "--json"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    difference = json.loads(done.stdout)
    assert difference["all"]["rmse"] == 0 and difference["differing"] == 0, difference


def render_to(tev, name, *arguments, lines=0):
    done = run(SCENE, "-o", name, "--tev", f"127.0.0.1:{tev.port}", "--progress", "none", *arguments, lines=lines)
    tev.join()
    return done


def test_methods():
    for method in "path", "fld":
        tev = FakeTev()
        render_to(tev, f"{method}.exr", "--method", method, "--size", "37x23", "--spp", "4")
        assert list(tev.images) == [f"{method}.exr"]
        check_same(tev, f"{method}.exr")
    tev = FakeTev()
    render_to(tev, "crop.exr", "--method", "path", "--size", "64x48", "--crop", "8,8,16x12", "--spp", "4")
    assert tev.images["crop.exr"][:2] == (16, 12)


def test_bands():
    """Large images come in several packets."""
    tev = FakeTev()
    render_to(tev, "large.exr", "--method", "path", "--size", "1500x710", "--spp", "1", "--threads", "2")
    assert [update[1:3] for update in tev.updates][-2:] == [(0, 699), (699, 11)]
    check_same(tev, "large.exr")


def test_convergence():
    """Images come while path converges, at most one a second, and the last is that of the file."""
    tev = FakeTev()
    begun = time.monotonic()
    render_to(tev, "long.exr", "--method", "path", "--size", "48x32", "--time", "5", "--threads", "1")
    seconds = time.monotonic() - begun
    count = len(tev.updates)
    assert 2 <= count <= seconds + 1, (count, seconds)
    assert len({update[3] for update in tev.updates}) == count, "updates do not differ"
    for before, after in zip(tev.updates[:-2], tev.updates[1:-1]):
        assert after[0] - before[0] > 0.5, tev.updates
    check_same(tev, "long.exr")
    spp = "1000", "--threads", "1"  # more than a second of it
    run(SCENE, "-o", "plain.exr", "--method", "path", "--size", "48x32", "-q", "--spp", *spp)
    tev = FakeTev()
    render_to(tev, "shown.exr", "--method", "path", "--size", "48x32", "--spp", *spp)
    check_same(tev, "plain.exr")  # being shown changes no result


def test_failures():
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    done = run(SCENE, "-o", "no.exr", "--tev", f"127.0.0.1:{port}", status=1, lines=1)
    assert f"--tev 127.0.0.1:{port}: Connection refused" in done.stderr, done.stderr
    for address in ("", "localhost", ":14158", "localhost:", "localhost:0", "localhost:65536", "localhost:1x", "::1:14158",
                    "localhost:-1"):
        done = run(SCENE, "-o", "no.exr", "--tev", address, status=2, lines=1)
        assert "HOST:PORT" in done.stderr, done.stderr
    run(SCENE, "-o", "no.exr", "--tev", "no.such.host.invalid:14158", status=1, lines=1)
    tev = FakeTev(packets_max=2)  # the connection is lost during the render
    done = render_to(tev, "lost.exr", "--method", "path", "--size", "48x32", "--time", "4", "--threads", "1", lines=1)
    assert "warning: tev is gone" in done.stderr, done.stderr
    subprocess.run([sys.argv[1], "info", "lost.exr"], check=True, stdout=subprocess.DEVNULL)
    tev = FakeTev(reads=False)
    done = render_to(tev, "stuck.exr", "--method", "path", "--size", "1300x1200", "--spp", "1", lines=1)
    assert "warning: tev is gone" in done.stderr, done.stderr


def test_viewer():
    """The viewer's images, coarse ones enlarged, in one image of tev that ends as the method's final one; and with tev gone the
    viewer goes on."""
    tev = FakeTev()
    viewer = test_view.Viewer("builtin:cloud_sun", "--method", "fld", "--size", "48x32", "--no-compare", "--threads", "2",
                              "--tev", f"127.0.0.1:{tev.port}")
    client = viewer.connect()
    client.wait_final()
    for step in range(5):
        revision = client.set("media[0].scale", 1.1 + 0.1 * step, moving=True)
    client.wait_final(revision)
    open("live.exr", "wb").write(viewer.image("method")[2])
    assert viewer.stop() == (0, "view: Ctrl-C ends it\n")
    tev.join()
    assert tev.created == 1 and list(tev.images) == ["builtin:cloud_sun"] and len(tev.updates) >= 3, tev.created
    check_same(tev, "live.exr")
    tev = FakeTev(packets_max=2)
    viewer = test_view.Viewer("builtin:cloud_sun", "--method", "fld", "--size", "48x32", "--no-compare",
                              "--tev", f"127.0.0.1:{tev.port}")
    client = viewer.connect()
    client.wait_final()
    tev.join()
    client.wait_final(client.set("media[0].scale", 2))
    status, errors = viewer.stop()
    assert status == 0 and errors.count("\n") == 2 and "warning: tev is gone" in errors, errors
    for arguments, status in (("--tev", "nowhere"), 2), (("--tev", f"127.0.0.1:{tev.port}"), 1):
        done = subprocess.run([sys.argv[1], "view", "builtin:cloud_sun", "--no-open", *arguments], capture_output=True, text=True)
        assert done.returncode == status and done.stderr.count("\n") == 1 and "--tev" in done.stderr, done


for test in test_methods, test_bands, test_convergence, test_failures, test_viewer:
    test()
    print(test.__name__, flush=True)
