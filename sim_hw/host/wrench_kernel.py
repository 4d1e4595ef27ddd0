"""The mean of the ground's forces over some steps, as wrenches on the transducers. Compiled.

Sums in the order of the steps and products in the order in which they are written, as numpy does it: the
same bits with and without machine code.
"""

from model.compiled import COUNT, compile_for, compiled, given, in_place, out
from model.values.arrays import FloatArray


@in_place
@compiled
def mean_wrenches(
    forces: FloatArray,
    first: int,
    last: int,
    lever: FloatArray,
    mounting: FloatArray,
    wrench: FloatArray,
) -> None:
    """Write the mean wrench on each transducer, sensor axes.

    Args:
        forces: Ring of the ground's forces on the feet, body axes, a row a step, (K, N, 3) [N].
        first: Number of the first step; steps before 0 are as step 0.
        last: Number of the last one.
        lever: From transducers to feet, body axes, (N, 3) [m].
        mounting: Cosine and sine of each transducer's turn about z, and +1 where it is upright, else -1,
            (3, N).
        wrench: Forces and moments, (N, 6) [N, N m]; changed.
    """
    for k in range(len(lever)):
        fx, fy, fz = 0.0, 0.0, 0.0
        for step in range(first, last + 1):
            row = max(step, 0) % len(forces)
            if step == first:
                fx, fy, fz = forces[row, k, 0], forces[row, k, 1], forces[row, k, 2]
            else:
                fx += forces[row, k, 0]
                fy += forces[row, k, 1]
                fz += forces[row, k, 2]
        count = float(last - first + 1)
        fx, fy, fz = fx / count, fy / count, fz / count
        x, y, z = lever[k, 0], lever[k, 1], lever[k, 2]
        tx, ty, tz = y * fz - z * fy, z * fx - x * fz, x * fy - y * fx
        c, s, up = mounting[0, k], mounting[1, k], mounting[2, k]
        wrench[k, 0] = c * fx + s * fy
        wrench[k, 1] = (c * fy - s * fx) * up
        wrench[k, 2] = fz * up
        wrench[k, 3] = c * tx + s * ty
        wrench[k, 4] = (c * ty - s * tx) * up
        wrench[k, 5] = tz * up


def prepare() -> None:
    """Load or make the machine code, so that no step waits for it."""
    compile_for(mean_wrenches, *given(3), COUNT, COUNT, *given(2, 2), *out(2))
