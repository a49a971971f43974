"""The viewer's server with callbacks of a test program (view_host.c): who is let in, what is refused, slow and dead
clients, and the frames bit for bit.
usage: test_view_protocol.py view_host"""
import json, math, struct, subprocess, sys, time, zlib
from websocket import BINARY, CLOSE, CONTINUATION, TEXT, PING, Refused, WebSocket, request

WIDTH, HEIGHT = 61, 23
METHOD, PATH = 0, 1


class Host:
    def __init__(self, kind="local", port=0):
        self.process = subprocess.Popen([sys.argv[1], str(port), kind], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        text=True)
        words = self.process.stdout.readline().split()
        assert words[0] == "port", words
        self.port, self.token = int(words[1]), words[3]

    def tell(self, line):
        """Gives a command; returns the number of clients."""
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()
        return int(self.process.stdout.readline().split()[1])

    def wait_for_clients(self, count):
        deadline = time.monotonic() + 60
        while self.tell("") != count:
            assert time.monotonic() < deadline, f"{self.tell('')} clients, not {count}"
            time.sleep(0.02)

    def stop(self):
        rest, _ = self.process.communicate(timeout=60)
        assert rest == "stopped, SIGPIPE ignored\n", rest
        assert self.process.returncode == 0

    def connect(self, **more):
        client = WebSocket(self.port, f"/live?token={self.token}", **more)
        assert read_text(client)["type"] == "welcome"
        return client


def read_text(client):
    opcode, data = client.receive()
    assert opcode == TEXT, (opcode, data[:100])
    return json.loads(data)


def read_frame(client):
    opcode, data = client.receive()
    assert opcode == BINARY, (opcode, data[:100])
    return data


def number_of(frame):
    return struct.unpack_from("<I", frame, 8)[0]


def revision_of(frame):
    return struct.unpack_from("<I", frame, 12)[0]


def acknowledge(client, frame):
    client.send(json.dumps({"type": "ack", "channel": frame[4], "sequence": number_of(frame)}))


def echo(client, text="hello"):
    """What the server answers to a text; all that came before was sent before."""
    client.send(text)
    return read_text(client)


def test_doors(host):
    port, token, wrong = host.port, host.token, "0" * 32
    assert len(token) == 32 and set(token) <= set("0123456789abcdef")
    status, headers, body = request(port, f"/?token={token}")
    assert status == 200 and body.startswith(b"<!doctype html>"), (status, body)
    cookie = headers["set-cookie"]
    assert cookie.startswith(f"tyndall_{port}={token};") and "HttpOnly" in cookie and "SameSite=Strict" in cookie
    for target in ("/", f"/?token={wrong}", "/?token=", f"/?token={token[:-1]}", f"/?token={token}0", "/image.exr",
                   f"/image.exr?channel=method&token={wrong}", "/live"):
        status, headers, body = request(port, target)
        assert status == 403 and body.count(b"\n") == 1, (target, status)
        assert "set-cookie" not in headers and token.encode() not in body
    assert request(port, "/", cookie=f"a=b; tyndall_{port}={token}")[0] == 200
    assert request(port, f"/?token={wrong}", cookie=f"tyndall_{port}={token}")[0] == 403
    assert request(port, "/", cookie=f"tyndall_{port}={wrong}")[0] == 403
    for host_name in (None, "", "evil.example", f"evil.example:{port}", f"127.0.0.1:{port + 1}",
                      f"127.0.0.1:{port}.evil.example", f"localhost.evil.example:{port}"):
        for target in (f"/?token={token}", "/a.js"):
            assert request(port, target, host=host_name)[0] in (400, 403), host_name
    for host_name in (f"localhost:{port}", "127.0.0.1", "localhost"):  # clients that are no browsers leave the port out
        assert request(port, f"/?token={token}", host=host_name)[0] == 200, host_name
    for origin in ("http://evil.example", "null", f"http://127.0.0.1:{port + 1}", f"https://127.0.0.1:{port}",
                   f"http://127.0.0.1:{port}@evil.example", f"127.0.0.1:{port}"):
        try:
            WebSocket(port, f"/live?token={token}", origin=origin)
            raise AssertionError(origin)
        except Refused as refused:
            assert refused.args == (403,), origin
    for target in ("/live", f"/live?token={wrong}"):
        try:
            WebSocket(port, target)
            raise AssertionError(target)
        except Refused as refused:
            assert refused.args == (403,)
    for origin in (None, f"http://127.0.0.1:{port}", f"http://localhost:{port}"):
        WebSocket(port, f"/live?token={token}", origin=origin).close()
    WebSocket(port, "/live", cookie=f"tyndall_{port}={token}", origin=f"http://127.0.0.1:{port}").close()
    host.wait_for_clients(0)


def test_requests(host):
    port, token = host.port, host.token
    expected = {"/a.js": (200, "text/javascript"), "/b.js": (404, "text/plain"), "/a.js/": (404, "text/plain"),
                "/../a.js": (200, "text/javascript"), "/%2e%2e/%2e%2e/etc/passwd": (404, "text/plain"),
                "/index.html": (404, "text/plain"), "/live/": (404, "text/plain"),
                f"/live?token={token}": (404, "text/plain"),
                f"/image.exr?token={token}&channel=method": (200, "image/x-exr"),
                f"/image.exr?token={token}&channel=path": (404, "text/plain"),
                f"/image.exr?token={token}&channel=other": (404, "text/plain"),
                f"/image.exr?token={token}": (404, "text/plain")}
    for target, (status, kind) in expected.items():
        got, headers, body = request(port, target)
        assert (got, headers["content-type"].split(";")[0]) == (status, kind), (target, got, headers)
        check_headers(port, headers)
        assert len(body) == int(headers["content-length"]), target
    assert request(port, f"/image.exr?token={token}&channel=method")[2] == b"x" * 1000000
    assert request(port, "/a.js", method="POST")[0] == 405
    assert request(port, "/a.js", method="PUT")[0] == 405
    assert request(port, "/a.js", method="HEAD")[2] == b""
    for target, method, version in (("*", "OPTIONS", "HTTP/1.1"), ("/a.js", "GET", "HTTP/9.9"), ("a.js", "GET", "HTTP/1.1"),
                                    ("/" + "a" * 100000, "GET", "HTTP/1.1")):
        status, headers, _ = request(port, target, method, version)
        assert status == 0 or 400 <= status < 600, (target[:10], status)
        if status:
            check_headers(port, headers)
    assert request(port, "/live?token=" + token, upgrade="websocket", connection="Upgrade")[0] == 400


def check_headers(port, headers):
    assert headers["cache-control"] == "no-store" and headers["x-content-type-options"] == "nosniff"
    assert headers["referrer-policy"] == "no-referrer"
    policy = headers["content-security-policy"]
    for part in ("default-src 'self'", f"ws://127.0.0.1:{port} ws://localhost:{port};", "frame-ancestors 'none'"):
        assert part in policy, policy


def test_messages(host):
    client = host.connect()
    assert echo(client) == {"type": "echo", "size": 5}
    assert echo(client, "")["size"] == 0
    assert echo(client, "\0 ü €")["size"] == 8
    assert echo(client, "x" * (1 << 20))["size"] == 1 << 20
    for part in ("hello ", "from ", "parts"):
        client.send(part, TEXT if part == "hello " else CONTINUATION, last=part == "parts")
    assert read_text(client)["size"] == 16
    client.send(b"ping", PING)
    assert echo(client)["size"] == 5
    for data in (b"\xff", b"\xc0\x80", b"\xed\xa0\x80", b"ok\xe2\x82"):
        client.send(data)
        assert read_text(client) == {"type": "error", "text": "the message is not UTF-8"}, data
    client.send(b"\0" * 1000, BINARY)
    assert read_text(client) == {"type": "error", "text": "binary messages are not understood"}
    client.send(b"\0" * 1000, BINARY, last=False)
    client.send(b"\0" * 1000, CONTINUATION)
    assert read_text(client)["text"] == "binary messages are not understood"
    for text in ('{"type": "ack"}', '{"type": "ack", "channel": 0, "sequence": 1}', '{"type": "ack", "channel": 2, "sequence": 1}',
                 '{"type": "ack", "channel": -1, "sequence": 1}', '{"type": "ack", "channel": 0, "sequence": "1"}'):
        assert echo(client, text) == {"type": "error", "text": "ack: no such frame was sent"}, text
    assert echo(client, '{"type": "ack"')["type"] == "echo"  # JSON is not the server's matter
    client.send("", CLOSE)
    assert client.receive()[0] == CLOSE
    for size in (1 << 20) + 1, 1 << 23:
        client = host.connect()
        client.send("x" * size)
        assert client.receive()[0] == CLOSE and client.closed == 1009
    client = host.connect()
    for _ in range(3):
        client.send("x" * 400000, TEXT if _ == 0 else CONTINUATION, last=False)
    assert client.receive()[0] == CLOSE and client.closed == 1009
    for opcode in CONTINUATION, 3, 11:
        client = host.connect()
        client.send("x", opcode)
        expect_end(client)
    client = host.connect()
    client.socket.sendall(b"GET / HTTP/1.1\r\n\r\n" + bytes(range(256)) * 64)
    client.close()
    client = host.connect()
    client.send("flood")
    while client.receive()[0] != CLOSE:
        pass
    assert client.closed == 1009
    host.tell("refuse")
    client = WebSocket(host.port, f"/live?token={host.token}")
    assert read_text(client)["type"] == "error"
    assert client.receive()[0] == CLOSE and client.closed == 1008
    host.wait_for_clients(0)


def expect_end(client):
    try:
        while client.receive()[0] != CLOSE:
            pass
    except (EOFError, ConnectionError):
        pass


def test_close(host):
    """The answer to a goodbye is the last frame, whatever is about to be sent."""
    for _ in range(300):
        client = host.connect()
        for _ in range(20):
            client.send("x")
        client.send(b"\x03\xe8", CLOSE)
        while client.receive()[0] != CLOSE:
            pass
        assert client.closed == 1000 and client.rest() == b""
    host.wait_for_clients(0)


def test_places(host):
    clients = [host.connect() for _ in range(8)]
    extra = WebSocket(host.port, f"/live?token={host.token}")
    assert read_text(extra) == {"type": "error", "text": "all places are taken; close another page"}
    assert extra.receive()[0] == CLOSE and extra.closed == 1013
    assert host.tell("") == 8
    for client in clients:
        assert echo(client)["type"] == "echo"
    clients[0].close()
    host.wait_for_clients(7)
    host.connect().close()
    for client in clients[1:]:
        client.send(b"\x03\xe8", CLOSE)
        assert client.receive()[0] == CLOSE and client.closed == 1000
    host.wait_for_clients(0)


def test_texts(host):
    first, second = host.connect(), host.connect()
    host.tell('tell 0 {"type": "scene"}')
    host.tell('tell 1 {"type": "status", "n": 1}')
    for client in first, second:
        assert [read_text(client)["type"] for _ in range(2)] == ["scene", "status"]
    third = host.connect()  # is told the last status
    assert read_text(third) == {"type": "status", "n": 1}
    for client in first, second, third:
        client.close()
    host.wait_for_clients(0)


def test_acknowledgements(host):
    """Two frames of a channel are under way at most; what comes meanwhile is dropped but for the last."""
    client, other = host.connect(), host.connect()
    read_text(client), read_text(other)  # the status
    for revision in range(1, 11):
        host.tell(f"show 0 {revision} 8 8 0")
        frame = read_frame(other)
        assert (number_of(frame), revision_of(frame)) == (revision, revision)
        acknowledge(other, frame)
    host.tell("show 1 77 8 8 0")  # channels are counted apart
    frames = [read_frame(client) for _ in range(3)]
    assert [(frame[4], number_of(frame)) for frame in frames].count((PATH, 1)) == 1
    method = [frame for frame in frames if frame[4] == METHOD]
    assert [number_of(frame) for frame in method] == [1, 2]
    assert echo(client)["type"] == "echo"  # and nothing more
    acknowledge(client, method[0])
    frame = read_frame(client)
    assert (number_of(frame), revision_of(frame)) == (3, 10)
    acknowledge(client, frame)
    assert echo(client)["type"] == "echo"
    late = host.connect()
    assert read_text(late)["type"] == "status"
    assert sorted(revision_of(read_frame(late)) for _ in range(2)) == [10, 77]  # the last frames
    for each in client, other, late:
        each.close()
    host.wait_for_clients(0)


def test_slow_clients(host):
    """Clients that read nothing neither hold up the program, which shows frames, nor another client."""
    slow = [host.connect(receive_buffer=4096) for _ in range(3)]
    good = host.connect()
    read_text(good)
    while revision_of(read_frame(good)) not in (10, 77):
        pass
    host.process.stdin.write("run 300 1280 720\n")  # 1.7 GB of halves
    host.process.stdin.flush()
    seen = []
    while not seen or seen[-1] != 300:
        frame = read_frame(good)
        acknowledge(good, frame)
        if frame[4] == METHOD:
            seen.append(revision_of(frame))
    host.process.stdout.readline()
    assert len(seen) > 2 and seen[-1] == 300, seen
    host.wait_for_clients(1)  # those who read nothing were dropped
    assert echo(good)["type"] == "echo"
    for client in slow + [good]:
        client.close()
    host.wait_for_clients(0)


def expected_halves(count):
    edges = [0.0, 0.0, 0.0, 65504.0, -65504.0, 65504.0, 6e-8, -2e-8, 1.00048828125, -0.0]
    values = edges + [i * 37 % 1009 / 256 - 0.5 for i in range(len(edges), count)]
    return struct.pack(f"<{count}e", *values[:count])


def check_frame(frame, codec, moving):
    assert frame[:4] == b"TYF1" and frame[4] == PATH and frame[5] == codec and frame[6:8] == bytes(2)
    assert struct.unpack_from("<II", frame, 8) == (1, 5)
    assert struct.unpack_from("<HHHH", frame, 16) == (WIDTH, HEIGHT, 2 * WIDTH, 2 * HEIGHT)
    assert struct.unpack_from("<fffI", frame, 24) == (1.5, 2.5, -1.0 if codec == 2 else 0.0, 0 if moving else 1)
    assert frame[40:64] == bytes(24)


def frame_of(kind, moving):
    host = Host(kind)
    host.tell(f"show 1 5 {WIDTH} {HEIGHT} {int(moving)}")
    client = host.connect()
    frame = read_frame(client)
    check_frame(frame, {"local": 0, "remote": 2 if moving else 1}[kind], moving)
    host.stop()  # with a client
    assert client.receive()[0] == CLOSE and client.closed == 1001
    client.close()
    return frame[64:]


def undo_differences(packed):
    count = WIDTH * HEIGHT
    plain = zlib.decompress(packed)
    assert len(plain) == 6 * count
    halves = [0] * (3 * count)
    for c in range(3):
        for y in range(HEIGHT):
            left = 0
            for x in range(WIDTH):
                at = c * count + y * WIDTH + x
                left = (left + plain[at] + 256 * plain[3 * count + at]) & 0xffff
                halves[3 * (y * WIDTH + x) + c] = left
    return struct.pack(f"<{3 * count}H", *halves)


def test_codecs():
    expected = expected_halves(3 * WIDTH * HEIGHT)
    assert frame_of("local", True) == expected and frame_of("local", False) == expected
    assert undo_differences(frame_of("remote", False)) == expected
    jpeg = frame_of("remote", True)
    assert jpeg[:2] == b"\xff\xd8" and jpeg[-2:] == b"\xff\xd9"
    start = jpeg.index(b"\xff\xc0")  # the sizes, and 4:4:4
    assert struct.unpack_from(">HH", jpeg, start + 5) == (HEIGHT, WIDTH)
    assert jpeg[start + 9] == 3 and jpeg[start + 11] == 0x11


def test_taken_port(host):
    second = subprocess.run([sys.argv[1], str(host.port), "local"], capture_output=True, text=True, stdin=subprocess.DEVNULL)
    assert second.returncode == 1 and second.stderr == ""
    assert second.stdout == f"error cannot listen on 127.0.0.1:{host.port}: Address already in use\n", second.stdout


def main():
    host = Host()
    test_taken_port(host)
    for test in (test_doors, test_requests, test_messages, test_close, test_places, test_texts, test_acknowledgements, test_slow_clients):
        test(host)
        print(test.__name__, flush=True)
    port, clients = host.port, [host.connect() for _ in range(3)]
    clients[0].close()
    host.stop()  # with clients of which some do not answer
    again = Host(port=port)
    again.stop()
    test_codecs()


main()
