"""A WebSocket client and plain requests, byte by byte, so that tests can send what no browser would."""
import base64, os, socket, struct, threading

WAIT = 60  # seconds, for a slow and busy machine
CONTINUATION, TEXT, BINARY, CLOSE, PING, PONG = 0, 1, 2, 8, 9, 10


class Refused(Exception):
    """The server answered an upgrade with another status."""


def request(port, target, method="GET", version="HTTP/1.1", **headers):
    """The status, the headers by small names and the body of an answer; status 0: there was none. host=None leaves that
    header out."""
    connection = socket.create_connection(("127.0.0.1", port), WAIT)
    with connection:
        connection.sendall(head_of(port, target, method, version, headers))
        data = b""
        while got := connection.recv(1 << 16):
            data += got
    return split_answer(data)


def head_of(port, target, method, version, headers):
    fields = {"host": f"127.0.0.1:{port}"} | {name.replace("_", "-"): value for name, value in headers.items()}
    lines = [f"{method} {target} {version}"] + [f"{name}: {value}" for name, value in fields.items() if value is not None]
    return "\r\n".join(lines + ["", ""]).encode()


def split_answer(data):
    if not data:
        return 0, {}, b""
    head, _, body = data.partition(b"\r\n\r\n")
    first, *lines = head.decode().split("\r\n")
    return int(first.split()[1]), {name.lower(): value for name, value in (line.split(": ", 1) for line in lines)}, body


class WebSocket:
    def __init__(self, port, target, receive_buffer=None, **headers):
        self.socket = socket.socket()
        if receive_buffer:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        self.socket.settimeout(WAIT)
        self.socket.connect(("127.0.0.1", port))
        self.buffer, self.closed, self.sending = b"", None, threading.Lock()
        upgrade = {"upgrade": "websocket", "connection": "Upgrade", "sec_websocket_version": "13",
                   "sec_websocket_key": base64.b64encode(os.urandom(16)).decode()}
        self.socket.sendall(head_of(port, target, "GET", "HTTP/1.1", upgrade | headers))
        while b"\r\n\r\n" not in self.buffer:
            self.fill()
        status = int(self.buffer.split()[1])
        if status != 101:
            raise Refused(status)
        self.buffer = self.buffer.partition(b"\r\n\r\n")[2]

    def fill(self):
        got = self.socket.recv(1 << 20)
        if not got:
            raise EOFError
        self.buffer += got

    def take(self, count):
        while len(self.buffer) < count:
            self.fill()
        taken, self.buffer = self.buffer[:count], self.buffer[count:]
        return taken

    def rest(self):
        """All bytes until the server ends the connection."""
        try:
            while True:
                self.fill()
        except (EOFError, ConnectionError):
            return self.buffer

    def send(self, data, opcode=TEXT, last=True):
        data = data.encode() if isinstance(data, str) else data
        size = len(data)
        head = bytes([(0x80 if last else 0) | opcode])
        head += bytes([0x80 | size]) if size < 126 else struct.pack(">BH", 0xfe, size) if size < 1 << 16 \
            else struct.pack(">BQ", 0xff, size)
        with self.sending:
            self.socket.sendall(head + bytes(4) + data)  # masked by zeros

    def receive(self):
        """(opcode, data) of the next message; pings are answered. After a goodbye self.closed is its code."""
        while True:
            first, second = self.take(2)
            size = second & 0x7f
            size = struct.unpack(">H", self.take(2))[0] if size == 126 else \
                struct.unpack(">Q", self.take(8))[0] if size == 127 else size
            data = self.take(size)
            if first & 0x0f == PING:
                self.send(data, PONG)
            elif first & 0x0f == CLOSE:
                self.closed = struct.unpack(">H", data[:2])[0] if data else 1005
                self.send(data[:2], CLOSE)
                return CLOSE, data[2:]
            elif first & 0x0f != PONG:
                assert first & 0x80 and not second & 0x80, "the server sends whole messages without a mask"
                return first & 0x0f, data

    def close(self):
        self.socket.close()
