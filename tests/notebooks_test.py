#!/usr/bin/python3
"""The notebooks of the Python client: stored without outputs, executed whole
against a daemon, their pictures kept in $NOTEBOOK_PICTURES, if that is set."""
import base64
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import nbclient
import nbformat

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import ROOT, SLOW_S, Daemon

SOURCE = pathlib.Path(ROOT) / "clients/python"
FILES = sorted((SOURCE / "notebooks").glob("*.ipynb"))


class Notebooks(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon()
        folder = cls.enterClassContext(tempfile.TemporaryDirectory())
        os.environ.update(
            PELAGOS_URL=cls.daemon.url(""), PYTHONPATH=str(SOURCE),
            PYTHONDONTWRITEBYTECODE="1", IPYTHONDIR=f"{folder}/ipython",
            JUPYTER_RUNTIME_DIR=f"{folder}/runtime",
            PYDEVD_DISABLE_FILE_VALIDATION="1", MPLCONFIGDIR=f"{folder}/matplotlib",
            # Debian's kernel and packages, whatever else is in PATH.
            JUPYTER_PATH="/usr/share/jupyter", JUPYTER_DATA_DIR=folder,
            PATH="/usr/bin:/bin:" + os.environ["PATH"])
        # It says on stderr that it makes its cache of fonts.
        subprocess.run(["/usr/bin/python3", "-c",
                        "import matplotlib.font_manager"], check=True,
                       capture_output=True)

    @classmethod
    def tearDownClass(cls):
        status = cls.daemon.stop()
        assert status == 0, f"the daemon ended with {status}"

    def test_five(self):
        self.assertEqual([f.name[:2] for f in FILES],
                         [f"{n}_" for n in range(1, 6)])

    def test_stored_without_outputs(self):
        for file in FILES:
            book = nbformat.read(file, as_version=4)
            nbformat.validate(book)
            for cell in book.cells:
                if cell.cell_type == "code":
                    self.assertEqual((cell.outputs, cell.execution_count),
                                     ([], None), file.name)

    def execute(self, number):
        file = FILES[number - 1]
        book = nbformat.read(file, as_version=4)
        nbclient.NotebookClient(
            book, timeout=20 * int(SLOW_S), startup_timeout=10 * int(SLOW_S),
            kernel_name="python3").execute()
        pictures = [output.data["image/png"] for cell in book.cells
                    for output in cell.get("outputs", [])
                    if "image/png" in output.get("data", {})]
        streams = "".join(
            output.text for cell in book.cells
            for output in cell.get("outputs", [])
            if output.output_type == "stream" and output.name == "stderr")
        self.assertEqual(streams, "")
        if kept := os.environ.get("NOTEBOOK_PICTURES"):
            for n, data in enumerate(pictures):
                pathlib.Path(kept, f"{file.stem}-{n}.png").write_bytes(
                    base64.b64decode(data))
        return len(pictures)

    def test_first_picture(self):
        self.assertEqual(self.execute(1), 2)

    def test_sea_state(self):
        self.assertEqual(self.execute(2), 3)

    def test_depth_and_labels(self):
        self.assertEqual(self.execute(3), 1)

    def test_colour_of_water(self):
        self.assertEqual(self.execute(4), 3)

    def test_voyage(self):
        self.assertEqual(self.execute(5), 2)


if __name__ == "__main__":
    unittest.main(verbosity=2)
