#!/usr/bin/python3
"""Rasters of heights whose numbers look right and are not: fill values that
nobody declared, ranges and scales that GDAL leaves out, directions and units
that only a title has. Each is read as it says, or refused with a command."""
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

import netCDF4
import numpy as np
from osgeo import gdal as geo
from osgeo import osr

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import SLOW_S
from seabed_test import DOWN, LATS, LONS, STEP, bottom

geo.UseExceptions()
HOLE = (slice(2, 8), slice(2, 9)) # south-west, 7 km and more from the origin
IN_HOLE = {"east": -7500, "north": -8500}


def holed(value, values=-DOWN):
    values = values.copy()
    values[HOLE] = value
    return values


class Undeclared(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="pelagos-undeclared-")
        cls.addClassCleanup(shutil.rmtree, cls.folder)

    def netcdf(self, values=-DOWN, name="z", kind="f4", **attributes):
        path = os.path.join(self.folder, "seabed.nc")
        with netCDF4.Dataset(path, "w") as d:
            for axis, v, units in (("lon", LONS, "degrees_east"),
                                   ("lat", LATS, "degrees_north")):
                d.createDimension(axis, len(v))
                c = d.createVariable(axis, "f8", (axis,))
                c.units, c[:] = units, v
            v = d.createVariable(name, kind, ("lat", "lon"))
            v.set_auto_maskandscale(False)
            v.setncatts(attributes)
            v[:] = values.astype(kind)
        return path

    def tiff(self, values=-DOWN, title="", nodata=None):
        path = os.path.join(self.folder, "seabed.tif")
        frame = osr.SpatialReference()
        frame.SetFromUserInput("EPSG:4326")
        to = geo.GetDriverByName("GTiff").Create(
            path, len(LONS), len(LATS), 1, geo.GDT_Float32)
        to.SetSpatialRef(frame)
        to.SetGeoTransform([LONS[0] - STEP / 2, STEP, 0,
                            LATS[-1] + STEP / 2, 0, -STEP])
        band = to.GetRasterBand(1)
        band.SetDescription(title)
        if nodata is not None:
            band.SetNoDataValue(nodata)
        band.WriteRaster(0, 0, len(LONS), len(LATS),
                         values[::-1].astype("f4").tobytes())
        return path

    def is_at(self, path, want=-40, **place):
        got = bottom(path, **place)
        self.assertIsInstance(got, float, got)
        self.assertAlmostEqual(got, want, delta=0.1)

    def refused(self, path, *words):
        got = bottom(path)
        self.assertIsInstance(got, str, got)
        for word in words:
            self.assertIn(word, got)
        self.assertLess(len(got), 256)
        return got

    def mended(self, path, said, tool):
        """The command of the refusal makes it one that is read."""
        self.assertIn(tool, said)
        if shutil.which(tool):
            words = said[said.index(tool):].split()
            self.assertEqual(words[-1], "FILE")
            subprocess.run([*words[:-1], path], check=True, timeout=SLOW_S)
            self.is_at(path)
            self.assertTrue(np.isnan(bottom(path, **IN_HOLE)))

    def test_fills(self):
        for fill in (-999, 999, -99, -999.9, -888, 9999, -32768):
            path = self.netcdf(holed(fill))
            self.mended(path, self.refused(path, f"{fill:g}"), "ncatted")
            path = self.tiff(holed(fill))
            self.mended(path, self.refused(path, f"{fill:g}"), "gdal_edit.py")
        # of another fill value than that which it declares
        self.refused(self.tiff(holed(-999), nodata=-9999), "-999")
        path = self.netcdf(holed(-9990, -10 * DOWN), kind="i2",
                           scale_factor=0.1)
        self.mended(path, self.refused(path, "z,o,s,-9990"), "ncatted")

    def test_no_fills(self):
        """A slope that ends at -999 and a bottom that is flat there."""
        slope = -999 + 15 * (LONS[None, :] - LONS[0]) / STEP + 0 * DOWN
        self.is_at(self.tiff(slope), slope[24, 30])
        self.is_at(self.tiff(-999 + 0 * DOWN), -999)

    def test_told(self):
        for more in ({"valid_range": np.float32([-900, 900])},
                     {"valid_min": np.float32(-900)},
                     {"missing_value": np.float32([-888, -999])},
                     {"missing_value": np.float32(-999)}):
            path = self.netcdf(holed(-999), **more)
            self.is_at(path)
            self.assertTrue(np.isnan(bottom(path, **IN_HOLE)), more)
        self.is_at(self.netcdf(-10 * DOWN, kind="i2", scale_factor="0.1"))

    def test_titles(self):
        """A depth by its title, a unit by its title."""
        for name, more in (("bathy", {}), ("dpt", {}),
                           ("wct", {"long_name": "sounding"}),
                           ("z", {"comment": "positive down"}),
                           ("z", {"positive": "downwards"}),
                           ("z", {"long_name": "floor, positive downwards"}),
                           ("z", {"description": "depths"})):
            self.is_at(self.netcdf(DOWN, name, **more))
        self.is_at(self.tiff(DOWN, "Soundings"))
        self.is_at(self.tiff(-DOWN / 0.3048, "Elevation (feet)"))
        self.is_at(self.netcdf(DOWN / 1.8288, "depth_fathoms"))
        self.is_at(self.netcdf(-DOWN / 0.3048, "z", long_name="height [ft]"))
        self.is_at(self.netcdf(-DOWN, "z", long_name="foot of the slope",
                               units="m"))
        # a depth that is negative all over contradicts itself
        self.refused(self.netcdf(-DOWN, standard_name="depth"),
                     "grow downward", "ncatted")


if __name__ == "__main__":
    unittest.main(verbosity=2)
