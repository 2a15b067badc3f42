"""VTK reads what the writer wrote. Run by the GoogleTest Vtu.VtkReadsEveryValue, which writes the samples."""

import math
import os
import unittest

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkFiltersVerdict import vtkMeshQuality
from vtkmodules.vtkIOXML import vtkXMLPUnstructuredGridReader, vtkXMLUnstructuredGridReader

from berm.results import read_series

SAMPLES = os.environ.get("BERM_VTU_SAMPLES")


def read(name):
    reader = vtkXMLPUnstructuredGridReader() if name.endswith(".pvtu") else vtkXMLUnstructuredGridReader()
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
        names = [grid.GetPointData().GetArray("displacement").GetComponentName(k) for k in range(3)]
        self.assertEqual(names, ["X", "Y", "Z"])
        body = array(grid.GetCellData(), "body")
        self.assertEqual(body.dtype.kind, "i")
        np.testing.assert_array_equal(body, [-7, 0, 2147483647])
        np.testing.assert_array_equal(array(grid.GetCellData(), 'a<b & "c"'), [1e-300, 0.1, -1e300])

    def test_solid_mesh(self):
        grid = read("solid.vtu")
        self.assertEqual([grid.GetCellType(c) for c in range(grid.GetNumberOfCells())], [10, 24, 12, 25, 9])
        sizes = [grid.GetCell(c).GetNumberOfPoints() for c in range(5)]
        self.assertEqual(sizes, [4, 10, 8, 20, 4])
        points = vtk_to_numpy(grid.GetPoints().GetData())
        for c in (1, 3):  # every mid-side node lies where VTK looks for it: half-way between the corners of its edge
            cell = grid.GetCell(c)
            for e in range(cell.GetNumberOfEdges()):
                edge = cell.GetEdge(e)
                a, b, middle = (points[edge.GetPointId(k)] for k in range(3))
                np.testing.assert_array_equal(middle, 0.5 * (a + b))
        quality = vtkMeshQuality()
        quality.SetInputData(grid)
        quality.SetTetQualityMeasureToVolume()
        quality.SetHexQualityMeasureToVolume()
        quality.Update()
        volume = array(quality.GetOutput().GetCellData(), "Quality")
        np.testing.assert_allclose([volume[0], volume[2]], [1.0 / 6.0, 8.0], rtol=1e-14)
        number = array(grid.GetPointData(), "id")
        self.assertEqual((number.dtype.kind, number.dtype.itemsize), ("i", 8))
        np.testing.assert_array_equal(number, [2**53 + 1 - i for i in range(30)])
        pair = array(grid.GetCellData(), "pair")
        np.testing.assert_array_equal(pair, [[1, -1], [2**63 - 1, -(2**63)], [0, 5], [6, 7], [8, 9]])

    def test_distributed_cloud(self):
        grid = read("whole.pvtu")
        self.assertEqual((grid.GetNumberOfPoints(), grid.GetNumberOfCells()), (8, 8))
        n = np.array([5] * 5 + [3] * 3)
        np.testing.assert_array_equal(
            vtk_to_numpy(grid.GetPoints().GetData()), np.stack([n, 0 * n, 0 * n + 1], 1).astype(float)
        )
        np.testing.assert_array_equal(array(grid.GetPointData(), "id"), 10**10 + n)
        np.testing.assert_array_equal(array(grid.GetPointData(), "stress"), 0.5 * n[:, None] * np.ones(6))
        np.testing.assert_array_equal(array(grid.GetPointData(), "a<b"), n)
        self.assertEqual([grid.GetCell(c).GetPointId(0) for c in range(8)], list(range(8)))

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
