#!/usr/bin/python3
"""Height files that would read, write or fetch something else. Each is first
opened with all of GDAL's drivers and no sandbox, which shows that it is what
it claims; then by the reader, then with all drivers inside the sandbox."""
import http.server
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import threading
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import BIN, SLOW_S, Daemon

READER = os.path.join(BIN, "pelagos-seabed")
ANY = os.path.join(BIN, "any_raster")
SIDE = 64
SECRET = 777


class Web(http.server.BaseHTTPRequestHandler):
    def do_GET(self):
        self.server.requests.append(self.path)
        self.send_error(404)

    do_HEAD = do_GET

    def log_message(self, *_):
        pass


def mrf(source, folder):
    return (f"<MRF_META><CachedSource><Source>{source}</Source></CachedSource>"
            f"<Raster><Size x='{SIDE}' y='{SIDE}' c='1'/>"
            f"<PageSize x='{SIDE}' y='{SIDE}' c='1'/>"
            "<Compression>NONE</Compression><DataType>Float32</DataType>"
            f"<DataFile>{folder}/written.dat</DataFile>"
            f"<IndexFile>{folder}/written.idx</IndexFile></Raster></MRF_META>")


def vrt(source):
    return (f"<VRTDataset rasterXSize='{SIDE}' rasterYSize='{SIDE}'>"
            "<VRTRasterBand dataType='Float32' band='1'><SimpleSource>"
            f"<SourceFilename>{source}</SourceFilename>"
            "<SourceBand>1</SourceBand></SimpleSource></VRTRasterBand>"
            "</VRTDataset>")


def ers(raw):
    return ('DatasetHeader Begin\n\tVersion = "6.0"\n'
            f'\tDataFile = "{raw}"\n\tDataSetType = ERStorage\n'
            "\tDataType = Raster\n\tByteOrder = LSBFirst\n"
            "\tRasterInfo Begin\n\t\tCellType = IEEE4ByteReal\n"
            f"\t\tNrOfLines = {SIDE}\n\t\tNrOfCellsPerLine = {SIDE}\n"
            "\t\tNrOfBands = 1\n\tRasterInfo End\nDatasetHeader End\n")


def isis3(raw):
    return ("Object = IsisCube\n  Object = Core\n    StartByte = 1\n"
            f'    ^Core = "{raw}"\n    Format = BandSequential\n'
            f"    Group = Dimensions\n      Samples = {SIDE}\n"
            f"      Lines = {SIDE}\n      Bands = 1\n    End_Group\n"
            "    Group = Pixels\n      Type = Real\n      ByteOrder = Lsb\n"
            "      Base = 0.0\n      Multiplier = 1.0\n    End_Group\n"
            "  End_Object\nEnd_Object\nEnd\n")


def pds(raw):
    return ("PDS_VERSION_ID = PDS3\r\nRECORD_TYPE = FIXED_LENGTH\r\n"
            f"RECORD_BYTES = 256\r\nFILE_RECORDS = 64\r\n^IMAGE = \"{raw}\"\r\n"
            f"OBJECT = IMAGE\r\n  LINES = {SIDE}\r\n  LINE_SAMPLES = {SIDE}\r\n"
            "  SAMPLE_TYPE = PC_REAL\r\n  SAMPLE_BITS = 32\r\n  BANDS = 1\r\n"
            "END_OBJECT = IMAGE\r\nEND\r\n")


def pds4(raw):
    axes = "".join(f"<Axis_Array><axis_name>{name}</axis_name>"
                   f"<elements>{SIDE}</elements><sequence_number>{i}"
                   "</sequence_number></Axis_Array>"
                   for i, name in ((1, "Line"), (2, "Sample")))
    return ('<?xml version="1.0"?><Product_Observational '
            'xmlns="http://pds.nasa.gov/pds4/pds/v1"><Identification_Area/>'
            f"<File_Area_Observational><File><file_name>{raw}</file_name>"
            '</File><Array_2D_Image><offset unit="byte">0</offset>'
            "<axes>2</axes><axis_index_order>Last Index Fastest"
            "</axis_index_order><Element_Array><data_type>IEEE754LSBSingle"
            f"</data_type></Element_Array>{axes}</Array_2D_Image>"
            "</File_Area_Observational></Product_Observational>")


def kml(picture):
    return ('<?xml version="1.0"?><kml xmlns="http://www.opengis.net/kml/2.2">'
            f"<Document><GroundOverlay><name>x</name><Icon><href>{picture}"
            "</href></Icon><LatLonBox><north>53</north><south>52</south>"
            "<east>6</east><west>5</west></LatLonBox></GroundOverlay>"
            "</Document></kml>")


def ozi(picture):
    corners = "".join(f"Point0{i},xy,{x},{y},in, deg, 52,{lat},N, 5,{lon},E, "
                      "grid, , , ,N\r\n"
                      for i, x, y, lat, lon in ((1, 0, 0, "30.0", "6.0"),
                                                (2, 63, 63, "24.0", "12.0"),
                                                (3, 63, 0, "30.0", "12.0")))
    return (f"OziExplorer Map Data File Version 2.2\r\nx\r\n{picture}\r\n"
            "1 ,Map Code,\r\nWGS 84,WGS 84,   0.0000,   0.0000,WGS 84\r\n"
            "Reserved 1\r\nReserved 2\r\nMagnetic Variation,,,E\r\n"
            "Map Projection,Latitude/Longitude,PolyCal,No,AutoCalOnly,No,"
            f"BSBUseWPX,No\r\n{corners}IWH,Map Image Width/Height,64,64\r\n")


@unittest.skipUnless(shutil.which("gdal_translate"), "needs gdal-bin")
class Hostile(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.top = tempfile.mkdtemp(prefix="pelagos-hostile-")
        cls.folder = os.path.join(cls.top, "bathymetry")
        cls.outside = os.path.join(cls.top, "outside")
        os.mkdir(cls.folder)
        os.mkdir(cls.outside)
        raw, tif, png, h5 = (cls.out(f"secret.{kind}")
                             for kind in ("bin", "tif", "png", "h5"))
        with open(raw, "wb") as f:
            f.write(struct.pack("<f", SECRET) * SIDE * SIDE)
        with open(cls.out("secret.asc"), "w") as f:
            f.write(f"ncols {SIDE}\nnrows {SIDE}\nxllcorner 5.1\n"
                    "yllcorner 52.5\ncellsize 0.001\n"
                    + (f"{SECRET} " * SIDE + "\n") * SIDE)
        translate = ["gdal_translate", "-q", "-a_srs", "EPSG:4326"]
        for more in ([tif], ["-ot", "Byte", "-of", "PNG", "-scale", "0", "777",
                             "0", "200", png]):
            subprocess.run([*translate, *more[:-1], cls.out("secret.asc"),
                            more[-1]], check=True, timeout=SLOW_S)
        # as a file of this directory, for links and sidecars
        shutil.copy(tif, cls.inside("good.tif"))
        cls.hdf5("plain", h5, "-")
        cls.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Web)
        cls.server.requests = []
        threading.Thread(target=cls.server.serve_forever, daemon=True).start()
        cls.web = f"/vsicurl/http://127.0.0.1:{cls.server.server_port}/x.png"
        # name: (text, the value that would come out)
        cls.reading = {"cache.mrf": (mrf(tif, cls.outside), 777),
                       "other.vrt": (vrt(tif), 777),
                       "other.ers": (ers(raw), 777),
                       "other.cub": (isis3(raw), 777),
                       "other.lbl": (pds(raw), 777),
                       "other.xml": (pds4(raw), 777),
                       "other.kml": (kml(png), 200),
                       "other.map": (ozi(png), 200)}
        cls.fetching = {"web.mrf": mrf(cls.web, cls.outside),
                        "web.kml": kml(cls.web), "web.map": ozi(cls.web)}
        for name, (text, _) in cls.reading.items():
            cls.write(name, text)
        for name, text in cls.fetching.items():
            cls.write(name, text)
        for kind, other in (("storage", raw), ("virtual", h5), ("link", h5)):
            cls.hdf5(kind, cls.inside(f"{kind}.h5"), other)
            # netCDF 4 is HDF5 by another name
            shutil.copy(cls.inside(f"{kind}.h5"), cls.inside(f"{kind}.nc"))

    @classmethod
    def tearDownClass(cls):
        cls.server.shutdown()
        cls.server.server_close()
        shutil.rmtree(cls.top)

    @classmethod
    def out(cls, name):
        return os.path.join(cls.outside, name)

    @classmethod
    def inside(cls, name):
        return os.path.join(cls.folder, name)

    @classmethod
    def write(cls, name, text):
        with open(cls.inside(name), "w", newline="") as f:
            f.write(text)

    @classmethod
    def hdf5(cls, kind, name, other):
        subprocess.run([ANY, "hdf5", kind, name, other], check=True,
                       timeout=SLOW_S)

    def any(self, walls, name):
        return subprocess.run([ANY, "read", walls, name], cwd=self.folder,
                              capture_output=True, text=True, timeout=SLOW_S)

    def reader(self, name, *place):
        return subprocess.run(
            [READER, "52.5", "5.1", "elevation", self.folder, name, *place],
            capture_output=True, timeout=SLOW_S)

    def written(self):
        return {name: os.path.getsize(os.path.join(folder, name))
                for folder in (self.outside, self.folder)
                for name in os.listdir(folder)}

    def refused(self, name):
        """By the reader, where the file says where it lies and where it does
        not; and by the sandbox alone."""
        before = self.written()
        for place in ((), ("52.5", "5.1", "10")):
            result = self.reader(name, *place)
            self.assertEqual((result.returncode, result.stdout), (1, b""),
                             name)
            self.assertTrue(result.stderr.strip(), name)
        self.assertEqual(self.written(), before, name)

    def test_files_of_elsewhere(self):
        for name, (_, value) in self.reading.items():
            self.assertEqual(self.any("none", name).stdout, f"{value}\n", name)
            for made in ("written.dat", "written.idx"):
                if os.path.exists(self.out(made)):
                    os.remove(self.out(made))
            self.refused(name)

    def test_hdf5(self):
        for kind in ("storage", "virtual"):
            self.assertEqual(self.any("none", f"{kind}.h5").stdout,
                             f"{SECRET}\n", kind)
        for kind, words in (("storage", b"external storage"),
                            ("virtual", b"virtual data set"),
                            ("link", b"external link")):
            for ending in ("h5", "nc"):
                name = f"{kind}.{ending}"
                self.refused(name)
                self.assertIn(words, self.reader(name).stderr, name)

    def test_requests(self):
        for name in self.fetching:
            self.server.requests.clear()
            self.any("none", name)
            self.assertTrue(self.server.requests, name)
            self.server.requests.clear()
            self.refused(name)
            self.assertEqual(self.server.requests, [], name)

    def test_the_sandbox_alone(self):
        """Every driver there is, and nothing gets out or in."""
        walls = subprocess.run([ANY, "walls"], capture_output=True, text=True,
                               timeout=SLOW_S).stdout.split()
        for wall in walls:
            before = self.written()
            self.server.requests.clear()
            for name in [*self.reading, *self.fetching, "storage.h5",
                         "virtual.h5"]:
                result = self.any(wall, name)
                if wall != "calls":  # which cannot tell files apart
                    self.assertNotIn(result.stdout.strip(),
                                     ("777", "200"), (wall, name))
                self.assertEqual(self.written(), before, (wall, name))
            if wall != "files":  # which an older kernel has without ports
                self.assertEqual(self.server.requests, [], wall)
            # and what may be read is
            self.assertEqual(self.any(wall, "good.tif").stdout, "777\n", wall)
        if not walls:
            self.skipTest("this system has neither Landlock nor seccomp")

    def test_sidecars_and_links(self):
        # georeference beside the file: an ENVI header that leads out
        shutil.copy(self.out("secret.bin"), self.inside("raw.bin"))
        with open(self.out("raw.hdr"), "w") as f:
            f.write(f"ENVI\nsamples = {SIDE}\nlines = {SIDE}\nbands = 1\n"
                    "header offset = 0\nfile type = ENVI Standard\n"
                    "data type = 4\ninterleave = bsq\nbyte order = 0\n")
        os.symlink(self.out("raw.hdr"), self.inside("raw.hdr"))
        place = ("52.5", "5.1", "10")
        walls = subprocess.run([ANY, "walls"], capture_output=True, text=True,
                               timeout=SLOW_S).stdout.split()
        if "files" in walls:
            self.refused("raw.bin")
        os.remove(self.inside("raw.hdr"))
        shutil.copy(self.out("raw.hdr"), self.inside("raw.hdr"))
        self.assertEqual(self.reader("raw.bin", *place).returncode, 0)

    def test_the_daemon(self):
        os.symlink(self.out("secret.tif"), self.inside("out.tif"))
        os.symlink("good.tif", self.inside("in.tif"))
        os.mkfifo(self.inside("fifo.tif"))
        os.mkdir(self.inside("directory.tif"))
        with Daemon("--bathymetry", self.folder) as daemon:
            before = self.written()
            for name in [*self.reading, *self.fetching, "storage.h5",
                         "link.nc", "out.tif", "fifo.tif", "directory.tif",
                         "/vsicurl/http://127.0.0.1/x.tif"]:
                answer = daemon.patch({"seabed": {
                    "file": name, "latitude": 52.6, "longitude": 5.2,
                    "spacing": 10}})
                self.assertNotEqual(answer.status, 200, name)
                self.assertIn("seabed.file", answer.body.decode())
            self.assertEqual(self.written(), before)
            self.assertNotIn("file", daemon.state().get("seabed", {}))
            answer = daemon.patch({"seabed": {"file": "out.tif"}})
            self.assertIn("link out of", answer.body.decode())
            answer = daemon.patch({"origin": {"latitude": 52.52,
                                              "longitude": 5.12},
                                   "seabed": {"file": "in.tif"}})
            self.assertEqual(answer.status, 200, answer)


if __name__ == "__main__":
    unittest.main(verbosity=2)
