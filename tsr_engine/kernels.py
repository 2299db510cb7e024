"""The decorator of kernels that take many views of arrays.

Numba counts the references to the memory of an array with atomic operations. A view, such as one row of a picture,
costs two of them, and kernels that work row by row take some hundred thousand views of a picture. The counts then take
a tenth of the time of a search. Kernels without them can make no arrays: their callers pass working memory.
"""

from __future__ import annotations

from functools import partial

from numba import njit

kernel = partial(njit, cache=True, nogil=True, error_model="numpy", _nrt=False)
"""``numba.njit`` without counts of references; the compiler refuses a kernel that makes an array."""
