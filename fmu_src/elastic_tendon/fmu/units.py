"""Units as FMI wants them: display units and declared types."""

from math import pi

# unit -> (its display unit, display units in one unit)
DISPLAY_UNITS = {
    "m": ("mm", 1000.0),
    "rad": ("deg", 180 / pi),
    "rad/s": ("deg/s", 180 / pi),
    "rad/s2": ("deg/s2", 180 / pi),
}

# unit -> (declared type, quantity), as in Modelica
TYPES = {
    "s": ("Time", "Time"),
    "m": ("Length", "Length"),
    "m/s": ("Velocity", "Velocity"),
    "kg": ("Mass", "Mass"),
    "rad": ("Angle", "Angle"),
    "rad/s": ("AngularVelocity", "AngularVelocity"),
    "rad/s2": ("AngularAcceleration", "AngularAcceleration"),
    "N": ("Force", "Force"),
    "N.m": ("Torque", "Torque"),
    "kg.m2": ("Inertia", "MomentOfInertia"),
    "N/m": ("TranslationalSpringConstant", "TranslationalSpringConstant"),
    "N.s/m": ("TranslationalDampingConstant", "TranslationalDampingConstant"),
    "N.m/rad": ("RotationalSpringConstant", "RotationalSpringConstant"),
    "N.m.s/rad": ("RotationalDampingConstant", "RotationalDampingConstant"),
}
