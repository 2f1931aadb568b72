"""An RTSP client for tests, standard library only."""
import socket
import struct
import time

from pelagos_daemon import SLOW_S


class RtspClient:
    """RTP over the RTSP connection itself (interleaved), as far as needed."""

    def __init__(self, port, view, buffer=None, timeout=SLOW_S):
        self.url = f"rtsp://127.0.0.1:{port}/{view}"
        self.socket = socket.socket()
        if buffer:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
        self.socket.settimeout(timeout)
        self.socket.connect(("127.0.0.1", port))
        self.buffer = b""
        self.sequence = 0
        self.session = None
        self.rtp_time = None  # of the last picture
        self.report = None    # (seconds since 1900, RTP time), the last one

    def take(self, count):
        while len(self.buffer) < count:
            data = self.socket.recv(1 << 16)
            if not data:
                raise ConnectionResetError("closed")
            self.buffer += data
        data, self.buffer = self.buffer[:count], self.buffer[count:]
        return data

    def ask(self, method, url, **headers):
        self.sequence += 1
        headers["CSeq"] = self.sequence
        if self.session:
            headers["Session"] = self.session
        lines = "".join(f"{k}: {v}\r\n" for k, v in headers.items())
        self.socket.sendall(f"{method} {url} RTSP/1.0\r\n{lines}\r\n".encode())
        self.asked = time.monotonic()
        while True:  # pictures may come before the answer
            first = self.take(1)
            if first != b"$":
                break
            self.take(struct.unpack(">BH", self.take(3))[1])
        head = first
        while not head.endswith(b"\r\n\r\n"):
            head += self.take(1)
        lines = head.decode().split("\r\n")
        answer = dict(line.split(": ", 1) for line in lines[1:] if ": " in line)
        body = self.take(int(answer.get("Content-Length", 0)))
        return int(lines[0].split()[1]), answer, body.decode()

    def describe(self):
        """The address of the stream's control."""
        status, _, self.sdp = self.ask("DESCRIBE", self.url,
                                       Accept="application/sdp")
        assert status == 200, status
        control = [line.split(":", 1)[1] for line in self.sdp.split("\r\n")
                   if line.startswith("a=control:")][-1]
        return f"{self.url}/{control}"

    def setup(self, control):
        status, answer, _ = self.ask(
            "SETUP", control,
            Transport="RTP/AVP/TCP;unicast;interleaved=0-1")
        if status == 200:
            self.session = answer["Session"].split(";")[0]
        return status

    def play(self):
        status = self.setup(self.describe())
        assert status == 200, status
        status, _, _ = self.ask("PLAY", self.url)
        assert status == 200, status
        return self.sdp

    def picture(self):
        """Whether the next whole picture is a key frame."""
        key = False
        while True:
            mark, channel, size = struct.unpack(">cBH", self.take(4))
            data = self.take(size)
            assert mark == b"$", mark
            if channel == 1:
                self.hear(data)
            if channel == 0:
                self.rtp_time, = struct.unpack_from(">I", data, 4)
                kind = data[12] & 31
                key = key or kind == 5 or (kind == 28 and data[13] & 31 == 5)
                if data[1] & 0x80:
                    return key

    def hear(self, data):
        """A sender report, which says what RTP times mean (RFC 3550, 6.4)."""
        if data[1] == 200:
            seconds, fraction, rtp = struct.unpack_from(">III", data, 8)
            self.report = (seconds + fraction / 2 ** 32, rtp)

    def wall_time(self, rtp_time):
        """Seconds since 1900, of a picture by its RTP time."""
        seconds, rtp = self.report
        ticks = (rtp_time - rtp + 2 ** 31) % 2 ** 32 - 2 ** 31
        return seconds + ticks / 90000

    def close(self):
        self.socket.close()
