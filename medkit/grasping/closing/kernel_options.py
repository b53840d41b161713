"""How the closing kernels are compiled: `entry` for Python, `inner` for kernels, `leaf` in line.

None of them allocates, so all go without reference counts (``_nrt``), which for tuples of thirty
arrays cost more than the work itself, in time and in compile time; a kernel that allocates
nevertheless does not compile. Division by zero gives infinity as in numpy.
"""

from __future__ import annotations

from typing import Any

from numba import njit

# numba takes these options, but its type hints do not list them.
_compiled: Any = njit
# A product and a sum may be rounded once instead of twice; nothing else of IEEE is given up.
_OPTIONS = {"cache": True, "error_model": "numpy", "_nrt": False, "fastmath": {"contract"}}
# Wrappers for Python cost compile time where no one calls from Python.
_BARE = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}

#: For kernels that Python calls.
entry: Any = _compiled(**_OPTIONS)
#: For kernels that only other kernels call.
inner: Any = _compiled(**_OPTIONS, **_BARE)
#: For leaves called by the thousand: handing over the tuples costs more than what a leaf does.
leaf: Any = _compiled(**_OPTIONS, **_BARE, forceinline=True)
#: For tables of hand and object, rounded as numpy rounds, so that plain numpy is their exact twin.
_EXACT = {"cache": True, "error_model": "numpy", "_nrt": False}
exact: Any = _compiled(**_EXACT, no_cfunc_wrapper=True)
exact_inner: Any = _compiled(**_EXACT, **_BARE)
