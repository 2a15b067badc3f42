"""VTK reads what the writer wrote. Run by the GoogleTest Vtu.VtkReadsEveryValue, which writes the samples."""

import math
import os
import unittest

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

from berm.results import read_series

SAMPLES = os.environ.get("BERM_VTU_SAMPLES")


def read(name):
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(os.path.join(SAMPLES, name))
    errors = []
    reader.AddObserver("ErrorEvent", lambda *_: errors.append("error"))
    reader.Update()
    if errors:
        raise AssertionError(f"VTK could not read {name}")
    return reader.GetOutput()


def array(attributes, name):
    return vtk_to_numpy(attributes.GetArray(name))


@unittest.skipUnless(SAMPLES, "no samples: run through the GoogleTest Vtu.VtkReadsEveryValue")
class WrittenFiles(unittest.TestCase):
    def test_mixed_mesh(self):
        grid = read("mixed.vtu")
        self.assertEqual([grid.GetCellType(c) for c in range(grid.GetNumberOfCells())], [22, 5, 9])
        cells = [[grid.GetCell(c).GetPointId(k) for k in range(grid.GetCell(c).GetNumberOfPoints())] for c in range(3)]
        self.assertEqual(cells, [[0, 1, 2, 3, 4, 5], [6, 7, 8], [0, 1, 10, 11]])
        points = vtk_to_numpy(grid.GetPoints().GetData())
        np.testing.assert_array_equal(points, [[0.1 * i, 1.0 / (i + 1), 0.0] for i in range(12)])
        displacement = array(grid.GetPointData(), "displacement")
        np.testing.assert_allclose(displacement.ravel(), [math.sin(i) for i in range(36)], rtol=1e-15)
        body = array(grid.GetCellData(), "body")
        self.assertEqual(body.dtype.kind, "i")
        np.testing.assert_array_equal(body, [-7, 0, 2147483647])
        np.testing.assert_array_equal(array(grid.GetCellData(), 'a<b & "c"'), [1e-300, 0.1, -1e300])

    def test_clouds_of_several_blocks(self):
        for name, n in (("cloud.vtu", 100001), ("block.vtu", 131072)):
            with self.subTest(name):
                grid = read(name)
                self.assertEqual((grid.GetNumberOfPoints(), grid.GetNumberOfCells()), (n, n))
                self.assertTrue((vtk_to_numpy(grid.GetCellTypesArray()) == 1).all())
                self.assertEqual(grid.GetCell(n - 1).GetPointId(0), n - 1)
                i = np.arange(n, dtype=float)
                np.testing.assert_array_equal(
                    vtk_to_numpy(grid.GetPoints().GetData()), np.stack([i, 0.5 * i, 0 * i], 1)
                )
                stress = array(grid.GetPointData(), "stress")
                np.testing.assert_array_equal(stress, 1e6 * i[:, None] + np.arange(6))

    def test_empty_cloud(self):
        grid = read("empty.vtu")
        self.assertEqual((grid.GetNumberOfPoints(), grid.GetNumberOfCells()), (0, 0))

    def test_series(self):
        series = read_series(os.path.join(SAMPLES, "series.pvd"))
        self.assertEqual([time for time, _ in series], [0.0, 1.0 / 3.0])
        self.assertEqual([os.path.basename(file) for _, file in series], ["mixed.vtu", "cloud.vtu"])


if __name__ == "__main__":
    unittest.main()
