"""Settings for all tests."""

import os

# before numpy is imported: threads that wait for one another slow small matrices down, and most
# where several tests run at once
for variable in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(variable, "1")
