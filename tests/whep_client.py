"""A WHEP player by GStreamer's webrtcbin, without the page: what it decodes, as
grey pictures. Needs python3-gst."""
import random
import re
import socket
import threading
import time

import gi

gi.require_version("Gst", "1.0")
gi.require_version("GstSdp", "1.0")
gi.require_version("GstWebRTC", "1.0")
from gi.repository import Gst, GstSdp, GstWebRTC

Gst.init(None)
CAPS = {codec: f"application/x-rtp,media=video,encoding-name={codec},payload=97,"
               f"clock-rate=90000{more}" for codec, more in (
                   ("H264", ",packetization-mode=(string)1,"
                            "profile-level-id=(string)42e01f"), ("VP8", ""))}
DECODE = {"H264": "rtph264depay ! h264parse ! openh264dec",
          "VP8": "rtpvp8depay ! vp8dec"}
SHOW = ("queue ! {} ! videoconvert ! video/x-raw,format=GRAY8 ! appsink name=out "
        "max-buffers=4 drop=true sync=false")


def taken(answer):
    """The answer as if its refused line of data were taken: Pion begins SCTP
    in spite of a refusal."""
    media, data = answer.split("m=application 0 ", 1)
    mid = re.search(r"a=mid:(\S+)", data).group(1)
    transport = re.findall(r"a=(?:ice-ufrag|ice-pwd|setup|fingerprint):.*\r\n",
                           media)
    return (re.sub(r"(a=group:BUNDLE .*)\r\n", rf"\1 {mid}\r\n", media)
            + "m=application 9 UDP/DTLS/SCTP webrtc-datachannel\r\n"
            f"c=IN IP4 0.0.0.0\r\na=mid:{mid}\r\na=sctp-port:5000\r\n"
            + "".join(transport))


class Player:
    """Makes an offer; `answered(sdp)` connects; frames() takes pictures."""

    def __init__(self, asks_again=False, address="127.0.0.1", codec="H264",
                 data=False):
        """asks_again: for lost packets (NACK, RTX); address: its own; data:
        with a channel of data, which it begins whatever the answer says."""
        self.data = data
        self.codec = codec
        self.pipeline = Gst.Pipeline()
        self.web = Gst.ElementFactory.make("webrtcbin")
        self.web.set_property("bundle-policy", "max-bundle")
        self.pipeline.add(self.web)
        # Loopback, which ICE leaves out where it is not told so.
        self.ice = self.web.get_property("ice-agent")
        self.ice.emit("add-local-ip-address", address)
        self.agent = self.ice.get_property("agent")
        self.agent.set_property("upnp", False)
        self.out = self.last = None
        self.ready = threading.Event()
        self.web.connect("pad-added", self.add_pad)
        self.web.emit("add-transceiver",
                      GstWebRTC.WebRTCRTPTransceiverDirection.RECVONLY,
                      Gst.Caps.from_string(CAPS[codec]))
        if asks_again:
            self.web.emit("get-transceiver", 0).set_property("do-nack", True)
        self.pipeline.set_state(Gst.State.PLAYING)
        if data:
            self.channel = self.web.emit("create-data-channel", "d", None)

    def wait(self, signal, *values):
        promise = Gst.Promise.new()
        self.web.emit(signal, *values, promise)
        promise.wait()
        self.promise = promise  # what it holds is borrowed
        return promise.get_reply()

    def offer(self):
        reply = self.wait("create-offer", None)
        made = reply.get_value("offer")
        text = made.sdp.as_text()
        _, sdp = GstSdp.SDPMessage.new_from_text(text)
        self.wait("set-local-description",
                  GstWebRTC.WebRTCSessionDescription.new(
                      GstWebRTC.WebRTCSDPType.OFFER, sdp))
        return text

    def gathered(self):
        """The offer with all candidates, once they are there."""
        self.offer()
        complete = GstWebRTC.WebRTCICEGatheringState.COMPLETE
        while self.web.get_property("ice-gathering-state") != complete:
            time.sleep(0.01)
        return self.web.get_property("local-description").sdp.as_text()

    def answered(self, text):
        if self.data:
            text = taken(text)
        _, sdp = GstSdp.SDPMessage.new_from_text(text)
        self.wait("set-remote-description",
                  GstWebRTC.WebRTCSessionDescription.new(
                      GstWebRTC.WebRTCSDPType.ANSWER, sdp))

    def add_pad(self, _, pad):
        if pad.get_direction() != Gst.PadDirection.SRC:
            return
        decode = Gst.parse_bin_from_description(
            SHOW.format(DECODE[self.codec]), True)
        self.out = decode.get_by_name("out")
        self.pipeline.add(decode)
        decode.sync_state_with_parent()
        pad.link(decode.get_static_pad("sink"))
        self.ready.set()

    def frame(self, seconds=60):
        """(width, height, bytes of rows), or None."""
        if not self.ready.wait(seconds):
            return None
        sample = self.out.emit("try-pull-sample", int(seconds * Gst.SECOND))
        if not sample:
            return None
        form = sample.get_caps().get_structure(0)
        buffer = sample.get_buffer()
        self.last = (form.get_value("width"), form.get_value("height"),
                     buffer.extract_dup(0, buffer.get_size()))
        return self.last

    def close(self):
        self.pipeline.set_state(Gst.State.NULL)


class Lossy:
    """A relay before a WHEP session on loopback, which drops a share of RTP's
    packets to the player once it is told so."""

    def __init__(self, seed):
        self.share, self.dropped = 0, 0
        self.again, self.kind = 0, None  # packets of RTX, by their type
        self.random = random.Random(seed)
        self.player = None
        self.inside, self.outside = (
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
        self.inside.bind(("127.0.0.1", 0))
        self.outside.bind(("127.0.0.1", 0))

    def answer(self, text):
        """The answer as a player gets it: the way leads over the relay."""
        self.kind = int(re.search(r"a=rtpmap:(\d+) rtx/", text).group(1))
        found = re.search(r"candidate:\S+ 1 UDP \d+ 127\.0\.0\.1 (\d+)", text)
        self.inside.connect(("127.0.0.1", int(found.group(1))))
        for way in (self._up, self._down):
            threading.Thread(target=way, daemon=True).start()
        port = self.outside.getsockname()[1]
        lines = [line for line in text.split("\r\n")
                 if not line.startswith("a=candidate:")]
        lines.insert(lines.index("a=end-of-candidates"), "a=candidate:1 1 UDP "
                     f"2015363327 127.0.0.1 {port} typ host")
        return "\r\n".join(lines)

    def _up(self):
        while True:
            data, self.player = self.outside.recvfrom(65536)
            try:
                self.inside.send(data)
            except OSError:
                pass  # the session has ended

    def _down(self):
        while True:
            try:
                data = self.inside.recv(65536)
            except OSError:
                continue
            # RFC 7983: RTP and RTCP from 128 to 191; RTCP by its second byte.
            media = 128 <= data[0] < 192 and not 200 <= data[1] <= 207
            self.again += media and data[1] & 127 == self.kind
            if media and self.random.random() < self.share:
                self.dropped += 1
            elif self.player:
                self.outside.sendto(data, self.player)
