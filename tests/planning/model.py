"""What cameras take, by the figures of figures.py; docs/planning.md says how.

Everything is a function of figures and of what is asked for, so that a reader
can do the same by hand: rates are pictures a second, sizes pixels.
"""
import math

K, M = 1e3, 1e6
HD, FULL, UHD = (1280, 720), (1920, 1080), (3840, 2160)
HD_PIXELS = 1280 * 720
NAMES = {HD: "1280×720", FULL: "1920×1080", UHD: "3840×2160",
         (640, 360): "640×360"}


def up(x):
    """Things are whole; what is whole but for rounding stays."""
    return max(1, math.ceil(x - 1e-9))


class Model:
    """The numbers that the formulas of the page have, from figures."""

    def __init__(self, figures):
        f = self.figures = figures
        small, large = 1 / f["drawn_720"].value, 1 / f["drawn_2160"].value
        pixels = UHD[0] * UHD[1]
        # A picture on the device: a line through the two sizes measured.
        self.pixel_s = (large - small) / (pixels - HD_PIXELS)
        self.picture_s = small - self.pixel_s * HD_PIXELS
        # Pictures of 1280×720 by a core, drawing included: the least seen.
        # Of the slow machine: frames a second of 64 views, on 16 cores.
        slow = f["h264_slow"].values[-1] * 64 / 16
        self.core = {"h264": min(f["h264_32"].value / 32,
                                 f["h264_16"].value / 16, slow),
                     "jpeg": f["jpeg_2"].value / 2}
        # One view by itself: one encoder, one thread; a JPEG is the device's.
        self.alone = {"h264": f["h264_slow"].value,
                      "jpeg": f["jpeg_alone"].value * self.size(UHD)}
        self.raster_s, self.shade_s = (
            x / K for x in f["traffic_ms"].values[2:])
        self.software_s = f["core_ms"].value / K
        self.encode_s = f["h264_core_ms"].value / K

    def size(self, size):
        """Its pixels over those of 1280×720."""
        return size[0] * size[1] / HD_PIXELS

    def device_s(self, size):
        return self.picture_s + self.pixel_s * size[0] * size[1]

    def traffic_s(self, size):
        """With a ship and buoys in the picture: objects as at 1280×720."""
        return self.raster_s + self.shade_s * self.size(size)

    def cores(self, rate, size, codec):
        return rate * self.size(size) / self.core[codec]

    def software_cores(self, rate, size):
        return rate * self.size(size) * (self.software_s + self.encode_s)

    def most_rate(self, size, codec):
        """Pictures a second of one view."""
        return min(self.figures["live_hz"].value,
                   self.alone[codec] / self.size(size))

    def places(self, size):
        """Live views of a daemon, each another view: by its views, its live
        views, its pixels."""
        f = self.figures
        return int(min(f["views"].value, f["streams"].value,
                       f["pixels"].value // (size[0] * size[1])))

    def bits(self, size, codec, rate):
        """Of one view to one viewer, bit/s. H.264: the daemon's default."""
        if codec == "h264":
            return K * min(40000, max(300, self.figures["kbps"].value
                                      * self.size(size) ** 0.75))
        return self.figures["jpeg_kb"].values[-1] * K * 8 * self.size(size) \
            * rate


class Need:
    """What N cameras take on machines that have a device for each daemon."""

    def __init__(self, model, cameras, size, rate, codec, machine,
                 traffic=False):
        self.cameras, self.size, self.rate = cameras, size, rate
        self.codec, self.machine, self.model = codec, machine, model
        self.pictures = cameras * rate
        self.devices = self.pictures * (
            model.traffic_s(size) if traffic else model.device_s(size))
        self.cores = model.cores(self.pictures, size, codec)
        self.software = model.software_cores(self.pictures, size)
        self.places = model.places(size)
        self.daemons = up(cameras / self.places)
        self.bits = cameras * model.bits(size, codec, rate)
        # All of one state, so of one exercise.
        self.states = up(cameras / model.figures["views"].value)
        # In machines, before they are made whole.
        load = machine["load"]
        self.shares = {
            "a daemon's places": cameras / self.places,
            "the device": self.devices / load,
            "cores": self.cores / machine["cores"] / load,
            "the network": self.bits / machine["bits"] / load}
        self.order = sorted(self.shares, key=self.shares.get, reverse=True)
        self.machines = up(self.shares[self.order[0]])
        self.next_machines = up(self.shares[self.order[1]])

    def cost(self, price):
        """For an hour: whole machines, each with its cores and its device."""
        each = price["machine"] + price["device"] \
            + price["core"] * self.machine["cores"]
        return self.machines * each


class Viewers:
    """Who watch by HLS through edges, one view each."""

    def __init__(self, model, cameras, size, viewers, edge_bits, load):
        self.stream = model.bits(size, "h264", None)
        self.all = viewers * self.stream
        self.carrying = up(self.all / (edge_bits * load))
        self.edges = self.carrying + 1
        self.origin = cameras * self.stream * self.edges
        self.wall = self.all * cameras


class Frames:
    """A set of labelled frames on the software device."""

    def __init__(self, figures, frames, cores, size):
        self.core_h = frames * figures["set_s"].value / 3600
        self.hours = self.core_h / cores
        self.bytes = frames * figures["set_kb"].value * K
        self.exr_h = frames * figures["exr_ms"].value / K \
            * size[0] * size[1] / HD_PIXELS / 3600


class Log:
    """One exercise of so many nodes at so many frames a second."""

    def __init__(self, nodes, rate):
        # Each node says once a second how it is, and watches all of it.
        self.puts = rate + nodes
        self.told = nodes * self.puts
        self.period_ms = K / rate
