"""Weather files for tests, written by others: GRIB2 by ecCodes, NetCDF by
netCDF4. Numbers are functions of latitude, longitude and hours."""
import os
import shutil
import struct
import subprocess

import numpy as np

SAMPLE = "/usr/share/eccodes/samples/regular_ll_sfc_grib{}.tmpl"
HAS_ECCODES = shutil.which("grib_filter") and os.path.exists(SAMPLE.format(2))
DATE = "20260621"  # at noon; 1782043200 s since 1970
NOON_UNIX_S = 1782043200
# ecCodes' name, unit of the last bit
NAMES = {"u10": "10u", "v10": "10v", "swh": "swh", "pp1d": "pp1d",
         "mwp": "mwp", "mwd": "mwd", "shww": "shww", "mpts": "mpts",
         "mdts": "mdts"}


# One quantum of each number that pelagos-weather hands over.
QUANTA = [1 / 256, 1 / 256, 1 / 1024, 1 / 1024, np.pi / 32767, 1 / 1024,
          1 / 1024, np.pi / 32767]


def parse(data):
    """The output of pelagos-weather: notes, and of each grid (west, south, steps),
    times and quanta by number."""
    assert data[:8] == b"pelwthr2", data[:8]
    count, length = struct.unpack("2I", data[8:16])
    notes, grids = data[16:16 + length].decode(), []
    at = 16 + (length + 7) // 8 * 8
    for _ in range(count):
        columns, rows, times, has = struct.unpack("4I", data[at:at + 16])
        place = struct.unpack("4d", data[at + 16:at + 48])
        unix = np.frombuffer(data, "f8", times, at + 48)
        at, values = at + 48 + 8 * times, {}
        for n in range(8):
            if has >> n & 1:
                values[n] = np.frombuffer(data, "i2", columns * rows * times,
                                          at).reshape(times, rows, columns)
                at += 2 * columns * rows * times
        at = (at + 7) // 8 * 8
        grids.append((place, unix, values))
    assert at == len(data), (at, len(data))
    return notes, grids


def grid(west, north, columns, rows, step):
    """Latitudes from north, longitudes."""
    return (north - step * np.arange(rows), west + step * np.arange(columns))


def write_grib(path, fields, lats, lons, hours, edition=2):
    """fields: {name: f(lat, lon, hours) -> array, NaN: none}."""
    step = abs(float(lons[1] - lons[0]))
    rules = []
    for hour in hours:
        for name, field in fields.items():
            v = field(lats[:, None], lons[None, :], hour)
            v = np.where(np.isnan(v), 9999, v)
            rules.append(
                f"set dataDate={DATE}; set dataTime=1200; set Ni={len(lons)}; "
                f"set Nj={len(lats)}; "
                f"set latitudeOfFirstGridPointInDegrees={lats[0]:.6f}; "
                f"set latitudeOfLastGridPointInDegrees={lats[-1]:.6f}; "
                f"set longitudeOfFirstGridPointInDegrees={lons[0]:.6f}; "
                f"set longitudeOfLastGridPointInDegrees={lons[-1]:.6f}; "
                f"set iDirectionIncrementInDegrees={step:.6f}; "
                f"set jDirectionIncrementInDegrees={step:.6f}; "
                f'set shortName="{NAMES[name]}"; set stepRange="{hour}"; '
                "set bitmapPresent=1; set missingValue=9999; "
                "set bitsPerValue=20; set values={"
                + ",".join(f"{x:.7g}" for x in v.ravel())
                + f'}}; write "{path}";\n')
    with open(path + ".rules", "w") as f:
        f.write("".join(rules))
    if os.path.exists(path):
        os.remove(path)
    subprocess.run(["grib_filter", path + ".rules", SAMPLE.format(edition)],
                   check=True, timeout=120)
    os.remove(path + ".rules")


def write_netcdf(path, fields, lats, lons, hours, packed=False, **more):
    """packed: 16 bits with scale and offset, as ERA5. more: leave_time,
    undeclared: a fill value that no attribute tells."""
    import netCDF4
    with netCDF4.Dataset(path, "w") as d:
        d.createDimension("time", None)
        d.createDimension("latitude", len(lats))
        d.createDimension("longitude", len(lons))
        la = d.createVariable("latitude", "f4", ("latitude",))
        lo = d.createVariable("longitude", "f4", ("longitude",))
        la.units, lo.units = "degrees_north", "degrees_east"
        la[:], lo[:] = lats, lons
        t = d.createVariable("time", "i4", ("time",))
        if not more.get("leave_time"):
            t.units = "hours since 1900-01-01 00:00:00.0"
        t[:] = [1108620 + h for h in hours]
        for name, field in fields.items():
            all_ = np.stack([field(lats[:, None], lons[None, :], h)
                             + np.zeros((len(lats), len(lons)))
                             for h in hours])
            if more.get("undeclared"):
                v = d.createVariable(name, "f4",
                                     ("time", "latitude", "longitude"))
                v[:] = np.where(np.isnan(all_), 1e20, all_)
                continue
            v = d.createVariable(name, "i2" if packed else "f4",
                                 ("time", "latitude", "longitude"),
                                 fill_value=-32767 if packed else 9.97e36)
            if packed:
                low, high = np.nanmin(all_), np.nanmax(all_)
                v.add_offset = (low + high) / 2
                v.scale_factor = max(high - low, 1e-3) / 65000
            v[:] = np.ma.masked_invalid(all_)


def front(lat, lon, hour):
    """0 before, 1 behind a front that moves east by 2° an hour."""
    return 0.5 + 0.5 * np.tanh((2 * hour - 1 - (lon - 4)) / 1.5) + 0 * lat


def wind(lat, lon, hour):
    speed = 5 + 9 * front(lat, lon, hour)
    comes_from = np.radians(200 + 80 * front(lat, lon, hour) + lat - 52)
    return -speed * np.sin(comes_from), -speed * np.cos(comes_from)


FIELDS = {
    "u10": lambda a, o, h: wind(a, o, h)[0],
    "v10": lambda a, o, h: wind(a, o, h)[1],
    "swh": lambda a, o, h: 1.5 + 1.7 * front(a, o, h) + 0.01 * (a - 52),
    "pp1d": lambda a, o, h: 10 - 2 * front(a, o, h),
    "mwd": lambda a, o, h: 230 + 30 * front(a, o, h),
}
