"""Images of a scene that changes while it is shown: by `tyndall view` and its protocol (docs/view_protocol.md), and where that
does not run, by small renders one after another. Neither knows Blender."""
import base64
import json
import os
import re
import signal
import socket
import struct
import subprocess
import threading
import zlib

import numpy as np

from . import exr, process

TEXT, BINARY, CLOSE, PING, PONG = 1, 2, 8, 9, 10
HEADER = 64


class WebSocket:
    """A client of RFC 6455 for one server on 127.0.0.1."""

    def __init__(self, port, target, seconds=20):
        self.socket = socket.create_connection(("127.0.0.1", port), seconds)
        self.buffer, self.lock = b"", threading.Lock()
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall((f"GET {target} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                             f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n\r\n").encode())
        while b"\r\n\r\n" not in self.buffer:
            self._fill()
        head, _, self.buffer = self.buffer.partition(b"\r\n\r\n")
        if b" 101 " not in head.splitlines()[0] + b" ":
            raise OSError("the viewer refused the connection")
        self.socket.settimeout(None)

    def _fill(self):
        got = self.socket.recv(1 << 20)
        if not got:
            raise EOFError
        self.buffer += got

    def _take(self, count):
        while len(self.buffer) < count:
            self._fill()
        out, self.buffer = self.buffer[:count], self.buffer[count:]
        return out

    def send(self, data, opcode=TEXT):
        length = len(data)
        head = struct.pack("!BB", 0x80 | opcode, 0x80 | min(length, 126)) if length < 126 else \
            struct.pack("!BBH", 0x80 | opcode, 0x80 | 126, length) if length < 1 << 16 else \
            struct.pack("!BBQ", 0x80 | opcode, 0x80 | 127, length)
        mask = os.urandom(4)
        masked = np.frombuffer(data, np.uint8) ^ np.resize(np.frombuffer(mask, np.uint8), length)
        with self.lock:
            self.socket.sendall(head + mask + masked.tobytes())

    def receive(self):
        """The opcode and the bytes of the next message."""
        whole, first = b"", None
        while True:
            a, b = self._take(2)
            length = b & 127
            if length == 126:
                length = struct.unpack("!H", self._take(2))[0]
            elif length == 127:
                length = struct.unpack("!Q", self._take(8))[0]
            body, opcode = self._take(length), a & 15
            if opcode == PING:
                self.send(body, PONG)
            elif opcode == CLOSE:
                raise EOFError
            elif opcode != PONG:
                first = first or opcode
                whole += body
                if a & 0x80:
                    return first, whole

    def close(self):
        try:
            self.socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        self.socket.close()


def pixels_of(frame):
    """A frame of the protocol as height x width x 3, the first row at the top; None for those of other kinds."""
    if frame[:4] != b"TYF1" or frame[4] != 0:
        return None
    width, height = struct.unpack_from("<HH", frame, 16)
    body, codec = frame[HEADER:], frame[5]
    if codec == 0:
        return np.frombuffer(body, np.float16).reshape(height, width, 3).astype(np.float32)
    if codec != 1:
        return None
    count = width * height * 3
    raw = np.frombuffer(zlib.decompress(body), np.uint8)
    bits = raw[:count].astype(np.uint16) | raw[count:].astype(np.uint16) << 8
    planes = np.cumsum(bits.reshape(3, height, width), axis=2, dtype=np.uint16).view(np.float16)
    return np.moveaxis(planes, 0, -1).astype(np.float32)


class Viewer:
    """`tyndall view` of a scene file. changed: called from another thread when there is a new image."""

    def __init__(self, program, scene_file, size, method, changed):
        self.changed, self.image, self.message, self.closed = changed, None, "", False
        self.process = process.start(
            [program, "view", scene_file, "--no-open", "--no-compare", "--size", f"{size[0]}x{size[1]}", "--method", method],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        address = self.process.stdout.readline().decode(errors="replace")
        found = re.search(r"http://[^:]+:(\d+)/\?token=(\w+)", address)
        if found is None:
            self.close()
            raise OSError("tyndall view does not run")
        self.socket = WebSocket(int(found[1]), f"/live?token={found[2]}")
        self.thread = threading.Thread(target=self._listen, daemon=True)
        self.thread.start()

    def _listen(self):
        try:
            while not self.closed:
                opcode, data = self.socket.receive()
                if opcode == BINARY:
                    self._show(data)
                else:
                    self._read(json.loads(data))
        except (OSError, EOFError, ValueError):
            pass

    def _show(self, data):
        sequence = struct.unpack_from("<I", data, 8)[0]
        self._send({"type": "ack", "channel": data[4], "sequence": sequence})
        image = pixels_of(data)
        if image is not None:
            self.image = image
            self.changed()

    def _read(self, message):
        if message.get("type") == "error":
            self.message = message.get("text", "")
        elif message.get("type") == "status":
            self.message = message.get("message") or f'{message.get("method", "")} {message.get("stage", "")}'

    def _send(self, message):
        try:
            self.socket.send(json.dumps(message).encode())
        except OSError:
            self.message = "tyndall view has ended"

    def set_camera(self, camera, moving):
        changes = [{"path": f"camera.{key}", "value": camera.get(key)} for key in
                   ("position", "target", "up", "fov_y", "shift", "aperture_radius", "focus_distance")]
        self._send({"type": "set", "changes": changes, "moving": moving})

    def set_scene(self, document):
        """Exchanges media, lights and surfaces for those of another document."""
        changes = [{"path": key, "value": document[key]} for key in ("media", "lights", "geometry")]
        self._send({"type": "set", "changes": changes, "moving": False})

    def set_view(self, **view):
        """method, width and height."""
        self._send({"type": "view", **view})

    def close(self):
        self.closed = True
        if hasattr(self, "socket"):
            self.socket.close()
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
            try:
                self.process.wait(5)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        self.process.stdout.close()


class Renders:
    """The same by `tyndall render`: a quarter of the size first, then all of it; a change starts anew."""

    def __init__(self, program, scene_file, size, method, changed):
        self.program, self.scene_file, self.size, self.method, self.changed = program, scene_file, size, method, changed
        self.image, self.message, self.closed = None, "", False
        with open(scene_file, encoding="utf-8") as file:
            self.document = json.load(file)
        self.wanted, self.wake = 1, threading.Event()
        self.wake.set()
        self.thread = threading.Thread(target=self._work, daemon=True)
        self.thread.start()

    def _work(self):
        while not self.closed:
            self.wake.wait()
            self.wake.clear()
            wanted = self.wanted
            for divisor in (4, 1):
                if self.closed or wanted != self.wanted:
                    break
                self._render(wanted, divisor)

    def _render(self, wanted, divisor):
        folder = os.path.dirname(self.scene_file)
        path, out = os.path.join(folder, "viewport.json"), os.path.join(folder, "viewport.exr")
        with open(path, "w", encoding="utf-8") as file:
            json.dump(self.document, file)
        size = [max(s // divisor, 1) for s in self.size]
        run = process.Run(self.program, ["render", path, "-o", out, "--method", self.method, "--size", f"{size[0]}x{size[1]}"], folder)
        while run.is_running():
            run.readers[0].join(0.05)
            if self.closed or wanted != self.wanted:
                run.process.kill()
        if run.finish() != 0:
            self.message = run.reason() if wanted == self.wanted else ""
            return
        image = exr.stack(exr.read(out)[0], ("R", "G", "B"))
        self.image, self.message = image, self.method
        self.changed()

    def _again(self):
        self.wanted += 1
        self.wake.set()

    def set_camera(self, camera, moving):
        known = self.document.setdefault("camera", {})
        for key in ("position", "target", "up", "fov_y", "shift", "aperture_radius", "focus_distance"):
            known.pop(key, None)
            if key in camera:
                known[key] = camera[key]
        self._again()

    def set_scene(self, document):
        self.document.update({key: document[key] for key in ("media", "lights", "geometry")})
        self._again()

    def set_view(self, method=None, width=None, height=None):
        self.method = method or self.method
        self.size = (width or self.size[0], height or self.size[1])
        self._again()

    def close(self):
        self.closed = True
        self.wake.set()
        self.thread.join(5)


def show(program, scene_file, size, method, changed):
    """A Viewer of a scene file, or Renders where `tyndall view` does not run."""
    try:
        return Viewer(program, scene_file, size, method, changed)
    except (OSError, EOFError):
        return Renders(program, scene_file, size, method, changed)
