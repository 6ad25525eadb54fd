"""Injury by the material point method: a projectile through the limb (paper, section 2.2).

`shoot` is the pipeline's stage. `Experiment` sets up any other case: docs/guide/injury_experiments.
"""

from __future__ import annotations

from .bodies.attitude import attitude
from .bodies.combined_solids import (
    ClosedSurface,
    Difference,
    FunctionSolid,
    HalfSpace,
    Intersection,
    Union,
)
from .bodies.drawn_shapes import BladeShape, Box, Cylinder, Ogive
from .bodies.mesh_shape import MeshShape
from .bodies.projectiles import PROJECTILES, Projectile, projectile
from .bodies.rigid_body import BodyPath, BodyState, RigidBody
from .bodies.rotations import rotation_about
from .bodies.shapes import Shape, Sphere
from .bodies.solids import Ball, Block, Rod, Shell, Solid, Tube
from .boundaries import AbsorbingEnds, Boundary, HeldEnds, Wall
from .experiment.experiment import Experiment
from .experiment.fields import Fields
from .experiment.result import (
    ExperimentResult,
    RigidBodyRecord,
    SensorRecord,
    TissueRecord,
)
from .experiment.sensors import CavitySensor, PointSensor, RegionSensor, SectionSensor, Sensor
from .material_model import (
    Material,
    drucker_prager,
    elastic,
    liquid,
    neo_hookean,
    von_mises,
)
from .material_point import (
    MaterialPointHistory,
    material_point,
    pure_shear,
    simple_shear,
    tensile_test,
    uniaxial_strain,
    volumetric_strain,
)
from .materials import MATERIALS, material
from .parameters import AimParameters, InjuryParameters, ProjectileParameters
from .shot.body_surface import projectile_surfaces
from .shot.line import aim
from .shot.passage import shoot
from .solver import MpmSolver

__all__ = [
    "MATERIALS",
    "PROJECTILES",
    "AbsorbingEnds",
    "AimParameters",
    "Ball",
    "BladeShape",
    "Block",
    "BodyPath",
    "BodyState",
    "Boundary",
    "Box",
    "CavitySensor",
    "ClosedSurface",
    "Cylinder",
    "Difference",
    "Experiment",
    "ExperimentResult",
    "Fields",
    "FunctionSolid",
    "HalfSpace",
    "HeldEnds",
    "InjuryParameters",
    "Intersection",
    "Material",
    "MaterialPointHistory",
    "MeshShape",
    "MpmSolver",
    "Ogive",
    "PointSensor",
    "Projectile",
    "ProjectileParameters",
    "RegionSensor",
    "RigidBody",
    "RigidBodyRecord",
    "Rod",
    "SectionSensor",
    "Sensor",
    "SensorRecord",
    "Shape",
    "Shell",
    "Solid",
    "Sphere",
    "TissueRecord",
    "Tube",
    "Union",
    "Wall",
    "aim",
    "attitude",
    "drucker_prager",
    "elastic",
    "liquid",
    "material",
    "material_point",
    "neo_hookean",
    "projectile",
    "projectile_surfaces",
    "pure_shear",
    "rotation_about",
    "shoot",
    "simple_shear",
    "tensile_test",
    "uniaxial_strain",
    "volumetric_strain",
    "von_mises",
]
