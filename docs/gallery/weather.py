#!/usr/bin/python3
"""Writes winds over the Earth for the gallery: trades, westerlies, calms between
them, lows and highs; no day's weather.

    weather.py FILE.nc
"""
import sys

import netCDF4
import numpy as np

# Latitude, longitude, greatest wind (m/s, anticlockwise) and where it is, km.
WHIRLS = [(14, -141, 24, 260), (38, -163, 19, 900), (46, -138, 17, 800),
          (31, -146, -8, 1100), (27, -178, -9, 1200), (-17, -152, -16, 500),
          (-42, -140, -20, 900), (-48, -172, -18, 1000), (-28, -125, 8, 1200),
          (8, -170, 7, 500), (4, -128, 6, 450)]


def winds(lat, lon):
    """East and north components at 10 m, m/s."""
    rad, lat = np.radians, lat + 0 * lon
    side = np.sign(lat)
    east = (-7.5 * np.exp(-((np.abs(lat) - 15) / 8) ** 2) +
            8.5 * np.exp(-((np.abs(lat) - 46) / 11) ** 2))
    north = -2.5 * side * np.exp(-((np.abs(lat) - 13) / 8) ** 2)
    for la, lo, most, radius in WHIRLS:
        x = (np.mod(lon - lo + 180, 360) - 180) * 111.2 * np.cos(rad(lat))
        y = (lat - la) * 111.2
        r = np.hypot(x, y) + 1e-6
        speed = most * r / radius * np.exp(0.5 * (1 - (r / radius) ** 2))
        # Inflow over the sea turns it by 20 degrees.
        inward = np.abs(speed) * (0.35 if most * la > 0 else -0.35)
        east += (-y * speed - x * inward) / r
        north += (x * speed - y * inward) / r
    for k in range(1, 7): # gusty
        a, b = 2.3 * k, 11 + 9 * k
        wave = np.sin(rad(b * lat + 31 * k) + 2 * np.sin(rad(b * lon / 2 + a)))
        east *= 1 + 0.12 * wave / np.sqrt(k)
        north *= 1 + 0.12 * wave / np.sqrt(k)
    return east, north


def main():
    if len(sys.argv) != 2:
        sys.exit("weather.py FILE.nc")
    lats, lons = np.arange(90, -90.1, -0.5), np.arange(-180, 180, 0.5)
    fields = winds(lats[:, None], lons[None, :])
    with netCDF4.Dataset(sys.argv[1], "w", format="NETCDF3_CLASSIC") as d:
        for name, values, unit in (("latitude", lats, "degrees_north"),
                                   ("longitude", lons, "degrees_east"),
                                   ("time", [0],
                                    "hours since 2026-06-21 12:00:00")):
            d.createDimension(name, len(values))
            v = d.createVariable(name, "f4", (name,))
            v.units = unit
            v[:] = values
        for name, field in zip(("u10", "v10"), fields):
            v = d.createVariable(name, "f4", ("time", "latitude", "longitude"))
            v.units = "m s-1"
            v[:] = field[None]


if __name__ == "__main__":
    main()
