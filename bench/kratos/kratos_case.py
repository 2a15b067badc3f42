"""Writes the column as a case of Kratos MPM: two meshes (mdpa), a material and the parameters of the run (json)."""

import json
import math

# name of the law, and its numbers beside the elastic ones (angles in radians)
LAWS = {
    "mohr_coulomb": lambda c: ("HenckyMCPlasticPlaneStrain2DLaw",
                               {"COHESION": c.cohesion, "INTERNAL_FRICTION_ANGLE": math.radians(c.friction_angle),
                                "INTERNAL_DILATANCY_ANGLE": 0.0}),
    "neo_hookean": lambda c: ("HyperElasticNeoHookeanPlaneStrain2DLaw", {}),
}


def quads(nx, ny, across, first):
    """Numbers of the nodes of nx x ny cells in a grid with `across` nodes in a row."""
    for j in range(ny):
        for i in range(nx):
            low = first + j * across + i
            yield low, low + 1, low + across + 1, low + across


def block(name, lines):
    return f"Begin {name}\n" + "".join(f"  {line}\n" for line in lines) + f"End {name.split()[0]}\n\n"


def part(name, nodes, elements):
    return (f"Begin SubModelPart {name}\n" + block("SubModelPartNodes", nodes) +
            block("SubModelPartElements", elements) + "End SubModelPart\n\n")


def mesh(element, property_id, nx, ny, h, first, name):
    """A regular mesh as text, and the node numbers by column and row."""
    number = {(i, j): first + j * (nx + 1) + i for j in range(ny + 1) for i in range(nx + 1)}
    text = block(f"Properties {property_id}", [])
    text += block("Nodes", [f"{n} {i * h:.15g} {j * h:.15g} 0" for (i, j), n in number.items()])
    cells = list(enumerate(quads(nx, ny, nx + 1, first), first))
    text += block(f"Elements {element}", [f"{e} {property_id} {' '.join(map(str, q))}" for e, q in cells])
    return text + part(name, number.values(), [e for e, _ in cells]), number


def fixed(where, x, y):
    return {"python_module": "assign_vector_variable_process", "kratos_module": "KratosMultiphysics",
            "Parameters": {"model_part_name": f"Background_Grid.{where}", "variable_name": "DISPLACEMENT",
                           "constrained": [x, y, False], "value": [0.0, 0.0, 0.0], "interval": [0.0, "End"]}}


def parameters(c, solver):
    gravity = {"python_module": "assign_gravity_to_material_point_process",
               "kratos_module": "KratosMultiphysics.MPMApplication",
               "Parameters": {"model_part_name": "MPM_Material", "modulus": 9.81, "direction": [0.0, -1.0, 0.0]}}
    return {
        "problem_data": {"problem_name": "column", "parallel_type": "OpenMP", "echo_level": 0, "start_time": 0.0,
                         "end_time": c.steps * c.dt},
        "solver_settings": {
            "solver_type": "Dynamic", "time_integration_method": "implicit", "scheme_type": "newmark",
            "analysis_type": "non_linear", "model_part_name": "MPM_Material", "domain_size": 2, "echo_level": 0,
            "model_import_settings": {"input_type": "mdpa", "input_filename": "column_Body"},
            "grid_model_import_settings": {"input_type": "mdpa", "input_filename": "column_Grid"},
            "material_import_settings": {"materials_filename": "materials.json"},
            "time_stepping": {"time_step": c.dt},
            "convergence_criterion": "residual_criterion",
            "residual_relative_tolerance": c.tolerance, "residual_absolute_tolerance": 1e-12,
            "max_iteration": 25, "pressure_dofs": False,
            "problem_domain_sub_model_part_list": ["body", "grid"], "processes_sub_model_part_list": ["base", "wall"],
            "linear_solver_settings": solver},
        "processes": {"constraints_process_list": [fixed("base", True, True), fixed("wall", True, False)],
                      "gravity": [gravity]}}


def write(folder, c, solver):
    grid, nodes = mesh("Element2D4N", 0, c.cells[0], c.cells[1], c.h, 1, "grid")
    grid += part("base", [n for (_, j), n in nodes.items() if j == 0], [])
    grid += part("wall", [n for (i, j), n in nodes.items() if i == 0 and j > 0], [])
    (folder / "column_Grid.mdpa").write_text(grid)
    first = len(nodes) + 1
    body, _ = mesh("MPMUpdatedLagrangian2D4N", 1, round(c.width / c.h), round(c.height / c.h), c.h, first, "body")
    (folder / "column_Body.mdpa").write_text(body)
    law, numbers = LAWS[c.law](c)
    variables = {"MATERIAL_POINTS_PER_ELEMENT": 4, "THICKNESS": 1.0, "DENSITY": c.density,
                 "YOUNG_MODULUS": c.youngs_modulus, "POISSON_RATIO": c.poisson_ratio, **numbers}
    material = {"model_part_name": "Initial_MPM_Material.body", "properties_id": 1,
                "Material": {"constitutive_law": {"name": law}, "Variables": variables, "Tables": {}}}
    (folder / "materials.json").write_text(json.dumps({"properties": [material]}, indent=1))
    (folder / "ProjectParameters.json").write_text(json.dumps(parameters(c, solver), indent=1))
