"""The receiving end of tev's protocol, by which `tyndall render --tev` shows an image while it converges: packets of a length,
little-endian, and CREATE_IMAGE or UPDATE_IMAGE with planes of floats."""
import socket
import struct
import threading

import numpy as np

CREATE_IMAGE, UPDATE_IMAGE = 4, 6


class _Packet:
    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, form):
        values = struct.unpack_from("<" + form, self.data, self.at)
        self.at += struct.calcsize("<" + form)
        return values

    def text(self):
        end = self.data.index(0, self.at)
        text, self.at = self.data[self.at:end], end + 1
        return text.decode(errors="replace")


class Receiver:
    """Listens on a free port of 127.0.0.1 for one connection. take() gives the newest image."""

    def __init__(self):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.listener.settimeout(0.5)
        self.port = self.listener.getsockname()[1]
        self.lock, self.image, self.fresh, self.closed = threading.Lock(), None, False, False
        self.thread = threading.Thread(target=self._serve, daemon=True)
        self.thread.start()

    def _serve(self):
        connection = None
        while connection is None and not self.closed:
            try:
                connection, _ = self.listener.accept()
            except socket.timeout:
                continue
            except OSError:
                return
        if connection is None:
            return
        with connection:
            file = connection.makefile("rb")
            while not self.closed:
                head = file.read(4)
                if len(head) < 4:
                    return
                size = struct.unpack("<I", head)[0] - 4
                body = file.read(size)
                if len(body) < size:
                    return
                self._take(_Packet(body))

    def _take(self, packet):
        kind, _ = packet.take("BB")
        packet.text()
        if kind == CREATE_IMAGE:
            width, height, count = packet.take("iii")
            with self.lock:
                self.image = np.zeros((height, width, count), np.float32)
        elif kind == UPDATE_IMAGE and self.image is not None:
            names = [packet.text() for _ in range(packet.take("i")[0])]
            x, y, width, height = packet.take("iiii")
            offsets, strides = packet.take(f"{len(names)}q"), packet.take(f"{len(names)}q")
            values = np.frombuffer(packet.data, np.float32, offset=packet.at) if packet.at % 4 == 0 else \
                np.frombuffer(packet.data[packet.at:], np.float32)
            with self.lock:
                for c, (offset, stride) in enumerate(zip(offsets, strides)):
                    plane = values[offset:offset + (width * height - 1) * stride + 1:stride]
                    self.image[y:y + height, x:x + width, c] = plane.reshape(height, width)
                self.fresh = True

    def take(self):
        """A copy of the image, height x width x 3 with the first row at the top, if there is a newer one; else None."""
        with self.lock:
            if not self.fresh:
                return None
            self.fresh = False
            return self.image.copy()

    def close(self):
        self.closed = True
        self.listener.close()
