"""A CIGI 3.3 host for the tests, written from the packet tables alone.

    host = Host(("127.0.0.1", port))
    host.send(entity(1, 52.6, 5.2, yaw=90), hot(7, 52.6, 5.2))
    frame = host.receive()           # Start of Frame and answers

Every packet is made by `struct` from offsets written here; nothing is shared
with the server. Packets are functions of the byte order: host.send() calls
them with the host's.
"""
import socket
import struct
import time

from pelagos_daemon import SLOW_S

# --- host to image generator ------------------------------------------------


def ig_control(order, frame, last_ig, database=0, mode=1, stamp=None, minor=3,
               magic=0x8000):
    flags = mode | (stamp is not None) << 2 | minor << 4
    return struct.pack(order + "BBBbBBHIII4x", 1, 24, 3, database, flags, 0,
                       magic, frame & 0xFFFFFFFF,
                       (stamp or 0) & 0xFFFFFFFF, last_ig & 0xFFFFFFFF)


def entity(id, latitude, longitude, altitude=0, yaw=0, pitch=0, roll=0,
           state=1, parent=None, clamp=0):
    flags = state | (parent is not None) << 2 | clamp << 5
    return lambda order: struct.pack(
        order + "BBHBBBBHHfffddd", 2, 48, id, flags, 0, 255, 0, 0,
        parent or 0, roll, pitch, yaw, latitude, longitude, altitude)


def conformal(id, latitude, longitude, yaw=0):
    return lambda order: struct.pack(order + "BBHfdd", 3, 24, id, yaw,
                                     latitude, longitude)


def component(id, state, values=(), instance=0, kind=7, seed=0, depth=0):
    data = (list(values) + [0.0] * 4)[:4]
    return lambda order: struct.pack(order + "BBHHBBffffIf", 4, 32, id,
                                     instance, kind, state, *data, seed,
                                     depth)


def short_component(id, state, first=0.0, second=0.0, instance=0, kind=7):
    return lambda order: struct.pack(order + "BBHHBBff", 5, 16, id, instance,
                                     kind, state, first, second)


def rate(id, x=0, y=0, z=0, roll=0, pitch=0, yaw=0, local=False):
    return lambda order: struct.pack(order + "BBHBBHffffff", 8, 32, id, 0,
                                     local << 1, 0, x, y, z, roll, pitch, yaw)


def celestial(hour, minute, month, day, year, valid=True, ephemeris=True):
    date = month * 1000000 + day * 10000 + year
    return lambda order: struct.pack(order + "BBBBB3xIf", 9, 16, hour, minute,
                                     ephemeris | 2 | valid << 4, date, 0)


def atmosphere(visibility, wind, direction, humidity=50, celsius=12,
               pressure=1010, enable=True):
    return lambda order: struct.pack(order + "BBBBffffff4x", 10, 32, enable,
                                     humidity, celsius, visibility, wind, 0,
                                     direction, pressure)


def region(id, latitude, longitude, x, y, radius=0, rotation=0, state=1):
    return lambda order: struct.pack(order + "BBHB3xddfffff4x", 11, 48, id,
                                     state, latitude, longitude, x, y, radius,
                                     rotation, 0)


def weather(layer, visibility, wind, direction, base=0, scope=0, region=0,
            enable=True):
    return lambda order: struct.pack(
        order + "BBHBBBBffffffffffff", 12, 56, region, layer, 50, enable,
        scope, 12, visibility, 0, 0, base, 100, 0, wind, 0, direction, 1010,
        0)


def maritime(clarity, celsius=10, height=0, scope=0, region=0, enable=True):
    return lambda order: struct.pack(order + "BBHB3xfff4x", 13, 24, region,
                                     enable | 2 | scope << 2, height, celsius,
                                     clarity)


def wave(id, height, period, direction, length=0, enable=True, scope=0,
         region=0):
    return lambda order: struct.pack(order + "BBHBBHffffff", 14, 32, region,
                                     id, enable | scope << 1, 0, height,
                                     length, period, direction, 0, 0)


def view_control(view, entity, x=None, y=None, z=None, roll=None, pitch=None,
                 yaw=None, group=0):
    parts = (x, y, z, roll, pitch, yaw)
    enables = sum((part is not None) << i for i, part in enumerate(parts))
    return lambda order: struct.pack(order + "BBHBBHffffff", 16, 32, view,
                                     group, enables, entity,
                                     *(part or 0 for part in parts))


def sensor(view, sensor_id, on=True, black_hot=False, gain=0.5, level=0.5,
           noise=0.0, dropout=False, auto=False, track=0, extended=False):
    flags = on | black_hot << 1 | dropout << 2 | auto << 3 | track << 5
    return lambda order: struct.pack(order + "BBHBBBBffff", 17, 24, view,
                                     sensor_id, flags, extended, 0, gain,
                                     level, 0, noise)


def view_definition(view, left=None, right=None, top=None, bottom=None,
                    group=0):
    parts = (None, None, left, right, top, bottom)
    enables = sum((part is not None) << i for i, part in enumerate(parts))
    return lambda order: struct.pack(order + "BBHBBBBffffff", 21, 32, view,
                                     group, enables, 0, 0,
                                     *(part or 0 for part in parts))


def hat_hot(id, latitude, longitude, altitude=0, kind=1, period=0,
            entity=None):
    flags = kind | (entity is not None) << 2
    return lambda order: struct.pack(order + "BBHBBHddd", 24, 32, id, flags,
                                     period, entity or 0, latitude, longitude,
                                     altitude)


def los_segment(id, source, target, extended=False, period=0):
    return lambda order: struct.pack(order + "BBHBBHddddddIBBH", 25, 64, id,
                                     extended, 0, 0, *source, *target, 0,
                                     period, 0, 0)


def los_vector(id, source, azimuth, elevation, most, least=0, extended=False,
               period=0):
    return lambda order: struct.pack(order + "BBHBBHffffdddIB3x", 26, 56, id,
                                     extended, 0, 0, azimuth, elevation,
                                     least, most, *source, 0, period)


def position(id, kind=0, continuous=False):
    return lambda order: struct.pack(order + "BBHBBH", 27, 8, id, 0,
                                     continuous | kind << 1, 0)


def conditions(id, latitude, longitude, kind=1):
    return lambda order: struct.pack(order + "BBBB4xddd", 28, 32, kind, id,
                                     latitude, longitude, 0)


def raw(data):
    return lambda order: data


# --- image generator to host ------------------------------------------------


def _sof(o, b):
    (_, _, major, database, status, flags, magic, frame, stamp,
     last) = struct.unpack_from(o + "BBBbBBHIII", b)
    return dict(major=major, database=database, status=status, mode=flags & 3,
                stamped=flags >> 2 & 1, minor=flags >> 4, magic=magic,
                frame=frame, stamp=stamp, last_host=last)


def _hat_hot(o, b):
    id, flags, height = struct.unpack_from(o + "HBxxxd", b, 2)
    return dict(id=id, valid=flags & 1, hot=flags >> 1 & 1, frame=flags >> 4,
                height=height)


def _extended(o, b):
    id, flags, hat, hot, material, azimuth, elevation = struct.unpack_from(
        o + "HBxxxddIff", b, 2)
    return dict(id=id, valid=flags & 1, frame=flags >> 4, hat=hat, hot=hot,
                material=material, azimuth=azimuth, elevation=elevation)


def _los(o, b):
    id, flags, count, entity_id, distance = struct.unpack_from(o + "HBBHd", b,
                                                               2)
    return dict(id=id, valid=flags & 1, visible=flags >> 2 & 1,
                frame=flags >> 4, count=count, range=distance)


def _los_extended(o, b):
    id, flags, count, _, distance, latitude, longitude, altitude = \
        struct.unpack_from(o + "HBBHdddd", b, 2)
    material, azimuth, elevation = struct.unpack_from(o + "Iff", b, 44)
    return dict(id=id, valid=flags & 1, range_valid=flags >> 2 & 1,
                visible=flags >> 3 & 1, frame=flags >> 4, count=count,
                range=distance, latitude=latitude, longitude=longitude,
                altitude=altitude, material=material, azimuth=azimuth,
                elevation=elevation)


def _sensor(o, b):
    view, id, flags, across, up, x, y, frame = struct.unpack_from(
        o + "HBBxxHHffI", b, 2)
    return dict(view=view, id=id, status=flags & 3, size=(across, up), x=x,
                y=y, frame=frame)


def _sensor_extended(o, b):
    view, id, flags, entity_id, across, up, x, y, frame = struct.unpack_from(
        o + "HBBHHHffI", b, 2)
    latitude, longitude, altitude = struct.unpack_from(o + "ddd", b, 24)
    return dict(view=view, id=id, status=flags & 3, valid=flags >> 2 & 1,
                entity=entity_id, size=(across, up), x=x, y=y, frame=frame,
                latitude=latitude, longitude=longitude, altitude=altitude)


def _position(o, b):
    id, part, flags, latitude, longitude, altitude, roll, pitch, yaw = \
        struct.unpack_from(o + "HBBxxdddfff", b, 2)
    return dict(id=id, kind=flags & 7, latitude=latitude, longitude=longitude,
                altitude=altitude, roll=roll, pitch=pitch, yaw=yaw)


def _weather(o, b):
    id, humidity, celsius, visibility, wind, _, direction, pressure = \
        struct.unpack_from(o + "BBffffff", b, 2)
    return dict(id=id, humidity=humidity, celsius=celsius,
                visibility=visibility, wind=wind, direction=direction,
                pressure=pressure)


def _maritime(o, b):
    id, height, celsius, clarity = struct.unpack_from(o + "Bxfff", b, 2)
    return dict(id=id, height=height, celsius=celsius, clarity=clarity)


ANSWERS = {101: ("sof", 24, _sof), 102: ("hat_hot", 16, _hat_hot),
           103: ("extended", 40, _extended), 104: ("los", 16, _los),
           105: ("los_extended", 56, _los_extended),
           106: ("sensor", 24, _sensor),
           107: ("sensor_extended", 48, _sensor_extended),
           108: ("position", 48, _position), 109: ("weather", 32, _weather),
           111: ("maritime", 16, _maritime)}


QUESTIONS = (24, 25, 26, 27, 28)


def parse(order, data):
    """List of (name, fields); raises on anything the tables do not have."""
    packets = []
    while data:
        name, size, read = ANSWERS[data[0]]
        if data[1] != size or size > len(data):
            raise ValueError(f"{name} has {data[1]} bytes of {len(data)}")
        if (name == "sof") != (not packets):
            raise ValueError("Start of Frame is not the first packet")
        packets.append((name, read(order, data)))
        data = data[size:]
    return packets


class Frame:
    """One datagram of the image generator, with the time of receipt."""

    def __init__(self, order, data, at):
        self.data, self.at = data, at
        packets = parse(order, data)
        self.sof = packets[0][1]
        self.answers = packets[1:]

    def all(self, name):
        return [fields for kind, fields in self.answers if kind == name]


class Host:
    """big: byte order; stamped: asynchronous, with timestamps that count
    10 us; log: list that gets (True if sent, bytes)."""

    def __init__(self, to, big=True, minor=3, stamped=False, database=0,
                 bind=("127.0.0.1", 0)):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        self.socket.bind(bind)
        self.to, self.order, self.minor = to, ">" if big else "<", minor
        self.stamped, self.database = stamped, database
        self.frame = self.last_ig = 0
        self.stamp = 0
        self.mode = 1
        self.log = []

    def datagram(self, *packets):
        head = ig_control(self.order, self.frame, self.last_ig, self.database,
                          self.mode, self.stamp if self.stamped else None,
                          self.minor)
        return head + b"".join(packet(self.order) for packet in packets)

    def send(self, *packets, ticks=None):
        """The next host frame; ticks: how far its timestamp goes on."""
        self.frame += 1
        self.stamp += 1667 if ticks is None else ticks
        return self.send_raw(self.datagram(*packets))

    def send_raw(self, data):
        self.log.append((True, data))
        self.socket.sendto(data, self.to)
        return self.frame

    def receive(self, timeout=20.0):
        """The next frame, or None."""
        self.socket.settimeout(timeout)
        try:
            data, _ = self.socket.recvfrom(65536)
        except (TimeoutError, socket.timeout, BlockingIOError):
            return None
        frame = Frame(self.order, data, time.monotonic())
        self.log.append((False, data))
        self.last_ig = frame.sof["frame"]
        return frame

    def drain(self, timeout=0.001):
        frames = []
        while (frame := self.receive(timeout)) is not None:
            frames.append(frame)
        return frames

    def settle(self, number=None, timeout=SLOW_S):
        """Frames until one knows host frame `number` (the newest)."""
        number = self.frame if number is None else number
        frames = []
        end = time.monotonic() + timeout
        while time.monotonic() < end:
            frame = self.receive(max(end - time.monotonic(), 0.001))
            if frame is None:
                break
            frames.append(frame)
            if frame.sof["last_host"] == number:
                return frames
        raise TimeoutError(f"host frame {number} is not answered; last "
                           f"{frames[-1].sof if frames else None}")

    def ask(self, *packets):
        """Sends a frame; the answers in the frame that knows of it and, where
        some are still missing there, in those after it: the next, or on a busy
        machine a later one."""
        self.send(*packets)
        asked = sum(packet(self.order)[0] in QUESTIONS for packet in packets)
        frames = self.settle()
        answers = [answer for frame in frames for answer in frame.answers]
        self.gather(answers, asked)
        return answers

    def gather(self, answers, count, seconds=SLOW_S):
        """Adds what comes until there are `count` answers."""
        end = time.monotonic() + seconds
        while len(answers) < count and time.monotonic() < end:
            if (frame := self.receive(0.1)) is not None:
                answers += frame.answers

    def close(self):
        self.socket.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


# --- captures ---------------------------------------------------------------


def write_pcap(path, host_port, ig_port, log):
    """The datagrams of a host's log as a capture of raw IP (link type 101),
    so that tshark can be asked without a capture's privileges."""
    with open(path, "wb") as f:
        f.write(struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 262144, 101))
        for number, (sent, data) in enumerate(log):
            ports = (host_port, ig_port) if sent else (ig_port, host_port)
            udp = struct.pack(">HHHH", *ports, 8 + len(data), 0) + data
            ip = struct.pack(">BBHHHBBHII", 0x45, 0, 20 + len(udp),
                             number & 0xFFFF, 0, 64, 17, 0, 0x7F000001,
                             0x7F000001) + udp
            f.write(struct.pack("<IIII", number // 1000,
                                number % 1000 * 1000, len(ip), len(ip)) + ip)
