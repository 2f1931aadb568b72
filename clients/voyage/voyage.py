#!/usr/bin/python3
"""Writes voyage.nmea, the voyage of `make demo`: 64 s of a coaster that leaves
the shelter of Enkhuizen for the Markermeer, from 6 to 12 knots, with a turn of
60 degrees to starboard, and takes up the motion of the open water.

Four times a second: position, heading, turn rate, heel and trim; once a
second: time, wind and depth. The wind freshens for ten seconds, then stays: a
console may take it over from there. All of it is made up.
"""
import math
import sys

RATE_HZ = 4
SECONDS = 64
START = (52.6935, 5.2905)  # deg north, deg east
NOON_S = 12 * 3600
KNOT = 1852 / 3600
METRES_PER_MINUTE = 1855.7  # of latitude, 52.7 N


def smooth(t, start, end):
    """From 0 to 1 between start and end, with no corner."""
    x = min(max((t - start) / (end - start), 0), 1)
    return x * x * (3 - 2 * x)


def speed_kn(t):
    return 6 + 6 * smooth(t, 8, 40)


def heading_deg(t):
    return 215 + 60 * smooth(t, 18, 46)


def turn_rate(t):
    return (heading_deg(t + 0.05) - heading_deg(t - 0.05)) / 0.1  # deg/s


def course_deg(t):
    """The ship slides outward in the turn."""
    return heading_deg(t) - 1.5 * turn_rate(t)


def heel_deg(t):
    sea = 0.4 + 3.0 * smooth(t, 5, 45)
    roll = math.sin(2 * math.pi * t / 7.4) + 0.35 * math.sin(
        2 * math.pi * t / 5.9 + 1)
    return sea * roll - 1.6 * turn_rate(t) * speed_kn(t) / 12  # outward


def trim_deg(t):
    sea = 0.2 + 1.1 * smooth(t, 5, 45)
    pitch = math.sin(2 * math.pi * t / 4.8) + 0.3 * math.sin(
        2 * math.pi * t / 3.7 + 2)
    return sea * pitch + 0.4 * (speed_kn(t) - 6) / 6


def wind(t):
    """m/s, deg true it blows from."""
    return 5.5 + 1.5 * smooth(t, 0, 10), 244 + 6 * smooth(t, 0, 10)


def sentence(body):
    total = 0
    for c in body:
        total ^= ord(c)
    return f"${body}*{total:02X}"


def clock(t):
    t += NOON_S
    return f"{int(t) // 3600:02d}{int(t) // 60 % 60:02d}{t % 60:05.2f}"


def degrees_minutes(angle, width):
    minutes = abs(angle) * 60
    return f"{int(minutes) // 60:0{width}d}{minutes % 60:08.5f}"


def at(t, latitude, longitude):
    where = (f"{degrees_minutes(latitude, 2)},N,"
             f"{degrees_minutes(longitude, 3)},E")
    yield (f"GPRMC,{clock(t)},A,{where},{speed_kn(t):.2f},"
           f"{course_deg(t):.2f},210626,,,A")
    yield f"HEHDT,{heading_deg(t):.2f},T"
    yield f"HEROT,{turn_rate(t) * 60:.1f},A"
    yield f"IIXDR,A,{heel_deg(t):.2f},D,HEEL,A,{trim_deg(t):.2f},D,TRIM"
    if t == int(t):
        mps, deg = wind(t)
        yield f"GPZDA,{clock(t)},21,06,2026,00,00"
        yield f"WIMWD,{deg:.1f},T,,M,{mps / KNOT:.1f},N,{mps:.1f},M"
        yield f"SDDPT,{3.2 + 1.1 * smooth(t, 10, 60):.1f},0.6,"


def sail():
    latitude, longitude = START
    for i in range(SECONDS * RATE_HZ + 1):
        t = i / RATE_HZ
        for body in at(t, latitude, longitude):
            yield sentence(body)
        for k in range(10):  # small steps: the track is an arc
            u = t + (k + 0.5) / (10 * RATE_HZ)
            metres = speed_kn(u) * KNOT / (10 * RATE_HZ)
            course = math.radians(course_deg(u))
            latitude += metres * math.cos(course) / METRES_PER_MINUTE / 60
            longitude += (metres * math.sin(course) / METRES_PER_MINUTE / 60 /
                          math.cos(math.radians(latitude)))


if __name__ == "__main__":
    sys.stdout.write("".join(line + "\r\n" for line in sail()))
