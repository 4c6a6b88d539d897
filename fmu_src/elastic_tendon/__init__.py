"""The elastic tendon actuator: one model as simulator, FMU, linear models and fit.

    import elastic_tendon as et

    model = et.load_model("biorob_x4_joint_3")
    recording = et.read("recording.csv")
    found = et.diagnose(model, recording)

What is public is listed in ``__init__.pyi``. Names are imported on first use, so that importing
the package costs nothing.
"""

import logging

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

logging.getLogger(__name__).addHandler(logging.NullHandler())
